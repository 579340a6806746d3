//! Predictions for samples that were cut and are not measured yet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_design::RatioPrediction;
use slipgrid_design::results::{Table, believed, believed_interval, fixed};
use slipgrid_infer::calibrate::{LearnedSamples, PendingSample};
use slipgrid_infer::discrepancy::{Discrepancy, Sensitivity};

use super::{PER_MM, SAMPLE_AND_LOAD, TrialsReport, sample_and_load};

/// Pending sample with its predictions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PendingReport {
    /// Name of the sample.
    pub name: String,
    /// Areal density: share of the face that is cavity.
    pub areal_density: f64,
    /// Edge length per area, in 1/mm.
    pub edge_per_mm: f64,
    /// Depth of the cavities.
    pub depth_um: f64,
    /// Predictions at the conditions of the flat sample.
    pub predicted: Vec<RatioPrediction>,
}

impl PendingReport {
    fn new(of: &PendingSample, learned: &Discrepancy) -> Self {
        let loads: Vec<_> = of.modelled.iter().map(|at| at.load).collect();
        let sensitivity: Vec<Sensitivity> = of.modelled.iter().map(|at| at.sensitivity).collect();
        let found = learned.at(&loads).predict_made(&of.features, &sensitivity, &of.dimension_shifts);
        let predicted =
            of.modelled.iter().enumerate().map(|(row, at)| RatioPrediction::new(&at.load, at.ratio, &found, row));
        Self {
            name: of.name.clone(),
            areal_density: tidy(of.features.areal_density),
            edge_per_mm: tidy(of.features.edge_1_m * PER_MM),
            depth_um: tidy(LENGTH_UM.from_si(of.features.depth_m)),
            predicted: predicted.collect(),
        }
    }
}

impl TrialsReport {
    /// Adds predictions for the pending samples.
    #[must_use]
    pub fn with_pending(self, learned: &LearnedSamples) -> Self {
        let of = |sample: &PendingSample| PendingReport::new(sample, &learned.discrepancy);
        Self { predicted: learned.pending.iter().map(of).collect(), ..self }
    }

    /// Formats the pending samples as text; empty without any.
    pub(super) fn pending_text(&self) -> String {
        if self.predicted.is_empty() {
            return String::new();
        }
        let mut table =
            Table::new(["pending"].into_iter().chain(SAMPLE_AND_LOAD).chain(["model", "predicted", "95 %"]));
        for of in &self.predicted {
            for at in &of.predicted {
                let sample = [of.areal_density, of.edge_per_mm, of.depth_um];
                let cells = sample_and_load(sample, [at.pressure_mpa, at.speed_mm_s, at.humidity_pct]);
                let said = [fixed(Some(at.modelled), 3), believed(at.ratio, 3), believed_interval(at.interval_95)];
                table.row([of.name.clone()].into_iter().chain(cells).chain(said));
            }
        }
        format!("\npending: cut and not yet measured; ratios modelled, and predicted by all trials\n{table}")
    }
}
