//! Record of a validation.

use serde::Serialize;

use super::laws::ScaledLaw;
use super::ratios::{MeasuredReport, RatioReport};
use super::rims::RimsReport;
use super::summary::Summary;
use slipgrid_design::results::{MadeBy, PatternReport};

/// Record that `validate --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Program that made the record.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the calibration.
    pub name: String,
    /// Source of the measurements.
    pub source: String,
    /// Name of the compared trial; null if the calibration's patterned samples are compared.
    pub trial: Option<String>,
    /// Planform of the measured cavities; null if the calibration does not state it.
    pub cut_as: Option<String>,
    /// Height of the modelled specimen; null if only a layer is modelled, as in the source.
    pub thickness_mm: Option<f64>,
    /// The area law is based on a synthetic surface.
    pub synthetic_surface: bool,
    /// Model assumptions and methods.
    pub model: Vec<String>,
    /// Description of the error sources that the standard deviations of modelled values include.
    pub errors: String,
    /// Modelled pattern, as grooves.
    pub pattern: PatternReport,
    /// Areal density of the modelled pattern as square cavities.
    pub areal_density_square: f64,
    /// Depth of the measured cavities.
    pub measured_depth_um: f64,
    /// Factors on the slopes of the surface.
    pub slope_factors: Vec<f64>,
    /// Averages over all `results`.
    pub summary: Summary,
    /// Conclusions, in sentences.
    pub statements: Vec<String>,
    /// Statements of the source, compared with the results; empty for other sources and for trials.
    pub published: Vec<PublishedReport>,
    /// Every condition measured on both samples, modelled or not.
    pub measured: Vec<MeasuredReport>,
    /// Area laws, one per slope factor.
    pub area_laws: Vec<ScaledLaw>,
    /// Ratios for rims of several heights at the speed and humidity of the first result; null if not requested.
    pub rims: Option<RimsReport>,
    /// Transient run at the highest load; null if no run was made.
    pub in_time: Option<TimeReport>,
    /// Wall time in seconds, stored in timings.json.
    pub wall_s: f64,
    /// Number of threads.
    pub threads: usize,
    /// Measured and modelled ratios, one result per compared condition.
    pub results: Vec<RatioReport>,
}

impl ValidationReport {
    /// Whether square cavities are modelled in addition to grooves; false if the samples were cut as grooves.
    pub fn has_squares(&self) -> bool {
        self.cut_as.as_deref() != Some("groove")
    }

    /// Remark on a synthetic surface for titles; empty for a measured surface.
    pub(super) const fn synthetic_words(&self) -> &'static str {
        if self.synthetic_surface { " (synthetic surface)" } else { "" }
    }

    /// Results at the speed and humidity of the first result.
    pub(super) fn at_first_condition(&self) -> Vec<&RatioReport> {
        let first = self.results.first();
        let alike = |row: &&RatioReport| first.is_some_and(|first| row.measured.is_at_condition_of(&first.measured));
        self.results.iter().filter(alike).collect()
    }

    /// Results at the speed and humidity of the first result, by increasing pressure.
    pub(super) fn by_pressure(&self) -> Vec<&RatioReport> {
        let mut rows = self.at_first_condition();
        rows.sort_by(|a, b| a.measured.pressure_mpa.total_cmp(&b.measured.pressure_mpa));
        rows
    }

    /// Whether all results have the speed and humidity of the first result.
    pub(super) fn has_one_condition(&self) -> bool {
        self.at_first_condition().len() == self.results.len()
    }
}

/// Statement of the source with the corresponding result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PublishedReport {
    /// Subject of the statement.
    pub quantity: String,
    /// Statement of the source.
    pub source: String,
    /// Corresponding result of slipgrid, from the model or from the source's tables.
    pub here: String,
}

/// Results of a transient run at one load: whole sample as grooves, from rest. Friction is null where the run gives
/// none, for the reason that the status states.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TimeReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Travel of the bulk of the specimen.
    pub sliding_um: f64,
    /// Mean local static coefficient: 0.30/0.27 times the dynamic coefficient.
    pub static_mean: f64,
    /// Mean local dynamic coefficient: measured flat friction over the area factor f.
    pub dynamic_mean: f64,
    /// Relative standard deviation of both local coefficients between blocks.
    pub relative_std: f64,
    /// Dynamic friction of the flat surface.
    pub mu_flat: Option<f64>,
    /// Standard error of `mu_flat` as an average over time.
    pub mu_flat_stderr: Option<f64>,
    /// Standard deviation of `mu_flat` from the time average, random draws of the local coefficients, and measured
    /// friction.
    pub mu_flat_std: Option<f64>,
    /// Static peak at the onset of sliding, flat surface.
    pub mu_static_flat: Option<f64>,
    /// Standard deviation of `mu_static_flat` between random draws of the local coefficients.
    pub mu_static_flat_std: Option<f64>,
    /// Dynamic friction of the patterned surface.
    pub mu_patterned: Option<f64>,
    /// Standard error of `mu_patterned` as an average over time.
    pub mu_patterned_stderr: Option<f64>,
    /// Standard deviation of `mu_patterned` from the time average, random draws of the local coefficients, measured
    /// friction, and Young's modulus.
    pub mu_patterned_std: Option<f64>,
    /// Static peak at the onset of sliding, patterned surface.
    pub mu_static_patterned: Option<f64>,
    /// Standard deviation of `mu_static_patterned` between random draws of the local coefficients.
    pub mu_static_patterned_std: Option<f64>,
    /// Ratio of patterned to flat dynamic friction.
    pub ratio: Option<f64>,
    /// Standard error of the ratio as an average over time.
    pub ratio_stderr: Option<f64>,
    /// Standard deviation of the ratio from all known error sources.
    pub ratio_std: Option<f64>,
    /// Status at the end of the flat run.
    pub status_flat: &'static str,
    /// Status at the end of the patterned run.
    pub status_patterned: &'static str,
    /// Wall time in seconds, stored in timings.json.
    pub wall_s: f64,
}
