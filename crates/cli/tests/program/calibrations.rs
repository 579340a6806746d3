//! Calibrations and traces: unusable input is refused at once with its name, unusual input is warned of once.

use std::fmt::Write as _;
use std::fs;

use crate::common::{CALIBRATION, FLAT, Place};
use slipgrid_io::formats::Document;
use slipgrid_io::formats::calibration::Calibration;

const FLAGS: [&str; 8] =
    ["--effective-radius-mm", "40", "--force-n", "50", "--speed-mm-s", "2", "--humidity-pct", "15"];

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

fn rise(t: f64) -> f64 {
    1.0 - (-t / 0.1).exp()
}

fn run_in(t: f64) -> f64 {
    rise(t) * (0.25 + 0.05 * (-t / 4.0).exp())
}

fn traces<'a>(files: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [&["traces"], files, &FLAGS, more].concat()
}

#[test]
fn a_table_says_what_sampling_may_have_missed_of_a_static_peak() {
    let place = Place::with(&[
        ("run-in.csv", &trace(1, run_in)),
        ("peak.csv", &trace(2, |t| run_in(t) + if (0.38..0.42).contains(&t) { 0.08 } else { 0.0 })),
    ]);
    place.succeed(&traces(&["peak.csv"], &["-o", "sharp"]));
    let row = place.read("sharp/flat.csv");
    assert!(
        row.contains(": mu_static_std is ") && row.contains(", what sampling may have missed of the peak\n"),
        "{row}"
    );
    assert!(!row.lines().last().unwrap().ends_with(",,"), "{row}");
    // Neither run-in nor what is not sought is a peak.
    for (file, flag) in [("run-in.csv", &[][..]), ("peak.csv", &["--no-static-peak"])] {
        let told = place.succeed(&traces(&[file], &[&["-o", "none"], flag].concat()));
        assert_eq!(told.contains("run-in, no static peak"), flag.is_empty(), "{told}");
        let row = place.read("none/flat.csv");
        assert!(row.lines().last().unwrap().ends_with(",,"), "{row}");
    }
}

#[test]
fn a_sample_that_slides_back_and_forth_is_read_by_its_strokes() {
    // A crank at 1 Hz: friction has turned 0.05 s after each dead centre; the sensor shows 0.02 too much.
    let of = |mu: f64, t: f64| mu * (20.0 * (std::f64::consts::TAU * t).sin()).clamp(-1.0, 1.0) + 0.02;
    let friction = |t: f64| of(0.25, t);
    let coefficients: String = trace(5, friction)
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let ratio =
                cells[1].parse::<f64>().map_or("\u{b5} [-]".to_owned(), |torque| format!("{:.6}", torque / 2.0));
            format!("{};{ratio}\n", cells[0])
        })
        .collect();
    let place = Place::with(&[
        ("crank.csv", &trace(5, friction)),
        ("crank-2.csv", &trace(6, |t| of(0.252, t))),
        ("cof.csv", &coefficients),
    ]);
    let of_first = |told: &str, file: &str| -> f64 {
        let row = told.lines().find(|line| line.trim_start().starts_with(file)).unwrap();
        row.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let told = place.succeed(&traces(&["crank.csv"], &["--reciprocating", "-o", "crank"]));
    assert!((of_first(&told, "crank.csv") - 0.25).abs() < 2e-4, "{told}");
    assert!(told.contains("differ by an offset of +0.0200, 8 % of friction"), "{told}");
    let cof = place.succeed(&traces(&["cof.csv"], &["--reciprocating"]));
    assert!((of_first(&cof, "cof.csv") - of_first(&told, "crank.csv")).abs() < 2e-4, "{cof}");
    assert!(cof.contains("no normal force is recorded"), "{cof}");
    // The same from a calibration, with another part of the strokes; the part alone is refused.
    let (head, _) = CALIBRATION.split_once("[measurements]").unwrap();
    let condition =
        "[[traces.condition]]\nforce_n = 50.0\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\nfiles = [\"crank*.csv\"]\n";
    let text = |keys: &str| format!("{head}[traces]\neffective_radius_mm = 40.0\n{keys}{condition}");
    place.write("c.toml", text("reciprocating = true\nstroke_share = 0.7\n"));
    let told = place.succeed(&["traces", "c.toml"]);
    assert!((of_first(&told, "crank.csv") - 0.25).abs() < 2e-4, "{told}");
    let refused = place.refuse(&["traces", "c.toml", "--window-s", "-1,2"]);
    assert!(refused.contains("--window-s: is a flag for exports"), "{refused}");
    let refused = place.refuse(&traces(&["crank.csv"], &["--reciprocating", "--window-s", "10,60"]));
    assert!(refused.contains("or another window, window_s in [traces] or --window-s"), "{refused}");
    for (keys, says) in [
        ("stroke_share = 0.7\n", "stroke_share: 0.7 needs `reciprocating = true`"),
        ("reciprocating = true\nstroke_share = 1.5\n", "expected a number above 0 up to 1"),
    ] {
        place.write("c.toml", text(keys));
        let refused = place.refuse(&["traces", "c.toml"]);
        assert!(refused.contains(says), "{refused}");
    }
}

#[test]
fn conditions_and_trials_have_traces_of_their_own() {
    let turning = |t: f64| 0.24 * (20.0 * (std::f64::consts::TAU * t).sin()).clamp(-1.0, 1.0);
    let names = ["a-1", "a-2", "back-1", "back-2", "cut-1", "cut-2", "cut-back-1", "cut-back-2"];
    let mut place = Vec::new();
    for (name, seed) in names.into_iter().zip(1..) {
        let factor = if name.starts_with("cut") { 0.8 } else { 1.0 } * (1.0 + 0.002 * f64::from(seed % 2));
        let shape = move |t: f64| factor * if name.contains("back") { turning(t) } else { 0.25 * rise(t) };
        place.push((format!("{name}.csv"), trace(seed, shape)));
    }
    let place: Vec<(&str, &str)> = place.iter().map(|(name, text)| (&name[..], &text[..])).collect();
    let place = Place::with(&place);
    let (head, tail) = CALIBRATION.split_once("[measurements]\nflat = \"flat.csv\"\n").unwrap();
    let condition = |table: &str, speed: &str, files: &str, more: &str| {
        format!("[[{table}]]\nforce_n = 50.0\nspeed_mm_s = {speed}\nhumidity_pct = 15.0\nfiles = [\"{files}\"]\n{more}")
    };
    let back = "reciprocating = true\nwindow_s = [5.0, 44.0]\n";
    let flat = condition("traces.condition", "2.0", "a-*.csv", "")
        + &condition("traces.condition", "10.0", "back-*.csv", back);
    let pattern = "[trial.pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let cut = condition("trial.traces", "2.0", "cut-?.csv", "").replace("cut-?.csv", "cut-1.csv\", \"cut-2.csv")
        + &condition("trial.traces", "10.0", "cut-back-*.csv", back);
    let trial = |more: &str| format!("[[trial]]\nname = \"pilot\"\n{more}{pattern}{cut}");
    let text = |more: &str| format!("{head}[traces]\neffective_radius_mm = 40.0\n{flat}{tail}{}", trial(more));
    place.write("c.toml", text(""));
    let told = place.succeed(&["traces", "c.toml", "-o", "out"]);
    assert!(told.contains("trial \"pilot\", 50 N, 10 mm/s") && told.contains("flat sample, 50 N, 10 mm/s"), "{told}");
    let flat_rows = place.read("out/flat.csv");
    let cut_rows = place.read("out/trial-1-measured.csv");
    let drawn = place.read("out/trial-1-50N-10mm_s-15pct.svg");
    assert!(drawn.contains("\nFriction in time: trial &quot;pilot&quot;, 50 N, 10 mm/s, 15 % humidity\n"));
    assert!(!place.path("out/patterned.csv").exists());
    let friction = |rows: &str| -> Vec<f64> {
        rows.lines().skip(2).map(|row| row.split(',').nth(3).unwrap().parse().unwrap()).collect()
    };
    for (flat, cut) in friction(&flat_rows).into_iter().zip(friction(&cut_rows)) {
        assert!((cut / flat - 0.8).abs() < 0.002, "{flat_rows}{cut_rows}");
    }
    let read = |text: String| {
        place.write("c.toml", text);
        Calibration::read(&slipgrid_io::disk::disk(), &place.path("c.toml"))
    };
    let own = read(text("")).unwrap();
    let windows: Vec<f64> = own.traces.iter().map(|traces| traces.condition.window_s[0]).collect();
    assert_eq!(windows, [10.0, 5.0, 10.0, 5.0]);
    // The tables that were written say the same.
    let tables = format!(
        "{head}[measurements]\nflat = \"out/flat.csv\"\n{tail}[[trial]]\nname = \"pilot\"\nmeasurements = \"out/trial-1-measured.csv\"\n{pattern}"
    );
    let tables = read(tables).unwrap();
    assert_eq!((own.stated.trials.samples.len(), own.stated.trials.samples[0].measured.len()), (1, 2));
    for (own, table) in own.stated.trials.samples[0].measured.iter().zip(&tables.stated.trials.samples[0].measured) {
        assert!((own.mu_dynamic - table.mu_dynamic).abs() < 1e-6 && own.speed_m_s == table.speed_m_s);
    }
    // A table [traces] without conditions says how those of a trial are read.
    let setup = format!(
        "{head}[measurements]\nflat = \"out/flat.csv\"\n[traces]\neffective_radius_mm = 40.0\n{tail}{}",
        trial("")
    );
    assert_eq!(read(setup.clone()).unwrap().stated.trials, own.stated.trials);
    // A share of strokes is that of a trial that alone turns.
    let share = setup.replace("radius_mm = 40.0\n", "radius_mm = 40.0\nstroke_share = 0.4\n");
    assert_eq!(read(share).unwrap().traces[1].condition.stroke_share, Some(0.4));
    // One table a repeat is one condition with its repeats; one read over two windows is no two ratios.
    let each = |more: &str| {
        condition("trial.traces", "2.0", "cut-1.csv", "") + &condition("trial.traces", "2.0", "cut-2.csv", more)
    };
    let split =
        |more: &str| text("").replace(&condition("trial.traces", "2.0", "cut-1.csv\", \"cut-2.csv", ""), &each(more));
    assert_ne!(split(""), text(""));
    assert_eq!(read(split("")).unwrap().stated.trials, own.stated.trials);
    let flats = text("").replace("files = [\"a-*.csv\"]", "files = [\"a-1.csv\"]")
        + "[[traces.condition]]\nforce_n = 50.0\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\nfiles = [\"a-2.csv\"]\n";
    assert_eq!(read(flats).unwrap().stated.flat[0], own.stated.flat[0]);
    let two = condition("traces.condition", "2.0", "a-1.csv\", \"cut-1.csv", "")
        + &condition("traces.condition", "2.0", "a-2.csv\", \"cut-2.csv", "window_s = [20.0, 40.0]\n");
    let windows = format!("{head}[traces]\neffective_radius_mm = 40.0\n{two}{tail}").replace("per-condition", "single");
    read(windows).unwrap();
    place.succeed(&["traces", "c.toml", "-o", "twice"]);
    assert!(place.path("twice/flat-50N-2mm_s-15pct-2.svg").is_file());
    for (text, says) in [
        (
            text("measurements = \"out/trial-1-measured.csv\"\n"),
            "stands beside measurements; expected either measurements or [[trial.traces]]",
        ),
        (
            text("").replace("files = [\"cut-1.csv\"", "surface = \"flat\"\nfiles = [\"cut-1.csv\""),
            "is not the surface of a trial",
        ),
        (text("").replace("cut-1.csv", "a-1.csv"), "a-1.csv once more"),
        (
            text("").replace("cut-back-*.csv\"]\nreciprocating = true", "cut-back-*.csv\"]\nstroke_share = 0.5"),
            "needs `reciprocating = true`",
        ),
        (setup.replace(&cut, ""), "traces.condition: is missing"),
        (split("window_s = [20.0, 40.0]\n"), "has 50 N, 2 mm/s, 15 % again"),
    ] {
        let refused = read(text.clone()).unwrap_err().to_string();
        assert!(refused.contains(says), "{refused}\n{text}");
    }
}

#[test]
fn one_export_named_twice_in_a_calibration_is_refused() {
    let place = Place::with(&[("a-1.csv", &trace(1, |t| 0.25 * rise(t)))]);
    let (head, _) = CALIBRATION.split_once("[measurements]").unwrap();
    let condition = "[[traces.condition]]\nforce_n = 50.0\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\n";
    let text = format!("{head}[traces]\neffective_radius_mm = 40.0\n{condition}files = [\"a-1.csv\", \"a-*.csv\"]\n");
    place.write("c.toml", &text);
    let message = place.refuse(&["traces", "c.toml"]);
    assert!(message.contains("c.toml:17: traces.condition.files") && message.contains("as line 17 does"), "{message}");
    place.write("c.toml", text.replace("\"a-1.csv\", ", ""));
    place.succeed(&["traces", "c.toml"]);
    fs::create_dir(place.path("exports")).unwrap();
    place.write("c.toml", text.replace("\"a-1.csv\", \"a-*.csv\"", "\"exports\""));
    let message = place.refuse(&["traces", "c.toml"]);
    assert!(message.contains("traces.condition.files: \"exports\" is a folder"), "{message}");
    let off = text.replace("\"a-1.csv\", ", "").replace("[traces]\n", "[traces]\nstatic_peak = false\n");
    place.write("c.toml", off);
    place.succeed(&["traces", "c.toml"]);
}

#[test]
fn a_table_of_too_many_conditions_is_refused() {
    let header = FLAT.lines().next().unwrap();
    let rows: String = (1..=300).map(|i| format!("{i},2,15,0.248,0.002\n")).collect();
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", &format!("{header}\n{rows}"))]);
    let message = place.refuse(&["calibrate", "c.toml", "-q"]);
    assert!(message.contains("c.toml: 300 coefficients are to be fitted; expected fewer conditions"), "{message}");
}

#[test]
fn windows_that_a_map_does_not_hold_are_refused_in_the_file_that_asks_for_them() {
    let map = "map = \"map.asc\"\nwindows = 200";
    let place = Place::with(&[("c.toml", &CALIBRATION.replace("persson_rms_slope = 0.0137", map)), ("flat.csv", FLAT)]);
    place.succeed(&["synthesize", "--pixels", "256", "-o", "map.asc"]);
    let message = place.refuse(&["calibrate", "c.toml", "-q"]);
    assert!(message.starts_with("error: c.toml: surface.windows: number of windows per side is 200"), "{message}");
}

#[test]
fn pressure_follows_from_the_area_of_every_shape_of_specimen() {
    let place = Place::with(&[("flat.csv", FLAT)]);
    let read = |keys: &str| {
        let text = CALIBRATION.replace("radius_mm = 5.0", keys);
        Calibration::from_document(&Document::within(&slipgrid_io::disk::disk(), place.path("c.toml"), text)).unwrap()
    };
    let quarter_pi = std::f64::consts::FRAC_PI_4;
    for (keys, area_mm2) in [
        ("radius_mm = 5.0", quarter_pi * 100.0),
        ("diameter_mm = 10.0", quarter_pi * 100.0),
        ("outer_diameter_mm = 30.0\ninner_diameter_mm = 20.0", quarter_pi * 500.0),
        ("shape = \"ring\"\nouter_diameter_mm = 30.0\ninner_diameter_mm = 20.0", quarter_pi * 500.0),
        ("shape = \"rectangle\"\nlength_mm = 10.0\nwidth_mm = 4.0", 40.0),
    ] {
        let found = read(keys);
        // 50 N in MPa are 50 N/mm2 over the area.
        assert!((found.pressure_pa(50.0) / (50e6 / area_mm2) - 1.0).abs() < 1e-12, "{keys}");
    }
}
