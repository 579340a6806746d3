//! The chance that a cut sample is on target: every command gives the same number, and the advice follows from it.

use crate::common::{Place, at, column, free, limit, short_at_one_pressure, trusted};

const TOLERANCES: &str = "[tolerances]\nwidth_std_um = 6.0\nspacing_std_um = 1.0\ndepth_std_um = 0.2\n";
const MODULUS: &str = "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.08\n";
const TARGET: &str = "value = 0.88\ntolerance = 0.02";

#[test]
fn the_chance_comes_first_with_what_is_expected_and_what_limits_it() {
    let text = short_at_one_pressure(TARGET, TOLERANCES).replace("density_g_cm3 = 0.9\n", MODULUS);
    let place = Place::with(&[("a.toml", &text)]);
    let (told, found) = place.optimized("a", 0);
    let chance = at(&found, "/chance");
    let words = format!("cut a trial: {:.0} % chance that a cut sample is on target", 100.0 * chance);
    assert!(told.starts_with(&format!("test design: {words}\n")), "{told}");
    assert_eq!((&found["advice"], &found["words"], &found["trials"]), (&"trial".into(), &words.into(), &0.into()));
    let of = |key: &str| at(&found, &format!("/expected/0/{key}"));
    assert_eq!((of("pressure_mpa"), of("target_low"), of("target_high")), (2.6, 0.86, 0.9));
    assert!(of("low_95") < of("target_low") && of("low_95") < of("median") && of("median") < of("high_95"), "{found}");

    // Limits in the order of what they cost in whole per cent: knowing one never lowers the chance, and each moves the ratio.
    let known = column(&found["limited_by"], "/chance_if_known");
    assert!(known.is_sorted_by(|a, b| *a > b - 0.01) && known.iter().all(|known| *known >= chance), "{known:?}");
    assert!(column(&found["limited_by"], "/std/0").into_iter().all(|std| std > 0.0));
    let known_to = ["model error", "Young's modulus", "width"].map(|input| limit(&found, input)["known_to"].clone());
    assert_eq!(known_to, ["no trial yet", "known to 21 %", "made to 6 um"]);
    // A texture made to 6 um scatters by six times what its median changes along a micrometre, and by what the model
    // lacks more or less of there: the form of the model error goes with at most the width, of which 6 um are a share.
    let slopes = found["slopes"].as_array().unwrap();
    let slope = slopes.iter().find(|slope| slope["dimension"] == "width_um").unwrap();
    let expected = 6.0 * at(slope, "/per_um/0").abs();
    let share = 6.0 / at(&found, "/design/width_um");
    let most = expected.hypot(share * at(limit(&found, "model error"), "/std/0"));
    assert!((0.9 * expected..1.1 * most).contains(&at(limit(&found, "width"), "/std/0")), "{slope} {most}");

    // The bars of the page stand in the order of the record.
    let page = place.read("out/a/report.html");
    let (_, bars) = page.split_once("What limits it").unwrap();
    let names = found["limited_by"].as_array().unwrap().iter().map(|limit| limit["input"].as_str().unwrap());
    let places: Vec<usize> = names.filter_map(|name| bars.find(&format!("<span>{name}<small>"))).collect();
    assert!(places.len() > 1 && places.is_sorted(), "{places:?}");
}

/// A target from `low_95` to `high_95` has a chance of 95 %, and a target below the median a chance of one half.
#[test]
fn the_chance_is_the_share_of_the_samples_that_are_expected() {
    let place = Place::with(&[]);
    // Bounds that allow one texture only.
    let of = |target: &str| {
        let text = trusted(&short_at_one_pressure(target, TOLERANCES)).replace("[40.0, 100.0]", "80.0");
        place.write("a.toml", text);
        place.json("optimize a.toml --json")
    };
    let found = of(TARGET);
    let [low, median, high] = ["low_95", "median", "high_95"].map(|key| at(&found, &format!("/expected/0/{key}")));
    for (target, share) in [
        (format!("lowest = {low}\nhighest = {high}"), 0.95),
        (format!("highest = {median}"), 0.5),
        (format!("lowest = {low}\nhighest = {median}"), 0.475),
    ] {
        let found = of(&target);
        assert!((at(&found, "/chance") - share).abs() < 0.005, "{target}: {}", found["chance"]);
        assert_eq!(at(&found, "/expected/0/median"), median);
    }
}

/// Contributions of the inputs add up to the scatter of samples. The chosen designs hardly depend on the modulus to
/// first order, so that the second order dominates and is listed.
#[test]
fn the_limits_are_all_that_scatters_samples() {
    let text = free(&trusted(&short_at_one_pressure(TARGET, TOLERANCES))).replace("density_g_cm3 = 0.9\n", MODULUS);
    let found = Place::with(&[("a.toml", &text)]).optimized("a", 0).1;
    let sum = column(&found["limited_by"], "/std/0").iter().map(|std| std.powi(2)).sum::<f64>().sqrt();
    let width = at(&found, "/expected/0/high_95") - at(&found, "/expected/0/low_95");
    assert!((width / (2.0 * 1.96) / sum - 1.0).abs() < 0.1, "{width} {}", found["limited_by"]);
    let first = &found["limited_by"][0];
    assert!(first["input"] == "Young's modulus" && at(first, "/chance_if_known") > 1.5 * at(&found, "/chance"));
}

#[test]
fn a_target_above_the_flat_surface_is_not_answered_by_a_pattern() {
    let even = short_at_one_pressure("goal = \"even\"", "").replace("[2.6]", "[1.3, 2.6]");
    let place = Place::with(&[
        ("above.toml", &short_at_one_pressure("value = 1.2\ntolerance = 0.03", "")),
        ("highest.toml", &short_at_one_pressure("goal = \"highest\"", "")),
        ("even.toml", &even),
        ("beside.toml", &short_at_one_pressure("goal = \"highest\"\nhighest = 0.93", "")),
        ("flat.toml", &short_at_one_pressure("lowest = 0.95\nhighest = 1.05", "")),
    ]);
    // Before any trial only a trial says how far the model is off.
    assert_eq!(place.optimized("above", 0).1["advice"], "trial");
    // Ratios of the flat surface are even by nature.
    for file in ["highest", "flat", "even"] {
        assert_eq!(place.optimized(file, 3).1["advice"], "do_not_texture", "{file}");
        place.ends(&format!("next {file}.toml"), 3);
    }
    // The flat surface does not do what is demanded beside the goal.
    let found = place.optimized("beside", 0).1;
    assert_eq!((&found["advice"], &found["goal"]["goal"]), (&"trial".into(), &"highest".into()));
    assert!(at(&found, "/expected/0/median") <= 0.93 && at(&found, "/chance") >= 0.5, "{found}");
}
