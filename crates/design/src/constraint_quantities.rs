//! Quantities of a design that its constraints limit, computed by the model of the search.

use crate::optimize::ModelFailure;
use slipgrid_laser::export::{Laser, Layout, laser_time_s};
use slipgrid_model::pattern::Pattern;

use crate::evaluation_cache::Answer;
use crate::task::{ConstraintQuantity, DesignTask};
use slipgrid_laser::export::Specimen;

/// Quantities of designs that limits apply to, and the inputs to compute them.
#[derive(Clone, Debug, Default)]
pub struct Limited {
    measures: Vec<ConstraintQuantity>,
    laser: Laser,
    outline: Option<Specimen>,
}

impl Limited {
    /// Collects the quantities that `design` limits.
    pub fn of(design: &DesignTask) -> Self {
        Self { measures: design.quantities.clone(), laser: design.laser, outline: Some(design.specimen) }
    }

    /// Checks that `pattern` fits the specimen, so that the laser can cut it.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where no cavity fits, or far too many do.
    pub fn check(&self, pattern: &Pattern) -> Result<(), ModelFailure> {
        let laid = self.outline.map_or(Ok(()), |outline| outline.check(*pattern));
        laid.map_err(|error| ModelFailure::Trial { reason: error.to_string() })
    }

    /// Computes the limited quantities of `pattern` from the model's `answer`, in the order of the limits, in SI units.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the specimen cannot take the pattern.
    pub fn values(&self, pattern: &Pattern, answer: &Answer) -> Result<Vec<f64>, ModelFailure> {
        self.measures
            .iter()
            .map(|measure| {
                Ok(match measure {
                    ConstraintQuantity::PeakPressure => answer.peak_pressure_pa(),
                    ConstraintQuantity::BearingArea => 1.0 - self.areal_density(pattern)?,
                    ConstraintQuantity::ArealDensity => self.areal_density(pattern)?,
                    ConstraintQuantity::LaserTime => self.laser_time_s(pattern)?,
                    // Without remaining cavities there is no ceiling that could sag, so the full depth is used.
                    ConstraintQuantity::Clearance => answer.clearance_m().unwrap_or_else(|| pattern.depth_m()),
                    ConstraintQuantity::LeastPressure => answer.least_pressure,
                })
            })
            .collect()
    }

    fn layout(&self, pattern: &Pattern) -> Result<Layout, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        let outline = self.outline.ok_or_else(|| trial("there is no specimen".to_owned()))?;
        outline.layout(*pattern).map_err(|error| trial(error.to_string()))
    }

    /// Areal density of the specimen as cut, not of the infinite pattern.
    fn areal_density(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        Ok(self.layout(pattern)?.areal_density())
    }

    fn laser_time_s(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        laser_time_s(&self.layout(pattern)?, &self.laser)
            .ok_or_else(|| ModelFailure::Trial { reason: "the laser's time is not known".to_owned() })
    }
}
