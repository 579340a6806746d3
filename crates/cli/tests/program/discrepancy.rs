//! Designs that aim with the discrepancy of patterned samples, and one error beside every value.

use std::fs;

use crate::common::{CALIBRATION, DESIGN, Place, number, result};
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

/// A groove whose ratio was measured to be nine tenths of the modelled one.
const TRIAL: &str = "[material.learned]\nreference_pressure_mpa = 1.5\nlowest_pressure_mpa = 0.65\n\
    reference_speed_mm_s = 2.0\nmodulus_relative_std = 0.1\n[material.learned.prior]\n\
    [[material.learned.trial]]\nname = \"first\"\nareal_density = 0.4\nedge_per_mm = 10.0\nwidth_um = 80.0\npitch_um = 200.0\n\
    depth_um = 10.0\npressure_mpa = [2.6]\nspeed_mm_s = [2.0]\nhumidity_pct = [40.0]\nmeasured_ratio = [0.783]\n\
    modelled_ratio = [0.87]\npatterned_std = [0.005]\nflat_std = [0.005]\nmodulus_sensitivity = [0.1]\n";

const ERRORS: [(&str, &str); 2] = [
    ("density_g_cm3 = 0.9\n", "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.038\n"),
    ("dynamic_mean = 0.27\n", "dynamic_mean = 0.27\ndynamic_std_error = 0.0027\n"),
];

fn part(value: &Value, input: &str) -> f64 {
    let parts = value["parts"].as_array().unwrap();
    parts.iter().find(|part| part["input"] == input).map_or(0.0, |part| number(&part["std"]))
}

#[test]
fn values_count_times_what_trials_say_and_the_chance_has_all_of_it() {
    let known = |text: String| ERRORS.iter().fold(text, |text, (from, to)| text.replace(from, to));
    let tolerances = "[tolerances]\nwidth_std_um = 1.0\n";
    let of = |aims: &str| known(design(&format!("value = 0.75\ntolerance = 0.02\n{aims}"), TRIAL)) + tolerances;
    let place = Place::with(&[("plain.toml", &of("")), ("aimed.toml", &of("discrepancy = true"))]);
    place.run(&["optimize", "plain.toml", "-o", "out/plain"]);
    let told = place.succeed(&["optimize", "aimed.toml", "-o", "out/aimed"]);
    assert!(told.contains("aimed with what trials say that the model lacks"), "{told}");
    assert!(told.contains("by the physics alone, which the values above are times the factor of"), "{told}");
    let (aimed, plain) = (result(&place, "out/aimed"), result(&place, "out/plain"));
    assert!(plain["discrepancy"].is_null());

    // What is compared with the target is the run's ratio times the factor; the run itself is reported as it is.
    let found = &aimed["discrepancy"];
    let (at, errors) = (&found["by_pressure"][0], &aimed["errors"]["by_pressure"][0]);
    let (factor, ratio) = (number(&at["factor"]), number(&aimed["confirmed"][0]["ratio"]));
    assert!(found["trials"] == 1 && (0.85..0.97).contains(&factor), "{found}");
    assert!((number(&errors["ratio"]["value"]) - factor * ratio).abs() < 1e-6, "{errors}");
    assert!((factor * ratio - 0.75).abs() <= 0.02 && (number(&at["confirmed"]["physics"]) - ratio).abs() < 1e-9);
    assert!(number(&found["physics_misfit"]) > 1.0);

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
        assert!(part(ratio, "time average") > 0.0, "{ratio}");
        // What was predicted is known by the run, and by how far that is from it.
        assert_eq!(part(&at["predicted"], "time average"), part(ratio, "time average"));
        let distance = (number(&ratio["value"]) - number(&at["predicted"]["value"])).abs();
        assert!((part(&at["predicted"], "distance from the confirming run") - distance).abs() < 1e-9, "{at}");
        assert_eq!(found["errors"]["unknown"], serde_json::json!(["area law"]));
    }
    let of = |found: &Value| found["errors"]["by_pressure"][0]["ratio"].clone();
    let (with, without) = (of(&aimed), of(&plain));
    let expected = number(&at["relative_std"]) * number(&with["value"]);
    assert!((part(&with, "discrepancy") / expected - 1.0).abs() < 1e-3, "{with} {expected}");
    assert_eq!(part(&without, "discrepancy"), 0.0);
    // What is not known of the modulus is in the discrepancy.
    assert!(part(&with, "Young's modulus") == 0.0 && part(&without, "Young's modulus") > 0.0);
    let ends = with["interval_95"].as_array().unwrap();
    let value = number(&with["value"]);
    assert!(number(&ends[0]) < value - 1.5 * expected && number(&ends[1]) > value + 1.5 * expected, "{with}");

    // Its distribution drawn, and integrated exactly: but for flat friction, blocks and time the same chance.
    let [drawn, exact] = [&aimed["chance"]["value"], &aimed["advice"]["chance"]].map(number);
    assert!((drawn - exact).abs() < 0.05 && (0.05..0.9).contains(&exact), "{drawn} {exact}");
    // What is listed beside a trial is likelier than it.
    let plain = &plain["advice"];
    let rather = plain["rather"].as_array().unwrap();
    assert!(plain["advice"] == "trial" && !rather.is_empty(), "{plain}");
    assert!(rather.iter().all(|of| number(&of["chance"]) > number(&plain["chance"])), "{plain}");
    let names: Vec<&str> =
        aimed["chance"]["parts"].as_array().unwrap().iter().map(|part| part["input"].as_str().unwrap()).collect();
    assert!(names.contains(&"discrepancy") && !names.contains(&"Young's modulus"), "{names:?}");
    assert!(aimed["chance"]["limited_by"]["known_to"].as_str().unwrap().contains("one trial"));
    let page = fs::read_to_string(place.path("out/aimed/report.html")).unwrap();
    assert!(
        page.contains("The search aimed with the discrepancy") && page.contains("What the error of a confirmed value")
    );
    let svg = fs::read_to_string(place.path("out/aimed/target.svg")).unwrap();
    assert!(svg.contains("confirmed ± one standard deviation"));
}

#[test]
fn a_material_without_errors_shows_those_of_the_run_alone_and_says_so() {
    let place = Place::with(&[("a.toml", &design("value = 0.88\ntolerance = 0.02", ""))]);
    let told = place.succeed(&["optimize", "a.toml"]);
    assert!(
        told.contains("+-: one standard deviation of time average, layout on the specimen, size of blocks, local coefficients drawn;"),
        "{told}"
    );
    assert!(told.contains("not known of this material: flat friction, Young's modulus, area law"), "{told}");
    let found = result(&place, "out/a");
    let at = &found["errors"]["by_pressure"][0];
    assert_eq!(found["discrepancy"], Value::Null);
    let distance = (number(&at["ratio"]["value"]) - number(&at["predicted"]["value"])).abs();
    assert!((number(&at["predicted"]["std"]) / number(&at["ratio"]["std"]).hypot(distance) - 1.0).abs() < 1e-6, "{at}");
    let own = number(&found["confirmed"][0]["ratio_stderr"]);
    let own = own.hypot(part(&at["ratio"], "layout on the specimen")).hypot(part(&at["ratio"], "size of blocks"));
    assert!(
        (2.0 * part(&at["ratio"], "size of blocks") / number(&found["confirmed"][0]["ratio_discretization_error"])
            - 1.0)
            .abs()
            < 1e-6
    );
    assert!((number(&at["ratio"]["std"]) / own - 1.0).abs() < 1e-6, "{at}");
    // 5 % over the blocks in contact and of about equal friction; it is taken out of the ratio.
    let mu = &at["mu"];
    let interface = fs::read_to_string(place.path("out/a/interface.csv")).unwrap();
    let land = interface.lines().filter(|line| line.contains(",patterned,")).count() as f64;
    let expected = 0.05 * number(&mu["value"]) / land.sqrt();
    let drawn = part(mu, "local coefficients drawn");
    assert!(drawn >= 0.98 * expected && drawn < 1.3 * expected, "{drawn} {expected}");
    let of_ratio = at["ratio"]["parts"].as_array().unwrap();
    assert!(of_ratio.iter().all(|part| part["input"] != "local coefficients drawn"), "{of_ratio:?}");
}

#[test]
fn a_simulated_design_has_the_errors_it_was_found_with() {
    let known = |text: String| ERRORS.iter().fold(text, |text, (from, to)| text.replace(from, to));
    let place = Place::with(&[("a.toml", &known(design("value = 0.88\ntolerance = 0.02", TRIAL)))]);
    place.succeed(&["optimize", "a.toml"]);
    let (found, scene) = (result(&place, "out/a"), "out/a/scene.toml");
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
    let predicted = &found["advice"]["predicted"][0];
    let expected = number(&predicted["ratio"]) / number(&predicted["modelled"]);
    assert!((number(&corrected["factor"]) - expected).abs() < 1e-3 && expected < 0.97, "{corrected} {expected}");
    let share = number(&corrected["ratio"]["value"]) / number(&simulated["ratio"]["value"]);
    assert!((share - number(&corrected["factor"])).abs() < 1e-9);
    assert!(part(&corrected["ratio"], "discrepancy") > 0.0 && part(&simulated["ratio"], "discrepancy") == 0.0);

    // A periodic cell at the mean coefficients has neither time nor draws in it.
    let steady = simulate(&["--fidelity", "steady", "--extent", "cell"]);
    assert_eq!(steady["errors"]["includes"], serde_json::json!(["size of blocks", "flat friction", "Young's modulus"]));
    let told = place.succeed(&["simulate", scene, "--fidelity", "steady", "--extent", "cell"]);
    assert!(told.contains("mu_dynamic      +-  mu_flat      +-   ratio      +-"), "{told}");
    assert!(told.contains("with what one trial says that the model lacks"), "{told}");

    // On a flat surface flat friction is all there is, and of a static peak its coefficient and its draw.
    let text = fs::read_to_string(place.path(scene)).unwrap();
    let from_rest = |line: &str| match line.split_once(" = ") {
        Some(("warm_start" | "mu_stderr", _)) => None,
        Some(("sliding_um", _)) => Some("sliding_um = 1.0\n".to_owned()),
        _ => Some(format!("{line}\n")),
    };
    // A lower layer is sheared sooner.
    let flat: String = text.replace("layer_um = 200", "layer_um = 60").lines().filter_map(from_rest).collect();
    assert!(flat.contains("layer_um = 60"), "{flat}");
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

#[test]
fn the_discrepancy_never_stands_in_place_of_a_pattern() {
    // Next to no texture did nearly all: the target is about the factor itself, and the flat surface has 1.
    let trial = TRIAL
        .replace("areal_density = 0.4", "areal_density = 0.0014")
        .replace("edge_per_mm = 10.0", "edge_per_mm = 0.04");
    let trial = trial.replace("[0.783]", "[0.83]").replace("[0.87]", "[0.9996]");
    let text =
        design("value = 0.83\ntolerance = 0.03\ndiscrepancy = true", &trial).replace("[40.0, 200.0]", "[40.0, 2000.0]");
    let place = Place::with(&[("a.toml", &text)]);
    place.run(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    let by_physics = number(&found["discrepancy"]["by_pressure"][0]["predicted"]["physics"]);
    assert!(by_physics < 0.97 + 1e-6, "{}", found["discrepancy"]);
}

#[test]
fn before_any_trial_designs_aim_with_what_is_believed() {
    let text = design("value = 0.88\ntolerance = 0.02\ndiscrepancy = true", "");
    // One factor for every texture, as earlier versions wrote it, is read over.
    let old = design("value = 0.88\ntolerance = 0.02", "[material.discrepancy]\npattern = \"groove\"\n");
    let place = Place::with(&[("a.toml", &text), ("old.toml", &old)]);
    let told = place.succeed(&["optimize", "a.toml"]);
    assert!(told.contains("what is believed before any trial"), "{told}");
    let found = result(&place, "out/a");
    let at = &found["discrepancy"]["by_pressure"][0];
    assert!((number(&at["factor"]) - 1.0).abs() < 1e-9 && number(&at["relative_std"]) > 0.1, "{at}");
    assert!(number(&found["chance"]["value"]) < 0.3, "{}", found["chance"]);
    place.succeed(&["optimize", "old.toml"]);
    let old = result(&place, "out/old");
    assert!(old["material"]["notes"].to_string().contains("[discrepancy] of the material file is not used"));
    assert!(old["discrepancy"].is_null());
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
    assert!(known["trials"] == 1 && told.contains("what one trial says"), "{told}");
    // Measured ratios are 0.9 of what the model gives those grooves.
    let factor = number(&known["by_pressure"][0]["factor"]);
    let trial = fs::read_to_string(place.path("out/a/scene.toml")).unwrap();
    let (from, to) = (trial.find("[pattern]").unwrap(), trial.find("[sample]").unwrap());
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 80.0\nspacing_um = 160.0\ndepth_um = 20.0\n\n";
    fs::write(place.path("trial.toml"), format!("{}{pattern}{}", &trial[..from], &trial[to..])).unwrap();
    let steady = place.succeed(&["simulate", "trial.toml", "--fidelity", "steady", "--extent", "cell", "--json"]);
    let steady: Value = serde_json::from_str(&steady).unwrap();
    let (at, corrected) = (&steady["errors"]["by_pressure"][0]["ratio"], &steady["discrepancy"]["by_pressure"][0]);
    // Two measurements, each known to 1.4 %, on a sample of which little was believed.
    assert!((number(&corrected["ratio"]["value"]) / 0.9 - 1.0).abs() < 0.02, "{corrected} {at}");
    let at = &found["errors"]["by_pressure"][0];
    let aimed = number(&confirmed["ratio"]) * factor;
    assert!((number(&at["ratio"]["value"]) - aimed).abs() < 1e-6 && (aimed - 0.8).abs() <= 0.02);
    // Each of two coefficients is known to 1 %, and what lies between them no better.
    let share = part(&at["mu"], "flat friction") / number(&at["mu"]["value"]);
    assert!((share / 0.01 - 1.0).abs() < 0.1, "{share}");
    assert!(part(&at["ratio"], "discrepancy") > 0.0 && part(&at["ratio"], "Young's modulus") == 0.0);
}
