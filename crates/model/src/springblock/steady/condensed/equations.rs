//! Unknowns of a condensed cell, and the elimination that leaves the equations around its cavities.

use std::sync::Arc;

use super::super::dense::{add_times, elongation, solve_many, subtract_products};
use super::super::flat_layer::FlatLayer;
use super::super::system::{Contact, contacts};
use super::{Ceiling, Condensed, CondensedCell, cell_cache};
use crate::springblock::Lattice;
use crate::springblock::lattice::Bond;

/// Typical number of evaluations of the normal forces for a few loads, for the estimate of operations.
const EVALUATIONS: f64 = 40.0;

/// Compression of one row under uniform pressure, in units of P l^2 / k: P l^2 on a column of width w compresses a row
/// by w / (3 w / 2).
const ROW_DESCENT: f64 = 2.0 / 3.0;
/// Index value that means that there is no index.
const NONE: usize = usize::MAX;

/// Consecutive columns in which one field of the flat layer is an unknown or an input of the cell.
#[derive(Clone, Copy, Debug)]
struct Run {
    field: usize,
    first: usize,
    count: usize,
    /// Index of the first of these columns in a row of coefficients.
    place: usize,
}

/// Layout of the unknowns and inputs of a condensed cell, before any coefficient is computed.
pub struct Equations {
    nx: usize,
    explicit: usize,
    contacts: Vec<Contact>,
    missing: Vec<Bond>,
    /// Index into `blocks` of the block in column i of row j, by j nx + i; [`NONE`] for a block without a missing
    /// spring.
    number: Vec<usize>,
    /// Column and row of each block with a missing spring.
    blocks: Vec<(usize, usize)>,
    /// Index of the unknown in a field of the flat layer and column i, by field * nx + i; [`NONE`] where there is no
    /// unknown.
    unknown_at: Vec<usize>,
    /// Field of the flat layer and column of each unknown.
    unknowns: Vec<(usize, usize)>,
    runs: Vec<Run>,
    /// Index of the face height in a row of coefficients, by column; [`NONE`] if the face height of the column is not
    /// an input.
    height_at: Vec<usize>,
    /// Indices, in a row of coefficients, of the face heights of tied contacts, which are not inputs of any field of
    /// the layer.
    tied_heights: Vec<usize>,
}

impl Equations {
    /// Creates the layout for a periodic lattice of equal columns whose cavities leave at least one row; `None` for
    /// another lattice. With `raised` the heights of the face at the contacts are inputs.
    pub fn for_lattice(lattice: &Lattice, raised: bool) -> Option<Self> {
        let width = lattice.columns().first()?.width;
        let explicit = (lattice.cavity_rows() + 1).max(2);
        if !lattice.is_periodic() || explicit > lattice.ny() || lattice.columns().iter().any(|c| c.width != width) {
            return None;
        }
        let contacts = contacts(lattice, &[], |_| 0);
        let nx = lattice.nx();
        let mut missing = Vec::new();
        let mut number = vec![NONE; explicit * nx];
        let mut blocks = Vec::new();
        let mut unknown_at = vec![NONE; 2 * explicit * nx];
        // Unknowns are marked by 0 here and numbered below.
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
                        // Row 0 is held vertically: the unknown there, if any, is a displacement, not a force.
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
        let mut unknowns = Vec::new();
        let mut runs: Vec<Run> = Vec::new();
        for (at, unknown) in unknown_at.iter_mut().enumerate().filter(|(_, unknown)| **unknown == 0) {
            *unknown = unknowns.len();
            add_to_runs(&mut runs, at / nx, at % nx, unknowns.len());
            unknowns.push((at / nx, at % nx));
        }
        for (contact, place) in contacts.iter().zip(unknowns.len()..) {
            // Friction inputs start a new run, even next to the unknowns of the same field.
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
                // A block tied to the face has its own height, which is an unknown.
                if contact.tie.is_none() {
                    add_to_runs(&mut runs, 1, contact.column, place);
                } else {
                    tied_heights.push(place);
                }
            }
        }
        Some(Self {
            nx,
            explicit,
            contacts,
            missing,
            number,
            blocks,
            unknown_at,
            unknowns,
            runs,
            height_at,
            tied_heights,
        })
    }

    /// Number of multiplications and additions for condensing and for the iterations. The substitutions of the band
    /// solver, which are as many, are not counted for either method.
    pub fn products(&self, lattice: &Lattice) -> f64 {
        let [n, m, missing] = [self.unknowns.len(), self.contacts.len(), self.missing.len()].map(|count| count as f64);
        let (half, fields) = (lattice.nx() as f64 / 2.0, 2.0 * self.explicit as f64);
        let elimination = n * n * n / 3.0 + n * n * m + n * m * m;
        elimination + 8.0 * missing * (n + m) + fields * fields / 2.0 * half * half + EVALUATIONS * m * m
    }

    /// Number of inputs: friction forces, then the heights of the face if the model has heights.
    fn inputs(&self) -> usize {
        self.contacts.len() + self.height_at.iter().filter(|place| **place != NONE).count()
    }

    /// Number of entries of a row of coefficients: one for each unknown and input, and a constant.
    fn width(&self) -> usize {
        self.unknowns.len() + self.inputs() + 1
    }

    /// Sets `row` to the coefficients of the output field `out` of the flat layer in `column`, without uniform
    /// compression.
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
                // Friction is positive against sliding: the force is -T.
                target.iter_mut().zip(source).for_each(|(target, source)| *target = -source);
            }
        }
    }

    /// Sets `row` to the coefficients of the displacement `field` in `column`, with uniform compression.
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
            // u_0
            row[last] = if field % 2 == 1 { -((field / 2) as f64) * ROW_DESCENT } else { 0.0 };
        }
    }

    /// Coefficients of the forces R u, with the stiffness R of the missing springs: a horizontal and a vertical row for
    /// each block with a missing spring.
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
            elongation(&mut stretch, e, [ax, az], [bx, bz]);
            for ((i, j), block, sign) in [(bond.a, ends[0], 1.0), (b, ends[1], -1.0)] {
                if lattice.is_attached(i, j) {
                    let (x, z) = forces[2 * block * width..][..2 * width].split_at_mut(width);
                    add_times(x, sign * e[0], &stretch);
                    add_times(z, sign * e[1], &stretch);
                }
            }
        }
        forces
    }

    /// Like [`Self::condense`], cached: shared by all threads if condensing takes many `products`, otherwise per
    /// thread.
    pub fn condense_cached(self, lattice: &Lattice, products: f64) -> Option<Arc<CondensedCell>> {
        let condense = || self.condense(lattice).map(Arc::new);
        if products < cell_cache::MIN_SHARED_PRODUCTS {
            cell_cache::get_or_condense_per_thread(lattice, condense)
        } else {
            cell_cache::SHARED_CACHE.get_or_condense(lattice, condense)
        }
    }

    /// Condenses the cell to the response of the normal forces, the ceilings, and the unknowns as functions of the
    /// inputs; `None` if the equations are singular.
    pub fn condense(self, lattice: &Lattice) -> Option<CondensedCell> {
        let w = lattice.columns().first()?.width;
        let layer = &FlatLayer::new(lattice.nx(), w, lattice.ny(), self.explicit);
        let (nx, width) = (self.nx, self.width());
        let (n, m, inputs) = (self.unknowns.len(), self.contacts.len(), self.inputs());
        let forces = self.missing_forces(lattice, layer);
        // Downward force of a block of row 0: the force of the layer minus R u.
        let pressed = |column: usize, row: &mut [f64]| {
            self.gather(layer, 1, column, row);
            row[width - 1] = w;
            if self.number[column] != NONE {
                let missing = &forces[(2 * self.number[column] + 1) * width..][..width];
                add_times(row, -1.0, missing);
            }
        };
        let mut ties = vec![0.0; nx];
        for contact in &self.contacts {
            ties[contact.column] = contact.tie.unwrap_or(0.0);
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
        for (number, contact) in self.contacts.iter().enumerate() {
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
        // Betti's theorem with uniform compression, in which the reaction is w and row j descends by 2 j / 3:
        // descent L = 2 ny L / 3 - sum w u - sum 2 j g / 3
        let load = lattice.length();
        let work = |(&(field, _), own): (&(usize, usize), &[f64])| match field {
            1 => w * own[inputs],
            _ if field % 2 == 1 => (field / 2) as f64 * ROW_DESCENT * own[inputs],
            _ => 0.0,
        };
        let work: f64 = self.unknowns.iter().zip(unknowns.chunks_exact(inputs + 1)).map(work).sum();
        let descent = lattice.ny() as f64 * ROW_DESCENT - work / load;
        let response = Condensed { load, contacts: self.contacts, influence, at_rest };
        Some(CondensedCell { response, ceilings, unknowns, descent })
    }
}

fn add_to_runs(runs: &mut Vec<Run>, field: usize, column: usize, place: usize) {
    match runs.last_mut() {
        Some(run) if run.field == field && run.first + run.count == column => run.count += 1,
        _ => runs.push(Run { field, first: column, count: 1, place }),
    }
}
