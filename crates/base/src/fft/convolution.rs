//! Filters of real periodic maps: transform, multiplication of every wave by a real even factor, inverse transform.
//!
//! The result of a filter does not depend on the order in which the waves are stored, so that no transform puts them in
//! order. Sides that are powers of two have a method of their own (`powers_of_two`), 1.5 to 2 times as fast as the other
//! (`any_size`), which is 1.3 to 2.7 times as fast as the transforms of rustfft with transpositions between.
//!
//! Sums and products are scalar operations in fixed order, without fused multiply-add, for every vector width: every
//! machine returns the same bytes.

#[cfg(test)]
use pulp::Simd;
use pulp::WithSimd;

use crate::fft::any_size::AnySize;
use crate::fft::number::{Number, vectorized};
use crate::fft::powers_of_two::PowersOfTwo;

/// Plan of a filter for maps of one size; see the module documentation.
#[derive(Clone, Debug)]
pub struct Convolution<T> {
    points: usize,
    method: Method<T>,
}

#[derive(Clone, Debug)]
enum Method<T> {
    PowersOfTwo(PowersOfTwo<T>),
    AnySize(AnySize<T>),
}

/// Vectors that a filter uses.
#[derive(Clone, Copy, Debug)]
enum Widths {
    /// The widest of this machine.
    Widest,
    #[cfg(test)]
    Avx2,
    #[cfg(test)]
    Scalar,
}

impl<T: Number> Convolution<T> {
    /// Plans filters of maps of `rows` x `cols` points, both at least 1; `None` if a side has a prime factor above 127.
    #[must_use]
    pub fn new(rows: usize, cols: usize) -> Option<Self> {
        let method = match PowersOfTwo::new(rows, cols) {
            Some(plan) => Method::PowersOfTwo(plan),
            None => Method::AnySize(AnySize::new(rows, cols)?),
        };
        Some(Self { points: rows * cols, method })
    }

    /// Length of the scratch buffer that a filter needs.
    #[must_use]
    pub fn scratch_len(&self) -> usize {
        match &self.method {
            Method::PowersOfTwo(plan) => plan.scratch_len(),
            Method::AnySize(plan) => plan.scratch_len(),
        }
    }

    /// Arranges the factors in the order that [`Precision::filter`](crate::fft::Precision::filter) expects.
    ///
    /// `factor(k, l)` is the factor of the wave with k periods along x and l along y, with k up to rows/2 and l up to
    /// cols/2. It must include the normalization 1/(rows cols).
    #[must_use]
    pub fn factors(&self, factor: impl Fn(usize, usize) -> f64) -> Vec<T> {
        match &self.method {
            Method::PowersOfTwo(plan) => plan.factors(factor),
            Method::AnySize(plan) => plan.factors(factor),
        }
    }

    /// Filters a map; see [`Precision::filter`](crate::fft::Precision::filter).
    pub(crate) fn filter(
        &self,
        input_and_factors: [&[T]; 2],
        output: &mut [T],
        scratch: &mut [T],
        should_continue: &dyn Fn() -> bool,
    ) {
        self.filter_by(Widths::Widest, input_and_factors, output, scratch, should_continue);
    }

    fn filter_by(
        &self,
        widths: Widths,
        [input, factors]: [&[T]; 2],
        output: &mut [T],
        scratch: &mut [T],
        should_continue: &dyn Fn() -> bool,
    ) {
        assert!(input.len() == self.points && output.len() == self.points, "a map of another size");
        match &self.method {
            Method::PowersOfTwo(plan) => {
                run(Filter { plan, input, factors, output, scratch, should_continue }, widths);
            }
            Method::AnySize(plan) => run(Filter { plan, input, factors, output, scratch, should_continue }, widths),
        }
    }
}

fn run(filter: impl WithSimd<Output = ()>, widths: Widths) {
    match widths {
        Widths::Widest => vectorized(filter),
        #[cfg(test)]
        Widths::Scalar => Simd::vectorize(pulp::Scalar::new(), filter),
        #[cfg(test)]
        Widths::Avx2 => {
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = pulp::x86::V3::try_new() {
                return Simd::vectorize(simd, filter);
            }
            vectorized(filter);
        }
    }
}

/// One application of a filter by the method of `plan`.
pub(crate) struct Filter<'a, T, P> {
    pub(crate) plan: &'a P,
    pub(crate) input: &'a [T],
    pub(crate) factors: &'a [T],
    pub(crate) output: &'a mut [T],
    pub(crate) scratch: &'a mut [T],
    /// Called between parts of the map; the filter stops if it returns false.
    pub(crate) should_continue: &'a dyn Fn() -> bool,
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

    fn filtered<T: Number>(rows: usize, cols: usize, input: &[T]) -> Vec<T> {
        let plan = Convolution::<T>::new(rows, cols).unwrap();
        let factors = plan.factors(|k, l| factor(k, l) / (rows * cols) as f64);
        let (mut output, mut scratch) = (vec![T::zero(); input.len()], vec![T::zero(); plan.scratch_len()]);
        plan.filter([input, &factors], &mut output, &mut scratch, &|| true);
        output
    }

    #[test]
    fn every_wave_is_multiplied_by_its_factor() {
        let sizes =
            [(8, 256), (16, 512), (64, 256), (32, 2048), (9, 75), (50, 33), (57, 31), (38, 1), (1, 40), (16, 64)];
        for (rows, cols) in sizes {
            let turn = |k: usize, n: usize, of: usize| (k * n % of) as f64 / of as f64;
            let pairs = [(0, 0), (0, 1), (1, 0), (rows / 2, 0), (0, cols / 2), (rows / 2, cols / 2), (3, 77), (2, 128)];
            for (k, l) in pairs.map(|(k, l)| (k % (rows / 2 + 1), l % (cols / 2 + 1))) {
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
        for (rows, cols) in [(8, 256), (128, 512), (512, 1024), (513, 650)] {
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
        fn same<T: Number>(rows: usize, cols: usize, input: &[T], bits: impl Fn(T) -> u64) {
            let plan = Convolution::<T>::new(rows, cols).unwrap();
            let factors = plan.factors(factor);
            let by = |widths| {
                let (mut output, mut scratch) = (vec![T::zero(); input.len()], vec![T::zero(); plan.scratch_len()]);
                plan.filter_by(widths, [input, &factors], &mut output, &mut scratch, &|| true);
                output.into_iter().map(&bits).collect::<Vec<u64>>()
            };
            let scalar = by(Widths::Scalar);
            for widths in [Widths::Widest, Widths::Avx2] {
                assert_eq!(by(widths), scalar, "{rows} x {cols}, {widths:?}");
            }
        }
        for (rows, cols) in [(16, 512), (18, 511), (20, 511), (26, 37)] {
            let input = uneven(rows * cols);
            same(rows, cols, &input, f64::to_bits);
            let rounded: Vec<f32> = input.iter().map(|&value| value as f32).collect();
            same(rows, cols, &rounded, |value| u64::from(value.to_bits()));
        }
    }

    #[test]
    fn great_prime_factors_are_left_to_others() {
        assert!(Convolution::<f32>::new(131, 256).is_none());
    }
}
