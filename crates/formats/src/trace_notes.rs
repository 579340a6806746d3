//! Notes of traces: what is odd about those of a calibration, in words.

use slipgrid_traces::TraceFlag;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S};

use super::traces::ConditionTraces;

/// Notes of conditions for a material's provenance: what concerns many traces alike is said once, first.
#[must_use]
pub fn notes(conditions: &[ConditionTraces]) -> Vec<String> {
    let (mut notes, said) = common(conditions);
    for traces in conditions {
        let condition = &traces.condition;
        let place = format!(
            "{}, {} N, {} mm/s, {} %",
            condition.sample(),
            condition.force_n,
            SPEED_MM_S.from_si(condition.speed_m_s),
            HUMIDITY_PCT.from_si(condition.humidity)
        );
        for trace in &traces.traces {
            let own = trace.flags.iter().filter(|flag| !said.contains(*flag));
            notes.extend(own.map(|flag| format!("{place}, {}: {flag}", trace.label)));
        }
        if !condition.excluded.is_empty() {
            let names = condition.excluded.iter().filter_map(|path| path.file_name());
            let names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
            notes.push(format!("{place}: {} left out by `exclude`", names.join(", ")));
        }
        if traces.mean.count == 1 {
            notes
                .push(format!("{place}: one repeat; its deviation is the error within the trace, not between repeats"));
        }
        if traces.mean.stick_slips > 0 {
            let (found, of) = (traces.mean.stick_slips, traces.mean.count);
            notes.push(format!(
                "{place}: stick-slip in {found} of {of} repeat{}; the model has no stick-slip of the whole sample",
                if of == 1 { "" } else { "s" }
            ));
        }
        if (1..traces.mean.count).contains(&traces.mean.peaks) {
            let (found, of) = (traces.mean.peaks, traces.mean.count);
            notes.push(format!("{place}: a static peak in {found} of {of} repeats only; it is not fitted"));
        }
    }
    notes
}

/// Notes for several traces at once, and the flags that they stand for.
fn common(conditions: &[ConditionTraces]) -> (Vec<String>, Vec<String>) {
    let all = || conditions.iter().flat_map(|traces| &traces.traces);
    let of = all().count();
    let (mut notes, mut said) = (Vec::new(), Vec::new());
    let flags = || all().flat_map(|trace| &trace.findings.flags);
    let offsets: Vec<[f64; 2]> = flags()
        .filter_map(|flag| match flag {
            TraceFlag::StrokesDiffer { offset, relative } => Some([*offset, 100.0 * relative.abs()]),
            _ => None,
        })
        .collect();
    if let [[first, share], _, ..] = offsets[..] {
        let range = |part: usize, start: f64| {
            offsets
                .iter()
                .map(|of| of[part])
                .fold([start; 2], |[least, most], value| [least.min(value), most.max(value)])
        };
        let ([least, most], [low, high]) = (range(0, first), range(1, share));
        notes.push(format!(
            "in {} of {of} traces strokes there and back differ by an offset, from {least:+.4} to {most:+.4}, {low:.0} to {high:.0} % of \
             friction: half the width of the loop is taken",
            offsets.len()
        ));
        said.extend(flags().filter(|flag| matches!(flag, TraceFlag::StrokesDiffer { .. })).map(TraceFlag::to_string));
    }
    // What a recording lacks, it lacks in the same words.
    for flag in [TraceFlag::SignNotRecorded, TraceFlag::LoadNotRecorded] {
        let count = flags().filter(|other| **other == flag).count();
        if count > 1 {
            notes.push(format!("in {count} of {of} traces: {flag}"));
            said.push(flag.to_string());
        }
    }
    (notes, said)
}
