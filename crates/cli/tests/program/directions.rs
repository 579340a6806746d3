//! Designs for several sliding directions.

use crate::common::{Place, json, number, result, small, trusted};

/// Small design of rectangles, half as long as the minimum width.
fn rectangles(angles: &str) -> String {
    let pattern = format!("\"rectangle\"\nlength_um = 40.0\nsliding_angle_deg = {angles}");
    let text = small()
        .replace("\"groove\"", &pattern)
        .replace("[40.0, 80.0]", "[80.0, 160.0]")
        .replace("spacing_um = 60.0", "spacing_um = 100.0");
    text.replace("[0.65, 2.6]", "[1.3, 2.6]")
}

#[test]
fn the_target_holds_in_each_direction() {
    let place = Place::with(&[]);
    place.write("both.toml", trusted(&rectangles("[0, 90]")));
    let said = place.succeed(&["optimize", "both.toml", "-o", "both"]);
    assert!(said.contains("at 0 deg") && said.contains("at 90 deg"), "{said}");
    let found = result(&place, "both");
    let expected = found["expected"].as_array().unwrap();
    let angles: Vec<f64> = expected.iter().map(|at| number(&at["sliding_angle_deg"])).collect();
    assert_eq!(angles, [0.0, 0.0, 90.0, 90.0]);
    for at in expected {
        let median = number(&at["median"]);
        assert!((number(&at["target_low"])..=number(&at["target_high"])).contains(&median) && median < 0.999, "{at}");
    }
    // Each is what the turned scene gives alone as a steady cell, but for what is beyond cells, which is that of the first.
    let scene = place.read("both/scene.toml");
    let beyond = ["0.0", "90.0"].map(|angle_deg| {
        let planform = "planform = \"rectangle\"";
        let turned = scene.replace(planform, &format!("{planform}\nsliding_angle_deg = {angle_deg}"));
        place.write("turned.toml", turned);
        let told = place.succeed(&["simulate", "turned.toml", "--json", "--fidelity", "steady", "--extent", "cell"]);
        let ratios =
            json(&told)["results"].as_array().unwrap().iter().map(|load| number(&load["ratio"])).collect::<Vec<_>>();
        let first = if angle_deg == "0.0" { 0 } else { 2 };
        [0, 1].map(|row| (number(&found["modelled"][first + row]["ratio"]) / ratios[row]).ln())
    });
    for row in [0, 1] {
        assert!((beyond[0][row] - beyond[1][row]).abs() < 1e-3, "{beyond:?}");
    }
    // A second run takes the study over, and one of other directions does not.
    place.succeed(&["optimize", "both.toml", "-o", "both", "--resume"]);
    place.write("both.toml", rectangles("[0, 45]"));
    let refused = place.refuse(&["optimize", "both.toml", "-o", "both", "--resume"]);
    assert!(refused.contains("sliding_angle_deg"), "{refused}");
}

#[test]
fn directions_alike_by_symmetry_are_solved_once() {
    let place = Place::with(&[]);
    place.write("groove.toml", small().replace("\"groove\"", "\"groove\"\nsliding_angle_deg = [0.0, 180.0]"));
    place.succeed(&["optimize", "groove.toml", "-o", "groove"]);
    let found = result(&place, "groove");
    assert_eq!((found["dimensions"].as_u64(), found["expected"].as_array().map(Vec::len)), (Some(2), Some(2)));
    let model = found["model"].as_array().unwrap();
    let said = "sliding at 180 deg is by symmetry what sliding at 0 deg is: solved once";
    assert!(model.iter().any(|line| line == said), "{model:?}");
}
