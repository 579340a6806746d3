//! Discrepancies from trials in designs and scenes, and the error of every value of a scene.

use crate::common::{
    Place, at, column, correction, free, measured, patterned, row, short, short_at_one_pressure, trusted,
};
use serde_json::Value;

/// Design of a short sample at one pressure.
fn design(target: &str, material: &str) -> String {
    short_at_one_pressure(target, "").replace("[target]", &format!("{material}[target]"))
}

/// Trial of a groove whose measured ratio is nine tenths of the modelled one.
const TRIAL: &str = "[material.learned]\nreference_pressure_mpa = 1.5\nlowest_pressure_mpa = 0.65\n\
    reference_speed_mm_s = 2.0\nmodulus_relative_std = 0.1\n[material.learned.prior]\n\
    [[material.learned.trial]]\nname = \"first\"\nareal_density = 0.4\nedge_per_mm = 10.0\nwidth_um = 80.0\npitch_um = 200.0\n\
    depth_um = 10.0\npressure_mpa = [2.6]\nspeed_mm_s = [2.0]\nhumidity_pct = [40.0]\nmeasured_ratio = [0.783]\n\
    modelled_ratio = [0.87]\npatterned_std = [0.005]\nflat_std = [0.005]\nmodulus_sensitivity = [0.1]\n";

const ERRORS: [(&str, &str); 2] = [
    ("density_g_cm3 = 0.9\n", "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.038\n"),
    ("dynamic_mean = 0.27\n", "dynamic_mean = 0.27\ndynamic_std_error = 0.0027\n"),
];

/// Discrepancy factor at the first load: predicted median over modelled ratio.
fn factor(sample: &Value) -> f64 {
    at(sample, "/expected/0/median") / at(sample, "/modelled/0/ratio")
}

fn part(value: &Value, input: &str) -> f64 {
    row(&value["parts"], "input", input).map_or(0.0, |part| at(part, "/std"))
}

#[test]
fn a_trial_on_target_allows_a_series_and_is_not_modelled_again() {
    let of = |target: &str, material: &str| design(target, material) + "[tolerances]\nwidth_std_um = 1.0\n";
    let near = "value = 0.75\ntolerance = 0.02";
    // Measured at a pressure near by, it is no sample on target, and speaks for similar ones.
    let series = trusted(&of("value = 0.86\ntolerance = 0.06", ""))
        .replace("[target]", &format!("{}[target]", TRIAL.split_once("[material.learned.prior]\n").unwrap().1))
        .replace("pressure_mpa = [2.6]\nspeed_mm_s", "pressure_mpa = [1.9]\nspeed_mm_s")
        .replace("[0.783]", "[0.87]");
    let place =
        Place::with(&[("without.toml", &of(near, "")), ("with.toml", &of(near, TRIAL)), ("series.toml", &series)]);
    // Trials of a material file are not modelled again as the layer of the design.
    let [said, silent] = ["with", "without"].map(|name| place.told(&format!("explore {name}.toml -o {name}.html")));
    assert!(said.contains("um is modelled alone") && !silent.contains("modelled alone"), "{said} {silent}");
    let found = place.optimized("series", 0).1;
    assert!(found["advice"] == "series" && at(&found, "/chance") >= 0.9, "{found}");
}

#[test]
fn a_scene_without_errors_shows_those_of_its_run_alone_and_says_so() {
    let place = Place::with(&[("a.toml", &design("value = 0.88\ntolerance = 0.02", ""))]);
    place.succeed("optimize a.toml");
    let found = place.json("simulate out/a/scene.toml --json");
    assert_eq!(found["errors"]["unknown"], serde_json::json!(["flat friction", "Young's modulus", "area law"]));
    let (errors, run) = (&found["errors"]["by_pressure"][0], &found["results"][0]);
    let effects = ["layout on the specimen", "sliding in time", "size of blocks", "phases of stick-slip"];
    let own = effects.iter().fold(at(run, "/ratio_stderr"), |own, effect| own.hypot(part(&errors["ratio"], effect)));
    let of_blocks = at(correction(run, "size of blocks").unwrap(), "/std");
    assert!((part(&errors["ratio"], "size of blocks") / of_blocks - 1.0).abs() < 1e-6);
    assert!((at(errors, "/ratio/std") / own - 1.0).abs() < 1e-6, "{errors}");
    // 5 % over the blocks in contact and of about equal friction; it is taken out of the ratio.
    let interface = place.read("out/a/interface.csv");
    let land = interface.lines().filter(|line| line.contains(",patterned,")).count() as f64;
    let expected = 0.05 * at(errors, "/mu/value") / land.sqrt();
    let drawn = part(&errors["mu"], "local coefficients drawn");
    assert!(drawn >= 0.98 * expected && drawn < 1.3 * expected, "{drawn} {expected}");
    assert!(row(&errors["ratio"]["parts"], "input", "local coefficients drawn").is_none());
}

#[test]
fn a_simulated_design_has_what_trials_say_and_the_errors_of_what_is_solved() {
    let known = |text: String| ERRORS.iter().fold(text, |text, (from, to)| text.replace(from, to));
    let place = Place::with(&[("a.toml", &known(design("value = 0.8\ntolerance = 0.02", TRIAL)))]);
    let found = place.optimized("a", 0).1;
    let again = place.json("simulate out/a/scene.toml --json");
    let (simulated, corrected) = (&again["errors"]["by_pressure"][0], &again["discrepancy"]["by_pressure"][0]);
    assert_eq!(again["results"][0]["ratio"], found["confirmed"][0]["ratio"]);
    assert!((at(corrected, "/factor") - factor(&found)).abs() < 1e-3 && factor(&found) < 0.97, "{corrected}");
    let share = at(corrected, "/ratio/value") / at(simulated, "/ratio/value");
    assert!((share - at(corrected, "/factor")).abs() < 1e-9);
    assert!(part(&corrected["ratio"], "discrepancy") > 0.0 && part(&simulated["ratio"], "discrepancy") == 0.0);

    // A periodic cell at the mean coefficients has neither time nor draws in it.
    let steady = place.json("simulate out/a/scene.toml --fidelity steady --extent cell --json");
    assert_eq!(steady["errors"]["includes"], serde_json::json!(["size of blocks", "flat friction", "Young's modulus"]));

    // On a flat surface flat friction is all there is, and of a static peak its coefficient and its draw.
    let text = place.read("out/a/scene.toml");
    let from_rest = |line: &str| match line.split_once(" = ") {
        Some(("warm_start" | "mu_stderr", _)) => None,
        Some(("sliding_um", _)) => Some("sliding_um = 1.0\n".to_owned()),
        _ => Some(format!("{line}\n")),
    };
    let flat: String = text.lines().filter_map(from_rest).collect();
    let (from, to) = (flat.find("[pattern]").unwrap(), flat.find("[sample]").unwrap());
    let flat = format!("{}{}", &flat[..from], &flat[to..]);
    place.write("static.toml", flat.replace("dynamic_std_error", "static_std_error = 0.003\ndynamic_std_error"));
    place.write("flat.toml", flat);
    let [open, known] = ["flat", "static"].map(|name| place.json(&format!("simulate {name}.toml --json")));
    let errors = &known["errors"]["by_pressure"][0];
    assert!((part(&errors["mu"], "flat friction") / at(errors, "/mu/value") - 0.01).abs() < 1e-6, "{errors}");
    assert!(errors.get("ratio").is_none() && errors.get("mu_flat").is_none() && known["discrepancy"].is_null());
    let peak = &errors["mu_static"];
    assert!((part(peak, "static coefficient") / at(peak, "/value") - 0.01).abs() < 1e-6, "{peak}");
    assert!(part(peak, "local coefficients drawn") > 0.0);
    assert_eq!(known["errors"]["unknown"], serde_json::json!([]));
    assert_eq!(open["errors"]["unknown"], serde_json::json!(["static coefficient"]));
}

#[test]
fn a_calibration_is_interpolated_between_its_speeds() {
    let groove = "[pattern]\nplanform = \"groove\"\nwidth_um = 80.0\nspacing_um = 160.0\ndepth_um = 20.0\n";
    // Coefficients at 1 and at 4 mm/s lie 10 % about those at 2 mm/s: half way in the logarithm.
    let table = |factor: f64| {
        let header = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned();
        let rows = [(1, 0.9), (4, 1.1)].map(|(speed, of)| format!("205,{speed},15,{},0.0025\n", 0.25 * of * factor));
        header + &rows.concat()
    };
    let named = measured(&free(&design("value = 0.8\ntolerance = 0.02", "")), "c.toml");
    let place = Place::with(&[
        ("a.toml", &named),
        ("outside.toml", &named.replace("speed_mm_s = 2.0", "speed_mm_s = 0.9")),
        ("c.toml", &patterned(groove)),
        ("flat.csv", &table(1.0)),
        ("patterned.csv", &table(0.9)),
    ]);
    let message = place.refuse("optimize outside.toml");
    assert!(message.contains("not between measured ones") && message.contains("1 mm/s at 15 %"), "{message}");

    let found = place.optimized("a", 0).1;
    let flat = at(&found, "/confirmed/0/mu_flat");
    assert!((flat / 0.25 - 1.0).abs() < 0.01, "{flat}");
    assert!(found["material"]["notes"].to_string().contains("1 mm/s at 15 % (0.50), 4 mm/s at 15 % (0.50)"));
    assert_eq!(found["trials"], 1);
    // Measured ratios are 0.9 of those of a flat sample: what is expected of another sample of those grooves.
    let trial = place.read("out/a/scene.toml");
    let (from, to) = (trial.find("[pattern]").unwrap(), trial.find("[sample]").unwrap());
    place.write("trial.toml", format!("{}{groove}\n{}", &trial[..from], &trial[to..]));
    let steady = place.json("simulate trial.toml --fidelity steady --extent cell --json");
    let (errors, corrected) = (&steady["errors"]["by_pressure"][0], &steady["discrepancy"]["by_pressure"][0]);
    // Two measurements, each known to 1.4 %, on a sample of which little was believed.
    assert!((at(corrected, "/ratio/value") / 0.9 - 1.0).abs() < 0.02, "{corrected} {errors}");
    // Each of two coefficients is known to 1 %, and what lies between them no better.
    let share = part(&errors["mu"], "flat friction") / at(errors, "/mu/value");
    assert!((share / 0.01 - 1.0).abs() < 0.1, "{share}");
    let own = column(&place.json("next a.toml --candidate 80,160,18.2 --json")["own"], "/expected/0/median");
    assert!((own[0] / 0.9 - 1.0).abs() < 0.03, "{own:?}");
}

/// A target between the measured pressures, where the flat sample is known to 5 %: its error is shared with the trial,
/// which friction is then better known by. The scene of the design says of its friction what the design does.
#[test]
fn a_scene_between_measured_pressures_says_what_its_design_says() {
    let groove = "[pattern]\nplanform = \"groove\"\nwidth_um = 60.0\nspacing_um = 120.0\ndepth_um = 10.4\n";
    let table = |factor: f64| {
        let rows = [(51, 0.25), (205, 0.28)].map(|(force, mu)| format!("{force},2,15,{},0.0125\n", mu * factor));
        "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned() + &rows.concat()
    };
    let target = "quantity = \"mu_dynamic\"\npressure_mpa = 1.3\nvalue = 0.23\ntolerance = 0.05\n";
    let (head, rest) = short().split_once("quantity = \"ratio\"").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    let (_, rest) = rest.split_once("tolerance = 0.01\n").unwrap();
    let place = Place::with(&[
        ("a.toml", &measured(&format!("{head}{target}{rest}"), "c.toml")),
        ("c.toml", &patterned(groove)),
        ("flat.csv", &table(1.0)),
        ("patterned.csv", &table(0.9)),
    ]);
    place.run("optimize a.toml");
    let expected = &place.result("out/a")["expected"][0];
    let scene = place.json("simulate out/a/scene.toml --json");
    let mu = &scene["discrepancy"]["by_pressure"][0]["mu"];
    // The tolerances of a cut sample and the second order of the modulus are not in a scene.
    for (design, scene) in [("/median", "/value"), ("/low_95", "/interval_95/0"), ("/high_95", "/interval_95/1")] {
        let (design, scene) = (at(expected, design), at(mu, scene));
        assert!((scene / design - 1.0).abs() < 3e-3, "{design} {scene}: {expected} {mu}");
    }
}
