//! The fast integrator: leapfrog on linear springs, strip by strip.
//!
//! ```text
//! u_after = u + kept (u - u_before) + kick F/m,  kept = (1 - g dt/2) / (1 + g dt/2),  kick = dt^2 / (1 + g dt/2)
//! ```
//!
//! one force evaluation a step, damping implicit, symplectic without damping and friction, of order 2;
//! stable for dt < 2/omega_max. Units: k = 1, l = 1, m = 1.

use std::thread::Scope;

use super::contact::{ContactForce, ContactSums};
use super::engine::{Engine, PlaneEngine, Setup};
use super::protocol::Protocol;
use super::stencil::{BulkBalance, strips};
use super::strip::{BulkPlace, Strip};
use super::strip_workers::StripWorkers;
use super::sweep::Kick;
use crate::lattice::Lattice;

/// Leapfrog on the strips of a plain lattice.
#[derive(Debug)]
pub struct StripLeapfrog<'scope, 'env, 'a> {
    /// Strips before the first step; the workers have them after it.
    strips: Vec<Strip<'a>>,
    strip_workers: Option<StripWorkers<'scope, 'a>>,
    /// Where other threads may be started, and how many with the caller's.
    threads: Option<(&'scope Scope<'scope, 'env>, usize)>,
    balance: BulkBalance,
    protocol: Protocol,
    time_step: f64,
    steps: u64,
    periodic: bool,
    contacts: usize,
}

impl<'scope, 'env, 'a: 'scope> StripLeapfrog<'scope, 'env, 'a> {
    /// A plain lattice at rest.
    #[must_use]
    pub fn new(lattice: &Lattice, setup: Setup<'a>) -> Self {
        let Setup { contact, protocol, time_step, damping, liftoff } = setup;
        let kick = Kick::new(time_step, damping);
        let (stencils, balance) = strips(lattice);
        let (blocks, law) = contact.into_parts();
        let contacts = blocks.len();
        let strips = stencils
            .into_iter()
            .map(|stencil| Strip::new(stencil, lattice.ny(), &blocks, law, kick, liftoff))
            .collect();
        let periodic = lattice.is_periodic();
        Self { strips, strip_workers: None, threads: None, balance, protocol, time_step, steps: 0, periodic, contacts }
    }

    /// The same, advanced by at most `threads` threads of `scope` with the caller's.
    #[must_use]
    pub fn with_threads(self, scope: &'scope Scope<'scope, 'env>, threads: usize) -> Self {
        Self { threads: Some((scope, threads)), ..self }
    }

    /// Displacements of block (i, j), x and y; of the caller's own strips until [`Engine::finish`].
    #[must_use]
    pub fn displacement(&self, i: usize, j: usize) -> [f64; 2] {
        let strips = self.strip_workers.as_ref().map_or(&self.strips[..], StripWorkers::own);
        let strip = strips.iter().find(|strip| strip.columns().contains(&i));
        strip.map_or([0.0; 2], |strip| strip.displacement(i - strip.columns().start, j))
    }

    /// The workers, which take the strips over.
    fn strip_workers(&mut self) -> &mut StripWorkers<'scope, 'a> {
        let Self { strips, strip_workers, threads, periodic, .. } = self;
        strip_workers.get_or_insert_with(|| StripWorkers::new(std::mem::take(strips), *periodic, *threads))
    }
}

impl<'scope, 'a: 'scope> Engine for StripLeapfrog<'scope, '_, 'a> {
    fn begin_drive(&mut self) {
        self.strip_workers().begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let time = self.steps as f64 * self.time_step;
        self.steps += 1;
        let (x, load, balance) = (self.protocol.bulk_x(time), self.protocol.load(time), self.balance);
        let strip_workers = self.strip_workers();
        let height = balance.height(strip_workers.held(), x, load);
        strip_workers.step(BulkPlace { x, height })
    }

    fn all_have_slipped(&self) -> bool {
        self.strip_workers.as_ref().is_some_and(StripWorkers::all_have_slipped)
    }

    fn contacts(&self) -> usize {
        self.contacts
    }

    fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.strip_workers().contact_forces()
    }

    fn finish(&mut self) {
        self.strip_workers().finish();
    }

    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn evaluations_per_step(&self) -> u64 {
        1
    }
}

impl<'scope, 'a: 'scope> PlaneEngine for StripLeapfrog<'scope, '_, 'a> {
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for strip in &mut self.strips {
            strip.start(displacement);
        }
    }

    fn rise(&self, i: usize, j: usize) -> f64 {
        self.displacement(i, j)[1]
    }
}
