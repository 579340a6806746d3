//! Change from steady to dynamic sliding, from the longest strip of a face.

use std::convert::Infallible;
use std::sync::OnceLock;

use crate::pattern::Pattern;
use slipgrid_base::monitor::cached;

use super::super::{RunResults, all_affordable, describe_protocol, describe_scheme, describe_start, run_all, seed_of};
use super::strips::{solve_drawn, without_slivers};
use crate::springblock::dynamics::cache_key_settings;
use crate::springblock::{
    Effect, Face, Lattice, Load, LoadOutcome, Monitor, Scene, SceneError, Statements, Status, SteadyModel, Strip,
    SurfaceOutcome, columns, draws,
};

/// Maximum number of columns of the strip that is run dynamically: the published specimen has 996.
const MAX_TIMED_COLUMNS: f64 = 1200.0;
/// Relative standard error of applying the change from steady to dynamic sliding of one strip to strips with other
/// lengths and cavities, which deviate by no more (`strips_follow_the_longest_in_time`).
pub const TIME_CHANGE_ERROR: f64 = 0.5;

/// Dynamic run of the longest strip of a face.
pub struct TimedStrip {
    /// Outcomes of the strip and its flat counterpart, by load.
    loads: Vec<LoadOutcome>,
    /// Change of the ratio from steady to dynamic sliding, by load.
    added: Vec<Option<f64>>,
    /// Fraction of the strip's columns that are cavity.
    share: f64,
    statements: Statements,
}

impl TimedStrip {
    /// Runs the longest strip of `face` with cavities of `pattern` at every load of `scene`.
    ///
    /// # Errors
    /// The errors of [`super::super::simulate`].
    pub fn new(scene: &Scene, face: &Face, pattern: &Pattern, monitor: &dyn Monitor) -> Result<Self, SceneError> {
        let strip = timed_strip(face.longest(), scene.layer.block_m);
        let part =
            if strip.length_m < face.longest().length_m { "part of the longest strip" } else { "the longest strip" };
        let strip = without_slivers(strip, pattern.depth_m(), scene.layer.block_m);
        let lattices = timed_lattices(scene, pattern, &strip);
        let none = vec![0.0; scene.loads.len()];
        all_affordable(scene, &lattices)?;
        let models = vec![OnceLock::new(); lattices.len()];
        // The steady ratios are computed while no run has begun, or while the last one ends.
        let (integrated, steady) = rayon::join(
            || run_all(scene, &lattices, &models, &none, monitor),
            || drawn_ratios(scene, &lattices, &models, monitor),
        );
        let RunResults { loads, scheme } = integrated?;
        let mut statements = Statements::default();
        statements.method(describe_scheme(scene, &scheme));
        describe_protocol(scene, scheme.step_s, &mut statements);
        statements.method(format!(
            "in time: {part} of the specimen, {:.2} mm with {} cavities on whole blocks of {:.0} um; the other strips take from it what time adds to steady sliding",
            strip.length_m * 1e3,
            strip.cavities_m.len(),
            scene.layer.block_m * 1e6,
        ));
        describe_start(scene, "layer", &mut statements);
        let columns = lattices[0].columns();
        let share = columns.iter().filter(|column| !column.is_land()).count() as f64 / columns.len() as f64;
        let added = loads.iter().zip(steady).map(|(load, steady)| Some(load.ratio()? - steady?)).collect();
        Ok(Self { loads, added, share, statements })
    }

    /// Cavity fraction of `face` over that of the strip, D / `D_1`; 0 if the strip has no cavity.
    fn relative_share(&self, face: &Face) -> f64 {
        if self.share > 0.0 { face.cavity_share() / self.share } else { 0.0 }
    }

    /// Change of the ratio of `face` from steady to dynamic sliding, by load; `None` if the run has no trusted mean.
    pub fn change_on(&self, face: &Face) -> Vec<Option<f64>> {
        let share = self.relative_share(face);
        let each = self.added.iter().zip(&self.loads);
        each.map(|(added, load)| added.filter(|_| load.is_trusted()).map(|added| added * share)).collect()
    }

    /// Adds the change from steady to dynamic sliding to the `steady` outcomes of `face`; returns the outcomes and the
    /// statements on the run.
    pub fn apply(&self, face: &Face, steady: &[LoadOutcome]) -> (Vec<LoadOutcome>, Statements) {
        let share = self.relative_share(face);
        // With a single strip there is no other strip to apply the change to.
        let followed = if face.strips().len() > 1 { TIME_CHANGE_ERROR } else { 0.0 };
        let of_load = |((strip, added), steady): ((&LoadOutcome, &Option<f64>), &LoadOutcome)| {
            let mut load = LoadOutcome {
                surface: strip.surface.clone(),
                flat: strip.flat.clone(),
                ratio_stderr: strip.ratio_stderr.map(|stderr| stderr * share),
                ..steady.clone()
            };
            match added.map(|added| added * share) {
                Some(change) => load.correct(Effect::Time, change, followed * change.abs()),
                None => load.remove_ratio(),
            }
            load.surface.cavity_closed |= steady.surface.cavity_closed;
            load.surface.area_law_extrapolated |= steady.surface.area_law_extrapolated;
            load
        };
        let loads = self.loads.iter().zip(&self.added).zip(steady).map(of_load).collect();
        (loads, self.statements.clone())
    }
}

/// Part of `strip` that is run dynamically: a strip that is too long is cut in the middle of a land.
fn timed_strip(strip: &Strip, block_m: f64) -> Strip {
    let most_m = MAX_TIMED_COLUMNS * block_m;
    if strip.length_m <= most_m {
        return strip.clone();
    }
    let middles = strip.cavities_m.windows(2).map(|pair| f64::midpoint(pair[0][1], pair[1][0]));
    let length_m = middles.take_while(|at_m| *at_m <= most_m).last().unwrap_or(most_m);
    let cavities_m = strip.cavities_m.iter().copied().filter(|[_, end_m]| *end_m <= length_m).collect();
    Strip { length_m, cavities_m, ..strip.clone() }
}

/// Lattices of the strip and of its flat counterpart, in this order, on whole blocks.
pub fn timed_lattices(scene: &Scene, pattern: &Pattern, strip: &Strip) -> Vec<Lattice> {
    let (block_m, rows) = (scene.layer.block_m, scene.layer.rows());
    let cavities: Vec<[f64; 2]> = strip.cavities_m.iter().map(|ends_m| ends_m.map(|at_m| at_m / block_m)).collect();
    let own = columns::whole_strip(strip.length_m / block_m, &cavities, pattern.depth_m() / block_m, rows);
    let own = columns::with_relief(own, pattern, block_m, scene.relief.as_deref());
    let flat = columns::flat(own.len());
    [own, flat].into_iter().map(|columns| Lattice::new(columns, rows, false)).collect()
}

/// Steady friction of the first lattice, a strip, over that of the second, its flat counterpart, by load, with the
/// coefficients drawn for the dynamic runs, averaged over draws; `None` without a ratio. `models` caches the equations;
/// missing ones are created. The friction of the flat lattice is stored in the monitor's cache.
pub fn drawn_ratios(
    scene: &Scene,
    lattices: &[Lattice],
    models: &[OnceLock<SteadyModel>],
    monitor: &dyn Monitor,
) -> Vec<Option<f64>> {
    let ([own, flat], [of_own, of_flat]) = (lattices, models) else { return Vec::new() };
    let friction = |lattice: &Lattice, made: &OnceLock<SteadyModel>| {
        drawn_friction(scene, made.get_or_init(|| SteadyModel::for_scene(scene, lattice.clone())))
    };
    let count = scene.loads.len();
    let of_flat = || {
        let content = (cache_key_settings(scene), &scene.loads, flat);
        let Ok(friction) = cached(monitor, ("flat", &content), 0.0, || Ok::<_, Infallible>(friction(flat, of_flat)));
        friction
    };
    let (own, flat) = rayon::join(|| friction(own, of_own), of_flat);
    let ratio = |load: usize| {
        let of_draw = |(own, flat): (&f64, &f64)| Some(own / flat).filter(|ratio| ratio.is_finite());
        let ratios = own.iter().zip(&flat).skip(load).step_by(count).map(of_draw).collect::<Option<Vec<f64>>>()?;
        Some(ratios.iter().sum::<f64>() / ratios.len() as f64)
    };
    (0..count).map(ratio).collect()
}

/// Steady friction coefficients of `model`, ordered by draw and then by load; NaN without a solution.
fn drawn_friction(scene: &Scene, model: &SteadyModel) -> Vec<f64> {
    let of_draw = |draw: usize| {
        let of_load = |load: &Load| {
            let drawn = draws::draw(&load.friction, seed_of(scene, draw), model.lattice().nx());
            drawn.iter().map(|drawn| drawn.dynamic_mu).collect()
        };
        solve_drawn(scene, model, 1.0, &scene.loads.iter().map(of_load).collect::<Vec<Vec<f64>>>())
    };
    let mu = |surface: SurfaceOutcome| {
        let found = surface.mu_dynamic.filter(|mu| *mu != 0.0 && surface.status == Status::Converged);
        found.unwrap_or(f64::NAN)
    };
    (0..scene.run.draws as usize).flat_map(of_draw).map(mu).collect()
}
