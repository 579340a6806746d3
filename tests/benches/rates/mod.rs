//! Rates that more than one benchmark measures.

use std::time::Instant;

use slipgrid_model::springblock::{Scene, Unwatched, simulate};

/// Number of repetitions for the median.
const REPETITIONS: usize = 5;

/// Median of [`REPETITIONS`] numbers.
pub fn median(measure: impl FnMut() -> f64) -> f64 {
    let mut found: Vec<f64> = std::iter::repeat_with(measure).take(REPETITIONS).collect();
    found.sort_by(f64::total_cmp);
    found[REPETITIONS / 2]
}

/// Seconds and site updates of one run over `travel_m`.
fn run(scene: &Scene, travel_m: f64) -> (f64, f64) {
    let mut scene = scene.clone();
    scene.run.sliding_m = travel_m;
    let start = Instant::now();
    let simulation = simulate(&scene, &Unwatched).expect("a valid scene");
    let seconds = start.elapsed().as_secs_f64();
    let surfaces = simulation.loads.iter().flat_map(|load| [Some(&load.surface), load.flat.as_ref()]).flatten();
    let updates: u64 = surfaces.filter_map(|surface| surface.cost.map(|cost| cost.site_updates)).sum();
    (seconds, updates as f64)
}

/// Median of the site updates per second between a travel and three times that travel, so that the setup does not count.
pub fn site_updates_per_second(scene: &Scene, travel_m: f64) -> f64 {
    median(|| {
        let ((short_s, few), (long_s, many)) = (run(scene, travel_m), run(scene, 3.0 * travel_m));
        (many - few) / (long_s - short_s)
    })
}
