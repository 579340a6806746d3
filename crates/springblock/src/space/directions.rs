//! Generalized conjugate residuals whose search directions are kept (S. C. Eisenstat, H. C. Elman, M. H. Schultz,
//! SIAM J. Numer. Anal. 20, 345, 1983).
//!
//! For directions p_k with orthonormal images q_k = A p_k, the least residual over their span takes one
//! scalar product each: whatever was learnt of A for one right-hand side serves all later ones.

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
        // Twice is enough against rounding.
        for _ in 0..2 {
            for kept in &self.kept {
                let share = dot(&kept.image, &direction.image);
                subtract(&mut direction.image, share, &kept.image);
                subtract(&mut direction.step, share, &kept.step);
                subtract(&mut direction.normal, share, &kept.normal);
            }
        }
        let after = norm(&direction.image);
        if after.is_nan() || after <= DEPENDENT * before {
            return None;
        }
        for values in [&mut direction.image, &mut direction.step, &mut direction.normal] {
            values.iter_mut().for_each(|value| *value /= after);
        }
        self.kept.push(direction);
        self.kept.last()
    }
}

/// a . b in eight partial sums of fixed order: the same with any vector width.
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
