//! Dynamic runs of a surface and its flat counterpart for every draw and load.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::{averaging, compare};
use crate::springblock::dynamics::{DynamicRun, Scheme, cache_key_settings, cached_run};
use crate::springblock::{Effect, Lattice, LoadOutcome, Monitor, Scene, SceneError, SteadyModel, SurfaceOutcome};

/// Outcomes of dynamic runs by load, averaged over draws, and the integration scheme of the scene's own surface.
pub struct RunResults {
    pub loads: Vec<LoadOutcome>,
    pub scheme: Scheme,
}

/// Runs `lattices`, a surface and its flat counterpart if there is one, at every load.
///
/// `steady` caches the equations of steady sliding, one entry per lattice; runs with a warm start create them.
/// `corrections`, by load, are added to the ratios as [`Effect::WholeBlocks`].
pub fn run_all(
    scene: &Scene,
    lattices: &[Lattice],
    steady: &[OnceLock<SteadyModel>],
    corrections: &[f64],
    monitor: &dyn Monitor,
) -> Result<RunResults, SceneError> {
    let schemes = require_stable(lattices.par_iter().map(|lattice| Scheme::choose(scene, lattice)).collect())?;
    let surfaces = lattices.len();
    let draws = scene.run.draws as usize;
    let runs = surfaces * draws * scene.loads.len();
    let share = 1.0 / runs as f64;
    // Threads without a run of their own help with another run.
    let threads = rayon::current_num_threads() / runs;
    let outcomes: Vec<SurfaceOutcome> = (0..runs)
        .into_par_iter()
        .map(|task| {
            let (draw, surface) = (task / surfaces % draws, task % surfaces);
            let load = &scene.loads[task / (surfaces * draws)];
            let (lattice, steady, scheme) = (&lattices[surface], &steady[surface], schemes[surface]);
            let (seed, stderr_share) = (seed_of(scene, draw), stderr_share(scene));
            let run = DynamicRun { scene, load, lattice, steady, scheme, threads, share, seed, stderr_share };
            let content = (cache_key_settings(scene), load, lattice, scheme, seed, stderr_share);
            cached_run(monitor, &content, share, || run.run(monitor))
        })
        .collect();
    let corrected = |load: usize, _: usize, outcome: &mut LoadOutcome| match corrections[load] {
        0.0 => {}
        change => outcome.correct(Effect::WholeBlocks, change, None),
    };
    Ok(RunResults { loads: collect(scene, surfaces, outcomes, corrected), scheme: schemes[0] })
}

/// Returns all `schemes`, or the error with the smallest stability limit: a step within that limit is stable on all
/// lattices.
fn require_stable(schemes: Vec<Result<Scheme, SceneError>>) -> Result<Vec<Scheme>, SceneError> {
    let limit_s = |refused: &SceneError| match refused {
        SceneError::UnstableStep { limit_s, .. } => *limit_s,
        _ => 0.0,
    };
    let refused = schemes.iter().filter_map(|scheme| scheme.as_ref().err());
    let least = refused.min_by(|a, b| limit_s(a).total_cmp(&limit_s(b))).cloned();
    least.map_or_else(|| schemes.into_iter().collect(), Err)
}

pub const fn seed_of(scene: &Scene, draw: usize) -> u64 {
    scene.run.seed.wrapping_add(draw as u64)
}

/// Relative standard error of dynamic mu at which the run of one draw may end, such that the mean of all draws has the
/// requested error; `None` if no error is requested.
pub fn stderr_share(scene: &Scene) -> Option<f64> {
    scene.run.mu_stderr.map(|wanted| wanted * (scene.run.draws as f64).sqrt())
}

/// Combines runs, ordered by load, draw and surface with the patterned one first, to one record per load. `correct` is
/// called with the index of the load, that of the draw, and their outcome, which it may change.
pub fn collect(
    scene: &Scene,
    surfaces: usize,
    outcomes: Vec<SurfaceOutcome>,
    correct: impl Fn(usize, usize, &mut LoadOutcome),
) -> Vec<LoadOutcome> {
    let mut outcomes = outcomes.into_iter();
    let mut loads = Vec::with_capacity(scene.loads.len());
    for (place, load) in scene.loads.iter().enumerate() {
        let mut draws = Vec::new();
        for draw in 0..scene.run.draws as usize {
            let Some(own) = outcomes.next() else { break };
            let flat = if surfaces == 2 { outcomes.next() } else { None };
            let mut outcome = compare(load, own, flat);
            correct(place, draw, &mut outcome);
            draws.push(outcome);
        }
        loads.extend(averaging::mean(draws));
    }
    loads
}
