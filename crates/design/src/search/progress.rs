//! What a running search knows: solved textures, and what interpolates between them.

use slipgrid_infer::discrepancy::Features;
use slipgrid_model::pattern::Pattern;

use super::is_same;
use crate::between_designs::BetweenDesigns;
use crate::prediction::Prediction;

/// State of a running search in addition to the table.
#[derive(Default)]
pub struct Progress {
    /// Textures solved by the model.
    pub solved: Vec<Prediction>,
    /// Solved textures; those not solved as cut include the interpolated effect of the specimen's ends, pressure tilt
    /// and time.
    pub with_cutting: Vec<Prediction>,
    /// Textures that the model cannot compute.
    pub refused: Vec<Pattern>,
    /// Error of the table in ln R, R the friction ratio, at every load, interpolated between solved textures.
    pub off: BetweenDesigns,
    /// Effect of the specimen's ends, pressure tilt and time on ln R, interpolated between textures solved as cut.
    pub by_cutting: BetweenDesigns,
    /// Logarithm of the peak pressure in the run of a specimen over that of its cell, interpolated between textures
    /// solved as cut; empty without a limit of this pressure.
    pub peak_by_run: BetweenDesigns,
}

impl Progress {
    pub fn is_known(&self, design: &Pattern) -> bool {
        let own = Features::from(design);
        self.refused.contains(design) || self.solved.iter().any(|of| is_same(&of.texture.features, &own))
    }

    /// Peak pressure in the run of a specimen of `design` over that of its cell, at least 1; 1 if no run is known.
    pub fn run_over_cell(&self, design: &Pattern) -> f64 {
        self.peak_by_run.at(design).map_or(1.0, |log| log[0].exp().max(1.0))
    }

    /// Covariance of ln R from errors that all samples share, taken from the solved texture nearest to `design`; empty
    /// if there is none.
    pub fn covariance(&self, design: &Pattern) -> Vec<f64> {
        let apart = |of: &Prediction| -> f64 {
            let lengths = design.lengths_m().into_iter().zip(of.texture.pattern.lengths_m());
            lengths.map(|(a, b)| (a / b).ln().powi(2)).sum()
        };
        let nearest = self.solved.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.map_or_else(Vec::new, |of| of.texture.covariance.clone())
    }
}
