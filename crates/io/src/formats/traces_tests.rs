use std::path::Path;

use super::*;
use crate::formats::calibration::Calibration;
use crate::formats::source::in_memory;

/// `rows` lines at 10 Hz, each from its time and a ripple, so that no sensor is constant.
fn lines(rows: u32, line: impl Fn(f64, f64) -> String) -> String {
    let ripple = |t: f64| 1.0 + 0.01 * (7.0 * t).sin();
    (0..rows).map(|row| f64::from(row) * 0.1).map(|t| line(t, ripple(t)) + "\n").collect()
}

/// Traces of a calibration whose conditions have these speeds and keys, read from `export`.
fn read(export: &str, keys: &str, conditions: &[(u32, &str)]) -> Result<Vec<ConditionTraces>, String> {
    let condition = |(speed, own): &(u32, &str)| {
        format!(
            "[[traces.condition]]\nforce_n = 10\nspeed_mm_s = {speed}\nhumidity_pct = 50\nfiles = [\"a.csv\"]\n{own}\n"
        )
    };
    let text = format!(
        "name = \"a\"\nsource = \"test\"\n[material]\nyoungs_modulus_gpa = 2.5\ndensity_g_cm3 = 1.42\n[specimen]\nradius_mm = 1.0\n\
         [surface]\npersson_rms_slope = 0.1\n[traces]\nwindow_s = [1, 9]\n{keys}\n{}",
        conditions.iter().map(condition).collect::<String>()
    );
    let source = in_memory(&[("c.toml", text.as_bytes()), ("a.csv", export.as_bytes())]);
    Calibration::read(&source, Path::new("c.toml")).map(|read| read.traces).map_err(|refused| refused.to_string())
}

fn notes_of(export: &str, keys: &str) -> String {
    notes(&read(export, keys, &[(100, "")]).unwrap()).join("\n")
}

#[test]
fn steps_of_one_export_are_traces_of_several_conditions_or_repeats_of_one() {
    let step = |step: u32, mu: f64| lines(101, move |t, ripple| format!("{step};{t:.1};{:.4};10", 10.0 * mu * ripple));
    let export = format!("Step;Time [s];Fx [N];Fz [N]\n{}{}", step(4, 0.21), step(7, 0.23));
    let found = read(&export, "", &[(100, "step = 4"), (200, "step = 7")]).unwrap();
    let mu: Vec<f64> = found.iter().map(|traces| (1e2 * traces.mean.mu_dynamic.mean).round()).collect();
    assert_eq!(mu, [21.0, 23.0]);
    assert_eq!(found[1].traces[0].label, "a.csv, step 7");
    let repeats = read(&export, "", &[(100, "step = 4"), (100, "step = 7")]).unwrap();
    assert_eq!((repeats.len(), repeats[0].mean.count), (1, 2));
    for (conditions, says) in [
        (
            &[(100, "step = 4"), (200, "step = 4")][..],
            "c.toml:23: traces.condition.files: \"a.csv\" names a.csv once more, as line 17 does",
        ),
        (&[(100, "step = 4"), (200, "")], "names a.csv once more"),
        (&[(100, "step = 5")], "a.csv: has no step 5; expected one of its steps: 4 (from line 2), 7 (from line 103)"),
        (&[(100, "step = -1")], "c.toml:18: "),
        (&[(100, "step = 5000000000")], "is no number of a step"),
        (&[(100, "")], "a.csv: holds several steps, each with its own clock: 4 (from line 2), 7 (from line 103)"),
    ] {
        let refused = read(&export, "", conditions).unwrap_err();
        assert!(refused.contains(says), "{conditions:?}: {refused}");
    }
}

#[test]
fn a_recorded_coefficient_that_contradicts_the_forces_is_told() {
    let export = |factor: f64| {
        "time [s],torque [N m],normal force [N],COF\n".to_owned()
            + &lines(101, |t, ripple| format!("{t:.1},{:.5},10,{:.5}", 0.0381 * 2.5 * ripple, factor * 0.25 * ripple))
    };
    let radius = "effective_radius_mm = 38.1";
    let said = notes_of(&export(2.0), radius);
    let says = "the recorded friction coefficient is 0.5005, 2.00 times the 0.2500 of torque / (normal force x radius): the radius or a channel is wrong";
    assert!(said.contains(says), "{said}");
    assert!(!notes_of(&export(1.05), radius).contains("coefficient"));
    // With a dead weight the stated force is doubtful; a force and a coefficient may be exchanged.
    let dead = "time,Fx [N],COF\n".to_owned()
        + &lines(101, |t, ripple| format!("{t:.1},{:.5},{:.5}", 2.5 * ripple, 0.5 * ripple));
    assert!(
        notes_of(&dead, "").contains("2.00 times the 0.2500 of friction force / the stated force"),
        "{}",
        notes_of(&dead, "")
    );
    let exchanged = "time,COF,Fx [N],Fz\n".to_owned()
        + &lines(101, |t, ripple| format!("{t:.1},{:.5},{:.5},10", 2.5 * ripple, 0.25 * ripple));
    let refused = read(&exchanged, "", &[(100, "")]).unwrap_err();
    let says = "the friction force is 0.25 N and the friction coefficient 2.5: they are likely in each other's place";
    assert!(refused.contains(says), "{refused}");
}

#[test]
fn friction_that_cannot_be_is_refused_with_the_unit_or_the_quantity_that_was_recorded() {
    for (header, friction, says) in [
        ("time,COF,Fz", 25.0, "friction is 25 in the window, which cannot be; "),
        ("time,COF,Fz", 25.0, "; in per cent, that would be 0.25"),
        ("time,COF", 25.0, "; in per cent, that would be 0.25"),
        ("time,COF,Fz", 12.0, "; as a friction force in N, it would be 1.2"),
        ("time,Fx,Fz", 2100.0, "; with the friction force in mN, as `Fx [mN]`, that would be 0.21"),
        ("time,Fx,Fz", 0.0021, "friction is 0.00021 in the window"),
        ("time,Fx,Fz", 0.0021, "; in kN, as `Fx [kN]`, that would be 0.21"),
        ("time,torque,Fz", 80.0, "; with the torque in N mm or mN m, as `torque [mN m]`, that would be 0.21"),
        ("time,torque [mN m],Fz", 0.08, "; with the torque in N m, as `torque [N m]`, that would be 0.21"),
    ] {
        let load = if header.ends_with("Fz") { ",10" } else { "" };
        let export = format!("{header}\n") + &lines(101, |t, ripple| format!("{t:.1},{:.8}{load}", friction * ripple));
        let refused = read(&export, "effective_radius_mm = 38.1", &[(100, "")]).unwrap_err();
        assert!(refused.contains(says), "{header} {friction}: {refused}");
        assert_eq!(refused.contains("torque"), header.contains("torque"), "{refused}");
    }
    // Friction as of graphite may be a coefficient in the column of the force.
    let coefficient = "time,Fx,Fz\n".to_owned() + &lines(101, |t, ripple| format!("{t:.1},{:.5},10", 0.05 * ripple));
    let told = notes_of(&coefficient, "");
    assert!(
        told.contains("mu 0.005 is unusual") && told.contains("; as a friction coefficient, it would be 0.05"),
        "{told}"
    );
    let exchanged = "time,Fz,COF\n".to_owned() + &lines(101, |t, ripple| format!("{t:.1},{:.5},10", 0.25 * ripple));
    let refused = read(&exchanged, "", &[(100, "")]).unwrap_err();
    assert!(refused.contains("normal force and friction coefficient are likely in each other's place"), "{refused}");
}

#[test]
fn a_dead_weight_is_told_with_the_titles_that_are_not_used() {
    let export = "time;Fx [N];Laps\n".to_owned() + &lines(101, |t, ripple| format!("{t:.1};{:.5};{t}", 2.1 * ripple));
    let said = notes_of(&export, "");
    assert!(said.contains("friction is over the stated 10 N, as of a dead weight"), "{said}");
    assert!(said.contains("no column is the normal force; not used are Laps"), "{said}");
}

#[test]
fn friction_that_turns_late_is_told() {
    let export = |lag_s: f64| {
        let row = |row: i32| {
            let t = 0.01 * f64::from(row);
            let side = if (t - lag_s).rem_euclid(0.8) < 0.4 { 1.0 } else { -1.0 };
            let x = if t.rem_euclid(0.8) < 0.4 { t.rem_euclid(0.8) } else { 0.8 - t.rem_euclid(0.8) };
            format!("{t:.2},{:.4},10,{:.3}\n", 2.5 * side * (1.0 + 0.01 * (7.0 * t).sin()), 100.0 * x)
        };
        "time [s],Fx [N],Fz [N],x [mm]\n".to_owned() + &(0..1500).map(row).collect::<String>()
    };
    let keys = "reciprocating = true";
    let said = |lag_s: f64| notes(&read(&export(lag_s), keys, &[(100, "window_s = [1, 14]")]).unwrap()).join("\n");
    assert!(said(0.08).contains("friction turns 0.085 s after the position, 21 % of a stroke"), "{}", said(0.08));
    assert!(!said(0.0).contains("friction turns"), "{}", said(0.0));
}

#[test]
fn lines_that_end_with_carriage_returns_alone_are_lines() {
    let export = "time;Fx [N];Fz [N]\n".to_owned() + &lines(101, |t, ripple| format!("{t:.1};{:.5};10", 2.1 * ripple));
    let [as_usual, returns] =
        [export.clone(), export.replace('\n', "\r")].map(|text| read(&text, "", &[(100, "")]).unwrap());
    assert_eq!(as_usual, returns);
}

#[test]
fn a_disturbed_reading_is_named_with_its_line_and_one_that_spoils_friction_is_refused_by_it() {
    let export = |reading: f64| {
        let row = |t: f64, ripple: f64| {
            let force_n = if (t - 5.0).abs() < 0.01 { reading } else { 2.1 * ripple };
            format!("{t:.1};{force_n:.5};{:.3}", 10.0 * ripple)
        };
        "time;Fx [N];Fz [N]\n".to_owned() + &lines(101, row)
    };
    let said = notes_of(&export(30.0), "");
    assert!(said.contains("friction is 3.013 at 5.00 s, beside 0.21, which changes"), "{said}");
    assert!(said.ends_with("a disturbed reading? (line 52)") || said.contains("reading? (line 52)\n"), "{said}");
    let refused = read(&export(1e12), "", &[(100, "")]).unwrap_err();
    assert!(refused.contains("which cannot be: friction is ") && refused.contains("(line 52)"), "{refused}");
    assert!(!refused.contains("torque"), "{refused}");
    assert!(!notes_of(&export(2.1), "").contains("disturbed"));
}

#[test]
fn a_repeat_beyond_all_others_is_refused_at_its_own_condition() {
    let step = |step: u32, mu: f64| lines(101, move |t, ripple| format!("{step};{t:.1};{:.4};10", 10.0 * mu * ripple));
    let steps = [(1, 0.21), (2, 0.22), (3, 0.24), (4, 0.23), (5, 2.6)].map(|(number, mu)| step(number, mu)).concat();
    let export = format!("Step;Time [s];Fx [N];Fz [N]\n{steps}");
    let own = ["step = 1", "step = 2", "step = 3", "step = 4", "step = 5"];
    let speeds = [100, 100, 200, 200, 200];
    let conditions: Vec<(u32, &str)> = speeds.into_iter().zip(own).collect();
    let refused = read(&export, "", &conditions).unwrap_err();
    assert!(refused.starts_with("c.toml:26: has mu 2.5999"), "{refused}");
    assert!(refused.contains("in a.csv, step 5, of 0.23") && refused.contains("`exclude`"), "{refused}");
    assert_eq!(read(&export, "", &conditions[..4]).unwrap().len(), 2);
}

/// A form that takes the last trace off leaves the options of `[traces]`, for the traces that come next.
#[test]
fn options_of_traces_stand_alone_beside_a_table_of_flat_samples() {
    let read = |tables: &str| {
        let text = format!(
            "name = \"a\"\nsource = \"test\"\n[material]\nyoungs_modulus_gpa = 2.5\ndensity_g_cm3 = 1.42\n[specimen]\nradius_mm = 1.0\n\
             [surface]\npersson_rms_slope = 0.1\n{tables}"
        );
        let rows = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n1,10,50,0.25,0.01\n5,10,50,0.24,0.01\n10,10,50,0.23,0.01\n";
        let source = in_memory(&[("c.toml", text.as_bytes()), ("flat.csv", rows.as_bytes())]);
        Calibration::read(&source, Path::new("c.toml")).map(|read| read.traces.len()).map_err(|error| error.to_string())
    };
    let measured = "[measurements]\nflat = \"flat.csv\"\n";
    for options in ["window_s = [1, 9]", "stroke_share = 0.5", "zero_s = [0, 1]", "columns = { torque = \"Mz\" }"] {
        assert_eq!(read(&format!("{measured}[traces]\n{options}\n")), Ok(0), "{options}");
    }
    let says = "traces.condition: is missing; expected at least one [[traces.condition]]";
    assert!(read("[traces]\nwindow_s = [1, 9]\n").unwrap_err().contains(says));
}
