//! The tables `[traces]` of a calibration and `[[trial.traces]]` of a trial, in their serialized form.

use std::ops::Range;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::statistics::upper_median;
use slipgrid_model::material::Condition;
use slipgrid_traces::columns::{Channel, Titles};
use slipgrid_traces::{DEFAULT_STROKE_SHARE, DEFAULT_WINDOW_S, Repeats, moderate};

use super::calibration_file::CalibrationFile;
use super::friction::read_condition;
use super::measurements::ORDER;
use super::stated_specimen::read_count;
use super::traces::{
    ConditionTraces, Export, OfTrial, ReadTrace, Seen, SurfaceKind, TraceCondition, TraceSetup, analyse_among,
};
use super::values::{Number, NumberList, interval};
use crate::formats::plausible::RELATIVE_DEVIATION;
use crate::formats::source::{Entry, Source, fits};
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{FORCE_N, LENGTH_MM, STROKE_SHARE, TIME_S};

/// The table `[traces]` of a calibration file.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracesFile {
    /// Seconds since the first row between which friction is averaged; [10, 40] when absent.
    window_s: Option<NumberList>,
    /// Distance from the axis to a specimen's centre, needed for a torque: mu = torque / (normal force x radius).
    effective_radius_mm: Option<Number>,
    /// Specimens that share the recorded normal force; 1 when absent.
    specimens: Option<Spanned<u64>>,
    /// Whether to look for a static peak at the onset of sliding; true when absent. In reciprocating sliding no peak is
    /// looked for.
    static_peak: Option<bool>,
    /// The sample slides back and forth; false when absent. Friction is half the width of the loop of two strokes.
    reciprocating: Option<bool>,
    /// Fraction of every stroke, about its middle, that is averaged with `reciprocating`; 0.5 when absent.
    stroke_share: Option<Number>,
    /// Seconds since the first row, before touchdown, between which the mean normal force and friction force (or
    /// torque) are taken as the zero of the sensors and subtracted; without the key, nothing is subtracted.
    zero_s: Option<NumberList>,
    /// Titles of columns that are not among the known ones, as `{ friction_force = "F_tan", normal_force = "F_norm
    /// [mN]" }`; the known titles of the quantity are then ignored. `#2` behind a title selects the second column with
    /// this title, and `none` states that no column holds the quantity.
    columns: Option<ColumnsFile>,
    /// One table per condition; needed unless a trial has `[[trial.traces]]`.
    condition: Option<Spanned<Vec<TraceConditionFile>>>,
}

/// Custom titles of columns of exports, with units as in an export; the known titles of the same quantity are then
/// ignored. `#2` behind a title selects the second column with this title, and `none` states that no column holds the
/// quantity.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnsFile {
    /// Title of the time column; a unit in brackets applies if the column has no unit, otherwise s.
    time: Option<Spanned<String>>,
    /// Title of the torque column; in N m if no unit is stated.
    torque: Option<Spanned<String>>,
    /// Title of the friction force column; in N if no unit is stated.
    friction_force: Option<Spanned<String>>,
    /// Title of the friction coefficient column.
    friction_coefficient: Option<Spanned<String>>,
    /// Title of the normal force column; in N if no unit is stated.
    normal_force: Option<Spanned<String>>,
    /// Title of the sliding speed column; in mm/s if no unit is stated.
    speed: Option<Spanned<String>>,
    /// Title of the revolutions column; in rpm if no unit is stated.
    revolutions: Option<Spanned<String>>,
    /// Title of the relative humidity column; in % if no unit is stated.
    humidity: Option<Spanned<String>>,
    /// Title of the column with the number of the repeat.
    repeat: Option<Spanned<String>>,
    /// Title of the column with the number of the step.
    step: Option<Spanned<String>>,
    /// Title of the column with the position along the sliding path, which is not read if no unit is stated.
    position: Option<Spanned<String>>,
}

impl ColumnsFile {
    fn titles(&self, document: &Document) -> Result<Titles, Diagnostic> {
        let mut titles = Titles::default();
        for (channel, title) in [
            (Channel::Time, &self.time),
            (Channel::Torque, &self.torque),
            (Channel::FrictionForce, &self.friction_force),
            (Channel::Coefficient, &self.friction_coefficient),
            (Channel::NormalForce, &self.normal_force),
            (Channel::Speed, &self.speed),
            (Channel::Revolutions, &self.revolutions),
            (Channel::Humidity, &self.humidity),
            (Channel::Repeat, &self.repeat),
            (Channel::Step, &self.step),
            (Channel::Position, &self.position),
        ] {
            let Some(title) = title else { continue };
            if !title.get_ref().contains(char::is_alphanumeric) {
                return Err(document
                    .refuse(title.span(), "is no title")
                    .expected("letters or digits of the title of a column"));
            }
            titles.name(channel, title.get_ref()).map_err(|unknown| {
                let [reason, expected] = unknown.words();
                document.refuse(title.span(), reason).expected(expected)
            })?;
        }
        Ok(titles)
    }
}

/// Exports of one condition; further tables of the condition are repeats.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TraceConditionFile {
    /// Normal force on one specimen.
    force_n: Number,
    /// Sliding speed.
    speed_mm_s: Number,
    /// Relative humidity; if humidity was not measured, give one number in all conditions.
    humidity_pct: Number,
    /// Surface of the sample, `flat` or `patterned`; `flat` when absent, but `patterned` in a trial.
    surface: Option<Spanned<String>>,
    /// Exports, each once; `*` stands for any letters.
    files: Spanned<Vec<Spanned<String>>>,
    /// Rank of the measurement of this condition in the order of all measurements, counted from 1; unknown when absent.
    order: Option<Number>,
    /// Step of the exports to read, by its number in the export, or counted from 1 if steps are not numbered; the whole
    /// export when absent.
    step: Option<Spanned<u64>>,
    /// Exports of `files` that are left out, such as a spoilt repeat; `*` stands for any letters.
    exclude: Option<Vec<Spanned<String>>>,
    /// Seconds between which friction of this condition is averaged; as `[traces]` says when absent.
    window_s: Option<NumberList>,
    /// The sample slides back and forth in this condition; as `[traces]` says when absent.
    reciprocating: Option<bool>,
    /// Fraction of every stroke that is averaged in this condition; as `[traces]` says when absent.
    stroke_share: Option<Number>,
    /// Seconds between which the zero of the sensors is read in this condition; as `[traces]` says when absent.
    zero_s: Option<NumberList>,
}

/// Conditions, each with its file position.
pub(crate) type PlacedConditions = Vec<(Range<usize>, TraceCondition)>;

/// Time span of the sensors' zero, in seconds since the first row, and the file position of its key.
type Zero = ([f64; 2], Range<usize>);

/// Reads the traces of a calibration, each export once.
pub(crate) struct TraceReader<'d> {
    document: &'d Document,
    /// Options for reading the exports.
    pub(crate) setup: TraceSetup,
    window_s: [f64; 2],
    reciprocating: bool,
    stroke_share: Option<f64>,
    /// Times between which the zero of the sensors is read, in seconds since the first row, with the file position of
    /// the key; `None` if `[traces]` states none.
    zero_s: Option<Zero>,
    /// Every export named so far, with the line of the file that names it.
    named: Vec<(Export, Option<u32>)>,
    /// Every trace read so far.
    seen: Vec<Seen>,
}

impl<'d> TraceReader<'d> {
    /// Reads the options of the table `[traces]` of the `calibration`, which hold for all its traces.
    ///
    /// # Errors
    /// [`Diagnostic`] for any refused input.
    pub(crate) fn new(document: &'d Document, calibration: &CalibrationFile) -> Result<Self, Diagnostic> {
        let none = TracesFile::default();
        let file = calibration.traces.as_ref().map_or(&none, Spanned::get_ref);
        let window_s = read_window(document, file.window_s.as_ref())?;
        let specimens = file.specimens.as_ref().map_or(Ok(1), |count| read_count(document, count))?;
        let zero_s = read_zero(document, file.zero_s.as_ref())?;
        let effective_radius_m = document.optional(file.effective_radius_mm.as_ref(), LENGTH_MM)?;
        let reciprocating = file.reciprocating.unwrap_or(false);
        let turns = |condition: &TraceConditionFile| condition.reciprocating == Some(true);
        let of_trials = calibration.trial.iter().filter_map(|trial| trial.get_ref().traces.as_ref());
        let mut all = file.condition.iter().chain(of_trials).flat_map(Spanned::get_ref).peekable();
        // Options may wait for the traces that they are for.
        let some_turn = reciprocating || all.peek().is_none() || all.any(turns);
        if let Some(share) = file.stroke_share.as_ref().filter(|_| !some_turn) {
            return Err(needs_reciprocating(document, share));
        }
        Ok(Self {
            document,
            setup: TraceSetup {
                effective_radius_m,
                specimens,
                static_peak: file.static_peak.unwrap_or(true),
                titles: file.columns.as_ref().map_or(Ok(Titles::default()), |columns| columns.titles(document))?,
            },
            window_s: window_s.unwrap_or(DEFAULT_WINDOW_S),
            reciprocating,
            stroke_share: document.optional(file.stroke_share.as_ref(), STROKE_SHARE)?,
            zero_s,
            named: Vec::new(),
            seen: Vec::new(),
        })
    }

    /// Reads the conditions of the table `[traces]` and checks that files exist. If `needed`, because nothing else has the
    /// flat samples or traces for its options, a table without conditions is refused.
    ///
    /// # Errors
    /// [`Diagnostic`] for any refused input.
    pub(crate) fn table(&mut self, table: &Spanned<TracesFile>, needed: bool) -> Result<PlacedConditions, Diagnostic> {
        match &table.get_ref().condition {
            Some(list) => self.conditions(list, None),
            None if needed => {
                Err(self.document.missing(table.span(), "condition").expected("at least one [[traces.condition]]"))
            }
            None => Ok(Vec::new()),
        }
    }

    /// Reads the conditions in the list of `trial`, or of `[traces]` if `None`, and checks that files exist. Exports of
    /// a condition that is named several times, for example once per repeat, are joined.
    ///
    /// # Errors
    /// [`Diagnostic`] for any refused input.
    pub(crate) fn conditions(
        &mut self,
        list: &Spanned<Vec<TraceConditionFile>>,
        trial: Option<&OfTrial>,
    ) -> Result<PlacedConditions, Diagnostic> {
        if list.get_ref().is_empty() {
            let table = if trial.is_some() { "trial.traces" } else { "traces.condition" };
            let refused = self.document.refuse(list.span(), "is empty");
            return Err(refused.expected(format!("at least one [[{table}]]")));
        }
        let mut all = PlacedConditions::new();
        for file in list.get_ref() {
            let found = self.condition(file, trial)?;
            match all.iter_mut().find(|(_, other)| other.is_repeated_by(&found)) {
                Some((_, other)) => {
                    other.files.extend(found.files);
                    other.excluded.extend(found.excluded);
                }
                None => all.push((file.force_n.span(), found)),
            }
        }
        Ok(all)
    }

    /// Reads and analyses every trace of `conditions`; the scatter of each condition is shrunk towards that of the
    /// other conditions on the same kind of surface.
    ///
    /// # Errors
    /// Errors of [`analyse_condition`](super::traces::analyse_condition), also for an export with the content of an
    /// earlier export.
    pub(crate) fn analyse(
        &mut self,
        conditions: &[(Range<usize>, TraceCondition)],
    ) -> Result<Vec<ConditionTraces>, Diagnostic> {
        let (found, refused) = self.analyse_readable(conditions);
        let scattered = || self.scattered(&found, conditions);
        match refused.into_iter().next().or_else(scattered) {
            Some(refused) => Err(refused),
            None => Ok(found),
        }
    }

    /// Refuses the trace that is farthest from the median of its kind of surface if repeats scatter so much that a
    /// standard deviation, which conditions share, cannot be one of friction; `None` otherwise.
    fn scattered(
        &self,
        found: &[ConditionTraces],
        conditions: &[(Range<usize>, TraceCondition)],
    ) -> Option<Diagnostic> {
        let most = RELATIVE_DEVIATION.measurable[1];
        let is_wide = |mean: &Repeats| mean.mu_dynamic_predictive_std() > most * mean.mu_dynamic.mean;
        let wide = found.iter().find(|traces| is_wide(&traces.mean))?;
        let alike = found.iter().zip(conditions).filter(|(own, _)| own.condition.surface == wide.condition.surface);
        let alike: Vec<(&ReadTrace, &Range<usize>)> =
            alike.flat_map(|(traces, (span, _))| traces.traces.iter().map(move |trace| (trace, span))).collect();
        let mut friction: Vec<f64> = alike.iter().map(|(trace, _)| trace.findings.window.mu).collect();
        let usual = upper_median(&mut friction)?;
        let off = |trace: &ReadTrace| (trace.findings.window.mu / usual).ln().abs();
        let (trace, span) = alike.into_iter().max_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        let reason = format!(
            "has mu {:.4} in {}, of {usual:.4} in the median of its surface: repeats scatter by more than their mean",
            trace.findings.window.mu, trace.label
        );
        let refused = Diagnostic { key: None, value: None, ..self.document.refuse(span.clone(), reason) };
        Some(refused.expected("repeats that agree, or `exclude` in this condition"))
    }

    /// Like [`Self::analyse`], but continues after a refused condition. Returns the analysed conditions and the
    /// refusals.
    pub(crate) fn analyse_readable(
        &mut self,
        conditions: &[(Range<usize>, TraceCondition)],
    ) -> (Vec<ConditionTraces>, Vec<Diagnostic>) {
        let source = self.document.source();
        let (mut found, mut refused) = (Vec::new(), Vec::new());
        for (_, condition) in conditions {
            match analyse_among(source, &self.setup, condition, &mut self.seen) {
                Ok(traces) => found.push(traces),
                Err(reason) => refused.push(reason),
            }
        }
        for kind in SurfaceKind::ALL {
            let alike = found.iter_mut().filter(|traces| traces.condition.surface == kind);
            moderate(&mut alike.map(|traces| &mut traces.mean).collect::<Vec<_>>());
        }
        (found, refused)
    }

    fn condition(&mut self, file: &TraceConditionFile, trial: Option<&OfTrial>) -> Result<TraceCondition, Diagnostic> {
        let document = self.document;
        let usual = if trial.is_some() { SurfaceKind::Patterned } else { SurfaceKind::Flat };
        let surface = file.surface.as_ref();
        let surface = surface.map_or(Ok(usual), |name| document.choice(name, &SurfaceKind::ALL, SurfaceKind::name))?;
        if let Some(name) = file.surface.as_ref().filter(|_| trial.is_some() && surface == SurfaceKind::Flat) {
            return Err(document
                .refuse(name.span(), "is not the surface of a trial")
                .expected("\"patterned\" or no key; flat samples stand in [[traces.condition]]"));
        }
        let force_n = document.number(&file.force_n, FORCE_N)?;
        let Condition { speed_m_s, humidity } = read_condition(document, &file.speed_mm_s, &file.humidity_pct)?;
        let window_s = read_window(document, file.window_s.as_ref())?.unwrap_or(self.window_s);
        let stroke_share = match (&file.stroke_share, file.reciprocating.unwrap_or(self.reciprocating)) {
            (Some(share), false) => return Err(needs_reciprocating(document, share)),
            (None, false) => None,
            (Some(share), true) => Some(document.number(share, STROKE_SHARE)?),
            (None, true) => Some(self.stroke_share.unwrap_or(DEFAULT_STROKE_SHARE)),
        };
        let zero = read_zero(document, file.zero_s.as_ref())?.or_else(|| self.zero_s.clone());
        if let Some((_, place)) = zero.as_ref().filter(|([_, to_s], _)| *to_s > window_s[0]) {
            let reason = format!("reaches into the averaging window, which begins at {} s", window_s[0]);
            return Err(document
                .refuse(place.clone(), reason)
                .expected(format!("a span before touchdown, that ends at {} s or before", window_s[0])));
        }
        let zero_s = zero.map(|(span_s, _)| span_s);
        let step = file.step.as_ref().map(|step| read_step(document, step)).transpose()?;
        let (files, excluded) = self.files(&file.files, file.exclude.as_deref().unwrap_or_default(), step)?;
        Ok(TraceCondition {
            surface,
            trial: trial.cloned(),
            force_n,
            speed_m_s,
            humidity,
            window_s,
            stroke_share,
            zero_s,
            order: document.optional(file.order.as_ref(), ORDER)?,
            files,
            excluded,
        })
    }

    /// Finds the exports of a list. Returns the exports to be used, and the paths of those that `exclude` leaves out.
    fn files(
        &mut self,
        list: &Spanned<Vec<Spanned<String>>>,
        exclude: &[Spanned<String>],
        step: Option<u32>,
    ) -> Result<(Vec<Export>, Vec<PathBuf>), Diagnostic> {
        let document = self.document;
        let mut files = Vec::new();
        for name in list.get_ref() {
            let found = matching(document.source(), &document.resolve(name.get_ref()));
            if found.is_empty() {
                let what = match document.source().entry(&document.resolve(name.get_ref())) {
                    Ok(Entry::Folder) => "is a folder",
                    _ => "names no file",
                };
                return Err(document.refuse(name.span(), what).expected("an export, or a name with * in it"));
            }
            for path in &found {
                let own = Export { path: document.source().canonical(path), step };
                let here = document.refuse(name.span(), "");
                // Other steps of an export are separate traces.
                let is_same = |other: &Export| {
                    other.path == own.path && (other.step == own.step || other.step.is_none() || own.step.is_none())
                };
                if let Some((_, line)) = self.named.iter().find(|(other, _)| is_same(other)) {
                    let before = line.map_or_else(String::new, |line| format!(", as line {line} does"));
                    let reason = format!("names {} once more{before}: one export is one repeat", path.display());
                    return Err(Diagnostic { reason, ..here }.expected("each export once"));
                }
                self.named.push((own, here.line));
            }
            files.extend(found);
        }
        if files.is_empty() {
            return Err(document.refuse(list.span(), "is empty").expected("at least one export"));
        }
        let mut excluded = Vec::new();
        for name in exclude {
            // A plain file name applies in the folder of any export, as messages show it.
            let pattern = document.resolve(name.get_ref());
            let is_named = |path: &PathBuf| {
                path.file_name().is_some_and(|file| fits(&file.to_string_lossy(), name.get_ref()))
                    || matching(document.source(), &pattern).contains(path)
            };
            let named: Vec<PathBuf> = files.extract_if(.., |path| is_named(path)).collect();
            if named.is_empty() {
                let expected = "the name of an export that `files` names, each once";
                return Err(document.refuse(name.span(), "leaves out none of the files").expected(expected));
            }
            excluded.extend(named);
        }
        if files.is_empty() {
            let expected = "an `exclude` that leaves at least one export";
            return Err(document.refuse(list.span(), "is left out as a whole").expected(expected));
        }
        Ok((files.into_iter().map(|path| Export { path, step }).collect(), excluded))
    }
}

fn read_step(document: &Document, step: &Spanned<u64>) -> Result<u32, Diagnostic> {
    u32::try_from(*step.get_ref()).map_err(|_| {
        document.refuse(step.span(), "is no number of a step").expected("a whole number, as exports give it")
    })
}

fn needs_reciprocating(document: &Document, share: &Number) -> Diagnostic {
    document.refuse(share.span(), "needs `reciprocating = true`").expected("both keys or neither")
}

fn read_window(document: &Document, window: Option<&NumberList>) -> Result<Option<[f64; 2]>, Diagnostic> {
    interval(document, window, TIME_S, ["is no window", "two increasing times, [10, 40]"])
}

fn read_zero(document: &Document, zero: Option<&NumberList>) -> Result<Option<Zero>, Diagnostic> {
    let words = ["is no span of time", "two increasing times before touchdown, [0, 2]"];
    Ok(interval(document, zero, TIME_S, words)?.zip(zero.map(Spanned::span)))
}

/// Files whose names match `pattern`, in which * stands for any characters of the name, sorted by path.
fn matching(source: &Source, pattern: &Path) -> Vec<PathBuf> {
    let is_file = |path: &Path| source.entry(path).is_ok_and(|entry| entry == Entry::File);
    let name = pattern.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if !name.contains('*') {
        return if is_file(pattern) { vec![pattern.to_owned()] } else { Vec::new() };
    }
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names = source.names(folder);
    let fitting = names.iter().filter(|own| fits(own, &name) && is_file(&folder.join(own)));
    let mut found: Vec<PathBuf> = fitting.map(|name| pattern.with_file_name(name)).collect();
    found.sort();
    found
}
