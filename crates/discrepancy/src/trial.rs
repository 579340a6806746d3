//! Trials: samples that were cut and measured.

use crate::{DiscrepancyError, Features, Load};

/// A sample that was cut and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its name.
    pub name: String,
    /// Its texture, as it was measured or designed.
    pub features: Features,
    /// Standard deviation of t where it is known; that of the hyperparameters otherwise.
    pub sample_std: Option<f64>,
    /// The disc that it shares with other trials of this name; `None` on a disc of its own. Trials of one disc share t.
    pub disc: Option<String>,
    /// What was measured of it.
    pub measured: Vec<Measured>,
    /// Standard errors of its width, spacing and depth, in metres; 0 where they are taken as exact.
    pub dimensions_std_m: [f64; 3],
    /// What errors of its dimensions do, one list a dimension: d ln R / dx times the standard error of x, at each of `measured`.
    pub of_dimensions: Vec<Vec<f64>>,
}

/// A ratio of patterned to flat friction that was measured, beside the modelled one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Pressure, speed and humidity. Measurements of one condition share the flat sample's.
    pub load: Load,
    /// Measured ratio.
    pub measured: f64,
    /// Modelled ratio.
    pub modelled: f64,
    /// Standard error of the patterned sample's friction over itself.
    pub patterned_std: f64,
    /// Standard error of the flat sample's friction over itself.
    pub flat_std: f64,
    /// g = d ln R / d ln E.
    pub modulus_sensitivity: f64,
}

impl Measured {
    /// ln(measured / modelled).
    #[must_use]
    pub fn log_excess(&self) -> f64 {
        libm::log(self.measured / self.modelled)
    }
}

impl Trial {
    /// # Errors
    /// [`DiscrepancyError::Measured`] of the first number that means nothing.
    pub(crate) fn check(&self) -> Result<(), DiscrepancyError> {
        for (row, at) in self.measured.iter().enumerate() {
            let refuse = |quantity, value, expected| {
                Err(DiscrepancyError::Measured { trial: self.name.clone(), row: row + 1, quantity, value, expected })
            };
            for (quantity, value) in [
                ("pressure in pascals", at.load.pressure_pa),
                ("speed in m/s", at.load.speed_m_s),
                ("measured ratio", at.measured),
                ("modelled ratio", at.modelled),
            ] {
                if !(value > 0.0 && value.is_finite()) {
                    return refuse(quantity, value, "positive and finite");
                }
            }
            for (quantity, value) in [
                ("humidity", at.load.humidity),
                ("error of the patterned sample", at.patterned_std),
                ("error of the flat sample", at.flat_std),
            ] {
                if !(0.0..=1.0).contains(&value) {
                    return refuse(quantity, value, "from 0 to 1");
                }
            }
            if !at.modulus_sensitivity.is_finite() {
                return refuse("sensitivity to the modulus", at.modulus_sensitivity, "finite");
            }
        }
        Ok(())
    }
}
