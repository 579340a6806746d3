//! Stability limit of the time step, from the largest eigenfrequency of the lattice.

use super::bonds::Bonds;
use crate::springblock::{Lattice, Springs};

/// Number of steps of the Lanczos recursion. The largest eigenvalue, which free edges separate well from the others, is
/// found to better than 1e-4.
const LANCZOS_STEPS: usize = 80;

/// Largest angular eigenfrequency of the lattice in units of sqrt(k/m), with spring stiffness k and block mass m.
/// Blocks on the counterface move vertically only if `liftoff`.
pub fn largest_frequency(lattice: &Lattice, liftoff: bool) -> f64 {
    let mut bonds = Bonds::new(lattice, Springs::Linear);
    let root: Vec<f64> = bonds.inverse_mass().iter().map(|inverse| inverse.sqrt()).collect();
    let blocks = root.len();
    let mut weight: Vec<f64> = root.iter().chain(&root).copied().collect();
    if !liftoff {
        for i in lattice.contacts() {
            weight[blocks + i] = 0.0;
        }
    }
    let mut u = [vec![0.0; blocks], vec![0.0; blocks]];
    largest_eigenfrequency(&weight, |displacement, force| {
        for (u, displacement) in u.iter_mut().zip(displacement.chunks_exact(blocks)) {
            u.copy_from_slice(displacement);
        }
        bonds.evaluate(&u, 0.0, 0.0);
        for (force, own) in force.chunks_exact_mut(blocks).zip(bonds.forces()) {
            force.copy_from_slice(own);
        }
    })
}

/// Largest angular eigenfrequency of a system of masses and springs. `weight` is 1 over the square root of the mass of
/// each unknown, or 0 for removed blocks and pinned directions; `forces` computes the spring forces at given
/// displacements. Units: k = 1, m = 1.
///
/// Lanczos recursion on M^-1/2 K M^-1/2 with mass matrix M and stiffness matrix K; the largest eigenvalue of the
/// resulting tridiagonal matrix is found by bisection on Sturm counts.
pub fn largest_eigenfrequency(weight: &[f64], mut forces: impl FnMut(&[f64], &mut [f64])) -> f64 {
    let unknowns = weight.len();
    // A fixed start vector without symmetry has a component along every mode.
    let mut q: Vec<f64> = (0..unknowns)
        .map(|n| if weight[n] > 0.0 { (n as f64 * 2.399_963).sin() + if n % 2 == 0 { 1.0 } else { -1.0 } } else { 0.0 })
        .collect();
    scale_to_unit(&mut q);
    let mut previous = vec![0.0; unknowns];
    let (mut diagonal, mut off_diagonal): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut u, mut force) = (vec![0.0; unknowns], vec![0.0; unknowns]);
    for _ in 0..LANCZOS_STEPS.min(unknowns) {
        for ((u, weight), q) in u.iter_mut().zip(weight).zip(&q) {
            *u = weight * q;
        }
        forces(&u, &mut force);
        // w = M^-1/2 K M^-1/2 q - beta q_previous
        let beta = off_diagonal.last().copied().unwrap_or(0.0);
        let mut w: Vec<f64> = (0..unknowns).map(|n| -weight[n] * force[n] - beta * previous[n]).collect();
        let alpha: f64 = w.iter().zip(&q).map(|(w, q)| w * q).sum();
        for (w, q) in w.iter_mut().zip(&q) {
            *w -= alpha * q;
        }
        diagonal.push(alpha);
        let norm = scale_to_unit(&mut w);
        if norm <= 1e-12 {
            break;
        }
        off_diagonal.push(norm);
        previous = std::mem::replace(&mut q, w);
    }
    largest_eigenvalue(&diagonal, &off_diagonal).max(0.0).sqrt()
}

fn scale_to_unit(vector: &mut [f64]) -> f64 {
    let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    if norm > 0.0 {
        for v in vector.iter_mut() {
            *v /= norm;
        }
    }
    norm
}

/// Largest eigenvalue of a symmetric tridiagonal matrix by bisection.
fn largest_eigenvalue(diagonal: &[f64], off_diagonal: &[f64]) -> f64 {
    let bound = |i: usize| {
        let left = if i > 0 { off_diagonal[i - 1].abs() } else { 0.0 };
        let right = if i + 1 < diagonal.len() { off_diagonal[i].abs() } else { 0.0 };
        diagonal[i].abs() + left + right
    };
    let mut high = (0..diagonal.len()).map(bound).fold(0.0, f64::max);
    let mut low = -high;
    // All eigenvalues are below x if all pivots of T - x are negative.
    let all_below = |x: f64| {
        let mut pivot = 1.0;
        (0..diagonal.len()).all(|i| {
            let coupling = if i > 0 { off_diagonal[i - 1] * off_diagonal[i - 1] } else { 0.0 };
            pivot = diagonal[i] - x - coupling / pivot;
            pivot < 0.0
        })
    };
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if all_below(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Pattern, Planform};
    use crate::springblock::columns::{cell, flat};

    #[test]
    fn edge_masses_raise_the_largest_frequency_above_the_bulk_one() {
        let free = largest_frequency(&Lattice::new(flat(60), 20, false), false);
        assert!((free - 3.022).abs() < 2e-3, "{free}");
        // Stability limits of the published polymer: leapfrog 11.76 ns, Runge-Kutta 16.6 ns.
        assert!((2.0 / free / 5.6273e7 / 11.76e-9 - 1.0).abs() < 1e-3);
        assert!((8.0_f64.sqrt() / free / 5.6273e7 / 16.6e-9 - 1.0).abs() < 3e-3);
        let pattern = Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6).unwrap();
        let patterned = largest_frequency(&Lattice::new(cell(&pattern, 10e-6), 20, true), false);
        assert!(patterned > 6.0_f64.sqrt() && patterned < 3.1, "{patterned}");
    }
}
