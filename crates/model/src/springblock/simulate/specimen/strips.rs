//! Steady sliding of a face, strip by strip.

use std::convert::Infallible;

use crate::pattern::Pattern;
use rayon::prelude::*;
use slipgrid_base::monitor::cached;

use super::super::rim_difference::{self, without_rim};
use super::super::{UNIFORM_COLUMNS, compare, require_memory};
use super::without_thickness;
use crate::springblock::steady::factor_bytes;
use crate::springblock::{
    Effect, Face, Lattice, Layer, Load, LoadOutcome, Monitor, Scene, SceneError, Status, SteadyLoad, SteadyModel,
    Strip, SurfaceOutcome, columns,
};

/// Maximum length of a strip that is solved whole, in heights of the layer.
///
/// If a strip is longer, both ends are solved, half of that length each, and the part between is replaced by periodic
/// cells. The effect of an end decays within one height, so that the error of the ratio is below 2e-5
/// (`strips_are_their_ends_and_cells_between_them`; strips of 15 heights halve it, strips of 6 double it). If cavities are not whole blocks, the cavities of a whole strip
/// have different positions relative to the blocks; the cavity of the cell has one position, with a known effect of
/// smaller blocks (`cells_between_ends_take_strips_to_smaller_blocks`).
pub const STRIP_HEIGHTS: f64 = 10.0;
/// Maximum length of the flat strip whose ends are those of the flat face, in heights of the layer.
const FLAT_HEIGHTS: f64 = 15.0;
/// Minimum width of land at the end of a strip that a lattice resolves, in blocks.
const MIN_END_BLOCKS: f64 = 2.0;

/// Part of the face that is solved on one lattice.
struct Piece {
    /// Index of the band of its strip.
    band: usize,
    /// Area that the piece represents, in square metres.
    area_m2: f64,
    /// Area of the cavities, in square metres.
    cavity_area_m2: f64,
    /// Index of its lattice; equal lattices have one index.
    lattice: usize,
}

/// Parts of a face before they are solved.
#[derive(Default)]
struct Plan {
    pieces: Vec<Piece>,
    /// Different lattices of the pieces.
    lattices: Vec<Lattice>,
    /// Number of strips that were shortened by whole periods.
    shortened: usize,
}

/// Outcomes of steady sliding of the whole face with mean local coefficients, by load.
pub struct SteadyFace {
    pub loads: Vec<LoadOutcome>,
    /// Number of strips that were shortened by whole periods.
    pub shortened: usize,
    /// Peak pressure of any strip over that of the longest one with cavities, at the load where this is largest.
    pub peak_over_longest: f64,
}

/// Removes whole periods from a `strip` longer than [`STRIP_HEIGHTS`] layer heights; returns the rest and the removed
/// length, in metres.
pub fn shortened(strip: &Strip, layer: &Layer) -> (Strip, f64) {
    let most_m = STRIP_HEIGHTS * layer.height_m;
    let cavities = &strip.cavities_m;
    if strip.length_m <= most_m {
        return (strip.clone(), 0.0);
    }
    let Some(periods) = cavities.len().checked_sub(1).filter(|periods| *periods > 0) else {
        let kept = cavities.is_empty();
        // Without cavities land can be removed; with one cavity nothing is removed.
        return if kept {
            (Strip { length_m: most_m, ..strip.clone() }, strip.length_m - most_m)
        } else {
            (strip.clone(), 0.0)
        };
    };
    let pitch_m = (cavities[periods][0] - cavities[0][0]) / periods as f64;
    // Whole periods, at most those between the first and the last cavity.
    let left_out = (((strip.length_m - most_m) / pitch_m).ceil().max(0.0) as usize).min(periods - 1);
    let first = (cavities.len() - left_out).div_ceil(2);
    let out_m = left_out as f64 * pitch_m;
    let ends = cavities[..first]
        .iter()
        .copied()
        .chain(cavities[first + left_out..].iter().map(|[start_m, end_m]| [start_m - out_m, end_m - out_m]));
    (Strip { length_m: strip.length_m - out_m, cavities_m: ends.collect(), ..strip.clone() }, out_m)
}

/// Minimum width, in metres, of land between a cavity and an end of a strip; narrower land is removed.
pub fn min_wall_m(depth_m: f64, block_m: f64) -> f64 {
    depth_m.max(MIN_END_BLOCKS * block_m)
}

/// Removes land between a cavity and the ends of `strip` that is narrower than [`min_wall_m`]. On such a slender wall
/// friction raises the pressure, higher pressure raises friction, and there is no equilibrium.
pub fn without_slivers(mut strip: Strip, depth_m: f64, block_m: f64) -> Strip {
    let least_m = min_wall_m(depth_m, block_m);
    let length_m = strip.length_m;
    if let Some(first) = strip.cavities_m.first_mut().filter(|first| first[0] < least_m) {
        first[0] = 0.0;
    }
    if let Some(last) = strip.cavities_m.last_mut().filter(|last| length_m - last[1] < least_m) {
        last[1] = length_m;
    }
    strip
}

impl Plan {
    /// Divides `face` into parts with the blocks of `layer`.
    fn new(layer: &Layer, pattern: &Pattern, face: &Face) -> Self {
        let (block_m, rows) = (layer.block_m, layer.rows());
        let blocks = |strip: &Strip| -> Vec<[f64; 2]> {
            strip.cavities_m.iter().map(|ends_m| ends_m.map(|at_m| at_m / block_m)).collect()
        };
        // Rounding to a billionth of a row removes the rounding errors of decimal numbers in files.
        let depth = (pattern.depth_m() / block_m * 1e9).round() * 1e-9;
        let cavity_m2 = |strip: &Strip| strip.cavity_length_m() * strip.width_m;
        let mut plan = Self::default();
        for strip in face.strips() {
            let (kept, out_m) = shortened(strip, layer);
            let bearing = without_slivers(kept.clone(), pattern.depth_m(), block_m);
            let ends = Lattice::new(columns::strip(kept.length_m / block_m, &blocks(&bearing), depth), rows, false);
            plan.add(strip.band, [kept.area_m2(), cavity_m2(&kept)], ends);
            if out_m > 0.0 {
                plan.shortened += 1;
                let middle = if kept.cavities_m.is_empty() {
                    columns::flat(UNIFORM_COLUMNS)
                } else {
                    columns::cell(pattern, block_m)
                };
                let cavity_area_m2 = cavity_m2(strip) - cavity_m2(&kept);
                plan.add(strip.band, [out_m * strip.width_m, cavity_area_m2], Lattice::new(middle, rows, true));
            }
        }
        plan
    }

    fn add(&mut self, band: usize, [area_m2, cavity_area_m2]: [f64; 2], lattice: Lattice) {
        let known = self.lattices.iter().position(|known| *known == lattice);
        let place = known.unwrap_or(self.lattices.len());
        if known.is_none() {
            self.lattices.push(lattice);
        }
        self.pieces.push(Piece { band, area_m2, cavity_area_m2, lattice: place });
    }

    /// Returns the memory, in bytes, of the equations of all parts; refuses them if they do not fit in memory.
    fn affordable(&self) -> Result<f64, SceneError> {
        let bytes = |lattice: &Lattice| factor_bytes(lattice.nx(), lattice.ny(), lattice.is_periodic());
        require_memory(self.lattices.iter().map(bytes).sum())
    }
}

/// Memory of the equations of `face` with the blocks of `layer`, in bytes.
///
/// # Errors
/// [`SceneError::TooLarge`], as in [`SteadyFace::new`].
pub fn face_bytes(layer: &Layer, pattern: &Pattern, face: &Face) -> Result<f64, SceneError> {
    Plan::new(layer, &without_rim(pattern), face).affordable()
}

impl SteadyFace {
    /// Solves the layer of `scene` on `face`; `None` once `monitor` has cancelled.
    pub fn new(
        scene: &Scene,
        pattern: &Pattern,
        face: &Face,
        monitor: &dyn Monitor,
    ) -> Result<Option<Self>, SceneError> {
        // Strips are solved with flat lands; the effect of rims is that on the cell of the whole thickness.
        let rims = rim_difference::of_rims(scene, pattern);
        let (scene, pattern) = (&without_thickness(scene), &without_rim(pattern));
        let plan = Plan::new(&scene.layer, pattern, face);
        plan.affordable()?;
        let model = |lattice: Lattice| monitor.heed().ok().map(|()| SteadyModel::for_scene(scene, lattice));
        let models: Option<Vec<SteadyModel>> = plan.lattices.into_par_iter().map(model).collect();
        let Some(models) = models else { return Ok(None) };
        // P_s = k_s d with sum A_s P_s = P sum A_s
        let stiffness: Vec<f64> = models.iter().map(SteadyModel::stiffness_per_length).collect();
        let area_m2: f64 = plan.pieces.iter().map(|piece| piece.area_m2).sum();
        let carried: f64 = plan.pieces.iter().map(|piece| piece.area_m2 * stiffness[piece.lattice]).sum();
        let shares: Vec<f64> = stiffness.iter().map(|own| own * (area_m2 / carried)).collect();
        let solved =
            |(model, share): (&SteadyModel, &f64)| Some(solve(scene, model, *share)).filter(|_| !monitor.cancelled());
        let by_lattice: Option<Vec<Vec<SurfaceOutcome>>> = models.par_iter().zip(&shares).map(solved).collect();
        let Some(by_lattice) = by_lattice else { return Ok(None) };
        let flat = flat_face(scene, face, monitor);
        let mut peak_over_longest = 1.0_f64;
        let each = scene.loads.iter().zip(flat).enumerate().map(|(place, (load, flat))| {
            let parts = plan.pieces.iter().map(|piece| SolvedPiece {
                piece,
                columns: models[piece.lattice].lattice().nx(),
                pressure_share: shares[piece.lattice],
                surface: &by_lattice[piece.lattice][place],
            });
            let parts: Vec<SolvedPiece<'_>> = parts.collect();
            let outcome = face_load(face, &parts, flat, load);
            let peak_pa = parts.iter().map(|part| part.surface.peak_pressure_pa).fold(0.0, f64::max);
            let ratio = peak_pa / outcome.surface.peak_pressure_pa;
            // A longest strip without a solution has no pressure.
            if ratio.is_finite() {
                peak_over_longest = peak_over_longest.max(ratio);
            }
            outcome
        });
        let mut loads: Vec<LoadOutcome> = each.collect();
        rim_difference::add(&rims, face.share_of(pattern), &mut loads);
        Ok(Some(Self { loads, shortened: plan.shortened, peak_over_longest }))
    }
}

/// Piece of a face under one load.
struct SolvedPiece<'a> {
    piece: &'a Piece,
    /// Number of columns of its lattice.
    columns: usize,
    /// Pressure relative to the nominal pressure, P_s / P.
    pressure_share: f64,
    surface: &'a SurfaceOutcome,
}

/// Solves steady sliding on `model` at each load of `scene`, with `share` times the pressure and the mean coefficient
/// of the load.
pub fn solve(scene: &Scene, model: &SteadyModel, share: f64) -> Vec<SurfaceOutcome> {
    let columns = model.lattice().nx();
    let of_load = |load: &Load| vec![load.friction.dynamic_mean(); columns];
    solve_drawn(scene, model, share, &scene.loads.iter().map(of_load).collect::<Vec<_>>())
}

/// Like [`solve`] with the dynamic coefficients `dynamic_mu`: per load a list with one value per column.
pub fn solve_drawn<'a>(
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

/// Solves the flat `face` under each load of `scene`. Friction is uniform except near the ends of its strips: the two
/// ends change the friction force per width equally on every strip. They are those of the longest strip, of at most
/// [`FLAT_HEIGHTS`] layer heights, and cached, because every pattern on the face has the same.
fn flat_face(scene: &Scene, face: &Face, monitor: &dyn Monitor) -> Vec<SurfaceOutcome> {
    let Layer { height_m, block_m, .. } = scene.layer;
    let length_m = face.longest().length_m.min(FLAT_HEIGHTS * height_m);
    let lattice = Lattice::new(columns::strip(length_m / block_m, &[], 0.0), scene.layer.rows(), false);
    let content = (&lattice, block_m, scene.elastic, &scene.area_law, &scene.loads, scene.run.liftoff);
    let solve = || Ok::<_, Infallible>(solve(scene, &SteadyModel::for_scene(scene, lattice.clone()), 1.0));
    let Ok(strip) = cached(monitor, ("flat face", &content), 0.0, solve);
    let sum = |of: fn(&Strip) -> f64| face.strips().iter().map(of).sum::<f64>();
    let ends_per_m = sum(|strip| strip.width_m) / sum(Strip::area_m2);
    let of_load = |(load, own): (&Load, SurfaceOutcome)| {
        let uniform = load.flat_mu(scene.area_law.as_ref());
        // mu = mu_u + (mu_1 - mu_u) L_1 sum w_s / sum w_s L_s
        let mu_dynamic = own.mu_dynamic.map(|mu| uniform + (mu - uniform) * length_m * ends_per_m);
        SurfaceOutcome { mu_dynamic, ..own }
    };
    scene.loads.iter().zip(strip).map(of_load).collect()
}

/// Combines the outcomes of `parts` and the outcome `flat` of the flat face under one load.
fn face_load(face: &Face, parts: &[SolvedPiece<'_>], flat: SurfaceOutcome, load: &Load) -> LoadOutcome {
    let (ratio, sampling_error) = face_ratio(face, parts, flat.mu_dynamic).unzip();
    let longest = parts.iter().max_by_key(|part| (part.piece.cavity_area_m2 > 0.0, part.columns));
    let surfaces = || parts.iter().map(|part| part.surface);
    let worst = surfaces().map(|surface| surface.status).max();
    let most = |of: fn(&SurfaceOutcome) -> f64| surfaces().map(of).fold(0.0, f64::max);
    let surface = SurfaceOutcome {
        status: worst.unwrap_or(Status::Converged),
        residual: Some(most(|surface| surface.residual.unwrap_or(0.0))),
        tension_blocks: surfaces().map(|surface| surface.tension_blocks).sum(),
        cavity_closed: surfaces().any(|surface| surface.cavity_closed),
        clearance_m: surfaces().filter_map(|surface| surface.clearance_m).reduce(f64::min),
        area_law_extrapolated: surfaces().any(|surface| surface.area_law_extrapolated),
        iterations: surfaces().map(|surface| surface.iterations).max().unwrap_or(0),
        mu_dynamic: ratio.zip(flat.mu_dynamic).map(|(ratio, mu)| ratio * mu),
        ..longest.map_or_else(|| flat.clone(), |part| part.surface.clone())
    };
    let mut outcome = compare(load, surface, Some(flat));
    outcome.correct(Effect::Layout, 0.0, sampling_error);
    outcome
}

/// Friction ratio of the face to the flat face with the coefficient `flat_mu`, and the standard error of sampling the
/// face by strips, from the deviations of the bands from a friction reduction proportional to their cavities; `None`
/// without a ratio.
fn face_ratio(face: &Face, parts: &[SolvedPiece<'_>], flat_mu: Option<f64>) -> Option<(f64, f64)> {
    let flat_mu = flat_mu.filter(|mu| *mu != 0.0)?;
    let area_m2: f64 = parts.iter().map(|part| part.piece.area_m2).sum();
    // By band: reduction of the ratio, and area of cavities over the area of the face.
    let mut bands = vec![[0.0; 2]; face.bands()];
    for SolvedPiece { piece, pressure_share, surface, .. } in parts {
        let [lowered, share] = &mut bands[piece.band];
        *lowered += piece.area_m2 * pressure_share * (1.0 - surface.mu_dynamic? / flat_mu) / area_m2;
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
