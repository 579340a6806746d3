//! Data of the sweeps over a strip: coefficients of rows and displacements of blocks.

use super::real::{LINE_BYTES, Real, whole_lines};

/// Stiffnesses of the eight springs of one block, in units of the spring stiffness k: east, west, north, south, north
/// east, south west, north west and south east. East is the sliding direction, north points from the counterface to the
/// bulk. For each kind of [`super::bond_rows::KINDS`] the spring to that side is followed by the opposite one.
pub type Springs8 = [f64; 8];

/// Springs of a block inside the lattice.
pub const INSIDE: Springs8 = [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5];

/// Springs and inverse mass of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Site {
    pub springs: Springs8,
    pub inverse_mass: f64,
}

/// Spring stiffnesses and inverse masses of a row: one array per spring, in the order of [`Springs8`], with one entry
/// per column, padded with zeros to whole cache lines. Stiffnesses of diagonal springs are halved.
#[derive(Clone, Debug)]
pub struct RowCoefficients<R> {
    pub springs: [Vec<R>; 8],
    pub inverse_mass: Vec<R>,
}

impl<R: Real> RowCoefficients<R> {
    /// Creates the coefficients of a row from its blocks `sites`, in the order of the columns.
    pub fn new(sites: &[Site]) -> Self {
        let column = |of: &dyn Fn(&Site) -> f64| {
            let mut values: Vec<R> = sites.iter().map(of).map(R::round_from).collect();
            values.resize(whole_lines::<R>(sites.len()), R::default());
            values
        };
        let scale = |spring: usize| if spring < 4 { 1.0 } else { 0.5 };
        Self {
            springs: std::array::from_fn(|spring| column(&|site| scale(spring) * site.springs[spring])),
            inverse_mass: column(&|site| site.inverse_mass),
        }
    }
}

/// One value per block, row by row, aligned to cache lines.
///
/// Column i of row j is at `LINE + j * stride + i`, where LINE is the number of values in a cache line. At least two
/// ghost values, copies of columns across the sides of the strip, follow the last column of a row: the first belongs to
/// the right side of this row, the last to the left side of the next row. Row ny is the bulk. Column 0 begins a cache
/// line.
#[derive(Clone, Debug)]
pub struct Plane<R> {
    values: Vec<R>,
    skip: usize,
}

impl<R: Real> Plane<R> {
    pub(super) fn zero(size: usize) -> Self {
        let values = vec![R::default(); size + R::LINE];
        // A clone may be misaligned, which is slower but correct.
        let skip = values.as_ptr().align_offset(LINE_BYTES).min(R::LINE);
        Self { values, skip }
    }

    #[inline(always)]
    pub fn rows(&self) -> &[R] {
        &self.values[self.skip..]
    }

    #[inline(always)]
    pub fn rows_mut(&mut self) -> &mut [R] {
        &mut self.values[self.skip..]
    }
}

/// Displacements of the blocks of a strip along x and y, in lattice spacings, at the current time and one step before
/// or after.
#[derive(Clone, Debug)]
pub struct Field<R> {
    pub nx: usize,
    pub ny: usize,
    pub stride: usize,
    pub now: [Plane<R>; 2],
    /// Displacements one step earlier. A sweep overwrites these values with the displacements one step later, which
    /// [`Field::swap`] then makes current.
    pub other: [Plane<R>; 2],
}

impl<R: Real> Field<R> {
    /// Creates a strip of `nx` columns and `ny` rows at rest.
    pub fn at_rest(nx: usize, ny: usize) -> Self {
        // An odd number of cache lines per row spreads the rows over the sets of the cache.
        let stride = ((nx + 2).div_ceil(R::LINE) | 1) * R::LINE;
        let plane = || Plane::zero(stride * (ny + 1) + 2 * R::LINE);
        Self { nx, ny, stride, now: [plane(), plane()], other: [plane(), plane()] }
    }

    /// Index of block (i, j) in [`Plane::rows`].
    #[inline(always)]
    pub const fn index(&self, i: usize, j: usize) -> usize {
        R::LINE + j * self.stride + i
    }

    /// Makes the displacements that a sweep has written to `other` current, by exchanging `now` and `other`.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.now, &mut self.other);
    }
}
