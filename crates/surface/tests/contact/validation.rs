//! Validation against independent results: closed forms, and tables computed with Tamaas.

use crate::closed_form::{Wave, crossed_waves_full_contact_pa};
use crate::common::{MODULUS_PA, SIDE_M, crossed_waves, paraboloid, rows, self_affine, solve, wave};
use slipgrid_surface::contact::closed_form::persson_area_fraction;
use slipgrid_surface::contact::{ContactState, SolveOptions, Unwatched, area_curve};

const AREA_CURVES: &str = include_str!("reference/area_curves.csv");
const SMOOTH_SHAPES: &str = include_str!("reference/smooth_shapes.csv");

fn peak_pa(state: &ContactState) -> f64 {
    state.pressure_pa.iter().copied().fold(0.0, f64::max)
}

/// Tables give areas to six digits: half a unit of the last digit, plus rounding in the comparison.
const SIX_DIGITS: f64 = 5.1e-7;

fn compare_area_curve(surface: &str, pixels: usize, most_iterations: usize, wanted_mpa: impl Fn(f64) -> bool) {
    let number = |field: &str| field.parse::<f64>().unwrap();
    let table: Vec<_> = rows(AREA_CURVES)
        .into_iter()
        .filter(|row| row[0] == surface && wanted_mpa(number(row[1])))
        .map(|row| [number(row[1]), number(row[2]), number(row[3])])
        .collect();
    let pressures_pa: Vec<f64> = table.iter().map(|row| row[0] * 1e6).collect();
    let map = self_affine(pixels);
    let curve = area_curve(&map, MODULUS_PA, &pressures_pa, &SolveOptions::default(), &Unwatched).unwrap();
    let mut iterations = 0;
    for (point, [mpa, area, corrected]) in curve.points.iter().zip(&table) {
        assert!((point.area_fraction - area).abs() < SIX_DIGITS, "{mpa} MPa: {}", point.area_fraction);
        assert!((point.area_fraction_corrected - corrected).abs() < SIX_DIGITS, "{mpa} MPa");
        iterations += point.convergence.iterations;
    }
    assert!(iterations <= most_iterations, "{iterations} iterations");
}

#[test]
fn validation_area_curve_of_a_256_map() {
    // The reference implementation took 285 iterations.
    compare_area_curve("A_256", 256, 300, |_| true);
}

#[test]
fn validation_area_curve_of_a_512_map() {
    // 376 iterations were needed for all 12 pressures.
    compare_area_curve("A_512", 512, 130, |mpa| [0.1, 0.7, 2.6, 5.0].contains(&mpa));
}

#[test]
fn validation_smooth_shapes() {
    for row in rows(SMOOTH_SHAPES) {
        let n: usize = row[1].parse().unwrap();
        let number = |field: usize| row[field].parse::<f64>().unwrap();
        let (map, pressure_pa) = match row[0] {
            "hertz_periodic" => (paraboloid(n), number(2) / (SIDE_M * SIDE_M)),
            "wave1" => (wave(n), number(2) * Wave::new(1e-6, SIDE_M, MODULUS_PA).full_contact_pressure_pa),
            _ => (crossed_waves(n), number(2) * crossed_waves_full_contact_pa(1e-6, SIDE_M, MODULUS_PA)),
        };
        let state = solve(&map, pressure_pa);
        assert!((state.area.fraction / number(3) - 1.0).abs() < 1e-5, "{row:?}: {:?}", state.area);
        assert!((state.area.fraction_corrected / number(4) - 1.0).abs() < 1e-5, "{row:?}: {:?}", state.area);
        assert!((peak_pa(&state) / number(5) - 1.0).abs() < 1e-5, "{row:?}: {}", peak_pa(&state));
    }
}

#[test]
fn validation_light_loads_lie_between_persson_and_bush() {
    let (map, pressure_pa) = (self_affine(256), 0.1e6);
    let slope = map.rms_slope_spectral(&Unwatched).unwrap();
    let kappa = solve(&map, pressure_pa).area.fraction_corrected * MODULUS_PA * slope / pressure_pa;
    // sqrt(8/pi) by Persson, sqrt(2 pi) by Bush, Gibson and Thomas; numerical results are 2.1 to 2.3.
    assert!((2.1..2.3).contains(&kappa), "{kappa}");
    let persson = persson_area_fraction(pressure_pa, MODULUS_PA, slope).unwrap() * MODULUS_PA * slope / pressure_pa;
    assert!(persson < kappa);
}
