//! Discrete Fourier transform of a real periodic map, and filters in Fourier space.
//!
//! Rows are transformed by a real FFT a few at a time and written transposed, so that each column of the half spectrum
//! is contiguous; columns are then transformed in place. A filter transforms each column, multiplies it and transforms
//! it back while it is in cache. Nothing is allocated once [`FourierWork`] has been made.
//!
//! Filters of maps whose sides are powers of two, with at least 8 rows and 256 columns, use [`Convolution`] instead:
//! unordered transforms, 1.6 to 2 times as fast at 256 to 2048 points a side, whose order of summation is the same on
//! every machine.
//!
//! All other transforms use the rustfft code for the processor at hand. With AVX it adds in another order than without,
//! so that sums differ by about 1e-15 relative between processors with and without AVX; the rms slope of the stand-in
//! map differs in its last bit. Using only the instructions of every x86-64 processor would give the same bytes
//! everywhere, but cost more than half of the speed: with these transforms for filters too, the area law of 512 x 512
//! points at 24 pressures took one core of an EPYC 2.2 s with AVX, 5.0 s with SSE alone, 5.7 s without either. Speed
//! was preferred; the programs that print the numbers state the dependence.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use slipgrid_base::fft::{Complex, ComplexToReal, Convolution, Factors, Fft, FftNum, Filter, Precision, RealToComplex};
use slipgrid_base::monitor::{Cancelled, Monitor, Unwatched};

/// Rows transformed before each transposition: their complex numbers in one column fill two cache lines.
const BLOCK_ROWS: usize = 8;
/// Complex numbers of padding between columns: keeps columns of power-of-two length out of each other's cache sets.
const COLUMN_PADDING: usize = 4;

/// Transforms of periodic maps of one size in double (f64) or single (f32) precision; shared freely between threads.
#[derive(Clone)]
pub struct Fourier<T: FftNum = f64> {
    rows: usize,
    cols: usize,
    row_forward: Arc<dyn RealToComplex<T>>,
    row_inverse: Arc<dyn ComplexToReal<T>>,
    column_forward: Arc<dyn Fft<T>>,
    column_inverse: Arc<dyn Fft<T>>,
    /// Filter for large sides that are powers of two; `None` for other sides.
    convolution: Option<Arc<Convolution<T>>>,
}

impl<T: FftNum> fmt::Debug for Fourier<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Fourier").field("rows", &self.rows).field("cols", &self.cols).finish_non_exhaustive()
    }
}

/// Buffers for one transform at a time, with the monitor that can cancel it; one per thread.
#[derive(Clone)]
pub struct FourierWork<'m, T = f64> {
    /// Half spectrum, column by column.
    spectrum: Vec<Complex<T>>,
    /// A few rows of the half spectrum, before or after transposition.
    block: Vec<Complex<T>>,
    /// One real row.
    row: Vec<T>,
    scratch: Vec<Complex<T>>,
    /// Scratch space for a few columns of a convolution.
    columns: Vec<T>,
    monitor: &'m dyn Monitor,
}

/// A real factor for every wave of a map, the same for waves k and -k. It includes the 1/(rows cols) that makes the
/// forward and inverse transforms together the identity.
#[derive(Clone, Debug)]
pub struct Multiplier<T = f64> {
    /// rows/2 + 1 factors for each column of the half spectrum (waves k and -k share one), or the factors of a
    /// convolution in its own order.
    factor: Vec<T>,
}

/// Rounds `value` to the precision of `T`.
fn rounded<T: FftNum>(value: f64) -> T {
    T::from_f64(value).unwrap_or_else(T::zero)
}

impl<T: Precision> Fourier<T> {
    /// Prepares transforms for maps of `rows` x `cols` points; a side of 0 counts as 1.
    pub fn new(rows: usize, cols: usize) -> Self {
        let (rows, cols) = (rows.max(1), cols.max(1));
        let (real, complex) = (T::real_plans(cols), T::complex_plans(rows));
        Self {
            rows,
            cols,
            row_forward: real.forward,
            row_inverse: real.inverse,
            column_forward: complex.forward,
            column_inverse: complex.inverse,
            convolution: Convolution::new(rows, cols).map(Arc::new),
        }
    }

    /// Number of columns of the half spectrum.
    fn columns(&self) -> usize {
        self.cols / 2 + 1
    }

    /// Distance between columns of the half spectrum in memory, in complex numbers.
    fn stride(&self) -> usize {
        self.rows + COLUMN_PADDING
    }

    /// 1/(rows cols), which makes the forward and inverse transforms together the identity.
    fn inverse_points(&self) -> f64 {
        1.0 / (self.rows as f64 * self.cols as f64)
    }

    /// Buffers for one filter at a time.
    pub fn work(&self) -> FourierWork<'static, T> {
        self.work_watched(&Unwatched)
    }

    /// Buffers for one filter at a time, which ends once `monitor` cancels; the filter's output is then undefined.
    pub fn work_watched<'m>(&self, monitor: &'m dyn Monitor) -> FourierWork<'m, T> {
        let Some(convolution) = &self.convolution else { return self.transform_work(monitor) };
        let columns = vec![T::zero(); convolution.scratch_len()];
        FourierWork { spectrum: Vec::new(), block: Vec::new(), row: Vec::new(), scratch: Vec::new(), columns, monitor }
    }

    /// Buffers for one transform at a time.
    fn transform_work<'m>(&self, monitor: &'m dyn Monitor) -> FourierWork<'m, T> {
        let zero = Complex::new(T::zero(), T::zero());
        let scratch = self
            .row_forward
            .get_scratch_len()
            .max(self.row_inverse.get_scratch_len())
            .max(self.column_forward.get_inplace_scratch_len())
            .max(self.column_inverse.get_inplace_scratch_len());
        FourierWork {
            spectrum: vec![zero; self.columns() * self.stride()],
            block: vec![zero; BLOCK_ROWS * self.columns()],
            row: vec![T::zero(); self.cols],
            scratch: vec![zero; scratch],
            columns: Vec::new(),
            monitor,
        }
    }

    /// The angular wave number |q| in rad/m of k waves along x and l along y, on pixels `dx_m` x `dy_m`.
    pub fn wave_number(&self, k: usize, l: usize, dx_m: f64, dy_m: f64) -> f64 {
        // q = 2 pi (k / (rows dx), l / (cols dy))
        let qx = TAU * k as f64 / (self.rows as f64 * dx_m);
        let qy = TAU * l as f64 / (self.cols as f64 * dy_m);
        // Unlike hypot, the root is rounded alike by every library; squares of lengths of maps do not overflow.
        (qx * qx + qy * qy).sqrt()
    }

    /// The filter that multiplies each wave by `factor(|q|)`, q the angular wave number in rad/m on pixels
    /// of `dx_m` x `dy_m`; `mean` is the factor of the mean, q = 0.
    pub fn multiplier(&self, dx_m: f64, dy_m: f64, mean: f64, factor: impl Fn(f64) -> f64) -> Multiplier<T> {
        self.wave_multiplier(|k, l| if k == 0 && l == 0 { mean } else { factor(self.wave_number(k, l, dx_m, dy_m)) })
    }

    /// The filter that multiplies the waves of +-k along x and +-l along y by `factor(k, l)`, k up to rows/2 and
    /// l up to cols/2.
    pub fn wave_multiplier(&self, factor: impl Fn(usize, usize) -> f64) -> Multiplier<T> {
        let inverse_points = self.inverse_points();
        if let Some(convolution) = &self.convolution {
            return Multiplier { factor: convolution.factors(|k, l| factor(k, l) * inverse_points) };
        }
        let waves = (0..self.columns()).flat_map(|l| (0..=self.rows / 2).map(move |k| (k, l)));
        Multiplier { factor: waves.map(|(k, l)| rounded(factor(k, l) * inverse_points)).collect() }
    }

    /// Writes `input` to `output` with every wave multiplied by its factor in `multiplier`; both are rows x cols, row
    /// by row.
    pub fn filter(&self, input: &[T], multiplier: &Multiplier<T>, output: &mut [T], work: &mut FourierWork<'_, T>) {
        self.filter_by(input, Factors::Stored(&multiplier.factor), output, work);
    }

    /// Like [`Self::filter`] with the multiplier that [`Self::wave_multiplier`] returns for `factor`, but computes the
    /// factors while the filter runs, without storing them.
    pub fn filter_unstored(
        &self,
        input: &[T],
        factor: impl Fn(usize, usize) -> f64,
        output: &mut [T],
        work: &mut FourierWork<'_, T>,
    ) {
        let inverse_points = self.inverse_points();
        self.filter_by(input, Factors::Computed(&|k, l| factor(k, l) * inverse_points), output, work);
    }

    fn filter_by(&self, input: &[T], factors: Factors<'_, T>, output: &mut [T], work: &mut FourierWork<'_, T>) {
        if let Some(convolution) = &self.convolution {
            let should_continue = &|| !work.monitor.cancelled();
            let scratch = &mut work.columns;
            return T::filter(Filter { plan: convolution, input, factors, output, scratch, should_continue });
        }
        // A cancelled transform leaves the output undefined, as documented.
        let _ = self.filter_columns(input, factors, output, work);
    }

    /// Filters a map of any size.
    fn filter_columns(
        &self,
        input: &[T],
        factors: Factors<'_, T>,
        output: &mut [T],
        work: &mut FourierWork<'_, T>,
    ) -> Result<(), Cancelled> {
        self.rows_forward(input, work)?;
        let half = self.rows / 2 + 1;
        let FourierWork { spectrum, scratch, monitor, .. } = work;
        let mut computed = Vec::new();
        for (l, column) in spectrum.chunks_exact_mut(self.stride()).enumerate() {
            monitor.heed()?;
            let factor = match factors {
                Factors::Stored(all) => &all[l * half..][..half],
                Factors::Computed(factor) => {
                    computed.clear();
                    computed.extend((0..half).map(|k| rounded::<T>(factor(k, l))));
                    &computed[..]
                }
            };
            let column = &mut column[..self.rows];
            self.column_forward.process_with_scratch(column, scratch);
            let (low, high) = column.split_at_mut(half);
            for (wave, &m) in low.iter_mut().zip(factor) {
                *wave = wave.scale(m);
            }
            // Wave rows - k is wave -k and shares the factor of k.
            for (wave, &m) in high.iter_mut().rev().zip(&factor[1..]) {
                *wave = wave.scale(m);
            }
            self.column_inverse.process_with_scratch(column, scratch);
        }
        self.rows_inverse(output, work)
    }

    /// Transforms all rows of `input` into the columns of the spectrum.
    fn rows_forward(&self, input: &[T], work: &mut FourierWork<'_, T>) -> Result<(), Cancelled> {
        assert_eq!(input.len(), self.rows * self.cols, "a map of another size");
        let (columns, stride) = (self.columns(), self.stride());
        let FourierWork { spectrum, block, row, scratch, monitor, .. } = work;
        for (chunk, rows) in input.chunks(BLOCK_ROWS * self.cols).enumerate() {
            monitor.heed()?;
            let first = chunk * BLOCK_ROWS;
            let present = rows.len() / self.cols;
            for (source, target) in rows.chunks_exact(self.cols).zip(block.chunks_exact_mut(columns)) {
                row.copy_from_slice(source);
                let done = self.row_forward.process_with_scratch(row, target, scratch);
                debug_assert!(done.is_ok(), "buffers have the plan's lengths");
            }
            for (l, column) in spectrum.chunks_exact_mut(stride).enumerate() {
                for (k, wave) in column[first..first + present].iter_mut().enumerate() {
                    *wave = block[k * columns + l];
                }
            }
        }
        Ok(())
    }

    /// Transforms the columns of the spectrum, already inverted along x, into rows.
    fn rows_inverse(&self, output: &mut [T], work: &mut FourierWork<'_, T>) -> Result<(), Cancelled> {
        assert_eq!(output.len(), self.rows * self.cols, "a map of another size");
        let (columns, stride) = (self.columns(), self.stride());
        let FourierWork { spectrum, block, scratch, monitor, .. } = work;
        for (chunk, rows) in output.chunks_mut(BLOCK_ROWS * self.cols).enumerate() {
            monitor.heed()?;
            let first = chunk * BLOCK_ROWS;
            let present = rows.len() / self.cols;
            for (l, column) in spectrum.chunks_exact(stride).enumerate() {
                for (k, wave) in column[first..first + present].iter().enumerate() {
                    block[k * columns + l] = *wave;
                }
            }
            for (target, source) in rows.chunks_exact_mut(self.cols).zip(block.chunks_exact_mut(columns)) {
                // The mean and the Nyquist wave of a real row are real; the imaginary part is rounding error.
                source[0].im = T::zero();
                if self.cols.is_multiple_of(2) {
                    source[columns - 1].im = T::zero();
                }
                let done = self.row_inverse.process_with_scratch(source, target, scratch);
                debug_assert!(done.is_ok(), "buffers have the plan's lengths");
            }
        }
        Ok(())
    }
}

impl Fourier {
    /// Calls `visit(|q|, twins, |sum h exp(-i q x)|^2)` for every wave except the mean, with q in rad/m on pixels of
    /// `dx_m` x `dy_m`. Of a wave and its mirror image (-k, -l) one is visited, with `twins` = 2; if l is 0 or the
    /// Nyquist wave, both are, with `twins` = 1.
    pub(crate) fn visit_waves(
        &self,
        input: &[f64],
        [dx_m, dy_m]: [f64; 2],
        mut visit: impl FnMut(f64, f64, f64),
        monitor: &dyn Monitor,
    ) -> Result<(), Cancelled> {
        let work = &mut self.transform_work(monitor);
        self.rows_forward(input, work)?;
        for (l, column) in work.spectrum.chunks_exact_mut(self.stride()).enumerate() {
            monitor.heed()?;
            let column = &mut column[..self.rows];
            self.column_forward.process_with_scratch(column, &mut work.scratch);
            // The half spectrum holds one of the waves l and -l, which are the same for l = 0 and at the Nyquist wave.
            let twins = if l == 0 || 2 * l == self.cols { 1.0 } else { 2.0 };
            for (k, wave) in column.iter().enumerate() {
                if k > 0 || l > 0 {
                    visit(self.wave_number(k.min(self.rows - k), l, dx_m, dy_m), twins, wave.norm_sqr());
                }
            }
        }
        Ok(())
    }

    /// Replaces `map` by its autocorrelation, summed over one period: map(t) = sum over x of map(x) map(x + t).
    pub(crate) fn autocorrelate(&self, map: &mut [f64], monitor: &dyn Monitor) -> Result<(), Cancelled> {
        let work = &mut self.transform_work(monitor);
        self.rows_forward(map, work)?;
        let inverse_points = self.inverse_points();
        for column in work.spectrum.chunks_exact_mut(self.stride()) {
            monitor.heed()?;
            let column = &mut column[..self.rows];
            self.column_forward.process_with_scratch(column, &mut work.scratch);
            for wave in column.iter_mut() {
                // Wiener-Khinchin theorem: the transform of the autocorrelation is |h_q|^2.
                *wave = Complex::new(wave.norm_sqr() * inverse_points, 0.0);
            }
            self.column_inverse.process_with_scratch(column, &mut work.scratch);
        }
        self.rows_inverse(map, work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of the given size without symmetry.
    fn uneven(rows: usize, cols: usize) -> Vec<f64> {
        (0..rows * cols).map(|n| ((n * n * 7919 + 13 * n) % 1009) as f64 / 1009.0 - 0.4).collect()
    }

    /// Direct filter by sums over all waves, slow but independent.
    fn filter_directly(rows: usize, cols: usize, input: &[f64], factor: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let signed = |k: usize, n: usize| if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
        let mut output = vec![0.0; rows * cols];
        for k in 0..rows {
            for l in 0..cols {
                let phase = |i: usize, j: usize| {
                    TAU * ((k * i % rows) as f64 / rows as f64 + (l * j % cols) as f64 / cols as f64)
                };
                let mut wave = Complex::new(0.0, 0.0);
                for i in 0..rows {
                    for j in 0..cols {
                        wave += Complex::from_polar(input[i * cols + j], -phase(i, j));
                    }
                }
                wave *= factor(signed(k, rows), signed(l, cols)) / (rows * cols) as f64;
                for i in 0..rows {
                    for j in 0..cols {
                        output[i * cols + j] += (wave * Complex::from_polar(1.0, phase(i, j))).re;
                    }
                }
            }
        }
        output
    }

    #[test]
    fn filter_agrees_with_the_sum_over_waves_for_any_size() {
        for (rows, cols) in [(8, 8), (9, 7), (6, 15), (13, 4), (2, 2), (1, 5), (5, 1), (10, 12)] {
            let (dx, dy) = (0.5, 1.25);
            let input = uneven(rows, cols);
            let fourier = Fourier::new(rows, cols);
            let multiplier = fourier.multiplier(dx, dy, 0.3, |q| 1.0 / (1.0 + q));
            let mut output = vec![0.0; rows * cols];
            fourier.filter(&input, &multiplier, &mut output, &mut fourier.work());
            let expected = filter_directly(rows, cols, &input, |k, l| {
                let q = (TAU * k / (rows as f64 * dx)).hypot(TAU * l / (cols as f64 * dy));
                if q == 0.0 { 0.3 } else { 1.0 / (1.0 + q) }
            });
            for (a, b) in output.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-13, "{rows} x {cols}: {a} and {b}");
            }
        }
    }

    #[test]
    fn single_precision_is_the_same_filter() {
        let (rows, cols) = (48, 20);
        let double = Fourier::new(rows, cols);
        let single = Fourier::<f32>::new(rows, cols);
        let input = uneven(rows, cols);
        let rounded: Vec<f32> = input.iter().map(|&value| value as f32).collect();
        let (mut expected, mut output) = (vec![0.0; rows * cols], vec![0.0; rows * cols]);
        let factor = |q: f64| 1.0 / (1.0 + q);
        double.filter(&input, &double.multiplier(1.0, 1.0, 0.3, factor), &mut expected, &mut double.work());
        single.filter(&rounded, &single.multiplier(1.0, 1.0, 0.3, factor), &mut output, &mut single.work());
        assert!(expected.iter().zip(&output).all(|(a, &b)| (a - f64::from(b)).abs() < 1e-6));
    }

    #[test]
    fn convolutions_are_the_same_filter() {
        for (rows, cols) in [(8, 256), (16, 512), (32, 256), (64, 4096), (256, 256)] {
            let (own, mut other) = (Fourier::new(rows, cols), Fourier::new(rows, cols));
            assert!(own.convolution.is_some());
            other.convolution = None;
            let input = uneven(rows, cols);
            let filtered = |fourier: &Fourier| {
                let multiplier = fourier.multiplier(0.5, 1.25, 0.3, |q| 1.0 / (1.0 + q));
                let mut output = vec![0.0; rows * cols];
                fourier.filter(&input, &multiplier, &mut output, &mut fourier.work());
                output
            };
            for (a, b) in filtered(&own).iter().zip(filtered(&other)) {
                assert!((a - b).abs() < 1e-13, "{rows} x {cols}: {a} and {b}");
            }
        }
    }

    #[test]
    fn autocorrelation_agrees_with_the_sum_for_any_size() {
        for (rows, cols) in [(8, 8), (9, 7), (6, 15), (1, 5)] {
            let input = uneven(rows, cols);
            let mut output = input.clone();
            Fourier::new(rows, cols).autocorrelate(&mut output, &Unwatched).unwrap();
            for (n, found) in output.iter().enumerate() {
                let moved = |m: usize| (m / cols + n / cols) % rows * cols + (m % cols + n % cols) % cols;
                let sum: f64 = (0..rows * cols).map(|m| input[m] * input[moved(m)]).sum();
                assert!((found - sum).abs() < 1e-12, "{rows} x {cols}: {found} and {sum}");
            }
        }
    }

    #[test]
    fn parseval_holds_for_any_size() {
        for (rows, cols) in [(8, 8), (9, 7), (6, 15), (13, 4), (1, 5), (5, 1)] {
            let input = uneven(rows, cols);
            let points = input.len() as f64;
            let mean = input.iter().sum::<f64>() / points;
            let variance = input.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / points;
            let mut sum = 0.0;
            let add = |_, twins, square| sum += twins * square / (points * points);
            Fourier::new(rows, cols).visit_waves(&input, [1.0; 2], add, &Unwatched).unwrap();
            assert!((sum - variance).abs() < 1e-14, "{rows} x {cols}: {sum} and {variance}");
        }
    }
}
