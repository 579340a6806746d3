//! A cheap approximation of a convolution: a stencil for the short range and a coarse grid for the rest.
//!
//! ```text
//! A  ~  N + B^T C B
//! ```
//!
//! where N is a stencil of a point and its eight neighbours, B sums over blocks of 4 x 4 points, B^T copies a block's
//! value to its points, and C multiplies the waves of the coarse grid by the difference between the factors of A and N.
//! N and B^T C B are symmetric.
//!
//! If 4 does not divide a side, up to three of its blocks have 5 points. B and B^T then weight a block of n points by
//! sqrt(4/n), so that B B^T is 16 times the identity on every grid. Without the weights B^T C B would subtract more
//! from N at long blocks than N has there: the sum would be indefinite, and conjugate gradients preconditioned by it
//! would stall.

use std::ops::Range;

use crate::topography::fourier::{Fourier, FourierWork, Multiplier};
use multiversion::multiversion;

use crate::contact::blocks::Side;
use crate::contact::kernels::dot;

/// Values of a convolution stencil: at the point, at its neighbours in the next row, in the next column, and at the
/// corners.
#[derive(Clone, Copy, Debug)]
struct Stencil {
    centre: f64,
    next_row: f64,
    next_column: f64,
    corner: f64,
}

impl Stencil {
    /// Returns the stencil that has the values of a kernel at a point and its neighbours; the Fourier transform of the
    /// kernel is `stiffness`, and its values are (1/N) sum of stiffness cos(q x) over N waves.
    fn from_kernel(rows: &Side, cols: &Side, stiffness: impl Fn(usize, usize) -> f64) -> Self {
        let [mut centre, mut next_row, mut next_column, mut corner] = [0.0; 4];
        let row_cosines: Vec<f64> = (0..=rows.points / 2).map(|k| rows.neighbour_cosine(k)).collect();
        for l in 0..=cols.points / 2 {
            let [mut here, mut neighbours] = [0.0; 2];
            for (k, neighbour_cosine) in row_cosines.iter().enumerate() {
                let wave = multiplicity(k, rows.points) * stiffness(k, l);
                here += wave;
                neighbours += wave * neighbour_cosine;
            }
            let (multiplicity, neighbour_cosine) = (multiplicity(l, cols.points), cols.neighbour_cosine(l));
            centre += multiplicity * here;
            next_row += multiplicity * neighbours;
            next_column += multiplicity * here * neighbour_cosine;
            corner += multiplicity * neighbours * neighbour_cosine;
        }
        let per_point = 1.0 / (rows.points * cols.points) as f64;
        let (row_share, column_share) = (per_point * rows.neighbour_share(), cols.neighbour_share());
        Self {
            centre: per_point * centre,
            next_row: row_share * next_row,
            next_column: per_point * column_share * next_column,
            corner: row_share * column_share * corner,
        }
    }

    /// Fits a stencil whose transform is bilinear in the cosines of the two sides and equals `factor` at n/4 and n/2
    /// periods along sides of n points.
    fn from_short_waves(rows: &Side, cols: &Side, factor: impl Fn(usize, usize) -> f64) -> Self {
        let along = |part: usize| rows.fit_line(|k| cols.fit_line(|l| factor(k, l))[part]);
        let ([centre, by_row], [by_column, by_both]) = (along(0), along(1));
        Self { centre, next_row: by_row / 2.0, next_column: by_column / 2.0, corner: by_both / 4.0 }
    }

    /// Fourier transform of the stencil at a wave; `cos_x` and `cos_y` are [`Side::neighbour_cosine`], cos(2 pi k/n),
    /// along both sides.
    fn factor(&self, cos_x: f64, cos_y: f64) -> f64 {
        let neighbours = 2.0 * (self.next_row * cos_x + self.next_column * cos_y);
        self.centre + neighbours + 4.0 * self.corner * cos_x * cos_y
    }
}

/// Mean of `factor` over all waves of a grid, which is the value of the convolution kernel at its centre.
fn mean_of_waves(rows: usize, cols: usize, factor: impl Fn(usize, usize) -> f64) -> f64 {
    let waves = (0..=rows / 2).flat_map(|k| (0..=cols / 2).map(move |l| (k, l)));
    waves.map(|(k, l)| multiplicity(k, rows) * multiplicity(l, cols) * factor(k, l)).sum::<f64>() / (rows * cols) as f64
}

/// Number of waves among k and -k along a side of `points`: 1 if they are the same wave, otherwise 2.
fn multiplicity(k: usize, points: usize) -> f64 {
    if k == 0 || 2 * k == points { 1.0 } else { 2.0 }
}

/// Choice of the stencil for the short range of a convolution.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Near {
    /// Kernel values at a point and its neighbours, for kernels that decay fast.
    Kernel,
    /// Factors of short waves and the centre of the kernel, for long-range kernels with a smooth remainder.
    ShortWaves,
}

/// Approximation N + B^T C B of a convolution A on maps of one size: a stencil N, sums B over blocks, and a convolution
/// C on the coarse grid of the blocks.
#[derive(Clone, Debug)]
pub(crate) struct TwoGrids {
    rows: Side,
    cols: Side,
    stencil: Stencil,
    coarse: Fourier<f32>,
    remainder: Multiplier<f32>,
}

/// Buffers that each concurrent use of [`TwoGrids`] needs.
pub(crate) struct TwoGridsWork {
    fourier: FourierWork<'static, f32>,
    /// Sums over blocks, B x.
    blocks: Vec<f32>,
    /// Contribution of the coarse grid per block, C B x.
    added: Vec<f32>,
    /// Row of `added` that belongs to the current map row, expanded to points.
    expanded: Vec<f32>,
    /// Sum of the rows before and after the current row.
    neighbours: Vec<f32>,
    /// First map row, saved because `apply` overwrites its input.
    first: Vec<f32>,
    /// Map row before the current one, saved because `apply` overwrites its input.
    before: Vec<f32>,
    /// Result rows of one row of blocks.
    result: Vec<f32>,
}

impl TwoGrids {
    /// Approximates the convolution on maps of `rows` x `cols` points that multiplies the wave with k periods along x
    /// and l along y by `factor(k, l)`.
    pub(crate) fn new(rows: usize, cols: usize, near: Near, factor: impl Fn(usize, usize) -> f64) -> Self {
        let (rows, cols) = (Side::new(rows), Side::new(cols));
        let coarse = Fourier::new(rows.blocks, cols.blocks);
        // B B^T is the identity divided by this number.
        let blocks_per_point = 1.0 / (rows.block * cols.block) as f64;
        let rest = |stencil: Stencil, k: usize, l: usize| {
            (factor(k, l) - stencil.factor(rows.neighbour_cosine(k), cols.neighbour_cosine(l))) * blocks_per_point
        };
        let mut stencil = match near {
            Near::Kernel => Stencil::from_kernel(&rows, &cols, &factor),
            Near::ShortWaves => Stencil::from_short_waves(&rows, &cols, &factor),
        };
        if matches!(near, Near::ShortWaves) && blocks_per_point < 1.0 {
            // Correct the centre so that a single point meets the kernel's centre. The coarse grid takes back the share
            // `blocks_per_point` of any correction.
            let alone = mean_of_waves(rows.points, cols.points, &factor);
            let found = stencil.centre + mean_of_waves(rows.blocks, cols.blocks, |k, l| rest(stencil, k, l));
            stencil.centre += (alone - found) / (1.0 - blocks_per_point);
        }
        let remainder = coarse.wave_multiplier(|k, l| rest(stencil, k, l));
        Self { rows, cols, stencil, coarse, remainder }
    }

    pub(crate) fn work(&self) -> TwoGridsWork {
        let blocks = self.rows.blocks * self.cols.blocks;
        let row = || vec![0.0; self.cols.points];
        TwoGridsWork {
            fourier: self.coarse.work(),
            blocks: vec![0.0; blocks],
            added: vec![0.0; blocks],
            expanded: row(),
            neighbours: row(),
            first: row(),
            before: row(),
            result: vec![0.0; self.rows.longest_block() * self.cols.points],
        }
    }

    /// Weight of the point itself in the stencil: for [`Near::Kernel`], the value of the kernel at its centre.
    pub(crate) fn centre(&self) -> f64 {
        self.stencil.centre
    }

    /// Indices of the points in block row `n`.
    fn block_points(&self, n: usize) -> Range<usize> {
        let rows = self.rows.block_points(n);
        rows.start * self.cols.points..rows.end * self.cols.points
    }

    /// Fills `values` by calls of `fill` for one range of points after the other, and computes the block sums that
    /// [`Self::apply`] needs.
    pub(crate) fn gather(
        &self,
        values: &mut [f32],
        work: &mut TwoGridsWork,
        mut fill: impl FnMut(Range<usize>, &mut [f32]),
    ) {
        for (n, sums) in work.blocks.chunks_exact_mut(self.cols.blocks).enumerate() {
            let points = self.block_points(n);
            let values = &mut values[points.clone()];
            fill(points, values);
            self.cols.sum(values, self.rows.weight(n), &mut work.expanded, sums);
        }
    }

    /// Computes A `values`, one row of blocks after the other.
    ///
    /// `update` receives a range of points, the values of A `values` there, and those of `values`, and may overwrite
    /// both. The block sums of A `values`, as overwritten, are kept for the next call. Requires the block sums of
    /// `values` from [`Self::gather`] or from the previous call.
    pub(crate) fn apply(
        &self,
        values: &mut [f32],
        work: &mut TwoGridsWork,
        mut update: impl FnMut(Range<usize>, &mut [f32], &mut [f32]),
    ) {
        let Self { rows, cols, stencil, coarse, remainder } = self;
        let TwoGridsWork { fourier, blocks, added, expanded, neighbours, first, before, result } = work;
        coarse.filter(blocks, remainder, added, fourier);
        // Save the rows that neighbours still need after they have been overwritten.
        first.copy_from_slice(&values[..cols.points]);
        before.copy_from_slice(&values[values.len() - cols.points..]);
        let grids = added.chunks_exact(cols.blocks).zip(blocks.chunks_exact_mut(cols.blocks));
        for (n, (coarse_values, sums)) in grids.enumerate() {
            cols.expand(coarse_values, rows.weight(n), expanded);
            let points = self.block_points(n);
            let result = &mut result[..points.len()];
            for (row, result) in rows.block_points(n).zip(result.chunks_exact_mut(cols.points)) {
                let (row, after) = values[row * cols.points..].split_at(cols.points);
                sum_rows(neighbours, before, after.get(..cols.points).unwrap_or(first));
                apply_stencil(result, row, neighbours, expanded, *stencil);
                before.copy_from_slice(row);
            }
            update(points.clone(), result, &mut values[points]);
            cols.sum(result, rows.weight(n), expanded, sums);
        }
    }

    /// Fills `values` by calls of `fill` for one range of points after the other, and returns the scalar product of
    /// `values` and A `values`.
    pub(crate) fn energy(
        &self,
        values: &mut [f32],
        work: &mut TwoGridsWork,
        mut fill: impl FnMut(Range<usize>, &mut [f32]),
    ) -> f64 {
        let Self { rows, cols, stencil, coarse, remainder } = self;
        let mut energy = 0.0;
        // Each row counts with itself and twice with the row before it; by symmetry this includes the row after it.
        let mut near_energy = |row: &[f32], before: &[f32], work: &mut TwoGridsWork| {
            let TwoGridsWork { expanded, neighbours, result, .. } = work;
            sum_rows(neighbours, before, before);
            let result = &mut result[..cols.points];
            apply_stencil(result, row, neighbours, expanded, *stencil);
            energy += dot(row, result);
        };
        for n in 0..rows.blocks {
            let points = self.block_points(n);
            fill(points.clone(), &mut values[points.clone()]);
            // The contribution of the coarse grid is added at the end.
            work.expanded.fill(0.0);
            for start in points.clone().step_by(cols.points).filter(|&start| start > 0) {
                let (before, row) = values[start - cols.points..start + cols.points].split_at(cols.points);
                near_energy(row, before, work);
            }
            let sums = &mut work.blocks[n * cols.blocks..(n + 1) * cols.blocks];
            cols.sum(&values[points], rows.weight(n), &mut work.expanded, sums);
        }
        work.expanded.fill(0.0);
        near_energy(&values[..cols.points], &values[values.len() - cols.points..], work);
        coarse.filter(&work.blocks, remainder, &mut work.added, &mut work.fourier);
        energy + dot(&work.blocks, &work.added)
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn sum_rows(sums: &mut [f32], before: &[f32], after: &[f32]) {
    for ((sum, b), a) in sums.iter_mut().zip(before).zip(after) {
        *sum = b + a;
    }
}

/// Computes one row of N x + `added` for the stencil N and a periodic grid x, of which `row` is this row; `neighbours`
/// is the sum of the rows before and after `row`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn apply_stencil(output: &mut [f32], row: &[f32], neighbours: &[f32], added: &[f32], stencil: Stencil) {
    let [centre, next_row, next_column, corner] =
        [stencil.centre, stencil.next_row, stencil.next_column, stencil.corner].map(|weight| weight as f32);
    // Arguments: values of three columns in this row, and the sums over the rows before and after it.
    let value = |[left, here, right]: [f32; 3], [neighbours_left, neighbours, neighbours_right]: [f32; 3]| {
        centre * here
            + next_row * neighbours
            + next_column * (left + right)
            + corner * (neighbours_left + neighbours_right)
    };
    let last = row.len() - 1;
    for column in [0, last] {
        let columns =
            [if column == 0 { last } else { column - 1 }, column, if column == last { 0 } else { column + 1 }];
        output[column] = added[column] + value(columns.map(|n| row[n]), columns.map(|n| neighbours[n]));
    }
    if let Some(inner) = output.get_mut(1..last) {
        for (n, out) in inner.iter_mut().enumerate() {
            *out = added[n + 1]
                + value([row[n], row[n + 1], row[n + 2]], [neighbours[n], neighbours[n + 1], neighbours[n + 2]]);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// q/q1 on pixels of 1 x `aspect`, 1/2 for the mean.
    pub(crate) fn stiffness((rows, cols): (usize, usize), aspect: f64) -> impl Fn(usize, usize) -> f64 {
        let (x, y) = (1.0 / rows as f64, 1.0 / (cols as f64 * aspect));
        move |k, l| if k == 0 && l == 0 { 0.5 } else { (k as f64 * x).hypot(l as f64 * y) / x.min(y) }
    }

    /// q1/q on pixels of 1 x `aspect`, 0 for the mean.
    fn compliance(sides: (usize, usize), aspect: f64) -> impl Fn(usize, usize) -> f64 {
        let stiffness = stiffness(sides, aspect);
        move |k, l| if k == 0 && l == 0 { 0.0 } else { 1.0 / stiffness(k, l) }
    }

    fn applied(convolution: &TwoGrids, input: &[f32]) -> Vec<f32> {
        let (mut values, mut work) = (input.to_vec(), convolution.work());
        convolution.gather(&mut values, &mut work, |_, _| {});
        convolution.apply(&mut values, &mut work, |_, result, values| values.copy_from_slice(result));
        values
    }

    /// The exact convolution.
    fn exact((rows, cols): (usize, usize), factor: impl Fn(usize, usize) -> f64, input: &[f32]) -> Vec<f32> {
        let fourier = Fourier::<f32>::new(rows, cols);
        let mut output = input.to_vec();
        fourier.filter(input, &fourier.wave_multiplier(factor), &mut output, &mut fourier.work());
        output
    }

    pub(crate) fn uneven(points: usize, seed: usize) -> Vec<f32> {
        (0..points).map(|n| ((n * n * 7919 + seed * n + 13) % 1009) as f32 / 1009.0 - 0.4).collect()
    }

    #[test]
    fn it_is_symmetric_and_positive_on_sides_of_any_length() {
        for (rows, cols) in [(64, 64), (67, 35), (16, 18), (40, 1), (1, 33), (2, 64), (3, 3), (256, 17)] {
            let convolution = TwoGrids::new(rows, cols, Near::Kernel, stiffness((rows, cols), 1.3));
            let (a, b) = (uneven(rows * cols, 3), uneven(rows * cols, 11));
            let (image_a, image_b) = (applied(&convolution, &a), applied(&convolution, &b));
            let (left, right) = (dot(&a, &image_b), dot(&b, &image_a));
            let size = (dot(&a, &image_a) * dot(&b, &image_b)).sqrt();
            assert!(size > 0.0 && (left - right).abs() < 1e-5 * size, "{rows} x {cols}: {left} and {right} of {size}");
        }
    }

    /// Conjugate gradients need a positive preconditioner. The lowest eigenvalue of A follows from the highest of s -
    /// A, s above the spectrum of A.
    #[test]
    fn the_stiffness_is_positive_whatever_four_leaves_over() {
        for (rows, cols) in [(64, 64), (65, 67), (66, 66), (67, 65), (67, 67), (98, 17), (19, 22)] {
            for aspect in [0.25, 1.0, 4.0] {
                let convolution = TwoGrids::new(rows, cols, Near::Kernel, stiffness((rows, cols), aspect));
                let highest_eigenvalue = |shift: f32, sign: f32| {
                    let mut vector = uneven(rows * cols, 3);
                    let mut eigenvalue = 0.0;
                    for _ in 0..300 {
                        let image = applied(&convolution, &vector);
                        let image: Vec<f32> = image.iter().zip(&vector).map(|(i, v)| shift * v + sign * i).collect();
                        let norm = dot(&image, &image).sqrt();
                        eigenvalue = norm / dot(&vector, &vector).sqrt();
                        vector = image.iter().map(|value| value / norm as f32).collect();
                    }
                    eigenvalue
                };
                let shift = 1.1 * highest_eigenvalue(0.0, 1.0);
                let lowest = shift - highest_eigenvalue(shift as f32, -1.0);
                assert!(lowest > 0.0, "{rows} x {cols}, pixels 1 x {aspect}: {lowest} of {shift}");
            }
        }
    }

    #[test]
    fn on_short_sides_it_is_the_convolution_itself() {
        for sides in [(15, 12), (8, 8), (2, 5), (1, 7), (9, 1), (2, 2), (1, 1)] {
            let input = uneven(sides.0 * sides.1, 5);
            let tolerance = 1e-5 * (sides.0 + sides.1) as f32;
            let close = |found: Vec<f32>, expected: Vec<f32>| {
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found - expected).abs() < tolerance, "{sides:?}: {found}, {expected}");
                }
            };
            let (stiff, soft) = (stiffness(sides, 0.7), compliance(sides, 0.7));
            close(
                applied(&TwoGrids::new(sides.0, sides.1, Near::Kernel, &stiff), &input),
                exact(sides, &stiff, &input),
            );
            close(
                applied(&TwoGrids::new(sides.0, sides.1, Near::ShortWaves, &soft), &input),
                exact(sides, &soft, &input),
            );
        }
    }

    /// With N alone, a wave as long as the side would meet a stiffness of tens instead of 1; with C alone, the shortest
    /// wave would meet none.
    #[test]
    fn waves_of_all_lengths_meet_about_their_factor() {
        let (rows, cols) = (128, 96);
        let (stiff, soft) = (stiffness((rows, cols), 1.0), compliance((rows, cols), 1.0));
        let stiffness = TwoGrids::new(rows, cols, Near::Kernel, &stiff);
        let compliance = TwoGrids::new(rows, cols, Near::ShortWaves, &soft);
        for (k, l) in [(1, 0), (0, 1), (2, 3), (8, 1), (12, 12), (20, 5), (40, 30), (64, 0), (0, 48), (64, 48)] {
            let phase = |n: usize| (k * (n / cols)) as f64 / rows as f64 + (l * (n % cols)) as f64 / cols as f64;
            let wave: Vec<f32> = (0..rows * cols).map(|n| (TAU * phase(n)).cos() as f32).collect();
            for (convolution, factor) in [(&stiffness, stiff(k, l)), (&compliance, soft(k, l))] {
                let share = dot(&wave, &applied(convolution, &wave)) / dot(&wave, &wave) / factor;
                assert!((0.8..1.25).contains(&share), "{k} and {l}: {share} of {factor}");
            }
        }
    }

    /// Search directions of a solve are rough; their energy must be accurate to better than a tenth.
    #[test]
    fn the_energy_of_rough_fields_is_about_theirs() {
        for (sides, aspect) in [((128, 96), 1.0), ((67, 70), 1.0), ((64, 130), 0.5), ((40, 1), 1.0), ((100, 12), 1.0)] {
            let soft = compliance(sides, aspect);
            let about = TwoGrids::new(sides.0, sides.1, Near::ShortWaves, &soft);
            let white = uneven(sides.0 * sides.1, 7);
            for power in [0, 1] {
                // White noise, or noise with amplitudes proportional to the wavelength.
                let mut field = if power == 0 { white.clone() } else { exact(sides, &soft, &white) };
                let expected = dot(&field, &exact(sides, &soft, &field));
                let found = about.energy(&mut field, &mut about.work(), |_, _| {});
                let by_rows = dot(&field, &applied(&about, &field));
                assert!((found / by_rows - 1.0).abs() < 1e-4, "{sides:?}, {power}: {found}, by rows {by_rows}");
                assert!((found / expected - 1.0).abs() < 0.09, "{sides:?}, {power}: {}", found / expected);
            }
        }
    }
}
