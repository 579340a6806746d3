//! What displacements are kept in: double precision, or single where they are deviations from sliding in equilibrium.
//!
//! Sweeps do nothing but add and multiply, lane by lane, and both precisions share their text.

use std::fmt::Debug;

use pulp::bytemuck::Pod;
use pulp::{Simd, WithSimd};

/// A floating-point number and its vectors.
pub trait Real: Pod + Default + PartialEq + Debug + Send + Sync {
    /// Values in a cache line.
    const LINE: usize;
    /// Distance of numbers from 1 up to 2.
    const EPSILON: f64;

    /// A vector of such numbers.
    type Vector<S: Simd>: Pod;

    /// `value` rounded.
    fn of(value: f64) -> Self;
    /// The same number in double precision.
    fn widened(self) -> f64;

    /// `value` rounded, in every lane.
    fn splat<S: Simd>(simd: S, value: f64) -> Self::Vector<S>;
    /// a + b
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a - b
    fn sub<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b
    fn mul<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b + c, where a is a power of two, so that it is the same fused and in two steps.
    fn scale_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;

    /// Whole vectors from the beginning of `values`.
    fn vectors<S: Simd>(values: &[Self]) -> &[Self::Vector<S>];
    /// The same, to be written.
    fn vectors_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Vector<S>];

    /// Lanes of a vector.
    #[inline(always)]
    #[must_use]
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Vector<S>>() / size_of::<Self>()
    }
}

/// One precision: its type, the type of its vectors, and what they are called in `pulp`.
macro_rules! real {
    ($real:ident, $vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $scale_add:ident, $of:ident, $of_mut:ident) => {
        impl Real for $real {
            const LINE: usize = LINE_BYTES / size_of::<Self>();
            const EPSILON: f64 = Self::EPSILON as f64;

            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn widened(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: f64) -> S::$vector {
                simd.$splat(value as Self)
            }

            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn scale_add<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$scale_add(a, b, c)
            }

            #[inline(always)]
            fn vectors<S: Simd>(values: &[Self]) -> &[S::$vector] {
                S::$of(values).0
            }

            #[inline(always)]
            fn vectors_mut<S: Simd>(values: &mut [Self]) -> &mut [S::$vector] {
                S::$of_mut(values).0
            }
        }
    };
}

/// Bytes in a cache line.
pub const LINE_BYTES: usize = 64;

real!(f64, f64s, splat_f64s, add_f64s, sub_f64s, mul_f64s, mul_add_e_f64s, as_simd_f64s, as_mut_simd_f64s);
real!(f32, f32s, splat_f32s, add_f32s, sub_f32s, mul_f32s, mul_add_e_f32s, as_simd_f32s, as_mut_simd_f32s);

/// The whole number of cache lines that holds `columns` values, in values.
#[must_use]
pub const fn whole_lines<R: Real>(columns: usize) -> usize {
    columns.next_multiple_of(R::LINE)
}

/// Largest force on a block above the contact row, over that on the contact row, of a state that is in equilibrium above it: what is left is
/// not much above the rounding of deviations.
const EQUILIBRIUM: f64 = 1e-6;

/// Whether a state with the largest forces `inside` and `at_contact`, above the contact row and on it, may be deviated from: the former are
/// left out then.
#[must_use]
pub fn is_in_equilibrium(inside: f64, at_contact: f64) -> bool {
    inside <= EQUILIBRIUM * at_contact
}

/// Adds forces to those of the state that displacements deviate from, in double precision.
pub struct AddForces<'a, R> {
    /// Forces by the deviations.
    pub force: &'a [R],
    /// Forces in the state itself.
    pub of_base: &'a [f64],
    /// Their sum.
    pub total: &'a mut [f64],
}

impl<R: Real> WithSimd for AddForces<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((total, force), of_base) in self.total.iter_mut().zip(self.force).zip(self.of_base) {
            *total = of_base + force.widened();
        }
    }
}

/// Moves contact blocks by `velocity` and places them in a row of the frame, which has been carried by `carried`.
pub struct PlaceContacts<'a, R> {
    /// Displacements in the frame at rest.
    pub place: &'a mut [f64],
    /// Displacements of this step.
    pub velocity: &'a [f64],
    /// How far the frame has been carried after the step.
    pub carried: f64,
    /// Displacements in the frame after the step.
    pub row: &'a mut [R],
}

impl<R: Real> WithSimd for PlaceContacts<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((place, velocity), row) in self.place.iter_mut().zip(self.velocity).zip(self.row) {
            *place += velocity;
            *row = R::of(*place - self.carried);
        }
    }
}
