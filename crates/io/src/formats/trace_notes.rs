//! Notes on anomalies in the traces of a calibration.

use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, counted};

use super::traces::ConditionTraces;

/// Notes on anomalies of conditions and their traces, for a material's provenance. A note that concerns many conditions
/// is written once, with the first of them.
pub fn notes(conditions: &[ConditionTraces]) -> Vec<String> {
    let traces = conditions.iter().map(|traces| traces.traces.len()).sum();
    let of_traces = grouped(&of_traces(conditions), ("traces", traces));
    let of_conditions = grouped(&of_conditions(conditions), ("conditions", conditions.len()));
    let list = "traces.csv, which calibrate --report and traces -o write, says of every trace what is odd about it";
    let list = of_traces.iter().any(|group| group.is_of_many).then(|| list.to_owned());
    let words = |groups: Vec<Group>| groups.into_iter().map(|group| group.words);
    words(of_traces).chain(list).chain(words(of_conditions)).collect()
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

/// Remarks that differ at most in their numbers, joined to one sentence.
struct Group {
    words: String,
    is_of_many: bool,
}

/// Joins remarks that differ only in their numbers to one sentence; `what` names the subject, traces or conditions, and
/// `all` is the total number of subjects.
fn grouped(remarks: &[Remark], (what, all): (&str, usize)) -> Vec<Group> {
    let kind = |words: &str| words.replace(|letter: char| letter.is_ascii_digit() || "+-".contains(letter), "");
    let mut groups: Vec<(String, &Remark, usize)> = Vec::new();
    for remark in remarks {
        let own = kind(&remark.words);
        match groups.iter_mut().find(|(known, ..)| *known == own) {
            Some((.., count)) => *count += 1,
            None => groups.push((own, remark, 1)),
        }
    }
    let in_words = |(_, first, count): (String, &Remark, usize)| Group {
        words: match count {
            1 => format!("{}: {}", first.place, first.words),
            _ => format!("{count} of {all} {what}, the first of them {}: {}", first.place, first.words),
        },
        is_of_many: count > 1,
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
    let of_condition = |traces: &ConditionTraces| -> Vec<Remark> {
        let place = place(traces);
        let of_trace = traces.traces.iter().flat_map(|trace| {
            trace.flags.iter().map(|flag| Remark { place: format!("{place}, {}", trace.label), words: flag.clone() })
        });
        of_trace.collect()
    };
    conditions.iter().flat_map(of_condition).collect()
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
            let words = match traces.mean.mu_dynamic.freedom {
                0 => "one repeat; its deviation is the error within the trace, not between repeats",
                _ => {
                    "one repeat; its deviation is that between repeats of other conditions, at least the error within the trace"
                }
            };
            add(words.to_owned());
        }
        if traces.mean.stick_slips > 0 {
            let (found, of) = (traces.mean.stick_slips, traces.mean.count);
            add(format!(
                "stick-slip in {found} of {}; the model has no stick-slip of the whole sample",
                counted(of, "repeat")
            ));
        }
        if (1..traces.mean.count).contains(&traces.mean.peaks) {
            let (found, of) = (traces.mean.peaks, traces.mean.count);
            add(format!("a static peak in {found} of {of} repeats only; it is not fitted"));
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
        let words: Vec<String> = grouped(&remarks, ("traces", 23)).into_iter().map(|group| group.words).collect();
        assert_eq!(
            words,
            [
                "2 of 23 traces, the first of them a.csv: friction rises by 0.0199, 7 %, after 1.68 s",
                "a.csv: only 3 different values occur",
                "c.csv: friction falls by 0.0202, 12 %, after 1.70 s",
            ]
        );
    }
}
