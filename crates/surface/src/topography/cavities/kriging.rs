//! Least squares for profiles with rough noise: the difference of two heights of a profile grows with their distance.

use slipgrid_base::statistics::cholesky::{cholesky, dot, is_regular, solve_lower, solve_upper};

/// Minimum nugget relative to the maximum semivariance, which keeps the equations well conditioned.
const MIN_NUGGET: f64 = 1e-3;
/// Variance of the profiles' common level over the maximum semivariance: large, since every fit has its own level.
const LEVEL: f64 = 10.0;

/// Semivariance of a rough profile at a lag of m bins: nugget + scale m^(2 H), for m > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variogram {
    pub(super) nugget: f64,
    pub(super) scale: f64,
    pub(super) twice_hurst: f64,
}

impl Variogram {
    /// Fits the semivariances at lags 1, 2, ... with equal relative weights; white noise if there are none.
    pub(super) fn fit(semivariance: &[f64]) -> Self {
        const WHITE: Variogram = Variogram { nugget: 1.0, scale: 0.0, twice_hurst: 1.0 };
        let known = || semivariance.iter().enumerate().filter(|(_, value)| **value > 0.0);
        if known().count() == 0 {
            return WHITE;
        }
        let mut best = (f64::INFINITY, WHITE);
        for step in 1..20 {
            // 2 H from 0.1 to 1.9
            let twice_hurst = 0.1 * f64::from(step);
            // Least squares of (nugget + scale p)/value = 1 over p = m^(2 H), with neither below zero.
            let mut sums = [0.0; 5];
            for (index, value) in known() {
                let (one, power) = (1.0 / value, libm::pow(index as f64 + 1.0, twice_hurst) / value);
                for (sum, term) in sums.iter_mut().zip([one * one, one * power, power * power, one, power]) {
                    *sum += term;
                }
            }
            let [oo, op, pp, o, p] = sums;
            let determinant = oo * pp - op * op;
            let both = [(o * pp - p * op) / determinant, (p * oo - o * op) / determinant];
            for [nugget, scale] in [both, [o / oo, 0.0], [0.0, p / pp]] {
                let misfit: f64 = known()
                    .map(|(index, value)| {
                        let found = nugget + scale * libm::pow(index as f64 + 1.0, twice_hurst);
                        (found / value - 1.0).powi(2)
                    })
                    .sum();
                if nugget >= 0.0 && scale >= 0.0 && misfit < best.0 {
                    best = (misfit, Self { nugget, scale, twice_hurst });
                }
            }
        }
        best.1
    }

    fn at(&self, lag: usize) -> f64 {
        self.nugget + self.scale * libm::pow(lag as f64, self.twice_hurst)
    }
}

/// Generalized least squares of level + slope x + h f, with the height h of a shape f, for profiles over bins with the
/// noise of a variogram (universal kriging). Waves longer than a profile give it a slope, which is the same for all
/// cavities of a pattern whose pitch matches the waves; therefore the slope is fitted with the level.
pub(super) struct Kriging {
    /// Lower Cholesky factor of the covariance, row by row.
    factor: Vec<f64>,
    /// Constant 1, whitened.
    ones: Vec<f64>,
    /// Constant and slope, whitened and orthonormalized.
    drift: Vec<Vec<f64>>,
    /// Length of the whitened rise of 1 from the first bin to the last, orthogonal to the constant.
    rise: f64,
}

/// A shape f, whitened and orthogonal to constant and slope.
pub(super) struct Shape {
    whitened: Vec<f64>,
    square: f64,
}

impl Shape {
    /// Whether the height of the shape can be separated from level and slope.
    pub(super) fn is_determined(&self) -> bool {
        self.square > 0.0
    }
}

impl Kriging {
    /// Factors the covariance of profiles with heights in `bins`, increasing; `extra` is added to the nugget. `None` if the
    /// equations are degenerate.
    pub(super) fn new(variogram: Variogram, bins: &[usize], extra: f64) -> Option<Self> {
        let span = bins.last()? - bins.first()?;
        let greatest = variogram.at(span.max(1)) + extra;
        let nugget = (variogram.nugget + extra).max(MIN_NUGGET * greatest) - variogram.nugget;
        let sill = LEVEL * (greatest + nugget);
        let covariance = |lag: usize| if lag == 0 { sill } else { sill - variogram.at(lag) - nugget };
        let by_lag: Vec<f64> = (0..=span).map(covariance).collect();
        let covariances: Vec<f64> =
            bins.iter().flat_map(|one| bins.iter().map(|other| by_lag[one.abs_diff(*other)])).collect();
        let factor = cholesky(&covariances, bins.len()).filter(|factor| is_regular(factor, bins.len()))?;
        let mut kriging = Self { factor, ones: Vec::new(), drift: Vec::new(), rise: 0.0 };
        kriging.ones = kriging.whiten(&vec![1.0; bins.len()]);
        for power in [0, 1] {
            let share = |bin: usize| (bin - bins[0]) as f64 / span.max(1) as f64;
            let values: Vec<f64> = bins.iter().map(|&bin| share(bin).powi(power)).collect();
            let mut whitened = kriging.whiten(&values);
            kriging.strip(&mut whitened);
            kriging.rise = dot(&whitened, &whitened).sqrt();
            kriging.drift.push(whitened.iter().map(|value| value / kriging.rise).collect());
        }
        Some(kriging)
    }

    /// Whitens a profile z: returns L^-1 z, with the Cholesky factor L of the covariance.
    pub(super) fn whiten(&self, profile: &[f64]) -> Vec<f64> {
        let mut whitened = profile.to_vec();
        solve_lower(&self.factor, profile.len(), &mut whitened);
        whitened
    }

    /// Removes constant and slope from a whitened profile.
    fn strip(&self, whitened: &mut [f64]) {
        for direction in &self.drift {
            let share = dot(whitened, direction);
            for (value, part) in whitened.iter_mut().zip(direction) {
                *value -= share * part;
            }
        }
    }

    pub(super) fn shape(&self, values: &[f64]) -> Shape {
        let mut whitened = self.whiten(values);
        let whole = dot(&whitened, &whitened);
        self.strip(&mut whitened);
        let square = dot(&whitened, &whitened);
        Shape { square: if square > 1e-9 * whole { square } else { 0.0 }, whitened }
    }

    /// The slope, on any level; its height is the rise from the first bin to the last.
    pub(super) fn slope(&self) -> Shape {
        let whitened: Vec<f64> = self.drift[1].iter().map(|value| value * self.rise).collect();
        Shape { whitened, square: self.rise * self.rise }
    }

    /// Returns the height h of `shape` in the whitened profile `ready`, and the decrease of the sum of squares by it.
    pub(super) fn height(&self, shape: &Shape, ready: &[f64]) -> (f64, f64) {
        let product = dot(&shape.whitened, ready);
        (product / shape.square, product * product / shape.square)
    }

    /// Root mean square deviation of the whitened profile `ready`, a mean of `count` profiles, from level, slope and
    /// `shape`, in standard errors.
    pub(super) fn misfit(&self, shape: &Shape, ready: &[f64], count: usize) -> f64 {
        let mut rest = ready.to_vec();
        self.strip(&mut rest);
        let (_, gain) = self.height(shape, ready);
        // Level, slope, height and width are fitted.
        let freedom = ready.len().saturating_sub(4).max(1) as f64;
        (count as f64 * (dot(&rest, &rest) - gain).max(0.0) / freedom).sqrt()
    }

    /// Weights a with which a profile z has the height h = sum of a z.
    pub(super) fn weights(&self, shape: &Shape) -> Vec<f64> {
        // L^T a = f/(f f)
        let mut weights: Vec<f64> = shape.whitened.iter().map(|value| value / shape.square).collect();
        solve_upper(&self.factor, weights.len(), &mut weights);
        weights
    }

    /// Level of `profile`, its generalized least-squares mean.
    pub(super) fn level(&self, profile: &[f64]) -> f64 {
        dot(&self.whiten(profile), &self.ones) / dot(&self.ones, &self.ones)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variogram_is_found_again() {
        for (nugget, scale, twice_hurst) in [(0.5, 0.2, 1.6), (0.0, 3.0, 0.4), (2.0, 1e-3, 1.9)] {
            let given = Variogram { nugget, scale, twice_hurst };
            let found = Variogram::fit(&(1..30).map(|lag| given.at(lag)).collect::<Vec<f64>>());
            for lag in [1, 7, 29] {
                assert!((found.at(lag) / given.at(lag) - 1.0).abs() < 1e-6, "{found:?} {given:?}");
            }
        }
        assert!(Variogram::fit(&[0.0; 9]).nugget > 0.0 && Variogram::fit(&[]).nugget > 0.0);
    }

    #[test]
    fn the_height_of_a_step_on_any_level_and_slope_is_exact_and_that_of_its_weights() {
        let bins: Vec<usize> = (0..40).filter(|bin| bin % 7 != 3).collect();
        let step: Vec<f64> = bins.iter().map(|&bin| if bin < 9 { 1.0 } else { 0.0 }).collect();
        for twice_hurst in [0.2, 1.0, 1.9] {
            let kriging = Kriging::new(Variogram { nugget: 0.1, scale: 0.3, twice_hurst }, &bins, 0.01).unwrap();
            let profile: Vec<f64> = step.iter().map(|step| 5.0 + 0.7 * step).collect();
            let shape = kriging.shape(&step);
            let (height, _) = kriging.height(&shape, &kriging.whiten(&profile));
            assert!((height - 0.7).abs() < 1e-9, "{height}");
            let weights = kriging.weights(&shape);
            assert!((dot(&weights, &profile) - 0.7).abs() < 1e-9 && weights.iter().sum::<f64>().abs() < 1e-9);
            let slope: Vec<f64> = bins.iter().map(|&bin| bin as f64).collect();
            assert!(dot(&weights, &slope).abs() < 1e-7 && !kriging.shape(&slope).is_determined());
            let rising: Vec<f64> = slope.iter().map(|bin| 5.0 + 0.7 * bin / slope.last().unwrap()).collect();
            let (rise, _) = kriging.height(&kriging.slope(), &kriging.whiten(&rising));
            assert!((rise - 0.7).abs() < 1e-7, "{rise}");
            assert!(!kriging.shape(&vec![1.0; bins.len()]).is_determined());
            let level: Vec<f64> = profile.iter().zip(&step).map(|(height, step)| height - 0.7 * step).collect();
            assert!((kriging.level(&level) - 5.0).abs() < 1e-9);
        }
    }
}
