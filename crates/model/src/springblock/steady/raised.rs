//! Steady sliding on a face with height variations: unilateral contact of a cell of equal columns.
//!
//! Elimination ([`super::condensed`]) gives the normal forces N of the m contacts as a function of their friction T and
//! their heights z. The heights of the face are r:
//!
//! ```text
//! N = N_0 + A T(N) + K z,     N >= 0,     z >= r,     N (z - r) = 0,     T = mu_d f(p) N
//! ```
//!
//! Each contact is either on the counterface, where z = r and N is unknown, or off it, where N = 0 and z is unknown.
//! Newton's method on the m unknowns, with the contact states updated after each step, solves elasticity, friction and
//! contact together. This semismooth method reaches the solution to rounding in a few steps. If it does not, only the
//! contact that violates its condition most is switched. If the solid yields at a given pressure, a contact that would
//! exceed this pressure carries it, at a height z <= r; the contact remains flattened for the following loads. Heights
//! are in units of P l^2 / k (nominal pressure P, lattice spacing l, spring stiffness k), so that a fixed relief has
//! less effect at larger loads.

use super::condensed::CondensedModel;
use super::dense::{add_times, solve_many};
use super::newton::{friction_at, friction_slope};
use super::{Equilibrium, SteadyLoad, TOLERANCE, displacement_unit, unloaded};
use crate::material::Elastic;
use slipgrid_base::statistics::extremes;

use crate::springblock::{Lattice, Status, SurfaceOutcome};

/// Maximum number of steps in which every contact that violates its condition switches.
const MAX_STEPS: usize = 40;
/// Maximum number, per contact, of steps in which only the contact with the largest violation switches.
const MAX_SINGLE_STEPS: usize = 4;
/// Maximum number of halvings of a step that does not decrease the residual.
const MAX_HALVINGS: usize = 10;
/// Violation of a contact condition up to which the condition counts as met: a force divided by the mean normal force,
/// or a gap divided by the scale of heights.
const ROUNDING: f64 = 1e-12;

/// Model of a cell whose face has height variations.
#[derive(Clone, Debug)]
pub struct RaisedModel {
    block_m: f64,
    elastic: Elastic,
    /// Normal forces as a function of friction forces and face heights.
    condensed: CondensedModel,
    /// Height r of the face of each contact, in lattice spacings.
    relief: Vec<f64>,
}

/// State of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactStatus {
    /// In contact at the height of its face.
    On,
    /// Off the counterface without force.
    Off,
    /// In contact, flattened, at the pressure at which it yields.
    Yielding,
}

/// State of a face after previous loads: contact states, and heights in lattice spacings. Empty before the first load.
#[derive(Clone, Debug, Default)]
pub struct FaceHistory {
    touch: Vec<ContactStatus>,
    relief: Vec<f64>,
}

/// Contact states, normal forces in units of P l^2, and heights in units of P l^2 / k, by contact; P is the nominal
/// pressure, l the lattice spacing, k the spring stiffness.
struct State {
    touch: Vec<ContactStatus>,
    normal: Vec<f64>,
    height: Vec<f64>,
}

/// Contact conditions under one load with the nominal pressure P; l is the lattice spacing, k the spring stiffness.
struct Contacts<'a> {
    model: &'a CondensedModel,
    load: &'a SteadyLoad<'a>,
    /// Height r of the face of each contact, in units of P l^2 / k.
    relief: Vec<f64>,
    /// Normal forces at which contacts yield, in units of P l^2.
    cap: Vec<f64>,
    /// Scale of the heights, in units of P l^2 / k: the largest difference of two face heights, at least 1.
    height_scale: f64,
    /// Scale of the forces, in units of P l^2: the mean normal force.
    force_scale: f64,
}

impl RaisedModel {
    /// Condenses `lattice`, whose blocks are `block_m` metres apart; `None` if the lattice is not periodic with equal
    /// columns, if its cavities reach the top row, or if the equations are singular.
    pub fn new(lattice: &Lattice, block_m: f64, elastic: Elastic) -> Option<Self> {
        let condensed = CondensedModel::with_raised_face(lattice, block_m, elastic.youngs_modulus_pa())?;
        let relief = condensed.contacts().iter().map(|contact| lattice.columns()[contact.column].relief).collect();
        Some(Self { block_m, elastic, condensed, relief })
    }

    /// Solves steady sliding under `load` on the face that the previous loads have left.
    pub fn solve(&self, load: &SteadyLoad, history: &mut FaceHistory) -> SurfaceOutcome {
        let model = &self.condensed;
        if load.pressure_pa == 0.0 || model.contacts().is_empty() {
            return unloaded(model.contacts(), self.block_m);
        }
        let m = self.relief.len();
        if history.relief.len() != m {
            *history = FaceHistory { touch: vec![ContactStatus::On; m], relief: self.relief.clone() };
        }
        let unit = displacement_unit(load.pressure_pa, self.elastic.youngs_modulus_pa());
        let relief: Vec<f64> = history.relief.iter().map(|r| r / unit).collect();
        // N = p w, forces in units of P l^2
        let cap = |width: f64| self.elastic.yield_pressure_pa().map_or(f64::INFINITY, |p| p / load.pressure_pa * width);
        let spread = extremes(relief.iter().copied());
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
        // An unconverged state must not change the face.
        if status == Status::Converged {
            for (c, touch) in state.touch.iter_mut().enumerate().filter(|(_, touch)| **touch == ContactStatus::Yielding)
            {
                // Yielded contacts keep the height to which they were pressed and are elastic again.
                history.relief[c] = state.height[c] * unit;
                *touch = ContactStatus::On;
            }
            history.touch = state.touch;
        } else {
            history.touch = vec![ContactStatus::On; m];
        }
        let friction = (0..m).map(|c| friction_at(model.response(), load, c, state.normal[c])).collect();
        let equilibrium =
            Equilibrium { status, iterations, residual, friction, normal: state.normal, displacement: Vec::new() };
        model.observe_raised(load, &equilibrium, &state.height)
    }
}

impl Contacts<'_> {
    /// Solves the contact conditions, starting from `state`; returns the status, the number of steps, and the residual
    /// divided by the load.
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
                // With unchanged contacts only the law is nonlinear: shorten a step that increases the residual.
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

    /// Residual N - N_0 - A T - K z of the normal forces N, by contact, in units of P l^2.
    fn residual(&self, state: &State) -> Vec<f64> {
        let response = self.model.response();
        let m = state.touch.len();
        let mut residual: Vec<f64> = state.normal.iter().zip(&response.at_rest).map(|(n, rest)| n - rest).collect();
        let (by_friction, by_height) = response.influence.split_at(m * m);
        for c in 0..m {
            let friction = friction_at(response, self.load, c, state.normal[c]);
            add_times(&mut residual, friction, &by_friction[c * m..][..m]);
            add_times(&mut residual, state.height[c], &by_height[c * m..][..m]);
        }
        residual
    }

    /// Newton's step, by contact: change of the normal force for contacts on the counterface, change of the height for
    /// other contacts; `None` if the equations are singular.
    fn direction(&self, state: &State, residual: &[f64]) -> Option<Vec<f64>> {
        let response = self.model.response();
        let m = state.touch.len();
        let (by_friction, by_height) = response.influence.split_at(m * m);
        let width = m + 1;
        let mut equations = vec![0.0; m * width];
        for c in 0..m {
            let slope = friction_slope(response, self.load, c, state.normal[c]);
            let is_on = state.touch[c] == ContactStatus::On;
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
            let is_on = state.touch[c] == ContactStatus::On;
            *(if is_on { &mut state.normal[c] } else { &mut state.height[c] }) += part * by;
        }
    }

    /// Switches contacts that violate their condition: lifts contacts under tension, lands lifted contacts below the
    /// height of their face, lets contacts above their yield force yield, and makes yielding contacts above their face
    /// elastic. With `single` only the contact with the largest violation switches. Returns whether any contact
    /// switched.
    fn switch(&self, state: &mut State, single: bool) -> bool {
        // Violation of the condition, and the next state of the contact.
        let broken = |c: usize| {
            let below = (self.relief[c] - state.height[c]) / self.height_scale;
            let beyond = (state.normal[c] - self.cap[c]) / self.force_scale;
            match state.touch[c] {
                ContactStatus::On if beyond > 0.0 => (beyond, ContactStatus::Yielding),
                ContactStatus::On => (-state.normal[c] / self.force_scale, ContactStatus::Off),
                ContactStatus::Off => (below, ContactStatus::On),
                ContactStatus::Yielding => (-below, ContactStatus::On),
            }
        };
        let mut moved: Vec<(usize, (f64, ContactStatus))> =
            (0..state.touch.len()).map(|c| (c, broken(c))).filter(|(_, (by, _))| *by > ROUNDING).collect();
        if single {
            moved = moved.into_iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0)).into_iter().collect();
        }
        for (c, (_, touch)) in &moved {
            state.touch[*c] = *touch;
            state.height[*c] = self.relief[*c];
            state.normal[*c] = if *touch == ContactStatus::Yielding { self.cap[*c] } else { 0.0 };
        }
        // The remaining tension is a rounding error.
        for (c, normal) in state.normal.iter_mut().enumerate() {
            if state.touch[c] == ContactStatus::On && !single {
                *normal = normal.max(0.0);
            }
        }
        !moved.is_empty()
    }
}

fn size(residual: &[f64]) -> f64 {
    residual.iter().map(|value| value.abs()).sum()
}

#[cfg(test)]
mod tests;
