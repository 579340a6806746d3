//! Steady and dynamic simulation of a cell or a strip in space: lattices, runs and statements.

use crate::pattern::Pattern;
use rayon::prelude::*;
use slipgrid_base::monitor::cached;

use super::drawn_ratios::SteadyRatios;
use super::space_strip::{self, SpaceStrip};
use super::statements::{
    PERIODIC_CELL, SPEED_ZERO, STRETCHED_CELL, describe_draws, describe_law, describe_protocol, describe_start,
    describe_steady, space_reason,
};
use super::{blocks, collect, compare, differences, require_memory, seed_of, stderr_share};
use crate::springblock::dynamics::{SpaceRun, SpaceScheme, cache_key_settings, cached_run};
use crate::springblock::{
    Dimension, Effect, Extent, LoadOutcome, Monitor, Scene, SceneError, Simulation, SpaceLattice, Statements, Status,
    SteadyCell, Strip, SurfaceOutcome,
};

/// Maximum number of blocks of a dynamic cell or strip: the springs, from which the step limit is computed, then take
/// up to 4 GiB.
const MAX_BLOCKS: f64 = 1e7;
/// Maximum memory of a steady cell for error estimates, in bytes; a cell of this size takes a second.
pub const MAX_ESTIMATED_BYTES: f64 = 1e8;
/// Number of columns along each axis of the flat layer whose largest eigenfrequency represents every flat layer; even,
/// so that the shortest waves fit.
const FLAT_COLUMNS: usize = 8;
/// Memory per block for the warm start of a dynamic run, in bytes: displacements of all rows, as unknowns and as
/// spectra.
const WARM_BYTES_PER_BLOCK: f64 = 500.0;

/// A pattern in space and, optionally, a strip of a specimen with its own cavities.
#[derive(Clone, Copy)]
pub struct StripLayout<'a> {
    pub pattern: &'a Pattern,
    pub strip: Option<&'a Strip>,
}

impl StripLayout<'_> {
    /// Returns the strip that `scene` requests, made of copies of `cell`; `None` if the scene requests one cell.
    fn strip(self, scene: &Scene, cell: impl FnOnce() -> SpaceLattice) -> Option<SpaceStrip> {
        (scene.run.extent == Extent::Strip).then(|| SpaceStrip::new(scene, self.pattern, &cell(), self.strip))
    }
}

/// Cavity fraction of a strip over that of a cell; 1 without a strip.
fn relative_cavity_share(strip: Option<&SpaceStrip>) -> f64 {
    strip.map_or(1.0, |strip| strip.relative_cavity_share)
}

/// Cavity fraction of the strip of `layout` over that of a cell; 1 without a strip.
pub fn layout_share(scene: &Scene, layout: StripLayout) -> f64 {
    let cell = || SteadyCell::with_dimension(scene, Dimension::Space).space_lattice(layout.pattern, scene.layer.rows());
    relative_cavity_share(layout.strip(scene, cell).as_ref())
}

/// Simulates steady sliding of the cell of the pattern, or of a strip of the sample.
pub fn steady(scene: &Scene, layout: StripLayout, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let pattern = layout.pattern;
    let model = SteadyCell::with_dimension(scene, Dimension::Space);
    let strip = layout.strip(scene, || model.space_lattice(pattern, scene.layer.rows()));
    let mut loads = match &strip {
        None => steady_loads(scene, pattern, monitor)?,
        Some(strip) => space_strip::steady_loads(scene, strip, monitor)?,
    };
    let ratios: Vec<Option<f64>> = match &strip {
        None => loads.iter().map(|load| load.ratio()).collect(),
        Some(_) => model.ratios_heeding(pattern, monitor),
    };
    let error = discretization_error(scene, pattern, &ratios, monitor);
    blocks::set_errors(&mut loads, error.as_deref(), relative_cavity_share(strip.as_ref()));
    monitor.advance(1.0);
    let [nx, ny] =
        strip.as_ref().map_or_else(|| model.columns(pattern).map(|columns| columns as usize), SpaceStrip::columns);
    let why = space_reason(scene, pattern);
    let mut statements = Statements::default();
    statements.model(describe_steady(scene));
    statements.method(strip.as_ref().map_or_else(|| PERIODIC_CELL.to_owned(), SpaceStrip::statement));
    statements.model.extend(strip.as_ref().and_then(|strip| strip.few_periods_statement(pattern)));
    statements.method(format!(
        "three dimensions, {why}: {nx} x {ny} x {} blocks, nu = 1/4, friction against the drive",
        scene.layer.rows()
    ));
    if strip.is_none() {
        statements.method(
            "mean local coefficients: a periodic cell has no scatter to average; the flat surface slides at mu_d f(P)",
        );
    }
    if scene.speed_m_s == 0.0 {
        statements.model(SPEED_ZERO);
    }
    if !model.is_plain(pattern) {
        statements.method(STRETCHED_CELL);
    }
    describe_law(scene, &mut statements);
    Ok(Simulation { statements, loads })
}

/// Outcomes of steady sliding by load, without discretization errors.
pub fn steady_loads(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Result<Vec<LoadOutcome>, SceneError> {
    let model = SteadyCell::with_dimension(scene, Dimension::Space);
    require_memory(model.bytes(pattern))?;
    let outcomes = scene.loads.iter().zip(model.solve_heeding(pattern, monitor));
    let compared = outcomes.map(|(load, outcome)| {
        // A flat layer is uniform and needs no solve.
        let flat = SurfaceOutcome {
            mu_dynamic: outcome.mu_flat.or((load.pressure_pa > 0.0).then_some(0.0)),
            peak_pressure_pa: load.pressure_pa,
            area_law_extrapolated: scene.area_law.as_ref().is_some_and(|law| law.is_extrapolated(load.pressure_pa)),
            residual: outcome.mu_flat.map(|_| 0.0),
            ..SurfaceOutcome::unsolved(
                match outcome.mu_flat {
                    Some(_) => Status::Converged,
                    None if load.pressure_pa > 0.0 => Status::NoFriction,
                    None => Status::NoLoad,
                },
                std::iter::empty(),
            )
        };
        compare(load, outcome.surface, Some(flat))
    });
    Ok(compared.collect())
}

/// Estimated differences of the ratios `own` of steady cells in space from the limit of vanishing blocks
/// ([`blocks::block_error`]), by load; `None` if other block sizes are too expensive, and once `monitor` has cancelled.
/// Results are cached, so that a run that confirms a prediction does not repeat them.
fn discretization_error(
    scene: &Scene,
    pattern: &Pattern,
    own: &[Option<f64>],
    monitor: &dyn Monitor,
) -> Option<Vec<f64>> {
    if let Some(errors) = blocks::edge_groove_error(scene, pattern) {
        return Some(errors);
    }
    let estimate = || {
        blocks::block_error(scene, own, |scene| {
            let model = SteadyCell::with_dimension(scene, Dimension::Space);
            (model.bytes(pattern) < MAX_ESTIMATED_BYTES && !monitor.cancelled())
                .then(|| model.ratios_heeding(pattern, monitor))
        })
    };
    let content = (SteadyCell::with_dimension(scene, Dimension::Space), pattern, own);
    cached(monitor, ("blocks", &content), 0.0, || estimate().ok_or(())).ok()
}

/// Dynamic runs of the cell of the pattern, or of a strip of the sample, and of a flat surface.
pub fn dynamic(scene: &Scene, layout: StripLayout, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let pattern = layout.pattern;
    let rows = scene.layer.rows();
    let [nx, ny] = SpaceLattice::columns_of(pattern, scene.layer.block_m);
    // Grooves have no period along their length: with as many columns along as across, a cell contains as many draws as
    // a square cell.
    let along = if pattern.is_uniform_along_y() { nx } else { ny };
    let cell = SteadyCell::with_dimension(scene, Dimension::Space);
    let blocks = match scene.run.extent {
        Extent::Cell | Extent::Sample => nx * along * rows as f64,
        Extent::Strip => scene.layer.columns() as f64 * nx.max(ny) * rows as f64,
    };
    if blocks > MAX_BLOCKS {
        return Err(SceneError::TooManyBlocks { blocks, most: MAX_BLOCKS });
    }
    if scene.run.warm_start {
        require_memory(blocks * WARM_BYTES_PER_BLOCK)?;
    }
    let exact = cell.space_lattice(pattern, rows);
    let whole = exact.nearest_whole();
    let strip = layout.strip(scene, || whole.clone());
    let [own, flat] = strip.as_ref().map_or_else(
        || {
            let own = if pattern.is_uniform_along_y() { whole.repeated_along_y(nx as usize) } else { whole.clone() };
            let flat = SpaceLattice::flat(own.columns(), rows);
            [own, flat]
        },
        |strip| strip.lattices.clone(),
    );
    let direction = strip.as_ref().map_or_else(|| pattern.sliding_direction(), |strip| strip.direction);
    let scheme = SpaceScheme::choose(scene, &own)?;
    SpaceScheme::choose(scene, &SpaceLattice::flat([FLAT_COLUMNS; 2], rows))?;

    let steady = cell.ratios_heeding(pattern, monitor);
    let error = discretization_error(scene, pattern, &steady, monitor);
    let is_whole = exact == whole;
    let corrections =
        if is_whole { vec![0.0; scene.loads.len()] } else { corrections(&cell, pattern, &whole, &steady, monitor) };

    let lattices = [&own, &flat];
    let surfaces = lattices.len();
    let drawn_ratios = || SteadyRatios::new(scene, lattices, direction, monitor);
    let draws = scene.run.draws as usize;
    let runs = surfaces * draws * scene.loads.len();
    let integrated = || -> Vec<SurfaceOutcome> {
        let run = |task: usize| {
            let (load, draw, surface) = (task / (surfaces * draws), task / surfaces % draws, task % surfaces);
            let run = SpaceRun {
                scene,
                load: &scene.loads[load],
                lattice: lattices[surface],
                direction,
                scheme,
                share: 1.0 / runs as f64,
                seed: seed_of(scene, draw),
                stderr_share: stderr_share(scene),
            };
            let content =
                (cache_key_settings(scene), run.load, run.lattice, run.direction, scheme, run.seed, run.stderr_share);
            let mut outcome = cached_run(monitor, &content, run.share, || run.run(monitor));
            strip.iter().for_each(|strip| strip.to_pattern_axes(&mut outcome));
            outcome
        };
        (0..runs).into_par_iter().map(run).collect()
    };
    let (outcomes, drawn_ratios) = rayon::join(integrated, drawn_ratios);
    let share = relative_cavity_share(strip.as_ref());
    let mut loads = collect(scene, surfaces, outcomes, |load, draw, outcome| {
        // r = r_steady + (r_dynamic - r_steady of the same draw)
        if let Some((steady, drawn)) = drawn_ratios.as_ref().and_then(|known| known.get(load, draw)) {
            let added = outcome.solved.map(|ratio| ratio - drawn);
            outcome.solved = added.map(|_| steady);
            added.into_iter().for_each(|change| outcome.correct(Effect::Time, change, None));
        }
        if corrections[load] != 0.0 {
            outcome.correct(Effect::WholeBlocks, share * corrections[load], None);
        }
    });
    blocks::set_errors(&mut loads, error.as_deref(), share);
    let statements = statements(scene, pattern, &own, strip.as_ref(), scheme, (!is_whole).then_some(&whole));
    Ok(Simulation { statements, loads })
}

/// Steady ratio `exact` of the pattern minus the ratio of the lattice `whole`, rounded to whole blocks, by load; 0 if
/// one is missing.
fn corrections(
    cell: &SteadyCell,
    pattern: &Pattern,
    whole: &SpaceLattice,
    exact: &[Option<f64>],
    monitor: &dyn Monitor,
) -> Vec<f64> {
    let whole: Vec<Option<f64>> =
        cell.solve_in_space(whole.clone(), pattern, monitor).iter().map(|outcome| outcome.ratio).collect();
    differences(exact, &whole)
}

fn statements(
    scene: &Scene,
    pattern: &Pattern,
    own: &SpaceLattice,
    strip: Option<&SpaceStrip>,
    scheme: SpaceScheme,
    nearest: Option<&SpaceLattice>,
) -> Statements {
    let [nx, ny] = strip.map_or_else(|| own.columns(), SpaceStrip::columns);
    let mut statements = Statements::default();
    statements.method(format!(
        "dynamic: linear springs, leapfrog with implicit damping at {:.3} ns (limit {:.2} ns), damping {} sqrt(k/m) of the vertical plane",
        scheme.step_s * 1e9,
        scheme.limit_s * 1e9,
        scene.run.damping,
    ));
    statements.method(strip.map_or_else(|| PERIODIC_CELL.to_owned(), SpaceStrip::statement));
    statements.model.extend(strip.and_then(|strip| strip.few_periods_statement(pattern)));
    statements.method(format!(
        "three dimensions, {}: {nx} x {ny} x {} blocks, nu = 1/4, friction a vector against the velocity",
        space_reason(scene, pattern),
        scene.layer.rows(),
    ));
    describe_protocol(scene, scheme.step_s, &mut statements);
    if pattern.is_uniform_along_y() && strip.is_none() {
        statements.method("grooves: as many columns along them as across, with coefficients of their own");
    }
    if scene.run.draws == 1 {
        statements
            .method("one draw of the local coefficients: standard errors are those within the run, not between draws");
    }
    describe_draws(scene, &mut statements);
    describe_start(scene, if strip.is_some() { "strip" } else { "cell" }, &mut statements);
    if let Some(nearest) = nearest {
        let [nx, ny] = nearest.columns();
        let share = 1.0 - (0..nx * ny).map(|n| nearest.contact_share(n % nx, n / nx)).sum::<f64>() / (nx * ny) as f64;
        statements.method(format!(
            "nearest whole blocks ({nx} x {ny} columns, {:.2} % cavity, {:.0} rows deep) plus the steady difference of the ratio to the pattern itself; mu_static and the interface are those of the whole blocks",
            100.0 * share,
            nearest.depth(),
        ));
    }
    describe_law(scene, &mut statements);
    statements
}

#[cfg(test)]
mod tests {
    use crate::material::LocalFriction;
    use crate::pattern::{Planform, Texture};

    use super::*;
    use crate::springblock::Unwatched;
    use crate::springblock::simulate;
    use crate::springblock::tests::samples::{self, pattern, says};
    use crate::springblock::{Fidelity, Layer, Load};

    /// A warm dynamic run of squares `width_um` wide with a pitch of 120 um in a layer of 60 um.
    fn scene(width_um: f64, friction: LocalFriction) -> Scene {
        let squares = pattern(Planform::Square, width_um, 120.0 - width_um, 20.0);
        let scene = samples::scene(squares, &[2.6], samples::in_time(0.3e-6));
        let layer = Layer { length_m: 960e-6, height_m: 60e-6, ..scene.layer };
        Scene { layer, loads: vec![Load { pressure_pa: 2.6e6, friction }], ..scene }
    }

    #[test]
    fn squares_slide_in_space_and_near_steady_sliding() {
        let mut scene = scene(60.0, samples::friction());
        assert_eq!(scene.dimension(), Dimension::Space);
        let found = simulate(&scene, &Unwatched).unwrap();
        assert!(says(&found, "three dimensions, as square cavities need: 12 x 12 x 6"));
        let load = &found.loads[0];
        let flat = load.flat.as_ref().unwrap();
        assert_eq!((load.surface.status, flat.status), (Status::Converged, Status::Converged));
        assert!(load.surface.mu_across.unwrap().abs() < 0.002 && flat.mu_across.unwrap().abs() < 0.002);
        assert_eq!((load.surface.interface.len(), flat.interface.len()), (144 - 36, 144));
        assert!(load.surface.tension_blocks == 0 && !load.surface.cavity_closed);
        scene.run.fidelity = Fidelity::Steady;
        let steady = simulate(&scene, &Unwatched).unwrap().loads[0].clone();
        let (ratio, expected) = (load.ratio().unwrap(), steady.ratio().unwrap());
        assert!((ratio - expected).abs() < 0.006, "{ratio} {expected}");
        assert_eq!(load.correction(Effect::Blocks), steady.correction(Effect::Blocks));
        // Micro-stick-slip raises friction above steady sliding.
        let excess = flat.mu_dynamic.unwrap() / steady.flat.unwrap().mu_dynamic.unwrap() - 1.0;
        assert!(excess > 0.0 && excess < 0.05, "{excess}");
    }

    #[test]
    fn amontons_coulomb_with_equal_coefficients_gives_one() {
        let mut scene = scene(60.0, LocalFriction::new(0.27, 0.27, 0.0).unwrap());
        scene.area_law = None;
        scene.run.warm_start = false;
        scene.run.sliding_m = 0.6e-6;
        for angle_deg in [0.0, 30.0] {
            let texture = Texture::new(Planform::Square).with_sliding_angle_deg(angle_deg).unwrap();
            scene.pattern = Some(pattern(texture, 60.0, 60.0, 20.0));
            let load = simulate(&scene, &Unwatched).unwrap().loads[0].clone();
            assert_eq!(load.surface.status, Status::Converged);
            assert!((load.ratio().unwrap() - 1.0).abs() < 2e-3, "{:?}", load.ratio());
            assert!((load.surface.mu_dynamic.unwrap() - 0.27).abs() < 5e-4);
        }
    }

    #[test]
    fn draws_are_averaged_and_threads_change_nothing() {
        let mut scene = scene(60.0, samples::friction());
        scene.run.sliding_m = 0.1e-6;
        scene.run.draws = 2;
        let threads = |count: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| simulate(&scene, &Unwatched).unwrap())
        };
        let both = threads(1);
        assert_eq!(both, threads(3));
        assert!(says(&both, "mean of 2 draws"));
        scene.run.draws = 1;
        let ratios = [1, 2].map(|seed| {
            scene.run.seed = seed;
            simulate(&scene, &Unwatched).unwrap().loads[0].ratio().unwrap()
        });
        let load = &both.loads[0];
        assert!((load.ratio().unwrap() - (ratios[0] + ratios[1]) / 2.0).abs() < 1e-15);
        // The standard error of two runs is at least half their difference.
        assert!(load.ratio_stderr.unwrap() >= (ratios[0] - ratios[1]).abs() / 2.0 - 1e-15);
    }

    #[test]
    fn dimensions_that_are_no_whole_blocks_are_corrected_by_the_steady_difference() {
        let mut scene = scene(60.0, samples::friction());
        scene.run.sliding_m = 0.1e-6;
        let whole = simulate(&scene, &Unwatched).unwrap().loads[0].ratio().unwrap();
        let steady = |pattern: &Pattern| SteadyCell::new(&scene).ratios(pattern)[0].unwrap();
        let nearest = scene.pattern.unwrap();
        let pattern = pattern(Planform::Square, 62.0, 58.0, 18.0);
        let difference = steady(&pattern) - steady(&nearest);
        scene.pattern = Some(pattern);
        let found = simulate(&scene, &Unwatched).unwrap();
        assert!(difference.abs() > 1e-3 && (found.loads[0].ratio().unwrap() - whole - difference).abs() < 1e-12);
        assert!(says(&found, "nearest whole blocks (12 x 12 columns, 25.00 % cavity"));
    }

    #[test]
    fn grooves_along_the_sliding_direction_have_columns_along_them() {
        let mut scene = scene(60.0, samples::friction());
        let texture = Texture::new(Planform::Groove).with_sliding_angle_deg(90.0).unwrap();
        scene.pattern = Some(pattern(texture, 60.0, 60.0, 20.0));
        scene.run.sliding_m = 0.1e-6;
        let load = simulate(&scene, &Unwatched).unwrap().loads[0].clone();
        assert_eq!((load.surface.status, load.surface.interface.len()), (Status::Converged, 72));
    }

    #[test]
    fn what_cannot_run_says_so() {
        let mut scene = scene(60.0, samples::friction());
        scene.run.step_s = Some(20e-9);
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::UnstableStep { .. })));
        scene.run.step_s = None;
        scene.loads[0].pressure_pa = 0.0;
        let load = simulate(&scene, &Unwatched).unwrap().loads[0].clone();
        assert_eq!((load.surface.status, load.surface.interface.len()), (Status::NoLoad, 108));
        scene.loads[0].pressure_pa = 2.6e6;
        scene.speed_m_s = 1e-15;
        let load = simulate(&scene, &Unwatched).unwrap().loads[0].clone();
        assert_eq!(load.surface.status, Status::TooManySteps);
        scene.run.dimensions = Some(3);
        scene.run.fidelity = Fidelity::Reference;
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::Unsupported { .. })));
        scene.run.draws = 65;
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::OutOfRange { quantity: "draws", .. })));
    }
}
