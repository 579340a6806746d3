//! Surfaces and tables shared by several tests.

pub mod surfaces;

use std::f64::consts::TAU;

use slipgrid_surface::contact::{ContactState, RoughContact, SolveOptions, Unwatched};
use slipgrid_surface::topography::{HeightMap, SelfAffine};

/// E* of E = 0.38 GPa, nu = 1/3, in pascals.
pub const MODULUS_PA: f64 = 427.5e6;
/// Side of all reference maps, in metres.
pub const SIDE_M: f64 = 1e-3;

/// Radius of the paraboloid, in metres.
pub const RADIUS_M: f64 = 0.01;

/// The state of contact of `map`, with the default options.
pub fn solve(map: &HeightMap, pressure_pa: f64) -> ContactState {
    let contact = RoughContact::new(map, MODULUS_PA, &Unwatched).unwrap();
    contact.solve(pressure_pa, &SolveOptions::default(), &Unwatched).unwrap()
}

/// Pressure from which on all of `map` is in contact, in pascals.
pub fn full_contact_pa(map: &HeightMap) -> f64 {
    RoughContact::new(map, MODULUS_PA, &Unwatched).unwrap().full_contact_pressure_pa()
}

/// A square map of the reference side; `height` is a function of x and y from 0 to 1.
pub fn square(n: usize, height: impl Fn(f64, f64) -> f64) -> HeightMap {
    let at = |k: usize| k as f64 / n as f64;
    let heights = (0..n * n).map(|k| height(at(k / n), at(k % n))).collect();
    HeightMap::new(n, n, SIDE_M / n as f64, SIDE_M / n as f64, heights).unwrap()
}

/// A paraboloid of radius 10 mm, its summit in the middle of the map.
pub fn paraboloid(n: usize) -> HeightMap {
    square(n, |x, y| -((x - 0.5).powi(2) + (y - 0.5).powi(2)) * SIDE_M * SIDE_M / (2.0 * RADIUS_M))
}

/// A wave of amplitude 1 um along x.
pub fn wave(n: usize) -> HeightMap {
    square(n, |x, _| 1e-6 * (TAU * x).cos())
}

/// Two crossed waves of amplitude 1 um.
pub fn crossed_waves(n: usize) -> HeightMap {
    square(n, |x, y| 1e-6 * (TAU * x).cos() * (TAU * y).cos())
}

/// The reference map A_n.
pub fn self_affine(n: usize) -> HeightMap {
    SelfAffine { pixels: n, max_wave: n as u32 / 8, ..SelfAffine::STAND_IN }.map().unwrap()
}

/// Rows of a reference table, without comments and title, split into fields.
pub fn rows(table: &'static str) -> Vec<Vec<&'static str>> {
    let data = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    data.map(|line| line.split(',').collect()).collect()
}
