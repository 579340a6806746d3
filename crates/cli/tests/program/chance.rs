//! The chance that a cut sample is on target: every command gives the same number, and the advice follows from it.

use crate::common::{Place, free, number, optimized, short, trusted};

const TOLERANCES: &str = "[tolerances]\nwidth_std_um = 6.0\nspacing_std_um = 1.0\ndepth_std_um = 0.2\n";
const MODULUS: &str = "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.08\n";

/// Design of a short sample of several periods, at one pressure.
fn design(target: &str, more: &str) -> String {
    let text = short().replace("[0.65, 2.6]", "[2.6]").replace("value = 0.9\ntolerance = 0.01", target);
    format!("{text}{more}")
}

/// Design whose bounds allow one texture only.
fn fixed(target: &str, more: &str) -> String {
    design(target, more).replace("[40.0, 100.0]", "80.0")
}

#[test]
fn the_chance_comes_first_with_what_is_expected_and_what_limits_it() {
    let text = design("value = 0.88\ntolerance = 0.02", TOLERANCES).replace("density_g_cm3 = 0.9\n", MODULUS);
    let place = Place::with(&[("a.toml", &text)]);
    let (told, found) = optimized(&place, "a.toml", 0);
    let chance = number(&found["chance"]);
    let words = format!("cut a trial: {:.0} % chance that a cut sample is on target", 100.0 * chance);
    assert!(told.starts_with(&format!("test design: {words}\n")), "{told}");
    assert_eq!((&found["advice"], &found["words"], &found["trials"]), (&"trial".into(), &words.into(), &0.into()));
    let [at] = &found["expected"].as_array().unwrap()[..] else { panic!("{}", found["expected"]) };
    let of = |key: &str| number(&at[key]);
    assert_eq!((of("pressure_mpa"), of("target_low"), of("target_high")), (2.6, 0.86, 0.9));
    assert!(of("low_95") < of("target_low") && of("low_95") < of("median") && of("median") < of("high_95"), "{at}");
    assert!(told.contains("95 % of samples  model alone") && told.contains("0.860 to 0.900"), "{told}");

    // What limits it, the most first: none makes it less likely to be known exactly, and what is known to more moves the ratio.
    let limits = found["limited_by"].as_array().unwrap();
    let known: Vec<f64> = limits.iter().map(|limit| number(&limit["chance_if_known"])).collect();
    assert!(known.windows(2).all(|pair| pair[0] >= pair[1]) && known.iter().all(|known| *known >= chance), "{known:?}");
    let limit = |input: &str| limits.iter().find(|limit| limit["input"] == input).unwrap();
    assert_eq!(limit("model error")["known_to"], "no trial yet");
    assert_eq!(
        (&limit("Young's modulus")["known_to"], &limit("width")["known_to"]),
        (&"known to 21 %".into(), &"made to 6 um".into())
    );
    assert!(limits.iter().all(|limit| number(&limit["std"][0]) > 0.0), "{limits:?}");
    assert!(told.contains("limited mostly by model error (no trial yet): without it, "), "{told}");
    // A texture made to 6 um scatters by six times what its median changes along a micrometre, and by what the model lacks more or less of there.
    let slopes = found["slopes"].as_array().unwrap();
    let slope = slopes.iter().find(|slope| slope["dimension"] == "width_um").unwrap();
    let expected = 6.0 * number(&slope["per_um"][0]).abs();
    let of = |input: &str| number(&limit(input)["std"][0]);
    // The form of what is lacking goes with at most the width: 6 um are a share of it.
    let share = 6.0 / number(&found["design"]["width_um"]);
    let most = expected.hypot(share * of("model error"));
    assert!((0.9 * expected..1.1 * most).contains(&of("width")), "{slope} {most} {}", limit("width"));

    let page = place.read("out/a/report.html");
    let at = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what}"));
    assert!(at("chance that a cut sample is on target") < at("95 % of samples"));
    assert!(page.contains("explorer-data"));
    assert!(at("95 % of samples") < at("Limited mostly by model error"));
    assert!(at("Limited mostly by model error") < at("What to cut") && at("What to cut") < at("What limits it"));
    // Bars stand in the order of the record, which begins with the input that the headline names.
    let bars = &page[at("What limits it")..];
    let names = limits.iter().map(|limit| format!("<span>{}<small>", limit["input"].as_str().unwrap()));
    let places: Vec<usize> = names.filter_map(|name| bars.find(&name)).collect();
    assert!(places.len() > 1 && places.is_sorted(), "{places:?}");
}

/// A target from `low_95` to `high_95` has a chance of 95 %, and a target below the median a chance of one half.
#[test]
fn the_chance_is_the_share_of_the_samples_that_are_expected() {
    let place = Place::with(&[]);
    let of = |target: &str| {
        place.write("a.toml", trusted(&fixed(target, TOLERANCES)));
        place.json(&["optimize", "a.toml", "--json"])
    };
    let found = of("value = 0.88\ntolerance = 0.02");
    let [low, median, high] = ["low_95", "median", "high_95"].map(|key| number(&found["expected"][0][key]));
    for (target, share) in [
        (format!("lowest = {low}\nhighest = {high}"), 0.95),
        (format!("highest = {median}"), 0.5),
        (format!("lowest = {low}\nhighest = {median}"), 0.475),
    ] {
        let found = of(&target);
        assert!((number(&found["chance"]) - share).abs() < 0.005, "{target}: {}", found["chance"]);
        assert_eq!(number(&found["expected"][0]["median"]), median);
    }
}

/// Contributions of the inputs add up to the scatter of samples. The chosen designs hardly depend on the modulus to
/// first order, so that the second order dominates and is listed.
#[test]
fn the_limits_are_all_that_scatters_samples() {
    let text =
        free(&trusted(&design("value = 0.88\ntolerance = 0.02", TOLERANCES))).replace("density_g_cm3 = 0.9\n", MODULUS);
    let place = Place::with(&[("a.toml", &text)]);
    let (_, found) = optimized(&place, "a.toml", 0);
    let limits = found["limited_by"].as_array().unwrap();
    let sum = limits.iter().map(|limit| number(&limit["std"][0]).powi(2)).sum::<f64>().sqrt();
    let [low, high] = ["low_95", "high_95"].map(|key| number(&found["expected"][0][key]));
    assert!(((high - low) / (2.0 * 1.96) / sum - 1.0).abs() < 0.1, "{low} {high} {limits:?}");
    let first = &limits[0];
    assert!(first["input"] == "Young's modulus" && number(&first["chance_if_known"]) > 1.5 * number(&found["chance"]));
}

#[test]
fn a_target_above_the_flat_surface_is_not_answered_by_a_pattern() {
    let even = design("goal = \"even\"", "").replace("[2.6]", "[1.3, 2.6]");
    let place = Place::with(&[
        ("above.toml", &design("value = 1.2\ntolerance = 0.03", "")),
        ("highest.toml", &design("goal = \"highest\"", "")),
        ("even.toml", &even),
        ("beside.toml", &design("goal = \"highest\"\nhighest = 0.93", "")),
        ("flat.toml", &design("lowest = 0.95\nhighest = 1.05", "")),
    ]);
    // Before any trial only a trial says how far the model is off.
    let (told, found) = optimized(&place, "above.toml", 0);
    assert!(told.contains("no texture is expected to lie within it, but before any trial"), "{told}");
    assert_eq!(found["advice"], "trial");
    // Ratios of the flat surface are even by nature.
    for file in ["highest.toml", "flat.toml", "even.toml"] {
        let (told, found) = optimized(&place, file, 3);
        assert!(told.contains("do not texture: the flat surface is what is asked for"), "{told}");
        assert_eq!(found["advice"], "do_not_texture", "{file}");
        assert_eq!(place.run(&["next", file]).status.code(), Some(3), "{file}");
    }
    let page = place.read("out/highest/report.html");
    assert!(page.contains("Do not texture: the flat surface is what is asked for"));
    // The flat surface does not do what is demanded beside the goal.
    let (_, found) = optimized(&place, "beside.toml", 0);
    assert_eq!((&found["advice"], &found["goal"]["goal"]), (&"trial".into(), &"highest".into()));
    assert!(number(&found["expected"][0]["median"]) <= 0.93 && number(&found["chance"]) >= 0.5, "{found}");
}
