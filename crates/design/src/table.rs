//! Table over the bounds: interpolation of the model over all textures within the bounds, from results of the model at
//! nodes. R is the friction ratio, E Young's modulus.
//!
//! | quantity of a texture | nodes | interpolation |
//! |---|---|---|
//! | ln R of cells at every load, maximum and minimum pressure, sag of the ceilings | in the plane all in the layer's blocks; in space larger blocks, corrected by fewer cells in the requested ones | cubic splines in ln of the lengths |
//! | d ln R / d ln E; changes of ln R by local law and by smaller blocks | fewer (slow changes) | linear in ln |
//! | change of R by the specimen's ends and pressure tilt, over 1 - R | fewer, at one depth | linear in ln |
//!
//! The areal density of the specimen's face, which jumps where one more cavity fits, is that of every texture itself.
//! All values are cached by content, so that another target recomputes nothing. Nodes that the model cannot compute are
//! holes.

use crate::optimize::{ModelFailure, Tolerances};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::monitor::{Cancelled, Monitor, Part, cached};
use slipgrid_base::statistics::{Axis, Normals, ResponseSurface, median, normal_probability};
use slipgrid_base::units::tidy;
use slipgrid_infer::discrepancy::DimensionShift;
use slipgrid_laser::export::Specimen;
use slipgrid_laser::specimen::{Laid, on_face};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Dimension;

use crate::as_cut::BeyondCells;
use crate::evaluation_cache::Answer;
use crate::inputs::{made, of_dimensions, shift};
use crate::sensitivities::{Modelled, Models, from_numbers};
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// Number of outputs besides ln R, R the friction ratio, at each load: logarithm of the maximum pressure in pascals,
/// minimum ratio of local to nominal pressure, sag of the ceilings in metres.
const BESIDE: usize = 3;

/// Number of nodes along width, spacing and depth per factor e between the bounds, and maximum number.
pub type Density = ([f64; 3], [usize; 3]);

/// Numbers of nodes of a table, and of textures for the error estimate.
pub struct Scope {
    /// Nodes of ratios, maximum and minimum pressure, and sag.
    nodes: Density,
    /// Like `nodes`, for cells in space in the requested blocks, which correct the table in larger blocks.
    lift: Density,
    /// Maximum number of nodes along width, spacing and depth for the sensitivities of the ratio to inputs.
    sensitivities: [usize; 3],
    /// Maximum number of nodes along width, spacing and depth for changes by smaller blocks.
    blocks: [usize; 3],
    /// Maximum number of nodes along width, spacing and depth for the effects of the specimen's ends and pressure tilt.
    face: [usize; 3],
    /// Number of random textures for the error estimate.
    checks: usize,
}

impl Scope {
    /// Scope in the plane, where a node takes a millisecond.
    pub const PLANE: Self = Self {
        nodes: ([6.0, 5.0, 2.8], [14, 16, 10]),
        lift: ([0.0; 3], [0; 3]),
        sensitivities: [7, 7, 4],
        // Of the change, 0.0052 in ln R in the root mean square of 80 random textures of the LDPE design, these leave
        // 0.0036, and 4 x 4 x 3 nodes 0.0044; where cavities are a few blocks wide, changes are 0.02 and smooth.
        blocks: [3, 3, 3],
        // Of the effect, 0.022 in ln R in the root mean square of 80 random textures of the LDPE design, these leave
        // 0.008, as do 4 x 4 nodes; 3 x 4 x 2 leave 0.011. It jumps where one more cavity fits between the ends.
        face: [3, 4, 1],
        checks: 60,
    };
    /// Scope in space, where a node takes longer.
    pub const SPACE: Self = Self {
        nodes: ([5.0, 4.0, 2.0], [12, 12, 7]),
        lift: ([3.0, 3.0, 1.5], [5, 5, 4]),
        sensitivities: [5, 5, 3],
        // Of the change, 0.0116 in ln R in the root mean square of textures of the design of crossing grooves, these leave
        // 0.0012; 3 x 3 x 3 nodes leave 0.0005 and take a sixth of the time of the table more.
        blocks: [2, 2, 2],
        checks: 12,
        ..Self::PLANE
    };

    /// Scope of a table by `model`.
    const fn of(model: &SteadyModel<'_>) -> Self {
        if model.is_cheap_per_design() { Self::PLANE } else { Self::SPACE }
    }

    /// Densities of the nodes of a table by `model`, and of its correction from larger to the requested blocks; `None`
    /// if there is no model in larger blocks.
    const fn densities(&self, model: &SteadyModel<'_>) -> (Density, Option<Density>) {
        if model.has_guide() {
            (self.nodes, Some(self.lift))
        } else if model.is_cheap_per_design() {
            (self.nodes, None)
        } else {
            (self.lift, None)
        }
    }
}

/// Error and cost of a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TableReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of nodes that the model cannot compute.
    pub holes: usize,
    /// Number of random textures at which the table was compared with the model.
    pub checked: usize,
    /// Median over the random textures of the largest relative error of the ratio at any load.
    pub median_error: f64,
    /// Maximum over the random textures of the relative error of the ratio at any load.
    pub worst_error: f64,
    /// Memory of the table's numbers.
    pub bytes: usize,
}

/// Interpolated model results (ratios, sensitivities, extreme pressures, clearance) for every texture within the
/// bounds.
#[derive(Clone)]
pub struct Table {
    surface: ResponseSurface,
    /// Indices of nodes that the model cannot compute; no values are interpolated between them and adjacent nodes.
    holes: Vec<usize>,
    sensitivities: Nodes,
    blocks: Nodes,
    /// Changes of the friction ratio R by the specimen's ends and pressure tilt, over 1 - R; `None` if samples are
    /// sectors.
    face: Option<Nodes>,
    /// Specimen that textures are cut into; `None` if samples are sectors.
    specimen: Option<Specimen>,
    dimension: Dimension,
    loads: usize,
    /// Error and cost of the table.
    pub report: TableReport,
}

impl Table {
    /// Solves `models` at the nodes over the bounds of `task`, and the effects of the specimen's ends and pressure tilt
    /// by `beyond`; advances `stage` to its end. `None` if cancelled or if the model can compute no node.
    pub fn new(task: &DesignTask, models: &Models<'_>, beyond: &BeyondCells<'_>, stage: &dyn Monitor) -> Option<Self> {
        let scope = Scope::of(models.own);
        let (own, lift) = scope.densities(models.own);
        let loads = models.own.asked().loads.len();
        let lattice = axes(task, own);
        let (of_nodes, of_lift) = if lift.is_some() { (0.2, 0.4) } else { (0.6, 0.0) };
        let ask = |lengths: &[[f64; 3]], coarse: bool, share: f64| {
            solved(task, models, lengths, coarse, &Part::new(stage, share))
        };
        let nodes = ResponseSurface::nodes(&lattice);
        let (mut values, holes) = filled(ask(&nodes, lift.is_some(), of_nodes)?, counts(&lattice))?;
        if let Some(lift) = lift {
            let few_axes = axes(task, lift);
            let few = ResponseSurface::nodes(&few_axes);
            let (fine, coarse) = (ask(&few, false, of_lift)?, ask(&few, true, 0.0)?);
            // A node without a result takes the difference of fine and coarse blocks from one other node, not from two.
            let over = fine.into_iter().zip(coarse).map(|(fine, coarse)| {
                Some(fine?.iter().zip(coarse?).map(|(fine, coarse)| fine - coarse).collect::<Vec<f64>>())
            });
            let (over, _) = filled(over.collect(), counts(&few_axes))?;
            let lift = ResponseSurface::through(few_axes, loads + BESIDE, over.concat());
            for (at, own) in nodes.iter().zip(&mut values) {
                own.iter_mut().zip(lift.at(at)).for_each(|(own, lift)| *own += lift);
            }
        }
        let surface = ResponseSurface::through(lattice, loads + BESIDE, values.concat());
        let part = Part::new(stage, 0.4 / 3.0);
        let of = |design: &Pattern| models.numbers(design).ok();
        let sensitivities = Nodes::new(task, ("slopes", models), &of, scope.sensitivities, &part)?;
        // ln (r + s) / r, s the change by smaller blocks; zero if these are too expensive, as in the final evaluation.
        let smaller = |design: &Pattern| {
            let ratios = models.own.steady(design).ok()?.ratio;
            let Some((shifts, _)) = models.refined(design, &ratios, true) else { return Some(vec![0.0; loads]) };
            Some(ratios.iter().zip(shifts).map(|(ratio, shift)| (shift / ratio).max(-0.5).ln_1p()).collect())
        };
        let blocks = Nodes::new(task, ("blocks", models), &smaller, scope.blocks, &part)?;
        // Ends and tilt change the effect 1 - R of a texture by a share that varies less than the change.
        let by_face = |design: &Pattern| {
            let ratios = models.own.steady(design).ok()?.ratio;
            let changes = beyond.by_face(design, &ratios, true, stage);
            let shares = changes.iter().zip(ratios).map(|(log, ratio)| log.exp_m1() * ratio / effect(ratio));
            Some(shares.collect::<Vec<f64>>()).filter(|shares| shares.iter().all(|share| share.is_finite()))
        };
        let face = match beyond.face {
            Some(_) => Some(Nodes::new(task, ("ends and tilt", models), &by_face, scope.face, &part)?),
            None => None,
        };
        let beside = [&sensitivities, &blocks].into_iter().chain(&face).map(Nodes::bytes).sum::<usize>();
        let bytes = size_of_val(surface.coefficients()) + beside;
        let report = TableReport { nodes: nodes.len(), holes: holes.len(), bytes, ..TableReport::default() };
        let (specimen, dimension) = (beyond.face, models.own.dimension());
        let mut table = Self { surface, holes, sensitivities, blocks, face, specimen, dimension, loads, report };
        table.measure(task, models, scope.checks, stage)?;
        Some(table)
    }

    /// Extends the table to the wider bounds of `task`, in the plane: quantities with few nodes are extrapolated as
    /// constant. `None` if `stage` is cancelled or if the model can compute no node.
    pub fn widened(&self, task: &DesignTask, models: &Models<'_>, stage: &dyn Monitor) -> Option<Self> {
        let lattice = axes(task, Scope::PLANE.nodes);
        let nodes = ResponseSurface::nodes(&lattice);
        let (values, holes) = filled(solved(task, models, &nodes, false, &Part::new(stage, 0.0))?, counts(&lattice))?;
        let surface = ResponseSurface::through(lattice, self.loads + BESIDE, values.concat());
        Some(Self { surface, holes, ..self.clone() })
    }

    /// Compares the table with the model at `count` random textures, uniform in the logarithms of the lengths; `None`
    /// if `stage` is cancelled.
    fn measure(&mut self, task: &DesignTask, models: &Models<'_>, count: usize, stage: &dyn Monitor) -> Option<()> {
        let all = random_places(self.surface.axes(), count, 1);
        let exact = solved(task, models, &all, false, &Part::new(stage, 0.0))?;
        let off = |(lengths_m, exact): (&[f64; 3], Option<Vec<f64>>)| {
            let design = task.space.pattern(*lengths_m).ok()?;
            let (exact, found) = (exact?, self.values(&design)?);
            let is_open = exact[self.loads + 2] < design.depth_m();
            let share = self.lay(&design)?.share(&design);
            let (exact, found) = (self.on_specimen(exact, share)?, self.on_specimen(found, share)?);
            let each = exact.iter().zip(&found).map(|(exact, found)| (exact - found).abs());
            is_open.then(|| each.fold(0.0, f64::max))
        };
        let mut off: Vec<f64> = all.iter().zip(exact).filter_map(off).collect();
        self.report.checked = off.len();
        self.report.worst_error = tidy(off.iter().copied().fold(0.0, f64::max));
        self.report.median_error = tidy(median(&mut off).unwrap_or(0.0));
        Some(())
    }

    /// Lays `design` out on the specimen; `None` if the specimen does not take it.
    pub fn lay(&self, design: &Pattern) -> Option<Laid> {
        Laid::new(self.specimen.as_ref(), design, self.dimension).ok()
    }

    /// ln R at each load on a specimen whose areal density is `share` times that of the infinite pattern with the
    /// outputs `values`; `None` if friction would vanish.
    fn on_specimen(&self, mut values: Vec<f64>, share: f64) -> Option<Vec<f64>> {
        values.truncate(self.loads);
        values.iter_mut().for_each(|log| *log = on_face(log.exp(), share).ln());
        values.iter().all(|log| log.is_finite()).then_some(values)
    }

    /// Interpolates all outputs of the infinite pattern, ln R at each load and [`BESIDE`] others, at the lengths of
    /// `design`; `None` next to a node that the model cannot compute.
    fn values(&self, design: &Pattern) -> Option<Vec<f64>> {
        let lengths_m = design.lengths_m();
        (!self.surface.is_beside(&self.holes, &lengths_m)).then(|| self.surface.at(&lengths_m))
    }

    /// Interpolated model values and results for `design`, laid out as in `laid`, in the layer's blocks, without the
    /// effects of the specimen's ends and pressure tilt; `None` next to a node that the model cannot compute, or if
    /// cavities close.
    pub fn at(&self, design: &Pattern, laid: &Laid) -> Option<(Modelled, Answer)> {
        let values = self.values(design)?;
        let answer = self.answer_of(design, &values)?;
        let face_share = laid.share(design);
        let log_ratio = self.on_specimen(values, face_share)?;
        let numbers = self.sensitivities.at(design.lengths_m());
        Some((Modelled { log_ratio, sensitivity: from_numbers(&numbers, self.loads), face_share }, answer))
    }

    /// Interpolated results for `design` without ratios, which needs no layout; `None` as for [`Self::at`].
    pub fn answer(&self, design: &Pattern) -> Option<Answer> {
        self.answer_of(design, &self.values(design)?)
    }

    /// Results without ratios from the outputs `values` of `design`; `None` if cavities close.
    fn answer_of(&self, design: &Pattern, values: &[f64]) -> Option<Answer> {
        let beside = &values[self.loads..];
        let clearance_m = design.depth_m() - beside[2];
        (clearance_m > 0.0).then(|| Answer {
            ratio: Vec::new(),
            peak_pressure_mpa: 1e-6 * beside[0].exp(),
            least_pressure: beside[1],
            clearance_um: Some(1e6 * clearance_m),
        })
    }

    /// Change of the logarithm of each of `ratios`, those of `design` by the table, by the specimen's ends and pressure
    /// tilt; empty, which means no change, if samples are sectors, and if no node has a value.
    pub fn by_face(&self, design: &Pattern, ratios: &[f64]) -> Vec<f64> {
        let shares = self.face.as_ref().map_or_else(Vec::new, |face| face.at(design.lengths_m()));
        let change = |share: f64, ratio: f64| if ratio > 0.0 { share * effect(ratio) / ratio } else { 0.0 };
        let log = |(share, ratio): (f64, &f64)| change(share, *ratio).max(-0.5).ln_1p();
        shares.into_iter().zip(ratios).map(log).collect()
    }

    /// Change of the logarithm of each ratio by smaller blocks.
    pub fn by_blocks(&self, design: &Pattern) -> Vec<f64> {
        self.blocks.at(design.lengths_m())
    }

    /// Errors of the dimensions of samples of `design` with the standard deviations of `tolerances`, from differences
    /// over one standard deviation to each side, with the number of cavities of `laid`; `None` as for [`Self::at`].
    pub fn dimension_shifts(
        &self,
        design: &Pattern,
        laid: &Laid,
        tolerances: &Tolerances,
    ) -> Option<Vec<DimensionShift>> {
        let own = |(_, by_m): (&str, [f64; 3])| {
            let [above, below] = [1.0, -1.0].map(|side| {
                let made = made(design, &by_m, side);
                self.on_specimen(self.values(&made)?, laid.share(&made))
            });
            let log_ratio = above?.into_iter().zip(below?).map(|(above, below)| 0.5 * (above - below));
            Some(shift(design, laid, &by_m, log_ratio.collect()))
        };
        of_dimensions(tolerances).into_iter().map(own).collect()
    }
}

/// Effect 1 - R of a texture whose ratio R is `ratio`, at least 0.01: ends and tilt change smaller ones by more than a
/// share of them.
fn effect(ratio: f64) -> f64 {
    (1.0 - ratio).max(0.01)
}

/// Axes over the bounds of `task`.
fn axes(task: &DesignTask, density: Density) -> [Axis; 3] {
    axes_between(task.space.lengths_m(), density)
}

/// Axes between `bounds` in any unit.
pub fn axes_between(bounds: [[f64; 2]; 3], (each, most): Density) -> [Axis; 3] {
    std::array::from_fn(|axis| {
        let [from, to] = bounds[axis];
        // At most some dozens, so the cast is exact.
        let wanted = 1 + (each[axis] * (to / from).ln()).ceil() as usize;
        Axis::new(bounds[axis], wanted.min(most[axis]))
    })
}

/// `count` random triples of lengths between the ends of `axes`, uniform in the logarithms.
pub fn random_places(axes: &[Axis; 3], count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut normals = Normals::new(seed);
    let mut at = |axis: &Axis| axis.from * (axis.to / axis.from).powf(normal_probability(normals.draw()));
    (0..count).map(|_| axes.each_ref().map(&mut at)).collect()
}

/// Numbers of nodes of the table of `task` by `model`: of the table itself, and of its correction from larger to the
/// requested blocks, 0 if there is no model in larger blocks.
pub fn nodes(task: &DesignTask, model: &SteadyModel<'_>) -> [f64; 2] {
    let count = |density: Density| axes(task, density).iter().map(|axis| axis.nodes as f64).product();
    let (own, lift) = Scope::of(model).densities(model);
    [count(own), lift.map_or(0.0, count)]
}

/// Solves infinite patterns with `lengths`, in metres: ln R at each load, ln of the peak pressure in pascals, minimum ratio
/// of local to nominal pressure, and sag in metres; in the guide's larger blocks if `coarse`. Closed cavities are
/// solved as if their ceiling could pass the counterface, so that outputs are smooth up to closure. An entry is `None`
/// if its design cannot be computed; the result is `None` once `stage` is cancelled or the cache fails.
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
            Some((_, Err(failure @ (ModelFailure::Cancelled | ModelFailure::Broken(_))))) => Err(failure),
            Some((design, Ok(answer))) => {
                let sag_m = answer.clearance_m().map_or(0.0, |clearance_m| design.depth_m() - clearance_m);
                let log = answer.ratio.iter().map(|ratio| ratio.ln());
                let all = log.chain([answer.peak_pressure_pa().ln(), answer.least_pressure, sag_m]);
                Ok(Some(all.collect::<Vec<f64>>()).filter(|all| all.iter().all(|value| value.is_finite())))
            }
            _ => Ok(None),
        }
    };
    let content = (models.own.content(), &task.space, lengths, coarse, "ln R of cells, ln peak, least, sag");
    cached(stage, ("nodes", &content), 1.0, || lengths.par_iter().map(one).collect::<Result<_, _>>()).ok()
}

/// Numbers of nodes along each of `axes`.
pub fn counts(axes: &[Axis; 3]) -> [usize; 3] {
    axes.each_ref().map(|axis| axis.nodes)
}

/// Gives nodes without values the values of the nearest node that has them, and returns the values and the indices of
/// these nodes; `None` if no node has values.
pub fn filled(answers: Vec<Option<Vec<f64>>>, [_, rows, depths]: [usize; 3]) -> Option<(Vec<Vec<f64>>, Vec<usize>)> {
    let place = |node: usize| [node / (rows * depths), node / depths % rows, node % depths];
    let answered: Vec<(usize, &Vec<f64>)> =
        answers.iter().enumerate().filter_map(|(node, answer)| Some((node, answer.as_ref()?))).collect();
    let nearest = |node: usize| {
        let distance = |(other, _): &&(usize, &Vec<f64>)| -> usize {
            place(node).iter().zip(place(*other)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
        };
        answered.iter().min_by_key(distance).map(|(_, answer)| (*answer).clone())
    };
    let holes = (0..answers.len()).filter(|node| answers[*node].is_none()).collect();
    let values = answers.iter().enumerate().map(|(node, answer)| answer.clone().or_else(|| nearest(node)));
    Some((values.collect::<Option<_>>()?, holes))
}

/// Numbers at the nodes of a lattice, interpolated linearly.
#[derive(Clone)]
struct Nodes {
    /// Logarithms of width, spacing and depth at the nodes.
    axes: [Vec<f64>; 3],
    /// Numbers at the nodes, width varying slowest, those of the nearest node where a design cannot be computed; empty
    /// if none can.
    nodes: Vec<Vec<f64>>,
}

impl Nodes {
    /// Evaluates `of` at up to `most` nodes along each length, a single one in the middle; `name` and `models` identify
    /// the values in the cache. `None` if `stage` is cancelled.
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
            let share = |node: usize| if count == 1 { 0.5 } else { node as f64 / (count - 1) as f64 };
            (0..count).map(|node| low + (high - low) * share(node)).collect()
        });
        let counts @ [widths, spacings, depths] = axes.each_ref().map(Vec::len);
        let count = widths * spacings * depths;
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
            if stage.cancelled() { Err(Cancelled) } else { Ok(nodes) }
        };
        let loads_of_face = (name == "ends and tilt").then(|| task.target.points().len());
        let content = (name, models.own.content(), models.content_of_sensitivities(), space, &axes, loads_of_face);
        let nodes = cached(stage, ("nodes", &content), 1.0, ask).ok()?;
        let nodes = filled(nodes, counts).map(|(nodes, _)| nodes).unwrap_or_default();
        Some(Self { axes, nodes })
    }

    fn bytes(&self) -> usize {
        self.nodes.iter().map(|node| size_of_val(&node[..])).sum()
    }

    /// Interpolates linearly between the eight surrounding nodes in the logarithms of the lengths; empty without nodes.
    /// Beyond the lattice the value at its edge is used.
    fn at(&self, lengths_m: [f64; 3]) -> Vec<f64> {
        let place = |axis: usize| {
            let (nodes, x) = (&self.axes[axis], lengths_m[axis].ln());
            let low = nodes.partition_point(|node| *node <= x).clamp(1, nodes.len().max(2) - 1) - 1;
            let Some(next) = nodes.get(low + 1) else { return (low, 0.0) };
            (low, ((x - nodes[low]) / (next - nodes[low])).clamp(0.0, 1.0))
        };
        let [(w, tw), (s, ts), (d, td)] = [0, 1, 2].map(place);
        let (spacings, depths) = (self.axes[1].len(), self.axes[2].len());
        let mut sum = vec![0.0; self.nodes.first().map_or(0, Vec::len)];
        for corner in 0..8 {
            let [i, j, k] = [corner >> 2, corner >> 1 & 1, corner & 1];
            let share = |t: f64, upper: usize| if upper == 1 { t } else { 1.0 - t };
            let weight = share(tw, i) * share(ts, j) * share(td, k);
            let node = self.nodes.get(((w + i) * spacings + s + j) * depths + d + k).filter(|_| weight != 0.0);
            node.into_iter().for_each(|node| sum.iter_mut().zip(node).for_each(|(sum, own)| *sum += weight * own));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_without_an_answer_has_that_of_the_nearest() {
        let mut answers = vec![None; 16];
        assert_eq!(filled(answers.clone(), [4, 4, 1]), None);
        (answers[2], answers[13]) = (Some(vec![0.5]), Some(vec![0.7]));
        let values: Vec<f64> = filled(answers, [4, 4, 1]).unwrap().0.iter().map(|answer| answer[0]).collect();
        assert_eq!((values[2], values[7], values[9], values[13], values[12]), (0.5, 0.5, 0.7, 0.7, 0.7));
    }
}
