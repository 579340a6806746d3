//! A specimen as it is cut: the sum of the strips of its face along the sliding direction.
//!
//! All strips hang from one rigid bulk and come down alike. With k_s the force per length that a unit descent takes of strip
//! s, w_s its width and L_s its length, their pressures P_s and the friction of the face under the nominal pressure P are
//!
//! ```text
//! P_s = k_s d,     sum w_s L_s P_s = P sum w_s L_s,     mu = sum w_s L_s P_s mu_s / (P sum w_s L_s)
//! ```
//!
//! That bulk stands on the modelled layer. How the parts of the face share the load where the specimen behind the layer is elastic
//! is added ([`load_sharing`](super::load_sharing)).
//!
//! The strips sample the face. Its share of cavities D is known exactly, and what cavities take off friction goes very
//! nearly as their share, so that the ratio to the flat face is taken as 1 - (1 - r) D / D_strips. What strips depart from
//! that proportion is the error of the sampling.
//!
//! In time one strip is run, the longest, on whole blocks. The others take from it what time adds to steady sliding:
//!
//! ```text
//! r = r_steady + (r_dynamic,1 - r_steady,1) D / D_1
//! ```

use rayon::prelude::*;

use super::pressure_tilt::PressureTilt;
use super::rim_difference::{RimDifference, without_rim};
use super::{
    Behind, Integrated, MOST_FACTOR_BYTES, UNIFORM_COLUMNS, cancelled, compare, describe_draws, describe_law,
    describe_protocol, describe_scheme, describe_start, discretization_error, integrate, seed_of,
};
use crate::Monitor;
use crate::cell::SteadyCell;
use crate::columns;
use crate::dimension::Dimension;
use crate::draws;
use crate::error::SceneError;
use crate::face::{Face, Strip};
use crate::lattice::Lattice;
use crate::outcome::{LoadOutcome, Simulation, Statements, Status, SurfaceOutcome};
use crate::scene::{Extent, Fidelity, Layer, Load, RunOptions, Scene};
use crate::steady::{SteadyLoad, SteadyModel, factor_bytes};
use slipgrid_pattern::Pattern;

/// Length of the longest strip that is solved as it is, in heights of the layer. Of a longer one both ends are kept, half of that
/// length each, and what is left out between them is periodic: what an end does decays within a height, so that the ratio of the face
/// is off by less than 1e-5 (`strips_are_their_ends_and_cells_between_them`). Where cavities are no whole blocks, those of a whole strip
/// lie on blocks in different ways; the cell lies in one way, and what smaller blocks change of it is known
/// (`cells_between_ends_take_strips_to_smaller_blocks`).
const STRIP_HEIGHTS: f64 = 15.0;
/// Columns of the strip that is run in time: the published specimen has 996.
const MOST_TIMED_COLUMNS: f64 = 1200.0;
/// Narrowest land at the end of a strip that a lattice resolves, in blocks.
const LEAST_END_BLOCKS: f64 = 2.0;
/// Share of what time adds to steady sliding on one strip that is left open for the others: that of strips of other lengths
/// and cavities departs from it by no more (`strips_follow_the_longest_in_time`).
const TIME_SHARE: f64 = 0.5;

/// Solves `scene`, whose pattern lies on `face` as its strips say, beside the flat face. Loads and strips run in parallel on
/// rayon's current pool; the result does not depend on the number of threads.
///
/// # Errors
/// [`SceneError`] if the scene means nothing, without a pattern, and where the strips do not fit in memory.
pub fn simulate_specimen(scene: &Scene, face: &Face, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    scene.validate()?;
    let Some(pattern) = &scene.pattern else {
        return Err(SceneError::Unsupported {
            what: "the layout of a flat specimen",
            instead: "give a pattern, or simulate the flat sample",
        });
    };
    // Blocks stand for the layer alone.
    let layer = &Scene { layer: scene.layer.alone(), ..scene.clone() };
    let rims = RimDifference::new(scene, pattern);
    let Some(steady) = SteadyFace::new(layer, &rims, pattern, face, monitor)? else { return Ok(cancelled(scene)) };
    let mut said = Statements::default();
    let mut loads = match scene.run.fidelity {
        Fidelity::Steady => {
            said.model("steady: equilibrium with every contact block sliding, linear elasticity; no time");
            steady.loads.clone()
        }
        Fidelity::Dynamic | Fidelity::Reference => in_time(layer, face, pattern, &steady, &mut said, monitor)?,
    };
    // What cavities take off the face is that of the cell, in proportion to their share.
    let share = face.cavity_share() / pattern.section_density();
    let cells = SteadyCell::solved(scene, Dimension::Plane).ratios(pattern);
    super::blocks::state(&mut loads, discretization_error(scene, pattern, &cells).as_deref(), share);
    describe(scene, face, pattern, &steady, &mut said);
    let run = RunOptions { extent: Extent::Sample, ..scene.run };
    let behind = Behind::under_face(&Scene { run, ..scene.clone() }, pattern, face, monitor);
    let flat = Scene { relief: None, ..scene.clone() };
    let tilt = PressureTilt::of_face(&flat, &without_rim(pattern), face, share, monitor);
    behind.tell(&tilt, &mut loads, &mut said);
    let mut simulation = Simulation { statements: said, loads };
    super::blocks::refine(scene, pattern, share, &mut simulation, monitor);
    describe_draws(scene, &mut simulation.statements);
    describe_law(scene, &mut simulation.statements);
    Ok(simulation)
}

/// Steady ratios of the face by load, over the thickness that `scene` says, without what tells how far off they are; all `None` once
/// `monitor` has cancelled.
///
/// # Errors
/// [`SceneError`] where the strips do not fit in memory.
pub fn steady_face_ratios(
    scene: &Scene,
    pattern: &Pattern,
    face: &Face,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SceneError> {
    let layer = Scene { layer: scene.layer.alone(), ..scene.clone() };
    let steady = SteadyFace::new(&layer, &RimDifference::new(scene, pattern), pattern, face, monitor)?;
    let Some(SteadyFace { mut loads, .. }) = steady else { return Ok(vec![None; scene.loads.len()]) };
    if scene.layer.is_backed() {
        Behind::under_face(scene, pattern, face, monitor).tell(
            &PressureTilt::default(),
            &mut loads,
            &mut Statements::default(),
        );
    }
    Ok(loads.iter().map(|load| load.ratio).collect())
}

/// A part of the face that is solved on one lattice.
struct Piece {
    band: usize,
    /// Area that it stands for, in square metres.
    area_m2: f64,
    /// Area of its cavities, in square metres.
    cavity_area_m2: f64,
    model: SteadyModel,
    /// Pressure over the nominal one: P_s / P.
    pressure_share: f64,
}

/// Steady sliding of the whole face with mean coefficients.
struct SteadyFace {
    loads: Vec<LoadOutcome>,
    /// Strips that were shortened by whole periods.
    shortened: usize,
}

/// `strip` without the periods that make it longer than [`STRIP_HEIGHTS`], and the length left out, in metres.
fn shortened(strip: &Strip, layer: &Layer) -> (Strip, f64) {
    let most_m = STRIP_HEIGHTS * layer.height_m;
    let cavities = &strip.cavities_m;
    if strip.length_m <= most_m {
        return (strip.clone(), 0.0);
    }
    let Some(periods) = cavities.len().checked_sub(1).filter(|periods| *periods > 0) else {
        let kept = cavities.is_empty();
        // Nothing but land, or one cavity: land can go.
        return if kept {
            (Strip { length_m: most_m, ..strip.clone() }, strip.length_m - most_m)
        } else {
            (strip.clone(), 0.0)
        };
    };
    let pitch_m = (cavities[periods][0] - cavities[0][0]) / periods as f64;
    // Whole periods; at most those that lie between the first and the last cavity.
    let left_out = (((strip.length_m - most_m) / pitch_m).ceil().max(0.0) as usize).min(periods - 1);
    let first = (cavities.len() - left_out).div_ceil(2);
    let out_m = left_out as f64 * pitch_m;
    let ends = cavities[..first]
        .iter()
        .copied()
        .chain(cavities[first + left_out..].iter().map(|[start_m, end_m]| [start_m - out_m, end_m - out_m]));
    (Strip { length_m: strip.length_m - out_m, cavities_m: ends.collect(), ..strip.clone() }, out_m)
}

/// `strip` without land between a cavity and its ends that is narrower than the cavity is deep, or than
/// [`LEAST_END_BLOCKS`]: on so slender a wall friction raises the pressure that raises friction, and nothing holds it.
pub(super) fn without_slivers(mut strip: Strip, depth_m: f64, block_m: f64) -> Strip {
    let least_m = depth_m.max(LEAST_END_BLOCKS * block_m);
    let length_m = strip.length_m;
    if let Some(first) = strip.cavities_m.first_mut().filter(|first| first[0] < least_m) {
        first[0] = 0.0;
    }
    if let Some(last) = strip.cavities_m.last_mut().filter(|last| length_m - last[1] < least_m) {
        last[1] = length_m;
    }
    strip
}

impl SteadyFace {
    /// `None` once `monitor` has cancelled.
    fn new(
        scene: &Scene,
        rims: &RimDifference,
        pattern: &Pattern,
        face: &Face,
        monitor: &dyn Monitor,
    ) -> Result<Option<Self>, SceneError> {
        let (block_m, rows) = (scene.layer.block_m, scene.layer.rows());
        // Strips lie flat: what rims add is that of the cell.
        let pattern = &without_rim(pattern);
        let blocks = |strip: &Strip| -> Vec<[f64; 2]> {
            strip.cavities_m.iter().map(|ends_m| ends_m.map(|at_m| at_m / block_m)).collect()
        };
        // To a billionth of a row: what decimals in files leave behind is gone.
        let depth = (pattern.depth_m() / block_m * 1e9).round() * 1e-9;
        let mut planned: Vec<(usize, f64, f64, Lattice)> = Vec::new();
        let mut count = 0;
        for strip in face.strips() {
            let (kept, out_m) = shortened(strip, &scene.layer);
            let cavity_m2 = |strip: &Strip| strip.cavity_length_m() * strip.width_m;
            let bearing = without_slivers(kept.clone(), pattern.depth_m(), block_m);
            let ends = Lattice::new(columns::strip(kept.length_m / block_m, &blocks(&bearing), depth), rows, false);
            planned.push((strip.band, kept.area_m2(), cavity_m2(&kept), ends));
            if out_m > 0.0 {
                count += 1;
                let middle = if kept.cavities_m.is_empty() {
                    columns::flat(UNIFORM_COLUMNS)
                } else {
                    columns::cell(pattern, block_m)
                };
                let cavity_area_m2 = cavity_m2(strip) - cavity_m2(&kept);
                planned.push((strip.band, out_m * strip.width_m, cavity_area_m2, Lattice::new(middle, rows, true)));
            }
        }
        let bytes = planned.iter().map(|(.., lattice)| factor_bytes(lattice.nx(), rows, lattice.is_periodic())).sum();
        if bytes > MOST_FACTOR_BYTES {
            return Err(SceneError::TooLarge { bytes, most_bytes: MOST_FACTOR_BYTES });
        }
        let pieces: Option<Vec<Piece>> = planned
            .into_par_iter()
            .map(|(band, area_m2, cavity_area_m2, lattice)| {
                monitor.heed().ok()?;
                let model = SteadyModel::of(scene, lattice);
                Some(Piece { band, area_m2, cavity_area_m2, pressure_share: model.stiffness_per_length(), model })
            })
            .collect();
        let Some(mut pieces) = pieces else { return Ok(None) };
        // P_s = k_s d with sum A_s P_s = P sum A_s
        let area_m2: f64 = pieces.iter().map(|piece| piece.area_m2).sum();
        let carried: f64 = pieces.iter().map(|piece| piece.area_m2 * piece.pressure_share).sum();
        for piece in &mut pieces {
            piece.pressure_share *= area_m2 / carried;
        }
        let solved =
            |piece: &Piece| Some(solve(scene, &piece.model, piece.pressure_share)).filter(|_| !monitor.cancelled());
        let by_piece: Option<Vec<Vec<SurfaceOutcome>>> = pieces.par_iter().map(solved).collect();
        let Some(by_piece) = by_piece else { return Ok(None) };
        let mut by_piece: Vec<_> = by_piece.into_iter().map(Vec::into_iter).collect();
        let flat = FlatFace::new(scene, face).solve(scene);
        let each = scene.loads.iter().zip(flat).map(|(load, flat)| {
            let surfaces: Vec<SurfaceOutcome> = by_piece.iter_mut().filter_map(Iterator::next).collect();
            face_load(face, &pieces, &surfaces, flat, load)
        });
        let mut loads: Vec<LoadOutcome> = each.collect();
        rims.add(face.cavity_share() / pattern.section_density(), &mut loads);
        Ok(Some(Self { loads, shortened: count }))
    }
}

/// Steady sliding on `model` at each load of `scene`, at `share` of its pressure and with its mean coefficient.
fn solve(scene: &Scene, model: &SteadyModel, share: f64) -> Vec<SurfaceOutcome> {
    let columns = model.lattice().nx();
    let of_load = |load: &Load| vec![load.friction.dynamic_mean(); columns];
    solve_drawn(scene, model, share, &scene.loads.iter().map(of_load).collect::<Vec<_>>())
}

/// The same with the coefficients `dynamic_mu` of every column, one row a load.
fn solve_drawn<'a>(
    scene: &'a Scene,
    model: &SteadyModel,
    share: f64,
    dynamic_mu: &'a [Vec<f64>],
) -> Vec<SurfaceOutcome> {
    let of_load = |(load, dynamic_mu): (&Load, &'a Vec<f64>)| SteadyLoad {
        pressure_pa: load.pressure_pa * share,
        dynamic_mu,
        area_law: scene.area_law.as_ref(),
    };
    let loads: Vec<SteadyLoad> = scene.loads.iter().zip(dynamic_mu).map(of_load).collect();
    model.solve_all(&loads)
}

/// The flat face: uniform but for the ends of its strips.
struct FlatFace {
    /// The longest strip, flat.
    model: SteadyModel,
    length_m: f64,
    /// Strips have two ends each: their width over the area of the face, per metre.
    ends_per_m: f64,
}

impl FlatFace {
    fn new(scene: &Scene, face: &Face) -> Self {
        let block_m = scene.layer.block_m;
        let length_m = face.longest().length_m.min(STRIP_HEIGHTS * scene.layer.height_m);
        let columns = columns::strip(length_m / block_m, &[], 0.0);
        let lattice = Lattice::new(columns, scene.layer.rows(), false);
        let model = SteadyModel::of(scene, lattice);
        let sum = |of: fn(&Strip) -> f64| face.strips().iter().map(of).sum::<f64>();
        Self { model, length_m, ends_per_m: sum(|strip| strip.width_m) / sum(Strip::area_m2) }
    }

    /// The flat face under each load: what a pair of ends takes off one strip is that of every strip.
    fn solve(&self, scene: &Scene) -> Vec<SurfaceOutcome> {
        let of_load = |(load, own): (&Load, SurfaceOutcome)| {
            let uniform = load.flat_mu(scene.area_law.as_ref());
            // mu = mu_u + (mu_1 - mu_u) L_1 sum w_s / sum w_s L_s
            let mu_dynamic = own.mu_dynamic.map(|mu| uniform + (mu - uniform) * self.length_m * self.ends_per_m);
            SurfaceOutcome { mu_dynamic, ..own }
        };
        scene.loads.iter().zip(solve(scene, &self.model, 1.0)).map(of_load).collect()
    }
}

/// The face under one load, of which `surfaces` are the pieces and `flat` the flat face.
fn face_load(
    face: &Face,
    pieces: &[Piece],
    surfaces: &[SurfaceOutcome],
    flat: SurfaceOutcome,
    load: &Load,
) -> LoadOutcome {
    let (ratio, sampling_error) = face_ratio(face, pieces, surfaces, flat.mu_dynamic).unzip();
    let longest = surfaces.iter().zip(pieces).max_by(|(_, a), (_, b)| {
        (a.cavity_area_m2 > 0.0, a.model.lattice().nx()).cmp(&(b.cavity_area_m2 > 0.0, b.model.lattice().nx()))
    });
    let worst = surfaces.iter().map(|surface| surface.status).find(|status| *status != Status::Converged);
    let most = |of: fn(&SurfaceOutcome) -> f64| surfaces.iter().map(of).fold(0.0, f64::max);
    let surface = SurfaceOutcome {
        status: worst.unwrap_or(Status::Converged),
        peak_pressure_pa: most(|surface| surface.peak_pressure_pa),
        residual: Some(most(|surface| surface.residual.unwrap_or(0.0))),
        tension_blocks: surfaces.iter().map(|surface| surface.tension_blocks).sum(),
        cavity_closed: surfaces.iter().any(|surface| surface.cavity_closed),
        clearance_m: surfaces.iter().filter_map(|surface| surface.clearance_m).reduce(f64::min),
        area_law_extrapolated: surfaces.iter().any(|surface| surface.area_law_extrapolated),
        iterations: surfaces.iter().map(|surface| surface.iterations).max().unwrap_or(0),
        mu_dynamic: ratio.zip(flat.mu_dynamic).map(|(ratio, mu)| ratio * mu),
        ..longest.map_or_else(|| flat.clone(), |(surface, _)| surface.clone())
    };
    LoadOutcome { ratio_layout_error: sampling_error, ..compare(load, surface, Some(flat)) }
}

/// Ratio of the face to the flat one of `flat_mu`, and the standard error of sampling it by strips: what bands depart from
/// a lowering of friction in proportion to their cavities, as if by chance.
fn face_ratio(face: &Face, pieces: &[Piece], surfaces: &[SurfaceOutcome], flat_mu: Option<f64>) -> Option<(f64, f64)> {
    let flat_mu = flat_mu.filter(|mu| *mu != 0.0)?;
    let area_m2: f64 = pieces.iter().map(|piece| piece.area_m2).sum();
    // By band: what it takes off the ratio, and its cavities over the face's area.
    let mut bands = vec![[0.0; 2]; face.bands()];
    for (piece, surface) in pieces.iter().zip(surfaces) {
        let [lowered, share] = &mut bands[piece.band];
        *lowered += piece.area_m2 * piece.pressure_share * (1.0 - surface.mu_dynamic? / flat_mu) / area_m2;
        *share += piece.cavity_area_m2 / area_m2;
    }
    let [lowered, share] = bands.iter().fold([0.0; 2], |sum, band| [sum[0] + band[0], sum[1] + band[1]]);
    if share == 0.0 {
        return None;
    }
    // 1 - r = D (1 - r_strips) / D_strips
    let ratio = 1.0 - face.cavity_share() * lowered / share;
    let departures = bands.iter().map(|band| (band[0] - band[1] * lowered / share).powi(2)).sum::<f64>();
    Some((ratio, departures.sqrt() * face.cavity_share() / share))
}

/// Ratios of the face with what time adds to steady sliding on its longest strip.
fn in_time(
    scene: &Scene,
    face: &Face,
    pattern: &Pattern,
    steady: &SteadyFace,
    said: &mut Statements,
    monitor: &dyn Monitor,
) -> Result<Vec<LoadOutcome>, SceneError> {
    let strip = timed_strip(face.longest(), scene.layer.block_m);
    let part = if strip.length_m < face.longest().length_m { "part of the longest strip" } else { "the longest strip" };
    let strip = without_slivers(strip, pattern.depth_m(), scene.layer.block_m);
    let lattices = timed_lattices(scene, pattern, &strip);
    let none = vec![0.0; scene.loads.len()];
    let Integrated { mut loads, scheme, steady: models } = integrate(scene, &lattices, &none, monitor)?;
    said.method(describe_scheme(scene, &scheme));
    describe_protocol(scene, scheme.step_s, said);
    said.method(format!(
        "in time: {part} of the specimen, {:.2} mm with {} cavities on whole blocks of {:.0} um; the other strips take from it what time adds to steady sliding",
        strip.length_m * 1e3,
        strip.cavities_m.len(),
        scene.layer.block_m * 1e6,
    ));
    describe_start(scene, "layer", said);
    let models: Vec<SteadyModel> = lattices
        .into_par_iter()
        .zip(models)
        .map(|(lattice, made)| made.into_inner().unwrap_or_else(|| SteadyModel::of(scene, lattice)))
        .collect();
    let columns = models[0].lattice().columns();
    let own_share = columns.iter().filter(|column| !column.is_land()).count() as f64 / columns.len() as f64;
    let share = if own_share > 0.0 { face.cavity_share() / own_share } else { 0.0 };
    for ((outcome, of_steady), steady) in loads.iter_mut().zip(drawn_ratios(scene, &models)).zip(&steady.loads) {
        let added = outcome.ratio.zip(of_steady).map(|(dynamic, steady)| dynamic - steady);
        outcome.ratio = steady.ratio.zip(added).map(|(ratio, added)| ratio + added * share);
        outcome.ratio_stderr = outcome.ratio_stderr.map(|stderr| stderr * share);
        let flat_mu = outcome.flat.as_ref().and_then(|flat| flat.mu_dynamic);
        outcome.surface.mu_dynamic = outcome.ratio.zip(flat_mu).map(|(ratio, mu)| ratio * mu);
        outcome.surface.cavity_closed |= steady.surface.cavity_closed;
        outcome.surface.area_law_extrapolated |= steady.surface.area_law_extrapolated;
        // One strip has nothing to follow it.
        let followed = if face.strips().len() > 1 { TIME_SHARE } else { 0.0 };
        outcome.ratio_layout_error =
            steady.ratio_layout_error.zip(added).map(|(sampled, added)| sampled.hypot(followed * added * share));
    }
    Ok(loads)
}

/// The part of `strip` that is run in time: up to the middle of a land where it is too long.
fn timed_strip(strip: &Strip, block_m: f64) -> Strip {
    let most_m = MOST_TIMED_COLUMNS * block_m;
    if strip.length_m <= most_m {
        return strip.clone();
    }
    let middles = strip.cavities_m.windows(2).map(|pair| f64::midpoint(pair[0][1], pair[1][0]));
    let length_m = middles.take_while(|at_m| *at_m <= most_m).last().unwrap_or(most_m);
    let cavities_m = strip.cavities_m.iter().copied().filter(|[_, end_m]| *end_m <= length_m).collect();
    Strip { length_m, cavities_m, ..strip.clone() }
}

/// The strip and its flat companion on whole blocks.
fn timed_lattices(scene: &Scene, pattern: &Pattern, strip: &Strip) -> Vec<Lattice> {
    let (block_m, rows) = (scene.layer.block_m, scene.layer.rows());
    let cavities: Vec<[f64; 2]> = strip.cavities_m.iter().map(|ends_m| ends_m.map(|at_m| at_m / block_m)).collect();
    let own = columns::whole_strip(strip.length_m / block_m, &cavities, pattern.depth_m() / block_m, rows);
    let own = columns::raised(own, pattern, block_m, scene.relief.as_deref());
    let flat = columns::flat(own.len());
    [own, flat].into_iter().map(|columns| Lattice::new(columns, rows, false)).collect()
}

/// Steady ratio of the first of `models` over the second with the coefficients that the runs in time draw, by load.
fn drawn_ratios(scene: &Scene, models: &[SteadyModel]) -> Vec<Option<f64>> {
    let draws = scene.run.draws as usize;
    let mut sums = vec![Some(0.0); scene.loads.len()];
    for draw in 0..draws {
        let solved = |model: &SteadyModel| {
            let of_load = |load: &Load| {
                let drawn = draws::draw(&load.friction, seed_of(scene, draw), model.lattice().nx());
                drawn.iter().map(|drawn| drawn.dynamic_mu).collect()
            };
            solve_drawn(scene, model, 1.0, &scene.loads.iter().map(of_load).collect::<Vec<Vec<f64>>>())
        };
        let surfaces: Vec<Vec<SurfaceOutcome>> = models.par_iter().map(solved).collect();
        let mu = |surface: &SurfaceOutcome| {
            surface.mu_dynamic.filter(|mu| *mu != 0.0 && surface.status == Status::Converged)
        };
        for (load, sum) in sums.iter_mut().enumerate() {
            let ratio = mu(&surfaces[0][load]).zip(mu(&surfaces[1][load])).map(|(own, flat)| own / flat);
            *sum = sum.zip(ratio).map(|(sum, ratio)| sum + ratio);
        }
    }
    sums.into_iter().map(|sum| sum.map(|sum: f64| sum / draws as f64)).collect()
}

fn describe(scene: &Scene, face: &Face, pattern: &Pattern, steady: &SteadyFace, said: &mut Statements) {
    let strips = face.strips().len();
    said.model(format!(
        "specimen as it is laid out: cavities take {:.2} % of its face, {:.2} % of a period; {} along the sliding direction with cavities and ends of {} own{}",
        100.0 * face.cavity_share(),
        100.0 * pattern.areal_density(),
        if strips == 1 { "one strip".to_owned() } else { format!("{strips} different strips") },
        if strips == 1 { "its" } else { "their" },
        if scene.layer.is_backed() { "" } else { ", under one rigid bulk" },
    ));
    if face
        .strips()
        .iter()
        .any(|strip| without_slivers(strip.clone(), pattern.depth_m(), scene.layer.block_m) != *strip)
    {
        said.model(
            "walls at the rim that are narrower than the cavities are deep bear nothing: friction would turn them over",
        );
    }
    if scene.is_raised() {
        said.model(RimDifference::statement());
    }
    if steady.shortened > 0 {
        said.method(format!(
            "strips longer than {} mm: both ends and periodic cells between them, which changes the ratio of cavities of whole blocks by less than 1e-5",
            (STRIP_HEIGHTS * scene.layer.height_m * 1e6).round() / 1e3
        ));
    }
    said.method("two dimensions: vertical planes along the sliding direction, plane stress, nu = 1/3");
}

#[cfg(test)]
mod tests;
