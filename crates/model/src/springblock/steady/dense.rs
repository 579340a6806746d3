//! Dense matrices stored by rows: elimination with many right-hand sides, linear combinations of rows.

use multiversion::multiversion;

/// Number of rows processed together, so that each target entry is loaded once for four products.
const BATCH: usize = 4;

/// Gauss-Jordan elimination with partial pivoting; returns false if a pivot vanishes.
///
/// `rows` has rows of `width` entries. The first `order` columns are the matrix, the others are right-hand sides, which
/// the solutions replace. For n unknowns and m right-hand sides it takes n^3/3 + n^2 m multiplications and additions.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn solve_many(rows: &mut [f64], order: usize, width: usize) -> bool {
    let mut first = 0;
    while first < order {
        let end = (first + BATCH).min(order);
        for k in first..end {
            // Below the pivot only the columns of this panel are up to date.
            let largest = (k..order)
                .max_by(|&a, &b| rows[a * width + k].abs().total_cmp(&rows[b * width + k].abs()))
                .unwrap_or(k);
            if largest != k {
                let (above, below) = rows.split_at_mut(largest * width);
                above[k * width..(k + 1) * width].swap_with_slice(&mut below[..width]);
            }
            let pivot = rows[k * width + k];
            if pivot == 0.0 || !pivot.is_finite() {
                return false;
            }
            // Update the pivot's row beyond the panel by the panel's rows above it.
            let (above, below) = rows.split_at_mut(k * width);
            let (own, below) = below.split_at_mut(width);
            for q in first..k {
                let factor = own[q];
                for (t, s) in own[end..].iter_mut().zip(&above[q * width + end..(q + 1) * width]) {
                    *t -= factor * s;
                }
            }
            let inverse = 1.0 / pivot;
            for row in below[..(order - k - 1) * width].chunks_exact_mut(width) {
                row[k] *= inverse;
                for column in k + 1..end {
                    row[column] -= row[k] * own[column];
                }
            }
        }
        let (above, below) = rows.split_at_mut(end * width);
        for row in below[..(order - end) * width].chunks_exact_mut(width) {
            let (panel, rest) = row.split_at_mut(end);
            subtract_rows(rest, &panel[first..], &above[first * width..], width, end);
        }
        first = end;
    }
    // Back substitution: x_k = (b_k - sum U_kc x_c) / U_kk, right-hand sides only.
    for k in (0..order).rev() {
        let (above, below) = rows.split_at_mut((k + 1) * width);
        let (matrix, right) = above[k * width..].split_at_mut(order);
        subtract_rows(right, &matrix[k + 1..], below, width, order);
        let inverse = 1.0 / matrix[k];
        right.iter_mut().for_each(|value| *value *= inverse);
    }
    true
}

/// Computes `target` -= sum of `factors` times the rows of `rows`, from entry `skip` of each row on.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn subtract_products(target: &mut [f64], factors: &[f64], rows: &[f64], width: usize, skip: usize) {
    subtract_rows(target, factors, rows, width, skip);
}

/// Computes `target` += `factor` times `row`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn add_times(target: &mut [f64], factor: f64, row: &[f64]) {
    target.iter_mut().zip(row).for_each(|(target, value)| *target += factor * value);
}

/// Computes `target` = e . (a - b) from the rows of the x and z components of a and b.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn elongation(target: &mut [f64], e: [f64; 2], [ax, az]: [&[f64]; 2], [bx, bz]: [&[f64]; 2]) {
    let ends = ax.iter().zip(az).zip(bx.iter().zip(bz));
    for (target, ((ax, az), (bx, bz))) in target.iter_mut().zip(ends) {
        *target = e[0] * (ax - bx) + e[1] * (az - bz);
    }
}

/// Number of partial sums of a product, in a fixed order that does not depend on the vector width.
pub const LANES: usize = 8;

/// Sum of the partial sums `sums`, in a fixed order.
#[inline(always)]
pub fn total(sums: &[f64; LANES]) -> f64 {
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))
}

/// Scalar product of `a` and `b`, compiled for the vectors of its caller.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    total(&sums) + rest
}

#[inline(always)]
fn subtract_rows(target: &mut [f64], factors: &[f64], rows: &[f64], width: usize, skip: usize) {
    let length = target.len();
    let row = |number: usize| &rows[number * width + skip..][..length];
    let whole = factors.len() - factors.len() % BATCH;
    for number in (0..whole).step_by(BATCH) {
        let [f0, f1, f2, f3] = [0, 1, 2, 3].map(|at| factors[number + at]);
        let [r0, r1, r2, r3] = [0, 1, 2, 3].map(|at| row(number + at));
        for at in 0..length {
            target[at] -= (f0 * r0[at] + f1 * r1[at]) + (f2 * r2[at] + f3 * r3[at]);
        }
    }
    for (number, factor) in factors.iter().enumerate().skip(whole) {
        for (target, value) in target.iter_mut().zip(row(number)) {
            *target -= factor * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_the_equations_to_rounding() {
        for (order, right) in [(1, 1), (3, 2), (4, 4), (9, 1), (30, 7)] {
            let width = order + right;
            // Zero pivots on the diagonal require row exchanges.
            let entry = |r: usize, c: usize| {
                if r == c && r.is_multiple_of(3) && order > 1 { 0.0 } else { ((r * 31 + c * 17) as f64).sin() + 0.1 }
            };
            let matrix: Vec<f64> = (0..order * width).map(|at| entry(at / width, at % width)).collect();
            let mut solved = matrix.clone();
            assert!(solve_many(&mut solved, order, width));
            for (r, s) in (0..order).flat_map(|r| (0..right).map(move |s| (r, s))) {
                let sum: f64 = (0..order).map(|c| matrix[r * width + c] * solved[c * width + order + s]).sum();
                assert!((sum - matrix[r * width + order + s]).abs() < 1e-11, "{order} {r} {s}");
            }
        }
        assert!(!solve_many(&mut [1.0, 2.0, 1.0, 2.0, 4.0, 1.0], 2, 3));
    }
}
