//! The land of a cut sample, which is steeper than the flat sample, corrects the modelled ratio of its trial.

use crate::common::{CALIBRATION, Place, THREE_FORCES, number};
use serde_json::Value;

/// Options for both maps: pixels of 4 um, waves of 32 um and longer.
const MAP: &str = "synthesize --pixels 256 --waves 4:32 --quiet";
/// Grooves of the cut sample, without scatter.
const CUT: &str = "--cavities 60,140,5.2 --wall-um 4 --cavity-std 0,0,0 -o cut.asc";

#[test]
fn a_land_a_fifth_steeper_lowers_the_modelled_ratio_as_its_contact_area() {
    let surface = |map: &str| CALIBRATION.replace("persson_rms_slope = 0.0137", map);
    let trial = |more: &str| {
        format!(
            "[[trial]]\nname = \"cut\"\nmeasurements = \"cut.csv\"\n{more}[trial.pattern]\nwidth_um = 60.0\nspacing_um = 140.0\n\
             depth_um = 5.2\n"
        )
    };
    let file = |map: &str, more: &str| surface(map) + &trial(more);
    let mapped = "map = \"cut.asc\"\n";
    let place = Place::with(&[
        ("flat.csv", THREE_FORCES),
        ("cut.csv", THREE_FORCES),
        ("alone.toml", &file("map = \"flat.asc\"", "")),
        ("mapped.toml", &file("map = \"flat.asc\"", mapped)),
        ("slope.toml", &file("persson_rms_slope = 0.0137", mapped)),
        ("uncut.toml", &file("map = \"flat.asc\"", "map = \"flat.asc\"\n")),
        ("fine.toml", &file("map = \"flat.asc\"", "map = \"fine.asc\"\n")),
    ]);
    let synthesize = |more: &str| {
        place.succeed(&MAP.split_whitespace().chain(more.split_whitespace()).collect::<Vec<_>>());
    };
    synthesize("--rms-slope 0.02 --side-mm 1.024 -o flat.asc");
    synthesize(&format!("--rms-slope 0.024 --side-mm 1.024 {CUT}"));
    synthesize("--rms-slope 0.024 --side-mm 0.512 -o fine.asc");
    let [alone, mapped] = ["alone.toml", "mapped.toml"].map(|name| place.json(&["trials", name, "--json", "-q"]));
    assert!(alone.get("lands").is_none());
    let land = &mapped["lands"][0];
    let (over_flat, log_std) = (number(&land["over_flat"]), number(&land["log_std"]));
    assert!((over_flat / 1.2 - 1.0).abs() < 3.0 * log_std.max(0.01) && log_std < 0.06, "{land}");
    let modelled = |of: &Value| -> Vec<f64> {
        of["trials"][0]["measured"].as_array().unwrap().iter().map(|at| number(&at["modelled"])).collect()
    };
    let factors: Vec<f64> = land["factor"].as_array().unwrap().iter().map(number).collect();
    for ((before, after), factor) in modelled(&alone).iter().zip(modelled(&mapped)).zip(&factors) {
        assert!((after / before - factor).abs() < 1e-4, "{before} {after} {factor}");
        // Between area in proportion to load and full contact.
        assert!((0.97 / over_flat..0.99).contains(factor), "{factor}");
    }
    // The less the load, the more the slope counts.
    assert!(factors.is_sorted(), "{factors:?}");
    let said = place.succeed(&["trials", "mapped.toml", "-q"]);
    assert!(said.contains("land of cut: rms slope") && said.contains("times the flat sample's"), "{said}");
    for (name, says) in [
        ("slope.toml", "no map of a flat sample"),
        ("uncut.toml", "heights do not part"),
        ("fine.toml", "expected pixels of 4 x 4 um"),
    ] {
        let told = place.refuse(&["trials", name]);
        assert!(told.contains(says), "{name}: {told}");
    }
}
