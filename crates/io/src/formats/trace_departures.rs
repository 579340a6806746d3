//! Describes deviations of a trace from its condition, and unused columns of exports whose titles are similar to known ones.

use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, significant, tidy};
use slipgrid_traces::columns::{Channel, Titles};
use slipgrid_traces::export::{Recorded, TraceFile, titles_in};
use slipgrid_traces::{Tangential, TraceFindings, lag_of_friction, speed_of_position};
use strsim::levenshtein;

use crate::formats::plausible::{FRICTION, FRICTION_OF_FORCE, FRICTION_OF_TORQUE};
use crate::formats::traces::TraceCondition;

/// A recorded speed that deviates from the nominal speed by more than this fraction gives a warning.
const SPEED_OFF: f64 = 0.1;
/// Relative deviation of the speed derived from the recorded position that gives a warning. It is larger than
/// `SPEED_OFF`, because strokes differ in speed.
const POSITION_OFF: f64 = 0.2;
/// Deviation of the recorded from the nominal relative humidity, as a fraction of 1, that gives a warning.
const HUMIDITY_OFF: f64 = 0.05;
/// The drive counts as at rest if the recorded speed is below this fraction of the nominal speed.
const STILL: f64 = 0.01;
/// Relative deviation of the friction coefficient recorded by the instrument that gives a warning: the instrument may
/// divide by the nominal load, and does not subtract an offset.
const COEFFICIENT_OFF: f64 = 0.1;
/// Lag of friction behind the position, relative to the duration of a stroke, that gives a warning. A filter lag of
/// 0.05 strokes reduces friction in the middle half of a stroke by half a per cent, a lag of 0.1 strokes by three per
/// cent.
const LAG: f64 = 0.05;

/// Warns that a trace was recorded at rest, according to the speed of the recorded trace; `None` otherwise or without a
/// recorded speed.
pub(crate) fn stands_still(condition: &TraceCondition, repeat: &Recorded) -> Option<String> {
    let speed = repeat.speed_m_s.map(f64::abs).filter(|speed| *speed < STILL * condition.speed_m_s)?;
    let (found, nominal) = (SPEED_MM_S.from_si(speed), SPEED_MM_S.from_si(condition.speed_m_s));
    Some(format!(
        "the recorded speed is {found:.4} mm/s, of {nominal} mm/s: the sample does not slide, or its unit is another"
    ))
}

/// Warnings about `repeat` in `file`: deviations of speed, humidity, friction coefficient and position from the
/// condition and the `findings`, and repeated or missing rows.
pub(crate) fn departures(
    condition: &TraceCondition,
    repeat: &Recorded,
    findings: &TraceFindings,
    file: &TraceFile,
) -> Vec<String> {
    let mut flags = Vec::new();
    if let Some(line) = repeat.clock_restarts_in_line {
        flags.push(format!("the clock begins anew in line {line}: the rows from there on were taken as a repeat"));
    }
    let is_loadless = repeat.channels.normal_force_n.is_empty();
    if is_loadless && !matches!(repeat.channels.tangential, Tangential::Coefficient(_)) && !file.unused.is_empty() {
        flags.push(format!("no column is the normal force; not used are {}", file.unused.join(", ")));
    }
    flags.extend(coefficient_off(condition, repeat, findings));
    flags.extend(lags(condition, repeat));
    if let Some(speed) = repeat.speed_m_s.map(f64::abs).filter(|v| (v / condition.speed_m_s - 1.0).abs() > SPEED_OFF) {
        let (found, nominal) = (SPEED_MM_S.from_si(speed), SPEED_MM_S.from_si(condition.speed_m_s));
        flags.push(format!("the recorded speed is {found:.3} mm/s, not the nominal {nominal}"));
    }
    flags.extend(position_speed_off(condition, repeat));
    if let Some(humidity) = repeat.humidity.filter(|h| (h - condition.humidity).abs() > HUMIDITY_OFF) {
        let (found, nominal) = (HUMIDITY_PCT.from_si(humidity), HUMIDITY_PCT.from_si(condition.humidity));
        flags.push(format!("the recorded humidity is {found:.1} %, not the nominal {nominal}"));
    }
    if repeat.repeated_rows > 0 {
        let (count, all) = (repeat.repeated_rows, repeat.repeated_rows + repeat.channels.time_s.len());
        flags.push(format!("{count} of {all} rows repeat the row before them and were left out"));
    }
    if let Some(missing) = &repeat.missing {
        flags.push(format!("{}: left out", missing.words(true)));
    }
    flags
}

/// Checks the friction coefficient `mu` under `force_n` by the quantity that was recorded: a warning if it is unusual.
///
/// # Errors
/// What is accepted, with the unit or the quantity that the column probably has, if such friction cannot be measured.
pub(crate) fn judge_friction(recorded: &Tangential, mu: f64, force_n: f64) -> Result<Option<String>, String> {
    let (judge, other, other_mu) = match recorded {
        Tangential::ForceN(_) => (FRICTION_OF_FORCE, "as a friction coefficient, it", mu * force_n),
        Tangential::TorqueNm(_) => (FRICTION_OF_TORQUE, "", f64::NAN),
        Tangential::Coefficient(_) => (FRICTION, "as a friction force in N, it", mu / force_n),
    };
    let is_other = FRICTION.judge(other_mu) == Ok(None);
    let with = |words: String| {
        if is_other { format!("{words}; {other} would be {}", significant(other_mu, 3)) } else { words }
    };
    judge.judge(mu).map(|told| told.map(with)).map_err(with)
}

/// Reason to refuse a trace whose friction force and coefficient stand in each other's column; `None` otherwise.
pub(crate) fn exchanged_coefficient(
    condition: &TraceCondition,
    repeat: &Recorded,
    findings: &TraceFindings,
) -> Option<String> {
    let own = repeat.usual_coefficient(condition.window_s)?;
    let (mu, force_n) = (findings.window.mu, findings.normal_force_n);
    // The friction column holds the coefficient, and the coefficient column the force.
    let is_exchanged = matches!(repeat.channels.tangential, Tangential::ForceN(_))
        && !(0.5..=2.0).contains(&(own / mu))
        && (own / (mu * force_n * force_n) - 1.0).abs() <= COEFFICIENT_OFF;
    is_exchanged.then(|| {
        format!(
            "the friction force is {} N and the friction coefficient {}: they are likely in each other's place",
            significant(mu * force_n, 3),
            significant(own, 3)
        )
    })
}

/// Warns if the friction coefficient recorded by the instrument differs from that computed from torque or force.
fn coefficient_off(condition: &TraceCondition, repeat: &Recorded, findings: &TraceFindings) -> Option<String> {
    // The instrument does not subtract the zero.
    let own = repeat.usual_coefficient(condition.window_s).filter(|_| condition.zero_s.is_none())?;
    let mu = findings.window.mu;
    if (own / mu - 1.0).abs() <= COEFFICIENT_OFF {
        return None;
    }
    let (channel, divisor, wrong) = match (&repeat.channels.tangential, repeat.channels.normal_force_n.is_empty()) {
        (Tangential::TorqueNm(_), _) => {
            (Channel::Torque, "(normal force x radius)", "the radius or a channel is wrong")
        }
        (_, true) => (Channel::FrictionForce, "the stated force", "the stated force or a channel is wrong"),
        (_, false) => (Channel::FrictionForce, "normal force", "a channel or its unit is wrong"),
    };
    Some(format!(
        "the recorded friction coefficient is {own:.4}, {:.2} times the {mu:.4} of {} / {divisor}: {wrong}",
        own / mu,
        channel.title()
    ))
}

/// Warns if friction reverses later or earlier than the position of a reciprocating sample; `None` otherwise.
fn lags(condition: &TraceCondition, repeat: &Recorded) -> Option<String> {
    condition.stroke_share?;
    let lag = lag_of_friction(&repeat.channels, &repeat.position_m, condition.window_s)?;
    let (part, side) = (lag.lag_s.abs() / lag.stroke_s, if lag.lag_s > 0.0 { "after" } else { "before" });
    (part > LAG).then(|| {
        format!(
            "friction turns {:.3} s {side} the position, {:.0} % of a stroke: its filter or clock lags, or the arm yields; friction may be low",
            lag.lag_s.abs(),
            100.0 * part
        )
    })
}

/// Warns if the speed derived from the recorded position differs from the nominal speed.
fn position_speed_off(condition: &TraceCondition, repeat: &Recorded) -> Option<String> {
    let moved = speed_of_position(
        &repeat.channels.time_s,
        repeat.channels.start_s,
        &repeat.position_m,
        condition.window_s,
        condition.stroke_share,
    );
    // A nearly constant position is not the position along the path: it is the radius of a pin on a disc, or wear.
    let moved = moved.map(|speed| speed / condition.speed_m_s).filter(|ratio| *ratio > STILL);
    let ratio = moved.filter(|ratio| (ratio - 1.0).abs() > POSITION_OFF)?;
    let nominal = SPEED_MM_S.from_si(condition.speed_m_s);
    let found = ratio * nominal;
    let place = condition.stroke_share.map_or_else(
        || "in the window".to_owned(),
        |share| format!("in the middle {} % of its strokes", tidy(100.0 * share)),
    );
    Some(format!(
        "the recorded position moves at {found:.3} mm/s {place}, not at the nominal {nominal}: speed, its unit or that of the \
         position is wrong"
    ))
}

/// Minimum number of letters of titles that are compared: shorter titles are similar to many words.
const FEWEST_LETTERS: usize = 4;

/// Warns of each unused column of `file` whose title is similar to a known title of a quantity that no column holds.
pub(crate) fn near_titles(file: &TraceFile, titles: &Titles) -> Vec<String> {
    let is_free = |channel: &Channel| !file.used.contains(channel) && !titles.has_title(*channel);
    let free: Vec<Channel> = Channel::ALL.into_iter().filter(is_free).collect();
    let is_of_another = |title: &str| {
        let letters = Titles::letters_of(title);
        let names = |channel: Channel| channel.names().chain(channel.secondary_names());
        let is_one = |channel: Channel| names(channel).any(|name| letters.iter().any(|own| own == name));
        Channel::ALL.into_iter().any(|channel| !is_free(&channel) && is_one(channel))
    };
    let of_title = |title: &String| {
        if is_of_another(title) {
            return None;
        }
        let (channel, known, distance) = nearest_title(title, &free)?;
        let (what, key) = (channel.title(), channel.key());
        if distance == 0 {
            let units = channel.unit_words();
            return (!channel.is_needed())
                .then(|| format!("the column `{title}` is not used: its unit is none of those of a {what}, {units}"));
        }
        Some(format!(
            "the column `{title}` is not used: its title is not known, and near to `{known}` (did you mean that? `columns = {{ {key} = \
             \"{title}\" }}` in [traces] takes it as the {what})"
        ))
    };
    file.unused.iter().filter_map(of_title).collect()
}

/// Finds the known title that is most similar to an unknown one in the `text` of an export, of the quantities of which
/// one is needed and no column holds any; `None` if none is similar enough.
pub(crate) fn near_missing_title(text: &str, titles: &Titles) -> Option<&'static str> {
    let found = titles_in(text, titles);
    let is_there = |channel: &Channel| found.iter().any(|(_, own)| own.as_ref() == Some(channel));
    let needed: [&[Channel]; 2] = [&[Channel::Time], &[Channel::FrictionForce, Channel::Torque, Channel::Coefficient]];
    let missing = needed.into_iter().find(|channels| !channels.iter().any(is_there))?;
    let unknown = found.iter().filter(|(_, channel)| channel.is_none());
    unknown
        .filter_map(|(title, _)| nearest_title(title, missing))
        // A known title with an unknown unit is refused for the unit.
        .filter(|(.., distance)| *distance > 0)
        .min_by_key(|(.., distance)| *distance)
        .map(|(_, known, _)| known)
}

/// Finds the known title of one of the `channels` that is most similar to `title`; `None` if none is similar enough.
/// Returns the channel, the known title and the number of differing letters.
fn nearest_title(title: &str, channels: &[Channel]) -> Option<(Channel, &'static str, usize)> {
    let own = Titles::letters_of(title);
    let long = |letters: &str| letters.chars().count() >= FEWEST_LETTERS;
    let known = channels.iter().flat_map(|channel| channel.names().map(|name| (*channel, name)));
    let pairs = known.filter(|(_, name)| long(name)).flat_map(|(channel, name)| {
        // A quarter of the letters may differ.
        own.iter().filter(|own| long(own)).map(move |own| {
            let distance = levenshtein(own, name);
            (distance <= own.chars().count().div_ceil(4)).then_some((channel, name, distance))
        })
    });
    pairs.flatten().min_by_key(|(.., distance)| *distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_traces::export::{ExportOptions, parse};

    fn said(header: &str, titles: &Titles) -> Vec<String> {
        let cells = header.split(',').count();
        let rows: String = (0..3).map(|i| vec![i.to_string(); cells].join(",") + "\n").collect();
        let options = ExportOptions { effective_radius_m: Some(0.04), titles: Some(titles), step: None };
        near_titles(&parse(&format!("{header}\n{rows}"), &options).unwrap(), titles)
    }

    #[test]
    fn titles_with_a_slip_of_the_pen_are_named_with_the_one_that_is_meant() {
        let none = Titles::default();
        for (title, known, key) in [
            ("Positon (mm)", "position", "position"),
            ("positon_mm", "position", "position"),
            ("Humidty [%]", "humidity", "humidity"),
            ("slidingsped", "slidingspeed", "speed"),
        ] {
            let said = said(&format!("time,Fx,Fz,{title}"), &none);
            assert_eq!(said.len(), 1, "{title}: {said:?}");
            assert!(
                said[0].starts_with(&format!("the column `{title}` is not used: its title is not known")),
                "{said:?}"
            );
            assert!(said[0].contains(&format!("near to `{known}`")), "{said:?}");
            assert!(said[0].contains(&format!("{key} = \"{title}\"")), "{said:?}");
        }
        let unit = said("time,Fx,Fz,Position (inch)", &none);
        assert!(unit.len() == 1 && unit[0].contains("its unit is none of those of a position, mm, m, cm"), "{unit:?}");
    }

    #[test]
    fn a_refused_export_suggests_the_title_that_is_meant() {
        let none = Titles::default();
        for (header, meant) in [
            ("time [s],frction force [N],normal force [N]", Some("frictionforce")),
            ("tme [s],friction force [N],normal force [N]", None),
            ("Elapsed tme [s],friction force [N],normal force [N]", Some("elapsedtime")),
            ("time [s],abc [N],normal force [N]", None),
            ("time [s],friction force [MPa],normal force [N]", None),
        ] {
            assert_eq!(near_missing_title(&format!("{header}\n0,1,2\n"), &none), meant, "{header}");
        }
    }

    #[test]
    fn other_titles_and_those_of_quantities_that_are_there_are_not_named() {
        let none = Titles::default();
        for title in ["Temp", "Wear (um)", "Step", "Cycles", "Status", "Channel 4", "COF"] {
            assert_eq!(said(&format!("time,Fx,Fz,{title}"), &none), Vec::<String>::new(), "{title}");
        }
        assert_eq!(said("time,Fx,Fz,Position (mm),Positon (mm)", &none), Vec::<String>::new());
        let mut own = Titles::default();
        own.name(Channel::Position, "x_stage [mm]").unwrap();
        assert_eq!(said("time,Fx,Fz,Positon (mm)", &own), Vec::<String>::new());
        // A force that `columns` excludes is not a misspelt torque.
        own.name(Channel::Coefficient, "mu").unwrap();
        assert_eq!(said("time,mu,Friction force [N],Fz", &own), Vec::<String>::new());
    }
}
