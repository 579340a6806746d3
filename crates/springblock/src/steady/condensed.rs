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

use super::dense::{solve_many, subtract_products};
use super::flat_layer::FlatLayer;
use super::system::{Contact, band_products, contacts};
use super::{Equilibrium, LinearResponse, SteadyLoad, displacement_unit, iterate, observe, unloaded};
use crate::lattice::{Bond, Lattice};
use crate::outcome::{Status, SurfaceOutcome};

/// Evaluations of N over a few loads.
const EVALUATIONS: f64 = 40.0;

/// No number.
const NONE: usize = usize::MAX;

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
        let unit = displacement_unit(pressure_pa, self.youngs_modulus_pa);
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

/// Consecutive columns of a field of the flat layer with an input.
#[derive(Clone, Copy, Debug)]
struct Run {
    field: usize,
    first: usize,
    count: usize,
    /// Place of the first one in a row of coefficients.
    place: usize,
}

/// Which unknowns there are, before anything is computed.
struct Equations {
    nx: usize,
    explicit: usize,
    contacts: Vec<Contact>,
    missing: Vec<Bond>,
    /// Number of block j nx + i among those at a missing spring.
    number: Vec<usize>,
    /// Those blocks: column and row.
    blocks: Vec<(usize, usize)>,
    /// Unknown by field and column.
    unknown_at: Vec<usize>,
    /// Unknowns: their field and column.
    unknowns: Vec<(usize, usize)>,
    runs: Vec<Run>,
    /// Place of the height of the face in a row of coefficients, by column; [`NONE`] where it is no input.
    height_at: Vec<usize>,
    /// Those of them that no field of the layer takes in: of contacts that are tied.
    tied_heights: Vec<usize>,
}

impl Equations {
    /// Those of a ring of equal columns whose cavities leave a row, with the columns `lifted` off the counterface; heights of
    /// the face at the contacts are inputs if it is `raised`.
    fn of(lattice: &Lattice, lifted: &[usize], raised: bool) -> Option<Self> {
        let width = lattice.columns().first()?.width;
        let explicit = (lattice.cavity_rows() + 1).max(2);
        if !lattice.is_periodic() || explicit > lattice.ny() || lattice.columns().iter().any(|c| c.width != width) {
            return None;
        }
        let mut contacts = contacts(lattice, |_| 0);
        for contact in &mut contacts {
            contact.lifted = lifted.contains(&contact.column);
        }
        Some(Self::new(lattice, explicit, contacts, raised))
    }

    fn new(lattice: &Lattice, explicit: usize, mut contacts: Vec<Contact>, raised: bool) -> Self {
        let nx = lattice.nx();
        let mut missing = Vec::new();
        let mut number = vec![NONE; explicit * nx];
        let mut blocks = Vec::new();
        let mut unknown_at = vec![NONE; 2 * explicit * nx];
        // Marked here, numbered below.
        lattice.for_each_missing_bond(|bond| {
            let ends = [Some(bond.a), bond.b].into_iter().flatten();
            if ends.clone().all(|(i, j)| !lattice.is_attached(i, j)) {
                return;
            }
            for (i, j) in ends {
                if number[j * nx + i] == NONE {
                    number[j * nx + i] = blocks.len();
                    blocks.push((i, j));
                    if lattice.is_attached(i, j) {
                        // Row 0 is held vertically: its displacement is the unknown there, if any, not a force.
                        unknown_at[2 * j * nx + i] = 0;
                        if j > 0 {
                            unknown_at[(2 * j + 1) * nx + i] = 0;
                        }
                    }
                }
            }
            missing.push(bond);
        });
        for (i, column) in lattice.columns().iter().enumerate() {
            if column.coverage > 0.0 && lattice.is_attached(i, 0) {
                unknown_at[nx + i] = 0;
            }
        }
        for contact in contacts.iter().filter(|contact| contact.lifted) {
            unknown_at[nx + contact.column] = 0;
        }
        let mut unknowns = Vec::new();
        let mut runs: Vec<Run> = Vec::new();
        for (at, unknown) in unknown_at.iter_mut().enumerate().filter(|(_, unknown)| **unknown == 0) {
            *unknown = unknowns.len();
            add_to_runs(&mut runs, at / nx, at % nx, unknowns.len());
            unknowns.push((at / nx, at % nx));
        }
        for contact in contacts.iter_mut().filter(|contact| contact.lifted) {
            contact.dof = unknown_at[nx + contact.column];
        }
        for (contact, place) in contacts.iter().zip(unknowns.len()..) {
            // Friction on a block that lacks springs is an input of its own.
            if runs.last().is_some_and(|run| run.place < unknowns.len()) {
                runs.push(Run { field: 0, first: contact.column, count: 1, place });
            } else {
                add_to_runs(&mut runs, 0, contact.column, place);
            }
        }
        let mut height_at = vec![NONE; nx];
        let mut tied_heights = Vec::new();
        if raised {
            for (contact, place) in contacts.iter().zip(unknowns.len() + contacts.len()..) {
                height_at[contact.column] = place;
                // What is tied to the face has a height of its own, an unknown.
                if contact.tie.is_none() {
                    add_to_runs(&mut runs, 1, contact.column, place);
                } else {
                    tied_heights.push(place);
                }
            }
        }
        Self { nx, explicit, contacts, missing, number, blocks, unknown_at, unknowns, runs, height_at, tied_heights }
    }

    /// Multiplications and additions that condensing takes, and the iterations after it; the band's substitutions,
    /// which are as many, are not held against it.
    fn products(&self, lattice: &Lattice) -> f64 {
        let [n, m, missing] = [self.unknowns.len(), self.contacts.len(), self.missing.len()].map(|count| count as f64);
        let (half, fields) = (lattice.nx() as f64 / 2.0, 2.0 * self.explicit as f64);
        let elimination = n * n * n / 3.0 + n * n * m + n * m * m;
        elimination + 8.0 * missing * (n + m) + fields * fields / 2.0 * half * half + EVALUATIONS * m * m
    }

    /// Friction forces, and heights where they are inputs.
    fn inputs(&self) -> usize {
        self.contacts.len() + self.height_at.iter().filter(|place| **place != NONE).count()
    }

    /// Entries of a row of coefficients: unknowns, inputs, 1.
    fn width(&self) -> usize {
        self.unknowns.len() + self.inputs() + 1
    }

    /// Coefficients of field `out` in `column`, without what uniform compression adds.
    fn gather(&self, layer: &FlatLayer, out: usize, column: usize, row: &mut [f64]) {
        for place in &self.tied_heights {
            row[*place] = 0.0;
        }
        for run in &self.runs {
            let target = &mut row[run.place..run.place + run.count];
            let source = layer.responses(out, column, run.field, run.first, run.count);
            if run.place < self.unknowns.len() || run.field == 1 {
                target.copy_from_slice(source);
            } else {
                // Friction is positive against sliding: -T is the force.
                target.iter_mut().zip(source).for_each(|(target, source)| *target = -source);
            }
        }
    }

    /// Coefficients of the displacement `field` in `column`.
    fn displacement(&self, layer: &FlatLayer, field: usize, column: usize, row: &mut [f64]) {
        let last = row.len() - 1;
        if field == 1 {
            row.fill(0.0);
            let unknown = self.unknown_at[self.nx + column];
            if unknown != NONE {
                row[unknown] = 1.0;
            } else if self.height_at[column] != NONE {
                row[self.height_at[column]] = 1.0;
            }
        } else {
            self.gather(layer, field, column, row);
            // u_0: one row under P l^2 on a column of width w yields by w / (3 w / 2).
            row[last] = if field % 2 == 1 { -((field / 2) as f64) * 2.0 / 3.0 } else { 0.0 };
        }
    }

    /// Coefficients of R u, two rows for each of the blocks.
    fn missing_forces(&self, lattice: &Lattice, layer: &FlatLayer) -> Vec<f64> {
        let width = self.width();
        let mut displacements = vec![0.0; 2 * self.blocks.len() * width];
        for (rows, &(i, j)) in displacements.chunks_exact_mut(2 * width).zip(&self.blocks) {
            let (x, z) = rows.split_at_mut(width);
            self.displacement(layer, 2 * j, i, x);
            self.displacement(layer, 2 * j + 1, i, z);
        }
        let mut forces = vec![0.0; 2 * self.blocks.len() * width];
        let mut stretch = vec![0.0; width];
        for bond in &self.missing {
            let Some(b) = bond.b else { continue };
            let [kxx, kxy, kyy] = bond.linear();
            // k e e^T = s s^T
            let e = [kxx.sqrt(), if kxy < 0.0 { -kyy.sqrt() } else { kyy.sqrt() }];
            let ends = [bond.a, b].map(|(i, j)| self.number[j * self.nx + i]);
            let of = |block: usize| displacements[2 * block * width..][..2 * width].split_at(width);
            let ((ax, az), (bx, bz)) = (of(ends[0]), of(ends[1]));
            for at in 0..width {
                stretch[at] = e[0] * (ax[at] - bx[at]) + e[1] * (az[at] - bz[at]);
            }
            for ((i, j), block, sign) in [(bond.a, ends[0], 1.0), (b, ends[1], -1.0)] {
                if lattice.is_attached(i, j) {
                    let (x, z) = forces[2 * block * width..][..2 * width].split_at_mut(width);
                    for at in 0..width {
                        x[at] += sign * e[0] * stretch[at];
                        z[at] += sign * e[1] * stretch[at];
                    }
                }
            }
        }
        forces
    }

    /// [`Self::condense`], remembered where that takes many of its `products`.
    fn condense_or_recall(self, lattice: &Lattice, products: f64) -> Option<Arc<CondensedCell>> {
        let condense = || self.condense(lattice).map(Arc::new);
        if products < latest::WORTH_REMEMBERING { condense() } else { latest::LATEST.recall(lattice, condense) }
    }

    /// N_0, A, the ceilings, and the unknowns over T; `None` if the equations are singular.
    fn condense(self, lattice: &Lattice) -> Option<CondensedCell> {
        let w = lattice.columns().first()?.width;
        let layer = &FlatLayer::new(lattice.nx(), w, lattice.ny(), self.explicit);
        let (nx, width) = (self.nx, self.width());
        let (n, m, inputs) = (self.unknowns.len(), self.contacts.len(), self.inputs());
        let forces = self.missing_forces(lattice, layer);
        // What a block of row 0 presses on what is below it: the layer's force less R u.
        let pressed = |column: usize, row: &mut [f64]| {
            self.gather(layer, 1, column, row);
            row[width - 1] = w;
            if self.number[column] != NONE {
                let missing = &forces[(2 * self.number[column] + 1) * width..][..width];
                row.iter_mut().zip(missing).for_each(|(row, missing)| *row -= missing);
            }
        };
        let mut ties = vec![0.0; nx];
        for contact in &self.contacts {
            ties[contact.column] = contact.tie.filter(|_| !contact.lifted).unwrap_or(0.0);
        }
        // M y = B (T, z, 1)
        let mut equations = vec![0.0; n * width];
        for (number, (row, &(field, column))) in equations.chunks_exact_mut(width).zip(&self.unknowns).enumerate() {
            if field == 1 {
                pressed(column, row);
                row[number] += ties[column];
                if self.height_at[column] != NONE {
                    row[self.height_at[column]] -= ties[column];
                }
                let scale = 1.0 / row[number];
                row[..n].iter_mut().for_each(|entry| *entry *= scale);
                row[n..].iter_mut().for_each(|entry| *entry *= -scale);
            } else {
                let block = self.number[field / 2 * nx + column];
                let missing = &forces[(2 * block + field % 2) * width..][..width];
                row.copy_from_slice(missing);
                row[..n].iter_mut().for_each(|entry| *entry = -*entry);
                row[number] += 1.0;
            }
        }
        if !solve_many(&mut equations, n, width) {
            return None;
        }
        let mut unknowns = vec![0.0; n * (inputs + 1)];
        for (unknown, row) in unknowns.chunks_exact_mut(inputs + 1).zip(equations.chunks_exact(width)) {
            unknown.copy_from_slice(&row[n..]);
        }
        let mut influence = vec![0.0; m * inputs];
        let mut at_rest = vec![0.0; m];
        let mut row = vec![0.0; width];
        // Off the counterface nothing presses.
        for (number, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| !contact.lifted) {
            pressed(contact.column, &mut row);
            let (by_unknowns, rest) = row.split_at_mut(n);
            rest.iter_mut().for_each(|entry| *entry = -*entry);
            subtract_products(rest, by_unknowns, &unknowns, inputs + 1, 0);
            // -N
            at_rest[number] = -rest[inputs];
            for (column, entry) in rest[..inputs].iter().enumerate() {
                influence[column * m + number] = *entry;
            }
        }
        let ceilings = (0..nx)
            .filter(|&i| !lattice.columns()[i].is_land())
            .map(|i| {
                let mut height = vec![0.0; width];
                self.displacement(layer, 2 * lattice.lowest_row(i) + 1, i, &mut height);
                Ceiling { depth: lattice.columns()[i].cavity_rows, height }
            })
            .collect();
        let response = Condensed { load: lattice.length(), contacts: self.contacts, influence, at_rest };
        Some(CondensedCell { response, ceilings, unknowns })
    }
}

fn add_to_runs(runs: &mut Vec<Run>, field: usize, column: usize, place: usize) {
    match runs.last_mut() {
        Some(run) if run.field == field && run.first + run.count == column => run.count += 1,
        _ => runs.push(Run { field, first: column, count: 1, place }),
    }
}

mod latest;

#[cfg(test)]
mod tests;
