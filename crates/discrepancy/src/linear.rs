//! Small dense symmetric systems, row by row.

/// The lower triangular factor L of `matrix` = L L^T, n x n. A pivot that is zero but for rounding makes a column of zeros,
/// and `None` stands for one that is below that.
pub fn cholesky(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut factor = vec![0.0; n * n];
    for row in 0..n {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| factor[row * n + k] * factor[column * n + k]).sum();
            let left = matrix[row * n + column] - known;
            if row == column {
                let rounding = 1e-14 * matrix[row * n + row].abs() * n as f64;
                if left.is_nan() || left < -rounding {
                    return None;
                }
                factor[row * n + row] = if left > rounding { left.sqrt() } else { 0.0 };
            } else {
                let pivot = factor[column * n + column];
                factor[row * n + column] = if pivot > 0.0 { left / pivot } else { 0.0 };
            }
        }
    }
    Some(factor)
}

/// L^-1 b in the place of b.
pub fn solve_lower(factor: &[f64], n: usize, values: &mut [f64]) {
    for row in 0..n {
        let known: f64 = (0..row).map(|k| factor[row * n + k] * values[k]).sum();
        values[row] = (values[row] - known) / factor[row * n + row];
    }
}

/// L^-T b in the place of b.
pub fn solve_upper(factor: &[f64], n: usize, values: &mut [f64]) {
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| factor[k * n + row] * values[k]).sum();
        values[row] = (values[row] - known) / factor[row * n + row];
    }
}

/// ln det(L L^T).
pub fn log_determinant(factor: &[f64], n: usize) -> f64 {
    (0..n).map(|row| 2.0 * libm::log(factor[row * n + row])).sum()
}

/// Whether a factor has no column of zeros.
pub fn is_regular(factor: &[f64], n: usize) -> bool {
    (0..n).all(|row| factor[row * n + row] > 0.0)
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
