//! Samples that were cut and are not yet measured, as they are modelled.

use slipgrid_discrepancy::{DimensionShift, Features, Load, Sensitivity, Trial};

/// A sample that was cut and not yet measured, as it is modelled at the flat sample's conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct PendingSample {
    /// Its name.
    pub name: String,
    /// Its texture.
    pub features: Features,
    /// What is modelled, one a condition.
    pub modelled: Vec<ModelledRatio>,
    /// Errors of its dimensions.
    pub dimension_shifts: Vec<DimensionShift>,
}

/// The modelled ratio of patterned to flat friction at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelledRatio {
    /// Pressure, speed and humidity.
    pub load: Load,
    /// The ratio.
    pub ratio: f64,
    /// How its logarithm follows what all textures have in common.
    pub sensitivity: Sensitivity,
}

impl From<Trial> for PendingSample {
    /// Without what stands for measurements.
    fn from(trial: Trial) -> Self {
        let Trial { name, features, measured, dimension_shifts, .. } = trial;
        let modelled =
            measured.iter().map(|at| ModelledRatio { load: at.load, ratio: at.modelled, sensitivity: at.sensitivity });
        Self { name, features, modelled: modelled.collect(), dimension_shifts }
    }
}
