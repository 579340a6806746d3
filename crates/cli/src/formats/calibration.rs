//! Calibration files: what `calibrate` takes.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipgrid_material::{Elastic, THRESHOLD_PRESSURE_PA};
use slipgrid_pattern::Pattern;
use toml::Spanned;

use super::document::Document;
use super::file_kind::FileKind;
use super::material::existing;
use super::measurements::{self, Measurement};
use super::pattern::{PatternFile, read_pattern};
use super::scene::DEFAULT_LAYER;
use super::surface::{Surface, SurfaceFile};
use super::traces::{self, ConditionTraces, SurfaceKind, TracesFile};
use super::values::{Number, NumberList};
use crate::diagnostic::Diagnostic;
use crate::units::{DENSITY_G_CM3, LENGTH_MM, MODULUS_GPA, MODULUS_STD_GPA, POISSON, PRESSURE_MPA, RELATIVE_STD};

/// Poisson's ratio of the contact computation where a file names none: that of the lattice.
pub const DEFAULT_POISSON_RATIO: f64 = 1.0 / 3.0;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationFile {
    name: String,
    source: String,
    material: Spanned<BulkFile>,
    surface: Option<Spanned<SurfaceFile>>,
    specimen: SpecimenFile,
    measurements: Option<Spanned<MeasurementsFile>>,
    traces: Option<Spanned<TracesFile>>,
    pattern: Option<Spanned<PatternFile>>,
    fit: Option<FitFile>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BulkFile {
    youngs_modulus_gpa: Number,
    youngs_modulus_std_gpa: Option<Number>,
    density_g_cm3: Number,
    poisson_ratio: Option<Number>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpecimenFile {
    radius_mm: Number,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasurementsFile {
    flat: Option<Spanned<String>>,
    patterned: Option<Spanned<String>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FitFile {
    coefficients: Option<Spanned<String>>,
    discrepancy: Option<Spanned<String>>,
    area_law_scale_mpa: Option<NumberList>,
    relative_std: Option<Number>,
}

/// What is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coefficients {
    /// One pair for all measurements.
    Single,
    /// One pair for each load, speed and humidity.
    PerCondition,
}

impl Coefficients {
    /// All kinds of fit.
    pub const ALL: [Self; 2] = [Self::Single, Self::PerCondition];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::PerCondition => "per-condition",
        }
    }
}

/// How the model's error on patterned samples is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscrepancyForm {
    /// One factor.
    Constant,
    /// A factor whose logarithm is linear in pressure.
    Linear,
    /// Not at all.
    None,
}

impl DiscrepancyForm {
    /// All forms.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Linear, Self::None];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::None => "none",
        }
    }
}

/// A calibration ready to be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Name of the pair of materials.
    pub name: String,
    /// Publication or laboratory.
    pub source: String,
    /// Young's modulus and density.
    pub elastic: Elastic,
    /// Standard deviation of Young's modulus, in pascals.
    pub youngs_modulus_std_pa: Option<f64>,
    /// Poisson's ratio of the contact computation.
    pub poisson_ratio: f64,
    /// Where the area law comes from.
    pub surface: Surface,
    /// Pressure P0 up to which friction is proportional to load, in pascals.
    pub threshold_pa: f64,
    /// Radius of one specimen, in metres.
    pub specimen_radius_m: f64,
    /// Measurements on flat samples.
    pub flat: Vec<Measurement>,
    /// Measurements on patterned samples; empty without any.
    pub patterned: Vec<Measurement>,
    /// Traces behind the measurements, where they were read from traces.
    pub traces: Vec<ConditionTraces>,
    /// Pattern of the patterned samples, where the file names it.
    pub pattern: Option<Pattern>,
    /// How the model's error on patterned samples is estimated.
    pub discrepancy: DiscrepancyForm,
    /// Bounds of the area law's scale E* h'rms, in pascals, where no surface is given and it is fitted.
    pub area_law_scale_pa: Option<[f64; 2]>,
    /// What is fitted.
    pub coefficients: Coefficients,
    /// Scatter of the local coefficients, which no mean identifies.
    pub relative_std: f64,
    /// The files that it was read from.
    pub inputs: Vec<PathBuf>,
}

impl Calibration {
    /// Reads the calibration file at `path`, its measurements included; the map is only looked for.
    ///
    /// # Errors
    /// [`Diagnostic`] for anything refused in it or in its tables.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(&Document::read(path, FileKind::Calibration)?)
    }

    /// Standard deviation of Young's modulus over itself, where it is named.
    #[must_use]
    pub fn modulus_relative_std(&self) -> Option<f64> {
        Some(self.youngs_modulus_std_pa? / self.elastic.youngs_modulus_pa())
    }

    /// Reads a calibration from a document.
    ///
    /// # Errors
    /// As [`Calibration::read`].
    pub fn from_document(document: &Document) -> Result<Self, Diagnostic> {
        let file: CalibrationFile = document.parse()?;
        let bulk = file.material.get_ref();
        let elastic = Elastic::new(
            document.number(&bulk.youngs_modulus_gpa, MODULUS_GPA)?,
            document.number(&bulk.density_g_cm3, DENSITY_G_CM3)?,
        )
        .map_err(|error| document.refuse(file.material.span(), error.to_string()))?;
        let surface = file.surface.as_ref().map_or(Ok(Surface::None), |surface| Surface::new(document, surface))?;
        let threshold = file.surface.as_ref().and_then(|surface| surface.get_ref().threshold_mpa.as_ref());
        let threshold_pa = document.optional(threshold, PRESSURE_MPA)?.unwrap_or(THRESHOLD_PRESSURE_PA);
        let (flat, patterned, traces) = read_measured(document, &file)?;
        let pattern = file.pattern.as_ref();
        let pattern = pattern.map(|table| read_pattern(document, table, &DEFAULT_LAYER)).transpose()?;
        let fit = file.fit.as_ref();
        let area_law_scale_pa = read_scale(document, &file)?;
        Ok(Self {
            inputs: inputs(document, &file, &surface, &traces),
            name: file.name,
            source: file.source,
            elastic,
            youngs_modulus_std_pa: document.optional(bulk.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?,
            poisson_ratio: document.optional(bulk.poisson_ratio.as_ref(), POISSON)?.unwrap_or(DEFAULT_POISSON_RATIO),
            surface,
            threshold_pa,
            specimen_radius_m: document.number(&file.specimen.radius_mm, LENGTH_MM)?,
            flat,
            patterned,
            traces,
            pattern,
            area_law_scale_pa,
            discrepancy: fit
                .and_then(|fit| fit.discrepancy.as_ref())
                .map_or(Ok(DiscrepancyForm::Constant), |name| {
                    document.choice(name, &DiscrepancyForm::ALL, DiscrepancyForm::name)
                })?,
            coefficients: fit
                .and_then(|fit| fit.coefficients.as_ref())
                .map_or(Ok(Coefficients::PerCondition), |name| {
                    document.choice(name, &Coefficients::ALL, Coefficients::name)
                })?,
            relative_std: document
                .optional(fit.and_then(|fit| fit.relative_std.as_ref()), RELATIVE_STD)?
                .unwrap_or(super::material::DEFAULT_RELATIVE_STD),
        })
    }

    /// Nominal pressure of a normal force on one specimen, in pascals.
    #[must_use]
    pub fn pressure_pa(&self, force_n: f64) -> f64 {
        // P = F / (pi r^2)
        force_n / (std::f64::consts::PI * self.specimen_radius_m * self.specimen_radius_m)
    }
}

/// The calibration's file, its tables, its map and its traces.
fn inputs(document: &Document, file: &CalibrationFile, surface: &Surface, traces: &[ConditionTraces]) -> Vec<PathBuf> {
    let tables = file.measurements.iter().flat_map(|table| [&table.get_ref().flat, &table.get_ref().patterned]);
    let tables = tables.flatten().map(|name| document.resolve(name.get_ref()));
    let map = match surface {
        Surface::Map { path, .. } => Some(path.clone()),
        _ => None,
    };
    let traces = traces.iter().flat_map(|traces| traces.condition.files.iter().cloned());
    std::iter::once(document.path().to_owned()).chain(tables).chain(map).chain(traces).collect()
}

/// Measurements on flat and on patterned samples, from tables or from traces, and the traces.
type Measured = (Vec<Measurement>, Vec<Measurement>, Vec<ConditionTraces>);

fn read_measured(document: &Document, file: &CalibrationFile) -> Result<Measured, Diagnostic> {
    let mut tables = [Vec::new(), Vec::new()];
    if let Some(measurements) = &file.measurements {
        let names = [measurements.get_ref().flat.as_ref(), measurements.get_ref().patterned.as_ref()];
        for (table, name) in tables.iter_mut().zip(names) {
            if let Some(name) = name {
                *table = measurements::read(&existing(document, name, name.get_ref())?)?;
            }
        }
    }
    let mut read = Vec::new();
    if let Some(table) = &file.traces {
        let (setup, conditions) = traces::read_table(document, table.get_ref())?;
        for kind in SurfaceKind::ALL {
            if !tables[kind as usize].is_empty() && conditions.iter().any(|condition| condition.surface == kind) {
                let reason = format!("has {} samples, and so has [measurements]", kind.name());
                return Err(document.refuse(table.span(), reason).expected("one of the two"));
            }
        }
        for condition in &conditions {
            let traces = traces::analyse_condition(&setup, condition)?;
            tables[condition.surface as usize].push(traces.measurement());
            read.push(traces);
        }
    }
    let [flat, patterned] = tables;
    if flat.is_empty() {
        let place = file.measurements.as_ref().map_or(0..0, Spanned::span);
        return Err(document.missing(place, "measurements.flat").expected("a table, or [traces] of flat samples"));
    }
    Ok((flat, patterned, read))
}

fn read_scale(document: &Document, file: &CalibrationFile) -> Result<Option<[f64; 2]>, Diagnostic> {
    let Some(bounds) = file.fit.as_ref().and_then(|fit| fit.area_law_scale_mpa.as_ref()) else { return Ok(None) };
    if file.surface.is_some() {
        return Err(document.refuse(bounds.span(), "stands beside [surface]").expected("one of the two"));
    }
    match document.numbers(bounds, PRESSURE_MPA)?[..] {
        [from, to] if from < to => Ok(Some([from, to])),
        _ => Err(document.refuse(bounds.span(), "is no range").expected("two increasing pressures, [0.5, 50]")),
    }
}
