//! The quantities of a design that its limits hold, as the search's model gives them.

use slipgrid_export::{Laser, Layout, laser_time_s};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;

use crate::evaluation_cache::Answer;
use crate::task::DesignTask;
use slipgrid_export::Specimen;

/// A quantity of a design that can be limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintQuantity {
    /// Largest local pressure at any target pressure, in the cell and in confirming runs of the specimen.
    PeakPressure,
    /// Share of the face that is land.
    BearingArea,
    /// Share of the face that is cavity.
    ArealDensity,
    /// Time under the laser for the specimen.
    LaserTime,
    /// Least height of a ceiling above the counterface at any target pressure.
    Clearance,
    /// Least local pressure over the nominal one, at any target pressure: negative under tension.
    LeastPressure,
}

impl ConstraintQuantity {
    /// Whether a design is laid on its specimen for it.
    #[must_use]
    pub const fn takes_a_layout(self) -> bool {
        matches!(self, Self::BearingArea | Self::ArealDensity | Self::LaserTime)
    }
}

/// What is measured of every design, with what that takes.
#[derive(Clone, Debug, Default)]
pub struct Limited {
    measures: Vec<ConstraintQuantity>,
    laser: Laser,
    outline: Option<Specimen>,
}

impl Limited {
    /// The quantities that `design` limits.
    #[must_use]
    pub fn of(design: &DesignTask) -> Self {
        Self { measures: design.quantities.clone(), laser: design.laser, outline: Some(design.specimen) }
    }

    /// Whether the specimen takes `pattern`: what cannot be drawn for the laser is no answer.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where no cavity fits, or far too many do.
    pub fn check(&self, pattern: &Pattern) -> Result<(), ModelFailure> {
        let laid = self.outline.map_or(Ok(()), |outline| outline.check(*pattern));
        laid.map_err(|error| ModelFailure::Trial { reason: error.to_string() })
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
                    ConstraintQuantity::PeakPressure => answer.peak_pressure_pa(),
                    ConstraintQuantity::BearingArea => 1.0 - self.areal_density(pattern)?,
                    ConstraintQuantity::ArealDensity => self.areal_density(pattern)?,
                    ConstraintQuantity::LaserTime => self.laser_time_s(pattern)?,
                    // Where nothing is left that could sag, nothing does.
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

    /// Of the specimen as it is cut, not of the endless pattern.
    fn areal_density(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        Ok(self.layout(pattern)?.areal_density())
    }

    fn laser_time_s(&self, pattern: &Pattern) -> Result<f64, ModelFailure> {
        laser_time_s(&self.layout(pattern)?, &self.laser)
            .ok_or_else(|| ModelFailure::Trial { reason: "the laser's time is not known".to_owned() })
    }
}
