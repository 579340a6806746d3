//! Generalized conjugate residuals whose search directions are kept (S. C. Eisenstat, H. C. Elman, M. H. Schultz,
//! SIAM J. Numer. Anal. 20, 345, 1983).
//!
//! For directions p_k with orthonormal images q_k = A p_k, the least residual over their span takes one
//! scalar product each: whatever was learnt of A for one right-hand side serves all later ones.

use multiversion::multiversion;

/// Search directions of a linear operator, their images, and what else is linear in them.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    kept: Vec<Direction>,
}

/// One direction.
#[derive(Clone, Debug)]
pub struct Direction {
    /// p.
    pub step: Vec<f64>,
    /// A p, of unit length.
    pub image: Vec<f64>,
    /// Normal forces that p makes.
    pub normal: Vec<f64>,
}

/// An image that loses all but this share of its length against the others adds only rounding.
const DEPENDENT: f64 = 1e-13;
/// Share of its length that an image must keep for one pass against the others to leave it orthogonal to 1e-14.
const ENOUGH: f64 = 0.1;
/// Directions that are taken off another at a time.
const AT_ONCE: usize = 4;

impl Directions {
    /// Directions kept.
    #[must_use]
    pub fn all(&self) -> &[Direction] {
        &self.kept
    }

    /// Forgets all directions.
    pub fn clear(&mut self) {
        self.kept.clear();
    }

    /// Adds `direction`, its image of any length; `None` if that depends on those of the others.
    pub fn add(&mut self, mut direction: Direction) -> Option<&Direction> {
        let before = norm(&direction.image);
        let mut shares = vec![0.0; self.kept.len()];
        let mut after = self.orthogonalize(&mut direction.image, &mut shares);
        // What is left of an image that lost most of its length is rounding in part; twice is enough.
        if after < ENOUGH * before {
            after = self.orthogonalize(&mut direction.image, &mut shares);
        }
        if after.is_nan() || after <= DEPENDENT * before {
            return None;
        }
        // The step and its normal forces follow their image, several directions at a time.
        for (kept, shares) in self.kept.chunks(AT_ONCE).zip(shares.chunks(AT_ONCE)) {
            subtract_all(&mut direction.step, shares, kept, |kept| &kept.step);
            subtract_all(&mut direction.normal, shares, kept, |kept| &kept.normal);
        }
        for values in [&mut direction.image, &mut direction.step, &mut direction.normal] {
            values.iter_mut().for_each(|value| *value /= after);
        }
        self.kept.push(direction);
        self.kept.last()
    }

    /// Takes from `image` what it has of the others' images, adds their shares to `shares`, and returns the length left.
    fn orthogonalize(&self, image: &mut [f64], shares: &mut [f64]) -> f64 {
        for (kept, of_kept) in self.kept.iter().zip(shares) {
            let share = dot(&kept.image, image);
            subtract(image, share, &kept.image);
            *of_kept += share;
        }
        norm(image)
    }
}

/// `values` less the `shares` of what `part` takes of each of at most [`AT_ONCE`] directions.
fn subtract_all(values: &mut [f64], shares: &[f64], kept: &[Direction], part: fn(&Direction) -> &Vec<f64>) {
    if let ([a, b, c, d], [p, q, r, s]) = (shares, kept) {
        subtract_four(values, [*a, *b, *c, *d], [p, q, r, s].map(|kept| &part(kept)[..]));
    } else {
        for (share, kept) in shares.iter().zip(kept) {
            subtract(values, *share, part(kept));
        }
    }
}

/// a -= sum of shares b, in the order of the shares.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn subtract_four(a: &mut [f64], shares: [f64; AT_ONCE], b: [&[f64]; AT_ONCE]) {
    let [p, q, r, s] = b;
    for ((((a, p), q), r), s) in a.iter_mut().zip(p).zip(q).zip(r).zip(s) {
        *a = *a - shares[0] * p - shares[1] * q - shares[2] * r - shares[3] * s;
    }
}

/// a . b in eight partial sums of fixed order: the same with any vector width.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7])) + rest
}

/// |a|.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// a -= share b.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub fn subtract(a: &mut [f64], share: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= share * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_right_hand_side_needs_no_new_direction_in_a_space_already_spanned() {
        let apply = |x: &[f64]| vec![2.0 * x[0] + x[1], 3.0 * x[1] - x[2], x[2] + 0.5 * x[0]];
        let mut directions = Directions::default();
        for axis in 0..3 {
            let mut step = vec![0.1; 3];
            step[axis] = 1.0;
            let image = apply(&step);
            assert!(directions.add(Direction { step, image, normal: Vec::new() }).is_some());
        }
        let step = vec![0.3, -1.0, 2.0];
        let image = apply(&step);
        assert!(directions.add(Direction { step, image, normal: Vec::new() }).is_none());
        for right in [[1.0, 0.0, 0.0], [0.2, -4.0, 1.0]] {
            let (mut x, mut residual) = (vec![0.0; 3], right.to_vec());
            for direction in directions.all() {
                let share = dot(&direction.image, &residual);
                subtract(&mut x, -share, &direction.step);
                subtract(&mut residual, share, &direction.image);
            }
            let found = apply(&x);
            assert!((0..3).all(|c| (found[c] - right[c]).abs() < 1e-14), "{found:?}");
        }
    }
}
