//! Parts of a ledger of trials: samples that are not measured yet, slopes of the land between cavities, and the scatter
//! of samples of one texture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_design::RatioPrediction;
use slipgrid_infer::calibrate::{CalibrationTask, Learned};
use slipgrid_infer::discrepancy::{Discrepancy, Sensitivity, Trial};
use slipgrid_io::formats::calibration::Calibration;

use super::{PER_MM, TrialsReport};

/// Pending sample with its predictions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PendingTrial {
    /// Name of the sample.
    pub name: String,
    /// Areal density: share of a period of the infinite pattern that is cavity.
    pub areal_density: f64,
    /// Edge length per area, in 1/mm.
    pub edge_per_mm: f64,
    /// Depth of the cavities.
    pub depth_um: f64,
    /// Predictions at the conditions of the flat sample.
    pub predicted: Vec<RatioPrediction>,
}

impl PendingTrial {
    fn new(of: &Trial, learned: &Discrepancy) -> Self {
        let loads: Vec<_> = of.measured.iter().map(|at| at.load).collect();
        let sensitivity: Vec<Sensitivity> = of.measured.iter().map(|at| at.sensitivity).collect();
        let found = learned.at(&loads).predict_made(&of.features, &sensitivity, &of.dimension_shifts);
        let predicted =
            of.measured.iter().enumerate().map(|(row, at)| RatioPrediction::new(&at.load, at.modelled, &found, row));
        Self {
            name: of.name.clone(),
            areal_density: tidy(of.features.areal_density),
            edge_per_mm: tidy(of.features.edge_1_m * PER_MM),
            depth_um: tidy(LENGTH_UM.from_si(of.features.depth_m)),
            predicted: predicted.collect(),
        }
    }
}

/// The ledger doubts the stated scatter if its posterior weight is below this value.
const BELIEVED: f64 = 0.5;

/// Standard deviation of ln(ratio) between samples of one texture, for samples without an individually stated scatter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SampleScatter {
    /// Stated scatter, or the default if none was stated.
    pub stated: f64,
    /// Posterior weight of the stated scatter.
    pub weight: f64,
    /// Posterior scatter: root mean square over all candidate scatters.
    pub found: f64,
}

impl SampleScatter {
    /// Scatter of samples from the trials of `learned`; `None` if trials cannot change the scatter, because it is
    /// stated as zero or for every trial.
    pub(super) fn of(learned: &Discrepancy) -> Option<Self> {
        let all = learned.scatter_weights();
        let stated = all.first().filter(|_| all.len() > 1)?;
        Some(Self { stated: tidy(stated.std), weight: tidy(stated.weight), found: tidy(learned.sample_std()) })
    }

    /// States the posterior scatter in one line, and what speaks against the stated one if it is unlikely.
    pub(super) fn text(&self) -> String {
        let Self { stated, weight, found } = self;
        let doubt = format!("; the trials leave the assumed one a weight of {weight:.3}");
        let doubt = if *weight < BELIEVED { &doubt } else { "" };
        format!(
            "scatter of samples of one texture, in ln ratio: {stated} assumed (sample_std), {found:.3} learned and used{doubt}\n"
        )
    }
}

impl TrialsReport {
    /// Makes the ledger of the `calibration` from the samples of `task` and `learned`, the discrepancy learned from these
    /// samples, with pending samples and slopes of the land between cavities. Doubts about the input come first among
    /// the warnings.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` has cancelled.
    pub fn of_samples(
        calibration: &Calibration,
        task: &CalibrationTask,
        learned: &Learned,
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let Learned { discrepancy, pending, lands, .. } = learned;
        let ledger = Self::new(&calibration.stated.name, &task.flat, &task.trials.samples, discrepancy, monitor)?;
        let predicted = pending.iter().map(|sample| PendingTrial::new(sample, discrepancy)).collect();
        Ok(Self { predicted, lands: lands.clone(), ..ledger }.with_warnings(calibration.stated.doubts.clone()))
    }
}
