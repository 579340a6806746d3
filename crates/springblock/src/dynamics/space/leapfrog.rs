//! Leapfrog on a plain cell in space, linear springs, damping implicit.

use std::ops::Range;

use super::super::contact::{ContactBlock, ContactForce, ContactSums, LocalLaw};
use super::super::contact_vectors::ContactVectors;
use super::super::engine::Engine;
use super::super::protocol::Protocol;
use super::super::rows::whole_lines;
use super::super::stencil::fixed_sum;
use super::super::sweep::{Kick, MoveRow};
use super::field::Field;
use super::stencil::{GeneralRow, Stencil};
use super::sweep::{InsideRows, RowForces};
use crate::draws::Coefficients;
use crate::space::SpaceLattice;
use slipgrid_fft::vectorized;

/// What the leapfrog starts from, beside the lattice. Units: k = 1, l = 1, m = 1.
#[derive(Clone, Debug)]
pub struct SpaceSetup<'a> {
    /// Coefficients of all columns, x fastest.
    pub coefficients: &'a [Coefficients],
    /// Friction law.
    pub law: LocalLaw<'a>,
    /// Load and motion of the bulk.
    pub protocol: Protocol,
    /// Unit vector of the sliding direction.
    pub direction: [f64; 2],
    /// Time step.
    pub time_step: f64,
    /// Damping frequency gamma.
    pub damping: f64,
    /// Contact is unilateral.
    pub liftoff: bool,
}

/// Rows of a tile, which is swept from layer to layer: fewer sweep more rows twice, with more the lines of one column
/// of vectors leave the first-level cache before the next column needs them.
const TILE: usize = 10;

/// Layers that a step moves before the next step follows, at least two. With fewer, a larger share of layers is read twice from the
/// second-level cache, as neighbours; with more they leave that cache before the next step needs them.
const SLAB: usize = 4;

/// Forces of a row, or of the whole contact layer.
type Forces = [Vec<f64>; 3];

/// The integrator with its state.
#[derive(Clone, Debug)]
pub struct SpaceLeapfrog<'a> {
    stencil: Stencil,
    field: Field,
    contact: ContactVectors<'a, 2>,
    protocol: Protocol,
    direction: [f64; 2],
    kick: Kick,
    time_step: f64,
    steps: u64,
    liftoff: bool,
    /// Vertical displacements of the last step of contact blocks in the air, by place.
    fall: Vec<f64>,
    contact_force: Forces,
    row_force: Forces,
}

impl<'a> SpaceLeapfrog<'a> {
    /// A plain lattice at rest.
    #[must_use]
    pub fn new(lattice: &SpaceLattice, setup: SpaceSetup<'a>) -> Self {
        let SpaceSetup { coefficients, law, protocol, direction, time_step, damping, liftoff } = setup;
        let [nx, ny] = lattice.columns();
        let padded = whole_lines(nx);
        let kick = Kick::new(time_step, damping);
        let stencil = Stencil::new(lattice);
        let blocks = (0..nx * ny)
            .filter(|column| lattice.contact_share(column % nx, column / nx) > 0.0)
            .map(|column| ContactBlock::new(column / nx * padded + column % nx, coefficients[column]))
            .collect();
        let inverse_mass = stencil.general[0].iter().flat_map(|row| row.coefficients.inverse_mass.iter().copied());
        let contact = ContactVectors::new(blocks, law, direction, inverse_mass, kick);
        let zero = |size: usize| [vec![0.0; size], vec![0.0; size], vec![0.0; size]];
        Self {
            stencil,
            field: Field::at_rest([nx, ny], lattice.rows()),
            contact,
            protocol,
            direction,
            kick,
            time_step,
            steps: 0,
            liftoff,
            fall: vec![0.0; padded * ny],
            contact_force: zero(padded * ny),
            row_force: zero(padded),
        }
    }

    /// Starts from given displacements over l, by (i, j, k), every block at rest.
    pub fn start_sheared(&mut self, displacement: &dyn Fn([usize; 3]) -> [f64; 3]) {
        let Field { nx, ny, nz, .. } = self.field;
        for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
            self.field.place([i, j, k], displacement([i, j, k]));
        }
        self.field.join_sides();
    }

    /// Raises the faces of the contact blocks as those of `lattice` are; what stands higher begins off the counterface. After
    /// [`Self::start_sheared`].
    pub fn raise(&mut self, lattice: &SpaceLattice) {
        let padded = whole_lines(self.field.nx);
        let Self { field, contact, .. } = self;
        contact.place(|place| {
            let (i, j) = (place % padded, place / padded);
            [lattice.relief(i, j), field.displacement([i, j, 0])[2]]
        });
    }

    /// Displacements of block (i, j, k).
    #[must_use]
    pub fn displacement(&self, block: [usize; 3]) -> [f64; 3] {
        self.field.displacement(block)
    }

    /// The contact layer.
    #[cfg(test)]
    #[must_use]
    pub const fn contact(&self) -> &ContactVectors<'a, 2> {
        &self.contact
    }

    /// Displacements of the bulk at `time` that balance the load.
    fn bulk(&self, time: f64) -> [f64; 3] {
        let Field { nx, ny, nz, .. } = self.field;
        let z = self.field.now[2].rows();
        let top: f64 = (0..ny).map(|j| fixed_sum(&z[self.field.at(0, j, nz - 1)..][..nx])).sum();
        // 3 sum (H - u_z) = -load: one vertical spring and four diagonals a block; sideways they cancel.
        let blocks = (nx * ny) as f64;
        let travel = self.protocol.bulk_x(time);
        let [x, y] = self.direction;
        [x * travel, y * travel, top / blocks - self.protocol.load(time) / (3.0 * blocks)]
    }

    /// Forces on the contact layer, friction, and its motion.
    fn step_contact(&mut self) -> ContactSums {
        let Self { stencil, field, contact, kick, contact_force: force, .. } = self;
        let padded = whole_lines(field.nx);
        for GeneralRow { row, coefficients } in &stencil.general[0] {
            let (row, force) = (*row, force.each_mut().map(|force| &mut force[row * padded..][..padded]));
            vectorized(RowForces { coefficients, field, layer: 0, row, force });
        }
        let [x, y, lift] = force.each_ref().map(Vec::as_slice);
        let sums = contact.kick([x, y], lift, kick.kept);
        for j in 0..field.ny {
            let start = field.at(0, j, 0);
            for (c, velocity) in contact.velocity().into_iter().enumerate() {
                field.other[c].place_moved(&field.now[c], start, &velocity[j * padded..][..field.nx]);
            }
        }
        if self.liftoff {
            self.move_vertically();
        }
        sums
    }

    /// Vertical motion of contact blocks under unilateral contact.
    fn move_vertically(&mut self) {
        let Self { stencil, field, contact, kick, contact_force: [_, _, force], fall, .. } = self;
        let padded = whole_lines(field.nx);
        for j in 0..field.ny {
            let (start, nx) = (field.at(0, j, 0), field.nx);
            field.other[2].rows_mut()[start..][..nx].copy_from_slice(&field.now[2].rows()[start..][..nx]);
        }
        for block in contact.unsettled() {
            let (place, i, j) = (block.column, block.column % padded, block.column / padded);
            let (at, inverse_mass) = (field.at(i, j, 0), stencil.general[0][j].coefficients.inverse_mass[i]);
            let height = field.now[2].rows()[at];
            if let Some(height) = block.fly(height, &mut fall[place], *kick, inverse_mass, force[place]) {
                field.other[2].rows_mut()[at] = height;
            }
        }
    }

    /// Moves `layers`, the contact layer apart.
    fn step_inside(&mut self, layers: Range<usize>) {
        let Self { stencil, field, kick, row_force: force, .. } = self;
        let layers = layers.start.max(1)..layers.end;
        for layer in layers.clone() {
            for GeneralRow { row, coefficients } in &stencil.general[layer] {
                let forces = force.each_mut().map(Vec::as_mut_slice);
                vectorized(RowForces { coefficients, field, layer, row: *row, force: forces });
                let (inverse_mass, force) = (&coefficients.inverse_mass, force.each_ref().map(Vec::as_slice));
                // What lanes beyond the last column write is restored when sides are joined.
                let (columns, start) = (field.nx, field.at(0, *row, layer));
                let (now, other) = (&field.now, &mut field.other);
                vectorized(MoveRow { inverse_mass, now, other, columns, start, kick: *kick, force });
            }
        }
        for tile in (0..field.ny).step_by(TILE) {
            for layer in layers.clone() {
                for rows in &stencil.inside[layer] {
                    let rows = rows.start.max(tile)..rows.end.min(tile + TILE);
                    if !rows.is_empty() {
                        vectorized(InsideRows { field, layer, rows, kick: *kick });
                    }
                }
            }
        }
    }

    /// Takes step number `step` in `layers`; the sums over the contact layer, zero where it is not among them. What a step needs of
    /// the bulk is known once the top layer is where the step before has moved it.
    fn move_layers(&mut self, layers: Range<usize>, step: u64) -> ContactSums {
        if layers.end == self.field.nz {
            let bulk = self.bulk(step as f64 * self.time_step);
            self.field.place_bulk(bulk);
        }
        self.step_inside(layers.clone());
        let sums = if layers.start == 0 { self.step_contact() } else { ContactSums::default() };
        self.field.join_layers(layers);
        self.field.turn();
        sums
    }
}

impl Engine for SpaceLeapfrog<'_> {
    fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let sums = self.move_layers(0..self.field.nz, self.steps);
        self.steps += 1;
        sums
    }

    /// The second step follows the first from the top down, one layer behind it: the layers that it needs are still in the
    /// second-level cache, which cells of 40 x 40 columns and more do not fit into, and those that it replaces nobody needs any more.
    fn one_or_two_steps(&mut self) -> (ContactSums, Option<ContactSums>) {
        let (top, step) = (self.field.nz, self.steps);
        let mut upper = top;
        while upper > SLAB {
            let lower = upper - SLAB;
            self.move_layers(lower..upper, step);
            self.move_layers(lower + 1..top.min(upper + 1), step + 1);
            upper = lower;
        }
        let first = self.move_layers(0..upper, step);
        self.steps += 1;
        if !first.is_finite() {
            return (first, None);
        }
        let second = self.move_layers(0..top.min(upper + 1), step + 1);
        self.steps += 1;
        (first, Some(second))
    }

    fn all_have_slipped(&self) -> bool {
        self.contact.all_have_slipped()
    }

    fn contacts(&self) -> usize {
        self.contact.len()
    }

    fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.contact.forces().collect()
    }

    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn evaluations_per_step(&self) -> u64 {
        1
    }
}
