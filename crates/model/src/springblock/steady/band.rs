//! Symmetric positive definite band matrices: assembly, factorization, solution.
//!
//! A = U^T D U, where U is unit upper triangular with half bandwidth b. For n unknowns the factorization takes n b^2
//! multiplications and additions, and each solution takes 4 n b.

use multiversion::multiversion;

use super::dense::{LANES, dot, total};

/// Upper half of a symmetric band matrix A: row r holds A[r][r..=r + half_bandwidth].
#[derive(Clone, Debug)]
pub struct BandMatrix {
    order: usize,
    half_bandwidth: usize,
    rows: Vec<f64>,
}

impl BandMatrix {
    /// Creates the zero matrix of `order` rows.
    pub fn zero(order: usize, half_bandwidth: usize) -> Self {
        // The zeros are written explicitly. Zero pages from the system would be mapped when `add` first reads them and
        // copied when it writes, which flushes the address cache of every thread.
        let mut rows = std::hint::black_box(Vec::with_capacity(order * (half_bandwidth + 1)));
        rows.resize(order * (half_bandwidth + 1), 0.0);
        Self { order, half_bandwidth, rows }
    }

    /// Adds `value` to A[r][c] and, by symmetry, to A[c][r]; both must lie within the band.
    pub fn add(&mut self, r: usize, c: usize, value: f64) {
        let (r, c) = (r.min(c), r.max(c));
        self.rows[r * (self.half_bandwidth + 1) + (c - r)] += value;
    }

    /// Replaces row and column `r` by those of the identity, so that unknown r becomes zero.
    pub fn pin(&mut self, r: usize) {
        let stride = self.half_bandwidth + 1;
        for back in 1..=self.half_bandwidth.min(r) {
            self.rows[(r - back) * stride + back] = 0.0;
        }
        self.rows[r * stride..(r + 1) * stride].fill(0.0);
        self.rows[r * stride] = 1.0;
    }

    /// Factors A in place; `None` if A is not positive definite to rounding.
    pub fn factor(mut self) -> Option<BandFactor> {
        eliminate(&mut self.rows, self.order, self.half_bandwidth).then_some(BandFactor { upper: self })
    }
}

/// Factors U and D of A = U^T D U, with unit upper triangular U and diagonal D: row r holds 1/D[r], then U[r][r + 1..].
#[derive(Clone, Debug)]
pub struct BandFactor {
    upper: BandMatrix,
}

impl BandFactor {
    /// Solves A x = b; `x` holds b on entry.
    pub fn solve(&self, x: &mut [f64]) {
        substitute(&self.upper.rows, self.upper.half_bandwidth, x);
    }

    /// Solves A x = b for several b at once, with results identical to [`Self::solve`].
    pub fn solve_batch(&self, x: &mut [[f64; BATCH]]) {
        substitute_batch(&self.upper.rows, self.upper.half_bandwidth, x);
    }
}

/// Number of right-hand sides that are solved together: the factor, which exceeds the caches near the processor, is
/// read once for all of them.
pub const BATCH: usize = 4;

/// Factors the matrix in place by right-looking elimination; returns false if a pivot is not positive.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn eliminate(rows: &mut [f64], order: usize, half_bandwidth: usize) -> bool {
    let stride = half_bandwidth + 1;
    for k in 0..order {
        let reach = half_bandwidth.min(order - 1 - k);
        let (head, tail) = rows.split_at_mut((k + 1) * stride);
        let pivot_row = &mut head[k * stride..];
        let pivot = pivot_row[0];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let inverse = 1.0 / pivot;
        for back in 1..=reach {
            // A[k + back][..] -= A[k][k + back] / A[k][k] * A[k][..]
            let factor = pivot_row[back] * inverse;
            if factor != 0.0 {
                let target = &mut tail[(back - 1) * stride..(back - 1) * stride + reach - back + 1];
                for (t, s) in target.iter_mut().zip(&pivot_row[back..=reach]) {
                    *t -= factor * s;
                }
            }
        }
        pivot_row[0] = inverse;
        for u in &mut pivot_row[1..=reach] {
            *u *= inverse;
        }
    }
    true
}

/// Solves by forward and backward substitution; `x` holds the right-hand side on entry.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn substitute(rows: &[f64], half_bandwidth: usize, x: &mut [f64]) {
    let stride = half_bandwidth + 1;
    let order = x.len();
    for k in 0..order {
        let reach = half_bandwidth.min(order - 1 - k);
        let value = x[k];
        if value != 0.0 {
            let row = &rows[k * stride + 1..k * stride + 1 + reach];
            for (t, u) in x[k + 1..=k + reach].iter_mut().zip(row) {
                *t -= u * value;
            }
        }
    }
    for k in (0..order).rev() {
        let reach = half_bandwidth.min(order - 1 - k);
        let row = &rows[k * stride + 1..k * stride + 1 + reach];
        x[k] = x[k] * rows[k * stride] - dot(row, &x[k + 1..=k + reach]);
    }
}

/// Like [`substitute`] for several right-hand sides, in the same order of operations.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn substitute_batch(rows: &[f64], half_bandwidth: usize, x: &mut [[f64; BATCH]]) {
    let stride = half_bandwidth + 1;
    let order = x.len();
    for k in 0..order {
        let reach = half_bandwidth.min(order - 1 - k);
        let value = x[k];
        let row = &rows[k * stride + 1..k * stride + 1 + reach];
        for (t, u) in x[k + 1..=k + reach].iter_mut().zip(row) {
            for side in 0..BATCH {
                t[side] -= u * value[side];
            }
        }
    }
    for k in (0..order).rev() {
        let reach = half_bandwidth.min(order - 1 - k);
        let row = &rows[k * stride + 1..k * stride + 1 + reach];
        let known = &x[k + 1..=k + reach];
        let mut sums = [[0.0; BATCH]; LANES];
        let (row_chunks, row_rest) = row.as_chunks::<LANES>();
        let (known_chunks, known_rest) = known.as_chunks::<LANES>();
        let mut rest = [0.0; BATCH];
        for (u, v) in row_rest.iter().zip(known_rest) {
            for side in 0..BATCH {
                rest[side] += u * v[side];
            }
        }
        for (u, v) in row_chunks.iter().zip(known_chunks) {
            for lane in 0..LANES {
                for side in 0..BATCH {
                    sums[lane][side] += u[lane] * v[lane][side];
                }
            }
        }
        for side in 0..BATCH {
            let product = total(&sums.map(|sum| sum[side])) + rest[side];
            x[k][side] = x[k][side] * rows[k * stride] - product;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonally dominant band matrix with entries that vary along the band.
    fn example(order: usize, half_bandwidth: usize) -> BandMatrix {
        let mut matrix = BandMatrix::zero(order, half_bandwidth);
        for r in 0..order {
            matrix.add(r, r, 2.0 * half_bandwidth as f64 + 1.0 + (r % 3) as f64);
            for c in r + 1..(r + half_bandwidth + 1).min(order) {
                matrix.add(r, c, ((r * 7 + c * 13) % 11) as f64 / 5.5 - 1.0);
            }
        }
        matrix
    }

    fn times(matrix: &BandMatrix, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; matrix.order];
        for r in 0..matrix.order {
            for c in r..(r + matrix.half_bandwidth + 1).min(matrix.order) {
                let value = matrix.rows[r * (matrix.half_bandwidth + 1) + (c - r)];
                y[r] += value * x[c];
                if c != r {
                    y[c] += value * x[r];
                }
            }
        }
        y
    }

    #[test]
    fn solutions_satisfy_the_equations_to_rounding() {
        for (order, half_bandwidth) in [(1, 0), (5, 4), (60, 1), (200, 37)] {
            let matrix = example(order, half_bandwidth);
            let right: Vec<f64> = (0..order).map(|i| (i as f64 * 0.7).sin()).collect();
            let mut x = right.clone();
            matrix.clone().factor().unwrap().solve(&mut x);
            let residual = times(&matrix, &x).iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(residual < 1e-12, "{order} {half_bandwidth} {residual}");
        }
    }

    #[test]
    fn several_right_hand_sides_at_once_have_the_bits_of_each_alone() {
        for (order, half_bandwidth) in [(1, 0), (5, 4), (60, 1), (200, 37), (90, 43)] {
            let factor = example(order, half_bandwidth).factor().unwrap();
            let right = |side: usize| move |i: usize| ((i * (side + 1)) as f64 * 0.7).sin();
            let mut together: Vec<[f64; BATCH]> =
                (0..order).map(|i| std::array::from_fn(|side| right(side)(i))).collect();
            factor.solve_batch(&mut together);
            for side in 0..BATCH {
                let mut alone: Vec<f64> = (0..order).map(right(side)).collect();
                factor.solve(&mut alone);
                assert!(alone.iter().zip(&together).all(|(alone, each)| alone.to_bits() == each[side].to_bits()));
            }
        }
    }

    #[test]
    fn pinned_unknowns_are_zero_and_the_others_ignore_them() {
        let mut matrix = example(30, 4);
        matrix.pin(10);
        let mut x = vec![1.0; 30];
        x[10] = 0.0;
        matrix.clone().factor().unwrap().solve(&mut x);
        assert_eq!(x[10], 0.0);
    }

    #[test]
    fn an_indefinite_matrix_has_no_factor() {
        let mut matrix = example(10, 2);
        matrix.add(5, 5, -100.0);
        assert!(matrix.factor().is_none());
    }
}
