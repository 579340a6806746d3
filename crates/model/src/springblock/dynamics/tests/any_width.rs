//! Tests of sweeps with every vector width of the machine.

use pulp::{Simd, WithSimd};

use super::super::real::Real;
use super::super::rows::Plane;

/// Fills the first `size` values of each plane with numbers of both signs, independent of the machine and the
/// allocation.
pub fn fill<'a, R: Real>(planes: impl IntoIterator<Item = &'a mut Plane<R>>, size: usize) {
    let mut number = 1_u32;
    for plane in planes {
        for value in plane.rows_mut().iter_mut().take(size) {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value = R::round_from((f64::from(number) / f64::from(u32::MAX) - 0.5) * 1e-3);
        }
    }
}

/// Asserts that `sweep` writes the same nonzero bits with vectors of every width as with scalars.
pub fn assert_same_bits<W: WithSimd<Output = Vec<f64>>>(what: &str, sweep: impl Fn() -> W) {
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    let scalar = bits(Simd::vectorize(pulp::Scalar::new(), sweep()));
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = pulp::x86::V3::try_new() {
            assert!(bits(Simd::vectorize(simd, sweep())) == scalar, "four lanes, {what}");
        }
        if let Some(simd) = pulp::x86::V4::try_new() {
            assert!(bits(Simd::vectorize(simd, sweep())) == scalar, "eight lanes, {what}");
        }
    }
    assert!(scalar.iter().any(|bits| *bits != 0));
}
