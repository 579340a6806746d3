//! Arithmetic in vectors of the widest instruction set of the machine.

use pulp::{Simd, WithSimd};
use realfft::FftNum;

/// Numbers with SIMD vectors: f32 or f64.
pub trait Number: FftNum {
    /// Vector type of the instruction set `S`.
    type V<S: Simd>: Copy;

    /// Rounds `value` to this type.
    fn round_from(value: f64) -> Self;
    /// Views `numbers` as vectors; their count must be a multiple of the vector length.
    fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::V<S>];
    /// Views `numbers` as mutable vectors; their count must be a multiple of the vector length.
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [Self::V<S>];
    /// Vector with `value` in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::V<S>;
    /// Sum a + b in every lane.
    fn sum<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Difference a - b in every lane.
    fn difference<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Product a b in every lane.
    fn product<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
}

macro_rules! impl_number {
    ($number:ty, $vector:ident, $vectors:ident, $vectors_mut:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident) => {
        impl Number for $number {
            type V<S: Simd> = S::$vector;

            fn round_from(value: f64) -> Self {
                value as $number
            }

            #[inline(always)]
            fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::V<S>] {
                S::$vectors(numbers).0
            }

            #[inline(always)]
            fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [Self::V<S>] {
                S::$vectors_mut(numbers).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> Self::V<S> {
                simd.$splat(value)
            }

            #[inline(always)]
            fn sum<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn difference<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn product<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
                simd.$mul(a, b)
            }
        }
    };
}

impl_number!(f32, f32s, as_simd_f32s, as_mut_simd_f32s, splat_f32s, add_f32s, sub_f32s, mul_f32s);
impl_number!(f64, f64s, as_simd_f64s, as_mut_simd_f64s, splat_f64s, add_f64s, sub_f64s, mul_f64s);

/// Runs `work` with the widest vectors of this machine.
///
/// The result does not depend on the width if each lane of `work` does scalar operations only.
#[inline]
pub fn vectorized<W: WithSimd>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = pulp::x86::V4::try_new() {
            return Simd::vectorize(simd, work);
        }
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Simd::vectorize(simd, work);
        }
    }
    Simd::vectorize(pulp::Scalar::new(), work)
}
