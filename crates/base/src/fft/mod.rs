//! Plans of discrete Fourier transforms in single and double precision, and filters of maps whose sides are powers of
//! two.
//!
//! The transforms of rustfft are generic over the number type. A crate that plans one transform compiles all of them,
//! for every vector width, which took half of the build time of `slipgrid-surface`. This module compiles the transforms
//! once per precision; other crates hold them behind pointers, as rustfft itself does.
//!
//! ```
//! use slipgrid_base::fft::{Complex, Precision};
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

pub use convolution::{Convolution, Factors, Filter};
pub use realfft::{ComplexToReal, FftNum, RealToComplex};
pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

use number::Number;
pub use number::vectorized;
use realfft::RealFftPlanner;
use rustfft::FftPlanner;

/// Forward and inverse transforms of real rows of one length, unnormalized.
#[derive(Clone)]
pub struct RealPlans<T: FftNum> {
    /// Transforms a row to its half spectrum.
    pub forward: Arc<dyn RealToComplex<T>>,
    /// Transforms a half spectrum to its row.
    pub inverse: Arc<dyn ComplexToReal<T>>,
}

/// Forward and inverse transforms of complex rows of one length, unnormalized.
#[derive(Clone)]
pub struct ComplexPlans<T: FftNum> {
    /// Transforms a row to its spectrum.
    pub forward: Arc<dyn Fft<T>>,
    /// Transforms a spectrum to its row.
    pub inverse: Arc<dyn Fft<T>>,
}

/// Precision for which transforms are compiled: f32 or f64.
pub trait Precision: Number {
    /// Plans transforms of real rows of `length` numbers; `length` is at least 1.
    fn real_plans(length: usize) -> RealPlans<Self>;

    /// Plans transforms of complex rows of `length` numbers; `length` is at least 1.
    fn complex_plans(length: usize) -> ComplexPlans<Self>;

    /// Runs `filter`: multiplies every Fourier component of its map by the factor of the component.
    fn filter(filter: Filter<'_, Self>);
}

/// Implements [`Precision`], which instantiates the generic transforms in this module.
macro_rules! impl_precision {
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

            fn filter(filter: Filter<'_, Self>) {
                filter.run();
            }
        }
    };
}

impl_precision!(f32);
impl_precision!(f64);
