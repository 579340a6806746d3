//! One side of a map in blocks of points: sums over blocks, and values repeated in them.

use std::f64::consts::TAU;
use std::ops::Range;

use multiversion::multiversion;

/// Points along a side of a block, on sides of at least [`SHORT_SIDE`] points; on shorter ones 1.
const BLOCK: usize = 4;
const SHORT_SIDE: usize = 16;
/// Weight of a block that is one point longer: sqrt(4/5).
const LONG_BLOCK_WEIGHT: f32 = 0.894_427_2;

/// One side of the map, cut into blocks. The first `long_blocks` of them have one point more than the others.
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

    /// The points of block `n`.
    pub(crate) fn points_of(&self, n: usize) -> Range<usize> {
        let start = |n: usize| n * self.block + n.min(self.long_blocks);
        start(n)..start(n + 1)
    }

    /// Points of the longest block.
    pub(crate) fn longest(&self) -> usize {
        self.points_of(0).len()
    }

    /// The weight of block `n`.
    pub(crate) fn weight(&self, n: usize) -> f32 {
        if n < self.long_blocks { LONG_BLOCK_WEIGHT } else { 1.0 }
    }

    /// `sums` of blocks of the rows `input`, which are one block of weight `weight`; `column_sums` is of one row.
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

    /// `values`, one a block, repeated at its points in rows of a block of weight `weight`.
    pub(crate) fn repeat(&self, values: &[f32], weight: f32, repeated: &mut [f32]) {
        if self.block == 1 {
            repeated.copy_from_slice(values);
        } else {
            let (long_values, other_values) = values.split_at(self.long_blocks);
            let (long, others) = repeated.split_at_mut(self.long_blocks * (BLOCK + 1));
            for (block, value) in long.chunks_exact_mut(BLOCK + 1).zip(long_values) {
                block.fill(LONG_BLOCK_WEIGHT * value);
            }
            repeat_values(other_values, others.as_chunks_mut::<BLOCK>().0);
        }
        scale(repeated, weight);
    }

    /// The share of a neighbour's value that either neighbour takes: they are one point where the side has two, and the
    /// point itself where it has one.
    pub(crate) fn neighbour_share(&self) -> f64 {
        match self.points {
            1 => 0.0,
            2 => 0.5,
            _ => 1.0,
        }
    }

    /// cos(2 pi k/n): what a wave of k along this side has at a neighbour, in the mean of both, over what it has at a point.
    pub(crate) fn turned(&self, k: usize) -> f64 {
        (TAU * k as f64 / self.points as f64).cos()
    }

    /// What a factor of waves along this side is at c = 0 and how it grows with c, c the wave's [`Self::turned`], on the line through
    /// its values at a quarter of all waves and at half of them. On sides without a coarse grid: its value at a quarter.
    pub(crate) fn line(&self, factor: impl Fn(usize) -> f64) -> [f64; 2] {
        let [quarter, half] = [self.points / 4, self.points / 2];
        let (at_quarter, at_half) = (factor(quarter), factor(half));
        if self.block == 1 {
            return [at_quarter, 0.0];
        }
        let slope = (at_quarter - at_half) / (self.turned(quarter) - self.turned(half));
        [at_quarter - slope * self.turned(quarter), slope]
    }
}

/// Multiplies by a block's weight; most are 1.
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
fn repeat_values(values: &[f32], blocks: &mut [[f32; BLOCK]]) {
    for (block, &value) in blocks.iter_mut().zip(values) {
        *block = [value; BLOCK];
    }
}
