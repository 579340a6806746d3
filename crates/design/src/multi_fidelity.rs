//! Searches and confirming runs in turn.

use std::ops::ControlFlow;

use slipgrid_material::Material;
use slipgrid_optimize::{
    Candidate, Goal, LowFidelityCorrection, Quantity, SearchError, SearchOptions, SearchOutcome, Status,
    least_evaluations, search, search_multi_fidelity,
};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Extent, Fidelity, Load, RunOptions, Scene, Statements};

use crate::DesignError;
use crate::best_round::{Advantage, KeptRound, Round};
use crate::cache_key::cache_key;
use crate::chance::Chances;
use crate::confirmation::WithoutTime;
use crate::constraint_quantities::Limited;
use crate::evaluation_cache::{EvaluationCache, Evaluations};
use crate::flat_sample::flat_friction;
use crate::operating_conditions::Further;
use crate::robust_search;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::time_budget::{SEARCH_SHARE, TimeBudget};
use crate::timings::{ImprovementReport, Timings};
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_units::{LENGTH_UM, SPEED_MM_S, tidy};

/// Searches made at most: each after the first takes what the specimens of the designs before it were found to add to the steady
/// model. Two suffice where that hardly depends on the design.
pub(super) const MOST_ROUNDS: usize = 8;
/// Designs run in time at most.
pub(super) const MOST_RUNS: usize = 4;

/// Searches and confirmations in turn, until a confirmed design meets the target.
pub(super) struct MultiFidelityLoop<'a> {
    pub(super) model: SteadyModel<'a>,
    pub(super) correction: LowFidelityCorrection,
    pub(super) scene: Scene,
    pub(super) status: Status,
    pub(super) rounds: usize,
    /// Designs run in time.
    pub(super) runs: usize,
    pub(super) evaluations: usize,
    pub(super) solid_evaluations: usize,
    pub(super) failed_trials: usize,
    /// The seconds allowed for searches were spent.
    pub(super) out_of_time: bool,
    /// What the last round found, or the one that was gone back to.
    pub(super) round: Round,
    /// The other conditions, with confirming runs of their own where they decide.
    pub(super) further: Vec<Further>,
    pub(super) history: Vec<ImprovementReport>,
    /// The seconds that the job may take.
    pub(super) budget: TimeBudget<'a>,
    /// Whom the job reports to.
    pub(super) monitor: &'a dyn Monitor,
    /// Stages that these did not suffice for.
    pub(super) cut_short: Vec<&'static str>,
    /// What the chance of designs rests on.
    pub(super) chances: Option<Chances<'a>>,
    /// Largest change of the model by the specimen solved last; 0 before.
    pub(super) missed: f64,
    /// What the run in time of the last design that was run added to its specimen in steady sliding, to the target's quantity by the physics
    /// at each load of the condition designed for; a guess before, and nothing where it is not known.
    pub(super) added_by_time: Option<Vec<f64>>,
    /// The design that the model was corrected at last: of it, it says what is known.
    pub(super) corrected_at: Option<Pattern>,
    /// The best design that was not run in time, since its specimen in steady sliding was off target.
    pub(super) waiting: Option<Waiting>,
    /// Dynamic over steady friction of the flat sample as calibrated, at each load of the condition designed for and then of each
    /// further one; absent where the material does not say it.
    pub(super) excess: Vec<Option<Vec<f64>>>,
    /// The best round so far.
    pub(super) kept: Option<KeptRound>,
    /// Which round's design is reported and why, where later ones were worse.
    pub(super) taken_back: Option<String>,
}

/// A design that was not run in time.
#[derive(Clone, Debug)]
pub struct Waiting {
    /// What it is expected to miss by in time, as the search ranks.
    merit: f64,
    /// The round that found it.
    round: Round,
}

/// How the names of confirming stages begin.
pub(super) const CONFIRMATION: &str = "confirmation";

/// Whether a target that designs miss by `misfit` tolerances may still be reached, where their model misses `missed` of the specimen: it is
/// missed by less than twice as much.
pub(super) fn is_doubtful(design: &DesignTask, misfit: f64, missed: f64) -> bool {
    missed > 0.5 * (misfit - 1.0) * design.target.tolerance()
}

/// That the seconds allowed did not suffice for `stages`, where there are any.
pub(super) fn time_statement(stages: &[&str]) -> Option<String> {
    (!stages.is_empty()).then(|| format!("cut short by max_seconds: {}", stages.join(", ")))
}

impl<'a> MultiFidelityLoop<'a> {
    /// The loop before its first search. Where the target is dynamic friction itself, the flat sample is run here.
    pub(super) fn new(
        design: &DesignTask,
        material: &Material,
        loads: Vec<Load>,
        further: Vec<Further>,
        budget: TimeBudget<'a>,
        monitor: &'a dyn Monitor,
        timings: &mut Timings,
    ) -> Result<Self, DesignError> {
        let from_rest = RunOptions {
            fidelity: Fidelity::Dynamic,
            extent: if design.strip { Extent::Strip } else { Extent::Sample },
            seed: design.seed,
            dimensions: design.dimensions,
            ..RunOptions::default()
        }
        .on_specimen(design.space.texture());
        let mut scene = design.flat_scene(material, loads, from_rest);
        if !design.from_rest {
            // Nobody asked for static friction: start where sliding is about to begin.
            scene.run = from_rest.from_sliding();
        }
        let started_s = monitor.seconds();
        let flat_mu = match design.target.quantity() {
            Quantity::Ratio => None,
            Quantity::DynamicFriction => {
                let flat = flat_friction(&scene, budget)?;
                monitor.heed()?;
                if budget.is_spent() {
                    let reason = "the seconds allowed were spent on the flat sample: nothing was searched";
                    return Err(DesignError::OutOfTime(reason.to_owned()));
                }
                let speed_mm_s = tidy(SPEED_MM_S.from_si(scene.speed_m_s));
                Some(flat.ok_or_else(|| {
                    DesignError::refused(format!(
                        "asks for {speed_mm_s} mm/s, at which the flat sample does not slide evenly in the model, but in waves or \
                         not at all: expected a lower speed"
                    ))
                })?)
            }
        };
        timings.flat = monitor.seconds() - started_s;
        let elsewhere: Vec<&[Load]> = further.iter().map(|at| &at.loads[..]).collect();
        let model = SteadyModel::new(&scene, &elsewhere, &design.directions.different_deg, &design.space, flat_mu)
            .watched_by(monitor)
            .on(design.specimen);
        Ok(Self {
            added_by_time: model.guessed_by_time(),
            model,
            correction: LowFidelityCorrection::new(),
            round: Round { confirming: scene.run, ..Round::default() },
            scene,
            status: Status::Budget,
            rounds: 0,
            runs: 0,
            evaluations: 0,
            solid_evaluations: 0,
            failed_trials: 0,
            out_of_time: false,
            further,
            history: Vec::new(),
            budget,
            monitor,
            cut_short: Vec::new(),
            chances: None,
            missed: 0.0,
            corrected_at: None,
            waiting: None,
            excess: Vec::new(),
            kept: None,
            taken_back: None,
        })
    }

    pub(super) fn run(&mut self, design: &DesignTask, timings: &mut Timings) -> Result<(), DesignError> {
        self.run_rounds(design, timings)?;
        self.take_the_kept(design);
        // What is reported stands on them, too.
        self.confirm_further(design, timings)
    }

    /// Whether a further round is allowed and can be paid: a search without its whole sample finds what chance would have it.
    pub(super) fn goes_on(&self, design: &DesignTask) -> bool {
        let left = design.max_evaluations.saturating_sub(self.evaluations);
        let least = || least_evaluations(&design.space, &design.constraints);
        let is_paid = self.rounds == 0 || least().is_ok_and(|least| left >= least);
        self.may_search_again() && left > 0 && is_paid && !self.out_of_time
    }

    /// Whether there were fewer searches, and fewer runs in time, than are made at most.
    const fn may_search_again(&self) -> bool {
        self.rounds < MOST_ROUNDS && self.runs < MOST_RUNS
    }

    fn run_rounds(&mut self, design: &DesignTask, timings: &mut Timings) -> Result<(), DesignError> {
        // Known of a search whose model is off by less than what is missing: one that only asks for less pressure reaches no more.
        let mut is_beyond_reach = false;
        // The design that was run in time last, and whether its ratios were taken to smaller blocks.
        let mut in_time = None;
        while self.goes_on(design) {
            let outcome = match self.search(design, timings) {
                // What was found before stands.
                Err(DesignError::OutOfTime(_)) if self.kept.is_some() || self.waiting.is_some() => {
                    self.end_without_search(design, timings)?;
                    break;
                }
                outcome => outcome?,
            };
            let has_searched = matches!(outcome.status, Status::Met | Status::Unreachable);
            let is_known = in_time.is_some_and(|(run, _)| run == outcome.best.design);
            self.round.best = Some(outcome.best);
            let ControlFlow::Continue(solved) = self.next_run(design, outcome.status, is_known, timings)? else {
                is_beyond_reach = false;
                continue;
            };
            let Some(best) = self.round.best.clone() else { break };
            if !has_searched && !self.may_beat_the_kept(&best) {
                self.note_worse(Advantage::Cut);
                self.status = if is_beyond_reach { Status::Unreachable } else { Status::Budget };
                break;
            }
            let pattern = best.design;
            let misfit = best.misfit;
            let keeps_by_model = best.violations.is_empty();
            let unchanged = in_time == Some((pattern, self.round.confirming.refine));
            if !unchanged {
                self.confirm(design, &pattern, solved, timings)?;
                in_time = Some((pattern, self.round.confirming.refine));
                if self.waits(&pattern) {
                    self.waiting = None;
                }
            }
            // Further runs are as dear: not of a design that misses, or breaks a limit, by what is known already.
            if self.is_confirmed(design) {
                self.confirm_further(design, timings)?;
            }
            // On target is all that is asked for, unless there is a goal: then nothing better may be left to find.
            let suffices = design.target.goal().is_none() || outcome.status == Status::Met;
            // What is even by the steady model need not be in time: searched again with what the first run taught.
            let is_settled = design.target.goal() != Some(Goal::Even) || unchanged || self.runs > 1;
            let is_whole = !self.cut_short.iter().any(|stage| stage.starts_with(CONFIRMATION));
            self.keep_round(design, !has_searched, suffices && is_whole);
            let feasible = self.broken(design).is_empty();
            if feasible && suffices && is_settled && is_whole && self.is_confirmed(design) {
                self.status = Status::Met;
                return Ok(());
            }
            let is_pressed_harder = keeps_by_model && self.breaks_in_time(design);
            let was_exact = unchanged && self.corrected_at == Some(pattern);
            let missed = self.correct(design);
            let doubtful = is_doubtful(design, misfit.max, missed);
            let again = match outcome.status {
                Status::Met => true,
                Status::Unreachable => doubtful || is_pressed_harder,
                Status::Budget | Status::Cancelled => false,
            };
            self.status = match outcome.status {
                // What was not confirmed may be reached yet.
                Status::Unreachable if is_whole => Status::Unreachable,
                Status::Budget if is_beyond_reach => Status::Unreachable,
                Status::Unreachable | Status::Met | Status::Budget | Status::Cancelled => Status::Budget,
            };
            is_beyond_reach = self.status == Status::Unreachable && !doubtful;
            // Where the model was corrected by this design's run before, it is exact already.
            if !again || was_exact {
                break;
            }
            // What a further search could reach is not known where none can be paid.
            if self.may_search_again() && !self.goes_on(design) && !is_beyond_reach {
                self.status = Status::Budget;
            }
        }
        Ok(())
    }

    /// Ends where the seconds did not suffice for a search: with what is kept, and before that with the design that waits, in time.
    pub(super) fn end_without_search(&mut self, design: &DesignTask, timings: &mut Timings) -> Result<(), DesignError> {
        self.status = Status::Budget;
        if self.kept.is_none()
            && self.take_the_waiting(design, f64::INFINITY)
            && let Some(pattern) = self.round.best.as_ref().map(|best| best.design)
        {
            self.confirm(design, &pattern, None, timings)?;
            self.keep_round(design, true, false);
        }
        Ok(())
    }

    /// What is known without time of the design to run next, which is the round's best after it; it breaks off where a further search comes
    /// first. `status` is that of the search that found the best design, and `is_known` says whether that was run last.
    fn next_run(
        &mut self,
        design: &DesignTask,
        status: Status,
        is_known: bool,
        timings: &mut Timings,
    ) -> Result<ControlFlow<(), Option<WithoutTime>>, DesignError> {
        let has_searched = matches!(status, Status::Met | Status::Unreachable);
        let solved = if has_searched && !is_known { self.without_time(design, timings)? } else { None };
        let expected = solved.as_ref().and_then(|solved| self.expected(design, solved));
        if let Some(expected) = expected.as_ref()
            && self.is_searched_again(design, status, expected)
        {
            self.wait(expected.merit);
            return Ok(ControlFlow::Break(()));
        }
        // One that waits may be nearer than what misses, or than what a search found before it was cut short.
        let missed_by = match expected {
            Some(expected) => Some(expected.merit).filter(|_| expected.misfit > 1.0),
            None => self.round.best.as_ref().map(|best| best.misfit.merit).filter(|_| !has_searched),
        };
        let is_other = missed_by.is_some_and(|merit| self.take_the_waiting(design, merit));
        Ok(ControlFlow::Continue(solved.filter(|_| !is_other)))
    }

    /// Whether `pattern` waits.
    pub(super) fn waits(&self, pattern: &Pattern) -> bool {
        self.waiting
            .as_ref()
            .and_then(|waiting| waiting.round.best.as_ref())
            .is_some_and(|best| best.design == *pattern)
    }

    /// The best design waits, of which `merit` is expected in time, unless one that is expected nearer does.
    pub(super) fn wait(&mut self, merit: f64) {
        if self.waiting.as_ref().is_none_or(|waiting| merit < waiting.merit) {
            self.waiting = Some(Waiting { merit, round: self.round.clone() });
        }
    }

    /// Takes the design that waits in the place of the best one, of which `merit` is expected, where it is expected nearer and keeps limits as
    /// well.
    pub(super) fn take_the_waiting(&mut self, design: &DesignTask, merit: f64) -> bool {
        let excess = |round: &Round| round.best.as_ref().map_or(f64::INFINITY, Candidate::excess);
        let is_nearer = |waiting: &mut Waiting| waiting.merit < merit && excess(&waiting.round) <= excess(&self.round);
        let Some(Waiting { round, .. }) = self.waiting.take_if(is_nearer) else { return false };
        let best = round.best.as_ref().map(|best| self.model.judged(design, best));
        // What can be reached is known best by the last search.
        let Round { confirming, reachable, searched, .. } = std::mem::take(&mut self.round);
        self.round = Round { best, confirming, reachable, searched, ..round };
        true
    }

    /// Keeps every answer in `cache`, and begins with those that it holds.
    pub(super) fn keep_answers(
        &mut self,
        design: &DesignTask,
        cache: &'a mut dyn EvaluationCache,
    ) -> Result<(), DesignError> {
        let asked = self.model.asked();
        let slopes = self.model.learned().map(|learned| (learned.follows_the_modulus(), &design.specimen));
        let key = cache_key(asked, design.space.texture(), &design.directions.different_deg, slopes);
        let place = cache.place();
        let (evaluations, known) = Evaluations::cached(cache, &key, asked.loads.len())?;
        if known > 0 {
            self.monitor.note(&format!("took over {known} answers from {place}"));
        }
        self.model.keep(Limited::of(design, &self.model), evaluations);
        Ok(())
    }

    /// A stage that may take all the time that is left.
    pub(super) fn stage(&self, name: &str) -> Stage<'a> {
        self.budget.stage(name)
    }

    /// How designs were searched in space, and at which speed they were run, beside what the confirming run says of itself.
    pub(super) fn describe(&self, said: &mut Statements) {
        let (asked, run) = (self.scene.speed_m_s, self.scene.clone().slowed().speed_m_s);
        let slowed = (run < asked).then(|| {
            let [asked, run] = [asked, run].map(|speed_m_s| tidy(SPEED_MM_S.from_si(speed_m_s)));
            format!(
                "in time at {run:.3} mm/s in place of {asked} mm/s, faster than which the modelled layer slides in waves, v = 0.01 P / sqrt(E rho): \
                 the coefficients are those at {asked} mm/s, and the ratio is known to about 0.01"
            )
        });
        said.model.extend(slowed.into_iter().chain(self.taken_back.clone()));
        if self.model.dimension().takes_strips() {
            return;
        }
        let um = |length_m: f64| tidy(LENGTH_UM.from_si(length_m));
        let block_um = um(self.scene.layer.block_m);
        said.method(match self.model.guide() {
            Some((_, guide_m)) => format!(
                "searched in space: steady cells in blocks of {block_um} um judged {} designs; cells in blocks of {} um, corrected by these, found them among {}",
                self.solid_evaluations,
                um(guide_m),
                self.evaluations,
            ),
            None => format!("searched in space: steady cells in blocks of {block_um} um"),
        });
        if self.round.confirming.extent != Extent::Strip {
            said.model("confirmed in time on one cell in space, taken for the specimen in proportion to its cavities; strip = true in [search] confirms on the row of cavities through the specimen's middle, with both ends, which takes minutes");
        }
    }

    /// Corrects the model at the confirmed design; returns the largest change of the target's quantity.
    pub(super) fn correct(&mut self, design: &DesignTask) -> f64 {
        self.learn_peaks(design);
        let confirmed = self.confirmed_each();
        let Some(best) = &self.round.best else { return 0.0 };
        self.corrected_at = Some(best.design);
        self.missed = self.model.correct(&best.design, &best.response.value, &confirmed);
        self.missed
    }

    pub(super) fn search(&mut self, design: &DesignTask, timings: &mut Timings) -> Result<SearchOutcome, DesignError> {
        let options = SearchOptions { seed: design.seed, max_evaluations: design.max_evaluations - self.evaluations };
        let bar = self.budget.stage_of_share("search", SEARCH_SHARE);
        let (target, space, constraints) = (&design.target, &design.space, &design.constraints);
        let outcome = match self.model.guide() {
            None => search(target, space, constraints, &options, &self.model, &bar),
            Some((guide, _)) => {
                let correction = &mut self.correction;
                search_multi_fidelity(target, space, constraints, &options, &self.model, &guide, correction, &bar)
            }
        };
        let outcome = outcome.and_then(|found| robust_search::choose(design, &self.model, &options, found, &bar));
        let out_of_time = bar.is_out_of_time();
        timings.search += bar.finish();
        self.monitor.heed()?;
        let failed = |error: SearchError| match error {
            SearchError::EveryTrialFailed { .. } | SearchError::CancelledAtStart if out_of_time => {
                DesignError::OutOfTime(format!("the seconds allowed were spent before a design was found: {error}"))
            }
            SearchError::EveryTrialFailed { .. } | SearchError::BrokenModel { .. } | SearchError::CancelledAtStart => {
                DesignError::Failed(error.to_string())
            }
            _ => DesignError::refused(error.to_string()),
        };
        if out_of_time {
            self.out_of_time = true;
            self.cut("search");
        }
        let (outcome, choice) = outcome.map_err(failed)?;
        self.rounds += 1;
        self.history.extend(outcome.history.iter().map(|point| ImprovementReport {
            round: self.rounds,
            evaluation: point.evaluation,
            misfit: point.misfit.max,
            feasible: point.feasible,
        }));
        self.round.choice = choice;
        let outcome = self.choose(design, outcome, timings).map_err(failed)?;
        self.monitor.heed()?;
        self.evaluations += outcome.evaluations.max(outcome.guide_evaluations);
        if !self.model.is_cheap_per_design() {
            self.solid_evaluations += outcome.evaluations;
        }
        self.failed_trials += outcome.failed_trials.len();
        self.round.alternatives = outcome.alternatives.iter().map(|candidate| candidate.design).collect();
        self.round.reachable.clone_from(&outcome.reachable);
        self.round.searched = outcome.evaluations;
        Ok(outcome)
    }

    /// Notes that the seconds allowed did not suffice for `stage`.
    pub(super) fn cut(&mut self, stage: &'static str) {
        if !self.cut_short.contains(&stage) {
            self.cut_short.push(stage);
        }
    }

    /// Largest distance of the confirming runs from the target, at all conditions, in tolerances; `None` where one has no
    /// value at some pressure.
    pub(super) fn confirmed_misfit(&self, design: &DesignTask) -> Option<f64> {
        Some(design.target.misfit(&self.confirmed_values()?).max)
    }

    /// The target's quantity by the confirming runs, at each pressure of each condition; `None` where one has no value at
    /// some pressure.
    pub(super) fn confirmed_values(&self) -> Option<Vec<f64>> {
        self.confirmed_each().into_iter().collect::<Option<Vec<f64>>>().filter(|values| !values.is_empty())
    }

    /// Whether the confirming runs of the best design are on target, and within the limit of the largest pressure.
    pub(super) fn is_confirmed(&self, design: &DesignTask) -> bool {
        let is_near = |values: Vec<f64>| design.target.misfit(&values).max <= 1.0;
        self.confirmed_values().is_some_and(is_near) && !self.breaks_in_time(design)
    }
}
