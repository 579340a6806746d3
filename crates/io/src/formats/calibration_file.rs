//! Tables of a calibration file in their serialized form.

use crate::formats::spanned::Spanned;
use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_infer::calibrate::Coefficients;
use slipgrid_infer::discrepancy::Hyperparameters;

use super::pattern::PatternFile;
use super::reporting::Reporting;
use super::stated_specimen::ForceIs;
use super::surface::SurfaceFile;
use super::trace_table::TracesFile;
use super::trials::TrialFile;
use super::values::{Number, NumberList};

/// Calibration in the form of its file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CalibrationFile {
    /// Name of the pair of materials.
    pub name: String,
    /// Publication or laboratory that the numbers come from.
    pub source: String,
    /// The softer body, which is modelled.
    pub material: Spanned<BulkFile>,
    /// Source of the area law; friction is proportional to load when absent.
    pub surface: Option<Spanned<SurfaceFile>>,
    /// The face of one specimen: pressure is force over its area.
    pub specimen: Spanned<FaceFile>,
    /// Tables of measured friction.
    pub measurements: Option<Spanned<MeasurementsFile>>,
    /// Raw exports of a tribometer, in place of tables.
    pub traces: Option<Spanned<TracesFile>>,
    /// Pattern of the patterned samples, which are then the first trial.
    pub pattern: Option<Spanned<PatternFile>>,
    /// One table for each sample that was cut.
    #[serde(default)]
    pub trial: Vec<Spanned<TrialFile>>,
    /// Prior standard deviations of ln(measured / modelled ratio), before any trial.
    pub trial_prior: Option<Spanned<Hyperparameters>>,
    /// Options of the fit.
    pub fit: Option<FitFile>,
    /// Statements for a report, which no computation uses.
    pub reporting: Option<Reporting>,
}

/// The bulk of the modelled body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BulkFile {
    /// Young's modulus at small strains, at the temperature of the test.
    pub youngs_modulus_gpa: Number,
    /// Standard deviation of Young's modulus; without the key, errors leave the error of the modulus out.
    pub youngs_modulus_std_gpa: Option<Number>,
    /// Density.
    pub density_g_cm3: Number,
    /// Contact pressure at which rims flatten permanently, about three times the yield stress; rims are elastic when
    /// absent.
    pub yield_pressure_mpa: Option<Number>,
    /// Poisson's ratio of the contact computation; 1/3 when absent.
    pub poisson_ratio: Option<Number>,
}

/// The face of one specimen, given by the radius of a disc or by a shape with its lengths.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaceFile {
    /// Radius of a disc.
    pub radius_mm: Option<Number>,
    /// `disc`, `rectangle` or `ring`; follows from the lengths when absent.
    pub shape: Option<Spanned<String>>,
    /// Diameter of a disc.
    pub diameter_mm: Option<Number>,
    /// Length of a rectangle along x, the sliding direction unless `sliding_angle_deg` turns it.
    pub length_mm: Option<Number>,
    /// Width of a rectangle across the sliding direction.
    pub width_mm: Option<Number>,
    /// Outer diameter of a ring.
    pub outer_diameter_mm: Option<Number>,
    /// Diameter of a ring's hole.
    pub inner_diameter_mm: Option<Number>,
    /// Thickness of the elastic specimen with which patterned samples are modelled, 0.2 to 1000; that of the requesting
    /// design or 7 when absent.
    pub thickness_mm: Option<Number>,
    /// How the specimen is held: `rigid` if the holder keeps it from turning, so that friction tilts the pressure, or
    /// `self-aligning`; needs `thickness_mm`; that of the requesting design when absent.
    pub holder: Option<Spanned<String>>,
    /// Cavities that cross the rim of the face of patterned samples: `whole` if they were left out, `clipped` if they
    /// were cut; `whole` when absent.
    pub cavities: Option<Spanned<String>>,
}

/// Tables of measured friction, one row per condition.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeasurementsFile {
    /// CSV table of flat samples.
    pub flat: Option<Spanned<String>>,
    /// CSV table of patterned samples, which are not fitted: with `[pattern]` they are the first trial.
    pub patterned: Option<Spanned<String>>,
    /// Number of specimens that the holder presses at once, also for the tables of trials; 1 when absent.
    pub samples: Option<Spanned<u64>>,
    /// `per_sample` if a force in the tables presses one specimen, `total` if the force presses all specimens; needed
    /// with several `samples`.
    #[schemars(with = "Option<String>")]
    pub force_is: Option<ForceIs>,
}

/// Options of the fit.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FitFile {
    /// Local friction coefficients to fit: `per-condition`, or `single`, one static and one dynamic coefficient for all
    /// loads, speeds and humidities; `per-condition` when absent.
    #[schemars(with = "Option<String>")]
    pub coefficients: Option<Coefficients>,
    /// Bounds of the pressure scale of the area law (contact modulus times rms slope), which is then fitted; only
    /// without `[surface]` and with `single` coefficients.
    pub area_law_scale_mpa: Option<NumberList>,
    /// Standard deviation of friction coefficients between contact blocks, relative to the mean; 0.05 when absent.
    pub relative_std: Option<Number>,
}
