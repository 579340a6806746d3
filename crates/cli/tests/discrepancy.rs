//! Designs that aim with the discrepancy of patterned samples, and one error beside every value.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod common;

use std::fs;

use common::{CALIBRATION, DESIGN, Place};
use serde_json::Value;

/// A short sample and one pressure.
fn design(target: &str, material: &str) -> String {
    DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("value = 0.9\ntolerance = 0.01", target)
        .replace("[40.0, 400.0]", "[40.0, 100.0]")
        .replace("[40.0, 1000.0]", "[40.0, 200.0]")
        .replace("max_evaluations = 50", "max_evaluations = 600")
        .replace("[target]", &format!("{material}[target]"))
}

/// Samples whose ratios are half the modelled ones: ln 2 below.
const HALF: &str = "[material.discrepancy]\npattern = \"groove 100 um wide\"\n[material.discrepancy.all]\n\
    coefficients = [-0.6931471805599453]\ncovariance = [[1e-4]]\nreference_pressure_mpa = 1.5\nscatter = 0.02\n\
    modulus_sensitivity = [0.1]\nmodulus_relative_std = 0.1\npressure_range_mpa = [0.6, 2.5]\nchi_square = 20.0\n\
    degrees_of_freedom = 10000\n";

/// Samples of which all patterns within the bounds are near.
const ALL: &str = "[[material.discrepancy.trials]]\nplanform = \"groove\"\nareal_density = 0.2\ndepth_um = 4.0\n\
    [[material.discrepancy.trials]]\nplanform = \"groove\"\nareal_density = 0.6\ndepth_um = 30.0\n";

const ERRORS: [(&str, &str); 2] = [
    ("density_g_cm3 = 0.9\n", "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.038\n"),
    ("dynamic_mean = 0.27\n", "dynamic_mean = 0.27\ndynamic_std_error = 0.0027\n"),
];

fn result(place: &Place, folder: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(place.path(folder).join("result.json")).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn part(value: &Value, input: &str) -> f64 {
    let parts = value["parts"].as_array().unwrap();
    parts.iter().find(|part| part["input"] == input).map_or(0.0, |part| number(&part["std"]))
}

#[test]
fn aiming_at_half_is_aiming_at_the_whole_without_the_factor() {
    // The chance counts the discrepancy's error only where it is aimed with: here samples alone decide.
    let by_samples = "robust = true\n[tolerances]\nwidth_std_um = 1.0\n";
    let known = |text: String| ERRORS.iter().fold(text, |text, (from, to)| text.replace(from, to)) + by_samples;
    let half = format!("{HALF}{ALL}");
    let aimed = known(design("value = 0.44\ntolerance = 0.01\ndiscrepancy = true", &half));
    let plain = known(design("value = 0.88\ntolerance = 0.02", &half));
    let place = Place::with(&[("plain.toml", &plain), ("aimed.toml", &aimed)]);
    let told = place.succeed(&["optimize", "plain.toml", "-o", "out/one"]);
    assert!(told.contains("physics alone; times the discrepancy") && told.contains("(0.500)"), "{told}");
    let plain = result(&place, "out/one");
    // The study holds answers of the physics: the other design takes them over, and corrections go along.
    let resumed = place.run(&["optimize", "aimed.toml", "-o", "out/one", "--resume"]);
    let said = String::from_utf8_lossy(&resumed.stderr).into_owned();
    assert!(resumed.status.success() && said.contains("took over"), "{said}");
    let told = String::from_utf8(resumed.stdout).unwrap();
    assert!(told.contains("aimed with the discrepancy of patterned samples"), "{told}");
    assert!(told.contains("2.6 MPa lies outside the pressures measured"), "{told}");
    let aimed = result(&place, "out/one");
    assert_eq!(aimed["design"], plain["design"]);
    assert_eq!(
        aimed["confirmed"][0]["ratio"], plain["confirmed"][0]["ratio"],
        "reported runs are those of the physics"
    );
    assert_eq!((&aimed["misfit"], &aimed["rounds"]), (&plain["misfit"], &plain["rounds"]));
    assert_eq!(number(&aimed["predicted_value"][0]), 0.5 * number(&plain["predicted_value"][0]));

    // Both readings stand in both results, the misfit of the other one too.
    let (with, without) = (&aimed["discrepancy"], &plain["discrepancy"]);
    assert_eq!((&with["used"], &without["used"]), (&Value::from(true), &Value::from(false)));
    for key in ["predicted", "confirmed", "mu"] {
        let (with, without) = (&with["by_pressure"][0][key], &without["by_pressure"][0][key]);
        assert_eq!(with, without, "{key}");
        assert!((number(&with["with_discrepancy"]) / number(&with["physics"]) - 0.5).abs() < 1e-9, "{with}");
    }
    let same = |left: &Value, right: &Value| (number(left) - number(right)).abs() < 1e-6;
    assert!(same(&with["misfit"]["with_discrepancy"], &aimed["misfit"]["confirmed"]));
    assert!(same(&without["misfit"]["physics"], &plain["misfit"]["confirmed"]));
    assert!(number(&without["misfit"]["with_discrepancy"]) > 10.0);
    assert_eq!(with["by_pressure"][0]["outside_measured_range"], true);

    // One error beside each value; its parts are independent of one another.
    for found in [&aimed, &plain] {
        let at = &found["errors"]["by_pressure"][0];
        for key in ["predicted", "ratio", "mu"] {
            let parts = at[key]["parts"].as_array().unwrap();
            let sum = parts.iter().map(|part| number(&part["std"]).powi(2)).sum::<f64>().sqrt();
            assert!((number(&at[key]["std"]) / sum - 1.0).abs() < 0.02, "{key}: {}", at[key]);
        }
        let (ratio, mu) = (&at["ratio"], &at["mu"]);
        // Flat friction is known to 1 %: friction takes that over, the ratio hardly.
        assert!((part(mu, "flat friction") / number(&mu["value"]) - 0.01).abs() < 1e-3, "{mu}");
        assert!(part(ratio, "flat friction") < 0.003 * number(&ratio["value"]), "{ratio}");
        assert!(part(ratio, "Young's modulus") > 0.0 && part(ratio, "time average") > 0.0, "{ratio}");
        assert_eq!(part(&at["predicted"], "time average"), 0.0);
        assert_eq!(found["errors"]["unknown"], serde_json::json!(["area law"]));
    }
    let of = |found: &Value| found["errors"]["by_pressure"][0]["ratio"].clone();
    let (with, without) = (of(&aimed), of(&plain));
    // Fit 1 % and scatter 2 % of the corrected ratio, nothing of it in the physics alone.
    let expected = (1e-4_f64 + 4e-4).sqrt() * number(&with["value"]);
    assert!((part(&with, "discrepancy") / expected - 1.0).abs() < 1e-3, "{with} {expected}");
    assert_eq!(part(&without, "discrepancy"), 0.0);
    // The fit of the discrepancy takes up a tenth of dE/E.
    let [left, right] = [&with, &without].map(|of| part(of, "Young's modulus") / number(&of["value"]));
    // Its sign at this design is not known here.
    let off = |share: f64| (share.abs() - 0.1 * 0.1).abs() < 1e-3;
    assert!(off(left - right) || off(left + right), "{left} {right}");
    assert!((part(&with, "time average") / part(&without, "time average") - 0.5).abs() < 1e-6);
    let page = fs::read_to_string(place.path("out/one/report.html")).unwrap();
    assert!(
        page.contains("The search aimed with the discrepancy") && page.contains("What the error of a confirmed value")
    );
    let svg = fs::read_to_string(place.path("out/one/target.svg")).unwrap();
    assert!(svg.contains("confirmed ± one standard deviation"));
}

#[test]
fn a_material_without_errors_shows_those_of_the_run_alone_and_says_so() {
    let place = Place::with(&[("a.toml", &design("value = 0.88\ntolerance = 0.02", ""))]);
    let told = place.succeed(&["optimize", "a.toml"]);
    assert!(
        told.contains("+-: one standard deviation of time average, local coefficients drawn, layout on the specimen, size of blocks;"),
        "{told}"
    );
    assert!(told.contains("not known of this material: flat friction, Young's modulus, area law"), "{told}");
    let found = result(&place, "out/a");
    let at = &found["errors"]["by_pressure"][0];
    assert_eq!((&at["predicted"]["std"], &found["discrepancy"]), (&Value::Null, &Value::Null));
    let own = number(&found["confirmed"][0]["ratio_stderr"]).hypot(part(&at["ratio"], "local coefficients drawn"));
    let own = own.hypot(part(&at["ratio"], "layout on the specimen")).hypot(part(&at["ratio"], "size of blocks"));
    assert!(
        (2.0 * part(&at["ratio"], "size of blocks") / number(&found["confirmed"][0]["ratio_discretization_error"])
            - 1.0)
            .abs()
            < 1e-6
    );
    assert!((number(&at["ratio"]["std"]) / own - 1.0).abs() < 1e-6, "{at}");
    // 5 % over the blocks in contact and of about equal friction; the ratio shares most of it with the flat sample.
    let mu = &at["mu"];
    let interface = fs::read_to_string(place.path("out/a/interface.csv")).unwrap();
    let land = interface.lines().filter(|line| line.contains(",patterned,")).count() as f64;
    let expected = 0.05 * number(&mu["value"]) / land.sqrt();
    let drawn = part(mu, "local coefficients drawn");
    assert!(drawn >= 0.98 * expected && drawn < 1.3 * expected, "{drawn} {expected}");
    let of_ratio = part(&at["ratio"], "local coefficients drawn") / number(&at["ratio"]["value"]);
    assert!(of_ratio < drawn / number(&mu["value"]), "{of_ratio}");
}

#[test]
fn a_simulated_design_has_the_errors_it_was_found_with() {
    let known = |text: String| ERRORS.iter().fold(text, |text, (from, to)| text.replace(from, to));
    let place = Place::with(&[("a.toml", &known(design("value = 0.88\ntolerance = 0.02", HALF)))]);
    place.succeed(&["optimize", "a.toml"]);
    let (found, scene) = (result(&place, "out/a"), "out/a/design.toml");
    let simulate = |more: &[&str]| -> Value {
        let arguments: Vec<&str> = ["simulate", scene, "--json"].into_iter().chain(more.iter().copied()).collect();
        serde_json::from_str(&place.succeed(&arguments)).unwrap()
    };
    let again = simulate(&[]);
    let (designed, simulated) = (&found["errors"]["by_pressure"][0], &again["errors"]["by_pressure"][0]);
    for key in ["ratio", "mu", "mu_flat"] {
        assert_eq!(designed[key]["value"], simulated[key]["value"], "{key}");
        let share = number(&designed[key]["std"]) / number(&simulated[key]["std"]);
        assert!((share - 1.0).abs() < 1e-6, "{key}: {} {}", designed[key], simulated[key]);
    }
    assert_eq!((&found["errors"]["includes"], &found["errors"]["unknown"]), {
        let errors = &again["errors"];
        (&errors["includes"], &errors["unknown"])
    });
    let corrected = &again["discrepancy"]["by_pressure"][0];
    assert!((number(&corrected["factor"]) - 0.5).abs() < 1e-9);
    assert!((number(&corrected["ratio"]["value"]) / number(&simulated["ratio"]["value"]) - 0.5).abs() < 1e-9);
    assert!(part(&corrected["ratio"], "discrepancy") > 0.0 && part(&simulated["ratio"], "discrepancy") == 0.0);

    // A periodic cell at the mean coefficients has neither time nor draws in it.
    let steady = simulate(&["--fidelity", "steady", "--extent", "cell"]);
    assert_eq!(steady["errors"]["includes"], serde_json::json!(["size of blocks", "flat friction", "Young's modulus"]));
    let told = place.succeed(&["simulate", scene, "--fidelity", "steady", "--extent", "cell"]);
    assert!(told.contains("mu_dynamic      +-  mu_flat      +-   ratio      +-"), "{told}");
    assert!(told.contains("were the model as far off as on patterned samples"), "{told}");

    // On a flat surface flat friction is all there is, and of a static peak its coefficient and its draw.
    let text = fs::read_to_string(place.path(scene)).unwrap();
    let flat = text
        .replace("warm_start = true\n", "")
        .replace("mu_stderr = 0.001\n", "")
        .replace("sliding_um = 0.4", "sliding_um = 2.0");
    let (from, to) = (flat.find("[pattern]").unwrap(), flat.find("[sample]").unwrap());
    let with_static = flat.replace("dynamic_std_error", "static_std_error = 0.003\ndynamic_std_error");
    fs::write(place.path("flat.toml"), format!("{}{}", &flat[..from], &flat[to..])).unwrap();
    let (from, to) = (with_static.find("[pattern]").unwrap(), with_static.find("[sample]").unwrap());
    fs::write(place.path("static.toml"), format!("{}{}", &with_static[..from], &with_static[to..])).unwrap();
    let of = |scene: &str| -> Value { serde_json::from_str(&place.succeed(&["simulate", scene, "--json"])).unwrap() };
    let [open, known] = ["flat.toml", "static.toml"].map(of);
    let at = &known["errors"]["by_pressure"][0];
    assert!((part(&at["mu"], "flat friction") / number(&at["mu"]["value"]) - 0.01).abs() < 1e-6, "{at}");
    assert!(at.get("ratio").is_none() && at.get("mu_flat").is_none() && known["discrepancy"].is_null());
    let peak = &at["mu_static"];
    assert!((part(peak, "static coefficient") / number(&peak["value"]) - 0.01).abs() < 1e-6, "{peak}");
    assert!(part(peak, "local coefficients drawn") > 0.0);
    assert_eq!(known["errors"]["unknown"], serde_json::json!([]));
    assert_eq!(open["errors"]["unknown"], serde_json::json!(["static coefficient"]));
}

/// The published factor on patterned samples, with what the samples were.
fn published(planform: &str) -> String {
    let trial =
        format!("[[material.discrepancy.trials]]\nplanform = \"{planform}\"\nareal_density = 0.0676\ndepth_um = 5.2\n");
    HALF.replace("-0.6931471805599453", &0.829_f64.ln().to_string()).replace("\"groove", &format!("\"{planform}"))
        + &trial
}

#[test]
fn the_discrepancy_is_used_near_its_trials_alone_and_never_in_place_of_a_pattern() {
    let asked = |value: f64, planform: &str| {
        design(&format!("value = {value}\ntolerance = 0.01\ndiscrepancy = true"), &published(planform))
            .replace("[40.0, 200.0]", "[100.0, 1000.0]")
    };
    let place = Place::with(&[
        ("factor.toml", &asked(0.83, "groove").replace("0.0676", "0.0014")),
        ("near.toml", &asked(0.80, "groove")),
        ("low.toml", &asked(0.70, "groove")),
        ("squares.toml", &asked(0.80, "square")),
    ]);
    // What is asked for is about the factor itself: by the physics alone almost no pattern would do, and the flat surface has 1.
    let run = place.run(&["optimize", "factor.toml"]);
    let told = String::from_utf8(run.stdout).unwrap();
    assert_eq!(run.status.code(), Some(3), "{told}");
    let found = result(&place, "out/factor");
    assert_eq!(found["status"], "unreachable");
    assert!(told.contains("areal density of 0.0933 to 0.21 % (the trials: 0.14 %)"), "{told}");
    assert!(told.contains("a depth of 2.6 to 10.4 um (the trials: 5.2 um)"), "{told}");
    assert!(told.contains("by more than the tolerance at some pressure"), "{told}");
    // Looked for near the trials, not found far from them and refused.
    place.succeed(&["optimize", "near.toml"]);
    let found = result(&place, "out/near");
    let (density, depth) = (number(&found["design"]["areal_density"]), number(&found["design"]["depth_um"]));
    assert!((0.0676 / 1.5..=0.0676 * 1.5).contains(&density) && (2.6..=10.4).contains(&depth), "{density} {depth}");
    assert_eq!(found["discrepancy"]["domain"]["far"], serde_json::json!([]));
    // Deeper and denser patterns would reach this one, and nobody knows by how much they are off.
    let run = place.run(&["optimize", "low.toml"]);
    let told = String::from_utf8(run.stdout).unwrap();
    assert_eq!(
        (run.status.code(), &result(&place, "out/low")["status"]),
        (Some(3), &Value::from("unreachable")),
        "{told}"
    );
    assert!(told.contains("areal density of 4.51 to 10.1 % (the trials: 6.76 %)"), "{told}");
    // Grooves by what squares say.
    let run = place.run(&["optimize", "squares.toml"]);
    let told = String::from_utf8(run.stdout).unwrap();
    assert_eq!(run.status.code(), Some(3), "{told}");
    let found = result(&place, "out/squares");
    assert_eq!((&found["status"], &found["chance"]), (&Value::from("unreachable"), &Value::Null));
    assert_eq!(found["discrepancy"]["domain"]["far"][0], "planform");
    assert!(told.contains("near are square with an areal density"), "{told}");
    assert!(told.contains("which this one (groove) is not: take it as a guess"), "{told}");
}

#[test]
fn a_discrepancy_that_does_not_say_what_the_samples_were_is_not_aimed_with() {
    let of = |target: &str| design(target, HALF);
    let place = Place::with(&[
        ("aimed.toml", &of("value = 0.44\ntolerance = 0.01\ndiscrepancy = true")),
        ("plain.toml", &of("value = 0.88\ntolerance = 0.02")),
    ]);
    let message = place.refuse(&["optimize", "aimed.toml"]);
    assert!(message.contains("target.discrepancy") && message.contains("[[discrepancy.trials]]"), "{message}");
    place.succeed(&["optimize", "plain.toml"]);
}

#[test]
fn aiming_without_patterned_samples_is_refused_at_the_key() {
    let place = Place::with(&[("a.toml", &design("value = 0.44\ntolerance = 0.01\ndiscrepancy = true", ""))]);
    let message = place.refuse(&["optimize", "a.toml"]);
    assert!(message.contains("target.discrepancy") && message.contains("[discrepancy]"), "{message}");
    let text = design("value = 0.44\ntolerance = 0.01\ndiscrepancy = true", "");
    let (from, to) = (text.find("[material]").unwrap(), text.find("[target]").unwrap());
    let named = format!("{}condition = {{ speed_mm_s = 2.0, humidity_pct = 15.0 }}\n{}", &text[..from], &text[to..])
        .replace("name = \"test design\"\n", "name = \"test design\"\nmaterial = \"c.toml\"\n");
    let flat = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.248,0.002\n205,2,15,0.27,0.002\n";
    let place = Place::with(&[("a.toml", &named), ("c.toml", CALIBRATION), ("flat.csv", flat)]);
    let message = place.refuse(&["optimize", "a.toml"]);
    assert!(message.contains("a.toml") && message.contains("needs patterned samples in the calibration"), "{message}");
}

#[test]
fn a_calibration_is_interpolated_between_its_speeds_and_aimed_with_where_asked() {
    let calibration =
        CALIBRATION.replace("flat = \"flat.csv\"", "flat = \"flat.csv\"\npatterned = \"patterned.csv\"").replace(
            "[fit]",
            "[pattern]\nplanform = \"groove\"\nwidth_um = 80.0\nspacing_um = 160.0\ndepth_um = 20.0\n[fit]",
        );
    // Coefficients at 1 and at 4 mm/s lie 10 % about those at 2 mm/s: half way in the logarithm.
    let table = |factor: f64| {
        let header = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned();
        let rows = [(1, 0.9), (4, 1.1)].map(|(speed, of)| format!("205,{speed},15,{},0.0025\n", 0.25 * of * factor));
        header + &rows.concat()
    };
    let text = design("value = 0.8\ntolerance = 0.02\ndiscrepancy = true", "");
    let (from, to) = (text.find("[material]").unwrap(), text.find("[target]").unwrap());
    let named = format!("{}{}", &text[..from], &text[to..]);
    let header =
        "name = \"test design\"\nmaterial = \"c.toml\"\ncondition = { speed_mm_s = 2.0, humidity_pct = 15.0 }\n";
    let named = named.replace("name = \"test design\"\n", header);
    let outside = named.replace("speed_mm_s = 2.0", "speed_mm_s = 0.9");
    let place = Place::with(&[
        ("a.toml", &named),
        ("outside.toml", &outside),
        ("c.toml", &calibration),
        ("flat.csv", &table(1.0)),
        ("patterned.csv", &table(0.9)),
    ]);
    let message = place.refuse(&["optimize", "outside.toml"]);
    assert!(message.contains("not between measured ones") && message.contains("1 mm/s at 15 %"), "{message}");

    let told = place.succeed(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    let confirmed = &found["confirmed"][0];
    let flat = number(&confirmed["mu_flat"]);
    assert!((flat / 0.25 - 1.0).abs() < 0.01, "{flat}");
    let notes = found["material"]["notes"].as_array().unwrap();
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("1 mm/s at 15 % (0.50), 4 mm/s at 15 % (0.50)")));
    let known = &found["discrepancy"];
    assert_eq!((&known["used"], &known["other_planform"]), (&Value::from(true), &Value::Null));
    assert!(told.contains("Near them are groove with an areal density of 22.2 to 50 % (the trials: 33.3 %)"), "{told}");
    // Measured ratios are 0.9 of what the model gives those grooves.
    let factor = number(&known["by_pressure"][0]["factor"]);
    let trial = fs::read_to_string(place.path("out/a/design.toml")).unwrap();
    let (from, to) = (trial.find("[pattern]").unwrap(), trial.find("[sample]").unwrap());
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 80.0\nspacing_um = 160.0\ndepth_um = 20.0\n\n";
    fs::write(place.path("trial.toml"), format!("{}{pattern}{}", &trial[..from], &trial[to..])).unwrap();
    let steady = place.succeed(&["simulate", "trial.toml", "--fidelity", "steady", "--extent", "cell", "--json"]);
    let steady: Value = serde_json::from_str(&steady).unwrap();
    let modelled = number(&steady["errors"]["by_pressure"][0]["ratio"]["value"]);
    assert!((factor * modelled / 0.9 - 1.0).abs() < 0.01, "{factor} {modelled}");
    let at = &found["errors"]["by_pressure"][0];
    let aimed = number(&confirmed["ratio"]) * factor;
    assert!((number(&at["ratio"]["value"]) - aimed).abs() < 1e-6 && (aimed - 0.8).abs() <= 0.02);
    // Each of two coefficients is known to 1 %: their mean to 0.7 %.
    let share = part(&at["mu"], "flat friction") / number(&at["mu"]["value"]);
    assert!((share / (0.01 * 0.5_f64.sqrt()) - 1.0).abs() < 0.1, "{share}");
    assert!(part(&at["ratio"], "discrepancy") > 0.0 && part(&at["ratio"], "Young's modulus") > 0.0);
}
