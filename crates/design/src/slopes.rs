//! Derivatives of expected values of a sample with respect to its dimensions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{LENGTH_UM, tidy};

use crate::inputs::made;
use crate::prediction::Prediction;
use crate::search::Search;

/// Derivatives of the expected values of a sample with respect to one dimension.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SlopeReport {
    /// `width_um`, `spacing_um` or `depth_um`.
    pub dimension: String,
    /// Change of the median of samples per micrometre, in the quantity of the target, one per load of each condition.
    pub per_um: Vec<f64>,
}

/// Computes the derivatives of the medians of samples of `best` along every dimension that is not fixed, with a
/// constant number of cavities, from differences over one block or burst to each side. Dimensions whose differences
/// cannot be computed are left out.
pub fn slopes(search: &Search<'_>, best: &Prediction) -> Vec<SlopeReport> {
    let pattern = best.texture.pattern;
    let limits = &search.task.constraints.limits;
    let block_m = search.task.layer.block_m;
    let steps_m = [block_m, block_m, limits.depth_per_burst_m.unwrap_or(block_m).min(0.2 * pattern.depth_m())];
    let slope = |(axis, dimension): (usize, &str)| {
        let by_m: [f64; 3] = std::array::from_fn(|other| if other == axis { steps_m[axis] } else { 0.0 });
        let at = |side: f64| search.made(best, &made(&pattern, &by_m, side)).map(|found| found.medians());
        let (above, below) = (at(1.0)?, at(-1.0)?);
        let per_um = above.iter().zip(&below).zip(&search.asked.bands);
        let per_um = per_um
            .map(|((above, below), band)| tidy(band.flat * (above - below) / (2.0 * LENGTH_UM.from_si(steps_m[axis]))));
        Some(SlopeReport { dimension: dimension.to_owned(), per_um: per_um.collect() })
    };
    let free = search.task.space.lengths_m().map(|[low, high]| low < high);
    let all = ["width_um", "spacing_um", "depth_um"].into_iter().enumerate();
    all.filter(|(axis, _)| free[*axis]).filter_map(slope).collect()
}
