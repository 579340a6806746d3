//! Calibrations with traces of their own, and pressures from the shape of the specimen.

use std::fmt::Write as _;

use crate::common::{CALIBRATION, FLAT, Place};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::Document;
use slipgrid_io::formats::calibration::Calibration;

/// Trace of 45 s at 50 Hz under 50 N and 40 mm with the friction `mu` of a time; the ripple depends on the seed.
fn trace(seed: u32, mu: impl Fn(f64) -> f64) -> String {
    let mut text = "time_s,torque_nm,normal_force_n\n".to_owned();
    for i in 0..=2250 {
        let t = 0.02 * f64::from(i);
        let ripple = 1e-4 * (1.7 * f64::from(i * (seed + 3))).sin();
        writeln!(text, "{t:.3},{:.6},50.0", (mu(t) + ripple) * 50.0 * 0.04).unwrap();
    }
    text
}

/// Table of a condition read from `files` with the lines `more`.
fn condition(table: &str, speed: &str, files: &str, more: &str) -> String {
    format!("[[{table}]]\nforce_n = 50.0\nspeed_mm_s = {speed}\nhumidity_pct = 15.0\nfiles = [\"{files}\"]\n{more}")
}

#[test]
fn conditions_and_trials_have_traces_of_their_own() {
    // A crank at 1 Hz: friction has turned 0.05 s after each dead centre; the sensor shows 0.02 too much.
    let turning = |t: f64| 0.24 * (20.0 * (std::f64::consts::TAU * t).sin()).clamp(-1.0, 1.0);
    let place = Place::with(&[]);
    for (name, seed) in ["a-1", "a-2", "back-1", "back-2", "cut-1", "cut-2", "cut-back-1", "cut-back-2"].iter().zip(1..)
    {
        let factor = if name.starts_with("cut") { 0.8 } else { 1.0 } * (1.0 + 0.002 * f64::from(seed % 2));
        let is_turning = name.contains("back");
        let shape =
            |t: f64| if is_turning { factor * turning(t) + 0.02 } else { factor * 0.25 * (1.0 - (-t / 0.1).exp()) };
        place.write(&format!("{name}.csv"), trace(seed, shape));
    }
    let (head, tail) = CALIBRATION.split_once("[measurements]\nflat = \"flat.csv\"\n").unwrap();
    let back = "reciprocating = true\nwindow_s = [5.0, 44.0]\n";
    let steady = condition("traces.condition", "2.0", "a-*.csv", "");
    let flat = steady.clone() + &condition("traces.condition", "10.0", "back-*.csv", back);
    let pattern = "[trial.pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let both = condition("trial.traces", "2.0", "cut-1.csv\", \"cut-2.csv", "");
    let cut = both.clone() + &condition("trial.traces", "10.0", "cut-back-*.csv", back);
    let trial = |more: &str| format!("[[trial]]\nname = \"pilot\"\n{more}{pattern}{cut}");
    let traces = "[traces]\neffective_radius_mm = 40.0\n";
    let text = |more: &str| format!("{head}{traces}{flat}{tail}{}", trial(more));
    place.write("c.toml", text(""));
    place.succeed("traces c.toml -o out");
    assert!(place.path("out/trial-1-50N-10mm_s-15pct.svg").is_file() && !place.path("out/patterned.csv").exists());
    let friction = |file: &str| -> Vec<f64> {
        let rows = place.read(file);
        rows.lines().skip(2).map(|row| row.split(',').nth(3).unwrap().parse().unwrap()).collect()
    };
    let (of_flat, of_cut) = (friction("out/flat.csv"), friction("out/trial-1-measured.csv"));
    assert!((of_flat[0] - 0.25).abs() < 5e-4 && (of_flat[1] - 0.24).abs() < 5e-4, "{of_flat:?}");
    for (flat, cut) in of_flat.iter().zip(of_cut) {
        assert!((cut / flat - 0.8).abs() < 0.002, "{flat} {cut}");
    }
    let read = |text: &str| {
        place.write("c.toml", text);
        Calibration::read(&disk(), &place.path("c.toml"))
    };
    let own = read(&text("")).unwrap();
    let windows: Vec<f64> = own.traces.iter().map(|traces| traces.condition.window_s[0]).collect();
    assert_eq!(windows, [10.0, 5.0, 10.0, 5.0]);
    // The tables that were written say the same.
    let measured = "[measurements]\nflat = \"out/flat.csv\"\n";
    let tables = format!(
        "{head}{measured}{tail}[[trial]]\nname = \"pilot\"\nmeasurements = \"out/trial-1-measured.csv\"\n{pattern}"
    );
    let tables = read(&tables).unwrap();
    let of = |of: &Calibration| of.stated.trials.samples[0].measured.clone();
    assert_eq!((of(&own).len(), of(&tables).len()), (2, 2));
    for (own, table) in of(&own).iter().zip(of(&tables)) {
        assert!((own.mu_dynamic - table.mu_dynamic).abs() < 1e-6 && own.speed_m_s == table.speed_m_s);
    }
    // A table [traces] without conditions says how those of a trial are read.
    let setup = format!("{head}{measured}{traces}{tail}{}", trial(""));
    assert_eq!(read(&setup).unwrap().stated.trials, own.stated.trials);
    // Once the last trace is taken off, they wait for the next one.
    assert!(read(&setup.replace(&cut, "")).unwrap().traces.is_empty());
    // A share of strokes is that of a trial that alone turns.
    let share = read(&setup.replace("radius_mm = 40.0\n", "radius_mm = 40.0\nstroke_share = 0.4\n")).unwrap();
    assert_eq!(share.traces[1].condition.stroke_share, Some(0.4));
    // One table a repeat is one condition with its repeats; one read over two windows is no two ratios.
    let each = |table: &str, name: &str, more: &str| {
        condition(table, "2.0", &format!("{name}-1.csv"), "") + &condition(table, "2.0", &format!("{name}-2.csv"), more)
    };
    let split = |more: &str| text("").replace(&both, &each("trial.traces", "cut", more));
    assert_eq!(read(&split("")).unwrap().stated.trials, own.stated.trials);
    let flats = text("").replace(&steady, &each("traces.condition", "a", ""));
    assert_eq!(read(&flats).unwrap().stated.flat[0], own.stated.flat[0]);
    let twice = condition("traces.condition", "2.0", "a-1.csv\", \"cut-1.csv", "")
        + &condition("traces.condition", "2.0", "a-2.csv\", \"cut-2.csv", "window_s = [20.0, 40.0]\n");
    read(&format!("{head}{traces}{twice}{tail}").replace("per-condition", "single")).unwrap();
    place.succeed("traces c.toml -o twice");
    assert!(place.path("twice/flat-50N-2mm_s-15pct-2.svg").is_file());
    for (text, says) in [
        (text("measurements = \"out/trial-1-measured.csv\"\n"), "either measurements or [[trial.traces]]"),
        (text("").replace("files = [\"cut-1", "surface = \"flat\"\nfiles = [\"cut-1"), "is not the surface of a trial"),
        (text("").replace("cut-1.csv", "a-1.csv"), "a-1.csv once more"),
        (text("").replace("a-*.csv", "a-1.csv\", \"a-*.csv"), "traces.condition.files"),
        (text("").replace("a-*.csv", "out"), "\"out\" is a folder"),
        (split("window_s = [20.0, 40.0]\n"), "has 50 N, 2 mm/s, 15 % again"),
    ] {
        let refused = read(&text).unwrap_err().to_string();
        assert!(refused.contains(says), "{refused}\n{text}");
    }
}

#[test]
fn pressure_follows_from_the_area_of_every_shape_of_specimen() {
    let place = Place::with(&[("flat.csv", FLAT)]);
    let quarter_pi = std::f64::consts::FRAC_PI_4;
    for (keys, area_mm2) in [
        ("radius_mm = 5.0", quarter_pi * 100.0),
        ("diameter_mm = 10.0", quarter_pi * 100.0),
        ("outer_diameter_mm = 30.0\ninner_diameter_mm = 20.0", quarter_pi * 500.0),
        ("shape = \"ring\"\nouter_diameter_mm = 30.0\ninner_diameter_mm = 20.0", quarter_pi * 500.0),
        ("shape = \"rectangle\"\nlength_mm = 10.0\nwidth_mm = 4.0", 40.0),
    ] {
        let document = Document::within(&disk(), place.path("c.toml"), CALIBRATION.replace("radius_mm = 5.0", keys));
        let found = Calibration::from_document(&document).unwrap();
        // 50 N in MPa are 50 N/mm2 over the area.
        assert!((found.pressure_pa(50.0) / (50e6 / area_mm2) - 1.0).abs() < 1e-12, "{keys}");
    }
}
