//! One cycle of multigrid for sum over neighbours of w (h - h_neighbour) = b at the missing points of a map.
//!
//! Missing points that share a cell of 2 x 2 (of 4 x 1 where one axis couples far more strongly) are one unknown of the
//! next coarser level, which has the same five-point form: weights between cells are the sums of those between their
//! points, over the cells' length, as the coarser mesh itself would have them. A W cycle with one Gauss-Seidel
//! sweep forward before and one backward after the correction is symmetric, as conjugate gradients need it; it works in single
//! precision, for it only steers them.

use slipgrid_monitor::Monitor;

/// No neighbour there.
pub(super) const NONE: u32 = u32::MAX;
/// Unknowns of the coarsest level, which sweeps alone solve.
const FEWEST: usize = 32;
/// Sweeps there and back on the coarsest level.
const COARSEST_SWEEPS: usize = 8;
/// Ratio of the couplings along both axes from which only the strong axis is coarsened.
const STRONG: f32 = 3.0;
/// Corrections from the coarser level in a cycle: 2 of a quarter of the unknowns cost half of this level.
const CORRECTIONS: usize = 2;

/// The unknowns of one level, row by row, so that the neighbour to the right of unknown n is n + 1.
#[derive(Debug)]
pub(super) struct Level {
    /// Cells of the level's grid along a row.
    cols: usize,
    /// The cell of each unknown, row by row.
    pub(super) cell: Vec<u32>,
    /// Neighbours across the rows, [`NONE`] where none is unknown.
    pub(super) up: Vec<u32>,
    pub(super) down: Vec<u32>,
    /// Weight of the neighbour to the right, 0 if that is no unknown, and of the one below.
    weight_right: Vec<f32>,
    weight_down: Vec<f32>,
    /// Sum of the weights of the neighbours whose height is known.
    anchor: Vec<f32>,
    /// Nominal weights across and along the rows.
    nominal: [f32; 2],
    /// The unknown of the next coarser level that this one is part of.
    parent: Vec<u32>,
    /// Approximate solution, and right side.
    pub(super) solution: Vec<f32>,
    pub(super) right_side: Vec<f32>,
}

impl Level {
    /// The level of the map itself: unknowns in the cells `cell` of a grid of `rows` x `cols`, weights of neighbours
    /// `weight` across and along the rows.
    fn finest(cell: Vec<u32>, rows: usize, cols: usize, weight: [f32; 2]) -> Self {
        let count = cell.len();
        let mut level = Self::empty(cell, cols, weight);
        let mut row_above = vec![NONE; cols];
        let mut row_here = vec![NONE; cols];
        let mut row = usize::MAX;
        for n in 0..count {
            let (i, j) = (level.cell[n] as usize / cols, level.cell[n] as usize % cols);
            if i != row {
                std::mem::swap(&mut row_above, &mut row_here);
                if i != row.wrapping_add(1) {
                    row_above.fill(NONE);
                }
                row_here.fill(NONE);
                row = i;
            }
            row_here[j] = n as u32;
            level.up[n] = row_above[j];
            if row_above[j] != NONE {
                level.down[row_above[j] as usize] = n as u32;
                level.weight_down[row_above[j] as usize] = weight[0];
            }
            if j + 1 < cols && n + 1 < count && level.cell[n + 1] == level.cell[n] + 1 {
                level.weight_right[n] = weight[1];
            }
        }
        for n in 0..count {
            let (i, j) = (level.cell[n] as usize / cols, level.cell[n] as usize % cols);
            let known = |there: bool, unknown: bool, weight: f32| if there && !unknown { weight } else { 0.0 };
            level.anchor[n] = known(i > 0, level.up[n] != NONE, weight[0])
                + known(i + 1 < rows, level.down[n] != NONE, weight[0])
                + known(j > 0, level.has_left(n), weight[1])
                + known(j + 1 < cols, level.has_right(n), weight[1]);
        }
        level
    }

    fn empty(cell: Vec<u32>, cols: usize, nominal: [f32; 2]) -> Self {
        let count = cell.len();
        Self {
            cols,
            cell,
            up: vec![NONE; count],
            down: vec![NONE; count],
            weight_right: vec![0.0; count],
            weight_down: vec![0.0; count],
            anchor: vec![0.0; count],
            nominal,
            parent: Vec::new(),
            solution: vec![0.0; count],
            right_side: vec![0.0; count],
        }
    }

    pub(super) fn has_right(&self, n: usize) -> bool {
        self.weight_right[n] > 0.0
    }

    pub(super) fn has_left(&self, n: usize) -> bool {
        n > 0 && self.has_right(n - 1)
    }

    /// The next coarser level; this one's unknowns learn their parents.
    fn coarser(&mut self) -> Self {
        let [across, along] = self.nominal;
        let size = if across > STRONG * along {
            [4, 1]
        } else if along > STRONG * across {
            [1, 4]
        } else {
            [2, 2]
        };
        let cols = self.cols.div_ceil(size[1]);
        let place = |cell: u32| (cell as usize / self.cols / size[0], cell as usize % self.cols / size[1]);
        self.parent = vec![0; self.cell.len()];
        let mut cell = Vec::new();
        let mut number = vec![NONE; cols];
        let mut from = 0;
        while from < self.cell.len() {
            // All unknowns in one row of coarser cells.
            let row = place(self.cell[from]).0;
            let count = self.cell[from..].partition_point(|&fine| place(fine).0 == row);
            number.fill(NONE);
            for &fine in &self.cell[from..from + count] {
                number[place(fine).1] = 0;
            }
            for (col, number) in number.iter_mut().enumerate().filter(|(_, number)| **number != NONE) {
                *number = cell.len() as u32;
                cell.push((row * cols + col) as u32);
            }
            for n in from..from + count {
                self.parent[n] = number[place(self.cell[n]).1];
            }
            from += count;
        }
        let [size_across, size_along] = size.map(|size| size as f32);
        // Over the cell's length across the axis there are as many weights, along it one over its length.
        let nominal = [across * size_along / size_across, along * size_across / size_along];
        let mut coarse = Self::empty(cell, cols, nominal);
        for n in 0..self.cell.len() {
            let parent = self.parent[n] as usize;
            if self.has_right(n) && self.parent[n + 1] != self.parent[n] {
                coarse.weight_right[parent] += self.weight_right[n] / size_along;
            }
            if self.down[n] != NONE {
                let below = self.parent[self.down[n] as usize];
                if below as usize != parent {
                    coarse.weight_down[parent] += self.weight_down[n] / size_across;
                    coarse.down[parent] = below;
                    coarse.up[below as usize] = parent as u32;
                }
            }
            // The rim is nearer than a neighbour by half a cell.
            coarse.anchor[parent] += self.anchor[n] * ANCHOR;
        }
        coarse
    }

    /// Sum of the weighted neighbours of unknown `n`, and the sum of all its weights.
    fn around(&self, n: usize) -> (f32, f32) {
        let (mut sum, mut weights) = (0.0, self.anchor[n]);
        let mut add = |neighbour: usize, weight: f32| {
            sum += weight * self.solution[neighbour];
            weights += weight;
        };
        if self.has_right(n) {
            add(n + 1, self.weight_right[n]);
        }
        if self.has_left(n) {
            add(n - 1, self.weight_right[n - 1]);
        }
        if self.down[n] != NONE {
            add(self.down[n] as usize, self.weight_down[n]);
        }
        if self.up[n] != NONE {
            add(self.up[n] as usize, self.weight_down[self.up[n] as usize]);
        }
        (sum, weights)
    }

    /// One Gauss-Seidel sweep over `unknowns` in their order.
    fn sweep(&mut self, unknowns: impl Iterator<Item = usize>) {
        for n in unknowns {
            let (sum, weights) = self.around(n);
            if weights > 0.0 {
                self.solution[n] = (self.right_side[n] + sum) / weights;
            }
        }
    }
}

/// Share of the anchors of a cell's points that its own has.
const ANCHOR: f32 = 0.5;

/// All levels, the finest first.
pub(super) struct Multigrid {
    pub(super) levels: Vec<Level>,
}

impl Multigrid {
    /// The levels for unknowns in the cells `cell` of a map of `rows` x `cols`, sorted; too few once `monitor` cancels.
    pub(super) fn new(cell: Vec<u32>, [rows, cols]: [usize; 2], weight: [f64; 2], monitor: &dyn Monitor) -> Self {
        let mut levels = vec![Level::finest(cell, rows, cols, weight.map(|weight| weight as f32))];
        while let Some(finest) = levels.last_mut().filter(|level| level.cell.len() > FEWEST && !monitor.cancelled()) {
            let coarse = finest.coarser();
            // Points that are alone in their cells merge at last, when the cells have grown; a single cell ends it.
            levels.push(coarse);
        }
        Self { levels }
    }

    /// One cycle from zero for the finest level's right side, or a part of one once `monitor` cancels.
    pub(super) fn precondition(&mut self, monitor: &dyn Monitor) {
        self.levels[0].solution.fill(0.0);
        cycle(&mut self.levels, monitor);
    }
}

/// One cycle that improves the first level's solution.
fn cycle(levels: &mut [Level], monitor: &dyn Monitor) {
    let Some((fine, coarser)) = levels.split_first_mut().filter(|_| !monitor.cancelled()) else { return };
    let count = fine.cell.len();
    let Some(coarse) = coarser.first_mut() else {
        for _ in 0..COARSEST_SWEEPS {
            fine.sweep(0..count);
            fine.sweep((0..count).rev());
        }
        return;
    };
    fine.sweep(0..count);
    coarse.right_side.fill(0.0);
    coarse.solution.fill(0.0);
    for n in 0..count {
        let (sum, weights) = fine.around(n);
        coarse.right_side[fine.parent[n] as usize] += fine.right_side[n] + sum - weights * fine.solution[n];
    }
    for _ in 0..CORRECTIONS {
        cycle(coarser, monitor);
    }
    for (solution, &parent) in fine.solution.iter_mut().zip(&fine.parent) {
        *solution += coarser[0].solution[parent as usize];
    }
    fine.sweep((0..count).rev());
}
