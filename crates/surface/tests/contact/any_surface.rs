//! Surfaces of any size, pixel shape and kind.

use crate::common::surfaces::{KINDS, Surface, random};
use crate::common::{MODULUS_PA, full_contact_pa, rows, solve};
use slipgrid_surface::topography::HeightMap;
use slipgrid_surface::topography::fourier::Fourier;

const ANY_SURFACE: &str = include_str!("reference/any_surface.csv");

/// Compares area fractions with the table, on surfaces whose number of points satisfies `wanted`.
fn compare_with_table(wanted: impl Fn(usize) -> bool) {
    let mut compared = 0;
    for row in rows(ANY_SURFACE) {
        let whole = |field: usize| row[field].parse::<usize>().unwrap();
        let surface = Surface {
            kind: row[0],
            rows: whole(1),
            cols: whole(2),
            aspect: row[3].parse().unwrap(),
            seed: row[4].parse().unwrap(),
        };
        let points = surface.rows * surface.cols;
        if wanted(points) {
            let state = solve(&surface.map(), row[5].parse::<f64>().unwrap() * 1e6);
            let pixels = (state.area.fraction * points as f64).round() as usize;
            assert_eq!(pixels, whole(6), "{row:?}");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn validation_small_surfaces_touch_as_by_other_codes() {
    compare_with_table(|points| points < 20_000);
}

#[test]
#[ignore = "minutes"]
fn validation_surfaces_of_any_size_touch_as_by_other_codes() {
    compare_with_table(|_| true);
}

/// Asserts the conditions of contact; the minimum of this convex problem is unique.
fn assert_contact(map: &HeightMap, pressure_pa: f64, name: &str) {
    let state = solve(map, pressure_pa);
    let points = state.pressure_pa.len() as f64;
    assert!(state.pressure_pa.iter().all(|&p| p >= 0.0) && state.gap_m.iter().all(|&g| g >= 0.0), "{name}");
    let mean_pa = state.pressure_pa.iter().sum::<f64>() / points;
    assert!((mean_pa / pressure_pa - 1.0).abs() < 1e-12, "{name}: {mean_pa} of {pressure_pa} Pa");
    let work: f64 = state.pressure_pa.iter().zip(&state.gap_m).map(|(p, g)| p * g).sum();
    assert!(work <= 1.1e-8 * mean_pa * points * map.sq_m(), "{name}: {work}");
    // g = u - h + const, u_q = 2/(E* q) p_q
    let fourier = Fourier::new(map.rows(), map.cols());
    let compliance = fourier.multiplier(map.dx_m(), map.dy_m(), 0.0, |q| 2.0 / (MODULUS_PA * q));
    let mut displacement_m = vec![0.0; state.pressure_pa.len()];
    fourier.filter(&state.pressure_pa, &compliance, &mut displacement_m, &mut fourier.work());
    let offset_m = |n: usize| displacement_m[n] - map.heights_m()[n] - state.gap_m[n];
    let height_m = map.heights_m().iter().fold(map.sq_m(), |highest, h| highest.max(h.abs()));
    for n in 0..displacement_m.len() {
        let off_m = offset_m(n) - offset_m(0);
        assert!(off_m.abs() < 1e-9 * height_m, "{name}: {off_m} at point {n}");
    }
}

#[test]
fn random_surfaces_of_any_size_end_in_contact() {
    for case in 0..60_u64 {
        let uniform = |n: u64| random(case + 1, n) as f64 / 2f64.powi(64);
        // Sizes with every remainder modulo 4, below and above the length from which two grids are used.
        let side = |n: u64| (4.0 * 30f64.powf(uniform(n))) as usize;
        let aspect = [1.0, 1.0, 1.5, 4.0, 8.0, 0.25, 0.125, 0.05][(8.0 * uniform(2)) as usize];
        let kind = KINDS[case as usize % KINDS.len()];
        let surface = Surface { kind, rows: side(0), cols: side(1), aspect, seed: case };
        let map = surface.map();
        if map.sq_m() > 0.0 {
            let share = 10f64.powf(-4.0 * uniform(3).powi(2));
            assert_contact(&map, share * full_contact_pa(&map), &format!("{surface:?} at {share} p*"));
        }
    }
}

/// Stepped heights, spikes and scratches on small oblong maps: conjugate gradients alone cycle or stall on them.
#[test]
fn degenerate_surfaces_end_in_contact() {
    let changed = |surface: Surface, change: &dyn Fn(usize, f64) -> f64| {
        let map = surface.map();
        let heights = map.heights_m().iter().enumerate().map(|(n, &h)| change(n, h)).collect();
        HeightMap::new(map.rows(), map.cols(), map.dx_m(), map.dy_m(), heights).unwrap()
    };
    let plateau = Surface { kind: "plateau", rows: 87, cols: 118, aspect: 0.5, seed: 781 };
    let scratched = Surface { kind: "white", rows: 53, cols: 14, aspect: 0.05, seed: 137 };
    let tiny = Surface { kind: "pits", rows: 2, cols: 15, aspect: 1.0, seed: 225 };
    let maps = [
        ("steps of 66 nm", changed(plateau, &|_, h| (h / 6.6e-8).round() * 6.6e-8)),
        ("steps of 250 nm", changed(plateau, &|_, h| (h / 2.5e-7).round() * 2.5e-7)),
        ("spikes", changed(plateau, &|n, h| if n % 997 == 5 { h + 1e-8 } else { h })),
        ("scratches", changed(scratched, &|n, h| if n / 14 % 7 == 0 { h - 1.2e-7 } else { h })),
        ("few points", tiny.map()),
        ("one spike", changed(tiny, &|n, h| if n == 9 { h + 3e-9 } else { h })),
    ];
    for (name, map) in &maps {
        let full_pa = full_contact_pa(map);
        for share in [1e-4, 6e-4, 1e-2, 0.3, 0.9] {
            assert_contact(map, share * full_pa, &format!("{name} at {share} p*"));
        }
    }
}
