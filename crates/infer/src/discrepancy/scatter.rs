//! Scatter of samples of one texture: its posterior given the trials, and contradictions to the stated scatter.

use crate::discrepancy::mixture::is_same;
use crate::discrepancy::{Discrepancy, Features, Form, Load, Measured, Trial};
use slipgrid_base::statistics::chi_square_beyond;
use slipgrid_base::statistics::cholesky::{cholesky, dot, is_regular, solve_lower};

/// Maximum standard deviation of ln(ratio) between samples of one texture, unless a larger one is stated.
const MAX_SCATTER: f64 = 0.2;
/// Two measured lengths count as equal below this relative difference, the resolution of a microscope.
const MICROSCOPE_RESOLUTION: f64 = 0.02;
/// Number of standard errors of a difference within which two lengths may be equal.
const WITHIN_ERRORS: f64 = 2.0;
/// Two samples contradict each other if the probability of their difference, times the number of compared pairs, is
/// below this.
const MIN_PROBABILITY: f64 = 0.01;

/// Possible scatter of samples with its prior and posterior weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterWeight {
    /// Standard deviation of the log ratio over samples of one texture.
    pub std: f64,
    /// Prior weight.
    pub prior: f64,
    /// Posterior weight.
    pub weight: f64,
}

/// Two samples of one texture, within the errors of their dimensions, whose ratios differ by more than the stated
/// scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    /// Indices of the trials, from 0.
    pub trials: [usize; 2],
    /// Condition of the largest difference.
    pub load: Load,
    /// Difference of the log ratios, measured over modelled, of the first and the second sample at this condition.
    pub difference: f64,
    /// Standard deviation of the log ratio over samples of one texture, as stated with each of the two trials, or the
    /// default.
    pub sample_std: [f64; 2],
    /// Whether each of the two trials states its standard deviation, which is then kept.
    pub is_own: [bool; 2],
    /// Probability of such differences d of the log ratios with their stated covariance C, by two tests: of all
    /// conditions by d^T C^-1 d, and of the shift common to them, which further conditions do not dilute.
    pub probability: f64,
}

impl Discrepancy {
    /// Possible standard deviations of the log ratio over samples of one texture, with prior weights. The stated one is
    /// first; it is the only one if it is zero or stated for every trial.
    pub(crate) fn scatters(&self) -> Vec<(f64, f64)> {
        let hyper = self.hyperparameters();
        let stated = hyper.sample_std;
        let trials = self.trials();
        let is_known = !trials.is_empty() && trials.iter().all(|trial| trial.sample_std.is_some());
        if stated == 0.0 || is_known {
            return vec![(stated, 1.0)];
        }
        let all = hyper.scatters.iter().map(|(times, weight)| (times * stated, *weight));
        let all: Vec<(f64, f64)> =
            all.filter(|(std, weight)| *weight > 0.0 && *std <= stated.max(MAX_SCATTER)).collect();
        let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
        all.into_iter().map(|(std, weight)| (std, weight / sum)).collect()
    }

    /// Posterior of the scatter of samples without a stated scatter.
    pub fn scatter_weights(&self) -> Vec<ScatterWeight> {
        let of = |(std, prior): (f64, f64)| {
            let own = self.members().iter().filter(|member| member.scatter.to_bits() == std.to_bits());
            ScatterWeight { std, prior, weight: own.map(|member| member.weight).sum() }
        };
        self.scatters().into_iter().map(of).collect()
    }

    /// Predictive standard deviation of the next sample of a texture: root mean square over all scatters.
    pub fn sample_std(&self) -> f64 {
        self.scatter_weights().iter().map(|of| of.weight * of.std * of.std).sum::<f64>().sqrt()
    }

    /// Pairs of samples of one texture that differ by more than the stated scatter, the least probable first.
    pub fn contradictions(&self) -> Vec<Contradiction> {
        let count = self.trials().len();
        let pairs = (0..count).flat_map(|second| (0..second).map(move |first| [first, second]));
        // Errors of the dimensions also change the discrepancy: `compared` bounds this change separately.
        let noise = self.noise(self.hyperparameters().sample_std, &|_, _| 0.0);
        let compared: Vec<Contradiction> = pairs.filter_map(|pair| self.compared(pair, &noise)).collect();
        let least = MIN_PROBABILITY / compared.len().max(1) as f64;
        let mut found: Vec<Contradiction> = compared.into_iter().filter(|pair| pair.probability < least).collect();
        found.sort_by(|a, b| {
            a.probability.total_cmp(&b.probability).then(b.difference.abs().total_cmp(&a.difference.abs()))
        });
        found
    }

    /// Compares two samples for measurements with the covariance `noise`; `None` if they differ in texture, share a disc,
    /// or have no common condition.
    fn compared(&self, trials: [usize; 2], noise: &[f64]) -> Option<Contradiction> {
        let [first, second] = trials.map(|place| &self.trials()[place]);
        let features = [&first.features, &second.features];
        if self.is_one_disc(trials[0], trials[1]) || !is_one_texture(features, [errors_m(first), errors_m(second)]) {
            return None;
        }
        let all = &self.rows().collect::<Vec<(usize, &Measured)>>()[..];
        let of = |trial: usize| (0..all.len()).filter(move |row| all[*row].0 == trial);
        let partner = |row: usize| of(trials[1]).find(|other| is_same(&all[*other].1.load, &all[row].1.load));
        let rows: Vec<[usize; 2]> = of(trials[0]).filter_map(|row| Some([row, partner(row)?])).collect();
        let n = rows.len();
        if n == 0 {
            return None;
        }
        let excess = |row: usize| all[row].1.log_excess();
        let difference: Vec<f64> = rows.iter().map(|[a, b]| excess(*a) - excess(*b)).collect();
        // ln h(x1) - ln h(x2), maximum over the forms: the effect of the difference in texture.
        let change = |form: &Form| libm::log(form.on_face(&first.features) / form.on_face(&second.features)).abs();
        let of_forms = self.hyperparameters().forms.iter().map(|(form, _)| change(form));
        let of_forms = of_forms.filter(|change| change.is_finite()).fold(0.0, f64::max);
        // The corresponding effect of errors of the dimensions: forms grow at most with the square of a width or spacing,
        // or linearly with depth.
        let of_errors: f64 = [first, second].into_iter().map(of_errors).sum();
        let apart = (of_forms * of_forms + of_errors).sqrt();
        let of_form: Vec<f64> = rows.iter().map(|[a, b]| 0.5 * (excess(*a) + excess(*b)) * apart).collect();
        // cov(y_a - y_b, y_c - y_d): the flat sample's error, shared by both, cancels.
        let at = |row: usize, other: usize| noise[row * all.len() + other];
        let entry = |entry: usize| {
            let ([a, b], [c, d]) = (rows[entry / n], rows[entry % n]);
            at(a, c) + at(b, d) - at(a, d) - at(b, c) + of_form[entry / n] * of_form[entry % n]
        };
        let covariance: Vec<f64> = (0..n * n).map(entry).collect();
        let factor = cholesky(&covariance, n).filter(|factor| is_regular(factor, n))?;
        let (mut whitened, mut ones) = (difference.clone(), vec![1.0; n]);
        solve_lower(&factor, n, &mut whitened);
        solve_lower(&factor, n, &mut ones);
        // (1^T C^-1 d)^2 / (1^T C^-1 1)
        let of_shift = chi_square_beyond(dot(&ones, &whitened).powi(2) / dot(&ones, &ones), 1);
        let of_all = chi_square_beyond(dot(&whitened, &whitened), n);
        // Of two tests either may fail by chance.
        let probability = if n == 1 { of_all } else { (2.0 * of_shift.min(of_all)).min(1.0) };
        let most = (0..n).max_by(|a, b| difference[*a].abs().total_cmp(&difference[*b].abs()))?;
        Some(Contradiction {
            trials,
            load: all[rows[most][0]].1.load,
            difference: difference[most],
            sample_std: trials.map(|trial| self.own_std(trial, self.hyperparameters().sample_std)),
            is_own: [first, second].map(|trial| trial.sample_std.is_some()),
            probability,
        })
    }
}

/// Standard errors of width, pitch and depth, in metres.
fn errors_m(of: &Trial) -> [f64; 3] {
    let [width, spacing, depth] = of.dimensions_std_m;
    [width, width.hypot(spacing), depth]
}

/// Upper bound of the squared relative standard error of any form due to errors of a sample's dimensions.
fn of_errors(of: &Trial) -> f64 {
    let lengths_m = [of.features.width_m, of.features.pitch_m, of.features.depth_m];
    let squares = errors_m(of).into_iter().zip(lengths_m).zip([2.0, 2.0, 1.0]);
    squares.map(|((error, length), power): ((f64, f64), f64)| (power * error / length).powi(2)).sum()
}

impl Trial {
    /// Whether `of` is the texture of the sample, within the errors of its dimensions or a fiftieth.
    pub fn has_texture(&self, of: &Features) -> bool {
        is_one_texture([&self.features, of], [errors_m(self), [0.0; 3]])
    }
}

/// Whether two textures with standard errors of their lengths are equal: all lengths within their errors or within a
/// fiftieth, and areal density and edge length accordingly.
fn is_one_texture(textures: [&Features; 2], errors_m: [[f64; 3]; 2]) -> bool {
    let [a, b] = textures.map(|of| [of.width_m, of.pitch_m, of.depth_m]);
    let [error_a, error_b] = errors_m;
    let allowed: [f64; 3] = std::array::from_fn(|axis| {
        (WITHIN_ERRORS * error_a[axis].hypot(error_b[axis]) / a[axis].min(b[axis])).max(MICROSCOPE_RESOLUTION)
    });
    // Areal density and edge length change with at most two powers of a length.
    let powers = 2.0 * (allowed[0] + allowed[1]);
    let apart = |of: fn(&Features) -> f64| libm::log(of(textures[0]) / of(textures[1])).abs();
    (0..3).all(|axis| (a[axis] - b[axis]).abs() / a[axis].min(b[axis]) <= allowed[axis])
        && apart(|of| of.areal_density) <= powers
        && apart(|of| of.edge_1_m) <= powers
}
