//! Thickness of the specimen in the model.

use crate::common::{DESIGN, Place, SCENE, correction, result};
use serde_json::Value;

/// Effects as results name them.
const BEHIND: &str = "specimen behind the layer";
const TILT: &str = "tilt of the pressure";

/// Scene of wide grooves, whose ratio depends on the thickness; `sample` replaces the layer.
fn wide(sample: &str) -> String {
    let wide = SCENE.replace("130.0", "400.0").replace("370.0", "824.5").replace("depth_um = 20.0", "depth_um = 49.4");
    wide.replace("layer_um = 200.0\n", sample).replace("block_um = 10.0", "block_um = 20.0")
}

fn ratios(result: &Value) -> Vec<f64> {
    result["results"].as_array().unwrap().iter().map(|load| load["ratio"].as_f64().unwrap()).collect()
}

/// Change of the ratio by `effect` at every load.
fn changes(result: &Value, effect: &str) -> Vec<Option<f64>> {
    let change = |load| Some(correction(load, effect)?["change"].as_f64().unwrap());
    result["results"].as_array().unwrap().iter().map(change).collect()
}

/// Number after `words` in the statements on the model of `result`.
fn said(result: &Value, words: &str) -> f64 {
    let model = result["model"].to_string();
    let number = model.split_once(words).unwrap().1;
    number.split_once(" at most").map_or(number, |(number, _)| number).parse().unwrap()
}

#[test]
fn a_scene_without_a_layer_is_the_specimen_as_thick_as_it_is() {
    let place = Place::with(&[
        ("none.toml", &wide("")),
        ("seven.toml", &wide("thickness_mm = 7.0\n")),
        ("high.toml", &wide("layer_um = 2400.0\n")),
        ("thin.toml", &wide("layer_um = 200.0\n")),
        ("film.toml", &wide("thickness_mm = 0.1\n")),
    ]);
    // A film of ten rows is its own layer.
    place.succeed(&["simulate", "film.toml"]);
    let [none, seven, high, thin] =
        ["none", "seven", "high", "thin"].map(|name| place.json(&["simulate", &format!("{name}.toml"), "--json"]));
    assert_eq!(ratios(&none), ratios(&seven));
    // Two periods are a half-space; block by block they take far longer.
    for (own, high) in ratios(&none).iter().zip(ratios(&high)) {
        assert!((own - high).abs() < 1e-6, "{own} {high}");
    }
    let differences: Vec<f64> = ratios(&none).iter().zip(ratios(&thin)).map(|(own, thin)| own - thin).collect();
    let widest = differences.iter().copied().fold(0.0, f64::min);
    assert!(differences.iter().all(|difference| *difference < -0.002), "{differences:?}");
    assert!((said(&thin, "would change the ratio by ") - widest).abs() < 6e-5, "{widest}");
    assert_eq!(changes(&none, BEHIND), [None, None]);
    assert!(none["model"].to_string().contains("specimen 7 mm thick"));
    assert!(
        thin["model"].to_string().contains("a specimen much thicker than the pattern is wide would change the ratio")
    );
}

#[test]
fn what_is_added_to_strips_is_among_the_errors() {
    let on_disc = |sample: &str| {
        let text = wide(sample).replace("length_um = 9960.0\n", "").replace("\"cell\"", "\"sample\"");
        format!("{text}[specimen]\nshape = \"disc\"\ndiameter_mm = 10.0\n")
    };
    let place = Place::with(&[("thick.toml", &on_disc("")), ("thin.toml", &on_disc("layer_um = 200.0\n"))]);
    let [thick, thin] = ["thick", "thin"].map(|name| place.json(&["simulate", &format!("{name}.toml"), "--json"]));
    let added = changes(&thick, BEHIND);
    // Half of what the tilt changes is in the ratio.
    let tilts: Vec<f64> = changes(&thick, TILT).into_iter().map(|half| 2.0 * half.unwrap()).collect();
    for ((own, thin), (added, tilt)) in ratios(&thick).iter().zip(ratios(&thin)).zip(added.iter().zip(&tilts)) {
        let added = added.unwrap();
        assert!((own - thin - added - 0.5 * tilt).abs() < 1e-9 && added < -0.002, "{own} {thin}");
    }
    let part = |result: &Value, input: &str| {
        let parts = result["errors"]["by_pressure"][1]["ratio"]["parts"].as_array().unwrap();
        let own = parts.iter().find(|part| part["input"] == input);
        own.map(|part| part["std"].as_f64().unwrap())
    };
    // The widest change that friction makes by tilting the pressure, to four decimals.
    let change = said(&thick, "this moves the ratio by ");
    assert!(
        tilts.iter().any(|tilt| (tilt - change).abs() < 5e-5)
            && tilts.iter().all(|tilt| tilt.abs() < change.abs() + 5e-5)
    );
    // What ends leave open, and 15 % of what the specimen changes; a third of the tilt.
    let open = 0.001_f64.hypot(0.15 * added[1].unwrap());
    assert!((part(&thick, BEHIND).unwrap() - open).abs() < 4e-5, "{open} {:?}", part(&thick, BEHIND));
    assert!((part(&thick, TILT).unwrap() - 0.34 * tilts[1].abs()).abs() < 1e-5, "{tilts:?} {:?}", part(&thick, TILT));
    assert!(part(&thin, BEHIND).is_none() && part(&thin, TILT).is_none());
}

#[test]
fn designs_are_searched_in_the_specimen_as_thick_as_it_is() {
    let narrow = DESIGN.replace("[40.0, 400.0]", "400.0").replace("[40.0, 1000.0]", "820.0");
    let narrow = narrow.replace("[2.0, 50.0]", "46.8").replace("value = 0.9", "value = 0.85");
    let narrow =
        narrow.replace("diameter_mm = 10.0", "diameter_mm = 3.0").replace("block_um = 10.0", "block_um = 20.0");
    let place = Place::with(&[("thick.toml", &narrow.replace("layer_um = 200.0\n", ""))]);
    place.run(&["optimize", "thick.toml", "-o", "out", "--quiet"]);
    let design = place.read("out/scene.toml");
    assert!(design.contains("layer_um = 200.0") && design.contains("thickness_mm = 7.0"), "{design}");
    let found = result(&place, "out");
    assert!(correction(&found["confirmed"][0], BEHIND).unwrap()["change"].as_f64().unwrap() < 0.0);
    // The written scene gives the confirmed ratio to the last bit.
    let again = place.json(&["simulate", "out/scene.toml", "--json"]);
    for (place, load) in found["confirmed"].as_array().unwrap().iter().enumerate() {
        assert_eq!(load["ratio"], again["results"][place]["ratio"]);
    }
    // A study of thin layers holds other answers.
    let study = place.read("out.study.jsonl");
    assert!(study.lines().next().unwrap().contains("\"thickness_mm\":7.0"), "{}", study.lines().next().unwrap());
}
