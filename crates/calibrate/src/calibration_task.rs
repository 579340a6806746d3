//! The job of a calibration: from measurements and a surface to a material and what is known of its errors.

use slipgrid_contact::ContactError;
use slipgrid_material::{AreaLaw, Condition, Elastic, Extrapolation, Material, MaterialError};
use slipgrid_monitor::{Monitor, Part, Stage};
use slipgrid_specimen::SpecimenError;
use slipgrid_springblock::{Layer, SceneError};
use slipgrid_topography::PreparedMap;

use crate::area_law::AreaLawError;
use crate::fit::{check_speeds, local_static_over_dynamic, seconds};
use crate::select_measurements::Selection;
use crate::surface_area_law_source::{SurfaceFindings, surface_findings};
use crate::trial_discrepancy::{TrialsTask, learn, sample_bytes};
use crate::uncertainty::MaterialUncertainty;
use crate::{Coefficients, Fit, FitError, Measurement, Problem, fit_coefficients, fitted_material, planned_steps};

/// Measurements, the surface they were made on, and what is to be made of them.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationTask {
    /// Name of the pair of materials.
    pub name: String,
    /// Publication or laboratory.
    pub source: String,
    /// Young's modulus and density.
    pub elastic: Elastic,
    /// Standard deviation of Young's modulus, in pascals, where it is known.
    pub youngs_modulus_std_pa: Option<f64>,
    /// Poisson's ratio of the contact computation.
    pub poisson_ratio: f64,
    /// Where the area law comes from.
    pub surface: Surface,
    /// Stated pressure P0 up to which friction is proportional to load, in pascals; `None` for the limit of small loads.
    pub threshold_pa: Option<f64>,
    /// Area of one specimen's face, in square metres.
    pub specimen_area_m2: f64,
    /// Measurements on flat samples.
    pub flat: Vec<Measurement>,
    /// Samples that were cut and measured, and what is believed before.
    pub trials: TrialsTask,
    /// What is fitted.
    pub coefficients: Coefficients,
    /// Scatter of the local coefficients relative to their means: no mean identifies it.
    pub relative_std: f64,
    /// mu_s / mu_d where no static peak was measured.
    pub static_over_dynamic: f64,
    /// The flat sample as modelled.
    pub layer: Layer,
    /// Seed of its local coefficients.
    pub seed: u64,
    /// The conditions and pressures for which coefficients are wanted; all where it is empty.
    pub selection: Selection,
    /// What is known of the measurements beforehand, one sentence each, for the material's notes.
    pub notes: Vec<String>,
    /// What of the measurements is hardly meant, one sentence each, for the material's warnings.
    pub doubts: Vec<String>,
}

/// Where the area law of a calibration comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Nowhere: friction is proportional to load (Amontons-Coulomb).
    None,
    /// Persson's contact area, of which the pressure scale E* h'rms is fitted together with the coefficients.
    FittedScale {
        /// Least and greatest scale, in pascals.
        bounds_pa: [f64; 2],
    },
    /// Measured flat friction is the law of local pressure.
    FlatFriction {
        /// The law, as [`crate::flat_friction_law`] finds it.
        law: AreaLaw,
        /// How it goes on above the last measured pressure.
        extrapolation: Extrapolation,
    },
    /// Persson's theory for a surface of which only the rms slope is known.
    RmsSlope(f64),
    /// Rough contact of an altitude map.
    Map(Box<MapSurface>),
}

/// An altitude map behind an area law.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSurface {
    /// The map, prepared as one period.
    pub map: PreparedMap,
    /// The map is known to be synthetic, whatever its file says.
    pub synthetic: bool,
    /// Windows along either side whose spread gives the law's standard errors; fewer than 2 for none, `None` for the default.
    pub windows: Option<usize>,
    /// A map of the same kind of sample after the test, prepared alike: only compared with the first.
    pub after: Option<PreparedMap>,
}

/// A calibration made.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOutcome {
    /// The material, its numbers to the digits that a material file holds.
    pub material: Material,
    /// What is known of its errors.
    pub uncertainty: MaterialUncertainty,
    /// The measurements on flat samples that were selected and fitted.
    pub measurements: Vec<Measurement>,
    /// The fit to them.
    pub fit: Fit,
    /// The same by speed and humidity, in the order in which these were measured, pressures increasing; empty where one pair of
    /// coefficients holds for all.
    pub by_condition: Vec<(Condition, Vec<FittedRow>)>,
    /// The surface and its contact area.
    pub surface: SurfaceFindings,
}

/// A measured pressure with what was fitted there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedRow {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Coefficients.
    pub pair: crate::FittedPair,
    /// Model minus measurement of dynamic friction.
    pub residual: f64,
    /// Dynamic friction of the flat sample over mu_d f(P), to five digits.
    pub dynamic_over_steady: f64,
}

/// Why a calibration was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The map has no contact area.
    #[error(transparent)]
    AreaLaw(AreaLawError),
    /// The map after the test has no contact area, or one that gives no law.
    #[error("{0}")]
    MapAfter(String),
    /// The contact area gives no area law.
    #[error("the contact area gives no area law: {0}")]
    NoAreaLaw(MaterialError),
    /// A theory of contact refused a number.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The fit was refused.
    #[error("{error}")]
    Fit {
        /// Why.
        error: FitError,
        /// The measurement that it is about.
        measurement: Option<Measurement>,
    },
    /// The numbers of the trials make no discrepancy.
    #[error("trials: {0}")]
    Trials(slipgrid_discrepancy::DiscrepancyError),
    /// The model of the patterned samples was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The model of a patterned sample on its specimen was refused.
    #[error(transparent)]
    Specimen(#[from] SpecimenError),
    /// A number of the material has no meaning.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A number that was fitted lies beyond what a material may have.
    #[error("the fit leads to {field} {value}: expected {expected}")]
    OutOfRange {
        /// Which number.
        field: &'static str,
        /// The number found, in the unit of a material file.
        value: f64,
        /// What would be accepted.
        expected: String,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl CalibrationError {
    /// The part of the task that it is about, named as in a calibration file, where it is one.
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

    /// `mu_s` / `mu_d` of blocks, before anything is fitted: the mean of those of which measured peaks tell, or what is assumed without any.
    #[must_use]
    pub fn local_static_over_dynamic(&self) -> f64 {
        let told = |flat: &Measurement| local_static_over_dynamic(flat.static_peak?.mu / flat.mu_dynamic);
        let shares: Vec<f64> = self.flat.iter().filter_map(told).collect();
        if shares.is_empty() {
            return self.static_over_dynamic;
        }
        shares.iter().sum::<f64>() / shares.len() as f64
    }

    /// Standard deviation of Young's modulus over itself, where it is known.
    #[must_use]
    pub fn modulus_relative_std(&self) -> Option<f64> {
        Some(self.youngs_modulus_std_pa? / self.elastic.youngs_modulus_pa())
    }
}

/// Selects the measurements that `task` needs, computes the area law, fits local coefficients and learns from
/// trials. Stages of the monitor: "area law", "windows", "area law after the test", "calibration", and "trials" where the fit finds
/// the area law; it is told where the fit will take long.
///
/// # Errors
/// [`CalibrationError`] for numbers without meaning, measurements that the model cannot follow, or when the monitor asks to
/// stop.
pub fn run(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<CalibrationOutcome, CalibrationError> {
    let heed = || if monitor.cancelled() { Err(CalibrationError::Cancelled) } else { Ok(()) };
    // Before minutes of the rest, which do not need it.
    note_memory(sample_bytes(task)?, monitor);
    let measurements = task.selection.flat(task);
    // A modulus in the wrong unit is found before the contact of a map is computed.
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
    if let Some(text) = long_fit(&problem) {
        monitor.note(&text);
    }
    let stage = Stage::new(monitor, "calibration", None);
    // Trials wait for the fit only where that finds the area law.
    let is_known = problem.area_law_scale.is_none();
    let of_trials =
        if is_known && task.trials.samples.iter().any(|sample| !sample.measured.is_empty()) { 0.2 } else { 0.0 };
    let (fit, early) = rayon::join(
        || fit_coefficients(&problem, &Part::new(&stage, 1.0 - of_trials)),
        || is_known.then(|| learn(task, surface.law_and_curve(), &Part::new(&stage, of_trials))),
    );
    stage.finish();
    let mut fit = fit.map_err(|error| refused(error, &problem.measurements))?;
    surface.take_fitted_scale(&fit)?;
    fit.free_of_the_law(&problem, task.modulus_relative_std().filter(|_| surface.moves_with_the_modulus()))?;
    let learned = match early {
        Some(learned) => learned,
        None => {
            let stage = Stage::new(monitor, "trials", None);
            let learned = learn(task, surface.law_and_curve(), &stage);
            stage.finish();
            learned
        }
    };
    heed()?;
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

/// Memory from which it is told, in bytes.
const LARGE_BYTES: f64 = (1_u64 << 30) as f64;

/// Says how much memory the samples take, where that is much.
fn note_memory(bytes: f64, monitor: &dyn Monitor) {
    if bytes > LARGE_BYTES {
        let gib = bytes / LARGE_BYTES;
        monitor.note(&format!("the strips of a measured sample take about {gib:.1} GiB of memory"));
    }
}

/// A fit that is estimated to take longer says so before it begins, in minutes.
const LONG_MIN: f64 = 0.5;

/// Says how long the fit will take, where that is long.
fn long_fit(problem: &Problem) -> Option<String> {
    let steps: u64 = planned_steps(problem).ok()?.iter().fold(0, |sum, steps| sum.saturating_add(*steps));
    let runs = if problem.has_peaks() { 4.0 } else { 1.0 };
    // Each run has one thread.
    let threads = rayon::current_num_threads().min(problem.measurements.len()) as f64;
    let minutes = runs * seconds(problem, steps as f64) / threads / 60.0;
    (minutes > LONG_MIN).then(|| {
        format!("the runs of the flat sample take {steps} time steps a round, roughly {minutes:.1} minutes in all, and up to twenty times as long where means have to be taken for longer; steps grow with 1/speed, and heavy loads take more")
    })
}
