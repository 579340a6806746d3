//! Simulation of a scene: choice of lattices and solvers, comparison with the flat surface.

mod averaging;
mod blocks;
mod cavities_in_space;
mod drawn_ratios;
mod expense;
mod load_sharing;
mod pressure_tilt;
mod rim_difference;
mod runs;
mod space;
mod space_strip;
mod specimen;
mod statements;
mod thick_layer;

pub use specimen::{simulate_specimen, steady_face_bytes, steady_face_ratios, time_changes};

use std::sync::OnceLock;

use crate::pattern::Pattern;
use rayon::prelude::*;
use slipgrid_base::monitor::cached;

use crate::springblock::cell::cell_condensing_cost;
use crate::springblock::dynamics::{Plan, Scheme};
use crate::springblock::steady::{BATCH, factor_bytes};
use crate::springblock::{
    Column, Dimension, Extent, Fidelity, Lattice, Layer, Load, LoadOutcome, Monitor, RunOptions, Scene, SceneError,
    Simulation, Statements, Status, SteadyCell, SteadyLoad, SteadyModel, Strip, SurfaceOutcome, columns, draws,
};

use runs::{RunResults, collect, run_all, seed_of, stderr_share};
use space::{StripLayout, layout_share};
use statements::{
    SPEED_ZERO, STRETCHED_CELL, describe_draws, describe_extent, describe_law, describe_protocol, describe_scheme,
    describe_start, describe_steady,
};
use thick_layer::ThickLayerCorrection;

pub use blocks::{BlockRefinement, block_refinement, can_refine};
pub use expense::{Expense, bounded, cell_expense, expense};
use pressure_tilt::PressureTilt;
pub use pressure_tilt::{add_tilt, tilt_relative_error, tilt_shifts};

/// Maximum number of columns of a flat surface in a dynamic `cell`: without a pattern there is no period, and this many
/// blocks average out the scatter of the coefficients.
const FLAT_CELL_COLUMNS: usize = 100;

/// Maximum memory for the equations of one lattice, in bytes; two lattices may be in memory at the same time.
const MAX_FACTOR_BYTES: f64 = 8.0 * (1_u64 << 30) as f64;

/// Number of columns that represent a uniform periodic layer.
const UNIFORM_COLUMNS: usize = 3;

/// Value with the largest magnitude, the first among equals; 0 for no values.
fn widest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |widest: f64, value| if value.abs() > widest.abs() { value } else { widest })
}

/// Solves `scene` at every load, and a flat surface for comparison if the scene has a pattern.
///
/// Loads and surfaces run in parallel on rayon's current pool; the result does not depend on the
/// number of threads.
///
/// # Errors
/// [`SceneError`] if the scene is invalid; every other failure is a [`crate::springblock::Status`].
pub fn simulate(scene: &Scene, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let tilt = |pattern: &Pattern| PressureTilt::for_sample(scene, pattern, monitor);
    simulate_laid(scene, None, tilt, monitor).map(|(simulation, _)| simulation)
}

/// Like [`simulate`] for a strip of a specimen in space ([`Extent::Strip`]), with the length and the cavities of
/// `strip`. Also returns the cavity fraction of the strip over that of a period.
///
/// The tilt of the pressure is not included, because it depends on the whole specimen.
///
/// # Errors
/// The errors of [`simulate`].
pub fn simulate_strip(scene: &Scene, strip: &Strip, monitor: &dyn Monitor) -> Result<(Simulation, f64), SceneError> {
    let run = RunOptions { extent: Extent::Strip, dimensions: Some(Dimension::Space.number()), ..scene.run };
    let blocks = (strip.length_m / scene.layer.block_m).round().max(1.0);
    let layer = Layer { length_m: blocks * scene.layer.block_m, ..scene.layer };
    let scene = &Scene { layer, run, ..scene.clone() };
    simulate_laid(scene, Some(strip), |_| PressureTilt::default(), monitor)
}

/// Simulates `scene`, with the cavities of `strip` if given. Also returns the cavity fraction of the strip over that of
/// a period, or 1 without a strip.
fn simulate_laid(
    scene: &Scene,
    strip: Option<&Strip>,
    tilt: impl Fn(&Pattern) -> PressureTilt,
    monitor: &dyn Monitor,
) -> Result<(Simulation, f64), SceneError> {
    scene.validate()?;
    bounded(scene)?;
    let mut simulation = over_layer(scene, strip, monitor)?;
    let layout = strip.zip(scene.pattern.as_ref());
    let share = layout.map_or(1.0, |(strip, pattern)| layout_share(scene, StripLayout { pattern, strip: Some(strip) }));
    if let Some(pattern) = &scene.pattern {
        rim_difference::add_yielding(scene, pattern, share, &mut simulation.loads, &mut simulation.statements);
        let is_in_time = scene.run.fidelity != Fidelity::Steady;
        let correction = ThickLayerCorrection::new(scene, pattern, monitor).scaled(share);
        correction.apply(is_in_time, &tilt(pattern), &mut simulation.loads, &mut simulation.statements);
        blocks::refine(scene, pattern, share, &mut simulation, monitor);
    }
    Ok((simulation, share))
}

/// Result of a cancelled simulation: every surface has the status [`Status::Cancelled`].
fn cancelled(scene: &Scene) -> Simulation {
    let unsolved = || SurfaceOutcome::unsolved(Status::Cancelled, std::iter::empty());
    let loads = scene.loads.iter().map(|load| compare(load, unsolved(), Some(unsolved()))).collect();
    Simulation { statements: Statements::default(), loads }
}

/// Ratios of the steady cell of `scene` at every load as in [`simulate`], without error estimates, which take several
/// more cells. With [`crate::springblock::RunOptions::refine`] the ratios are those of smaller blocks if no cell for
/// this takes more than half a second in the vertical plane. `None` for a load that did not converge, and for a flat
/// scene. Ratios in the monitor's cache are not computed again.
///
/// # Errors
/// [`SceneError`] if the scene is invalid.
pub fn steady_ratios(scene: &Scene, monitor: &dyn Monitor) -> Result<Vec<Option<f64>>, SceneError> {
    scene.validate()?;
    bounded(scene)?;
    cached(monitor, ("ratios", scene), 1.0, || {
        let solved = &thick_layer::solver_scene(scene);
        let Some(pattern) = &scene.pattern else { return Ok(vec![None; scene.loads.len()]) };
        let mut loads = if scene.dimension() == Dimension::Space {
            let loads = space::steady_loads(solved, pattern, monitor)?;
            monitor.advance(1.0);
            loads
        } else {
            steady(solved, monitor)?.loads
        };
        rim_difference::add_yielding(scene, pattern, 1.0, &mut loads, &mut Statements::default());
        let own: Vec<Option<f64>> = loads.iter().map(|load| load.ratio()).collect();
        let refined = if scene.run.refine {
            blocks::refinement(scene, pattern, &own, blocks::MAX_PRODUCTS, monitor).ok()
        } else {
            None
        };
        let shifts = refined.map_or_else(|| vec![0.0; loads.len()], |refined| refined.shifts);
        let converged = |load: LoadOutcome| load.ratio().filter(|_| load.surface.status == Status::Converged);
        Ok(loads.into_iter().zip(shifts).map(|(load, shift)| Some(converged(load)? + shift)).collect())
    })
}

/// Like [`simulate`] without the corrections for yielding, thickness, tilt and refinement: strips and dynamic runs have
/// the layer only.
fn over_layer(scene: &Scene, strip: Option<&Strip>, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let solved = &thick_layer::solver_scene(scene);
    if let Some(pattern) = scene.pattern.as_ref().filter(|_| scene.dimension() == Dimension::Space) {
        let layout = StripLayout { pattern, strip };
        return match scene.run.fidelity {
            Fidelity::Steady => space::steady(solved, layout, monitor),
            Fidelity::Dynamic | Fidelity::Reference => space::dynamic(solved, layout, monitor),
        };
    }
    let mut simulation = match scene.run.fidelity {
        Fidelity::Steady => steady(solved, monitor)?,
        Fidelity::Dynamic | Fidelity::Reference => dynamic(solved, monitor)?,
    };
    // The error estimate is left out if it does not fit in memory.
    let estimated = scene
        .pattern
        .as_ref()
        .filter(|pattern| affordable(scene, columns::cell(pattern, scene.layer.block_m).len(), true).is_ok());
    if let Some(pattern) = estimated {
        let own: Vec<Option<f64>> = match (scene.run.fidelity, scene.run.extent) {
            (Fidelity::Steady, Extent::Cell) => simulation.loads.iter().map(|load| load.ratio()).collect(),
            _ => SteadyCell::with_dimension(scene, Dimension::Plane).ratios(pattern),
        };
        blocks::set_errors(&mut simulation.loads, discretization_error(scene, pattern, &own).as_deref(), 1.0);
    }
    Ok(simulation)
}

/// Planned number of time steps of one dynamic run of `scene`, with the default step unless the scene gives a step. A
/// run may continue beyond the plan until its mean is stationary. Runs of more than [`crate::springblock::MAX_STEPS`]
/// are refused.
pub fn planned_steps(scene: &Scene) -> u64 {
    Plan::new(scene, scene.run.step_s.unwrap_or(Scheme::default_step_s(scene))).total()
}

/// Columns of the scene's own surface, with `pattern`, and of the flat surface for comparison; the latter is `None`
/// without a pattern.
fn surfaces(scene: &Scene, pattern: Option<&Pattern>) -> (Vec<Column>, Option<Vec<Column>>) {
    let (block_m, whole) = (scene.layer.block_m, scene.layer.columns());
    let map = scene.relief.as_deref();
    match (pattern, scene.run.extent) {
        (None, Extent::Sample | Extent::Strip) => (columns::flat(whole), None),
        (None, Extent::Cell) => (columns::flat(whole.min(FLAT_CELL_COLUMNS)), None),
        (Some(pattern), Extent::Sample | Extent::Strip) => {
            (columns::sample_with_map(pattern, block_m, whole, map), Some(columns::flat(whole)))
        }
        (Some(pattern), Extent::Cell) => {
            let cell = columns::cell_with_map(pattern, block_m, map);
            // Steady sliding on a flat periodic layer is uniform, so that any number of columns gives the same result.
            let flat = if scene.run.fidelity == Fidelity::Steady { UNIFORM_COLUMNS } else { cell.len() };
            (cell, Some(columns::flat(flat)))
        }
    }
}

fn lattice(scene: &Scene, columns: Vec<Column>) -> Lattice {
    Lattice::new(columns, scene.layer.rows(), scene.run.extent == Extent::Cell)
}

/// Returns `bytes` if equations of that size may be solved, and [`SceneError::TooLarge`] above [`MAX_FACTOR_BYTES`].
fn require_memory(bytes: f64) -> Result<f64, SceneError> {
    let most_bytes = MAX_FACTOR_BYTES;
    if bytes > most_bytes { Err(SceneError::TooLarge { bytes, most_bytes }) } else { Ok(bytes) }
}

/// Refuses steady sliding of a lattice with `columns` columns if the equations of all blocks take too much memory.
fn affordable(scene: &Scene, columns: usize, periodic: bool) -> Result<(), SceneError> {
    require_memory(factor_bytes(columns, scene.layer.rows(), periodic)).map(|_| ())
}

/// Applies [`affordable`] to each of `lattices`.
fn all_affordable(scene: &Scene, lattices: &[Lattice]) -> Result<(), SceneError> {
    lattices.iter().try_for_each(|lattice| affordable(scene, lattice.nx(), lattice.is_periodic()))
}

/// Solves steady sliding of all blocks of the layer on `lattice` under each load of `scene`.
fn solve_all(scene: &Scene, lattice: Lattice) -> Vec<SurfaceOutcome> {
    let coefficients = |load: &Load| steady_coefficients(scene, load, lattice.nx());
    let drawn: Vec<Vec<f64>> = scene.loads.iter().map(coefficients).collect();
    let area_law = scene.area_law.as_ref();
    let loads = scene.loads.iter().zip(&drawn);
    let loads = loads.map(|(load, dynamic_mu)| SteadyLoad { pressure_pa: load.pressure_pa, dynamic_mu, area_law });
    let loads: Vec<SteadyLoad> = loads.collect();
    let model = SteadyModel::for_scene(scene, lattice);
    if scene.run.liftoff {
        // Loads under which blocks lift have factors of their own.
        return loads.par_iter().map(|load| model.solve(load)).collect();
    }
    loads.par_chunks(BATCH).flat_map_iter(|loads| model.solve_all(loads)).collect()
}

fn steady(scene: &Scene, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let (own, flat) = surfaces(scene, scene.pattern.as_ref());
    let cell = scene.pattern.as_ref().filter(|_| scene.run.extent == Extent::Cell);
    match cell {
        // A flat layer is uniform whatever its thickness.
        Some(pattern) if scene.layer.is_backed() => {
            require_memory(cell_condensing_cost(pattern, scene.layer.block_m).1).map(|_| ())
        }
        _ => affordable(scene, own.len(), scene.run.extent == Extent::Cell),
    }?;
    let own = lattice(scene, own);
    let is_plain = own.is_plain();
    let of_cell = |pattern: &Pattern| SteadyCell::with_dimension(scene, Dimension::Plane).solve(pattern);
    let own = || match cell {
        Some(pattern) => of_cell(pattern).into_iter().map(|found| found.surface).collect(),
        None => solve_all(scene, own),
    };
    let (own, flat) = rayon::join(own, || flat.map(|flat| solve_all(scene, lattice(scene, flat))));
    let flat = |number: usize| flat.as_ref().map(|all| all[number].clone());
    let own = own.into_iter().enumerate();
    let loads = own.map(|(number, own)| compare(&scene.loads[number], own, flat(number))).collect();
    monitor.advance(1.0);
    let mut statements = Statements::default();
    statements.model(describe_steady(scene));
    describe_extent(scene, &mut statements);
    if scene.run.extent == Extent::Cell {
        statements.method("mean local coefficients: a periodic cell has no scatter to average");
    }
    if scene.speed_m_s == 0.0 {
        statements.model(SPEED_ZERO);
    }
    if scene.loads.iter().any(|load| load.friction.dynamic_mean() > 1.0) {
        statements.model(
            "mu above 1: this equilibrium is unstable, as steady sliding of an elastic body on a rigid plane is",
        );
    }
    if !is_plain {
        statements.method(match scene.run.extent {
            Extent::Cell => STRETCHED_CELL,
            Extent::Sample | Extent::Strip => {
                "dimensions that are no whole blocks: columns fitted to the cavity's edges, depth blended between rows"
            }
        });
    }
    describe_law(scene, &mut statements);
    Ok(Simulation { statements, loads })
}

/// Local dynamic coefficients of a steady solve by column: the mean in a cell, random draws in a sample.
fn steady_coefficients(scene: &Scene, load: &Load, columns: usize) -> Vec<f64> {
    match scene.run.extent {
        Extent::Cell => vec![load.friction.dynamic_mean(); columns],
        Extent::Sample | Extent::Strip => {
            draws::draw(&load.friction, scene.run.seed, columns).iter().map(|drawn| drawn.dynamic_mu).collect()
        }
    }
}

fn dynamic(scene: &Scene, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let rows = scene.layer.rows();
    // Time integration runs on whole blocks; the steady model gives the correction to the exact dimensions.
    let nearest = match &scene.pattern {
        Some(pattern) => Some(columns::nearest_whole(pattern, scene.layer.block_m, rows).map_err(|_| {
            SceneError::Unsupported { what: "a pattern without whole blocks", instead: "give positive dimensions" }
        })?),
        None => None,
    };
    let (own, flat) = surfaces(scene, nearest.as_ref());
    let lattices: Vec<Lattice> = [Some(own), flat].into_iter().flatten().map(|c| lattice(scene, c)).collect();
    let corrections = off_lattice_corrections(scene, nearest.as_ref())?;
    if scene.run.warm_start {
        all_affordable(scene, &lattices)?;
    }
    let steady = vec![OnceLock::new(); lattices.len()];
    let RunResults { loads, scheme } = run_all(scene, &lattices, &steady, &corrections, monitor)?;
    let mut statements = Statements::default();
    statements.method(describe_scheme(scene, &scheme));
    describe_protocol(scene, scheme.step_s, &mut statements);
    describe_extent(scene, &mut statements);
    describe_draws(scene, &mut statements);
    describe_start(scene, "layer", &mut statements);
    if let Some(nearest) = nearest.filter(|_| corrections.iter().any(|c| *c != 0.0)) {
        statements.method(format!(
            "nearest whole blocks ({:.0} / {:.0} / {:.0} um) plus the steady difference of the ratio to the pattern itself; mu_static and the interface are those of the whole blocks",
            nearest.width_m() * 1e6,
            nearest.spacing_m() * 1e6,
            nearest.depth_m() * 1e6,
        ));
    }
    describe_law(scene, &mut statements);
    Ok(Simulation { statements, loads })
}

/// Steady ratio of the pattern minus the ratio of the pattern `nearest`, rounded to whole blocks, by load.
fn off_lattice_corrections(scene: &Scene, nearest: Option<&Pattern>) -> Result<Vec<f64>, SceneError> {
    let none = vec![0.0; scene.loads.len()];
    let (Some(pattern), Some(nearest)) = (&scene.pattern, nearest) else { return Ok(none) };
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    if close(pattern.width_m(), nearest.width_m())
        && close(pattern.spacing_m(), nearest.spacing_m())
        && close(pattern.depth_m(), nearest.depth_m())
    {
        return Ok(none);
    }
    affordable(scene, columns::cell(pattern, scene.layer.block_m).len(), true)?;
    let model = SteadyCell::with_dimension(scene, Dimension::Plane);
    let (exact, whole) = (model.ratios(pattern), model.ratios(nearest));
    Ok(differences(&exact, &whole))
}

/// Steady ratios `exact` with the exact dimensions minus those with `whole` blocks, by load; 0 if either is missing, so
/// that no correction is possible.
fn differences(exact: &[Option<f64>], whole: &[Option<f64>]) -> Vec<f64> {
    exact.iter().zip(whole).map(|(exact, whole)| exact.zip(*whole).map_or(0.0, |(e, w)| e - w)).collect()
}

/// Estimated difference of the ratios `own` of steady plane cells from the limit of vanishing blocks, by load
/// ([`blocks::block_error`]); `None` if other block sizes are impossible or too expensive.
fn discretization_error(scene: &Scene, pattern: &Pattern, own: &[Option<f64>]) -> Option<Vec<f64>> {
    blocks::block_error(scene, own, |scene| blocks::plane_ratios(scene, pattern, blocks::MAX_PRODUCTS))
}

fn compare(load: &Load, surface: SurfaceOutcome, flat: Option<SurfaceOutcome>) -> LoadOutcome {
    // States out of equilibrium have no ratio.
    let found = |surface: &SurfaceOutcome| surface.status != Status::NotConverged;
    let ratio = flat.as_ref().filter(|flat| found(&surface) && found(flat)).and_then(|flat| {
        let (own, flat) = (surface.mu_dynamic?, flat.mu_dynamic?);
        (flat != 0.0).then(|| own / flat)
    });
    let ratio_stderr = flat.as_ref().zip(ratio).and_then(|(flat, ratio)| {
        // d(a/b) = (da - (a/b) db) / b, which also holds if the patterned surface has no friction.
        let (own, of_flat) = (surface.mu_dynamic_stderr?, flat.mu_dynamic_stderr?);
        Some(own.hypot(ratio * of_flat) / flat.mu_dynamic?.abs())
    });
    LoadOutcome { pressure_pa: load.pressure_pa, surface, flat, ratio_stderr, solved: ratio, corrections: Vec::new() }
}

#[cfg(test)]
mod relief_tests;
