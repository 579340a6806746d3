//! The table `[traces]` of a calibration: which exports belong to which condition, and what they say.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipgrid_calibrate::{Measurement, StaticPeak};
use slipgrid_traces::export::{Recorded, TraceFile, parse};
use slipgrid_traces::{
    DEFAULT_STROKE_SHARE, DEFAULT_WINDOW_S, Repeats, TraceFindings, TraceFlag, TraceOptions, analyse, average,
};
use toml::Spanned;

use super::document::Document;
use super::values::{Number, NumberList};
use crate::diagnostic::Diagnostic;
use crate::plausible::FRICTION;
use crate::source::{Entry, Source, read_letters};
use slipgrid_units::{FORCE_N, HUMIDITY_PCT, LENGTH_MM, Quantity, SPEED_MM_S, STROKE_SHARE, TIME_S};

/// `[traces]` as a file writes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracesFile {
    /// Seconds since the first sample between which friction is averaged; [10, 40] when absent.
    window_s: Option<NumberList>,
    /// Distance from the axis to a specimen's centre: mu = torque / (normal force x radius).
    effective_radius_mm: Option<Number>,
    /// Specimens that share the recorded normal force; 1 when absent.
    specimens: Option<Spanned<u64>>,
    /// Look for a static peak at the onset of sliding; true when absent. Not looked for in reciprocating sliding.
    static_peak: Option<bool>,
    /// The sample slides back and forth; false when absent. Friction is half the width of the loop of two strokes.
    reciprocating: Option<bool>,
    /// Share of every stroke, about its middle, that is averaged with `reciprocating`; 0.5 when absent.
    stroke_share: Option<Number>,
    /// One table a condition.
    condition: Spanned<Vec<ConditionFile>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConditionFile {
    /// Normal force on one specimen.
    force_n: Number,
    /// Sliding speed.
    speed_mm_s: Number,
    /// Relative humidity.
    humidity_pct: Number,
    /// `flat` or `patterned`; `flat` when absent.
    surface: Option<Spanned<String>>,
    /// Exports, each once; `*` stands for any letters.
    files: Spanned<Vec<Spanned<String>>>,
}

/// The surface of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Flat.
    Flat,
    /// Patterned.
    Patterned,
}

impl SurfaceKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Flat, Self::Patterned];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Patterned => "patterned",
        }
    }
}

/// How all traces of a calibration are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSetup {
    /// Averaging window, in seconds since the first sample.
    pub window_s: [f64; 2],
    /// Distance from the axis to a specimen's centre, in metres; a torque needs it.
    pub effective_radius_m: Option<f64>,
    /// Specimens that share the recorded normal force.
    pub specimens: u32,
    /// Look for a static peak.
    pub static_peak: bool,
    /// Part in the middle of every stroke that counts where the sample slides back and forth.
    pub stroke_share: Option<f64>,
}

/// Traces of one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceCondition {
    /// Flat or patterned.
    pub surface: SurfaceKind,
    /// Nominal normal force on one specimen, in newtons.
    pub force_n: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
    /// Exports, in the order of their names.
    pub files: Vec<PathBuf>,
}

/// One repeat, read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadTrace {
    /// File, and number in it where there are several.
    pub label: String,
    /// What it says.
    pub findings: TraceFindings,
    /// What is odd, in words.
    pub flags: Vec<String>,
}

/// A condition with its repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionTraces {
    /// The condition.
    pub condition: TraceCondition,
    /// Its repeats.
    pub traces: Vec<ReadTrace>,
    /// Their mean.
    pub mean: Repeats,
}

impl ConditionTraces {
    /// The row of a table of measurements.
    #[must_use]
    pub fn measurement(&self) -> Measurement {
        let (condition, mean) = (&self.condition, &self.mean);
        Measurement {
            force_n: condition.force_n,
            speed_m_s: condition.speed_m_s,
            humidity: condition.humidity,
            mu_dynamic: mean.mu_dynamic.mean,
            mu_dynamic_std: mean.mu_dynamic.std,
            static_peak: mean.mu_static.map(|peak| StaticPeak { mu: peak.mean, std: peak.std }),
        }
    }
}

/// Number of specimens in a holder, at most.
const MOST_SPECIMENS: u64 = 100;
/// Departure of a recorded speed from the nominal one that is told.
const SPEED_OFF: f64 = 0.1;
/// Departure of a recorded humidity that is told.
const HUMIDITY_OFF: f64 = 0.05;

/// Conditions, each with its place in the file.
pub type PlacedConditions = Vec<(Range<usize>, TraceCondition)>;

/// Reads the table; files are looked for.
///
/// # Errors
/// [`Diagnostic`] for anything refused in it.
pub fn read_table(document: &Document, file: &TracesFile) -> Result<(TraceSetup, PlacedConditions), Diagnostic> {
    let window_s =
        file.window_s.as_ref().map_or(Ok(DEFAULT_WINDOW_S), |window| match document.numbers(window, TIME_S)?[..] {
            [from, to] if from < to => Ok([from, to]),
            _ => Err(document.refuse(window.span(), "is no window").expected("two increasing times, [10, 40]")),
        })?;
    let specimens = file.specimens.as_ref().map_or(Ok(1), |count| {
        u32::try_from(*count.get_ref()).ok().filter(|_| (1..=MOST_SPECIMENS).contains(count.get_ref())).ok_or_else(
            || {
                document
                    .refuse(count.span(), "specimens are not held")
                    .expected(format!("a whole number from 1 to {MOST_SPECIMENS}"))
            },
        )
    })?;
    let effective_radius_m = document.optional(file.effective_radius_mm.as_ref(), LENGTH_MM)?;
    if file.condition.get_ref().is_empty() {
        return Err(document.refuse(file.condition.span(), "is empty").expected("at least one [[traces.condition]]"));
    }
    let static_peak = file.static_peak.unwrap_or(true);
    let reciprocating = file.reciprocating.unwrap_or(false);
    let stroke_share = match &file.stroke_share {
        Some(share) if !reciprocating => {
            return Err(document.refuse(share.span(), "needs `reciprocating = true`").expected("both keys or neither"));
        }
        Some(share) => Some(document.number(share, STROKE_SHARE)?),
        None => reciprocating.then_some(DEFAULT_STROKE_SHARE),
    };
    // Every export that was named, with its own place and line.
    let mut named: Vec<(PathBuf, Option<u32>)> = Vec::new();
    let mut conditions = Vec::new();
    for condition in file.condition.get_ref() {
        conditions.push((condition.force_n.span(), read_condition(document, condition, &mut named)?));
    }
    Ok((TraceSetup { window_s, effective_radius_m, specimens, static_peak, stroke_share }, conditions))
}

fn read_condition(
    document: &Document,
    file: &ConditionFile,
    named: &mut Vec<(PathBuf, Option<u32>)>,
) -> Result<TraceCondition, Diagnostic> {
    let surface = file
        .surface
        .as_ref()
        .map_or(Ok(SurfaceKind::Flat), |name| document.choice(name, &SurfaceKind::ALL, SurfaceKind::name))?;
    let number = |value: &Number, quantity: Quantity| document.number(value, quantity);
    let mut files = Vec::new();
    for name in file.files.get_ref() {
        let found = matching(document.source(), &document.resolve(name.get_ref()));
        if found.is_empty() {
            let entry = document.source().entry(&document.resolve(name.get_ref()));
            let what = if entry.is_ok_and(|entry| entry == Entry::Folder) { "is a folder" } else { "names no file" };
            return Err(document.refuse(name.span(), what).expected("an export, or a name with * in it"));
        }
        for path in &found {
            let own = document.source().canonical(path);
            let here = document.refuse(name.span(), "");
            if let Some((_, line)) = named.iter().find(|(other, _)| *other == own) {
                let before = line.map_or_else(String::new, |line| format!(", as line {line} does"));
                let reason = format!("names {} once more{before}: one export is one repeat", path.display());
                return Err(Diagnostic { reason, ..here }.expected("each export once"));
            }
            named.push((own, here.line));
        }
        files.extend(found);
    }
    if files.is_empty() {
        return Err(document.refuse(file.files.span(), "is empty").expected("at least one export"));
    }
    Ok(TraceCondition {
        surface,
        force_n: number(&file.force_n, FORCE_N)?,
        speed_m_s: number(&file.speed_mm_s, SPEED_MM_S)?,
        humidity: number(&file.humidity_pct, HUMIDITY_PCT)?,
        files,
    })
}

/// Files whose names fit `pattern`, in which * stands for any letters of the name; sorted.
fn matching(source: &Source, pattern: &Path) -> Vec<PathBuf> {
    let is_file = |path: &Path| source.entry(path).is_ok_and(|entry| entry == Entry::File);
    let name = pattern.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if !name.contains('*') {
        return if is_file(pattern) { vec![pattern.to_owned()] } else { Vec::new() };
    }
    let parts: Vec<&str> = name.split('*').collect();
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names = source.names(folder);
    let fitting = names.iter().filter(|name| fits(name, &parts) && is_file(&folder.join(name)));
    let mut found: Vec<PathBuf> = fitting.map(|name| pattern.with_file_name(name)).collect();
    found.sort();
    found
}

/// Whether `name` is the parts in their order with anything between them.
fn fits(name: &str, parts: &[&str]) -> bool {
    let [first, middle @ .., last] = parts else { return parts == [name] };
    let Some(mut rest) = name.strip_prefix(first).and_then(|rest| rest.strip_suffix(last)) else { return false };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

/// Reads and analyses every trace of all conditions.
///
/// # Errors
/// As [`analyse_condition`], and for an export that holds what another holds.
pub fn analyse_conditions(
    source: &Source,
    setup: &TraceSetup,
    conditions: &[TraceCondition],
) -> Result<Vec<ConditionTraces>, Diagnostic> {
    let mut seen = Vec::new();
    conditions.iter().map(|condition| analyse_among(source, setup, condition, &mut seen)).collect()
}

/// Reads and analyses every trace of a condition.
///
/// # Errors
/// [`Diagnostic`] for a file that is no export, that is given twice or holds what another holds, or the first trace
/// that cannot be used; how many more there are is said.
pub fn analyse_condition(
    source: &Source,
    setup: &TraceSetup,
    condition: &TraceCondition,
) -> Result<ConditionTraces, Diagnostic> {
    analyse_among(source, setup, condition, &mut Vec::new())
}

/// A trace that was read, by its label, its samples and its fingerprint.
type Seen = (String, usize, [u64; 3]);

fn analyse_among(
    source: &Source,
    setup: &TraceSetup,
    condition: &TraceCondition,
    seen: &mut Vec<Seen>,
) -> Result<ConditionTraces, Diagnostic> {
    let options = TraceOptions {
        window_s: setup.window_s,
        effective_radius_m: setup.effective_radius_m.unwrap_or(f64::NAN),
        nominal_force_n: Some(condition.force_n * f64::from(setup.specimens)),
        speed_m_s: condition.speed_m_s,
        static_peak: setup.static_peak,
        stroke_share: setup.stroke_share,
    };
    let (mut traces, mut refused) = (Vec::new(), Vec::new());
    for path in &condition.files {
        let file = read_export(source, path, setup.effective_radius_m)?;
        let several = file.repeats.len() > 1;
        for repeat in &file.repeats {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let label = if several { format!("{name}, repeat {}", repeat.number) } else { name };
            let which = if several { format!("repeat {}: ", repeat.number) } else { String::new() };
            let (samples, sums) = (repeat.channels.time_s.len(), repeat.channels.fingerprint());
            if let Some((other, ..)) = seen.iter().find(|(_, n, other)| (*n, other) == (samples, &sums)) {
                let reason = format!("{which}holds the {samples} samples of {other} again: one export given twice");
                return Err(
                    Diagnostic::file(path, reason).expected("each repeat once; remove or replace one of the two")
                );
            }
            seen.push((label.clone(), samples, sums));
            if let Some(reason) = stands_still(condition, repeat) {
                refused.push(Diagnostic::file(path, format!("{which}{reason}")));
                continue;
            }
            match analyse(&repeat.channels, &options) {
                Ok(findings) => {
                    let mut flags: Vec<String> = findings.flags.iter().map(TraceFlag::to_string).collect();
                    flags.extend(departures(condition, repeat));
                    let mu = findings.window.mu;
                    match FRICTION.judge(mu) {
                        Ok(told) => flags.extend(told.map(|reason| format!("mu {mu:.4} {reason}"))),
                        Err(expected) => {
                            let reason = format!("{which}friction is {mu:.4} in the window, which cannot be");
                            refused.push(Diagnostic::file(path, reason).expected(format!(
                                "{expected}; the unit of a column stands in its name, as `torque_mnm`"
                            )));
                            continue;
                        }
                    }
                    traces.push(ReadTrace { label, findings, flags });
                }
                Err(error) => refused.push(Diagnostic::file(path, format!("{which}{error}"))),
            }
        }
    }
    let others = refused.len().saturating_sub(1);
    if let Some(mut first) = refused.into_iter().next() {
        if others > 0 {
            let plural = if others == 1 { "" } else { "s" };
            first.reason += &format!(" ({others} more trace{plural} of this condition cannot be used)");
        }
        return Err(first);
    }
    let findings: Vec<TraceFindings> = traces.iter().map(|trace| trace.findings.clone()).collect();
    match average(&findings) {
        Some(mean) => Ok(ConditionTraces { condition: condition.clone(), traces, mean }),
        None => Err(Diagnostic { reason: "no traces were given".into(), ..Diagnostic::default() }),
    }
}

/// Reads the export at `path` of `source`; `effective_radius_m` turns revolutions into speed.
fn read_export(source: &Source, path: &Path, effective_radius_m: Option<f64>) -> Result<TraceFile, Diagnostic> {
    parse_export(path, &read_letters(source, path, "a table of traces")?, effective_radius_m)
}

/// Reads an export from its text; `path` names it in messages.
///
/// # Errors
/// [`Diagnostic`] that names line and column of what was refused.
pub fn parse_export(path: &Path, text: &str, effective_radius_m: Option<f64>) -> Result<TraceFile, Diagnostic> {
    parse(text, effective_radius_m).map_err(|refused| Diagnostic {
        line: refused.line,
        key: refused.column.map(Into::into),
        value: refused.value.map(Into::into),
        ..Diagnostic::file(path, refused.reason).expected(refused.expected)
    })
}

/// Recorded speed over the nominal one below which the drive stood still.
const STILL: f64 = 0.01;

/// Says that a trace was recorded at rest, where it has a column of speed.
fn stands_still(condition: &TraceCondition, repeat: &Recorded) -> Option<String> {
    let speed = repeat.speed_m_s.map(f64::abs).filter(|speed| *speed < STILL * condition.speed_m_s)?;
    let (found, nominal) = (SPEED_MM_S.from_si(speed), SPEED_MM_S.from_si(condition.speed_m_s));
    Some(format!(
        "the recorded speed is {found:.4} mm/s, of {nominal} mm/s: the sample does not slide, or its unit is another"
    ))
}

/// Where recorded speed, humidity and rows are not what the condition says.
fn departures(condition: &TraceCondition, repeat: &Recorded) -> Vec<String> {
    let mut flags = Vec::new();
    if let Some(speed) = repeat.speed_m_s.map(f64::abs).filter(|v| (v / condition.speed_m_s - 1.0).abs() > SPEED_OFF) {
        let (found, nominal) = (SPEED_MM_S.from_si(speed), SPEED_MM_S.from_si(condition.speed_m_s));
        flags.push(format!("the recorded speed is {found:.3} mm/s, not the nominal {nominal}"));
    }
    if let Some(humidity) = repeat.humidity.filter(|h| (h - condition.humidity).abs() > HUMIDITY_OFF) {
        let (found, nominal) = (HUMIDITY_PCT.from_si(humidity), HUMIDITY_PCT.from_si(condition.humidity));
        flags.push(format!("the recorded humidity is {found:.1} %, not the nominal {nominal}"));
    }
    if repeat.repeated_rows > 0 {
        let (count, all) = (repeat.repeated_rows, repeat.repeated_rows + repeat.channels.time_s.len());
        flags.push(format!("{count} of {all} rows repeat the row before them and were left out"));
    }
    if repeat.incomplete_rows > 0 {
        flags.push(format!("{} rows without a number were left out", repeat.incomplete_rows));
    }
    flags
}

/// Notes of a condition for a material's provenance.
#[must_use]
pub fn notes(conditions: &[ConditionTraces]) -> Vec<String> {
    let mut notes = Vec::new();
    for traces in conditions {
        let condition = &traces.condition;
        let place = format!(
            "{} sample, {} N, {} mm/s, {} %",
            condition.surface.name(),
            condition.force_n,
            SPEED_MM_S.from_si(condition.speed_m_s),
            HUMIDITY_PCT.from_si(condition.humidity)
        );
        for trace in &traces.traces {
            notes.extend(trace.flags.iter().map(|flag| format!("{place}, {}: {flag}", trace.label)));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_letters() {
        for (name, pattern, fit) in [
            ("flat-50N-1.csv", "flat-50N-*.csv", true),
            ("flat-50N-1.csv", "*", true),
            ("flat-50N-1.csv", "*50N*1*", true),
            ("flat-150N-1.csv", "flat-50N-*.csv", false),
            ("flat-50N-1.txt", "flat-50N-*.csv", false),
            ("aba", "ab*ba", false),
        ] {
            assert_eq!(fits(name, &pattern.split('*').collect::<Vec<_>>()), fit, "{name} {pattern}");
        }
    }
}
