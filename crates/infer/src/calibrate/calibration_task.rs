//! Calibration job: from measurements and a surface to a material and its uncertainty.

use slipgrid_base::monitor::{Monitor, Part, Stage};
use slipgrid_laser::specimen::SpecimenError;
use slipgrid_model::material::{AreaLaw, Condition, Elastic, Extrapolation, Material, MaterialError};
use slipgrid_model::springblock::{Layer, SceneError};
use slipgrid_surface::contact::ContactError;
use slipgrid_surface::topography::PreparedMap;

use crate::calibrate::area_law::AreaLawError;
use crate::calibrate::fit::{check_speeds, local_static_over_dynamic, seconds};
use crate::calibrate::select_measurements::Selection;
use crate::calibrate::surface_area_law_source::{SurfaceFindings, surface_findings};
use crate::calibrate::trial_discrepancy::{TrialsTask, learn, sample_bytes};
use crate::calibrate::uncertainty::MaterialUncertainty;
use crate::calibrate::{
    Coefficients, Fit, FitError, Measurement, Problem, fit_coefficients, fitted_material, planned_steps,
};

/// Input of a calibration: measurements, the surface of the samples, and options.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationTask {
    /// Name of the pair of materials.
    pub name: String,
    /// Publication or laboratory that the measurements come from.
    pub source: String,
    /// Young's modulus and density.
    pub elastic: Elastic,
    /// Standard deviation of Young's modulus, in pascals, if known.
    pub youngs_modulus_std_pa: Option<f64>,
    /// Poisson's ratio for the contact computation.
    pub poisson_ratio: f64,
    /// Source of the area law.
    pub surface: Surface,
    /// Stated pressure P0 up to which friction is proportional to load, in pascals; `None` for the limit of small
    /// loads.
    pub threshold_pa: Option<f64>,
    /// Area of one specimen's face, in square metres.
    pub specimen_area_m2: f64,
    /// Measurements on flat samples.
    pub flat: Vec<Measurement>,
    /// Samples that were cut and measured, and the prior of the discrepancy.
    pub trials: TrialsTask,
    /// Kind of coefficients to fit.
    pub coefficients: Coefficients,
    /// Relative scatter of the local coefficients; mean friction does not determine it.
    pub relative_std: f64,
    /// Assumed mu_s / mu_d where no static peak was measured.
    pub static_over_dynamic: f64,
    /// Modelled layer of the flat sample.
    pub layer: Layer,
    /// Seed of the local coefficients.
    pub seed: u64,
    /// Conditions and pressures for which coefficients are needed; all if empty.
    pub selection: Selection,
    /// Notes about the measurements, one sentence each, which are added to the notes of the material.
    pub notes: Vec<String>,
    /// Doubts about the measurements, one sentence each, which are added to the warnings of the material.
    pub doubts: Vec<String>,
}

/// Source of the area law of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// No area law: friction is proportional to load (Amontons-Coulomb).
    None,
    /// Persson's contact area; its pressure scale E* h'rms is fitted together with the coefficients.
    FittedScale {
        /// Lower and upper bound of the scale, in pascals.
        bounds_pa: [f64; 2],
    },
    /// Measured flat friction is used as the law of local pressure.
    FlatFriction {
        /// The law, from [`crate::calibrate::flat_friction_law`].
        law: AreaLaw,
        /// Extrapolation above the highest measured pressure.
        extrapolation: Extrapolation,
    },
    /// Persson's theory for a surface with a known rms slope only.
    RmsSlope(f64),
    /// Rough contact of a height map.
    Map(Box<MapSurface>),
}

/// Height map from which an area law is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSurface {
    /// The map, prepared as one period.
    pub map: PreparedMap,
    /// Whether the map is known to be synthetic, whatever its file says.
    pub synthetic: bool,
    /// Number of windows along each side; their spread gives the standard errors of the law. Fewer than 2 for no
    /// errors, `None` for the default.
    pub windows: Option<usize>,
    /// Map of an equal sample after the test, prepared alike; only compared with `map`.
    pub after: Option<PreparedMap>,
}

/// Result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOutcome {
    /// The material, with its numbers rounded as in a material file.
    pub material: Material,
    /// Uncertainty of the material's numbers.
    pub uncertainty: MaterialUncertainty,
    /// Measurements on flat samples that were selected for the fit.
    pub measurements: Vec<Measurement>,
    /// The fit to these measurements.
    pub fit: Fit,
    /// Fitted rows by speed and humidity, in the order of the measurements, with increasing pressures; empty if one
    /// pair of coefficients is fitted to all measurements.
    pub by_condition: Vec<(Condition, Vec<FittedRow>)>,
    /// The surface and its contact area.
    pub surface: SurfaceFindings,
}

/// Fitted values at one measured pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedRow {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Fitted coefficients.
    pub pair: crate::calibrate::FittedPair,
    /// Model minus measurement of dynamic friction.
    pub residual: f64,
    /// Dynamic friction of the flat sample over mu_d f(P), to five digits.
    pub dynamic_over_steady: f64,
}

/// Reason why a calibration was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The contact area of the map cannot be computed.
    #[error(transparent)]
    AreaLaw(AreaLawError),
    /// The map after the test has no contact area or no area law.
    #[error("{0}")]
    MapAfter(String),
    /// The contact area has no area law.
    #[error("the contact area gives no area law: {0}")]
    NoAreaLaw(MaterialError),
    /// A contact theory refused a number.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The fit was refused.
    #[error("{error}")]
    Fit {
        /// The error of the fit.
        error: FitError,
        /// Measurement that caused the error.
        measurement: Option<Measurement>,
    },
    /// The trials have numbers from which no discrepancy can be computed.
    #[error("trials: {0}")]
    Trials(crate::discrepancy::DiscrepancyError),
    /// The spring-block model refused a patterned sample.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The model of a patterned sample on its specimen was refused.
    #[error(transparent)]
    Specimen(#[from] SpecimenError),
    /// A number of the material is invalid.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A fitted number is outside the range allowed for a material.
    #[error("the fit leads to {field} {value}: expected {expected}")]
    OutOfRange {
        /// Key of the number.
        field: &'static str,
        /// Value, in the unit of a material file.
        value: f64,
        /// Description of what is accepted.
        expected: String,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl CalibrationError {
    /// Key of the calibration file that the error is about, if there is one.
    #[must_use]
    pub const fn field(&self) -> Option<&'static str> {
        match self {
            Self::AreaLaw(AreaLawError::Windows(_)) => Some("surface.windows"),
            Self::AreaLaw(_) => Some("surface.map"),
            Self::MapAfter(_) => Some("surface.map_after"),
            Self::NoAreaLaw(_) | Self::Contact(_) => Some("surface"),
            Self::Fit { measurement: Some(_), .. } => Some("measurements.flat"),
            Self::Scene(_) => Some("measurements.patterned"),
            _ => None,
        }
    }
}

impl From<AreaLawError> for CalibrationError {
    fn from(error: AreaLawError) -> Self {
        match error {
            AreaLawError::Cancelled => Self::Cancelled,
            error => Self::AreaLaw(error),
        }
    }
}

impl CalibrationTask {
    /// Nominal pressure of a measurement, in pascals.
    #[must_use]
    pub fn pressure_pa(&self, measured: &Measurement) -> f64 {
        // P = F / A
        measured.force_n / self.specimen_area_m2
    }

    /// Mean local `mu_s` / `mu_d` before the fit, from the measured static peaks that determine it; the assumed ratio
    /// if there are none.
    #[must_use]
    pub fn local_static_over_dynamic(&self) -> f64 {
        let local = |flat: &Measurement| local_static_over_dynamic(flat.static_peak?.mu / flat.mu_dynamic);
        let shares: Vec<f64> = self.flat.iter().filter_map(local).collect();
        if shares.is_empty() {
            return self.static_over_dynamic;
        }
        shares.iter().sum::<f64>() / shares.len() as f64
    }

    /// Relative standard deviation of Young's modulus, if known.
    #[must_use]
    pub fn modulus_relative_std(&self) -> Option<f64> {
        Some(self.youngs_modulus_std_pa? / self.elastic.youngs_modulus_pa())
    }
}

/// Runs a calibration: selects the required measurements, computes the area law, fits local coefficients and learns
/// from trials. Stages of the monitor: "area law", "windows", "area law after the test", "calibration", and "trials" if
/// the area law is fitted. The monitor gets a note if the fit will take long.
///
/// # Errors
/// [`CalibrationError`] if a number is invalid, the model cannot reproduce a measurement, or the monitor cancels.
pub fn run(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<CalibrationOutcome, CalibrationError> {
    let check_cancelled = || if monitor.cancelled() { Err(CalibrationError::Cancelled) } else { Ok(()) };
    // Estimated first, so that a run that needs too much memory fails at once.
    note_memory(sample_bytes(task)?, monitor);
    let measurements = task.selection.flat(task);
    // Finds a modulus in the wrong unit before the contact of a map is computed.
    check_speeds(&task.elastic, task.specimen_area_m2, &measurements).map_err(|error| refused(error, &measurements))?;
    let mut surface = surface_findings(task, monitor)?;
    let problem = Problem {
        elastic: task.elastic,
        area_law: surface.law.clone(),
        area_law_scale: surface.scale()?,
        layer: task.layer,
        specimen_area_m2: task.specimen_area_m2,
        measurements,
        coefficients: task.coefficients,
        relative_std: task.relative_std,
        static_over_dynamic: task.static_over_dynamic,
        seed: task.seed,
    };
    if let Some(text) = long_fit_note(&problem) {
        monitor.note(&text);
    }
    let stage = Stage::new(monitor, "calibration", None);
    // Trials run in parallel with the fit, except if they need the fitted area law.
    let is_known = problem.area_law_scale.is_none();
    let trials_share =
        if is_known && task.trials.samples.iter().any(|sample| !sample.measured.is_empty()) { 0.2 } else { 0.0 };
    let (fit, early) = rayon::join(
        || fit_coefficients(&problem, &Part::new(&stage, 1.0 - trials_share)),
        || is_known.then(|| learn(task, surface.law_and_curve(), &Part::new(&stage, trials_share))),
    );
    stage.finish();
    let mut fit = fit.map_err(|error| refused(error, &problem.measurements))?;
    surface.set_fitted_scale(&fit)?;
    fit.include_law_errors(&problem, task.modulus_relative_std().filter(|_| surface.depends_on_modulus()))?;
    let learned = match early {
        Some(learned) => learned,
        None => {
            let stage = Stage::new(monitor, "trials", None);
            let learned = learn(task, surface.law_and_curve(), &stage);
            stage.finish();
            learned
        }
    };
    check_cancelled()?;
    fitted_material::outcome(task, problem.measurements, fit, surface, learned?)
}

fn refused(error: FitError, measurements: &[Measurement]) -> CalibrationError {
    match error {
        FitError::Cancelled => CalibrationError::Cancelled,
        error => {
            let measurement = error.measurement().and_then(|number| measurements.get(number - 1)).copied();
            CalibrationError::Fit { error, measurement }
        }
    }
}

/// Memory, in bytes, above which a note is given.
const NOTED_BYTES: f64 = (1_u64 << 30) as f64;

/// Notes the memory that the samples take, if it is large.
fn note_memory(bytes: f64, monitor: &dyn Monitor) {
    if bytes > NOTED_BYTES {
        let gib = bytes / NOTED_BYTES;
        monitor.note(&format!("the strips of a measured sample take about {gib:.1} GiB of memory"));
    }
}

/// Estimated minutes of a fit above which a note is given.
const NOTED_MINUTES: f64 = 0.5;

/// Notes the estimated time of the fit, if it is long.
fn long_fit_note(problem: &Problem) -> Option<String> {
    let steps: u64 = planned_steps(problem).ok()?.iter().fold(0, |sum, steps| sum.saturating_add(*steps));
    let runs = if problem.has_peaks() { 4.0 } else { 1.0 };
    // Each run uses one thread.
    let threads = rayon::current_num_threads().min(problem.measurements.len()) as f64;
    let minutes = runs * seconds(problem, steps as f64) / threads / 60.0;
    (minutes > NOTED_MINUTES).then(|| {
        format!("the runs of the flat sample take {steps} time steps a round, roughly {minutes:.1} minutes in all, and up to twenty times as long where means have to be taken for longer; steps grow with 1/speed, and heavy loads take more")
    })
}
