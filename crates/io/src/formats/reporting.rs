//! The table `[reporting]` of a calibration file: statements for a report of friction measurements.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statements about the measurements that a report needs and no computation uses, in free text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reporting {
    /// Standard or procedure by which friction was measured.
    pub standard: Option<String>,
    /// Laboratory, and date of the measurements.
    pub laboratory: Option<String>,
    /// Type and maker of the tribometer, with its force sensors.
    pub apparatus: Option<String>,
    /// Geometry of the contact and kind of motion.
    pub motion: Option<String>,
    /// Grade, maker and batch of the specimens' material.
    pub specimen_material: Option<String>,
    /// How the specimens were made, finished and conditioned.
    pub specimen_preparation: Option<String>,
    /// Roughness of the specimens before the test, with its filters.
    pub specimen_roughness: Option<String>,
    /// Material and hardness of the counterface.
    pub counterface_material: Option<String>,
    /// How the counterface was made and finished.
    pub counterface_preparation: Option<String>,
    /// Roughness of the counterface before the test, with its filters and direction.
    pub counterface_roughness: Option<String>,
    /// How specimens and counterface were cleaned.
    pub cleaning: Option<String>,
    /// Sliding before the measurement, and whether a counterface was used again.
    pub running_in: Option<String>,
    /// Lubricant and films between the faces; `none` for dry sliding.
    pub lubricant: Option<String>,
    /// Gas around the contact and its pressure.
    pub atmosphere: Option<String>,
    /// Temperature of the air, and of the contact where it was measured.
    pub temperature: Option<String>,
    /// Wear, transferred material and noise that were seen.
    pub observations: Option<String>,
}
