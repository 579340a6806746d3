//! Cholesky decomposition of small dense symmetric matrices (Golub and Van Loan, Matrix Computations, 4.2). An n x n
//! matrix is stored row by row in a slice of n^2 numbers.

/// Computes the lower triangular factor L of `matrix` = L L^T, n x n. A pivot that is zero within rounding gives a
/// column of zeros; `None` if a pivot is negative or NaN.
pub fn cholesky(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut is_definite = true;
    let factor = factor(matrix, n, |left, own| {
        let rounding = 1e-14 * own.abs() * n as f64;
        is_definite &= !left.is_nan() && left >= -rounding;
        left > rounding
    });
    is_definite.then_some(factor)
}

/// A pivot below this fraction of the variance on the diagonal is attributed to rounding of the covariance and counts
/// as zero.
const COVARIANCE_ROUNDING: f64 = 1e-10;

/// Computes the lower triangular factor of a covariance, n x n, which may be singular: a component that earlier
/// components determine, within rounding, gets a pivot of zero. For a matrix that is not a covariance, the result is
/// the factor of a nearby covariance.
pub fn covariance_factor(covariance: &[f64], n: usize) -> Vec<f64> {
    factor(covariance, n, |left, variance| left > COVARIANCE_ROUNDING * variance)
}

/// Computes the lower triangular factor of `matrix`, with a column of zeros where `is_pivot`, called with the remaining
/// pivot and the original diagonal entry, is false.
fn factor(matrix: &[f64], n: usize, mut is_pivot: impl FnMut(f64, f64) -> bool) -> Vec<f64> {
    let mut factor = vec![0.0; n * n];
    for row in 0..n {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| factor[row * n + k] * factor[column * n + k]).sum();
            let left = matrix[row * n + column] - known;
            let pivot = factor[column * n + column];
            factor[row * n + column] = if row == column {
                if is_pivot(left, matrix[row * n + row]) { left.sqrt() } else { 0.0 }
            } else if pivot > 0.0 {
                left / pivot
            } else {
                0.0
            };
        }
    }
    factor
}

/// Replaces the vector b in `values` by L^-1 b, with the lower triangular matrix L = `factor`, n x n.
pub fn solve_lower(factor: &[f64], n: usize, values: &mut [f64]) {
    for row in 0..n {
        let known: f64 = (0..row).map(|k| factor[row * n + k] * values[k]).sum();
        values[row] = (values[row] - known) / factor[row * n + row];
    }
}

/// Replaces the vector b in `values` by L^-T b, with the lower triangular matrix L = `factor`, n x n.
pub fn solve_upper(factor: &[f64], n: usize, values: &mut [f64]) {
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| factor[k * n + row] * values[k]).sum();
        values[row] = (values[row] - known) / factor[row * n + row];
    }
}

/// Natural logarithm of the determinant of L L^T, with the lower triangular matrix L = `factor`, n x n.
pub fn log_determinant(factor: &[f64], n: usize) -> f64 {
    (0..n).map(|row| 2.0 * libm::log(factor[row * n + row])).sum()
}

/// Replaces the vector b in `values` by (L L^T)^-1 b, with the lower triangular matrix L = `factor`, n x n.
pub fn solve(factor: &[f64], n: usize, values: &mut [f64]) {
    solve_lower(factor, n, values);
    solve_upper(factor, n, values);
}

/// Whether a triangular factor is regular: no entry of its diagonal is zero.
pub fn is_regular(factor: &[f64], n: usize) -> bool {
    (0..n).all(|row| factor[row * n + row] > 0.0)
}

/// Dot product of two vectors, summed from the first entry on.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_the_product_of_its_factors_and_solved_by_them() {
        // L = [2 0 0; 1 3 0; -1 2 1], x = (1, -2, 3)
        let matrix = [4.0, 2.0, -2.0, 2.0, 10.0, 5.0, -2.0, 5.0, 6.0];
        let factor = cholesky(&matrix, 3).unwrap();
        assert_eq!(factor, [2.0, 0.0, 0.0, 1.0, 3.0, 0.0, -1.0, 2.0, 1.0]);
        let mut solution = [4.0 - 4.0 - 6.0, 2.0 - 20.0 + 15.0, -2.0 - 10.0 + 18.0];
        solve(&factor, 3, &mut solution);
        assert!(solution.iter().zip([1.0, -2.0, 3.0]).all(|(found, x)| (found - x).abs() < 1e-14), "{solution:?}");
        assert!((log_determinant(&factor, 3) - 36.0_f64.ln()).abs() < 1e-14);
        assert!(is_regular(&factor, 3));
    }

    #[test]
    fn singular_matrices_have_columns_of_zeros_and_indefinite_ones_no_factor() {
        let factor = cholesky(&[1.0, 1.0, 1.0, 1.0], 2).unwrap();
        assert_eq!(factor, [1.0, 0.0, 1.0, 0.0]);
        assert!(!is_regular(&factor, 2));
        assert_eq!(cholesky(&[1.0, 2.0, 2.0, 1.0], 2), None);
        // Two components that are equal within rounding: the strict rule gives no factor, the other rule uses the first
        // one.
        let summed = [1.0, 1.0, 1.0, 1.0 - 1e-12];
        assert_eq!((cholesky(&summed, 2), covariance_factor(&summed, 2)), (None, vec![1.0, 0.0, 1.0, 0.0]));
    }
}
