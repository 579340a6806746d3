//! Kinds of targets and limits, reasons why a target is out of reach, and studies from which a killed run is resumed.

use std::fs;
use std::time::Duration;

use crate::common::{Place, at, free, short, small, trusted};

/// Design of a short sample of several periods, which is confirmed in a second.
fn design(target: &str, limits: &str) -> String {
    short().replace("value = 0.9\ntolerance = 0.01", target).replace("max_peak_pressure_mpa = 20.0", limits)
}

#[test]
fn time_under_the_laser_can_be_limited() {
    let laser = |limits: &str| {
        let text = free(&design("goal = \"lowest\"", limits));
        text.replace("spot_um = 23.0", "spot_um = 23.0\nrepetition_hz = 1000.0\nspeed_mm_s = 10.0")
    };
    let place = Place::with(&[("slow.toml", &laser("")), ("fast.toml", &laser("max_laser_time_s = 5.0"))]);
    let [slow, fast] = ["slow", "fast"].map(|name| {
        let expected = at(&place.optimized(name, 0).1, "/goal/expected");
        (place.toml(&format!("out/{name}/process.toml"))["work"]["estimated_time_s"].as_float().unwrap(), expected)
    });
    assert!(slow.0 > 5.0 && fast.0 <= 5.0 && fast.1 > slow.1, "{slow:?} {fast:?}");
}

#[test]
fn a_killed_run_is_resumed_and_ends_with_the_same_bytes() {
    let place = Place::with(&[("a.toml", &free(&design("value = [0.95, 0.9]\ntolerance = 0.02", "")))]);
    // Answers of earlier runs would stand in no study.
    place.succeed("optimize a.toml -o whole --no-cache");
    let whole = place.untimed("whole");
    let lines = |name: &str| {
        let mut lines: Vec<String> = place.read(name).lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    // Killed as soon as something has been answered.
    let mut child = place.begin("optimize a.toml -o cut");
    let path = place.path("cut.study.jsonl");
    while !fs::metadata(&path).is_ok_and(|file| file.len() > 1000) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(100));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(lines("cut.study.jsonl").len() > 1);
    assert!(place.told("optimize a.toml -o cut --resume --no-cache").contains("took over "));
    assert!(place.untimed("cut") == whole);
    assert_eq!(lines("whole.study.jsonl"), lines("cut.study.jsonl"), "nothing is evaluated twice");

    // Another target is served by the same study, another layer is not.
    let text = place.read("a.toml");
    place.write("a.toml", text.replace("layer_um = 60.0", "layer_um = 70.0"));
    let message = place.refuse("optimize a.toml -o cut --resume");
    assert!(message.contains("cut.study.jsonl:1: is a study of another design: its `layer` is "), "{message}");
    place.write("a.toml", text.replace("0.9]", "0.91]"));
    assert!(place.told("optimize a.toml -o cut --resume").contains("took over "));
}

#[test]
fn what_keeps_a_target_out_of_reach_is_said_and_lifting_it_suffices() {
    let text = trusted(&free(&design("value = [0.9, 0.82]\ntolerance = 0.03", "min_bearing_area = 0.85")));
    let place = Place::with(&[
        ("far.toml", &text),
        ("near.toml", &text.replace("min_bearing_area = 0.85\n", "")),
        ("flat.toml", &design("lowest = 0.95\nhighest = 1.05", "")),
    ]);
    assert_eq!(place.optimized("flat", 3).1["advice"], "do_not_texture");
    place.ends("next far.toml", 3);
    let (told, found) = place.optimized("far", 3);
    let blocked = &found["blocked_by"][0];
    let what = "the limit of bearing area, 0.85";
    assert_eq!((&found["advice"], &blocked["what"]), (&"cannot_be_met".into(), &what.into()));
    assert!(blocked["is_within_reach"] == true && at(blocked, "/chance") > at(&found, "/chance"), "{blocked}");
    assert!(told.contains(what) && place.read("out/far/report.html").contains(what));
    // What is said to be within reach is; the table knows ends, tilt and time of the design itself but roughly.
    let near = at(&place.optimized("near", 0).1, "/chance");
    assert!((near - at(blocked, "/chance")).abs() < 0.06, "{near} {blocked}");
}

/// A stiff body at a light load slides in waves, in which blocks stick; the result warns that they are not resolved.
#[test]
fn sliding_that_waves_carry_is_told() {
    let text = small()
        .replace("youngs_modulus_gpa = 0.38", "youngs_modulus_gpa = 10.0")
        .replace("density_g_cm3 = 0.9", "density_g_cm3 = 2.0")
        .replace("pressure_mpa = [0.7, 1.3, 2.6, 10.0]", "pressure_mpa = [0.01, 0.03, 0.06, 1.0]")
        .replace("pressure_mpa = [0.65, 2.6]", "pressure_mpa = [0.02, 0.04]");
    let place = Place::with(&[("waves.toml", &text)]);
    let told = place.run("optimize waves.toml --details").1;
    assert!(told.lines().any(|line| line.starts_with("! ") && line.contains("sliding is unstable to waves")), "{told}");
    assert!(place.read("out/waves/result.json").contains("\"sliding_waves\""));
}
