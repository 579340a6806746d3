//! Commands on good input: exit codes, what they print and what they write.

mod common;

use std::fs;

use common::{CALIBRATION, FLAT, Place, SCENE, names};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The object without what depends on time and threads.
fn timeless(mut value: Value) -> Value {
    if let Value::Object(fields) = &mut value {
        fields.retain(|key, _| !matches!(key.as_str(), "wall_s" | "threads" | "timings_s" | "site_updates_per_s"));
        fields.values_mut().for_each(|field| *field = timeless(field.take()));
    } else if let Value::Array(items) = &mut value {
        items.iter_mut().for_each(|item| *item = timeless(item.take()));
    }
    value
}

#[test]
fn a_steady_scene_as_json() {
    let place = Place::with(&[("scene.toml", SCENE)]);
    let result = json(&place.succeed(&["simulate", "scene.toml", "--json"]));
    assert_eq!(result["fidelity"], "steady");
    assert_eq!(result["extent"], "cell");
    assert!(!result["model"].as_array().unwrap().is_empty());
    assert!(result["wall_s"].as_f64().unwrap() >= 0.0 && result["threads"].as_u64().unwrap() >= 1);
    let loads = result["results"].as_array().unwrap();
    assert_eq!(loads.len(), 2);
    for load in loads {
        assert!(load["mu_static"].is_null() && load["mu_dynamic_stderr"].is_null() && load["steps"].is_null());
        assert_eq!(load["status"], "converged");
        let ratio = load["mu_dynamic"].as_f64().unwrap() / load["mu_flat"].as_f64().unwrap();
        assert!((load["ratio"].as_f64().unwrap() - ratio).abs() < 1e-12);
        for key in ["peak_pressure_mpa", "tension_blocks", "cavity_closed", "area_law_extrapolated"] {
            assert!(!load[key].is_null(), "{key}");
        }
    }
    // Pressures come back as they were written.
    assert_eq!(loads[0]["pressure_mpa"], 0.65);
    // A flat cell slides at mu_d f(P): f(2.6 MPa) = 0.9.
    assert!((loads[1]["mu_flat"].as_f64().unwrap() - 0.27 * 0.9).abs() < 1e-9);
}

#[test]
fn a_flat_scene_has_no_ratio() {
    let from = SCENE.find("[pattern]").unwrap();
    let to = SCENE.find("[sample]").unwrap();
    let flat = format!("{}{}", &SCENE[..from], &SCENE[to..]);
    let place = Place::with(&[("scene.toml", &flat)]);
    let result = json(&place.succeed(&["simulate", "scene.toml", "--json"]));
    assert!(result["pattern"].is_null() && result["areal_density"].is_null());
    for load in result["results"].as_array().unwrap() {
        assert!(load["ratio"].is_null() && load["mu_flat"].is_null());
    }
}

#[test]
fn square_cavities_are_a_section_model() {
    let place = Place::with(&[("scene.toml", &SCENE.replace("\"groove\"", "\"square\"")), ("groove.toml", SCENE)]);
    let square = json(&place.succeed(&["simulate", "scene.toml", "--json"]));
    let groove = json(&place.succeed(&["simulate", "groove.toml", "--json"]));
    assert_eq!(square["section_model"], true);
    assert_eq!(groove["section_model"], false);
    assert_eq!(square["areal_density"], 0.0676);
    assert_eq!(square["section_density"], 0.26);
    let ratio = square["results"][1]["ratio"].as_f64().unwrap();
    assert_eq!(square["results"][1]["ratio"], groove["results"][1]["ratio"]);
    // 1 - (width / pitch)(1 - ratio)
    let strip = square["results"][1]["ratio_strip_estimate"].as_f64().unwrap();
    assert!((strip - (1.0 - 0.26 * (1.0 - ratio))).abs() < 1e-12);
    assert!(groove["results"][1].get("ratio_strip_estimate").is_none());
    assert!(square["model"].to_string().contains("section model"));
}

#[test]
fn threads_change_nothing_but_time() {
    let place = Place::with(&[("scene.toml", SCENE)]);
    let run = |threads: &str| json(&place.succeed(&["simulate", "scene.toml", "--json", "--threads", threads]));
    let (one, three) = (run("1"), run("3"));
    assert_eq!((&one["threads"], &three["threads"]), (&Value::from(1), &Value::from(3)));
    assert_eq!(timeless(one), timeless(three));
}

#[test]
fn results_go_to_a_folder() {
    let place = Place::with(&[("scene.toml", SCENE)]);
    let printed = place.succeed(&["simulate", "scene.toml", "--json", "-o", "out/scene"]);
    let folder = place.path("out/scene");
    assert_eq!(names(&folder), ["interface-0.65mpa.svg", "interface-2.6mpa.svg", "interface.csv", "result.json"]);
    assert_eq!(fs::read_to_string(folder.join("result.json")).unwrap(), printed);
    let interface = fs::read_to_string(folder.join("interface.csv")).unwrap();
    assert_eq!(interface.lines().next().unwrap(), "load_mpa,surface,x_um,pressure_mpa,friction_mpa");
    assert!(interface.lines().any(|line| line.starts_with("2.6,patterned,")));

    // A second run replaces its files and leaves what is not its own.
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    place.succeed(&["simulate", "scene.toml", "-o", "out/scene"]);
    assert_eq!(fs::read_to_string(folder.join("notes.txt")).unwrap(), "mine");
    assert_eq!(names(&place.path("out")), ["scene"]);
}

#[test]
fn a_synthetic_map_and_its_area_law() {
    let place = Place::with(&[]);
    let args = ["synthesize", "--pixels", "64", "--waves", "2:8", "--sa-um", "0.3", "--seed", "7", "-o", "map.asc"];
    let said = place.succeed(&args);
    assert!(said.contains("synthetic") && said.contains("64 x 64 pixels"), "{said}");
    let first = fs::read(place.path("map.asc")).unwrap();
    place.succeed(&args);
    assert_eq!(fs::read(place.path("map.asc")).unwrap(), first);

    let list = [
        "area-law",
        "map.asc",
        "--pressures-mpa",
        "0.3,0.7,1.4",
        "--youngs-modulus-gpa",
        "0.38",
        "--json",
        "-o",
        "law",
    ];
    let law = json(&place.succeed(&list));
    assert_eq!(law["synthetic_surface"], true);
    assert!((law["sa_um"].as_f64().unwrap() - 0.3).abs() < 1e-4);
    assert_eq!(law["pixel_um"], 15.625);
    assert!(law["rms_slope"].as_f64().unwrap() > 0.0);
    let points = law["results"].as_array().unwrap();
    let area = |n: usize| points[n]["area_fraction_corrected"].as_f64().unwrap();
    assert!(area(0) < area(1) && area(1) < area(2));
    assert_eq!((&points[0]["factor"], &points[1]["factor"]), (&Value::from(1.0), &Value::from(1.0)));
    // f(P) = [A(P)/A(P0)] / [P/P0], P = 2 P0
    assert!((points[2]["factor"].as_f64().unwrap() - area(2) / area(1) / 2.0).abs() < 1e-12);
    assert_eq!(names(&place.path("law")), ["area-law.csv", "area-law.svg", "result.json"]);

    // Where no pressure reaches down to 0.7 MPa, the area there is computed beside the list.
    let above = json(&place.succeed(&["area-law", "map.asc", "--pressures-mpa", "1.4", "--json"]));
    assert_eq!(above["results"].as_array().unwrap().len(), 1);
    assert_eq!(above["results"][0]["factor"], points[2]["factor"]);
}

#[test]
fn measured_ratios_are_tabulated() {
    let calibration = CALIBRATION.replace("flat = \"flat.csv\"", "flat = \"flat.csv\"\npatterned = \"patterned.csv\"");
    let place = Place::with(&[
        ("calibration.toml", &calibration),
        ("flat.csv", FLAT),
        ("patterned.csv", &FLAT.replace("0.248,0.002", "0.208,0.007")),
    ]);
    let result = json(&place.succeed(&["validate", "calibration.toml", "--json"]));
    let row = &result["results"][0];
    assert!((row["ratio"].as_f64().unwrap() - 0.208 / 0.248).abs() < 1e-12);
    // 0.8387 sqrt((7/208)^2 + (2/248)^2)
    assert!((row["ratio_std"].as_f64().unwrap() - 0.029_03).abs() < 1e-4);
    assert!((row["pressure_mpa"].as_f64().unwrap() - 0.636_62).abs() < 1e-5);
}

#[test]
fn help_shows_examples_for_every_command() {
    let place = Place::with(&[]);
    let help = place.succeed(&["--help"]);
    for command in ["simulate", "optimize", "calibrate", "area-law", "synthesize", "export", "validate"] {
        assert!(help.contains(command), "{command}");
        let help = place.succeed(&[command, "--help"]);
        assert!(help.contains(&format!("slipgrid {command}")) && help.contains("Examples:"), "{help}");
        assert!(help.contains("--threads") && help.contains("--quiet"), "{help}");
    }
    assert_eq!(place.run(&["--version"]).stdout, format!("slipgrid {}\n", env!("CARGO_PKG_VERSION")).as_bytes());
}
