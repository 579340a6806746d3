//! The fast integrator: leapfrog on linear springs, strip by strip.
//!
//! ```text
//! u_after = u + kept (u - u_before) + kick F/m,  kept = (1 - g dt/2) / (1 + g dt/2),  kick = dt^2 / (1 + g dt/2)
//! ```
//!
//! Here g is the damping frequency and dt the time step. The scheme needs one force evaluation per step, and damping is
//! implicit. It is symplectic without damping and friction, of order 2, and stable for dt < 2/omega_max, with the
//! largest eigenfrequency omega_max. Units: k = 1, l = 1, m = 1.
//!
//! A run that starts from sliding in equilibrium stores deviations from that state, in the frame of the bulk, in single
//! precision, which halves memory traffic and arithmetic. Deviations are as small as slips, about a hundredth of the
//! shear of the layer, so that their rounding relative to slips is of order 1e-7. Displacements, velocities and
//! friction of the contact row are in double precision.

use std::ops::Range;
use std::thread::Scope;

use super::bonds::Bonds;
use super::contact::{ContactForce, ContactSums};
use super::engine::{Engine, PlaneEngine, Setup};
use super::protocol::Protocol;
use super::real::{Real, is_in_equilibrium};
use super::stencil::{BulkBalance, strips};
use super::strip::{Base, BulkPosition, Strip};
use super::strip_workers::StripWorkers;
use super::sweep::Kick;
use crate::springblock::{Lattice, Springs};

/// Leapfrog on the strips of a lattice of whole blocks.
#[derive(Debug)]
pub struct StripLeapfrog<'scope, 'env, 'a, R> {
    /// Strips before the first step; the workers own them afterwards.
    strips: Vec<Strip<'a, R>>,
    strip_workers: Option<StripWorkers<'scope, 'a, R>>,
    /// Scope in which other threads may be started, and the maximum number of threads including the thread of the
    /// caller.
    threads: Option<(&'scope Scope<'scope, 'env>, usize)>,
    balance: BulkBalance,
    protocol: Protocol,
    time_step: f64,
    steps: u64,
    periodic: bool,
    /// Displacements x and y of the base state, in lattice spacings, from which stored displacements deviate; index j *
    /// nx + i for column i of row j. Empty without a base state.
    base: Vec<[f64; 2]>,
    columns: usize,
}

impl<'scope, 'a: 'scope> StripLeapfrog<'scope, '_, 'a, f64> {
    /// Creates the integrator with a lattice of whole blocks at rest.
    pub fn new(lattice: &Lattice, setup: Setup<'a, 1>) -> Self {
        let kick = Kick::new(setup.time_step, setup.damping);
        Self::with_kick(lattice, setup, kick)
    }
}

impl<'scope, 'a: 'scope> StripLeapfrog<'scope, '_, 'a, f32> {
    /// Creates the integrator with a lattice of whole blocks in the sliding state `base`.
    ///
    /// `base` has the displacements x and y, in lattice spacings, in equilibrium under the load of `setup`, with index
    /// j * nx + i for column i of row j. The bulk moves at the speed of `setup` from the first step on. Returns `None`
    /// if unbalanced forces remain above the contact row.
    pub fn from_sliding(lattice: &Lattice, setup: Setup<'a, 1>, base: &[[f64; 2]]) -> Option<Self> {
        let Setup { protocol, time_step, damping, .. } = setup;
        let mut sliding = Self::with_kick(lattice, setup, Kick::new(time_step, damping).rounded::<f32>());
        let mut bonds = Bonds::new(lattice, Springs::Linear);
        let u = [0, 1].map(|c: usize| base.iter().map(|u| u[c]).collect::<Vec<f64>>());
        bonds.evaluate(&u, 0.0, protocol.load(0.0));
        let (nx, forces) = (lattice.nx(), bonds.forces());
        let largest = |rows: Range<usize>| {
            let each = forces.iter().flat_map(|force| &force[rows.clone()]);
            each.fold(0.0, |largest: f64, force| largest.max(force.abs()))
        };
        if !is_in_equilibrium(largest(nx..base.len()), largest(0..nx)) {
            return None;
        }
        let force = forces.each_ref().map(|force| force[..nx].to_vec());
        let height = base[..nx].iter().map(|u| u[1]).collect();
        let deviates_from = Base { force, height, carried: protocol.speed * time_step };
        for strip in &mut sliding.strips {
            strip.set_base(&deviates_from);
        }
        Some(Self { base: base.to_vec(), ..sliding })
    }
}

impl<'scope, 'env, 'a: 'scope, R: Real> StripLeapfrog<'scope, 'env, 'a, R> {
    fn with_kick(lattice: &Lattice, setup: Setup<'a, 1>, kick: Kick) -> Self {
        let Setup { contact, protocol, time_step, liftoff, .. } = setup;
        let (stencils, balance) = strips(lattice);
        let (blocks, law) = contact.into_parts();
        let strips = stencils
            .into_iter()
            .map(|stencil| Strip::new(stencil, lattice.ny(), &blocks, law, kick, liftoff))
            .collect();
        let periodic = lattice.is_periodic();
        let (base, columns) = (Vec::new(), lattice.nx());
        let threads = None;
        Self { strips, strip_workers: None, threads, balance, protocol, time_step, steps: 0, periodic, base, columns }
    }

    /// Allows up to `threads` threads of `scope`, including the thread of the caller.
    #[must_use]
    pub fn with_threads(self, scope: &'scope Scope<'scope, 'env>, threads: usize) -> Self {
        Self { threads: Some((scope, threads)), ..self }
    }

    /// Displacements x and y, in lattice spacings, of the block in column i of row j. Before [`Engine::finish`] only
    /// blocks in the strips of the calling thread have values.
    pub fn displacement(&self, i: usize, j: usize) -> [f64; 2] {
        let strips = self.strip_workers.as_ref().map_or(&self.strips[..], StripWorkers::own);
        let strip = strips.iter().find(|strip| strip.columns().contains(&i));
        let [x, y] = strip.map_or([0.0; 2], |strip| strip.displacement(i - strip.columns().start, j));
        match self.base.get(j * self.columns + i) {
            Some(base) => [base[0] + x + self.carried(self.steps), base[1] + y],
            None => [x, y],
        }
    }

    /// Displacement of the moving frame after `steps` steps, in lattice spacings: the displacement of the bulk if there
    /// is a base state, otherwise zero.
    fn carried(&self, steps: u64) -> f64 {
        if self.base.is_empty() { 0.0 } else { self.protocol.bulk_x(steps as f64 * self.time_step) }
    }

    /// Returns the workers; the first call hands the strips to them.
    fn strip_workers(&mut self) -> &mut StripWorkers<'scope, 'a, R> {
        let Self { strips, strip_workers, threads, periodic, .. } = self;
        strip_workers.get_or_insert_with(|| StripWorkers::new(std::mem::take(strips), *periodic, *threads))
    }
}

impl<'scope, 'a: 'scope, R: Real> Engine for StripLeapfrog<'scope, '_, 'a, R> {
    fn begin_drive(&mut self) {
        self.strip_workers().begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let time = self.steps as f64 * self.time_step;
        let x = self.protocol.bulk_x(time) - self.carried(self.steps);
        self.steps += 1;
        let carried = self.carried(self.steps);
        // The base state already balances the load.
        let load = if self.base.is_empty() { self.protocol.load(time) } else { 0.0 };
        let balance = self.balance;
        let strip_workers = self.strip_workers();
        let height = balance.height(strip_workers.top_row_force(), x, load);
        strip_workers.step(BulkPosition { x, height, carried })
    }

    fn all_have_slipped(&self) -> bool {
        self.strip_workers.as_ref().is_some_and(StripWorkers::all_have_slipped)
    }

    fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.strip_workers().contact_forces()
    }

    fn finish(&mut self) {
        self.strip_workers().finish();
    }
}

impl<'scope, 'a: 'scope, R: Real> PlaneEngine for StripLeapfrog<'scope, '_, 'a, R> {
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for strip in &mut self.strips {
            strip.start(displacement);
        }
    }

    fn rise(&self, i: usize, j: usize) -> f64 {
        self.displacement(i, j)[1]
    }
}
