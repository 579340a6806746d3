//! Coefficients of the mixture, each in units of its prior standard deviation, and their basis functions at a texture and
//! a load.

use crate::discrepancy::mixture::is_same;
use crate::discrepancy::residual::{KernelBasis, Place};
use crate::discrepancy::{Conditions, Features, Hyperparameters, Load, Sensitivity, Trial};
use slipgrid_base::statistics::cholesky::dot;

/// Number of coefficients before those of the humidities: alpha (amplitude), beta (pressure) and kappa (speed).
const OF_LOAD: usize = 3;
/// Number of coefficients of each humidity: eta (high pressures) and gamma (low pressures).
const OF_HUMIDITY: usize = 2;
/// Number of unknowns shared by all textures: eps, the error of ln(modulus), and lambda, the share of the local law.
pub const GLOBALS: usize = 2;
/// Prior mean of lambda, which is 0 or 1 with equal probability; lambda is treated as a continuous variable.
const LOCAL_LAW_MEAN: f64 = 0.5;
/// Prior standard deviation of lambda, the share of the local law.
const LOCAL_LAW_STD: f64 = 0.5;

impl Sensitivity {
    /// Factors of eps (modulus) and lambda (local law) in the discrepancy.
    pub(crate) const fn globals(&self) -> [f64; GLOBALS] {
        [self.modulus, self.local_law]
    }

    /// Prior mean of the logarithm of the true over the modelled ratio.
    pub(crate) const fn prior_mean(&self) -> f64 {
        LOCAL_LAW_MEAN * self.local_law
    }
}

/// Basis functions: first the errors of the flat sample at the loads of trials, then those of the load, then eta and
/// gamma at every measured humidity, eps, lambda, and the residual at the trials.
#[derive(Clone, Debug)]
pub struct Basis {
    pub hyper: Hyperparameters,
    pub conditions: Conditions,
    /// Prior relative standard deviation of Young's modulus.
    pub modulus_std: f64,
    /// Loads at which trials were measured: each has one error of the flat sample.
    pub flat: Vec<Load>,
    /// Expansion of eta, and of gamma, about the measured humidities.
    humidity_basis: KernelBasis,
    /// Expansion of the residual.
    pub residual_basis: KernelBasis,
}

impl Basis {
    /// Builds the basis for a posterior given `trials`.
    pub fn new(hyper: &Hyperparameters, conditions: Conditions, modulus_std: f64, trials: &[Trial]) -> Self {
        let measured = || trials.iter().flat_map(|trial| trial.measured.iter().map(move |at| (trial, at)));
        let mut flat: Vec<Load> = Vec::new();
        for (_, at) in measured().filter(|(_, at)| at.flat_std > 0.0) {
            if !flat.iter().any(|known| is_same(known, &at.load)) {
                flat.push(at.load);
            }
        }
        let places = measured().map(|(trial, at)| Place::new(hyper, &trial.features, &at.load)).collect();
        Self {
            humidity_basis: KernelBasis::new(
                measured().map(|(_, at)| Place::of_humidity(hyper, at.load.humidity)).collect(),
            ),
            residual_basis: KernelBasis::new(places),
            flat,
            hyper: hyper.clone(),
            conditions,
            modulus_std,
        }
    }

    /// Number of coefficients that a form multiplies, without the residual.
    pub fn of_form(&self) -> usize {
        OF_LOAD + OF_HUMIDITY * self.humidity_basis.places.len()
    }

    /// Number of all coefficients: errors of the flat sample, those of a form, eps and lambda, and those of the residual.
    pub fn count(&self) -> usize {
        self.flat.len() + self.of_form() + GLOBALS + self.residual_basis.places.len()
    }

    /// Indices of the coefficients eps (error of ln(modulus)) and lambda (share of the local law).
    pub fn globals(&self) -> [usize; GLOBALS] {
        std::array::from_fn(|global| self.flat.len() + self.of_form() + global)
    }

    /// Prior standard deviations of eps (error of ln(modulus)) and lambda (share of the local law).
    pub const fn global_stds(&self) -> [f64; GLOBALS] {
        [self.modulus_std, LOCAL_LAW_STD]
    }

    /// Means of eps (error of ln(modulus)) and lambda (share of the local law) for coefficients with the means `mean`.
    pub fn global_means(&self, mean: &[f64]) -> [f64; GLOBALS] {
        let [modulus, local_law] = self.globals();
        [self.modulus_std * mean[modulus], LOCAL_LAW_MEAN + LOCAL_LAW_STD * mean[local_law]]
    }

    /// Basis functions of the form's coefficients at `load`, for a form of value 1.
    pub fn at_load(&self, load: &Load) -> Vec<f64> {
        let (hyper, at) = (&self.hyper, &self.conditions);
        let u = (load.pressure_pa - at.reference_pressure_pa) / at.reference_pressure_pa;
        let s = libm::log(load.speed_m_s / at.reference_speed_m_s);
        let mut row = vec![hyper.amplitude_std, hyper.pressure_std * u, hyper.speed_std * s];
        let humidity = self.humidity(load.humidity);
        row.extend(self.of_humidity(load).iter().flat_map(|std| humidity.iter().map(move |part| std * part)));
        row
    }

    /// Standard deviations of eta and of gamma times q = P1 / P at `load`.
    fn of_humidity(&self, load: &Load) -> [f64; OF_HUMIDITY] {
        let q = self.conditions.lowest_pressure_pa / load.pressure_pa;
        [self.hyper.humidity_std, self.hyper.inverse_pressure_std * q]
    }

    /// Basis functions of eta and of gamma at a humidity.
    fn humidity(&self, humidity: f64) -> Vec<f64> {
        self.humidity_basis.whitened(&Place::of_humidity(&self.hyper, humidity))
    }

    /// Covariance of the humidity term eta + gamma q, q = P1 / P, at two loads that remains given the measured
    /// humidities.
    pub fn humidity_left(&self, a: &Load, b: &Load) -> f64 {
        let [at_a, at_b] = [a, b].map(|load| Place::of_humidity(&self.hyper, load.humidity));
        let [known_a, known_b] = [&at_a, &at_b].map(|at| self.humidity_basis.whitened(at));
        let left = at_a.correlation(&at_b) - dot(&known_a, &known_b);
        // At a measured humidity only rounding errors remain.
        if left.abs() < 1e-11 { 0.0 } else { dot(&self.of_humidity(a), &self.of_humidity(b)) * left }
    }

    /// Place of a texture and a load in the residual's coordinates.
    pub fn place(&self, of: &Features, load: &Load) -> Place {
        Place::new(&self.hyper, of, load)
    }

    /// Basis functions of the residual at `place`, times the amplitude.
    pub fn residual(&self, place: &Place) -> Vec<f64> {
        let mut row = self.residual_basis.whitened(place);
        row.iter_mut().for_each(|entry| *entry *= self.hyper.amplitude_std);
        row
    }

    /// Prior covariance of the residual at two places, less the part that [`Self::residual`] explains: negative where a
    /// trial lies between them.
    pub fn residual_left(&self, [a, b]: [&Place; 2], [row_a, row_b]: [&[f64]; 2]) -> f64 {
        let left = self.hyper.amplitude_std.powi(2) * a.correlation(b) - dot(row_a, row_b);
        // A variance that rounding makes negative.
        if a == b { left.max(0.0) } else { left }
    }

    /// Effects of the errors of the flat sample on a ratio measured at `load` with the relative error `std` of the flat
    /// sample.
    pub fn flat_row(&self, load: &Load, std: f64) -> Vec<f64> {
        self.flat.iter().map(|known| if is_same(known, load) { std } else { 0.0 }).collect()
    }

    /// Basis functions of all coefficients at a texture and a load. `flat` are those of the flat sample's errors, `form`
    /// is the value of the form times the scale, `residual` the standard deviation of the residual over that of alpha.
    pub fn row(
        &self,
        flat: Vec<f64>,
        [form, residual]: [f64; 2],
        of: &Features,
        load: &Load,
        sensitivity: Sensitivity,
    ) -> Vec<f64> {
        let mut row = flat;
        row.extend(self.at_load(load).iter().map(|entry| form * entry));
        row.extend(self.global_stds().into_iter().zip(sensitivity.globals()).map(|(std, own)| std * own));
        row.extend(self.residual(&self.place(of, load)).iter().map(|entry| form * residual * entry));
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrepancy::tests::{cut, measured};

    /// K(a, b) - K(a, t) K(t, b) / K(t, t), with a trial t between a and b.
    #[test]
    fn a_trial_between_two_loads_leaves_them_of_opposite_signs() {
        let hyper = Hyperparameters { residual_pressure_length: 1.0, ..Hyperparameters::default() };
        let features = hyper.reference;
        let load = |pressure_pa: f64| Load { pressure_pa, speed_m_s: 2e-3, humidity: 0.4 };
        let trial = cut("", features, vec![measured(load(1.4e6), 0.0, 0.01, Sensitivity::of_modulus(0.0))]);
        let basis = Basis::new(&hyper, Conditions::default(), 0.2, &[trial]);
        let [a, b] = [0.2e6, 10e6].map(|pressure_pa| basis.place(&features, &load(pressure_pa)));
        let rows = [&a, &b].map(|place| basis.residual(place));
        let left = basis.residual_left([&a, &b], [&rows[0], &rows[1]]);
        // Correlations exp(-d^2 / 2), d the difference of the logarithms.
        let k = |from: f64, to: f64| (-0.5 * (from / to).ln().powi(2)).exp();
        let expected = hyper.amplitude_std.powi(2) * (k(0.2, 10.0) - k(0.2, 1.4) * k(1.4, 10.0));
        assert!(expected < -5e-4 && (left - expected).abs() < 1e-12, "{left} {expected}");
    }
}
