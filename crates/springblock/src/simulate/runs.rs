//! Runs in time of a surface and its flat companion, of every draw and load, and what they come to.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::{averaging, compare};
use crate::Monitor;
use crate::dynamics::{DynamicRun, Scheme, remembered, settings};
use crate::error::SceneError;
use crate::lattice::Lattice;
use crate::outcome::{LoadOutcome, SurfaceOutcome};
use crate::scene::Scene;
use crate::steady::SteadyModel;

/// What runs in time found.
pub struct Integrated {
    pub loads: Vec<LoadOutcome>,
    pub scheme: Scheme,
}

/// Runs `lattices`, a surface and its flat companion where it has one, in time at every load; `corrections` of the ratio by
/// load. Equations of `steady` sliding, by lattice, are made where a run begins from them and nobody has made them.
pub fn integrate(
    scene: &Scene,
    lattices: &[Lattice],
    steady: &[OnceLock<SteadyModel>],
    corrections: &[f64],
    monitor: &dyn Monitor,
) -> Result<Integrated, SceneError> {
    let schemes = stable(lattices.par_iter().map(|lattice| Scheme::choose(scene, lattice)).collect())?;
    let surfaces = lattices.len();
    let draws = scene.run.draws as usize;
    let runs = surfaces * draws * scene.loads.len();
    let share = 1.0 / runs as f64;
    // Threads that find no run of their own help with another's.
    let threads = rayon::current_num_threads() / runs;
    let outcomes: Vec<SurfaceOutcome> = (0..runs)
        .into_par_iter()
        .map(|task| {
            let (draw, surface) = (task / surfaces % draws, task % surfaces);
            let load = &scene.loads[task / (surfaces * draws)];
            let (lattice, steady, scheme) = (&lattices[surface], &steady[surface], schemes[surface]);
            let (seed, stderr_share) = (seed_of(scene, draw), stderr_share(scene));
            let run = DynamicRun { scene, load, lattice, steady, scheme, threads, share, seed, stderr_share };
            let content = (settings(scene), load, lattice, scheme, seed, stderr_share);
            remembered(monitor, &content, share, || run.run(monitor))
        })
        .collect();
    let corrected = |load: usize, _: usize, outcome: &mut LoadOutcome| outcome.shift_ratio(corrections[load]);
    Ok(Integrated { loads: collect(scene, surfaces, outcomes, corrected), scheme: schemes[0] })
}

/// All of `schemes`, or the refusal of the one whose step must be the smallest: what it names is stable on all.
fn stable(schemes: Vec<Result<Scheme, SceneError>>) -> Result<Vec<Scheme>, SceneError> {
    let limit_s = |refused: &SceneError| match refused {
        SceneError::UnstableStep { limit_s, .. } => *limit_s,
        _ => 0.0,
    };
    let refused = schemes.iter().filter_map(|scheme| scheme.as_ref().err());
    let least = refused.min_by(|a, b| limit_s(a).total_cmp(&limit_s(b))).cloned();
    least.map_or_else(|| schemes.into_iter().collect(), Err)
}

/// Seed of the local coefficients of draw number `draw`.
pub const fn seed_of(scene: &Scene, draw: usize) -> u64 {
    scene.run.seed.wrapping_add(draw as u64)
}

/// Standard error over dynamic mu at which the run of one draw may end: that of their mean is the one asked for.
pub fn stderr_share(scene: &Scene) -> Option<f64> {
    scene.run.mu_stderr.map(|wanted| wanted * (scene.run.draws as f64).sqrt())
}

/// One record per load from runs by load, draw and surface, the patterned one first; `correct` corrects that of each load and draw.
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
