//! How well windows of a map represent the whole map.

use crate::common::{MODULUS_PA, self_affine};
use slipgrid_base::statistics::mean_and_std;
use slipgrid_surface::contact::{SolveOptions, Unwatched, area_curve, coarser, windows};
use slipgrid_surface::topography::{HeightMap, SelfAffine};

/// A(P)/A(P0) P0/P with P = 2.6 MPa and P0 = 0.7 MPa.
fn factor(map: &HeightMap) -> f64 {
    let options = SolveOptions { tolerance: 1e-5, ..SolveOptions::default() };
    let points = area_curve(map, MODULUS_PA, &[0.7e6, 2.6e6], &options, &Unwatched).unwrap().points;
    points[1].area_fraction_corrected / points[0].area_fraction_corrected * 0.7 / 2.6
}

fn mean_and_spread(maps: &[HeightMap]) -> (f64, f64) {
    let factors: Vec<f64> = maps.iter().map(factor).collect();
    mean_and_std(factors).map(|(mean, std)| (mean, std.unwrap())).unwrap()
}

#[test]
fn windows_without_a_period_of_their_own_give_the_factor_of_the_period() {
    // Quarters of one period, cut out and made periodic: the factor of their mean differs by 0.001 from that of the
    // whole map, and the mean rms slope by 1 %. Without the correction of the steps at their sides the slope is a third
    // too high.
    let map = self_affine(512);
    let quarters = windows(&map, 2, &Unwatched).unwrap();
    let (mean, spread) = mean_and_spread(&quarters);
    assert!((mean - factor(&map)).abs() < 2e-3, "{mean}");
    assert!((1e-3..8e-3).contains(&spread), "{spread}");
    let slope = map.rms_slope_spectral(&Unwatched).unwrap();
    for quarter in &quarters {
        assert!((quarter.rms_slope_spectral(&Unwatched).unwrap() / slope - 1.0).abs() < 0.05);
    }
}

#[test]
fn the_spread_of_windows_tells_the_standard_error_of_the_map() {
    // Sixteen maps of 128 x 128 points cut from one large surface. Their spread is the true standard error of one map;
    // each map alone must estimate it from its own four windows.
    let surface = SelfAffine { pixels: 512, min_wave: 16, max_wave: 64, ..SelfAffine::STAND_IN }.map().unwrap();
    let maps = windows(&surface, 4, &Unwatched).unwrap();
    let (_, true_error) = mean_and_spread(&maps);
    let told = maps.iter().map(|map| (mean_and_spread(&windows(map, 2, &Unwatched).unwrap()).1 / 2.0).powi(2));
    let told = (told.sum::<f64>() / 16.0).sqrt();
    assert!((0.6..1.7).contains(&(told / true_error)), "told {told}, true {true_error}");
}

#[test]
fn coarser_pixels_lower_slope_and_factor() {
    let map = self_affine(256);
    let blunt = coarser(&map, 4).unwrap();
    let slope = |map: &HeightMap| map.rms_slope_spectral(&Unwatched).unwrap();
    assert!(slope(&blunt) < slope(&map) && factor(&blunt) < factor(&map));
    assert_eq!(factor(&coarser(&map, 1).unwrap()), factor(&map));
}
