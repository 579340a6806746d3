//! Weighted least squares within bounds by the Levenberg-Marquardt method, with the Jacobian from forward differences.
//!
//! A parameter at a bound is fixed while the gradient pushes it outward; steps beyond a bound are clamped. argmin
//! offers neither bounds nor this method.

use slipgrid_base::statistics::cholesky::{cholesky, dot, is_regular, solve};

/// Relative step of the forward differences. The model is smooth and converged to 1e-11.
const DIFFERENCE_STEP: f64 = 1e-5;
/// Relative change of the parameters below which the fit has converged.
const TOLERANCE: f64 = 1e-9;
/// Maximum number of iterations. The model is nearly linear in its coefficients, so that three or four are typical.
const MAX_ITERATIONS: usize = 100;
/// Initial damping, and the factor by which it is divided after a successful step and multiplied after a failed one.
const DAMPING: (f64, f64) = (1e-3, 10.0);
/// Maximum damping; larger values make steps too small to help.
const MAX_DAMPING: f64 = 1e12;

/// Minimum eigenvalue of J^T J, with columns scaled to unit length, for which the data determine the parameters.
const MIN_CURVATURE: f64 = 1e-10;

/// A least-squares problem: residuals in standard deviations, as a function of the parameters.
pub struct LeastSquares<F> {
    residuals: F,
    /// Lower and upper bound of every parameter.
    bounds: Vec<[f64; 2]>,
    /// Parameters that are fixed at their start value.
    held: Vec<bool>,
}

/// Solution of a least-squares problem with its covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Best parameters.
    pub parameters: Vec<f64>,
    /// Residuals at the solution, in standard deviations.
    pub residuals: Vec<f64>,
    /// Covariance (J^T J)^-1 of the parameters, with the Jacobian J of the residuals; infinite on the diagonal if the
    /// data do not determine a parameter.
    pub covariance: Vec<Vec<f64>>,
    /// Whether each parameter ended at a bound.
    pub at_bound: Vec<bool>,
}

impl Solution {
    /// Sum of squared residuals.
    pub fn chi_square(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }

    /// Standard error of the parameter with this index; infinite if the data do not determine it.
    pub fn standard_error(&self, parameter: usize) -> f64 {
        self.covariance[parameter][parameter].max(0.0).sqrt()
    }
}

impl<E, F: Fn(&[f64]) -> Result<Vec<f64>, E>> LeastSquares<F> {
    /// A problem with `residuals` as a function of the parameters, and the lower and upper bound of each parameter.
    pub fn new(residuals: F, bounds: Vec<[f64; 2]>) -> Self {
        Self { residuals, held: vec![false; bounds.len()], bounds }
    }

    /// Fixes a parameter at its start value.
    pub fn hold(mut self, parameter: usize) -> Self {
        self.held[parameter] = true;
        self
    }

    /// Minimizes the sum of squares from `start`.
    ///
    /// # Errors
    /// Errors of the residual function.
    pub fn solve(&self, start: &[f64]) -> Result<Solution, E> {
        let within = |p: f64, i: usize| p.clamp(self.bounds[i][0], self.bounds[i][1]);
        let mut at: Vec<f64> = start.iter().enumerate().map(|(i, &p)| within(p, i)).collect();
        let mut residuals = (self.residuals)(&at)?;
        let mut damping = DAMPING.0;
        for _ in 0..MAX_ITERATIONS {
            let jacobian = self.jacobian(&at, &residuals)?;
            let gradient: Vec<f64> = jacobian.iter().map(|column| dot(column, &residuals)).collect();
            let free: Vec<usize> = (0..at.len())
                .filter(|&i| {
                    let outward = (at[i] <= self.bounds[i][0] && gradient[i] > 0.0)
                        || (at[i] >= self.bounds[i][1] && gradient[i] < 0.0);
                    !self.held[i] && !outward
                })
                .collect();
            let mut moved = 0.0_f64;
            while !free.is_empty() && damping < MAX_DAMPING {
                let Some(step) = step(&jacobian, &gradient, &free, damping) else {
                    damping *= DAMPING.1;
                    continue;
                };
                let mut trial = at.clone();
                for (&i, step) in free.iter().zip(step.iter()) {
                    trial[i] = within(at[i] - step, i);
                }
                let found = (self.residuals)(&trial)?;
                let sum = |values: &[f64]| values.iter().map(|r| r * r).sum::<f64>();
                if sum(&found) <= sum(&residuals) {
                    moved =
                        free.iter().map(|&i| (trial[i] - at[i]).abs() / at[i].abs().max(1e-300)).fold(0.0, f64::max);
                    (at, residuals) = (trial, found);
                    damping /= DAMPING.1;
                    break;
                }
                damping *= DAMPING.1;
            }
            if moved < TOLERANCE {
                break;
            }
        }
        let jacobian = self.jacobian(&at, &residuals)?;
        Ok(Solution {
            covariance: self.covariance(&jacobian),
            at_bound: (0..at.len()).map(|i| at[i] <= self.bounds[i][0] || at[i] >= self.bounds[i][1]).collect(),
            parameters: at,
            residuals,
        })
    }

    /// Derivatives of all residuals, one column per parameter; zero for fixed parameters.
    fn jacobian(&self, at: &[f64], residuals: &[f64]) -> Result<Vec<Vec<f64>>, E> {
        let column = |p: usize| {
            if self.held[p] {
                return Ok(vec![0.0; residuals.len()]);
            }
            let mut moved = at.to_vec();
            let step = DIFFERENCE_STEP * at[p].abs().max(1e-3);
            // Step backwards at the upper bound.
            moved[p] += if at[p] + step > self.bounds[p][1] { -step } else { step };
            let changed = (self.residuals)(&moved)?;
            Ok(changed.iter().zip(residuals).map(|(changed, here)| (changed - here) / (moved[p] - at[p])).collect())
        };
        (0..at.len()).map(column).collect()
    }

    fn covariance(&self, jacobian: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = jacobian.len();
        // Columns are scaled to unit length, because parameters may differ by many orders of magnitude.
        let norms: Vec<f64> = jacobian.iter().map(|column| dot(column, column).sqrt()).collect();
        let seen: Vec<usize> = (0..count).filter(|&p| norms[p] > 1e-9 && !self.held[p]).collect();
        let mut covariance = vec![vec![0.0; count]; count];
        for (p, row) in covariance.iter_mut().enumerate().filter(|(p, _)| !self.held[*p]) {
            row[p] = f64::INFINITY;
        }
        if let Some(inverse) = inverse(&curvature(jacobian, &seen, |p, q| norms[p] * norms[q])) {
            for (row, &p) in inverse.iter().zip(&seen) {
                for (entry, &q) in row.iter().zip(&seen) {
                    covariance[p][q] = entry / (norms[p] * norms[q]);
                }
            }
        }
        covariance
    }
}

/// Entries of J^T J for the `chosen` columns of the Jacobian J, each divided by `scale`, row by row.
fn curvature(jacobian: &[Vec<f64>], chosen: &[usize], scale: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let entry = |p: usize, q: usize| dot(&jacobian[p], &jacobian[q]) / scale(p, q);
    chosen.iter().flat_map(|&p| chosen.iter().map(move |&q| (p, q))).map(|(p, q)| entry(p, q)).collect()
}

/// Inverse of a matrix with unit diagonal, as rows; `None` if its smallest eigenvalue may be below [`MIN_CURVATURE`].
/// The trace of the inverse exceeds the reciprocal of the smallest eigenvalue.
fn inverse(curvature: &[f64]) -> Option<Vec<Vec<f64>>> {
    let n = curvature.len().isqrt();
    let factor = cholesky(curvature, n).filter(|factor| is_regular(factor, n))?;
    let row = |p: usize| {
        let mut row: Vec<f64> = (0..n).map(|q| f64::from(u8::from(p == q))).collect();
        solve(&factor, n, &mut row);
        row
    };
    let rows: Vec<Vec<f64>> = (0..n).map(row).collect();
    let trace: f64 = rows.iter().enumerate().map(|(p, row)| row[p]).sum();
    (trace * MIN_CURVATURE < 1.0).then_some(rows)
}

/// Solves (J^T J + damping diag(J^T J)) step = gradient for the free parameters, with the Jacobian J; `None` if the
/// matrix is singular.
fn step(jacobian: &[Vec<f64>], gradient: &[f64], free: &[usize], damping: f64) -> Option<Vec<f64>> {
    let n = free.len();
    let mut curvature = curvature(jacobian, free, |_, _| 1.0);
    for i in 0..n {
        curvature[i * n + i] = curvature[i * n + i] * (1.0 + damping) + f64::MIN_POSITIVE;
    }
    let factor = cholesky(&curvature, n).filter(|factor| is_regular(factor, n))?;
    let mut step: Vec<f64> = free.iter().map(|&p| gradient[p]).collect();
    solve(&factor, n, &mut step);
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Outcome = Result<Vec<f64>, ()>;

    fn line(p: &[f64]) -> Outcome {
        // y = a + b x through four points with std 0.1: b = 2, a = 1, var(b) = s^2 / Sxx, Sxx = 5.
        Ok([(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (3.0, 7.0)].iter().map(|(x, y)| (p[0] + p[1] * x - y) / 0.1).collect())
    }

    #[test]
    fn a_straight_line_has_its_textbook_slope_and_covariance() {
        let fit = LeastSquares::new(line, vec![[-10.0, 10.0]; 2]).solve(&[0.5, 0.5]).unwrap();
        assert!((fit.parameters[0] - 1.0).abs() < 1e-8 && (fit.parameters[1] - 2.0).abs() < 1e-8);
        assert!((fit.standard_error(1) - 0.1 / 5.0_f64.sqrt()).abs() < 1e-6);
        // cov(a, b) = -mean(x) var(b)
        assert!((fit.covariance[0][1] + 1.5 * 0.01 / 5.0).abs() < 1e-7);
        assert_eq!(fit.at_bound, [false, false]);
    }

    #[test]
    fn bounds_hold_and_the_rest_is_best_within_them() {
        let fit = LeastSquares::new(line, vec![[-10.0, 10.0], [0.0, 1.0]]).solve(&[0.5, 0.5]).unwrap();
        // With a slope of at most 1 the best intercept is 4 - 1.5.
        assert!((fit.parameters[0] - 2.5).abs() < 1e-8 && fit.parameters[1] == 1.0, "{fit:?}");
        assert_eq!(fit.at_bound, [false, true]);
        let held = LeastSquares::new(line, vec![[-10.0, 10.0]; 2]).hold(1).solve(&[0.5, 0.0]).unwrap();
        assert!((held.parameters[0] - 4.0).abs() < 1e-8 && held.parameters[1] == 0.0);
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let rosenbrock = |p: &[f64]| -> Outcome { Ok(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]) };
        let fit = LeastSquares::new(rosenbrock, vec![[-5.0, 5.0]; 2]).solve(&[-1.2, 1.0]).unwrap();
        assert!((fit.parameters[0] - 1.0).abs() < 1e-6 && (fit.parameters[1] - 1.0).abs() < 1e-6, "{fit:?}");
    }

    #[test]
    fn what_the_data_do_not_see_has_no_finite_error() {
        let sum = |p: &[f64]| -> Outcome { Ok(vec![p[0] + p[1] - 1.0, 2.0 * (p[0] + p[1] - 1.0)]) };
        let fit = LeastSquares::new(sum, vec![[-10.0, 10.0]; 2]).solve(&[0.1, 0.2]).unwrap();
        assert!(fit.standard_error(0).is_infinite() && (fit.parameters[0] + fit.parameters[1] - 1.0).abs() < 1e-8);
    }
}
