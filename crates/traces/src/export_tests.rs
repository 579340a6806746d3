use super::*;
use crate::{Tangential, TraceChannels};

fn parsed(text: &str) -> Result<TraceFile, ExportError> {
    parse(text, &ExportOptions { effective_radius_m: Some(0.04), ..ExportOptions::default() })
}

#[test]
fn separators_decimal_signs_units_and_comments() {
    let plain = parsed("time_s,torque_nm,normal_force_n\n0,0.5,50\n0.5,0.25,51\n").unwrap();
    let expected = TraceChannels {
        time_s: vec![0.0, 0.5],
        start_s: 0.0,
        tangential: Tangential::TorqueNm(vec![0.5, 0.25]),
        normal_force_n: vec![50.0, 51.0],
    };
    assert_eq!((plain.repeats.len(), &plain.repeats[0].channels), (1, &expected));
    for text in [
        "\u{feff}Test: LDPE; operator 7\n# made today\nZeit [s];Drehmoment [Nm];Normalkraft [N]\r\n0;0,5;50\r\n0,5;0,25;51\r\n",
        "Time\tTz\tFz\tCOF\ns\tN m\tN\t-\n0\t5e-1\t50\t0.25\n% pause\n0,5\t2,5E-1\t51\t0.2\n",
        "\"Time (ms)\",\"Tz (mN·m)\",\"Fz (kN)\"\n\"0\",\"500\",\"0,05\"\n500,250,\"0,051\"\n",
        "# comment, with, commas\nnormal_force,time,torque\n50,0.0,0.5\n\n51,0.5,0.25\n",
    ] {
        let found = parsed(text).unwrap();
        let channels = &found.repeats[0].channels;
        let close = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let Tangential::TorqueNm(torque) = &channels.tangential else { panic!("{text}") };
        assert!(close(&channels.time_s, &[0.0, 0.5]) && close(torque, &[0.5, 0.25]), "{text}");
        assert!(close(&channels.normal_force_n, &[50.0, 51.0]), "{text}");
    }
}

#[test]
fn repeats_speed_and_humidity() {
    let rows = "0,0.5,50,2.0,15\n1,0.5,50,2.2,17\n";
    let header = "time_s,friction_force_n,normal_force_n,speed_mm_s,humidity_pct\n";
    let twice = parsed(&format!("{header}{rows}{header}{rows}")).unwrap();
    assert_eq!((twice.repeats.len(), twice.repeats[1].number), (2, 2));
    let second = &twice.repeats[1];
    assert!((second.speed_m_s.unwrap() - 2.1e-3).abs() < 1e-15 && (second.humidity.unwrap() - 0.16).abs() < 1e-15);
    assert_eq!(second.channels.tangential, Tangential::ForceN(vec![0.5, 0.5]));
    let labelled = parsed("run;time;Tz;Fz;Drehzahl [1/min]\n1;0;1;2;30\n1;1;1;2;30\n2;0;1;2;30\n").unwrap();
    assert_eq!(labelled.repeats.iter().map(|r| r.channels.time_s.len()).collect::<Vec<_>>(), [2, 1]);
    // 30 revolutions per minute at 40 mm: pi / s x 0.04 m.
    assert!((labelled.repeats[0].speed_m_s.unwrap() - std::f64::consts::PI * 0.04).abs() < 1e-12);
}

#[test]
fn what_was_not_measured_is_left_out_and_counted() {
    let found = parsed("time,Tz,Fz,Temp\n0,1,2,20\n1,,2,20\n2,NaN,2,x\n3,1,2,\n").unwrap();
    let repeat = &found.repeats[0];
    let missing = repeat.missing.as_ref().unwrap();
    assert_eq!((repeat.channels.time_s.as_slice(), missing.rows, missing.of), (&[0.0, 3.0][..], 2, 4));
    assert_eq!(missing.words(true), "2 of 4 rows have no number in Tz from 1.00 to 2.00 s (lines 3 to 4)");
    assert_eq!(found.unused, ["Temp"]);
}

#[test]
fn time_is_counted_from_the_first_row_even_where_it_lacks_a_number() {
    // Friction of 0.25 with a drift of 0.001 per second; the clock begins at 7 s, and the force is recorded from
    // `from_s` on.
    let table = |from_s: f64| {
        let mut text = String::from("time,Fx,Fz,x [mm]\n");
        for t in (0..=1000).map(|row| f64::from(row) * 0.05) {
            let ripple = 0.01 * (3.0 * t).sin();
            let force = if t < from_s { String::new() } else { "60".to_owned() };
            text += &format!("{},{},{force},{}\n", 7.0 + t, 15.0 + 0.06 * t + ripple, 2.0 * t);
        }
        parsed(&text).unwrap().repeats.remove(0)
    };
    let options = crate::TraceOptions {
        window_s: [15.0, 45.0],
        nominal_force_n: Some(60.0),
        speed_m_s: 2e-3,
        static_peak: false,
        ..crate::tests::OPTIONS
    };
    let analysed = |repeat: &Recorded, options: &crate::TraceOptions| crate::analyse(&repeat.channels, options);
    let (whole, late) = (table(0.0), table(12.0));
    let found = [&whole, &late].map(|repeat| analysed(repeat, &options).unwrap());
    assert_eq!(found[0].window, found[1].window);
    assert!((found[1].time_s[0] - 12.0).abs() < 1e-9);
    let missing = late.missing.as_ref().unwrap().words(true);
    assert_eq!(missing, "240 of 1001 rows have no number in Fz from 0.00 to 11.95 s (lines 2 to 241)");
    assert!(found[1].flags.iter().any(|flag| flag.to_string().contains("no samples from 0.00 to 12.00 s")));
    let speed = |repeat: &Recorded, span_s: [f64; 2]| {
        crate::speed_of_position(&repeat.channels.time_s, repeat.channels.start_s, &repeat.position_m, span_s, None)
    };
    assert!(speed(&late, [13.0, 45.0]).is_some() && speed(&late, [0.0, 11.0]).is_none());
    // The file ends at 50 s; a window beyond its end is refused.
    let longer = crate::TraceOptions { window_s: [15.0, 55.0], ..options };
    assert!(
        matches!(analysed(&late, &longer), Err(crate::TraceError::TooShort { end_s, .. }) if (end_s - 50.0).abs() < 1e-9)
    );
    let early = crate::TraceOptions { window_s: [5.0, 45.0], ..options };
    let error = analysed(&late, &early).unwrap_err();
    assert!(matches!(error, crate::TraceError::Gap { from_s: 0.0, .. }), "{error:?}");
    let [reason, _] = late.missing.as_ref().unwrap().explains(&error, early.window_s).unwrap();
    assert!(reason.contains("from 0.00 to 11.95 s"), "{reason}");
    // A zero span without any record is refused.
    let zeroed = crate::TraceOptions { zero_s: Some([0.0, 4.0]), ..options };
    assert!(analysed(&late, &zeroed).unwrap_err().to_string().contains("holds 0 samples"));
}

#[test]
fn empty_cells_at_the_end_of_a_line_are_cells_whatever_separates_them() {
    for mark in ["\t", ";", ","] {
        let table = "Time,Fx,Fz,Kommentar\n0,1.5,50,\n1,1.6,50,gut\n\n2,1.7,50,\n";
        let found = parsed(&table.replace(',', mark)).unwrap();
        let (channels, unused) = (&found.repeats[0].channels, &found.unused);
        assert_eq!(
            (channels.time_s.as_slice(), unused.as_slice()),
            (&[0.0, 1.0, 2.0][..], &["Kommentar".to_owned()][..])
        );
        // All lines, or only the repeated header, end with a separator.
        for table in ["Time,Fx,Fz,\n0,1.5,50,\n1,1.6,50,\n", "Time,Fx,Fz,,\n0,1.5,50\nTime,Fx,Fz,,\n0,1.6,50\n"] {
            let found = parsed(&table.replace(',', mark)).unwrap();
            let samples: usize = found.repeats.iter().map(|repeat| repeat.channels.time_s.len()).sum();
            assert_eq!((samples, found.unused.len()), (2, 0), "{table}");
        }
        let short = parsed(&"Time,Fx,Fz,Kommentar\n0,1.5,50\n".replace(',', mark)).unwrap_err();
        assert_eq!((short.line, short.reason.as_str()), (Some(2), "has 3 values"));
    }
    // Instruments end rows with empty cells.
    assert_eq!(parsed("time,Fz,Fx\n0,50,4,,\n1,50,5,,\n").unwrap().repeats[0].channels.time_s, [0.0, 1.0]);
    // The cells of an unused column, here a temperature, may hold a point beside decimal commas.
    assert!(parsed("time;Fx;Fz;Temp\n0,0;15,2;500;20.5\n").is_ok());
}

#[test]
fn rows_that_repeat_the_row_before_are_left_out_and_counted() {
    let found = parsed("time,Tz,Fz\n0,1,2\n0,1,2\n1,1,2\n1,1,2\n1,1,2\n2,1,2\n").unwrap();
    let repeat = &found.repeats[0];
    assert_eq!((repeat.channels.time_s.as_slice(), repeat.repeated_rows), (&[0.0, 1.0, 2.0][..], 3));
    // Rows with different values at the same time are different samples.
    let found = parsed("time,Tz,Fz\n0,1,2\n0,1.5,2\n1,1,2\n").unwrap();
    assert_eq!((found.repeats[0].channels.time_s.len(), found.repeats[0].repeated_rows), (3, 0));
}

#[test]
fn a_coefficient_is_used_where_nothing_else_says_what_friction_was() {
    let alone = parsed("Time [s];\u{b5};Cycles\n0;0,25;1\n1;0,26;1\n").unwrap();
    let channels = &alone.repeats[0].channels;
    assert_eq!(channels.tangential, Tangential::Coefficient(vec![0.25, 0.26]));
    assert!(channels.normal_force_n.is_empty() && alone.unused == ["Cycles"]);
    let loaded = parsed("time,COF,Fz\n0,0.25,50\n1,0.26,\n").unwrap();
    let missing = loaded.repeats[0].missing.as_ref().unwrap();
    assert_eq!((&loaded.repeats[0].channels.normal_force_n[..], missing.rows), (&[50.0][..], 1));
    assert_eq!(missing.longest.columns, ["Fz"]);
    // Next to a force the coefficient is optional, and its cells may hold anything.
    let beside = parsed("time,Fx,COF,Fz\n0,12.5,x,50\n1,13,,50\n").unwrap();
    assert_eq!(beside.repeats[0].channels.tangential, Tangential::ForceN(vec![12.5, 13.0]));
    assert!(beside.unused.is_empty() && beside.repeats[0].coefficient.is_empty());
}

#[test]
fn titles_that_are_not_known_can_be_given() {
    let text = "Protokoll LT-7\nBediener;K. M.\n\nt [ms];x [mm];F_tan [N];F_norm [N]\n0;0,0000;1,0622;29,980\n10;0,02;3,1797;29,984\n";
    let mut titles = Titles::default();
    titles.name(Channel::FrictionForce, "F_tan").unwrap();
    titles.name(Channel::NormalForce, "F_norm").unwrap();
    let read = parse(text, &ExportOptions { titles: Some(&titles), ..ExportOptions::default() }).unwrap();
    let channels = &read.repeats[0].channels;
    assert_eq!(channels.tangential, Tangential::ForceN(vec![1.0622, 3.1797]));
    assert_eq!((&channels.time_s[..], &channels.normal_force_n[..]), (&[0.0, 0.01][..], &[29.98, 29.984][..]));
    // A custom title that the file does not have is named in the message.
    titles.name(Channel::Time, "Uhr").unwrap();
    let told =
        parse(text, &ExportOptions { titles: Some(&titles), ..ExportOptions::default() }).unwrap_err().to_string();
    assert!(told.contains("no column is the time") && told.contains("for time: uhr, as `columns` says"), "{told}");
}
