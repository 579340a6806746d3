//! Designs for several sliding directions.

use crate::common::{Place, at, column, small, trusted};

/// Small design of rectangles, half as long as the minimum width.
fn rectangles(angles: &str) -> String {
    let pattern = format!("\"rectangle\"\nlength_um = 40.0\nsliding_angle_deg = {angles}");
    small()
        .replace("\"groove\"", &pattern)
        .replace("[40.0, 80.0]", "[80.0, 160.0]")
        .replace("spacing_um = 60.0", "spacing_um = 100.0")
        .replace("[0.65, 2.6]", "[1.3, 2.6]")
}

#[test]
fn the_target_holds_in_each_direction() {
    let place = Place::with(&[("both.toml", &trusted(&rectangles("[0, 90]")))]);
    let found = place.optimized("both", 0).1;
    assert_eq!(column(&found["expected"], "/sliding_angle_deg"), [0.0, 0.0, 90.0, 90.0]);
    for row in found["expected"].as_array().unwrap() {
        let median = at(row, "/median");
        assert!((at(row, "/target_low")..=at(row, "/target_high")).contains(&median) && median < 0.999, "{row}");
    }
    // Each is what the turned scene gives alone as a steady cell, but for what is beyond cells, which is that of the first.
    let scene = place.read("out/both/scene.toml");
    let modelled = column(&found["modelled"], "/ratio");
    let beyond = [("0.0", &modelled[..2]), ("90.0", &modelled[2..])].map(|(angle_deg, modelled)| {
        let planform = "planform = \"rectangle\"";
        place.write("turned.toml", scene.replace(planform, &format!("{planform}\nsliding_angle_deg = {angle_deg}")));
        let cells = place.ratios("turned.toml --fidelity steady --extent cell");
        [0, 1].map(|row| (modelled[row] / cells[row]).ln())
    });
    for row in [0, 1] {
        assert!((beyond[0][row] - beyond[1][row]).abs() < 1e-3, "{beyond:?}");
    }
    // A second run takes the study over, and one of other directions does not.
    place.succeed("optimize both.toml --resume");
    place.write("both.toml", rectangles("[0, 45]"));
    assert!(place.refuse("optimize both.toml --resume").contains("sliding_angle_deg"));
}

#[test]
fn directions_alike_by_symmetry_are_solved_once() {
    let text = small().replace("\"groove\"", "\"groove\"\nsliding_angle_deg = [0.0, 180.0]");
    let found = Place::with(&[("groove.toml", &text)]).optimized("groove", 0).1;
    assert_eq!((found["dimensions"].as_u64(), found["expected"].as_array().map(Vec::len)), (Some(2), Some(2)));
    assert!(found["model"].to_string().contains("sliding at 180 deg is by symmetry what sliding at 0 deg is"));
}
