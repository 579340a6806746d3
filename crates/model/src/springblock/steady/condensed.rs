//! Steady sliding of a cell of equal columns, by condensation to forces around its cavities.
//!
//! The cell is a flat layer with missing springs. The full layer is uniform and its response is known
//! ([`super::flat_layer`]). Forces g on the blocks that lack a spring cancel the effect of the additional springs:
//!
//! ```text
//! u = u_0 + G (g, w, T),     g = R u,     w: N(u) + kappa w = 0
//! ```
//!
//! u_0 is uniform compression under the load, R the stiffness of the missing springs, w the height of blocks of row 0
//! that the counterface does not pin, kappa the tie of blocks that touch in part, and T friction. Removed blocks need
//! no force, since they belong to the full layer only. If the face has heights z, contacts are at w = z, or tied to it.
//! The n unknowns, about five per column of the cavity, replace two per block of the cell, and elimination gives N =
//! N_0 + A T + K z for the m contacts. It takes n^3/3 + n^2 m + n m^2 multiplications and additions, whereas the band
//! matrix of the whole cell takes 2 nx ny (4 ny)^2.

use std::sync::Arc;

use slipgrid_base::statistics::cholesky::dot;

use self::equations::Equations;
use super::dense::subtract_products;
use super::system::{Contact, band_products};
use super::{Equilibrium, LinearResponse, SteadyLoad, displacement_unit, iterate, observe, unloaded};
use crate::springblock::rims::PLANE_STRAIN;
use crate::springblock::{Lattice, Status, SurfaceOutcome};

/// Condensed model of a cell, for any load.
#[derive(Clone, Debug)]
pub struct CondensedModel {
    block_m: f64,
    youngs_modulus_pa: f64,
    liftoff: bool,
    cell: Arc<CondensedCell>,
}

/// Condensed equations of a cell, which depend on the lattice only, not on block size and material.
#[derive(Debug)]
struct CondensedCell {
    response: Condensed,
    ceilings: Vec<Ceiling>,
    /// Affine map from the inputs to the unknowns: for each unknown, the coefficients of the inputs and a constant.
    /// Inputs are the friction forces T by contact and, on a face with heights, the heights of the contacts.
    unknowns: Vec<f64>,
    /// Descent of the bulk without friction, in units of P l^2 / k with the nominal pressure P, lattice spacing l and
    /// spring stiffness k.
    descent: f64,
}

/// The lowest block of a column in a cavity.
#[derive(Clone, Debug)]
struct Ceiling {
    /// Depth of the cavity, in rows.
    depth: f64,
    /// Vertical displacement as an affine function: coefficients of the unknowns, then of the inputs, and a constant.
    /// The displacement is in units of P l^2 / k with the nominal pressure P, lattice spacing l and spring stiffness k.
    height: Vec<f64>,
}

/// Returns estimated upper bounds of the number of multiplications and additions, and of the memory in bytes, for
/// condensing a cell of `columns` columns, `covered` of which lie in cavities `depth` rows deep.
pub fn condensing_cost(columns: f64, covered: f64, depth: f64) -> (f64, f64) {
    let (half, fields, m) = (columns / 2.0 + 1.0, 2.0 * (depth + 2.0), columns);
    // Blocks of the ceiling, twice if it exists in part, and of the walls.
    let n = 5.0 * (covered + 2.0) + 4.0 * depth;
    let (blocks, width) = ((covered + 2.0) * (depth + 2.0), n + m);
    let products =
        n * n * n / 3.0 + n * n * m + n * m * m + 32.0 * blocks * width + fields * fields / 2.0 * half * half;
    (products, 8.0 * (2.0 * half * half + 2.0 * fields * fields * columns + width * (n + 4.0 * blocks)))
}

/// Normal forces N of the contacts as a function of the friction forces T on the contacts: N = N_0 + A T, plus K z if
/// the face has the heights z. Forces are in units of P l^2 with the nominal pressure P and lattice spacing l.
#[derive(Clone, Debug)]
pub(super) struct Condensed {
    pub(super) contacts: Vec<Contact>,
    pub(super) load: f64,
    /// Matrix -A by columns, then the matrix -K by columns if the face has heights.
    pub(super) influence: Vec<f64>,
    /// Normal force N_0 without friction, by contact.
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
        // The matrix of -A is used because products are subtracted.
        subtract_products(normal, friction, &self.influence, friction.len(), 0);
    }
}

impl CondensedModel {
    /// Condenses `lattice`, whose blocks are `block_m` metres apart. Returns `None` if the lattice is not periodic with
    /// equal columns, if cavities reach the top row, if the equations are singular, or if the band matrix of all blocks
    /// takes fewer operations.
    pub fn new(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64, liftoff: bool) -> Option<Self> {
        let equations = Equations::for_lattice(lattice, false)?;
        let products = equations.products(lattice);
        if products > band_products(lattice.nx(), lattice.ny()) {
            return None;
        }
        let cell = equations.condense_cached(lattice, products)?;
        Some(Self { block_m, youngs_modulus_pa, liftoff, cell })
    }

    /// Like [`Self::new`], but however many operations it takes, and with contacts that pull.
    pub(super) fn with_any_cost(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64) -> Option<Self> {
        let equations = Equations::for_lattice(lattice, false)?;
        let products = equations.products(lattice);
        let cell = equations.condense_cached(lattice, products)?;
        Some(Self { block_m, youngs_modulus_pa, liftoff: false, cell })
    }

    /// Like [`Self::new`], but however many operations it takes, and with the heights of the face as inputs, as needed
    /// by [`super::raised`].
    pub(super) fn with_raised_face(lattice: &Lattice, block_m: f64, youngs_modulus_pa: f64) -> Option<Self> {
        let cell = Arc::new(Equations::for_lattice(lattice, true)?.condense(lattice)?);
        Some(Self { block_m, youngs_modulus_pa, liftoff: true, cell })
    }

    /// Vertical stiffness of the layer without friction, in units of the spring stiffness k, divided by the length of
    /// the lattice in lattice spacings.
    pub fn stiffness_per_length(&self) -> f64 {
        1.0 / self.cell.descent
    }

    /// Normal forces as a function of friction forces and face heights.
    pub(super) fn response(&self) -> &Condensed {
        &self.cell.response
    }

    /// Contact blocks, left to right.
    pub(super) fn contacts(&self) -> &[Contact] {
        &self.cell.response.contacts
    }

    /// Solves for the fixed point of friction under `load`.
    pub(super) fn iterate(&self, load: &SteadyLoad) -> Equilibrium {
        iterate(self.response(), load)
    }

    /// Converts the equilibrium `state` to an outcome of the model.
    pub(super) fn observe(&self, load: &SteadyLoad, state: &Equilibrium) -> SurfaceOutcome {
        observe(self.contacts(), self.block_m, load, state, self.clearance(load.pressure_pa, &state.friction))
    }

    /// Like [`Self::observe`], for a face with the heights `heights` at the contacts, in units of P l^2 / k.
    pub(super) fn observe_raised(&self, load: &SteadyLoad, state: &Equilibrium, heights: &[f64]) -> SurfaceOutcome {
        let clearance = self.clearance(load.pressure_pa, &[&state.friction, heights].concat());
        observe(self.contacts(), self.block_m, load, state, clearance)
    }

    /// Solves steady sliding under `load`; `None` if blocks leave the counterface or the solve does not converge, in
    /// which case the band solver must be used.
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

    /// Values of the unknowns for `inputs`: friction forces, then the heights of the face if the model has heights.
    fn unknowns(&self, inputs: &[f64]) -> Vec<f64> {
        let count = inputs.len();
        self.cell.unknowns.chunks_exact(count + 1).map(|row| dot(&row[..count], inputs) + row[count]).collect()
    }

    /// Minimum height of a cavity's ceiling above the counterface for `inputs`, in lattice spacings; `None` if there is
    /// no ceiling.
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

mod cell_cache;
mod equations;

#[cfg(test)]
mod tests;
