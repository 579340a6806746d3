//! Traces in a calibration: a repeat that differs, titles of one's own, and a zero of the sensors. `tests/golden` keeps
//! what is said of odd traces.

use std::fmt::Write as _;

use crate::common::{CALIBRATION, Place};

/// Export of 45 s in one direction at 2 mm/s with the friction force and normal force of `forces`, from a time and a
/// ripple that depends on the seed.
fn export(seed: u32, forces: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let mut text = "t [s];x [mm];F_tan [N];F_norm [N]\n".to_owned();
    for i in 0..=900 {
        let t = 0.05 * f64::from(i);
        let [friction_n, normal_n] = forces(t, 1e-4 * (1.7 * f64::from(i * (seed + 3))).sin());
        writeln!(text, "{t:.3};{:.4};{friction_n:.5};{normal_n:.5}", 2.0 * t).unwrap();
    }
    text
}

/// Calibration with `keys` in `[traces]` and conditions of a force, its files and further lines.
fn calibration(keys: &str, conditions: &[(f64, &str, &str)]) -> String {
    let (head, _) = CALIBRATION.split_once("[measurements]").unwrap();
    let columns = "columns = { friction_force = \"F_tan\", normal_force = \"F_norm\" }\n";
    let condition = |(force_n, files, more): &(f64, &str, &str)| {
        format!(
            "[[traces.condition]]\nforce_n = {force_n:.1}\nspeed_mm_s = 2.0\nhumidity_pct = 45.0\nfiles = [\"{files}\"]\n{more}"
        )
    };
    format!("{head}[traces]\n{columns}{keys}{}", conditions.iter().map(condition).collect::<String>())
}

#[test]
fn a_spoilt_repeat_is_named_everywhere_and_can_be_left_out() {
    let run = |seed: u32, mu: f64| export(seed, |_, ripple| [(mu + ripple) * 60.0, 60.0]);
    let with = |exclude: &str| calibration("", &[(60.0, "sp-*.txt", exclude)]);
    let place = Place::with(&[
        ("sp-1.txt", &run(1, 0.305)),
        ("sp-2.txt", &run(2, 0.308)),
        ("sp-3.txt", &run(3, 0.416)),
        ("c.toml", &with("")),
        ("left-out.toml", &with("exclude = [\"sp-3.txt\"]\n")),
        ("absent.toml", &with("exclude = [\"sp-4.txt\"]\n")),
        ("all.toml", &with("exclude = [\"sp-*.txt\"]\n")),
    ]);
    let says = "sp-3.txt: mu 0.4160 is 36 % above the mean 0.3065 of the other repeats";
    assert!(place.succeed("traces c.toml -o out").contains(says));
    assert!(place.succeed("calibrate c.toml -o m.toml --report fit --details").contains(says));
    for file in ["out/traces.csv", "m.toml", "fit/report.html"] {
        assert!(place.read(file).contains("36 % above the mean 0.3065"), "{file}");
    }
    let told = place.succeed("traces left-out.toml");
    assert!(told.contains("mean of 2  0.3065") && !told.contains("36 % above"), "{told}");
    // Titles that are not known are shown with the key that gives them.
    place.refuse_all(
        "traces absent.toml => \"sp-4.txt\" leaves out none of the files
         traces all.toml => is left out as a whole
         traces sp-1.txt --force-n 60 --speed-mm-s 2 --humidity-pct 45 => columns = { friction_force = \"...\"",
    );
}

#[test]
fn a_zero_of_the_sensors_is_subtracted_at_all_forces() {
    // The head is unloaded for 4 s; its friction and normal force are 0.3 N and 2.4 N too high.
    let run = |seed: u32, force_n: f64| {
        export(seed, |t, ripple| {
            let load = force_n * (t - 4.0).clamp(0.0, 1.0);
            [(0.25 + ripple) * load + 0.3, load + 2.4 + ripple]
        })
    };
    let text = |keys: &str, more: &str| {
        calibration(keys, &[(60.0, "z-60.txt", more), (150.0, "z-150.txt", ""), (600.0, "z-600.txt", "")])
    };
    let place =
        Place::with(&[("z-60.txt", &run(1, 60.0)), ("z-150.txt", &run(2, 150.0)), ("z-600.txt", &run(3, 600.0))]);
    // (0.25 60 + 0.3) / 62.4
    for (keys, more, first, others) in [
        ("", "", "mean of 1  0.2452", 0),
        ("zero_s = [0.0, 2.2]\n", "", "mean of 1  0.2500", 3),
        ("", "zero_s = [0.0, 3.5]\n", "mean of 1  0.2500", 1),
    ] {
        place.write("c.toml", text(keys, more));
        let told = place.succeed("traces c.toml");
        assert!(told.contains(first) && told.matches("mean of 1  0.2500").count() == others, "{told}");
    }
}
