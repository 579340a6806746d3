//! Maps that are unsuitable for computation: warnings in every output that rests on them, and refusals.

use crate::common::{CALIBRATION, FLAT, Place, SCENE, at, measured, patterned};
use serde_json::Value;

/// Warnings of a result or a material that begin with `start`.
fn warnings<'a>(found: &'a Value, start: &str) -> Vec<&'a str> {
    let all = found.get("warnings").map_or(&[][..], |list| list.as_array().unwrap());
    all.iter().map(|entry| entry.as_str().unwrap()).filter(|told| told.starts_with(start)).collect()
}

/// New height from row, column and height of a point.
type Change<'a> = dyn Fn(usize, usize, f64) -> f64 + 'a;

/// Folder with the map `clean.asc`, 96 x 96 pixels with an rms slope of 0.03, and for each entry of `changed` a map
/// with this name, made by a function of row, column and height in the file's unit.
fn place(changed: &[(&str, &Change<'_>)]) -> Place {
    let place = Place::with(&[("flat.csv", FLAT)]);
    place.succeed("synthesize --pixels 96 --waves 3:24 --rms-slope 0.03 -o clean.asc");
    let clean = place.read("clean.asc");
    let (header, rows): (Vec<&str>, Vec<&str>) = clean.lines().partition(|line| line.starts_with('#'));
    for (name, change) in changed {
        let rows = rows.iter().enumerate().map(|(row, line)| {
            let heights = line.split_whitespace().enumerate();
            heights.map(|(col, height)| format!("{}\t", change(row, col, height.parse().unwrap()))).collect()
        });
        let rows: Vec<String> = rows.map(|row: String| row.trim_end().to_owned()).collect();
        place.write(name, format!("{}\n{}\n", header.join("\n"), rows.join("\n")));
    }
    place
}

/// Height of the spikes in these tests, in nanometres; the map's Sa is 0.57 um.
const SPIKE_NM: f64 = 6000.0;

/// Adds spikes at two points, one of which lies at the side of the map, and at a pair of points; subtracts one at a
/// fourth place.
fn spiked(row: usize, col: usize, height: f64) -> f64 {
    match (row, col) {
        (20, 30) | (50, 0) | (70, 80) | (70, 81) => height + SPIKE_NM,
        (90, 10) => height - SPIKE_NM,
        _ => height,
    }
}

#[test]
fn spikes_are_named_in_every_result_that_rests_on_a_map_and_removed_when_asked() {
    let place = place(&[("spiked.asc", &spiked)]);
    let surface = |map: &str| place.json(&format!("surface {map} --json"));
    let law = |map: &str| place.json(&format!("area-law {map} --pressures-mpa 0.3,0.7,2.6 --windows 1 --json"));
    for (read, value) in [(&surface as &dyn Fn(&str) -> Value, "/parameters/rms_slope"), (&law, "/results/2/factor")] {
        let [clean, found, despiked] = ["clean.asc", "spiked.asc", "spiked.asc --despike"].map(read);
        let told = warnings(&found, "spikes: 5 points in 4 places");
        assert!(told.len() == 1 && told[0].contains("--despike"), "{found}");
        assert_eq!((warnings(&clean, ""), warnings(&despiked, "")), (vec![], vec![]));
        let [clean, found, despiked] = [&clean, &found, &despiked].map(|of| at(of, value));
        assert!(
            (found / clean - 1.0).abs() > 0.05 && (despiked / clean - 1.0).abs() < 0.01,
            "{clean} {found} {despiked}"
        );
    }
    assert_eq!(surface("clean.asc --despike")["parameters"], surface("clean.asc")["parameters"]);

    // Material, scene and screen of a calibration by this map, beside another doubt, each once.
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let calibration = |map: &str| patterned(pattern).replace("persson_rms_slope = 0.0137", map);
    place.write("patterned.csv", FLAT.replace("0.248", "1.2"));
    place.write("scene.toml", measured(SCENE, "m.toml"));
    for (map, expected) in [("map = \"spiked.asc\"", 1), ("map = \"spiked.asc\"\ndespike = true", 0)] {
        place.write("c.toml", calibration(map));
        let printed = place.succeed("calibrate c.toml -o m.toml --details");
        assert_eq!(printed.matches("\n! spikes: ").count(), expected, "{printed}");
        let material = serde_json::to_value(place.toml("m.toml")).unwrap();
        let solved = place.json("simulate scene.toml --json")["material"].clone();
        for found in [&material, &solved] {
            assert_eq!((warnings(found, "measured ratio: ").len(), warnings(found, "spikes: ").len()), (1, expected));
        }
    }
}

#[test]
fn maps_that_mean_nothing_are_refused_and_those_that_mean_little_are_told() {
    // Ten points as high as a hair carry the light loads: f rises with the pressure.
    let high = |row: usize, col: usize, height: f64| {
        if row % 30 == 7 && col % 30 == 11 { height + 1.5 * SPIKE_NM } else { height }
    };
    // Squares of 32 x 32 pixels, of each side of which `least` are seen.
    let seen = |least: usize| {
        move |row: usize, col: usize, height: f64| {
            if row % 32 < least && col % 32 < least { height } else { f64::NAN }
        }
    };
    let place = place(&[
        ("high.asc", &high),
        ("steep.asc", &|_, _, height| 100.0 * height),
        ("tenth.asc", &seen(11)),
        ("hundredth.asc", &seen(4)),
    ]);
    place.write("c.toml", CALIBRATION.replace("persson_rms_slope = 0.0137", "map = \"high.asc\""));
    place.refuse_all(
        "area-law high.asc --windows 1 => error: high.asc: f reaches 1.
         area-law high.asc --windows 1 => --despike
         calibrate c.toml => the area law means nothing
         surface hundredth.asc -o out => error: hundredth.asc: 9072 of 9216 points are missing
         area-law hundredth.asc => error: hundredth.asc: 9072 of 9216 points are missing",
    );
    assert!(!place.path("out").exists());
    place.succeed("area-law high.asc --windows 1 --despike --json");
    for (line, start) in [
        ("surface steep.asc", "slope: the rms slope is 3;"),
        ("surface tenth.asc", "missing points: 88 % of the map (8127 of 9216 points)"),
        (
            "area-law tenth.asc --windows 1 --pressures-mpa 0.7,2.6 --threshold-mpa 0.7",
            "missing points: 88 % of the map",
        ),
    ] {
        let found = place.json(&format!("{line} --json"));
        assert_eq!(warnings(&found, start).len(), 1, "{found}");
    }
}

#[test]
fn a_law_that_jumps_or_exceeds_one_is_told() {
    let place = Place::with(&[("scene.toml", &SCENE.replace("[1.0, 0.96, 0.90, 0.60]", "[0.9, 1.05, 1.2, 1.0]"))]);
    let material = &place.json("simulate scene.toml --json")["material"];
    for start in
        ["area law jumps: f falls from 1 to 0.9 at its first pressure, 0.7 MPa", "factor above 1: f is 1.2 at 2.6 MPa"]
    {
        assert_eq!(warnings(material, start).len(), 1, "{material}");
    }
}
