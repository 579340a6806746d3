//! Tables and pictures of tribometer traces.

use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_MM, SPEED_MM_S, tidy};
use slipgrid_design::results::{SCHEMA, Table, VERSION, fixed, guard_formula};
use slipgrid_infer::calibrate::Measurement;
use slipgrid_io::formats::measurements;
use slipgrid_io::formats::traces::{ConditionTraces, OfTrial, ReadTrace, SurfaceKind, TraceCondition, notes};
use slipgrid_traces::{DEFAULT_WINDOW_S, TraceFindings};

use crate::charts::{RepeatTrace, Series, friction_loops, tribometer};
use crate::pictures::name_part;
use crate::{ChartError, Outputs};

/// Makes the tables and pictures of all `conditions`, by file name.
///
/// # Errors
/// [`ChartError`] if a picture cannot be drawn.
pub fn files(conditions: &[ConditionTraces]) -> Result<Outputs, ChartError> {
    let mut outputs = Outputs::default();
    for kind in SurfaceKind::ALL {
        let is_own = |traces: &&ConditionTraces| traces.condition.surface == kind && traces.condition.trial.is_none();
        let of_kind: Vec<&ConditionTraces> = conditions.iter().filter(is_own).collect();
        if !of_kind.is_empty() {
            let table = measured(&format!("{} samples", kind.name()), &of_kind);
            outputs.add(format!("{}.csv", kind.name()), table);
        }
    }
    for of_trial in conditions.chunk_by(|a, b| a.condition.trial == b.condition.trial) {
        if let Some(OfTrial { number, name }) = &of_trial[0].condition.trial {
            // A spreadsheet splits the comment at commas: no part may begin like a formula.
            let words: String =
                name.chars().filter(|c| !c.is_control()).map(|c| if ",;".contains(c) { ' ' } else { c }).collect();
            let table = measured(&format!("trial \"{words}\""), &of_trial.iter().collect::<Vec<_>>());
            outputs.add(format!("trial-{number}-measured.csv"), table);
        }
    }
    outputs.add("traces.csv", table(conditions));
    let mut names: Vec<String> = Vec::new();
    for traces in conditions {
        let own = name(&traces.condition, "");
        // One condition may be read twice, with two averaging windows.
        let again = match names.iter().filter(|other| **other == own).count() {
            0 => String::new(),
            before => format!("-{}", before + 1),
        };
        outputs.add(format!("{own}{again}.svg"), picture(traces)?);
        if let Some(loops) = loops(traces)? {
            outputs.add(format!("{}{again}.svg", name(&traces.condition, LOOPS)), loops);
        }
        names.push(own);
    }
    Ok(outputs)
}

/// Table of what was measured of `samples` in `conditions`, for a calibration.
fn measured(samples: &str, conditions: &[&ConditionTraces]) -> String {
    let rows: Vec<Measurement> = conditions.iter().map(|traces| traces.measurement()).collect();
    let comment = format!(
        "By slipgrid traces {VERSION}, schema {SCHEMA}: {samples}, mean of repeats, and how far another sample may be as a standard deviation{}",
        static_parts(conditions)
    );
    measurements::table(&comment, &rows)
}

/// Comments of a table that list the error sources of static friction; empty if no condition has a static peak.
fn static_parts(conditions: &[&ConditionTraces]) -> String {
    let of_condition = |traces: &&ConditionTraces| {
        let (peak, missed) = traces.mean.mu_static.zip(traces.mean.mu_static_missed)?;
        let [_, force, speed, humidity] = words(&traces.condition);
        Some(format!(
            "\n# {force} N, {speed} mm/s, {humidity} %: mu_static_std is {:.4}, the root of the sum of the squares of {:.4}, by {}, and \
             {missed:.4}, what sampling may have missed of the peak",
            traces.mean.mu_static_predictive_std()?,
            peak.predictive_std(traces.mean.count),
            if traces.mean.count > 1 { "the standard deviation of repeats" } else { "the noise of the one trace" },
        ))
    };
    let all: Vec<String> = conditions.iter().filter_map(of_condition).collect();
    if all.is_empty() {
        return String::new();
    }
    format!("; mu_static_std holds what sampling may have missed as well{}", all.concat())
}

/// Texts that identify a condition: surface or number of the trial, force in N, speed in mm/s and humidity in per cent.
fn words(condition: &TraceCondition) -> [String; 4] {
    [
        match &condition.trial {
            Some(trial) => format!("trial-{}", trial.number),
            None => condition.surface.name().to_owned(),
        },
        condition.force_n.to_string(),
        SPEED_MM_S.from_si(condition.speed_m_s).to_string(),
        HUMIDITY_PCT.from_si(condition.humidity).to_string(),
    ]
}

/// Part of the file name of a picture of friction against position.
pub(crate) const LOOPS: &str = "loops-";

/// File name without extension of a picture for a condition, for example `flat-200N-2mm_s-15pct`; `kind` is empty or
/// `LOOPS`.
fn name(condition: &TraceCondition, kind: &str) -> String {
    let [surface, ..] = words(condition);
    let numbers =
        [condition.force_n, SPEED_MM_S.from_si(condition.speed_m_s), HUMIDITY_PCT.from_si(condition.humidity)];
    let [force, speed, humidity] = numbers.map(name_part);
    format!("{surface}-{kind}{force}N-{speed}mm_s-{humidity}pct")
}

fn title(condition: &TraceCondition) -> String {
    let ([_, force, speed, humidity], sample) = (words(condition), condition.sample());
    format!("{sample}, {force} N, {speed} mm/s, {humidity} % humidity")
}

fn picture<'a>(traces: &'a ConditionTraces) -> Result<String, ChartError> {
    let repeat = |trace: &'a ReadTrace| {
        let points = trace.findings.time_s.iter().zip(&trace.findings.mu).map(|(&t, &mu)| [t, mu]).collect();
        RepeatTrace {
            series: Series { label: &trace.label, points },
            mu_dynamic: trace.findings.window.mu,
            static_peak: trace.findings.static_peak.map(|peak| [peak.time_s, peak.mu]),
        }
    };
    let repeats: Vec<RepeatTrace<'_>> = traces.traces.iter().map(repeat).collect();
    let window_s = traces.traces.first().map_or(DEFAULT_WINDOW_S, |trace| trace.findings.window_s);
    let title = format!("Friction in time: {}", title(&traces.condition));
    tribometer(&title, window_s, &repeats)
}

/// Draws friction against position; `None` for sliding in one direction, and where no position was recorded.
fn loops(traces: &ConditionTraces) -> Result<Option<String>, ChartError> {
    let recorded = traces.traces.iter().filter(|trace| !trace.loops.is_empty());
    let in_mm = |trace: &ReadTrace| trace.loops.iter().map(|[x_m, mu]| [LENGTH_MM.from_si(*x_m), *mu]).collect();
    let repeats: Vec<Series<'_>> = recorded.map(|trace| Series { label: &trace.label, points: in_mm(trace) }).collect();
    if repeats.is_empty() {
        return Ok(None);
    }
    friction_loops(&format!("Friction against position: {}", title(&traces.condition)), &repeats).map(Some)
}

/// Formats the values read from all traces as CSV, one row per repeat.
fn table<'a>(conditions: &'a [ConditionTraces]) -> String {
    let quoted = |text: &str| format!("\"{}\"", guard_formula(text).replace('"', "'"));
    let of_condition = |of: &'a ConditionTraces| of.traces.iter().map(|trace| (words(&of.condition), trace));
    let rows: Vec<([String; 4], &ReadTrace)> = conditions.iter().flat_map(of_condition).collect();
    let mut table = Table::of(&rows);
    for (place, name) in ["surface", "force_n", "speed_mm_s", "humidity_pct"].into_iter().enumerate() {
        table.column(name, |(condition, _)| condition[place].clone());
    }
    table.column("trace", |(_, of)| quoted(&of.label));
    table.numbers("mu_dynamic", |(_, of)| tidy(of.findings.window.mu));
    table.numbers("mu_dynamic_stderr", |(_, of)| tidy(of.findings.window.stderr));
    table.numbers("drift", |(_, of)| tidy(of.findings.window.drift));
    table.numbers("drift_stderr", |(_, of)| tidy(of.findings.window.drift_stderr));
    table.numbers("mu_static", |(_, of)| of.findings.static_peak.map(|peak| tidy(peak.mu)));
    table.numbers("mu_static_time_s", |(_, of)| of.findings.static_peak.map(|peak| tidy(peak.time_s)));
    table.numbers("stick_slip_amplitude", |(_, of)| of.findings.stick_slip.map(|slip| tidy(slip.amplitude)));
    table.numbers("stick_slip_period_s", |(_, of)| of.findings.stick_slip.map(|slip| tidy(slip.period_s)));
    table.numbers("stick_slips", |(_, of)| of.findings.stick_slip.map(|slip| slip.slips as f64));
    table.numbers("normal_force_n", |(_, of)| tidy(of.findings.normal_force_n));
    table.column("flags", |(_, of)| quoted(&of.flags.join("; ")));
    table.table().csv()
}

/// Formats the values read from the traces as text, one table per condition.
pub fn summary(conditions: &[ConditionTraces]) -> String {
    let mut text = String::new();
    for traces in conditions {
        text += &format!("{}\n", title(&traces.condition));
        let mean = &traces.mean;
        // The last row has the mean of the repeats.
        let rows: Vec<Option<&ReadTrace>> = traces.traces.iter().map(Some).chain([None]).collect();
        let of_trace = |digits: usize, value: fn(&TraceFindings) -> Option<f64>| {
            move |of: &Option<&ReadTrace>| of.map_or_else(String::new, |of| fixed(value(&of.findings), digits))
        };
        let of_mean =
            |value: f64| move |of: &Option<&ReadTrace>| of.map_or_else(|| fixed(Some(value), 4), |_| String::new());
        let mut table = Table::of(&rows);
        table.column("trace", |of| of.map_or_else(|| format!("mean of {}", mean.count), |of| of.label.clone()));
        table.column("mu", |of| fixed(Some(of.map_or(mean.mu_dynamic.mean, |of| of.findings.window.mu)), 4));
        table.column("error of mu", of_trace(4, |found| Some(found.window.stderr)));
        table.column("std of repeats", of_mean(mean.mu_dynamic.std));
        table.column("of another", of_mean(mean.mu_dynamic_predictive_std()));
        table.column("drift %", of_trace(1, |found| Some(100.0 * found.window.drift / found.window.mu)));
        let peak = |of: &ReadTrace| of.findings.static_peak.map(|peak| peak.mu);
        table.column("static peak", |of| fixed(of.map_or(mean.mu_static.map(|peak| peak.mean), peak), 4));
        table.column("at s", of_trace(2, |found| found.static_peak.map(|peak| peak.time_s)));
        table.column("slip", of_trace(4, |found| found.stick_slip.map(|slip| slip.amplitude)));
        table.column("period s", of_trace(2, |found| found.stick_slip.map(|slip| slip.period_s)));
        text += &format!("{}\n", table.table());
    }
    text + &crate::marked("-", notes(conditions))
}
