//! The quantities of a design that its limits hold, as the search's model gives them.

use slipgrid_export::{Laser, Layout, laser_time_s};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;

use super::study::Answer;
use crate::formats::design::Design;
use crate::formats::limits::Measure;
use crate::report::specimen::Specimen;

/// What is measured of every design, with what that takes.
#[derive(Clone, Debug, Default)]
pub struct Limited {
    measures: Vec<Measure>,
    laser: Laser,
    outline: Option<Specimen>,
}

impl Limited {
    /// The quantities that `design` limits.
    pub fn of(design: &Design) -> Self {
        Self { measures: design.measures.clone(), laser: design.laser, outline: Some(design.outline) }
    }

    /// Whether the specimen takes `pattern`: what cannot be drawn for the laser is no answer.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where no cavity fits, or far too many do.
    pub fn check(&self, pattern: &Pattern) -> Result<(), ModelFailure> {
        let laid = self.outline.map_or(Ok(()), |outline| outline.check(*pattern));
        laid.map_err(|error| ModelFailure::Trial { reason: error.to_string() })
    }

    /// Whether a closed cavity breaks a limit, and so needs no other refusal.
    pub fn judges_clearance(&self) -> bool {
        self.measures.contains(&Measure::Clearance)
    }

    /// The quantities of `pattern`, of which the model says `answer`, in the order of the limits, SI units.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the specimen cannot take the pattern.
    pub fn values(&self, pattern: &Pattern, answer: &Answer) -> Result<Vec<f64>, ModelFailure> {
        self.measures
            .iter()
            .map(|measure| {
                Ok(match measure {
                    Measure::PeakPressure => answer.peak_pressure_pa(),
                    Measure::BearingArea => 1.0 - self.areal_density(pattern)?,
                    Measure::ArealDensity => self.areal_density(pattern)?,
                    Measure::LaserTime => self.laser_time_s(pattern)?,
                    // Where nothing is left that could sag, nothing does.
                    Measure::Clearance => answer.clearance_m().unwrap_or_else(|| pattern.depth_m()),
                    Measure::LeastPressure => answer.least_pressure,
                })
            })
            .collect()
    }

    fn layout(&self, pattern: &Pattern) -> Result<Layout, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        let outline = self.outline.ok_or_else(|| trial("there is no specimen".to_owned()))?;
        outline.layout(*pattern).map_err(|error| trial(error.to_string()))
    }

    /// Of the specimen as it is cut, not of the endless pattern.
    fn areal_density(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        Ok(self.layout(pattern)?.areal_density())
    }

    fn laser_time_s(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        laser_time_s(&self.layout(pattern)?, &self.laser)
            .ok_or_else(|| ModelFailure::Trial { reason: "the laser's time is not known".to_owned() })
    }
}
