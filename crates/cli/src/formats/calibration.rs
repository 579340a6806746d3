//! Calibration files: what `calibrate` takes.

use std::path::Path;

use serde::Deserialize;
use slipgrid_material::Elastic;
use toml::Spanned;

use super::document::Document;
use super::material::existing;
use super::measurements::{self, Measurement};
use super::surface::{Surface, SurfaceFile};
use super::values::Number;
use crate::diagnostic::Diagnostic;
use crate::units::{DENSITY_G_CM3, LENGTH_MM, MODULUS_GPA, MODULUS_STD_GPA, POISSON, RELATIVE_STD};

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
    measurements: MeasurementsFile,
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
    flat: Spanned<String>,
    patterned: Option<Spanned<String>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FitFile {
    coefficients: Option<Spanned<String>>,
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
    /// Radius of one specimen, in metres.
    pub specimen_radius_m: f64,
    /// Measurements on flat samples.
    pub flat: Vec<Measurement>,
    /// Measurements on patterned samples; empty without any.
    pub patterned: Vec<Measurement>,
    /// What is fitted.
    pub coefficients: Coefficients,
    /// Scatter of the local coefficients, which no mean identifies.
    pub relative_std: f64,
}

impl Calibration {
    /// Reads the calibration file at `path`, its measurements included; the map is only looked for.
    ///
    /// # Errors
    /// [`Diagnostic`] for anything refused in it or in its tables.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(&Document::read(path)?)
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
        let flat = measurements::read(&existing(document, &file.measurements.flat, file.measurements.flat.get_ref())?)?;
        let patterned = match &file.measurements.patterned {
            Some(name) => measurements::read(&existing(document, name, name.get_ref())?)?,
            None => Vec::new(),
        };
        let fit = file.fit.as_ref();
        Ok(Self {
            name: file.name,
            source: file.source,
            elastic,
            youngs_modulus_std_pa: document.optional(bulk.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?,
            poisson_ratio: document.optional(bulk.poisson_ratio.as_ref(), POISSON)?.unwrap_or(DEFAULT_POISSON_RATIO),
            surface,
            specimen_radius_m: document.number(&file.specimen.radius_mm, LENGTH_MM)?,
            flat,
            patterned,
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
