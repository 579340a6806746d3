//! Anderson acceleration of a fixed-point iteration x <- g(x) (D. G. Anderson, J. ACM 12, 547, 1965).

use slipgrid_base::statistics::cholesky::dot;

/// Number of stored steps. More steps take memory and worsen the conditioning, fewer steps need more iterations; 3 to 8
/// perform alike here.
const DEPTH: usize = 6;
/// Stored steps are discarded if the residual grows by more than this factor in one step, because the secants are then
/// misleading.
const GROWTH: f64 = 4.0;
/// Regularization of the normal equations of the secants, relative to the diagonal.
const RIDGE: f64 = 1e-14;

/// Memory of the last steps of x and of the residual g(x) - x.
pub struct Anderson {
    steps: Vec<Vec<f64>>,
    residual_steps: Vec<Vec<f64>>,
    last: Option<(Vec<f64>, Vec<f64>)>,
    last_norm: f64,
}

impl Anderson {
    /// Creates an empty memory.
    pub const fn new() -> Self {
        Self { steps: Vec::new(), residual_steps: Vec::new(), last: None, last_norm: f64::INFINITY }
    }

    /// Replaces `x` by the next iterate, given `image` = g(x).
    pub fn step(&mut self, x: &mut [f64], image: &[f64]) {
        let residual: Vec<f64> = image.iter().zip(x.iter()).map(|(g, x)| g - x).collect();
        let norm = dot(&residual, &residual).sqrt();
        if norm > GROWTH * self.last_norm {
            self.steps.clear();
            self.residual_steps.clear();
        } else if let Some((last_x, last_residual)) = &self.last {
            if self.steps.len() == DEPTH {
                self.steps.remove(0);
                self.residual_steps.remove(0);
            }
            self.steps.push(difference(x, last_x));
            self.residual_steps.push(difference(&residual, last_residual));
        }
        self.last = Some((x.to_vec(), residual.clone()));
        self.last_norm = norm;

        // x+ = x + r - (dX + dR) gamma, where gamma minimizes |r - dR gamma|
        let gamma = self.least_squares(&residual);
        for i in 0..x.len() {
            let correction: f64 =
                gamma.iter().enumerate().map(|(m, g)| g * (self.steps[m][i] + self.residual_steps[m][i])).sum();
            x[i] += residual[i] - correction;
        }
    }

    /// Coefficients gamma of the stored steps from the regularized normal equations, by Cholesky elimination.
    fn least_squares(&self, residual: &[f64]) -> Vec<f64> {
        let m = self.residual_steps.len();
        let products = |a| self.residual_steps.iter().map(|b| dot(a, b)).collect();
        let mut matrix: Vec<Vec<f64>> = self.residual_steps.iter().map(|a| products(a)).collect();
        let mut right: Vec<f64> = self.residual_steps.iter().map(|a| dot(a, residual)).collect();
        for (a, row) in matrix.iter_mut().enumerate() {
            row[a] *= 1.0 + RIDGE;
        }
        for k in 0..m {
            if matrix[k][k].is_nan() || matrix[k][k] <= 0.0 {
                // Linearly dependent secants add nothing.
                right[k] = 0.0;
                matrix[k] = vec![0.0; m];
                matrix[k][k] = 1.0;
                for row in matrix.iter_mut().skip(k + 1) {
                    row[k] = 0.0;
                }
                continue;
            }
            for r in k + 1..m {
                let factor = matrix[r][k] / matrix[k][k];
                let (above, below) = matrix.split_at_mut(r);
                for (entry, pivot) in below[0][k..].iter_mut().zip(&above[k][k..]) {
                    *entry -= factor * pivot;
                }
                right[r] -= factor * right[k];
            }
        }
        for k in (0..m).rev() {
            let known: f64 = (k + 1..m).map(|c| matrix[k][c] * right[c]).sum();
            right[k] = (right[k] - known) / matrix[k][k];
        }
        right
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_map_is_solved_in_as_many_steps_as_it_has_dimensions() {
        // g(x) = M x + c with a spectral radius above one, so that plain iteration would diverge.
        let map = |x: &[f64]| vec![0.9 * x[0] - 0.5 * x[1] + 1.0, 0.8 * x[0] - 1.2 * x[1] + 0.5, 0.3 * x[2] - 2.0];
        let mut x = vec![0.0; 3];
        let mut mixer = Anderson::new();
        for _ in 0..6 {
            let image = map(&x);
            mixer.step(&mut x, &image);
        }
        let error: f64 = map(&x).iter().zip(&x).map(|(g, x)| (g - x).abs()).sum();
        assert!(error < 1e-9, "{error}");
    }
}
