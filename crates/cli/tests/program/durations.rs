//! Long computations: their duration is announced before, reported afterwards, and limited.

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE, json, measured, result, small};

/// Design of discs in a thin layer with a target out of reach.
fn discs() -> String {
    let asked = DESIGN.replace("value = 0.9", "value = 0.5");
    let bounded = asked.replace("\"groove\"", "\"disc\"");
    let bounded = bounded.replace("[40.0, 1000.0]", "60.0").replace("[40.0, 400.0]", "[40.0, 60.0]");
    let coarse = bounded.replace("layer_um = 200.0", "layer_um = 80.0").replace("block_um = 10.0", "block_um = 20.0");
    coarse.replace("[2.0, 50.0]", "10.4")
}

#[test]
fn the_stages_of_a_design_sum_to_its_duration() {
    let place = Place::with(&[("discs.toml", &discs())]);
    let output = place.run(&["optimize", "discs.toml", "-o", "out"]);
    let (told, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{told}{said}");
    let times = json(&place.read("out/timings.json"));
    let timings = times["timings_s"].as_object().unwrap();
    let sum: f64 = timings.values().map(|seconds| seconds.as_f64().unwrap()).sum();
    let wall_s = times["wall_s"].as_f64().unwrap();
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
    for (command, file) in [("optimize", "none.toml"), ("optimize", "few.toml"), ("next", "none.toml")] {
        let output = place.run(&[command, file, "-o", "out"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(4), "{file}: {said}");
        // Another test may have tabulated the designs.
        assert!(said.contains("error: the seconds allowed were spent before"), "{said}");
        assert!(!place.path("out").exists());
    }
}

#[test]
fn what_takes_more_than_memory_or_a_month_is_refused_by_name() {
    let sample = SCENE.replace("\"cell\"", "\"sample\"").replace("\"steady\"", "\"dynamic\"");
    let wide = SCENE.replace("spacing_um = 370.0", "spacing_um = 9000000.0");
    let warm = sample.replace("block_um = 10.0", "block_um = 1.0").replace("seed = 1", "seed = 1\nwarm_start = true");
    let long = sample
        .replace("length_um = 9960.0", "length_um = 99600.0")
        .replace("block_um = 10.0", "block_um = 1.0")
        .replace("sliding_um = 2.0", "sliding_um = 40.0");
    let fine = DESIGN.replace("block_um = 10.0", "block_um = 1.0");
    let files = [("wide.toml", wide.as_str()), ("warm.toml", &warm), ("long.toml", &long), ("design.toml", &fine)];
    let place = Place::with(&files);
    for (file, says) in [
        ("wide.toml", ["sample.block_um", "GiB"]),
        ("warm.toml", ["sample.block_um", "at most 8 GiB"]),
        ("long.toml", ["run.sliding_um", "at most 30 days"]),
    ] {
        let message = place.refuse(&["simulate", file]);
        assert!(says.iter().all(|says| message.contains(says)), "{file}: {message}");
    }
    let message = place.refuse(&["optimize", "design.toml", "-o", "out"]);
    assert!(
        message.contains("sample.block_um: 1.0 um makes confirming runs") && message.contains("8 GiB"),
        "{message}"
    );
    assert!(!place.path("out").exists() && !place.path("out.study.jsonl").exists());
    // Blocks are the design's, also those in which the samples of its calibration are modelled.
    let place = Place::with(&[("d.toml", &measured(&fine, "c.toml")), ("c.toml", CALIBRATION), ("flat.csv", FLAT)]);
    for command in ["optimize", "next", "explore"] {
        let message = place.refuse(&[command, "d.toml"]);
        let says = "sample.block_um: 1.0 um makes samples of the calibration that take about 12 GiB of memory";
        assert!(message.contains("error: d.toml:") && message.contains(says), "{message}");
    }
}

#[test]
fn a_bound_without_brackets_fixes_a_dimension() {
    let place = Place::with(&[("fixed.toml", &small())]);
    place.run(&["optimize", "fixed.toml", "-o", "out"]);
    let design = &result(&place, "out")["design"];
    assert_eq!((design["spacing_um"].as_f64(), design["depth_um"].as_f64()), (Some(60.0), Some(5.2)));
}

#[test]
fn hexagonal_discs_are_designed_and_drawn() {
    let text = discs().replace("value = 0.5", "value = 0.97\ntolerance = 0.03").replace("tolerance = 0.01\n", "");
    let text = text.replace("planform = \"disc\"", "planform = \"disc\"\narrangement = \"hexagonal\"");
    let place = Place::with(&[("hexagonal.toml", &text)]);
    let output = place.run(&["optimize", "hexagonal.toml", "-o", "out"]);
    let (told, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(matches!(output.status.code(), Some(0 | 3)), "{told}{said}");
    let found = result(&place, "out");
    assert_eq!(found["design"]["arrangement"], "hexagonal");
    // Rows lie sqrt(3)/2 of a pitch apart: centres of the file of cavities.
    let csv = place.read("out/pattern.csv");
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place_of = |name: &str| columns.iter().position(|column| column.starts_with(name)).unwrap();
    let (x, y) = (place_of("centre_x"), place_of("centre_y"));
    let centres: Vec<[f64; 2]> = lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [cells[x].parse().unwrap(), cells[y].parse().unwrap()]
        })
        .collect();
    let middle = centres.iter().copied().min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1]))).unwrap();
    let mut away: Vec<f64> = centres.iter().map(|c| (c[0] - middle[0]).hypot(c[1] - middle[1])).collect();
    away.sort_by(f64::total_cmp);
    let pitch = away[1];
    assert!((2..7).all(|n| (away[n] / pitch - 1.0).abs() < 1e-3) && away[7] > 1.5 * pitch, "{:?}", &away[..8]);
}
