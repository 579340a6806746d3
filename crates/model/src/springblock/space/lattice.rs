//! Geometry of the lattice in space: positions of blocks, springs between them, and masses.
//!
//! Columns have the indices i along x and j along y, both periodic; rows k count from the counterface up; the rigid
//! bulk is the row above the top row. Lengths are in lattice spacings l, stiffness in k = 2/5 E l, mass in m = rho l^3.
//!
//! Cells of whole blocks are the regular lattice. Other cells have the nearest whole number of columns, stretched to
//! fit, with springs that keep the solid isotropic ([`super::springs`]). The first edges along x and y of the first
//! cavity lie between two columns, other edges where the pattern puts them. A column that a cavity covers in part
//! exists in part: its blocks have weaker springs and a smaller contact area.

use crate::pattern::{Pattern, ReliefMap};

use super::springs::{LEVEL, Spring, springs};
use crate::springblock::columns::{divide, round_if_whole, round_share};
use crate::springblock::lattice::{joint_presence, stiffness_share};
use crate::springblock::rims;

/// A periodic cell with or without cavities, or a strip with two ends.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceLattice {
    columns: [usize; 2],
    rows: usize,
    spacing: [f64; 2],
    /// Fraction of every column that cavities cover; index j * nx + i for column i along x and j along y.
    coverage: Vec<f64>,
    /// Depth of the cavities, in rows.
    depth: f64,
    /// Mean height of the land of every column, positive towards the counterface, in lattice spacings; indices as for
    /// `coverage`. Empty for a flat face.
    relief: Vec<f64>,
    /// Number of lines of columns, the last along y, that are removed from the face to the bulk, which leaves two free
    /// ends.
    gap: usize,
}

/// A spring between block `a` and block `b`, or the bulk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceBond {
    /// Column indices along x and y, and row, of the lower end.
    pub a: [usize; 3],
    /// Column indices along x and y, and row, of the upper end; the row above the top row is the bulk.
    pub b: [usize; 3],
    /// Kind of the spring, with its stiffness in a flat layer.
    pub spring: Spring,
    /// Stiffness of the spring divided by the stiffness in a flat layer, in [0, 1].
    pub share: f64,
}

impl SpaceLattice {
    /// Number of columns along x and y of a cell of `pattern` in blocks `block_m` metres apart.
    pub fn columns_of(pattern: &Pattern, block_m: f64) -> [f64; 2] {
        let cell_m = repeated_cell_m(pattern);
        let along_y = if pattern.is_uniform_along_y() { 1.0 } else { divide(cell_m[1] / block_m).1 as f64 };
        [divide(cell_m[0] / block_m).1 as f64, along_y]
    }

    /// Creates a flat layer of `columns` columns along x and y and `rows` rows.
    pub fn flat(columns: [usize; 2], rows: usize) -> Self {
        Self::of_cubes(columns, rows, vec![0.0; columns[0] * columns[1]], 0.0)
    }

    /// Creates a cell of cubes with cavities `depth` rows deep, which cover the fraction `coverage[j * nx + i]` of
    /// column i along x and j along y. At depth 0 covered blocks are whole but do not touch the counterface.
    pub(super) const fn of_cubes(columns: [usize; 2], rows: usize, coverage: Vec<f64>, depth: f64) -> Self {
        Self { columns, rows, spacing: [1.0; 2], coverage, depth, relief: Vec::new(), gap: 0 }
    }

    /// Creates the cell of `pattern` with `rows` rows of blocks `block_m` metres apart: one period, or several if a
    /// short period is not a whole number of blocks or rims differ between cavities. Grooves take one column along y.
    pub fn cell(pattern: &Pattern, block_m: f64, rows: usize) -> Self {
        Self::cell_with_map(pattern, block_m, rows, None)
    }

    /// Like [`Self::cell`], with the measured relief `map` of the lands.
    pub fn cell_with_map(pattern: &Pattern, block_m: f64, rows: usize, map: Option<&ReliefMap>) -> Self {
        let cell_m = repeated_cell_m(pattern);
        // Oblique crossing grooves cut columns at any position: a crossing lies on a corner of columns, which gives the
        // lattice the mirror symmetries of the pattern.
        let extents_m = match (pattern.length_m(), pattern.centres_m().count()) {
            (Some(length_m), _) => [Some(pattern.width_m()), Some(length_m)],
            (None, _) if pattern.is_uniform_along_y() => [Some(pattern.width_m()), None],
            (None, 1) => [Some(pattern.width_m()); 2],
            (None, _) => [Some(0.0); 2],
        };
        let axes = [0, 1].map(|axis| match extents_m[axis] {
            None => (1, 1, 1.0, 0.0, 1),
            Some(extent_m) => {
                let (periods, columns, spacing) = divide(cell_m[axis] / block_m);
                let pitch_m = spacing * block_m;
                // A cavity of c columns in m columns has floor((m - c)/2) columns before it.
                let covered = (extent_m / pitch_m).round().max(1.0) as usize;
                let before = columns.saturating_sub(covered) / 2;
                let cells = periods * rims::cells(pattern)[axis];
                (columns, before, spacing, before as f64 * pitch_m + extent_m / 2.0, cells)
            }
        });
        let (columns, spacing) = (axes.map(|axis| axis.0), axes.map(|axis| axis.2));
        let edge_m = |axis: usize, column: usize| column as f64 * spacing[axis] * block_m - axes[axis].3;
        let sides = |column: usize| {
            let (i, j) = (column % columns[0], column / columns[0]);
            [edge_m(0, i), edge_m(0, i + 1), edge_m(1, j), edge_m(1, j + 1)]
        };
        let count = columns[0] * columns[1];
        let coverage =
            (0..count).map(sides).map(|[x0, x1, y0, y1]| pattern.coverage(x0, x1, y0, y1)).map(round_share).collect();
        let periods = [0, 1].map(|axis| if extents_m[axis].is_none() { 1 } else { axes[axis].4 });
        // The scene already refuses a map that does not fit its pattern.
        let relief = match map.and_then(|map| map.lands(pattern).ok()) {
            None => relief(pattern, block_m, periods, (0..count).map(sides)),
            Some(lands) => {
                (0..count).map(sides).map(|[x0, x1, y0, y1]| lands.mean_m([x0, x1], [y0, y1]) / block_m).collect()
            }
        };
        let depth = round_if_whole(pattern.depth_m() / block_m);
        Self { columns, rows, spacing, coverage, depth, relief, gap: 0 }
    }

    /// Returns the cell in whole cubes, for time integration: columns that are covered by half or more are cavity, and
    /// the depth is the nearest number of rows from 1 to all but one.
    pub fn nearest_whole(&self) -> Self {
        let depth = self.depth.round().max(1.0).min((self.rows - 1) as f64);
        // The least covered column remains land, so that something touches.
        let least = self.coverage.iter().copied().fold(f64::INFINITY, f64::min);
        let is_cavity = |share: f64| depth > 0.0 && share >= 0.5 && share > least;
        let coverage: Vec<f64> = self.coverage.iter().map(|share| f64::from(u8::from(is_cavity(*share)))).collect();
        let depth = if coverage.contains(&1.0) { depth } else { 0.0 };
        Self { spacing: [1.0; 2], coverage, depth, ..self.clone() }
    }

    /// Returns the cell repeated `count` times along y.
    pub fn repeated_along_y(&self, count: usize) -> Self {
        let columns = [self.columns[0], self.columns[1] * count];
        Self { columns, coverage: self.coverage.repeat(count), relief: self.relief.repeat(count), ..self.clone() }
    }

    /// Creates a strip with two ends: `lines` lines of this cell along y, then `gap` lines, at least one, that are
    /// removed from the face to the bulk. Line n of the strip is line `cell_line(n)` of the cell, or land if
    /// `cell_line(n)` is `None`.
    pub fn strip_along_y(&self, lines: usize, gap: usize, cell_line: impl Fn(usize) -> Option<usize>) -> Self {
        let nx = self.columns[0];
        let laid = |values: &[f64], elsewhere: f64, beyond: f64| -> Vec<f64> {
            let line =
                |n: usize| cell_line(n).map_or_else(|| vec![elsewhere; nx], |j| values[j * nx..(j + 1) * nx].to_vec());
            (0..lines).flat_map(line).chain(std::iter::repeat_n(beyond, gap * nx)).collect()
        };
        let coverage = laid(&self.coverage, 0.0, 1.0);
        let relief = if self.relief.is_empty() { Vec::new() } else { laid(&self.relief, 0.0, 0.0) };
        Self { columns: [nx, lines + gap], coverage, relief, gap, ..self.clone() }
    }

    /// Returns the lattice with x and y exchanged.
    pub fn transposed(&self) -> Self {
        let [nx, ny] = self.columns;
        let turned = |values: &[f64]| -> Vec<f64> {
            if values.is_empty() {
                return Vec::new();
            }
            (0..nx).flat_map(|i| (0..ny).map(move |j| values[j * nx + i])).collect()
        };
        let (coverage, relief) = (turned(&self.coverage), turned(&self.relief));
        let [a, b] = self.spacing;
        Self { columns: [ny, nx], spacing: [b, a], coverage, relief, ..self.clone() }
    }

    /// Sets the mean land height of each column, positive towards the counterface, in lattice spacings; index j * nx +
    /// i for column i along x and j along y.
    #[must_use]
    pub fn with_relief(self, relief: Vec<f64>) -> Self {
        Self { relief, ..self }
    }

    /// Number of columns along x and along y.
    pub const fn columns(&self) -> [usize; 2] {
        self.columns
    }

    /// Number of rows of blocks.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Distance between neighbouring columns along x and y, in lattice spacings.
    pub const fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Depth of the cavities, in rows.
    pub const fn depth(&self) -> f64 {
        self.depth
    }

    /// Mean height of the land of column (i, j), positive towards the counterface, in lattice spacings.
    pub fn relief(&self, i: usize, j: usize) -> f64 {
        self.relief.get(j * self.columns[0] + i).copied().unwrap_or(0.0)
    }

    /// Whether the face has height variations.
    pub fn is_raised(&self) -> bool {
        self.relief.iter().any(|height| *height != 0.0)
    }

    /// Maximum height of the land, positive towards the counterface, in lattice spacings; 0 for a flat face.
    pub fn highest(&self) -> f64 {
        let land = self.relief.iter().zip(&self.coverage).filter(|(_, coverage)| **coverage < 1.0);
        land.map(|(height, _)| *height).reduce(f64::max).unwrap_or(0.0)
    }

    /// Number of columns that belong to the face, without the gap between the ends of a strip.
    pub const fn face_columns(&self) -> usize {
        self.columns[0] * (self.columns[1] - self.gap)
    }

    /// Whether line `j` along y lies in the gap between the ends of a strip, where all blocks are removed.
    const fn is_cut(&self, j: usize) -> bool {
        j >= self.columns[1] - self.gap
    }

    /// Whether line `j` along y is the first or the last line of a strip with two ends, or lies in the gap.
    pub const fn is_end(&self, j: usize) -> bool {
        self.gap > 0 && (j == 0 || self.is_cut(j + 1))
    }

    /// Whether column (i, j) is entirely cavity.
    pub fn is_cavity(&self, i: usize, j: usize) -> bool {
        self.contact_share(i, j) == 0.0 && !self.is_cut(j)
    }

    /// Whether every block is a whole cube.
    pub fn is_plain(&self) -> bool {
        let whole = self.depth.fract() == 0.0 || self.coverage.iter().all(|share| *share == 0.0);
        whole && self.spacing == [1.0; 2] && self.coverage.iter().all(|share| *share == 0.0 || *share == 1.0)
    }

    /// Fraction of the area of column (i, j) that touches the counterface.
    pub fn contact_share(&self, i: usize, j: usize) -> f64 {
        1.0 - self.coverage[j * self.columns[0] + i]
    }

    /// Columns j * nx + i that touch the counterface, at least in part, in ascending order.
    pub fn contacts(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.coverage.len()).filter(|&column| self.coverage[column] < 1.0)
    }

    /// Number of rows into which a cavity reaches, at least in part.
    pub fn cavity_rows(&self) -> usize {
        // The depth is validated to be below the height of the layer.
        (self.depth.ceil() as usize).min(self.rows)
    }

    /// Number of rows that differ from a flat layer: the rows of the cavities, or all rows of a strip with ends.
    pub fn changed_rows(&self) -> usize {
        if self.gap > 0 { self.rows } else { self.cavity_rows() }
    }

    /// Lowest row in which cavities do not remove the whole block.
    pub fn ceiling_row(&self) -> usize {
        // The depth is validated to be below the height of the layer.
        (self.depth.floor() as usize).min(self.rows - 1)
    }

    /// Fraction of block (i, j, k) that exists.
    pub fn presence(&self, i: usize, j: usize, k: usize) -> f64 {
        if self.is_cut(j) {
            return 0.0;
        }
        // A cavity of depth d that covers the fraction c of a column removes c (d - k) of row k, clamped to [0, c].
        1.0 - self.coverage[j * self.columns[0] + i] * self.depth_in(k)
    }

    /// Fraction of the height of row `k` that cavities remove.
    fn depth_in(&self, k: usize) -> f64 {
        (self.depth - k as f64).clamp(0.0, 1.0)
    }

    /// Stiffness of a spring between blocks `a` and `b` (column indices along x and y, row) divided by the stiffness in
    /// a flat layer. The bulk, the row above the top row, is whole over the face.
    pub fn spring_share(&self, a: [usize; 3], b: [usize; 3]) -> f64 {
        if self.is_cut(a[1]) || self.is_cut(b[1]) {
            return 0.0;
        }
        let covered = [a, b].map(|[i, j, _]| self.coverage[j * self.columns[0] + i]);
        let deep = [a, b].map(|[_, _, k]| if k < self.rows { self.depth_in(k) } else { 0.0 });
        stiffness_share(joint_presence(covered, deep))
    }

    /// Visits every spring once, including springs to the bulk: row by row, column by column. With `weakened` only
    /// springs with less than the stiffness of a flat layer are visited, including springs of removed blocks.
    fn visit_bonds(&self, weakened: bool, mut visit: impl FnMut(SpaceBond)) {
        let kinds = springs(self.spacing);
        let rows = if weakened { self.changed_rows() } else { self.rows };
        let [nx, ny] = self.columns;
        for (k, j, i) in (0..rows).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
            let a = [i, j, k];
            for spring in kinds {
                let b = self.neighbour(a, &spring);
                let share = self.spring_share(a, b);
                if (weakened && share < 1.0) || (!weakened && share > 0.0) {
                    visit(SpaceBond { a, b, spring, share });
                }
            }
        }
    }

    /// Visits every spring once, including springs to the bulk: row by row, column by column.
    pub fn for_each_bond(&self, visit: impl FnMut(SpaceBond)) {
        self.visit_bonds(false, visit);
    }

    /// Visits every spring that is missing or weaker than in the flat layer.
    pub fn for_each_weakened_bond(&self, visit: impl FnMut(SpaceBond)) {
        self.visit_bonds(true, visit);
    }

    /// Existing springs from block (i, j, 0) to the row above.
    pub fn upward(&self, i: usize, j: usize) -> impl Iterator<Item = SpaceBond> + '_ {
        let a = [i, j, 0];
        springs(self.spacing).into_iter().skip(LEVEL).filter_map(move |spring| {
            let b = self.neighbour(a, &spring);
            let share = self.spring_share(a, b);
            (share > 0.0).then_some(SpaceBond { a, b, spring, share })
        })
    }

    /// Indices of the block at the other end of the spring of kind `spring` at `a`.
    fn neighbour(&self, a: [usize; 3], spring: &Spring) -> [usize; 3] {
        let wrap = |at: usize, step: isize, count: usize| (at + count).wrapping_add_signed(step) % count;
        [
            wrap(a[0], spring.step[0], self.columns[0]),
            wrap(a[1], spring.step[1], self.columns[1]),
            a[2] + spring.step[2].unsigned_abs(),
        ]
    }

    /// Mass of block (i, j, k) in units of rho l^3 (density rho, lattice spacing l) for cubes: an eighth for each
    /// adjacent cell of eight existing blocks, at least 1/8; 0 where there is no block. The bulk above counts as
    /// blocks.
    pub fn mass(&self, i: usize, j: usize, k: usize) -> f64 {
        let there = |i: usize, j: usize, k: usize| k >= self.rows || self.presence(i, j, k) > 0.0;
        if !there(i, j, k) {
            return 0.0;
        }
        let [nx, ny] = self.columns;
        let mut eighths = 0;
        for x in [(i + 1) % nx, (i + nx - 1) % nx] {
            for y in [(j + 1) % ny, (j + ny - 1) % ny] {
                for z in [k.checked_sub(1), Some(k + 1)].into_iter().flatten() {
                    let corners = [k, z].map(|k| there(x, j, k) && there(i, y, k) && there(x, y, k) && there(i, j, k));
                    eighths += usize::from(corners == [true; 2]);
                }
            }
        }
        eighths.max(1) as f64 / 8.0 * self.spacing[0] * self.spacing[1]
    }
}

/// Side lengths along x and y, in metres, of the rectangular cell of `pattern` that contains all the rims it needs.
fn repeated_cell_m(pattern: &Pattern) -> [f64; 2] {
    let (cell_m, cells) = (pattern.cell_m(), rims::cells(pattern));
    [0, 1].map(|axis| cell_m[axis] * cells[axis] as f64)
}

/// Mean heights, in lattice spacings, of the rims on the columns with the sides `sides` (x from, x to, y from, y to, in
/// metres in the axes of the pattern), for a cell of `periods` periods along x and y; empty without rims.
fn relief(pattern: &Pattern, block_m: f64, periods: [usize; 2], sides: impl Iterator<Item = [f64; 4]>) -> Vec<f64> {
    let centres_m: Vec<[f64; 2]> = pattern.centres_m().collect();
    let cell_m = pattern.cell_m();
    let Some(heights) = rims::heights(pattern, block_m, periods[0] * periods[1] * centres_m.len()) else {
        return Vec::new();
    };
    // Index of the rim of the nearest cavity.
    let nearest = |at_m: [f64; 2]| {
        let seen = centres_m.iter().enumerate().map(|(number, centre_m)| {
            let (mut cell, mut square, mut stride) = (0, 0.0, 1);
            for axis in 0..2 {
                let away = (at_m[axis] - centre_m[axis]) / cell_m[axis];
                // Columns lie within a few cells: the cast is exact.
                cell += (away.round() as i64).rem_euclid(periods[axis] as i64) as usize * stride;
                stride *= periods[axis];
                // The distance to a groove does not depend on the position along it.
                if axis == 0 || !pattern.is_uniform_along_y() {
                    square += ((away - away.round()) * cell_m[axis]).powi(2);
                }
            }
            (square, cell * centres_m.len() + number)
        });
        seen.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, number)| number)
    };
    sides
        .map(|[x0, x1, y0, y1]| {
            let share = pattern.rim_share(x0, x1, y0, y1);
            if share > 0.0 { share * heights[nearest([f64::midpoint(x0, x1), f64::midpoint(y0, y1)])] } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests;
