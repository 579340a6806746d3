//! Discretization error of the ratio of a steady cell, relative to the limit of vanishing blocks.
//!
//! Ratios are computed in blocks of 2l, l and l/2, or of l, l/2 and l/4 if that is cheap. With the differences d_1 and
//! d_2 between successive sizes, the order of convergence and the remainder after the last size are
//!
//! ```text
//! p = log2 |d_1 / d_2|,   tail = |d_2| / (2^p - 1),   0.5 <= p <= 2
//! ```
//!
//! At the edges of lands the pressure is singular, and at light loads an area law that starts at some pressure depends
//! on these edges only: orders down to one half occur, and differences change sign. The estimate is therefore the sum
//! of the magnitudes of the differences from l on, plus 1.5 tails, the largest over a load and its neighbours. On 40
//! random patterns it is not below the error in 96 % of cases (`tests/validation/blocks.rs`).
//!
//! If lands are raised, the blocks of a rim that touch change irregularly with the block size, and the differences show
//! no order. Then the estimate is twice the standard error
//!
//! ```text
//! s^2 = (d_1 + d_2)^2 + (1.5 d_2)^2,
//! ```
//!
//! which combines the change from blocks of l to blocks of l/4 and the remainder. Cells in space with rims use the
//! differences of a groove whose rims have the same edge length per area: at light loads the edges carry the load, and
//! cells in space in blocks of l/4 are expensive.

use crate::pattern::{Pattern, Planform, Texture};

use super::cavities_in_space::{has_flat_face, refined_by_grooves};
use super::widest;
use crate::springblock::{Dimension, Effect, LoadOutcome, Monitor, Scene, Simulation, SteadyCell, Unwatched};

/// Range of plausible orders of convergence.
const ORDERS: [f64; 2] = [0.5, 2.0];
/// Factor of the tail, the remainder after the last block size, in the estimate.
const TAIL_FACTOR: f64 = 1.5;
/// Remainder after the finest blocks over the last difference d_2 between ratios in successive block sizes, if lands
/// are raised.
///
/// With this value the error over its standard error has a root mean square of 1.15, 1.02, 0.87 and 0.69 at 0.3, 0.65,
/// 1.3 and 2.6 MPa on 28 random grooves with rims 10 to 60 um wide and 0.05 to 1 um high, in blocks of 20, 10 and 5 um.
const RAISED_REMAINDER: f64 = 1.5;
/// How refined ratios follow from those in the finest blocks.
#[derive(Clone, Copy, Debug)]
pub struct Finest {
    /// Change beyond the finest blocks over the last difference d_2.
    beyond: f64,
    /// Factors of |d_2| and of the tail in the error estimate from three block sizes.
    of_three: [f64; 2],
    /// Maximum number of multiplications of a cell in a fourth size, where lands are flat and three sizes suffice.
    max_fourth_products: f64,
    /// Minimum depth of a cavity, in units of the finest affordable blocks.
    min_depth_blocks: f64,
}

/// Factors of |d_2| and of the tail in the error estimate for refined ratios from more than three block sizes: on 40
/// random patterns the estimate is not below the error in 95 % of cases.
const FINEST_FACTORS: [f64; 2] = [2.0, 2.0];

impl Finest {
    /// Extrapolated with p = 1.6, for flat lands in the plane.
    ///
    /// On 40 random patterns in blocks down to 2.5 and to 1.25 um this leaves errors of 0.0008 and 0.0005 in the root mean
    /// square, and as solved 0.0016 and 0.0008. The estimate from three sizes is not below the error in 96 % of cases:
    /// their first two differences are large for other reasons than the singular edges that the finest blocks leave. A
    /// fourth size takes at most some hundredths of a second.
    pub const EXTRAPOLATED: Self =
        Self { beyond: 0.5, of_three: [1.0, 0.5], max_fourth_products: 2e8, min_depth_blocks: MIN_DEPTH_BLOCKS };
    /// As solved, for raised lands, and for grooves that stand for cavities in space. A fourth size takes at most a
    /// quarter of a second: it changes the ratio of the published trial by 1e-4.
    pub const AS_SOLVED: Self =
        Self { beyond: 0.0, of_three: FINEST_FACTORS, max_fourth_products: 1e9, ..Self::EXTRAPOLATED };

    /// Rule for the lands of `scene` in the plane.
    fn of(scene: &Scene) -> Self {
        if scene.is_raised() { Self::AS_SOLVED } else { Self::EXTRAPOLATED }
    }

    /// Ends at larger blocks, for comparisons of many textures. A table of such changes leaves as much of the changes of
    /// the textures that shipped designs solve as one by finer blocks: 0.0003 to 0.0004 of 0.0009 with flat lands, 0.0007
    /// to 0.0008 of 0.0016 with rims, there in a third of the time.
    fn roughly(self) -> Self {
        Self { min_depth_blocks: 1.5, ..self }
    }
}

/// Minimum depth of a cavity, in units of the finest blocks, for an estimate of the remainder.
const MIN_DEPTH_BLOCKS: f64 = 2.0;
/// Block sizes for refined ratios, relative to the layer's blocks, in the order in which they are solved.
const FACTORS: [f64; 6] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125];
/// Number of block sizes that suffice for cavities at least [`MIN_DEPTH_BLOCKS`] deep in the last of these sizes.
const DEEP_LEVELS: usize = 4;
/// Maximum number of multiplications of one steady plane cell for error estimates. Such a cell takes half a second.
pub const MAX_PRODUCTS: f64 = 2e9;
/// Maximum number of multiplications of one steady plane cell for refined ratios. Such a cell takes some seconds.
pub const MAX_REFINEMENT_PRODUCTS: f64 = 2e10;

/// Reason why ratios were not refined: the monitor cancelled.
pub const CANCELLED: &str = "the run was cancelled";
/// Reason why ratios were not refined: too few block sizes, or no error estimate in the scene's own blocks.
const UNKNOWN: &str = "how far they are from those of vanishing blocks is not known";

/// Effect of smaller blocks on a steady cell.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRefinement {
    /// Size of the finest blocks relative to the layer's blocks.
    pub factor: f64,
    /// Ratios in the finest blocks, of flat lands in the plane extrapolated beyond them, minus those in the layer's
    /// blocks, by load.
    pub shifts: Vec<f64>,
    /// Upper bound, with 95 % probability, of the difference of these ratios from those of vanishing blocks, by
    /// load.
    pub errors: Vec<f64>,
}

/// Effect of smaller blocks on the ratios of `scene`, from steady cells that each take at most `most` multiplications.
///
/// In space smaller cells and grooves are used, together with the ratios `own` of the scene's cell. `is_rough` ends at
/// larger blocks in the plane. `None` without a pattern, if fewer than two finer sizes are possible, if a cell has no
/// ratio, and in space with rims or a measured relief.
pub fn block_refinement(scene: &Scene, own: &[Option<f64>], most: f64, is_rough: bool) -> Option<BlockRefinement> {
    let pattern = scene.pattern.as_ref()?;
    if is_rough && scene.dimension() == Dimension::Plane {
        let finest = Finest::of(scene).roughly();
        return refine_in_plane(scene, pattern, (most, finest), &Unwatched).ok().map(|(found, _)| found);
    }
    refinement(scene, pattern, own, most, &Unwatched).ok()
}

/// Whether smaller blocks can refine the ratios of `scene` with `pattern`.
pub fn can_refine(scene: &Scene, pattern: &Pattern) -> bool {
    scene.dimension() == Dimension::Plane || has_flat_face(scene, pattern)
}

/// Effect of smaller blocks on `scene` with `pattern`, from steady cells that each take at most `most` multiplications,
/// or the reason why there is no result. `own` are the scene's ratios, which only cells in space need.
pub fn refinement(
    scene: &Scene,
    pattern: &Pattern,
    own: &[Option<f64>],
    most: f64,
    monitor: &dyn Monitor,
) -> Result<BlockRefinement, String> {
    match scene.dimension() {
        Dimension::Plane => refine_in_plane(scene, pattern, (most, Finest::of(scene)), monitor).map(|(found, _)| found),
        Dimension::Space => refined_by_grooves(scene, pattern, own, most, monitor),
    }
}

/// Ratios by load for one block size; `None` if that size is impossible.
pub type Ratios = Option<Vec<Option<f64>>>;

/// Estimated differences of the ratios of `scene` from the limit of vanishing blocks, by load.
///
/// `own` are the ratios in the scene's own blocks; `ratios` computes ratios in other blocks, or returns `None` if they
/// are too expensive. Returns `None` if two other sizes are not possible, or if a ratio is missing.
pub fn block_error(scene: &Scene, own: &[Option<f64>], ratios: impl Fn(&Scene) -> Ratios) -> Option<Vec<f64>> {
    let by = |factor: f64| with_block_factor(scene, factor).and_then(|scene| ratios(&scene));
    let own = Some(own.to_vec());
    let half = by(0.5);
    let quarter = if half.is_some() { by(0.25) } else { None };
    // Ratios from the largest blocks on, and the index of the own blocks among them.
    let (levels, first) = match (half, quarter) {
        (Some(half), Some(quarter)) => ([own, Some(half), Some(quarter)], 0),
        (Some(half), None) => ([by(2.0), own, Some(half)], 1),
        _ => ([by(4.0), by(2.0), own], 2),
    };
    let [Some(coarse), Some(middle), Some(fine)] = levels else { return None };
    let at = |load: usize| -> Option<f64> {
        let [coarse, middle, fine] = [coarse[load]?, middle[load]?, fine[load]?];
        let differences = [middle - coarse, fine - middle];
        Some(if scene.is_raised() { raised_error(differences, first) } else { error(differences, first) })
    };
    (0..fine.len()).map(at).collect::<Option<Vec<f64>>>().map(|errors| largest_near(&errors, 1))
}

/// Error estimate like [`block_error`] for cells in space with rims, from a groove with equal edge length per area.
/// `None` without rims, and if the cavities are so dense that the groove would have no land.
pub fn edge_groove_error(scene: &Scene, pattern: &Pattern) -> Option<Vec<f64>> {
    let groove = edge_groove(pattern)?;
    let mut plane = Scene { pattern: Some(groove), ..scene.clone() };
    plane.run.dimensions = Some(Dimension::Plane.number());
    let ratios = |scene: &Scene| plane_ratios(scene, &groove, MAX_PRODUCTS);
    block_error(&plane, &ratios(&plane)?, ratios)
}

/// Groove across the sliding direction with the width, depth and rims of `pattern` and equal edge length per area;
/// `None` without rims or land.
fn edge_groove(pattern: &Pattern) -> Option<Pattern> {
    let rim = pattern.texture().rim().filter(|rim| rim.stands())?;
    let spacing_m = 2.0 / pattern.edge_per_area_1_m() - pattern.width_m();
    Pattern::new(Texture::new(Planform::Groove).with_rim(*rim), pattern.width_m(), spacing_m, pattern.depth_m()).ok()
}

/// Adds discretization errors to `loads`, whose cavity fraction is `share` times that of a period. `errors` are those
/// of a steady cell; without them nothing is added.
pub fn set_errors(loads: &mut [LoadOutcome], errors: Option<&[f64]>, share: f64) {
    let none = vec![0.0; loads.len()];
    errors.into_iter().for_each(|errors| set_changes(loads, &none, errors, share));
}

/// Adds the changes `shifts` of a steady cell due to smaller blocks, with the `errors` that remain, both scaled by
/// `share`.
fn set_changes(loads: &mut [LoadOutcome], shifts: &[f64], errors: &[f64], share: f64) {
    for ((load, shift), error) in loads.iter_mut().zip(shifts).zip(errors) {
        // The true difference hardly exceeds the estimate, which is taken as two standard errors.
        load.correct(Effect::Blocks, shift * share, 0.5 * error * share);
    }
}

/// Error estimate from the two differences between the ratios in three block sizes. `first` is the index of the scene's
/// own size among these, 0 for the largest.
fn error(differences: [f64; 2], first: usize) -> f64 {
    let [before, last] = differences.map(f64::abs);
    if last == 0.0 {
        return if first == 0 { before } else { 0.0 };
    }
    [before, last][first.min(2)..].iter().sum::<f64>() + TAIL_FACTOR * tail(differences)
}

/// Like [`error`], for raised lands.
fn raised_error([before, last]: [f64; 2], first: usize) -> f64 {
    let to_finest = match first {
        0 => before + last,
        1 => last,
        _ => 0.0,
    };
    2.0 * to_finest.hypot(RAISED_REMAINDER * last)
}

/// For each load, the largest of the error estimates `errors` at this load and at `reach` loads on either side. Between
/// two loads where the differences change sign, the differences at one load are misleadingly small.
fn largest_near(errors: &[f64], reach: usize) -> Vec<f64> {
    let near = |load: usize| &errors[load.saturating_sub(reach)..(load + reach + 1).min(errors.len())];
    (0..errors.len()).map(|load| near(load).iter().copied().fold(0.0, f64::max)).collect()
}

/// Estimated difference of the ratio in the last of three block sizes from the limit of vanishing blocks (the tail),
/// from the two differences between the ratios in successive sizes.
fn tail([before, last]: [f64; 2]) -> f64 {
    if last == 0.0 {
        return 0.0;
    }
    let order = if before * last > 0.0 { (before / last).log2().clamp(ORDERS[0], ORDERS[1]) } else { ORDERS[0] };
    last.abs() / (order.exp2() - 1.0)
}

/// Ratios of the steady plane cell of `pattern` by load; `None` if it takes `most` multiplications or more.
pub fn plane_ratios(scene: &Scene, pattern: &Pattern, most: f64) -> Ratios {
    let model = SteadyCell::with_dimension(scene, Dimension::Plane);
    (model.products(pattern) < most).then(|| model.ratios(pattern))
}

/// Refines the ratios of `simulation`, whose cavity fraction is `share` times that of a period, by the effect of
/// smaller blocks on the steady cell, if `scene` requests it and the error decreases. Adds a statement on the
/// refinement, or the reason why there is none. Once `monitor` has cancelled, the simulation becomes a cancelled one.
pub fn refine(scene: &Scene, pattern: &Pattern, share: f64, simulation: &mut Simulation, monitor: &dyn Monitor) {
    if !scene.run.refine {
        return;
    }
    let own: Vec<Option<f64>> = simulation.loads.iter().map(|load| load.ratio()).collect();
    let found = refinement(scene, pattern, &own, MAX_REFINEMENT_PRODUCTS, monitor);
    if monitor.cancelled() {
        *simulation = super::cancelled(scene);
        return;
    }
    apply_refinement(scene, found, share, simulation);
}

/// Applies the refinement `found` to `simulation`, as in [`refine`].
pub fn apply_refinement(
    scene: &Scene,
    found: Result<BlockRefinement, String>,
    share: f64,
    simulation: &mut Simulation,
) {
    let Simulation { loads, statements } = simulation;
    let block_m = scene.layer.block_m;
    match found.and_then(|found| require_improvement(loads, found, share, block_m)) {
        Ok(BlockRefinement { factor, shifts, errors }) => {
            set_changes(loads, &shifts, &errors, share);
            let cell = match scene.dimension() {
                Dimension::Plane if scene.is_raised() => "the steady cell with",
                Dimension::Plane => "the steady cell, extrapolated from",
                Dimension::Space => {
                    "steady cells (in space as far as they take a second; then in the plane, of grooves of equal width, depth and share of the face) with"
                }
            };
            statements.method(format!(
                "blocks of {} um: their ratio plus the change of {cell} blocks of {} um, {:+.4} at most and known to \
                 {:.4}; pressures and the interface are those of the larger blocks",
                um(block_m),
                um(block_m * factor),
                widest(shifts.iter().copied()) * share,
                share * errors.iter().copied().fold(0.0, f64::max),
            ));
        }
        Err(reason) => statements.model(format!(
            "refine = true changes nothing: ratios stay those of blocks of {} um, since {reason}",
            um(block_m)
        )),
    }
}

/// Returns the refinement `found` if it reduces the error of `loads`, which were solved in blocks of `block_m`, and the
/// reason to refuse it otherwise.
fn require_improvement(
    loads: &[LoadOutcome],
    found: BlockRefinement,
    share: f64,
    block_m: f64,
) -> Result<BlockRefinement, String> {
    let stated = loads.iter().filter_map(|load| Some(2.0 * load.correction(Effect::Blocks)?.std?)).reduce(f64::max);
    let stated = stated.ok_or(UNKNOWN)?;
    let most = share * found.errors.iter().copied().fold(0.0, f64::max);
    if most < stated {
        return Ok(found);
    }
    let finest_um = um(block_m * found.factor);
    Err(format!("blocks of {finest_um} um would leave them open by {most:.4}, these by {stated:.4}"))
}

fn um(length_m: f64) -> f64 {
    (length_m * 1e9).round() / 1e3
}

/// Effect of vanishing blocks in the vertical plane, and the ratios in the blocks of `scene`, by load; or the reason why
/// there is no result. Cells take at most `most` multiplications; ratios follow from the finest possible blocks as in
/// `finest`.
pub fn refine_in_plane(
    scene: &Scene,
    pattern: &Pattern,
    (most, finest): (f64, Finest),
    monitor: &dyn Monitor,
) -> Result<(BlockRefinement, Vec<f64>), String> {
    let at = |factor: f64, most: f64| -> Result<Vec<f64>, String> {
        let of_blocks = format!("blocks of {} um", um(factor * scene.layer.block_m));
        monitor.heed().map_err(|_| CANCELLED)?;
        let finer = with_block_factor(scene, factor);
        let finer = finer.ok_or_else(|| format!("the layer cannot be cut into {of_blocks}"))?;
        let ratios = plane_ratios(&finer, pattern, most);
        let ratios = ratios.ok_or_else(|| format!("steady cells in {of_blocks} are too dear"))?;
        let found: Option<Vec<f64>> = ratios.into_iter().collect();
        found.ok_or_else(|| format!("the steady cell in {of_blocks} has no ratio at some load"))
    };
    let is_deep = |factor: f64| pattern.depth_m() >= finest.min_depth_blocks * factor * scene.layer.block_m;
    let mut levels: Vec<Vec<f64>> = Vec::new();
    let mut ended = None;
    for factor in FACTORS {
        let suffices = levels.len().checked_sub(1).is_some_and(|last| is_deep(FACTORS[last]));
        if levels.len() >= DEEP_LEVELS && suffices {
            break;
        }
        let is_spare = levels.len() + 1 == DEEP_LEVELS && suffices && !scene.is_raised();
        match at(factor, if is_spare { most.min(finest.max_fourth_products) } else { most }) {
            Ok(level) => levels.push(level),
            Err(reason) => {
                ended = Some(reason);
                break;
            }
        }
    }
    let [.., coarse, middle, fine] = &levels[..] else { return Err(ended.unwrap_or_else(|| UNKNOWN.to_owned())) };
    let [of_last, of_tail] = if levels.len() < DEEP_LEVELS { finest.of_three } else { FINEST_FACTORS };
    let left = |load: usize| {
        let differences @ [_, last] = [middle[load] - coarse[load], fine[load] - middle[load]];
        of_last * last.abs() + of_tail * tail(differences)
    };
    let shift = |load: usize| fine[load] + finest.beyond * (fine[load] - middle[load]) - levels[0][load];
    let shifts = (0..fine.len()).map(shift).collect();
    let factor = FACTORS[levels.len() - 1];
    if pattern.depth_m() < finest.min_depth_blocks * factor * scene.layer.block_m {
        let [depth_um, finest_um] = [pattern.depth_m(), factor * scene.layer.block_m].map(um);
        return Err(format!(
            "cavities {depth_um} um deep are shallower than two of the finest blocks, of {finest_um} um"
        ));
    }
    // With raised lands, the load at which they touch affects the errors at every load.
    let reach = if scene.is_raised() { fine.len() } else { 1 };
    let errors = largest_near(&(0..fine.len()).map(left).collect::<Vec<f64>>(), reach);
    Ok((BlockRefinement { factor, shifts, errors }, levels.swap_remove(0)))
}

/// Returns the cell of `scene` with blocks `factor` times as large; the layer height replaces the specimen's length.
/// `None` if the blocks do not divide the layer height, leave at most one row above the cavities, or make the scene
/// invalid.
pub fn with_block_factor(scene: &Scene, factor: f64) -> Option<Scene> {
    let mut other = scene.clone();
    other.layer.block_m *= factor;
    // A cell does not depend on the specimen's length, which must only be a whole number of blocks.
    other.layer.length_m = other.layer.height_m;
    let depth_m = scene.pattern.as_ref().map_or(0.0, Pattern::depth_m);
    (other.layer.height_m - other.layer.block_m > depth_m && other.validate().is_ok()).then_some(other)
}

#[cfg(test)]
mod tests;
