//! Filters of maps whose sides have no prime factor above 127.
//!
//! The result of a filter does not depend on the order in which the waves are stored, so that they stay where the
//! splits of [`Transform`] leave them, and all steps work in the output buffer, except for [`LANES`] sequences at a time:
//!
//! 1. Along x, two columns at a time as real and imaginary part of one complex sequence z = a + i b, [`LANES`] of them
//!    side by side in vector lanes.
//! 2. Along y, the waves k of all columns, [`LANES`] values of k side by side. The waves k and -k of a pair give those
//!    of its columns,
//!
//!    ```text
//!    2 a_k = z_k + z*_-k,   2 b_k = -i (z_k - z*_-k)
//!    ```
//!
//!    and a_-k = a*_k, so that only k up to half of the rows are transformed. Then the factors, the inverse transform,
//!    and z_k = a_k + i b_k, z_-k = a*_k + i b*_k.
//! 3. Along x in reverse.
//!
//! A single last column has no partner: its wave k is stored as real part in the row of k and imaginary part in that of
//! -k.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::fft::convolution::Filter;
use crate::fft::lanes::{ROW, Transform};
use crate::fft::number::Number;
use crate::fft::splits::{LANES, transpose};

/// Plan of a filter for maps of one size; see the module documentation.
#[derive(Clone, Debug)]
pub(crate) struct AnySize<T> {
    rows: usize,
    cols: usize,
    along_x: Transform<T>,
    along_y: Transform<T>,
    /// Rows of the waves k and -k, for k from 0 to rows/2.
    places: Vec<[usize; 2]>,
}

impl<T: Number> AnySize<T> {
    /// Plans filters of maps of `rows` x `cols` points; `None` if a side has a prime factor above 127.
    pub(crate) fn new(rows: usize, cols: usize) -> Option<Self> {
        let (along_x, along_y) = (Transform::new(rows)?, Transform::new(cols)?);
        let mut place_of = vec![0; rows];
        along_x.waves().into_iter().enumerate().for_each(|(place, wave)| place_of[wave] = place);
        let places = (0..=rows / 2).map(|k| [place_of[k], place_of[(rows - k) % rows]]).collect();
        Some(Self { rows, cols, along_x, along_y, places })
    }

    /// Length of the scratch buffer that a filter needs.
    pub(crate) fn scratch_len(&self) -> usize {
        ROW * self.rows.max(self.cols)
    }

    /// Arranges factors, see [`Convolution::factors`](crate::fft::Convolution::factors).
    pub(crate) fn factors(&self, factor: impl Fn(usize, usize) -> f64) -> Vec<T> {
        let waves: Vec<usize> = self.along_y.waves().into_iter().map(|l| l.min(self.cols - l)).collect();
        let tiles = self.places.len().div_ceil(LANES);
        let mut factors = vec![T::zero(); tiles * self.cols * LANES];
        let mut by_wave = vec![T::zero(); self.cols / 2 + 1];
        for k in 0..self.places.len() {
            // Step 2 works with 2 a and 2 b.
            by_wave.iter_mut().enumerate().for_each(|(l, value)| *value = T::round_from(0.5 * factor(k, l)));
            let lane = &mut factors[k / LANES * self.cols * LANES + k % LANES..];
            lane.iter_mut().step_by(LANES).zip(&waves).for_each(|(value, &l)| *value = by_wave[l]);
        }
        factors
    }

    /// Blocks of columns: those that are real parts, and as many or one less that are imaginary parts.
    fn blocks(&self) -> impl Iterator<Item = [Range<usize>; 2]> {
        let cols = self.cols;
        (0..cols).step_by(ROW).map(move |first| {
            let width = (cols - first).min(ROW);
            let middle = first + width.div_ceil(2);
            [first..middle, middle..first + width]
        })
    }
}

/// The column without a partner, as its place among the real parts.
fn single([re, im]: &[Range<usize>; 2]) -> Option<usize> {
    (re.len() > im.len()).then_some(im.len())
}

impl<T: Number> WithSimd for Filter<'_, T, AnySize<T>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plan, input, factors, output, scratch, should_continue } = self;
        let cols = plan.cols;
        let columns = &mut scratch[..plan.rows * ROW];
        for block in plan.blocks() {
            if !should_continue() {
                return;
            }
            copy_in(columns, input, cols, &block);
            plan.along_x.forward(simd, columns);
            copy_out(columns, output, cols, &block);
            if let Some(lane) = single(&block) {
                for &[place, mirror] in plan.places.iter().filter(|[place, mirror]| place != mirror) {
                    output[mirror * cols + block[0].start + lane] = columns[place * ROW + LANES + lane];
                }
            }
        }
        let tiles = plan.places.chunks(LANES).zip(factors.chunks_exact(cols * LANES));
        let waves = &mut scratch[..cols * ROW];
        for (places, factors) in tiles {
            if !should_continue() {
                return;
            }
            plan.gather(simd, output, places, waves);
            plan.along_y.forward(simd, waves);
            for (row, factor) in waves.as_chunks_mut::<ROW>().0.iter_mut().zip(factors.as_chunks::<LANES>().0) {
                let factor = T::vectors::<S>(factor);
                let (re, im) = row.split_at_mut(LANES);
                for part in [re, im] {
                    part_times::<T, S>(simd, T::vectors_mut::<S>(part), factor);
                }
            }
            plan.along_y.inverse(simd, waves);
            plan.scatter(simd, waves, places, output);
        }
        let columns = &mut scratch[..plan.rows * ROW];
        for block in plan.blocks() {
            if !should_continue() {
                return;
            }
            copy_in(columns, output, cols, &block);
            if let Some(lane) = single(&block) {
                for &[place, mirror] in &plan.places {
                    let column = block[0].start + lane;
                    let re = output[place * cols + column];
                    let im = if place == mirror { T::zero() } else { output[mirror * cols + column] };
                    (columns[place * ROW + lane], columns[mirror * ROW + lane]) = (re, re);
                    (columns[mirror * ROW + LANES + lane], columns[place * ROW + LANES + lane]) = (-im, im);
                }
            }
            plan.along_x.inverse(simd, columns);
            copy_out(columns, output, cols, &block);
        }
    }
}

/// Multiplies each number by its factor.
#[inline(always)]
fn part_times<T: Number, S: Simd>(simd: S, part: &mut [T::V<S>], factor: &[T::V<S>]) {
    part.iter_mut().zip(factor).for_each(|(value, &factor)| *value = T::product(simd, *value, factor));
}

/// Copies a block of columns of a map to rows of real and imaginary parts.
#[inline(always)]
fn copy_in<T: Number>(rows: &mut [T], map: &[T], cols: usize, [re, im]: &[Range<usize>; 2]) {
    for (row, map) in rows.as_chunks_mut::<ROW>().0.iter_mut().zip(map.chunks_exact(cols)) {
        if re.len() == LANES && im.len() == LANES {
            row.copy_from_slice(&map[re.start..im.end]);
        } else {
            // Lanes without a column would grow from call to call.
            row.fill(T::zero());
            row[..re.len()].copy_from_slice(&map[re.clone()]);
            row[LANES..][..im.len()].copy_from_slice(&map[im.clone()]);
        }
    }
}

/// Copies rows of real and imaginary parts to a block of columns of a map.
#[inline(always)]
fn copy_out<T: Number>(rows: &[T], map: &mut [T], cols: usize, [re, im]: &[Range<usize>; 2]) {
    for (row, map) in rows.as_chunks::<ROW>().0.iter().zip(map.chunks_exact_mut(cols)) {
        if re.len() == LANES && im.len() == LANES {
            map[re.start..im.end].copy_from_slice(row);
        } else {
            map[re.clone()].copy_from_slice(&row[..re.len()]);
            map[im.clone()].copy_from_slice(&row[LANES..][..im.len()]);
        }
    }
}

/// Numbers of [`LANES`] waves by [`LANES`] columns: real and imaginary parts of one column of each pair, and of the other.
type Tile<T> = [[T; LANES * LANES]; 4];

impl<T: Number> AnySize<T> {
    /// Collects the waves in `places` of all columns, one column in each row of `waves`.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, map: &[T], places: &[[usize; 2]], waves: &mut [T]) {
        let waves = waves.as_chunks_mut::<ROW>().0;
        let mut tile: Tile<T> = [[T::zero(); LANES * LANES]; 4];
        for block in self.blocks() {
            let [re, im] = &block;
            for (lane, &[place, mirror]) in places.iter().enumerate() {
                let row = |place: usize, of: &Range<usize>| padded(&map[place * self.cols..][of.clone()]);
                let z = [row(place, re), row(place, im), row(mirror, re), row(mirror, im)];
                let [z_re, z_im, w_re, w_im] = z.each_ref().map(|part| T::vectors::<S>(part));
                let [a_re, a_im, b_re, b_im] = &mut tile;
                let parts =
                    [a_re, a_im, b_re, b_im].map(|part| T::vectors_mut::<S>(&mut part[lane * LANES..][..LANES]));
                let [a_re, a_im, b_re, b_im] = parts;
                // 2 a = z + w*, 2 b = -i (z - w*)
                for v in 0..a_re.len() {
                    a_re[v] = T::sum(simd, z_re[v], w_re[v]);
                    a_im[v] = T::difference(simd, z_im[v], w_im[v]);
                    b_re[v] = T::sum(simd, z_im[v], w_im[v]);
                    b_im[v] = T::difference(simd, w_re[v], z_re[v]);
                }
                if let Some(column) = single(&block) {
                    let doubled = |value: T| value + value;
                    let im = if place == mirror { T::zero() } else { doubled(z[2][column]) };
                    let [a_re, a_im, ..] = &mut tile;
                    (a_re[lane * LANES + column], a_im[lane * LANES + column]) = (doubled(z[0][column]), im);
                }
            }
            tile.iter_mut().for_each(transpose);
            let [a_re, a_im, b_re, b_im] = &tile;
            for (of, parts) in [(re, [a_re, a_im]), (im, [b_re, b_im])] {
                let parts = parts.map(|part| part.as_chunks::<LANES>().0);
                for ((wave, re), im) in waves[of.clone()].iter_mut().zip(parts[0]).zip(parts[1]) {
                    wave[..LANES].copy_from_slice(re);
                    wave[LANES..].copy_from_slice(im);
                }
            }
        }
    }

    /// Puts the waves of all columns back to their rows.
    #[inline(always)]
    fn scatter<S: Simd>(&self, simd: S, waves: &[T], places: &[[usize; 2]], map: &mut [T]) {
        let waves = waves.as_chunks::<ROW>().0;
        let mut tile: Tile<T> = [[T::zero(); LANES * LANES]; 4];
        for block in self.blocks() {
            let [re, im] = &block;
            let [a_re, a_im, b_re, b_im] = &mut tile;
            for (of, parts) in [(re, [a_re, a_im]), (im, [b_re, b_im])] {
                let [re, im] = parts.map(|part| part.as_chunks_mut::<LANES>().0);
                for ((wave, re), im) in waves[of.clone()].iter().zip(re).zip(im) {
                    re.copy_from_slice(&wave[..LANES]);
                    im.copy_from_slice(&wave[LANES..]);
                }
            }
            tile.iter_mut().for_each(transpose);
            for (lane, &[place, mirror]) in places.iter().enumerate() {
                let numbers = tile.each_ref().map(|part| part.as_chunks::<LANES>().0[lane]);
                let [a_re, a_im, b_re, b_im] = numbers.each_ref().map(|part| T::vectors::<S>(part));
                let mut z = [[T::zero(); LANES]; 4];
                let [z_re, z_im, w_re, w_im] = z.each_mut().map(|part| T::vectors_mut::<S>(part));
                // z = a + i b, w = a* + i b*
                for v in 0..a_re.len() {
                    z_re[v] = T::difference(simd, a_re[v], b_im[v]);
                    z_im[v] = T::sum(simd, a_im[v], b_re[v]);
                    w_re[v] = T::sum(simd, a_re[v], b_im[v]);
                    w_im[v] = T::difference(simd, b_re[v], a_im[v]);
                }
                if let Some(column) = single(&block) {
                    (z[0][column], z[2][column]) = (numbers[0][column], numbers[1][column]);
                }
                let mut put = |place: usize, [z_re, z_im]: [&[T; LANES]; 2]| {
                    let row = &mut map[place * self.cols..][..self.cols];
                    copy_first(z_re, &mut row[re.clone()]);
                    copy_first(z_im, &mut row[im.clone()]);
                };
                put(place, [&z[0], &z[1]]);
                if place != mirror {
                    put(mirror, [&z[2], &z[3]]);
                }
            }
        }
    }
}

/// Copies as many of `values` as `to` takes; all of them without a call.
#[inline(always)]
fn copy_first<T: Number>(values: &[T; LANES], to: &mut [T]) {
    match <&mut [T; LANES]>::try_from(&mut *to) {
        Ok(all) => *all = *values,
        Err(_) => to.copy_from_slice(&values[..to.len()]),
    }
}

/// `values` with zeros up to [`LANES`].
#[inline(always)]
fn padded<T: Number>(values: &[T]) -> [T; LANES] {
    if let Ok(all) = values.try_into() {
        return all;
    }
    let mut all = [T::zero(); LANES];
    all[..values.len()].copy_from_slice(values);
    all
}
