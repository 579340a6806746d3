//! Measured flat friction as the local law, compared with the area law; maps before and after a test; errors of local
//! coefficients and the excess of dynamic friction in material files.

use crate::common::{CALIBRATION, Place, SCENE, measured, patterned};
use serde_json::Value;

const FLAT: &str =
    "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.248,0.002\n204,2,15,0.278,0.002\n";
const MEASURED: &str = "local_law = \"measured\"\nextrapolation = \"constant\"\n";

fn with_surface(surface: &str) -> String {
    CALIBRATION.replace("persson_rms_slope = 0.0137\n", surface)
}

/// Steady ratio of a groove and flat friction at the heavier load.
fn solved(place: &Place, material: &str) -> [f64; 2] {
    let scene = measured(SCENE, material).replace("[0.65, 2.6]", "2.5974");
    place.write("scene.toml", scene);
    let found: Value = place.json(&["simulate", "scene.toml", "--json"]);
    let row = &found["errors"]["by_pressure"][0];
    ["ratio", "mu_flat"].map(|key| row[key]["value"].as_f64().unwrap())
}

#[test]
fn by_the_measured_law_the_same_groove_raises_friction_that_the_area_law_lowers() {
    let cut = FLAT.replace("0.248", "0.20").replace("0.278", "0.23");
    let text = |surface: &str| patterned().replace("persson_rms_slope = 0.0137\n", surface);
    let place = Place::with(&[
        ("measured.toml", &text(MEASURED)),
        ("area.toml", &text("persson_rms_slope = 0.0137\nlocal_law = \"area\"\n")),
        ("flat.csv", FLAT),
        ("patterned.csv", &cut),
    ]);
    let told = place.succeed(&["calibrate", "measured.toml", "-o", "m.toml"]);
    assert!(told.contains("measured flat friction itself"), "{told}");
    place.succeed(&["calibrate", "area.toml", "-o", "a.toml"]);
    let written = place.toml("m.toml");
    assert_eq!(written["area_law"]["origin"].as_str(), Some("measured"));
    assert!(written.get("warnings").is_none(), "a law that rises is no fault of contact area");
    let ([raised, flat], [lowered, flat_by_area]) = (solved(&place, "m.toml"), solved(&place, "a.toml"));
    assert!(raised > 1.0 && raised < 1.05 && lowered < 0.95, "{raised} {lowered}");
    // Steady friction times the excess is what was measured, by either law.
    assert!((flat / 0.278 - 1.0).abs() < 2e-3 && (flat_by_area / 0.278 - 1.0).abs() < 2e-3, "{flat} {flat_by_area}");

    // A page without a picture of contact area, which a measured law does not have.
    place.succeed(&["validate", "measured.toml", "--sliding-um", "0", "-o", "page"]);
    let page = place.read("page/report.html");
    assert!(page.contains("measured law") && !place.path("page/area-law.svg").exists());

    // Both laws side by side, with what would decide.
    let told = place.succeed(&["validate", "area.toml"]);
    assert!(told.contains("grooves, constant") && told.contains("squares, logarithmic"), "{told}");
    assert!(told.contains("Two laws fit the flat samples alike") && told.contains("would decide"), "{told}");

    // What does not take the law for known is more by what Young's modulus leaves open of f, at the heavier load.
    let written = place.toml("a.toml");
    let table = &written["friction"]["conditions"][0];
    let at = |key: &str, place: usize| table[key][place].as_float().unwrap();
    assert!((at("dynamic_std_error", 0) / at("dynamic_std_error_given_law", 0) - 1.0).abs() < 0.1);
    assert!(at("dynamic_std_error", 1) > 3.0 * at("dynamic_std_error_given_law", 1), "{table}");
    assert!((at("dynamic_over_steady", 1) - 1.015).abs() < 0.01, "{table}");
    let written = place.toml("m.toml");
    assert!(written["friction"]["conditions"][0].get("dynamic_std_error_given_law").is_none());
}

#[test]
#[ignore = "takes ten to twenty seconds of both cores"]
fn a_fitted_law_is_compared_as_trials_have_it() {
    let calibration = "calibration/synthetic-polymer";
    let place = Place::with(&[]);
    let whole = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().join(calibration);
    let file = whole.join("calibration.toml").to_str().unwrap().to_owned();
    let found = place.json(&["validate", &file, "--slope-factors", "2", "--json"]);
    let learned = place.json(&["trials", &file, "--json"]);
    let modelled = |factor: f64| -> Vec<f64> {
        let of = |row: &serde_json::Value| {
            let laws = row["modelled"].as_array().unwrap();
            laws.iter().find(|law| law["slope_factor"] == factor).unwrap()["ratio_groove"].as_f64().unwrap()
        };
        found["results"].as_array().unwrap().iter().map(of).collect()
    };
    let of_trials = learned["trials"][0]["measured"].as_array().unwrap().iter();
    let of_trials: Vec<f64> = of_trials.map(|of| of["modelled"].as_f64().unwrap()).collect();
    let [own, steeper] = [modelled(1.0), modelled(2.0)];
    assert_eq!((own.len(), of_trials.len()), (2, 2));
    // Trials are modelled on their specimen, a comparison as endless: that is less than what another law changes.
    let law_changes = (steeper[1] - own[1]).abs();
    let alike = own.iter().zip(&of_trials).all(|(own, other)| (own - other).abs() < law_changes / 3.0);
    assert!(alike, "{own:?} {steeper:?} {of_trials:?}");
    // A steeper surface is farther from full contact: its friction is closer to the load.
    assert!(own[1] < 0.9 && own[1] < own[0] && steeper[1] > own[1], "{own:?} {steeper:?}");
}

#[test]
fn a_map_after_the_test_is_compared_and_the_law_rests_on_the_one_before() {
    let map = |after: &str| with_surface(&format!("map = \"before.asc\"\nsynthetic = true\n{after}"));
    let place = Place::with(&[
        ("alone.toml", &map("")),
        ("both.toml", &map("map_after = \"after.asc\"\n")),
        ("stray.toml", &with_surface("persson_rms_slope = 0.0137\nmap_after = \"before.asc\"\n")),
        ("flat.csv", FLAT),
    ]);
    place.succeed(&["synthesize", "-o", "before.asc", "--pixels", "256"]);
    // The same surface, rougher by as much as the published samples were after the test.
    let rougher = |line: &str| {
        let heights: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        heights.map_or_else(
            |_| line.to_owned(),
            |heights| heights.iter().map(|height| (height * 0.426 / 0.158).to_string()).collect::<Vec<_>>().join(" "),
        )
    };
    let before = place.read("before.asc");
    place.write("after.asc", before.lines().map(|line| rougher(line) + "\n").collect::<String>());
    place.succeed(&["calibrate", "alone.toml", "-o", "alone-m.toml"]);
    place.succeed(&["calibrate", "both.toml", "-o", "both-m.toml"]);
    let (alone, both) = (place.toml("alone-m.toml"), place.toml("both-m.toml"));
    assert_eq!(alone["area_law"], both["area_law"]);
    let notes = both["notes"].to_string();
    assert!(notes.contains("Sa is 0.426 um instead of 0.158 um") && notes.contains("at 2.6 MPa"), "{notes}");
    assert!(!alone["notes"].to_string().contains("before the test"));
    let message = place.refuse(&["calibrate", "stray.toml"]);
    assert!(message.contains("surface.map_after") && message.contains("the map before the test"), "{message}");
}
