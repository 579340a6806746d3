//! Samples whose dimensions are not those of the design.

use slipgrid_discrepancy::{DimensionShift, Features};

use super::*;

/// `design` with its lengths off by `side` times `by_m`, at most by nine tenths of each.
pub fn made(design: &Pattern, by_m: &[f64; DIMENSIONS], side: f64) -> Pattern {
    let lengths_m = design.lengths_m();
    let [width_m, spacing_m, depth_m] =
        std::array::from_fn(|axis| (lengths_m[axis] + side * by_m[axis]).max(0.1 * lengths_m[axis]));
    Pattern::new(*design.texture(), width_m, spacing_m, depth_m).unwrap_or(*design)
}

impl Chances<'_> {
    /// Errors of the dimensions of samples of a design: to first order.
    pub fn dimension_shifts(&self, expansion: &Expansion) -> Vec<DimensionShift> {
        let (slopes, values, design) = (&expansion.slopes, expansion.slopes.values(), expansion.slopes.design());
        let log_by = |input: usize, by: f64| {
            slopes.slopes()[input].iter().zip(values).map(move |(slope, value)| by * slope / value)
        };
        let shift = |by_m: [f64; DIMENSIONS], log_ratio: Vec<f64>| {
            let [above, below] = [1.0, -1.0].map(|side| Features::from(&made(design, &by_m, side)));
            DimensionShift { log_ratio, above, below: Some(below) }
        };
        let of_lengths = self.tolerances.independent_m().into_iter().map(|by_m| {
            let mut log_ratio = vec![0.0; values.len()];
            for (axis, by_m) in by_m.into_iter().enumerate() {
                log_ratio.iter_mut().zip(log_by(axis, by_m)).for_each(|(sum, by)| *sum += by);
            }
            shift(by_m, log_ratio)
        });
        let of_rim =
            self.uncertainty.rim().map(|place| shift([0.0; 3], log_by(place, self.uncertainty.std(place)).collect()));
        let of_bursts = self.burst.map(|place| {
            let std = self.uncertainty.std(place);
            shift([0.0, 0.0, std * design.depth_m()], log_by(place, std).collect())
        });
        of_lengths.chain(of_rim).chain(of_bursts).collect()
    }
}
