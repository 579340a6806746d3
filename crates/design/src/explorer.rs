//! Predictions for a sample of any texture within the bounds, on a lattice, so that a page only has to interpolate.

use std::ops::Range;

use crate::results::material_doubts;
use rayon::prelude::*;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::statistics::{Axis, ResponseSurface, median};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, tidy};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Load, Simulation};

use crate::DesignError;
use crate::prediction::Prediction;
use crate::prepared_task::PreparedTask;
use crate::search::Search;
use crate::session::with_table;
use crate::table::{Density, axes_between, filled, random_places};
use crate::task::{DesignTask, KnownMaterial};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;

/// Nodes along width, spacing and depth.
const NODES: Density = ([4.0, 3.5, 2.2], [11, 12, 8]);
/// Number of random textures at which the interpolation error is estimated.
const CHECKS: usize = 60;
/// Range of the correction of nodes around the design to the reported values: standard deviation of a Gaussian weight
/// in the logarithms of the lengths, about two nodes.
const NEARBY: f64 = 0.5;
/// The correction to reported values is made only if its weight, interpolated at the design, is at least this.
const MIN_REACHED: f64 = 0.3;
/// Chances are limited to this distance from 0 and 1, because their log odds are interpolated.
const MIN_CHANCE: f64 = 1e-4;

/// Predictions for a sample of any texture within the bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Explorer {
    /// Interpolated over width, spacing and depth in micrometres, in the quantity of the target: medians of samples at
    /// all loads of all conditions, then lower ends of the 95 % intervals of samples, then upper ends.
    pub expected: ResponseSurface,
    /// Interpolated log odds ln(p / (1 - p)), p the chance that a sample is on target.
    pub log_odds: ResponseSurface,
    /// Five interpolated values: logarithm of the maximum local pressure in MPa, minimum height of a cavity's ceiling
    /// under load in micrometres, share of the specimen's face that is cavity, logarithm of the laser time in seconds (0 if unknown),
    /// and minimum ratio of local to nominal pressure.
    pub beside: ResponseSurface,
    /// Indices of nodes that the model cannot compute; no values are interpolated between them and adjacent nodes.
    pub holes: Vec<usize>,
    /// Number of random textures at which interpolated medians were compared with direct predictions.
    pub checked: usize,
    /// Median over the random textures of the largest difference at any load between interpolated and predicted medians
    /// of samples, in the quantity of the target.
    pub median_error: f64,
    /// Maximum over the random textures of the largest difference at any load between interpolated and predicted
    /// medians of samples, in the quantity of the target.
    pub worst_error: f64,
}

/// Predictions for the designs of a task, before a design is chosen.
#[derive(Clone, Debug)]
pub struct Explored {
    /// Task with resolved conditions.
    pub task: DesignTask,
    /// Material of the task.
    pub material: KnownMaterial,
    /// Texture that a page shows first: of the textures with a prediction, the one with the maximum chance by the
    /// table.
    pub pattern: Pattern,
    /// Loads at the condition of the design.
    pub loads: Vec<Load>,
    /// Dynamic friction coefficient of the flat surface at each load, with the excess of dynamic over steady friction.
    pub flat_mu: Vec<f64>,
    /// Number of trials that predictions use.
    pub trials: usize,
    /// Target pressures outside the measured range, in words; `None` if there are none.
    pub beyond_measured: Option<String>,
    /// Predictions for all designs.
    pub explorer: Explorer,
}

/// Prediction for samples of one texture, interpolated between the nodes of an [`Explorer`].
#[derive(Clone, Debug, PartialEq)]
pub struct ExploredTexture {
    /// Median over cut samples at each target pressure, in the quantity of the target.
    pub expected: Vec<f64>,
    /// Lower end of the interval of 95 % of samples, in the quantity of the target.
    pub lower_95: Vec<f64>,
    /// Upper end of the interval of 95 % of samples, in the quantity of the target.
    pub upper_95: Vec<f64>,
    /// Chance that a sample is on target; `None` if the target accepts every value.
    pub chance: Option<f64>,
    /// Maximum local pressure, in MPa.
    pub peak_pressure_mpa: f64,
    /// Minimum height of a cavity's ceiling above the counterface under load, in micrometres.
    pub clearance_um: f64,
    /// Share of the face that is cavity.
    pub areal_density: f64,
    /// Time under the laser, in seconds; `None` if it is unknown.
    pub laser_s: Option<f64>,
}

/// Relative distance beyond a bound that counts as rounding, such as that of the conversion from metres to micrometres.
pub const BOUND_ROUNDING: f64 = 1e-9;

impl Explored {
    /// Interpolates the prediction for samples with width, spacing and depth `lengths_um`, at the loads of the first
    /// condition; `None` outside the bounds and beside textures that the model cannot compute.
    pub fn predict(&self, lengths_um: [f64; 3]) -> Option<ExploredTexture> {
        let Explorer { expected, log_odds, beside, holes, .. } = &self.explorer;
        let is_within = expected.axes().iter().zip(lengths_um).all(|(axis, length_um)| {
            (axis.from * (1.0 - BOUND_ROUNDING)..=axis.to * (1.0 + BOUND_ROUNDING)).contains(&length_um)
        });
        if !is_within || expected.is_beside(holes, &lengths_um) {
            return None;
        }
        let points = self.task.target.points();
        let all = expected.at(&lengths_um);
        // Medians of every load of every condition, then the lower ends, then the upper ends.
        let part = |number: usize| all[number * all.len() / 3..][..points.len()].to_vec();
        let has_demand = points.iter().any(|point| point.wanted.band().iter().any(Option::is_some));
        let log_odds = log_odds.at(&lengths_um)[0];
        let beside = beside.at(&lengths_um);
        Some(ExploredTexture {
            expected: part(0),
            lower_95: part(1),
            upper_95: part(2),
            chance: has_demand.then(|| 1.0 / (1.0 + (-log_odds).exp())),
            peak_pressure_mpa: beside[0].exp(),
            clearance_um: beside[1],
            areal_density: beside[2],
            laser_s: self.task.laser_time_s(&self.pattern).map(|_| beside[3].exp()),
        })
    }

    /// Reasons to doubt the numbers, in words.
    pub fn doubts(&self) -> Vec<String> {
        self.beyond_measured.clone().into_iter().chain(material_doubts(&self.material.material.provenance)).collect()
    }
}

/// Computes predictions for all designs within the bounds of `task`, by interpolation of the model.
///
/// # Errors
/// [`DesignError`] for a task that is refused or that the monitor cancels, and where no design can be computed.
pub fn explore_bounds(task: &DesignTask, monitor: &dyn Monitor) -> Result<Explored, DesignError> {
    let prepared = &PreparedTask::new(task)?;
    let budget = TimeBudget::new(monitor, None);
    let found = with_table(prepared, None, None, budget, &mut Timings::default(), |search, _| {
        let about_best = |open: &(dyn Fn(&Pattern) -> bool + Sync)| -> Result<(Pattern, Explorer), DesignError> {
            let nothing_computed = || search.models.own.nothing_computed(&task.space);
            let (best, _) = search.greatest(open);
            monitor.heed()?;
            let best = best.ok_or_else(nothing_computed)?;
            let pattern = best.texture.pattern;
            // Same accuracy as in `optimize`: with the effects of the specimen's ends, pressure tilt and time for this
            // texture.
            let about = search.solved(&pattern).map_or(best, |solved| search.as_cut(&solved));
            let explorer = Explorer::new(search, &about, about.texture.run.as_deref());
            monitor.heed()?;
            Ok((pattern, explorer.ok_or_else(nothing_computed)?))
        };
        let (pattern, explorer) = about_best(&|_| true)?;
        // A page begins at a texture that has a prediction.
        let found = if explorer.has_answer(&pattern) {
            (pattern, explorer)
        } else {
            about_best(&|other| explorer.has_answer(other)).unwrap_or((pattern, explorer))
        };
        monitor.heed()?;
        Ok((found, search.asked.learned.trials().len()))
    });
    let ((pattern, explorer), trials) = found?;
    let loads = prepared.loads().to_vec();
    let PreparedTask { task, material, uncertainty, outside, .. } = prepared.clone();
    let beyond_measured = task.beyond_measured(&material, &outside);
    let excess = uncertainty.excess(&task.pressures_pa(), task.condition.as_ref());
    let in_time = |row: usize| excess.as_ref().map_or(1.0, |excess| excess[row]);
    let flat_mu = |(row, load): (usize, &Load)| load.flat_mu(material.area_law.as_ref()) * in_time(row);
    let flat_mu = loads.iter().enumerate().map(flat_mu).collect();
    let material = KnownMaterial { material, uncertainty };
    Ok(Explored { task, material, pattern, loads, flat_mu, trials, beyond_measured, explorer })
}

impl Explorer {
    /// Whether `pattern` has a prediction: the model can compute all nodes around it.
    fn has_answer(&self, pattern: &Pattern) -> bool {
        !self.expected.is_beside(&self.holes, &pattern.lengths_m().map(|m| LENGTH_UM.from_si(m)))
    }

    /// Builds the explorer from the table of `search`, corrected by the table's error at the texture of `about`, and
    /// with the covariance of the errors that samples of this texture share. Near this texture the maximum pressure is
    /// that of `run`, a dynamic run of the texture on the specimen, where outer lands carry more than in an infinite
    /// pattern. `None` if no design can be computed or the search is cancelled.
    pub fn new(search: &Search<'_>, about: &Prediction, run: Option<&Simulation>) -> Option<Self> {
        let (task, loads) = (search.task, search.asked.loads.len());
        let off = search.off_at(about);
        let bounds_um = task.space.lengths_m().map(|bounds| bounds.map(|m| LENGTH_UM.from_si(m)));
        let axes = axes_between(bounds_um, NODES);
        let predicted = |lengths_um: &[f64; 3]| {
            let pattern = task.space.pattern(lengths_um.map(|um| LENGTH_UM.to_si(um))).ok()?;
            if search.stage.cancelled() {
                return None;
            }
            let found = search.roughly_with(&pattern, &off, &about.texture.covariance, 1.0)?;
            Some((pattern, found))
        };
        // Medians and 95 % intervals of samples in the quantity of the target, and the log odds.
        let numbers_of = |found: &Prediction| {
            let at = |load: usize, p: f64| search.asked.bands[load].flat * found.quantile(load, p);
            let quantiles = [0.5, 0.025, 0.975].into_iter().flat_map(|p| (0..loads).map(move |load| (load, p)));
            let mut numbers: Vec<f64> = quantiles.map(|(load, p)| at(load, p)).collect();
            let chance = found.chance().clamp(MIN_CHANCE, 1.0 - MIN_CHANCE);
            numbers.push((chance / (1.0 - chance)).ln());
            numbers
        };
        let beside_of = |pattern: &Pattern, run: Option<&Simulation>| {
            let answer = search.table.answer(pattern)?;
            let peak_pa = run.map_or_else(|| answer.peak_pressure_pa(), Simulation::peak_pressure_pa);
            Some([
                PRESSURE_MPA.from_si(peak_pa).ln(),
                answer.clearance_um.unwrap_or_else(|| LENGTH_UM.from_si(pattern.depth_m())),
                task.specimen.layout(*pattern).ok()?.areal_density(),
                task.laser_time_s(pattern).map_or(0.0, f64::ln),
                answer.least_pressure,
            ])
        };
        let node = |lengths_um: &[f64; 3]| {
            let (pattern, found) = predicted(lengths_um)?;
            Some([&numbers_of(&found)[..], &beside_of(&pattern, None)?].concat())
        };
        let nodes = ResponseSurface::nodes(&axes);
        let answers: Vec<Option<Vec<f64>>> = nodes.par_iter().map(node).collect();
        if search.stage.cancelled() {
            return None;
        }
        let (all, holes) = filled(answers, &axes)?;
        let mut reported = numbers_of(about);
        reported.extend(beside_of(&about.texture.pattern, run).into_iter().flatten());
        let all = self_consistent(all, &axes, (&nodes, &holes), about, &reported);
        let (expected, log_odds) = (surface(&axes, &all, 0..3 * loads), surface(&axes, &all, 3 * loads..3 * loads + 1));
        let beside = surface(&axes, &all, 3 * loads + 1..3 * loads + 6);
        let checks = random_places(&axes, CHECKS, 2);
        let off = |lengths_um: &[f64; 3]| {
            if expected.is_beside(&holes, lengths_um) {
                return None;
            }
            let medians = predicted(lengths_um)?.1.medians();
            let known = expected.at(lengths_um);
            let each = medians.iter().zip(&search.asked.bands).zip(&known);
            Some(each.map(|((median, band), known)| (band.flat * median - known).abs()).fold(0.0, f64::max))
        };
        let mut off: Vec<f64> = checks.par_iter().filter_map(off).collect();
        let worst_error = tidy(off.iter().copied().fold(0.0, f64::max));
        let (checked, median_error) = (off.len(), tidy(median(&mut off).unwrap_or(0.0)));
        Some(Self { expected, log_odds, beside, holes, checked, median_error, worst_error })
    }
}

/// Interpolates those numbers of each node that have the indices `of`; `all` holds the numbers of each node.
fn surface(axes: &[Axis; 3], all: &[Vec<f64>], of: Range<usize>) -> ResponseSurface {
    let numbers = all.iter().flat_map(|numbers| numbers[of.clone()].iter().copied()).collect();
    ResponseSurface::through(*axes, of.len(), numbers)
}

/// Corrects the numbers `all` of the nodes near the texture of `about`, so that interpolation gives the values
/// `reported` at this texture. The correction decreases with distance. No correction is made if the texture lies beside
/// a node that the model cannot compute.
fn self_consistent(
    mut all: Vec<Vec<f64>>,
    axes: &[Axis; 3],
    (nodes, holes): (&[[f64; 3]], &[usize]),
    about: &Prediction,
    reported: &[f64],
) -> Vec<Vec<f64>> {
    let about_um = about.texture.pattern.lengths_m().map(|m| LENGTH_UM.from_si(m));
    let own = surface(axes, &all, 0..reported.len());
    if own.is_beside(holes, &about_um) {
        return all;
    }
    // exp(-|ln x - ln x_about|^2 / 2 l^2)
    let weight = |node: &[f64; 3]| {
        let square: f64 = node.iter().zip(&about_um).map(|(a, b)| (a / b).ln().powi(2)).sum();
        vec![(-0.5 * square / NEARBY.powi(2)).exp()]
    };
    let weights: Vec<Vec<f64>> = nodes.iter().map(weight).collect();
    let at_about = surface(axes, &weights, 0..1).at(&about_um)[0];
    if at_about < MIN_REACHED {
        return all;
    }
    let off: Vec<f64> = own.at(&about_um).iter().zip(reported).map(|(own, reported)| reported - own).collect();
    for (numbers, weight) in all.iter_mut().zip(&weights) {
        numbers.iter_mut().zip(&off).for_each(|(number, off)| *number += off * weight[0] / at_about);
    }
    all
}
