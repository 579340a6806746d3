//! Transforms of complex sequences that lie side by side in vector lanes; see `any_size`.
//!
//! A sequence of length N = r m is split into r sequences of length m by
//!
//! ```text
//! X(s + r t) = sum_j w_m^(j t) [w_N^(j s) sum_q x(j + q m) w_r^(q s)],    w_n = exp(-2 pi i / n)
//! ```
//!
//! in place: the sequence of s takes the place of part s. Waves therefore end in the order of [`Transform::waves`]. The
//! inverse goes the same way back, without 1/N.

use pulp::Simd;

use crate::fft::number::Number;
use crate::fft::splits::{LANES, Wide};

/// Numbers of a row: real parts of all sequences, then imaginary parts.
pub(crate) const ROW: usize = 2 * LANES;
/// Largest prime factor of a length. The cost of a number grows in proportion to it; from about 150 on the transforms of
/// rustfft are faster.
const MAX_RADIX: usize = 127;

/// [a - i b, a + i b], or the other way round if `back`
#[inline(always)]
fn turned_pair<T: Number, S: Simd>(s: S, a: Wide<T, S>, b: Wide<T, S>, back: bool) -> [Wide<T, S>; 2] {
    let (minus, plus) = (a.minus_i_times(s, b), a.plus_i_times(s, b));
    if back { [plus, minus] } else { [minus, plus] }
}

/// One split of all blocks of a length.
#[derive(Clone, Debug)]
struct Level<T> {
    radix: usize,
    /// Rows of a block before the split.
    length: usize,
    /// w_N^(j s) for s from 1 to r - 1, one j after the other.
    twiddles: Vec<[T; 2]>,
    /// cos and sin of 2 pi q/r.
    turns: Vec<[T; 2]>,
}

/// Transform of one length.
#[derive(Clone, Debug)]
pub(crate) struct Transform<T> {
    length: usize,
    levels: Vec<Level<T>>,
}

/// cos and sin of 2 pi `share`/`of`.
fn turn<T: Number>(share: usize, of: usize) -> [T; 2] {
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * (share % of) as f64 / of as f64);
    [cos, sin].map(T::round_from)
}

impl<T: Number> Transform<T> {
    /// Plans transforms of `length` numbers; `None` if a prime factor is greater than [`MAX_RADIX`].
    pub(crate) fn new(length: usize) -> Option<Self> {
        let mut levels = Vec::new();
        let mut rest = length;
        while rest > 1 {
            let radix = if rest.is_multiple_of(4) { 4 } else { (2..=MAX_RADIX).find(|p| rest.is_multiple_of(*p))? };
            let places = (0..rest / radix).flat_map(|j| (1..radix).map(move |s| j * s));
            let twiddles = places.map(|share| turn(share, rest)).map(|[cos, sin]: [T; 2]| [cos, -sin]).collect();
            let turns = (0..radix).map(|q| turn(q, radix)).collect();
            levels.push(Level { radix, length: rest, twiddles, turns });
            rest /= radix;
        }
        Some(Self { length, levels })
    }

    /// Wave at each place of the transformed sequence.
    pub(crate) fn waves(&self) -> Vec<usize> {
        // s_1 + r_1 (s_2 + r_2 (...)) for the place s_1 m_1 + s_2 m_2 + ...
        let wave = |place: usize| {
            let (mut rest, mut wave, mut step) = (place, 0, 1);
            for level in &self.levels {
                let part = level.length / level.radix;
                wave += step * (rest / part);
                (rest, step) = (rest % part, step * level.radix);
            }
            wave
        };
        (0..self.length).map(wave).collect()
    }

    /// Transforms `rows`, one number of every sequence in each.
    #[inline(always)]
    pub(crate) fn forward<S: Simd>(&self, simd: S, rows: &mut [T]) {
        let rows = T::vectors_mut::<S>(rows);
        for level in &self.levels {
            level.apply(simd, rows, false);
        }
    }

    /// Inverse of [`Self::forward`], times the length.
    #[inline(always)]
    pub(crate) fn inverse<S: Simd>(&self, simd: S, rows: &mut [T]) {
        let rows = T::vectors_mut::<S>(rows);
        for level in self.levels.iter().rev() {
            level.apply(simd, rows, true);
        }
    }
}

impl<T: Number> Level<T> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rows: &mut [T::V<S>], back: bool) {
        let row = ROW * size_of::<T>() / size_of::<T::V<S>>();
        for block in rows.chunks_exact_mut(self.length * row) {
            // The radix as a literal lets the compiler unroll the loops.
            match (self.radix, back) {
                (4, false) => self.fours(simd, block, row, false),
                (4, true) => self.fours(simd, block, row, true),
                (2, _) => self.twos(simd, block, row, back),
                (3, false) => self.odd::<S, 1>(simd, block, row, 3, false),
                (3, true) => self.odd::<S, 1>(simd, block, row, 3, true),
                (5, false) => self.odd::<S, 2>(simd, block, row, 5, false),
                (5, true) => self.odd::<S, 2>(simd, block, row, 5, true),
                (..=13, _) => self.odd::<S, 6>(simd, block, row, self.radix, back),
                (..=31, _) => self.odd::<S, 15>(simd, block, row, self.radix, back),
                _ => self.odd::<S, { MAX_RADIX / 2 }>(simd, block, row, self.radix, back),
            }
        }
    }

    #[inline(always)]
    fn twos<S: Simd>(&self, s: S, block: &mut [T::V<S>], row: usize, back: bool) {
        let (a, b) = block.split_at_mut(block.len() / 2);
        for (j, twiddle) in self.twiddles.iter().enumerate() {
            let c = Wide::<T, S>::splat(s, *twiddle);
            for v in 0..row / 2 {
                let at = [j * row + v, j * row + row / 2 + v];
                let (x, mut y) = (Wide::<T, S>::load(a, at), Wide::<T, S>::load(b, at));
                if back {
                    y = y.times_conjugate(s, c);
                }
                let (sum, mut difference) = (x.plus(s, y), x.minus(s, y));
                if !back {
                    difference = difference.times(s, c);
                }
                sum.store(a, at);
                difference.store(b, at);
            }
        }
    }

    #[inline(always)]
    fn fours<S: Simd>(&self, s: S, block: &mut [T::V<S>], row: usize, back: bool) {
        let (low, high) = block.split_at_mut(block.len() / 2);
        let ((a, b), (c, d)) = (low.split_at_mut(low.len() / 2), high.split_at_mut(high.len() / 2));
        for (j, [first, second, third]) in self.twiddles.as_chunks::<3>().0.iter().enumerate() {
            let w1 = Wide::<T, S>::splat(s, *first);
            let w2 = Wide::<T, S>::splat(s, *second);
            let w3 = Wide::<T, S>::splat(s, *third);
            for v in 0..row / 2 {
                let at = [j * row + v, j * row + row / 2 + v];
                let x0 = Wide::<T, S>::load(a, at);
                let (mut x1, mut x2) = (Wide::<T, S>::load(b, at), Wide::<T, S>::load(c, at));
                let mut x3 = Wide::<T, S>::load(d, at);
                if back {
                    (x1, x2, x3) = (x1.times_conjugate(s, w1), x2.times_conjugate(s, w2), x3.times_conjugate(s, w3));
                }
                let (even_sum, even_difference) = (x0.plus(s, x2), x0.minus(s, x2));
                let (odd_sum, odd_difference) = (x1.plus(s, x3), x1.minus(s, x3));
                let [mut y1, mut y3] = turned_pair(s, even_difference, odd_difference, back);
                let (y0, mut y2) = (even_sum.plus(s, odd_sum), even_sum.minus(s, odd_sum));
                if !back {
                    (y1, y2, y3) = (y1.times(s, w1), y2.times(s, w2), y3.times(s, w3));
                }
                y0.store(a, at);
                y1.store(b, at);
                y2.store(c, at);
                y3.store(d, at);
            }
        }
    }

    /// Splits by an odd radix of up to 2 `HALF` + 1, with sums and differences of the numbers q and r - q:
    /// X(s), X(r - s) = x(0) + sum_q cos(2 pi q s/r) [x(q) + x(r - q)] -+ i sum_q sin(2 pi q s/r) [x(q) - x(r - q)].
    #[inline(always)]
    fn odd<S: Simd, const HALF: usize>(&self, s: S, block: &mut [T::V<S>], row: usize, radix: usize, back: bool) {
        let part = block.len() / radix;
        let half = (radix / 2).min(HALF);
        let zero = Wide::<T, S>::splat(s, [T::zero(); 2]);
        for (j, twiddles) in self.twiddles.chunks_exact(radix - 1).enumerate() {
            for v in 0..row / 2 {
                let start = j * row + v;
                let first = Wide::<T, S>::load(block, [start, start + row / 2]);
                let (mut sums, mut differences, mut all) = ([zero; HALF], [zero; HALF], first);
                for q in 1..=half {
                    let (near, far) = (start + q * part, start + (radix - q) * part);
                    let mut x = Wide::<T, S>::load(block, [near, near + row / 2]);
                    let mut y = Wide::<T, S>::load(block, [far, far + row / 2]);
                    if back {
                        x = x.times_conjugate(s, Wide::splat(s, twiddles[q - 1]));
                        y = y.times_conjugate(s, Wide::splat(s, twiddles[radix - q - 1]));
                    }
                    (sums[q - 1], differences[q - 1]) = (x.plus(s, y), x.minus(s, y));
                    all = all.plus(s, sums[q - 1]);
                }
                all.store(block, [start, start + row / 2]);
                for wave in 1..=half {
                    let (mut even, mut odd, mut place) = (first, zero, 0);
                    for q in 0..half {
                        place += wave;
                        place -= if place >= radix { radix } else { 0 };
                        let [cos, sin] = self.turns[place];
                        even = even.plus_scaled(s, T::splat(s, cos), sums[q]);
                        odd = odd.plus_scaled(s, T::splat(s, sin), differences[q]);
                    }
                    let [mut x, mut y] = turned_pair(s, even, odd, back);
                    if !back {
                        x = x.times(s, Wide::splat(s, twiddles[wave - 1]));
                        y = y.times(s, Wide::splat(s, twiddles[radix - wave - 1]));
                    }
                    let (near, far) = (start + wave * part, start + (radix - wave) * part);
                    x.store(block, [near, near + row / 2]);
                    y.store(block, [far, far + row / 2]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Transforms of all lengths against the sum over all numbers, and back.
    #[test]
    fn a_transform_is_the_sum_over_the_sequence() {
        for length in [1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 25, 30, 35, 37, 57, 64, 121, 127, 128, 210] {
            let transform = Transform::<f64>::new(length).unwrap();
            let value = |place: usize, number: usize| ((place * 37 + number * 91) % 101) as f64 / 101.0 - 0.4;
            let mut rows: Vec<f64> = (0..length * ROW).map(|n| value(n / ROW, n % ROW)).collect();
            let before = rows.clone();
            transform.forward(pulp::Scalar::new(), &mut rows);
            for (place, wave) in transform.waves().into_iter().enumerate() {
                for lane in [0, 7, LANES - 1] {
                    let (mut re, mut im) = (0.0, 0.0);
                    for n in 0..length {
                        let [cos, sin] = turn::<f64>(n * wave, length);
                        let (a, b) = (value(n, lane), value(n, LANES + lane));
                        (re, im) = (re + a * cos + b * sin, im + b * cos - a * sin);
                    }
                    let row = &rows[place * ROW..];
                    let (off_re, off_im) = (row[lane] - re, row[LANES + lane] - im);
                    assert!(off_re.abs().max(off_im.abs()) < 1e-12, "{length}, wave {wave}: {off_re}, {off_im}");
                }
            }
            transform.inverse(pulp::Scalar::new(), &mut rows);
            for (a, b) in rows.iter().zip(&before) {
                assert!((a / length as f64 - b).abs() < 1e-14, "{length}: {a} and {b}");
            }
        }
    }

    #[test]
    fn great_prime_factors_are_left_to_others() {
        assert!(Transform::<f32>::new(2 * 131).is_none());
    }
}
