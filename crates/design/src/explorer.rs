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
use crate::learned_discrepancy::LearnedDiscrepancy;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::steady_model::{Endless, SteadyModel};
use crate::task::{DesignTask, KnownMaterial};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;
use slipgrid_monitor::{Monitor, Part, Stage};
use slipgrid_springblock::{Load, cell_expense};

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
/// Why there is no explorer where no node has an answer.
const NO_ANSWER: &str = "no explorer: the steady model has no answer for any design within the bounds";
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
    /// Nodes of `values`, by their places, for which the steady model has no answer: there is none in the cells around them either.
    pub unanswered: Vec<usize>,
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
    /// What the corrected model says of it, the first a pressure; empty where nothing is corrected.
    pub values: &'a [f64],
    /// What its errors are, where anything is known of them.
    pub chances: Option<&'a Chances<'a>>,
    /// How exactly the values were computed.
    pub numerical: &'a Numerical,
}

impl Explorer {
    /// Whether a design has an answer: its cavities stay open, and all nodes around it are answered.
    #[must_use]
    pub fn has_answer(&self, lengths_um: &[f64; 3]) -> bool {
        !self.values.is_beside(&self.unanswered, lengths_um) && self.peak_and_sag.at(lengths_um)[1] < lengths_um[2]
    }

    /// The node with an answer that is nearest to the middle of the bounds.
    fn most_central(&self) -> Option<[f64; 3]> {
        let axes = self.values.axes();
        let off = |node: &[f64; 3]| -> f64 {
            axes.iter().zip(node).map(|(axis, length)| (length / (axis.from * axis.to).sqrt()).ln().powi(2)).sum()
        };
        let answered = ResponseSurface::nodes(axes).into_iter().filter(|node| self.has_answer(node));
        answered.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// What a task's designs do, before any is searched.
#[derive(Clone, Debug)]
pub struct Explored {
    /// The task.
    pub task: DesignTask,
    /// Its material.
    pub material: KnownMaterial,
    /// The design in the middle of the bounds, or the nearest to it that has an answer.
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

/// What the designs of `task` do at the condition that it is designed for, by the steady model; with the median discrepancy of trials
/// where the task aims with it.
///
/// # Errors
/// [`DesignError`] for a task that is refused or that the monitor cancels, and where no design can be computed.
pub fn explore_bounds(task: &DesignTask, monitor: &dyn Monitor) -> Result<Explored, DesignError> {
    let known = task.material.clone().ok_or_else(|| DesignError::refused("has no material"))?;
    let mut task = task.clone();
    task.check(&known)?;
    let task = &task;
    let (loads, outside) = task.loads(&known.material)?;
    let beyond_measured = task.beyond_measured(&known.material, &outside);
    let budget = TimeBudget::new(monitor, None);
    let scene = (task, &known.material, loads.clone());
    let mut found =
        MultiFidelityLoop::new(scene.0, scene.1, scene.2, Vec::new(), budget, monitor, &mut Timings::default())?;
    if task.discrepancy {
        let learned = LearnedDiscrepancy::new(task, &known.uncertainty, &found.further, &found.model)?;
        found.model.aim_with(learned);
    }
    let middle = task
        .space
        .middle()
        .map_err(|error| DesignError::refused(format!("the middle of the bounds is no pattern: {error}")))?;
    let of_flat = |(place, load): (usize, &Load)| match task.target.quantity() {
        Quantity::Ratio => load.flat_mu(found.model.area_law()),
        _ => found.model.scale(place),
    };
    let flat_mu = loads.iter().enumerate().map(of_flat).collect();
    let stage = budget.stage("explorer");
    let anchor = Anchor { design: &middle, values: &[], chances: None, numerical: &Numerical::default() };
    let explorer = explore(task, &found.model, &anchor, &stage);
    stage.finish();
    monitor.heed()?;
    let explorer = explorer.ok_or_else(|| DesignError::Failed(NO_ANSWER.to_owned()))?;
    let start = Some(middle).filter(|middle| explorer.has_answer(&lengths_um(middle)));
    let central = || explorer.most_central().and_then(|node| pattern(task.space.texture(), &node));
    let pattern = start.or_else(central).unwrap_or(middle);
    Ok(Explored { task: task.clone(), material: known, pattern, loads, flat_mu, beyond_measured, explorer })
}

/// Solves the surface by `model` and measures its error; `None` where `bar` has cancelled, or no design can be computed.
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
    let ask = |nodes: &[[f64; 3]], coarse: bool, share: f64| ask(model, &|_| texture, nodes, coarse, (bar, share));

    let nodes = ResponseSurface::nodes(&axes);
    let answers = ask(&nodes, is_guided, shares[0])?;
    let unanswered: Vec<usize> = (0..nodes.len()).filter(|place| answers[*place].is_none()).collect();
    let mut all = filled(answers, &axes)?;
    if is_guided {
        let axes = self::axes(&design.space, &FINE_NODES);
        let few = ResponseSurface::nodes(&axes);
        let (fine, coarse) = (ask(&few, false, shares[1])?, ask(&few, true, 0.0)?);
        // A node without an answer has its neighbour's change, not that of another answer.
        let difference = fine.into_iter().zip(coarse).map(|(fine, coarse)| Some(fine?.over(&coarse?)));
        let lift = surfaces(axes, &filled(difference.collect(), &axes)?);
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
    let answers = self::ask(model, &of, &checks, false, (bar, shares[2]))?;
    let mut off: Vec<f64> = answers
        .into_iter()
        .zip(checks.iter().zip(&factors))
        .filter_map(|(answer, (at, factor))| {
            let exact = answer.filter(|answer| !answer.is_closed(at[2]) && !values.is_beside(&unanswered, at))?.values;
            let change =
                rims.as_ref().map_or_else(Vec::new, |rims| rims.at(at, *factor)).into_iter().chain(iter::repeat(0.0));
            let found = values.at(at).into_iter().zip(change).map(|(found, change)| found + change);
            Some(exact.iter().zip(found).map(|(exact, found)| (exact - found).abs()).fold(0.0, f64::max))
        })
        .collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    let between = off_between(model, &texture, &checks, bar);
    let error = SurfaceError { points: off.len(), median: median(&mut off).unwrap_or(0.0), worst, between };

    let own = lengths_um(anchor.design);
    let difference = |(load, found): (usize, &f64)| anchor.values.get(load).map_or(0.0, |predicted| predicted - found);
    let offset = values.at(&own).iter().enumerate().map(difference).collect();
    let density = |at: &[f64; 3]| pattern(&texture, at).map_or(0.0, |pattern| pattern.areal_density());
    let [width, spacing, depth] = axes;
    let level = [width, spacing, Axis { nodes: 1, ..depth }];
    let densities = ResponseSurface::nodes(&level).iter().map(density).collect();
    let covariance = covariance(anchor, design.seed).unwrap_or_default();
    let areal_density = ResponseSurface::through(level, 1, densities);
    Some(Explorer { values, peak_and_sag, unanswered, areal_density, rims, error, offset, covariance })
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
        if is_too_dear(design, model) { (None, TOO_DEAR) } else { (explore(design, model, anchor, bar), NO_ANSWER) };
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
    let core_s: f64 = scenes.map(|scene| cell_expense(&scene).core_s).sum();
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
/// as `share` of a stage; `None` once it is cancelled. Of designs whose cavities close the values go on behind where they close, so that
/// the surface is smooth up to there.
fn ask(
    model: &SteadyModel,
    texture: &(impl Fn(usize) -> Texture + Sync),
    nodes: &[[f64; 3]],
    coarse: bool,
    (bar, share): (&Stage<'_>, f64),
) -> Option<Vec<Option<Endless>>> {
    let one = |(place, lengths_um): (usize, &[f64; 3])| {
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
    let all = || nodes.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>().ok();
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

/// The answers, where a node has none that of the nearest node that has one; `None` if none has.
fn filled(answers: Vec<Option<Endless>>, axes: &[Axis; 3]) -> Option<Vec<Endless>> {
    let [_, rows, depths] = axes.map(|axis| axis.nodes);
    let place = |node: usize| [node / (rows * depths), node / depths % rows, node % depths];
    let answered: Vec<(usize, &Endless)> =
        answers.iter().enumerate().filter_map(|(node, answer)| Some((node, answer.as_ref()?))).collect();
    let nearest = |node: usize| {
        let distance = |(other, _): &&(usize, &Endless)| -> usize {
            place(node).iter().zip(place(*other)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
        };
        answered.iter().min_by_key(distance).map(|(_, answer)| (*answer).clone())
    };
    answers.iter().enumerate().map(|(node, answer)| answer.clone().or_else(|| nearest(node))).collect()
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
    use slipgrid_discrepancy::{Conditions, Discrepancy, Features, Hyperparameters, Measured, Trial};
    use slipgrid_material::Elastic;
    use slipgrid_monitor::Unwatched;
    use slipgrid_pattern::Planform;

    use super::*;
    use crate::next_trial::tests::task;

    /// A task with these bounds, in micrometres, of a material with this modulus.
    fn bounded(bounds_um: [[f64; 2]; 3], youngs_modulus_pa: f64) -> DesignTask {
        let mut task = task(Planform::Groove);
        let [width, spacing, depth] = bounds_um.map(|bounds| bounds.map(|um| LENGTH_UM.to_si(um)));
        task.space = DesignSpace::new(Planform::Groove, width, spacing, depth).unwrap();
        task.material.as_mut().unwrap().material.elastic = Elastic::new(youngs_modulus_pa, 900.0).unwrap();
        task
    }

    #[test]
    fn designs_without_an_answer_are_holes_and_the_rest_is_explored() {
        // Periods of less than a block have no answer.
        let task = bounded([[4.0, 80.0], [4.0, 300.0], [10.0, 10.0]], 0.38e9);
        let Explored { explorer, pattern: start, .. } = explore_bounds(&task, &Unwatched).unwrap();
        let share = explorer.unanswered.len() as f64 / ResponseSurface::nodes(explorer.values.axes()).len() as f64;
        assert!(share > 0.0 && share < 0.5, "{share}");
        assert!(!explorer.has_answer(&[4.0, 4.0, 10.0]) && explorer.has_answer(&[80.0, 300.0, 10.0]));
        assert!(explorer.has_answer(&lengths_um(&start)) && explorer.error.points > 100);
        assert!(explorer.error.median < 0.01, "{:?}", explorer.error);

        // Wide and shallow cavities of a soft body close.
        let task = bounded([[60.0, 300.0], [100.0, 100.0], [2.0, 30.0]], 0.04e9);
        let Explored { explorer, pattern: start, .. } = explore_bounds(&task, &Unwatched).unwrap();
        assert!(explorer.unanswered.is_empty());
        assert!(!explorer.has_answer(&[300.0, 100.0, 2.0]) && explorer.has_answer(&[60.0, 100.0, 30.0]));
        assert!(explorer.has_answer(&lengths_um(&start)) && explorer.error.points > 20);
    }

    #[test]
    fn values_have_what_trials_add_where_the_task_aims_with_it() {
        let mut task = bounded([[60.0, 120.0], [300.0, 300.0], [10.0, 10.0]], 0.38e9);
        let at = [100.0, 300.0, 10.0];
        let features = Features::from(&pattern(task.space.texture(), &at).unwrap());
        let measured = |pressure_pa| Measured {
            load: slipgrid_discrepancy::Load { pressure_pa, speed_m_s: task.speed_m_s, humidity: 0.4 },
            measured: 0.72,
            modelled: 0.9,
            patterned_std: 0.001,
            flat_std: 0.001,
            modulus_sensitivity: 0.0,
        };
        let trial = Trial {
            name: "cut".to_owned(),
            features,
            sample_std: None,
            disc: None,
            measured: task.pressures_pa().into_iter().map(measured).collect(),
            dimensions_std_m: [0.0; 3],
            dimension_shifts: Vec::new(),
        };
        let learned = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.0, vec![trial]).unwrap();
        task.material.as_mut().unwrap().uncertainty.learned = Some(learned);
        let plain = explore_bounds(&task, &Unwatched).unwrap().explorer;
        task.discrepancy = true;
        let aimed = explore_bounds(&task, &Unwatched).unwrap().explorer;
        for (aimed, plain) in aimed.values.at(&at).iter().zip(plain.values.at(&at)) {
            assert!((aimed / plain - 0.8).abs() < 0.02, "{aimed} {plain}");
        }
        assert!(aimed.error.worst < 0.02, "{:?}", aimed.error);
    }

    #[test]
    fn a_node_without_an_answer_has_that_of_the_nearest() {
        let axes = [Axis::new([1.0, 8.0], 4), Axis::new([1.0, 8.0], 4), Axis::new([5.0, 5.0], 1)];
        let answer = |value: f64| Some(Endless { values: vec![value], peak_mpa: 1.0, sag_um: 0.0 });
        let mut answers = vec![None; 16];
        assert_eq!(filled(answers.clone(), &axes), None);
        (answers[2], answers[13]) = (answer(0.5), answer(0.7));
        let values: Vec<f64> = filled(answers, &axes).unwrap().iter().map(|answer| answer.values[0]).collect();
        assert_eq!((values[2], values[7], values[9], values[13], values[12]), (0.5, 0.5, 0.7, 0.7, 0.7));
    }
}
