//! Cost and error of the main job's confirming run, by its travel and its draws.

use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{
    Extent, Fidelity, Layer, LoadOutcome, RunOptions, Scene, Unwatched, simulate, warm_travel_m,
};
use slipgrid_tests::{Quoted, polymer_scene};

/// Number of draws of the local coefficients, each in a run of its own.
const DRAWS: u64 = 6;
/// Travel of the reference runs over the planned travel.
const LONG: f64 = 6.0;

/// Scene of the longest strip of the main job's design.
fn scene() -> Scene {
    let pattern = Pattern::new(Planform::Groove, 75.3e-6, 167e-6, 18.2e-6).unwrap();
    let scene = polymer_scene(Some(pattern), &[0.65, 1.3, 1.95, 2.6], Fidelity::Dynamic, Extent::Sample).unwrap();
    let layer = Layer { thickness_m: None, ..scene.layer };
    Scene { layer, run: RunOptions { warm_start: true, dimensions: Some(2), ..scene.run }, ..scene }
}

/// Outcomes of every load with the draw `seed`, after `travel` times the planned travel and until the standard error is
/// reached.
fn run(travel: f64, seed: u64) -> Vec<LoadOutcome> {
    let mut scene = scene();
    let planned_m =
        warm_travel_m((&scene.elastic, scene.area_law.as_ref()), &scene.layer, &scene.loads, scene.speed_m_s);
    scene.run = RunOptions { seed, sliding_m: travel * planned_m, mu_stderr: Some(1e-3), ..scene.run };
    simulate(&scene, &Unwatched).unwrap().loads
}

fn ratios(loads: &[LoadOutcome]) -> Vec<f64> {
    loads.iter().map(|load| load.ratio().unwrap()).collect()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / count).sqrt()
}

/// Cost is given in site updates, which do not depend on the machine; two cores do 2e9 per second.
#[test]
#[ignore = "two minutes on two cores: finds a table of the book, evidence/speed.md"]
fn the_confirming_run_is_as_long_as_its_error_asks_for() {
    let seeds = || 1..=DRAWS;
    let long: Vec<Vec<f64>> = seeds().map(|seed| ratios(&run(LONG, seed))).collect();
    let mean = |place: usize| long.iter().map(|ratios| ratios[place]).sum::<f64>() / DRAWS as f64;
    // One draw in place of many.
    let drawn = root_mean_square(long.iter().flat_map(|own| own.iter().enumerate().map(|(p, ratio)| ratio - mean(p))));
    let mut quoted = Quoted::new("speed").unwrap();
    quoted.sentence(&format!("the ratio of one draw differs by {drawn:.5} from the mean of six"));
    let mut rows = Vec::new();
    for travel in [0.5, 1.0, 2.0, 4.0] {
        let runs: Vec<Vec<LoadOutcome>> = seeds().map(|seed| run(travel, seed)).collect();
        let each = || runs.iter().zip(&long).flat_map(|(loads, long)| loads.iter().zip(long));
        let error = root_mean_square(each().map(|(load, long)| load.ratio().unwrap() - long));
        let stated = root_mean_square(each().map(|(load, _)| load.ratio_stderr.unwrap()));
        let surfaces = each().flat_map(|(load, _)| std::iter::once(&load.surface).chain(&load.flat));
        let updates: u64 = surfaces.map(|surface| surface.cost.unwrap().site_updates).sum();
        let updates = updates as f64 / DRAWS as f64;
        quoted.row(&format!("| {travel} | {updates:.1e} | {error:.5} | {stated:.5} |"));
        rows.push([updates, error, stated]);
    }
    // What is stated holds, and the planned run is off by less than what drawing coefficients once leaves open.
    assert!(rows.iter().all(|[_, error, stated]| error < stated));
    let [half, planned, ..] = rows[..] else { panic!() };
    assert!(planned[1] < 1e-3 && planned[1] < drawn.max(5e-4), "{planned:?} {drawn}");
    assert!(half[0] < planned[0] && half[2] > 0.9 * planned[2]);
    // Flat and patterned surfaces share their draws: with draws of their own the ratio would scatter by so much more.
    let flat: Vec<Vec<f64>> = seeds()
        .map(|seed| run(1.0, seed).iter().map(|load| load.flat.as_ref().unwrap().mu_dynamic.unwrap()).collect())
        .collect();
    let apart = root_mean_square((0..flat.len()).flat_map(|own| {
        let other = (own + 1) % flat.len();
        let (flat, long) = (&flat, &long);
        (0..long[own].len()).map(move |p| long[own][p] * (flat[own][p] / flat[other][p] - 1.0))
    }));
    quoted.sentence(&format!("If each had draws of its own, the ratio would scatter by {apart:.4} more"));
    assert!(apart > 2.0 * drawn);
    assert_eq!(quoted.differences().unwrap(), "");
}
