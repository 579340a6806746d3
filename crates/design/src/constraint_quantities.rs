//! Quantities of a design that its constraints limit, computed by the model of the search.

use crate::optimize::ModelFailure;
use slipgrid_laser::export::{Layout, laser_time_s};
use slipgrid_model::pattern::Pattern;

use crate::evaluation_cache::Answer;
use crate::optimize::{ConstraintQuantity, Limit};
use crate::task::DesignTask;

impl DesignTask {
    /// Computes the limited quantities of `pattern` from the model's `answer`, in the order of the limits, in SI units.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the specimen cannot take the pattern.
    pub(crate) fn limited(&self, pattern: &Pattern, answer: &Answer) -> Result<Vec<f64>, ModelFailure> {
        let layout = || -> Result<Layout, ModelFailure> {
            self.specimen.layout(*pattern).map_err(|error| ModelFailure::Trial(error.to_string()))
        };
        let value = |limit: &Limit| {
            Ok(match limit.quantity {
                ConstraintQuantity::PeakPressure => answer.peak_pressure_pa(),
                ConstraintQuantity::BearingArea => 1.0 - layout()?.areal_density(),
                ConstraintQuantity::ArealDensity => layout()?.areal_density(),
                ConstraintQuantity::LaserTime => laser_time_s(&layout()?, &self.laser)
                    .ok_or_else(|| ModelFailure::Trial("the laser's time is not known".to_owned()))?,
                // Without remaining cavities there is no ceiling that could sag, so the full depth is used.
                ConstraintQuantity::Clearance => answer.clearance_m().unwrap_or_else(|| pattern.depth_m()),
                ConstraintQuantity::LeastPressure => answer.least_pressure,
            })
        };
        self.constraints.quantities.iter().map(value).collect()
    }
}
