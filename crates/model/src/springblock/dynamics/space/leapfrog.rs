//! Leapfrog on a cell of whole cubes in space, with linear springs and implicit damping.
//!
//! A run that starts from sliding in equilibrium stores deviations from that state in single precision, like the
//! integrator in the plane.

use std::ops::Range;

use super::super::contact::{ContactForce, ContactSums};
use super::super::contact_vectors::ContactVectors;
use super::super::engine::{Engine, Setup};
use super::super::protocol::Protocol;
use super::super::real::{AddForces, PlaceContacts, Real, is_in_equilibrium, whole_lines};
use super::super::rows::Plane;
use super::super::stencil::fixed_sum;
use super::super::sweep::{Kick, MoveRow};
use super::bonds::SpaceBonds;
use super::field::Field;
use super::stencil::{GeneralRow, Stencil};
use super::sweep::{InsideRows, RowForces};
use crate::springblock::SpaceLattice;
use slipgrid_base::fft::vectorized;

/// Number of rows of a tile, which is swept layer by layer. Smaller tiles sweep more rows twice; larger tiles lose the
/// cache lines of one vector column from the first-level cache before the next column needs them.
const TILE: usize = 10;

/// Number of layers that a step moves before the next step follows, at least two. Fewer layers increase the share of
/// layers that are read twice from the second-level cache as neighbours; more layers leave that cache before the next
/// step needs them.
const SLAB: usize = 4;

/// Forces or displacements x, y and z of the blocks of a row or of the whole contact layer.
type Forces<R> = [Vec<R>; 3];

/// Leapfrog integrator with its state.
#[derive(Clone, Debug)]
pub struct SpaceLeapfrog<'a, R> {
    stencil: Stencil<R>,
    field: Field<R>,
    /// Number of lines of columns along y that belong to the face.
    lines: usize,
    /// Whether the cell has free ends along y.
    has_ends: bool,
    contact: ContactVectors<'a, 2>,
    protocol: Protocol,
    direction: [f64; 2],
    kick: Kick,
    time_step: f64,
    steps: u64,
    liftoff: bool,
    /// Vertical displacements of lifted contact blocks during the last step, by column, in lattice spacings.
    fall: Vec<f64>,
    row_force: Forces<R>,
    /// Displacements of the contact layer from the base state, in the frame at rest and in double precision.
    contact_place: Forces<f64>,
    /// Spring forces on the contact layer, in double precision.
    contact_force: Forces<f64>,
    /// Spring forces on the contact layer in the base state, in units of k l (spring stiffness times lattice spacing).
    base_force: Forces<f64>,
    /// Displacements x, y and z of the base state, in lattice spacings, from which stored displacements deviate; index
    /// (k ny + j) nx + i for block (i, j, k). Empty without a base state.
    base: Vec<[f64; 3]>,
    /// Drag of the moving frame along x and y, from [`Kick::drag`].
    drag: [f64; 2],
}

impl<'a> SpaceLeapfrog<'a, f64> {
    /// Creates the integrator with a lattice of whole cubes at rest.
    pub fn new(lattice: &SpaceLattice, setup: Setup<'a, 2>) -> Self {
        let kick = Kick::new(setup.time_step, setup.damping);
        Self::with_kick(lattice, setup, kick)
    }
}

impl<'a> SpaceLeapfrog<'a, f32> {
    /// Creates the integrator with a lattice of whole cubes in the sliding state `base`.
    ///
    /// `base` has the displacements, in lattice spacings, in equilibrium under the load of `setup`, with index (k ny +
    /// j) nx + i for block (i, j, k). The bulk moves at the speed of `setup` from the first step on. Returns `None` if
    /// unbalanced forces remain above the contact layer.
    pub fn from_sliding(lattice: &SpaceLattice, setup: Setup<'a, 2>, base: &[[f64; 3]]) -> Option<Self> {
        let Setup { protocol, time_step, damping, direction, .. } = setup;
        let mut sliding = Self::with_kick(lattice, setup, Kick::new(time_step, damping).rounded::<f32>());
        let bonds = SpaceBonds::new(lattice);
        let mut u = base.to_vec();
        u.push([0.0; 3]);
        bonds.balance(&mut u, protocol.load(0.0));
        let mut force = vec![[0.0; 3]; u.len()];
        bonds.forces(&u, &mut force);
        let [nx, ny] = lattice.columns();
        let largest = |forces: &[[f64; 3]]| forces.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs()));
        if !is_in_equilibrium(largest(&force[nx * ny..nx * ny * lattice.rows()]), largest(&force[..nx * ny])) {
            return None;
        }
        let padded = whole_lines::<f32>(nx);
        for (column, force) in force[..nx * ny].iter().enumerate() {
            let place = column / nx * padded + column % nx;
            for (base, force) in sliding.base_force.iter_mut().zip(force) {
                base[place] = *force;
            }
        }
        // Displacement relative to the frame one step earlier.
        let carried = direction.map(|part| part * protocol.speed * time_step);
        sliding.field.offset_previous(carried);
        sliding.drag = carried.map(|carried| sliding.kick.drag(carried));
        Some(Self { base: base.to_vec(), ..sliding })
    }
}

impl<'a, R: Real> SpaceLeapfrog<'a, R> {
    fn with_kick(lattice: &SpaceLattice, setup: Setup<'a, 2>, kick: Kick) -> Self {
        let Setup { contact, protocol, direction, time_step, liftoff, .. } = setup;
        let [nx, ny] = lattice.columns();
        let padded = whole_lines::<R>(nx);
        let stencil = Stencil::<R>::new(lattice);
        let (mut blocks, law) = contact.into_parts();
        for block in &mut blocks {
            block.column = block.column / nx * padded + block.column % nx;
        }
        let inverse_mass = stencil.general[0].iter().flat_map(|row| &row.coefficients.inverse_mass);
        let inverse_mass = inverse_mass.map(|inverse| inverse.to_f64());
        let contact = ContactVectors::new(blocks, law, direction, inverse_mass, kick);
        let zeros = || [0; 3].map(|_| vec![0.0; padded * ny]);
        Self {
            stencil,
            field: Field::at_rest([nx, ny], lattice.rows()),
            lines: lattice.face_columns() / nx,
            has_ends: lattice.face_columns() < nx * ny,
            contact,
            protocol,
            direction,
            kick,
            time_step,
            steps: 0,
            liftoff,
            fall: vec![0.0; padded * ny],
            row_force: [0; 3].map(|_| vec![R::default(); padded]),
            contact_place: zeros(),
            contact_force: zeros(),
            base_force: zeros(),
            base: Vec::new(),
            drag: [0.0; 2],
        }
    }

    /// Sets the initial displacements, in lattice spacings, which `displacement` returns for block (i, j, k), with
    /// every block at rest.
    pub fn start_sheared(&mut self, displacement: &dyn Fn([usize; 3]) -> [f64; 3]) {
        let Field { nx, ny, nz, .. } = self.field;
        for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
            let displacement = displacement([i, j, k]);
            self.field.place([i, j, k], displacement);
            if k == 0 {
                let place = j * whole_lines::<R>(nx) + i;
                for (own, u) in self.contact_place.iter_mut().zip(displacement) {
                    own[place] = u;
                }
            }
        }
        self.field.fill_all_images();
    }

    /// Displacements x, y and z of block (i, j, k), in lattice spacings.
    pub fn displacement(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let deviation = self.field.displacement([i, j, k]);
        let Field { nx, ny, .. } = self.field;
        let Some(base) = self.base.get((k * ny + j) * nx + i) else { return deviation };
        let [x, y] = self.carried(self.steps);
        let carried = [x, y, 0.0];
        std::array::from_fn(|c| base[c] + deviation[c] + carried[c])
    }

    /// Displacement of the moving frame along x and y after `steps` steps, in lattice spacings: the displacement of the
    /// bulk if there is a base state, otherwise zero.
    fn carried(&self, steps: u64) -> [f64; 2] {
        let travel = if self.base.is_empty() { 0.0 } else { self.protocol.bulk_x(steps as f64 * self.time_step) };
        self.direction.map(|part| part * travel)
    }

    #[cfg(test)]
    pub const fn contact(&self) -> &ContactVectors<'a, 2> {
        &self.contact
    }

    /// Displacements x, y and z of the bulk relative to the moving frame, in lattice spacings, at the beginning of step
    /// number `step`; z balances the load.
    fn bulk(&self, step: u64) -> [f64; 3] {
        let time = step as f64 * self.time_step;
        let Field { nx, nz, .. } = self.field;
        let (lines, [_, y, z]) = (self.lines, &self.field.now);
        let line = |values: &Plane<R>, j: usize| fixed_sum(&values.rows()[self.field.index(0, j, nz - 1)..][..nx]);
        let top: f64 = (0..lines).map(|j| line(z, j)).sum();
        let (travel, carried) = (self.protocol.bulk_x(time), self.carried(step));
        let [x, own_y] = [0, 1].map(|axis: usize| self.direction[axis] * travel - carried[axis]);
        // The base state already balances the load.
        let load = if self.base.is_empty() { self.protocol.load(time) } else { 0.0 };
        let blocks = (nx * lines) as f64;
        // 3 sum (H - u_z) = -load: each block has one vertical and four diagonal springs; horizontal forces cancel.
        let height = top / blocks - load / (3.0 * blocks);
        if !self.has_ends {
            return [x, own_y, height];
        }
        // At either end each block lacks one diagonal, and the remaining one pulls sideways:
        // (3 n - n_x) H = 3 sum u_z - (u_z,first + u_z,last)/2 + (u_y,first - u_y,last)/2 - load
        let [first, last] = [0, lines - 1];
        let ends = line(y, first) - line(y, last) - line(z, first) - line(z, last);
        [x, own_y, (3.0 * top + 0.5 * ends - load) / (3.0 * blocks - nx as f64)]
    }

    /// Computes the forces on the contact layer, applies friction, and moves the layer in step number `step`; returns
    /// the sums of contact forces.
    fn step_contact(&mut self, step: u64) -> ContactSums {
        let carried = self.carried(step + 1);
        let Self { stencil, field, contact, kick, contact_force, row_force, base_force, contact_place, .. } = self;
        let padded = whole_lines::<R>(field.nx);
        for GeneralRow { row, coefficients } in &stencil.general[0] {
            let row = *row;
            let force = row_force.each_mut().map(Vec::as_mut_slice);
            vectorized(RowForces { coefficients, field, layer: 0, row, force });
            let own = row * padded..(row + 1) * padded;
            for ((force, base), total) in row_force.iter().zip(&*base_force).zip(&mut *contact_force) {
                vectorized(AddForces { force, base_force: &base[own.clone()], total: &mut total[own.clone()] });
            }
        }
        let [x, y, lift] = contact_force.each_ref().map(Vec::as_slice);
        let sums = contact.kick([x, y], lift, kick.kept);
        for j in 0..field.ny {
            let (start, columns) = (field.index(0, j, 0), field.nx);
            for (c, velocity) in contact.velocity().into_iter().enumerate() {
                let (place, velocity) = (&mut contact_place[c][j * padded..], &velocity[j * padded..][..columns]);
                let row = &mut field.other[c].rows_mut()[start..][..columns];
                vectorized(PlaceContacts { place, velocity, carried: carried[c], row });
            }
        }
        if self.liftoff {
            self.move_vertically();
        }
        self.field.join_rows(0, 0..self.field.ny);
        sums
    }

    /// Moves contact blocks vertically under unilateral contact.
    fn move_vertically(&mut self) {
        let Self { stencil, field, contact, kick, contact_force: [_, _, force], fall, base, .. } = self;
        let [_, _, rises] = &mut self.contact_place;
        let (nx, padded) = (field.nx, whole_lines::<R>(field.nx));
        // Without a base state its height is 0.
        let base_height = |place: usize| base.get(place / padded * nx + place % padded).map_or(0.0, |base| base[2]);
        let inverse_mass =
            |place: usize| stencil.general[0][place / padded].coefficients.inverse_mass[place % padded].to_f64();
        contact.move_vertically(*kick, force, (&mut *rises, fall), base_height, inverse_mass);
        for j in 0..field.ny {
            let start = field.index(0, j, 0);
            let row = &mut field.other[2].rows_mut()[start..][..nx];
            for (row, rise) in row.iter_mut().zip(&rises[j * padded..]) {
                *row = R::round_from(*rise);
            }
        }
    }

    /// Takes one step of `layers` except the contact layer.
    fn step_inside(&mut self, layers: Range<usize>) {
        let Self { stencil, field, kick, row_force: force, drag, .. } = self;
        let [drag_x, drag_y] = *drag;
        let layers = layers.start.max(1)..layers.end;
        for layer in layers.clone() {
            for GeneralRow { row, coefficients } in &stencil.general[layer] {
                let forces = force.each_mut().map(Vec::as_mut_slice);
                vectorized(RowForces { coefficients, field, layer, row: *row, force: forces });
                let (inverse_mass, force) = (&coefficients.inverse_mass, force.each_ref().map(Vec::as_slice));
                // Vector lanes beyond the last column overwrite ghost values, which `join_rows` restores.
                let (columns, start) = (field.nx, field.index(0, *row, layer));
                let (now, other) = (&field.now, &mut field.other);
                let drag = [drag_x, drag_y, 0.0];
                vectorized(MoveRow { inverse_mass, now, other, columns, start, kick: *kick, drag, force });
                field.join_rows(layer, *row..*row + 1);
            }
        }
        for tile in (0..field.ny).step_by(TILE) {
            for layer in layers.clone() {
                for rows in &stencil.inside[layer] {
                    let rows = rows.start.max(tile)..rows.end.min(tile + TILE);
                    if !rows.is_empty() {
                        vectorized(InsideRows { field, layer, rows: rows.clone(), kick: *kick, drag: *drag });
                        field.join_rows(layer, rows);
                    }
                }
            }
        }
    }

    /// Takes step number `step` in the layers `layers`; returns the sums of forces over the contact layer, or zeros if
    /// `layers` does not include the contact layer. The top layer comes first, because the bulk's position follows from
    /// the top layer of the previous step.
    fn move_layers(&mut self, layers: Range<usize>, step: u64) -> ContactSums {
        if layers.end == self.field.nz {
            let bulk = self.bulk(step);
            self.field.place_bulk(bulk);
        }
        self.step_inside(layers.clone());
        let sums = if layers.start == 0 { self.step_contact(step) } else { ContactSums::default() };
        self.field.join_ends(layers);
        self.field.swap();
        sums
    }
}

impl<R: Real> Engine for SpaceLeapfrog<'_, R> {
    fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let sums = self.move_layers(0..self.field.nz, self.steps);
        self.steps += 1;
        sums
    }

    /// The second step follows the first from the top down, one layer behind it. The layers that the second step reads
    /// are then still in the second-level cache, into which cells of 40 x 40 columns and more do not fit. The first
    /// step no longer needs the layers that the second overwrites.
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

    fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.contact.forces().collect()
    }
}
