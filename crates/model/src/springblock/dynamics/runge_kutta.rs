//! The paper's integration: classical Runge-Kutta of order 4.
//!
//! Whether a contact block is at rest, and the direction in which it slips, are fixed at the beginning of a step for
//! all four stages; a block whose velocity would reverse ends the step at rest. Units: k = 1, l = 1, m = 1.

#[cfg(test)]
mod tests;

use pulp::{Simd, WithSimd};

use super::bonds::Bonds;
use super::contact::{ContactForce, ContactRow, ContactSums, Motion, slip_direction};
use super::engine::{Engine, PlaneEngine, Setup};
use super::protocol::Protocol;
use crate::springblock::{Lattice, Springs};
use slipgrid_base::fft::vectorized;

/// Displacements u and velocities v along x and y; index j * nx + i for column i of row j. Units: k = 1, l = 1, m = 1.
#[derive(Clone, Debug)]
struct State {
    u: [Vec<f64>; 2],
    v: [Vec<f64>; 2],
}

impl State {
    fn at_rest(blocks: usize) -> Self {
        let zero = || [vec![0.0; blocks], vec![0.0; blocks]];
        Self { u: zero(), v: zero() }
    }

    /// Sets self = base + h * slope for the blocks that `slope` contains.
    fn set_to(&mut self, base: &Self, h: f64, slope: &Self) {
        for ((own, base), slope) in self.parts_mut().zip(base.parts()).zip(slope.parts()) {
            for ((s, b), k) in own.iter_mut().zip(base).zip(slope) {
                *s = b + h * k;
            }
        }
    }

    /// Adds h * slope to self for the blocks that `slope` contains.
    fn add(&mut self, h: f64, slope: &Self) {
        for (own, slope) in self.parts_mut().zip(slope.parts()) {
            for (s, k) in own.iter_mut().zip(slope) {
                *s += h * k;
            }
        }
    }

    fn parts(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.u.iter().chain(&self.v)
    }

    fn parts_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.u.iter_mut().chain(&mut self.v)
    }
}

/// Runge-Kutta integrator with its state.
#[derive(Clone, Debug)]
pub struct RungeKutta<'a> {
    bonds: Bonds,
    nx: usize,
    state: State,
    stage: State,
    /// Time derivative of the state of the contact row.
    slope: State,
    next: State,
    contact: ContactRow<'a, 1>,
    /// Direction in which each contact block slips, or would slip if released, in this step: 1 or -1; 0 without
    /// friction.
    direction: Vec<f64>,
    protocol: Protocol,
    inverse_mass: Vec<f64>,
    damping: f64,
    time_step: f64,
    steps: u64,
    liftoff: bool,
    /// Work of drive, friction and damping since the start, in units of k l^2 (spring stiffness k, lattice spacing l).
    #[cfg(test)]
    ledger: tests::Ledger,
}

impl<'a> RungeKutta<'a> {
    /// Creates the integrator with `lattice` at rest.
    pub fn new(lattice: &Lattice, springs: Springs, setup: Setup<'a, 1>) -> Self {
        let Setup { contact, protocol, time_step, damping, liftoff, .. } = setup;
        let bonds = Bonds::new(lattice, springs);
        let inverse_mass = bonds.inverse_mass();
        let blocks = inverse_mass.len();
        Self {
            bonds,
            nx: lattice.nx(),
            state: State::at_rest(blocks),
            stage: State::at_rest(blocks),
            slope: State::at_rest(lattice.nx()),
            next: State::at_rest(blocks),
            direction: vec![0.0; contact.blocks.len()],
            contact,
            protocol,
            inverse_mass,
            damping,
            time_step,
            steps: 0,
            liftoff,
            #[cfg(test)]
            ledger: tests::Ledger::default(),
        }
    }

    /// Computes the time derivative of the contact row at `stage` from the forces just evaluated.
    fn find_slope(&mut self) {
        let Self { bonds, stage, slope, contact, direction, inverse_mass, damping, .. } = self;
        let [force_x, force_y] = bonds.forces();
        for (c, force) in [force_x, force_y].into_iter().enumerate() {
            slope.u[c].copy_from_slice(&stage.v[c][..slope.v[c].len()]);
            for (((a, f), inverse), v) in slope.v[c].iter_mut().zip(force).zip(inverse_mass.iter()).zip(&stage.v[c]) {
                // m a = F - gamma m v
                *a = f * inverse - *damping * v;
            }
        }
        for (number, direction) in direction.iter().enumerate() {
            let i = contact.blocks[number].column;
            match contact.blocks[number].motion {
                Motion::Rest => {
                    slope.u[0][i] = 0.0;
                    slope.v[0][i] = 0.0;
                }
                Motion::Slip => {
                    let friction = contact.sliding_friction(number, *direction, force_y[i]);
                    slope.v[0][i] -= friction * inverse_mass[i];
                }
                Motion::Lifted => {}
            }
        }
        // Blocks on the counterface move horizontally only.
        for block in contact.blocks.iter().filter(|block| block.motion != Motion::Lifted) {
            slope.u[1][block.column] = 0.0;
            slope.v[1][block.column] = 0.0;
        }
    }

    /// Adds `weight` times the time derivative of the rows above the contact row to `next`, and sets these rows of
    /// `stage` to `state` plus `ahead` times the derivative.
    fn advance_above(&mut self, weight: f64, ahead: f64) {
        let Self { bonds, nx, state, stage, next, inverse_mass, damping, .. } = self;
        for c in 0..2 {
            vectorized(Advance {
                weight,
                ahead,
                damping: *damping,
                force: &bonds.forces()[c][*nx..],
                inverse_mass: &inverse_mass[*nx..],
                state: [&state.u[c][*nx..], &state.v[c][*nx..]],
                stage: [&mut stage.u[c][*nx..], &mut stage.v[c][*nx..]],
                next: [&mut next.u[c][*nx..], &mut next.v[c][*nx..]],
            });
        }
    }
}

/// One Runge-Kutta stage for the displacements and velocities of blocks above the contact row, in one pass.
struct Advance<'a> {
    weight: f64,
    ahead: f64,
    damping: f64,
    force: &'a [f64],
    inverse_mass: &'a [f64],
    state: [&'a [f64]; 2],
    stage: [&'a mut [f64]; 2],
    next: [&'a mut [f64]; 2],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { weight, ahead, damping, force, inverse_mass, state, stage, next } = self;
        let ([u, v], [stage_u, stage_v], [next_u, next_v]) = (state, stage, next);
        let count = force.len();
        let (inverse_mass, u, v) = (&inverse_mass[..count], &u[..count], &v[..count]);
        let (stage_u, stage_v) = (&mut stage_u[..count], &mut stage_v[..count]);
        let (next_u, next_v) = (&mut next_u[..count], &mut next_v[..count]);
        for n in 0..count {
            let velocity = stage_v[n];
            // m a = F - gamma m v
            let acceleration = force[n] * inverse_mass[n] - damping * velocity;
            next_u[n] += weight * velocity;
            next_v[n] += weight * acceleration;
            stage_u[n] = u[n] + ahead * velocity;
            stage_v[n] = v[n] + ahead * acceleration;
        }
    }
}

impl Engine for RungeKutta<'_> {
    fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let (h, time) = (self.time_step, self.steps as f64 * self.time_step);
        self.steps += 1;
        let mut sums = ContactSums::default();
        self.stage.clone_from(&self.state);
        self.next.clone_from(&self.state);
        // Classical tableau: stages at 0, 1/2, 1/2, 1 with weights 1/6, 1/3, 1/3, 1/6.
        for (number, (at, weight, ahead)) in
            [(0.0, 1.0 / 6.0, 0.5), (0.5, 1.0 / 3.0, 0.5), (0.5, 1.0 / 3.0, 1.0), (1.0, 1.0 / 6.0, 0.0)]
                .into_iter()
                .enumerate()
        {
            let now = time + at * h;
            self.bonds.evaluate(&self.stage.u, self.protocol.bulk_x(now), self.protocol.load(now));
            if number == 0 {
                let [force_x, force_y] = self.bonds.forces();
                if self.liftoff {
                    for block in &mut self.contact.blocks {
                        if block.motion != Motion::Lifted && -force_y[block.column] < 0.0 {
                            block.motion = Motion::Lifted;
                        }
                    }
                }
                sums = self.contact.begin_step(&self.state.v[0], force_x, force_y);
                for (direction, block) in self.direction.iter_mut().zip(&self.contact.blocks) {
                    // A block without normal pressure at the start has no friction in this step.
                    let free = block.sliding == 0.0;
                    let towards = slip_direction(self.state.v[0][block.column], force_x[block.column]);
                    *direction = if free { 0.0 } else { towards };
                }
            }
            self.find_slope();
            #[cfg(test)]
            self.account(weight * h, now, time);
            self.next.add(weight * h, &self.slope);
            if number < 3 {
                self.stage.set_to(&self.state, ahead * h, &self.slope);
            }
            self.advance_above(weight * h, ahead * h);
        }
        std::mem::swap(&mut self.state, &mut self.next);
        for (block, direction) in self.contact.blocks.iter_mut().zip(&self.direction) {
            let i = block.column;
            if block.motion == Motion::Slip && block.sliding != 0.0 && self.state.v[0][i] * direction <= 0.0 {
                #[cfg(test)]
                self.ledger.stop(self.inverse_mass[i], self.state.v[0][i]);
                self.state.v[0][i] = 0.0;
                block.motion = Motion::Rest;
            }
            if block.motion == Motion::Lifted && self.state.u[1][i] <= block.face {
                self.state.u[1][i] = block.face;
                self.state.v[1][i] = 0.0;
                block.motion = Motion::Slip;
            }
        }
        sums
    }

    fn all_have_slipped(&self) -> bool {
        self.contact.all_have_slipped()
    }

    fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.contact.forces()
    }
}

impl PlaneEngine for RungeKutta<'_> {
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for number in 0..self.inverse_mass.len() {
            [self.state.u[0][number], self.state.u[1][number]] = displacement(number % self.nx, number / self.nx);
        }
    }

    fn rise(&self, i: usize, j: usize) -> f64 {
        self.state.u[1][j * self.nx + i]
    }
}
