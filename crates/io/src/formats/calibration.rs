//! Calibration files, the input of `calibrate`.

use std::path::{Path, PathBuf};

use slipgrid_base::monitor::Monitor;
use slipgrid_infer::calibrate::{CalibrationTask, Coefficients, CutSample, Measurement, Selection, Surface};
use slipgrid_laser::export::{ExportError, Specimen};
use slipgrid_model::material::Elastic;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Holder, Layer};

use super::calibration_file::{BulkFile, CalibrationFile, FitFile};
use super::file_kind::FileKind;
use super::friction::{DEFAULT_RELATIVE_STD, DEFAULT_STATIC_OVER_DYNAMIC};
use super::material::check_modulus_std;
use super::measured::{self, Placed, Remarks, Specimens};
use super::measurements;
use super::pattern::{PatternFile, check_depth, read_pattern};
use super::reporting::Reporting;
use super::scene::DEFAULT_LAYER;
use super::stated_specimen::{StatedSpecimen, area_m2, outline_told, sharing_force};
use super::surface::{NamedMap, read_surface};
use super::trace_notes::unrepeated;
use super::trace_table::TraceReader;
use super::traces::{self, ConditionTraces, SurfaceKind};
use super::trials::{self, FlatSamples};
use super::unusual;
use super::values::interval;
use crate::formats::altitude_map::read_land;
use crate::formats::plausible::{DENSITY, MODULUS, stiff_for_its_density};
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{DENSITY_G_CM3, MODULUS_GPA, MODULUS_STD_GPA, POISSON, PRESSURE_MPA, RELATIVE_STD};

/// Default Poisson's ratio of the contact computation: the value of the model's lattice of blocks.
pub const DEFAULT_POISSON_RATIO: f64 = 1.0 / 3.0;

/// A calibration ready to be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Calibration task with the values that the file states; [`Calibration::task`] adds layer, seed and selection, and the
    /// surface of a map.
    pub stated: CalibrationTask,
    /// Map from which the area law is computed; `None` if the law has another source.
    pub map: Option<NamedMap>,
    /// Thickness of the specimen, in metres; `None` if the file does not state it.
    pub thickness_m: Option<f64>,
    /// How the specimen is held; `None` if the file does not state it.
    pub holder: Option<Holder>,
    /// Measurements on patterned samples; empty without any.
    pub patterned: Vec<Measurement>,
    /// Traces from which the measurements were computed; empty without any.
    pub traces: Vec<ConditionTraces>,
    /// Pattern of the patterned samples; `None` if the file does not state it.
    pub pattern: Option<Pattern>,
    /// File positions of the measurements on flat samples, in the order of the files.
    pub placed: Vec<Placed>,
    /// Tables that the file names: of flat samples, patterned samples and trials.
    pub tables: Vec<PathBuf>,
    /// Files from which the calibration was read.
    pub inputs: Vec<PathBuf>,
    /// Statements for a report of the measurements, which no computation uses.
    pub reporting: Reporting,
}

impl Calibration {
    /// Reads the calibration file at `path` and its measurements. Maps are not read; only their existence is checked.
    ///
    /// # Errors
    /// [`Diagnostic`] for anything refused in the file or its tables.
    pub fn read(source: &Source, path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(&Document::read(source, path, FileKind::Calibration)?)
    }

    /// Trial that a validation of this calibration, read from `path`, compares with the model: the trial called `name`;
    /// without a name, the first measured trial, or `None` if there are patterned samples to compare.
    ///
    /// # Errors
    /// [`Diagnostic`] if there is no ratio to compare, or if no measured trial has the name.
    pub fn compared_trial(&self, path: &Path, name: Option<&str>) -> Result<Option<&CutSample>, Diagnostic> {
        let mut measured = self.stated.trials.samples.iter().filter(|cut| !cut.measured.is_empty());
        let Some(name) = name else {
            let first = measured.next().filter(|_| self.patterned.is_empty());
            if self.patterned.is_empty() && first.is_none() {
                let reason = "has no measured sample with a pattern, so there is no ratio to compare";
                return Err(Diagnostic::file(path, reason).expected(
                    "patterned = \"patterned.csv\" in [measurements], a table in the columns of the flat one, or a [[trial]] with its \
                     pattern and measurements = \"trial.csv\"",
                ));
            }
            return Ok(first);
        };
        let names: Vec<&str> = measured.clone().map(|cut| cut.name.as_str()).collect();
        let expected = if names.is_empty() { "a [[trial]] with measurements".to_owned() } else { names.join(", ") };
        let refused = Diagnostic::flag("--trial", name, "is no measured trial of this calibration");
        measured.find(|cut| cut.name == name).map(Some).ok_or_else(|| refused.expected(expected))
    }

    /// Standard deviation of Young's modulus, relative to the modulus; `None` if not given.
    pub fn modulus_relative_std(&self) -> Option<f64> {
        Some(self.stated.youngs_modulus_std_pa? / self.stated.elastic.youngs_modulus_pa())
    }

    /// Reads a calibration from a document.
    ///
    /// # Errors
    /// Errors of [`Calibration::read`].
    pub fn from_document(document: &Document) -> Result<Self, Diagnostic> {
        let document = &document.clone().as_kind(FileKind::Calibration);
        let file: CalibrationFile = document.parse()?;
        let bulk = file.material.get_ref();
        let yield_pressure_pa = document.optional(bulk.yield_pressure_mpa.as_ref(), PRESSURE_MPA)?;
        let elastic = Elastic::new(
            document.number(&bulk.youngs_modulus_gpa, MODULUS_GPA)?,
            document.number(&bulk.density_g_cm3, DENSITY_G_CM3)?,
        )
        .and_then(|elastic| elastic.with_yield_pressure_pa(yield_pressure_pa))
        .map_err(|error| document.refuse(file.material.span(), error.to_string()))?;
        let threshold = file.surface.as_ref().and_then(|surface| surface.get_ref().threshold_mpa.as_ref());
        let threshold_pa = document.optional(threshold, PRESSURE_MPA)?;
        let fit = file.fit.clone().unwrap_or_default();
        let coefficients = fit.coefficients.unwrap_or(Coefficients::PerCondition);
        let stated = StatedSpecimen::read(document, &file.specimen, None)?;
        let outline = stated.specimen.outline;
        let specimens = Specimens { area_m2: area_m2(&outline), modulus_pa: elastic.youngs_modulus_pa() };
        let mut remarks = Remarks { told: bulk_told(document, bulk)?, ..Remarks::default() };
        remarks.told.extend(outline_told(document, &file.specimen, &outline)?);
        let mut reader = TraceReader::new(document, &file)?;
        let samples = sharing_force(document, file.measurements.as_ref())?;
        let ([placed, patterned], mut traces) = read_measured(document, &file, samples, &mut reader)?;
        for rows in [&placed, &patterned] {
            remarks.told.extend(measured::check(rows, &specimens)?);
            remarks.repeated.extend(measured::identical(&[], rows));
        }
        remarks.told.extend(measured::check_partners(&patterned, &patterned, &placed)?);
        remarks.doubts.extend(measured::doubtful_ratios(&patterned, &placed));
        if coefficients == Coefficients::PerCondition {
            measured::refuse_repeated(&placed)?;
        }
        let cut =
            file.pattern.as_ref().map(|table| trials::of_tables(document, table, stated, &patterned)).transpose()?;
        remarks.told.extend(file.pattern.iter().flat_map(|table| unusual::of_cavity(document, table)));
        let pattern = cut.as_ref().map(|cut| cut.pattern);
        let first = cut.filter(|_| !patterned.is_empty());
        let scale_pa = read_scale(document, &fit, file.surface.is_some())?;
        let rows: Vec<Measurement> = placed.iter().map(|row| row.measurement).collect();
        let (surface, map) = match (&file.surface, scale_pa) {
            (Some(table), _) => read_surface(document, table, (&rows, specimens.area_m2))?,
            (None, Some(bounds_pa)) => (Surface::FittedScale { bounds_pa }, None),
            (None, None) => (Surface::None, None),
        };
        let flat = FlatSamples { stated, specimens: &specimens, measured: &placed, samples, has_map: map.is_some() };
        let prior = file.trial_prior.as_ref();
        let (trials, of_trials) =
            trials::read_trials(document, &file.trial, prior, &flat, first, &mut reader, &mut remarks)?;
        let once = unrepeated(&traces);
        traces.extend(of_trials);
        Ok(Self {
            tables: tables(document, &file),
            inputs: inputs(document, &file, map.as_ref(), &traces)
                .chain(trials.samples.iter().filter_map(|cut| cut.map.clone()))
                .collect(),
            reporting: file.reporting.clone().unwrap_or_default(),
            stated: CalibrationTask {
                name: file.name,
                source: file.source,
                elastic,
                youngs_modulus_std_pa: document.optional(bulk.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?,
                poisson_ratio: document
                    .optional(bulk.poisson_ratio.as_ref(), POISSON)?
                    .unwrap_or(DEFAULT_POISSON_RATIO),
                surface,
                threshold_pa,
                specimen_area_m2: specimens.area_m2,
                flat: rows,
                trials,
                coefficients,
                relative_std: document
                    .optional(fit.relative_std.as_ref(), RELATIVE_STD)?
                    .unwrap_or(DEFAULT_RELATIVE_STD),
                static_over_dynamic: DEFAULT_STATIC_OVER_DYNAMIC,
                layer: DEFAULT_LAYER,
                seed: 1,
                selection: Selection::default(),
                notes: remarks.told.iter().map(Diagnostic::to_string).collect(),
                doubts: remarks.warnings().into_iter().chain(once).collect(),
            },
            map,
            thickness_m: stated.thickness_m,
            holder: stated.holder,
            patterned: patterned.iter().map(|row| row.measurement).collect(),
            traces,
            pattern,
            placed,
        })
    }

    /// Calibration task for this layer and seed and the measurements in `selection`; maps are read from `files`.
    ///
    /// # Errors
    /// [`Diagnostic`] if a map cannot be read, or if `monitor` has cancelled.
    pub fn task(
        &self,
        files: &Source,
        (layer, seed): (Layer, u64),
        selection: Selection,
        monitor: &dyn Monitor,
    ) -> Result<CalibrationTask, Diagnostic> {
        let mut task = CalibrationTask { layer, seed, selection, ..self.stated.clone() };
        if let Some(named) = &self.map {
            let flat = named.read(files, monitor)?;
            for cut in &mut task.trials.samples {
                let land = cut.map.as_ref().map(|map| read_land(files, map, &named.options, &flat.map, monitor));
                cut.land = land.transpose()?;
            }
            task.surface = Surface::Map(Box::new(flat));
        }
        task.notes.extend(traces::notes(&self.traces));
        Ok(task)
    }

    /// Finds the file position of `measurement` on a flat sample; `None` for other measurements.
    pub fn place(&self, measurement: &Measurement) -> Option<&Placed> {
        self.placed.iter().find(|placed| placed.measurement == *measurement)
    }

    /// Nominal pressure of a normal force on one specimen, in pascals.
    pub fn pressure_pa(&self, force_n: f64) -> f64 {
        // P = F / A
        force_n / self.stated.specimen_area_m2
    }
}

/// Diagnostics for unusual modulus and density; refuses impossible values.
fn bulk_told(document: &Document, bulk: &BulkFile) -> Result<Vec<Diagnostic>, Diagnostic> {
    let modulus_gpa = *bulk.youngs_modulus_gpa.get_ref();
    check_modulus_std(document, modulus_gpa, bulk.youngs_modulus_std_gpa.as_ref())?;
    let judged = [(MODULUS, &bulk.youngs_modulus_gpa), (DENSITY, &bulk.density_g_cm3)];
    let told = judged.into_iter().filter_map(|(quantity, number)| {
        quantity.check(*number.get_ref(), || document.refuse(number.span(), "")).transpose()
    });
    let stiff = stiff_for_its_density(modulus_gpa, *bulk.density_g_cm3.get_ref());
    let stiff = stiff.map(|reason| Ok(document.refuse(bulk.youngs_modulus_gpa.span(), reason)));
    told.chain(stiff).collect()
}

/// Reads a pattern and checks that one period fits on the specimen, because memory and time of the model's cell grow
/// with the period. If `is_laid`, the layout of the cavities on the specimen is checked as well.
pub(crate) fn read_fitting_pattern(
    document: &Document,
    table: &Spanned<PatternFile>,
    specimen: &Specimen,
    is_laid: bool,
) -> Result<Pattern, Diagnostic> {
    let pattern = read_pattern(document, table)?;
    check_depth(document, table.get_ref(), pattern.depth_m(), &DEFAULT_LAYER)?;
    let checked = if is_laid { specimen.check(pattern) } else { specimen.check_period(&pattern) };
    let refused = |error: ExportError| document.refuse(table.span(), error.to_string());
    checked.map_err(|error| refused(error).expected("a pattern as it was cut into the specimen"))?;
    Ok(pattern)
}

/// Paths of the calibration file, its tables, maps and traces.
fn inputs(
    document: &Document,
    file: &CalibrationFile,
    map: Option<&NamedMap>,
    traces: &[ConditionTraces],
) -> impl Iterator<Item = PathBuf> {
    let maps = map.into_iter().flat_map(|map| std::iter::once(&map.path).chain(&map.after).cloned());
    let traces = traces.iter().flat_map(|traces| traces.condition.files.iter().map(|export| export.path.clone()));
    std::iter::once(document.path().to_owned()).chain(tables(document, file)).chain(maps).chain(traces)
}

/// Paths of the tables that the calibration names.
fn tables(document: &Document, file: &CalibrationFile) -> Vec<PathBuf> {
    let tables = file.measurements.iter().flat_map(|table| [&table.get_ref().flat, &table.get_ref().patterned]);
    let trials = file.trial.iter().filter_map(|trial| trial.get_ref().measurements.as_ref());
    tables.flatten().chain(trials).map(|name| document.resolve(name.get_ref())).collect()
}

/// Reads the measurements on flat and on patterned samples, from tables or traces, and the traces.
fn read_measured(
    document: &Document,
    file: &CalibrationFile,
    samples: u32,
    reader: &mut TraceReader<'_>,
) -> Result<([Vec<Placed>; 2], Vec<ConditionTraces>), Diagnostic> {
    let mut tables = [Vec::new(), Vec::new()];
    if let Some(table) = &file.measurements {
        for (rows, name) in tables.iter_mut().zip([&table.get_ref().flat, &table.get_ref().patterned]) {
            if let Some(name) = name {
                *rows = measurements::read(document, name, samples)?;
            }
        }
    }
    let mut read = Vec::new();
    if let Some(table) = &file.traces {
        let is_measured = !tables[SurfaceKind::Flat as usize].is_empty();
        let needed = !is_measured && !file.trial.iter().any(|trial| trial.get_ref().traces.is_some());
        let conditions = reader.table(table, needed)?;
        for kind in SurfaceKind::ALL {
            if !tables[kind as usize].is_empty() && conditions.iter().any(|(_, condition)| condition.surface == kind) {
                let reason = format!("has {} samples, and so has [measurements]", kind.name());
                return Err(document
                    .refuse(table.span(), reason)
                    .expected("samples of one kind either as a table or as traces"));
            }
        }
        for (traces, (span, condition)) in reader.analyse(&conditions)?.into_iter().zip(&conditions) {
            tables[condition.surface as usize].push(traces.placed(document, span));
            read.push(traces);
        }
    }
    if tables[SurfaceKind::Flat as usize].is_empty() {
        let missing = match &file.measurements {
            Some(table) => document.missing(table.span(), "flat"),
            None => document.missing(0..0, "measurements.flat"),
        };
        return Err(missing.expected(
            "a table, or [traces] of flat samples; traces of a cut sample stand beside them, in its [[trial]] as [[trial.traces]]",
        ));
    }
    Ok((tables, read))
}

fn read_scale(document: &Document, fit: &FitFile, has_surface: bool) -> Result<Option<[f64; 2]>, Diagnostic> {
    match &fit.area_law_scale_mpa {
        Some(bounds) if has_surface => Err(document
            .refuse(bounds.span(), "stands beside [surface]")
            .expected("either area_law_scale_mpa or [surface]")),
        bounds => {
            let words = ["is no range", "two increasing pressures, [0.5, 50]"];
            interval(document, bounds.as_ref(), PRESSURE_MPA, words)
        }
    }
}
