//! Multigrid cycle for sum over neighbours of w (h - h_neighbour) = b at the missing points of a map.
//!
//! Missing points that share a cell of 2 x 2 points (4 x 1 if the coupling along one axis is far stronger) form one
//! unknown of the next coarser level, which has the same five-point form. A weight between two cells is the sum of the
//! weights between their points, divided by the cells' length, as on a mesh of that spacing. A W cycle with one forward
//! Gauss-Seidel sweep before and one backward sweep after the correction is symmetric, as conjugate gradients require.
//! It works in single precision, which suffices for a preconditioner.

use slipgrid_base::monitor::Monitor;

/// Marks an absent neighbour.
pub(super) const NONE: u32 = u32::MAX;
/// Number of unknowns at which coarsening stops; sweeps alone solve this level.
const MAX_COARSEST_UNKNOWNS: usize = 32;
/// Number of forward and backward sweeps on the coarsest level.
const COARSEST_SWEEPS: usize = 8;
/// If the couplings along the two axes differ by more than this factor, only the strongly coupled axis is coarsened.
const STRONG: f32 = 3.0;
/// Number of corrections from the coarser level in a cycle. Two corrections on a quarter of the unknowns cost half a
/// sweep of this level.
const CORRECTIONS: usize = 2;

/// Unknowns of one level, row by row, so that the right neighbour of unknown n is n + 1.
#[derive(Debug)]
pub(super) struct Level {
    /// Number of cells along a row of the level's grid.
    cols: usize,
    /// Index of each unknown's cell in the level's grid, row by row.
    pub(super) cell: Vec<u32>,
    /// Neighbour of each unknown in the previous row; [`NONE`] where the neighbour is not an unknown.
    pub(super) up: Vec<u32>,
    /// Neighbour of each unknown in the next row; [`NONE`] where the neighbour is not an unknown.
    pub(super) down: Vec<u32>,
    /// Weight of the right neighbour; 0 where the neighbour is not an unknown.
    weight_right: Vec<f32>,
    /// Weight of the neighbour in the next row; 0 where the neighbour is not an unknown.
    weight_down: Vec<f32>,
    /// Sum of the weights of the neighbours with known height, for each unknown.
    anchor: Vec<f32>,
    /// Weights of neighbours across and along the rows on a complete grid of this level.
    nominal: [f32; 2],
    /// Unknown of the next coarser level that contains each unknown.
    parent: Vec<u32>,
    /// Approximate solution.
    pub(super) solution: Vec<f32>,
    /// Right side b of the equations.
    pub(super) right_side: Vec<f32>,
}

impl Level {
    /// The finest level: unknowns in the cells `cell` of a map of `rows` x `cols`, with the weights `weight` of
    /// neighbours across and along the rows.
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

    /// Builds the next coarser level and sets `parent` of this level's unknowns.
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
            // All unknowns lie in one row of coarse cells.
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
        // Parallel links between neighbouring cells add up, and a link weakens in proportion to the cell's length.
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
            // The hole's rim is closer than a neighbouring cell's centre by half a cell.
            coarse.anchor[parent] += self.anchor[n] * ANCHOR;
        }
        coarse
    }

    /// Weighted sum of the solution over the neighbours of unknown `n`, and the sum of all weights, including those of
    /// known heights.
    fn weighted_neighbours(&self, n: usize) -> (f32, f32) {
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
            let (sum, weights) = self.weighted_neighbours(n);
            if weights > 0.0 {
                self.solution[n] = (self.right_side[n] + sum) / weights;
            }
        }
    }
}

/// Fraction of the weights of known heights (`anchor`) of a cell's points that the coarser cell keeps.
const ANCHOR: f32 = 0.5;

/// All levels, the finest first.
pub(super) struct Multigrid {
    pub(super) levels: Vec<Level>,
}

impl Multigrid {
    /// Builds the levels for unknowns in the sorted cells `cell` of a map of `rows` x `cols`; stops early once
    /// `monitor` cancels.
    pub(super) fn new(cell: Vec<u32>, [rows, cols]: [usize; 2], weight: [f64; 2], monitor: &dyn Monitor) -> Self {
        let mut levels = vec![Level::finest(cell, rows, cols, weight.map(|weight| weight as f32))];
        while let Some(finest) =
            levels.last_mut().filter(|level| level.cell.len() > MAX_COARSEST_UNKNOWNS && !monitor.cancelled())
        {
            let coarse = finest.coarser();
            // Unknowns that are alone in their cells merge once the cells have grown; the last level is a single cell.
            levels.push(coarse);
        }
        Self { levels }
    }

    /// Runs one cycle from zero on the finest level's right side; stops early once `monitor` cancels.
    pub(super) fn precondition(&mut self, monitor: &dyn Monitor) {
        self.levels[0].solution.fill(0.0);
        cycle(&mut self.levels, monitor);
    }
}

/// Improves the solution of the first level by one cycle.
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
        let (sum, weights) = fine.weighted_neighbours(n);
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
