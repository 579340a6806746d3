//! Lands of trials, compared with the flat sample.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{PRESSURE_MPA, tidy};
use slipgrid_infer::calibrate::LandEffect;

use super::TrialsReport;

/// Land of a trial, and its effect on the modelled ratios.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LandReport {
    /// Name of the trial.
    pub trial: String,
    /// Rms slope of the land, by differences of neighbouring heights.
    pub rms_slope: f64,
    /// Rms slope over that of the flat sample.
    pub over_flat: f64,
    /// Standard error of the logarithm of `over_flat`, from windows of both maps.
    pub log_std: f64,
    /// Nominal pressures of the measured ratios.
    pub pressure_mpa: Vec<f64>,
    /// Factor on the modelled ratio at each pressure.
    pub factor: Vec<f64>,
    /// Slope and effect in words.
    pub words: String,
}

impl From<&LandEffect> for LandReport {
    fn from(of: &LandEffect) -> Self {
        let factors = || of.factors.iter();
        Self {
            trial: of.trial.clone(),
            rms_slope: of.slope.rms_slope,
            over_flat: of.slope.over_flat,
            log_std: of.slope.log_std,
            pressure_mpa: factors().map(|[pressure_pa, _]| tidy(PRESSURE_MPA.from_si(*pressure_pa))).collect(),
            factor: factors().map(|[_, factor]| *factor).collect(),
            words: of.to_string(),
        }
    }
}

impl TrialsReport {
    /// Adds the `lands` of measured trials.
    #[must_use]
    pub fn with_lands(self, lands: &[LandEffect]) -> Self {
        Self { lands: lands.iter().map(LandReport::from).collect(), ..self }
    }

    /// One line per land.
    pub(super) fn lands_text(&self) -> String {
        self.lands.iter().map(|land| format!("{}\n", land.words)).collect()
    }
}
