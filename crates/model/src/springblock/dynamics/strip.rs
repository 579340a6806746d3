//! A strip of columns with its state, the part of a lattice that one thread advances.

use std::ops::Range;

use super::contact::{ContactBlock, ContactSums, LocalLaw};
use super::contact_vectors::ContactVectors;
use super::real::{AddForces, PlaceContacts, Real, whole_lines};
use super::rows::Field;
use super::stencil::StripStencil;
use super::sweep::{InsideRows, Kick, MoveRow, RowForces, move_side_block};
use slipgrid_base::fft::vectorized;

/// Displacements of the bulk and of the moving frame in a step, in lattice spacings.
#[derive(Clone, Copy, Debug)]
pub struct BulkPosition {
    /// Horizontal displacement of the bulk relative to the moving frame.
    pub x: f64,
    /// Vertical displacement of the bulk.
    pub height: f64,
    /// Horizontal displacement of the moving frame after the step.
    pub carried: f64,
}

/// Base state, with every block above the contact row in equilibrium. Stored displacements are deviations from this
/// state, in a frame that moves with the bulk.
#[derive(Clone, Debug)]
pub struct Base {
    /// Horizontal and vertical spring forces on the contact row, by column, in units of k l (spring stiffness times
    /// lattice spacing).
    pub force: [Vec<f64>; 2],
    /// Vertical displacements of the contact row, by column, in lattice spacings.
    pub height: Vec<f64>,
    /// Displacement of the moving frame per step, in lattice spacings.
    pub carried: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

/// A strip of the lattice with its state.
#[derive(Clone, Debug)]
pub struct Strip<'a, R> {
    stencil: StripStencil<R>,
    field: Field<R>,
    pub contact: ContactVectors<'a, 1>,
    kick: Kick,
    /// Drag of the moving frame, from [`Kick::drag`].
    drag: f64,
    liftoff: bool,
    /// Vertical displacements of lifted contact blocks during the last step, by column, in lattice spacings.
    fall: Vec<f64>,
    force: [Vec<R>; 2],
    at_sides: Vec<[f64; 2]>,
    /// Displacements x and y of the contact row from the base state, in the frame at rest and in double precision.
    contact_place: [Vec<f64>; 2],
    /// Spring forces x and y on the contact row, including those of the base state, in double precision.
    contact_force: [Vec<f64>; 2],
    base: Base,
}

impl<'a, R: Real> Strip<'a, R> {
    /// Creates a strip of `rows` rows at rest; `blocks` are the contact blocks of the whole lattice.
    pub fn new(
        stencil: StripStencil<R>,
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
            .map(|block| ContactBlock { column: block.column - columns.start, ..*block })
            .collect();
        let inverse_mass = stencil.general[0].inverse_mass.iter().map(|inverse| inverse.to_f64());
        let contact = ContactVectors::new(own, law, [1.0], inverse_mass, kick);
        let padded = whole_lines::<R>(nx);
        let zeros = || [vec![0.0; padded], vec![0.0; padded]];
        Self {
            stencil,
            field: Field::at_rest(nx, rows),
            contact,
            kick,
            drag: 0.0,
            liftoff,
            fall: vec![0.0; nx],
            force: [vec![R::default(); padded], vec![R::default(); padded]],
            at_sides: Vec::new(),
            contact_place: zeros(),
            contact_force: zeros(),
            base: Base { force: zeros(), height: vec![0.0; padded], carried: 0.0 },
        }
    }

    /// Columns of the strip in the lattice.
    pub const fn columns(&self) -> &Range<usize> {
        &self.stencil.columns
    }

    /// Sets the initial displacements x and y, in lattice spacings, which `displacement` returns for a column of the
    /// lattice and a row, with every block at rest.
    pub fn start(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]) {
        for j in 0..self.field.ny {
            for i in 0..self.field.nx {
                let at = self.field.index(i, j);
                let u = displacement(self.stencil.columns.start + i, j);
                for (component, u) in u.into_iter().enumerate() {
                    self.field.now[component].rows_mut()[at] = R::round_from(u);
                    self.field.other[component].rows_mut()[at] = R::round_from(u);
                    if j == 0 {
                        self.contact_place[component][i] = u;
                    }
                }
            }
        }
    }

    /// Sets the base state `base`, indexed by column of the whole lattice, from which the stored displacements deviate,
    /// and starts the moving frame.
    pub fn set_base(&mut self, base: &Base) {
        let (columns, padded) = (self.stencil.columns.clone(), whole_lines::<R>(self.field.nx));
        let own = |values: &[f64]| {
            let mut own = values[columns.clone()].to_vec();
            own.resize(padded, 0.0);
            own
        };
        self.base = Base {
            force: base.force.each_ref().map(|force| own(force)),
            height: own(&base.height),
            carried: base.carried,
        };
        self.drag = self.kick.drag(base.carried);
        // Displacement relative to the frame one step earlier.
        let (first, stride, nx) = (self.field.index(0, 0), self.field.stride, self.field.nx);
        for row in self.field.other[0].rows_mut()[first..].chunks_mut(stride).take(self.field.ny) {
            row[..nx].fill(R::round_from(base.carried));
        }
    }

    /// Vertical force of the top row on the bulk at zero displacement of the bulk, in units of k l (spring stiffness
    /// times lattice spacing).
    pub fn top_row_force(&self) -> f64 {
        self.stencil.top_row_force(&self.field)
    }

    /// Displacements x and y, in lattice spacings, of the block in column i of the strip and row j.
    pub fn displacement(&self, i: usize, j: usize) -> [f64; 2] {
        let at = self.field.index(i, j);
        [0, 1].map(|component: usize| self.field.now[component].rows()[at].to_f64())
    }

    /// Copies the columns at both sides to the ghost columns beyond the opposite sides, for a strip that is a whole
    /// period.
    pub fn join_sides(&mut self) {
        let (first, nx, stride) = (self.field.index(0, 0), self.field.nx, self.field.stride);
        for plane in &mut self.field.now {
            // Each row has a copy of the last column, then the columns, then a copy of the first column.
            for row in plane.rows_mut()[first - 1..].chunks_exact_mut(stride).take(self.field.ny) {
                row[0] = row[nx];
                row[nx + 1] = row[1];
            }
        }
    }

    /// Number of values that a neighbouring strip needs: the displacements x and y of all blocks in the column at one
    /// side.
    pub const fn edge_len(&self) -> usize {
        2 * self.field.ny
    }

    /// Calls `give` with the index and the value of each displacement in the column at the side `from`: x by row, then
    /// y by row.
    pub fn edge(&self, from: Side, mut give: impl FnMut(usize, f64)) {
        let column = match from {
            Side::Left => 0,
            Side::Right => self.field.nx - 1,
        };
        let (at, stride, ny) = (self.field.index(column, 0), self.field.stride, self.field.ny);
        for (component, plane) in self.field.now.iter().enumerate() {
            for (j, value) in plane.rows()[at..].iter().step_by(stride).take(ny).enumerate() {
                give(component * ny + j, value.to_f64());
            }
        }
    }

    /// Sets the ghost column beyond the side `beyond`, a copy of the neighbouring strip's column; `take` returns the
    /// value for each index of [`Strip::edge`].
    pub fn set_image(&mut self, beyond: Side, mut take: impl FnMut(usize) -> f64) {
        let at = match beyond {
            Side::Left => self.field.index(0, 0) - 1,
            Side::Right => self.field.index(self.field.nx, 0),
        };
        let (stride, ny) = (self.field.stride, self.field.ny);
        for (component, plane) in self.field.now.iter_mut().enumerate() {
            for (j, value) in plane.rows_mut()[at..].iter_mut().step_by(stride).take(ny).enumerate() {
                *value = R::round_from(take(component * ny + j));
            }
        }
    }

    /// Takes one step; returns the sums of forces over the contact blocks of the strip at the beginning of the step.
    /// The ghost columns must be up to date.
    pub fn step(&mut self, bulk: BulkPosition) -> ContactSums {
        self.place_bulk(bulk);
        let Self { stencil, field, contact, kick, drag, force: [force_x, force_y], .. } = self;
        let mut sums = ContactSums::default();
        for (row, coefficients) in stencil.general.iter().enumerate() {
            vectorized(RowForces { coefficients, field, row, force_x, force_y });
            if row == 0 {
                let total = &mut self.contact_force;
                for ((force, base_force), total) in
                    [&*force_x, force_y].into_iter().zip(&self.base.force).zip(&mut *total)
                {
                    vectorized(AddForces { force, base_force, total });
                }
                let [force_x, force_y] = &*total;
                sums = contact.kick([force_x], force_y, kick.kept);
                let ([velocity], carried) = (contact.velocity(), bulk.carried);
                let (start, columns, place) = (field.index(0, 0), field.nx, &mut self.contact_place[0]);
                let (velocity, row) = (&velocity[..columns], &mut field.other[0].rows_mut()[start..][..columns]);
                vectorized(PlaceContacts { place, velocity, carried, row });
                if self.liftoff {
                    let inverse_mass = &coefficients.inverse_mass;
                    let (heights, rises) = (&self.base.height, &mut self.contact_place[1]);
                    let moved = (&mut rises[..], &mut self.fall[..]);
                    contact.move_vertically(*kick, force_y, moved, |i| heights[i], |i| inverse_mass[i].to_f64());
                    let row = &mut field.other[1].rows_mut()[start..][..columns];
                    for (row, rise) in row.iter_mut().zip(rises) {
                        *row = R::round_from(*rise);
                    }
                }
            } else {
                let inverse_mass = &coefficients.inverse_mass;
                let (columns, start) = (field.nx, field.index(0, row));
                let (now, other, force) = (&field.now, &mut field.other, [&force_x[..], force_y]);
                let drag = [*drag, 0.0];
                vectorized(MoveRow { inverse_mass, now, other, columns, start, kick: *kick, drag, force });
            }
        }
        let from = stencil.general.len();
        self.at_sides.clear();
        for (i, sites) in &stencil.sides {
            self.at_sides
                .extend((from..).zip(sites).map(|(j, site)| move_side_block(site, field, [*i, j], *kick, *drag)));
        }
        vectorized(InsideRows { field, from, kick: *kick, drag: *drag });
        let mut moved = self.at_sides.iter();
        for (i, sites) in &stencil.sides {
            for ((j, _), moved) in (from..).zip(sites).zip(&mut moved) {
                let at = field.index(*i, j);
                for (plane, moved) in field.other.iter_mut().zip(*moved) {
                    plane.rows_mut()[at] = R::round_from(moved);
                }
            }
        }
        field.swap();
        sums
    }

    fn place_bulk(&mut self, bulk: BulkPosition) {
        let (start, end) = (self.field.index(0, self.field.ny) - 1, self.field.index(self.field.nx, self.field.ny) + 1);
        for (plane, value) in self.field.now.iter_mut().zip([bulk.x, bulk.height]) {
            plane.rows_mut()[start..end].fill(R::round_from(value));
        }
    }
}
