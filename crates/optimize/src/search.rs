//! The search itself: a sample of the space, descents from its best designs, neighbouring numbers of bursts, and how far friction can be
//! brought.

use crate::evaluation_archive::{Archive, Evaluator, Interruption, LocalArchive};
use crate::local_search::{Cost, Descent, Method, Objective};
use crate::search_effort::{AGAIN, ALONG, Effort, NEAREST, NEXT_BURSTS, WHOLE};
use crate::space::Grid;
use crate::{
    Candidate, Constraints, DesignSpace, ForwardModel, Goal, SearchError, SearchOutcome, Status, Target,
    low_discrepancy, summary,
};
use rayon::prelude::*;
use slipgrid_monitor::Monitor;
use slipgrid_pattern::Pattern;

/// How the search is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SearchOptions {
    /// Seed of the sample.
    pub seed: u64,
    /// Most model evaluations.
    pub max_evaluations: usize,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { seed: 1, max_evaluations: 2000 }
    }
}

/// Evaluations below which a search of `space` under `constraints` takes less than its whole sample, which is half of all at most.
///
/// # Errors
/// [`SearchError`] where these leave nothing to search.
pub fn least_evaluations(space: &DesignSpace, constraints: &Constraints) -> Result<usize, SearchError> {
    Ok(2 * low_discrepancy::planned(Grid::new(space, constraints)?.free_axes().len()) - 1)
}

/// Smallest distance of two starts, as a share of the (logarithmic) bounds.
const START_DISTANCE: f64 = 0.15;
/// Penalty of a relative excess of 1, in median misfits of the sample: a constraint that changes by
/// its own size over the box is then twenty times as steep as the misfit.
const PENALTY_STEEPNESS: f64 = 20.0;
/// Target points up to which every one has its extremes sought; beyond, the lowest and highest
/// pressure and the one missed most.
const EVERY_EXTREME: usize = 4;
/// Steps of the grid tried at the end of a search for a goal.
const MOST_GRID_STEPS: usize = 20;
/// Share of the remaining evaluations that a stage before the last may spend.
const STAGE_SHARE: f64 = 0.6;

/// Searches `space` for a design that brings friction to `target` under `constraints`.
///
/// `monitor` hears of every evaluation, from any thread, as its share of those allowed; cancelled, the search ends
/// with what it has. The rayon pool of the caller is used.
///
/// # Errors
/// [`SearchError`] where the input leaves nothing to search, or the model is broken or fails
/// for every design of the sample.
pub fn search(
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    model: &dyn ForwardModel,
    monitor: &dyn Monitor,
) -> Result<SearchOutcome, SearchError> {
    search_with(WHOLE, &[], target, space, constraints, options, model, monitor)
}

/// As [`search`] along a guide, with the designs `known` beside the sample: those that earlier searches, when the
/// guide was hardly different, rested on. With any it looks no further than around the best of them.
pub(crate) fn search_along(
    known: &[Pattern],
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    guide: &dyn ForwardModel,
    monitor: &dyn Monitor,
) -> Result<SearchOutcome, SearchError> {
    let effort = if known.is_empty() { ALONG } else { AGAIN };
    search_with(effort, known, target, space, constraints, options, guide, monitor)
}

/// As [`search`], beginning with the designs `known`, of which one is the best of much the same problem; only the
/// nearest design is wanted. It asks a third as often.
///
/// # Errors
/// As [`search`].
pub fn search_near(
    known: &[Pattern],
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    model: &dyn ForwardModel,
    monitor: &dyn Monitor,
) -> Result<SearchOutcome, SearchError> {
    search_with(NEAREST, known, target, space, constraints, options, model, monitor)
}

#[allow(clippy::too_many_arguments, reason = "those of search, and what it begins with")]
fn search_with(
    effort: Effort,
    known: &[Pattern],
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    model: &dyn ForwardModel,
    monitor: &dyn Monitor,
) -> Result<SearchOutcome, SearchError> {
    if options.max_evaluations == 0 {
        return Err(SearchError::OutOfRange { quantity: "max_evaluations", value: 0.0, expected: "at least 1" });
    }
    let grid = Grid::new(space, constraints)?;
    let evaluator = Evaluator::new(model, target, constraints, options.max_evaluations, monitor);
    let mut search =
        Search { evaluator, grid, archive: Archive::default(), unfinished: Vec::new(), penalty: 0.0, effort };
    let sample_is_whole = search.sample(known, options)?;
    let status = match search.descend_in_stages() {
        Ok(()) if search.is_met() && (target.goal().is_none() || search.is_comfortable()) => Status::Met,
        Ok(()) if !search.unfinished.is_empty() || !sample_is_whole => Status::Budget,
        // There is nothing better than what was found.
        Ok(()) if search.is_met() => Status::Met,
        Ok(()) => Status::Unreachable,
        Err(Interruption::Budget) => Status::Budget,
        Err(Interruption::Cancelled) if search.is_met() && target.goal().is_none() => Status::Met,
        Err(Interruption::Cancelled) => Status::Cancelled,
        Err(Interruption::Error(error)) => return Err(error),
    };
    summary::outcome(&search.archive, &search.grid, target, status)
}

/// State of a search.
struct Search<'a> {
    evaluator: Evaluator<'a>,
    grid: Grid,
    archive: Archive,
    /// Descents that a stage's share of the evaluations cut short.
    unfinished: Vec<Descent>,
    penalty: f64,
    effort: Effort,
}

impl Search<'_> {
    /// Evaluates the designs `known`, the corners of the box and a low-discrepancy sample. Returns whether the
    /// evaluations allowed sufficed for the sample as planned.
    fn sample(&mut self, known: &[Pattern], options: &SearchOptions) -> Result<bool, SearchError> {
        let free = self.grid.free_axes();
        let corners = 1_usize << free.len();
        let (planned, most) = (low_discrepancy::planned(free.len()), options.max_evaluations.div_ceil(2));
        let is_whole = planned <= most;
        let mut shares = Vec::new();
        if is_whole {
            for corner in 0..corners {
                shares.push(free.iter().enumerate().fold([0.0; 3], |mut shares, (bit, &axis)| {
                    shares[axis] = (corner >> bit & 1) as f64;
                    shares
                }));
            }
        }
        for point in low_discrepancy::points(free.len(), low_discrepancy::SAMPLE[free.len()].min(most), options.seed) {
            shares.push(free.iter().zip(point).fold([0.0; 3], |mut shares, (&axis, t)| {
                shares[axis] = t;
                shares
            }));
        }
        let mut designs: Vec<Pattern> = known[..known.len().min(most)].to_vec();
        for design in shares.iter().filter_map(|shares| self.grid.design(shares)) {
            // On a coarse grid two points can be one design.
            if !designs.contains(&design) {
                designs.push(design);
            }
        }
        let results: Vec<_> = designs.par_iter().map(|design| self.evaluator.evaluate(design)).collect();
        for result in results {
            match result {
                Ok(record) => self.archive.absorb(vec![record]),
                Err(Interruption::Error(error)) => return Err(error),
                Err(Interruption::Budget | Interruption::Cancelled) => {}
            }
        }
        if self.archive.records().is_empty() {
            return Err(SearchError::CancelledAtStart);
        }
        let mut costs: Vec<f64> = self.archive.candidates().map(|candidate| candidate.misfit.cost).collect();
        costs.sort_by(f64::total_cmp);
        // Misfits are counted from 0, a goal from the best there is.
        let from = if self.has_goal() { costs.first().copied().unwrap_or(0.0) } else { 0.0 };
        match costs.get(costs.len() / 2) {
            Some(median) => self.penalty = PENALTY_STEEPNESS * (median - from).max(1.0),
            None => return Err(summary::every_trial_failed(&self.archive)),
        }
        Ok(is_whole)
    }

    /// Everything after the sample, each stage only where the ones before leave something to gain.
    fn descend_in_stages(&mut self) -> Result<(), Interruption> {
        if self.evaluator.is_cancelled() {
            return Err(Interruption::Cancelled);
        }
        // 1. From the best distinct designs of the sample.
        let mut tried = self.distinct_starts(&[], self.effort.starts);
        self.refine_at_bursts(&tried.clone())?;
        // 2. Width and spacing at the numbers of bursts near the best one.
        if !self.is_comfortable() {
            let most = if self.is_met() && !self.has_goal() { NEXT_BURSTS } else { self.effort.bursts };
            self.run(self.burst_descents(most), self.stage_budget())?;
        }
        // Extremes mostly lie on bounds, and other bounds hold other ones.
        if self.has_goal() && !self.is_comfortable() {
            self.run(self.bound_descents(), self.stage_budget())?;
        }
        // 3. The least root-mean-square misfit, which descents go for, can hide a design whose largest misfit, which
        // decides, is less.
        self.bring_the_largest_down()?;
        // 4. Before saying that the target is out of reach: how far friction can be brought, and
        // starts unlike those before; these, too, before saying that there is nothing better.
        let is_met = self.is_met();
        let looks_on = !is_met && !self.effort.nearest_alone;
        if looks_on {
            self.run(self.extreme_descents(), self.stage_budget())?;
        }
        if looks_on || (self.has_goal() && !self.is_comfortable()) {
            tried.extend(self.archive.best().map(|best| best.design));
            let starts = self.distinct_starts(&tried, self.effort.starts);
            self.refine_at_bursts(&starts)?;
            self.bring_the_largest_down()?;
        }
        // 5. With all evaluations left, what was cut short.
        if !self.is_comfortable() {
            let descents = std::mem::take(&mut self.unfinished);
            self.run(descents, self.remaining())?;
        }
        if self.has_goal() && !self.is_comfortable() && self.unfinished.is_empty() {
            self.step_to_the_limits()?;
        }
        Ok(())
    }

    /// Steps of the grid from the best design while they gain: descents keep a little away from constraints.
    fn step_to_the_limits(&mut self) -> Result<(), Interruption> {
        for _ in 0..MOST_GRID_STEPS {
            let Some(best) = self.archive.best().map(|best| best.design) else { break };
            let mut unknown = self.grid.neighbours(&best);
            unknown.retain(|neighbour| !self.archive.knows(neighbour));
            if unknown.len() > self.remaining() {
                return Err(Interruption::Budget);
            }
            let evaluator = &self.evaluator;
            let records: Vec<_> = unknown.par_iter().map(|neighbour| evaluator.evaluate(neighbour)).collect();
            self.archive.absorb(records.into_iter().collect::<Result<_, _>>()?);
            if self.archive.best().is_some_and(|found| found.design == best) {
                break;
            }
        }
        Ok(())
    }

    /// Gauss-Newton steps, or towards a goal linear ones, from `starts`, then, unless that was enough, simplexes from
    /// the best distinct designs so far.
    fn refine_at_bursts(&mut self, starts: &[Pattern]) -> Result<(), Interruption> {
        let from = |search: &Self, starts: &[Pattern], method| -> Vec<Descent> {
            let descent = |&start: &Pattern| search.descent(search.grid, start, Objective::Target, method);
            starts.iter().map(descent).collect()
        };
        self.run(from(self, starts, self.method()), self.stage_budget())?;
        if !self.is_comfortable() {
            let starts = self.distinct_starts(&[], self.effort.simplex_starts);
            self.run(from(self, &starts, Method::Simplex), self.stage_budget())?;
        }
        Ok(())
    }

    fn descent(&self, grid: Grid, start: Pattern, objective: Objective, method: Method) -> Descent {
        Descent::new(grid, start, self.cost(objective), method).with_simplex(self.effort.edge, self.effort.collapsed)
    }

    fn cost(&self, objective: Objective) -> Cost {
        let target = self.evaluator.target;
        let tolerance = match objective {
            Objective::Lowest(point) | Objective::Highest(point) => target.points()[point].wanted.tolerance(),
            Objective::Target | Objective::Largest => None,
        };
        Cost {
            objective,
            tolerance: tolerance.unwrap_or_else(|| target.tolerance()),
            comfortable: target.comfortable_cost(),
            penalty: self.penalty,
        }
    }

    fn has_goal(&self) -> bool {
        self.evaluator.target.goal().is_some()
    }

    /// What descends to the target first: Gauss-Newton steps where its cost is a root mean square.
    fn method(&self) -> Method {
        let target = self.evaluator.target;
        match target.goal() {
            None => Method::GaussNewton,
            Some(Goal::Even) if !target.has_demands() => Method::GaussNewton,
            Some(_) => Method::LinearSteps,
        }
    }

    /// Runs `descents` in rounds. In a round each has the same number of evaluations, fixed in
    /// advance, so that the outcome does not depend on the number of threads; what some leave
    /// unspent goes to the others in the next round.
    fn run(&mut self, mut descents: Vec<Descent>, budget: usize) -> Result<(), Interruption> {
        let last = self.archive.records().len() + budget;
        while !descents.is_empty() {
            let left = last.saturating_sub(self.archive.records().len());
            if left == 0 {
                break;
            }
            let later = descents.split_off(descents.len().min(left));
            let share = left / descents.len();
            let results: Vec<_> = descents
                .par_iter()
                .map(|descent| {
                    let mut local = LocalArchive::new(&self.evaluator, &self.archive, share);
                    let rest = descent.run(&mut local);
                    (local.close(), rest)
                })
                .collect();
            descents = later;
            let mut interruption = None;
            for ((records, interrupted), rest) in results {
                self.archive.absorb(records);
                descents.extend(rest);
                interruption = interruption.or(interrupted.filter(|interrupted| *interrupted != Interruption::Budget));
            }
            if let Some(interruption) = interruption {
                return Err(interruption);
            }
            if self.is_comfortable() {
                return Ok(());
            }
        }
        self.unfinished.extend(descents);
        Ok(())
    }

    /// The best designs that are unlike `taken` and one another.
    fn distinct_starts(&self, taken: &[Pattern], most: usize) -> Vec<Pattern> {
        let cost = self.cost(Objective::Target);
        let mut ranked: Vec<(f64, &Pattern)> =
            self.archive.candidates().map(|candidate| (cost.of(candidate), &candidate.design)).collect();
        // Stable: of equal costs the earlier first.
        ranked.sort_by(|left, right| left.0.total_cmp(&right.0));
        let mut starts: Vec<Pattern> = Vec::new();
        for (_, design) in ranked {
            let is_unlike = |other: &Pattern| self.grid.distance(design, other) >= START_DISTANCE;
            if starts.len() < most && taken.iter().chain(&starts).all(is_unlike) {
                starts.push(*design);
            }
        }
        starts
    }

    /// Descents in width and spacing from the best design tried at each number of bursts near the
    /// best one, itself included; none where depths are not counted in bursts.
    fn burst_descents(&self, most: usize) -> Vec<Descent> {
        let (Some([first, last]), Some(best)) = (self.grid.bursts(), self.archive.best()) else { return Vec::new() };
        let centre = self.grid.bursts_of(&best.design);
        let reach = most as u64;
        let mut bursts: Vec<u64> = (first.max(centre.saturating_sub(reach))..=last.min(centre + reach)).collect();
        bursts.sort_by_key(|&bursts| bursts.abs_diff(centre));
        bursts.truncate(most);
        let start_at = |bursts: u64| {
            let grid = self.grid.at_bursts(bursts);
            let tried = self.archive.candidates().filter(|candidate| self.grid.bursts_of(&candidate.design) == bursts);
            let start = tried.fold(None, |best: Option<&Candidate>, candidate| match best {
                Some(best) if !candidate.is_better_than(best) => Some(best),
                _ => Some(candidate),
            });
            let start = match start {
                Some(start) => Some(start.design),
                None => grid.design(&self.grid.shares(&best.design)),
            };
            start.map(|start| self.descent(grid, start, Objective::Target, self.method()))
        };
        bursts.into_iter().filter_map(start_at).collect()
    }

    /// Descents on the faces and edges of the bounds, from the best design brought there.
    fn bound_descents(&self) -> Vec<Descent> {
        let Some(best) = self.archive.best() else { return Vec::new() };
        let shares = self.grid.shares(&best.design);
        let ends = |grid: Grid| {
            let axes = grid.free_axes().into_iter();
            axes.flat_map(move |axis| [(axis, grid.at_end(axis, false)), (axis, grid.at_end(axis, true))])
        };
        // Corners have been evaluated. Of an edge, its two axes in order.
        let edges = ends(self.grid).flat_map(|(axis, face)| {
            ends(face).filter(move |(other, edge)| *other > axis && !edge.free_axes().is_empty()).map(|(_, edge)| edge)
        });
        let grids = ends(self.grid).map(|(_, face)| face).filter(|face| !face.free_axes().is_empty()).chain(edges);
        let descent =
            |grid: Grid| grid.design(&shares).map(|start| self.descent(grid, start, Objective::Target, self.method()));
        grids.filter_map(descent).collect()
    }

    /// Brings the largest misfit down, where that decides and is not met: by Gauss-Newton steps from the best design and
    /// from that of the least root mean square, then, where it may yet be met, by a simplex from the best.
    fn bring_the_largest_down(&mut self) -> Result<(), Interruption> {
        if !self.evaluator.target.ranks_by_largest() || self.is_met() {
            return Ok(());
        }
        let cost = self.cost(Objective::Target);
        let least = self.archive.candidates().min_by(|left, right| cost.of(left).total_cmp(&cost.of(right)));
        let mut starts: Vec<Pattern> = self.archive.best().into_iter().chain(least).map(|start| start.design).collect();
        starts.dedup();
        let descents = |search: &Self, starts: &[Pattern], method| -> Vec<Descent> {
            let from = |start: &Pattern| search.descent(search.grid, *start, Objective::Largest, method);
            starts.iter().map(from).collect()
        };
        self.run(descents(self, &starts, Method::GaussNewton), self.stage_budget())?;
        let near = |best: &&Candidate| !best.misfit.is_met() && best.misfit.rms <= 1.0;
        let start: Vec<Pattern> = self.archive.best().filter(near).map(|best| best.design).into_iter().collect();
        self.run(descents(self, &start, Method::Simplex), self.stage_budget())
    }

    /// Descents to the lowest and the highest value, each from the feasible design nearest to it so far.
    fn extreme_descents(&self) -> Vec<Descent> {
        let Some(best) = self.archive.best() else { return Vec::new() };
        let points = self.evaluator.target.points();
        let mut chosen: Vec<usize> = (0..points.len()).collect();
        if points.len() > EVERY_EXTREME {
            let miss = |&point: &usize| points[point].wanted.residual(best.response.value[point]).abs();
            let lightest =
                chosen.iter().copied().min_by(|&i, &j| points[i].pressure_pa.total_cmp(&points[j].pressure_pa));
            let heaviest =
                chosen.iter().copied().max_by(|&i, &j| points[i].pressure_pa.total_cmp(&points[j].pressure_pa));
            let missed = chosen.iter().copied().max_by(|i, j| miss(i).total_cmp(&miss(j)));
            chosen = [lightest, heaviest, missed].into_iter().flatten().collect();
            chosen.sort_unstable();
            chosen.dedup();
        }
        let mut descents = Vec::new();
        for point in chosen {
            let value = |candidate: &&Candidate| candidate.response.value[point];
            let lowest = self.archive.feasible().min_by(|left, right| value(left).total_cmp(&value(right)));
            let highest = self.archive.feasible().max_by(|left, right| value(left).total_cmp(&value(right)));
            for (start, objective) in [(lowest, Objective::Lowest(point)), (highest, Objective::Highest(point))] {
                descents.extend(start.map(|start| self.descent(self.grid, start.design, objective, Method::Simplex)));
            }
        }
        descents
    }

    fn remaining(&self) -> usize {
        self.evaluator.max_evaluations.saturating_sub(self.archive.records().len())
    }

    fn stage_budget(&self) -> usize {
        // Far below 2^52: exact but for the rounding asked for.
        (self.remaining() as f64 * STAGE_SHARE) as usize
    }

    fn is_met(&self) -> bool {
        self.archive.best().is_some_and(Candidate::meets_target)
    }

    fn is_comfortable(&self) -> bool {
        let comfortable = self.evaluator.target.comfortable_cost();
        self.archive.best().is_some_and(|best| best.meets_target() && best.misfit.cost <= comfortable)
    }
}
