//! What the traces of a calibration's conditions say.

use std::ops::Range;
use std::path::{Path, PathBuf};

use slipgrid_calibrate::{Measurement, StaticPeak};
use slipgrid_traces::columns::Titles;
use slipgrid_traces::export::{Recorded, TraceFile, parse};
use slipgrid_traces::{
    OddRepeat, Repeats, TraceError, TraceFindings, TraceFlag, TraceOptions, analyse, average, odd_repeats,
    speed_of_position,
};

use super::document::Document;
use super::measured::Placed;
pub use super::trace_notes::notes;
use crate::diagnostic::Diagnostic;
use crate::plausible::FRICTION;
use crate::source::{Source, read_letters};
use crate::unused_columns::near_titles;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S};

/// Number of specimens in a holder, at most.
pub const MOST_SPECIMENS: u32 = 100;

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
#[derive(Clone, Debug, PartialEq)]
pub struct TraceSetup {
    /// Distance from the axis to a specimen's centre, in metres; a torque needs it.
    pub effective_radius_m: Option<f64>,
    /// Specimens that share the recorded normal force.
    pub specimens: u32,
    /// Look for a static peak.
    pub static_peak: bool,
    /// Titles of columns beside those that are known.
    pub titles: Titles,
}

impl TraceSetup {
    /// Traces with the titles of columns that are known; `effective_radius_m` in metres.
    #[must_use]
    pub fn new(effective_radius_m: Option<f64>, specimens: u32, static_peak: bool) -> Self {
        Self { effective_radius_m, specimens, static_peak, titles: Titles::default() }
    }
}

/// The trial of a calibration that traces belong to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfTrial {
    /// Its number in the file, from 1.
    pub number: usize,
    /// Its name.
    pub name: String,
}

/// Traces of one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceCondition {
    /// Flat or patterned.
    pub surface: SurfaceKind,
    /// The trial that was measured, where it is one.
    pub trial: Option<OfTrial>,
    /// Nominal normal force on one specimen, in newtons.
    pub force_n: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
    /// Averaging window, in seconds since the first row.
    pub window_s: [f64; 2],
    /// Part in the middle of every stroke that counts where the sample slides back and forth.
    pub stroke_share: Option<f64>,
    /// Span before touchdown whose mean forces are subtracted as the sensors' zero, in seconds since the first row.
    pub zero_s: Option<[f64; 2]>,
    /// Exports, in the order of their names.
    pub files: Vec<PathBuf>,
    /// Exports that `exclude` left out.
    pub excluded: Vec<PathBuf>,
}

impl TraceCondition {
    /// Whether `other` is the same condition of the same sample, read in the same way: its exports are further repeats.
    #[must_use]
    pub fn is_repeated_by(&self, other: &Self) -> bool {
        Self { files: other.files.clone(), excluded: other.excluded.clone(), ..self.clone() } == *other
    }

    /// The sample in words: `flat sample`, or the name of a trial.
    #[must_use]
    pub fn sample(&self) -> String {
        self.trial
            .as_ref()
            .map_or_else(|| format!("{} sample", self.surface.name()), |trial| format!("trial \"{}\"", trial.name))
    }
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
    /// The row of a table of measurements; its deviations say how far another sample may be.
    #[must_use]
    pub fn measurement(&self) -> Measurement {
        let (condition, mean) = (&self.condition, &self.mean);
        Measurement {
            force_n: condition.force_n,
            speed_m_s: condition.speed_m_s,
            humidity: condition.humidity,
            mu_dynamic: mean.mu_dynamic.mean,
            mu_dynamic_std: mean.mu_dynamic_of_another(),
            static_peak: mean
                .mu_static
                .zip(mean.mu_static_of_another())
                .map(|(peak, std)| StaticPeak { mu: peak.mean, std }),
        }
    }

    /// The same with its place: the condition at `span` of `document`.
    pub(crate) fn placed(&self, document: &Document, span: &Range<usize>) -> Placed {
        let line = document.refuse(span.clone(), "").line.unwrap_or(1);
        Placed { measurement: self.measurement(), path: document.path().to_owned(), line }
    }
}

/// Departure of a recorded speed from the nominal one that is told.
const SPEED_OFF: f64 = 0.1;
/// The same of a speed that the recorded position says: strokes are not all of one speed.
const POSITION_OFF: f64 = 0.2;
/// Departure of a recorded humidity that is told.
const HUMIDITY_OFF: f64 = 0.05;

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

/// A trace that was read.
pub(crate) struct Seen {
    /// Its file, and its number there.
    label: String,
    /// How many samples it has.
    samples: usize,
    /// [`TraceChannels::fingerprint`](slipgrid_traces::TraceChannels::fingerprint).
    sums: [u64; 3],
}

/// The same among the traces that were `seen` before, to which it adds its own.
///
/// # Errors
/// As [`analyse_condition`]; a trace that was seen is given twice.
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
    let (mut traces, mut refused) = (Vec::new(), Vec::new());
    for path in &condition.files {
        let file = read_export(source, path, setup)?;
        let several = file.repeats.len() > 1;
        let near_titles = near_titles(&file, &setup.titles);
        for repeat in &file.repeats {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let label = if several { format!("{name}, repeat {}", repeat.number) } else { name };
            let which = if several { format!("repeat {}: ", repeat.number) } else { String::new() };
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
                    let mut flags: Vec<String> = findings.flags.iter().map(TraceFlag::to_string).collect();
                    flags.extend(departures(condition, repeat));
                    flags.extend_from_slice(&near_titles);
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
                Err(error) => refused.push(refuse_trace(path, &which, repeat, &error, options.window_s)),
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
    let friction: Vec<(f64, f64)> = findings.iter().map(|found| (found.window.mu, found.window.stderr)).collect();
    for odd in odd_repeats(&friction) {
        let labels = [traces[0].label.clone(), traces[odd.index].label.clone()];
        traces[odd.index].flags.push(words_of_odd(&odd, friction[odd.index].0, &labels));
    }
    match average(&findings) {
        Some(mean) => Ok(ConditionTraces { condition: condition.clone(), traces, mean }),
        None => Err(Diagnostic { reason: "no traces were given".into(), ..Diagnostic::default() }),
    }
}

/// The refusal of a trace with `error`; where rows without a number are to blame, of these.
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

/// Says how a repeat differs from the others, and how it is left out; `first` is the first of two.
fn words_of_odd(odd: &OddRepeat, mu: f64, [first, own]: &[String; 2]) -> String {
    let (amount, others) = (100.0 * odd.relative.abs(), odd.others);
    let side = if odd.relative < 0.0 { "below" } else { "above" };
    let differs = match odd.others_differ {
        Some(differ) => format!(
            "mu {mu:.4} is {amount:.0} % {side} the mean {others:.4} of the other repeats, which differ by {:.1} %: it may be spoilt, and \
             counts all the same",
            100.0 * differ
        ),
        None => format!(
            "mu {mu:.4} is {amount:.0} % {side} the {others:.4} of {first}: one of the two may be spoilt, and a third repeat would tell which; \
             both count"
        ),
    };
    let (file, inside) =
        own.split_once(", repeat ").map_or((own.as_str(), ""), |(file, _)| (file, "its rows removed or "));
    format!("{differs}; {inside}`exclude = [\"{file}\"]` in its condition leaves it out")
}

/// Reads the export at `path` of `source`.
fn read_export(source: &Source, path: &Path, setup: &TraceSetup) -> Result<TraceFile, Diagnostic> {
    parse_export(path, &read_letters(source, path, "a table of traces")?, setup)
}

/// Reads an export from its text; `path` names it in messages.
///
/// # Errors
/// [`Diagnostic`] that names line and column of what was refused.
pub fn parse_export(path: &Path, text: &str, setup: &TraceSetup) -> Result<TraceFile, Diagnostic> {
    parse(text, setup.effective_radius_m, &setup.titles).map_err(|refused| Diagnostic {
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
    let moved = speed_of_position(
        &repeat.channels.time_s,
        repeat.channels.start_s,
        &repeat.position_m,
        condition.window_s,
        condition.stroke_share.is_some(),
    );
    // A position that hardly changes is not that of sliding: where a pin stands on its disc, or how far it is worn.
    let moved = moved.map(|speed| speed / condition.speed_m_s).filter(|ratio| *ratio > STILL);
    if let Some(ratio) = moved.filter(|ratio| (ratio - 1.0).abs() > POSITION_OFF) {
        let nominal = SPEED_MM_S.from_si(condition.speed_m_s);
        let found = ratio * nominal;
        flags.push(format!(
            "the recorded position moves at {found:.3} mm/s in the window, not at the nominal {nominal}: speed, its unit or that of the \
             position is wrong"
        ));
    }
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
