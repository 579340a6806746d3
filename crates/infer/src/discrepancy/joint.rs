//! Information about the mechanism, which is the family of the form, from measuring several values at once.

use crate::discrepancy::{Component, Distribution, Form, information};

impl Distribution {
    /// Families of forms with their weights in this prediction, in the order of the forms.
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

    /// Prediction under the condition that a form of `family` holds.
    pub fn if_family(&self, family: &str) -> Self {
        let mut components = self.components.clone();
        components.retain(|of| of.form.family() == family);
        let sum: f64 = components.iter().map(|of| of.weight).sum();
        components.iter_mut().for_each(|of| of.weight /= sum);
        Self { components }
    }

    /// Prediction of a single number: the value with index `to` minus the value with index `from`.
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
    pub fn family_bits(&self, measured_std: f64) -> f64 {
        information(self, measured_std, Form::family) / std::f64::consts::LN_2
    }
}
