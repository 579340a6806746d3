//! Properties that hold on every surface.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{MODULUS_PA, full_contact_pa, self_affine, solve};
use slipgrid_surface::contact::{ContactError, Monitor, RoughContact, SolveOptions, Unwatched, area_curve};
use slipgrid_surface::topography::{Crop, HeightMap, MapError, SelfAffine};

/// A rough map with non-square pixels whose size is not a power of two.
fn uneven() -> HeightMap {
    let map = SelfAffine { pixels: 128, max_wave: 16, ..SelfAffine::STAND_IN }.map().unwrap();
    let (rows, cols) = (90, 77);
    let part = map.windowed(Some(Crop { first_row: 0, first_col: 0, rows, cols }), None).unwrap();
    HeightMap::new(rows, cols, 8e-6, 11e-6, part.heights_m().to_vec()).unwrap()
}

#[test]
fn turning_the_map_turns_nothing_else() {
    let map = uneven();
    let (rows, cols) = (map.rows(), map.cols());
    let heights = (0..rows * cols).map(|n| map.heights_m()[n % rows * cols + n / rows]).collect();
    let turned = HeightMap::new(cols, rows, map.dy_m(), map.dx_m(), heights).unwrap();
    let (a, b) = (solve(&map, 2e6), solve(&turned, 2e6));
    assert_eq!(a.area, b.area);
    assert_eq!(a.convergence.iterations, b.convergence.iterations);
}

#[test]
fn height_scales_like_inverse_pressure() {
    // A(P; s h) = A(P/s; h), and likewise for E*: in normalized units all three problems are identical. Powers of two
    // keep the rounding the same, so that the states agree to the last bit.
    let map = self_affine(128);
    let reference = solve(&map, 1e6);
    let higher = solve(&map.scaled(4.0).unwrap(), 4e6);
    assert_eq!(reference.area, higher.area);
    assert!(reference.pressure_pa.iter().zip(&higher.pressure_pa).all(|(a, b)| 4.0 * a == *b));
    let stiffer = RoughContact::new(&map, 8.0 * MODULUS_PA, &Unwatched).unwrap();
    assert_eq!(stiffer.solve(8e6, &SolveOptions::default(), &Unwatched).unwrap().area, reference.area);
    let other = solve(&map.scaled(3.7).unwrap(), 3.7e6);
    assert!((other.area.fraction - reference.area.fraction).abs() < 1e-12);
}

#[test]
fn from_full_contact_pressure_on_all_is_in_contact() {
    let map = self_affine(64);
    let full_pa = full_contact_pa(&map);
    let at = |pressure_pa| solve(&map, pressure_pa);
    for pressure_pa in [full_pa, 1.5 * full_pa, 1e15] {
        let state = at(pressure_pa);
        assert_eq!((state.area.fraction, state.area.fraction_corrected), (1.0, 1.0));
        let mean = state.pressure_pa.iter().sum::<f64>() / state.pressure_pa.len() as f64;
        assert!((mean / pressure_pa - 1.0).abs() < 1e-12);
        assert!(state.gap_m.iter().all(|&g| g == 0.0));
    }
    // Just below p* the solver finds the state that is known just above p*.
    let below = at(full_pa * (1.0 - 1e-9));
    assert!(below.area.fraction >= 1.0 - 2.0 / 4096.0, "{:?}", below.area);
    let above = at(full_pa * (1.0 + 1e-9));
    for (a, b) in below.pressure_pa.iter().zip(&above.pressure_pa) {
        assert!((a - b).abs() < 1e-6 * full_pa);
    }
}

/// The solve starts with the pressures that flatten the surface, without the negative ones: few at 0.9 p*.
#[test]
fn near_full_contact_few_iterations_are_left() {
    let map = self_affine(128);
    let iterations = |share: f64| solve(&map, share * full_contact_pa(&map)).convergence.iterations;
    let [middle, near, nearer] = [0.3, 0.9, 0.999].map(iterations);
    assert!(nearer < 7 && 2 * nearer <= near && near < middle && near < 14 && middle < 17, "{middle} {near} {nearer}");
}

#[test]
fn the_lightest_load_rests_on_the_highest_point() {
    let map = self_affine(64);
    let highest = map.heights_m().iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for pressure_pa in [1e-3, 1e-30, f64::MIN_POSITIVE] {
        let state = solve(&map, pressure_pa);
        assert_eq!(state.area.fraction, 1.0 / 4096.0);
        let loaded = state.pressure_pa.iter().position(|&p| p > 0.0).unwrap();
        assert_eq!(map.heights_m()[loaded], highest);
    }
}

/// Single high pixels carry high pressures. Scaling the pressures would take from them the load that other points
/// release.
#[test]
fn single_high_pixels_do_not_keep_the_rest_from_settling() {
    let pixels = 256;
    let noise = |n: usize| ((n * n * 7919 + 13 * n) % 1009) as f64 / 1009.0 - 0.5;
    let spike = |n: usize| if n % 4099 == 7 { 5e-6 } else { 0.0 };
    let heights = (0..pixels * pixels).map(|n| 7e-8 * noise(n) + spike(n)).collect();
    let map = HeightMap::new(pixels, pixels, 2e-6, 2e-6, heights).unwrap();
    for pressure_pa in [0.1e6, 0.3e6, 0.7e6, 1e6, 1.6e6] {
        let convergence = solve(&map, pressure_pa).convergence;
        assert!(convergence.iterations < 200, "{pressure_pa} Pa: {convergence:?}");
    }
}

/// Steps that set many pressures to zero at once may raise the energy; on white noise they once alternated without end.
#[test]
fn steps_that_overshoot_are_taken_back() {
    let noise = |n: usize| ((n * n * 7919 + 13 * n) % 10_007) as f64 / 10_007.0 - 0.5;
    for (rows, cols, dy_m) in [(128, 128, 1e-6), (96, 160, 1e-6), (128, 64, 4e-6)] {
        let heights = (0..rows * cols).map(|n| 3e-7 * noise(n)).collect();
        let map = HeightMap::new(rows, cols, 1e-6, dy_m, heights).unwrap();
        for share in [0.01, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8] {
            let convergence = solve(&map, share * full_contact_pa(&map)).convergence;
            assert!(convergence.iterations < 60, "{rows} x {cols}, {share} p*: {convergence:?}");
        }
    }
}

/// One pair per iteration, two for the start, and those that remove the rounding error.
#[test]
fn an_iteration_takes_one_pair_of_transforms() {
    let map = self_affine(256);
    for share in [0.01, 0.1, 0.3, 0.7] {
        let found = solve(&map, share * full_contact_pa(&map)).convergence;
        assert!((1..6).contains(&(found.fourier_pairs - found.iterations)), "{share} p*: {found:?}");
    }
}

#[test]
fn no_load_and_no_roughness_are_known_without_iterations() {
    let state = solve(&self_affine(64), 0.0);
    assert_eq!((state.area.fraction, state.convergence.iterations), (0.0, 0));
    assert!(state.gap_m.iter().all(|&g| g >= 0.0) && state.gap_m.contains(&0.0));
    let flat = HeightMap::new(7, 5, 1e-6, 2e-6, vec![3e-6; 35]).unwrap();
    let state = solve(&flat, 1e6);
    assert_eq!((state.area.fraction, state.area.fraction_corrected, state.convergence.iterations), (1.0, 1.0, 0));
    assert!(state.pressure_pa.iter().all(|&p| p == 1e6));
    assert_eq!(solve(&flat, 0.0).area.fraction, 0.0);
}

#[test]
fn absurd_input_is_refused_or_solved_but_never_breaks() {
    let map = self_affine(64);
    let contact = RoughContact::new(&map, MODULUS_PA, &Unwatched).unwrap();
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
        let refused = contact.solve(bad, &SolveOptions::default(), &Unwatched).unwrap_err().to_string();
        assert!(refused.contains("expected a pressure from 0"), "{refused}");
        assert!(RoughContact::new(&map, bad, &Unwatched).is_err());
    }
    for tolerance in [0.0, f64::NAN, 2.0] {
        let options = SolveOptions { tolerance, ..SolveOptions::default() };
        assert!(contact.solve(1e6, &options, &Unwatched).unwrap_err().to_string().contains("tolerance"));
    }
    let mut heights = map.heights_m().to_vec();
    heights[17] = f64::NAN;
    let holed = HeightMap::new(64, 64, 1e-6, 1e-6, heights).unwrap();
    let refused = RoughContact::new(&holed, MODULUS_PA, &Unwatched).unwrap_err().to_string();
    assert!(refused.contains("1 of 4096 heights are missing"), "{refused}");
    assert!(area_curve(&map, MODULUS_PA, &[], &SolveOptions::default(), &Unwatched).unwrap().points.is_empty());
    // Tiny, huge and spiky heights, and the smallest possible map.
    for scale in [1e-200, 1e-20, 1e6] {
        let state = solve(&map.scaled(scale).unwrap(), 1e6);
        assert!((0.0..=1.0).contains(&state.area.fraction));
        assert!(state.pressure_pa.iter().chain(&state.gap_m).all(|value| value.is_finite()));
    }
    let spike = (0..64).map(|n| if n == 9 { 1.0 } else { 0.0 }).collect();
    let state = solve(&HeightMap::new(8, 8, 1e-6, 1e-6, spike).unwrap(), 1e6);
    assert_eq!(state.area.fraction, 1.0 / 64.0);
    let small = HeightMap::new(2, 2, 1e-6, 1e-6, vec![0.0, 1e-6, 0.0, 0.0]).unwrap();
    assert_eq!(solve(&small, 1e3).area.fraction, 0.25);
}

#[test]
fn what_does_not_converge_is_refused() {
    let map = self_affine(128);
    let contact = RoughContact::new(&map, MODULUS_PA, &Unwatched).unwrap();
    let with = |max_iterations, tolerance| {
        let options = SolveOptions { max_iterations, tolerance };
        let curve = area_curve(&map, MODULUS_PA, &[0.5e6, 1e6], &options, &Unwatched)
            .map(|curve| curve.points[1].area_fraction);
        let solved = contact.solve(1e6, &options, &Unwatched).map(|state| state.area.fraction);
        (solved, curve)
    };
    let (exact, of_curve) = with(2000, 1e-8);
    assert_eq!(exact, of_curve);
    for limit in [0, 1, 3, 12] {
        let (solved, curve) = with(limit, 1e-8);
        let refused = solved.unwrap_err();
        assert!(matches!(refused, ContactError::NotConverged { iterations, .. } if iterations == limit), "{refused:?}");
        assert!(refused.to_string().starts_with("contact at 1 MPa did not converge: residual"), "{refused}");
        assert!(curve.unwrap_err().to_string().starts_with("contact at 0.5 MPa did not converge"));
    }
    // A tolerance below rounding is either met or refused.
    match with(2000, 1e-15).0 {
        Err(ContactError::NotConverged { residual, .. }) => assert!(residual > 1e-15 && residual < 1e-10, "{residual}"),
        found => assert_eq!(found, exact),
    }
}

struct Watch {
    solved: AtomicUsize,
    polls_left: AtomicUsize,
}

impl Monitor for Watch {
    fn advance(&self, _share: f64) {
        self.solved.fetch_add(1, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.polls_left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

#[test]
fn the_monitor_hears_of_each_pressure_and_can_stop() {
    let map = self_affine(64);
    let watch = |polls| Watch { solved: AtomicUsize::new(0), polls_left: AtomicUsize::new(polls) };
    let patient = watch(usize::MAX);
    area_curve(&map, MODULUS_PA, &[1e6, 2e6, 3e6], &SolveOptions::default(), &patient).unwrap();
    assert_eq!(patient.solved.into_inner(), 3);
    let one = watch(usize::MAX);
    area_curve(&map, MODULUS_PA, &[1e6], &SolveOptions::default(), &one).unwrap();
    let asked = usize::MAX - one.polls_left.into_inner();
    for polls in [1, asked / 4, asked / 2, asked - 1] {
        let stopped = area_curve(&map, MODULUS_PA, &[1e6], &SolveOptions::default(), &watch(polls));
        assert_eq!(stopped, Err(ContactError::Map(MapError::Cancelled)), "{polls} of {asked}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let map = self_affine(64);
    let pressures_pa = [0.2e6, 1e6, 3e6, 0.5e6, 2e6];
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| area_curve(&map, MODULUS_PA, &pressures_pa, &SolveOptions::default(), &Unwatched).unwrap())
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
    for (point, &pressure_pa) in one.points.iter().zip(&pressures_pa) {
        assert_eq!(point.pressure_pa, pressure_pa);
        assert_eq!(point.area_fraction, solve(&map, pressure_pa).area.fraction);
    }
}
