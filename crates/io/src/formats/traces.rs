//! Reads and analyses the traces of a calibration's conditions.

use std::ops::Range;
use std::path::{Path, PathBuf};

use slipgrid_base::units::significant;
use slipgrid_infer::calibrate::{Measurement, StaticPeak};
use slipgrid_traces::columns::Titles;
use slipgrid_traces::export::{ExportOptions, Recorded, TraceFile, parse};
use slipgrid_traces::{
    OddRepeat, Repeats, TraceError, TraceFindings, TraceFlag, TraceOptions, analyse, average, friction_loops,
    odd_repeats,
};

use super::measured::Placed;
pub use super::trace_notes::notes;
use crate::formats::file_kind::TableKind;
use crate::formats::source::{Source, read_letters};
use crate::formats::trace_departures::{
    departures, exchanged_coefficient, judge_friction, near_missing_title, near_titles, stands_still,
};
use crate::formats::{Diagnostic, Document};

/// The surface of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Flat surface.
    Flat,
    /// Patterned surface.
    Patterned,
}

slipgrid_base::names!(SurfaceKind { Flat = "flat", Patterned = "patterned" });

/// Trial of a calibration to which traces belong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfTrial {
    /// Number of the trial in the file, counted from 1.
    pub number: usize,
    /// Name of the trial.
    pub name: String,
}

/// An export, and the step in it that belongs to a condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    /// Path of the file.
    pub path: PathBuf,
    /// Step to read, by its number in the export; `None` for the whole file.
    pub step: Option<u32>,
}

impl Export {
    /// The whole file at `path`.
    pub const fn whole(path: PathBuf) -> Self {
        Self { path, step: None }
    }

    /// The name of the file.
    pub(crate) fn name(&self) -> String {
        self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }
}

/// Exports of one condition, and the options for reading them.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceCondition {
    /// Kind of surface: flat or patterned.
    pub surface: SurfaceKind,
    /// Trial to which the sample belongs; `None` for samples outside trials.
    pub trial: Option<OfTrial>,
    /// Nominal normal force on one specimen, in newtons.
    pub force_n: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
    /// Averaging window, in seconds since the first row.
    pub window_s: [f64; 2],
    /// Fraction in the middle of every stroke that is averaged if the sample slides back and forth; `None` for sliding
    /// in one direction.
    pub stroke_share: Option<f64>,
    /// Time span before touchdown, in seconds since the first row, over which mean forces are taken as the zero of the
    /// sensors and subtracted; `None` subtracts nothing.
    pub zero_s: Option<[f64; 2]>,
    /// Rank in the order in which all conditions were measured; `None` if not given.
    pub order: Option<f64>,
    /// Exports, in the order of the calibration file; exports that match one name with `*` are sorted by name.
    pub files: Vec<Export>,
    /// Exports that `exclude` left out.
    pub excluded: Vec<PathBuf>,
}

impl TraceCondition {
    /// Whether `other` is a repeat of this condition: sample, condition and options are equal.
    pub fn is_repeated_by(&self, other: &Self) -> bool {
        let Self { files, excluded, order, .. } = other.clone();
        Self { files, excluded, order, ..self.clone() } == *other
    }

    /// Describes the sample: `flat sample`, or the name of a trial.
    pub fn sample(&self) -> String {
        self.trial
            .as_ref()
            .map_or_else(|| format!("{} sample", self.surface.name()), |trial| format!("trial \"{}\"", trial.name))
    }
}

/// Options for reading all traces of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceSetup {
    /// Distance from the axis to a specimen's centre, in metres; needed for a torque.
    pub effective_radius_m: Option<f64>,
    /// Specimens that share the recorded normal force.
    pub specimens: u32,
    /// Whether to look for a static peak.
    pub static_peak: bool,
    /// Custom titles of columns; known titles of a quantity with a custom title are ignored.
    pub titles: Titles,
}

impl TraceSetup {
    /// Options for traces with known column titles; `effective_radius_m` is in metres.
    pub fn new(effective_radius_m: Option<f64>, specimens: u32, static_peak: bool) -> Self {
        Self { effective_radius_m, specimens, static_peak, titles: Titles::default() }
    }
}

/// One analysed repeat.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadTrace {
    /// Name of the file, with the step if only one step is read, and the number of the repeat if there are several.
    pub label: String,
    /// Results of the analysis.
    pub findings: TraceFindings,
    /// Position in metres and friction coefficient, with its sign, along the last loops of reciprocating sliding; empty
    /// for other traces, and if the position was not recorded.
    pub loops: Vec<[f64; 2]>,
    /// Anomalies, in words.
    pub flags: Vec<String>,
}

/// A condition with its repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionTraces {
    /// The condition.
    pub condition: TraceCondition,
    /// Repeats of the condition.
    pub traces: Vec<ReadTrace>,
    /// Means over the repeats, with standard deviations.
    pub mean: Repeats,
}

impl ConditionTraces {
    /// Converts the condition to a row of a table of measurements; the standard deviations are those for predicting
    /// another sample.
    pub fn measurement(&self) -> Measurement {
        let (condition, mean) = (&self.condition, &self.mean);
        Measurement {
            force_n: condition.force_n,
            speed_m_s: condition.speed_m_s,
            humidity: condition.humidity,
            mu_dynamic: mean.mu_dynamic.mean,
            mu_dynamic_std: mean.mu_dynamic_predictive_std(),
            static_peak: mean
                .mu_static
                .zip(mean.mu_static_predictive_std())
                .map(|(peak, std)| StaticPeak { mu: peak.mean, std }),
        }
    }

    /// Distance slid up to the middle of the averaging window, in metres.
    pub fn sliding_m(&self) -> f64 {
        let [from_s, to_s] = self.condition.window_s;
        0.5 * (from_s + to_s) * self.condition.speed_m_s
    }

    /// Measurement with the file position of the condition, which is at `span` of `document`.
    pub(crate) fn placed(&self, document: &Document, span: &Range<usize>) -> Placed {
        let line = document.refuse(span.clone(), "").line.unwrap_or(1);
        Placed {
            measurement: self.measurement(),
            path: document.path().to_owned(),
            line,
            sliding_m: Some(self.sliding_m()),
            order: self.condition.order,
        }
    }
}

/// Reads and analyses every trace of a condition.
///
/// # Errors
/// [`Diagnostic`] if a file is no export, is given twice or repeats another, or for the first trace that cannot be
/// used, with the number of further unusable traces.
pub fn analyse_condition(
    source: &Source,
    setup: &TraceSetup,
    condition: &TraceCondition,
) -> Result<ConditionTraces, Diagnostic> {
    analyse_among(source, setup, condition, &mut Vec::new())
}

/// A trace that was read earlier, kept to detect a trace that is given twice.
pub(crate) struct Seen {
    /// Label of the trace, as in `ReadTrace`.
    label: String,
    /// Number of samples of the trace.
    samples: usize,
    /// Checksums of the channels: [`TraceChannels::fingerprint`](slipgrid_traces::TraceChannels::fingerprint).
    sums: [u64; 3],
}

/// Reads and analyses every trace of a condition. Compares each trace with the traces `seen` before, and adds the trace
/// to `seen`.
///
/// # Errors
/// Errors of [`analyse_condition`]; a trace seen before is refused as given twice.
pub(crate) fn analyse_among(
    source: &Source,
    setup: &TraceSetup,
    condition: &TraceCondition,
    seen: &mut Vec<Seen>,
) -> Result<ConditionTraces, Diagnostic> {
    let options = TraceOptions {
        window_s: condition.window_s,
        effective_radius_m: setup.effective_radius_m.unwrap_or(f64::NAN),
        nominal_force_n: Some(condition.force_n * f64::from(setup.specimens)),
        speed_m_s: condition.speed_m_s,
        static_peak: setup.static_peak,
        stroke_share: condition.stroke_share,
        zero_s: condition.zero_s,
    };
    let (mut traces, mut names, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    for export in &condition.files {
        let path = &export.path;
        let file = parse_export(export, &read_letters(source, path, "a table of traces")?, setup)?;
        let several = file.repeats.len() > 1;
        let near_titles = near_titles(&file, &setup.titles);
        for repeat in &file.repeats {
            let name = export.name();
            let step = export.step.map(|step| format!("step {step}"));
            let parts: Vec<String> =
                step.into_iter().chain(several.then(|| format!("repeat {}", repeat.number))).collect();
            let which = if parts.is_empty() { String::new() } else { format!("{}: ", parts.join(", ")) };
            let label = [std::slice::from_ref(&name), &parts].concat().join(", ");
            let (samples, sums) = (repeat.channels.time_s.len(), repeat.channels.fingerprint());
            if let Some(Seen { label, .. }) = seen.iter().find(|other| (other.samples, other.sums) == (samples, sums)) {
                let reason = format!("{which}holds the {samples} samples of {label} again: one export given twice");
                return Err(
                    Diagnostic::file(path, reason).expected("each repeat once; remove or replace one of the two")
                );
            }
            seen.push(Seen { label: label.clone(), samples, sums });
            if let Some(reason) = stands_still(condition, repeat) {
                refused.push(Diagnostic::file(path, format!("{which}{reason}")));
                continue;
            }
            match analyse(&repeat.channels, &options) {
                Ok(findings) => {
                    if let Some(reason) = exchanged_coefficient(condition, repeat, &findings) {
                        let expected = "the quantity of each column in its title, or `columns` in [traces]";
                        refused.push(Diagnostic::file(path, format!("{which}{reason}")).expected(expected));
                        continue;
                    }
                    let mut flags: Vec<String> = findings.flags.iter().map(|flag| words_of(flag, repeat)).collect();
                    flags.extend(departures(condition, repeat, &findings, &file));
                    flags.extend_from_slice(&near_titles);
                    let mu = significant(findings.window.mu, 3);
                    match judge_friction(&repeat.channels.tangential, mu, findings.normal_force_n) {
                        Ok(told) => flags.extend(told.map(|reason| format!("mu {mu} {reason}"))),
                        Err(expected) => {
                            let reason = format!("{which}friction is {mu} in the window, which cannot be");
                            let broken = findings.flags.iter().find(|flag| matches!(flag, TraceFlag::Broken { .. }));
                            refused.push(match broken {
                                Some(broken) => {
                                    let reason = format!("{reason}: {}", words_of(broken, repeat));
                                    Diagnostic::file(path, reason).expected("readings of friction and load alone")
                                }
                                None => Diagnostic::file(path, reason).expected(expected),
                            });
                            continue;
                        }
                    }
                    let is_reciprocating = options.stroke_share.is_some();
                    let loops =
                        is_reciprocating.then(|| friction_loops(&repeat.channels, &repeat.position_m, &options));
                    traces.push(ReadTrace { label, findings, loops: loops.unwrap_or_default(), flags });
                    names.push(name);
                }
                Err(error) => refused.push(refuse_trace(path, &which, repeat, &error, options.window_s)),
            }
        }
    }
    let others = refused.len().saturating_sub(1);
    if let Some(mut first) = refused.into_iter().next() {
        if others > 0 {
            first.reason +=
                &format!(" ({} of this condition cannot be used)", slipgrid_base::units::counted(others, "more trace"));
        }
        return Err(first);
    }
    let findings: Vec<TraceFindings> = traces.iter().map(|trace| trace.findings.clone()).collect();
    let friction: Vec<(f64, f64)> = findings.iter().map(|found| (found.window.mu, found.window.stderr)).collect();
    for odd in odd_repeats(&friction) {
        let inside = if traces[odd.index].label == names[odd.index] { "" } else { "its rows removed or " };
        let words = words_of_odd(&odd, friction[odd.index].0, &traces[0].label);
        let exclude = format!("; {inside}`exclude = [\"{}\"]` in its condition leaves it out", names[odd.index]);
        traces[odd.index].flags.push(words + &exclude);
    }
    match average(&findings) {
        Some(mean) => Ok(ConditionTraces { condition: condition.clone(), traces, mean }),
        None => Err(Diagnostic { reason: "no traces were given".into(), ..Diagnostic::default() }),
    }
}

/// Diagnostic for a trace with `error`; if rows without a number caused the error, at these rows.
fn refuse_trace(path: &Path, which: &str, repeat: &Recorded, error: &TraceError, window_s: [f64; 2]) -> Diagnostic {
    let missing = repeat.missing.as_ref();
    match missing.and_then(|missing| Some((&missing.longest, missing.explains(error, window_s)?))) {
        Some((longest, [reason, expected])) => Diagnostic {
            line: Some(longest.lines[0]),
            key: Some(longest.columns.join(", ").into()),
            ..Diagnostic::file(path, format!("{which}{reason}")).expected(expected)
        },
        None => Diagnostic::file(path, format!("{which}{error}")),
    }
}

/// Describes `flag` of `repeat`, with the line of the sample that it concerns.
fn words_of(flag: &TraceFlag, repeat: &Recorded) -> String {
    let line = match flag {
        TraceFlag::Broken { time_s, .. } => repeat.line_at(*time_s),
        _ => None,
    };
    format!("{flag}{}", line.map_or_else(String::new, |line| format!(" (line {line})")))
}

/// Describes how a repeat with the friction `mu` differs from the others; `first` is the label of the first of two
/// repeats.
fn words_of_odd(odd: &OddRepeat, mu: f64, first: &str) -> String {
    let (amount, others) = (100.0 * odd.relative.abs(), odd.others);
    let side = if odd.relative < 0.0 { "below" } else { "above" };
    match odd.others_differ {
        Some(differ) => format!(
            "mu {mu:.4} is {amount:.0} % {side} the mean {others:.4} of the other repeats, which differ by {:.1} %: it may be spoilt, and \
             counts all the same",
            100.0 * differ
        ),
        None => format!(
            "mu {mu:.4} is {amount:.0} % {side} the {others:.4} of {first}: one of the two may be spoilt, and a third repeat would tell which; \
             both count"
        ),
    }
}

/// Reads an export from its `text`; messages name the path of the export.
///
/// # Errors
/// [`Diagnostic`] that names line and column of the refused value.
pub fn parse_export(export: &Export, text: &str, setup: &TraceSetup) -> Result<TraceFile, Diagnostic> {
    let (effective_radius_m, titles) = (setup.effective_radius_m, Some(&setup.titles));
    parse(text, &ExportOptions { effective_radius_m, titles, step: export.step }).map_err(|refused| {
        if let Some(kind) = TableKind::of(text) {
            return Diagnostic::file(&export.path, kind.is_no_recording())
                .expected("a recording of friction over time");
        }
        Diagnostic {
            line: refused.line,
            key: refused.column.map(Into::into),
            suggestion: near_missing_title(text, &setup.titles).filter(|_| refused.value.is_none()).map(Into::into),
            value: refused.value.map(Into::into),
            ..Diagnostic::file(&export.path, refused.reason).expected(refused.expected)
        }
    })
}

#[cfg(test)]
#[path = "traces_tests.rs"]
mod tests;
