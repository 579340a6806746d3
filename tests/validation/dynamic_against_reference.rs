//! The fast time integration against the paper's: Runge-Kutta of order 4, 1 ns, exact springs.

use slipgrid_springblock::{Extent, Fidelity, Layer, Scene, SurfaceOutcome, Unwatched, simulate};
use slipgrid_tests::polymer_scene;

fn run(scene: &Scene) -> SurfaceOutcome {
    let load = simulate(scene, &Unwatched).unwrap().loads.remove(0);
    if let Some(ratio) = load.ratio {
        println!("{}: ratio {ratio} +- {}", scene.run.fidelity.name(), load.ratio_stderr.unwrap());
    }
    load.surface
}

/// Compares both fidelities on `scene` and returns the work of each in spring-force evaluations.
fn compare(mut scene: Scene) -> [u64; 2] {
    let outcomes = [Fidelity::Dynamic, Fidelity::Reference].map(|fidelity| {
        scene.run.fidelity = fidelity;
        run(&scene)
    });
    let [dynamic, reference] = &outcomes;
    let value = |outcome: &SurfaceOutcome| (outcome.mu_dynamic.unwrap(), outcome.mu_dynamic_stderr.unwrap());
    let ((mu, error), (reference_mu, reference_error)) = (value(dynamic), value(reference));
    println!("dynamic {mu} +- {error}, reference {reference_mu} +- {reference_error}");
    assert!(error <= 1e-3 * mu && reference_error <= 1e-3 * mu, "{error} {reference_error}");
    // 0.3 % plus twice the standard errors
    let allowed = 3e-3 * reference_mu + 2.0 * error.hypot(reference_error);
    assert!((mu - reference_mu).abs() <= allowed, "{mu} {reference_mu}");
    outcomes.each_ref().map(|outcome| outcome.cost.unwrap().site_updates)
}

#[test]
fn a_thin_flat_strip_slides_alike() {
    let mut scene = polymer_scene(None, &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.layer = Layer { length_m: 2000e-6, height_m: 50e-6, block_m: 10e-6, thickness_m: None };
    scene.run.sliding_m = 0.3e-6;
    let [fast, slow] = compare(scene);
    // Force evaluations alone: 6 ns with one a step against 1 ns with four.
    assert!(slow > 22 * fast, "{fast} {slow}");
}

#[test]
#[ignore = "three minutes: a patterned sample of full height"]
fn a_patterned_sample_of_full_height_slides_alike() {
    let pattern = slipgrid_tests::published_groove().unwrap();
    let mut scene = polymer_scene(Some(pattern), &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.layer = Layer { length_m: 1500e-6, ..scene.layer };
    scene.run.warm_start = true;
    scene.run.sliding_m = 0.6e-6;
    compare(scene);
}

#[test]
#[ignore = "eight minutes: the paper's integration on the whole sample"]
fn the_whole_patterned_sample_slides_alike() {
    let pattern = slipgrid_tests::published_groove().unwrap();
    let mut scene = polymer_scene(Some(pattern), &[1.3], Fidelity::Dynamic, Extent::Sample).unwrap();
    scene.run.sliding_m = 1e-6;
    compare(scene);
}
