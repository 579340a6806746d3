//! Long computations: their duration is announced before, reported afterwards, and limited.

use crate::common::{DESIGN, Place, at, discs, json};

#[test]
fn the_stages_of_a_design_sum_to_its_duration() {
    let place = Place::with(&[("discs.toml", &discs())]);
    let told = place.succeed("optimize discs.toml -o out --details");
    let times = json(&place.read("out/timings.json"));
    let timings = times["timings_s"].as_object().unwrap();
    let sum: f64 = timings.values().map(|seconds| seconds.as_f64().unwrap()).sum();
    let wall_s = at(&times, "/wall_s");
    assert!((sum - wall_s).abs() < 1e-6 * wall_s, "{sum} of {wall_s} s: {timings:?}");
    assert!(timings.values().all(|seconds| seconds.as_f64() >= Some(0.0)), "{timings:?}");
    // What is said on one line sums to the same, but for rounding.
    let line = told.lines().find(|line| line.contains(" designs compared by a table of ")).unwrap();
    let words: Vec<&str> = line.split([' ', ',', ';']).collect();
    let said_s: f64 = words.windows(2).filter(|pair| pair[1] == "s").map(|pair| pair[0].parse::<f64>().unwrap()).sum();
    assert!((said_s - sum).abs() < 0.6, "{line}: {sum}");
}

#[test]
fn seconds_hold_for_all_stages() {
    let timed = |text: &str, seconds: &str| text.replace("seed = 1", &format!("seed = 1\nmax_seconds = {seconds}"));
    // No machine tabulates such a layer so soon.
    let fine = DESIGN.replace("block_um = 10.0", "block_um = 2.5");
    let place = Place::with(&[("none.toml", &timed(&discs(), "0")), ("few.toml", &timed(&fine, "1.5"))]);
    for line in ["optimize none.toml -o out", "optimize few.toml -o out", "next none.toml -o out"] {
        let said = place.ends(line, 4).1;
        // Another test may have tabulated the designs.
        assert!(said.contains("error: max_seconds was spent before"), "{said}");
        assert!(!place.path("out").exists());
    }
}
