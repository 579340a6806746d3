//! The table of the bounds: what the model says of every texture within them, from its answers at nodes.
//!
//! | of a texture | nodes | between them |
//! |---|---|---|
//! | ln R at every load, largest and least pressure, sag of the ceilings | in the plane all in the layer's blocks; in space larger blocks, lifted by fewer cells in those asked for | cubic splines in ln of the lengths |
//! | slope of ln R along ln E, its change by the local law; what smaller blocks change; ends and tilt | fewer, as they vary slowly | linear in ln of the lengths |
//!
//! All of it is kept by content, so that another target asks nothing anew. Textures that have no answer are holes.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_discrepancy::{DimensionShift, Sensitivity};
use slipgrid_material::Condition;
use slipgrid_monitor::{Monitor, Part};
use slipgrid_optimize::{ModelFailure, Tolerances};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Scene, block_refinement};
use slipgrid_statistics::{Axis, Normals, ResponseSurface, median, normal_probability};
use slipgrid_units::tidy;

use crate::DesignError;
use crate::as_cut::BeyondCells;
use crate::evaluation_cache::Answer;
use crate::inputs::{made, of_dimensions, shift};
use crate::kept_nodes::kept;
use crate::sensitivities::{Sensitivities, from_numbers};
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// Most multiplications of a cell that is refined: some hundredths of a second.
const MAX_REFINED: f64 = 2e8;
/// Beside ln R: logarithm of the largest pressure in pascals, least pressure over the nominal one, sag in metres.
const BESIDE: usize = 3;

/// How many nodes there are.
pub struct Scope {
    /// Along width, spacing and depth for each factor e between the bounds, and at most.
    nodes: ([f64; 3], [usize; 3]),
    /// In space the same of cells in the blocks asked for, which lift those in larger ones.
    lift: ([f64; 3], [usize; 3]),
    /// Most along each length of sensitivities, of what smaller blocks change, and of ends and tilt.
    sensitivities: [usize; 3],
    blocks: [usize; 3],
    face: [usize; 3],
    /// Random textures at which the error is measured.
    checks: usize,
}

impl Scope {
    /// In the plane, where a node takes a millisecond.
    pub const PLANE: Self = Self {
        nodes: ([6.0, 5.0, 2.8], [14, 16, 10]),
        lift: ([0.0; 3], [0; 3]),
        sensitivities: [7, 7, 4],
        // More nodes come no nearer (0.0021 and 0.0018 in the median of 40 and 30 random textures of the LDPE design): both jump where a
        // cavity more fits between the ends, or a length is no whole blocks.
        blocks: [4, 4, 3],
        face: [3, 4, 2],
        checks: 60,
    };
    /// In space.
    pub const SPACE: Self = Self {
        nodes: ([5.0, 4.0, 2.0], [12, 12, 7]),
        lift: ([3.0, 3.0, 1.5], [5, 5, 4]),
        sensitivities: [5, 5, 3],
        checks: 12,
        ..Self::PLANE
    };
}

/// How far the table is from the model, and what it took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TableReport {
    /// Nodes.
    pub nodes: usize,
    /// Those of them without an answer.
    pub holes: usize,
    /// Random textures at which the table was compared with the model.
    pub checked: usize,
    /// Median over them of the largest relative error of the ratio at any load.
    pub median_error: f64,
    /// The largest.
    pub worst_error: f64,
    /// Memory of its numbers.
    pub bytes: usize,
}

/// What the model says of a texture at the loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Modelled {
    /// ln R.
    pub log_ratio: Vec<f64>,
    /// How ln R follows what all textures have in common.
    pub sensitivity: Vec<Sensitivity>,
}

/// The model with its sensitivities.
pub struct Models<'a> {
    pub own: &'a SteadyModel<'a>,
    sensitivities: Sensitivities<'a>,
}

impl<'a> Models<'a> {
    /// Those about `own`, whose material is known as `material` says, at the condition of each load.
    ///
    /// # Errors
    /// [`DesignError`] where the area law cannot be moved.
    pub fn new(
        own: &'a SteadyModel<'a>,
        material: &MaterialUncertainty,
        conditions: &[Option<Condition>],
    ) -> Result<Self, DesignError> {
        Ok(Self { own, sensitivities: Sensitivities::new(own, material, conditions)? })
    }

    /// What they say of `design`.
    ///
    /// # Errors
    /// [`ModelFailure`] where it cannot be computed, or its cavities close.
    pub fn at(&self, design: &Pattern) -> Result<Modelled, ModelFailure> {
        Ok(Modelled {
            log_ratio: self.own.steady(design)?.ratio.iter().map(|ratio| ratio.ln()).collect(),
            sensitivity: self.sensitivities.at(design)?,
        })
    }

    /// What smaller blocks change of each ratio of `design`, and how far each is from vanishing blocks, as a standard deviation; `None`
    /// of rims in space, in several directions, and where smaller blocks are dear.
    pub fn refined(&self, design: &Pattern) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.own.has_directions() {
            return None;
        }
        let scene = Scene { pattern: Some(*design), ..self.own.asked().clone() };
        let share = self.own.share(design).ok()?;
        let ratios = self.own.steady(design).ok()?.ratio;
        // Of the cell: 1 - r = (1 - r_cell) D / D_period
        let own: Vec<Option<f64>> = ratios.iter().map(|ratio| Some(1.0 - (1.0 - ratio) / share)).collect();
        let refined = block_refinement(&scene, &own, MAX_REFINED)?;
        // What errors hardly exceed, as two standard deviations.
        let open = refined.errors.iter().map(|error| 0.5 * share * error).collect();
        Some((refined.shifts.iter().map(|shift| share * shift).collect(), open))
    }
}

/// What the model says of every texture within the bounds.
#[derive(Clone)]
pub struct Table {
    surface: ResponseSurface,
    /// Nodes without an answer, by their places: there is none in the cells around them either.
    holes: Vec<usize>,
    sensitivities: Nodes,
    blocks: Nodes,
    /// `None` where samples have no face of their own.
    face: Option<Nodes>,
    loads: usize,
    /// How far it is from the model.
    pub report: TableReport,
}

impl Table {
    /// Asks `models` at the nodes over the space of `task`, and what is `beyond` cells, as the whole of `stage`; `None` where that ends
    /// before, or where no node has an answer.
    pub fn new(task: &DesignTask, models: &Models<'_>, beyond: &BeyondCells<'_>, stage: &dyn Monitor) -> Option<Self> {
        let is_guided = models.own.has_guide();
        let scope = if models.own.is_cheap_per_design() { Scope::PLANE } else { Scope::SPACE };
        let loads = models.own.asked().loads.len();
        let lattice = axes(task, if is_guided || models.own.is_cheap_per_design() { scope.nodes } else { scope.lift });
        let (of_nodes, of_lift) = if is_guided { (0.2, 0.4) } else { (0.6, 0.0) };
        let ask = |lengths: &[[f64; 3]], coarse: bool, share: f64| {
            solved(task, models, lengths, coarse, &Part::new(stage, share))
        };
        let nodes = ResponseSurface::nodes(&lattice);
        let answers = ask(&nodes, is_guided, of_nodes)?;
        let holes: Vec<usize> = (0..nodes.len()).filter(|place| answers[*place].is_none()).collect();
        let mut values = filled(answers, &lattice)?;
        if is_guided {
            let few_axes = axes(task, scope.lift);
            let few = ResponseSurface::nodes(&few_axes);
            let (fine, coarse) = (ask(&few, false, of_lift)?, ask(&few, true, 0.0)?);
            // A node without an answer has its neighbour's change, not that of another answer.
            let over = fine.into_iter().zip(coarse).map(|(fine, coarse)| {
                Some(fine?.iter().zip(coarse?).map(|(fine, coarse)| fine - coarse).collect::<Vec<f64>>())
            });
            let over = filled(over.collect(), &few_axes)?;
            let lift = ResponseSurface::through(few_axes, loads + BESIDE, over.concat());
            for (at, own) in nodes.iter().zip(&mut values) {
                own.iter_mut().zip(lift.at(at)).for_each(|(own, lift)| *own += lift);
            }
        }
        let surface = ResponseSurface::through(lattice, loads + BESIDE, values.concat());
        let part = Part::new(stage, 0.4 / 3.0);
        let of = |design: &Pattern| models.sensitivities.numbers(design).ok();
        let sensitivities = Nodes::new(task, ("slopes", models), &of, scope.sensitivities, &part)?;
        // ln (r + s) / r, s what smaller blocks change; nothing where they are dear, as for what is judged in the end.
        let smaller = |design: &Pattern| {
            let Some((shifts, _)) = models.refined(design) else { return Some(vec![0.0; loads]) };
            let ratios = models.own.steady(design).ok()?.ratio;
            Some(ratios.iter().zip(shifts).map(|(ratio, shift)| (shift / ratio).max(-0.5).ln_1p()).collect())
        };
        let blocks = Nodes::new(task, ("blocks", models), &smaller, scope.blocks, &part)?;
        let by_face =
            |design: &Pattern| Some(beyond.by_face(design, &models.own.steady(design).ok()?.ratio, true, stage));
        let face = match beyond.face {
            Some(_) => Some(Nodes::new(task, ("face", models), &by_face, scope.face, &part)?),
            None => None,
        };
        let beside = [&sensitivities, &blocks].into_iter().chain(&face).map(Nodes::bytes).sum::<usize>();
        let bytes = size_of_val(surface.coefficients()) + beside;
        let report = TableReport { nodes: nodes.len(), holes: holes.len(), bytes, ..TableReport::default() };
        let mut table = Self { surface, holes, sensitivities, blocks, face, loads, report };
        table.measure(task, models, scope.checks, stage)?;
        Some(table)
    }

    /// The same over the wider space of `task`, in the plane: what varies slowly is taken to be at its ends as it is at those of this table. `None`
    /// where `stage` ends before.
    pub fn widened(&self, task: &DesignTask, models: &Models<'_>, stage: &dyn Monitor) -> Option<Self> {
        let lattice = axes(task, Scope::PLANE.nodes);
        let nodes = ResponseSurface::nodes(&lattice);
        let answers = solved(task, models, &nodes, false, &Part::new(stage, 0.0))?;
        let holes = (0..nodes.len()).filter(|place| answers[*place].is_none()).collect();
        let values = filled(answers, &lattice)?;
        let surface = ResponseSurface::through(lattice, self.loads + BESIDE, values.concat());
        Some(Self { surface, holes, ..self.clone() })
    }

    /// Compares it with the model at random textures, their logarithms evenly spread.
    fn measure(&mut self, task: &DesignTask, models: &Models<'_>, count: usize, stage: &dyn Monitor) -> Option<()> {
        let all = random_places(self.surface.axes(), count, 1);
        let exact = solved(task, models, &all, false, &Part::new(stage, 0.0))?;
        let off = |(lengths_m, exact): (&[f64; 3], Option<Vec<f64>>)| {
            let design = task.space.pattern(*lengths_m).ok()?;
            let (exact, found) = (exact?, self.values(&design)?);
            let is_open = exact[self.loads + 2] < design.depth_m();
            let each = exact.iter().zip(&found).take(self.loads).map(|(exact, found)| (exact - found).abs());
            is_open.then(|| each.fold(0.0, f64::max))
        };
        let mut off: Vec<f64> = all.iter().zip(exact).filter_map(off).collect();
        self.report.checked = off.len();
        self.report.worst_error = tidy(off.iter().copied().fold(0.0, f64::max));
        self.report.median_error = tidy(median(&mut off).unwrap_or(0.0));
        Some(())
    }

    /// All outputs at the lengths of `design`; `None` beside a hole.
    fn values(&self, design: &Pattern) -> Option<Vec<f64>> {
        let lengths_m = design.lengths_m();
        (!self.surface.is_beside(&self.holes, &lengths_m)).then(|| self.surface.at(&lengths_m))
    }

    /// ln R of `design` in the layer's blocks without ends, and its sensitivities; `None` beside a hole, and where cavities close.
    pub fn at(&self, design: &Pattern) -> Option<(Modelled, Answer)> {
        let mut log_ratio = self.values(design)?;
        let beside = log_ratio.split_off(self.loads);
        let clearance_m = design.depth_m() - beside[2];
        if clearance_m <= 0.0 {
            return None;
        }
        let numbers = self.sensitivities.at(design.lengths_m()).unwrap_or_default();
        let sensitivity = from_numbers(&numbers, self.loads);
        let answer = Answer {
            ratio: log_ratio.iter().map(|log| log.exp()).collect(),
            peak_pressure_mpa: 1e-6 * beside[0].exp(),
            least_pressure: beside[1],
            clearance_um: Some(1e6 * clearance_m),
        };
        Some((Modelled { log_ratio, sensitivity }, answer))
    }

    /// Change of the logarithm of each ratio by ends and tilt; none where a node beside it has no answer.
    pub fn by_face(&self, design: &Pattern) -> Vec<f64> {
        self.face.as_ref().and_then(|face| face.at(design.lengths_m())).unwrap_or_default()
    }

    /// What smaller blocks change of the logarithm of each ratio, so far as it is known there.
    pub fn by_blocks(&self, design: &Pattern) -> Vec<f64> {
        self.blocks.at(design.lengths_m()).unwrap_or_default()
    }

    /// Errors of the dimensions of samples of `design` that scatter as `tolerances` say: differences over a standard deviation each way.
    pub fn dimension_shifts(&self, design: &Pattern, tolerances: &Tolerances) -> Option<Vec<DimensionShift>> {
        let own = |(_, by_m): (&str, [f64; 3])| {
            let [above, below] = [1.0, -1.0].map(|side| self.values(&made(design, &by_m, side)));
            let log_ratio = above?.into_iter().zip(below?).take(self.loads).map(|(above, below)| 0.5 * (above - below));
            Some(shift(design, &by_m, log_ratio.collect()))
        };
        of_dimensions(tolerances).into_iter().map(own).collect()
    }
}

/// Nodes over the space of `task`: so many for each factor e along each length, and at most.
fn axes(task: &DesignTask, nodes: ([f64; 3], [usize; 3])) -> [Axis; 3] {
    axes_between(task.space.lengths_m(), nodes)
}

/// Nodes between `bounds` in any unit: so many for each factor e along each length, and at most.
pub fn axes_between(bounds: [[f64; 2]; 3], (each, most): ([f64; 3], [usize; 3])) -> [Axis; 3] {
    std::array::from_fn(|axis| {
        let [from, to] = bounds[axis];
        // At most some dozens: the cast is exact.
        let wanted = 1 + (each[axis] * (to / from).ln()).ceil() as usize;
        Axis::new(bounds[axis], wanted.min(most[axis]))
    })
}

/// `count` random places between the ends of `axes`, their logarithms evenly spread.
pub fn random_places(axes: &[Axis; 3], count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut normals = Normals::new(seed);
    let mut at = |axis: &Axis| axis.from * (axis.to / axis.from).powf(normal_probability(normals.draw()));
    (0..count).map(|_| axes.each_ref().map(&mut at)).collect()
}

/// Nodes of the table of `task` by `model`, and of them or beside them those in the blocks asked for that lift the others; 0 where none are.
pub fn nodes(task: &DesignTask, model: &SteadyModel<'_>) -> [f64; 2] {
    let scope = if model.is_cheap_per_design() { Scope::PLANE } else { Scope::SPACE };
    let count = |scope: ([f64; 3], [usize; 3])| axes(task, scope).iter().map(|axis| axis.nodes as f64).product();
    if model.has_guide() {
        [count(scope.nodes), count(scope.lift)]
    } else if model.is_cheap_per_design() {
        [count(scope.nodes), 0.0]
    } else {
        [count(scope.lift), 0.0]
    }
}

/// ln R, and what stands beside it, of each of `lengths`, in the guide's blocks where `coarse`; `None` once `stage` is cancelled. Of designs
/// whose cavities close they go on behind where they close, so that the surface is smooth up to there.
fn solved(
    task: &DesignTask,
    models: &Models<'_>,
    lengths: &[[f64; 3]],
    coarse: bool,
    stage: &dyn Monitor,
) -> Option<Vec<Option<Vec<f64>>>> {
    let one = |lengths_m: &[f64; 3]| {
        if stage.cancelled() {
            return Err(ModelFailure::Cancelled);
        }
        stage.advance(1.0 / lengths.len() as f64);
        let answer = task.space.pattern(*lengths_m).ok().map(|design| (design, models.own.tabulated(&design, coarse)));
        match answer {
            Some((_, Err(failure @ (ModelFailure::Cancelled | ModelFailure::Broken { .. })))) => Err(failure),
            Some((design, Ok(answer))) => {
                let sag_m = answer.clearance_m().map_or(0.0, |clearance_m| design.depth_m() - clearance_m);
                let log = answer.ratio.iter().map(|ratio| ratio.ln());
                let all = log.chain([answer.peak_pressure_pa().ln(), answer.least_pressure, sag_m]);
                Ok(Some(all.collect::<Vec<f64>>()).filter(|all| all.iter().all(|value| value.is_finite())))
            }
            _ => Ok(None),
        }
    };
    let content = (models.own.content(), &task.space, lengths, coarse, "ln R, ln peak, least, sag");
    kept(stage, &content, lengths.len(), || lengths.par_iter().map(one).collect::<Result<Vec<_>, _>>().ok())
}

/// The answers, where a node has none that of the nearest node that has one; `None` if none has.
pub fn filled(answers: Vec<Option<Vec<f64>>>, axes: &[Axis; 3]) -> Option<Vec<Vec<f64>>> {
    let [_, rows, depths] = axes.map(|axis| axis.nodes);
    let place = |node: usize| [node / (rows * depths), node / depths % rows, node % depths];
    let answered: Vec<(usize, &Vec<f64>)> =
        answers.iter().enumerate().filter_map(|(node, answer)| Some((node, answer.as_ref()?))).collect();
    let nearest = |node: usize| {
        let distance = |(other, _): &&(usize, &Vec<f64>)| -> usize {
            place(node).iter().zip(place(*other)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
        };
        answered.iter().min_by_key(distance).map(|(_, answer)| (*answer).clone())
    };
    answers.iter().enumerate().map(|(node, answer)| answer.clone().or_else(|| nearest(node))).collect()
}

/// Numbers at the nodes of a lattice, linear between them.
#[derive(Clone)]
struct Nodes {
    /// Logarithms of width, spacing and depth at the nodes.
    axes: [Vec<f64>; 3],
    /// Nodes, widths slowest; `None` where a design cannot be computed.
    nodes: Vec<Option<Vec<f64>>>,
}

impl Nodes {
    /// Asks `of`, the answer called `name` of `models`, at the nodes.
    fn new(
        task: &DesignTask,
        (name, models): (&str, &Models<'_>),
        of: &(dyn Fn(&Pattern) -> Option<Vec<f64>> + Sync),
        most: [usize; 3],
        stage: &dyn Monitor,
    ) -> Option<Self> {
        let space = &task.space;
        let axes: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            let [low, high] = space.lengths_m()[axis].map(f64::ln);
            let count = if low == high { 1 } else { most[axis] };
            (0..count).map(|node| low + (high - low) * node as f64 / (count.max(2) - 1) as f64).collect()
        });
        let [_, spacings, depths] = [0, 1, 2].map(|axis: usize| axes[axis].len());
        let count = axes[0].len() * spacings * depths;
        let share = 1.0 / count as f64;
        let ask = || {
            let node = |node: usize| {
                let lengths = [node / (spacings * depths), node / depths % spacings, node % depths];
                let design = space.pattern(std::array::from_fn(|axis| axes[axis][lengths[axis]].exp())).ok()?;
                let found = if stage.cancelled() { None } else { of(&design) };
                stage.advance(share);
                found
            };
            let nodes: Vec<Option<Vec<f64>>> = (0..count).into_par_iter().map(node).collect();
            (!stage.cancelled()).then_some(nodes)
        };
        let loads_of_face = (name == "face").then(|| task.target.points().len());
        let content = (name, models.own.content(), models.sensitivities.content(), space, &axes, loads_of_face);
        let nodes = kept(stage, &content, count, ask)?;
        Some(Self { axes, nodes })
    }

    fn bytes(&self) -> usize {
        self.nodes.iter().flatten().map(|node| size_of_val(&node[..])).sum()
    }

    /// The numbers at these lengths, linear between the eight nodes about it in the logarithms; `None` where one of them has none. Beyond
    /// the lattice its edge stands.
    fn at(&self, lengths_m: [f64; 3]) -> Option<Vec<f64>> {
        let place = |axis: usize| {
            let (nodes, x) = (&self.axes[axis], lengths_m[axis].ln());
            let low = nodes.partition_point(|node| *node <= x).clamp(1, nodes.len().max(2) - 1) - 1;
            let Some(next) = nodes.get(low + 1) else { return (low, 0.0) };
            (low, ((x - nodes[low]) / (next - nodes[low])).clamp(0.0, 1.0))
        };
        let [(w, tw), (s, ts), (d, td)] = [0, 1, 2].map(place);
        let (spacings, depths) = (self.axes[1].len(), self.axes[2].len());
        let mut sum: Option<Vec<f64>> = None;
        for corner in 0..8 {
            let [i, j, k] = [corner >> 2, corner >> 1 & 1, corner & 1];
            let share = |t: f64, upper: usize| if upper == 1 { t } else { 1.0 - t };
            let weight = share(tw, i) * share(ts, j) * share(td, k);
            if weight == 0.0 {
                continue;
            }
            let node = self.nodes[((w + i) * spacings + s + j) * depths + d + k].as_ref()?;
            let sum = sum.get_or_insert_with(|| vec![0.0; node.len()]);
            sum.iter_mut().zip(node).for_each(|(sum, own)| *sum += weight * own);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_without_an_answer_has_that_of_the_nearest() {
        let axes = [Axis::new([1.0, 8.0], 4), Axis::new([1.0, 8.0], 4), Axis::new([5.0, 5.0], 1)];
        let mut answers = vec![None; 16];
        assert_eq!(filled(answers.clone(), &axes), None);
        (answers[2], answers[13]) = (Some(vec![0.5]), Some(vec![0.7]));
        let values: Vec<f64> = filled(answers, &axes).unwrap().iter().map(|answer| answer[0]).collect();
        assert_eq!((values[2], values[7], values[9], values[13], values[12]), (0.5, 0.5, 0.7, 0.7, 0.7));
    }
}
