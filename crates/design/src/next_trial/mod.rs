//! The samples to cut next: those likeliest to be on target by the model and by what trials say that it lacks.

pub mod advice;
mod candidate_search;
mod interpolation;
mod local_search;
mod report;

use rayon::prelude::*;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_discrepancy::{
    Candidate, DimensionShift, Discrepancy, Features, Load, Prediction, Predictor, Scenarios, Score, Wanted,
    information,
};
use slipgrid_export::{Division, LEAST_PERIODS, Outline, Sector, Specimen};
use slipgrid_material::AreaLaw;
use slipgrid_monitor::{Monitor, Part, Stage};
use slipgrid_optimize::Quantity;
use slipgrid_pattern::Pattern;
use slipgrid_results::{MaterialReport, SCHEMA, VERSION};
use slipgrid_specimen::{SteadyOnFace, nearest_known, time_changes_on};
use slipgrid_springblock::{Fidelity, RunOptions, Scene};
use slipgrid_units::tidy;

use crate::chance::Chances;
use crate::learned_discrepancy::loads_of;
use crate::operating_conditions::{Further, further};
use crate::selection::Effort;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::{DesignError, TaskPart};
use candidate_search::{Scope, Search, is_same};
use interpolation::{Interpolation, Modelled, Models};

pub use advice::AdviceReport;
pub use report::{NextReport, OneDiscReport, PredictedRatio, RatioPrediction, SectorReport, TrialCandidateReport};

/// Designs that a report lists, each with a run in time of its own.
const LISTED: usize = 6;
/// Truths in which several samples are judged together.
const SCENARIOS: usize = 2000;
/// Seed of what one disc is off by in them.
const DISC_SEED: u64 = 2;
/// Relative error of a measurement, for what a trial would teach.
const MEASURED_STD: f64 = 0.01;
/// Advice: a chance above this is worth a series.
const SERIES: f64 = 0.5;

/// What is asked.
#[derive(Clone, Debug, Default)]
pub struct NextOptions {
    /// Samples to cut at once.
    pub count: usize,
    /// Patterns that were cut and are not measured yet.
    pub pending: Vec<Pattern>,
    /// Patterns whose chance is asked for.
    pub own: Vec<Pattern>,
    /// The samples are to be sectors of one specimen.
    pub one_disc: bool,
    /// Names of the specimens that were cut into sectors already; those of measured trials are known without them.
    pub discs: Vec<String>,
}

/// A design that could be cut.
#[derive(Clone, Debug)]
struct Design {
    pattern: Pattern,
    features: Features,
    ratio: Vec<f64>,
    sensitivity: Vec<f64>,
    /// Of the logarithms of the ratios, shared by all samples.
    covariance: Vec<f64>,
    dimension_shifts: Vec<DimensionShift>,
    /// The ratio in the layer's blocks.
    in_blocks: Vec<f64>,
}

/// A design with its chance.
#[derive(Clone, Debug)]
struct Judged {
    design: Design,
    prediction: Prediction,
    score: Score,
}

impl Design {
    fn new(pattern: Pattern, modelled: Modelled, covariance: Vec<f64>, dimension_shifts: Vec<DimensionShift>) -> Self {
        let ratio: Vec<f64> = modelled.log_ratio.iter().map(|log| log.exp()).collect();
        Self {
            features: Features::from(&pattern),
            in_blocks: ratio.clone(),
            ratio,
            sensitivity: modelled.sensitivity,
            covariance,
            dimension_shifts,
            pattern,
        }
    }

    /// The same with what smaller blocks change of the logarithms of its ratios.
    fn in_smaller_blocks(self, shifts: Option<Vec<f64>>) -> Self {
        self.moved(&shifts.unwrap_or_default())
    }

    /// The same with what else moves the logarithms of its ratios.
    fn moved(mut self, by: &[f64]) -> Self {
        self.ratio.iter_mut().zip(by).for_each(|(ratio, by)| *ratio *= by.exp());
        self
    }

    fn candidate(&self) -> Candidate<'_> {
        Candidate {
            features: self.features,
            modelled: &self.ratio,
            modulus_sensitivity: &self.sensitivity,
            covariance: &self.covariance,
            dimension_shifts: &self.dimension_shifts,
        }
    }

    fn judged(self, predictor: &Predictor, wanted: &Wanted) -> Judged {
        let prediction = predictor.of(&self.candidate());
        let score = wanted.score(&prediction, &self.ratio);
        Judged { design: self, prediction, score }
    }
}

/// What is wanted of `task`, where, and what its trials say.
struct Asked {
    loads: Vec<Load>,
    wanted: Wanted,
    /// The tolerances of the ratios: half the width of what is accepted, of a limit alone its margin.
    tolerances: Vec<f64>,
    learned: Discrepancy,
}

/// The samples to cut next, as a report and as patterns.
#[derive(Clone, Debug)]
pub struct NextTrials {
    /// The report.
    pub report: NextReport,
    /// Its samples.
    pub patterns: Vec<Pattern>,
    /// The same as sectors of one specimen, where that was asked for.
    pub sectors: Vec<Sector>,
    /// The material and where it came from.
    pub material: MaterialReport,
}

/// The samples of `task` to cut next. Stages of the monitor: "model", "trials".
///
/// # Errors
/// [`DesignError`] for a task that is refused, that the monitor cancels, or of which nothing can be computed.
pub fn next_trials(task: &DesignTask, options: &NextOptions, monitor: &dyn Monitor) -> Result<NextTrials, DesignError> {
    let mut task = task.clone();
    let known = task.material.clone().ok_or_else(|| DesignError::refused("has no material"))?;
    task.check(&known)?;
    let division = options.one_disc.then(|| Division::new(task.specimen, options.count)).transpose();
    let division = division.map_err(|error| DesignError::refused(error.to_string()))?;
    let (loads, outside) = task.loads(&known.material)?;
    let further = further(&task, &known.material)?;
    let run = RunOptions { fidelity: Fidelity::Steady, dimensions: task.dimensions, ..RunOptions::default() };
    let scene = task.flat_scene(&known.material, loads, run);
    let elsewhere: Vec<&[slipgrid_springblock::Load]> = further.iter().map(|at| &at.loads[..]).collect();
    let directions_deg = &task.directions.different_deg;
    let model = SteadyModel::new(&scene, &elsewhere, directions_deg, &task.space, None).watched_by(monitor);
    // A sector is a trial of an endless pattern: what presses on it has no rim of its own.
    let model = if division.is_none() { model.on(task.specimen) } else { model };
    let asked = asked(&task, &known.uncertainty, &further, &model)?;
    let models = Models::new(&model, &known.uncertainty)?;
    let chances = Chances::new(&task, &known.uncertainty, &model, &further)?;

    let stage = Stage::new(monitor, "model", None);
    let scope = if model.is_cheap_per_design() { Scope::PLANE } else { Scope::SPACE };
    let face = Some(task.specimen).filter(|_| division.is_none());
    let beyond = BeyondCells { model: &model, face, count: task.target.points().len(), seed: task.seed };
    let interpolation = Interpolation::new(&task, &models, &beyond, &scope, &stage);
    stage.finish();
    monitor.heed()?;
    let interpolation = interpolation.ok_or(DesignError::Cancelled)?;
    let stage = Stage::new(monitor, "trials", None);
    let material = MaterialReport::from(&known.material.provenance);
    let search = Search::new(&task, &asked, (&models, &beyond), &chances, (&interpolation, &scope), &stage);
    let found = choose(&search, options, division.as_ref(), &material);
    stage.finish();
    monitor.heed()?;
    let (mut report, patterns) = found?;
    report.basis = if model.dimension().takes_strips() { WITH_TIME } else { WITHOUT_TIME }.to_owned();
    let sectors = match &division {
        Some(division) => division.lay(&patterns).map_err(|error| DesignError::refused(error.to_string()))?,
        None => Vec::new(),
    };
    let learned = known.uncertainty.learned.iter().flat_map(|learned| learned.trials());
    let cut: Vec<&str> =
        learned.filter_map(|trial| trial.disc.as_deref()).chain(options.discs.iter().map(String::as_str)).collect();
    report.one_disc = OneDiscReport::of(new_name(&report.name, &task, &cut), &sectors);
    // Those that were asked for are numbered after the samples, as they are listed.
    report.beyond_measured = task.beyond_measured(&known.material, &outside);
    report.warnings = laser_warnings(&task, patterns.iter().chain(&options.own));
    Ok(NextTrials { report, patterns, sectors, material })
}

/// What chances are made of.
const WITH_TIME: &str =
    "Chances of listed samples come from the steady model with their own ends, tilt and sliding in time.";
const WITHOUT_TIME: &str = "Chances come from the steady model. What sliding in time adds is not known here and not in them; it moves ratios by some \
                            thousandths.";

/// Differences of samples from their cells: ends of strips, tilt of the pressure, and sliding in time, of each design by itself.
struct BeyondCells<'a> {
    model: &'a SteadyModel<'a>,
    /// Face of the specimen; `None` where samples are sectors of one.
    face: Option<Specimen>,
    /// Loads of the first condition; those of others are taken to differ as these.
    count: usize,
    seed: u64,
}

impl BeyondCells<'_> {
    /// The cell of `pattern` at the loads of the first condition.
    fn scene(&self, pattern: &Pattern) -> Scene {
        let mut scene = self.model.cell(pattern, false);
        scene.loads.truncate(self.count);
        scene
    }

    /// Change of the logarithm of each of `ratios` of `pattern`, one a load of every condition, by what is `added` to those of the first.
    fn log_shifts(&self, ratios: &[f64], added: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let shift = |(load, ratio): (usize, &f64)| (added(load % self.count) / ratio).max(-0.5).ln_1p();
        ratios.iter().enumerate().map(shift).collect()
    }

    /// Change of the logarithms of `ratios` of `pattern` by ends and tilt; zeros without a face, and where strips are too large to solve.
    /// Roughly where many designs are ranked.
    fn by_face(&self, pattern: &Pattern, ratios: &[f64], is_rough: bool, monitor: &dyn Monitor) -> Vec<f64> {
        let solve = if is_rough { SteadyOnFace::roughly } else { SteadyOnFace::new };
        let part = Part::new(monitor, 0.0);
        let on_face = self.face.as_ref().and_then(|face| solve(&self.scene(pattern), pattern, face, &part).ok());
        self.log_shifts(ratios, &|load| on_face.as_ref().and_then(|on_face| on_face.added(load)).unwrap_or(0.0))
    }

    /// Change of the logarithms of `ratios` of `pattern` by sliding in time; `None` in space, and where a run gives none.
    fn by_time(&self, pattern: &Pattern, ratios: &[f64], monitor: &dyn Monitor) -> Option<Vec<f64>> {
        let scene = self.scene(pattern);
        let timed = Scene {
            pattern: Some(pattern.with_rim(None)),
            run: RunOptions { seed: self.seed, ..scene.run },
            ..scene.clone()
        };
        let changes = time_changes_on(&timed, self.face.as_ref(), &Part::new(monitor, 0.0)).ok()?;
        let changes = nearest_known(&changes, &scene.loads)?;
        Some(self.log_shifts(ratios, &|load| changes[load]))
    }
}

/// A name for a specimen of `design` that none of those `cut` has.
fn new_name(design: &str, task: &DesignTask, cut: &[&str]) -> String {
    let what = if matches!(task.specimen.outline, Outline::Rectangle { .. }) { "rectangle" } else { "disc" };
    let mut names = (1..).map(|number| format!("{design}, {what} {number}"));
    names.find(|name| !cut.contains(&name.as_str())).unwrap_or_default()
}

fn asked(
    task: &DesignTask,
    material: &MaterialUncertainty,
    further: &[Further],
    model: &SteadyModel<'_>,
) -> Result<Asked, DesignError> {
    let learned = material.discrepancy().map_err(|error| DesignError::Failed(error.to_string()))?;
    let loads = loads_of(task, &learned, further, model);
    let count = task.target.points().len();
    let conditions = std::iter::once(task.condition).chain(further.iter().map(|further| further.at.condition));
    let pressures_pa = task.pressures_pa();
    let (mut lower, mut upper, mut tolerances) = (Vec::new(), Vec::new(), Vec::new());
    for (place, condition) in conditions.enumerate() {
        let excess = material.excess(&pressures_pa, condition.as_ref());
        for (row, demand) in task.target.points().iter().enumerate() {
            let at = &model.asked().loads[place * count + row];
            // Of friction itself: over that of the flat sample, mu_d f(P) times dynamic over steady friction.
            let law = |law: &AreaLaw| law.factor(at.pressure_pa);
            let flat = match task.target.quantity() {
                Quantity::Ratio => 1.0,
                Quantity::DynamicFriction => {
                    at.friction.dynamic_mean()
                        * model.area_law().map_or(1.0, law)
                        * excess.as_ref().map_or(1.0, |excess| excess[row])
                }
            };
            let [lowest, highest] = demand.wanted.band();
            lower.push(lowest.unwrap_or(0.0) / flat);
            upper.push(highest.unwrap_or(f64::INFINITY) / flat);
            tolerances.push(demand.wanted.tolerance().unwrap_or(0.0) / flat);
        }
    }
    if !task.target.has_demands() {
        let reason = "a target that demands nothing cannot be missed: there is no trial to choose";
        return Err(crate::Refusal::new(TaskPart::Whole, reason).into());
    }
    Ok(Asked { loads, wanted: Wanted { lower, upper }, tolerances, learned })
}

/// The samples of `search` to cut next, as `options` ask, on sectors of `division` where there is one.
fn choose(
    search: &Search<'_>,
    options: &NextOptions,
    division: Option<&Division>,
    material: &MaterialReport,
) -> Result<(NextReport, Vec<Pattern>), DesignError> {
    let Search { task, asked, .. } = *search;
    let pending: Vec<Features> = options.pending.iter().map(Features::from).collect();
    let is_open = |pattern: &Pattern, own: &Features| {
        !pending.iter().any(|cut| is_same(cut, own)) && division.is_none_or(|division| division.holds(pattern))
    };
    let (pool, compared) = search.best(&is_open, 0.0, options.count);
    search.stage.heed()?;
    if pool.is_empty() {
        let reason = match division {
            Some(division) => coarse(division),
            None => "no design within the bounds can be computed".to_owned(),
        };
        return Err(DesignError::Failed(reason));
    }
    if division.is_some() && pool.len() < options.count {
        let reason = format!("{} designs that fit on a sector were found: expected as many as sectors", pool.len());
        return Err(DesignError::Failed(reason));
    }
    let own = |pattern: &Pattern| {
        search.stage.heed()?;
        let refused = |failure| DesignError::refused(format!("the candidate cannot be computed: {failure}"));
        search.exactly(pattern).map(|found| search.as_cut(found)).map_err(refused)
    };
    let own: Vec<Judged> = options.own.iter().map(own).collect::<Result<_, _>>()?;
    let pending: Vec<Judged> = options.pending.iter().filter_map(|pattern| search.exactly(pattern).ok()).collect();
    let pool = search.all_as_cut(pool, LISTED.max(options.count));
    search.stage.heed()?;
    let (chosen, together) = several(&pool, &pending, options, asked);
    let report = |judged: &Judged| TrialCandidateReport::new(task, asked, judged);
    let greatest = pool.iter().map(|judged| judged.score.chance).fold(0.0, f64::max);
    let mut next = NextReport {
        program: "slipgrid".to_owned(),
        version: VERSION.to_owned(),
        schema: SCHEMA,
        name: task.name.clone(),
        trials: asked.learned.trials().len(),
        pending: options.pending.len(),
        designs: compared,
        advice: if greatest > SERIES { "series" } else { "trial" }.to_owned(),
        next: chosen.iter().map(|judged| report(judged)).collect(),
        one_on_target: tidy(together),
        one_disc: None,
        basis: String::new(),
        why: String::new(),
        best: pool.iter().take(LISTED).map(report).collect(),
        own: own.iter().map(report).collect(),
        warnings: Vec::new(),
        beyond_measured: None,
        material: material.clone(),
        specimen: (&task.specimen).into(),
        laser: task.laser,
        tolerances: task.assumed_tolerances(),
        seed: task.seed,
    };
    next.why = next.reason().unwrap_or_default();
    Ok((next, chosen.iter().map(|judged| judged.design.pattern).collect()))
}

/// `count` designs of `pool`, the first the best and each further one where those before and those `pending` miss the target, with
/// the chance that one of them is on it.
///
/// Samples on one disc share what differs from disc to disc: they are off together, and further apart from each other are better.
fn several<'a>(pool: &'a [Judged], pending: &[Judged], options: &NextOptions, asked: &Asked) -> (Vec<&'a Judged>, f64) {
    let count = options.count.max(1).min(pool.len());
    if count == 1 && pending.is_empty() {
        return (vec![&pool[0]], pool[0].score.chance);
    }
    let scenarios = Scenarios::new(&asked.learned, SCENARIOS, 1);
    // Each another sample.
    let on = |scenarios: &Scenarios, (number, judged): (usize, &Judged)| {
        scenarios.on_target(&judged.design.candidate(), &asked.loads, &asked.wanted, number)
    };
    let disc = if options.one_disc { scenarios.clone().on_one_disc(DISC_SEED) } else { scenarios.clone() };
    let hits: Vec<Vec<bool>> = pool.par_iter().enumerate().map(|of| on(&disc, of)).collect();
    let mut hit = vec![false; SCENARIOS];
    let mark = |hit: &mut Vec<bool>, by: &[bool]| hit.iter_mut().zip(by).for_each(|(hit, on)| *hit |= on);
    (pool.len()..).zip(pending).for_each(|of| mark(&mut hit, &on(&scenarios, of)));
    let mut of_pending = hit.clone();
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..count {
        let gain = |place: &usize| hits[*place].iter().zip(&hit).filter(|(on, hit)| **on && !**hit).count();
        let open = (0..pool.len()).filter(|place| !chosen.contains(place));
        // The first of nothing before it is the best by its score; of equal gains the better by that.
        let best = if chosen.is_empty() && pending.is_empty() {
            Some(0)
        } else {
            open.max_by(|a, b| gain(a).cmp(&gain(b)).then(b.cmp(a)))
        };
        let Some(best) = best else { break };
        mark(&mut hit, &hits[best]);
        chosen.push(best);
    }
    let chosen: Vec<&Judged> = chosen.into_iter().map(|place| &pool[place]).collect();
    // Others of the same designs: those that were chosen were lucky in their own draws.
    let others = (pool.len() + pending.len()..).zip(chosen.iter().copied());
    others.for_each(|of| mark(&mut of_pending, &on(&disc, of)));
    let together = of_pending.iter().filter(|hit| **hit).count() as f64 / SCENARIOS as f64;
    (chosen, together)
}

/// What the laser of `task` will not cut of `patterns` as they are designed, each with the number of its sample.
fn laser_warnings<'a>(task: &DesignTask, patterns: impl Iterator<Item = &'a Pattern>) -> Vec<String> {
    let of = |(number, pattern): (usize, &'a Pattern)| {
        let broken = task.constraints.limits.violations(pattern);
        let mut warnings: Vec<String> = broken.iter().map(ToString::to_string).collect();
        warnings.extend(task.laser.check_depth(pattern.depth_m()).err().map(|error| error.to_string()));
        let layout = task.specimen.layout(*pattern).ok();
        warnings.extend(layout.into_iter().flat_map(|layout| slipgrid_export::laser_warnings(&layout, &task.laser)));
        warnings.into_iter().map(move |warning| format!("sample {}: {warning}", number + 1))
    };
    patterns.enumerate().flat_map(of).collect()
}

/// Why no design fits on a sector.
fn coarse(division: &Division) -> String {
    format!(
        "no design within the bounds can be computed whose period fits {LEAST_PERIODS} times on the {:.2} mm wide circle of a sector: \
         expected fewer sectors, or finer textures within the bounds",
        1e3 * division.least_circle_m()
    )
}

/// What a trial of `judged` would teach of the form, in bits.
fn information_bits(judged: &Judged) -> f64 {
    information(&judged.prediction, MEASURED_STD) / std::f64::consts::LN_2
}

/// Seconds under the laser, where its speed is known.
fn laser_s(task: &DesignTask, pattern: &Pattern) -> Option<f64> {
    Effort::LaserTime.of(task, pattern).ok()
}

#[cfg(test)]
pub(crate) mod tests;
