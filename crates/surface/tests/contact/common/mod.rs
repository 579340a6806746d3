//! Surfaces and tables shared by several tests.

#[allow(dead_code, reason = "each test file takes what it needs")]
pub mod surfaces;

use std::f64::consts::TAU;

use slipgrid_surface::topography::{HeightMap, SelfAffine};

/// E* of E = 0.38 GPa, nu = 1/3, in pascals.
pub const MODULUS_PA: f64 = 427.5e6;
/// Side of all reference maps, in metres.
pub const SIDE_M: f64 = 1e-3;

/// A square map of the reference side; `height` is a function of x and y from 0 to 1.
pub fn square(n: usize, height: impl Fn(f64, f64) -> f64) -> HeightMap {
    let at = |k: usize| k as f64 / n as f64;
    let heights = (0..n * n).map(|k| height(at(k / n), at(k % n))).collect();
    HeightMap::new(n, n, SIDE_M / n as f64, SIDE_M / n as f64, heights).unwrap()
}

/// A wave of amplitude 1 um along x.
#[allow(dead_code, reason = "each test file takes what it needs")]
pub fn wave(n: usize) -> HeightMap {
    square(n, |x, _| 1e-6 * (TAU * x).cos())
}

/// Two crossed waves of amplitude 1 um.
#[allow(dead_code, reason = "each test file takes what it needs")]
pub fn crossed_waves(n: usize) -> HeightMap {
    square(n, |x, y| 1e-6 * (TAU * x).cos() * (TAU * y).cos())
}

/// The reference map A_n.
#[allow(dead_code, reason = "each test file takes what it needs")]
pub fn self_affine(n: usize) -> HeightMap {
    SelfAffine { pixels: n, max_wave: n as u32 / 8, ..SelfAffine::STAND_IN }.map().unwrap()
}

/// Rows of a reference table, without comments and title, split into fields.
#[allow(dead_code, reason = "each test file takes what it needs")]
pub fn rows(table: &'static str) -> Vec<Vec<&'static str>> {
    let data = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    data.map(|line| line.split(',').collect()).collect()
}
