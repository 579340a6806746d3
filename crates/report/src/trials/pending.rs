//! Samples that were cut and are not measured yet: what is predicted of them.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::LearnedSamples;
use slipgrid_discrepancy::{Discrepancy, Trial};
use slipgrid_results::{Table, believed, fixed};
use slipgrid_units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};

use super::{PER_MM, TrialsReport};

/// A pending sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PendingReport {
    /// Its name.
    pub name: String,
    /// Share of its face that is cavity.
    pub areal_density: f64,
    /// Length of its edges over its area, in 1/mm.
    pub edge_per_mm: f64,
    /// Depth of its cavities.
    pub depth_um: f64,
    /// What is predicted at the flat sample's conditions.
    pub predicted: Vec<PendingRatioReport>,
}

/// What all trials say of a ratio that is not measured yet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PendingRatioReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Modelled ratio.
    pub modelled: f64,
    /// Median of the true ratio of such a sample.
    pub ratio: f64,
    /// Ends of the interval that holds 95 % of such samples.
    pub interval_95: [f64; 2],
}

impl PendingRatioReport {
    /// The interval in words.
    pub(crate) fn interval(&self) -> String {
        let [low, high] = self.interval_95.map(|end| believed(end, 3));
        format!("{low} to {high}")
    }
}

impl PendingReport {
    fn new(of: &Trial, learned: &Discrepancy) -> Self {
        let loads: Vec<_> = of.measured.iter().map(|at| at.load).collect();
        let sensitivity: Vec<f64> = of.measured.iter().map(|at| at.modulus_sensitivity).collect();
        // Errors of its dimensions move all ratios together: cov_ij = sum of d_i d_j.
        let n = loads.len();
        let entry = |e: usize| of.of_dimensions.iter().map(|slopes| slopes[e / n] * slopes[e % n]).sum();
        let of_dimensions: Vec<f64> = (0..n * n).map(entry).collect();
        let found = learned.at(&loads).predict(&of.features, &sensitivity).with(&of_dimensions);
        let predicted = of.measured.iter().enumerate().map(|(row, at)| {
            let quantile = |p: f64| tidy(at.modelled * found.quantile(row, p).exp());
            PendingRatioReport {
                pressure_mpa: tidy(PRESSURE_MPA.from_si(at.load.pressure_pa)),
                speed_mm_s: tidy(SPEED_MM_S.from_si(at.load.speed_m_s)),
                humidity_pct: tidy(HUMIDITY_PCT.from_si(at.load.humidity)),
                modelled: tidy(at.modelled),
                ratio: quantile(0.5),
                interval_95: [quantile(0.025), quantile(0.975)],
            }
        });
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
    /// The same with what is predicted of the samples that are pending.
    #[must_use]
    pub fn with_pending(self, learned: &LearnedSamples) -> Self {
        let of = |trial: &Trial| PendingReport::new(trial, &learned.discrepancy);
        Self { predicted: learned.pending.iter().map(of).collect(), ..self }
    }

    /// The pending samples in words; nothing without any.
    pub(super) fn pending_text(&self) -> String {
        if self.predicted.is_empty() {
            return String::new();
        }
        let mut table = Table::new([
            "pending",
            "density",
            "edges 1/mm",
            "depth um",
            "P MPa",
            "v mm/s",
            "RH %",
            "model",
            "predicted",
            "95 %",
        ]);
        for of in &self.predicted {
            for at in &of.predicted {
                table.row([
                    of.name.clone(),
                    fixed(Some(of.areal_density), 3),
                    fixed(Some(of.edge_per_mm), 2),
                    fixed(Some(of.depth_um), 1),
                    fixed(Some(at.pressure_mpa), 3),
                    at.speed_mm_s.to_string(),
                    at.humidity_pct.to_string(),
                    fixed(Some(at.modelled), 3),
                    believed(at.ratio, 3),
                    at.interval(),
                ]);
            }
        }
        format!("\npending: cut and not yet measured; ratios modelled, and predicted by all trials\n{table}")
    }
}
