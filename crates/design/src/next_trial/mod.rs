//! The samples to cut next: those likeliest to be on target by the model and by what trials say that it lacks.

pub mod advice;
mod interpolation;
mod report;

use rayon::prelude::*;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_discrepancy::{
    Candidate, Discrepancy, Features, Load, Prediction, Predictor, Scenarios, Score, Wanted, information,
};
use slipgrid_export::{Division, LEAST_PERIODS, Removal, Sector};
use slipgrid_material::AreaLaw;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_optimize::{ModelFailure, Quantity};
use slipgrid_pattern::Pattern;
use slipgrid_results::{MaterialReport, SCHEMA, VERSION};
use slipgrid_springblock::{Fidelity, RunOptions};
use slipgrid_units::tidy;

use crate::chance::{About, Chances};
use crate::lattice_table::lattice;
use crate::learned::loads_of;
use crate::operating_conditions::{Further, further};
use crate::selection::Effort;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::{DesignError, TaskPart};
use interpolation::{Interpolation, Modelled, Models};

pub use advice::AdviceReport;
pub use report::{NextReport, OneDiscReport, PredictedRatio, SectorReport, TrialCandidateReport};

/// How much is looked at.
struct Scope {
    /// Most nodes of the interpolated model's lattice along width, spacing and depth.
    nodes: [usize; 3],
    /// Designs that are compared by it, about.
    designs: usize,
    /// Of these the best by it, which the model itself judges.
    judged: usize,
    /// Of these the best by that, of which everything counts.
    completed: usize,
}

impl Scope {
    /// In the plane, where a node takes some milliseconds.
    const PLANE: Self = Self { nodes: [13, 13, 9], designs: 20_000, judged: 48, completed: 16 };
    const SPACE: Self = Self { nodes: [6, 6, 4], ..Self::PLANE };
    /// Beside a design that was searched.
    const BESIDE: Self = Self { nodes: [9, 9, 5], designs: 5000, judged: 16, completed: 6 };
}

/// Designs that a report lists.
const LISTED: usize = 10;
/// Truths in which several samples are judged together.
const SCENARIOS: usize = 2000;
/// Seed of what one disc is off by in them.
const DISC_SEED: u64 = 2;
/// Relative error of a measurement, for what a trial would teach.
const MEASURED_STD: f64 = 0.01;
/// Advice: a chance above this is worth a series.
const SERIES: f64 = 0.5;
/// Lengths that differ by less are the same, relative.
const SAME_LENGTH: f64 = 1e-3;

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
}

/// A design that could be cut.
#[derive(Clone, Debug)]
struct Design {
    pattern: Pattern,
    features: Features,
    ratio: Vec<f64>,
    sensitivity: Vec<f64>,
    covariance: Vec<f64>,
}

/// A design with its chance.
#[derive(Clone, Debug)]
struct Judged {
    design: Design,
    prediction: Prediction,
    score: Score,
}

impl Design {
    fn new(pattern: Pattern, modelled: Modelled, covariance: Vec<f64>) -> Self {
        Self {
            features: Features::from(&pattern),
            ratio: modelled.log_ratio.iter().map(|log| log.exp()).collect(),
            sensitivity: modelled.sensitivity,
            covariance,
            pattern,
        }
    }

    fn candidate(&self) -> Candidate<'_> {
        Candidate {
            features: self.features,
            modelled: &self.ratio,
            modulus_sensitivity: &self.sensitivity,
            covariance: &self.covariance,
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
    let (loads, _) = task.loads(&known.material)?;
    let further = further(&task, &known.material)?;
    let run = RunOptions { fidelity: Fidelity::Steady, dimensions: task.dimensions, ..RunOptions::default() };
    let scene = task.flat_scene(&known.material, loads, run);
    let elsewhere: Vec<&[slipgrid_springblock::Load]> = further.iter().map(|at| &at.loads[..]).collect();
    let directions_deg = &task.directions.different_deg;
    let model =
        SteadyModel::new(&scene, &elsewhere, directions_deg, &task.space, None).watched_by(monitor).on(task.specimen);
    let asked = asked(&task, &known.uncertainty, &further, &model)?;
    let models = Models::new(&model, &known.uncertainty)?;
    let chances = Chances::new(&task, &known.uncertainty, &model, &further)?;

    let stage = Stage::new(monitor, "model", None);
    let scope = if model.is_spatial() { Scope::SPACE } else { Scope::PLANE };
    let interpolation = Interpolation::new(&task, &models, scope.nodes, &stage);
    stage.finish();
    monitor.heed()?;
    let interpolation = interpolation.ok_or(DesignError::Cancelled)?;
    let stage = Stage::new(monitor, "trials", None);
    let material = MaterialReport::from(&known.material.provenance);
    let search = Search::new(&task, &asked, &models, &chances, (&interpolation, &scope));
    let found = choose(&search, options, division.as_ref(), &material);
    stage.finish();
    monitor.heed()?;
    let (mut report, patterns) = found?;
    let sectors = match &division {
        Some(division) => division.lay(&patterns).map_err(|error| DesignError::refused(error.to_string()))?,
        None => Vec::new(),
    };
    let disc = format!("{}, disc {}", report.name, report.trials + report.pending + 1);
    report.one_disc = OneDiscReport::of(disc, &sectors);
    report.warnings = laser_warnings(&task, &patterns);
    Ok(NextTrials { report, patterns, sectors, material })
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
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
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
        }
    }
    if !task.target.has_demands() {
        let reason = "a target that demands nothing cannot be missed: there is no trial to choose";
        return Err(crate::Refusal::new(TaskPart::Whole, reason).into());
    }
    Ok(Asked { loads, wanted: Wanted { lower, upper }, learned })
}

/// Designs of whole blocks and bursts within the bounds and the laser's limits, about `most` of them.
fn designs(task: &DesignTask, most: usize) -> Vec<Pattern> {
    let (all, _) = lattice(task);
    let [spacings, depths] = [Pattern::spacing_m, Pattern::depth_m].map(|of| {
        let mut lengths: Vec<u64> = all.iter().map(|design| of(design).to_bits()).collect();
        lengths.sort_unstable();
        lengths.dedup();
        lengths.len()
    });
    // A stride that has no divisor with an axis in common spreads what is left out.
    let shares = |step: usize, axis: usize| (2..=step).any(|by| step.is_multiple_of(by) && axis.is_multiple_of(by));
    let least = all.len().div_ceil(most).max(1);
    let step = (least..).find(|step| !shares(*step, spacings) && !shares(*step, depths)).unwrap_or(least);
    all.into_iter().step_by(step).collect()
}

/// Whether two textures are one: trials know their features alone.
fn is_same(a: &Features, b: &Features) -> bool {
    let same = |of: fn(&Features) -> f64| (of(a) - of(b)).abs() <= SAME_LENGTH * of(a).max(of(b));
    same(|of| of.width_m) && same(|of| of.pitch_m) && same(|of| of.depth_m) && same(|of| of.areal_density)
}

/// What is asked, and what answers.
struct Search<'a> {
    task: &'a DesignTask,
    asked: &'a Asked,
    predictor: Predictor,
    models: &'a Models<'a>,
    interpolation: &'a Interpolation,
    /// What is not known exactly beside what trials tell of.
    chances: &'a Chances<'a>,
    scope: &'a Scope,
}

impl<'a> Search<'a> {
    fn new(
        task: &'a DesignTask,
        asked: &'a Asked,
        models: &'a Models<'a>,
        chances: &'a Chances<'a>,
        (interpolation, scope): (&'a Interpolation, &'a Scope),
    ) -> Self {
        Self { task, asked, predictor: asked.learned.at(&asked.loads), models, interpolation, chances, scope }
    }

    /// Covariance of the ratios of samples of `pattern` by their dimensions.
    fn covariance(&self, pattern: &Pattern) -> Option<Vec<f64>> {
        let std_m = self.task.tolerances.map_or([0.0; 3], |scatter| scatter.tolerances.std_m);
        self.interpolation.covariance([pattern.width_m(), pattern.spacing_m(), pattern.depth_m()], std_m)
    }

    /// `pattern` by the model itself in the layer's blocks, with the scatter of its dimensions.
    fn drafted(&self, pattern: &Pattern) -> Result<Judged, ModelFailure> {
        let covariance = self.covariance(pattern).unwrap_or_default();
        let design = Design::new(*pattern, self.models.at(pattern)?, covariance);
        Ok(design.judged(&self.predictor, &self.asked.wanted))
    }

    /// `pattern` in blocks as small as the model can have, with everything that is not known exactly.
    fn exactly(&self, pattern: &Pattern) -> Result<Judged, ModelFailure> {
        self.completed(self.drafted(pattern)?)
    }

    /// The same of a draft.
    fn completed(&self, draft: Judged) -> Result<Judged, ModelFailure> {
        let Judged { design: Design { pattern, mut ratio, sensitivity, .. }, .. } = draft;
        let still = self.chances.still(&pattern)?;
        let open = match self.models.refined(&pattern) {
            Some((shifts, open)) => {
                ratio.iter_mut().zip(shifts).for_each(|(ratio, shift)| *ratio += shift);
                vec![open; ratio.len()]
            }
            None => self.chances.numerical_of(&pattern, &still, &vec![0.0; ratio.len()])?,
        };
        let about = About { design: &pattern, still: &still, values: &ratio, numerical: &open };
        let covariance = self.chances.log_covariance(&about)?;
        let log_ratio = ratio.iter().map(|ratio| ratio.ln()).collect();
        let design = Design::new(pattern, Modelled { log_ratio, sensitivity }, covariance);
        Ok(design.judged(&self.predictor, &self.asked.wanted))
    }

    /// The designs of the greatest scores among those that were not cut and are `open`, at least `count` where there are as many, the greatest
    /// first, and how many were compared; those whose chance is below `least_chance` before everything counts are passed by.
    fn best(
        &self,
        open: &dyn Fn(&Pattern, &Features) -> bool,
        least_chance: f64,
        count: usize,
    ) -> (Vec<Judged>, usize) {
        let cut: Vec<Features> = self.asked.learned.trials().iter().map(|trial| trial.features).collect();
        let is_open = |pattern: &Pattern| {
            let own = Features::from(pattern);
            !cut.iter().any(|cut| is_same(cut, &own)) && open(pattern, &own)
        };
        let patterns: Vec<Pattern> = designs(self.task, self.scope.designs).into_iter().filter(is_open).collect();
        let between = |pattern: &Pattern| {
            let lengths_m = [pattern.width_m(), pattern.spacing_m(), pattern.depth_m()];
            Some(Design::new(*pattern, self.interpolation.at(lengths_m)?, self.covariance(pattern)?))
        };
        let drafts: Vec<Option<Design>> = patterns.par_iter().map(between).collect();
        let left: Vec<Design> = drafts.into_iter().flatten().collect();
        let candidate = |place: usize| Some(left[place].candidate());
        let wanted = (self.scope.judged, least_chance);
        let ranked = slipgrid_discrepancy::rank(&self.predictor, &self.asked.wanted, wanted, left.len(), &candidate);
        let best: Vec<Pattern> = ranked.iter().map(|chosen| left[chosen.place].pattern).collect();
        // The model itself at what looks best by the interpolated one.
        let drafts: Vec<Result<Judged, ModelFailure>> = best.par_iter().map(|pattern| self.drafted(pattern)).collect();
        let mut pool: Vec<Judged> = drafts.into_iter().flatten().collect();
        // Stable: of equal scores the earlier first.
        let sort = |pool: &mut Vec<Judged>| pool.sort_by(|a, b| b.score.value().total_cmp(&a.score.value()));
        pool.retain(|of| of.score.chance >= least_chance);
        sort(&mut pool);
        pool.truncate(self.scope.completed.max(2 * count));
        let whole: Vec<Result<Judged, ModelFailure>> =
            pool.into_par_iter().map(|draft| self.completed(draft)).collect();
        let mut pool: Vec<Judged> = whole.into_iter().flatten().collect();
        sort(&mut pool);
        (pool, left.len())
    }
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
        let refused = |failure| DesignError::refused(format!("the candidate cannot be computed: {failure}"));
        search.exactly(pattern).map_err(refused)
    };
    let own: Vec<Judged> = options.own.iter().map(own).collect::<Result<_, _>>()?;
    let pending: Vec<Judged> = options.pending.iter().filter_map(|pattern| search.exactly(pattern).ok()).collect();
    let (chosen, together) = several(&pool, &pending, options, asked);
    let report = |judged: &Judged| TrialCandidateReport::new(task, asked, judged);
    let greatest = pool.iter().map(|judged| judged.score.chance).fold(0.0, f64::max);
    let next = NextReport {
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
        best: pool.iter().take(LISTED).map(report).collect(),
        own: own.iter().map(report).collect(),
        warnings: Vec::new(),
        material: material.clone(),
        specimen: (&task.specimen).into(),
        laser: task.laser,
        seed: task.seed,
    };
    Ok((next, chosen.iter().map(|judged| judged.design.pattern).collect()))
}

/// `count` designs of `pool`, the first the best and each further one where those before and those `pending` miss the target, with
/// the chance that one of them is on it.
///
/// Samples on one disc share what differs from disc to disc: they are off together, and further apart from each other are better.
fn several<'a>(pool: &'a [Judged], pending: &[Judged], options: &NextOptions, asked: &Asked) -> (Vec<&'a Judged>, f64) {
    let (count, scenarios) = (options.count.max(1), Scenarios::new(&asked.learned, SCENARIOS, 1));
    let on = |scenarios: &Scenarios, judged: &Judged| {
        scenarios.on_target(&judged.design.candidate(), &asked.loads, &asked.wanted)
    };
    let disc = if options.one_disc { scenarios.clone().on_one_disc(DISC_SEED) } else { scenarios.clone() };
    let hits: Vec<Vec<bool>> = pool.par_iter().map(|judged| on(&disc, judged)).collect();
    let mut hit = vec![false; SCENARIOS];
    let mark = |hit: &mut Vec<bool>, by: &[bool]| hit.iter_mut().zip(by).for_each(|(hit, on)| *hit |= on);
    pending.iter().for_each(|judged| mark(&mut hit, &on(&scenarios, judged)));
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..count.min(pool.len()) {
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
    let together = hit.iter().filter(|hit| **hit).count() as f64 / SCENARIOS as f64;
    (chosen.into_iter().map(|place| &pool[place]).collect(), together)
}

/// What the laser of `task` will not cut of `patterns` as they are designed.
fn laser_warnings(task: &DesignTask, patterns: &[Pattern]) -> Vec<String> {
    let of = |(number, pattern): (usize, &Pattern)| {
        let removal = task.specimen.layout(*pattern).ok().and_then(|layout| Removal::new(&layout, &task.laser));
        let warnings = removal.map_or_else(Vec::new, |removal| removal.warnings);
        warnings.into_iter().map(move |warning| format!("sample {}: {warning}", number + 1))
    };
    patterns.iter().enumerate().flat_map(of).collect()
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
mod tests;
