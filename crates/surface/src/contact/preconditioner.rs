//! A cheap approximation of K_AA^-1, the inverse of the compliance restricted to the free points A.
//!
//! The pressure that causes the displacement u, K^-1 u, is the convolution Q with the transform q/q1. At the other
//! points B the pressure, zero, is given instead of the displacement. Eliminating the displacements of B, where no
//! pressure acts, gives
//!
//! ```text
//! K_AA^-1  =  Q_AA - Q_AB Q_BB^-1 Q_BA
//! ```
//!
//! Q_AA alone is too stiff along every edge of the contact. Two steps of relaxation approximate Q_BB^-1:
//!
//! ```text
//! v = r on A, 0 on B;   twice on B: v = v - t (Q v);   z = (Q v) on A
//! ```
//!
//! They replace Q_BB^-1 by t (2 - t Q_BB), which never exceeds Q_BB^-1, since 1 - t Q_BB (2 - t Q_BB) = (1 - t Q_BB)^2.
//! Therefore z remains symmetric and positive for any t. One step would not suffice: on a checkerboard contact it is
//! indefinite. Q falls as 1/r^3 with the distance r and is approximated on two grids. On rough maps of 512 x 512 and
//! 1024 x 1024 points conjugate gradients take three quarters of the iterations that they take with Q_AA.

use std::ops::Range;

use multiversion::multiversion;

use crate::contact::two_grids::{Near, TwoGrids, TwoGridsWork};

/// Relaxation factor t in units of 1/Q(0), where Q(0) is the convolution kernel Q at its centre.
const RELAXATION: f64 = 1.3;

/// Approximate inverse of the compliance on the free points of maps of one size.
#[derive(Clone, Debug)]
pub(crate) struct Preconditioner {
    stiffness: TwoGrids,
    relaxation: f32,
}

impl Preconditioner {
    /// Creates the preconditioner for maps of `rows` x `cols` points, where `stiffness(k, l)` is the stiffness of the
    /// wave with k periods along x and l along y.
    pub(crate) fn new(rows: usize, cols: usize, stiffness: impl Fn(usize, usize) -> f64) -> Self {
        let stiffness = TwoGrids::new(rows, cols, Near::Kernel, stiffness);
        let relaxation = (RELAXATION / stiffness.centre()) as f32;
        Self { stiffness, relaxation }
    }

    /// Pressure on a single point that moves alone, over its displacement, in normalized units.
    pub(crate) fn centre(&self) -> f64 {
        self.stiffness.centre()
    }

    /// Allocates the buffers that each concurrent use of the preconditioner needs.
    pub(crate) fn work(&self) -> TwoGridsWork {
        self.stiffness.work()
    }

    /// Computes the preconditioned residual z into `extended`; only the values on free points, where `residual` is not
    /// zero, are meaningful.
    ///
    /// `fill` writes the residual, one range of points after the other. `inspect` receives each finished range of
    /// points with z and the residual there.
    pub(crate) fn apply(
        &self,
        residual: &mut [f32],
        extended: &mut [f32],
        work: &mut TwoGridsWork,
        mut fill: impl FnMut(Range<usize>, &mut [f32]),
        mut inspect: impl FnMut(Range<usize>, &[f32], &[f32]),
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
            inspect(points.clone(), stiff, &residual[points]);
        });
    }
}

/// Sets `extended`, v, to the residual r on free points and to v - t (Q v) elsewhere, and overwrites `stiff`, Q v, with
/// the new v.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn relax(stiff: &mut [f32], extended: &mut [f32], residual: &[f32], relaxation: f32) {
    for ((stiff, v), &r) in stiff.iter_mut().zip(extended).zip(residual) {
        *v = if r != 0.0 { r } else { *v - relaxation * *stiff };
        *stiff = *v;
    }
}

#[cfg(test)]
mod tests {
    use crate::topography::fourier::Fourier;

    use super::*;
    use crate::contact::kernels::dot;
    use crate::contact::two_grids::tests::{stiffness, uneven};

    const SIDES: (usize, usize) = (48, 40);

    /// Returns z for the residual r.
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

    /// Tells whether the point at row i and column j is free.
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

    fn preconditioner() -> Preconditioner {
        Preconditioner::new(SIDES.0, SIDES.1, stiffness(SIDES, 1.0))
    }

    #[test]
    fn it_is_symmetric_on_every_contact() {
        let preconditioner = preconditioner();
        for (name, free) in contacts() {
            let [a, b] = [3, 11].map(|seed| masked(&uneven(SIDES.0 * SIDES.1, seed), free));
            let (of_a, of_b) = (solved(&preconditioner, &a), solved(&preconditioner, &b));
            let (left, right) = (dot(&a, &of_b), dot(&b, &of_a));
            let size = (dot(&a, &of_a) * dot(&b, &of_b)).sqrt();
            assert!((left - right).abs() < 1e-5 * size, "{name}: {left} and {right} of {size}");
        }
    }

    /// On any contact r.z stays positive; with one step of relaxation it is negative on a checkerboard.
    #[test]
    fn it_is_positive_on_every_contact() {
        let preconditioner = preconditioner();
        for (name, free) in contacts() {
            for field in [vec![1.0; SIDES.0 * SIDES.1], uneven(SIDES.0 * SIDES.1, 5)] {
                let r = masked(&field, free);
                assert!(dot(&r, &solved(&preconditioner, &r)) > 0.0, "{name}");
            }
        }
    }

    /// Applies K and the preconditioner to the pressures p of a contact: the result is near p with the edge terms, and
    /// far too stiff without.
    #[test]
    fn edges_of_the_contact_are_less_stiff_than_its_middle() {
        let preconditioner = preconditioner();
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
            // z.Kp over p.Kp, which is 1 for the exact inverse.
            let share = |z: &[f32]| dot(z, &u) / dot(&p, &u);
            let (with, without) = (share(&solved(&preconditioner, &u)), share(&masked(&filtered(&u, &stiff), free)));
            assert!(with > 0.99 && with - 1.0 < 0.75 * (without - 1.0), "{name}: {with}, without edges {without}");
        }
    }
}
