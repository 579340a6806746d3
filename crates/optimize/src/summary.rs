//! The outcome of a search, from all designs that it evaluated.

use crate::evaluation_archive::{Archive, Record};
use crate::space::Grid;
use crate::{Candidate, Demand, FailedTrial, HistoryPoint, ReachableRange, SearchError, SearchOutcome, Status, Target};

/// Alternatives reported, and how unlike one another they are, as a share of the bounds.
const ALTERNATIVES: usize = 4;
const ALTERNATIVE_DISTANCE: f64 = 0.1;

/// What the designs of `archive` say of `target`.
///
/// # Errors
/// [`SearchError::EveryTrialFailed`] where no design has a response.
pub(crate) fn outcome(
    archive: &Archive,
    grid: &Grid,
    target: &Target,
    status: Status,
) -> Result<SearchOutcome, SearchError> {
    let Some(best) = archive.best().cloned() else { return Err(every_trial_failed(archive)) };
    let mut history = Vec::new();
    let mut leader: Option<&Candidate> = None;
    for (index, record) in archive.records().iter().enumerate() {
        if let Some(candidate) = record.candidate()
            && leader.is_none_or(|leader| candidate.is_better_than(leader))
        {
            leader = Some(candidate);
            let (misfit, feasible) = (candidate.misfit, candidate.violations.is_empty());
            history.push(HistoryPoint { evaluation: index + 1, misfit, feasible });
        }
    }
    Ok(SearchOutcome {
        status,
        alternatives: alternatives(archive, grid, &best),
        best,
        evaluations: archive.records().len(),
        guide_evaluations: 0,
        failed_trials: failed_trials(archive),
        reachable: reachable(archive, target),
        meeting: archive.candidates().filter(|candidate| candidate.meets_target()).cloned().collect(),
        history,
    })
}

/// What is said where no design of `archive` has a response.
pub(crate) fn every_trial_failed(archive: &Archive) -> SearchError {
    let failed = failed_trials(archive);
    let reason = failed.first().map_or_else(String::new, |trial| trial.reason.clone());
    SearchError::EveryTrialFailed { trials: failed.len(), reason }
}

fn failed_trials(archive: &Archive) -> Vec<FailedTrial> {
    archive.records().iter().filter_map(Record::failure).cloned().collect()
}

fn alternatives(archive: &Archive, grid: &Grid, best: &Candidate) -> Vec<Candidate> {
    let mut meeting: Vec<&Candidate> = archive.candidates().filter(|candidate| candidate.meets_target()).collect();
    meeting.sort_by(|left, right| left.misfit.merit.total_cmp(&right.misfit.merit));
    unlike(meeting.into_iter(), grid, best)
}

/// The first of `ranked` that are unlike `best` and one another.
pub(crate) fn unlike<'a>(ranked: impl Iterator<Item = &'a Candidate>, grid: &Grid, best: &Candidate) -> Vec<Candidate> {
    let mut alternatives: Vec<Candidate> = Vec::new();
    for candidate in ranked {
        let is_unlike = |other: &Candidate| grid.distance(&candidate.design, &other.design) >= ALTERNATIVE_DISTANCE;
        if alternatives.len() < ALTERNATIVES && is_unlike(best) && alternatives.iter().all(is_unlike) {
            alternatives.push(candidate.clone());
        }
    }
    alternatives
}

fn reachable(archive: &Archive, target: &Target) -> Vec<ReachableRange> {
    let range = |(index, point): (usize, &Demand)| {
        let value = |candidate: &Candidate| candidate.response.value[index];
        // The earliest of equals, either way.
        let extreme = |is_beyond: fn(f64, f64) -> bool| {
            archive
                .feasible()
                .reduce(|extreme, next| if is_beyond(value(next), value(extreme)) { next } else { extreme })
        };
        let (lowest, highest) = (extreme(|a, b| a < b)?, extreme(|a, b| a > b)?);
        Some(ReachableRange {
            pressure_pa: point.pressure_pa,
            lowest: value(lowest),
            highest: value(highest),
            lowest_design: lowest.design,
            highest_design: highest.design,
        })
    };
    target.points().iter().enumerate().filter_map(range).collect()
}
