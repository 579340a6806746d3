//! The fast time integration compared with that of the paper: Runge-Kutta of order 4, 1 ns, exact springs.

use slipgrid_model::springblock::{Extent, Fidelity, Layer, LoadOutcome, Scene, Unwatched, simulate};
use slipgrid_tests::{Quoted, polymer_scene};

/// Friction and, for a patterned sample, the ratio, each with its standard error.
fn values(load: &LoadOutcome) -> Vec<(f64, f64)> {
    let surface = &load.surface;
    let friction = (surface.mu_dynamic.unwrap(), surface.mu_dynamic_stderr.unwrap());
    std::iter::once(friction).chain(load.ratio().map(|ratio| (ratio, load.ratio_stderr.unwrap()))).collect()
}

/// Compares both fidelities on `scene`; returns their values and their site updates.
fn compare(mut scene: Scene) -> ([Vec<(f64, f64)>; 2], [u64; 2]) {
    let outcomes = [Fidelity::Dynamic, Fidelity::Reference].map(|fidelity| {
        scene.run.fidelity = fidelity;
        simulate(&scene, &Unwatched).unwrap().loads.remove(0)
    });
    let found = outcomes.each_ref().map(values);
    println!("dynamic {:?}, reference {:?}", found[0], found[1]);
    let [(mu, error), (reference_mu, reference_error)] = [found[0][0], found[1][0]];
    assert!(error <= 1e-3 * mu && reference_error <= 1e-3 * mu, "{error} {reference_error}");
    // 0.3 % plus twice the standard errors
    let allowed = 3e-3 * reference_mu + 2.0 * error.hypot(reference_error);
    assert!((mu - reference_mu).abs() <= allowed, "{mu} {reference_mu}");
    (found, outcomes.map(|load| load.surface.cost.unwrap().site_updates))
}

/// Formats numbers with four decimals, as in the book.
fn told(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.4}")).collect::<Vec<_>>().join(", ")
}

/// Compares both fidelities on a flat strip 50 um thick; returns friction by each.
fn compare_strips(length_m: f64) -> [f64; 2] {
    let mut scene = polymer_scene(None, &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.layer = Layer { length_m, height_m: 50e-6, block_m: 10e-6, thickness_m: None, holder: None };
    scene.run.sliding_m = 0.3e-6;
    let ([dynamic, reference], [fast, slow]) = compare(scene);
    // Force evaluations alone: 6 ns with one a step against 1 ns with four.
    assert!(slow > 22 * fast, "{fast} {slow}");
    [dynamic[0].0, reference[0].0]
}

#[test]
fn a_short_thin_flat_strip_slides_alike() {
    compare_strips(500e-6);
}

#[test]
#[ignore = "twenty seconds: the strip of the book, four times as long"]
fn a_thin_flat_strip_slides_alike() {
    let [dynamic, reference] = compare_strips(2000e-6);
    let mut quoted = Quoted::new("verification").unwrap();
    quoted.sentence(&format!("{dynamic:.4} against {reference:.4} (standard errors 0.0001)"));
    assert_eq!(quoted.differences().unwrap(), "");
}

#[test]
#[ignore = "three minutes: a patterned sample of full height"]
fn a_patterned_sample_of_full_height_slides_alike() {
    let pattern = slipgrid_tests::published_groove().unwrap();
    let mut scene = polymer_scene(Some(pattern), &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.layer = Layer { length_m: 1500e-6, ..scene.layer };
    scene.run.warm_start = true;
    scene.run.sliding_m = 0.6e-6;
    let ([dynamic, reference], _) = compare(scene);
    let mut quoted = Quoted::new("verification").unwrap();
    let [own, other] = [&dynamic, &reference].map(|found| told(&[found[0].0, found[1].0]));
    let errors = told(&[dynamic[0].1, dynamic[1].1]);
    quoted.sentence(&format!("| {own} against {other} (standard errors {errors})"));
    assert_eq!(quoted.differences().unwrap(), "");
}

#[test]
#[ignore = "ten minutes: the paper's integration on the whole sample"]
fn the_whole_patterned_sample_slides_alike() {
    let pattern = slipgrid_tests::published_groove().unwrap();
    let mut scene = polymer_scene(Some(pattern), &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.run.sliding_m = 1e-6;
    let ([dynamic, reference], _) = compare(scene);
    let mut quoted = Quoted::new("verification").unwrap();
    let with_errors = |found: &[(f64, f64)]| -> String {
        found.iter().map(|(value, error)| format!("{value:.5} ± {error:.5}")).collect::<Vec<_>>().join(", ")
    };
    quoted.sentence(&format!("| {} against {}", with_errors(&dynamic), with_errors(&reference)));
    assert_eq!(quoted.differences().unwrap(), "");
}
