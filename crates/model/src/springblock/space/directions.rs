//! Generalized conjugate residuals with stored search directions (S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J.
//! Numer. Anal. 20, 345, 1983).
//!
//! The images of the directions p_k under the operator A are A p_k = sum_i R_ik q_i with orthonormal q_i and an upper
//! triangle R. Minimizing the residual r over the span of all directions takes one scalar product for each direction;
//! the corresponding step of the unknowns x takes one solution with R:
//!
//! ```text
//! c_i = q_i.r,     r <- r - sum c_i q_i,     R y = c,     x <- x + sum y_k p_k
//! ```
//!
//! The information on A from one right-hand side serves all later ones. Only images are orthogonalized: directions, and
//! other quantities linear in them, are stored as they are and combined once at the end.

use multiversion::multiversion;

use crate::springblock::steady::dense::{self, LANES, total};

/// Search directions of a linear operator, their images, and the normal forces that depend on them linearly.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    /// Search directions p, scaled such that the image of each had unit length before orthogonalization.
    steps: Vec<Vec<f64>>,
    /// Normal forces on the contacts due to each of the scaled search directions.
    normals: Vec<Vec<f64>>,
    /// Orthonormalized images q of the search directions.
    images: Vec<Vec<f64>>,
    /// Columns of the upper triangle R, which gives the images A p_k = sum_i R_ik q_i.
    factor: Vec<Vec<f64>>,
}

/// One search direction.
#[derive(Clone, Debug)]
pub struct Direction {
    /// Step p of the unknowns.
    pub step: Vec<f64>,
    /// Image A p of the step under the linear operator A.
    pub image: Vec<f64>,
    /// Normal forces due to the step.
    pub normal: Vec<f64>,
}

/// An image that retains no more than this fraction of its length after orthogonalization counts as linearly dependent.
const DEPENDENCE_TOLERANCE: f64 = 1e-13;
/// Minimum fraction of its length that an image must retain in one pass of orthogonalization to be orthogonal to 1e-14
/// after it; otherwise a second pass follows.
const MIN_RETAINED_SHARE: f64 = 0.1;
/// Number of vectors subtracted in one pass, which reads the target vector once.
const BATCH: usize = 4;

impl Directions {
    pub const fn count(&self) -> usize {
        self.images.len()
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds `direction`; returns false, without adding, if the image is linearly dependent on the stored images.
    pub fn add(&mut self, mut direction: Direction) -> bool {
        let before = norm(&direction.image);
        let mut shares = self.project_out(&mut direction.image);
        let mut after = norm(&direction.image);
        // The rest of an image that lost most of its length contains rounding errors; a second pass is enough.
        if after < MIN_RETAINED_SHARE * before {
            let more = self.project_out(&mut direction.image);
            shares.iter_mut().zip(more).for_each(|(share, more)| *share += more);
            after = norm(&direction.image);
        }
        if after.is_nan() || after <= DEPENDENCE_TOLERANCE * before {
            return false;
        }
        shares.push(after);
        for (values, length) in [
            (&mut direction.image, after),
            (&mut direction.step, before),
            (&mut direction.normal, before),
            (&mut shares, before),
        ] {
            values.iter_mut().for_each(|value| *value /= length);
        }
        self.steps.push(direction.step);
        self.normals.push(direction.normal);
        self.images.push(direction.image);
        self.factor.push(shares);
        true
    }

    /// Subtracts from `values` its projection on each image; returns the coefficient of each image.
    pub fn project_out(&self, values: &mut [f64]) -> Vec<f64> {
        let mut shares = Vec::with_capacity(self.images.len());
        for images in self.images.chunks(BATCH) {
            if let [p, q, r, s] = images {
                let of = dot_four([p, q, r, s], values);
                subtract_four(values, of, [p, q, r, s]);
                shares.extend(of);
            } else {
                for image in images {
                    let share = dot(image, values);
                    subtract(values, share, image);
                    shares.push(share);
                }
            }
        }
        shares
    }

    /// Like [`Self::project_out`] for the last direction only; `None` if there is none.
    pub fn project_out_last(&self, values: &mut [f64]) -> Option<f64> {
        let image = self.images.last()?;
        let share = dot(image, values);
        subtract(values, share, image);
        Some(share)
    }

    /// Adds to `unknowns` the step whose image is the sum of `shares[n]` times stored image n, and to `normal` the
    /// normal forces due to this step.
    pub fn advance(&self, shares: &[f64], unknowns: &mut [f64], normal: &mut [f64]) {
        // R y = c
        let mut y = shares.to_vec();
        for column in (0..y.len()).rev() {
            y[column] /= self.factor[column][column];
            let value = y[column];
            for (above, entry) in y[..column].iter_mut().zip(&self.factor[column]) {
                *above -= value * entry;
            }
        }
        for (values, each) in [(unknowns, &self.steps), (normal, &self.normals)] {
            for (y, each) in y.chunks(BATCH).zip(each.chunks(BATCH)) {
                if let ([a, b, c, d], [p, q, r, s]) = (y, each) {
                    subtract_four(values, [-a, -b, -c, -d], [p, q, r, s]);
                } else {
                    for (y, each) in y.iter().zip(each) {
                        subtract(values, -y, each);
                    }
                }
            }
        }
    }
}

/// Subtracts `shares[n]` times `b[n]` from `a` for each n, in this order.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn subtract_four(a: &mut [f64], shares: [f64; BATCH], b: [&[f64]; BATCH]) {
    let [p, q, r, s] = b;
    for ((((a, p), q), r), s) in a.iter_mut().zip(p).zip(q).zip(r).zip(s) {
        *a = *a - shares[0] * p - shares[1] * q - shares[2] * r - shares[3] * s;
    }
}

/// Scalar product of each of `a` with `b`, identical to that of [`dot`].
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn dot_four(a: [&[f64]; BATCH], b: &[f64]) -> [f64; BATCH] {
    let mut sums = [[0.0; LANES]; BATCH];
    let (chunks, rest) = b.as_chunks::<LANES>();
    let of = a.map(|a| a.as_chunks::<LANES>());
    for (place, b) in chunks.iter().enumerate() {
        for (sums, (chunks, _)) in sums.iter_mut().zip(&of) {
            let a = &chunks[place];
            for lane in 0..LANES {
                sums[lane] += a[lane] * b[lane];
            }
        }
    }
    std::array::from_fn(|number| {
        let sums = &sums[number];
        let rest: f64 = of[number].1.iter().zip(rest).map(|(a, b)| a * b).sum();
        total(sums) + rest
    })
}

/// Scalar product of `a` and `b`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    dense::dot(a, b)
}

/// Euclidean norm of `a`.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Subtracts `share` times `b` from `a`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn subtract(a: &mut [f64], share: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= share * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_right_hand_side_needs_no_new_direction_in_a_space_already_spanned() {
        // More unknowns than are processed in one pass, so that every branch runs.
        let count = 7;
        let apply = |x: &[f64]| -> Vec<f64> {
            (0..count).map(|i| (2.0 + i as f64) * x[i] - x[(i + 1) % count] + 0.3 * x[(i + 3) % count]).collect()
        };
        let mut directions = Directions::default();
        for axis in 0..count {
            let mut step = vec![0.1; count];
            step[axis] = 1.0;
            let image = apply(&step);
            assert!(directions.add(Direction { normal: vec![step[0], 2.0 * step[1]], step, image }));
        }
        let step: Vec<f64> = (0..count).map(|i| (i as f64).sin()).collect();
        let image = apply(&step);
        assert!(!directions.add(Direction { step, image, normal: Vec::new() }));
        for seed in [1.0, 2.7] {
            let right: Vec<f64> = (0..count).map(|i| (seed * i as f64).cos()).collect();
            let (mut x, mut normal, mut residual) = (vec![0.0; count], vec![0.0; 2], right.clone());
            let shares = directions.project_out(&mut residual);
            directions.advance(&shares, &mut x, &mut normal);
            let found = apply(&x);
            assert!(found.iter().zip(&right).all(|(found, right)| (found - right).abs() < 1e-14), "{found:?}");
            assert!(norm(&residual) < 1e-14);
            // Quantities linear in the directions follow them.
            assert!((normal[0] - x[0]).abs() < 1e-14 && (normal[1] - 2.0 * x[1]).abs() < 1e-14);
        }
    }
}
