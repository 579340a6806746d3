//! Weighted least squares by argmin's Gauss-Newton method, Jacobian by forward differences.

use argmin::core::{Error, Executor, Jacobian, Operator, State};
use argmin::solver::gaussnewton::GaussNewton;
use nalgebra::{DMatrix, DVector};

/// Relative step of the forward differences. The model is smooth and converged to 1e-11.
const DIFFERENCE: f64 = 1e-5;
/// Change of the norm of the residuals (in standard deviations) at which the fit has converged.
const TOLERANCE: f64 = 1e-7;
/// Iterations at most: the model is nearly linear in its coefficients, three or four do.
const MOST_ITERATIONS: u64 = 20;

/// Residuals in standard deviations, as a function of the parameters.
pub struct LeastSquares<F> {
    residuals: F,
    /// For every residual the parameters it depends on: a column of the Jacobian is found together with
    /// all columns that share no residual with it.
    depends_on: Vec<Vec<usize>>,
}

/// A solution with its curvature.
pub struct Solution {
    /// Best parameters.
    pub parameters: Vec<f64>,
    /// Residuals there, in standard deviations.
    pub residuals: Vec<f64>,
    /// Standard error of every parameter, sqrt of the diagonal of (J^T J)^-1; infinite where the data do
    /// not determine it.
    pub standard_errors: Vec<f64>,
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, Error>> LeastSquares<F> {
    /// A problem with the given residuals.
    pub fn new(residuals: F, depends_on: Vec<Vec<usize>>) -> Self {
        Self { residuals, depends_on }
    }

    /// Minimizes the sum of squares from `start`.
    ///
    /// # Errors
    /// Whatever the residuals return.
    pub fn solve(self, start: Vec<f64>) -> Result<Solution, Error> {
        let solver = GaussNewton::new().with_tolerance(TOLERANCE)?;
        let result = Executor::new(self, solver)
            .configure(|state| state.param(DVector::from_vec(start.clone())).max_iters(MOST_ITERATIONS))
            .run()?;
        let parameters = result.state().get_best_param().cloned().unwrap_or(DVector::from_vec(start));
        let problem = result.problem.problem.ok_or_else(|| Error::msg("the solver kept the problem"))?;
        let residuals = problem.apply(&parameters)?;
        let jacobian = problem.jacobian(&parameters)?;
        let curvature = jacobian.transpose() * jacobian;
        let count = parameters.len();
        let standard_errors = match curvature.try_inverse() {
            Some(covariance) => (0..count).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect(),
            None => vec![f64::INFINITY; count],
        };
        Ok(Solution {
            parameters: parameters.iter().copied().collect(),
            residuals: residuals.iter().copied().collect(),
            standard_errors,
        })
    }

    /// Groups of parameters of which no two enter the same residual.
    fn independent_groups(&self, parameters: usize) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for parameter in 0..parameters {
            let clashes = |group: &Vec<usize>| {
                self.depends_on
                    .iter()
                    .any(|entering| entering.contains(&parameter) && group.iter().any(|g| entering.contains(g)))
            };
            match groups.iter_mut().find(|group| !clashes(group)) {
                Some(group) => group.push(parameter),
                None => groups.push(vec![parameter]),
            }
        }
        groups
    }
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, Error>> Operator for LeastSquares<F> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;

    fn apply(&self, parameters: &Self::Param) -> Result<Self::Output, Error> {
        Ok(DVector::from_vec((self.residuals)(parameters.as_slice())?))
    }
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, Error>> Jacobian for LeastSquares<F> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, parameters: &Self::Param) -> Result<Self::Jacobian, Error> {
        let base = (self.residuals)(parameters.as_slice())?;
        let mut jacobian = DMatrix::zeros(base.len(), parameters.len());
        for group in self.independent_groups(parameters.len()) {
            let mut moved = parameters.clone();
            for &p in &group {
                moved[p] += DIFFERENCE * parameters[p].abs().max(f64::MIN_POSITIVE);
            }
            let changed = (self.residuals)(moved.as_slice())?;
            for (r, entering) in self.depends_on.iter().enumerate() {
                for &p in entering.iter().filter(|p| group.contains(p)) {
                    jacobian[(r, p)] = (changed[r] - base[r]) / (moved[p] - parameters[p]);
                }
            }
        }
        Ok(jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_has_its_textbook_slope_and_error() {
        // y = a + b x through four points with std 0.1: b = 2, a = 1, var(b) = s^2 / Sxx, Sxx = 5.
        let data = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (3.0, 7.0)];
        let residuals =
            move |p: &[f64]| Ok(data.iter().map(|(x, y)| (p[0] + p[1] * x - y) / 0.1).collect::<Vec<f64>>());
        let fit = LeastSquares::new(residuals, vec![vec![0, 1]; 4]).solve(vec![0.5, 0.5]).unwrap();
        assert!((fit.parameters[0] - 1.0).abs() < 1e-6 && (fit.parameters[1] - 2.0).abs() < 1e-6);
        assert!((fit.standard_errors[1] - 0.1 / 5.0_f64.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn parameters_that_share_no_residual_are_perturbed_together() {
        let problem = LeastSquares::new(|p: &[f64]| Ok(p.to_vec()), vec![vec![0], vec![1], vec![2]]);
        assert_eq!(problem.independent_groups(3), vec![vec![0, 1, 2]]);
        let coupled = LeastSquares::new(|p: &[f64]| Ok(p.to_vec()), vec![vec![0, 1], vec![1, 2]]);
        assert_eq!(coupled.independent_groups(3), vec![vec![0, 2], vec![1]]);
    }
}
