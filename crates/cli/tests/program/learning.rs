//! `next --learn`: a disc of two sectors that tells mechanisms apart.

use crate::common::{DESIGN, Place, at};

#[test]
fn the_disc_that_teaches_most_is_drawn_with_what_every_mechanism_predicts() {
    let design = DESIGN
        .replace("[40.0, 400.0]", "120.0")
        .replace("[40.0, 1000.0]", "320.0")
        .replace("[2.0, 50.0]", "10.4")
        .replace("layer_um = 200.0\nblock_um = 10.0", "layer_um = 100.0\nblock_um = 20.0");
    let place = Place::with(&[("design.toml", &design)]);
    let said = place.succeed("next design.toml --learn -o out -q");
    let files = "mechanisms.svg pattern.dxf pattern.svg process.toml result.json timings.json trials.toml";
    assert_eq!(place.listed("out"), files);
    let found = place.result("out");
    let learning = &found["learning"];
    assert!((0.0..at(learning, "/open_bits")).contains(&at(learning, "/bits")), "{learning}");
    let picture = place.read("out/mechanisms.svg");
    for of in learning["mechanisms"].as_array().unwrap() {
        let name = of["mechanism"].as_str().unwrap();
        assert!(said.contains(name) && picture.contains(name), "{name}");
        assert_eq!(of["loads"].as_array().unwrap().len(), 2, "one prediction per pressure");
    }
    // The files cut the sectors that the record names, one of them turned by a right angle.
    let trials = place.toml("out/trials.toml");
    let turned = |trial: &toml::Value| trial["pattern"].get("angle_deg").map_or(0.0, |angle| angle.as_float().unwrap());
    let angles: Vec<f64> = trials["trial"].as_array().unwrap().iter().map(turned).collect();
    assert_eq!(angles, [0.0, 90.0]);
    let sheet = serde_json::to_value(place.toml("out/process.toml")).unwrap();
    for (sector, sample) in sheet["sector"].as_array().unwrap().iter().zip(found["samples"].as_array().unwrap()) {
        for key in ["width_um", "spacing_um", "depth_um"] {
            assert_eq!(sector["pattern"][key], sample["design"][key], "{key}");
        }
    }
    // The same command prints the same record, and takes no number of samples.
    assert_eq!(place.json("next design.toml --learn --json -q"), found);
    place.refuse("next design.toml --learn --count 2");
}
