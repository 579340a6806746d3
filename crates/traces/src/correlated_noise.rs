//! Standard errors of the mean and of the slope of values with correlated noise.
//!
//! The means over the parts of a window are modelled as a line plus noise with the covariance exp(-|t| / tau). A window
//! of a few tens of tau determines tau badly. Therefore the variances are averaged over a set of correlation times tau,
//! each weighted by its restricted likelihood, which does not depend on the line and on the noise amplitude (D. A.
//! Harville, J. Am. Stat. Assoc. 72, 320, 1977). The standard error is e:
//!
//! ```text
//! e^2 = sum_tau w_tau v_tau R_tau / (n - 2),     w_tau ~ prior_tau |C|^-1/2 |X^T C^-1 X|^-1/2 R_tau^-(n-2)/2
//! ```
//!
//! with the covariance C of the n means for unit noise strength, the design matrix X of the line, the residual sum of
//! squares R of generalized least squares, and the variance v of the plain mean, or of the plain slope, for unit noise
//! strength.

use slipgrid_base::statistics::cholesky::{cholesky, dot, log_determinant, solve_lower};

/// Correlation times as fractions of the window, in addition to 0 (white noise). Noise with a longer correlation time
/// cannot be distinguished from a drift.
const CORRELATION_TIMES: [f64; 6] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32];
/// Prior weight of each correlation time relative to white noise, such that all correlation times together weigh as
/// much as white noise.
const CORRELATED_PRIOR: f64 = 1.0 / 6.0;

/// Standard errors of the mean of evenly spaced values, and of the change of their least-squares line over as many
/// steps as there are values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineErrors {
    /// Standard error of the mean.
    pub mean: f64,
    /// Standard error of the change of the line.
    pub change: f64,
}

/// Weight and errors for one correlation time.
struct Hypothesis {
    /// Natural logarithm of the weight, up to a constant.
    log_weight: f64,
    /// Squared standard errors of the mean and of the change of the line, in this order.
    squares: [f64; 2],
}

/// Computes the standard errors for `values`, each the mean over one part of a window. NaN for fewer than three values.
pub fn line_errors(values: &[f64]) -> LineErrors {
    if values.len() < 3 {
        return LineErrors { mean: f64::NAN, change: f64::NAN };
    }
    let priors = std::iter::once((0.0, 0.0)).chain(CORRELATION_TIMES.map(|time| (time, CORRELATED_PRIOR.ln())));
    let found: Vec<Hypothesis> = priors.filter_map(|(time, log_prior)| hypothesis(values, time, log_prior)).collect();
    let largest = found.iter().map(|hypothesis| hypothesis.log_weight).fold(f64::NEG_INFINITY, f64::max);
    // Without any noise all weights are equal.
    let weight =
        |hypothesis: &Hypothesis| if largest.is_finite() { (hypothesis.log_weight - largest).exp() } else { 1.0 };
    let total: f64 = found.iter().map(weight).sum();
    let error = |place: usize| {
        (found.iter().map(|hypothesis| weight(hypothesis) * hypothesis.squares[place]).sum::<f64>() / total).sqrt()
    };
    LineErrors { mean: error(0), change: error(1) }
}

fn hypothesis(values: &[f64], correlation_time: f64, log_prior: f64) -> Option<Hypothesis> {
    let n = values.len();
    let count = n as f64;
    let covariances = covariances(n, correlation_time);
    let matrix: Vec<f64> = (0..n * n).map(|at| covariances[(at / n).abs_diff(at % n)]).collect();
    let factor = cholesky(&matrix, n)?;
    let whitened = |component: &dyn Fn(usize) -> f64| {
        let mut all: Vec<f64> = (0..n).map(component).collect();
        solve_lower(&factor, n, &mut all);
        all
    };
    let x = |i: usize| (i as f64 + 0.5) / count - 0.5;
    let middle = values[n / 2];
    let (ones, slope, left) = (whitened(&|_| 1.0), whitened(&x), whitened(&|i| values[i] - middle));
    let subtract =
        |a: &[f64], factor: f64, b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - factor * b).collect() };
    // Gram-Schmidt: make the slope orthogonal to the mean, and the residuals orthogonal to both.
    let ones_squared = dot(&ones, &ones);
    let slope = subtract(&slope, dot(&slope, &ones) / ones_squared, &ones);
    let slope_squared = dot(&slope, &slope);
    let left = subtract(&left, dot(&left, &ones) / ones_squared, &ones);
    let left = subtract(&left, dot(&left, &slope) / slope_squared, &slope);
    let squares = dot(&left, &left);
    let freedom = count - 2.0;
    let variance = |weight: &dyn Fn(usize) -> f64| {
        (0..n * n).map(|at| weight(at / n) * matrix[at] * weight(at % n)).sum::<f64>() * squares / freedom
    };
    let sum_xx: f64 = (0..n).map(|i| x(i) * x(i)).sum();
    Some(Hypothesis {
        log_weight: log_prior
            - 0.5 * (log_determinant(&factor, n) + (ones_squared * slope_squared).ln() + freedom * squares.ln()),
        squares: [variance(&|_| 1.0 / count), variance(&|i| x(i) / sum_xx)],
    })
}

/// Covariances of the means over `n` equal parts of the unit interval, indexed by the distance between two parts, for
/// noise with the covariance exp(-|t| / tau) / (2 tau), whose integral is 1.
fn covariances(n: usize, tau: f64) -> Vec<f64> {
    let count = n as f64;
    if tau == 0.0 {
        return (0..n).map(|apart| if apart == 0 { count } else { 0.0 }).collect();
    }
    let step = 1.0 / (count * tau);
    let lost = -(-step).exp_m1();
    let covariance = |apart: usize| match apart {
        0 => count * count * tau * (step - lost),
        _ => 0.5 * count * count * tau * lost * lost * (-step * (apart - 1) as f64).exp(),
    };
    (0..n).map(covariance).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_of_parts_sum_to_that_of_the_whole() {
        for tau in [0.01_f64, 0.1, 0.3] {
            // 1/n^2 sum_ij C_ij = 1 - tau (1 - exp(-1 / tau)) for any number of parts.
            for n in [4, 20] {
                let found = covariances(n, tau);
                let sum: f64 = (0..n * n).map(|at| found[(at / n).abs_diff(at % n)]).sum::<f64>() / (n * n) as f64;
                assert!((sum - (1.0 - tau * (1.0 - (-1.0 / tau).exp()))).abs() < 1e-12, "{tau} {n}: {sum}");
            }
        }
    }

    #[test]
    fn values_on_a_line_have_no_error_and_equal_ones_neither() {
        let line: Vec<f64> = (0..20).map(|i| 0.3 + 0.01 * f64::from(i)).collect();
        let found = line_errors(&line);
        assert!(found.mean < 1e-15 && found.change < 1e-14, "{found:?}");
        assert_eq!(line_errors(&[0.25; 20]), LineErrors { mean: 0.0, change: 0.0 });
        assert!(line_errors(&[0.25; 2]).mean.is_nan());
    }
}
