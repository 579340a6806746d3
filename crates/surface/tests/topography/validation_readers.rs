//! Files written by other programs, and the values other programs read from them (`reference/make.py`).

use std::path::Path;

use serde_json::Value;
use slipgrid_surface::topography::{HeightMap, LengthUnit, ReadOptions, read_map};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/topography/reference"))
}

fn readings() -> Value {
    serde_json::from_slice(&std::fs::read(folder().join("readings.json")).unwrap()).unwrap()
}

fn read(name: &str) -> HeightMap {
    // An array has no pixel size and no unit, points have no unit.
    let options = if name.ends_with(".npy") {
        ReadOptions {
            pixel_m: Some([1.5e-6, 2.5e-6]),
            height_unit: Some(LengthUnit::Micrometre),
            ..ReadOptions::default()
        }
    } else if name.ends_with(".xyz") {
        let unit = Some(LengthUnit::Micrometre);
        ReadOptions { height_unit: unit, lateral_unit: unit, ..ReadOptions::default() }
    } else {
        ReadOptions::default()
    };
    let bytes = std::fs::read(folder().join(name)).unwrap();
    if name == "gwyddion.asc" {
        // The pixels are oblong, as in a truncated file; the sides are understood, but the reader asks for
        // confirmation.
        let refused = read_map(&bytes[..], &options).unwrap_err().to_string();
        assert!(refused.contains("make pixels of 1.5 x 2.5 um"), "{refused}");
        let given = ReadOptions { pixel_m: Some([1.5e-6, 2.5e-6]), ..options };
        return read_map(&bytes[..], &given).unwrap().map;
    }
    read_map(&bytes[..], &options).unwrap_or_else(|error| panic!("{name}: {error}")).map
}

#[test]
fn validation_files_of_other_programs_read_as_others_read_them() {
    let readings = readings();
    let readings = readings.as_object().unwrap();
    assert_eq!(readings.len(), 16);
    for (name, expected) in readings {
        let map = read(name);
        let number = |key: &str| expected[key].as_f64().unwrap();
        // The points were written with x from line to line; in all other files x runs along a line.
        let (along, across) = if name == "points.xyz" { ("lines", "points") } else { ("points", "lines") };
        assert_eq!(map.rows() as f64, number(along), "{name}");
        assert_eq!(map.cols() as f64, number(across), "{name}");
        assert_eq!(map.missing() as f64, number("missing"), "{name}");
        let steps = if along == "points" { ["step_x_um", "step_y_um"] } else { ["step_y_um", "step_x_um"] };
        for (found_m, key) in [map.dx_m(), map.dy_m()].into_iter().zip(steps) {
            assert!((found_m * 1e6 - number(key)).abs() < 1e-6, "{name}: {found_m}");
        }
        let heights_um: Vec<f64> = map.heights_m().iter().map(|height| height * 1e6).collect();
        let line: Vec<f64> = match along {
            "points" => heights_um.iter().skip(3).step_by(map.cols()).copied().collect(),
            _ => heights_um[3 * map.cols()..4 * map.cols()].to_vec(),
        };
        let listed: Vec<Option<f64>> =
            expected["third_line_um"].as_array().unwrap().iter().map(Value::as_f64).collect();
        // Some readers ignore an offset, so only differences can agree.
        let shift = if expected.get("without_offset").is_some() { line[0] - listed[0].unwrap() } else { 0.0 };
        // Heights in single precision, up to 3 um: an error of 2e-7 um each; the sum has 403 of them.
        let close = |found: f64, expected: f64| (found - shift - expected).abs() < 2e-7;
        for (found, listed) in line.iter().zip(&listed) {
            match listed {
                Some(listed) => assert!(close(*found, *listed), "{name}: {found} and {listed}"),
                None => assert!(found.is_nan(), "{name}"),
            }
        }
        let present = || heights_um.iter().copied().filter(|height| !height.is_nan());
        assert!(close(present().fold(f64::INFINITY, f64::min), number("least_um")), "{name}");
        assert!(close(present().fold(f64::NEG_INFINITY, f64::max), number("greatest_um")), "{name}");
        let count = present().count() as f64;
        assert!(close(present().sum::<f64>() / count, number("sum_um") / count), "{name}");
    }
}
