//! Samples that were cut, with their patterns, specimens and measurements.

use std::path::PathBuf;
use std::sync::Arc;

use slipgrid_laser::export::Specimen;
use slipgrid_model::pattern::{Pattern, ReliefMap};
use slipgrid_model::springblock::Holder;

use crate::calibrate::{LandSlope, Measurement};
use crate::discrepancy::Hyperparameters;

/// A sample that was cut; it is pending if it has no measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSample {
    /// Name of the sample.
    pub name: String,
    /// Date of the measurement as written in the file, or empty.
    pub date: String,
    /// Free text from the file.
    pub notes: String,
    /// Pattern, as measured or as designed.
    pub pattern: Pattern,
    /// Measured heights of the face over one period, used instead of modelled rims; `None` without such a map.
    pub relief: Option<Arc<ReliefMap>>,
    /// Path of the altitude map of the sample as cut, if the file names one.
    pub map: Option<PathBuf>,
    /// Rms slope of the land between cavities, if it was compared with the slope of the flat sample.
    pub land: Option<LandSlope>,
    /// Standard errors of width, spacing and depth, in metres; 0 for exact dimensions.
    pub dimensions_std_m: [f64; 3],
    /// Standard deviation, over samples of one texture, of the logarithm of the friction ratio; `None` if not stated.
    pub sample_std: Option<f64>,
    /// Name of the disc if the sample is one of several sectors of it; `None` if it has its own disc.
    pub disc: Option<String>,
    /// Specimen into which the sample was cut.
    pub specimen: CutSpecimen,
    /// Measurements; empty while the sample is pending.
    pub measured: Vec<Measurement>,
}

/// Specimen into which a sample was cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutSpecimen {
    /// Face, and treatment of cavities that cross its border; `None` for an infinite pattern, as on a sector of a disc.
    pub face: Option<Specimen>,
    /// Thickness, in metres, if it differs from that of the task's layer.
    pub thickness_m: Option<f64>,
    /// How the specimen is held, if it differs from that of the task's layer.
    pub holder: Option<Holder>,
}

/// Input for learning from trials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialsTask {
    /// Samples, earliest first.
    pub samples: Vec<CutSample>,
    /// Prior of the discrepancy.
    pub prior: Hyperparameters,
}
