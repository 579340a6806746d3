//! Execution of the rows: one function measures one run, the others decide which runs there are and when.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use slipgrid_model::springblock::{
    Extent, Fidelity, Monitor, Scene, SceneError, Simulation, Springs, SurfaceOutcome, Unwatched, simulate,
};

use super::plan::{Role, Row};
use slipgrid_base::monitor::{Part, Stage};

/// Runs shorter than this are timed again, and the shortest time counts.
const SHORT_S: f64 = 0.05;
/// Maximum number of timings of a short run.
const MAX_TIMINGS: usize = 5;

/// Result of one run of a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Seed of the local coefficients.
    pub seed: u64,
    /// Status at the end of the run, or the reason of a refusal.
    pub status: String,
    /// The run ended as planned.
    pub converged: bool,
    /// Wall time of the whole call, both surfaces, in seconds.
    pub wall_s: f64,
    /// Blocks times force evaluations, both surfaces; 0 for steady runs.
    pub site_updates: u64,
    /// Site updates per second of integration.
    pub site_updates_per_s: Option<f64>,
    /// Time step, in seconds.
    pub dt_s: Option<f64>,
    /// Dynamic friction coefficient.
    pub mu_dynamic: Option<f64>,
    /// Standard error of the dynamic friction coefficient; 0 for steady runs.
    pub mu_dynamic_stderr: Option<f64>,
    /// Static friction coefficient.
    pub mu_static: Option<f64>,
    /// Ratio of dynamic friction, patterned over flat.
    pub ratio: Option<f64>,
    /// Standard error of the ratio; 0 for steady runs.
    pub ratio_stderr: Option<f64>,
}

/// Solves `scene` and records the result.
pub fn measure(scene: &Scene, monitor: &dyn Monitor) -> Run {
    let started_s = monitor.seconds();
    let solved = simulate(scene, monitor);
    let wall_s = monitor.seconds() - started_s;
    let seed = scene.run.seed;
    match solved {
        Ok(simulation) => Run { wall_s, ..noted(scene, &simulation) },
        Err(error) => Run { seed, status: format!("refused: {error}"), ..Run::default() },
    }
}

fn noted(scene: &Scene, simulation: &Simulation) -> Run {
    let Some(load) = simulation.loads.first() else { return Run::default() };
    let surfaces: Vec<&SurfaceOutcome> = [Some(&load.surface), load.flat.as_ref()].into_iter().flatten().collect();
    let costs: Vec<_> = surfaces.iter().filter_map(|surface| surface.cost).collect();
    let site_updates: u64 = costs.iter().map(|cost| cost.site_updates).sum();
    let integration_s: f64 = costs.iter().map(|cost| cost.wall_s).sum();
    // The status of the run is that of the first surface that did not end as planned.
    let ended = surfaces.iter().map(|surface| surface.status.name()).find(|status| *status != "converged");
    let exact = (scene.run.fidelity == Fidelity::Steady).then_some(0.0);
    Run {
        seed: scene.run.seed,
        status: ended.unwrap_or("converged").to_owned(),
        converged: ended.is_none(),
        wall_s: 0.0,
        site_updates,
        site_updates_per_s: (site_updates > 0 && integration_s > 0.0).then(|| site_updates as f64 / integration_s),
        dt_s: costs.first().map(|cost| cost.dt_s),
        mu_dynamic: load.surface.mu_dynamic,
        mu_dynamic_stderr: exact.or(load.surface.mu_dynamic_stderr),
        mu_static: load.surface.mu_static,
        ratio: load.ratio,
        ratio_stderr: exact.filter(|_| load.ratio.is_some()).or(load.ratio_stderr),
    }
}

/// Maximum step that the scheme of `scene` allows on both surfaces; `None` if there is no limit.
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

/// Scene of a row's `seed`-th draw, counted from 0.
pub fn scene_of(row: &Row, base: &Scene, seed: u64) -> Scene {
    let mut scene = base.clone();
    scene.run.seed = base.run.seed.wrapping_add(seed);
    for change in &row.changes {
        change.apply(&mut scene, stability_limit_s);
    }
    scene
}

/// Estimated wall time of all rows on `threads` threads, in seconds.
pub fn expected_wall_s(rows: &[Row], base: &Scene, threads: usize) -> f64 {
    let of = |row: &Row| (0..row.seeds).map(|seed| expected_s(&scene_of(row, base, seed))).sum::<f64>();
    rows.iter().map(of).sum::<f64>() / threads as f64
}

/// Runs every row for all its seeds; returns one list per row, in the order of the seeds.
///
/// The first seed of every row runs on one thread and gives the reported time. It runs alone, or, with
/// `side_by_side`, together with as many other runs as there are threads, one core per run, longest first.
/// The other seeds then share all threads.
pub fn measure_all(rows: &[Row], base: &Scene, side_by_side: bool, progress: &Stage<'_>) -> Vec<Vec<Run>> {
    let scenes: Vec<Vec<Scene>> =
        rows.iter().map(|row| (0..row.seeds).map(|seed| scene_of(row, base, seed)).collect()).collect();
    let all_s: f64 = scenes.iter().flatten().map(expected_s).sum();
    let part = |scene: &Scene| Part::new(progress, expected_s(scene) / all_s);

    let mut first: Vec<(usize, &Scene)> =
        scenes.iter().enumerate().filter_map(|(row, scenes)| Some((row, scenes.first()?))).collect();
    first.sort_by(|a, b| expected_s(b.1).total_cmp(&expected_s(a.1)));
    let next = AtomicUsize::new(0);
    // A thread of a rayon pool would start another row while it waits for one, so separate threads are used.
    let work = || {
        let mut measured = Vec::new();
        while let Some((row, scene)) = first.get(next.fetch_add(1, Ordering::Relaxed)) {
            progress.detail(&rows[*row].label);
            let timed = || timed(scene, &part(scene));
            // The current pool is the fallback if the system provides no further thread.
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
            measured.push((*row, alone.map_or_else(|_| timed(), |pool| pool.install(timed))));
        }
        measured
    };
    let workers = if side_by_side { rayon::current_num_threads() } else { 1 };
    let measured: Vec<(usize, Run)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap_or_default()).collect()
    });
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); rows.len()];
    for (row, run) in measured {
        runs[row].push(run);
    }
    progress.detail("more seeds");
    let mut others: Vec<(usize, &Scene)> =
        scenes.iter().enumerate().flat_map(|(row, scenes)| scenes.iter().skip(1).map(move |s| (row, s))).collect();
    // Longest first, one at a time, so that all threads end at similar times.
    others.sort_by(|a, b| expected_s(b.1).total_cmp(&expected_s(a.1)));
    let more: Vec<(usize, Run)> =
        others.into_par_iter().with_max_len(1).map(|(row, scene)| (row, measure(scene, &part(scene)))).collect();
    for (row, run) in more {
        runs[row].push(run);
    }
    for runs in &mut runs {
        runs.sort_by_key(|run| run.seed.wrapping_sub(base.run.seed));
    }
    runs
}

/// Measures `scene`, repeatedly if it is fast: the shortest time counts.
fn timed(scene: &Scene, monitor: &dyn Monitor) -> Run {
    let mut run = measure(scene, monitor);
    for _ in 1..MAX_TIMINGS {
        if run.wall_s > SHORT_S || !run.converged {
            break;
        }
        let again = measure(scene, &Silent(monitor));
        if again.wall_s < run.wall_s {
            run = again;
        }
    }
    run
}

/// Estimated wall time of a run, in seconds.
fn expected_s(scene: &Scene) -> f64 {
    1e-3 + site_evaluations(scene) * seconds_per_site(scene)
}

/// Estimated number of blocks times force evaluations of a run, both surfaces; 0 for steady runs.
fn site_evaluations(scene: &Scene) -> f64 {
    if scene.run.fidelity == Fidelity::Steady || scene.speed_m_s <= 0.0 {
        return 0.0;
    }
    let columns = match (scene.run.extent, &scene.pattern) {
        (Extent::Cell, Some(pattern)) => pattern.pitch_m() / scene.layer.block_m,
        _ => scene.layer.columns() as f64,
    };
    // 6 ns for blocks of 10 um, in proportion to their size
    let usual_s = if scene.run.fidelity == Fidelity::Reference { 1e-9 } else { 6e-9 * scene.layer.block_m / 10e-6 };
    let steps = scene.run.sliding_m / scene.speed_m_s / scene.run.step_s.unwrap_or(usual_s);
    let stages = if scene.run.fidelity == Fidelity::Reference { 4.0 } else { 1.0 };
    2.0 * columns * scene.layer.rows() as f64 * steps * stages
}

/// Estimated seconds per site evaluation; used for the progress bar and the order of the runs only.
fn seconds_per_site(scene: &Scene) -> f64 {
    match (scene.run.fidelity, scene.run.springs) {
        (Fidelity::Reference, _) | (_, Some(Springs::Exact)) => 35e-9,
        _ => 1e-9,
    }
}

/// Monitor with the clock and the cancellation of another monitor, without its progress.
struct Silent<'a>(&'a dyn Monitor);

impl Monitor for Silent<'_> {
    fn seconds(&self) -> f64 {
        self.0.seconds()
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Runs of the row that has `role`.
pub fn runs_of<'a>(rows: &[Row], runs: &'a [Vec<Run>], role: Role) -> &'a [Run] {
    rows.iter().zip(runs).find(|(row, _)| row.role == role).map_or(&[], |(_, runs)| runs.as_slice())
}
