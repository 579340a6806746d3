//! Measured flat friction as the local law, compared with the area law; maps before and after a test; errors of local
//! coefficients and the excess of dynamic friction in material files.

use crate::common::{CALIBRATION, Place, SCENE, at, measured, patterned};

const FLAT: &str =
    "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.248,0.002\n204,2,15,0.278,0.002\n";
const SLOPE: &str = "persson_rms_slope = 0.0137\n";

/// Steady ratio of a groove and flat friction at the heavier load.
fn solved(place: &Place, material: &str) -> [f64; 2] {
    place.write("scene.toml", measured(SCENE, material).replace("[0.65, 2.6]", "2.5974"));
    let found = place.json("simulate scene.toml --json");
    ["ratio", "mu_flat"].map(|key| at(&found, &format!("/errors/by_pressure/0/{key}/value")))
}

#[test]
fn by_the_measured_law_the_same_groove_raises_friction_that_the_area_law_lowers() {
    let cut = FLAT.replace("0.248", "0.20").replace("0.278", "0.23");
    let text = |surface: &str| patterned("").replace(SLOPE, surface);
    let place = Place::with(&[
        ("measured.toml", &text("local_law = \"measured\"\nextrapolation = \"constant\"\n")),
        ("area.toml", &text(&format!("{SLOPE}local_law = \"area\"\n"))),
        ("flat.csv", FLAT),
        ("patterned.csv", &cut),
    ]);
    place.succeed("calibrate measured.toml -o m.toml");
    place.succeed("calibrate area.toml -o a.toml");
    let [by_law, by_area] = ["m.toml", "a.toml"].map(|name| place.toml(name));
    assert_eq!(by_law["area_law"]["origin"].as_str(), Some("measured"));
    assert!(by_law.get("warnings").is_none(), "a law that rises is no fault of contact area");
    let ([raised, flat], [lowered, flat_by_area]) = (solved(&place, "m.toml"), solved(&place, "a.toml"));
    assert!(raised > 1.0 && raised < 1.05 && lowered < 0.95, "{raised} {lowered}");
    // Steady friction times the excess is what was measured, by either law.
    assert!((flat / 0.278 - 1.0).abs() < 2e-3 && (flat_by_area / 0.278 - 1.0).abs() < 2e-3, "{flat} {flat_by_area}");

    // A page without a picture of contact area, which a measured law does not have; both laws where both fit.
    place.succeed("validate measured.toml --sliding-um 0 -o page");
    assert!(place.read("page/report.html").contains("measured law") && !place.path("page/area-law.svg").exists());
    assert!(place.succeed("validate area.toml").contains("Two laws fit the flat samples alike"));

    // What does not take the law for known is more by what Young's modulus leaves open of f, at the heavier load.
    let table = &by_area["friction"]["conditions"][0];
    let of = |key: &str, place: usize| table[key][place].as_float().unwrap();
    assert!((of("dynamic_std_error", 0) / of("dynamic_std_error_given_law", 0) - 1.0).abs() < 0.1);
    assert!(of("dynamic_std_error", 1) > 3.0 * of("dynamic_std_error_given_law", 1), "{table}");
    assert!((of("dynamic_over_steady", 1) - 1.015).abs() < 0.01, "{table}");
    assert!(by_law["friction"]["conditions"][0].get("dynamic_std_error_given_law").is_none());
}

#[test]
fn a_map_after_the_test_is_compared_and_the_law_rests_on_the_one_before() {
    let map = |after: &str| CALIBRATION.replace(SLOPE, &format!("map = \"before.asc\"\nsynthetic = true\n{after}"));
    let place = Place::with(&[
        ("alone.toml", &map("")),
        ("both.toml", &map("map_after = \"after.asc\"\n")),
        ("flat.csv", FLAT),
    ]);
    place.succeed("synthesize -o before.asc --pixels 256");
    // The same surface, rougher by as much as the published samples were after the test.
    let rougher = |line: &str| {
        let heights: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        heights.map_or_else(
            |_| format!("{line}\n"),
            |heights| heights.iter().map(|height| format!("{} ", height * 0.426 / 0.158)).collect::<String>() + "\n",
        )
    };
    place.write("after.asc", place.read("before.asc").lines().map(rougher).collect::<String>());
    let [alone, both] = ["alone", "both"].map(|name| {
        place.succeed(&format!("calibrate {name}.toml -o {name}-m.toml"));
        place.toml(&format!("{name}-m.toml"))
    });
    assert_eq!(alone["area_law"], both["area_law"]);
    assert!(both["notes"].to_string().contains("Sa is 0.426 um instead of 0.158 um"), "{}", both["notes"]);
    assert!(!alone["notes"].to_string().contains("before the test"));
}
