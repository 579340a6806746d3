//! Leapfrog on a plain cell in space, linear springs, damping implicit.

use super::super::contact::{ContactForce, ContactSums, LocalLaw, Motion};
use super::super::engine::Engine;
use super::super::protocol::Protocol;
use super::super::rows::whole_lines;
use super::super::stencil::fixed_sum;
use super::super::sweep::{Kick, vectorized};
use super::contact::ContactLayer;
use super::field::Field;
use super::slip::SlipBlock;
use super::stencil::Stencil;
use super::sweep::{InsideRows, MoveRow, RowForces};
use crate::draws::Coefficients;
use crate::space::SpaceLattice;

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

/// Forces of a row, or of the whole contact layer.
type Forces = [Vec<f64>; 3];

/// The integrator with its state.
#[derive(Clone, Debug)]
pub struct SpaceLeapfrog<'a> {
    stencil: Stencil,
    field: Field,
    contact: ContactLayer<'a>,
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
            .map(|column| SlipBlock::new(column / nx * padded + column % nx, coefficients[column]))
            .collect();
        let inverse_mass = stencil.contact.iter().flat_map(|row| row.inverse_mass.iter().copied());
        let contact = ContactLayer::new(blocks, law, direction, inverse_mass, kick);
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

    /// Displacements of block (i, j, k).
    #[must_use]
    pub fn displacement(&self, block: [usize; 3]) -> [f64; 3] {
        self.field.displacement(block)
    }

    /// The contact layer.
    #[cfg(test)]
    #[must_use]
    pub const fn contact(&self) -> &ContactLayer<'a> {
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
        for (j, coefficients) in stencil.contact.iter().enumerate() {
            let row = force.each_mut().map(|force| &mut force[j * padded..][..padded]);
            vectorized(RowForces { coefficients, field, layer: 0, row: j, force: row });
        }
        let sums = contact.kick(force.each_ref().map(Vec::as_slice), kick.kept);
        for j in 0..field.ny {
            let start = field.at(0, j, 0);
            for (c, velocity) in contact.velocity().into_iter().enumerate() {
                let now = &field.now[c].rows()[start..][..field.nx];
                let other = &mut field.other[c].rows_mut()[start..][..field.nx];
                for ((other, now), velocity) in other.iter_mut().zip(now).zip(&velocity[j * padded..]) {
                    *other = now + velocity;
                }
            }
        }
        if self.liftoff {
            self.move_vertically();
        }
        sums
    }

    /// Vertical motion of contact blocks under unilateral contact: lifts those under tension, moves those
    /// in the air, lands those that reach the counterface.
    fn move_vertically(&mut self) {
        let Self { stencil, field, contact, kick, contact_force: [_, _, force], fall, .. } = self;
        let padded = whole_lines(field.nx);
        for j in 0..field.ny {
            let (start, nx) = (field.at(0, j, 0), field.nx);
            field.other[2].rows_mut()[start..][..nx].copy_from_slice(&field.now[2].rows()[start..][..nx]);
        }
        for block in contact.unsettled() {
            if block.motion != Motion::Lifted && block.normal < 0.0 {
                block.motion = Motion::Lifted;
            }
            if block.motion == Motion::Lifted {
                let (place, i, j) = (block.place, block.place % padded, block.place / padded);
                let at = field.at(i, j, 0);
                let inverse_mass = stencil.contact[j].inverse_mass[i];
                fall[place] = kick.kept * fall[place] + kick.kick * inverse_mass * force[place];
                let height = field.now[2].rows()[at] + fall[place];
                // Landing ends the vertical motion on the counterface.
                let lands = height <= 0.0;
                field.other[2].rows_mut()[at] = if lands { 0.0 } else { height };
                if lands {
                    fall[place] = 0.0;
                    block.motion = Motion::Slip;
                }
            }
        }
    }

    /// Moves all layers above the contact layer.
    fn step_inside(&mut self) {
        let Self { stencil, field, kick, row_force: force, .. } = self;
        for general in &stencil.general {
            let (layer, row, coefficients) = (general.layer, general.row, &general.coefficients);
            let forces = force.each_mut().map(Vec::as_mut_slice);
            vectorized(RowForces { coefficients, field, layer, row, force: forces });
            let (inverse_mass, force) = (&coefficients.inverse_mass, force.each_ref().map(Vec::as_slice));
            // What lanes beyond the last column write is restored below.
            vectorized(MoveRow { inverse_mass, field, layer, row, kick: *kick, force });
        }
        for tile in (0..field.ny).step_by(TILE) {
            for (layer, ranges) in stencil.inside.iter().enumerate() {
                for rows in ranges {
                    let rows = rows.start.max(tile)..rows.end.min(tile + TILE);
                    if !rows.is_empty() {
                        vectorized(InsideRows { field, layer, rows, kick: *kick });
                    }
                }
            }
        }
    }
}

impl Engine for SpaceLeapfrog<'_> {
    fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    fn step(&mut self) -> ContactSums {
        let time = self.steps as f64 * self.time_step;
        self.steps += 1;
        let bulk = self.bulk(time);
        self.field.place_bulk(bulk);
        let sums = self.step_contact();
        self.step_inside();
        self.field.turn();
        self.field.join_sides();
        sums
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
