//! Designs for several speeds and humidities, given one by one or as ranges.

use crate::common::{Place, at, column, free, limit, measured, patterned, short_at_one_pressure, trusted};
use serde_json::Value;

/// Condition of the material: speed in mm/s, humidity in percent, mean local dynamic coefficient.
type Measured = (f64, f64, f64);

/// Design of a short sample at one pressure with coefficients at `measured` conditions; `header` gives the conditions.
fn design(target: &str, measured: &[Measured], header: &str) -> String {
    let row = |(speed, humidity, mean): &Measured| {
        let at_rest = 1.1 * mean;
        format!(
            "[[material.friction.conditions]]\nspeed_mm_s = {speed}\nhumidity_pct = {humidity}\npressure_mpa = [2.6]\n\
             static_mean = {at_rest}\ndynamic_mean = {mean}\n"
        )
    };
    let rows: String = measured.iter().map(row).collect();
    short_at_one_pressure(target, "")
        .replacen("quantity = \"ratio\"\n", "", 1)
        .replace("static_mean = 0.30\ndynamic_mean = 0.27\n", &format!("relative_std = 0.05\n{rows}"))
        .replace("[material]\n", &format!("{header}\n[material]\n"))
}

/// Discrepancy factor at every condition: predicted median over modelled ratio.
fn factors(found: &Value) -> Vec<f64> {
    let (expected, modelled) = (medians(found), column(&found["modelled"], "/ratio"));
    expected.iter().zip(modelled).map(|(expected, modelled)| expected / modelled).collect()
}

/// Predicted medians at every condition; the condition of the design is the first.
fn medians(found: &Value) -> Vec<f64> {
    column(&found["expected"], "/median")
}

fn are_within(found: &Value) -> bool {
    let is_within = |row: &Value| (at(row, "/target_low")..=at(row, "/target_high")).contains(&at(row, "/median"));
    found["expected"].as_array().unwrap().iter().all(is_within)
}

/// Ratio of the design in `folder` from a steady cell with the mean local dynamic coefficient `mean`.
fn steady(place: &Place, folder: &str, mean: f64) -> f64 {
    let scene = place.read(&format!("{folder}/scene.toml"));
    let lines = scene.lines().map(|line| match line.split_once(" = ") {
        Some(("dynamic_mean", _)) => format!("dynamic_mean = {mean}\n"),
        _ => format!("{line}\n"),
    });
    place.write("steady.toml", lines.collect::<String>());
    place.ratios("steady.toml --fidelity steady --extent cell")[0]
}

const FIRST: &str = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";

#[test]
fn a_friction_target_holds_at_every_condition() {
    let measured = [(2.0, 15.0, 0.27), (8.0, 15.0, 0.324)];
    let wanted = |tolerance: f64, speed: &str| {
        let header = format!("{FIRST}\nalso_at = [{{ speed_mm_s = {speed}, humidity_pct = 15.0 }}]");
        let target = format!("quantity = \"mu_dynamic\"\nvalue = 0.17\ntolerance = {tolerance}");
        trusted(&design(&target, &measured, &header))
    };
    let place = Place::with(&[("a.toml", &wanted(0.018, "4.0")), ("narrow.toml", &wanted(0.005, "8.0"))]);
    let found = place.optimized("a", 0).1;
    // The target stays as it was asked.
    assert_eq!((at(&found, "/target/value/0"), at(&found, "/target/tolerance")), (0.17, 0.018));
    assert_eq!(column(&found["expected"], "/speed_mm_s"), [2.0, 4.0]);
    // Half way from 2 to 8 mm/s friction is 1.1 times that at 2: aimed at from both sides.
    let expected = medians(&found);
    assert!(
        are_within(&found) && (expected[1] / expected[0] - 1.1).abs() < 0.011 && expected[0] < 0.17,
        "{expected:?}"
    );
    // Beyond a steady cell of the other friction the model has what the run in time and the face add at the first.
    let modelled = column(&found["modelled"], "/ratio");
    let beyond = |row: usize, mean: f64| (modelled[row] / steady(&place, "out/a", mean)).ln();
    assert!((beyond(0, 0.27) - beyond(1, 0.297)).abs() < 1e-3, "{} {}", beyond(0, 0.27), beyond(1, 0.297));
    // The ends of a range of friction stand for it: ratios rise or fall with friction all along.
    let along = [0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5].map(|mean| steady(&place, "out/a", mean));
    assert!(along.is_sorted() || along.is_sorted_by(|a, b| a >= b), "{along:?}");

    // What no pattern can do is said, beside the likeliest design: flat friction of the one is 1.2 times that of the other.
    let found = place.optimized("narrow", 0).1;
    assert!(found["words"].as_str().unwrap().contains("the model alone reaches no texture on target"), "{found}");
    let share = medians(&found)[1] / medians(&found)[0];
    assert!((share - 1.2).abs() < 0.03 && share > 0.175 / 0.165, "{share}");
}

#[test]
fn shares_of_samples_count_all_conditions_together() {
    // Friction of the flat surface is known to 1 % at either, and 1 % separates the second from its limit.
    let measured = [(2.0, 15.0, 0.20), (2.0, 80.0, 0.27)];
    let both = format!("{FIRST}\nalso_at = [{{ speed_mm_s = 2.0, humidity_pct = 80.0 }}]");
    let place = Place::with(&[]);
    let below = |highest: f64| {
        let target = format!("quantity = \"mu_dynamic\"\nhighest = {highest}");
        let text = design(&target, &measured, &both).replace("width_um = [40.0, 100.0]", "width_um = 60.0");
        let text = [0.20, 0.27].into_iter().fold(text, |text, mean| {
            let known = format!("dynamic_mean = {mean}\n");
            text.replace(&known, &format!("{known}dynamic_std_error = {}\n", 0.01 * mean))
        });
        place.write("a.toml", trusted(&text));
        place.run("optimize a.toml");
        place.result("out/a")
    };
    let wide = medians(&below(0.5));
    assert!(wide[1] > 1.2 * wide[0], "{wide:?}");
    let found = below(1.01 * wide[1]);
    assert_eq!(medians(&found), wide);
    // A normal distribution is below its standard deviation with 84 %; the little else that is not known widens it.
    let share = at(&found, "/chance");
    assert!((0.7..0.84).contains(&share), "{share}");
    let flat = limit(&found, "flat friction");
    assert!(at(flat, "/chance_if_known") > share + 0.02 && flat["known_to"] == "known to 1.0 %", "{flat}");
    let relative = at(flat, "/std/1") / at(&found, "/modelled/1/ratio");
    assert!((relative - 0.01).abs() < 5e-4, "{relative}");
}

#[test]
fn a_calibration_takes_in_every_condition_of_a_range() {
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n";
    // At 5 mm/s nothing is needed: the range ends before.
    let table = |dry: f64, humid: f64| {
        let mut text = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned();
        for (humidity, mu) in [(15, 0.25 * dry), (80, 0.28 * humid)] {
            for (force, more) in [(100, 0.99), (150, 1.0), (205, 1.01)] {
                text += &format!("{force},2,{humidity},{},0.0025\n", mu * more);
            }
        }
        text + &format!("205,5,15,{},0.0025\n", 0.3 * dry)
    };
    let text = free(&design("quantity = \"ratio\"\nvalue = 0.8\ntolerance = 0.08", &[(2.0, 15.0, 0.27)], ""));
    let with = |humidity: &str| measured(&text, "c.toml").replace("_pct = 15.0", &format!("_pct = {humidity}"));
    let place = Place::with(&[
        ("a.toml", &with("[15.0, 80.0]")),
        ("outside.toml", &with("[15.0, 81.0]")),
        ("c.toml", &patterned(pattern)),
        ("flat.csv", &table(1.0, 1.0)),
        ("patterned.csv", &table(0.9, 0.8)),
    ]);
    let message = place.refuse("optimize outside.toml");
    assert!(message.contains("outside.toml:4: condition: ") && message.contains("2 mm/s at 81 %"), "{message}");
    let found = place.optimized("a", 0).1;
    assert_eq!(found["trials"], 1);
    // Measured ratios are 0.9 at 15 % and 0.8 at 80 %; modelled ones hardly differ.
    let (factors, humidities) = (factors(&found), column(&found["expected"], "/humidity_pct"));
    assert_eq!(humidities.len(), 5);
    let [dry, humid] = [15.0, 80.0].map(|at| factors[humidities.iter().position(|of| *of == at).unwrap()]);
    assert!((humid / dry / (0.8 / 0.9) - 1.0).abs() < 0.05, "{dry} {humid}");
    let flat = at(&found, "/confirmed/0/mu_flat");
    assert!((flat / (0.25 * 1.01) - 1.0).abs() < 0.02, "{flat}");
}
