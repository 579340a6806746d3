//! One side of a map divided into blocks of points: sums over blocks, and expansion of block values to points.

use std::f64::consts::TAU;
use std::ops::Range;

use multiversion::multiversion;

/// Number of points along a side of a block, if the side of the map has at least [`SHORT_SIDE`] points.
const BLOCK: usize = 4;
/// A side of the map with fewer points than this has blocks of one point.
const SHORT_SIDE: usize = 16;
/// Weight of a block of five points, sqrt(4/5); see `two_grids`.
const LONG_BLOCK_WEIGHT: f32 = 0.894_427_2;

/// One side of the map, divided into blocks of `block` points; the first `long_blocks` blocks have one point more.
#[derive(Clone, Debug)]
pub(crate) struct Side {
    pub(crate) points: usize,
    pub(crate) block: usize,
    pub(crate) blocks: usize,
    long_blocks: usize,
}

impl Side {
    pub(crate) fn new(points: usize) -> Self {
        let block = if points < SHORT_SIDE { 1 } else { BLOCK };
        Self { points, block, blocks: points / block, long_blocks: points % block }
    }

    pub(crate) fn block_points(&self, n: usize) -> Range<usize> {
        let start = |n: usize| n * self.block + n.min(self.long_blocks);
        start(n)..start(n + 1)
    }

    /// Number of points in the longest block.
    pub(crate) fn longest_block(&self) -> usize {
        self.block_points(0).len()
    }

    pub(crate) fn weight(&self, n: usize) -> f32 {
        if n < self.long_blocks { LONG_BLOCK_WEIGHT } else { 1.0 }
    }

    /// Writes to `sums` the weighted sum of the points in each block of one row of blocks.
    ///
    /// `input` holds the map rows of this row of blocks. Each point has `weight` times the weight of its block along
    /// this side. `column_sums` is scratch space of one map row.
    pub(crate) fn sum(&self, input: &[f32], weight: f32, column_sums: &mut [f32], sums: &mut [f32]) {
        column_sums.fill(0.0);
        let mut fours = input.chunks_exact(4 * self.points);
        for four in &mut fours {
            let (two, others) = four.split_at(2 * self.points);
            let ((a, b), (c, d)) = (two.split_at(self.points), others.split_at(self.points));
            add_four(column_sums, [a, b, c, d]);
        }
        fours.remainder().chunks_exact(self.points).for_each(|row| add(column_sums, row));
        scale(column_sums, weight);
        if self.block == 1 {
            sums.copy_from_slice(column_sums);
            return;
        }
        let (long, others) = column_sums.split_at(self.long_blocks * (BLOCK + 1));
        let (long_sums, other_sums) = sums.split_at_mut(self.long_blocks);
        for (sum, block) in long_sums.iter_mut().zip(long.chunks_exact(BLOCK + 1)) {
            *sum = LONG_BLOCK_WEIGHT * block.iter().sum::<f32>();
        }
        sum_blocks(others.as_chunks::<BLOCK>().0, other_sums);
    }

    /// Fills the map row `expanded` with the value in `values` of each point's block, times `weight` and the weight of
    /// the block along this side.
    pub(crate) fn expand(&self, values: &[f32], weight: f32, expanded: &mut [f32]) {
        if self.block == 1 {
            expanded.copy_from_slice(values);
        } else {
            let (long_values, other_values) = values.split_at(self.long_blocks);
            let (long, others) = expanded.split_at_mut(self.long_blocks * (BLOCK + 1));
            for (block, value) in long.chunks_exact_mut(BLOCK + 1).zip(long_values) {
                block.fill(LONG_BLOCK_WEIGHT * value);
            }
            expand_values(other_values, others.as_chunks_mut::<BLOCK>().0);
        }
        scale(expanded, weight);
    }

    /// Factor on the stencil weight of a neighbour along this side, 1 on sides of three points or more.
    ///
    /// On a side of two points both neighbours are the same point, so each counts half. On a side of one point the
    /// neighbour is the point itself and counts nothing.
    pub(crate) fn neighbour_share(&self) -> f64 {
        match self.points {
            1 => 0.0,
            2 => 0.5,
            _ => 1.0,
        }
    }

    /// cos(2 pi k/n) on a side of n points. In a wave of `k` periods along this side, the mean of the two neighbours of
    /// a point is this factor times the value at the point.
    pub(crate) fn neighbour_cosine(&self, k: usize) -> f64 {
        (TAU * k as f64 / self.points as f64).cos()
    }

    /// Fits a straight line in c = [`Self::neighbour_cosine`] to `factor(k)` at k = n/4 and k = n/2 on a side of n
    /// points.
    ///
    /// Returns the value at c = 0 and the slope. A side with blocks of one point returns `factor(n/4)` and slope 0.
    pub(crate) fn fit_line(&self, factor: impl Fn(usize) -> f64) -> [f64; 2] {
        let [quarter, half] = [self.points / 4, self.points / 2];
        let (at_quarter, at_half) = (factor(quarter), factor(half));
        if self.block == 1 {
            return [at_quarter, 0.0];
        }
        let slope = (at_quarter - at_half) / (self.neighbour_cosine(quarter) - self.neighbour_cosine(half));
        [at_quarter - slope * self.neighbour_cosine(quarter), slope]
    }
}

/// Multiplies `values` by a block weight, which is 1 for most blocks.
fn scale(values: &mut [f32], weight: f32) {
    if weight != 1.0 {
        values.iter_mut().for_each(|value| *value *= weight);
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add(sums: &mut [f32], row: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += value;
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_four(sums: &mut [f32], [a, b, c, d]: [&[f32]; 4]) {
    for ((((sum, a), b), c), d) in sums.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *sum += (a + b) + (c + d);
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn sum_blocks(blocks: &[[f32; BLOCK]], sums: &mut [f32]) {
    for (sum, [a, b, c, d]) in sums.iter_mut().zip(blocks) {
        *sum = (a + b) + (c + d);
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn expand_values(values: &[f32], blocks: &mut [[f32; BLOCK]]) {
    for (block, &value) in blocks.iter_mut().zip(values) {
        *block = [value; BLOCK];
    }
}
