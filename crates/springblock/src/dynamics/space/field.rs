//! Displacements of the blocks of a periodic cell in space, at two instants.

use std::ops::Range;

use super::super::real::Real;
use super::super::rows::Plane;

/// Sets of a first-level cache.
const SETS: usize = 64;
/// Lines of a row, or a multiple of them, at which rows meet in an eighth of the sets or less.
const MEETING: usize = 8;
/// Sets by which neighbouring layers are kept apart: a sweep along y stays in as many rows at a time.
const APART: usize = 12;

/// x, y and z displacements: at an instant, and one step before it or after it.
///
/// Column i of row j (along y) of layer k is at `LINE + k * layer + (j + 1) * stride + i`: the row before row 0 and the
/// one behind the last hold images of the rows at the other side, and so do the values beside a row's columns. Layer
/// nz is the bulk.
#[derive(Clone, Debug)]
pub struct Field<R> {
    pub nx: usize,
    pub ny: usize,
    pub nz: usize,
    pub stride: usize,
    pub layer: usize,
    pub now: [Plane<R>; 3],
    /// One step earlier; a sweep replaces it by one step later, and [`Field::turn`] makes that the present.
    pub other: [Plane<R>; 3],
}

impl<R: Real> Field<R> {
    /// A cell of nx x ny columns and nz rows at rest.
    #[must_use]
    pub fn at_rest([nx, ny]: [usize; 2], nz: usize) -> Self {
        // Rows of a multiple of so many lines would meet in the same few sets of a cache. Others have no line more than they need: every one
        // is read.
        let own = (nx + 2).div_ceil(R::LINE);
        let stride = (own + usize::from(own.is_multiple_of(MEETING))) * R::LINE;
        // Nor do layers: not near a multiple of 64 lines, which would meet in the same sets of the first cache.
        let lines = (ny + 2) * stride / R::LINE;
        let beside = lines % SETS;
        let skip = if beside < APART { APART - beside } else { (beside + APART).saturating_sub(SETS) * 2 };
        let layer = (lines + skip) * R::LINE;
        let plane = || Plane::zero(layer * (nz + 1) + 2 * R::LINE);
        let planes = || [plane(), plane(), plane()];
        Self { nx, ny, nz, stride, layer, now: planes(), other: planes() }
    }

    /// Index of block (i, j, k) in [`Plane::rows`].
    #[inline(always)]
    #[must_use]
    pub const fn at(&self, i: usize, j: usize, k: usize) -> usize {
        R::LINE + k * self.layer + (j + 1) * self.stride + i
    }

    /// Displacements of block (i, j, k).
    #[must_use]
    pub fn displacement(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let at = self.at(i, j, k);
        [0, 1, 2].map(|component: usize| self.now[component].rows()[at].widened())
    }

    /// Places block (i, j, k) at rest.
    pub fn place(&mut self, [i, j, k]: [usize; 3], displacement: [f64; 3]) {
        let at = self.at(i, j, k);
        for (component, u) in displacement.into_iter().enumerate() {
            self.now[component].rows_mut()[at] = R::of(u);
            self.other[component].rows_mut()[at] = R::of(u);
        }
    }

    /// Lets every block come, in the step before, from `back` behind where it is.
    pub fn carry(&mut self, back: [f64; 2]) {
        for (plane, back) in self.other.iter_mut().zip(back) {
            plane.rows_mut().fill(R::of(back));
        }
    }

    /// Places the bulk.
    pub fn place_bulk(&mut self, displacement: [f64; 3]) {
        let from = self.at(0, 0, self.nz) - self.stride - 1;
        for (plane, u) in self.now.iter_mut().zip(displacement) {
            plane.rows_mut()[from..from + self.layer + 2].fill(R::of(u));
        }
    }

    /// Fills the images of all layers at both instants.
    pub fn join_sides(&mut self) {
        self.join_layers(0..self.nz);
        self.turn();
        self.join_layers(0..self.nz);
        self.turn();
    }

    /// Fills the images of all of `layers` where sweeps have written.
    fn join_layers(&mut self, layers: Range<usize>) {
        for k in layers.clone() {
            self.join_rows(k, 0..self.ny);
        }
        self.join_ends(layers);
    }

    /// Fills the images beside `rows` of layer `k` where a sweep has written: soon after it, while they are in the first-level cache. Lanes
    /// beyond the last column may have written over those of the row after them, which may have been swept before.
    pub fn join_rows(&mut self, k: usize, rows: Range<usize>) {
        let (start, nx) = (self.at(0, rows.start, k) - 1, self.nx);
        for values in self.other.iter_mut().map(Plane::rows_mut) {
            for row in values[start..].chunks_mut(self.stride).take(rows.len() + 1) {
                row[0] = row[nx];
                row[nx + 1] = row[1];
            }
        }
    }

    /// Fills the images of the first and the last row of `layers`, once those have theirs.
    pub fn join_ends(&mut self, layers: Range<usize>) {
        let Self { nx, ny, stride, layer, other, .. } = self;
        for values in other.iter_mut().map(Plane::rows_mut) {
            for k in layers.clone() {
                // One value before the row to one behind it.
                let row = |number: usize| R::LINE + k * *layer + number * *stride - 1;
                values.copy_within(row(*ny)..row(*ny) + *nx + 2, row(0));
                values.copy_within(row(1)..row(1) + *nx + 2, row(*ny + 1));
            }
        }
    }

    /// Makes what a sweep has written the present.
    pub fn turn(&mut self) {
        std::mem::swap(&mut self.now, &mut self.other);
    }
}
