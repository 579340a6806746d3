//! Properties of all readers: the heights do not depend on the format, and parts agree with the whole map.

use proptest::prelude::*;
use slipgrid_surface::topography::{
    Crop, Decimation, DecimationMethod, HeightMap, LengthUnit, MatrixStyle, ReadOptions, read_map,
};

/// A map of whole nanometres on pixels of 2 um x 1 um, with missing points.
fn maps() -> impl Strategy<Value = HeightMap> {
    (2..12_usize, 2..12_usize).prop_flat_map(|(rows, cols)| {
        let height = prop_oneof![9 => (-30_000..30_000_i16).prop_map(Some), 1 => Just(None)];
        proptest::collection::vec(height, rows * cols)
            .prop_filter("a map needs a height", |heights| heights.iter().any(Option::is_some))
            .prop_map(move |heights| {
                let heights = heights.into_iter().map(|h| h.map_or(f64::NAN, |h| f64::from(h) / 1e9)).collect();
                HeightMap::new(rows, cols, 2e-6, 1e-6, heights).unwrap()
            })
    })
}

fn nanometres(map: &HeightMap) -> impl Iterator<Item = Option<i16>> {
    map.heights_m().iter().map(|height| (!height.is_nan()).then(|| (height * 1e9).round() as i16))
}

/// The map in every format, in the layout of its usual writers: x runs along the lines of a file.
fn files(map: &HeightMap) -> Vec<(&'static str, Vec<u8>)> {
    let (lines, points) = (map.cols(), map.rows());
    let (rows, cols) = (lines, points);
    // Line after line.
    let nanometres = |map: &HeightMap| {
        let all: Vec<Option<i16>> = nanometres(map).collect();
        (0..lines * points).map(move |n| all[n % points * lines + n / points])
    };
    let style = MatrixStyle { channel: "z".to_owned(), comments: Vec::new(), unit: LengthUnit::Nanometre, decimals: 0 };
    let matrix = map.to_matrix_text(&style).into_bytes();

    let mut gsf = format!(
        "Gwyddion Simple Field 1.0\nXRes = {cols}\nYRes = {rows}\nXReal = {}\nYReal = {}\nXYUnits = um\nZUnits = nm\n",
        2 * cols,
        rows
    )
    .into_bytes();
    gsf.resize(gsf.len() + 4 - gsf.len() % 4, 0);
    gsf.extend(nanometres(map).flat_map(|h| h.map_or(f32::NAN, f32::from).to_le_bytes()));

    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    let header = format!("{{'descr': '>f4', 'fortran_order': False, 'shape': ({rows}, {cols}), }}\n");
    npy.extend_from_slice(&(header.len() as u16).to_le_bytes());
    npy.extend_from_slice(header.as_bytes());
    npy.extend(nanometres(map).flat_map(|h| h.map_or(f32::NAN, f32::from).to_be_bytes()));

    let scales = [2e-6_f64, 1e-6, 1e-9, -1.0];
    let mut sdf = b"bISO-1.0maker     010120261200010120261200".to_vec();
    sdf.extend([cols as u16, rows as u16].into_iter().flat_map(u16::to_le_bytes));
    sdf.extend(scales.into_iter().flat_map(f64::to_le_bytes));
    sdf.extend_from_slice(&[0, 5, 0]);
    sdf.extend(nanometres(map).flat_map(|h| h.unwrap_or(i16::MIN).to_le_bytes()));

    let mut text = format!(
        "aISO-1.0\nNumPoints = {cols}\nNumProfiles = {rows}\nXscale = 2e-6\nYscale = 1e-6\nZscale = 1e-9\nDataType = 5\n*\n"
    );
    for height in nanometres(map) {
        text += &height.map_or_else(|| "BAD ".to_owned(), |height| format!("{height}\n"));
    }
    text += "\n*\n*\n";

    let mut sur = vec![0; 512];
    let mut put = |at: usize, bytes: &[u8]| sur[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"DIGITAL SURF");
    put(16, &[1, 0, 2]);
    put(86, &[1]);
    put(98, &[16]);
    put(100, &(-30_000_i32).to_le_bytes());
    for (at, count) in [(108, cols), (112, rows), (116, rows * cols)] {
        put(at, &(count as u32).to_le_bytes());
    }
    for (at, step) in [(120, 2_f32), (124, 1.0), (128, 1.0)] {
        put(at, &step.to_le_bytes());
    }
    for (at, unit) in [(180, "um"), (196, "um"), (212, "nm")] {
        put(at, unit.as_bytes());
    }
    sur.extend(nanometres(map).flat_map(|h| h.unwrap_or(-30_002).to_le_bytes()));

    let mut xyz = String::from("x_um,y_um,z_nm\n");
    for (n, height) in nanometres(map).enumerate() {
        let height = height.map_or_else(|| "NaN".to_owned(), |height| height.to_string());
        xyz += &format!("{},{},{height}\n", 2 * (n % cols), n / cols);
    }
    vec![
        ("matrix", matrix),
        ("gsf", gsf),
        ("npy", npy),
        ("binary sdf", sdf),
        ("text sdf", text.into_bytes()),
        ("sur", sur),
        ("xyz", xyz.into_bytes()),
    ]
}

fn options(name: &str) -> ReadOptions {
    let given =
        ReadOptions { pixel_m: Some([2e-6, 1e-6]), height_unit: Some(LengthUnit::Nanometre), ..ReadOptions::default() };
    if name == "npy" { given } else { ReadOptions::default() }
}

fn same(one: &HeightMap, other: &HeightMap) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs();
    (one.rows(), one.cols()) == (other.rows(), other.cols())
        && close(one.dx_m(), other.dx_m())
        && close(one.dy_m(), other.dy_m())
        && one.heights_m().iter().zip(other.heights_m()).all(|(a, b)| a.is_nan() && b.is_nan() || (a - b).abs() < 1e-18)
}

proptest! {
    #[test]
    fn every_format_gives_back_the_same_map(map in maps()) {
        for (name, bytes) in files(&map) {
            let read = read_map(&bytes[..], &options(name)).unwrap().map;
            prop_assert!(same(&map, &read), "{name}: {read:?}");
        }
    }

    #[test]
    fn what_is_kept_while_reading_is_what_would_be_kept_afterwards(
        map in maps(),
        corner in (0..6_usize, 0..6_usize),
        size in (1..12_usize, 1..12_usize),
        factor in 1..4_usize,
        pick in any::<bool>(),
    ) {
        let crop = Some(Crop { first_row: corner.0, first_col: corner.1, rows: size.0, cols: size.1 });
        let method = if pick { DecimationMethod::Pick } else { DecimationMethod::Mean };
        let decimation = Some(Decimation { factor, method });
        // A crop counts the lines of the file.
        let kept = Some(Crop { first_row: corner.1, first_col: corner.0, rows: size.1, cols: size.0 });
        let afterwards = map.windowed(kept, decimation);
        for (name, bytes) in files(&map) {
            let reading = read_map(&bytes[..], &ReadOptions { crop, decimation, ..options(name) });
            match (&afterwards, reading) {
                (Ok(expected), Ok(found)) => prop_assert!(same(expected, &found.map), "{name}"),
                (Err(_), Err(_)) => {}
                (expected, found) => prop_assert!(false, "{name}: {expected:?} {:?}", found.map(|read| read.map)),
            }
        }
    }

    #[test]
    fn a_file_cut_short_is_never_read_as_a_whole_one(map in maps(), share in 0.0..1.0_f64) {
        for (name, bytes) in files(&map) {
            // A truncated text is still a map, with a row or a point less.
            if matches!(name, "matrix" | "xyz" | "text sdf") {
                continue;
            }
            let length = ((bytes.len() as f64) * share) as usize;
            prop_assert!(read_map(&bytes[..length], &options(name)).is_err(), "{name} at {length}");
        }
    }
}
