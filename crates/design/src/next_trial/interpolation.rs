//! The steady model on a lattice of designs, and between its nodes.

use rayon::prelude::*;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_discrepancy::{DimensionShift, Features};
use slipgrid_monitor::{Monitor, Part};
use slipgrid_optimize::{ModelFailure, Tolerances};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Scene, block_refinement};

use super::BeyondCells;
use super::candidate_search::Scope;
use crate::DesignError;
use crate::chance::made;
use crate::kept_nodes::kept;
use crate::learned_discrepancy::ModulusSlopes;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// Most multiplications of a cell by which a candidate is refined: some hundredths of a second.
const MOST_REFINED: f64 = 2e8;

/// Modelled ratio and its slope along the logarithm of Young's modulus, at every load.
#[derive(Clone, Debug, PartialEq)]
pub struct Modelled {
    /// ln R.
    pub log_ratio: Vec<f64>,
    /// g = d ln R / d ln E.
    pub sensitivity: Vec<f64>,
}

/// The model with its slopes along Young's modulus.
pub struct Models<'a> {
    own: &'a SteadyModel<'a>,
    slopes: ModulusSlopes<'a>,
}

impl<'a> Models<'a> {
    /// Those about `own`, whose material is known as `material` says.
    ///
    /// # Errors
    /// [`DesignError`] where the area law cannot be moved.
    pub fn new(own: &'a SteadyModel<'a>, material: &MaterialUncertainty) -> Result<Self, DesignError> {
        Ok(Self { own, slopes: ModulusSlopes::new(own, material)? })
    }

    /// What they say of `design`.
    ///
    /// # Errors
    /// [`ModelFailure`] where it cannot be computed.
    pub fn at(&self, design: &Pattern) -> Result<Modelled, ModelFailure> {
        Ok(Modelled {
            log_ratio: self.ratios(design)?.iter().map(|ratio| ratio.ln()).collect(),
            sensitivity: self.slopes.at(design)?,
        })
    }

    /// Loads of all conditions.
    fn loads(&self) -> usize {
        self.own.asked().loads.len()
    }

    /// Modelled ratios alone.
    fn ratios(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        self.own.ratios_made(design, &self.own.lay(design)?)
    }

    /// What smaller blocks change of each ratio of `design`, and how far each is from vanishing blocks, as a standard deviation; `None`
    /// of rims in space, in several directions, and where smaller blocks are dear.
    pub fn refined(&self, design: &Pattern) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.own.has_directions() {
            return None;
        }
        let scene = Scene { pattern: Some(*design), ..self.own.asked().clone() };
        let share = self.own.share(design).ok()?;
        // Of the cell: 1 - r = (1 - r_cell) D / D_period
        let own: Vec<Option<f64>> =
            self.ratios(design).ok()?.iter().map(|ratio| Some(1.0 - (1.0 - ratio) / share)).collect();
        let refined = block_refinement(&scene, &own, MOST_REFINED)?;
        // What errors hardly exceed, as two standard deviations.
        let open = refined.errors.iter().map(|error| 0.5 * share * error).collect();
        Some((refined.shifts.iter().map(|shift| share * shift).collect(), open))
    }
}

/// The models at the nodes of a lattice, and what smaller blocks change at those of a coarser one.
pub struct Interpolation {
    model: Nodes,
    blocks: Nodes,
    face: Nodes,
}

/// Numbers at the nodes of a lattice.
struct Nodes {
    /// Logarithms of width, spacing and depth at the nodes.
    axes: [Vec<f64>; 3],
    /// Nodes, widths slowest; `None` where a design cannot be computed.
    nodes: Vec<Option<Modelled>>,
}

impl Interpolation {
    /// Asks `models` at the nodes of lattices over the space of `task`, as many along each length as `scope` says, and what smaller blocks and
    /// what is `beyond` cells change, as the whole of `stage`; `None` where that ends before.
    pub fn new(
        task: &DesignTask,
        models: &Models<'_>,
        beyond: &BeyondCells<'_>,
        scope: &Scope,
        stage: &dyn Monitor,
    ) -> Option<Self> {
        let third = Part::new(stage, 1.0 / 3.0);
        let model = Nodes::new(task, ("model", models), &|design| models.at(design).ok(), scope.nodes, &third)?;
        // ln (r + s) / r, s what smaller blocks change; nothing where they are dear, as for what is judged in the end.
        let shift = |design: &Pattern| {
            let nothing = || Modelled { log_ratio: vec![0.0; models.loads()], sensitivity: Vec::new() };
            let Some((shifts, _)) = models.refined(design) else { return Some(nothing()) };
            let ratios = models.ratios(design).ok()?;
            let logs = ratios.iter().zip(shifts).map(|(ratio, shift)| (shift / ratio).max(-0.5).ln_1p());
            Some(Modelled { log_ratio: logs.collect(), sensitivity: Vec::new() })
        };
        let blocks = Nodes::new(task, ("blocks", models), &shift, scope.blocks, &third)?;
        let by_face = |design: &Pattern| {
            let log_ratio = beyond.by_face(design, &models.ratios(design).ok()?, true, stage);
            Some(Modelled { log_ratio, sensitivity: Vec::new() })
        };
        let face = Nodes::new(task, ("face", models), &by_face, scope.face, &third)?;
        Some(Self { model, blocks, face })
    }

    /// What the models say of a design of these lengths, between the nodes about it; `None` where one of them cannot be computed.
    pub fn at(&self, lengths_m: [f64; 3]) -> Option<Modelled> {
        self.model.at(lengths_m)
    }

    /// Change of the logarithm of each ratio by ends and tilt; none where a node beside it has no answer.
    pub fn by_face(&self, lengths_m: [f64; 3]) -> Vec<f64> {
        self.face.at(lengths_m).map_or_else(Vec::new, |known| known.log_ratio)
    }

    /// What smaller blocks change of the logarithm of each ratio, so far as it is known there.
    pub fn shifts(&self, lengths_m: [f64; 3]) -> Option<Vec<f64>> {
        Some(self.blocks.at(lengths_m)?.log_ratio)
    }

    /// Errors of the dimensions of samples of `design` that scatter as `tolerances` say: differences over a standard deviation each way.
    pub fn dimension_shifts(&self, design: &Pattern, tolerances: &Tolerances) -> Option<Vec<DimensionShift>> {
        let shift = |by_m: &[f64; 3]| {
            let [above, below] = [1.0, -1.0].map(|side| made(design, by_m, side));
            let log_ratio = self.at(above.lengths_m())?.log_ratio;
            let log_ratio = log_ratio.iter().zip(self.at(below.lengths_m())?.log_ratio);
            Some(DimensionShift {
                log_ratio: log_ratio.map(|(above, below)| 0.5 * (above - below)).collect(),
                above: Features::from(&above),
                below: Some(Features::from(&below)),
            })
        };
        tolerances.independent_m().iter().map(shift).collect()
    }
}

impl Nodes {
    /// Asks `of`, the answer called `name` of `models`, at the nodes.
    fn new(
        task: &DesignTask,
        (name, models): (&str, &Models<'_>),
        of: &(dyn Fn(&Pattern) -> Option<Modelled> + Sync),
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
            let nodes: Vec<Option<Modelled>> = (0..count)
                .into_par_iter()
                .map(|node| {
                    let lengths = [node / (spacings * depths), node / depths % spacings, node % depths];
                    let design = space.pattern(std::array::from_fn(|axis| axes[axis][lengths[axis]].exp())).ok()?;
                    let found = if stage.cancelled() { None } else { of(&design) };
                    stage.advance(share);
                    found
                })
                .collect();
            let numbers = |found: Modelled| [found.log_ratio, found.sensitivity].concat();
            (!stage.cancelled()).then(|| nodes.into_iter().map(|found| found.map(numbers)).collect())
        };
        let loads_of_face = (name == "face").then(|| task.target.points().len());
        let content = (name, models.own.content(), models.slopes.content(), space, &axes, loads_of_face);
        let loads = models.loads();
        let modelled = |numbers: Vec<f64>| {
            let (log_ratio, sensitivity) = numbers.split_at_checked(loads)?;
            Some(Modelled { log_ratio: log_ratio.to_vec(), sensitivity: sensitivity.to_vec() })
        };
        let nodes = kept(stage, &content, count, ask)?.into_iter().map(|node| node.and_then(modelled)).collect();
        Some(Self { axes, nodes })
    }

    /// What the models say of a design of these lengths, linear between the eight nodes about it in the logarithms; `None` where
    /// one of them cannot be computed. Beyond the lattice its edge stands.
    fn at(&self, lengths_m: [f64; 3]) -> Option<Modelled> {
        let place = |axis: usize| {
            let (nodes, x) = (&self.axes[axis], lengths_m[axis].ln());
            let low = nodes.partition_point(|node| *node <= x).clamp(1, nodes.len().max(2) - 1) - 1;
            let Some(next) = nodes.get(low + 1) else { return (low, 0.0) };
            (low, ((x - nodes[low]) / (next - nodes[low])).clamp(0.0, 1.0))
        };
        let [(w, tw), (s, ts), (d, td)] = [0, 1, 2].map(place);
        let (spacings, depths) = (self.axes[1].len(), self.axes[2].len());
        let mut sum: Option<Modelled> = None;
        for corner in 0..8 {
            let [i, j, k] = [corner >> 2, corner >> 1 & 1, corner & 1];
            let share = |t: f64, upper: usize| if upper == 1 { t } else { 1.0 - t };
            let weight = share(tw, i) * share(ts, j) * share(td, k);
            if weight == 0.0 {
                continue;
            }
            let node = self.nodes[((w + i) * spacings + s + j) * depths + d + k].as_ref()?;
            let sum = sum.get_or_insert_with(|| Modelled {
                log_ratio: vec![0.0; node.log_ratio.len()],
                sensitivity: vec![0.0; node.sensitivity.len()],
            });
            for (sum, own) in [(&mut sum.log_ratio, &node.log_ratio), (&mut sum.sensitivity, &node.sensitivity)] {
                sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += weight * own);
            }
        }
        sum
    }
}
