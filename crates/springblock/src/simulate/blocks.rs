//! How far the ratio of a steady cell is from that of vanishing blocks.
//!
//! From ratios in blocks of 2l, l and l/2, or of l, l/2 and l/4 where that is cheap, with the differences d_1 and d_2 from
//! each to the next, the order of convergence and what is left after the last are
//!
//! ```text
//! p = log2 |d_1 / d_2|,   tail = |d_2| / (2^p - 1),   0.5 <= p <= 2
//! ```
//!
//! At the edges of lands pressure is singular, and an area law that begins at some pressure sees nothing but these
//! at light loads: orders down to one half occur, and differences change sign. So the estimate is the sum of the
//! differences from l on, not of their sum, and of 1.5 tails, the largest over all loads. On 40 random patterns it is not
//! below the error in 97 % of cases (`tests/validation/blocks.rs`).

use crate::scene::Scene;

/// Orders of convergence that are believed.
const ORDERS: [f64; 2] = [0.5, 2.0];
/// Tails that count.
const TAILS: f64 = 1.5;

/// Ratios by load in blocks of each size; `None` in blocks that cannot be had.
pub type Ratios = Option<Vec<Option<f64>>>;

/// An estimate of how far ratios in blocks of `scene` are from those of vanishing blocks, the same for every load; `None`
/// where two other sizes cannot be had. `own`: the ratios in its own blocks; `ratios`: those of the scene in other
/// blocks, or nothing where they are too dear.
pub fn block_error(scene: &Scene, own: &[Option<f64>], ratios: impl Fn(&Scene) -> Ratios) -> Option<f64> {
    let by = |factor: f64| sized(scene, factor).and_then(|scene| ratios(&scene));
    let own = Some(own.to_vec());
    let half = by(0.5);
    let quarter = if half.is_some() { by(0.25) } else { None };
    // Ratios from the largest blocks on, and the place of the own ones among them.
    let (levels, first) = match (half, quarter) {
        (Some(half), Some(quarter)) => ([own, Some(half), Some(quarter)], 0),
        (Some(half), None) => ([by(2.0), own, Some(half)], 1),
        _ => ([by(4.0), by(2.0), own], 2),
    };
    let [Some(coarse), Some(middle), Some(fine)] = levels else { return None };
    let at = |load: usize| -> Option<f64> {
        let [coarse, middle, fine] = [coarse[load]?, middle[load]?, fine[load]?];
        Some(error([middle - coarse, fine - middle], first))
    };
    (0..fine.len()).map(at).try_fold(0.0, |largest: f64, error| error.map(|error| largest.max(error)))
}

/// The estimate from the differences of three sizes, of which number `first` is the own one.
fn error(differences: [f64; 2], first: usize) -> f64 {
    let [before, last] = differences.map(f64::abs);
    if last == 0.0 {
        return if first == 0 { before } else { 0.0 };
    }
    let order = (before / last).log2().clamp(ORDERS[0], ORDERS[1]);
    let order = if differences[0] * differences[1] > 0.0 { order } else { ORDERS[0] };
    let tail = last / (order.exp2() - 1.0);
    [before, last][first.min(2)..].iter().sum::<f64>() + TAILS * tail
}

/// `scene` in blocks `factor` times as large; `None` where they do not divide the layer or the specimen behind it.
pub fn sized(scene: &Scene, factor: f64) -> Option<Scene> {
    let mut other = scene.clone();
    other.layer.block_m *= factor;
    // The cell knows no specimen: any whole number of blocks does.
    other.layer.length_m = other.layer.height_m;
    let depth_m = scene.pattern.as_ref().map_or(0.0, slipgrid_pattern::Pattern::depth_m);
    (other.layer.height_m - other.layer.block_m > depth_m && other.validate().is_ok()).then_some(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_of_known_order_is_bounded_and_not_by_much() {
        for order in [0.5_f64, 0.7, 1.0, 1.5, 2.0] {
            // r(l) = c l^p
            let ratio = |block: f64| 0.01 * block.powf(order);
            for (blocks, first) in [([1.0, 0.5, 0.25], 0), ([2.0, 1.0, 0.5], 1), ([4.0, 2.0, 1.0], 2)] {
                let [coarse, middle, fine] = blocks.map(ratio);
                let found = error([middle - coarse, fine - middle], first);
                assert!(found >= ratio(1.0) && found <= 1.51 * ratio(1.0), "{order} {first}: {found}");
            }
        }
    }

    #[test]
    fn differences_that_change_sign_do_not_cancel() {
        let found = error([0.004, -0.003], 0);
        assert!((found - (0.007 + 1.5 * 0.003 / (2.0_f64.sqrt() - 1.0))).abs() < 1e-12);
        assert_eq!((error([0.0, 0.0], 0), error([0.001, 0.0], 0), error([0.001, 0.0], 1)), (0.0, 0.001, 0.0));
    }
}
