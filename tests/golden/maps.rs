//! Altitude maps: synthetic maps in several formats and shapes, and files of other programs.

use std::fmt::Write as _;
use std::fs;

use crate::Case;
use crate::place::{Place, repository};
use crate::random::Random;
use crate::record::Record;

/// Files of other programs, from the tests of the readers, with the options that they need.
const FOREIGN: [(&str, &str); 17] = [
    ("gsffile.gsf", ""),
    ("gwyddion.asc", ""),
    ("iso.npy", "--pixel-um 1 --height-unit um"),
    ("numpy-f4.npy", "--pixel-um 1 --height-unit um"),
    ("numpy-fortran.npy", "--pixel-um 1 --height-unit nm"),
    ("points.xyz", "--height-unit um --lateral-unit um"),
    ("spip.asc", ""),
    ("surface-topography-D.x3p", ""),
    ("surface-topography-F.x3p", ""),
    ("surface-topography-I.x3p", ""),
    ("surface-topography-L.x3p", ""),
    ("surfalize-binary.sdf", ""),
    ("surfalize-compressed.sur", ""),
    ("surfalize-latin1.sur", ""),
    ("surfalize-text.sdf", ""),
    ("surfalize-utf8.sur", ""),
    ("surfalize.x3p", ""),
];

/// Synthetic maps of 96 pixels: name, options of `synthesize`, and options of `surface`.
const MADE: [(&str, &str, &str); 16] = [
    ("rough", "", ""),
    ("rough, plane not subtracted", "", "--form mean"),
    ("rough, second order", "", "--form second-order"),
    ("rough, decimated", "", "--decimate 2"),
    ("rough, picked", "", "--decimate 3 --decimate-by pick"),
    ("rough, cropped", "", "--crop 10,20,40,50"),
    ("rough, spikes", "", "--despike"),
    ("smooth", "--hurst 1 --waves 2:12 --sa-um 0.5", ""),
    ("steep", "--hurst 0.4 --rms-slope 0.05", ""),
    ("grooves", "--side-mm 2 --cavities 130,370,5.2 --wall-um 20", "--cavities --period-out @period.asc"),
    ("grooves, rims", "--side-mm 0.5 --cavities 60,60,5 --rims 0.5,20 --rim-std-um 0.05", "--cavities"),
    ("grooves, ramps", "--side-mm 0.5 --cavities 60,60,5 --rims 0.5,25 --rim-profile ramp", "--cavities"),
    ("squares", "--side-mm 0.8 --cavities 80,80,8 --cavity-shape square", "--cavities --period-out @period.asc"),
    ("discs", "--side-mm 0.8 --cavities 90,70,8 --cavity-shape disc --cavity-std 3,0,0.4", "--cavities"),
    ("discs, one period", "--side-mm 0.16 --cavities 90,70,8 --cavity-shape disc", "--cavities"),
    ("no cavities", "", "--cavities"),
];

pub fn cases() -> Vec<Case> {
    let foreign = FOREIGN.iter().map(|(file, options)| {
        Case::new(*file, true, move || {
            let path = repository().join("crates/surface/tests/topography/reference").join(file);
            measured(&Place::new(), &path.display().to_string(), options)
        })
    });
    let made = MADE.iter().enumerate().map(|(number, (name, options, reading))| {
        Case::new(*name, true, move || measured(&synthesized(number, options), "@map.asc", reading))
    });
    let formats = ["csv", "xyz", "npy", "gsf", "txt"].iter().map(|format| {
        Case::new(format!("as {format}"), true, move || {
            let place = synthesized(0, "--pixels 40 --waves 2:12");
            let (file, options) = rewrite(&place, format);
            measured(&place, &file, options)
        })
    });
    let laws = LAWS.iter().map(|(name, made, options)| {
        Case::new(format!("area law, {name}"), !name.contains("windows"), move || {
            let mut record = Record::new();
            synthesized(3, made).run(&format!("area-law @map.asc {options} --json"), &mut record);
            record
        })
    });
    let persson = Case::new("area law, Persson", true, || {
        let mut record = Record::new();
        Place::new().run("area-law --persson-rms-slope 0.0137 --json", &mut record);
        record
    });
    foreign.chain(made).chain(formats).chain(laws).chain([persson]).collect()
}

/// Area laws: name, options of `synthesize`, and options of `area-law`.
const LAWS: [(&str, &str, &str); 7] = [
    ("64 points", "--pixels 64 --waves 4:20", "--windows 0"),
    ("windows", "", "--windows 2"),
    ("another body", "", "--windows 0 --youngs-modulus-gpa 2.5 --poisson-ratio 0.4 --pressures-mpa 0.5,2,8,40"),
    ("threshold", "", "--windows 0 --threshold-mpa 0.3"),
    ("resolutions", "", "--windows 0 --resolutions"),
    ("steep", "--hurst 0.4 --rms-slope 0.05", "--windows 0 --pressures-mpa 0.7,5"),
    ("grooves", "--side-mm 0.5 --cavities 60,60,5", "--windows 0 --pressures-mpa 0.7,5"),
];

/// Folder with the synthetic map map.asc.
fn synthesized(seed: usize, options: &str) -> Place {
    let place = Place::new();
    let size = if options.contains("--pixels") { "" } else { "--pixels 96" };
    let waves = if options.contains("--waves") { "" } else { "--waves 4:32" };
    let (code, _, err) = place.run_raw(&format!("synthesize {size} {waves} --seed {seed} {options} -o @map.asc"));
    assert_eq!(code, 0, "{err}");
    place
}

/// Records the outputs of `surface`.
fn measured(place: &Place, file: &str, options: &str) -> Record {
    let mut record = Record::new();
    place.run(&format!("surface {file} {options} --json -o @out"), &mut record);
    place.record_folder("out", &mut record);
    if fs::exists(place.path("period.asc")).unwrap() {
        place.record_file("period.asc", "period.asc", &mut record);
    }
    record
}

/// Writes map.asc of `place` in another format, with a spike and, if the format allows it, a missing point. Returns the
/// name of the file and the options that it needs.
fn rewrite(place: &Place, format: &str) -> (String, &'static str) {
    let text = fs::read_to_string(place.path("map.asc")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect())
        .collect();
    let (lines, points) = (rows.len(), rows[0].len());
    let mut random = Random::new(7);
    let [hole, spike] = [0, 0].map(|_| (random.next() % (lines * points) as u64) as usize);
    let heights: Vec<f64> = rows
        .concat()
        .iter()
        .enumerate()
        .map(|(place, height)| if place == hole { f64::NAN } else { height + if place == spike { 5.0 } else { 0.0 } })
        .collect();
    let shown = |height: &f64| if height.is_nan() { "nan".to_owned() } else { format!("{height:.5}") };
    let joined = |mark: &str| {
        heights
            .chunks(points)
            .fold(String::new(), |text, row| text + &row.iter().map(shown).collect::<Vec<_>>().join(mark) + "\n")
    };
    let bytes = match format {
        "csv" => joined(";").replace('.', ",").into_bytes(),
        "txt" => format!("# Width: 0.5 mm\n# Height: 0.5 mm\n# Value units: um\n{}", joined("\t")).into_bytes(),
        "xyz" => {
            let points = heights
                .iter()
                .enumerate()
                .filter(|(_, height)| !height.is_nan())
                .map(|(n, height)| (12.5 * (n % points) as f64, 12.5 * (n / points) as f64, height));
            points
                .fold(String::new(), |mut text, (x, y, height)| {
                    writeln!(text, "{x} {y} {height:.5}").unwrap();
                    text
                })
                .into_bytes()
        }
        "npy" => {
            let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({lines}, {points}), }}\n");
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
            bytes.extend_from_slice(header.as_bytes());
            bytes.extend(heights.iter().flat_map(|height| height.to_le_bytes()));
            bytes
        }
        _ => {
            let mut bytes = format!(
                "Gwyddion Simple Field 1.0\nXRes = {points}\nYRes = {lines}\nXReal = 0.0005\nYReal = 0.0005\nXYUnits = m\nZUnits = um\n"
            )
            .into_bytes();
            bytes.resize(bytes.len() + 4 - bytes.len() % 4, 0);
            bytes.extend(heights.iter().flat_map(|height| (*height as f32).to_le_bytes()));
            bytes
        }
    };
    let file = format!("made.{format}");
    place.write(&file, &bytes);
    let options = match format {
        "csv" | "npy" => "--pixel-um 12.5 --height-unit um --despike",
        "xyz" => "--height-unit um --lateral-unit um",
        _ => "--despike",
    };
    (format!("@{file}"), options)
}
