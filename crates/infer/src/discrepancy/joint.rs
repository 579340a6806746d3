//! Joint prediction of several samples cut on one disc, and what measuring them teaches about the mechanism.
//!
//! Samples of one disc share the coefficients, the modulus, the local law, the scatter t and the errors of the material.
//! Errors of dimensions are independent between samples.

use crate::discrepancy::mixture::Member;
use crate::discrepancy::prediction::MIN_WEIGHT;
use crate::discrepancy::residual::Place;
use crate::discrepancy::{Candidate, Component, Discrepancy, Form, Load, Prediction, information};
use slipgrid_base::statistics::cholesky::{covariance_factor, dot};

/// Sample at one load: the parts of its prediction that are common to all members.
struct At {
    sample: usize,
    load: usize,
    place: Place,
    /// Basis functions of the residual.
    residual: Vec<f64>,
    /// Row of the factor of the covariance that all samples share.
    shared: Vec<f64>,
}

/// Sample at one load by one member.
struct OfMember {
    /// h, times its mean over errors of the dimensions for the mean.
    form: f64,
    mean_of_form: f64,
    mean_of_globals: f64,
    /// L^-1 of the row of the form and the residual, and of that of eps and lambda.
    by_form: Vec<f64>,
    by_globals: Vec<f64>,
    /// Changes by one standard deviation of each error of the dimensions.
    moved: Vec<f64>,
    /// E (1 + d ln h)^2
    times: f64,
}

impl Discrepancy {
    /// Predicts ln(true ratio / modelled ratio) of `samples` of one disc: first at all `loads` of the first sample, then of
    /// the next. Marginals equal those of [`Predictor::of`](crate::discrepancy::Predictor::of).
    #[must_use]
    pub fn on_one_disc(&self, samples: &[Candidate<'_>], loads: &[Load]) -> Prediction {
        let (basis, n) = (self.basis(), loads.len());
        let mut rows: Vec<At> = Vec::new();
        for (sample, of) in samples.iter().enumerate() {
            let factor = if of.covariance.is_empty() { vec![0.0; n * n] } else { covariance_factor(of.covariance, n) };
            for (load, at) in loads.iter().enumerate() {
                let place = basis.place(&of.features, at);
                let (residual, shared) = (basis.residual(&place), factor[load * n..][..n].to_vec());
                rows.push(At { sample, load, place, residual, shared });
            }
        }
        let size = rows.len();
        // Covariance of eta, of the residual and of shared errors that the coefficients do not explain.
        let left = |of: &dyn Fn(&At, &At) -> f64| -> Vec<f64> {
            (0..size * size).map(|entry| of(&rows[entry / size], &rows[entry % size])).collect()
        };
        let of_humidity = left(&|a, b| basis.humidity_left(&loads[a.load], &loads[b.load]));
        let of_residual = left(&|a, b| basis.residual_left([&a.place, &b.place], [&a.residual, &b.residual]));
        let of_all = left(&|a, b| dot(&a.shared, &b.shared));
        let at_loads: Vec<Vec<f64>> = loads.iter().map(|load| basis.at_load(load)).collect();
        let (p, globals, stds) = (basis.count(), basis.globals(), basis.global_stds());
        let component = |member: &Member| {
            let global_means = basis.global_means(&member.mean);
            let whitened =
                |row: &[f64]| -> Vec<f64> { (0..p).map(|r| dot(&member.inverse[r * p..][..=r], &row[..=r])).collect() };
            let one = |at: &At| {
                let of = &samples[at.sample];
                let form = member.value(&of.features);
                let mut row: Vec<f64> = at_loads[at.load].iter().map(|entry| form * entry).collect();
                row.extend([0.0; 2]);
                row.extend(at.residual.iter().map(|entry| form * member.residual * entry));
                let (own, mut of_globals) = (of.sensitivity[at.load].globals(), vec![0.0; p]);
                globals.iter().enumerate().for_each(|(global, place)| of_globals[*place] = stds[global] * own[global]);
                let shifts = of.dimension_shifts.iter();
                let mean: f64 = shifts.clone().map(|shift| shift.mean_form(&member.form, &of.features)).product();
                let mean_of_form = mean * dot(&row, &member.mean);
                let logs: Vec<f64> = shifts.clone().map(|shift| shift.log_form(&member.form, &of.features)).collect();
                OfMember {
                    form,
                    mean_of_form,
                    mean_of_globals: dot(&own, &global_means),
                    by_form: whitened(&row),
                    by_globals: whitened(&of_globals),
                    times: 1.0 + dot(&logs, &logs),
                    moved: shifts.zip(&logs).map(|(by, log)| by.log_ratio[at.load] + mean_of_form * log).collect(),
                }
            };
            let each: Vec<OfMember> = rows.iter().map(one).collect();
            let entry = |entry: usize| {
                let (row, column) = (entry / size, entry % size);
                let ([a, b], is_one) = ([&each[row], &each[column]], rows[row].sample == rows[column].sample);
                let of_form = dot(&a.by_form, &b.by_form)
                    + a.form * b.form * (of_humidity[entry] + member.residual.powi(2) * of_residual[entry]);
                let of_globals =
                    dot(&a.by_globals, &b.by_globals) + dot(&a.by_form, &b.by_globals) + dot(&a.by_globals, &b.by_form);
                let (times, moved) = if is_one { (a.times, dot(&a.moved, &b.moved)) } else { (1.0, 0.0) };
                times * of_form + of_globals + moved + member.scatter.powi(2) + of_all[entry]
            };
            Component {
                form: member.form,
                weight: member.weight,
                mean: each.iter().map(|at| at.mean_of_form + at.mean_of_globals).collect(),
                covariance: (0..size * size).map(entry).collect(),
            }
        };
        let members = self.members().iter().filter(|member| member.weight > MIN_WEIGHT);
        Prediction { components: members.map(component).collect() }
    }
}

impl Prediction {
    /// Families of forms with their weights, in the order of the forms.
    #[must_use]
    pub fn families(&self) -> Vec<(&'static str, f64)> {
        let mut all: Vec<(&'static str, f64)> = Vec::new();
        for of in &self.components {
            match all.iter_mut().find(|(family, _)| *family == of.form.family()) {
                Some((_, weight)) => *weight += of.weight,
                None => all.push((of.form.family(), of.weight)),
            }
        }
        all
    }

    /// Prediction if the forms of `family` hold.
    #[must_use]
    pub fn if_family(&self, family: &str) -> Self {
        let mut components = self.components.clone();
        components.retain(|of| of.form.family() == family);
        let sum: f64 = components.iter().map(|of| of.weight).sum();
        components.iter_mut().for_each(|of| of.weight /= sum);
        Self { components }
    }

    /// Value number `to` minus value number `from`, as the one value of a prediction.
    #[must_use]
    pub fn difference(&self, from: usize, to: usize) -> Self {
        let n = self.loads();
        let of = |of: &Component| {
            let at = |row: usize, column: usize| of.covariance[row * n + column];
            let covariance = vec![at(from, from) + at(to, to) - 2.0 * at(from, to)];
            Component { mean: vec![of.mean[to] - of.mean[from]], covariance, ..of.clone() }
        };
        Self { components: self.components.iter().map(of).collect() }
    }

    /// Information about the family of the form from measuring all values with the relative standard error `measured_std`,
    /// in bits; see [`information`].
    #[must_use]
    pub fn family_bits(&self, measured_std: f64) -> f64 {
        information(self, measured_std, Form::family) / std::f64::consts::LN_2
    }
}
