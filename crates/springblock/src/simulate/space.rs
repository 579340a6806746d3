//! Dynamic runs of the three-dimensional cell: which lattices, what runs on them, what is said.

use rayon::prelude::*;
use slipgrid_pattern::Pattern;

use super::{MOST_FACTOR_BYTES, coarse_ratios, collect, describe_draws, describe_law, seed_of, stderr_share, why_solid};
use crate::dynamics::{MOST_STEPS, Plan, SolidRun, SolidScheme};
use crate::error::SceneError;
use crate::monitor::Monitor;
use crate::outcome::{Simulation, Status, SurfaceOutcome};
use crate::scene::{Load, Scene};
use crate::solid::{SolidLattice, SolidLoad, SolidModel, SolidSteadyModel};

/// Most blocks of a cell: its springs, which set the limit of the time step, take up to 4 GiB then.
const MOST_BLOCKS: f64 = 1e7;
/// Columns along each axis of the flat layer whose largest eigenfrequency stands for that of any: even, so that they
/// hold the shortest waves.
const FLAT_COLUMNS: usize = 8;
/// Bytes a block of a warm start, which knows the displacements of all rows, as unknowns and as spectra.
const WARM_BYTES_PER_BLOCK: f64 = 500.0;

/// Dynamic runs of the cell of `pattern` and of a flat one.
pub fn dynamic(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let rows = scene.layer.rows();
    let [nx, ny] = SolidLattice::columns_of(pattern, scene.layer.block_m);
    // Grooves have no period along themselves: as many columns as across hold as many draws as squares do.
    let along = if pattern.length_m().is_none() { nx } else { ny };
    let blocks = nx * along * rows as f64;
    if blocks > MOST_BLOCKS {
        return Err(SceneError::TooManyBlocks { blocks, most: MOST_BLOCKS });
    }
    let (bytes, most_bytes) = (blocks * WARM_BYTES_PER_BLOCK, MOST_FACTOR_BYTES);
    if scene.run.warm_start && bytes > most_bytes {
        return Err(SceneError::TooLarge { bytes, most_bytes });
    }
    let exact = SolidLattice::cell(pattern, scene.layer.block_m, rows);
    let whole = exact.nearest_whole();
    let own = if pattern.length_m().is_none() { whole.repeated_along_y(nx as usize) } else { whole.clone() };
    let flat = SolidLattice::flat(own.columns(), rows);
    let scheme = SolidScheme::choose(scene, &own)?;
    SolidScheme::choose(scene, &SolidLattice::flat([FLAT_COLUMNS; 2], rows))?;

    let model = SolidModel::new(scene);
    let (steady, coarse) =
        rayon::join(|| model.ratios(pattern), || coarse_ratios(scene, SolidModel::new, |model| model.ratios(pattern)));
    let is_whole = exact == whole;
    let corrections = if is_whole { vec![0.0; scene.loads.len()] } else { corrections(scene, pattern, &whole, &steady) };

    let lattices = [&own, &flat];
    let surfaces = lattices.len();
    let starts: Vec<Option<Vec<[f64; 3]>>> = (0..surfaces * scene.loads.len())
        .into_par_iter()
        .map(|task| {
            let (load, lattice) = (&scene.loads[task / surfaces], lattices[task % surfaces]);
            scene.run.warm_start.then(|| steady_model(scene, lattice).displacements(&solid_load(scene, pattern, load)))
        })
        .collect();
    let draws = scene.run.draws as usize;
    let runs = surfaces * draws * scene.loads.len();
    let outcomes: Vec<SurfaceOutcome> = (0..runs)
        .into_par_iter()
        .map(|task| {
            let (load, draw, surface) = (task / (surfaces * draws), task / surfaces % draws, task % surfaces);
            SolidRun {
                scene,
                load: &scene.loads[load],
                lattice: lattices[surface],
                direction: pattern.sliding_direction(),
                scheme,
                share: 1.0 / runs as f64,
                seed: seed_of(scene, draw),
                stderr_share: stderr_share(scene),
                start: starts[load * surfaces + surface].as_deref(),
            }
            .run(monitor)
        })
        .collect();
    let mut loads = collect(scene, surfaces, &corrections, outcomes);
    for ((load, steady), coarse) in loads.iter_mut().zip(&steady).zip(&coarse) {
        load.ratio_discretization_error = steady.zip(*coarse).map(|(own, coarse)| (own - coarse).abs());
    }
    let model = statements(scene, pattern, &own, scheme, (!is_whole).then_some(&whole));
    Ok(Simulation { model, loads })
}

fn steady_model(scene: &Scene, lattice: &SolidLattice) -> SolidSteadyModel {
    SolidSteadyModel::new(lattice.clone(), scene.layer.block_m, scene.elastic.youngs_modulus_pa())
}

fn solid_load<'a>(scene: &'a Scene, pattern: &Pattern, load: &Load) -> SolidLoad<'a> {
    SolidLoad {
        pressure_pa: load.pressure_pa,
        dynamic_mu: load.friction.dynamic_mean(),
        area_law: scene.area_law.as_ref(),
        direction: pattern.sliding_direction(),
    }
}

/// Steady ratio of the pattern itself less that of its nearest whole blocks, by load.
fn corrections(scene: &Scene, pattern: &Pattern, whole: &SolidLattice, exact: &[Option<f64>]) -> Vec<f64> {
    let loads: Vec<SolidLoad<'_>> = scene.loads.iter().map(|load| solid_load(scene, pattern, load)).collect();
    let outcomes = steady_model(scene, whole).solve_all(&loads);
    loads
        .iter()
        .zip(&outcomes)
        .zip(exact)
        .map(|((load, outcome), exact)| {
            // mu_flat = mu_d f(P)
            let flat = load.dynamic_mu * load.area_law.map_or(1.0, |law| law.factor(load.pressure_pa));
            let solved = matches!(outcome.status, Status::Converged | Status::NoFriction) && flat > 0.0;
            // Without a steady ratio on one side there is nothing to correct by.
            exact.zip(outcome.mu_dynamic.filter(|_| solved)).map_or(0.0, |(exact, mu)| exact - mu / flat)
        })
        .collect()
}

fn statements(
    scene: &Scene,
    pattern: &Pattern,
    own: &SolidLattice,
    scheme: SolidScheme,
    nearest: Option<&SolidLattice>,
) -> Vec<String> {
    let [nx, ny] = own.columns();
    let mut model = vec![
        format!(
            "dynamic: linear springs, leapfrog with implicit damping at {:.3} ns (limit {:.2} ns), damping {} sqrt(k/m) of the vertical plane",
            scheme.step_s * 1e9,
            scheme.limit_s * 1e9,
            scene.run.damping,
        ),
        "cell: one period with periodic sides, as nothing asked for depends on the ends".to_owned(),
        format!(
            "three dimensions, {}: {nx} x {ny} x {} blocks, nu = 1/4, friction a vector against the velocity",
            why_solid(scene, pattern),
            scene.layer.rows(),
        ),
    ];
    let steps = Plan::new(scene, scheme.step_s).total();
    if steps > MOST_STEPS {
        model.push(format!(
            "not run: {:.3e} m of travel at {:.3e} m/s would take {steps:.1e} steps, more than {MOST_STEPS:.0e}; travel less, slide faster, or ask for steady",
            scene.run.sliding_m, scene.speed_m_s,
        ));
    }
    if scene.speed_m_s == 0.0 {
        model.push("speed 0: the bulk stays where it is; 20 us of rest are simulated".to_owned());
    }
    if pattern.length_m().is_none() {
        model.push("grooves: as many columns along them as across, with coefficients of their own".to_owned());
    }
    if scene.run.draws == 1 {
        model.push(
            "one draw of the local coefficients: standard errors are those within the run, not between draws".to_owned(),
        );
    }
    describe_draws(scene, &mut model);
    if scene.run.warm_start {
        model.push(
            "warm start from the sheared steady equilibrium of mean coefficients, at rest: no ramp, no static friction"
                .to_owned(),
        );
    }
    if let Some(nearest) = nearest {
        let share = 1.0
            - (0..nx * nearest.columns()[1]).map(|n| nearest.contact_share(n % nx, n / nx)).sum::<f64>()
                / (nx * nearest.columns()[1]) as f64;
        model.push(format!(
            "nearest whole blocks ({nx} x {} columns, {:.2} % cavity, {:.0} rows deep) plus the steady difference of the ratio to the pattern itself; mu_static and the interface are those of the whole blocks",
            nearest.columns()[1],
            100.0 * share,
            nearest.depth(),
        ));
    }
    describe_law(scene, &mut model);
    model
}
