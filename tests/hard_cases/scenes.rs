//! Runs `slipgrid simulate` on every file of `scenes/`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use serde_json::Value;
use slipgrid_tests::{repository, slipgrid};

/// Statuses for which mu may be absent.
const WITHOUT_MU: [&str; 6] = ["no_load", "no_onset", "too_many_steps", "diverged", "not_converged", "cancelled"];

fn files() -> Vec<PathBuf> {
    let folder = repository().join("tests/hard_cases/scenes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Table in the lines that begin with `#=`.
fn expectations(text: &str) -> toml::Table {
    let lines: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("#=")).collect();
    lines.join("\n").parse().unwrap()
}

/// Whether `found` satisfies `expected`.
fn agrees(expected: &toml::Value, found: &Value) -> bool {
    match expected {
        toml::Value::String(name) if name == "null" => found.is_null(),
        toml::Value::String(name) => found == name.as_str(),
        toml::Value::Boolean(truth) => found == truth,
        toml::Value::Integer(count) => found.as_i64() == Some(*count),
        toml::Value::Array(choices) => match choices.as_slice() {
            [least, most] if !least.is_str() => {
                let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
                found.as_f64().is_some_and(|found| {
                    number(least).is_some_and(|least| least <= found) && number(most).is_some_and(|most| found <= most)
                })
            }
            choices => choices.iter().any(|choice| agrees(choice, found)),
        },
        _ => false,
    }
}

/// Differences of the outcome for `file` from the expected one.
fn complaints(file: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(file).unwrap();
    let expected = expectations(&text);
    assert!(text.starts_with("# ") && !expected.is_empty(), "{} says nothing of what is expected", file.display());
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let output = folder.path().join("out");
    let arguments = ["--quiet", "simulate", file.to_str().unwrap(), "--json", "-o", output.to_str().unwrap()];
    let (code, out, err) = slipgrid(&arguments);
    let wall_s = started.elapsed().as_secs_f64();

    let mut wrong = Vec::new();
    let exit = expected.get("exit").and_then(toml::Value::as_integer).unwrap_or(0);
    if i64::from(code) != exit {
        wrong.push(format!("exit code {code}: {err}"));
        return wrong;
    }
    if exit != 0 {
        let says = expected["says"].as_str().unwrap();
        if !err.contains(says) || !out.is_empty() || output.exists() {
            wrong.push(format!("expected a refusal with \"{says}\" and nothing written: {err}"));
        }
        return wrong;
    }
    for written in ["interface.csv", "friction.csv"] {
        let text = std::fs::read_to_string(output.join(written)).unwrap_or_default().to_lowercase();
        if text.contains("nan") || text.contains("inf") {
            wrong.push(format!("{written} holds numbers that are none"));
        }
    }
    let json: Value = serde_json::from_str(&out).unwrap();
    for load in json["results"].as_array().unwrap() {
        let status = load["status"].as_str().unwrap();
        for (key, expected) in expected.iter().filter(|(key, _)| !["exit", "says", "model"].contains(&key.as_str())) {
            if load.get(key).is_none_or(|found| !agrees(expected, found)) {
                wrong.push(format!(
                    "{} MPa: {key} is {} ({status}), expected {expected}",
                    load["pressure_mpa"], load[key]
                ));
            }
        }
        if load["mu_dynamic"].is_null() && !WITHOUT_MU.contains(&status) {
            wrong.push(format!("{} MPa: no mu, but status {status}", load["pressure_mpa"]));
        }
        if status == "not_converged" && !(load["mu_dynamic"].is_null() && load["ratio"].is_null()) {
            wrong.push(format!("{} MPa: friction of what did not converge", load["pressure_mpa"]));
        }
    }
    if let Some(part) = expected.get("model").and_then(toml::Value::as_str)
        && !json["model"].as_array().unwrap().iter().any(|statement| statement.as_str().unwrap().contains(part))
    {
        wrong.push(format!("the model does not say \"{part}\": {}", json["model"]));
    }
    let first = &json["results"][0];
    println!(
        "{wall_s:7.3} s {}: {} mu {} ratio {} tension {}",
        file.file_stem().unwrap().to_str().unwrap(),
        first["status"],
        first["mu_dynamic"],
        first["ratio"],
        first["tension_blocks"],
    );
    wrong
}

#[test]
fn every_scene_behaves_as_its_first_lines_say() {
    let wrong = |file: PathBuf| -> String {
        let name = file.file_stem().unwrap().to_str().unwrap();
        complaints(&file).into_iter().map(|complaint| format!("{name}: {complaint}\n")).collect()
    };
    let wrong: String = files().into_par_iter().map(wrong).collect();
    assert!(wrong.is_empty(), "\n{wrong}");
}
