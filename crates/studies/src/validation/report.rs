//! A validation as JSON.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::ratios::{MeasuredReport, RatioReport};
use super::rims::RimsReport;
use super::summary::Summary;
use slipgrid_results::PatternReport;

/// What `validate --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValidationReport {
    /// `slipgrid`.
    pub program: Cow<'static, str>,
    /// Its version.
    pub version: Cow<'static, str>,
    /// Schema of the file.
    #[serde(default = "slipgrid_results::first_schema")]
    pub schema: u32,
    /// Name of the calibration.
    pub name: String,
    /// Where the measurements come from.
    pub source: String,
    /// Name of the trial that is compared; null where that is the patterned samples of the calibration.
    #[serde(default)]
    pub trial: Option<String>,
    /// Planform of the measured cavities; null where the calibration does not say it.
    #[serde(default)]
    pub cut_as: Option<String>,
    /// Height of the modelled specimen; null where only a layer of it is modelled, as the source did.
    #[serde(default)]
    pub thickness_mm: Option<f64>,
    /// The area law rests on a synthetic surface.
    pub synthetic_surface: bool,
    /// What was modelled and how.
    pub model: Vec<String>,
    /// What the standard deviations of modelled values are of.
    pub errors: String,
    /// The pattern that is modelled, as grooves.
    pub pattern: PatternReport,
    /// The same as square cavities.
    pub areal_density_square: f64,
    /// Depth of the measured cavities.
    pub measured_depth_um: f64,
    /// What the slopes of the surface were multiplied by.
    pub slope_factors: Vec<f64>,
    /// Averages over `results`.
    pub summary: Summary,
    /// What the numbers say, in sentences.
    pub statements: Vec<String>,
    /// What the source says beside what is found here.
    pub published: Vec<PublishedReport>,
    /// Every condition measured on both samples, modelled or not.
    pub measured: Vec<MeasuredReport>,
    /// The area laws, one per slope factor.
    pub area_laws: Vec<AreaTable>,
    /// What rims of several heights would make of the ratios at the condition of the first row; null where that is not asked.
    #[serde(default)]
    pub rims: Option<RimsReport>,
    /// The run in time at the heaviest load; null where none was made.
    pub in_time: Option<TimeReport>,
    /// Seconds, which stand in timings.json.
    #[serde(default)]
    pub wall_s: f64,
    /// Threads that computed.
    #[serde(default)]
    pub threads: usize,
    /// One per measured condition.
    pub results: Vec<RatioReport>,
}

impl ValidationReport {
    /// Square cavities say something of the samples that are compared: these were not cut as grooves.
    #[must_use]
    pub fn has_squares(&self) -> bool {
        self.cut_as.as_deref() != Some("groove")
    }
}

/// A statement of the source and its counterpart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PublishedReport {
    /// What it is about.
    pub quantity: String,
    /// What the source says.
    pub source: String,
    /// What its tables and the model give.
    pub here: String,
}

/// An area law with the contact area behind it, one number per pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaTable {
    /// What the slopes of the surface are multiplied by.
    pub slope_factor: f64,
    /// Rms slope.
    pub rms_slope: Option<f64>,
    /// Nominal pressures.
    pub pressure_mpa: Vec<f64>,
    /// Real contact area over nominal area, corrected along its perimeter.
    pub area_fraction: Vec<f64>,
    /// The factor f.
    pub factor: Vec<f64>,
}

/// Friction in time at one load, whole sample, from rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Travel of the bulk.
    pub sliding_um: f64,
    /// Mean local static coefficient, 0.30/0.27 times the dynamic one.
    pub static_mean: f64,
    /// Mean local dynamic coefficient, measured flat friction over f.
    pub dynamic_mean: f64,
    /// Relative scatter of both.
    pub relative_std: f64,
    /// Dynamic friction, flat.
    pub mu_flat: Option<f64>,
    /// Its standard error in time.
    pub mu_flat_stderr: Option<f64>,
    /// Its standard deviation with what is drawn and measured.
    pub mu_flat_std: Option<f64>,
    /// Peak at the onset of sliding, flat.
    pub mu_static_flat: Option<f64>,
    /// Its standard deviation among draws.
    pub mu_static_flat_std: Option<f64>,
    /// Dynamic friction, patterned.
    pub mu_patterned: Option<f64>,
    /// Its standard error in time.
    pub mu_patterned_stderr: Option<f64>,
    /// Its standard deviation with what is drawn, measured and known of Young's modulus.
    pub mu_patterned_std: Option<f64>,
    /// Peak at the onset of sliding, patterned.
    pub mu_static_patterned: Option<f64>,
    /// Its standard deviation among draws.
    pub mu_static_patterned_std: Option<f64>,
    /// Patterned over flat.
    pub ratio: Option<f64>,
    /// Its standard error in time.
    pub ratio_stderr: Option<f64>,
    /// Its standard deviation with all that is known.
    pub ratio_std: Option<f64>,
    /// How the flat run ended.
    pub status_flat: Cow<'static, str>,
    /// How the patterned run ended.
    pub status_patterned: Cow<'static, str>,
    /// Seconds, which stand in timings.json.
    #[serde(default)]
    pub wall_s: f64,
}
