//! Predictions for a sample of any texture within the bounds, on a lattice, so that a page only has to interpolate.
//!
//! The areal density of a small specimen jumps where one more cavity fits. Nodes therefore hold predictions for several
//! cavity fractions of the face over that of a period, between which the predictions are smooth; a texture has its own.

use std::ops::Range;

use crate::results::material_doubts;
use rayon::prelude::*;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::statistics::{Axis, ResponseSurface, extremes, median};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, tidy};
use slipgrid_laser::export::{Layout, exposure_time_s, one_exposure};
use slipgrid_laser::specimen::Laid;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Dimension, Load, Simulation};

use crate::DesignError;
use crate::prediction::Prediction;
use crate::prepared_task::PreparedTask;
use crate::search::Search;
use crate::session::with_table;
use crate::table::{Density, axes_between, counts, filled, random_places};
use crate::task::{DesignTask, KnownMaterial};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;

/// Nodes along width, spacing and depth.
const NODES: Density = ([4.0, 3.5, 2.2], [11, 12, 8]);
/// Number of random textures at which the interpolation error is estimated.
const CHECKS: usize = 60;
/// Number of random textures whose cavity fractions bound those of all textures.
const LAID: usize = 1000;
/// Distance of the nodes of cavity fractions between which the log odds are interpolated. Half of it changes no chance
/// by 0.005 (`an_explorer_says_what_the_search_does_of_every_texture`).
const SHARE_STEP: f64 = 0.15;
/// Maximum number of nodes of cavity fractions.
const MAX_SHARES: usize = 7;
/// Minimum distance of the smallest and greatest cavity fraction.
const SAME_SHARE: f64 = 1e-3;
/// Number of outputs of [`Explorer::beside`].
pub const BESIDE: usize = 6;
/// Range of the correction of nodes around the design to the reported values: standard deviation of a Gaussian weight
/// in the logarithms of the lengths, about two nodes.
const NEARBY: f64 = 0.5;
/// The correction to reported values is made only if its weight, interpolated at the design, is at least this.
const MIN_REACHED: f64 = 0.3;

/// Predictions for a sample of any texture within the bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Explorer {
    /// Interpolated over width, spacing and depth in micrometres, in the quantity of the target: medians of samples at
    /// all loads of all conditions, then lower ends of the 95 % intervals of samples, then upper ends; all for the first
    /// of [`Self::quantile_nodes`] evenly spaced cavity fractions between `shares`, then all for the next.
    pub expected: ResponseSurface,
    /// Interpolated [`soft_odds`] of the chance that a sample is on target, above those that [`rough_odds`] makes of
    /// medians and intervals, for evenly spaced cavity fractions between `shares`; then the [`core`] of the distribution.
    /// The difference is small and smooth, while chances fall steeply from node to node.
    pub odds: ResponseSurface,
    /// Lowest and highest accepted value at each load of the first condition, in the quantity of the target.
    pub bands: Vec<[Option<f64>; 2]>,
    /// Six interpolated values: logarithm of the maximum local pressure in MPa, minimum height of a cavity's ceiling
    /// under load in micrometres, minimum ratio of local to nominal pressure, logarithm of the time of one exposure over
    /// the area of the cavities and the time of [`one_exposure`] (0 if unknown), share of the face that is cavity, and
    /// the cavity fraction as in `shares`.
    pub beside: ResponseSurface,
    /// Range of the cavity fractions of the face over that of a period, of the nodes and of random textures; fractions
    /// beyond it count as its ends.
    pub shares: [f64; 2],
    /// Dimension of the model.
    pub dimension: Dimension,
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
    /// Number of whole passes or bursts nearest to the depth, and the depth that they make in micrometres; `None` if the
    /// laser's depth is unknown.
    pub exposures: Option<(f64, f64)>,
    /// Time under the laser, in seconds; `None` if it is unknown.
    pub laser_s: Option<f64>,
}

/// Relative distance beyond a bound that counts as rounding, such as that of the conversion from metres to micrometres.
pub const BOUND_ROUNDING: f64 = 1e-9;

impl Explored {
    /// Interpolates the prediction for samples with width, spacing and depth `lengths_um`, at the loads of the first
    /// condition; `None` outside the bounds and beside textures that the model cannot compute.
    pub fn predict(&self, lengths_um: [f64; 3]) -> Option<ExploredTexture> {
        let Explorer { expected, beside, holes, .. } = &self.explorer;
        let is_within = expected.axes().iter().zip(lengths_um).all(|(axis, length_um)| {
            (axis.from * (1.0 - BOUND_ROUNDING)..=axis.to * (1.0 + BOUND_ROUNDING)).contains(&length_um)
        });
        if !is_within || expected.is_beside(holes, &lengths_um) {
            return None;
        }
        let pattern = self.task.space.pattern(lengths_um.map(|um| LENGTH_UM.to_si(um))).ok()?;
        let layout = self.task.specimen.layout(pattern).ok()?;
        let points = self.task.target.points();
        let (all, chance) = self.explorer.sample(&layout);
        // Medians of every load of every condition, then the lower ends, then the upper ends.
        let part = |number: usize| all[number * all.len() / 3..][..points.len()].to_vec();
        let has_demand = points.iter().any(|point| point.wanted.band().iter().any(Option::is_some));
        let beside = beside.at(&lengths_um);
        let exposed = one_exposure(layout.pattern(), &self.task.laser)
            .map(|(each_um, time_s_m2)| ((lengths_um[2] / each_um).round().max(1.0), each_um, time_s_m2));
        Some(ExploredTexture {
            expected: part(0),
            lower_95: part(1),
            upper_95: part(2),
            chance: has_demand.then_some(chance),
            peak_pressure_mpa: beside[0].exp(),
            clearance_um: beside[1],
            areal_density: layout.areal_density(),
            exposures: exposed.map(|(count, each_um, _)| (count, count * each_um)),
            laser_s: exposed
                .and_then(|(count, _, time_s_m2)| Some(count * time_s_m2? * layout.cavity_area_m2() * beside[3].exp())),
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
    let budget = TimeBudget::new(monitor, None, 1.0);
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

    /// Number of cavity fractions between which medians and ends of intervals are interpolated.
    pub fn quantile_nodes(&self) -> usize {
        (self.odds.outputs() - 1).min(3)
    }

    /// Medians and ends of 95 % intervals as in [`Self::expected`], and the chance, of samples laid out as in `layout`.
    pub fn sample(&self, layout: &Layout) -> (Vec<f64>, f64) {
        let lengths_um = layout.pattern().lengths_m().map(|m| LENGTH_UM.from_si(m));
        let share = Laid::from_layout(layout, self.dimension).share(layout.pattern());
        let expected = between(&self.expected.at(&lengths_um), self.quantile_nodes(), self.shares, share);
        let mut above = self.odds.at(&lengths_um);
        let core = above.pop().unwrap_or(NORMAL_CORE);
        let above = between(&above, above.len(), self.shares, share)[0];
        let chance = chance_of(above + rough_odds(&self.bands, &expected, core));
        (expected, chance)
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
        let pattern = |lengths_um: &[f64; 3]| task.space.pattern(lengths_um.map(|um| LENGTH_UM.to_si(um))).ok();
        let dimension = search.models.own.dimension();
        let laid = |lengths_um: &[f64; 3]| {
            let layout = task.specimen.layout(pattern(lengths_um)?).ok()?;
            Some((Laid::from_layout(&layout, dimension).share(layout.pattern()), layout))
        };
        let nodes = ResponseSurface::nodes(&axes);
        let laid_nodes: Vec<Option<(f64, Layout)>> = nodes.par_iter().map(laid).collect();
        let places = random_places(&axes, LAID, 3);
        let further: Vec<f64> = places.par_iter().filter_map(|place| Some(laid(place)?.0)).collect();
        let [from, to] = extremes(laid_nodes.iter().flatten().map(|(share, _)| *share).chain(further));
        let shares = [from, to.max(from + SAME_SHARE)];
        // One prediction for each half of the range, or several for each.
        let halves = ((to - from) / (2.0 * SHARE_STEP)).ceil() as usize;
        let odds_nodes = if to - from < SHARE_STEP { 2 } else { 1 + 2 * halves.min(MAX_SHARES / 2) };
        let quantile_nodes = odds_nodes.min(3);
        let predicted = |lengths_um: &[f64; 3], share: f64| {
            let pattern = pattern(lengths_um).filter(|_| !search.stage.cancelled())?;
            let laid = Laid::of_share(share, &pattern, dimension);
            search.roughly_unlimited((&pattern, &laid), &off, &about.texture.covariance)
        };
        // Medians and 95 % intervals of samples in the quantity of the target.
        let quantiles_of = |found: &Prediction| -> Vec<f64> {
            let at = |load: usize, p: f64| search.asked.bands[load].flat * found.quantile(load, p);
            [0.5, 0.025, 0.975].into_iter().flat_map(|p| (0..loads).map(move |load| at(load, p))).collect()
        };
        let bands: Vec<[Option<f64>; 2]> = task.target.points().iter().map(|point| point.wanted.band()).collect();
        let above = |found: &Prediction, quantiles: &[f64], core: f64| {
            soft_odds(found.chance()) - rough_odds(&bands, quantiles, core)
        };
        // Smooth, unlike the time: depths are whole exposures, and widths take whole lines. A cavity narrower than the spot
        // has no line, and the number of one that fits.
        let spot_um = task.laser.spot_um.unwrap_or(0.0);
        let log_time = |layout: &Layout| {
            let [width_um, spacing_um, depth_um] = layout.pattern().lengths_m().map(|m| LENGTH_UM.from_si(m));
            let log = |layout: &Layout| {
                let (_, time_s_m2) = one_exposure(layout.pattern(), &task.laser)?;
                let log = (exposure_time_s(layout, &task.laser)? / (time_s_m2? * layout.cavity_area_m2())).ln();
                log.is_finite().then_some(log)
            };
            log(layout).or_else(|| log(&laid(&[width_um.max(spot_um), spacing_um, depth_um])?.1)).unwrap_or(0.0)
        };
        let beside_of = |(share, layout): &(f64, Layout), log_time: f64, run: Option<&Simulation>| {
            let (pattern, density) = (layout.pattern(), layout.areal_density());
            let answer = search.table.answer(pattern)?;
            let peak_pa = run.map_or_else(|| answer.peak_pressure_pa(), Simulation::peak_pressure_pa);
            Some([
                PRESSURE_MPA.from_si(peak_pa).ln(),
                answer.clearance_um.unwrap_or_else(|| LENGTH_UM.from_si(pattern.depth_m())),
                answer.least_pressure,
                log_time,
                density,
                *share,
            ])
        };
        // One exposure takes as long at every depth.
        let depths = counts(&axes)[2];
        let time_of =
            |of: &[Option<(f64, Layout)>]| of.iter().flatten().next().map_or(0.0, |(_, layout)| log_time(layout));
        let log_times: Vec<f64> = laid_nodes.par_chunks(depths).map(time_of).collect();
        let node = |place: usize| {
            let (lengths_um, laid) = (&nodes[place], laid_nodes[place].as_ref());
            let at = |node: usize| shares[0] + (shares[1] - shares[0]) * node as f64 / (odds_nodes - 1) as f64;
            let found = (0..odds_nodes).map(|node| predicted(lengths_um, at(node))).collect::<Option<Vec<_>>>()?;
            let quantiles: Vec<Vec<f64>> = found.iter().map(quantiles_of).collect();
            let core = core(&found[odds_nodes / 2], &quantiles[odds_nodes / 2], bands.len());
            let odds = found.iter().zip(&quantiles).map(|(found, quantiles)| above(found, quantiles, core));
            let odds: Vec<f64> = odds.chain([core]).collect();
            let quantiles: Vec<Vec<f64>> =
                quantiles.into_iter().step_by((odds_nodes - 1) / (quantile_nodes - 1)).collect();
            Some([quantiles.concat(), odds, beside_of(laid?, log_times[place / depths], None)?.to_vec()].concat())
        };
        let answers: Vec<Option<Vec<f64>>> = (0..nodes.len()).into_par_iter().map(node).collect();
        if search.stage.cancelled() {
            return None;
        }
        let (all, holes) = filled(answers, counts(&axes))?;
        let ends = [3 * loads * quantile_nodes, 3 * loads * quantile_nodes + odds_nodes + 1];
        let own = laid(&about.texture.pattern.lengths_m().map(|m| LENGTH_UM.from_si(m)))?;
        let mixed = |numbers: &[f64]| {
            let (quantiles, rest) = numbers.split_at(ends[0]);
            let (odds, beside) = rest.split_at(odds_nodes);
            [&between(quantiles, quantile_nodes, shares, own.0)[..], &between(odds, odds_nodes, shares, own.0), beside]
                .concat()
        };
        let mut reported = quantiles_of(about);
        let own_core = core(about, &reported, bands.len());
        reported.extend([above(about, &reported, own_core), own_core]);
        reported.extend(beside_of(&own, log_time(&own.1), run).into_iter().flatten());
        // The same for all cavity fractions.
        let missing = |numbers: &[f64]| {
            let off: Vec<f64> = reported.iter().zip(mixed(numbers)).map(|(reported, own)| reported - own).collect();
            let (quantiles, rest) = off.split_at(3 * loads);
            [&quantiles.repeat(quantile_nodes)[..], &vec![rest[0]; odds_nodes], &rest[1..]].concat()
        };
        let all = self_consistent(all, &axes, (&nodes, &holes), about, &missing);
        let [expected, odds, beside] =
            [0..ends[0], ends[0]..ends[1], ends[1]..ends[1] + BESIDE].map(|of| surface(&axes, &all, of));
        let checks = random_places(&axes, CHECKS, 2);
        let mut explorer = Self {
            expected,
            odds,
            bands,
            beside,
            shares,
            dimension,
            holes,
            checked: 0,
            median_error: 0.0,
            worst_error: 0.0,
        };
        let off = |lengths_um: &[f64; 3]| {
            if explorer.expected.is_beside(&explorer.holes, lengths_um) {
                return None;
            }
            let (share, layout) = laid(lengths_um)?;
            let medians = predicted(lengths_um, share)?.medians();
            let known = explorer.sample(&layout).0;
            let each = medians.iter().zip(&search.asked.bands).zip(&known);
            Some(each.map(|((median, band), known)| (band.flat * median - known).abs()).fold(0.0, f64::max))
        };
        let mut off: Vec<f64> = checks.par_iter().filter_map(off).collect();
        explorer.worst_error = tidy(off.iter().copied().fold(0.0, f64::max));
        (explorer.checked, explorer.median_error) = (off.len(), tidy(median(&mut off).unwrap_or(0.0)));
        Some(explorer)
    }
}

/// Softening of [`soft_odds`]: chances below it, far from the target, are interpolated like numbers near zero.
const SOFTENED: f64 = 0.01;

/// Softened log odds ln((p + e) / (1 - p + e)) of the chance `p`, finite for chances of 0 and 1; e = [`SOFTENED`].
fn soft_odds(p: f64) -> f64 {
    ((p + SOFTENED) / (1.0 - p + SOFTENED)).ln()
}

/// Chance of the softened log odds `odds`; the page repeats the formula.
fn chance_of(odds: f64) -> f64 {
    let of = odds.exp();
    (((1.0 + SOFTENED) * of - SOFTENED) / (1.0 + of)).clamp(0.0, 1.0)
}

/// Standard score of the upper quartile of a normal distribution, and of the upper end of its 95 % interval.
const SCORES: [f64; 2] = [0.6745, 1.96];
/// [`core`] of a normal distribution.
const NORMAL_CORE: f64 = SCORES[0] / SCORES[1];

/// Distance of the quartiles of samples over the width of their 95 % interval, in the logarithm, mean of the first
/// `count` loads: below [`NORMAL_CORE`], as few samples are far off. `quantiles` as for [`rough_odds`].
fn core(found: &Prediction, quantiles: &[f64], count: usize) -> f64 {
    let loads = quantiles.len() / 3;
    let share = |load: usize| {
        let whole = (quantiles[2 * loads + load] / quantiles[loads + load]).ln().max(1e-3);
        (found.quantile(load, 0.75) / found.quantile(load, 0.25)).ln() / whole
    };
    (0..count).map(share).sum::<f64>() / count as f64
}

/// [`soft_odds`] of the chance that samples lie within `bands`, lowest and highest values at each of the first loads, if
/// the ratios at all loads are off together: by medians, lower and upper ends of 95 % intervals at all loads, which
/// `quantiles` holds one after the other, and by their [`core`].
///
/// The page repeats the formula. The distance u of a value from the median, over that of the end of the interval in
/// the logarithm, has the standard score z. The distribution function F is logistic, nearly normal. Of the chances at 60
/// random textures near a design of squares with one trial, normal distributions would leave 0.05 in the mean, these
/// 0.015 (`an_explorer_says_what_the_search_does_of_every_texture`).
///
/// ```text
/// u = a z + b z^3 with u = core at z = 0.6745 and u = 1 at z = 1.96,   p = F(min z_highest) - F(max z_lowest)
/// ```
fn rough_odds(bands: &[[Option<f64>; 2]], quantiles: &[f64], core: f64) -> f64 {
    let [inner, outer] = SCORES;
    let core = core.clamp(0.1, 0.999 * NORMAL_CORE);
    let b = (1.0 / outer - core / inner) / (outer * outer - inner * inner);
    let a = core / inner - b * inner * inner;
    let scale = (a / (3.0 * b)).sqrt();
    let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
    for (load, band) in bands.iter().enumerate() {
        let [median, lower, upper] = [0, 1, 2].map(|part| quantiles[part * quantiles.len() / 3 + load].max(1e-3));
        let score = |value: f64| {
            let off = (value / median).ln();
            let end = (if off > 0.0 { upper } else { lower } / median).ln().abs().max(2e-3);
            2.0 * scale * ((1.5 * off / (end * a * scale)).asinh() / 3.0).sinh()
        };
        lowest = band[0].map_or(lowest, |value| lowest.max(score(value)));
        highest = band[1].map_or(highest, |value| highest.min(score(value)));
    }
    let below = |z: f64| 1.0 / (1.0 + (-1.702 * z).exp());
    soft_odds((below(highest) - below(lowest)).clamp(0.0, 1.0))
}

/// Interpolates outputs at `share` by the polynomial through their `values` at `nodes` evenly spaced cavity fractions
/// from the first to the second of `ends`: all outputs at the first node, then all at the second, and so on.
fn between(values: &[f64], nodes: usize, [from, to]: [f64; 2], share: f64) -> Vec<f64> {
    let (outputs, last) = (values.len() / nodes, (nodes - 1) as f64);
    let place = last * ((share - from) / (to - from)).clamp(0.0, 1.0);
    let weight = |node: usize| {
        let others = (0..nodes).filter(|other| *other != node).map(|other| other as f64);
        others.map(|other| (place - other) / (node as f64 - other)).product::<f64>()
    };
    let mut found = vec![0.0; outputs];
    for (node, own) in values.chunks(outputs).enumerate() {
        found.iter_mut().zip(own).for_each(|(found, own)| *found += weight(node) * own);
    }
    found
}

/// Interpolates those numbers of each node that have the indices `of`; `all` holds the numbers of each node.
fn surface(axes: &[Axis; 3], all: &[Vec<f64>], of: Range<usize>) -> ResponseSurface {
    let numbers = all.iter().flat_map(|numbers| numbers[of.clone()].iter().copied()).collect();
    ResponseSurface::through(*axes, of.len(), numbers)
}

/// Corrects the numbers `all` of the nodes near the texture of `about` by what is `missing` of the numbers interpolated
/// at this texture. The correction decreases with distance. No correction is made if the texture lies beside a node that
/// the model cannot compute.
fn self_consistent(
    mut all: Vec<Vec<f64>>,
    axes: &[Axis; 3],
    (nodes, holes): (&[[f64; 3]], &[usize]),
    about: &Prediction,
    missing: &dyn Fn(&[f64]) -> Vec<f64>,
) -> Vec<Vec<f64>> {
    let about_um = about.texture.pattern.lengths_m().map(|m| LENGTH_UM.from_si(m));
    let own = surface(axes, &all, 0..all[0].len());
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
    let off = missing(&own.at(&about_um));
    for (numbers, weight) in all.iter_mut().zip(&weights) {
        numbers.iter_mut().zip(&off).for_each(|(number, off)| *number += off * weight[0] / at_about);
    }
    all
}
