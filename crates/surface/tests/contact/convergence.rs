//! Observed order of convergence on shapes with closed-form pressures.

use std::f64::consts::TAU;

use crate::closed_form::{Hertz, Wave, crossed_waves_full_contact_pa};
use crate::common::{MODULUS_PA, RADIUS_M, SIDE_M, crossed_waves, paraboloid, solve};
use slipgrid_surface::contact::{RoughContact, SolveOptions, Unwatched};
use slipgrid_surface::topography::HeightMap;

// Pressure falls to zero as the square root of the distance from the edge of the contact. The pixels along the edge, a
// share h of all, have errors of order sqrt(h), so the L2 error is of order h. The position of the edge within a pixel
// makes single errors scatter, hence the rms over several loads.

fn pressure_pa(map: &HeightMap, nominal_pa: f64) -> Vec<f64> {
    let options = SolveOptions { tolerance: 1e-7, ..SolveOptions::default() };
    RoughContact::new(map, MODULUS_PA, &Unwatched).unwrap().solve(nominal_pa, &options, &Unwatched).unwrap().pressure_pa
}

fn relative_distance(found: impl Iterator<Item = f64>, expected: impl Iterator<Item = f64>) -> f64 {
    let (mut distance, mut norm) = (0.0, 0.0);
    for (found, expected) in found.zip(expected) {
        distance += (found - expected).powi(2);
        norm += expected * expected;
    }
    (distance / norm).sqrt()
}

fn rms(errors: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = errors.len() as f64;
    (errors.map(|error| error * error).sum::<f64>() / count).sqrt()
}

#[test]
fn validation_pressure_under_a_sphere_converges_at_order_one() {
    // Contact radii of 4 to 7 % of the period: neighbours a period away change the pressure by less than 1e-3.
    let error = |n: usize| {
        let map = paraboloid(n);
        rms((0..8).map(|load| {
            let contact_radius_m = SIDE_M * (0.04 + 0.03 * f64::from(load) / 7.0);
            // F = 4 E* a^3 / (3 R)
            let load_n = 4.0 * MODULUS_PA * contact_radius_m.powi(3) / (3.0 * RADIUS_M);
            let hertz = Hertz::new(RADIUS_M, load_n, MODULUS_PA);
            let expected = (0..n * n).map(|k| {
                let at = |i: usize| (i as f64 / n as f64 - 0.5) * SIDE_M;
                hertz.pressure_pa(at(k / n).hypot(at(k % n)))
            });
            relative_distance(pressure_pa(&map, load_n / (SIDE_M * SIDE_M)).into_iter(), expected)
        }))
    };
    let (coarse, fine) = (error(64), error(256));
    let order = (coarse / fine).log2() / 2.0;
    assert!((0.85..1.15).contains(&order), "order {order}: {coarse}, {fine}");
    assert!(fine < 0.04, "{fine}");
}

#[test]
fn validation_pressure_under_a_wave_converges_at_order_one() {
    // The slope of the pressure is singular at the edge of the contact, so that the grid allows order one at most.
    let exact = Wave::new(1e-6, SIDE_M, MODULUS_PA);
    let error = |n: usize| {
        let heights = (0..n * 2).map(|k| 1e-6 * (TAU * (k / 2) as f64 / n as f64).cos()).collect();
        let pixel_m = SIDE_M / n as f64;
        let map = HeightMap::new(n, 2, pixel_m, pixel_m, heights).unwrap();
        rms((0..60).map(|load| {
            let nominal_pa = (0.05 + 0.9 * (f64::from(load) + 0.5) / 60.0) * exact.full_contact_pressure_pa;
            let found = solve(&map, nominal_pa).pressure_pa.into_iter().step_by(2);
            relative_distance(found, (0..n).map(|i| exact.pressure_pa(nominal_pa, i as f64 * pixel_m)))
        }))
    };
    let (coarse, fine) = (error(64), error(1024));
    let order = (coarse / fine).ln() / 16f64.ln();
    assert!((0.9..1.1).contains(&order), "{order}");
    // The rms error is about 0.55 / n.
    assert!(fine < 0.65 / 1024.0, "{fine}");
}

#[test]
fn pressure_under_crossed_waves_converges_at_order_one() {
    let full_pa = crossed_waves_full_contact_pa(1e-6, SIDE_M, MODULUS_PA);
    // At intermediate loads there is no closed form: each grid is compared with the next finer one at common points.
    let difference = |n: usize| {
        rms((0..10).map(|load| {
            let nominal_pa = full_pa * (0.05 + 0.085 * f64::from(load));
            let coarse = pressure_pa(&crossed_waves(n), nominal_pa);
            let fine = pressure_pa(&crossed_waves(2 * n), nominal_pa);
            let shared = (0..n * n).map(|k| fine[2 * (k / n) * 2 * n + 2 * (k % n)]);
            relative_distance(coarse.into_iter(), shared)
        }))
    };
    let (coarse, fine) = (difference(24), difference(96));
    let order = (coarse / fine).log2() / 2.0;
    assert!((0.85..1.15).contains(&order), "order {order}: {coarse}, {fine}");
}
