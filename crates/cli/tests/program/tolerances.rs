//! `optimize` with tolerances, trade-offs and a robust search: what stands in its files.

use std::fs;

use crate::common::{DESIGN, Place, result};
use serde_json::Value;

/// A short sample and one pressure; standard errors as a calibration writes them.
fn design(more: &str) -> String {
    let text = DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 4.0")
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("value = 0.9", "value = 0.88")
        .replace("tolerance = 0.01", "tolerance = 0.02")
        .replace("max_evaluations = 50", "max_evaluations = 2000")
        .replace("density_g_cm3 = 0.9\n", "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.038\n")
        .replace("dynamic_mean = 0.27\n", "dynamic_mean = 0.27\ndynamic_std_error = 0.0027\n")
        .replace("spot_um = 23.0\n", "spot_um = 23.0\nrepetition_hz = 20000.0\nspeed_mm_s = 200.0\n");
    format!("{text}{more}")
}

const TOLERANCES: &str = "[tolerances]\nwidth_std_um = 8.0\nspacing_std_um = 13.0\ndepth_std_um = 1.3\ndraws = 100\n";

#[test]
fn samples_trade_offs_and_the_robust_choice_are_reported() {
    let trade_offs = "[trade_offs]\ngoals = [\"misfit\", \"laser_time\", \"spread\"]\ndesigns = 30\n";
    let text = design(&format!("robust = true\n{TOLERANCES}{trade_offs}"));
    let place = Place::with(&[("robust.toml", &text)]);
    let output = place.run(&["optimize", "robust.toml", "--threads", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let summary = String::from_utf8(output.stdout).unwrap();
    for said in ["1e-4 where one dimension grows by 1 um", "100 draws", "trade-offs: of", "chosen for its samples"] {
        assert!(summary.contains(said), "{said}: {summary}");
    }

    let found = result(&place, "out/robust");
    let slopes = &found["sensitivities"]["by_pressure"][0];
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(number(&slopes["per_um"]["width"]) < 0.0 && number(&slopes["per_um"]["spacing"]) > 0.0);
    let robustness = &found["robustness"];
    let samples = &robustness["samples"];
    let at = &samples["by_pressure"][0];
    let (mean, std) = (number(&at["ratio"]["mean"]), number(&at["ratio"]["std"]));
    let confirmed = number(&found["confirmed"][0]["ratio"]);
    assert!((mean - confirmed).abs() < 0.5 * std, "{mean} {confirmed} {std}");
    // To first order the dimensions' parts are the scatter of samples.
    let parts = robustness["parts"][0]["of"].as_array().unwrap();
    let of = |names: &[&str]| {
        let squares = parts.iter().filter(|part| names.contains(&part["input"].as_str().unwrap()));
        squares.map(|part| number(&part["std"]).powi(2)).sum::<f64>().sqrt()
    };
    let made = of(&["width", "spacing", "depth"]);
    assert!((std / made - 1.0).abs() < 0.15, "{std} {made}");
    // The flat sample's friction is known to 1 %, which friction takes over and the ratio hardly.
    let all = &robustness["with_material"]["by_pressure"][0];
    let (mu, flat) = (&all["mu"], number(&found["confirmed"][0]["mu_flat"]));
    let expected = (number(&all["ratio"]["std"]) * flat).hypot(0.01 * number(&mu["mean"]));
    assert!((number(&mu["std"]) / expected - 1.0).abs() < 0.15, "{mu} {expected}");
    assert!(of(&["Young's modulus"]) > of(&["flat friction"]));
    assert!(number(&robustness["with_material"]["probability"]) <= number(&samples["probability"]) + 0.02);
    assert!(number(&robustness["optimum"]["expected_rms"]) <= number(&robustness["optimum"]["nominal_expected_rms"]));
    // The best as designed has samples with its own cavities: more than half of them within the tolerance, as their misfit says.
    let nominal = number(&robustness["optimum"]["nominal_probability"]);
    assert!(number(&robustness["optimum"]["nominal_expected_rms"]) < 0.8);
    assert!(nominal > 0.5 && nominal <= number(&samples["probability"]), "{nominal}");

    let trade_offs = &found["trade_offs"];
    assert_eq!(trade_offs["goals"][1], "laser_time_s");
    assert!((number(&trade_offs["chosen"][0]) - number(&found["misfit"]["predicted"])).abs() < 1e-6);
    let folder = place.path("out/robust");
    let table = fs::read_to_string(folder.join("trade-offs.csv")).unwrap();
    let columns =
        "width_um,spacing_um,depth_um,areal_density,misfit_tolerances,laser_time_s,spread_tolerances,on_front,chosen";
    assert_eq!(table.lines().next().unwrap(), columns);
    assert_eq!(
        table.lines().filter(|line| line.ends_with(",1,0") || line.ends_with(",1,1")).count(),
        number(&trade_offs["front"]) as usize
    );
    assert_eq!(table.lines().skip(1).filter(|line| line.ends_with(",1")).count(), 1, "one is chosen");
    let sheet = fs::read_to_string(folder.join("process.toml")).unwrap();
    let time: toml::Table = sheet.parse().unwrap();
    let time_s = time["work"]["estimated_time_s"].as_float().unwrap();
    assert!((number(&trade_offs["chosen"][1]) / time_s - 1.0).abs() < 1e-6);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    for heading in ["What samples will do", "What a micrometre changes", "Trade-offs"] {
        assert!(page.contains(heading), "{heading}");
    }

    // The same on two threads.
    assert_eq!(place.run(&["optimize", "robust.toml", "--threads", "2", "-o", "again"]).status.code(), Some(0));
    for name in ["trade-offs.csv", "trade-offs.svg"] {
        let again = fs::read(place.path("again").join(name)).unwrap();
        assert!(fs::read(folder.join(name)).unwrap() == again, "{name}");
    }
    assert_eq!(result(&place, "again")["robustness"], *robustness);
}

/// All samples are deeper or shallower by what the depth per burst is off by.
#[test]
fn samples_with_the_material_count_a_fitted_depth_per_burst() {
    let fitted = "spot_um = 23.0\nfluence_j_cm2 = 10.0\n[laser.ablation]\nfluence_j_cm2 = [2.0, 5.0, 10.0, 20.0]\n\
                  depth_per_burst_um = [0.6, 1.9, 2.4, 3.6]\n";
    let text = crate::common::small().replace("depth_per_burst_um = 2.6\n", "").replace("spot_um = 23.0\n", fitted);
    let tolerances = "[tolerances]\nwidth_std_um = 1.0\ndepth_std_um = 0.5\ndraws = 100\n";
    let place = Place::with(&[("fitted.toml", &format!("{text}{tolerances}"))]);
    place.run(&["optimize", "fitted.toml", "-o", "out", "--no-explorer"]);
    let found = result(&place, "out");
    let number = |value: &Value| value.as_f64().unwrap();
    let of = |list: &Value, key: &str, name: &str, what: &str| {
        let row = list.as_array().unwrap().iter().find(|row| row[key] == name).unwrap_or_else(|| panic!("{list}"));
        if row[what].is_array() { number(&row[what][0]) } else { number(&row[what]) }
    };
    let robustness = &found["robustness"];
    let std = |name: &str| of(&robustness["parts"][0]["of"], "input", name, "std");
    let percent = of(&robustness["inputs"], "name", "depth per burst", "std");
    // dr / d ln(depth) = depth dr / d depth
    let expected = std("depth") * 0.01 * percent * number(&found["design"]["depth_um"]) / 0.5;
    assert!(percent > 1.0 && (std("depth per burst") / expected - 1.0).abs() < 0.1, "{robustness}");
    // Nothing else is known of this material: it alone is drawn beside the dimensions.
    let [all, samples] = ["with_material", "samples"].map(|which| &robustness[which]["by_pressure"]);
    assert!(all.is_array() && all != samples, "{robustness}");
}

#[test]
fn what_samples_need_and_do_not_have_is_refused_by_key() {
    for (more, says) in [
        ("robust = true\n", "search.robust"),
        ("[tolerances]\nwidth_std_um = -1.0\n", "tolerances.width_std_um"),
        ("[tolerances]\nwidth_std_um = 3000.0\n", "tolerances.width_std_um: 3000.0 is more than the largest width"),
        (
            "[tolerances]\ndepth_std_um = 3000.0\n",
            "sample in six would be drawn with no depth at all; expected at most",
        ),
        ("[tolerances]\nwidth_spacing_correlation = 2.0\n", "tolerances.width_spacing_correlation"),
        ("[tolerances]\ndraws = 3\n", "tolerances.draws"),
        ("[trade_offs]\ngoals = [\"misfit\", \"spread\"]\n", "[tolerances]"),
        ("[trade_offs]\ngoals = [\"misfit\"]\n", "trade_offs.goals"),
    ] {
        let place = Place::with(&[("refused.toml", &design(more))]);
        let message = place.refuse(&["optimize", "refused.toml"]);
        assert!(message.contains(says), "{message}");
    }
    let without_laser =
        design("[trade_offs]\ngoals = [\"misfit\", \"laser_time\"]\n").replace("repetition_hz = 20000.0\n", "");
    let place = Place::with(&[("refused.toml", &without_laser)]);
    let message = place.refuse(&["optimize", "refused.toml"]);
    assert!(message.contains("laser.repetition_hz"), "{message}");
}
