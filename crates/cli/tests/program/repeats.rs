//! Repeats of one condition that differ, and columns with custom titles.

use crate::common::{CALIBRATION, Place};
use std::fmt::Write as _;

const FLAGS: [&str; 6] = ["--force-n", "60", "--speed-mm-s", "2", "--humidity-pct", "45"];

/// Header of an export: time in seconds, position in millimetres, friction force and normal force in newtons.
const HEADER: &str = "t [s];x [mm];Reibkraft [N];Normalkraft [N]\n";

/// Export of 45 s in one direction at 2 mm/s with the friction force and normal force of `forces`, from a time and a
/// ripple that depends on the seed.
fn export(header: &str, seed: u32, forces: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let mut text = header.to_owned();
    for i in 0..=900 {
        let t = 0.05 * f64::from(i);
        let [friction_n, normal_n] = forces(t, 1e-4 * (1.7 * f64::from(i * (seed + 3))).sin());
        writeln!(text, "{t:.3};{:.4};{friction_n:.5};{normal_n:.5}", 2.0 * t).unwrap();
    }
    text
}

/// Export under 60 N with friction `mu`.
fn run(header: &str, seed: u32, mu: f64) -> String {
    export(header, seed, |_, ripple| [(mu + ripple) * 60.0, 60.0])
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
    assert!(place.read("out/traces.csv").contains("it may be spoilt"));
    let fitted = place.succeed(&["calibrate", "c.toml", "-o", "m.toml", "--report", "fit"]);
    assert!(fitted.contains(says), "{fitted}");
    for file in ["m.toml", "fit/report.html"] {
        assert!(place.read(file).contains("36 % above the mean 0.3065"), "{file}");
    }
    // What the message proposes leaves it out, and is told.
    place.write("c.toml", calibration("", "exclude = [\"sp-3.txt\"]\n"));
    let told = place.succeed(&["traces", "c.toml"]);
    assert!(told.contains("mean of 2  0.3065") && told.contains("sp-3.txt left out by `exclude`"), "{told}");
    assert!(!told.contains("spoilt"), "{told}");
    for (exclude, says) in [
        ("exclude = [\"sp-4.txt\"]\n", "\"sp-4.txt\" leaves out none of the files"),
        ("exclude = [\"sp-*.txt\"]\n", "is left out as a whole"),
    ] {
        place.write("c.toml", calibration("", exclude));
        let refused = place.refuse(&["traces", "c.toml"]);
        assert!(refused.contains(says), "{refused}");
    }
    let pair = place.succeed(&[&["traces", "sp-1.txt", "sp-3.txt"], &FLAGS[..]].concat());
    assert!(pair.contains("36 % above the 0.3050 of sp-1.txt: one of the two may be spoilt"), "{pair}");
}

#[test]
fn titles_of_ones_own_are_given_in_the_calibration() {
    let header = HEADER.replace("Reibkraft", "F_tan").replace("Normalkraft", "F_norm");
    let place = Place::with(&[("sp-1.txt", &run(&header, 1, 0.304)), ("sp-2.txt", &run(&header, 2, 0.306))]);
    let refused = place.refuse(&[&["traces", "sp-1.txt"], &FLAGS[..]].concat());
    let proposed = "columns = { friction_force = \"...\", normal_force = \"...\" }";
    assert!(
        refused.contains("sp-1.txt:1: `t [s];x [mm];F_tan [N];F_norm [N]`") && refused.contains(proposed),
        "{refused}"
    );
    let columns = "columns = { friction_force = \"F_tan\", normal_force = \"F_norm\" }\n";
    place.write("c.toml", calibration(columns, ""));
    let told = place.succeed(&["traces", "c.toml"]);
    assert!(told.contains("mean of 2  0.3050"), "{told}");
    place.write("c.toml", calibration("columns = { normal_force = \"-\" }\n", ""));
    let refused = place.refuse(&["traces", "c.toml"]);
    assert!(refused.contains("normal_force: \"-\" is no title"), "{refused}");
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

#[test]
fn an_offset_of_all_traces_is_told_once() {
    // Strokes of half a second, with an offset of the sensor of 12 to 14 % of friction.
    let strokes = |seed: u32, offset: f64| {
        let mut text = "time_s,friction_force_n,normal_force_n\n".to_owned();
        for i in 0..=4500 {
            let t = 0.01 * f64::from(i);
            let side = if (2.0 * t + 1e-6).floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
            let ripple = 1e-3 * (1.7 * f64::from(i * (seed + 3))).sin();
            writeln!(text, "{t:.3},{:.5},60.0", (0.3 * (1.0 + 1e-3 * f64::from(seed)) * side + ripple + offset) * 60.0)
                .unwrap();
        }
        text
    };
    let place = Place::with(&[
        ("sp-1.txt", &strokes(1, 0.036)),
        ("sp-2.txt", &strokes(2, 0.039)),
        ("sp-3.txt", &strokes(3, 0.042)),
        ("c.toml", &calibration("reciprocating = true\n", "")),
    ]);
    for command in [&["traces", "c.toml", "-o", "out"][..], &["calibrate", "c.toml", "-o", "m.toml"]] {
        let told = place.succeed(command);
        assert!(told.contains("3 of 3 traces, the first of them flat sample, "), "{told}");
        assert_eq!(told.matches("there and back").count(), 1, "{told}");
    }
    // Each trace keeps its own in the table.
    assert_eq!(place.read("out/traces.csv").matches("there and back").count(), 3);
}

#[test]
fn a_stretch_without_numbers_is_named_with_its_column_and_times() {
    // The row of 0.05 n s is in line n + 2.
    let without = |rows: std::ops::Range<usize>, word: &str| {
        let whole = run(HEADER, 1, 0.305);
        let row = |(n, line): (usize, &str)| {
            let mut cells: Vec<&str> = line.split(';').collect();
            if rows.contains(&n) {
                cells[2] = word;
            }
            cells.join(";") + "\n"
        };
        let (header, lines) = whole.split_once('\n').unwrap();
        format!("{header}\n{}", lines.lines().enumerate().map(row).collect::<String>())
    };
    let place = Place::with(&[
        ("middle.txt", &without(400..600, "NaN")),
        ("end.txt", &without(500..901, "")),
        ("most.txt", &without(5..900, "NaN")),
        ("all.txt", &without(0..901, "---")),
        ("few.txt", &without(400..405, "NaN")),
    ]);
    let flags = |file: &'static str| [&["traces", file], &FLAGS[..]].concat();
    for (file, says) in [
        (
            "middle.txt",
            "middle.txt:402: Reibkraft [N]: 200 of 901 rows have no number from 20.00 to 29.95 s (lines 402 to 601), and friction is \
             averaged from 10 to 40 s: ",
        ),
        ("end.txt", "end.txt:502: Reibkraft [N]: 401 of 901 rows have no number from 25.00 to 45.00 s"),
        ("most.txt", "most.txt:7: Reibkraft [N]: 895 of 901 rows have no number from 0.25 to 44.95 s"),
        ("all.txt", "all.txt:2: Reibkraft [N]: none of the 901 rows below the header has a number; expected"),
    ] {
        let refused = place.refuse(&flags(file));
        assert!(refused.contains(says), "{refused}");
        assert!(!refused.contains("Time [s]") && refused.contains("; expected "), "{refused}");
    }
    let told = place.succeed(&flags("few.txt"));
    assert!(
        told.contains(
            "5 of 901 rows have no number in Reibkraft [N] from 20.00 to 20.20 s (lines 402 to 406): left out"
        ),
        "{told}"
    );
}

/// Export of a run under `force_n` that starts with the head unloaded; its friction and normal force are 0.3 N and 2.4
/// N too high.
fn with_offset(seed: u32, force_n: f64) -> String {
    export(HEADER, seed, |t, ripple| {
        let load = force_n * (t - 4.0).clamp(0.0, 1.0);
        [(0.25 + ripple) * load + 0.3, load + 2.4 + ripple]
    })
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
    assert!(place.read("m.toml").contains(once));
    // (0.25 60 + 0.3) / 62.4
    assert!(told.contains("mean of 1  0.2452") && !told.contains("0.2500"), "{told}");
    for (keys, more) in [("zero_s = [0.0, 2.2]\n", ""), ("zero_s = [0.5, 3.0]\n", "zero_s = [0.0, 3.5]\n")] {
        place.write("c.toml", text(keys, more));
        let told = place.succeed(&["traces", "c.toml"]);
        assert_eq!(told.matches("mean of 1  0.2500").count(), 3, "{told}");
        assert!(told.contains("were subtracted as the sensors' zero") && !told.contains("before touchdown"), "{told}");
    }
    let by_flag = place.succeed(&[&["traces", "z-60.txt", "--zero-s", "0,3"], &FLAGS[..]].concat());
    assert!(by_flag.contains("mean of 1  0.2500"), "{by_flag}");
    for (keys, more, says) in [
        (
            "zero_s = [2.0, 1.0]\n",
            "",
            "c.toml:12: traces.zero_s: [2.0, 1.0] is no span of time; expected two increasing times before",
        ),
        ("zero_s = [1.0]\n", "", "c.toml:12: traces.zero_s: [1.0] is no span of time"),
        ("zero_s = [0.0, nan]\n", "", "c.toml:12: traces.zero_s: nan is out of range; expected"),
        ("zero_s = [-1.0, 2.0]\n", "", "c.toml:12: traces.zero_s: -1.0 is out of range; expected"),
        (
            "zero_s = [0.0, 12.0]\n",
            "",
            "c.toml:12: traces.zero_s: [0.0, 12.0] reaches into the averaging window, which begins at 10 s; expected a span before",
        ),
        (
            "",
            "zero_s = [50.0, 60.0]\n",
            "c.toml:17: traces.condition.zero_s: [50.0, 60.0] reaches into the averaging window",
        ),
        (
            "zero_s = [0.0, 4.5]\n",
            "",
            "z-60.txt: the normal force is 11.39991 N at 4.15 s, within the zero from 0 to 4.5 s, of 62.40 N in the window: expected",
        ),
        (
            "zero_s = [0.0, 0.1]\n",
            "",
            "z-60.txt: the zero from 0 to 0.1 s holds 3 samples, one every 0.05 s: expected a zero_s",
        ),
    ] {
        place.write("c.toml", text(keys, more));
        let refused = place.refuse(&["traces", "c.toml"]);
        assert!(refused.contains(says), "{says}\n{refused}");
    }
    let refused = place.refuse(&[&["traces", "z-60.txt", "--zero-s", "3,0"], &FLAGS[..]].concat());
    assert!(refused.contains("--zero-s: 3,0 is no span of time; expected two increasing times, 0,2"), "{refused}");
}
