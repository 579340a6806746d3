//! Steady sliding on a face with heights: unilateral contact of a cell of equal columns.
//!
//! Elimination ([`super::condensed`]) leaves the normal forces N of the m contacts over their friction T and the heights z
//! of what touches, and the face lies at the heights r:
//!
//! ```text
//! N = N_0 + A T(N) + K z,     N >= 0,     z >= r,     N (z - r) = 0,     T = mu_d f(p) N
//! ```
//!
//! Each contact is on the counterface, where z = r and N is sought, or off it, where N = 0 and z is. Newton's method on the
//! m unknowns, with the contacts on and off anew after each step, solves elasticity, friction and contact together: a
//! semismooth method, which ends after a few steps at the solution to rounding. Should it not, the contact that breaks its
//! condition most is moved alone. Heights are in units of P l^2 / k: a fixed relief weighs the less the larger the load.

use super::condensed::CondensedModel;
use super::dense::solve_many;
use super::newton::{friction_at, friction_slope};
use super::{Equilibrium, SteadyLoad, TOLERANCE, displacement_unit, unloaded};
use crate::lattice::Lattice;
use crate::outcome::{Status, SurfaceOutcome};

/// Steps in which every contact that breaks its condition moves.
const MOST_STEPS: usize = 40;
/// Steps for each contact in which only the worst one does.
const MOST_SINGLE_STEPS: usize = 4;
/// Halvings of a step that does not lessen the residual.
const MOST_HALVINGS: usize = 10;
/// A force over the mean one, or a gap over the largest height, that counts as none.
const ROUNDING: f64 = 1e-12;

/// A cell whose face has heights.
#[derive(Clone, Debug)]
pub struct RaisedModel {
    block_m: f64,
    youngs_modulus_pa: f64,
    /// N over friction and heights.
    condensed: CondensedModel,
    /// r of each contact, in lattice spacings.
    relief: Vec<f64>,
}

/// Which contacts are on the counterface, and the unknowns.
struct State {
    on: Vec<bool>,
    normal: Vec<f64>,
    height: Vec<f64>,
}

/// The conditions under one load.
struct Contacts<'a> {
    model: &'a CondensedModel,
    load: &'a SteadyLoad<'a>,
    /// r in units of P l^2 / k.
    relief: Vec<f64>,
    /// The largest difference of two of them, or of what the layer yields.
    height_scale: f64,
    force_scale: f64,
}

impl RaisedModel {
    /// The model of `lattice`, whose blocks are `block_m` apart; `None` where it is no ring of equal columns, where its
    /// cavities reach the uppermost row, or where the equations are singular.
    #[must_use]
    pub fn new(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64) -> Option<Self> {
        let condensed = CondensedModel::raised(lattice, block_m, youngs_modulus_pa)?;
        let relief = condensed.contacts().iter().map(|contact| lattice.columns()[contact.column].relief).collect();
        Some(Self { block_m, youngs_modulus_pa, condensed, relief })
    }

    /// Steady sliding under `load`. `on` says which contacts touch, in the order of contacts, where a neighbouring load has
    /// been solved, and does so for this one afterwards; empty before the first.
    #[must_use]
    pub fn solve(&self, load: &SteadyLoad, on: &mut Vec<bool>) -> SurfaceOutcome {
        let model = &self.condensed;
        if load.pressure_pa == 0.0 || model.contacts().is_empty() {
            return unloaded(model.contacts(), self.block_m);
        }
        let unit = displacement_unit(load.pressure_pa, self.youngs_modulus_pa);
        let relief: Vec<f64> = self.relief.iter().map(|r| r / unit).collect();
        let spread =
            relief.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| [low.min(*r), high.max(*r)]);
        let contacts = Contacts {
            model,
            load,
            height_scale: (spread[1] - spread[0]).max(1.0),
            force_scale: model.response().load / relief.len() as f64,
            relief,
        };
        let m = contacts.relief.len();
        let mut state = State { on: std::mem::take(on), normal: vec![0.0; m], height: contacts.relief.clone() };
        if state.on.len() != m {
            state.on = vec![true; m];
        }
        let (status, iterations, residual) = contacts.solve(&mut state);
        *on = state.on;
        let friction = (0..m).map(|c| friction_at(model.response(), load, c, state.normal[c])).collect();
        let equilibrium =
            Equilibrium { status, iterations, residual, friction, normal: state.normal, displacement: Vec::new() };
        model.observe_raised(load, &equilibrium, &state.height)
    }
}

impl Contacts<'_> {
    /// Solves from `state` on: status, steps and residual.
    fn solve(&self, state: &mut State) -> (Status, usize, f64) {
        let m = state.on.len();
        let mut residual = self.residual(state);
        let most = MOST_STEPS + MOST_SINGLE_STEPS * m;
        for step in 0..most {
            let Some(direction) = self.direction(state, &residual) else {
                return (Status::NotConverged, step, f64::NAN);
            };
            let before = size(&residual);
            self.advance(state, &direction, 1.0);
            let changed = self.switch(state, step >= MOST_STEPS);
            residual = self.residual(state);
            let after = size(&residual) / self.model.response().load;
            if !changed {
                if after <= TOLERANCE {
                    return (Status::Converged, step + 1, after);
                }
                // With the same contacts only the law is not linear: a step that leads away is shortened.
                let mut part = 1.0;
                for _ in 0..MOST_HALVINGS {
                    if size(&residual) < before {
                        break;
                    }
                    part *= 0.5;
                    self.advance(state, &direction, -part);
                    residual = self.residual(state);
                }
            }
        }
        (Status::NotConverged, most, size(&residual) / self.model.response().load)
    }

    /// N - N_0 - A T - K z.
    fn residual(&self, state: &State) -> Vec<f64> {
        let response = self.model.response();
        let m = state.on.len();
        let mut residual: Vec<f64> = state.normal.iter().zip(&response.at_rest).map(|(n, rest)| n - rest).collect();
        let (by_friction, by_height) = response.influence.split_at(m * m);
        for c in 0..m {
            let friction = friction_at(response, self.load, c, state.normal[c]);
            add(&mut residual, friction, &by_friction[c * m..][..m]);
            add(&mut residual, state.height[c], &by_height[c * m..][..m]);
        }
        residual
    }

    /// The step of Newton's method: of N where a contact is on, of z where it is off.
    fn direction(&self, state: &State, residual: &[f64]) -> Option<Vec<f64>> {
        let response = self.model.response();
        let m = state.on.len();
        let (by_friction, by_height) = response.influence.split_at(m * m);
        let width = m + 1;
        let mut equations = vec![0.0; m * width];
        for c in 0..m {
            let slope = friction_slope(response, self.load, c, state.normal[c]);
            let (column, scale) =
                if state.on[c] { (&by_friction[c * m..][..m], slope) } else { (&by_height[c * m..][..m], 1.0) };
            for (row, entry) in column.iter().enumerate() {
                equations[row * width + c] = scale * entry;
            }
            if state.on[c] {
                equations[c * width + c] += 1.0;
            }
        }
        for (row, residual) in equations.chunks_exact_mut(width).zip(residual) {
            row[m] = -residual;
        }
        solve_many(&mut equations, m, width).then(|| equations.chunks_exact(width).map(|row| row[m]).collect())
    }

    fn advance(&self, state: &mut State, direction: &[f64], part: f64) {
        for (c, by) in direction.iter().enumerate() {
            *(if state.on[c] { &mut state.normal[c] } else { &mut state.height[c] }) += part * by;
        }
    }

    /// Lifts contacts under tension and lands those below the face, or only the one that breaks its condition most; whether
    /// there was any.
    fn switch(&self, state: &mut State, single: bool) -> bool {
        let broken = |c: usize| {
            if state.on[c] {
                -state.normal[c] / self.force_scale
            } else {
                (self.relief[c] - state.height[c]) / self.height_scale
            }
        };
        let worst = (0..state.on.len()).map(|c| (c, broken(c))).filter(|(_, by)| *by > ROUNDING);
        let mut moved: Vec<(usize, f64)> = worst.collect();
        if single {
            moved = moved.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).into_iter().collect();
        }
        for (c, _) in &moved {
            state.on[*c] = !state.on[*c];
            state.normal[*c] = 0.0;
            state.height[*c] = self.relief[*c];
        }
        // What is left of tension is rounding.
        for (c, normal) in state.normal.iter_mut().enumerate() {
            if state.on[c] && !single {
                *normal = normal.max(0.0);
            }
        }
        !moved.is_empty()
    }
}

fn add(target: &mut [f64], factor: f64, values: &[f64]) {
    target.iter_mut().zip(values).for_each(|(target, value)| *target += factor * value);
}

fn size(residual: &[f64]) -> f64 {
    residual.iter().map(|value| value.abs()).sum()
}

#[cfg(test)]
mod tests;
