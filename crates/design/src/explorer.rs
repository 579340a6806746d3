//! What any design within the bounds does, as a response surface that a page can ask: no search, no solver.
//!
//! Grooves are solved on a lattice of widths, spacings and depths. In space large blocks give the shape of the surface and a few cells
//! in the layer's own blocks lift it to where it belongs. The error is measured at designs that are no nodes.

mod rims;

use std::iter;

use rayon::prelude::*;
use slipgrid_optimize::{DesignSpace, ModelFailure, Quantity};
use slipgrid_pattern::{Pattern, Texture};
use slipgrid_results::MaterialReport;
use slipgrid_statistics::{Axis, Normals, ResponseSurface, median, normal_probability};
use slipgrid_units::LENGTH_UM;

pub use self::rims::RimChanges;
use self::rims::{factors, rim_changes};
use crate::DesignError;
use crate::chance::{About, Chances, Numerical};
use crate::kept_nodes::kept;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::steady_model::{Endless, SteadyModel};
use crate::task::{DesignTask, KnownMaterial};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;
use slipgrid_monitor::{Monitor, Part, Stage};
use slipgrid_springblock::{Load, expense};

/// Nodes along width, spacing and depth for each factor e between the bounds, and the most of them, in the vertical plane; in space
/// of large blocks, and of the layer's own.
const PLANE_NODES: Nodes = Nodes { each: [8.0, 6.0, 3.4], most: [20, 20, 12] };
const COARSE_NODES: Nodes = Nodes { each: [5.0, 4.0, 2.0], most: [12, 12, 7] };
const FINE_NODES: Nodes = Nodes { each: [3.0, 3.0, 1.5], most: [5, 5, 3] };
/// Designs at which the error is measured: as many as there are nodes, within these limits; in space.
const PLANE_CHECKS: [usize; 2] = [200, 1000];
const SPACE_CHECKS: usize = 50;
/// Of these, how many are asked between the target's pressures, and in how many parts each two of them are divided.
const PLANE_BETWEEN: (usize, usize) = (50, 8);
const SPACE_BETWEEN: (usize, usize) = (8, 4);
/// Most nodes that may have no answer: they get their neighbour's.
const MOST_LEFT_OUT: f64 = 0.05;
/// Nodes that are asked before those without an answer are counted again: where there are too many, the rest is not asked.
const AT_ONCE: usize = 128;
/// Why there is no explorer where they are more.
const TOO_FEW: &str = "no explorer: more than 5 % of the designs within the bounds have no answer, as where cavities close under the load";
/// Seconds of one core, roughly, beyond which designs in space are not asked for an explorer alone.
const MOST_CORE_S: f64 = 6.0;
/// Why there is none then.
const TOO_DEAR: &str = "no explorer: the designs within the bounds, in space, would take one core longer than six seconds; slipgrid explore asks them all the same";
/// Draws behind the covariance of the errors.
const DRAWS: usize = 2000;

/// How many nodes an axis gets.
struct Nodes {
    each: [f64; 3],
    most: [usize; 3],
}

/// How far the surface is from the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceError {
    /// Designs at which both were asked.
    pub points: usize,
    /// Median over them of the largest difference at any load, in the target's quantity.
    pub median: f64,
    /// The largest.
    pub worst: f64,
    /// How far straight lines between the target's pressures are from the ratios that the solver finds there, at most; `None` with one
    /// pressure, and where that is not known.
    pub between: Option<f64>,
}

/// A design's values anywhere within the bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Explorer {
    /// By width, spacing and depth in micrometres: the target's quantity of an endless pattern at each pressure.
    pub values: ResponseSurface,
    /// By the same: the logarithm of the largest local pressure over MPa, over the target's pressures, and how far ceilings come down
    /// in micrometres: where that is the depth, cavities close under the load, and there is no answer.
    pub peak_and_sag: ResponseSurface,
    /// By width and spacing, at any depth: share of a period that is cavity.
    pub areal_density: ResponseSurface,
    /// What rims of other heights change; `None` without rims, and in space.
    pub rims: Option<RimChanges>,
    /// Its error against the solver, where there are rims of any height between those of `rims`.
    pub error: SurfaceError,
    /// What is added to the values, one a pressure: with it they are at the design found what was predicted of it.
    pub offset: Vec<f64>,
    /// Covariance of the values' errors at the design found, one row a pressure; empty where they are not known.
    pub covariance: Vec<Vec<f64>>,
}

/// Where the surface is anchored.
pub struct Anchor<'a> {
    /// The design found.
    pub design: &'a Pattern,
    /// What the corrected model says of it, the first a pressure.
    pub values: &'a [f64],
    /// What its errors are, where anything is known of them.
    pub chances: Option<&'a Chances<'a>>,
    /// How exactly the values were computed.
    pub numerical: &'a Numerical,
}

/// What a task's designs do, before any is searched.
#[derive(Clone, Debug)]
pub struct Explored {
    /// The task.
    pub task: DesignTask,
    /// Its material.
    pub material: KnownMaterial,
    /// The design in the middle of the bounds.
    pub pattern: Pattern,
    /// The loads.
    pub loads: Vec<Load>,
    /// Friction of the flat surface in steady sliding at each load; of a target that is friction itself what ratios are multiplied by.
    pub flat_mu: Vec<f64>,
    /// Which of the pressures lie outside those at which friction was measured, in words.
    pub beyond_measured: Option<String>,
    /// What any design does.
    pub explorer: Explorer,
}

impl Explored {
    /// What makes its numbers doubtful, in words.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let material = MaterialReport::from(&self.material.material.provenance);
        self.beyond_measured.clone().into_iter().chain(material.doubts()).collect()
    }
}

/// What the designs of `task` do at the condition that it is designed for, by the steady model alone.
///
/// # Errors
/// [`DesignError`] for a task that is refused or that the monitor cancels, and where too many designs cannot be computed.
pub fn explore_bounds(task: &DesignTask, monitor: &dyn Monitor) -> Result<Explored, DesignError> {
    let known = task.material.clone().ok_or_else(|| DesignError::refused("has no material"))?;
    let mut task = task.clone();
    task.check(&known)?;
    let task = &task;
    let (loads, outside) = task.loads(&known.material)?;
    let beyond_measured = task.beyond_measured(&known.material, &outside);
    let budget = TimeBudget::new(monitor, None);
    let scene = (task, &known.material, loads.clone());
    let found =
        MultiFidelityLoop::new(scene.0, scene.1, scene.2, Vec::new(), budget, monitor, &mut Timings::default())?;
    let pattern = task
        .space
        .middle()
        .map_err(|error| DesignError::refused(format!("the middle of the bounds is no pattern: {error}")))?;
    let middle = found.model.endless(&pattern, false).map_err(|failure| DesignError::Failed(failure.to_string()))?;
    let values = middle.values;
    let of_flat = |(place, load): (usize, &Load)| match task.target.quantity() {
        Quantity::Ratio => load.flat_mu(found.model.area_law()),
        _ => found.model.scale(place),
    };
    let flat_mu = loads.iter().enumerate().map(of_flat).collect();
    let stage = budget.stage("explorer");
    let anchor = Anchor { design: &pattern, values: &values, chances: None, numerical: &Numerical::default() };
    let explorer = explore(task, &found.model, &anchor, &stage);
    stage.finish();
    monitor.heed()?;
    let explorer = explorer.ok_or_else(|| DesignError::Failed(TOO_FEW.to_owned()))?;
    Ok(Explored { task: task.clone(), material: known, pattern, loads, flat_mu, beyond_measured, explorer })
}

/// Solves the surface by `model` and measures its error; `None` where `bar` has cancelled, or too many designs cannot be computed.
pub fn explore(design: &DesignTask, model: &SteadyModel, anchor: &Anchor<'_>, bar: &Stage<'_>) -> Option<Explorer> {
    let is_guided = model.guide().is_some();
    let axes = axes(&design.space, if is_guided { &COARSE_NODES } else { &PLANE_NODES });
    let texture = *design.space.texture();
    let rim =
        texture.rim().copied().filter(|rim| !is_guided && rim.heights_m().iter().any(|[_, height_m]| *height_m > 0.0));
    let shares = match rim {
        _ if is_guided => [0.2, 0.6, 0.2],
        Some(_) => [0.5, 0.4, 0.1],
        None => [0.8, 0.0, 0.2],
    };
    let ask = |nodes: &[[f64; 3]], coarse: bool, share: f64| {
        ask(model, &|_| texture, nodes, (coarse, MOST_LEFT_OUT), (bar, share))
    };

    let nodes = ResponseSurface::nodes(&axes);
    let mut all = whole(ask(&nodes, is_guided, shares[0])?, &axes)?;
    if is_guided {
        let axes = self::axes(&design.space, &FINE_NODES);
        let few = ResponseSurface::nodes(&axes);
        let (fine, coarse) = (ask(&few, false, shares[1])?, ask(&few, true, 0.0)?);
        // A node without an answer has its neighbour's change, not that of another answer.
        let difference = fine.into_iter().zip(coarse).map(|(fine, coarse)| Some(fine?.over(&coarse?)));
        let lift = surfaces(axes, &whole(difference.collect(), &axes)?);
        for (at, answer) in nodes.iter().zip(&mut all) {
            answer.values.iter_mut().zip(lift.0.at(at)).for_each(|(value, lift)| *value += lift);
            let beside = lift.1.at(at);
            answer.peak_mpa *= beside[0].exp();
            answer.sag_um += beside[1];
        }
    }
    let (values, peak_and_sag) = surfaces(axes, &all);
    let rims = match rim {
        Some(rim) => Some(rim_changes(design, model, rim, (bar, shares[1]))?),
        None => None,
    };

    let [fewest, most] = PLANE_CHECKS;
    let count = if is_guided { SPACE_CHECKS } else { nodes.len().clamp(fewest, most) };
    let checks = checks(&axes, count, design.seed);
    let factors = factors(rims.as_ref(), count, design.seed);
    let of = |place: usize| rim.map_or(texture, |rim| texture.with_rim(rim.times(factors[place])));
    let mut off: Vec<f64> = self::ask(model, &of, &checks, (false, 1.0), (bar, shares[2]))?
        .into_iter()
        .zip(checks.iter().zip(&factors))
        .filter_map(|(answer, (at, factor))| {
            let exact = answer.filter(|answer| !answer.is_closed(at[2]))?.values;
            let change =
                rims.as_ref().map_or_else(Vec::new, |rims| rims.at(at, *factor)).into_iter().chain(iter::repeat(0.0));
            let found = values.at(at).into_iter().zip(change).map(|(found, change)| found + change);
            Some(exact.iter().zip(found).map(|(exact, found)| (exact - found).abs()).fold(0.0, f64::max))
        })
        .collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    let between = off_between(model, &texture, &checks, bar);
    let error = SurfaceError { points: off.len(), median: median(&mut off)?, worst, between };

    let own = lengths_um(anchor.design);
    let offset = values.at(&own).iter().zip(anchor.values).map(|(found, predicted)| predicted - found).collect();
    let density = |at: &[f64; 3]| pattern(&texture, at).map_or(0.0, |pattern| pattern.areal_density());
    let [width, spacing, depth] = axes;
    let level = [width, spacing, Axis { nodes: 1, ..depth }];
    let densities = ResponseSurface::nodes(&level).iter().map(density).collect();
    let covariance = covariance(anchor, design.seed).unwrap_or_default();
    let areal_density = ResponseSurface::through(level, 1, densities);
    Some(Explorer { values, peak_and_sag, areal_density, rims, error, offset, covariance })
}

/// The explorer beside a search, and why there is none where that is not a matter of time.
pub(crate) fn explore_beside(
    design: &DesignTask,
    model: &SteadyModel,
    anchor: &Anchor<'_>,
    bar: &Stage<'_>,
) -> (Option<Explorer>, Option<&'static str>) {
    if !design.explorer {
        return (None, None);
    }
    let (explorer, reason) =
        if is_too_dear(design, model) { (None, TOO_DEAR) } else { (explore(design, model, anchor, bar), TOO_FEW) };
    let is_missing = explorer.is_none() && !bar.is_out_of_time();
    (explorer, is_missing.then_some(reason))
}

/// Whether the designs that an explorer asks take longer than it is worth beside a search: of those in space, by their cells' columns.
fn is_too_dear(design: &DesignTask, model: &SteadyModel) -> bool {
    if model.guide().is_none() {
        return false;
    }
    let nodes = ResponseSurface::nodes(&axes(&design.space, &FINE_NODES));
    let texture = design.space.texture();
    let scenes = nodes.iter().filter_map(|node| Some(model.scene(&pattern(texture, node)?)));
    let core_s: f64 = scenes.map(|scene| expense(&scene).core_s).sum();
    core_s * (nodes.len() + SPACE_CHECKS) as f64 > MOST_CORE_S * nodes.len() as f64
}

fn axes(space: &DesignSpace, nodes: &Nodes) -> [Axis; 3] {
    let bounds = space.lengths_m().map(|bounds| bounds.map(|m| LENGTH_UM.from_si(m)));
    std::array::from_fn(|axis| {
        let [from, to] = bounds[axis];
        // At most some dozens: the cast is exact.
        let wanted = 1 + (nodes.each[axis] * (to / from).ln()).ceil() as usize;
        Axis::new(bounds[axis], wanted.min(nodes.most[axis]))
    })
}

fn pattern(texture: &Texture, lengths_um: &[f64; 3]) -> Option<Pattern> {
    let [width_m, spacing_m, depth_m] = lengths_um.map(|um| LENGTH_UM.to_si(um));
    Pattern::new(*texture, width_m, spacing_m, depth_m).ok()
}

/// Width, spacing and depth of `pattern`, in micrometres.
fn lengths_um(pattern: &Pattern) -> [f64; 3] {
    pattern.lengths_m().map(|m| LENGTH_UM.from_si(m))
}

/// What the model says of each of `nodes`, of the texture that `texture` has for its place, in its guide's blocks where `coarse`,
/// as `share` of a stage; `None` once it is cancelled, or more than the share `most_missing` has no answer, those whose cavities close
/// among them: of these the values go on behind where they close, so that the surface is smooth up to there. Nodes are asked far
/// from one another first, as those without an answer lie together.
fn ask(
    model: &SteadyModel,
    texture: &(impl Fn(usize) -> Texture + Sync),
    nodes: &[[f64; 3]],
    (coarse, most_missing): (bool, f64),
    (bar, share): (&Stage<'_>, f64),
) -> Option<Vec<Option<Endless>>> {
    let one = |place: &usize| {
        let (place, lengths_um) = (*place, &nodes[*place]);
        if bar.cancelled() {
            return Err(ModelFailure::Cancelled);
        }
        bar.advance(share / nodes.len() as f64);
        let answer = pattern(&texture(place), lengths_um).map(|pattern| model.endless(&pattern, coarse));
        match answer {
            Some(Err(ModelFailure::Cancelled)) => Err(ModelFailure::Cancelled),
            Some(Ok(answer)) => Ok(Some(answer)),
            _ => Ok(None),
        }
    };
    let has_none = |(place, answer): (&usize, &Option<Endless>)| {
        answer.as_ref().is_none_or(|answer| answer.is_closed(nodes[*place][2]))
    };
    let all = || {
        let mut answers = vec![None; nodes.len()];
        let mut missing = 0;
        for places in spread(nodes.len()).chunks(AT_ONCE) {
            let found: Vec<Option<Endless>> = places.par_iter().map(one).collect::<Result<_, _>>().ok()?;
            missing += places.iter().zip(&found).filter(|own| has_none(*own)).count();
            if missing as f64 > most_missing * nodes.len() as f64 {
                return None;
            }
            places.iter().zip(found).for_each(|(place, answer)| answers[*place] = answer);
        }
        Some(answers)
    };
    if model.learned().is_some() {
        return all();
    }
    let mut textures: Vec<Texture> = (0..nodes.len()).map(texture).collect();
    textures.dedup();
    let content = (model.content(), textures, nodes, coarse, "values, peak, sag");
    let numbers = |answer: Endless| [answer.values, vec![answer.peak_mpa, answer.sag_um]].concat();
    let asked = || Some(all()?.into_iter().map(|answer| answer.map(numbers)).collect());
    let answer = |mut numbers: Vec<f64>| {
        let (sag_um, peak_mpa) = (numbers.pop()?, numbers.pop()?);
        Some(Endless { values: numbers, peak_mpa, sag_um })
    };
    Some(
        kept(&Part::new(bar, share), &content, nodes.len(), asked)?
            .into_iter()
            .map(|node| node.and_then(answer))
            .collect(),
    )
}

/// The numbers from 0 to `count`, each once, those that follow each other far apart: steps of the golden section.
fn spread(count: usize) -> Vec<usize> {
    let divides = |step: usize| {
        let (mut a, mut b) = (count, step);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // Some thousands at most: the cast is exact.
    let golden = (0.618 * count as f64) as usize;
    let step = (golden.max(1)..).find(|step| divides(*step) == 1).unwrap_or(1);
    (0..count).map(|n| n * step % count.max(1)).collect()
}

/// The answers, where a node has none that of the nearest node with the same width and spacing, else of the nearest before it.
fn whole(answers: Vec<Option<Endless>>, axes: &[Axis; 3]) -> Option<Vec<Endless>> {
    let missing = answers.iter().filter(|answer| answer.is_none()).count();
    if missing as f64 > MOST_LEFT_OUT * answers.len() as f64 {
        return None;
    }
    let depths = axes[2].nodes;
    let mut found: Vec<Endless> = Vec::with_capacity(answers.len());
    for (place, answer) in answers.iter().enumerate() {
        let row = place / depths * depths;
        let near = (row..row + depths).filter(|near| answers[*near].is_some()).min_by_key(|near| near.abs_diff(place));
        let own = answer.clone().or_else(|| near.and_then(|near| answers[near].clone()));
        found.push(own.or_else(|| found.last().cloned()).or_else(|| answers.iter().flatten().next().cloned())?);
    }
    Some(found)
}

/// Values, and logarithms of the largest pressures beside how far ceilings come down, through their nodes.
fn surfaces(axes: [Axis; 3], all: &[Endless]) -> (ResponseSurface, ResponseSurface) {
    let outputs = all.first().map_or(0, |answer| answer.values.len());
    let values = all.iter().flat_map(|answer| answer.values.iter().copied()).collect();
    let beside = all.iter().flat_map(|answer| [answer.peak_mpa.max(f64::MIN_POSITIVE).ln(), answer.sag_um]).collect();
    (ResponseSurface::through(axes, outputs, values), ResponseSurface::through(axes, 2, beside))
}

/// How far straight lines between the target's pressures are from the solver at most, over the first of the `checks`.
fn off_between(model: &SteadyModel, texture: &Texture, checks: &[[f64; 3]], bar: &Stage<'_>) -> Option<f64> {
    let (count, parts) = if model.guide().is_some() { SPACE_BETWEEN } else { PLANE_BETWEEN };
    let designs = &checks[..count.min(checks.len())];
    let one = |lengths_um: &[f64; 3]| {
        let off = pattern(texture, lengths_um).filter(|_| !bar.cancelled());
        off.and_then(|pattern| model.off_between(&pattern, parts)).map(|off| vec![off])
    };
    let asked = || Some(designs.par_iter().map(one).collect()).filter(|_| !bar.cancelled());
    let found = kept(&Part::new(bar, 0.0), &(model.content(), designs, parts, "between"), designs.len(), asked)?;
    found.into_iter().flatten().flatten().reduce(f64::max)
}

/// Designs anywhere within the bounds, their logarithms evenly spread.
fn checks(axes: &[Axis; 3], count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut normals = Normals::new(seed);
    let mut at = |axis: &Axis| axis.from * (axis.to / axis.from).powf(normal_probability(normals.draw()));
    (0..count).map(|_| [at(&axes[0]), at(&axes[1]), at(&axes[2])]).collect()
}

/// Covariance of the values' errors at the design found.
fn covariance(anchor: &Anchor<'_>, seed: u64) -> Option<Vec<Vec<f64>>> {
    let chances = anchor.chances.filter(|chances| chances.is_known())?;
    let still = chances.still(anchor.design).ok()?;
    let about = About { design: anchor.design, still: &still, values: anchor.values, numerical: anchor.numerical };
    let expansion = chances.expand(&about).ok()?;
    Some(chances.covariance(&chances.draws(DRAWS, seed), &expansion))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_asked_each_once_and_far_apart() {
        for count in [0, 1, 2, 12, 175, 1008, 4800] {
            let order = spread(count);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..count), "{count}");
            // A corner of a tenth of all has a tenth of the first eighth, within a third.
            let corner = order.iter().take(count / 8).filter(|place| **place < count / 10).count();
            assert!(count < 1000 || (corner as f64 / (count as f64 / 80.0) - 1.0).abs() < 0.34, "{count}: {corner}");
        }
    }
}
