//! Gaussian processes with a squared exponential kernel, expanded exactly about the trials: the residual c of a form, of
//! the logarithms of width, pitch, depth and pressure; and eta and gamma, of humidity.
//!
//! A sample is on target over a range only if it is at every point of it. Paths of this kernel are smooth, so the chance
//! converges with the second power of the step between computed points; those of exp(-|dH| / length) are rough, and the
//! chance falls with every further point.
//!
//! With places x_1 ... x_m of the trials, K their correlation and K = L L^T, the values of c at a place x are
//!
//! ```text
//! c(x) = w(x)^T theta + rest(x),     w(x) = L^-1 k(x),     theta ~ N(0, I)
//! cov(rest(x), rest(y)) = k(x, y) - w(x)^T w(y)
//! ```
//!
//! and the rest is independent of every measurement. A place is omitted if the other places explain all but
//! [`EXPLAINED`] of its variance.

use crate::discrepancy::{Features, Hyperparameters, Load};
use slipgrid_base::statistics::cholesky::{dot, solve_lower};

/// Minimum variance that a further place must add, relative to the variance of the process: a hundredth of the rounding
/// error of other terms.
const EXPLAINED: f64 = 1e-12;

/// Texture at a pressure: the logarithms of width, pitch, depth and pressure, each over its correlation length; or a
/// humidity over its correlation length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place(pub [f64; 4]);

impl Place {
    pub fn new(hyper: &Hyperparameters, of: &Features, load: &Load) -> Self {
        let [width, pitch, depth] = of.logarithms();
        let length = hyper.residual_length;
        let pressure = libm::log(load.pressure_pa) / hyper.residual_pressure_length;
        Self([width / length, pitch / length, depth / length, pressure])
    }

    pub fn of_humidity(hyper: &Hyperparameters, humidity: f64) -> Self {
        Self([humidity / hyper.humidity_length, 0.0, 0.0, 0.0])
    }

    /// Prior correlation exp(-|x - y|^2 / 2) of a process at two places x and y.
    pub fn correlation(&self, other: &Self) -> f64 {
        let square: f64 = self.0.iter().zip(other.0).map(|(a, b)| (a - b) * (a - b)).sum();
        libm::exp(-0.5 * square)
    }
}

/// Places of the expansion of a process, with the lower factor of their correlation.
#[derive(Clone, Debug)]
pub struct KernelBasis {
    pub places: Vec<Place>,
    factor: Vec<f64>,
}

impl KernelBasis {
    /// Selects places by a pivoted Cholesky factorization (Higham, Accuracy and Stability of Numerical Algorithms, 10.3):
    /// each step takes the place of maximum remaining variance.
    pub fn new(mut candidates: Vec<Place>) -> Self {
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut places: Vec<Place> = Vec::new();
        // Whitened values of each candidate at the selected places.
        let mut known: Vec<Vec<f64>> = vec![Vec::new(); candidates.len()];
        let left = |row: &Vec<f64>| 1.0 - dot(row, row);
        while let Some((next, variance)) = known
            .iter()
            .map(left)
            .enumerate()
            .reduce(|most, other| if other.1 > most.1 { other } else { most })
            .filter(|(_, variance)| *variance > EXPLAINED)
        {
            let (place, row, pivot) = (candidates.swap_remove(next), known.swap_remove(next), variance.sqrt());
            for (other, whitened) in candidates.iter().zip(&mut known) {
                let explained = dot(&row, whitened);
                whitened.push((other.correlation(&place) - explained) / pivot);
            }
            places.push(place);
            rows.push([row, vec![pivot]].concat());
        }
        let n = places.len();
        let mut factor = vec![0.0; n * n];
        for (place, row) in rows.iter().enumerate() {
            factor[place * n..][..row.len()].copy_from_slice(row);
        }
        Self { places, factor }
    }

    /// Basis functions w(x) = L^-1 k(x) at the place x, with its correlations k(x) with the places of the basis.
    pub fn whitened(&self, place: &Place) -> Vec<f64> {
        let mut row: Vec<f64> = self.places.iter().map(|own| own.correlation(place)).collect();
        self.whiten(&mut row);
        row
    }

    /// Multiplies values at the places of the basis by L^-1, in place, with the factor L of their correlation.
    pub fn whiten(&self, values: &mut [f64]) {
        solve_lower(&self.factor, self.places.len(), values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_others_explain_are_left_out_and_correlations_are_kept() {
        let place = |x: f64, y: f64| Place([x, 0.0, y, 0.0]);
        let all = vec![place(0.0, 0.0), place(1.0, 0.5), place(0.0, 0.0), place(1e-7, 0.0), place(-0.3, 2.0)];
        let basis = KernelBasis::new(all.clone());
        assert_eq!(basis.places.len(), 3);
        for a in &all {
            for b in &all {
                let by_basis = dot(&basis.whitened(a), &basis.whitened(b));
                assert!((by_basis - a.correlation(b)).abs() < 1e-7, "{by_basis} {}", a.correlation(b));
            }
        }
        // The basis explains little far from all places, and nearly everything close to one.
        let explained = |at: Place| dot(&basis.whitened(&at), &basis.whitened(&at));
        assert!(explained(place(6.0, 6.0)) < 1e-6 && explained(place(0.01, 0.0)) > 0.999);
        assert_eq!(KernelBasis::new(Vec::new()).whitened(&place(0.0, 0.0)), Vec::<f64>::new());
    }
}
