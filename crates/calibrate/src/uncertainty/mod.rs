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
mod local_law;
mod material_uncertainty;
mod sampling_scatter;

pub use covariances::{Covariance, with_scale};
pub(crate) use first_order_propagation::NORMAL_95;
pub use first_order_propagation::{Deviation, Deviations, ScaleShift, Slopes, moved};
pub(crate) use local_law::flat_friction;
pub use local_law::{local_law, local_law_changes, with_local_law};
pub use material_uncertainty::{CoefficientEstimate, MaterialUncertainty};
pub use sampling_scatter::{SamplingScatter, sampling_scatter};

use slipgrid_discrepancy::Prediction;

/// How well a material is known at the loads of a scene; the area law carries its own errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputUncertainty {
    /// Variance of the relative error of flat dynamic friction, one per load; `None` where it is not known.
    pub flat_friction: Option<Vec<f64>>,
    /// The same of the static coefficient.
    pub static_friction: Option<Vec<f64>>,
    /// What moves the area law along the pressure; `None` where nothing does or it is not known.
    pub scale: Option<ScaleError>,
    /// Of values that the discrepancy corrects, one a load; `None` where values are the model's own.
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

/// What trials say that the model lacks at one load. What Young's modulus leaves open of the ratio is in it: trials were modelled
/// with the same one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscrepancyAt {
    /// Median of a sample's true ratio over the modelled one.
    pub factor: f64,
    /// Standard deviation of its logarithm.
    pub log_std: f64,
    /// How far the 68 % interval of its logarithm reaches below and above the median.
    pub log_reach_68: [f64; 2],
    /// The same of the 95 % interval.
    pub log_reach_95: [f64; 2],
}

impl DiscrepancyAt {
    /// What `prediction` says at each load.
    #[must_use]
    pub fn each(prediction: &Prediction) -> Vec<Self> {
        let at = |(load, median): (usize, f64)| {
            let reach = |outside: f64| {
                [median - prediction.quantile(load, outside), prediction.quantile(load, 1.0 - outside) - median]
            };
            let (_, log_std) = prediction.moments(load);
            // The shares beyond one and beyond 1.96 standard deviations of a normal one.
            Self { factor: median.exp(), log_std, log_reach_68: reach(0.158_655_254), log_reach_95: reach(0.025) }
        };
        prediction.medians().into_iter().enumerate().map(at).collect()
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
    /// What the model lacks on patterned samples, Young's modulus among it.
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
