use super::*;

#[test]
fn the_units_that_are_listed_are_known_and_none_is_left_out() {
    for channel in Channel::ALL.into_iter().filter(|channel| channel.unit_words().contains(" or ")) {
        let words = channel.unit_words().replace(" or those of revolutions", "").replace(" or ", ", ");
        let listed: Vec<f64> = words
            .split(", ")
            .map(|word| {
                let priority = Priority::Primary;
                let mut column = Column { channel, priority, name: String::new(), factor: f64::NAN };
                column.set_unit(word).unwrap_or_else(|unknown| panic!("{unknown:?}"));
                column.factor
            })
            .collect();
        // The first column counts without a unit; none with another length is skipped.
        assert_eq!(listed[0], channel.units()[0].1, "{words}");
        for (name, factor) in channel.units() {
            assert!(listed.contains(factor), "{name} is not in {words}");
        }
    }
}

#[test]
fn names_and_units_of_several_houses() {
    for (written, channel, factor) in [
        ("time_s", Channel::Time, 1.0),
        ("Time [ms]", Channel::Time, 1e-3),
        ("Elapsed time (min)", Channel::Time, 60.0),
        ("Tz", Channel::Torque, 1.0),
        ("Tz (N·m)", Channel::Torque, 1.0),
        ("Torque/mNm", Channel::Torque, 1e-3),
        ("torque_nmm", Channel::Torque, 1e-3),
        ("\"Drehmoment [N cm]\"", Channel::Torque, 1e-2),
        ("friction_force_n", Channel::FrictionForce, 1.0),
        ("Fx(mN)", Channel::FrictionForce, 1e-3),
        ("normal_force", Channel::NormalForce, 1.0),
        ("Fz [kN]", Channel::NormalForce, 1e3),
        ("speed_mm_s", Channel::Speed, 1e-3),
        ("Sliding speed (m/s)", Channel::Speed, 1.0),
        ("speed [rpm]", Channel::Revolutions, 1.0 / 60.0),
        ("speed [rad/s]", Channel::Revolutions, 1.0 / std::f64::consts::TAU),
        ("speed (mm/min)", Channel::Speed, 1e-3 / 60.0),
        ("velocity_um_s", Channel::Speed, 1e-6),
        ("Drehzahl [min\u{207b}¹]", Channel::Revolutions, 1.0 / 60.0),
        ("Drehzahl (U/min)", Channel::Revolutions, 1.0 / 60.0),
        ("time (hours)", Channel::Time, 3600.0),
        ("Fz [lbf]", Channel::NormalForce, 4.448_221_615_260_5),
        ("Fz [daN]", Channel::NormalForce, 10.0),
        ("Fz [g]", Channel::NormalForce, 9.806_65e-3),
        ("Ball Load (kg)", Channel::NormalForce, 9.806_65),
        ("V (mm/sec)", Channel::Speed, 1e-3),
        ("Step Time (sec)", Channel::Time, 1.0),
        ("DAQ.Fz (N)", Channel::NormalForce, 1.0),
        ("DAQ.COF ()", Channel::Coefficient, 1.0),
        ("Rotary.Velocity (rpm)", Channel::Revolutions, 1.0 / 60.0),
        ("Nominal Load [mN]", Channel::NormalForce, 1e-3),
        ("Traction Coeff (-)", Channel::Coefficient, 1.0),
        ("torque [lbf.in]", Channel::Torque, 4.448_221_615_260_5 * 25.4e-3),
        ("RH [% r.h.]", Channel::Humidity, 1e-2),
        ("RH [%]", Channel::Humidity, 1e-2),
        ("humidity_pct", Channel::Humidity, 1e-2),
        ("run", Channel::Repeat, 1.0),
        ("COF", Channel::Coefficient, 1.0),
        ("Friction coefficient [-]", Channel::Coefficient, 1.0),
        ("mu [%]", Channel::Coefficient, 1e-2),
        ("COF (pct)", Channel::Coefficient, 1e-2),
        ("\u{b5}", Channel::Coefficient, 1.0),
        ("\u{3bc} []", Channel::Coefficient, 1.0),
    ] {
        let found = column(written, &Titles::default()).unwrap().unwrap_or_else(|| panic!("{written}"));
        assert_eq!((found.channel, found.factor), (channel, factor), "{written}");
    }
    for other in ["Cycles", "Temperature [C]", "Z-position (mm)", ""] {
        assert_eq!(column(other, &Titles::default()), Ok(None), "{other}");
    }
}

#[test]
fn a_title_of_ones_own_stands_for_those_that_are_known() {
    let mut titles = Titles::default();
    titles.name(Channel::FrictionForce, "F_tan").unwrap();
    titles.name(Channel::NormalForce, "F_norm [mN]").unwrap();
    titles.name(Channel::Time, "\u{6642}\u{9593}").unwrap();
    for (written, channel, factor) in [
        ("F_tan", Channel::FrictionForce, 1.0),
        ("F_tan [mN]", Channel::FrictionForce, 1e-3),
        ("\"f tan (kN)\"", Channel::FrictionForce, 1e3),
        ("F_norm", Channel::NormalForce, 1e-3),
        ("F_norm [N]", Channel::NormalForce, 1.0),
        ("\u{6642}\u{9593} [ms]", Channel::Time, 1e-3),
    ] {
        let found = column(written, &titles).unwrap().unwrap_or_else(|| panic!("{written}"));
        assert_eq!((found.channel, found.factor), (channel, factor), "{written}");
    }
    // Custom titles give units as exports do: in brackets, after a slash or after an underscore.
    for (title, written, factor) in [
        ("Nominal Load [N]", "Nominal Load [N]", 1.0),
        ("Last/mN", "Last/mN", 1e-3),
        ("Last/mN", "Last [kN]", 1e3),
        ("load_kg", "load_kg", 9.806_65),
        ("load_kg", "Load kg [N]", 1.0),
        ("F_n", "F_n", 1.0),
    ] {
        let mut titles = Titles::default();
        titles.name(Channel::NormalForce, title).unwrap();
        let found = column(written, &titles).unwrap().unwrap_or_else(|| panic!("{title} {written}"));
        assert_eq!((found.channel, found.factor), (Channel::NormalForce, factor), "{title} {written}");
    }
    // A known title is not used as a second column of a channel with a custom title.
    assert_eq!(column("Fz [N]", &titles), Ok(None));
    assert!(column("F_tan [bananas]", &titles).is_err() && titles.name(Channel::Time, "t [N]").is_err());
}
