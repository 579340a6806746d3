//! Search for the texture within bounds and limits with the maximum chance of a sample on target.
//!
//! ```text
//! all textures by the table -> best of every region -> climbs over whole blocks and bursts by the table
//!   -> solve where climbs end; correct the table by the difference -> repeat until the best is a solved texture
//!   -> solve the best as cut (specimen's ends, tilt, time); correct the table -> repeat until the best is as cut
//! ```

mod cutting;
mod interpolated;
mod progress;
mod ranking;

use crate::optimize::{ConstraintQuantity, ModelFailure, Violation};
use rayon::prelude::*;
use slipgrid_base::monitor::{Monitor, Part as Share, cached};
use slipgrid_infer::discrepancy::{Features, Predictor};
use slipgrid_model::pattern::Pattern;

use self::progress::Progress;
use crate::DesignError;
use crate::as_cut::{BeyondCells, CutTexture, Known};
use crate::band::Asked;
use crate::evaluation_cache::Answer;
use crate::explorer::BOUND_ROUNDING;
use crate::inputs::Inputs;
use crate::prediction::Prediction;
use crate::prepared_task::PreparedTask;
use crate::sensitivities::Models;
use crate::steps::{Place, Steps, climb};
use crate::table::Table;
use crate::task::DesignTask;

/// Total weight of the likeliest members of the predictor's mixture that preselect textures; the whole mixture ranks
/// these textures. After one trial, such members are a sixth of all.
pub const SHARE_OF_RANKING: f64 = 0.8;
/// Total weight of the likeliest members of the mixture that predict lattices of a thousand textures for pages and
/// trade-offs. After one trial, such members are half of all, and give chances to 0.004
/// (`likeliest_members_give_the_chances_of_all`).
pub const SHARE_OF_LATTICES: f64 = 0.995;
/// Number of starts of climbs, in different regions.
const STARTS: usize = 6;
/// Maximum number of textures that one set of climbs evaluates by the table.
const CLIMBED: usize = 1500;
/// Number of the best textures by the table that are solved in addition to the ends of climbs: candidates for several
/// samples.
const POOL: usize = 12;
/// Maximum number of rounds of climbs by the corrected table.
const MAX_ROUNDS: usize = 16;
/// Maximum number of textures that keep all limits and that a search solves as cut.
const MAX_AS_CUT: usize = 4;
/// Maximum number of textures that a search solves as cut, with those that break a limit: by how much the peak pressure
/// in the run of a specimen exceeds that of its cell is known from other textures only roughly.
const MAX_RUNS: usize = 12;
/// Chances that differ by less are equal within the error of the table.
pub const ALIKE: f64 = 0.005;
/// Relative gain in value up to which a predicted improvement is not worth another dynamic run. The effects of the
/// specimen's ends, pressure tilt and time change values by 0.1 to 2.5 % for the shipped designs and seven other
/// targets, in half of them by less than 0.8 %; of four predicted gains below 0.7 % three were not confirmed.
const EQUAL: f64 = 0.01;
/// Maximum difference between the logarithms of any length of two similar textures.
const UNLIKE: f64 = 0.15;
/// Relative difference below which two lengths, or two areal densities, are equal.
const SAME_LENGTH: f64 = 1e-3;

/// Whether two textures are equal, compared by their features because trials store only features.
pub fn is_same(a: &Features, b: &Features) -> bool {
    let same = |of: fn(&Features) -> f64| (of(a) - of(b)).abs() <= SAME_LENGTH * of(a).max(of(b));
    same(|of| of.width_m) && same(|of| of.pitch_m) && same(|of| of.depth_m) && same(|of| of.areal_density)
}

/// Task, models and table of a search.
#[derive(Clone)]
pub struct Search<'a> {
    pub prepared: &'a PreparedTask,
    pub task: &'a DesignTask,
    pub asked: &'a Asked,
    pub predictor: Predictor,
    /// The likeliest members of `predictor`, for lattices of textures.
    pub of_lattices: Predictor,
    /// Fewer of the likeliest members of `predictor`, to rank textures.
    pub of_ranking: Predictor,
    pub models: &'a Models<'a>,
    pub beyond: &'a BeyondCells<'a>,
    pub table: &'a Table,
    pub inputs: &'a Inputs<'a>,
    /// Receives progress and can cancel the search.
    pub stage: &'a dyn Monitor,
}

/// Result of a search.
pub struct Found {
    /// Textures solved by the model: the first is solved as cut; the others are sorted by decreasing value, and may
    /// exceed the value of the first by [`EQUAL`].
    pub solved: Vec<Prediction>,
    /// Number of textures compared by the table.
    pub compared: usize,
    /// Whether some texture has accepted medians at every load.
    pub is_within_reach: bool,
}

impl<'a> Search<'a> {
    /// Creates the search for what is `asked`, with the predictors of its trials.
    pub fn new(
        (prepared, asked): (&'a PreparedTask, &'a Asked),
        (models, inputs): (&'a Models<'a>, &'a Inputs<'a>),
        (beyond, table): (&'a BeyondCells<'a>, &'a Table),
        stage: &'a dyn Monitor,
    ) -> Self {
        let predictor = asked.learned.of_friction_at(&asked.loads, &asked.flat_shares);
        let [of_lattices, of_ranking] = [SHARE_OF_LATTICES, SHARE_OF_RANKING].map(|share| predictor.likeliest(share));
        Self {
            prepared,
            task: &prepared.task,
            asked,
            predictor,
            of_lattices,
            of_ranking,
            models,
            beyond,
            table,
            inputs,
            stage,
        }
    }

    /// Creates the search by the same table for other trials, as of `asked`.
    pub fn asking(&self, asked: &'a Asked) -> Self {
        let Self { prepared, models, inputs, beyond, table, stage, .. } = *self;
        Self { task: self.task, ..Self::new((prepared, asked), (models, inputs), (beyond, table), stage) }
    }
}

impl Search<'_> {
    /// Compares `texture` with the limits by the model's `answer`.
    ///
    /// # Errors
    /// [`ModelFailure`] if the specimen does not take the pattern.
    fn limited(&self, texture: CutTexture, answer: Answer) -> Result<CutTexture, ModelFailure> {
        let excess = self.violations(&texture.pattern, &answer)?.iter().map(Violation::excess).sum();
        Ok(CutTexture { excess, limited: Some(answer), ..texture })
    }

    /// Lists the limits that `pattern` with the model's `answer` violates.
    ///
    /// # Errors
    /// [`ModelFailure`] if the specimen does not take the pattern.
    fn violations(&self, pattern: &Pattern, answer: &Answer) -> Result<Vec<Violation>, ModelFailure> {
        // The laser can cut the pattern only if some cavities fit the specimen, and not far too many do.
        self.task.specimen.check(*pattern).map_err(|error| ModelFailure::Trial(error.to_string()))?;
        Ok(self.task.constraints.violations(pattern, &self.task.limited(pattern, answer)?))
    }

    /// Limits that `texture` violates.
    pub fn violated_by(&self, texture: &CutTexture) -> Vec<Violation> {
        let answer = texture.limited.as_ref().filter(|_| texture.excess > 0.0);
        answer.and_then(|answer| self.violations(&texture.pattern, answer).ok()).unwrap_or_default()
    }

    /// Interpolates `pattern` in the table, corrected by the known errors of the table at solved textures.
    fn corrected(&self, pattern: &Pattern, known: &Progress) -> Option<CutTexture> {
        let texture = self.interpolated_with(pattern, &self.table.lay(pattern)?, known.run_over_cell(pattern))?;
        let texture = texture.moved(&known.off.at(pattern).unwrap_or_default());
        let texture = texture.moved(&known.by_cutting.at(pattern).unwrap_or_default());
        Some(CutTexture { covariance: known.covariance(pattern), ..texture })
    }

    /// Solved textures, sorted by decreasing value; those not solved as cut include the interpolated effect of the
    /// specimen's ends, pressure tilt and time, also on the peak pressure where that is limited.
    fn ordered(&self, known: &mut Progress) -> Vec<Prediction> {
        let one = |of: &Prediction| {
            let pattern = &of.texture.pattern;
            let Some(by) = known.by_cutting.at(pattern).filter(|_| of.texture.known < Known::AsCut) else {
                return of.clone();
            };
            let peak = known.run_over_cell(pattern).max(1.0);
            self.predicted(self.with_peak(of.texture.clone().moved(&by), &|of_cell_mpa| peak * of_cell_mpa))
        };
        let fresh: Vec<Prediction> = known.solved[known.with_cutting.len()..].par_iter().map(one).collect();
        known.with_cutting.extend(fresh);
        sorted(known.with_cutting.clone())
    }

    /// Compares `texture` with the limits again, its peak pressure, in megapascals, changed by `change`.
    fn with_peak(&self, texture: CutTexture, change: &dyn Fn(f64) -> f64) -> CutTexture {
        let changed = |of: &Answer| Answer { peak_pressure_mpa: change(of.peak_pressure_mpa), ..of.clone() };
        let limited = texture.limited.as_ref().map(changed);
        limited.and_then(|answer| self.limited(texture.clone(), answer).ok()).unwrap_or(texture)
    }

    fn predicted(&self, texture: CutTexture) -> Prediction {
        Prediction::new(texture, &self.predictor, self.asked)
    }

    /// Predicts a sample of `pattern` from a solution in the smallest affordable blocks, with all input uncertainties;
    /// the effects of the specimen's ends and pressure tilt come from the table.
    ///
    /// # Errors
    /// [`ModelFailure`] if the pattern cannot be computed.
    pub fn solved(&self, pattern: &Pattern) -> Result<Prediction, ModelFailure> {
        let (modelled, answer) = self.models.at(pattern)?;
        let mut ratio: Vec<f64> = modelled.log_ratio.iter().map(|log| log.exp()).collect();
        let content = (self.models.own.content(), pattern);
        let refine = || self.models.refined(pattern, &answer.ratio, false).ok_or(());
        let refined = cached(self.stage, ("refined ratios", &content), 0.0, refine).ok();
        if let Some((shifts, _)) = &refined {
            ratio.iter_mut().zip(shifts).for_each(|(ratio, shift)| *ratio += shift);
        }
        let parts = self.inputs.parts(pattern, &ratio, refined.map(|(_, open)| open))?;
        let by_face = self.table.by_face(pattern, &answer.ratio);
        let texture = CutTexture::interpolated(*pattern, modelled, Vec::new()).with_parts(parts);
        let texture = self.limited(CutTexture { ratio, known: Known::Solved, ..texture }, answer)?;
        Ok(self.predicted(texture.moved(&by_face)))
    }

    fn limits_peak(&self) -> bool {
        let mut limits = self.task.constraints.quantities.iter();
        limits.any(|limit| limit.quantity == ConstraintQuantity::PeakPressure)
    }

    /// Finds the textures of maximum value among those that the filter `open` allows: the first is solved as cut, the
    /// others are sorted by decreasing value, at least `count` in all if there are as many. If the stage is cancelled,
    /// returns the results so far.
    pub fn best(&self, open: &(dyn Fn(&Pattern) -> bool + Sync), count: usize) -> Found {
        let steps = Steps::new(self.task);
        let (ranked, compared, is_within_reach) = self.ranked(&steps, POOL.max(count), open);
        self.stage.advance(0.3);
        let mut known = Progress::default();
        // Textures of trials are candidates too: a texture that was on target is likely to be so again.
        let cut = self.cut().into_iter().filter(|pattern| open(pattern));
        let ends = self.climbed(&steps, self.first_of_regions(&ranked), (&known, &[]), open);
        let pool = ranked.iter().take(POOL.max(count)).map(|of| of.texture.pattern);
        self.solve(ends.into_iter().chain(cut).chain(pool).collect(), &mut known);
        self.stage.advance(0.3);
        let mut solved = self.ordered(&mut known);
        for _ in 0..MAX_RUNS {
            let is_kept = |of: &&Prediction| of.texture.known == Known::AsCut && of.texture.excess == 0.0;
            let kept = solved.iter().filter(is_kept).count();
            if kept == MAX_AS_CUT {
                break;
            }
            // Repeats until the best by the corrected table is a solved texture.
            for _ in 0..MAX_ROUNDS {
                let from = solved.iter().take(STARTS / 2).map(|of| of.texture.pattern).collect();
                let mut ends = self.climbed(&steps, from, (&known, &solved), open);
                ends.retain(|end| !known.is_known(end));
                if ends.is_empty() || self.stage.cancelled() {
                    break;
                }
                self.solve(ends, &mut known);
                solved = self.ordered(&mut known);
            }
            // While every texture as cut breaks a limit, those whose cells keep it may do so, whatever is predicted.
            let keeps = |of: &Prediction| {
                let own = known.solved.iter().find(|own| own.texture.pattern == of.texture.pattern);
                own.is_some_and(|own| own.texture.excess == 0.0)
            };
            let is_open = |(place, of): &(usize, &Prediction)| {
                let is_next = *place == 0 || kept == 0 && keeps(of);
                is_next && of.texture.known < Known::AsCut && !self.stage.cancelled()
            };
            let first = solved.iter().enumerate().find(is_open).map(|(_, of)| of);
            let Some(first) = first.filter(|first| !self.is_alike_as_cut(first, &solved)) else { break };
            let pattern = first.texture.pattern;
            let Some(own) = known.solved.iter_mut().find(|of| of.texture.pattern == pattern) else { break };
            let found = self.as_cut(own);
            if found.texture.known < Known::AsCut {
                break;
            }
            let by = found.texture.ratio.iter().zip(&own.texture.ratio).map(|(cut, solved)| (cut / solved).ln());
            known.by_cutting.learn([(pattern, by.collect())]);
            if self.limits_peak()
                && let Some((run, cell)) = found.texture.run.as_ref().zip(own.texture.limited.as_ref())
            {
                let log = (run.peak_pressure_pa() / cell.peak_pressure_pa()).ln();
                known.peak_by_run.learn([(pattern, vec![log])]);
            }
            *own = found;
            known.with_cutting.clear();
            solved = self.ordered(&mut known);
            self.stage.advance(0.05);
        }
        // The best of those solved as cut comes first, even if others promise a little more, or more at the round limit.
        if let Some(first) = solved.iter().position(|of| of.texture.known == Known::AsCut) {
            solved[..=first].rotate_right(1);
        }
        self.stage.advance(0.2);
        // The model may say of a solved texture what the table did not.
        let is_within = |of: &Prediction| of.texture.excess == 0.0 && of.is_within(self.asked);
        let is_within_reach = is_within_reach || solved.iter().any(is_within);
        Found { solved, compared, is_within_reach }
    }

    /// Error that no texture was found: the time limit ended, or none within the bounds can be computed.
    pub fn nothing_found(&self) -> DesignError {
        if self.stage.cancelled() {
            return DesignError::OutOfTime("max_seconds was spent before a design was found".to_owned());
        }
        self.models.own.nothing_computed(&self.task.space)
    }

    /// Whether `solved` has a [`Known::AsCut`] texture that keeps all limits and whose value is at least 1 - [`EQUAL`]
    /// times that of `first`, so that a dynamic run of `first` is not worth its time. Always false with a goal.
    fn is_alike_as_cut(&self, first: &Prediction, solved: &[Prediction]) -> bool {
        let mut kept = solved.iter().filter(|of| of.texture.known == Known::AsCut && of.texture.excess == 0.0);
        self.asked.goal.is_none() && kept.any(|of| of.value() >= (1.0 - EQUAL) * first.value())
    }

    /// Finds the texture of maximum value by the table and a climb, among those that the filter `open` allows, and
    /// whether some texture has accepted medians at every load.
    pub fn greatest(&self, open: &(dyn Fn(&Pattern) -> bool + Sync)) -> (Option<Prediction>, bool) {
        let steps = Steps::new(self.task);
        let (ranked, _, is_within_reach) = self.ranked(&steps, STARTS, open);
        let ends = self.climbed(&steps, self.first_of_regions(&ranked), (&Progress::default(), &[]), open);
        let all = ends.iter().filter_map(|end| self.roughly(end)).collect();
        (sorted(all).into_iter().next(), is_within_reach)
    }

    fn is_within_bounds(&self, pattern: &Pattern) -> bool {
        let mut bounds = self.task.space.lengths_m().into_iter().zip(pattern.lengths_m());
        bounds.all(|([low, high], own)| (low * (1.0 - BOUND_ROUNDING)..=high * (1.0 + BOUND_ROUNDING)).contains(&own))
    }

    /// Whether `pattern` lies within the bounds and, by the table, keeps all limits.
    pub fn is_admitted(&self, pattern: &Pattern) -> bool {
        self.is_within_bounds(pattern) && self.interpolated(pattern).is_some_and(|texture| texture.excess == 0.0)
    }

    /// Texture of the task with the lengths of `features`.
    fn pattern_of(&self, features: &Features) -> Option<Pattern> {
        self.task.space.pattern([features.width_m, features.pitch_m - features.width_m, features.depth_m]).ok()
    }

    /// Textures of trials that are designs of the task: within bounds and limits, with the features of the task's
    /// texture.
    fn cut(&self) -> Vec<Pattern> {
        let of = |features: &Features| {
            let pattern = self.pattern_of(features)?;
            // Measured depths need not be whole bursts.
            let is_makeable = self.task.constraints.limits.violations(&pattern).is_empty()
                && self.task.laser.check_depth(&pattern).is_ok();
            (self.is_within_bounds(&pattern) && is_makeable && is_same(features, &Features::from(&pattern)))
                .then_some(pattern)
        };
        self.asked.learned.trials().iter().filter_map(|trial| of(&trial.features)).collect()
    }

    /// Returns the textures at which climbs from `starts` by the corrected table end; `solved` textures have their
    /// solved values.
    fn climbed(
        &self,
        steps: &Steps<'_>,
        starts: Vec<Pattern>,
        (known, solved): (&Progress, &[Prediction]),
        open: &(dyn Fn(&Pattern) -> bool + Sync),
    ) -> Vec<Pattern> {
        let values = solved.iter().map(|of| (&of.texture.pattern, Some(of.value())));
        let values = values.chain(known.refused.iter().map(|pattern| (pattern, None)));
        let values = values.filter_map(|(pattern, value)| Some((steps.place(pattern)?, value))).collect();
        let value = |pattern: &Pattern| Some(self.predicted(self.corrected(pattern, known)?).value());
        let starts: Vec<Place> = starts.iter().filter_map(|pattern| steps.place(pattern)).collect();
        let part = Share::new(self.stage, 0.0);
        climb(steps, &starts, CLIMBED, values, (open, &value), &part)
    }

    /// Solves those of `designs` that are not solved yet, and adds them to `known`.
    fn solve(&self, designs: Vec<Pattern>, known: &mut Progress) {
        let mut fresh: Vec<Pattern> = Vec::new();
        for design in designs {
            let own = Features::from(&design);
            let is_fresh = !fresh.iter().any(|other| is_same(&Features::from(other), &own));
            if is_fresh && !known.is_known(&design) {
                fresh.push(design);
            }
        }
        let one = |design: &Pattern| if self.stage.cancelled() { None } else { self.solved(design).ok() };
        let answers: Vec<Option<Prediction>> = fresh.par_iter().map(one).collect();
        let mut off = Vec::new();
        for (design, found) in fresh.into_iter().zip(answers) {
            let Some(found) = found else {
                known.refused.push(design);
                continue;
            };
            off.push((design, self.off_at(&found)));
            known.solved.push(found);
        }
        known.off.learn(off.into_iter().filter(|(_, off)| !off.is_empty()));
    }

    /// Returns the first `most` of `solved`, keeping only the best of similar ones; if fewer than `least` remain, adds
    /// others.
    pub fn unlike(&self, solved: &[Prediction], least: usize, most: usize) -> Vec<Prediction> {
        let mut chosen: Vec<&Prediction> = Vec::new();
        for of in solved {
            let is_allowed = of.texture.excess == 0.0 || chosen.is_empty();
            let is_alike = |other: &&Prediction| {
                let lengths = of.texture.pattern.lengths_m().into_iter().zip(other.texture.pattern.lengths_m());
                lengths.into_iter().all(|(own, other)| (own / other).ln().abs() < UNLIKE)
            };
            if is_allowed && !chosen.iter().any(is_alike) {
                chosen.push(of);
            }
        }
        let is_left = |of: &&Prediction| !chosen.iter().any(|other| other.texture.pattern == of.texture.pattern);
        let lacking = least.saturating_sub(chosen.len());
        let rest: Vec<&Prediction> = solved.iter().filter(is_left).take(lacking).collect();
        chosen.into_iter().chain(rest).take(most).cloned().collect()
    }
}

/// Sorts by decreasing value, and by decreasing chance where textures break limits equally.
fn sorted(mut all: Vec<Prediction>) -> Vec<Prediction> {
    all.sort_by(|a, b| b.value().total_cmp(&a.value()).then(b.chance().total_cmp(&a.chance())));
    all
}
