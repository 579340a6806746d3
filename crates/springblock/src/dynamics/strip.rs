//! A strip of columns with its state: what one thread advances by one step.

use std::ops::Range;

use super::contact::{ContactBlock, ContactSums, LocalLaw};
use super::contact_vectors::ContactVectors;
use super::rows::{Field, whole_lines};
use super::stencil::StripStencil;
use super::sweep::{ContactRowForces, InsideRows, Kick, MoveRow, RowForces, side};
use slipgrid_fft::vectorized;

/// What a step needs from outside the strip.
#[derive(Clone, Copy, Debug)]
pub struct BulkPlace {
    /// Horizontal displacement of the bulk.
    pub x: f64,
    /// Its vertical displacement.
    pub height: f64,
}

/// One side of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

/// A strip of the lattice.
#[derive(Clone, Debug)]
pub struct Strip<'a> {
    stencil: StripStencil,
    field: Field,
    contact: ContactVectors<'a, 1>,
    kick: Kick,
    liftoff: bool,
    /// Vertical displacements of the last step of contact blocks in the air, by column.
    fall: Vec<f64>,
    force: [Vec<f64>; 2],
    at_sides: Vec<[f64; 2]>,
}

impl<'a> Strip<'a> {
    /// A strip of `rows` rows at rest; `blocks`: the contact blocks of the whole lattice.
    #[must_use]
    pub fn new(
        stencil: StripStencil,
        rows: usize,
        blocks: &[ContactBlock<1>],
        law: LocalLaw<'a>,
        kick: Kick,
        liftoff: bool,
    ) -> Self {
        let columns = stencil.columns.clone();
        let nx = columns.len();
        let own = blocks
            .iter()
            .filter(|block| columns.contains(&block.column))
            .map(|block| {
                let mut own = *block;
                own.column -= columns.start;
                own
            })
            .collect();
        let contact = ContactVectors::new(own, law, [1.0], stencil.general[0].inverse_mass.iter().copied(), kick);
        Self {
            stencil,
            field: Field::at_rest(nx, rows),
            contact,
            kick,
            liftoff,
            fall: vec![0.0; nx],
            force: [vec![0.0; whole_lines(nx)], vec![0.0; whole_lines(nx)]],
            at_sides: Vec::new(),
        }
    }

    /// Its columns in the lattice.
    #[must_use]
    pub const fn columns(&self) -> &Range<usize> {
        &self.stencil.columns
    }

    /// The contact blocks.
    #[must_use]
    pub const fn contact(&self) -> &ContactVectors<'a, 1> {
        &self.contact
    }

    /// The bulk begins to move.
    pub fn begin_drive(&mut self) {
        self.contact.begin_drive();
    }

    /// Starts from given displacements, by column of the lattice and row, at rest.
    pub fn start(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for j in 0..self.field.ny {
            for i in 0..self.field.nx {
                let at = self.field.at(i, j);
                let u = displacement(self.stencil.columns.start + i, j);
                for (component, u) in u.into_iter().enumerate() {
                    self.field.now[component].rows_mut()[at] = u;
                    self.field.other[component].rows_mut()[at] = u;
                }
            }
        }
    }

    /// What the top row takes of the balance of the bulk.
    #[must_use]
    pub fn held(&self) -> f64 {
        self.stencil.held(&self.field)
    }

    /// Displacements of block (i, j), i within the strip.
    #[must_use]
    pub fn displacement(&self, i: usize, j: usize) -> [f64; 2] {
        let at = self.field.at(i, j);
        [0, 1].map(|component: usize| self.field.now[component].rows()[at])
    }

    /// Joins the left side to the right side: a strip that is a whole period.
    pub fn join_sides(&mut self) {
        let (first, nx, stride) = (self.field.at(0, 0), self.field.nx, self.field.stride);
        for plane in &mut self.field.now {
            // The image of the last column, then the columns, then the image of the first.
            for row in plane.rows_mut()[first - 1..].chunks_exact_mut(stride).take(self.field.ny) {
                row[0] = row[nx];
                row[nx + 1] = row[1];
            }
        }
    }

    /// Values that a neighbour needs: both displacements of every row, one side's column.
    #[must_use]
    pub const fn edge_len(&self) -> usize {
        2 * self.field.ny
    }

    /// Hands the values of the column at `from` to `give`, row by row.
    pub fn edge(&self, from: Side, mut give: impl FnMut(usize, f64)) {
        let column = match from {
            Side::Left => 0,
            Side::Right => self.field.nx - 1,
        };
        let (at, stride, ny) = (self.field.at(column, 0), self.field.stride, self.field.ny);
        for (component, plane) in self.field.now.iter().enumerate() {
            for (j, value) in plane.rows()[at..].iter().step_by(stride).take(ny).enumerate() {
                give(component * ny + j, *value);
            }
        }
    }

    /// Takes the values of the column beyond `beyond`, as [`Strip::edge`] numbers them.
    pub fn set_image(&mut self, beyond: Side, mut take: impl FnMut(usize) -> f64) {
        let at = match beyond {
            Side::Left => self.field.at(0, 0) - 1,
            Side::Right => self.field.at(self.field.nx, 0),
        };
        let (stride, ny) = (self.field.stride, self.field.ny);
        for (component, plane) in self.field.now.iter_mut().enumerate() {
            for (j, value) in plane.rows_mut()[at..].iter_mut().step_by(stride).take(ny).enumerate() {
                *value = take(component * ny + j);
            }
        }
    }

    /// Advances by one step; the sums over the strip's contact blocks at its beginning. The images of the
    /// neighbours' columns must be those of this instant.
    pub fn step(&mut self, bulk: BulkPlace) -> ContactSums {
        self.place_bulk(bulk);
        let Self { stencil, field, contact, kick, force: [force_x, force_y], .. } = self;
        let mut sums = ContactSums::default();
        for (row, coefficients) in stencil.general.iter().enumerate() {
            if row == 0 && !self.liftoff {
                vectorized(ContactRowForces { coefficients, field, force_x, force_y });
            } else {
                vectorized(RowForces { coefficients, field, row, force_x, force_y });
            }
            if row == 0 {
                sums = contact.kick([force_x], force_y, kick.kept);
                let [velocity] = contact.velocity();
                field.other[0].place_moved(&field.now[0], field.at(0, 0), &velocity[..field.nx]);
                if self.liftoff {
                    move_vertically(contact, *kick, &coefficients.inverse_mass, force_y, field, &mut self.fall);
                }
            } else {
                let inverse_mass = &coefficients.inverse_mass;
                let (columns, start) = (field.nx, field.at(0, row));
                let (now, other, force) = (&field.now, &mut field.other, [&force_x[..], force_y]);
                vectorized(MoveRow { inverse_mass, now, other, columns, start, kick: *kick, force });
            }
        }
        let from = stencil.general.len();
        self.at_sides.clear();
        for (i, sites) in &stencil.sides {
            self.at_sides.extend((from..).zip(sites).map(|(j, site)| side(site, field, *i, j, *kick)));
        }
        vectorized(InsideRows { field, from, kick: *kick });
        let mut moved = self.at_sides.iter();
        for (i, sites) in &stencil.sides {
            for ((j, _), moved) in (from..).zip(sites).zip(&mut moved) {
                let at = field.at(*i, j);
                field.other[0].rows_mut()[at] = moved[0];
                field.other[1].rows_mut()[at] = moved[1];
            }
        }
        field.turn();
        sums
    }

    fn place_bulk(&mut self, bulk: BulkPlace) {
        let (start, end) = (self.field.at(0, self.field.ny) - 1, self.field.at(self.field.nx, self.field.ny) + 1);
        for (plane, value) in self.field.now.iter_mut().zip([bulk.x, bulk.height]) {
            plane.rows_mut()[start..end].fill(value);
        }
    }
}

/// Vertical motion of contact blocks under unilateral contact.
fn move_vertically(
    contact: &mut ContactVectors<1>,
    kick: Kick,
    inverse_mass: &[f64],
    force_y: &[f64],
    field: &mut Field,
    fall: &mut [f64],
) {
    let start = field.at(0, 0);
    let (now, other) = (&field.now[1].rows()[start..][..field.nx], &mut field.other[1].rows_mut()[start..]);
    other[..field.nx].copy_from_slice(now);
    for block in contact.unsettled() {
        let i = block.column;
        if let Some(height) = block.fly(now[i], &mut fall[i], kick, inverse_mass[i], force_y[i]) {
            other[i] = height;
        }
    }
}
