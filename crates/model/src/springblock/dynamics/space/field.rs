//! Displacements of the blocks of a periodic cell in space at two instants.

use std::ops::Range;

use super::super::real::Real;
use super::super::rows::Plane;

/// Number of sets of a first-level cache.
const SETS: usize = 64;
/// Number of cache lines; row lengths that are multiples of this number are avoided, because such rows share an eighth
/// of the cache sets or fewer.
const MEETING: usize = 8;
/// Minimum distance in cache sets between neighbouring layers, which leaves room for that many rows in a sweep along y.
const APART: usize = 12;

/// Displacements x, y and z, in lattice spacings, at the current time and one step before or after.
///
/// Column i of row j (along y) of layer k is at `LINE + k * layer + (j + 1) * stride + i`. The row before row 0 and the
/// row after the last are ghost rows, copies of the rows at the opposite side; the values before and after the columns
/// of a row are copies of the columns at the opposite side. Layer nz is the bulk.
#[derive(Clone, Debug)]
pub struct Field<R> {
    pub nx: usize,
    pub ny: usize,
    pub nz: usize,
    pub stride: usize,
    pub layer: usize,
    pub now: [Plane<R>; 3],
    /// Displacements one step earlier. A sweep overwrites these values with the displacements one step later, which
    /// [`Field::swap`] then makes current.
    pub other: [Plane<R>; 3],
}

impl<R: Real> Field<R> {
    /// Creates a cell of nx x ny columns and nz layers at rest.
    pub fn at_rest([nx, ny]: [usize; 2], nz: usize) -> Self {
        // Rows with a multiple of `MEETING` cache lines would share a few sets of the cache. No other padding is added,
        // because every line is read.
        let own = (nx + 2).div_ceil(R::LINE);
        let stride = (own + usize::from(own.is_multiple_of(MEETING))) * R::LINE;
        // Likewise, keep the layer size away from multiples of 64 lines, which would share the same sets of the
        // first-level cache.
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
    pub const fn index(&self, i: usize, j: usize, k: usize) -> usize {
        R::LINE + k * self.layer + (j + 1) * self.stride + i
    }

    /// Displacements x, y and z of block (i, j, k), in lattice spacings.
    pub fn displacement(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let at = self.index(i, j, k);
        [0, 1, 2].map(|component: usize| self.now[component].rows()[at].to_f64())
    }

    /// Sets the displacement of block (i, j, k) at both instants, so that the block is at rest.
    pub fn place(&mut self, [i, j, k]: [usize; 3], displacement: [f64; 3]) {
        let at = self.index(i, j, k);
        for (component, u) in displacement.into_iter().enumerate() {
            self.now[component].rows_mut()[at] = R::round_from(u);
            self.other[component].rows_mut()[at] = R::round_from(u);
        }
    }

    /// Sets all displacements along x and y one step earlier to `back`, the displacement of the moving frame per step:
    /// relative to the frame, blocks at rest move backwards.
    pub fn offset_previous(&mut self, back: [f64; 2]) {
        for (plane, back) in self.other.iter_mut().zip(back) {
            plane.rows_mut().fill(R::round_from(back));
        }
    }

    /// Sets the current displacement of the bulk.
    pub fn place_bulk(&mut self, displacement: [f64; 3]) {
        let from = self.index(0, 0, self.nz) - self.stride - 1;
        for (plane, u) in self.now.iter_mut().zip(displacement) {
            plane.rows_mut()[from..from + self.layer + 2].fill(R::round_from(u));
        }
    }

    /// Fills the ghost values of all layers at both instants.
    pub fn fill_all_images(&mut self) {
        for _ in 0..2 {
            for k in 0..self.nz {
                self.join_rows(k, 0..self.ny);
            }
            self.join_ends(0..self.nz);
            self.swap();
        }
    }

    /// Fills the ghost values at both ends of the rows `rows` of layer `k` in the displacements that a sweep has
    /// written.
    ///
    /// Call this method soon after the sweep, while the rows are in the first-level cache. Vector lanes beyond the last
    /// column may have overwritten ghost values of the next row, which may have been swept before; these are filled
    /// again.
    pub fn join_rows(&mut self, k: usize, rows: Range<usize>) {
        let (start, nx) = (self.index(0, rows.start, k) - 1, self.nx);
        for values in self.other.iter_mut().map(Plane::rows_mut) {
            for row in values[start..].chunks_mut(self.stride).take(rows.len() + 1) {
                row[0] = row[nx];
                row[nx + 1] = row[1];
            }
        }
    }

    /// Fills the ghost rows before the first and after the last row of each layer of `layers`. Call this method after
    /// the ghost values at the ends of the rows have been filled.
    pub fn join_ends(&mut self, layers: Range<usize>) {
        let Self { nx, ny, stride, layer, other, .. } = self;
        for values in other.iter_mut().map(Plane::rows_mut) {
            for k in layers.clone() {
                // From one value before the row to one value after it.
                let row = |number: usize| R::LINE + k * *layer + number * *stride - 1;
                values.copy_within(row(*ny)..row(*ny) + *nx + 2, row(0));
                values.copy_within(row(1)..row(1) + *nx + 2, row(*ny + 1));
            }
        }
    }

    /// Makes the displacements that a sweep has written to `other` current, by exchanging `now` and `other`.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.now, &mut self.other);
    }
}
