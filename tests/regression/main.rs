//! Comparison with recorded results of earlier versions, and reproducibility.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

use slipgrid_model::springblock::{Extent, Fidelity, Layer, Unwatched, simulate};
use slipgrid_tests::{polymer_scene, published_groove};

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    for fidelity in [Fidelity::Steady, Fidelity::Dynamic] {
        let mut scene =
            polymer_scene(Some(published_groove().unwrap()), &[0.65, 2.6], fidelity, Extent::Sample).unwrap();
        scene.layer = Layer { length_m: 1000e-6, height_m: 100e-6, block_m: 10e-6, thickness_m: None, holder: None };
        scene.run.sliding_m = 0.2e-6;
        let [one, two] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| simulate(&scene, &Unwatched)).unwrap()
        });
        assert_eq!(one, two);
    }
}

#[test]
fn the_published_pattern_keeps_its_steady_ratio() {
    // Recorded with version 0.1.0; E* h'rms = 4 MPa, Persson's area law.
    let scene =
        polymer_scene(Some(published_groove().unwrap()), &[0.65, 1.3, 1.95, 2.6], Fidelity::Steady, Extent::Cell)
            .unwrap();
    let recorded = [0.979926, 0.927539, 0.873411, 0.826327];
    for (load, recorded) in simulate(&scene, &Unwatched).unwrap().loads.iter().zip(recorded) {
        assert!((load.ratio().unwrap() - recorded).abs() < 1e-6, "{:?}", load.ratio());
    }
}
