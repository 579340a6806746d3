//! Rims along the edges of cavities: in scenes, designs and calibrations, and in all files written for them.

use std::fs;

use crate::common::{DESIGN, Place, SCENE, THREE_FORCES, number, patterned_calibration};
use serde_json::Value;

const RIMS: &str = "rim_height_um = 0.1\nrim_width_um = 20.0\nrim_profile = \"flat\"\n";

fn scene(rims: &str) -> String {
    SCENE.replace("depth_um = 20.0\n", &format!("depth_um = 20.0\n{rims}"))
}

/// Design of a short sample at one pressure.
fn design(rims: &str, tolerances: &str) -> String {
    let text = DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("layer_um = 200.0", "layer_um = 60.0")
        .replace("[2.0, 50.0]", "[2.0, 30.0]")
        .replace("[0.65, 2.6]", "[1.3]")
        .replace("value = 0.9\ntolerance = 0.01", "value = 0.88\ntolerance = 0.03")
        .replace("[40.0, 400.0]", "[60.0, 150.0]")
        .replace("[40.0, 1000.0]", "[80.0, 300.0]")
        .replace("planform = \"groove\"\n", &format!("planform = \"groove\"\n{rims}"));
    format!("{text}{tolerances}")
}

#[test]
fn a_scene_says_its_rims_and_one_of_no_height_is_none() {
    let flat = scene("rim_height_um = 0\nrim_width_um = 20.0\n");
    let (with, without) = (scene(RIMS), scene(""));
    let place = Place::with(&[("with.toml", &with), ("without.toml", &without), ("flat.toml", &flat)]);
    let simulated = |name: &str| place.json(&["simulate", name, "--json"]);
    assert!(place.succeed(&["simulate", "with.toml"]).contains("flat rims 0.1 um high, 20 um wide"));
    let (with, without) = (simulated("with.toml"), simulated("without.toml"));
    // The higher the load, the more a rim is pressed into the land.
    let change = |row: usize| number(&with["results"][row]["ratio"]) - number(&without["results"][row]["ratio"]);
    assert!(-0.2 < change(0) && change(0) < change(1) && change(1) < -5e-3, "{} {}", change(0), change(1));

    // Not even a key of a rim of no height is written.
    for name in ["flat", "without"] {
        place.succeed(&["simulate", &format!("{name}.toml"), "-o", name]);
    }
    let bytes = |name: &str| fs::read(place.path(name).join("result.json")).unwrap();
    assert_eq!(bytes("flat"), bytes("without"));
}

#[test]
fn rims_flatten_where_the_material_yields() {
    let yields = |mpa: &str| {
        scene(RIMS).replace("density_g_cm3 = 0.9", &format!("density_g_cm3 = 0.9\nyield_pressure_mpa = {mpa}"))
    };
    let (soft, hard) = (yields("5.0"), yields("1000"));
    let place = Place::with(&[
        ("soft.toml", &soft),
        ("hard.toml", &hard),
        ("never.toml", &scene(RIMS)),
        ("bad.toml", &yields("-1")),
    ]);
    let [soft, hard, never] =
        ["soft.toml", "hard.toml", "never.toml"].map(|name| place.json(&["simulate", name, "--json"]));
    for row in 0..2 {
        let of = |result: &Value, key: &str| number(&result["results"][row][key]);
        assert_eq!(of(&hard, "ratio"), of(&never, "ratio"));
        let (own, elastic) = (of(&soft, "ratio"), of(&never, "ratio"));
        // At 0.65 MPa nothing bears 5 MPa; at 2.6 MPa what rims and edges no longer carry the land between does.
        assert!(if row == 0 { own == elastic } else { own > elastic + 1e-4 }, "{own} {elastic}");
        assert!(of(&soft, "peak_pressure_mpa") <= 5.0 * (1.0 + 1e-9), "{soft}");
    }
    assert!(
        soft["model"].to_string().contains("flatten for good at 5 MPa, in the order of the loads"),
        "{}",
        soft["model"]
    );
    let refused = place.refuse(&["simulate", "bad.toml"]);
    assert!(refused.contains("material.yield_pressure_mpa") && refused.contains("-1"), "{refused}");
}

#[test]
fn a_design_with_rims_carries_them_and_their_tolerance_into_every_file() {
    let tolerances = "[tolerances]\nwidth_std_um = 2.0\nrim_height_std_um = 0.02\n";
    let rims = "rim_heights_um = [[2.6, 0.07], [20.0, 0.13]]\nrim_width_um = 20.0\nrim_profile = \"ramp\"\n\
                rim_height_std_um = 0.01\n";
    // At one spacing: two lengths are searched in a fraction of the time of three.
    let of = |rims: &str| design(rims, tolerances).replace("[80.0, 300.0]", "[170.0, 170.0]");
    let place = Place::with(&[("d.toml", &of(rims))]);
    let summary = place.succeed(&["optimize", "d.toml", "-o", "out"]);
    for said in [" um high, 20 um wide, scattering by 0.01 um", "not modelled: roughening by the laser"] {
        assert!(summary.contains(said), "{said}: {summary}");
    }
    let read = |name: &str| fs::read_to_string(place.path("out").join(name)).unwrap();
    let found: Value = serde_json::from_str(&read("result.json")).unwrap();
    assert_eq!(found["design"]["rim_heights_um"], serde_json::json!([[2.6, 0.07], [20.0, 0.13]]));
    let limits = found["limited_by"].as_array().unwrap();
    let rim = limits.iter().find(|limit| limit["input"] == "rim height").unwrap();
    assert_eq!(rim["known_to"], "made to 0.02 um");

    // The scene is the design, to the last digit; so is what is exported of the result.
    let scene = ["simulate", "out/scene.toml", "--json", "--fidelity", "steady", "--extent", "cell"];
    let written = &place.json(&scene)["pattern"];
    for key in ["rim_heights_um", "rim_width_um", "rim_profile", "rim_height_std_um", "width_um", "depth_um"] {
        assert_eq!(written[key], found["design"][key], "{key}");
    }
    let process = read("process.toml");
    for said in ["rim_width_um = 20.0", "rim_profile = \"ramp\"", "rim_height_std_um = 0.01", "have to be measured"] {
        assert!(process.contains(said), "{said}: {process}");
    }
    assert!(!process.contains("recast"));
    place.succeed(&["export", "out", "-o", "again"]);
    assert_eq!(place.read("again/process.toml"), process);
    let page = read("report.html");
    assert!(page.contains("rims, as assumed"));

    // Rims of other heights have other answers.
    place.write("d.toml", of(RIMS));
    let message = place.refuse(&["optimize", "d.toml", "-o", "out", "--resume"]);
    assert!(message.contains("rim"), "{message}");
}

/// A scatter of rim heights about zero is accepted. Rims cannot be lower than the land, so that it scatters samples by
/// half as much as elsewhere.
#[test]
fn rims_of_no_height_may_have_some() {
    let half = design(
        "rim_height_um = 0\nrim_width_um = 20.0\n",
        "[tolerances]\nrim_height_std_um = 0.02\nwidth_std_um = 2.0\n",
    );
    let place = Place::with(&[("half.toml", &half)]);
    let told = place.succeed(&["optimize", "half.toml", "-o", "half"]);
    assert!(told.contains("not modelled: recast rims"), "{told}");
    let found = crate::common::result(&place, "half");
    assert!(found["design"].get("rim_width_um").is_none(), "{}", found["design"]);
    let limits = found["limited_by"].as_array().unwrap();
    assert!(limits.iter().any(|limit| limit["input"] == "rim height" && number(&limit["std"][0]) > 0.0), "{limits:?}");
}

#[test]
fn the_rims_of_patterned_samples_are_in_the_modelled_ratio() {
    let squares = "width_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let patterned = THREE_FORCES.replace("0.25,", "0.22,").replace("0.26,", "0.22,");
    let rims = format!("{squares}rim_height_um = 0.1\nrim_width_um = 10.0\n");
    let place = Place::with(&[
        ("flat.csv", THREE_FORCES),
        ("patterned.csv", &patterned),
        ("with.toml", &patterned_calibration(&rims)),
        ("without.toml", &patterned_calibration(squares)),
    ]);
    let [with, without] = ["with", "without"].map(|name| place.log_excess(name));
    // ln(measured / modelled): rims take some of it upon themselves.
    assert!(with > without + 0.005, "{with} {without}");
}
