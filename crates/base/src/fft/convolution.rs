//! Filters of real periodic maps whose sides are powers of two: transform, multiplication of every wave by a real even
//! factor, inverse transform.
//!
//! The result of a filter does not depend on the order in which the waves are stored, so no bit reversal is needed. A
//! sequence x is taken as the polynomial sum x_j y^j, and its transform as the remainders modulo the factors of y^n -
//! 1, which splits by
//!
//! ```text
//! y^(2m) - c^2 = (y^m - c)(y^m + c)
//! ```
//!
//! down to y - c, whose remainder is the amplitude of the wave c; the inverse goes back up. For real sequences,
//! however, y^(2m) - 1 splits into y^m - 1, which is real again, and y^m + 1 = (y^(m/2) - i)(y^(m/2) + i). The two
//! remainders of the latter are conjugates, so that one complex remainder of m/2 numbers suffices: real data cost half
//! of complex data, and no wave is computed twice.
//!
//! 1. Columns, several side by side in vector lanes: real numbers to the waves along x, in place.
//! 2. Each wave along x, a row of complex numbers: split down to rows of [`LANES`] numbers. The last splits take place
//!    across rows, after tiles of [`LANES`] by [`LANES`] numbers have been transposed. Then the factors, and the same
//!    splits in reverse.
//! 3. Columns in reverse.
//!
//! All steps work in the output buffer, except for one block of columns. Sums and products are scalar operations in
//! fixed order, without fused multiply-add, for every vector width: every machine returns the same bytes.

use pulp::{Simd, WithSimd};

use crate::fft::number::{Number, vectorized};
use crate::fft::splits::{LANES, ROOTS, TILE, filter_tile, radix_2, radix_4, transpose};

/// Real and imaginary parts of complex numbers.
type Parts<'a, V> = (&'a mut [V], &'a mut [V]);

/// Total size, in bytes, of the columns that are transformed together, which determines the number of these columns.
const BLOCK_BYTES: usize = 1 << 20;
/// Minimum number of columns that are transformed together.
const MIN_BLOCK_COLUMNS: usize = 32;
/// Maximum number of columns that are transformed together.
const MAX_BLOCK_COLUMNS: usize = 128;
/// Approximate count of numbers that are processed between two checks for cancellation, in whole rows.
const NUMBERS_PER_CHECK: usize = 1 << 15;
/// Minimum number of rows of a map.
const MIN_ROWS: usize = 8;

/// Plan of a filter for maps of one size; see the module documentation.
#[derive(Clone, Debug)]
pub struct Convolution<T> {
    rows: usize,
    cols: usize,
    /// Real and imaginary parts of c, c^2 and c^3 for each block; a block is a remainder modulo y^(4m) - c^4.
    roots: Vec<[[T; 2]; 3]>,
    /// `roots` in the order in which tiles use them: per tile, those of the blocks of 16 numbers, one per lane, then
    /// those of the four blocks of 4 in each.
    tile_roots: Vec<T>,
    /// Wave number along y, from 0 to cols/2, of each number of a row.
    waves_along_y: Vec<u32>,
}

/// Factors by which a filter multiplies the waves.
#[derive(Clone, Copy)]
pub enum Factors<'a, T> {
    /// All factors, as [`Convolution::factors`] returns them.
    Stored(&'a [T]),
    /// Function `factor(k, l)` as in [`Convolution::factors`], called while the filter runs: slower, but takes no
    /// memory.
    Computed(&'a dyn Fn(usize, usize) -> f64),
}

/// Wave number of block `block` in the splits of y^n - 1, as a fraction of n: the bits of `block` mirrored at the
/// binary point.
fn wave_fraction(block: usize) -> f64 {
    (block as u64).reverse_bits() as f64 / 2f64.powi(64)
}

/// Real and imaginary parts of c, c^2 and c^3 for block `block`, a remainder modulo y^(4m) - c^4.
fn roots<T: Number>(block: usize) -> [[T; 2]; 3] {
    // c = exp(2 pi i fraction / 4)
    [1.0, 2.0, 3.0].map(|power| {
        let (sin, cos) = libm::sincos(power * wave_fraction(block) * std::f64::consts::FRAC_PI_2);
        [cos, sin].map(T::round_from)
    })
}

impl<T: Number> Convolution<T> {
    /// Plans filters of maps of `rows` x `cols` points; `None` unless both are powers of two, with at least 8 rows and
    /// 256 columns.
    pub fn new(rows: usize, cols: usize) -> Option<Self> {
        if !rows.is_power_of_two() || !cols.is_power_of_two() || rows < MIN_ROWS || cols < TILE {
            return None;
        }
        let tiles = (0..cols / TILE).flat_map(|tile| {
            let blocks = move |level: usize, part: usize| {
                let lanes: Vec<_> = (0..LANES).map(|lane| roots((tile * LANES + lane) * level + part)).collect();
                (0..6).flat_map(move |n| lanes.clone().into_iter().map(move |root: [[T; 2]; 3]| root[n / 2][n % 2]))
            };
            blocks(1, 0).chain((0..4).flat_map(move |part| blocks(4, part)))
        });
        let count = (cols / LANES).max(rows);
        let waves_along_y = (0..cols).map(|n| {
            let (tile, place) = (n / TILE, n % TILE);
            let l = (wave_fraction((tile * LANES + place % LANES) * LANES + place / LANES) * cols as f64) as usize;
            l.min(cols - l) as u32
        });
        Some(Self {
            rows,
            cols,
            roots: (0..count).map(roots).collect(),
            tile_roots: tiles.collect(),
            waves_along_y: waves_along_y.collect(),
        })
    }

    /// Number of columns that are transformed together.
    fn width(&self) -> usize {
        (BLOCK_BYTES / (self.rows * size_of::<T>())).clamp(MIN_BLOCK_COLUMNS, MAX_BLOCK_COLUMNS)
    }

    /// Length of the scratch buffer that a filter needs, in numbers.
    pub fn scratch_len(&self) -> usize {
        (self.rows * self.width()).max(3 * self.cols)
    }

    /// Arranges the factors in the order that [`Factors::Stored`] expects.
    ///
    /// `factor(k, l)` is the factor of the wave with k periods along x and l along y, with k up to rows/2 and l up to
    /// cols/2. It must include the normalization 1/(rows cols).
    pub fn factors(&self, factor: impl Fn(usize, usize) -> f64) -> Vec<T> {
        let mut factors = vec![T::zero(); (self.rows / 2 + 1) * self.cols];
        let mut waves = vec![T::zero(); self.cols];
        for (row, k) in factors.chunks_exact_mut(self.cols).zip(self.waves()) {
            self.row_factors(k, &factor, &mut waves, row);
        }
        factors
    }

    /// Writes the factors of the waves with `k` periods along x to `row`; `waves` is scratch space of the same length.
    fn row_factors(&self, k: usize, factor: impl Fn(usize, usize) -> f64, waves: &mut [T], row: &mut [T]) {
        // A complex remainder stands for two waves, so the inverse transform halves it.
        let multiplicity = if k == 0 || 2 * k == self.rows { 1.0 } else { 2.0 };
        let waves = &mut waves[..self.cols / 2 + 1];
        waves.iter_mut().enumerate().for_each(|(l, value)| *value = T::round_from(multiplicity * factor(k, l)));
        row.iter_mut().zip(&self.waves_along_y).for_each(|(value, &l)| *value = waves[l as usize]);
    }

    /// Factors of row number `row`, which holds the waves with `k` periods along x: stored, or computed in `computed`.
    fn factors_at<'f>(
        &self,
        (row, k): (usize, usize),
        factors: Factors<'f, T>,
        waves: &mut [T],
        computed: &'f mut [T],
    ) -> &'f [T] {
        match factors {
            Factors::Stored(all) => &all[row * self.cols..][..self.cols],
            Factors::Computed(factor) => {
                self.row_factors(k, factor, waves, computed);
                computed
            }
        }
    }

    /// Numbers of periods along x in the order in which the rows store the waves: two real rows, then complex rows.
    fn waves(&self) -> impl Iterator<Item = usize> {
        let rows = self.rows;
        let complex = self.complex_row_counts().flat_map(move |half| {
            (0..half / 2).map(move |part| {
                // (1/4)/m + share, m = half/2
                let k = rows / (2 * half) + (wave_fraction(part) * rows as f64) as usize;
                k.min(rows - k)
            })
        });
        [0, rows / 2].into_iter().chain(complex)
    }

    /// Number of rows of each complex remainder, real parts before imaginary parts; it is also the index of the
    /// remainder's first row.
    fn complex_row_counts(&self) -> impl Iterator<Item = usize> {
        (1..self.rows.ilog2()).map(|power| 1 << power)
    }
}

/// Application of a filter to a map. Maps are stored row by row.
pub struct Filter<'a, T> {
    /// Plan for maps of this size.
    pub plan: &'a Convolution<T>,
    /// The map.
    pub input: &'a [T],
    /// Factors by which the waves are multiplied.
    pub factors: Factors<'a, T>,
    /// The resulting map; incomplete if the filter was stopped.
    pub output: &'a mut [T],
    /// Buffer of at least [`Convolution::scratch_len`] numbers.
    pub scratch: &'a mut [T],
    /// Called between parts of some ten thousand numbers; the filter stops if it returns false.
    pub should_continue: &'a dyn Fn() -> bool,
}

impl<T: Number> Filter<'_, T> {
    pub(crate) fn run(self) {
        let points = self.plan.rows * self.plan.cols;
        assert!(self.input.len() == points && self.output.len() == points, "a map of another size");
        vectorized(self);
    }
}

impl<T: Number> WithSimd for Filter<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plan, input, factors, output, scratch, should_continue } = self;
        let (cols, half, width) = (plan.cols, plan.rows / 2, plan.width());
        let columns = &mut scratch[..plan.rows * width];
        for first in (0..cols).step_by(width) {
            if !should_continue() {
                return;
            }
            let (sums, differences) = columns.split_at_mut(half * width);
            let both = sums.chunks_exact_mut(width).zip(differences.chunks_exact_mut(width));
            for (row, (sum, difference)) in both.enumerate() {
                let (upper, lower) = (&input[row * cols + first..], &input[(row + half) * cols + first..]);
                let (upper, lower) = (T::vectors::<S>(&upper[..width]), T::vectors::<S>(&lower[..width]));
                let both = T::vectors_mut::<S>(sum).iter_mut().zip(T::vectors_mut::<S>(difference));
                for ((sum, difference), (&a, &b)) in both.zip(upper.iter().zip(lower)) {
                    (*sum, *difference) = (T::sum(simd, a, b), T::difference(simd, a, b));
                }
            }
            plan.columns(simd, columns, false);
            for (row, column) in columns.chunks_exact(width).enumerate() {
                output[row * cols + first..][..width].copy_from_slice(column);
            }
        }
        let (reals, complex) = output.split_at_mut(2 * cols);
        let (imaginary, computed) = scratch.split_at_mut(cols);
        let (waves, computed) = computed.split_at_mut(cols);
        let computed = &mut computed[..cols];
        let mut rows_of_waves = plan.waves().enumerate();
        for (real, (row, k)) in reals.chunks_exact_mut(cols).zip(&mut rows_of_waves) {
            imaginary.fill(T::zero());
            plan.row(simd, real, imaginary, plan.factors_at((row, k), factors, waves, computed));
        }
        let mut rest = complex;
        let rows_together = (NUMBERS_PER_CHECK / cols).max(1);
        for half in plan.complex_row_counts() {
            let (block, below) = rest.split_at_mut(half * cols);
            let (re, im) = block.split_at_mut(half / 2 * cols);
            let rows = re.chunks_exact_mut(cols).zip(im.chunks_exact_mut(cols)).zip(&mut rows_of_waves);
            for ((re, im), (row, k)) in rows {
                if row % rows_together == 0 && !should_continue() {
                    return;
                }
                plan.row(simd, re, im, plan.factors_at((row, k), factors, waves, computed));
            }
            rest = below;
        }
        let columns = &mut scratch[..plan.rows * width];
        for first in (0..cols).step_by(width) {
            if !should_continue() {
                return;
            }
            for (row, column) in columns.chunks_exact_mut(width).enumerate() {
                column.copy_from_slice(&output[row * cols + first..][..width]);
            }
            plan.columns(simd, columns, true);
            let (upper, lower) = output.split_at_mut(half * cols);
            let (sums, differences) = columns.split_at(half * width);
            let both = sums.chunks_exact(width).zip(differences.chunks_exact(width));
            for (row, (sum, difference)) in both.enumerate() {
                let place = row * cols + first;
                let upper = T::vectors_mut::<S>(&mut upper[place..][..width]);
                let lower = T::vectors_mut::<S>(&mut lower[place..][..width]);
                let both = T::vectors::<S>(sum).iter().zip(T::vectors::<S>(difference));
                for ((upper, lower), (&a, &b)) in upper.iter_mut().zip(lower).zip(both) {
                    (*upper, *lower) = (T::sum(simd, a, b), T::difference(simd, a, b));
                }
            }
        }
    }
}

impl<T: Number> Convolution<T> {
    /// Transforms `columns`, stored as rows of equal length, after the first split of the real numbers; if `back`, the
    /// inverse, which leaves the last join of the real numbers open.
    #[inline(always)]
    fn columns<S: Simd>(&self, simd: S, columns: &mut [T], back: bool) {
        let vectors = T::vectors_mut::<S>(columns);
        let row = vectors.len() / self.rows;
        let levels = self.rows.ilog2() - 1;
        if !back {
            for level in (0..levels).rev() {
                Self::split_reals(simd, &mut vectors[..(2 << level) * row]);
            }
        }
        for half in self.complex_row_counts() {
            let (re, im) = vectors[half * row..2 * half * row].split_at_mut(half / 2 * row);
            self.split_rows(simd, (re, im), (half / 2, 2), back);
        }
        if back {
            for level in 0..levels {
                Self::split_reals(simd, &mut vectors[..(2 << level) * row]);
            }
        }
    }

    /// Replaces two halves of real numbers by their sums and differences, in place.
    #[inline(always)]
    fn split_reals<S: Simd>(simd: S, vectors: &mut [T::V<S>]) {
        let (sums, differences) = vectors.split_at_mut(vectors.len() / 2);
        for (a, b) in sums.iter_mut().zip(differences) {
            (*a, *b) = (T::sum(simd, *a, *b), T::difference(simd, *a, *b));
        }
    }

    /// Filters one row of complex numbers: transform, multiplication by `factor`, inverse transform.
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, re: &mut [T], im: &mut [T], factor: &[T]) {
        let length = self.cols / LANES;
        self.split_rows(simd, (T::vectors_mut::<S>(re), T::vectors_mut::<S>(im)), (length, 0), false);
        let tiles = re.as_chunks_mut::<TILE>().0.iter_mut().zip(im.as_chunks_mut::<TILE>().0);
        let kept = factor.as_chunks::<TILE>().0.iter().zip(self.tile_roots.as_chunks::<{ 5 * ROOTS }>().0);
        for ((re, im), (factor, roots)) in tiles.zip(kept) {
            transpose(re);
            transpose(im);
            filter_tile(simd, re, im, factor, roots);
            transpose(re);
            transpose(im);
        }
        self.split_rows(simd, (T::vectors_mut::<S>(re), T::vectors_mut::<S>(im)), (length, 0), true);
    }

    /// Splits a block of `length` rows of complex numbers, with the index `first` among the blocks of this size, down
    /// to single rows, or joins single rows if `back`.
    #[inline(always)]
    fn split_rows<S: Simd>(&self, simd: S, (re, im): Parts<'_, T::V<S>>, (length, first): (usize, usize), back: bool) {
        let levels = length.ilog2().div_ceil(2);
        for step in 0..levels {
            let blocks = 1 << (2 * if back { levels - 1 - step } else { step });
            let size = re.len() / blocks;
            for (block, &root) in self.roots[first * blocks..][..blocks].iter().enumerate() {
                let (re, im) = (&mut re[block * size..][..size], &mut im[block * size..][..size]);
                if length / blocks == 2 {
                    radix_2(simd, re, im, root[1], back);
                } else {
                    radix_4(simd, re, im, root, back);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without any symmetry.
    fn uneven(count: usize) -> Vec<f64> {
        (0..count).map(|n| ((n * n % 7919 * 7919 + 13 * n) % 1009) as f64 / 1009.0 - 0.4).collect()
    }

    fn factor(k: usize, l: usize) -> f64 {
        1.0 / (1.0 + k as f64 + 0.3 * l as f64)
    }

    /// Output of a filter with these `factors`, applied by `run`.
    fn output_of<'a, T: Number>(
        plan: &'a Convolution<T>,
        input: &'a [T],
        factors: Factors<'a, T>,
        run: &dyn Fn(Filter<'_, T>),
    ) -> Vec<T> {
        let (mut output, mut scratch) = (vec![T::zero(); input.len()], vec![T::zero(); plan.scratch_len()]);
        let (into, scratch) = (&mut output, &mut scratch);
        run(Filter { plan, input, factors, output: into, scratch, should_continue: &|| true });
        output
    }

    fn filtered<T: Number>(rows: usize, cols: usize, input: &[T]) -> Vec<T> {
        let plan = Convolution::<T>::new(rows, cols).unwrap();
        let factors = plan.factors(|k, l| factor(k, l) / (rows * cols) as f64);
        output_of(&plan, input, Factors::Stored(&factors), &|filter| filter.run())
    }

    #[test]
    fn every_wave_is_multiplied_by_its_factor() {
        for (rows, cols) in [(8, 256), (16, 512), (64, 256), (32, 2048)] {
            let turn = |k: usize, n: usize, of: usize| (k * n % of) as f64 / of as f64;
            let pairs = [(0, 0), (0, 1), (1, 0), (rows / 2, 0), (0, cols / 2), (rows / 2, cols / 2), (3, 77), (2, 128)];
            for (k, l) in pairs {
                // A wave and its mirror image have the same factor.
                for l in [l, (cols - l) % cols] {
                    let at =
                        |n: usize| std::f64::consts::TAU * (turn(k, n / cols, rows) + turn(l, n % cols, cols)) + 0.7;
                    let input: Vec<f64> = (0..rows * cols).map(|n| at(n).cos()).collect();
                    let expected = factor(k, l.min(cols - l));
                    for (a, b) in filtered(rows, cols, &input).iter().zip(&input) {
                        assert!((a - expected * b).abs() < 1e-13, "{rows} x {cols}, wave {k}, {l}: {a}");
                    }
                }
            }
        }
    }

    #[test]
    fn single_precision_rounds_as_little_as_its_digits() {
        for (rows, cols) in [(8, 256), (128, 512), (512, 1024)] {
            let input = uneven(rows * cols);
            let rounded: Vec<f32> = input.iter().map(|&value| value as f32).collect();
            let exact: Vec<f64> = rounded.iter().map(|&value| f64::from(value)).collect();
            let (single, double) = (filtered(rows, cols, &rounded), filtered(rows, cols, &exact));
            let square: f64 = double.iter().map(|a| a * a).sum();
            let error: f64 = single.iter().zip(&double).map(|(&a, b)| (f64::from(a) - b).powi(2)).sum();
            assert!((error / square).sqrt() < 3e-7, "{rows} x {cols}: {}", (error / square).sqrt());
        }
    }

    #[test]
    fn vectors_of_any_width_give_the_same_bytes() {
        fn same<T: Number>(input: &[T], bits: impl Fn(T) -> u64) {
            let plan = Convolution::<T>::new(16, 512).unwrap();
            let factors = plan.factors(factor);
            let with = |run: &dyn Fn(Filter<'_, T>)| {
                let output = output_of(&plan, input, Factors::Stored(&factors), run);
                output.into_iter().map(&bits).collect::<Vec<u64>>()
            };
            let scalar = with(&|filter| Simd::vectorize(pulp::Scalar::new(), filter));
            #[cfg(target_arch = "x86_64")]
            {
                if let Some(simd) = pulp::x86::V3::try_new() {
                    assert_eq!(with(&|filter| Simd::vectorize(simd, filter)), scalar);
                }
                if let Some(simd) = pulp::x86::V4::try_new() {
                    assert_eq!(with(&|filter| Simd::vectorize(simd, filter)), scalar);
                }
            }
            assert_eq!(with(&|filter| filter.run()), scalar);
        }
        let input = uneven(16 * 512);
        same(&input, f64::to_bits);
        same(&input.iter().map(|&value| value as f32).collect::<Vec<_>>(), |value| u64::from(value.to_bits()));
    }

    #[test]
    fn computed_factors_give_the_bytes_of_stored_ones() {
        fn both<T: Number>(input: &[T]) {
            let plan = Convolution::<T>::new(16, 512).unwrap();
            let filtered = |factors| output_of(&plan, input, factors, &|filter| filter.run());
            assert_eq!(filtered(Factors::Computed(&factor)), filtered(Factors::Stored(&plan.factors(factor))));
        }
        let input = uneven(16 * 512);
        both(&input);
        both(&input.iter().map(|&value| value as f32).collect::<Vec<_>>());
    }

    #[test]
    fn other_sizes_are_left_to_others() {
        for (rows, cols) in [(4, 256), (8, 128), (12, 256), (8, 768)] {
            assert!(Convolution::<f32>::new(rows, cols).is_none());
        }
    }
}
