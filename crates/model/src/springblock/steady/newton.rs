//! Newton's method for steady sliding, used if the fixed-point iteration does not converge, as for lands that tilt and
//! area laws that fall steeply.
//!
//! Normal forces N = N0 + A T are affine in the friction forces T, which are positive against sliding. The equations
//!
//! ```text
//! R(T) = T - g(N0 + A T) = 0,     g = mu_d f(p) max(N, 0)
//! ```
//!
//! are piecewise smooth; their Jacobian I - g' A uses the slope of the current piece. Steps are halved until |R|
//! decreases. A takes one solution of the elastic equations per contact, so the method is used only if the cheaper
//! iteration has failed.

use super::LinearResponse;
use super::SteadyLoad;
use super::dense::solve_many;

/// Maximum number of Newton steps.
const MAX_STEPS: usize = 60;
/// Maximum number of halvings of a step.
const MAX_HALVINGS: usize = 12;
/// Maximum number of contacts, beyond which the dense Jacobian becomes too expensive and the method is not tried.
pub const MAX_CONTACTS: usize = 1500;
/// Step of the finite difference for the derivative of friction by normal force, relative to the normal force; far
/// below the width of the steps of an area law.
const SLOPE_STEP: f64 = 1e-7;

/// Friction force on contact number `number` at the normal force `normal`, both in units of P l^2 (nominal pressure P,
/// lattice spacing l); 0 for a lifted contact.
pub fn friction_at(system: &impl LinearResponse, load: &SteadyLoad, number: usize, normal: f64) -> f64 {
    let contact = &system.contacts()[number];
    let normal = if contact.lifted { 0.0 } else { normal.max(0.0) };
    let factor = load.area_law.map_or(1.0, |law| law.factor(normal / contact.width * load.pressure_pa));
    // T = mu_d f(p) N
    load.dynamic_mu[contact.column] * factor * normal
}

/// Derivative of [`friction_at`] with respect to the normal force, one-sided from `normal` upward.
pub fn friction_slope(system: &impl LinearResponse, load: &SteadyLoad, number: usize, normal: f64) -> f64 {
    let ahead = normal + SLOPE_STEP * normal.abs().max(SLOPE_STEP);
    let at = |normal: f64| friction_at(system, load, number, normal);
    (at(ahead) - at(normal)) / (ahead - normal)
}

/// Improves the friction forces `friction` by Newton's method until the sum of the magnitudes of the residuals R,
/// divided by the load, is at most `tolerance`; leaves `friction` unchanged if this fails. Returns the number of Newton
/// steps.
pub fn improve(system: &impl LinearResponse, load: &SteadyLoad, friction: &mut Vec<f64>, tolerance: f64) -> usize {
    let n = friction.len();
    if n == 0 || n > MAX_CONTACTS {
        return 0;
    }
    let equations = Equations { system, load, influence: Influence::new(system, n), tolerance };
    let mut at = friction.clone();
    let (found, steps) = equations.solve(&mut at);
    if found {
        *friction = at;
    }
    steps
}

/// The equations R(T) = T - g(N0 + A T) = 0 of the friction forces T.
struct Equations<'a, S> {
    system: &'a S,
    load: &'a SteadyLoad<'a>,
    influence: Influence,
    tolerance: f64,
}

impl<S: LinearResponse> Equations<'_, S> {
    /// Returns the residuals R at the friction forces `friction` and the normal forces `normal`, and the sum of the
    /// magnitudes of the residuals, divided by the load.
    fn residual(&self, friction: &[f64], normal: &[f64]) -> (Vec<f64>, f64) {
        let of = |c: usize| friction[c] - friction_at(self.system, self.load, c, normal[c]);
        let r: Vec<f64> = (0..friction.len()).map(of).collect();
        let norm = r.iter().map(|r| r.abs()).sum::<f64>() / self.system.load();
        (r, norm)
    }

    /// Newton's step of the friction forces for the residuals `r`; `None` if the Jacobian is singular.
    fn direction(&self, r: &[f64], normal: &[f64]) -> Option<Vec<f64>> {
        // J = I - g' A, with -R as the last column
        let (n, width) = (r.len(), r.len() + 1);
        let mut equations = vec![0.0; n * width];
        for (row, (entries, influence)) in
            equations.chunks_exact_mut(width).zip(self.influence.matrix.chunks_exact(n)).enumerate()
        {
            let slope = friction_slope(self.system, self.load, row, normal[row]);
            for (entry, a) in entries.iter_mut().zip(influence) {
                *entry = -slope * a;
            }
            entries[row] += 1.0;
            entries[n] = -r[row];
        }
        solve_many(&mut equations, n, width).then(|| equations.chunks_exact(width).map(|row| row[n]).collect())
    }

    /// Runs Newton's method from the friction forces `at`, which it updates; returns whether it converged, and the
    /// number of steps.
    fn solve(&self, at: &mut Vec<f64>) -> (bool, usize) {
        let mut normal = self.influence.normal(at);
        let (mut r, mut norm) = self.residual(at, &normal);
        for step in 0..MAX_STEPS {
            if norm <= self.tolerance {
                return (true, step);
            }
            let Some(direction) = self.direction(&r, &normal) else { return (false, step) };
            let mut part = 1.0;
            for halving in 0..=MAX_HALVINGS {
                let trial: Vec<f64> = at.iter().zip(&direction).map(|(at, d)| at + part * d).collect();
                let trial_normal = self.influence.normal(&trial);
                let (trial_r, trial_norm) = self.residual(&trial, &trial_normal);
                // A step that does not decrease |R| at any length crosses a kink: the shortest one is taken.
                if trial_norm < norm || halving == MAX_HALVINGS {
                    (*at, normal, r, norm) = (trial, trial_normal, trial_r, trial_norm);
                    break;
                }
                part *= 0.5;
            }
        }
        (norm <= self.tolerance, MAX_STEPS)
    }
}

/// Normal forces N = N0 + A T as a function of the friction forces T: N0, and A by rows.
struct Influence {
    at_rest: Vec<f64>,
    matrix: Vec<f64>,
}

impl Influence {
    fn new(system: &impl LinearResponse, n: usize) -> Self {
        let mut displacement = vec![0.0; system.order()];
        let mut at_rest = vec![0.0; n];
        system.respond(&vec![0.0; n], &mut displacement, &mut at_rest);
        let mut matrix = vec![0.0; n * n];
        let (mut unit, mut normal) = (vec![0.0; n], vec![0.0; n]);
        for column in 0..n {
            unit[column] = 1.0;
            system.respond(&unit, &mut displacement, &mut normal);
            unit[column] = 0.0;
            for row in 0..n {
                matrix[row * n + column] = normal[row] - at_rest[row];
            }
        }
        Self { at_rest, matrix }
    }

    fn normal(&self, friction: &[f64]) -> Vec<f64> {
        let n = friction.len();
        let rows = self.matrix.chunks_exact(n);
        rows.zip(&self.at_rest)
            .map(|(row, rest)| rest + row.iter().zip(friction).map(|(a, t)| a * t).sum::<f64>())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::SteadyModel;
    use super::*;
    use crate::material::AreaLaw;
    use crate::springblock::tests::samples::{E_PA, groove};
    use crate::springblock::{Lattice, Status, columns};

    fn cell(width_um: f64, land_um: f64, depth_um: f64) -> SteadyModel {
        let columns = columns::cell(&groove(width_um, land_um, depth_um), 10e-6);
        SteadyModel::new(Lattice::new(columns, 20, true), 10e-6, E_PA, false)
    }

    /// Counts the equilibria of Amontons-Coulomb friction on `system`, one for each consistent set of loaded contacts,
    /// by trying all sets.
    fn equilibria(system: &impl LinearResponse, mu: f64) -> usize {
        let n = system.contacts().len();
        let influence = Influence::new(system, n);
        let consistent = |loaded: usize| {
            // N = N0 + mu A N on the loaded contacts; the others follow.
            let on = |c: usize| f64::from(u8::from(loaded >> c & 1 == 1));
            let entry = |row: usize, c: usize| match c == n {
                true => influence.at_rest[row],
                false => f64::from(u8::from(row == c)) - mu * influence.matrix[row * n + c] * on(c),
            };
            let mut rows: Vec<f64> = (0..n * (n + 1)).map(|at| entry(at / (n + 1), at % (n + 1))).collect();
            solve_many(&mut rows, n, n + 1) && (0..n).all(|c| (rows[c * (n + 1) + n] > 0.0) == (on(c) > 0.0))
        };
        (0..1 << n).filter(|&loaded| consistent(loaded)).count()
    }

    #[test]
    fn an_equilibrium_is_found_wherever_there_is_one() {
        for (land, depth) in [(40.0, 120.0), (40.0, 60.0), (60.0, 150.0), (80.0, 100.0)] {
            let model = cell(100.0, land, depth);
            for tenths in 1..16 {
                let mu = 0.1 * f64::from(tenths);
                let dynamic_mu = vec![mu; model.lattice().nx()];
                let load = SteadyLoad { pressure_pa: 1e6, dynamic_mu: &dynamic_mu, area_law: None };
                let status = model.solve(&load).status;
                let (count, found) = (equilibria(&model.system, mu), status == Status::Converged);
                assert!(count <= 1 && found == (count == 1), "{land} {depth} {mu}: {count} {status:?}");
            }
        }
    }

    #[test]
    fn steep_and_stepped_laws_are_solved() {
        let model = cell(60.0, 60.0, 50.0);
        let mut rescued = 0;
        for mu in [0.1, 0.27, 0.5, 0.7, 1.0] {
            for (width, after) in [(1e-1, 0.0), (1e-2, 0.3), (1e-3, 0.8), (1e-5, 0.0), (1e-5, 2.0)] {
                for at_pa in [0.5e6, 1.0e6, 1.5e6, 2.5e6] {
                    // f changes from 1 to `after` within the relative pressure interval `width`.
                    let law = AreaLaw::new(vec![at_pa, at_pa * (1.0 + width)], vec![1.0, after]).unwrap();
                    let dynamic_mu = vec![mu; model.lattice().nx()];
                    let load = SteadyLoad { pressure_pa: 1e6, dynamic_mu: &dynamic_mu, area_law: Some(&law) };
                    let outcome = model.solve(&load);
                    assert_ne!(outcome.status, Status::NotConverged, "{mu} {width} {after} {at_pa}");
                    rescued += usize::from(outcome.iterations > super::super::MAX_ITERATIONS);
                }
            }
        }
        assert!(rescued > 0, "Newton's method was not needed");
    }
}
