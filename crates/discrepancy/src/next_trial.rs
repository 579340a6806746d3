//! The texture to cut next.

use std::collections::BTreeSet;

use rayon::prelude::*;
use slipgrid_statistics::{Normals, part_box_probability, rough_part_box_probability};

use crate::{DimensionShift, Features, Form, Prediction, Predictor};
use slipgrid_statistics::cholesky::{cholesky, covariance_factor, dot, is_regular, log_determinant, solve_lower};

/// What counts beside the chance: a texture that misses by little teaches more of the target than one that misses by far.
const OF_CLOSENESS: f64 = 0.05;
/// Draws of each form behind the closeness of a texture and behind [`information`].
const DRAWS: usize = 16;
/// Forms of less weight change no choice.
const MIN_WEIGHT: f64 = 1e-4;
/// A form that can add no more than this to a chance is not asked.
const MIN_CHANCE: f64 = 1e-5;
/// By how much the draws behind a closeness may lie above its expectation.
const SCATTER_OF_CLOSENESS: f64 = 1.25;
/// Textures whose scores are computed at a time, so that the choice does not depend on the number of threads: at first at least so many, and
/// of every further batch twice as many, up to the most. What is found early spares what comes later.
const MIN_BATCH: usize = 4;
const MAX_BATCH: usize = 64;

/// What a cut sample should do: its ratio at each load.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Least ratio that is accepted; 0 where there is no least.
    pub lower: Vec<f64>,
    /// Largest ratio that is accepted; infinite where there is none.
    pub upper: Vec<f64>,
}

/// How much there is for cutting a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Chance that a cut sample is on target at all loads at once.
    pub chance: f64,
    /// E exp(-m^2 / 4), m the largest distance from the middle of what is accepted, in half its width.
    pub closeness: f64,
}

/// A texture that could be cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<'a> {
    /// What the discrepancy depends on.
    pub features: Features,
    /// Modelled ratio at each load.
    pub modelled: &'a [f64],
    /// g = d ln R / d ln E at each load.
    pub modulus_sensitivity: &'a [f64],
    /// Covariance of the logarithms of the ratios that all samples share beside the discrepancy, loads x loads; empty where that is nothing.
    pub covariance: &'a [f64],
    /// Independent errors of the dimensions of each sample; empty where these are exact.
    pub dimension_shifts: &'a [DimensionShift],
}

/// Candidates that come first by rough chances, of which the exact ones decide.
const FINALISTS: usize = 8;

/// The texture to cut next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// Its place among the candidates.
    pub place: usize,
    /// How much there is for it.
    pub score: Score,
}

impl Score {
    /// What textures are ranked by.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.chance + OF_CLOSENESS * self.closeness
    }
}

impl Wanted {
    /// What is accepted of the logarithm of the true over the `modelled` ratio.
    #[must_use]
    pub fn over(&self, modelled: &[f64]) -> [Vec<f64>; 2] {
        let log = |ends: &[f64]| ends.iter().zip(modelled).map(|(end, ratio)| libm::log(end / ratio)).collect();
        [log(&self.lower), log(&self.upper)]
    }

    /// How much there is for a texture of which `prediction` is known, and whose ratios are `modelled`.
    #[must_use]
    pub fn score(&self, prediction: &Prediction, modelled: &[f64]) -> Score {
        let bounds = self.over(modelled);
        let chance = chance(prediction, &bounds, 0.0, part_box_probability).unwrap_or(0.0);
        Score { chance, closeness: closeness(prediction, &bounds) }
    }

    /// The same with a rougher probability of the box, for many textures that are compared.
    #[must_use]
    pub fn rough_score(&self, prediction: &Prediction, modelled: &[f64]) -> Score {
        let bounds = self.over(modelled);
        let chance = chance(prediction, &bounds, 0.0, rough_part_box_probability).unwrap_or(0.0);
        Score { chance, closeness: closeness(prediction, &bounds) }
    }

    /// The same, roughly; `None` where the chance is below `least_chance`, or the score's value below `least_value`. `most_close` is no less than the
    /// closeness, which is dearer than most chances that are too small.
    fn score_above(
        &self,
        prediction: &Prediction,
        modelled: &[f64],
        [least_chance, least_value]: [f64; 2],
        most_close: f64,
    ) -> Option<Score> {
        let bounds = self.over(modelled);
        let least = least_chance.max(least_value - OF_CLOSENESS * most_close);
        let chance = chance(prediction, &bounds, least, rough_part_box_probability)?;
        let score = Score { chance, closeness: closeness(prediction, &bounds) };
        (score.value() >= least_value).then_some(score)
    }

    /// No less than the score of [`Wanted::score`]: by each load alone.
    fn most(&self, prediction: &Prediction, modelled: &[f64], least_chance: f64) -> Option<Score> {
        let [lower, upper] = self.over(modelled);
        let chance = prediction.most_probability_within(&lower, &upper);
        if chance < least_chance {
            return None;
        }
        let n = modelled.len();
        let close = |of: &crate::Component| {
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
        Some(Score { chance, closeness: SCATTER_OF_CLOSENESS * prediction.components.iter().map(close).sum::<f64>() })
    }
}

/// Probability of a box, as [`part_box_probability`] has it.
type Within = fn(&[f64], &[f64], &[f64], &[f64], f64) -> f64;

/// Chance that a sample lies within `bounds` at all loads at once; `None` where that is less than `least`, which the forms that can
/// add most tell before the others are asked.
fn chance(prediction: &Prediction, [lower, upper]: &[Vec<f64>; 2], least: f64, within: Within) -> Option<f64> {
    let n = lower.len();
    let forms = prediction.components.iter().enumerate().filter(|(_, of)| of.weight > MIN_WEIGHT);
    let mut most: Vec<(usize, f64)> =
        forms.map(|(place, of)| (place, of.weight * of.most_within(lower, upper))).collect();
    most.retain(|(_, most)| *most > MIN_CHANCE);
    most.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut left: f64 = most.iter().map(|(_, most)| most).sum();
    let mut found = vec![0.0; prediction.components.len()];
    let mut sum = 0.0;
    for (place, most) in most {
        if sum + left.max(0.0) < least {
            return None;
        }
        let of = &prediction.components[place];
        let factor = covariance_factor(&of.covariance, n);
        found[place] = of.weight * within(&of.mean, &factor, lower, upper, most);
        sum += found[place];
        left -= most;
    }
    // In the order of the forms, whichever came first.
    let chance: f64 = found.iter().sum();
    (chance >= least).then_some(chance)
}

/// E exp(-m^2 / 4), by draws and their opposites.
fn closeness(prediction: &Prediction, [lower, upper]: &[Vec<f64>; 2]) -> f64 {
    let n = lower.len();
    let mut normals = Normals::new(1);
    let deviates: Vec<f64> = (0..DRAWS * n).map(|_| normals.draw()).collect();
    let mut sum = 0.0;
    for of in prediction.components.iter().filter(|of| of.weight > MIN_WEIGHT) {
        let factor = covariance_factor(&of.covariance, n);
        let close = |z: &[f64], side: f64| {
            let misfit = |load: usize| {
                let known = of.mean[load] + side * dot(&factor[load * n..][..=load], z);
                let half = 0.5 * (upper[load] - lower[load]);
                if half.is_finite() { (known - lower[load] - half).abs() / half } else { 0.0 }
            };
            let most = (0..n).map(misfit).fold(0.0, f64::max);
            libm::exp(-0.25 * most * most)
        };
        let drawn: f64 = deviates.chunks(n.max(1)).map(|z| close(z, 1.0) + close(z, -1.0)).sum();
        sum += of.weight * drawn / (2 * DRAWS) as f64;
    }
    sum
}

/// The greatest score of `count` candidates that `of` gives; candidates of which it gives nothing are passed by. Of equal ones
/// the first.
pub fn choose<'a>(
    predictor: &Predictor,
    wanted: &Wanted,
    count: usize,
    of: &(dyn Fn(usize) -> Option<Candidate<'a>> + Sync),
) -> Option<Chosen> {
    let finalists = Ranking::new(predictor, wanted, 0.0, count, of).best(FINALISTS, 0.0, &|_| true).into_iter();
    let exact = finalists.filter_map(|Chosen { place, .. }| {
        let candidate = of(place)?;
        Some(Chosen { place, score: wanted.score(&predictor.of(&candidate), candidate.modelled) })
    });
    exact.reduce(|best, next| if next.score.value() > best.score.value() { next } else { best })
}

/// Candidates with what their scores are at most, so that few are scored.
pub struct Ranking<'r, 'a> {
    predictor: &'r Predictor,
    wanted: &'r Wanted,
    of: &'r (dyn Fn(usize) -> Option<Candidate<'a>> + Sync),
    /// Places and bounds of the scores, the greatest value first.
    bounds: Vec<(usize, Score)>,
}

impl<'r, 'a> Ranking<'r, 'a> {
    /// The `count` candidates that `of` gives, but those whose chance is below `least_chance` for certain.
    pub fn new(
        predictor: &'r Predictor,
        wanted: &'r Wanted,
        least_chance: f64,
        count: usize,
        of: &'r (dyn Fn(usize) -> Option<Candidate<'a>> + Sync),
    ) -> Self {
        let mut bounds: Vec<(usize, Score)> = (0..count)
            .into_par_iter()
            .filter_map(|place| {
                let candidate = of(place)?;
                Some((place, wanted.most(&predictor.of(&candidate), candidate.modelled, least_chance)?))
            })
            .collect();
        bounds.sort_by(|a, b| b.1.value().total_cmp(&a.1.value()).then(a.0.cmp(&b.0)));
        Self { predictor, wanted, of, bounds }
    }

    /// The `most` greatest scores of those candidates whose place `is_open` and whose chance is `least_chance` or more, the greatest first.
    /// Candidates of less are not asked again: later calls may ask for no lower chance.
    #[must_use]
    pub fn best(&mut self, most: usize, least_chance: f64, is_open: &dyn Fn(usize) -> bool) -> Vec<Chosen> {
        let Self { predictor, wanted, of, bounds } = self;
        let may_do = |(place, bound): &&(usize, Score)| bound.chance >= least_chance && is_open(*place);
        let open: Vec<(usize, Score)> = bounds.iter().filter(may_do).copied().collect();
        let mut best: Vec<Chosen> = Vec::new();
        let mut too_low = BTreeSet::new();
        let (mut left, mut size) = (&open[..], most.clamp(MIN_BATCH, MAX_BATCH));
        while let Some((_, first)) = left.first() {
            // What enters must not be below the least of those that are kept.
            let least_value = if best.len() < most { 0.0 } else { best.last().map_or(0.0, |last| last.score.value()) };
            if first.value() < least_value {
                break;
            }
            let batch;
            (batch, left) = left.split_at(size.min(left.len()));
            size = (2 * size).min(MAX_BATCH);
            let least = [least_chance, least_value];
            let score = |(place, bound): &(usize, Score)| {
                let candidate = of(*place)?;
                wanted.score_above(&predictor.of(&candidate), candidate.modelled, least, bound.closeness)
            };
            let asked = batch.par_iter().filter(|(_, bound)| bound.value() >= least_value);
            let scored: Vec<(usize, Option<Score>)> = asked.map(|bound| (bound.0, score(bound))).collect();
            for (place, score) in scored {
                match score {
                    Some(score) => best.push(Chosen { place, score }),
                    None if least_value == 0.0 => _ = too_low.insert(place),
                    None => {}
                }
            }
            best.sort_by(|a, b| b.score.value().total_cmp(&a.score.value()).then(a.place.cmp(&b.place)));
            best.truncate(most);
        }
        bounds.retain(|(place, _)| !too_low.contains(place));
        best
    }
}

impl Predictor {
    /// What is predicted of a sample of `candidate`.
    #[must_use]
    pub fn of(&self, candidate: &Candidate<'_>) -> Prediction {
        let Candidate { features, modulus_sensitivity, covariance, dimension_shifts, .. } = candidate;
        self.predict_made(features, modulus_sensitivity, dimension_shifts).with(covariance)
    }
}

/// What measuring a sample would say of the form, in nats: the expected fall of the entropy of the forms' weights, where each
/// load is measured with the relative standard error `measured_std`. Seeded draws: a tenth of it is their error.
#[must_use]
pub fn information(prediction: &Prediction, measured_std: f64) -> f64 {
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
        let of_form: f64 = members.iter().filter(|(of, ..)| of.form == own.form).map(|(of, ..)| of.weight).sum();
        for _ in 0..4 * DRAWS {
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
            // E ln p(y | form) / p(y): samples that scatter more than stated are of the same form.
            let ratio = sum(&|form| *form == own.form) / of_form / sum(&|_| true);
            gain += own.weight * libm::log(ratio) / (4 * DRAWS) as f64;
        }
    }
    gain.max(0.0)
}
