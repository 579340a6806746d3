//! Runs whole commands on shipped files: a second material is calibrated from raw traces, which recovers the parameters
//! of the synthetic data, and a scene does as its first lines say.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use slipgrid_tests::repository;

/// Parameters of calibration/synthetic-polymer/make_traces.py.
const DYNAMIC_MEAN: f64 = 0.18;
const SCALE_PA: f64 = 12e6;
const DISCREPANCY: f64 = 0.95;
/// Tolerance of relative friction: the script assumes an excess of dynamic over steady friction of 1.5 %, and the model
/// computes it; the two may differ by one percent.
const EXCESS: f64 = 0.01;

fn folder() -> PathBuf {
    repository().join("calibration/synthetic-polymer")
}

fn slipgrid(arguments: &[&str]) -> (u8, String, String) {
    slipgrid_tests::slipgrid(&[&["--quiet"], arguments].concat())
}

#[test]
fn a_synthetic_material_is_calibrated_from_raw_traces_in_one_command() {
    let place = tempfile::tempdir().unwrap();
    let (material, report) = (place.path().join("m.toml"), place.path().join("report"));
    let calibration = folder().join("calibration.toml");
    let arguments = [
        "calibrate",
        calibration.to_str().unwrap(),
        "-o",
        material.to_str().unwrap(),
        "--report",
        report.to_str().unwrap(),
    ];
    let (code, out, err) = slipgrid(&arguments);
    println!("{out}");
    assert_eq!((code, err.as_str()), (0, ""));
    let fit: Value = serde_json::from_str(&fs::read_to_string(report.join("fit.json")).unwrap()).unwrap();
    let parameter = |name: &str| {
        let all = fit["parameters"].as_array().unwrap();
        all.iter().find(|parameter| parameter["name"] == name).unwrap().clone()
    };
    let number = |value: &Value| value.as_f64().unwrap();
    let mean = parameter("dynamic_mean");
    let error = number(&mean["std_error"]);
    assert!((number(&mean["value"]) - DYNAMIC_MEAN).abs() < 3.0 * error + EXCESS * DYNAMIC_MEAN, "{mean}");
    let scale = parameter("area_law_scale_pa");
    assert!((number(&scale["value"]) - SCALE_PA).abs() < 3.0 * number(&scale["std_error"]), "{scale}");
    assert!(number(&scale["std_error"]) < 0.1 * SCALE_PA && fit["degrees_of_freedom"] == 2);

    for name in ["flat.csv", "patterned.csv", "traces.csv", "flat-300N-5mm_s-50pct.svg", "residuals.svg"] {
        assert!(report.join(name).is_file(), "{name}");
    }
    // Measured ratios over modelled ones: what the samples lack beyond the model.
    let written: toml::Table = fs::read_to_string(&material).unwrap().parse().unwrap();
    let trial = &written["learned"]["trial"][0];
    let column = |key: &str| trial[key].as_array().unwrap().iter().map(|ratio| ratio.as_float().unwrap());
    let logs: Vec<f64> =
        column("measured_ratio").zip(column("modelled_ratio")).map(|(own, modelled)| (own / modelled).ln()).collect();
    let found = logs.iter().sum::<f64>() / logs.len() as f64;
    assert!((found - DISCREPANCY.ln()).abs() < 0.02, "{found}");
    assert_eq!(written["area_law"]["origin"].as_str(), Some("fit"));

    // The design beside it counts that: what is expected of a sample is below what the model says.
    let design = fs::read_to_string(folder().join("design.toml")).unwrap();
    assert!(design.contains("material = \"calibration.toml\""));
    fs::write(place.path().join("d.toml"), design.replace("\"calibration.toml\"", "\"m.toml\"")).unwrap();
    let design = place.path().join("d.toml");
    let (code, out, err) = slipgrid(&["next", design.to_str().unwrap(), "--json"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let result: Value = serde_json::from_str(&out).unwrap();
    let sample = &result["samples"][0];
    assert!(result["trials"] == 1 && number(&sample["chance"]) > 0.1, "{out}");
    for (at, modelled) in sample["expected"].as_array().unwrap().iter().zip(sample["modelled"].as_array().unwrap()) {
        let factor = number(&at["median"]) / number(&modelled["ratio"]);
        assert!((0.9..0.99).contains(&factor), "{at} {modelled}");
    }

    // The material is one that scenes take.
    let scene = place.path().join("scene.toml");
    let text = "material = \"m.toml\"\n[pattern]\nwidth_um = 100.0\nspacing_um = 300.0\ndepth_um = 20.0\n\
        [sample]\nlength_um = 1000.0\nlayer_um = 200.0\nblock_um = 10.0\n[load]\npressure_mpa = 2.8\nspeed_mm_s = 5.0\n";
    fs::write(&scene, text).unwrap();
    let (code, _, err) = slipgrid(&["simulate", scene.to_str().unwrap(), "--json"]);
    assert_eq!((code, err.as_str()), (0, ""));
}

#[test]
fn exports_of_one_condition_need_no_calibration_file_and_bad_ones_are_refused() {
    let file = |name: &str| folder().join("traces").join(name).to_str().unwrap().to_owned();
    let place = tempfile::tempdir().unwrap();
    let condition = ["--effective-radius-mm", "25", "--specimens", "3", "--force-n", "300", "--speed-mm-s", "5"];
    let run = |files: &[String], more: &[&str]| {
        let mut arguments = vec!["traces"];
        arguments.extend(files.iter().map(String::as_str));
        arguments.extend(condition);
        arguments.extend(["--humidity-pct", "50", "--window-s", "8,28"]);
        arguments.extend(more);
        slipgrid(&arguments)
    };
    let files = [1, 2, 3].map(|repeat| file(&format!("flat-300N-{repeat}.csv")));
    let out = place.path().join("out");
    let (code, told, err) = run(&files, &["-o", out.to_str().unwrap()]);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(told.contains("mean of 3"), "{told}");
    let table = fs::read_to_string(out.join("flat.csv")).unwrap();
    let row: Vec<f64> = table.lines().last().unwrap().split(',').filter_map(|cell| cell.parse().ok()).collect();
    // 1.015 mu_d f(10.6 MPa), f = 0.6558 by Persson's area.
    assert!((row[3] - 1.015 * DYNAMIC_MEAN * 0.6558).abs() < 4.0 * row[4], "{table}");

    // A torque sensor at the end of its range, and a clock that goes back.
    let good = fs::read_to_string(&files[0]).unwrap();
    let clipped: String = good
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(';').map(str::to_owned).collect();
            if cells.len() > 1 && cells[1].replace(',', ".").parse::<f64>().is_ok_and(|torque| torque > 2700.0) {
                cells[1] = "2700,0".to_owned();
            }
            cells.join(";") + "\n"
        })
        .collect();
    for (text, reason) in
        [(clipped, "the torque stands at 2.7"), (good.replace("\n20,0;", "\n2,0;"), "the clock goes back")]
    {
        let bad = place.path().join("bad.csv");
        fs::write(&bad, text).unwrap();
        let (code, _, err) = run(&[files[1].clone(), bad.to_str().unwrap().to_owned()], &[]);
        assert!(code == 2 && err.contains("bad.csv") && err.contains(reason), "{code} {err}");
    }
}

#[test]
fn the_shipped_scene_with_rims_slides_with_less_friction_than_it_says_it_would_without() {
    let ratio = |text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene.toml");
        fs::write(&scene, text).unwrap();
        let (code, out, err) = slipgrid(&["simulate", scene.to_str().unwrap(), "--json"]);
        assert_eq!((code, err.as_str()), (0, ""));
        serde_json::from_str::<Value>(&out).unwrap()["results"][0]["ratio"].as_f64().unwrap()
    };
    let text = fs::read_to_string(repository().join("designs/scene-rims.toml")).unwrap();
    let without: String =
        text.lines().filter(|line| !line.starts_with("rim_")).map(|line| format!("{line}\n")).collect();
    let change = ratio(&without) - ratio(&text);
    assert!((change - 0.0327).abs() < 5e-4, "{change}");
}
