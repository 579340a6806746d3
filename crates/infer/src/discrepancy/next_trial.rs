//! Chance that a sample is on target, and ranking of textures to cut next.

use slipgrid_base::statistics::{BoxRule, Normals};

use crate::discrepancy::{Component, DimensionShift, Distribution, Features, Form, Sensitivity};
use slipgrid_base::statistics::cholesky::{cholesky, covariance_factor, dot, is_regular, log_determinant, solve_lower};

/// Weight of [`Score::closeness`] relative to the chance: a texture that misses by little teaches more about the target
/// than one that misses by far.
const OF_CLOSENESS: f64 = 0.05;
/// Approximate number of draws for [`information`], divided between the components by weight.
const DRAWS: f64 = 2000.0;
/// Weight below which a component of the mixture is ignored in closeness and information: it would not affect the choice
/// of the next trial.
const MIN_WEIGHT: f64 = 1e-4;
/// A component of the mixture is skipped if it can add at most this to a chance.
const MIN_CHANCE: f64 = 1e-6;
/// Number of integration points over all components for a reported chance: root mean square error of at most 0.0015
/// (`points_shared_by_all_components_leave_little_of_a_chance_open`), in 2.2 ms for 196 components.
const POINTS: usize = 12_288;
/// Number of integration points for a chance used in rankings: root mean square error of at most 0.01, in 0.2 ms.
const ROUGH_POINTS: usize = 512;

/// Target band of a cut sample: bounds of its friction ratio, patterned over flat, at each load.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Minimum accepted ratio; 0 if there is none.
    pub lower: Vec<f64>,
    /// Maximum accepted ratio; infinite if there is none.
    pub upper: Vec<f64>,
}

/// Score of a texture as the next one to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Chance that a cut sample is on target at all loads.
    pub chance: f64,
    /// Closeness to the target, from 0 to 1: expectation of exp(-m^2 / 4) at the load where it is smallest, with m the
    /// distance from the middle of the target band over half the width of the band; 1 for a limit on one side.
    pub closeness: f64,
}

/// Texture that could be cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<'a> {
    /// Features that the discrepancy depends on.
    pub features: Features,
    /// Modelled ratio at each load.
    pub modelled: &'a [f64],
    /// Sensitivity of the logarithm of the modelled ratio at each load to unknowns shared by all textures.
    pub sensitivity: &'a [Sensitivity],
    /// Covariance of the errors of the log ratios that all samples share, without the discrepancy: a matrix of loads x
    /// loads, row by row; empty if zero.
    pub covariance: &'a [f64],
    /// Independent errors of the dimensions of each sample; empty if exact.
    pub dimension_shifts: &'a [DimensionShift],
}

impl Score {
    /// Value by which textures are ranked: the chance plus a small multiple of the closeness.
    pub fn value(&self) -> f64 {
        self.chance + OF_CLOSENESS * self.closeness
    }
}

impl Wanted {
    /// Lower and upper bounds, one per load, of the logarithm of the true over the `modelled` ratio of a sample on
    /// target.
    pub fn over(&self, modelled: &[f64]) -> [Vec<f64>; 2] {
        let log = |ends: &[f64]| ends.iter().zip(modelled).map(|(end, ratio)| libm::log(end / ratio)).collect();
        [log(&self.lower), log(&self.upper)]
    }

    /// Scores a texture with the given `prediction` and `modelled` ratios.
    pub fn score(&self, prediction: &Distribution, modelled: &[f64]) -> Score {
        self.score_by(prediction, modelled, POINTS)
    }

    /// Like [`Self::score`], but less exact and faster, to compare many textures.
    pub fn rough_score(&self, prediction: &Distribution, modelled: &[f64]) -> Score {
        self.score_by(prediction, modelled, ROUGH_POINTS)
    }

    fn score_by(&self, prediction: &Distribution, modelled: &[f64], points: usize) -> Score {
        let bounds = self.over(modelled);
        Score { chance: chance(prediction, &bounds, points), closeness: closeness(prediction, &bounds) }
    }
}

/// Chance that a sample lies between `lower` and `upper` at all loads, from about `points` integration points, divided
/// between the components by their maximum contributions.
fn chance(prediction: &Distribution, [lower, upper]: &[Vec<f64>; 2], points: usize) -> f64 {
    let n = lower.len();
    let most: Vec<f64> = prediction.components.iter().map(|of| of.weight * of.most_within(lower, upper)).collect();
    let sum: f64 = most.iter().sum();
    let rule = BoxRule::new(n);
    let mut first = 0;
    let part = |(of, most): (&Component, f64)| {
        if most <= MIN_CHANCE {
            return 0.0;
        }
        // At most `points`, so the cast is exact.
        let last = first + ((points as f64 * most / sum).ceil() as usize).next_multiple_of(BoxRule::LANES);
        let factor = covariance_factor(&of.covariance, n);
        let within = rule.probability(&of.mean, &factor, [lower, upper], first..last);
        first = last;
        of.weight * within
    };
    prediction.components.iter().zip(most).map(part).sum()
}

/// Computes [`Score::closeness`].
fn closeness(prediction: &Distribution, [lower, upper]: &[Vec<f64>; 2]) -> f64 {
    let n = lower.len();
    let close = |of: &Component| {
        let at = |load: usize| {
            let half = 0.5 * (upper[load] - lower[load]);
            if !half.is_finite() {
                return 1.0;
            }
            // E exp(-x^2 / 4) = exp(-mu^2 / (4 + 2 s^2)) / sqrt(1 + s^2 / 2)
            let mean = (of.mean[load] - lower[load] - half) / half;
            let variance = of.covariance[load * n + load] / (half * half);
            libm::exp(-mean * mean / (4.0 + 2.0 * variance)) / (1.0 + 0.5 * variance).sqrt()
        };
        of.weight * (0..n).map(at).fold(1.0, f64::min)
    };
    prediction.components.iter().filter(|of| of.weight > MIN_WEIGHT).map(close).sum()
}

/// Information about the kind of form, which `kind` names, from measuring a sample, in nats: the expected decrease of the
/// entropy of the kinds' weights if each load is measured with the relative standard error `measured_std`. Seeded draws,
/// with an error of a tenth of the result.
pub fn information<K: PartialEq>(prediction: &Distribution, measured_std: f64, kind: impl Fn(&Form) -> K) -> f64 {
    let n = prediction.loads();
    let members: Vec<_> = prediction
        .components
        .iter()
        .filter(|of| of.weight > MIN_WEIGHT)
        .filter_map(|of| {
            let mut covariance = of.covariance.clone();
            (0..n).for_each(|load| covariance[load * n + load] += measured_std * measured_std);
            let factor = cholesky(&covariance, n).filter(|factor| is_regular(factor, n))?;
            let log_determinant = log_determinant(&factor, n);
            Some((of, factor, log_determinant))
        })
        .collect();
    let mut normals = Normals::new(1);
    let mut gain = 0.0;
    for (own, factor, _) in &members {
        let is_own = |form: &Form| kind(form) == kind(&own.form);
        let of_kind: f64 = members.iter().filter(|(of, ..)| is_own(&of.form)).map(|(of, ..)| of.weight).sum();
        // At most some thousands, so the cast is exact.
        let draws = (DRAWS * own.weight).ceil() as usize;
        for _ in 0..draws {
            let z: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
            let y: Vec<f64> = (0..n).map(|load| own.mean[load] + dot(&factor[load * n..][..=load], &z)).collect();
            let logs: Vec<f64> = members
                .iter()
                .map(|(of, factor, log_determinant)| {
                    let mut off: Vec<f64> = y.iter().zip(&of.mean).map(|(y, mean)| y - mean).collect();
                    solve_lower(factor, n, &mut off);
                    -0.5 * (dot(&off, &off) + log_determinant)
                })
                .collect();
            let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let sum = |is_in: &dyn Fn(&Form) -> bool| -> f64 {
                let within = members.iter().zip(&logs).filter(|((of, ..), _)| is_in(&of.form));
                within.map(|((of, ..), log)| of.weight * libm::exp(log - most)).sum()
            };
            // E ln p(y | kind) / p(y): members of different scatter belong to one kind.
            let ratio = sum(&is_own) / of_kind / sum(&|_| true);
            gain += own.weight * libm::log(ratio) / draws as f64;
        }
    }
    gain.max(0.0)
}
