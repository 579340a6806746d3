//! Floating-point types of displacements: f64, or f32 for deviations from sliding in equilibrium.
//!
//! Sweeps only add and multiply, lane by lane, and are generic over the precision.

use std::fmt::Debug;

use pulp::bytemuck::Pod;
use pulp::{Simd, WithSimd};

/// A floating-point number and its vectors.
pub trait Real: Pod + Default + PartialEq + Debug + Send + Sync {
    /// Number of values in a cache line.
    const LINE: usize;
    /// Distance between 1 and the next larger number.
    const EPSILON: f64;

    /// Vector type of the instruction set `S`.
    type Vector<S: Simd>: Pod;

    /// Rounds `value` to this type.
    fn round_from(value: f64) -> Self;
    /// Converts to double precision.
    fn to_f64(self) -> f64;

    /// Vector with the rounded `value` in every lane.
    fn splat<S: Simd>(simd: S, value: f64) -> Self::Vector<S>;
    /// Lane-wise a + b.
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// Lane-wise a - b.
    fn sub<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// Lane-wise a b.
    fn mul<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// Lane-wise a b + c; a must be a power of two, so that fused and separate operations give the same result.
    fn scale_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;

    /// Views the beginning of `values` as vectors; a remainder is left out.
    fn vectors<S: Simd>(values: &[Self]) -> &[Self::Vector<S>];
    /// Views the beginning of `values` as mutable vectors; a remainder is left out.
    fn vectors_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Vector<S>];

    #[inline(always)]
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Vector<S>>() / size_of::<Self>()
    }
}

/// Implements [`Real`] for one type, given the names of its vector operations in `pulp`.
macro_rules! real {
    ($real:ident, $vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $scale_add:ident, $of:ident, $of_mut:ident) => {
        impl Real for $real {
            const LINE: usize = LINE_BYTES / size_of::<Self>();
            const EPSILON: f64 = Self::EPSILON as f64;

            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn round_from(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
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

/// Rounds the number of values `columns` up to whole cache lines; returns a number of values.
pub const fn whole_lines<R: Real>(columns: usize) -> usize {
    columns.next_multiple_of(R::LINE)
}

/// Maximum ratio of the largest spring force above the contact row to the largest on the contact row in a state that
/// counts as in equilibrium: smaller forces are not much above the rounding error of deviations.
const EQUILIBRIUM: f64 = 1e-6;

/// Whether displacements may be stored as deviations from a state whose largest spring forces are `inside` above the
/// contact row and `at_contact` on it. Deviations neglect the forces above the contact row.
pub fn is_in_equilibrium(inside: f64, at_contact: f64) -> bool {
    inside <= EQUILIBRIUM * at_contact
}

/// Adds the forces of deviations to those of the base state, in double precision.
pub struct AddForces<'a, R> {
    /// Forces due to the deviations.
    pub force: &'a [R],
    /// Forces in the base state.
    pub base_force: &'a [f64],
    /// Sum of `force` and `base_force`.
    pub total: &'a mut [f64],
}

impl<R: Real> WithSimd for AddForces<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((total, force), base_force) in self.total.iter_mut().zip(self.force).zip(self.base_force) {
            *total = base_force + force.to_f64();
        }
    }
}

/// Moves contact blocks by `velocity` and writes their displacements relative to the moving frame to `row`.
/// Displacements are in lattice spacings.
pub struct PlaceContacts<'a, R> {
    /// Displacements in the frame at rest, updated by the step.
    pub place: &'a mut [f64],
    /// Displacements during this step.
    pub velocity: &'a [f64],
    /// Displacement of the moving frame after the step.
    pub carried: f64,
    /// Displacements in the moving frame after the step.
    pub row: &'a mut [R],
}

impl<R: Real> WithSimd for PlaceContacts<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((place, velocity), row) in self.place.iter_mut().zip(self.velocity).zip(self.row) {
            *place += velocity;
            *row = R::round_from(*place - self.carried);
        }
    }
}
