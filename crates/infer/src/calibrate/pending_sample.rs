//! Modelled ratios of samples that were cut and not yet measured.

use crate::discrepancy::{DimensionShift, Features, Load, Sensitivity, Trial};

/// Modelled ratios of a sample that was cut and not yet measured, at the conditions of the flat sample.
#[derive(Clone, Debug, PartialEq)]
pub struct PendingSample {
    /// Name of the sample.
    pub name: String,
    /// Features of the texture.
    pub features: Features,
    /// Modelled ratios, one per condition.
    pub modelled: Vec<ModelledRatio>,
    /// Changes of the ratios for one standard error of each dimension.
    pub dimension_shifts: Vec<DimensionShift>,
}

/// The modelled ratio of patterned to flat friction at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelledRatio {
    /// Pressure, speed and humidity.
    pub load: Load,
    /// Modelled ratio of patterned to flat friction.
    pub ratio: f64,
    /// Sensitivity of the logarithm of the ratio to the unknowns shared by all textures, such as Young's modulus.
    pub sensitivity: Sensitivity,
}

impl From<Trial> for PendingSample {
    /// Keeps the modelled values and drops the placeholders for measurements.
    fn from(trial: Trial) -> Self {
        let Trial { name, features, measured, dimension_shifts, .. } = trial;
        let modelled =
            measured.iter().map(|at| ModelledRatio { load: at.load, ratio: at.modelled, sensitivity: at.sensitivity });
        Self { name, features, modelled: modelled.collect(), dimension_shifts }
    }
}
