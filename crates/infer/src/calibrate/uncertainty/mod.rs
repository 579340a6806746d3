//! First-order uncertainty of the friction of a scene, from the errors of a calibration.
//!
//! | type | role |
//! |---|---|
//! | [`MaterialUncertainty`] | errors of a material's numbers |
//! | [`InputUncertainty`] | errors of a material at the loads of a scene |
//! | [`Slopes`] | sensitivity of the ratio to each uncertain number |
//! | [`Deviations`] | standard deviations of ratio, friction and flat friction at one load, with their contributions |
//!
//! Flat friction mu_flat = mu_d f(P), local coefficient times area factor, is the measured quantity. If the area law
//! changes, for example with Young's modulus, mu_d changes and mu_flat stays. The remaining error of a ratio comes from
//! the edges of cavities.

pub(super) mod covariances;
mod first_order_propagation;
mod local_law;
mod material_uncertainty;
mod sampling_scatter;

pub use covariances::{Covariance, with_scale};
pub use first_order_propagation::{Deviation, Deviations, ScaleShift, Slopes, moved};
pub(crate) use local_law::flat_friction;
pub use local_law::{local_law, local_law_changes, with_local_law};
pub use material_uncertainty::{CoefficientEstimate, MaterialUncertainty};
pub use sampling_scatter::{SamplingScatter, sampling_scatter};

use crate::discrepancy::Distribution;

/// Errors of a material at the loads of a scene; the area law carries its own errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputUncertainty {
    /// Variance of the relative error of flat dynamic friction, one per load; `None` if not known.
    pub flat_friction: Option<Vec<f64>>,
    /// Variance of the relative error of the static coefficient, one per load; `None` if not known.
    pub static_friction: Option<Vec<f64>>,
    /// Error of the pressure scale of the area law; `None` if the scale is exact or its error is not known.
    pub scale: Option<ScaleError>,
    /// Discrepancy at each load; `None` for uncorrected values of the model.
    pub discrepancy: Option<Vec<DiscrepancyAt>>,
}

/// Error of Young's modulus or of the fitted pressure scale; both shift the area law along the pressure axis.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleError {
    /// Whether the scale was fitted to flat friction; otherwise this is the error of the modulus.
    pub is_fitted: bool,
    /// Variance of the logarithm of the scale or of Young's modulus.
    pub variance: f64,
    /// Covariance with the relative error of flat friction, one per load; zero unless the scale was fitted together
    /// with friction.
    pub with_friction: Vec<f64>,
}

impl ScaleError {
    /// Error of Young's modulus with the standard deviation `log_std` of its logarithm. Flat friction, which is
    /// measured, is independent of the modulus. `loads` is the number of loads.
    pub fn of_modulus(log_std: f64, loads: usize) -> Self {
        Self { is_fitted: false, variance: log_std * log_std, with_friction: vec![0.0; loads] }
    }
}

/// Discrepancy of the model at one load. It includes the effect of the error of Young's modulus, because trials were
/// modelled with the same modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscrepancyAt {
    /// Median of the true ratio of a sample over the modelled one.
    pub factor: f64,
    /// Standard deviation of the logarithm of this factor.
    pub log_std: f64,
    /// Distances, in the logarithm, from the median to the lower and upper end of the 68 % interval.
    pub log_reach_68: [f64; 2],
    /// Distances, in the logarithm, from the median to the lower and upper end of the 95 % interval.
    pub log_reach_95: [f64; 2],
}

impl DiscrepancyAt {
    /// Converts `prediction` to one value per load.
    pub fn each(prediction: &Distribution) -> Vec<Self> {
        let at = |(load, median): (usize, f64)| {
            let reach = |outside: f64| {
                [median - prediction.quantile(load, outside), prediction.quantile(load, 1.0 - outside) - median]
            };
            let (_, log_std) = prediction.moments(load);
            // Tail probabilities beyond 1 and 1.96 standard deviations of a normal distribution.
            Self { factor: median.exp(), log_std, log_reach_68: reach(0.158_655_254), log_reach_95: reach(0.025) }
        };
        prediction.medians().into_iter().enumerate().map(at).collect()
    }
}

/// Source of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Dynamic friction of the flat sample.
    FlatFriction,
    /// Young's modulus, which shifts the area law along the pressure axis.
    Modulus,
    /// The pressure scale of the area law, fitted to flat friction.
    FittedScale,
    /// Factors of the area law, all shifted to the same side.
    AreaLaw,
    /// Discrepancy of the model for patterned samples, including Young's modulus.
    Discrepancy,
}

slipgrid_base::names!(Source {
    FlatFriction = "flat friction",
    Modulus = "Young's modulus",
    FittedScale = "scale of the area law",
    AreaLaw = "area law",
    Discrepancy = "discrepancy",
});
