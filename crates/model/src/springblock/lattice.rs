//! Geometry of the block lattice: positions of blocks, springs between them, and masses.
//!
//! Rows j = 0..ny count from the counterface up, columns i = 0..nx along the sliding direction. The rigid bulk is row
//! ny. Lengths are in lattice spacings l, stiffness in k = 3/4 E l, mass in m = rho l^3.
//!
//! Springs between two neighbouring columns, whose centres are w l apart, represent an isotropic plane-stress sheet
//! with nu = 1/3 on cells of w x 1:
//!
//! ```text
//! diagonal   k_d = (k/2) (w^2 + 1) / (2 w)
//! horizontal k_x = (k/2) (3 - w^2) / w
//! vertical   k_y = (k/2) (3 - 1/w^2) w   (mean of the two adjoining intervals)
//! ```
//!
//! so that C12 = C66 = k/2 and C11 = 3k/2 for any w; w = 1 gives k/2, k and k.

use crate::springblock::Column;

/// A lattice with or without cavities.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    columns: Vec<Column>,
    rows: usize,
    periodic: bool,
}

/// Constant c of [`stiffness_share`]: the stiffness of the surroundings of a partial ceiling row, relative to a whole
/// row.
///
/// The value makes friction nearly linear in the depth: on the published pattern, 3 to 43 um deep, the changes of the
/// ratio per 1 um differ from their mean by at most 4.7e-4, compared with 6.8e-4 if springs are scaled by the present
/// fraction itself (an infinite constant).
const CEILING_COMPLIANCE: f64 = 3.0;

/// Minimum stiffness of a spring relative to the same spring between whole blocks: weaker springs are left out; their
/// effect on the friction ratio is equally small.
const MIN_SHARE: f64 = 1e-4;

/// Stiffness of the springs of a block of which the fraction `presence` exists, relative to a whole block.
///
/// It is 0 without a block and 1 for a whole block, so that whole rows are unchanged. In between it is c y / (1 + c -
/// y) with y the presence and c [`CEILING_COMPLIANCE`]: a strip of stiffness s displaces its surroundings of compliance
/// 1/c by s / (s + c), which becomes linear in y.
pub fn stiffness_share(presence: f64) -> f64 {
    let share = CEILING_COMPLIANCE * presence / (1.0 + CEILING_COMPLIANCE - presence);
    if share < MIN_SHARE { 0.0 } else { share }
}

/// Present fraction of the connection between two blocks. Cavities remove the fraction `covered` of the width by the
/// fraction `deep` of the height from each of the two blocks.
///
/// The connection lacks the union of the two removed rectangles, superposed. Its presence is the smaller of the
/// presences of the two blocks if these are in one row or in columns with equal coverage, and the product if one block
/// lacks width and the other lacks height.
pub fn joint_presence(covered: [f64; 2], deep: [f64; 2]) -> f64 {
    let both = covered[0].min(covered[1]) * deep[0].min(deep[1]);
    1.0 - (covered[0] * deep[0] + covered[1] * deep[1] - both)
}

/// Stiffness, in units of k = 3/4 E l (Young's modulus E, lattice spacing l), of the tie that holds a block to the
/// counterface if a fraction `share`, between 0 and 1, of the block touches it: free at 0 and pinned at 1.
///
/// The compliance is (1 - a)/a, a being `share`, minus half of the additional compliance of the block's springs, which
/// are weakened because only the fraction `presence` of the block exists. This makes friction nearly linear in the
/// width: on 100 patterns 100 to 400 um wide, up to 1000 um apart and 10 to 40 um deep, changes per 1 um differ from
/// those of a smooth curve by at most 3.2e-4 of the ratio, half of them by less than 4.5e-5; with (1 - a)/a alone by
/// 8.9e-4 and 9.1e-5.
pub fn tie(share: f64, presence: f64) -> f64 {
    1.0 / ((1.0 - share) / share - 0.5 * (1.0 / stiffness_share(presence) - 1.0))
}

/// Stiffness of the horizontal, the diagonal and the vertical springs, in units of k = 3/4 E l, between columns whose
/// centres are `w` lattice spacings apart.
pub fn springs(w: f64) -> [f64; 3] {
    // k_x = (k/2) (3 - w^2) / w, k_d = (k/2) (w^2 + 1) / (2 w), k_y = (k/2) (3 - 1/w^2) w
    [0.5 * (3.0 / w - w), 0.25 * (w + 1.0 / w), 0.5 * (3.0 * w - 1.0 / w)]
}

/// A spring between block `a` and block `b`, or between block `a` and the rigid bulk if `b` is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// Column and row of the first end.
    pub a: (usize, usize),
    /// Column and row of the second end; `None` for the rigid bulk.
    pub b: Option<(usize, usize)>,
    /// Vector from `a` to `b` at rest, in lattice spacings.
    pub rest: [f64; 2],
    /// Stiffness in units of k = 3/4 E l, with Young's modulus E and the lattice spacing l.
    pub stiffness: f64,
}

impl Bond {
    /// Entries xx, xy and yy of the matrix `stiffness` e e^T of the linear spring, with the unit vector e along `rest`,
    /// in units of k = 3/4 E l.
    pub fn linear(&self) -> [f64; 3] {
        let [x, y] = self.rest;
        let scale = self.stiffness / (x * x + y * y);
        [scale * x * x, scale * x * y, scale * y * y]
    }
}

impl Lattice {
    /// Creates a lattice of `columns` (at least one) and `rows` (at least one); its sides are joined if `periodic`.
    pub fn new(columns: Vec<Column>, rows: usize, periodic: bool) -> Self {
        Self { columns, rows, periodic }
    }

    /// Number of columns of blocks, nx.
    pub fn nx(&self) -> usize {
        self.columns.len()
    }

    /// Number of rows of blocks, ny.
    pub const fn ny(&self) -> usize {
        self.rows
    }

    /// Whether the left side is joined to the right side.
    pub const fn is_periodic(&self) -> bool {
        self.periodic
    }

    /// The columns, left to right.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Length along the sliding direction, in lattice spacings.
    pub fn length(&self) -> f64 {
        self.columns.iter().map(|column| column.width).sum()
    }

    /// Indices of the columns that touch the counterface, at least in part.
    pub fn contacts(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nx()).filter(|&i| self.contact_share(i) > 0.0)
    }

    /// Fraction of the width of column `i` that touches the counterface: 0 in a cavity, and if the lowest block has no
    /// springs.
    pub fn contact_share(&self, i: usize) -> f64 {
        if self.is_attached(i, 0) { 1.0 - self.columns[i].coverage } else { 0.0 }
    }

    /// Fraction of block (i, j) that exists: 1 for a whole block, 0 for a removed one. Fractions in between occur in
    /// the ceiling row of a cavity whose depth is not a whole number of rows, and in columns at the edge of a cavity.
    pub fn presence(&self, i: usize, j: usize) -> f64 {
        // A cavity of depth d rows that covers the fraction c of a column removes c (d - j) of row j, clamped to [0,
        // c].
        1.0 - self.columns[i].coverage * self.depth_in(i, j)
    }

    /// Fraction of the height of block (i, j) that a cavity in its column removes.
    fn depth_in(&self, i: usize, j: usize) -> f64 {
        (self.columns[i].cavity_rows - j as f64).clamp(0.0, 1.0)
    }

    /// Whether springs connect block (i, j) to other blocks or to the bulk.
    pub fn is_attached(&self, i: usize, j: usize) -> bool {
        stiffness_share(self.presence(i, j)) > 0.0
    }

    /// Row of the lowest block of column `i` that exists at least in part: the ceiling of a cavity or, on land, row 0.
    pub fn lowest_row(&self, i: usize) -> usize {
        let column = &self.columns[i];
        let row = if column.is_land() { 0 } else { column.cavity_rows.floor() as usize };
        if row < self.rows && !self.is_attached(i, row) { row + 1 } else { row }
    }

    /// Whether every block is whole and every column one lattice spacing wide.
    pub fn is_plain(&self) -> bool {
        let whole = |column: &Column| column.coverage.fract() == 0.0 && column.cavity_rows.fract() == 0.0;
        self.columns.iter().all(|column| column.width == 1.0 && whole(column))
    }

    /// Whether the face has height variations.
    pub fn is_raised(&self) -> bool {
        self.columns.iter().any(|column| column.relief != 0.0)
    }

    /// Column to the right of `i`; `None` at the right end.
    fn right_of(&self, i: usize) -> Option<usize> {
        if i + 1 < self.nx() { Some(i + 1) } else { self.periodic.then_some(0) }
    }

    /// Column to the left of `i`; `None` at the left end.
    fn left_of(&self, i: usize) -> Option<usize> {
        if i > 0 { Some(i - 1) } else { self.periodic.then_some(self.nx() - 1) }
    }

    fn interval(&self, a: usize, b: usize) -> f64 {
        0.5 * (self.columns[a].width + self.columns[b].width)
    }

    fn vertical_stiffness(&self, i: usize) -> f64 {
        let of_interval = |w: f64| springs(w)[2];
        match (self.left_of(i), self.right_of(i)) {
            (Some(left), Some(right)) => {
                0.5 * (of_interval(self.interval(left, i)) + of_interval(self.interval(i, right)))
            }
            (Some(side), None) | (None, Some(side)) => of_interval(self.interval(side, i)),
            (None, None) => 1.0,
        }
    }

    /// Number of rows that cavities occupy, at least in part.
    pub fn cavity_rows(&self) -> usize {
        let deepest = self.columns.iter().map(|column| column.cavity_rows).fold(0.0, f64::max);
        (deepest.ceil() as usize).min(self.rows)
    }

    /// Visits every spring of the flat layer, with the share of its stiffness that remains, including springs to the
    /// bulk, in a fixed order: column by column, row by row. With `cavities` only springs that start near a cavity are
    /// visited: in the rows of the cavity, and in its columns or the columns next to them.
    fn visit_bonds(&self, cavities: bool, mut visit: impl FnMut(Bond, f64)) {
        let rows = if cavities { self.cavity_rows() } else { self.rows };
        for i in 0..self.nx() {
            let (left, right) = (self.left_of(i), self.right_of(i));
            if cavities && [left, Some(i), right].into_iter().flatten().all(|i| self.columns[i].coverage == 0.0) {
                continue;
            }
            let vertical = self.vertical_stiffness(i);
            let beside = |side: usize| {
                let w = self.interval(i, side);
                (side, w, springs(w))
            };
            let (to_left, to_right) = (left.map(beside), right.map(beside));
            for j in 0..rows {
                let above = j + 1;
                let mut join = |column: usize, row: usize, rest: [f64; 2], stiffness: f64| {
                    let b = (row < self.rows).then_some((column, row));
                    let deep = [self.depth_in(i, j), b.map_or(0.0, |(column, row)| self.depth_in(column, row))];
                    let there = joint_presence([i, column].map(|i| self.columns[i].coverage), deep);
                    visit(Bond { a: (i, j), b, rest, stiffness }, stiffness_share(there));
                };
                if let Some((right, w, [level, ..])) = to_right.filter(|(right, ..)| *right != i) {
                    join(right, j, [w, 0.0], level);
                }
                join(i, above, [0.0, 1.0], vertical);
                for (side, sign) in [(to_right, 1.0), (to_left, -1.0)] {
                    if let Some((side, w, [_, oblique, _])) = side {
                        join(side, above, [sign * w, 1.0], oblique);
                    }
                }
            }
        }
    }

    /// Visits every spring once, including springs to the bulk, in a fixed order: column by column, row by row. Springs
    /// of partial blocks are scaled by [`stiffness_share`].
    pub fn for_each_bond(&self, mut visit: impl FnMut(Bond)) {
        self.visit_bonds(false, |bond, share| {
            if share > 0.0 {
                visit(Bond { stiffness: bond.stiffness * share, ..bond });
            }
        });
    }

    /// Visits the missing stiffness of every spring that is weaker than in a flat layer, including springs of removed
    /// blocks, in a fixed order.
    pub fn for_each_missing_bond(&self, mut visit: impl FnMut(Bond)) {
        self.visit_bonds(true, |bond, share| {
            if share < 1.0 {
                visit(Bond { stiffness: bond.stiffness * (1.0 - share), ..bond });
            }
        });
    }

    /// Mass of block (i, j) in units of m = rho l^3, with the density rho and the lattice spacing l: a quarter for each
    /// adjacent square of the mesh whose four corners exist, at least 1/4; 0 where there is no block. The bulk above
    /// the last row counts as existing.
    pub fn mass(&self, i: usize, j: usize) -> f64 {
        let there = |i: usize, j: usize| j >= self.rows || self.presence(i, j) > 0.0;
        if !there(i, j) {
            return 0.0;
        }
        let mut quarters = 0;
        for side in [self.left_of(i), self.right_of(i)].into_iter().flatten() {
            for row in [j.checked_sub(1), Some(j + 1)].into_iter().flatten() {
                if there(side, j) && there(i, row) && there(side, row) {
                    quarters += 1;
                }
            }
        }
        f64::from(quarters.max(1)) / 4.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::columns::{cell, flat, sample};
    use crate::springblock::tests::samples::groove;

    fn published_cell() -> Lattice {
        Lattice::new(cell(&groove(130.0, 370.0, 20.0), 10e-6), 20, true)
    }

    #[test]
    fn masses_follow_the_quarter_cells() {
        let lattice = published_cell();
        assert_eq!(lattice.mass(5, 10), 1.0); // inside
        assert_eq!(lattice.mass(5, 0), 0.5); // on the counterface
        assert_eq!(lattice.mass(5, 19), 1.0); // below the bulk
        assert_eq!(lattice.mass(17, 0), 0.25); // edge of the land
        assert_eq!(lattice.mass(17, 1), 0.5); // wall of the cavity
        assert_eq!(lattice.mass(17, 2), 0.75); // re-entrant corner
        assert_eq!(lattice.mass(20, 1), 0.0); // removed
        assert_eq!(lattice.mass(20, 2), 0.5); // ceiling
        let free = Lattice::new(flat(4), 3, false);
        assert_eq!((free.mass(0, 0), free.mass(0, 1), free.mass(0, 2)), (0.25, 0.5, 0.5));
    }

    #[test]
    fn total_mass_is_that_of_the_cells() {
        // A flat periodic layer of ny rows has ny - 1/2 + 1/2 cells per column: the bulk's share of the top cell is
        // included, and half a cell is missing below row 0.
        let lattice = Lattice::new(flat(7), 5, true);
        let total: f64 = (0..7).flat_map(|i| (0..5).map(move |j| (i, j))).map(|(i, j)| lattice.mass(i, j)).sum();
        assert!((total - 7.0 * 4.5).abs() < 1e-12);
    }

    #[test]
    fn a_lone_land_column_weighs_at_least_a_quarter() {
        let lattice = Lattice::new(cell(&groove(20.0, 10.0, 20.0), 10e-6), 5, true);
        let land = lattice.contacts().next().unwrap();
        assert_eq!(lattice.mass(land, 0), 0.25);
    }

    /// Energy density of a uniform strain (exx, eyy, gxy) in units of k, from the springs of a periodic block of fitted
    /// columns away from its lower and upper edge rows.
    fn energy_density(widths: &[f64], strain: [f64; 3]) -> f64 {
        let columns: Vec<Column> = widths.iter().copied().map(Column::land).collect();
        let lattice = Lattice::new(columns, 6, true);
        let [exx, eyy, gxy] = strain;
        let mut energy = 0.0;
        lattice.for_each_bond(|bond| {
            // Rows 2 and 3 own the springs to the right and above: two full rows of cells.
            if (2..4).contains(&bond.a.1) {
                let [x, y] = bond.rest;
                let d = [exx * x + 0.5 * gxy * y, 0.5 * gxy * x + eyy * y];
                let [kxx, kxy, kyy] = bond.linear();
                energy += 0.5 * (kxx * d[0] * d[0] + 2.0 * kxy * d[0] * d[1] + kyy * d[1] * d[1]);
            }
        });
        energy / (2.0 * lattice.length())
    }

    #[test]
    fn springs_are_isotropic_plane_stress_with_nu_one_third_on_square_and_fitted_cells() {
        for widths in [vec![1.0; 6], vec![1.2; 5], vec![0.8; 5], vec![0.9, 0.9, 1.15, 1.15, 1.15]] {
            // C11 = C22 = 3k/2, C12 = C66 = k/2.
            for (strain, twice_energy) in
                [([1.0, 0.0, 0.0], 1.5), ([0.0, 1.0, 0.0], 1.5), ([0.0, 0.0, 1.0], 0.5), ([1.0, 1.0, 0.0], 4.0)]
            {
                let energy = energy_density(&widths, strain);
                assert!((2.0 * energy - twice_energy).abs() < 1e-12, "{widths:?} {strain:?} {energy}");
            }
        }
    }

    #[test]
    fn a_whole_block_lattice_has_the_plain_springs() {
        let mut seen = [0; 2];
        published_cell().for_each_bond(|bond| {
            let diagonal = bond.rest[0] != 0.0 && bond.rest[1] != 0.0;
            assert_eq!(bond.stiffness, if diagonal { 0.5 } else { 1.0 });
            seen[usize::from(diagonal)] += 1;
        });
        // 50 columns of 20 rows minus 13 x 2 removed blocks: horizontal and vertical springs of the rest.
        let horizontal = 50 * 20 - 2 * 14;
        let vertical = 50 * 20 - 2 * 13;
        assert_eq!(seen[0], horizontal + vertical);
        // Two diagonals above each block, except those from or to removed blocks.
        assert_eq!(seen[1], 2 * 50 * 20 - 2 * 2 * 13 - 2);
    }

    #[test]
    fn partial_ceiling_rows_scale_their_springs() {
        let lattice = Lattice::new(cell(&groove(130.0, 370.0, 14.0), 10e-6), 20, true);
        assert!((lattice.presence(20, 1) - 0.6).abs() < 1e-9 && lattice.presence(20, 0) == 0.0);
        assert_eq!(lattice.lowest_row(20), 1);
        assert!(!lattice.is_plain());
        lattice.for_each_bond(|bond| {
            if bond.a == (20, 1) && bond.b == Some((21, 1)) {
                // 3 y / (4 - y) at y = 0.6
                assert!((bond.stiffness - 1.8 / 3.4).abs() < 1e-9);
            }
        });
    }

    #[test]
    fn what_joins_two_blocks_lacks_the_union_of_what_they_lack() {
        let is = |covered, deep, expected: f64| assert!((joint_presence(covered, deep) - expected).abs() < 1e-12);
        is([1.0, 1.0], [0.4, 0.4], 0.6); // within a ceiling row
        is([0.3, 1.0], [0.4, 0.4], 0.6); // from it to the column at the edge
        is([0.3, 0.3], [1.0, 0.4], 0.7); // within that column
        is([0.3, 1.0], [1.0, 0.4], 0.7 * 0.6); // from that column, beside the cavity, to the ceiling
        is([0.0, 1.0], [1.0, 1.0], 0.0); // to a removed block
    }

    #[test]
    fn a_tie_stiffens_with_its_share_from_free_to_pinned() {
        for deep in [0.1, 0.5, 1.0] {
            let ties: Vec<f64> =
                (1..100).map(|n| 0.01 * f64::from(n)).map(|a| tie(a, 1.0 - (1.0 - a) * deep)).collect();
            assert!(ties[0] > 0.0 && ties[0] < 0.031 && ties[98] > 90.0, "{} {}", ties[0], ties[98]);
            assert!(ties.windows(2).all(|pair| pair[1] > pair[0]));
        }
        // On a whole block the tie stiffness is a/(1 - a).
        assert!((tie(0.25, 1.0) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_free_sample_has_one_diagonal_to_the_bulk_at_each_side() {
        let lattice = Lattice::new(sample(&groove(130.0, 370.0, 20.0), 10e-6, 100), 20, false);
        let mut to_bulk = vec![0; 100];
        lattice.for_each_bond(|bond| {
            if bond.b.is_none() {
                to_bulk[bond.a.0] += 1;
            }
        });
        assert_eq!((to_bulk[0], to_bulk[1], to_bulk[99]), (2, 3, 2));
    }
}
