//! Designs whose target must hold in several sliding directions.

use std::fs;

use crate::common::{Place, result, small};
use serde_json::Value;

/// A small design of rectangles, half as long as its narrowest is wide.
fn rectangles(angles: &str) -> String {
    let pattern = format!("\"rectangle\"\nlength_um = 40.0\nsliding_angle_deg = {angles}");
    small().replace("\"groove\"", &pattern).replace("[40.0, 80.0]", "[80.0, 160.0]")
}

#[test]
fn the_target_holds_in_each_direction_and_the_worst_decides() {
    let place = Place::with(&[]);
    fs::write(place.path("both.toml"), rectangles("[0, 90]")).unwrap();
    let said = place.succeed(&["optimize", "both.toml", "-o", "both"]);
    assert!(said.contains("sliding at 0 deg: ratio") && said.contains("sliding at 90 deg: ratio"), "{said}");
    let found = result(&place, "both");
    let at = found["conditions"]["at"].as_array().unwrap();
    let angles: Vec<f64> = at.iter().map(|at| at["sliding_angle_deg"].as_f64().unwrap()).collect();
    assert_eq!((angles, found["conditions"]["held"].as_bool()), (vec![0.0, 90.0], Some(true)));
    let misfit = |at: &Value| at["misfit"].as_f64().unwrap();
    let worst = usize::try_from(found["conditions"]["worst"].as_u64().unwrap()).unwrap();
    assert!(at.iter().all(|other| misfit(other) <= misfit(&at[worst])));
    assert!((found["misfit"]["confirmed"].as_f64().unwrap() - misfit(&at[worst])).abs() < 1e-9);
    assert!(at[worst]["in_time"].as_bool().unwrap(), "{at:?}");
    // Each is what the turned scene gives alone, run as the design's was.
    let scene = fs::read_to_string(place.path("both/scene.toml")).unwrap();
    for (angle_deg, at) in ["0.0", "90.0"].iter().zip(at) {
        let planform = "planform = \"rectangle\"";
        let turned = scene.replace(planform, &format!("{planform}\nsliding_angle_deg = {angle_deg}"));
        fs::write(place.path("turned.toml"), turned).unwrap();
        let told: Value = serde_json::from_str(&place.succeed(&["simulate", "turned.toml", "--json"])).unwrap();
        for (own, told) in at["by_pressure"].as_array().unwrap().iter().zip(told["results"].as_array().unwrap()) {
            let [own, told] = [own, told].map(|value| value["ratio"].as_f64().unwrap());
            assert!((own - told).abs() < 1e-9 && own < 0.999, "{angle_deg}: {own} {told}");
        }
    }
    // A second run takes the study over, and one of other directions does not.
    place.succeed(&["optimize", "both.toml", "-o", "both", "--resume"]);
    fs::write(place.path("both.toml"), rectangles("[0, 45]")).unwrap();
    let refused = place.refuse(&["optimize", "both.toml", "-o", "both", "--resume"]);
    assert!(refused.contains("sliding_angle_deg"), "{refused}");
}

#[test]
fn samples_slide_in_each_direction_at_the_same_pressure() {
    let place = Place::with(&[]);
    let one = rectangles("[0, 90]").replace("[0.65, 2.6]", "[2.6]");
    let text = format!("{one}\n[tolerances]\nwidth_std_um = 2.0\n");
    fs::write(place.path("both.toml"), text).unwrap();
    place.succeed(&["optimize", "both.toml", "-o", "both"]);
    let found = result(&place, "both");
    let spread = found["robustness"]["samples"]["by_pressure"].as_array().unwrap();
    let confirmed = found["confirmed"].as_array().unwrap();
    assert_eq!(spread.len(), confirmed.len());
    for (samples, confirmed) in spread.iter().zip(confirmed) {
        let [mean, std] = ["mean", "std"].map(|key| samples["ratio"][key].as_f64().unwrap());
        assert!((mean - confirmed["ratio"].as_f64().unwrap()).abs() < std, "{samples} {confirmed}");
    }
}

#[test]
fn directions_alike_by_symmetry_are_solved_once() {
    let place = Place::with(&[]);
    fs::write(place.path("groove.toml"), small().replace("\"groove\"", "\"groove\"\nsliding_angle_deg = [0.0, 180.0]"))
        .unwrap();
    place.succeed(&["optimize", "groove.toml", "-o", "groove"]);
    let found = result(&place, "groove");
    assert_eq!((found["dimensions"].as_u64(), found["conditions"].is_null()), (Some(2), true));
    let model = found["model"].as_array().unwrap();
    let said = "sliding at 180 deg is by symmetry what sliding at 0 deg is: solved once";
    assert!(model.iter().any(|line| line == said), "{model:?}");
}

#[test]
fn wrong_directions_are_refused_where_they_stand() {
    let place = Place::with(&[]);
    for (angles, expected) in [
        ("[]", ":22: pattern.sliding_angle_deg: is empty; expected at least one number"),
        ("[0, 200]", ":22: pattern.sliding_angle_deg: 200 is out of range"),
        ("[0, \"x\"]", ":22: pattern.sliding_angle_deg"),
    ] {
        fs::write(
            place.path("a.toml"),
            small().replace("\"groove\"", &format!("\"groove\"\nsliding_angle_deg = {angles}")),
        )
        .unwrap();
        let refused = place.refuse(&["optimize", "a.toml", "-o", "a"]);
        assert!(refused.contains(expected), "{refused}");
    }
    // The plane has no section along grooves, and a scene is one run.
    let text = small().replace("\"groove\"", "\"groove\"\nsliding_angle_deg = [0, 90]");
    fs::write(place.path("a.toml"), text.replace("seed = 1", "seed = 1\ndimensions = 2")).unwrap();
    let refused = place.refuse(&["optimize", "a.toml", "-o", "a"]);
    assert!(refused.contains("pattern.sliding_angle_deg") && refused.contains("three dimensions"), "{refused}");
}
