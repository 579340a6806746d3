//! What a calibration leaves open of the friction of a scene, to first order.
//!
//! | type | role |
//! |---|---|
//! | [`MaterialUncertainty`] | how well the numbers of a material are known |
//! | [`InputUncertainty`] | how well a material is known at the loads of a scene |
//! | [`Slopes`] | how the ratio follows each number that is not known exactly |
//! | [`Deviations`] | standard deviations of ratio, friction and flat friction at one load, with their parts |
//!
//! Flat friction mu_flat = mu_d f(P) is what was measured: where the area law is another, because Young's modulus is, the
//! local coefficient mu_d follows and mu_flat stays. What is left of a ratio's error is what the cavities' edges make of it.

mod covariances;
mod first_order_propagation;
mod material_uncertainty;
mod sampling_scatter;

pub use covariances::{Covariance, log_covariance, with_scale};
pub use first_order_propagation::{Deviation, Deviations, ScaleShift, Slopes, moved};
pub use material_uncertainty::{CoefficientEstimate, MaterialUncertainty};
pub use sampling_scatter::{SamplingScatter, sampling_scatter};

use slipgrid_springblock::Load;

use crate::Discrepancy;

/// How well a material is known at the loads of a scene; the area law carries its own errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputUncertainty {
    /// Variance of the relative error of flat dynamic friction, one per load; `None` where it is not known.
    pub flat_friction: Option<Vec<f64>>,
    /// The same of the static coefficient.
    pub static_friction: Option<Vec<f64>>,
    /// What moves the area law along the pressure; `None` where nothing does or it is not known.
    pub scale: Option<ScaleError>,
    /// Of values that the discrepancy corrects, one per load; `None` where values are the model's own.
    pub discrepancy: Option<Vec<DiscrepancyAt>>,
}

/// The error of Young's modulus, or of the fitted pressure scale of the area law, which moves the law alike.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleError {
    /// The scale was fitted to flat friction; otherwise it is the modulus.
    pub is_fitted: bool,
    /// Variance of its logarithm.
    pub variance: f64,
    /// Covariance with the relative error of flat friction, one per load: zero unless fitted together.
    pub with_friction: Vec<f64>,
}

impl ScaleError {
    /// Of Young's modulus with a standard deviation of its logarithm, at so many loads: flat friction, which was measured,
    /// does not go with it.
    #[must_use]
    pub fn of_modulus(log_std: f64, loads: usize) -> Self {
        Self { is_fitted: false, variance: log_std * log_std, with_friction: vec![0.0; loads] }
    }
}

/// The discrepancy at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscrepancyAt {
    /// Measured over modelled ratio.
    pub factor: f64,
    /// Variance of its logarithm at a given Young's modulus, widened for few measurements.
    pub log_variance: f64,
    /// How its logarithm falls with that of Young's modulus.
    pub modulus_sensitivity: f64,
}

impl DiscrepancyAt {
    /// The discrepancy `found` at each of `loads`.
    #[must_use]
    pub fn each(found: &Discrepancy, loads: &[Load]) -> Vec<Self> {
        let covariance = log_covariance(found, loads);
        let at = |(place, load): (usize, &Load)| Self {
            factor: found.factor(load.pressure_pa),
            log_variance: covariance[place][place],
            modulus_sensitivity: found.modulus_sensitivity_at(load.pressure_pa),
        };
        loads.iter().enumerate().map(at).collect()
    }
}

/// A number that is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Dynamic friction of the flat sample.
    FlatFriction,
    /// Young's modulus, which moves the area law along the pressure.
    Modulus,
    /// The pressure scale of the area law, fitted to flat friction.
    FittedScale,
    /// The area law's own factors, all off to the same side.
    AreaLaw,
    /// The model's error on patterned samples.
    Discrepancy,
}

impl Source {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FlatFriction => "flat friction",
            Self::Modulus => "Young's modulus",
            Self::FittedScale => "scale of the area law",
            Self::AreaLaw => "area law",
            Self::Discrepancy => "discrepancy",
        }
    }
}
