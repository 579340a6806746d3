//! An inverse of the compliance on the points that are free to move, K_AA^-1, that costs little.
//!
//! The pressure that a displacement asks for, K^-1 u, is the convolution Q with the transform of q/q1. Where the displacement of
//! the other points B is not given but their pressure, zero, it is that of the displacement for which they ask none:
//!
//! ```text
//! K_AA^-1  =  Q_AA - Q_AB Q_BB^-1 Q_BA
//! ```
//!
//! Q_AA alone is too stiff along every edge of the contact. Two steps of relaxation stand for Q_BB^-1:
//!
//! ```text
//! v = r on A, 0 on B;   twice on B: v = v - t (Q v);   z = (Q v) on A
//! ```
//!
//! that is t (2 - t Q_BB) in its place, which is never above Q_BB^-1, since 1 - t Q_BB (2 - t Q_BB) = (1 - t Q_BB)^2: z stays
//! symmetric and positive for any t. One step would not: a contact like a checkerboard makes it indefinite. Q falls as 1/r^3 with
//! the distance r and is taken on two grids. On rough maps of 512 x 512 and 1024 x 1024 points conjugate gradients take three
//! quarters of the iterations that they take with Q_AA.

use std::ops::Range;

use multiversion::multiversion;

use crate::two_grids::{Near, TwoGrids, TwoGridsWork};

/// t, over the value that Q has at a point.
const RELAXATION: f64 = 1.3;

/// The inverse for maps of one size.
#[derive(Clone, Debug)]
pub(crate) struct Preconditioner {
    stiffness: TwoGrids,
    relaxation: f32,
}

impl Preconditioner {
    /// For maps of `rows` x `cols` points whose waves of k along x and l along y have the stiffness `stiffness(k, l)`.
    pub(crate) fn new(rows: usize, cols: usize, stiffness: impl Fn(usize, usize) -> f64) -> Self {
        let stiffness = TwoGrids::new(rows, cols, Near::Kernel, stiffness);
        let relaxation = (RELAXATION / stiffness.centre()) as f32;
        Self { stiffness, relaxation }
    }

    /// Stiffness of a point that moves alone.
    pub(crate) fn centre(&self) -> f64 {
        self.stiffness.centre()
    }

    /// Buffers for one running preconditioner.
    pub(crate) fn work(&self) -> TwoGridsWork {
        self.stiffness.work()
    }

    /// z = `extended` on free points, where `residual` is not zero; elsewhere it means nothing. `fill` makes the residual in one range
    /// of points after the other, and `see` is shown what z is there, and the residual.
    pub(crate) fn apply(
        &self,
        residual: &mut [f32],
        extended: &mut [f32],
        work: &mut TwoGridsWork,
        mut fill: impl FnMut(Range<usize>, &mut [f32]),
        mut see: impl FnMut(Range<usize>, &[f32], &[f32]),
    ) {
        let Self { stiffness, relaxation } = self;
        stiffness.gather(extended, work, |points, extended| {
            let residual = &mut residual[points.clone()];
            fill(points, residual);
            extended.copy_from_slice(residual);
        });
        for _ in 0..2 {
            stiffness.apply(extended, work, |points, stiff, extended| {
                relax(stiff, extended, &residual[points], *relaxation);
            });
        }
        stiffness.apply(extended, work, |points, stiff, extended| {
            extended.copy_from_slice(stiff);
            see(points.clone(), stiff, &residual[points]);
        });
    }
}

/// v = r on free points, v - t (Q v) elsewhere, in place of both Q v and v.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn relax(stiff: &mut [f32], extended: &mut [f32], residual: &[f32], relaxation: f32) {
    for ((stiff, v), &r) in stiff.iter_mut().zip(extended).zip(residual) {
        *v = if r != 0.0 { r } else { *v - relaxation * *stiff };
        *stiff = *v;
    }
}

#[cfg(test)]
mod tests {
    use slipgrid_topography::fourier::Fourier;

    use super::*;
    use crate::kernels::dot;
    use crate::two_grids::tests::{stiffness, uneven};

    const SIDES: (usize, usize) = (48, 40);

    /// z for the residual r.
    fn solved(preconditioner: &Preconditioner, r: &[f32]) -> Vec<f32> {
        let (mut residual, mut z) = (vec![0.0; r.len()], vec![0.0; r.len()]);
        preconditioner.apply(
            &mut residual,
            &mut z,
            &mut preconditioner.work(),
            |points, residual| residual.copy_from_slice(&r[points]),
            |_, _, _| {},
        );
        z.iter().zip(r).map(|(&z, &r)| if r == 0.0 { 0.0 } else { z }).collect()
    }

    /// Is the point at row i and column j free?
    type Contact = fn(usize, usize) -> bool;

    fn contacts() -> [(&'static str, Contact); 6] {
        [
            ("all", |_, _| true),
            ("checkerboard", |i, j| (i + j) % 2 == 0),
            ("stripes", |i, _| i % 2 == 0),
            ("single points", |i, j| i % 6 == 1 && j % 5 == 2),
            ("disc", |i, j| (i as f64 - 20.0).hypot(j as f64 - 20.0) < 9.0),
            ("patches", |i, j| (i * i * 31 + 17 * j * j + 7 * i * j) % 101 < 40),
        ]
    }

    fn masked(values: &[f32], free: Contact) -> Vec<f32> {
        let at = |n: usize| free(n / SIDES.1, n % SIDES.1);
        values.iter().enumerate().map(|(n, &value)| if at(n) { value } else { 0.0 }).collect()
    }

    fn made() -> Preconditioner {
        Preconditioner::new(SIDES.0, SIDES.1, stiffness(SIDES, 1.0))
    }

    #[test]
    fn it_is_symmetric_on_every_contact() {
        let preconditioner = made();
        for (name, free) in contacts() {
            let [a, b] = [3, 11].map(|seed| masked(&uneven(SIDES.0 * SIDES.1, seed), free));
            let (of_a, of_b) = (solved(&preconditioner, &a), solved(&preconditioner, &b));
            let (left, right) = (dot(&a, &of_b), dot(&b, &of_a));
            let size = (dot(&a, &of_a) * dot(&b, &of_b)).sqrt();
            assert!((left - right).abs() < 1e-5 * size, "{name}: {left} and {right} of {size}");
        }
    }

    /// Whatever the contact, r.z stays above what K_AA^-1 would make of it; one step of relaxation makes it negative on a checkerboard.
    #[test]
    fn it_is_positive_on_every_contact() {
        let preconditioner = made();
        for (name, free) in contacts() {
            for field in [vec![1.0; SIDES.0 * SIDES.1], uneven(SIDES.0 * SIDES.1, 5)] {
                let r = masked(&field, free);
                assert!(dot(&r, &solved(&preconditioner, &r)) > 0.0, "{name}");
            }
        }
    }

    /// Of the pressures p on a contact, K p there and back: near p with the edges, far too stiff without.
    #[test]
    fn edges_of_the_contact_are_less_stiff_than_its_middle() {
        let preconditioner = made();
        let fourier = Fourier::<f32>::new(SIDES.0, SIDES.1);
        let stiff = stiffness(SIDES, 1.0);
        let filtered = |input: &[f32], factor: &dyn Fn(usize, usize) -> f64| {
            let mut output = input.to_vec();
            fourier.filter(input, &fourier.wave_multiplier(factor), &mut output, &mut fourier.work());
            output
        };
        let compliance = |k: usize, l: usize| if k == 0 && l == 0 { 2.0 } else { 1.0 / stiff(k, l) };
        for (name, free) in contacts().into_iter().skip(1) {
            let p = masked(&uneven(SIDES.0 * SIDES.1, 5), free);
            let u = masked(&filtered(&p, &compliance), free);
            // z.Kp over p.Kp, 1 for the inverse
            let share = |z: &[f32]| dot(z, &u) / dot(&p, &u);
            let (with, without) = (share(&solved(&preconditioner, &u)), share(&masked(&filtered(&u, &stiff), free)));
            assert!(with > 0.99 && with - 1.0 < 0.75 * (without - 1.0), "{name}: {with}, without edges {without}");
        }
    }
}
