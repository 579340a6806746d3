//! Plans of discrete Fourier transforms in single and double precision, and filters of maps whose sides are powers of two.
//!
//! The transforms of rustfft are generic over the number: every crate that plans one compiles all of them, for every vector width
//! that a processor may have, which took half of the time that `contact` and `topography` took to build. Here they are compiled
//! once for each precision, and the others hold them behind pointers, as rustfft does itself.
//!
//! ```
//! use slipgrid_fft::{Complex, Precision};
//! let plans = f64::real_plans(4);
//! let (mut row, mut spectrum) = ([1.0, 2.0, 3.0, 4.0], [Complex::new(0.0, 0.0); 3]);
//! plans.forward.process(&mut row, &mut spectrum)?;
//! assert!((spectrum[0].re - 10.0).abs() < 1e-15 && (spectrum[2].re + 2.0).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod convolution;
mod number;
mod splits;

use std::sync::Arc;

pub use convolution::Convolution;
pub use realfft::{ComplexToReal, FftNum, RealToComplex};
pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

use convolution::Filter;
use number::Number;
pub use number::vectorized;
use realfft::RealFftPlanner;
use rustfft::FftPlanner;

/// Transforms of real rows of one length, there and back, unnormalized.
#[derive(Clone)]
pub struct RealPlans<T: FftNum> {
    /// Row to half spectrum.
    pub forward: Arc<dyn RealToComplex<T>>,
    /// Half spectrum to row.
    pub inverse: Arc<dyn ComplexToReal<T>>,
}

/// Transforms of complex rows of one length, there and back, unnormalized.
#[derive(Clone)]
pub struct ComplexPlans<T: FftNum> {
    /// Row to spectrum.
    pub forward: Arc<dyn Fft<T>>,
    /// Spectrum to row.
    pub inverse: Arc<dyn Fft<T>>,
}

/// A precision in which transforms are compiled: f32 or f64.
pub trait Precision: Number {
    /// Transforms of real rows of `length` numbers, at least 1.
    fn real_plans(length: usize) -> RealPlans<Self>;

    /// Transforms of rows of `length` complex numbers, at least 1.
    fn complex_plans(length: usize) -> ComplexPlans<Self>;

    /// `output` = `input` with every wave multiplied by its factor, in the order of [`Convolution::factors`]; `scratch` of
    /// [`Convolution::scratch_len`]. Where `goes_on` says no on the way the rest is left undone.
    fn filter(
        plan: &Convolution<Self>,
        input_and_factors: [&[Self]; 2],
        output: &mut [Self],
        scratch: &mut [Self],
        goes_on: &dyn Fn() -> bool,
    );
}

/// Compiles the transforms of one precision here, whoever plans them.
macro_rules! compiled {
    ($number:ty) => {
        impl Precision for $number {
            fn real_plans(length: usize) -> RealPlans<Self> {
                let mut planner = RealFftPlanner::<$number>::new();
                RealPlans { forward: planner.plan_fft_forward(length), inverse: planner.plan_fft_inverse(length) }
            }

            fn complex_plans(length: usize) -> ComplexPlans<Self> {
                let mut planner = FftPlanner::<$number>::new();
                ComplexPlans { forward: planner.plan_fft_forward(length), inverse: planner.plan_fft_inverse(length) }
            }

            fn filter(
                plan: &Convolution<Self>,
                [input, factors]: [&[Self]; 2],
                output: &mut [Self],
                scratch: &mut [Self],
                goes_on: &dyn Fn() -> bool,
            ) {
                Filter { plan, input, factors, output, scratch, goes_on }.run();
            }
        }
    };
}

compiled!(f32);
compiled!(f64);
