//! Maps that are unsuitable for computation: warnings in every output, and refusals.

use crate::common::{CALIBRATION, FLAT, Place, SCENE, measured, patterned_calibration};
use serde_json::Value;

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().map_or_else(Vec::new, |list| list.iter().map(|entry| entry.as_str().unwrap()).collect())
}

/// New height from row, column and height of a point.
type Change<'a> = dyn Fn(usize, usize, f64) -> f64 + 'a;

/// Folder with the map `clean.asc`, 96 x 96 pixels with an rms slope of 0.03, and for each entry of `changed` a map
/// with this name, made by a function of row, column and height in the file's unit.
fn place(changed: &[(&str, &Change<'_>)]) -> Place {
    let place = Place::with(&[("flat.csv", FLAT)]);
    place.succeed(&["synthesize", "--pixels", "96", "--waves", "3:24", "--rms-slope", "0.03", "-o", "clean.asc"]);
    let clean = place.read("clean.asc");
    for (name, change) in changed {
        let mut row = 0;
        let lines = clean.lines().map(|line| {
            if line.starts_with('#') {
                return format!("{line}\n");
            }
            let heights = line.split_whitespace().enumerate();
            let heights: Vec<String> =
                heights.map(|(col, height)| change(row, col, height.parse().unwrap()).to_string()).collect();
            row += 1;
            heights.join("\t") + "\n"
        });
        let text: String = lines.collect();
        place.write(name, text);
    }
    place
}

/// Height of the spikes in these tests, in nanometres; the map's Sa is 0.57 um.
const SPIKE_NM: f64 = 6000.0;

/// Adds `high` at two points, one of which lies at the side of the map, and at a pair of points; subtracts it at a fourth
/// place.
fn spiked(high: f64) -> impl Fn(usize, usize, f64) -> f64 {
    move |row, col, height| match (row, col) {
        (20, 30) | (50, 0) | (70, 80) | (70, 81) => height + high,
        (90, 10) => height - high,
        _ => height,
    }
}

fn law<'a>(map: &'a str, flags: &[&'a str]) -> Vec<&'a str> {
    [&["area-law", map, "--pressures-mpa", "0.3,0.7,2.6", "--windows", "1"][..], flags].concat()
}

#[test]
fn spikes_are_named_by_surface_and_area_law_and_removed_when_asked() {
    let place = place(&[("spiked.asc", &spiked(SPIKE_NM))]);
    let clean = place.json(&["surface", "clean.asc", "--json"]);
    assert!(clean.get("warnings").is_none(), "{}", clean["warnings"]);
    let slope = |result: &Value| result["parameters"]["rms_slope"].as_f64().unwrap();

    let found = place.json(&["surface", "spiked.asc", "--json"]);
    let warnings = strings(&found["warnings"]);
    assert!(warnings[0].starts_with("spikes: 5 points in 4 places stand alone"), "{warnings:?}");
    assert!(warnings[0].contains("rows 20 to 90, columns 0 to 8") && warnings[0].contains("--despike"), "{warnings:?}");
    assert!(slope(&found) > 1.3 * slope(&clean));
    let text = place.succeed(&["surface", "spiked.asc"]);
    assert!(text.contains("\n! spikes: 5 points"), "{text}");

    let despiked = place.json(&["surface", "spiked.asc", "--despike", "--json"]);
    assert!(despiked.get("warnings").is_none());
    assert!(strings(&despiked["model"]).iter().any(|note| note.starts_with("despiked: 5 points in 4 places")));
    assert!((slope(&despiked) / slope(&clean) - 1.0).abs() < 0.01, "{} {}", slope(&despiked), slope(&clean));
    let untouched = place.json(&["surface", "clean.asc", "--despike", "--json"]);
    assert!(strings(&untouched["model"]).contains(&"despiked: no spikes were found"));
    assert_eq!(untouched["parameters"], clean["parameters"]);

    let said = place.json(&law("spiked.asc", &["--json"]));
    assert!(strings(&said["warnings"])[0].starts_with("spikes: 5 points"), "{said}");
    assert!(place.succeed(&law("spiked.asc", &[])).contains("\n! spikes: 5 points"));
    let [clean, despiked] =
        [law("clean.asc", &["--json"]), law("spiked.asc", &["--despike", "--json"])].map(|args| place.json(&args));
    assert!(despiked.get("warnings").is_none() && clean.get("warnings").is_none());
    let factor = |law: &Value| law["results"][2]["factor"].as_f64().unwrap();
    assert!((factor(&despiked) / factor(&clean) - 1.0).abs() < 0.01, "{} {}", factor(&despiked), factor(&clean));
}

#[test]
fn what_is_wrong_with_a_map_stands_in_every_result_that_rests_on_it() {
    let place = place(&[("spiked.asc", &spiked(SPIKE_NM))]);
    let calibration =
        |more: &str| CALIBRATION.replace("persson_rms_slope = 0.0137", &format!("map = \"spiked.asc\"{more}"));
    place.write("calibration.toml", calibration(""));
    place.write("despiked.toml", calibration("\ndespike = true"));
    let printed = place.succeed(&["calibrate", "calibration.toml", "-o", "material.toml"]);
    assert!(printed.contains("\n! spikes: 5 points in 4 places"), "{printed}");
    let material = place.read("material.toml");
    assert!(material.contains("warnings = [\"spikes: 5 points in 4 places"), "{material}");

    place.write("scene.toml", measured(SCENE, "material.toml"));
    let result = place.json(&["simulate", "scene.toml", "--json"]);
    assert!(strings(&result["material"]["warnings"])[0].starts_with("spikes: 5 points"), "{result}");
    assert!(place.succeed(&["simulate", "scene.toml"]).contains("! the material is doubtful: spikes: 5 points"));

    let printed = place.succeed(&["calibrate", "despiked.toml", "-o", "material.toml"]);
    assert!(!printed.contains("! spikes") && printed.contains("- despiked: 5 points in 4 places"), "{printed}");
    let result = place.json(&["simulate", "scene.toml", "--json"]);
    assert!(result["material"].get("warnings").is_none());
}

#[test]
fn a_doubtful_ratio_and_a_doubtful_map_are_each_said_once() {
    let place = place(&[("spiked.asc", &spiked(SPIKE_NM))]);
    let pattern = "planform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let calibration = patterned_calibration(pattern).replace("persson_rms_slope = 0.0137", "map = \"spiked.asc\"");
    place.write("calibration.toml", calibration);
    place.write("patterned.csv", FLAT.replace("0.248", "1.2"));
    place.succeed(&["calibrate", "calibration.toml", "-o", "material.toml"]);
    let material = place.toml("material.toml");
    let told: Vec<&str> = material["warnings"].as_array().unwrap().iter().map(|told| told.as_str().unwrap()).collect();
    let count = |start: &str| told.iter().filter(|told| told.starts_with(start)).count();
    assert_eq!((count("measured ratio: "), count("spikes: ")), (1, 1), "{told:?}");
    assert!(told[0].starts_with("measured ratio: "), "{told:?}");
    assert!(
        told.iter()
            .any(|told| told.starts_with("spikes: ") && told.ends_with("despike = true in [surface], replaces them"))
    );
}

#[test]
fn a_law_that_rises_above_one_and_slopes_of_no_surface_are_refused() {
    // Ten points as high as a hair carry the light loads: f rises with the pressure.
    let high = |row: usize, col: usize, height: f64| {
        if row % 30 == 7 && col % 30 == 11 { height + 1.5 * SPIKE_NM } else { height }
    };
    let in_metres = |_: usize, _: usize, height: f64| 1e4 * height;
    let flat = |_: usize, _: usize, _: f64| 0.0;
    let place = place(&[("high.asc", &high), ("metres.asc", &in_metres), ("flat.asc", &flat)]);
    for (args, message) in [
        (vec!["area-law", "high.asc", "--windows", "1"], "error: high.asc: f reaches 1."),
        (vec!["area-law", "metres.asc"], "error: metres.asc: the rms slope is 3.00e2, which no measured surface has"),
        (vec!["surface", "metres.asc"], "error: metres.asc: the rms slope is 3.00e2, which no measured surface has"),
        (vec!["area-law", "flat.asc"], "error: flat.asc: the rms slope is 0.00e0, which no measured surface has"),
    ] {
        let said = place.refuse(&args);
        assert!(said.starts_with(message), "{args:?}: {said}");
    }
    let said = place.refuse(&["area-law", "high.asc", "--windows", "1"]);
    assert!(said.contains("spikes: ") && said.contains("--despike"), "{said}");
    assert!(place.refuse(&["area-law", "metres.asc"]).contains("unit of heights: Sq is"));
    place.succeed(&["area-law", "high.asc", "--windows", "1", "--despike", "--json"]);
    place.write("calibration.toml", CALIBRATION.replace("persson_rms_slope = 0.0137", "map = \"high.asc\""));
    assert!(place.refuse(&["calibrate", "calibration.toml"]).contains("the area law means nothing"));
    let said = place.refuse(&["surface", "metres.asc", "-o", "out"]);
    assert!(said.contains("expected a slope from 1e-7 to 10: see the units of heights (height_unit)"), "{said}");
    assert!(!place.path("out").exists());
    // A surface without heights is one, and one that is steeper than those that slide is warned of.
    place.succeed(&["surface", "flat.asc"]);
    let steep = |_: usize, _: usize, height: f64| 100.0 * height;
    let place = self::place(&[("steep.asc", &steep)]);
    let text = place.succeed(&["surface", "steep.asc"]);
    assert!(text.contains("\n! slope: the rms slope is 3.00e0"), "{text}");
}

#[test]
fn maps_that_are_hardly_there_are_told_or_refused() {
    let seen = |least: usize| {
        move |row: usize, col: usize, height: f64| {
            // Squares of 32 x 32 pixels, one third or less of each side seen.
            if row % 32 < least && col % 32 < least { height } else { f64::NAN }
        }
    };
    let place = place(&[("tenth.asc", &seen(11)), ("hundredth.asc", &seen(4)), ("most.asc", &seen(31))]);
    let missing = |map: &str| {
        let found = place.json(&["surface", map, "--json"]);
        strings(&found["warnings"])
            .iter()
            .find(|warning| warning.starts_with("missing points"))
            .map(|w| (*w).to_owned())
    };
    assert!(missing("tenth.asc").unwrap().starts_with("missing points: 88 % of the map (8127 of 9216 points)"));
    assert_eq!(missing("most.asc"), None);
    for command in ["surface", "area-law"] {
        let said = place.refuse(&[command, "hundredth.asc"]);
        assert!(said.starts_with("error: hundredth.asc: 9072 of 9216 points are missing"), "{said}");
    }
    let law =
        ["area-law", "tenth.asc", "--windows", "1", "--pressures-mpa", "0.7,2.6", "--threshold-mpa", "0.7", "--json"];
    let law = place.json(&law);
    assert!(strings(&law["warnings"])[0].starts_with("missing points: 88 %"), "{law}");
}

#[test]
fn a_law_that_jumps_or_exceeds_one_is_told() {
    let scene = |factor: &str| SCENE.replace("[1.0, 0.96, 0.90, 0.60]", factor);
    let place =
        Place::with(&[("jump.toml", &scene("[0.9, 0.85, 0.8, 0.6]")), ("above.toml", &scene("[1.0, 1.05, 1.2, 1.0]"))]);
    for (file, warning) in [
        ("jump.toml", "area law jumps: f falls from 1 to 0.9 at its first pressure, 0.7 MPa"),
        ("above.toml", "factor above 1: f is 1.2 at 2.6 MPa"),
    ] {
        let result = place.json(&["simulate", file, "--json"]);
        assert!(strings(&result["material"]["warnings"])[0].starts_with(warning), "{result}");
        assert!(place.succeed(&["simulate", file]).contains(&format!("! the material is doubtful: {warning}")));
    }
    let plain = Place::with(&[("scene.toml", SCENE)]);
    assert!(plain.json(&["simulate", "scene.toml", "--json"])["material"].get("warnings").is_none());
}
