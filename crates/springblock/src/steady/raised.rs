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
//! condition most is moved alone. Where the solid yields at a pressure, a contact that would bear more bears that, at a height
//! z <= r below its own; it stays so flat for the loads that follow. Heights are in units of P l^2 / k: a fixed relief weighs the less the larger the load.

use super::condensed::CondensedModel;
use super::dense::solve_many;
use super::newton::{friction_at, friction_slope};
use super::{Equilibrium, SteadyLoad, TOLERANCE, displacement_unit, unloaded};
use slipgrid_material::Elastic;

use crate::lattice::Lattice;
use crate::outcome::{Status, SurfaceOutcome};

/// Steps in which every contact that breaks its condition moves.
const MAX_STEPS: usize = 40;
/// Steps for each contact in which only the worst one does.
const MAX_SINGLE_STEPS: usize = 4;
/// Halvings of a step that does not lessen the residual.
const MAX_HALVINGS: usize = 10;
/// A force over the mean one, or a gap over the largest height, that counts as none.
const ROUNDING: f64 = 1e-12;

/// A cell whose face has heights.
#[derive(Clone, Debug)]
pub struct RaisedModel {
    block_m: f64,
    elastic: Elastic,
    /// N over friction and heights.
    condensed: CondensedModel,
    /// r of each contact, in lattice spacings.
    relief: Vec<f64>,
}

/// How a contact meets the counterface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// It lies on it, at the height of its face.
    On,
    /// It is off it and bears nothing.
    Off,
    /// It lies on it, flattened, and bears the pressure at which it yields.
    Yielding,
}

/// What the loads so far have left of a face: which contacts touch, and their heights in lattice spacings. Empty before the
/// first.
#[derive(Clone, Debug, Default)]
pub struct FaceHistory {
    touch: Vec<Touch>,
    relief: Vec<f64>,
}

/// How each contact meets the counterface, and the unknowns.
struct State {
    touch: Vec<Touch>,
    normal: Vec<f64>,
    height: Vec<f64>,
}

/// The conditions under one load.
struct Contacts<'a> {
    model: &'a CondensedModel,
    load: &'a SteadyLoad<'a>,
    /// r in units of P l^2 / k.
    relief: Vec<f64>,
    /// Normal forces at which contacts yield, in units of P l^2.
    cap: Vec<f64>,
    /// The largest difference of two of them, or of what the layer yields.
    height_scale: f64,
    force_scale: f64,
}

impl RaisedModel {
    /// The model of `lattice`, whose blocks are `block_m` apart; `None` where it is no ring of equal columns, where its
    /// cavities reach the uppermost row, or where the equations are singular.
    #[must_use]
    pub fn new(lattice: &Lattice, block_m: f64, elastic: Elastic) -> Option<Self> {
        let condensed = CondensedModel::raised(lattice, block_m, elastic.youngs_modulus_pa())?;
        let relief = condensed.contacts().iter().map(|contact| lattice.columns()[contact.column].relief).collect();
        Some(Self { block_m, elastic, condensed, relief })
    }

    /// Steady sliding under `load` on what the loads before have left of the face.
    #[must_use]
    pub fn solve(&self, load: &SteadyLoad, history: &mut FaceHistory) -> SurfaceOutcome {
        let model = &self.condensed;
        if load.pressure_pa == 0.0 || model.contacts().is_empty() {
            return unloaded(model.contacts(), self.block_m);
        }
        let m = self.relief.len();
        if history.relief.len() != m {
            *history = FaceHistory { touch: vec![Touch::On; m], relief: self.relief.clone() };
        }
        let unit = displacement_unit(load.pressure_pa, self.elastic.youngs_modulus_pa());
        let relief: Vec<f64> = history.relief.iter().map(|r| r / unit).collect();
        // N = p w, forces in units of P l^2
        let cap = |width: f64| self.elastic.yield_pressure_pa().map_or(f64::INFINITY, |p| p / load.pressure_pa * width);
        let spread =
            relief.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| [low.min(*r), high.max(*r)]);
        let contacts = Contacts {
            model,
            load,
            height_scale: (spread[1] - spread[0]).max(1.0),
            force_scale: model.response().load / relief.len() as f64,
            cap: model.contacts().iter().map(|contact| cap(contact.width)).collect(),
            relief,
        };
        let touch = std::mem::take(&mut history.touch);
        let mut state = State { touch, normal: vec![0.0; m], height: contacts.relief.clone() };
        let (status, iterations, residual) = contacts.solve(&mut state);
        // What is no solution leaves the face as it was.
        if status == Status::Converged {
            for (c, touch) in state.touch.iter_mut().enumerate().filter(|(_, touch)| **touch == Touch::Yielding) {
                // What has yielded is as high as it was pressed, and elastic from there on.
                history.relief[c] = state.height[c] * unit;
                *touch = Touch::On;
            }
            history.touch = state.touch;
        } else {
            history.touch = vec![Touch::On; m];
        }
        let friction = (0..m).map(|c| friction_at(model.response(), load, c, state.normal[c])).collect();
        let equilibrium =
            Equilibrium { status, iterations, residual, friction, normal: state.normal, displacement: Vec::new() };
        model.observe_raised(load, &equilibrium, &state.height)
    }
}

impl Contacts<'_> {
    /// Solves from `state` on: status, steps and residual.
    fn solve(&self, state: &mut State) -> (Status, usize, f64) {
        let m = state.touch.len();
        let mut residual = self.residual(state);
        let most = MAX_STEPS + MAX_SINGLE_STEPS * m;
        for step in 0..most {
            let Some(direction) = self.direction(state, &residual) else {
                return (Status::NotConverged, step, f64::NAN);
            };
            let before = size(&residual);
            self.advance(state, &direction, 1.0);
            let changed = self.switch(state, step >= MAX_STEPS);
            residual = self.residual(state);
            let after = size(&residual) / self.model.response().load;
            if !changed {
                if after <= TOLERANCE {
                    return (Status::Converged, step + 1, after);
                }
                // With the same contacts only the law is not linear: a step that leads away is shortened.
                let mut part = 1.0;
                for _ in 0..MAX_HALVINGS {
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
        let m = state.touch.len();
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
        let m = state.touch.len();
        let (by_friction, by_height) = response.influence.split_at(m * m);
        let width = m + 1;
        let mut equations = vec![0.0; m * width];
        for c in 0..m {
            let slope = friction_slope(response, self.load, c, state.normal[c]);
            let is_on = state.touch[c] == Touch::On;
            let (column, scale) =
                if is_on { (&by_friction[c * m..][..m], slope) } else { (&by_height[c * m..][..m], 1.0) };
            for (row, entry) in column.iter().enumerate() {
                equations[row * width + c] = scale * entry;
            }
            if is_on {
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
            let is_on = state.touch[c] == Touch::On;
            *(if is_on { &mut state.normal[c] } else { &mut state.height[c] }) += part * by;
        }
    }

    /// Lifts contacts under tension, lands those below the face, lets those yield that bear too much, and makes those elastic
    /// that stand above their face; or only the one that breaks its condition most. Whether there was any.
    fn switch(&self, state: &mut State, single: bool) -> bool {
        // How far the condition is broken, and how the contact goes on then.
        let broken = |c: usize| {
            let below = (self.relief[c] - state.height[c]) / self.height_scale;
            let beyond = (state.normal[c] - self.cap[c]) / self.force_scale;
            match state.touch[c] {
                Touch::On if beyond > 0.0 => (beyond, Touch::Yielding),
                Touch::On => (-state.normal[c] / self.force_scale, Touch::Off),
                Touch::Off => (below, Touch::On),
                Touch::Yielding => (-below, Touch::On),
            }
        };
        let mut moved: Vec<(usize, (f64, Touch))> =
            (0..state.touch.len()).map(|c| (c, broken(c))).filter(|(_, (by, _))| *by > ROUNDING).collect();
        if single {
            moved = moved.into_iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0)).into_iter().collect();
        }
        for (c, (_, touch)) in &moved {
            state.touch[*c] = *touch;
            state.height[*c] = self.relief[*c];
            state.normal[*c] = if *touch == Touch::Yielding { self.cap[*c] } else { 0.0 };
        }
        // What is left of tension is rounding.
        for (c, normal) in state.normal.iter_mut().enumerate() {
            if state.touch[c] == Touch::On && !single {
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
