//! Cholesky factorisation A = L L^T whose sums run from the first term on, starting at the entry of A.

/// Lower triangular factor L, row by row, of the symmetric matrix A = `entry`, n x n; `None` if the square of a pivot
/// is at most `least`.
pub(super) fn factor(n: usize, entry: impl Fn(usize, usize) -> f64, least: f64) -> Option<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::new();
    for i in 0..n {
        let mut row: Vec<f64> = Vec::new();
        for (j, above) in factor.iter().enumerate() {
            let sum = (0..j).fold(entry(i, j), |sum, k| sum - row[k] * above[k]);
            row.push(sum / above[j]);
        }
        let square = row.iter().fold(entry(i, i), |sum, value| sum - value * value);
        if square <= least {
            return None;
        }
        row.push(square.sqrt());
        factor.push(row);
    }
    Some(factor)
}

/// Solves L x = `right` for the lower triangular matrix L.
pub(super) fn solve_lower(factor: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solution = Vec::with_capacity(right.len());
    for (row, &value) in factor.iter().zip(right) {
        let known = row.iter().zip(&solution).fold(value, |sum: f64, (factor, x): (&f64, &f64)| sum - factor * x);
        solution.push(known / row[solution.len()]);
    }
    solution
}
