//! Notes on anomalies in the traces of a calibration.

use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, counted};
use slipgrid_traces::Repeats;

use super::traces::ConditionTraces;

/// Notes on anomalies of conditions and their traces, for a material's provenance. A note that concerns many conditions
/// is written once, with the first of them.
pub fn notes(conditions: &[ConditionTraces]) -> Vec<String> {
    let traces = conditions.iter().map(|traces| traces.traces.len()).sum();
    let remarks = of_traces(conditions);
    let mut notes = grouped(&remarks, ("traces", traces));
    if notes.len() < remarks.len() {
        let list = "traces.csv, which calibrate --report and traces -o write, says of every trace what is odd about it";
        notes.push(list.to_owned());
    }
    notes.extend(grouped(&of_conditions(conditions), ("conditions", conditions.len())));
    notes
}

/// Note that errors are incomplete, if a condition was measured once and no other condition on the same kind of surface
/// was repeated; `None` otherwise.
pub fn unrepeated(conditions: &[ConditionTraces]) -> Option<String> {
    let is_alone = |traces: &ConditionTraces| traces.mean.count == 1 && traces.mean.mu_dynamic.freedom == 0;
    let alone = conditions.iter().filter(|traces| is_alone(traces)).count();
    (alone > 0).then(|| {
        format!(
            "errors of friction: {alone} of {} conditions were measured once, and no other was repeated: nothing tells how far another sample may \
             be, and the errors of friction and of ratios, and the chance, count the error within a trace alone. Three repeats of one condition \
             would tell",
            conditions.len()
        )
    })
}

/// An anomaly, and the condition or trace in which it occurs.
struct Remark {
    place: String,
    words: String,
}

/// Joins remarks that differ only in their numbers to one sentence; `what` names the subject, traces or conditions, and
/// `all` is the total number of subjects.
fn grouped(remarks: &[Remark], (what, all): (&str, usize)) -> Vec<String> {
    let kind = |words: &str| words.replace(|letter: char| letter.is_ascii_digit() || "+-".contains(letter), "");
    let mut groups: Vec<(String, &Remark, usize)> = Vec::new();
    for remark in remarks {
        let own = kind(&remark.words);
        match groups.iter_mut().find(|(known, ..)| *known == own) {
            Some((.., count)) => *count += 1,
            None => groups.push((own, remark, 1)),
        }
    }
    let in_words = |(_, Remark { place, words }, count): (String, &Remark, usize)| match count {
        1 => format!("{place}: {words}"),
        _ => format!("{count} of {all} {what}, the first of them {place}: {words}"),
    };
    groups.into_iter().map(in_words).collect()
}

/// Describes a condition by sample, force, speed and humidity.
fn place(traces: &ConditionTraces) -> String {
    let condition = &traces.condition;
    format!(
        "{}, {} N, {} mm/s, {} %",
        condition.sample(),
        condition.force_n,
        SPEED_MM_S.from_si(condition.speed_m_s),
        HUMIDITY_PCT.from_si(condition.humidity)
    )
}

/// Anomalies of single traces.
fn of_traces(conditions: &[ConditionTraces]) -> Vec<Remark> {
    let of_one = conditions.iter().flat_map(|traces| traces.traces.iter().map(|trace| (place(traces), trace)));
    let remarks = of_one.flat_map(|(place, trace)| {
        let remark = move |words: &String| Remark { place: format!("{place}, {}", trace.label), words: words.clone() };
        trace.flags.iter().map(remark)
    });
    remarks.collect()
}

/// Anomalies of the repeats of a condition.
fn of_conditions(conditions: &[ConditionTraces]) -> Vec<Remark> {
    let mut remarks = Vec::new();
    for traces in conditions {
        let mut add = |words: String| remarks.push(Remark { place: place(traces), words });
        if !traces.condition.excluded.is_empty() {
            let names = traces.condition.excluded.iter().filter_map(|path| path.file_name());
            let names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
            add(format!("{} left out by `exclude`", names.join(", ")));
        }
        if traces.mean.count == 1 {
            let deviation = match traces.mean.mu_dynamic.freedom {
                0 => "the error within the trace, not between repeats",
                _ => "that between repeats of other conditions, at least the error within the trace",
            };
            add(format!("one repeat; its deviation is {deviation}"));
        }
        let Repeats { stick_slips, peaks, count, .. } = traces.mean;
        if stick_slips > 0 {
            let of = counted(count, "repeat");
            add(format!("stick-slip in {stick_slips} of {of}; the model has no stick-slip of the whole sample"));
        }
        if (1..count).contains(&peaks) {
            add(format!("a static peak in {peaks} of {count} repeats only; it is not fitted"));
        }
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_that_differ_in_numbers_alone_are_one_sentence() {
        let remark = |place: &str, words: &str| Remark { place: place.into(), words: words.into() };
        let remarks = [
            remark("a.csv", "friction rises by 0.0199, 7 %, after 1.68 s"),
            remark("a.csv", "only 3 different values occur"),
            remark("b.csv", "friction rises by 0.0202, 12 %, after 1.70 s"),
            remark("c.csv", "friction falls by 0.0202, 12 %, after 1.70 s"),
        ];
        assert_eq!(
            grouped(&remarks, ("traces", 23)),
            [
                "2 of 23 traces, the first of them a.csv: friction rises by 0.0199, 7 %, after 1.68 s",
                "a.csv: only 3 different values occur",
                "c.csv: friction falls by 0.0202, 12 %, after 1.70 s",
            ]
        );
    }
}
