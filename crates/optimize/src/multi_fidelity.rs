//! Search with a dear model along a cheap one.

use crate::evaluation_archive::{Archive, Evaluator, Interruption, Key, Record, key};
use crate::low_fidelity_correction::{Correction, LowFidelityCorrection};
use crate::search::search_along;
use crate::space::Grid;
use crate::{
    Candidate, Constraints, DesignSpace, ForwardModel, ModelFailure, Response, SearchError, SearchOptions,
    SearchOutcome, Status, Target, summary,
};
use rayon::prelude::*;
use slipgrid_monitor::{Monitor, Part};
use slipgrid_pattern::Pattern;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Searches along the corrected guide. Differences that are smooth settle in three or four.
const MOST_ROUNDS: usize = 12;
/// Searches after the one that met the target, to come closer to it.
const MORE_ONCE_MET: usize = 2;
/// The corrected guide has settled where it misses the model by less, in tolerances: at the best designs it found,
/// and at those of lowest and highest value, where an extreme by the model itself is only as much beyond.
const SETTLED: f64 = 0.1;
const SETTLED_EXTREMES: f64 = 0.5;
/// Of the designs at the ends of the widths and spacings whose value by the guide is as near to its extreme, relative to it, the
/// shallowest are judged too: there the guide may have them in the wrong order.
const NEAR_THE_EXTREME: f64 = 0.02;
const SHALLOWEST: usize = 3;
/// Depths at which these ends are looked at, at most.
const MOST_DEPTHS: u64 = 32;
/// The model's failure at a design holds within this distance, as a share of the bounds.
const FAILURE_REACH: f64 = 0.02;

/// As [`search`](crate::search()), where `model` is dear and `guide` is a cheap model that differs from it little, or smoothly.
///
/// The whole space is searched along the guide, corrected by what is known of its differences from the model
/// (`low_fidelity_correction`, which grows). The model then judges what this found: the best design, its alternatives and,
/// where the target was out of reach, the designs of lowest and highest value, at the end also shallow ones with the widths and spacings
/// of the bounds; and the search begins again with
/// what that taught, until the model itself meets the target, or the corrected guide agrees with it at all
/// these designs and still says that none does. The response of every design in the outcome is the model's own;
/// `evaluations` counts its answers, `guide_evaluations` the designs that the guide was asked of, both limited
/// by the options' `max_evaluations`. Cancelled by `monitor` before the model was asked of any design, it asks the model of
/// the best that the guide knows.
///
/// # Errors
/// As [`search`](crate::search()), for either model.
#[allow(clippy::too_many_arguments, reason = "those of search, and the two that make it guided")]
pub fn search_multi_fidelity(
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    model: &dyn ForwardModel,
    guide: &dyn ForwardModel,
    low_fidelity_correction: &mut LowFidelityCorrection,
    monitor: &dyn Monitor,
) -> Result<SearchOutcome, SearchError> {
    let grid = Grid::new(space, constraints)?;
    let guide = Remembered { guide, answers: Mutex::new(BTreeMap::new()) };
    // So many answers are allowed of each of the two.
    let half = Part::new(monitor, 0.5);
    let evaluator = Evaluator::new(model, target, constraints, options.max_evaluations, &half);
    let mut judge = Judge { evaluator, archive: Archive::default(), failures: Vec::new() };
    // Had no round ended otherwise, guide and model would never have come to agree.
    let mut ending = Status::Budget;
    let mut rounds_met = 0;
    for _ in 0..MOST_ROUNDS {
        let left = options.max_evaluations.saturating_sub(guide.len());
        if left == 0 {
            break;
        }
        let correction = low_fidelity_correction.correction(&grid, target.values(), constraints.quantities.len());
        let corrected = Corrected { guide: &guide, correction, grid: &grid, failures: &judge.failures };
        let along = SearchOptions { max_evaluations: left, ..*options };
        let part = Part::new(&half, left as f64 / options.max_evaluations as f64);
        let found = search_along(&judge.seeds(), target, space, constraints, &along, &corrected, &part)?;
        if found.status == Status::Cancelled {
            // Without a design of the model itself there would be nothing to report.
            if judge.archive.records().is_empty()
                && let Err(Interruption::Error(error)) = judge.ask(vec![found.best.design])
            {
                return Err(error);
            }
            ending = Status::Cancelled;
            break;
        }
        // Both are of designs that the search has asked the guide of: nothing is computed here.
        let asked: Vec<(Pattern, Response, Response)> = judge
            .unjudged(&found)
            .into_iter()
            .filter_map(|design| Some((design, corrected.respond(&design).ok()?, guide.respond(&design).ok()?)))
            .collect();
        let records = match judge.ask(asked.iter().map(|(design, ..)| *design).collect()) {
            Ok(records) => records,
            Err(Interruption::Budget) => break,
            Err(Interruption::Cancelled) => {
                ending = Status::Cancelled;
                break;
            }
            Err(Interruption::Error(error)) => return Err(error),
        };
        let mut agree = true;
        for (record, (design, expected, guided)) in records.iter().zip(&asked) {
            agree &= match record {
                Record::Computed(candidate) => {
                    low_fidelity_correction.learn(*design, &candidate.response, guided);
                    let most = if *design == found.best.design { SETTLED } else { SETTLED_EXTREMES };
                    difference(&candidate.response, expected) <= most * target.tolerance()
                        && candidate.violations.len() == constraints.violations(design, expected).len()
                }
                Record::Failed(_) => false,
            };
        }
        rounds_met += usize::from(judge.best().is_some_and(Candidate::meets_target));
        let is_goal = target.goal().is_some();
        let has_settled = agree && (found.status == Status::Unreachable || (is_goal && found.status == Status::Met));
        // A goal can always come closer: there it takes agreement.
        let close = judge.is_comfortable() || (rounds_met > MORE_ONCE_MET && !is_goal);
        if close || records.is_empty() || has_settled {
            // Where the guide still says that the target is met, the model does not follow it, unless the two agree.
            ending = if found.status == Status::Met && !has_settled { Status::Budget } else { found.status };
            break;
        }
    }
    if ending == Status::Unreachable && !judge.best().is_some_and(Candidate::meets_target) {
        let correction = low_fidelity_correction.correction(&grid, target.values(), constraints.quantities.len());
        let corrected = Corrected { guide: &guide, correction, grid: &grid, failures: &judge.failures };
        let left = options.max_evaluations.saturating_sub(guide.len());
        let mut designs = extremes(&corrected, target, constraints, left);
        designs.retain(|design| !judge.archive.knows(design));
        if let Err(Interruption::Error(error)) = judge.ask(designs) {
            return Err(error);
        }
    }
    if judge.archive.records().is_empty() && ending == Status::Cancelled {
        return Err(SearchError::CancelledAtStart);
    }
    let met = judge.best().is_some_and(Candidate::meets_target);
    let status = match ending {
        _ if met && (target.goal().is_none() || judge.is_comfortable()) => Status::Met,
        Status::Met if !met => Status::Budget,
        ending => ending,
    };
    let outcome = summary::outcome(&judge.archive, &grid, target, status)?;
    Ok(SearchOutcome { guide_evaluations: guide.len(), ..outcome })
}

/// Of the designs at the ends of the widths and spacings, at every depth, those that `corrected` says to have the lowest and highest
/// values at each point of `target`, and the shallowest of those whose values are hardly different, as far as they respect
/// `constraints`; none where there are more than `most`.
fn extremes(corrected: &Corrected<'_>, target: &Target, constraints: &Constraints, most: usize) -> Vec<Pattern> {
    let count = corrected.grid.values(2).min(MOST_DEPTHS);
    let mut designs: Vec<Pattern> = Vec::new();
    for ends in [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]] {
        let at = |step| corrected.grid.design(&[ends[0], ends[1], corrected.grid.spread(2, step, count)]);
        for design in (0..count).filter_map(at) {
            if !designs.contains(&design) {
                designs.push(design);
            }
        }
    }
    if designs.len() > most {
        return Vec::new();
    }
    let answer = |design: &Pattern| {
        let response = corrected.respond(design).ok()?;
        constraints.violations(design, &response).is_empty().then_some((*design, response))
    };
    let mut answered: Vec<(Pattern, Response)> = designs.par_iter().filter_map(answer).collect();
    answered.sort_by(|(left, _), (right, _)| left.depth_m().total_cmp(&right.depth_m()));
    let mut found: Vec<Pattern> = Vec::new();
    for (point, side) in (0..target.points().len()).flat_map(|point| [(point, 1.0), (point, -1.0)]) {
        let height = |(_, response): &(Pattern, Response)| side * response.value[point];
        let Some(extreme) = answered.iter().min_by(|a, b| height(a).total_cmp(&height(b))) else { continue };
        let limit = height(extreme) + NEAR_THE_EXTREME * height(extreme).abs();
        let shallow = answered.iter().filter(|of| height(of) <= limit).take(SHALLOWEST);
        for (design, _) in std::iter::once(extreme).chain(shallow) {
            if !found.contains(design) {
                found.push(*design);
            }
        }
    }
    found
}

/// Largest difference of two responses' values.
fn difference(left: &Response, right: &Response) -> f64 {
    left.value.iter().zip(&right.value).map(|(left, right)| (left - right).abs()).fold(0.0, f64::max)
}

/// The model, and what it has said.
struct Judge<'a> {
    evaluator: Evaluator<'a>,
    archive: Archive,
    /// Designs that the model could not compute.
    failures: Vec<Pattern>,
}

impl Judge<'_> {
    /// The designs that `found` rests on and the model has not judged yet.
    fn unjudged(&self, found: &SearchOutcome) -> Vec<Pattern> {
        let mut designs: Vec<Pattern> = Vec::new();
        let alternatives = found.alternatives.iter().map(|candidate| candidate.design);
        let extremes = found.reachable.iter().flat_map(|range| [range.lowest_design, range.highest_design]);
        let extremes = extremes.filter(|_| found.status != Status::Met);
        for design in std::iter::once(found.best.design).chain(alternatives).chain(extremes) {
            if !self.archive.knows(&design) && !designs.contains(&design) {
                designs.push(design);
            }
        }
        designs
    }

    /// What the model says of `designs`, in parallel; all of it is kept.
    fn ask(&mut self, designs: Vec<Pattern>) -> Result<Vec<Record>, Interruption> {
        let evaluator = &self.evaluator;
        if self.archive.records().len() + designs.len() > evaluator.max_evaluations {
            return Err(Interruption::Budget);
        }
        let answers: Vec<_> = designs.par_iter().map(|design| evaluator.evaluate(design)).collect();
        let records = answers.into_iter().collect::<Result<Vec<Record>, Interruption>>()?;
        self.failures.extend(records.iter().filter_map(Record::failure).map(|failed| failed.design));
        self.archive.absorb(records.clone());
        Ok(records)
    }

    /// Designs that the model has judged and could compute.
    fn seeds(&self) -> Vec<Pattern> {
        self.archive.candidates().map(|candidate| candidate.design).collect()
    }

    fn best(&self) -> Option<&Candidate> {
        self.archive.best()
    }

    fn is_comfortable(&self) -> bool {
        self.best()
            .is_some_and(|best| best.meets_target() && best.misfit.cost <= self.evaluator.target.comfortable_cost())
    }
}

/// The guide, asked of each design once but where two threads come to one at the same time.
struct Remembered<'a> {
    guide: &'a dyn ForwardModel,
    answers: Mutex<BTreeMap<Key, Result<Response, ModelFailure>>>,
}

impl Remembered<'_> {
    /// Answers are whole when they enter: those of a panicking thread are as good as any.
    fn answers(&self) -> MutexGuard<'_, BTreeMap<Key, Result<Response, ModelFailure>>> {
        self.answers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Designs of which the guide was asked.
    fn len(&self) -> usize {
        self.answers().len()
    }
}

impl ForwardModel for Remembered<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        if let Some(known) = self.answers().get(&key(design)) {
            return known.clone();
        }
        let answer = self.guide.respond(design);
        self.answers().insert(key(design), answer.clone());
        answer
    }
}

/// The guide with what is known of its differences from the model.
pub(crate) struct Corrected<'a> {
    pub(crate) guide: &'a dyn ForwardModel,
    pub(crate) correction: Correction,
    pub(crate) grid: &'a Grid,
    /// Designs that the model could not compute.
    pub(crate) failures: &'a [Pattern],
}

impl ForwardModel for Corrected<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        if self.failures.iter().any(|failed| self.grid.distance(failed, design) <= FAILURE_REACH) {
            return Err(ModelFailure::Trial { reason: "the model could not compute a design like it".to_owned() });
        }
        let guided = self.guide.respond(design)?;
        Ok(self.correction.apply(&self.grid.shares(design), &guided))
    }
}
