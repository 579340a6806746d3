//! Repeats of one condition that differ, and columns with custom titles.

use std::fmt::Write as _;
use std::fs;

use crate::common::{CALIBRATION, Place};

const FLAGS: [&str; 6] = ["--force-n", "60", "--speed-mm-s", "2", "--humidity-pct", "45"];

/// Header of an export: time in seconds, position in millimetres, friction force and normal force in newtons.
const HEADER: &str = "t [s];x [mm];Reibkraft [N];Normalkraft [N]\n";

/// Export of 45 s in one direction at 2 mm/s under 60 N with friction `mu`; the ripple depends on the seed.
fn run(header: &str, seed: u32, mu: f64) -> String {
    let mut text = header.to_owned();
    for i in 0..=900 {
        let t = 0.05 * f64::from(i);
        let ripple = 1e-4 * (1.7 * f64::from(i * (seed + 3))).sin();
        writeln!(text, "{t:.3};{:.4};{:.5};60.0", 2.0 * t, (mu + ripple) * 60.0).unwrap();
    }
    text
}

/// Calibration with `keys` in `[traces]` and `condition` in its only condition.
fn calibration(keys: &str, condition: &str) -> String {
    let (head, _) = CALIBRATION.split_once("[measurements]").unwrap();
    format!(
        "{head}[traces]\n{keys}[[traces.condition]]\nforce_n = 60.0\nspeed_mm_s = 2.0\nhumidity_pct = 45.0\nfiles = [\"sp-*.txt\"]\n{condition}"
    )
}

#[test]
fn a_spoilt_repeat_is_named_everywhere_and_can_be_left_out() {
    let place = Place::with(&[
        ("sp-1.txt", &run(HEADER, 1, 0.305)),
        ("sp-2.txt", &run(HEADER, 2, 0.308)),
        ("sp-3.txt", &run(HEADER, 3, 0.416)),
        ("c.toml", &calibration("", "")),
    ]);
    let says = "sp-3.txt: mu 0.4160 is 36 % above the mean 0.3065 of the other repeats, which differ by 1.0 %: it may be spoilt";
    let named = place.succeed(&[&["traces", "sp-1.txt", "sp-2.txt", "sp-3.txt"], &FLAGS[..]].concat());
    assert!(named.contains(says) && named.contains("`exclude = [\"sp-3.txt\"]`"), "{named}");
    let told = place.succeed(&["traces", "c.toml", "-o", "out"]);
    assert!(told.contains(says) && told.contains("mean of 3"), "{told}");
    assert!(fs::read_to_string(place.path("out/traces.csv")).unwrap().contains("it may be spoilt"));
    let fitted = place.succeed(&["calibrate", "c.toml", "-o", "m.toml", "--report", "fit"]);
    assert!(fitted.contains(says), "{fitted}");
    for file in ["m.toml", "fit/report.html"] {
        assert!(fs::read_to_string(place.path(file)).unwrap().contains("36 % above the mean 0.3065"), "{file}");
    }
    // What the message proposes leaves it out, and is told.
    fs::write(place.path("c.toml"), calibration("", "exclude = [\"sp-3.txt\"]\n")).unwrap();
    let told = place.succeed(&["traces", "c.toml"]);
    assert!(told.contains("mean of 2  0.3065") && told.contains("sp-3.txt left out by `exclude`"), "{told}");
    assert!(!told.contains("spoilt"), "{told}");
    let pair = place.succeed(&[&["traces", "sp-1.txt", "sp-3.txt"], &FLAGS[..]].concat());
    assert!(pair.contains("36 % above the 0.3050 of sp-1.txt: one of the two may be spoilt"), "{pair}");
}

#[test]
fn a_stated_speed_that_the_position_does_not_have_is_told() {
    let bare = run(HEADER, 1, 0.305).replace("x [mm]", "x");
    let place = Place::with(&[("sp-1.txt", &run(HEADER, 1, 0.305)), ("bare.txt", &bare)]);
    let told = |file: &str, speed: &str| {
        place.succeed(&["traces", file, "--force-n", "60", "--speed-mm-s", speed, "--humidity-pct", "45"])
    };
    let fast = told("sp-1.txt", "50");
    assert!(fast.contains("position moves at 2.000 mm/s in the window, not at the nominal 50"), "{fast}");
    for (file, speed) in [("sp-1.txt", "2"), ("sp-1.txt", "2.3"), ("bare.txt", "50")] {
        let told = told(file, speed);
        assert!(!told.contains("position"), "{told}");
    }
}

/// Export of a run under `force_n` that starts with the head unloaded; its friction and normal force are 0.3 N and 2.4
/// N too high.
fn with_offset(seed: u32, force_n: f64) -> String {
    let mut text = HEADER.to_owned();
    for i in 0..=900 {
        let t = 0.05 * f64::from(i);
        let load = force_n * (t - 4.0).clamp(0.0, 1.0);
        let ripple = 1e-4 * (1.7 * f64::from(i * (seed + 3))).sin();
        writeln!(text, "{t:.3};{:.4};{:.5};{:.5}", 2.0 * t, (0.25 + ripple) * load + 0.3, load + 2.4 + ripple).unwrap();
    }
    text
}

#[test]
fn an_offset_before_touchdown_is_told_at_all_forces_and_zero_s_removes_it() {
    let (head, _) = CALIBRATION.split_once("[measurements]").unwrap();
    let condition = |force: f64, more: &str| {
        format!(
            "[[traces.condition]]\nforce_n = {force:.1}\nspeed_mm_s = 2.0\nhumidity_pct = 45.0\nfiles = [\"z-{force}.txt\"]\n{more}"
        )
    };
    let text = |keys: &str, more: &str| {
        format!("{head}[traces]\n{keys}{}{}{}", condition(60.0, more), condition(150.0, ""), condition(600.0, ""))
    };
    let place = Place::with(&[
        ("z-60.txt", &with_offset(1, 60.0)),
        ("z-150.txt", &with_offset(2, 150.0)),
        ("z-600.txt", &with_offset(3, 600.0)),
        ("c.toml", &text("", "")),
    ]);
    let told = place.succeed(&["traces", "c.toml"]);
    let says = "before touchdown, up to 2.20 s, the normal force 2.400 N and the friction force 0.3000 N are read";
    assert!(told.contains("3 of 3 traces, the first of them") && told.contains(says), "{told}");
    assert!(told.contains("`zero_s = [0, 2.20]` in [traces] or --zero-s subtracts it"), "{told}");
    // Nothing tells how far another sample may be.
    let calibrated = place.succeed(&["calibrate", "c.toml", "-o", "m.toml"]);
    let once = "errors of friction: 3 of 3 conditions were measured once, and no other was repeated";
    assert!(calibrated.contains(&format!("! {once}")), "{calibrated}");
    assert!(fs::read_to_string(place.path("m.toml")).unwrap().contains(once));
    // (0.25 60 + 0.3) / 62.4
    assert!(told.contains("mean of 1  0.2452") && !told.contains("0.2500"), "{told}");
    for (keys, more) in [("zero_s = [0.0, 2.2]\n", ""), ("zero_s = [0.5, 3.0]\n", "zero_s = [0.0, 3.5]\n")] {
        fs::write(place.path("c.toml"), text(keys, more)).unwrap();
        let told = place.succeed(&["traces", "c.toml"]);
        assert_eq!(told.matches("mean of 1  0.2500").count(), 3, "{told}");
        assert!(told.contains("were subtracted as the sensors' zero") && !told.contains("before touchdown"), "{told}");
    }
    let by_flag = place.succeed(&[&["traces", "z-60.txt", "--zero-s", "0,3"], &FLAGS[..]].concat());
    assert!(by_flag.contains("mean of 1  0.2500"), "{by_flag}");
}
