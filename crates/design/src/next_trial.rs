//! Samples to cut next: those with the maximum chance by the model corrected by trials.

use std::ops::RangeInclusive;

use crate::results::MadeBy;
use rayon::prelude::*;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::{counted, tidy};
use slipgrid_infer::calibrate::CutSample;
use slipgrid_infer::discrepancy::{Features, Scenarios};
use slipgrid_laser::export::{Division, MAX_SECTORS, MIN_PERIODS, Outline, Sector};
use slipgrid_model::pattern::Pattern;

use crate::DesignError;
use crate::advice::Advice;
use crate::band::Asked;
use crate::design_report::SCHEMA;
use crate::learning_disc;
use crate::next_report::{NextReport, OneDiscReport};
use crate::optimize::Violation;
use crate::prediction::Prediction;
use crate::prepared_task::PreparedTask;
use crate::search::{Search, is_same};
use crate::session::with_table;
use crate::task::DesignTask;
use crate::time_budget::{SEARCH_SHARE, TimeBudget, UNCONFIRMED_SHARE};
use crate::timings::Timings;

/// Maximum number of designs in a report, unless more samples are to be cut at once.
const LISTED: usize = 6;
/// Number of random scenarios by which the joint chance of several samples is estimated.
const SCENARIOS: usize = 2000;
/// Seed of the errors that samples on one disc share in the scenarios.
const DISC_SEED: u64 = 2;

/// Options of `next`.
#[derive(Clone, Debug, Default)]
pub struct NextOptions {
    /// Number of samples to cut at once.
    pub count: usize,
    /// Samples that were cut and are not measured yet.
    pub pending: Vec<CutSample>,
    /// Patterns whose chance the user asks for.
    pub own: Vec<Pattern>,
    /// Whether the samples are sectors of one specimen.
    pub one_disc: bool,
    /// Whether to choose two sectors of one specimen that teach most about the mechanism of the model error, in place of
    /// `count` samples likely to be on target.
    pub learn: bool,
    /// Names of specimens already cut into sectors; those of measured trials are known and need not be given.
    pub discs: Vec<String>,
}

impl NextOptions {
    /// Accepted numbers of samples to cut at once, on separate specimens or as sectors of one.
    pub const fn counts(one_disc: bool) -> RangeInclusive<usize> {
        if one_disc { 2..=MAX_SECTORS } else { 1..=20 }
    }

    /// Options for what the trials of a calibration say, `samples`: which are pending, and which discs were cut.
    pub fn of_samples(samples: &[CutSample]) -> Self {
        let pending = samples.iter().filter(|cut| cut.measured.is_empty()).cloned().collect();
        let discs = samples.iter().filter_map(|cut| cut.disc.clone()).collect();
        Self { pending, discs, ..Self::default() }
    }

    /// Whether `pattern` is not pending and, if `division` is given, fits on its sectors.
    pub fn is_open(&self, pattern: &Pattern, division: Option<&Division>) -> bool {
        let own = Features::from(pattern);
        !self.pending.iter().any(|cut| is_same(&Features::from(&cut.pattern), &own))
            && division.is_none_or(|division| division.holds(pattern))
    }
}

/// Samples to cut next, as a report and as patterns.
#[derive(Clone, Debug)]
pub struct NextTrials {
    /// Report on the samples, as written to result.json.
    pub report: NextReport,
    /// Advice that the report names; `None` for a disc to learn from, which asks no target.
    pub advice: Option<Advice>,
    /// Patterns of the samples to cut.
    pub patterns: Vec<Pattern>,
    /// Sectors of one specimen; empty if not requested.
    pub sectors: Vec<Sector>,
}

/// Finds the samples of `task` to cut next. Stages of the monitor: "table", "search".
///
/// # Errors
/// [`DesignError`] for a task that is refused, that the monitor cancels, or of which nothing can be computed.
pub fn next_trials(task: &DesignTask, options: &NextOptions, monitor: &dyn Monitor) -> Result<NextTrials, DesignError> {
    let prepared = &PreparedTask::new(task)?;
    let task = &prepared.task;
    if !task.target.has_demands() && options.count > 1 && !options.learn {
        let reason = "demands nothing that one of several samples could meet: expected one sample at a time";
        return Err(DesignError::refused(reason));
    }
    let count = if options.learn { learning_disc::SECTORS } else { options.count };
    let division = (options.one_disc || options.learn).then(|| Division::new(task.specimen, count)).transpose();
    let division = division.map_err(|error| DesignError::refused(error.to_string()))?;
    // Two tables of a disc to learn from share the time.
    let share = if options.learn { SEARCH_SHARE } else { UNCONFIRMED_SHARE };
    let budget = TimeBudget::new(monitor, task.search.max_seconds, share);
    let mut found = match &division {
        Some(division) if options.learn => learning_disc::choose(task, options, division, budget)?,
        division => {
            let division = division.as_ref();
            with_table(prepared, division, None, budget, &mut Timings::default(), |search, _| {
                choose(search, options, division, monitor)
            })?
        }
    };
    found.sectors = match &division {
        Some(division) => division.lay(&found.patterns).map_err(|error| DesignError::refused(error.to_string()))?,
        None => Vec::new(),
    };
    let learned = prepared.uncertainty.learned.iter().flat_map(|learned| learned.trials());
    let cut: Vec<&str> =
        learned.filter_map(|trial| trial.disc.as_deref()).chain(options.discs.iter().map(String::as_str)).collect();
    found.report.one_disc = OneDiscReport::of(new_name(&found.report.name, task, &cut), &found.sectors);
    // The user's samples are numbered after the samples to cut, in the order of the list.
    found.report.warnings = laser_warnings(task, found.patterns.iter().chain(&options.own));
    Ok(found)
}

/// Finds a name for a specimen of `design` that is not in `cut`.
fn new_name(design: &str, task: &DesignTask, cut: &[&str]) -> String {
    let what = if matches!(task.specimen.outline, Outline::Rectangle { .. }) { "rectangle" } else { "disc" };
    let mut names = (1..).map(|number| format!("{design}, {what} {number}"));
    names.find(|name| !cut.contains(&name.as_str())).unwrap_or_default()
}

/// Chooses the samples of `search` to cut next by `options`, on sectors of `division` if given.
fn choose(
    search: &Search<'_>,
    options: &NextOptions,
    division: Option<&Division>,
    monitor: &dyn Monitor,
) -> Result<NextTrials, DesignError> {
    let asked = search.asked;
    let found = search.best(&|pattern| options.is_open(pattern, division), options.count);
    monitor.heed()?;
    let Some(best) = found.solved.first() else {
        return Err(match division {
            Some(division) if !search.stage.cancelled() => DesignError::NothingToCut(coarse(division)),
            _ => search.nothing_found(),
        });
    };
    let nothing_to_cut = |reason: String| {
        if search.stage.cancelled() { search.nothing_found() } else { DesignError::NothingToCut(reason) }
    };
    if division.is_some() && best.texture.excess > 0.0 {
        return Err(nothing_to_cut(unkept(&search.violated_by(&best.texture))));
    }
    if division.is_some() && found.solved.len() < options.count {
        let designs = counted(found.solved.len(), "design");
        let reason = format!("only {designs} fit on one of {} sectors", options.count);
        return Err(nothing_to_cut(reason));
    }
    let own = |pattern: &Pattern| {
        monitor.heed()?;
        let refused = |failure| DesignError::refused(format!("the candidate cannot be computed: {failure}"));
        search.solved(pattern).map(|found| search.as_cut(&found)).map_err(refused)
    };
    let own: Vec<Prediction> = options.own.iter().map(own).collect::<Result<_, _>>()?;
    let pending = options.pending.iter().filter_map(|cut| Some((cut, search.solved(&cut.pattern).ok()?)));
    let pending: Vec<(&CutSample, Prediction)> = pending.collect();
    monitor.heed()?;
    let advice = Advice::of(search, best, found.is_within_reach);
    let listed = search.unlike(&found.solved, options.count, LISTED.max(options.count));
    let (chosen, together) = if options.count <= 1 && pending.is_empty() {
        (vec![best.clone()], best.chance())
    } else {
        let scenarios = Scenarios::new(&asked.learned, SCENARIOS, 1).of_friction(&asked.flat_shares);
        // Samples on one disc share what differs from disc to disc.
        let on_disc = options.one_disc.then(|| scenarios.clone().on_one_disc(DISC_SEED));
        let draws = Draws { asked, disc: on_disc.as_ref().unwrap_or(&scenarios), scenarios: &scenarios };
        let chosen = several(&listed, &pending, options.count, &draws);
        // Solves each sample as cut; the first one is already solved.
        let chosen: Vec<Prediction> = chosen.into_iter().map(|of| search.as_cut(of)).collect();
        let together = one_on_target(&chosen, &pending, options.count, &draws);
        (chosen, together)
    };
    let first = best.report(search);
    let is_chosen = |of: &&Prediction| !chosen.iter().any(|own| own.texture.pattern == of.texture.pattern);
    // With pending samples the first sample need not be the likeliest.
    let told = if advice == Advice::Trial { chosen.first().unwrap_or(best) } else { best };
    let report = NextReport {
        compared: found.compared,
        advice: advice.name().to_owned(),
        words: advice.words(told.chance(), asked.has_demands(), found.is_within_reach),
        samples: chosen.iter().map(|of| of.full_report(search)).collect(),
        one_on_target: asked.has_demands().then(|| tidy(together)),
        others: listed.iter().filter(is_chosen).map(|of| of.report(search).beside(&first)).collect(),
        own: own.iter().map(|of| of.report(search)).collect(),
        cut_short: search.stage.cancelled().then(|| "search".to_owned()).into_iter().collect(),
        ..new_report(search, options)
    };
    let patterns = chosen.iter().map(|of| of.texture.pattern).collect();
    Ok(NextTrials { report, advice: Some(advice), patterns, sectors: Vec::new() })
}

/// Creates the report on the task of `search` without samples and advice.
pub fn new_report(search: &Search<'_>, options: &NextOptions) -> NextReport {
    let Search { prepared, task, asked, .. } = *search;
    NextReport {
        made_by: MadeBy::slipgrid(SCHEMA),
        name: task.name.clone(),
        trials: asked.learned.trials().len(),
        pending: options.pending.len(),
        beyond_measured: task.beyond_measured(&prepared.material, &prepared.outside),
        material: prepared.material.provenance.clone(),
        specimen: (&task.specimen).into(),
        laser: task.laser,
        tolerances: task.assumed_tolerances(),
        seed: task.search.seed,
        ..NextReport::default()
    }
}

/// Random scenarios by which the joint chance of several samples is estimated.
struct Draws<'a> {
    asked: &'a Asked,
    /// Scenarios of samples on separate discs.
    scenarios: &'a Scenarios,
    /// Scenarios of the samples to cut, which are on one disc if requested.
    disc: &'a Scenarios,
}

impl Draws<'_> {
    /// For each of `scenarios`, whether the sample with the number `number` and the texture of `of` is on target.
    fn hits(&self, scenarios: &Scenarios, (number, of): (usize, &Prediction)) -> Vec<bool> {
        scenarios.on_target(&of.texture.candidate(), &self.asked.loads, &self.asked.wanted, number)
    }

    /// For each scenario, whether any of the `pending` samples, numbered from `first` on, is on target. Those of one disc
    /// share what differs from disc to disc.
    fn any_on_target(&self, pending: &[(&CutSample, Prediction)], first: usize) -> Vec<bool> {
        let mut hit = vec![false; SCENARIOS];
        for (place, (cut, of)) in pending.iter().enumerate() {
            let same_disc = pending.iter().position(|(other, _)| cut.disc.is_some() && other.disc == cut.disc);
            let on_disc = same_disc.map(|disc| self.scenarios.clone().on_one_disc(DISC_SEED + 1 + disc as u64));
            mark(&mut hit, &self.hits(on_disc.as_ref().unwrap_or(self.scenarios), (first + place, of)));
        }
        hit
    }
}

/// Adds the scenarios `by`, in which a sample is on target, to the scenarios `hit`, in which some sample is on target.
fn mark(hit: &mut [bool], by: &[bool]) {
    hit.iter_mut().zip(by).for_each(|(hit, on)| *hit |= on);
}

/// Chooses `count` designs of `pool`: the first is the best, and each further design is on target most often in
/// scenarios in which the designs before and the `pending` samples miss the target.
///
/// Samples on one disc miss the target together, so that textures on one disc should differ more.
fn several<'a>(
    pool: &'a [Prediction],
    pending: &[(&CutSample, Prediction)],
    count: usize,
    draws: &Draws<'_>,
) -> Vec<&'a Prediction> {
    let count = count.max(1).min(pool.len());
    let each: Vec<Vec<bool>> = pool.par_iter().enumerate().map(|of| draws.hits(draws.disc, of)).collect();
    let mut hit = draws.any_on_target(pending, pool.len());
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..count {
        let gain = |place: &usize| each[*place].iter().zip(&hit).filter(|(on, hit)| **on && !**hit).count();
        let open = (0..pool.len()).filter(|place| !chosen.contains(place));
        // Without earlier samples the best is chosen by score; equal gains are decided by the score.
        let best = if chosen.is_empty() && pending.is_empty() {
            Some(0)
        } else {
            open.max_by(|a, b| gain(a).cmp(&gain(b)).then(b.cmp(a)))
        };
        let Some(best) = best else { break };
        mark(&mut hit, &each[best]);
        chosen.push(best);
    }
    chosen.into_iter().map(|place| &pool[place]).collect()
}

/// Chance that at least one of the `chosen` or `pending` samples is on target.
fn one_on_target(chosen: &[Prediction], pending: &[(&CutSample, Prediction)], count: usize, draws: &Draws<'_>) -> f64 {
    // Uses other sample numbers than the choice did, because the chosen designs were favoured by their own draws.
    let first = LISTED.max(count);
    let mut hit = draws.any_on_target(pending, first);
    (first + pending.len()..).zip(chosen).for_each(|of| mark(&mut hit, &draws.hits(draws.disc, of)));
    hit.iter().filter(|hit| **hit).count() as f64 / SCENARIOS as f64
}

/// Warnings about features of `patterns` that the laser of `task` cannot cut as designed, each with the number of the
/// sample.
pub fn laser_warnings<'a>(task: &DesignTask, patterns: impl Iterator<Item = &'a Pattern>) -> Vec<String> {
    let of = |(number, pattern): (usize, &'a Pattern)| {
        let broken = task.constraints.limits.violations(pattern);
        let mut warnings: Vec<String> = broken.iter().map(ToString::to_string).collect();
        // Warnings about passes name the speed that makes the depth.
        let part_burst = task.laser.check_depth(pattern).err().filter(|_| !task.laser.has_passes());
        warnings.extend(part_burst.map(|error| error.to_string()));
        let layout = task.specimen.layout(*pattern).ok();
        warnings
            .extend(layout.into_iter().flat_map(|layout| slipgrid_laser::export::laser_warnings(&layout, &task.laser)));
        warnings.into_iter().map(move |warning| format!("sample {}: {warning}", number + 1))
    };
    patterns.enumerate().flat_map(of).collect()
}

/// Message that every design on a sector violates limits; the best one violates `limits`.
pub fn unkept(limits: &[Violation]) -> String {
    let limits: Vec<String> = limits.iter().map(ToString::to_string).collect();
    let of_best = if limits.is_empty() { String::new() } else { format!(" (the best one: {})", limits.join(", ")) };
    format!("no design found that fits on a sector keeps all limits{of_best}: expected other limits or wider bounds")
}

/// Message that no design fits on a sector of `division`.
pub fn coarse(division: &Division) -> String {
    format!(
        "no design within the bounds can be computed whose period fits {MIN_PERIODS} times on the {:.2} mm wide circle of a sector: \
         expected fewer sectors, or finer textures within the bounds",
        1e3 * division.least_circle_m()
    )
}
