//! All designs of a lattice, as an independent check of the search: widths and spacings in whole blocks, depths in whole
//! bursts.

use rayon::prelude::*;
use slipgrid_model::pattern::Pattern;

use crate::search::Search;
use crate::whole_steps::lattice;

/// Every design of a lattice with the prediction for a sample, by the table over the bounds.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Designs of the lattice.
    pub patterns: Vec<Pattern>,
    /// Prediction for each design; `None` if it cannot be computed.
    pub predicted: Vec<Option<LatticeSample>>,
}

/// Prediction for a sample of a lattice design.
#[derive(Clone, Debug)]
pub struct LatticeSample {
    /// Chance that the sample is on target.
    pub chance: f64,
    /// Medians of the target's quantity, one per load of each condition.
    pub medians: Vec<f64>,
    /// Quantities that the task limits, in SI units, in the order of the limits.
    pub limited: Vec<f64>,
    /// Whether all limits hold.
    pub keeps_limits: bool,
}

impl Lattice {
    /// Builds the lattice for the task of `search`.
    pub fn new(search: &Search<'_>) -> Self {
        let patterns = lattice(search.task);
        let sample = |pattern: &Pattern| {
            let found = search.roughly(pattern).filter(|_| !search.stage.cancelled())?;
            let limited = search.task.limited(pattern, &search.table.answer(pattern)?).ok()?;
            let medians = found.medians();
            let medians = medians.iter().zip(&search.asked.bands).map(|(ratio, band)| ratio * band.flat);
            let keeps_limits = found.texture.excess == 0.0;
            Some(LatticeSample { chance: found.chance(), medians: medians.collect(), limited, keeps_limits })
        };
        let predicted = patterns.par_iter().map(sample).collect();
        Self { patterns, predicted }
    }
}
