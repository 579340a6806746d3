//! Runs of a method, with their wall times.

use rayon::prelude::*;
use slipgrid_base::monitor::{Part, Stage};
use slipgrid_model::springblock::{
    Fidelity, Monitor, Scene, SceneError, Simulation, SurfaceOutcome, Unwatched, expense, simulate,
};

use super::plan::Method;

/// Runs shorter than this, in seconds, are timed again, and the shortest time counts.
const SHORT_S: f64 = 0.05;
/// Maximum number of timings of a short run.
const MAX_TIMINGS: usize = 5;
/// Minimum estimated time of a run, in seconds, because the setup of a run takes time as well.
const MIN_EXPECTED_S: f64 = 1e-3;

/// Result of one run of a method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Random seed of the local friction coefficients.
    pub seed: u64,
    /// Status at the end of the run, or the reason why the scene was refused.
    pub status: String,
    /// Wall time of the whole call, both surfaces, in seconds.
    pub wall_s: f64,
    /// Blocks times force evaluations, both surfaces; 0 for steady runs.
    pub site_updates: u64,
    /// Site updates per second of integration; `None` for steady runs.
    pub site_updates_per_s: Option<f64>,
    /// Time step, in seconds; `None` for steady runs.
    pub dt_s: Option<f64>,
    /// Dynamic mu, static mu and the ratio patterned over flat, each with its standard error if the run provides one;
    /// the standard error of a steady run is 0.
    pub values: [Option<(f64, Option<f64>)>; 3],
}

impl Run {
    /// Whether the run ended as planned.
    pub fn has_converged(&self) -> bool {
        self.status == CONVERGED
    }
}

/// Status of a run that ended as planned.
const CONVERGED: &str = "converged";

/// Solves `scene` and records the result with the wall time.
pub fn measure(scene: &Scene, monitor: &dyn Monitor) -> Run {
    let started_s = monitor.seconds();
    let solved = simulate(scene, monitor);
    let wall_s = monitor.seconds() - started_s;
    match solved {
        Ok(simulation) => Run { wall_s, ..record(scene, &simulation) },
        Err(error) => Run { seed: scene.run.seed, status: format!("refused: {error}"), ..Run::default() },
    }
}

fn record(scene: &Scene, simulation: &Simulation) -> Run {
    let Some(load) = simulation.loads.first() else { return Run::default() };
    let surfaces: Vec<&SurfaceOutcome> = [Some(&load.surface), load.flat.as_ref()].into_iter().flatten().collect();
    let costs: Vec<_> = surfaces.iter().filter_map(|surface| surface.cost).collect();
    let site_updates: u64 = costs.iter().map(|cost| cost.site_updates).sum();
    let integration_s: f64 = costs.iter().map(|cost| cost.wall_s).sum();
    // The status of the run is that of the first surface that did not end as planned.
    let ended = surfaces.iter().map(|surface| surface.status.name()).find(|status| *status != CONVERGED);
    let exact = (scene.run.fidelity == Fidelity::Steady).then_some(0.0);
    let with = |value: Option<f64>, stderr: Option<f64>| value.map(|value| (value, exact.or(stderr)));
    Run {
        seed: scene.run.seed,
        status: ended.unwrap_or(CONVERGED).to_owned(),
        wall_s: 0.0,
        site_updates,
        site_updates_per_s: (site_updates > 0 && integration_s > 0.0).then(|| site_updates as f64 / integration_s),
        dt_s: costs.first().map(|cost| cost.dt_s),
        values: [
            with(load.surface.mu_dynamic, load.surface.mu_dynamic_stderr),
            with(load.surface.mu_static, None),
            with(load.ratio(), load.ratio_stderr),
        ],
    }
}

/// Maximum time step, in seconds, at which the integration scheme of `scene` is stable on both surfaces; `None` if
/// there is no limit.
pub fn stability_limit_s(scene: &Scene) -> Option<f64> {
    let limit = |mut scene: Scene| {
        scene.run.step_s = Some(f64::MAX);
        match simulate(&scene, &Unwatched) {
            Err(SceneError::UnstableStep { limit_s, .. }) => Some(limit_s),
            _ => None,
        }
    };
    let own = limit(scene.clone())?;
    let flat = limit(Scene { pattern: None, ..scene.clone() })?;
    Some(own.min(flat))
}

/// `base` with the changes of `method`; `seed`, from 0, is added to the seed of `base`.
pub fn scene_of(method: &Method, base: &Scene, seed: u64) -> Scene {
    let mut scene = base.clone();
    scene.run.seed = base.run.seed.wrapping_add(seed);
    for change in &method.changes {
        change.apply(&mut scene, stability_limit_s);
    }
    scene
}

/// Runs `method` for all seeds and returns the runs in the order of the seeds. The first run is alone on one thread and
/// gives the reported wall time; the other runs share all threads. `all_s` is the expected time of the whole
/// comparison, in seconds.
pub fn measure_all(method: &Method, base: &Scene, seeds: u64, all_s: f64, progress: &Stage<'_>) -> Vec<Run> {
    progress.detail(&method.label);
    let part = |scene: &Scene| Part::new(progress, expected_s(scene) / all_s);
    let first = scene_of(method, base, 0);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let timed = || timed(&first, &part(&first));
    // The current thread pool is the fallback if the system provides no further thread.
    let first = alone.map_or_else(|_| timed(), |pool| pool.install(timed));
    let others = (1..seeds).into_par_iter().map(|seed| {
        let scene = scene_of(method, base, seed);
        measure(&scene, &part(&scene))
    });
    let others: Vec<Run> = others.collect();
    std::iter::once(first).chain(others).collect()
}

/// Measures `scene`, repeatedly if the run is short, and returns the run with the shortest wall time.
fn timed(scene: &Scene, monitor: &dyn Monitor) -> Run {
    let mut run = measure(scene, monitor);
    for _ in 1..MAX_TIMINGS {
        if run.wall_s > SHORT_S || !run.has_converged() {
            break;
        }
        let again = measure(scene, &Part::new(monitor, 0.0));
        if again.wall_s < run.wall_s {
            run = again;
        }
    }
    run
}

/// Estimated wall time of all runs of a method, in seconds.
pub fn expected_wall_s(method: &Method, base: &Scene, seeds: u64) -> f64 {
    let one_s = expected_s(&scene_of(method, base, 0));
    one_s * (1.0 + seeds.saturating_sub(1) as f64 / rayon::current_num_threads() as f64)
}

/// Estimated time of a run on one thread, in seconds; for the announced duration and the progress bar.
fn expected_s(scene: &Scene) -> f64 {
    expense(scene).core_s.max(MIN_EXPECTED_S)
}
