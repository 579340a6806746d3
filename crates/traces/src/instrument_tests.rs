//! Synthetic exports in the layout of real instruments.

use crate::columns::{Channel, Titles};
use crate::export::{ExportError, ExportOptions, TraceFile, parse};
use crate::{Tangential, TraceFlag, TraceOptions, analyse};

/// `rows` lines at 10 Hz, each made from its time.
fn lines(rows: u32, line: impl Fn(f64) -> String) -> String {
    (0..rows).map(|row| line(f64::from(row) * 0.1) + "\n").collect()
}

/// A small ripple, so that no sensor looks stuck.
fn ripple(t: f64) -> f64 {
    1.0 + 0.01 * (7.0 * t).sin()
}

fn read(text: &str, step: Option<u32>, titles: &[(Channel, &str)]) -> Result<TraceFile, ExportError> {
    let mut own = Titles::default();
    titles.iter().for_each(|(channel, title)| own.name(*channel, title).unwrap());
    parse(text, &ExportOptions { effective_radius_m: None, titles: Some(&own), step })
}

/// Window from 1 to 9 s under a stated force of 10 N.
const OPTIONS: TraceOptions = TraceOptions {
    window_s: [1.0, 9.0],
    nominal_force_n: Some(10.0),
    speed_m_s: 0.1,
    static_peak: false,
    ..crate::tests::OPTIONS
};

/// Mean friction of every trace, and the flags of the first one.
fn friction(file: &TraceFile) -> (Vec<f64>, Vec<TraceFlag>) {
    let found: Vec<_> = file.repeats.iter().map(|repeat| analyse(&repeat.channels, &OPTIONS).unwrap()).collect();
    (found.iter().map(|found| found.window.mu).collect(), found[0].flags.clone())
}

fn assert_friction(file: &TraceFile, expected: &[f64]) {
    let (found, _) = friction(file);
    let close = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 3e-3);
    assert!(close, "{found:?}, not {expected:?}");
}

/// A step in the format of CETR and UMT, at 1 kgf.
fn umt_step(number: u32, mu: f64) -> String {
    let head = format!(
        "Step No. {number}\n\nStep Type Code: 0\nSet Force    = -1019.7\n\nFx,Fz,Z,X,V1,T,Ff,COF\ng,g,mm,mm,mm/sec,sec,g,\n\n"
    );
    let row = |t: f64| {
        let force = 1019.7 * mu * ripple(t);
        format!("{:.3},-1019.7,-0.69,3.949,0.055,{t:.2},{force:.3},{:.5}", -force, mu * ripple(t))
    };
    head + &lines(101, row) + "\n\n"
}

#[test]
fn umt_with_grams_steps_and_two_columns_of_one_force() {
    let head = "Created by UMT ver.1\nTotal number of runs - 2\nRun # 1\nRun date 12 May\n";
    let run = umt_step(1, 0.7) + &umt_step(2, 0.6);
    let text = format!("{head}{run}Run # 2\n{run}").replace('\n', "\r\n");
    assert_friction(&read(&text, Some(1), &[]).unwrap(), &[0.7, 0.7]);
    let second = read(&text, Some(2), &[]).unwrap();
    assert_friction(&second, &[0.6, 0.6]);
    assert!(matches!(&second.repeats[0].channels.tangential, Tangential::ForceN(force) if force[0] < 0.0));
    // Two runs of a step are repeats.
    let runs = format!("{head}{}Run # 2\n{}", umt_step(1, 0.7), umt_step(1, 0.6));
    assert_friction(&read(&runs, None, &[]).unwrap(), &[0.7, 0.6]);
}

#[test]
fn mtm_with_titles_that_come_twice_and_steps_of_other_columns() {
    let step = |number: u32, first: &str, mu: f64| {
        let head = format!(
            "Step {number} started at 19/08/2016 09:48:51\r\nStep type\tBOD\tStep duration\t02:46:40\r\nZero traction force (N)\t0.1\t(measured)\r\n\
             {first}\tTraction Coeff (-)\t\tStep Time (s)\tBall Load (N)\tPin Load (N)\tSliding Speed (mm/s)\tTraction Force (N)\tTraction Coeff (-)\t\r\n"
        );
        let row = |t: f64| {
            let mu = mu * ripple(t);
            let own = if first == "SRR (%)" { 0.0 } else { t };
            format!("{own:.1}\t{mu:.4}\t\t{t:.1}\t10.000\t\t100.0\t{:.4}\t{mu:.4}\t\r", 10.0 * mu)
        };
        head + &lines(101, row) + "\r\n"
    };
    let foot = "All steps completed, test completed normally at 19/08/2016 12:35:32\r\n";
    let one =
        format!("MTM Test Data File\r\n\r\nNumber of steps in profile:\t1\r\n{}{foot}", step(1, "Step Time (s)", 0.09));
    let file = read(&one, None, &[]).unwrap();
    assert_friction(&file, &[0.09]);
    assert!((file.repeats[0].speed_m_s.unwrap() - 0.1).abs() < 1e-12);
    let two = format!("{}{}{foot}", step(1, "Step Time (s)", 0.09), step(2, "SRR (%)", 0.05));
    assert_friction(&read(&two, Some(2), &[]).unwrap(), &[0.05]);
    assert!(read(&two, None, &[]).unwrap_err().reason.contains("several steps"));
}

#[test]
fn rtec_with_steps_in_a_column_and_a_foot() {
    let step = |step: u32, mu: f64| {
        lines(101, |t| {
            format!("{step},{:.3},{step},10.00,{:.4},{mu},96.4,0.09,25.1,", t + 0.148, 10.0 * mu * ripple(t))
        })
    };
    let text = format!(
        "Recipe, UpperSample, Averaging, Radius\rRotary_4tests.Rx,,100,1,\r\n\
         Step, Timestamp, RecipeStep, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),Rotary.Velocity (rpm),Rotary.Position (rev),RTC.Temperature (C),\r\n\
         {}{}\r\nTotalTime\r\n00:12:58.5914145\r\n",
        step(4, 0.14),
        step(7, 0.16)
    );
    for (number, mu) in [(4, 0.14), (7, 0.16)] {
        assert_friction(&read(&text, Some(number), &[]).unwrap(), &[mu]);
    }
    assert!(read(&text, None, &[]).unwrap_err().reason.ends_with("4 (from line 3), 7 (from line 104)"));
    // Steps are repeats if `columns` names their column as `repeat`.
    let repeats = read(&text, None, &[(Channel::Repeat, "Step"), (Channel::FrictionForce, "DAQ.Fx (N)")]).unwrap();
    assert_friction(&repeats, &[0.14, 0.16]);
    // Steps on a common clock need no step number: the window selects the step.
    let through = format!(
        "Step,Time [s],Fx [N],Fz [N]\n{}",
        lines(201, |t| format!("{},{t:.1},{:.4},10", if t < 10.0 { 1 } else { 2 }, 2.0 * ripple(t)))
    );
    assert_eq!(read(&through, None, &[]).unwrap().repeats[0].channels.time_s.len(), 201);
    let second = read(&through, Some(2), &[]).unwrap();
    assert_eq!((second.repeats[0].channels.start_s, second.repeats.len()), (10.0, 1));
}

#[test]
fn anton_paar_takes_the_measured_load_before_the_nominal_one() {
    let export = |titles: &str, row: &dyn Fn(f64) -> String| {
        format!(
            "TriboX 8\r\n\r\nInstrument\tTRB3\r\nNormal load\t10.00 [N]\r\n\r\nTime [s]\tDistance [m]\tLaps\tSequence ID\tNominal Load {titles}\r\n"
        ) + &lines(101, row)
    };
    let trb = export("[N]\t\u{b5}\tAngle [\u{b0}]\tFriction Force [N]\tHumidity [%]", &|t| {
        let mu = 0.21 * ripple(t);
        format!("{t:.1}\t{t}\t{t}\t0\t10.0\t{mu:.5}\t0\t{:.5}\t41.0", 10.0 * mu)
    });
    let known: [&[(Channel, &str)]; 4] = [
        &[],
        &[(Channel::NormalForce, "Nominal Load [N]")],
        &[(Channel::Coefficient, "\u{b5}")],
        &[(Channel::Coefficient, "\u{b5}"), (Channel::FrictionForce, "none"), (Channel::NormalForce, "none")],
    ];
    for titles in known {
        assert_friction(&read(&trb, None, titles).unwrap(), &[0.21]);
    }
    let nano = export("[mN]\tLinear Position [mm]\tNormal force [mN]\tFriction force [mN]", &|t| {
        format!("{t:.1}\t{t}\t{t}\t0\t9000\t1.5\t10000\t{:.3}", 2100.0 * ripple(t))
    });
    assert_friction(&read(&nano, None, &[]).unwrap(), &[0.21]);
}

#[test]
fn without_a_load_the_stated_force_counts_and_is_told() {
    let t11 =
        "Time [s];Friction force [N];Displacement [um];Temperature2 [C];Rotational speed [rpm];Number of revolutions\n"
            .to_owned()
            + &lines(101, |t| format!("{t:.1};{:.4};3;22;120;{t}", 2.1 * ripple(t)));
    let file = read(&t11, None, &[]).unwrap();
    assert_friction(&file, &[0.21]);
    assert!(
        friction(&file).1.iter().any(|flag| flag.to_string().contains("the stated 10 N")),
        "{:?}",
        friction(&file).1
    );
    assert_eq!(file.unused, ["Temperature2 [C]", "Number of revolutions"]);
    let channels = &file.repeats[0].channels;
    let unstated = TraceOptions { nominal_force_n: None, ..OPTIONS };
    assert!(analyse(channels, &unstated).unwrap_err().to_string().ends_with("to divide the friction force by"));
    let zeroed = TraceOptions { zero_s: Some([0.0, 0.5]), ..OPTIONS };
    assert!(analyse(channels, &zeroed).unwrap_err().to_string().contains("touchdown is not known"));
    // An unknown column with the unit of a force may be the load.
    let hidden = t11.replace("Temperature2 [C]", "Auflast [N]");
    let refused = read(&hidden, None, &[]).unwrap_err().to_string();
    assert!(refused.contains("not known are `Auflast [N]`, `Number of revolutions`"), "{refused}");
    assert_friction(&read(&hidden, None, &[(Channel::NormalForce, "none")]).unwrap(), &[0.21]);
    // A custom title must exist in the file.
    assert!(
        read(&t11, None, &[(Channel::NormalForce, "Last")])
            .unwrap_err()
            .to_string()
            .contains("last, as `columns` says")
    );
}

#[test]
fn words_below_the_last_row_are_left_out_and_words_between_rows_are_not() {
    let rows = lines(101, |t| format!("{t:.1};10;{:.4}", 2.1 * ripple(t)));
    let header = "time [s];normal force [N];friction force [N]\n";
    for foot in [
        "",
        "\nTest completed normally\n",
        "Total;10;2.1\n",
        "\nMean COF;0.210\nMax COF;0.23\n",
        "Total time: 00:01\n00:01:02\n",
    ] {
        assert_friction(&read(&format!("{header}{rows}{foot}"), None, &[]).unwrap(), &[0.21]);
        let between = read(&format!("{header}{rows}{foot}99;10;2.1\n"), None, &[]);
        assert_eq!(between.is_ok(), foot.is_empty(), "{foot}: {between:?}");
    }
    // After text lines the next run may begin.
    assert_friction(&read(&format!("{header}{rows}Test completed\n{rows}"), None, &[]).unwrap(), &[0.21, 0.21]);
}

#[test]
fn several_columns_of_one_kind_are_one_or_are_named() {
    let same = "Time (s);COF;Time (s);Load (N)\n".to_owned()
        + &lines(101, |t| format!("{t:.1};{:.4};{t:.1};10.0", 0.21 * ripple(t)));
    assert_friction(&read(&same, None, &[]).unwrap(), &[0.21]);
    let other = "Time (s);Fx (N);Ff (N);Load (N);Time (s)\n".to_owned()
        + &lines(101, |t| format!("{t:.1};{:.4};{:.4};10.0;{:.1}", 2.1 * ripple(t), 3.1 * ripple(t), 2.0 * t));
    let refused = read(&other, None, &[]).unwrap_err().to_string();
    assert!(refused.contains("`Time (s)`, `Time (s)` are each the time, and differ first in line 3"), "{refused}");
    assert!(refused.contains("`columns = { time = \"Time (s) #1\" }`"), "{refused}");
    let refused = read(&other, None, &[(Channel::Time, "Time (s) #2")]).unwrap_err().to_string();
    assert!(refused.contains("`columns = { friction_force = \"Fx (N)\" }`"), "{refused}");
    let file = read(&other, None, &[(Channel::Time, "Time (s) #2"), (Channel::FrictionForce, "Ff (N)")]).unwrap();
    assert_friction(&file, &[0.31]);
    assert_eq!(file.repeats[0].channels.time_s[1], 0.2);
    // Torque and force are both present; `columns` selects one.
    let both = same.replace("COF", "Tz [N m]").replace("Time (s);Load", "Fx [N];Load");
    let refused = read(&both, None, &[]).unwrap_err().to_string();
    assert!(
        refused.contains("`columns = { torque = \"Tz [N m]\" }` or `columns = { friction_force = \"Fx [N]\" }`"),
        "{refused}"
    );
    assert!(read(&both, None, &[(Channel::FrictionForce, "Fx [N]")]).is_ok());
}

#[test]
fn a_clock_that_begins_anew_begins_a_repeat() {
    let run = |mu: f64| lines(101, move |t| format!("{t:.1};{:.4};10", 10.0 * mu * ripple(t)));
    let text = format!("time;Fx;Fz\n{}{}", run(0.21), run(0.22));
    let file = read(&text, None, &[]).unwrap();
    assert_friction(&file, &[0.21, 0.22]);
    assert_eq!(file.repeats.iter().map(|run| run.clock_restarts_in_line).collect::<Vec<_>>(), [None, Some(103)]);
    assert_friction(&read(&text, Some(2), &[]).unwrap(), &[0.22]);
    // Time and friction are swapped.
    let swapped = "Fx;time;Fz\n".to_owned() + &lines(101, |t| format!("{t:.1};{:.4};10", 2.1 * ripple(t)));
    let file = read(&swapped, None, &[]).unwrap();
    let said = analyse(&file.repeats[0].channels, &OPTIONS).unwrap_err().to_string();
    assert!(said.contains("so that time and friction force are likely in each other's place"), "{said}");
}
