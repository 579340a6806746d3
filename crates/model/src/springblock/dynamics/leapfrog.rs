//! Leapfrog: velocities half a step behind positions, one force evaluation per step, implicit damping.
//!
//! ```text
//! v+ = [(1 - g dt/2) v- + dt F/m] / (1 + g dt/2),   u+ = u + dt v+
//! ```
//!
//! The velocities v- and v+ are those before and after the force F, g is the damping frequency, and dt the time step.
//! Velocities are stored times dt. The scheme is symplectic without damping and friction and of order 2; it is stable
//! for dt < 2/omega_max, with the largest eigenfrequency omega_max. Units: k = 1, l = 1, m = 1.

use super::bonds::Bonds;
use super::contact::{ContactForce, ContactRow, ContactSums};
use super::engine::{Engine, PlaneEngine, Setup};
use super::protocol::Protocol;
use super::sweep::Kick;
use crate::springblock::{Lattice, Springs};

/// Leapfrog with the spring forces of [`Bonds`]: for exact springs, and as the reference for the stencil in tests.
#[derive(Clone, Debug)]
pub struct BondLeapfrog<'a> {
    bonds: Bonds,
    nx: usize,
    displacement: [Vec<f64>; 2],
    /// Velocities x and y times the time step, in lattice spacings.
    velocity: [Vec<f64>; 2],
    contact: ContactRow<'a, 1>,
    protocol: Protocol,
    coefficients: Kick,
    inverse_mass: Vec<f64>,
    contact_kick: Vec<f64>,
    time_step: f64,
    steps: u64,
    liftoff: bool,
}

impl<'a> BondLeapfrog<'a> {
    /// Creates the integrator with `lattice` at rest.
    pub fn new(lattice: &Lattice, springs: Springs, setup: Setup<'a, 1>) -> Self {
        let Setup { contact, protocol, time_step, damping, liftoff, .. } = setup;
        let bonds = Bonds::new(lattice, springs);
        let coefficients = Kick::new(time_step, damping);
        let inverse_mass = bonds.inverse_mass();
        let (nx, blocks) = (lattice.nx(), inverse_mass.len());
        Self {
            bonds,
            nx,
            displacement: [vec![0.0; blocks], vec![0.0; blocks]],
            velocity: [vec![0.0; blocks], vec![0.0; blocks]],
            contact,
            protocol,
            coefficients,
            contact_kick: inverse_mass[..nx].iter().map(|inverse| coefficients.kick * inverse).collect(),
            inverse_mass,
            time_step,
            steps: 0,
            liftoff,
        }
    }
}

impl Engine for BondLeapfrog<'_> {
    fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let time = self.steps as f64 * self.time_step;
        self.steps += 1;
        self.bonds.evaluate(&self.displacement, self.protocol.bulk_x(time), self.protocol.load(time));
        let [force_x, force_y] = self.bonds.forces();
        let Kick { kept, kick } = self.coefficients;
        let nx = self.nx;
        let [wx, wy] = &mut self.velocity;
        let sums = self.contact.kick(&mut wx[..nx], force_x, force_y, kept, &self.contact_kick);
        if self.liftoff {
            let uy = &mut self.displacement[1];
            for block in &mut self.contact.blocks {
                let (i, inverse_mass) = (block.column, self.inverse_mass[block.column]);
                let height = block.move_detached(uy[i], &mut wy[i], self.coefficients, inverse_mass, force_y[i]);
                // A block that has landed stays at its face.
                if height == Some(block.face) {
                    uy[i] = block.face;
                }
            }
        }
        for number in nx..self.inverse_mass.len() {
            let scale = kick * self.inverse_mass[number];
            wx[number] = kept * wx[number] + scale * force_x[number];
            wy[number] = kept * wy[number] + scale * force_y[number];
        }
        for (u, w) in self.displacement.iter_mut().zip(&self.velocity) {
            for (u, w) in u.iter_mut().zip(w) {
                *u += w;
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

impl PlaneEngine for BondLeapfrog<'_> {
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for number in 0..self.inverse_mass.len() {
            [self.displacement[0][number], self.displacement[1][number]] =
                displacement(number % self.nx, number / self.nx);
        }
    }

    fn rise(&self, i: usize, j: usize) -> f64 {
        self.displacement[1][j * self.nx + i]
    }
}
