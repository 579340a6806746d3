//! Laboratories drawn from the posterior, and their predictions for every texture.

use super::generator::{Generator, within};
use super::physics::LOADS;
use super::truth::{DIMENSIONS_STD, SAMPLE_STD, TOLERANCE};
use super::{FALL, MIDDLE, NEAR_FLAT, REACHED, at_fall};

/// Draw of a laboratory that is consistent with the measurements.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    /// Index of the mechanism in the generator's kinds.
    pub kind: usize,
    /// Logarithm of the laboratory's Young's modulus over the expected one.
    pub log_modulus: f64,
    /// Size of the mechanism at each load.
    pub amplitude: [f64; LOADS],
    /// Errors of the flat sample's logarithms, by load.
    pub flat: [f64; LOADS],
    /// Weight: a logarithm before [`Draws::new`], a fraction of the sum afterwards.
    pub weight: f64,
}

/// Draws whose weights sum to 1.
#[derive(Clone, Debug, Default)]
pub struct Draws {
    /// All draws with a positive weight.
    pub all: Vec<Draw>,
}

impl Draws {
    /// Creates normalized draws from draws whose weights are logarithms.
    pub fn new(mut all: Vec<Draw>) -> Self {
        let most = all.iter().map(|draw| draw.weight).fold(f64::NEG_INFINITY, f64::max);
        all.iter_mut().for_each(|draw| draw.weight = (draw.weight - most).exp());
        Self { all }.normalized()
    }

    fn normalized(mut self) -> Self {
        let sum: f64 = self.all.iter().map(|draw| draw.weight).sum();
        self.all.retain(|draw| draw.weight > 0.0);
        self.all.iter_mut().for_each(|draw| draw.weight /= sum);
        self
    }

    /// Effective number of draws: the number of equally weighted draws with the same variance; 0 without draws.
    pub fn effective(&self) -> f64 {
        if self.all.is_empty() {
            return 0.0;
        }
        1.0 / self.all.iter().map(|draw| draw.weight * draw.weight).sum::<f64>()
    }

    /// Conditions the draws on the knowledge that `target` was drawn until some texture truly reaches it. Draws of
    /// laboratories that do not reach it are dropped; the others are weighted by the inverse of the share of targets
    /// that they reach.
    pub fn of_reached(&self, generator: &Generator, target: &[f64; LOADS]) -> Self {
        let near = between(target, REACHED * TOLERANCE);
        let mut left = Vec::new();
        for draw in &self.all {
            let truths = || (0..generator.textures()).map(|place| generator.log_truth(draw, place));
            if truths().any(|log| is_within(&log, &near)) {
                let share = share_reached(truths().map(|log| log.map(f64::exp)));
                left.push(Draw { weight: draw.weight / share, ..*draw });
            }
        }
        Self { all: left }.normalized()
    }

    /// Probability, for each texture, that a sample is on target; `wanted` holds the limits of the logarithms.
    pub fn chances(&self, generator: &Generator, wanted: &[[f64; LOADS]; 2]) -> Vec<f64> {
        let mut chances = vec![0.0; generator.textures()];
        for draw in &self.all {
            for (place, chance) in chances.iter_mut().enumerate() {
                *chance += draw.weight * chance_of(&generator.log_truth(draw, place), wanted);
            }
        }
        chances
    }

    /// Predicted probability, at each load, that the measured logarithm of a sample of texture `place` is below
    /// `measured`.
    pub fn below(&self, generator: &Generator, place: usize, noise: f64, measured: &[f64; LOADS]) -> [f64; LOADS] {
        let mut below = [0.0; LOADS];
        for draw in &self.all {
            let log = generator.log_truth(draw, place);
            for load in 0..LOADS {
                let variance = noise * noise + SAMPLE_STD * SAMPLE_STD + (DIMENSIONS_STD * log[load]).powi(2);
                let z = (measured[load] - log[load] + draw.flat[load]) / variance.sqrt();
                below[load] += draw.weight * slipgrid_base::statistics::normal_probability(z);
            }
        }
        below
    }
}

/// Lower and upper limits of ratios within `distance` of `target`.
pub fn around(target: &[f64; LOADS], distance: f64) -> [[f64; LOADS]; 2] {
    [-distance, distance].map(|distance| target.map(|ratio| ratio + distance))
}

/// Logarithms of the limits returned by [`around`].
pub fn between(target: &[f64; LOADS], distance: f64) -> [[f64; LOADS]; 2] {
    around(target, distance).map(|ratios| ratios.map(f64::ln))
}

/// Whether every value is within its limits.
pub fn is_within(values: &[f64; LOADS], [lower, upper]: &[[f64; LOADS]; 2]) -> bool {
    (0..LOADS).all(|load| (lower[load]..=upper[load]).contains(&values[load]))
}

/// Probability that a sample is on target, if its texture as designed has the logarithms `log`.
pub fn chance_of(log: &[f64; LOADS], wanted: &[[f64; LOADS]; 2]) -> f64 {
    // Four standard deviations of the sample's own and of its dimensions.
    let is_far = (0..LOADS).any(|load| {
        let most = 4.0 * (SAMPLE_STD + DIMENSIONS_STD * log[load].abs());
        log[load] < wanted[0][load] - most || log[load] > wanted[1][load] + most
    });
    if is_far { 0.0 } else { within(log, wanted, (0.0, 1.0), &|_| (0.0, SAMPLE_STD)) }
}

/// Grid of targets for [`share_reached`]: number of falls with pressure, and of ratios at the middle pressures.
const FALLS: usize = 8;
const MIDDLES: usize = 128;

/// Fraction of all targets that at least one of `truths` reaches; at least one target of the grid.
pub fn share_reached(truths: impl Iterator<Item = [f64; LOADS]>) -> f64 {
    let (step, distance) = (MIDDLE[1] / MIDDLES as f64, REACHED * TOLERANCE);
    let falls: [[f64; LOADS]; FALLS] = std::array::from_fn(|place| {
        std::array::from_fn(|load| at_fall(FALL * (place as f64 + 0.5) / FALLS as f64, load))
    });
    // Bits of the middles that are reached, for each fall.
    let mut reached = [0_u128; FALLS];
    let is_asked = |ratio: f64| (MIDDLE[0]..=MIDDLE[0] + MIDDLE[1]).contains(&ratio);
    for truth in truths {
        if !is_asked(truth[0] - FALL) && !is_asked(truth[0] + FALL) {
            continue;
        }
        for (fall, bits) in falls.iter().zip(&mut reached) {
            let middles: [f64; LOADS] = std::array::from_fn(|load| truth[load] - fall[load]);
            let least = middles.iter().copied().fold(f64::NEG_INFINITY, f64::max) - distance;
            let most = middles.iter().copied().fold(f64::INFINITY, f64::min) + distance;
            // How many middles, from + (place + 0.5) step, lie below a ratio; none lies in an interval that is empty.
            let below = |ratio: f64| ((ratio - MIDDLE[0]) / step + 0.5).clamp(0.0, MIDDLES as f64) as u32;
            let (first, end) = (below(least), below(most));
            if first < end {
                let bits_below = |end: u32| u128::MAX.checked_shr(MIDDLES as u32 - end).unwrap_or(0);
                *bits |= bits_below(end) & !bits_below(first);
            }
        }
    }
    let middle = |place: &usize| MIDDLE[0] + (*place as f64 + 0.5) * step;
    let asked: u128 =
        (0..MIDDLES).filter(|place| (middle(place) - 1.0).abs() >= NEAR_FLAT).map(|place| 1 << place).sum();
    let count: u32 = reached.iter().map(|bits| (bits & asked).count_ones()).sum();
    f64::from(count.max(1)) / f64::from(asked.count_ones() * FALLS as u32)
}
