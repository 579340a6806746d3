//! Steady sliding of a cell of equal columns by the few forces about its cavities.
//!
//! The cell is a flat layer from which springs are missing. Filled up it is the same everywhere, and its response
//! is known ([`super::flat_layer`]). What the filling does is undone by forces g on the blocks that lack a spring:
//!
//! ```text
//! u = u_0 + G (g, w, T),     g = R u,     w: N(u) + kappa w = 0
//! ```
//!
//! u_0 is uniform compression under the load, R the stiffness of the missing springs, w the height of blocks of row
//! 0 that the counterface does not pin, kappa the tie of those that it touches in part, T friction. Removed blocks
//! need no force: where they are and what binds them is the filling's affair. Where the face has heights z, what touches it
//! is at w = z, or tied to it. So n unknowns, some five a column of the
//! cavity, replace two a block of the cell, and elimination leaves N = N_0 + A T + K z for the m contacts. It takes
//! n^3/3 + n^2 m + n m^2 multiplications and additions where the band of the whole cell takes 2 nx ny (4 ny)^2.

use std::sync::Arc;

use self::equations::Equations;
use super::dense::subtract_products;
use super::system::{Contact, band_products};
use super::{Equilibrium, LinearResponse, SteadyLoad, displacement_unit, iterate, observe, unloaded};
use crate::columns::PLANE_STRAIN;
use crate::lattice::Lattice;
use crate::outcome::{Status, SurfaceOutcome};

/// A cell that may slide under many loads.
#[derive(Clone, Debug)]
pub struct CondensedModel {
    block_m: f64,
    youngs_modulus_pa: f64,
    liftoff: bool,
    cell: Arc<CondensedCell>,
}

/// A cell without its unknowns: what follows from the lattice alone, whatever its blocks measure and are made of.
#[derive(Debug)]
struct CondensedCell {
    response: Condensed,
    ceilings: Vec<Ceiling>,
    /// Unknowns y = Y T + y_0, by rows: Y, then y_0. Heights follow T where they are inputs.
    unknowns: Vec<f64>,
}

/// The lowest block of a column in a cavity.
#[derive(Clone, Debug)]
struct Ceiling {
    /// Depth of the cavity, in rows.
    depth: f64,
    /// Its height over the unknowns, the inputs, and 1.
    height: Vec<f64>,
}

/// Multiplications and additions, and memory in bytes, that condensing a cell of `columns` takes, roughly and at most, whose
/// cavities take `covered` of them and are `depth` rows deep.
pub fn condensing(columns: f64, covered: f64, depth: f64) -> (f64, f64) {
    let (half, fields, m) = (columns / 2.0 + 1.0, 2.0 * (depth + 2.0), columns);
    // The ceiling's blocks, twice where it is there in part, and the walls'.
    let n = 5.0 * (covered + 2.0) + 4.0 * depth;
    let (blocks, width) = ((covered + 2.0) * (depth + 2.0), n + m);
    let products =
        n * n * n / 3.0 + n * n * m + n * m * m + 32.0 * blocks * width + fields * fields / 2.0 * half * half;
    (products, 8.0 * (2.0 * half * half + 2.0 * fields * fields * columns + width * (n + 4.0 * blocks)))
}

/// N = N_0 + A T, and + K z where the face has heights z.
#[derive(Clone, Debug)]
pub(super) struct Condensed {
    pub(super) contacts: Vec<Contact>,
    pub(super) load: f64,
    /// -A by columns, then -K.
    pub(super) influence: Vec<f64>,
    pub(super) at_rest: Vec<f64>,
}

impl LinearResponse for Condensed {
    fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    fn load(&self) -> f64 {
        self.load
    }

    fn order(&self) -> usize {
        0
    }

    fn respond(&self, friction: &[f64], _: &mut [f64], normal: &mut [f64]) {
        normal.copy_from_slice(&self.at_rest);
        // Products are subtracted: the matrix is that of -A.
        subtract_products(normal, friction, &self.influence, friction.len(), 0);
    }
}

impl CondensedModel {
    /// The model of `lattice`, whose blocks are `block_m` apart; `None` where it is no ring of equal columns, where
    /// cavities reach the uppermost row, or where the band of all blocks takes fewer operations.
    #[must_use]
    pub fn new(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64, liftoff: bool) -> Option<Self> {
        let equations = Equations::of(lattice, &[], false)?;
        let products = equations.products(lattice);
        if products > band_products(lattice.nx(), lattice.ny()) {
            return None;
        }
        let cell = equations.condense_or_recall(lattice, products)?;
        Some(Self { block_m, youngs_modulus_pa, liftoff, cell })
    }

    /// The same at any number of operations, with the contact blocks of the columns `lifted` off the counterface.
    pub(super) fn lifted(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64, lifted: &[usize]) -> Option<Self> {
        let (equations, liftoff) = (Equations::of(lattice, lifted, false)?, !lifted.is_empty());
        let cell = if liftoff {
            Arc::new(equations.condense(lattice)?)
        } else {
            let products = equations.products(lattice);
            equations.condense_or_recall(lattice, products)?
        };
        Some(Self { block_m, youngs_modulus_pa, liftoff, cell })
    }

    /// The same with the heights of the face as inputs, as [`super::raised`] needs them.
    pub(super) fn raised(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64) -> Option<Self> {
        let cell = Arc::new(Equations::of(lattice, &[], true)?.condense(lattice)?);
        Some(Self { block_m, youngs_modulus_pa, liftoff: true, cell })
    }

    /// N over friction and heights.
    pub(super) fn response(&self) -> &Condensed {
        &self.cell.response
    }

    /// The contact blocks, left to right.
    pub(super) fn contacts(&self) -> &[Contact] {
        &self.cell.response.contacts
    }

    /// The fixed point of friction under `load` with the blocks on and off the counterface that are.
    pub(super) fn iterate(&self, load: &SteadyLoad) -> Equilibrium {
        iterate(self.response(), load)
    }

    /// What `state` says.
    pub(super) fn observe(&self, load: &SteadyLoad, state: &Equilibrium) -> SurfaceOutcome {
        observe(self.contacts(), self.block_m, load, state, self.clearance(load.pressure_pa, &state.friction))
    }

    /// What `state` says of a face with the heights `heights` at its contacts.
    pub(super) fn observe_raised(&self, load: &SteadyLoad, state: &Equilibrium, heights: &[f64]) -> SurfaceOutcome {
        let clearance = self.clearance(load.pressure_pa, &[&state.friction, heights].concat());
        observe(self.contacts(), self.block_m, load, state, clearance)
    }

    /// Height over P l^2 / k of every contact block that is off the counterface, in the order of the contacts.
    pub(super) fn heights(&self, state: &Equilibrium) -> Vec<Option<f64>> {
        let unknowns = self.unknowns(&state.friction);
        let of_lifted = |contact: &Contact| contact.lifted.then(|| unknowns[contact.dof]);
        self.contacts().iter().map(of_lifted).collect()
    }

    /// Steady sliding under `load`; `None` where blocks leave the counterface or the solve does not converge, so that
    /// the band solver has to say how it ends.
    #[must_use]
    pub fn solve(&self, load: &SteadyLoad) -> Option<SurfaceOutcome> {
        let contacts = &self.cell.response.contacts;
        if load.pressure_pa == 0.0 || contacts.is_empty() {
            return Some(unloaded(contacts, self.block_m));
        }
        let state = iterate(self.response(), load);
        let lifts = self.liftoff && state.normal.iter().any(|normal| *normal < 0.0);
        if state.status != Status::Converged || lifts {
            return None;
        }
        Some(self.observe(load, &state))
    }

    /// The unknowns under the inputs `inputs`: friction forces, then heights where they are inputs.
    fn unknowns(&self, inputs: &[f64]) -> Vec<f64> {
        let count = inputs.len();
        self.cell.unknowns.chunks_exact(count + 1).map(|row| dot(&row[..count], inputs) + row[count]).collect()
    }

    /// Least height of a ceiling above the counterface, in blocks.
    fn clearance(&self, pressure_pa: f64, inputs: &[f64]) -> Option<f64> {
        let unit = displacement_unit(pressure_pa, PLANE_STRAIN * self.youngs_modulus_pa);
        let affine = |row: &[f64]| dot(&row[..inputs.len()], inputs) + row[inputs.len()];
        let unknowns = self.unknowns(inputs);
        let heights = self.cell.ceilings.iter().map(|ceiling| {
            let (by_unknowns, rest) = ceiling.height.split_at(unknowns.len());
            ceiling.depth + (dot(by_unknowns, &unknowns) + affine(rest)) * unit
        });
        heights.reduce(f64::min)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

mod equations;
mod latest;

#[cfg(test)]
mod tests;
