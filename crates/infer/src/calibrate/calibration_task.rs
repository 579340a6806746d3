//! Input of a calibration, and reasons to refuse it.

use slipgrid_laser::specimen::SpecimenError;
use slipgrid_model::material::{AreaLaw, Condition, Elastic, Extrapolation, MaterialError};
use slipgrid_model::springblock::{Layer, SceneError};
use slipgrid_surface::contact::ContactError;
use slipgrid_surface::topography::PreparedMap;

use crate::calibrate::area_law::AreaLawError;
use crate::calibrate::fit::local_static_over_dynamic;
use crate::calibrate::{Coefficients, FitError, Measurement, TrialsTask};

/// Conditions and pressures at which friction is needed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Speeds and humidities; all measurements are selected if empty.
    pub conditions: Vec<Condition>,
    /// Nominal pressures, in pascals. With conditions, only measurements at or next to these pressures are selected.
    pub pressures_pa: Vec<f64>,
}

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
    /// Stated pressure P0 up to which friction is proportional to load, in pascals; `None` if the law refers to the
    /// limit of small loads.
    pub threshold_pa: Option<f64>,
    /// Area of one specimen's face, in square metres.
    pub specimen_area_m2: f64,
    /// Measurements on flat samples.
    pub flat: Vec<Measurement>,
    /// Samples that were cut and measured, and the prior of the discrepancy.
    pub trials: TrialsTask,
    /// Whether one pair of local coefficients is fitted to all measurements, or one pair per load, speed and humidity.
    pub coefficients: Coefficients,
    /// Relative standard deviation of the local coefficients between contact blocks; mean friction does not determine
    /// it.
    pub relative_std: f64,
    /// Assumed ratio mu_s / mu_d of the local static to the local dynamic coefficient where no static peak was
    /// measured.
    pub static_over_dynamic: f64,
    /// Modelled layer of the flat sample.
    pub layer: Layer,
    /// Seed of the random draw of local coefficients.
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
        /// The law, from [`crate::calibrate::flat_friction_law()`].
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
    /// errors, `None` for the default number.
    pub windows: Option<usize>,
    /// Map of an equal sample after the friction test, prepared like `map` and only compared with it; `None` if not
    /// given.
    pub after: Option<PreparedMap>,
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
        /// Measurement that caused the error; `None` if no single one did.
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
        /// Key of the number in a material file.
        field: &'static str,
        /// Value, in the unit of a material file.
        value: f64,
        /// Description of the accepted values.
        expected: String,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl CalibrationError {
    /// Key of the calibration file that the error is about, if there is one.
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
    pub fn pressure_pa(&self, measured: &Measurement) -> f64 {
        // P = F / A
        measured.force_n / self.specimen_area_m2
    }

    /// Mean ratio mu_s / mu_d of local static to dynamic coefficients before the fit, over the measured static peaks
    /// that determine the ratio; the assumed ratio if there is no such peak.
    pub fn local_static_over_dynamic(&self) -> f64 {
        let local = |flat: &Measurement| local_static_over_dynamic(flat.static_peak?.mu / flat.mu_dynamic);
        let shares: Vec<f64> = self.flat.iter().filter_map(local).collect();
        if shares.is_empty() {
            return self.static_over_dynamic;
        }
        shares.iter().sum::<f64>() / shares.len() as f64
    }

    /// Relative standard deviation of Young's modulus; `None` if not known.
    pub fn modulus_relative_std(&self) -> Option<f64> {
        Some(self.youngs_modulus_std_pa? / self.elastic.youngs_modulus_pa())
    }
}
