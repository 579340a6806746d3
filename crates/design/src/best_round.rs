//! The best round of searches and confirming runs: what a later one found need not be nearer.

use slipgrid_optimize::{Candidate, ForwardModel, ReachableRange, Status};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{RunOptions, Simulation};

use crate::DesignError;
use crate::confirmed_peak::Broken;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::robust_search::RobustChoice;
use crate::selection::Chosen;
use crate::task::DesignTask;

/// What a round found, and what its confirming runs made of it.
#[derive(Clone, Debug, Default)]
pub struct Round {
    /// The best design; `None` before there is one.
    pub best: Option<Candidate>,
    /// What the model says of it at the condition designed for.
    pub predicted: Option<Simulation>,
    /// The confirming run there.
    pub confirmed: Option<Simulation>,
    /// Its largest local pressure in the cell at each load of each condition, in pascals; none where that is not limited.
    pub cell_peaks_pa: Vec<f64>,
    /// How it is confirmed.
    pub confirming: RunOptions,
    /// Other designs that the search found to meet the target.
    pub alternatives: Vec<Pattern>,
    /// What designs within bounds and limits reach.
    pub reachable: Vec<ReachableRange>,
    /// How many designs that is known of: those that the search's model itself was asked of.
    pub searched: usize,
    /// How the best design was chosen, where samples decided.
    pub choice: Option<RobustChoice>,
    /// What the best design was chosen from by its chance.
    pub selection: Option<Chosen>,
}

/// The best design of a round that had one, solved and confirmed.
#[derive(Clone, Copy, Debug)]
pub struct BestDesign<'a> {
    /// What the search found.
    pub found: &'a Candidate,
    /// What the model says of it at the condition designed for.
    pub predicted: &'a Simulation,
    /// The confirming run there.
    pub confirmed: &'a Simulation,
}

impl<'a> BestDesign<'a> {
    /// The design.
    pub(crate) const fn pattern(&self) -> Pattern {
        self.found.design
    }

    /// The target's quantity at each load, as the search took it.
    pub(crate) fn value(&self) -> &'a [f64] {
        &self.found.response.value
    }
}

impl Round {
    /// The best design.
    ///
    /// # Errors
    /// [`DesignError::Failed`] before there is one.
    pub(crate) fn best_design(&self) -> Result<BestDesign<'_>, DesignError> {
        let (Some(found), Some(predicted), Some(confirmed)) = (&self.best, &self.predicted, &self.confirmed) else {
            return Err(DesignError::Failed("the search ended without a design".to_owned()));
        };
        Ok(BestDesign { found, predicted, confirmed })
    }
}

/// The best round so far.
#[derive(Clone, Debug)]
pub struct KeptRound {
    /// Which it was, from 1.
    number: usize,
    round: Round,
    /// Its confirming runs at the other conditions.
    further: Vec<Option<Simulation>>,
    standing: Standing,
    /// A design of its on target is what was asked for: its search and its confirming runs ended by themselves.
    is_whole: bool,
    /// What it has over each later round, with the numbers of these.
    over: Vec<(usize, Advantage)>,
}

/// What a round has over a later one in whose place it is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advantage {
    /// It breaks limits by less.
    Limits,
    /// It alone is confirmed on target.
    OnTarget,
    /// It is better by its confirming runs.
    Better,
    /// Its confirming runs alone gave values.
    Confirmed,
    /// The later search was cut short, and found nothing better as far as the model says.
    Cut,
}

impl Advantage {
    /// What is to be said of the later search.
    const fn words(self) -> &'static str {
        match self {
            Self::Limits => "breaks limits by more",
            Self::OnTarget => "is not confirmed on target",
            Self::Better => "is worse by its confirming runs",
            Self::Confirmed => "has no confirmed value",
            Self::Cut => "is no better by the model, its search cut short",
        }
    }
}

/// What rounds are compared by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Sum of the relative excesses over broken constraints; 0 where none is.
    excess: f64,
    /// On target by the confirming runs.
    is_on_target: bool,
    /// What the confirming runs miss by, as the search ranks; `None` where they gave no value.
    confirmed: Option<f64>,
    /// What the search's model missed by.
    predicted: f64,
    /// The search was cut short.
    is_cut: bool,
}

impl Standing {
    /// What a round that stands so has over a later one, where it is kept in its place: the one that respects every limit, then the one
    /// confirmed on target, then the one nearer by its confirming runs. Without these the later is kept, whose model knows more, unless
    /// its search was cut short of what the earlier had found.
    fn over(&self, later: &Self) -> Option<Advantage> {
        let (stays, by) = if self.excess != later.excess {
            (self.excess < later.excess, Advantage::Limits)
        } else if self.is_on_target != later.is_on_target {
            (self.is_on_target, Advantage::OnTarget)
        } else {
            match (self.confirmed, later.confirmed) {
                (Some(own), Some(later)) => (own < later, Advantage::Better),
                (None, None) => (later.is_cut && self.predicted < later.predicted, Advantage::Cut),
                (own, _) => (own.is_some(), Advantage::Confirmed),
            }
        };
        stays.then_some(by)
    }
}

impl MultiFidelityLoop<'_> {
    /// How the round that has just ended stands; `is_cut` says whether its search was cut short. `None` before there is a design.
    fn standing(&self, design: &DesignTask, is_cut: bool) -> Option<Standing> {
        let best = self.round.best.as_ref()?;
        let broken = self.broken(design);
        Some(Standing {
            excess: broken.iter().map(Broken::excess).sum(),
            is_on_target: broken.is_empty() && self.is_confirmed(design),
            confirmed: self.confirmed_values().map(|values| design.target.misfit(&values).merit),
            predicted: best.misfit.merit,
            is_cut,
        })
    }

    /// Keeps the round that has just ended, unless the one kept before is better. `is_cut` says whether its search was cut short, and
    /// `is_whole` whether its design is what was asked for where it is on target.
    pub(super) fn keep_round(&mut self, design: &DesignTask, is_cut: bool, is_whole: bool) {
        let Some(standing) = self.standing(design, is_cut) else { return };
        if let Some(by) = self.kept.as_ref().and_then(|kept| kept.standing.over(&standing)) {
            return self.note_worse(by);
        }
        self.kept = Some(KeptRound {
            number: self.rounds,
            round: self.round.clone(),
            further: self.further.iter().map(|at| at.confirmed.clone()).collect(),
            standing,
            is_whole,
            over: Vec::new(),
        });
    }

    /// Notes what the round kept has over the last one.
    pub(super) fn note_worse(&mut self, by: Advantage) {
        let last = self.rounds;
        self.kept.iter_mut().for_each(|kept| kept.over.push((last, by)));
    }

    /// Whether a search that was cut short found something better than what is kept, as far as the model says: otherwise it is not worth
    /// a confirming run.
    pub(super) fn may_beat_the_kept(&self, found: &Candidate) -> bool {
        let Some(kept) = &self.kept else { return true };
        let known = kept.standing.confirmed.unwrap_or(kept.standing.predicted);
        found.excess() < kept.standing.excess || (found.excess() == kept.standing.excess && found.misfit.merit < known)
    }

    /// Goes back to the round kept, where a later one was worse, and corrects the model by its confirming run.
    pub(super) fn take_the_kept(&mut self, design: &DesignTask) {
        let Some(kept) = self.kept.take().filter(|kept| kept.number != self.rounds) else { return };
        let last = std::mem::replace(&mut self.round, kept.round);
        self.further.iter_mut().zip(kept.further).for_each(|(at, run)| at.confirmed = run);
        let later = kept.over.iter().map(|(number, by)| format!("what search {number} found {}", by.words()));
        let later: Vec<String> = later.collect();
        self.taken_back =
            Some(format!("the design of search {} of {}: {}", kept.number, self.rounds, later.join("; ")));
        let is_unreachable = self.status == Status::Unreachable;
        if kept.standing.is_on_target && (kept.is_whole || is_unreachable) {
            self.status = if kept.is_whole { Status::Met } else { Status::Budget };
        } else if is_unreachable {
            // The last search says so, and by its model alone nothing within the ranges meets the target.
            (self.round.reachable, self.round.alternatives) = (last.reachable, last.alternatives);
        }
        let Some(pattern) = self.round.best.as_ref().map(|best| best.design) else { return };
        if let Ok(now) = self.model.respond(&pattern) {
            let confirmed = self.confirmed_each();
            self.model.correct(&pattern, &now.value, &confirmed);
            self.learn_peaks(design);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::next_trial::tests::task;
    use crate::time_budget::TimeBudget;
    use crate::timings::Timings;
    use crate::{NoCache, Unwatched, run};
    use slipgrid_optimize::{Quantity, Target, TargetPoint, least_evaluations};
    use slipgrid_pattern::Planform;
    use slipgrid_springblock::Layer;

    fn standing(excess: f64, is_on_target: bool, confirmed: Option<f64>) -> Standing {
        Standing { excess, is_on_target, confirmed, predicted: 1.0, is_cut: false }
    }

    #[test]
    fn limits_then_the_target_then_the_confirmed_misfit_decide() {
        // Each is better than all that follow.
        let ranked = [
            standing(0.0, true, Some(0.9)),
            standing(0.0, false, Some(0.8)),
            standing(0.0, false, Some(1.3)),
            standing(0.0, false, None),
            standing(0.1, true, Some(0.1)),
        ];
        for (place, own) in ranked.iter().enumerate() {
            // Of equals the later, which knows more.
            assert_eq!(own.over(own), None);
            for other in &ranked[place + 1..] {
                assert!(own.over(other).is_some() && other.over(own).is_none());
            }
        }
    }

    #[test]
    fn a_search_cut_short_takes_nothing_back_that_was_found_before() {
        let whole = Standing { predicted: 1.0, ..standing(0.0, false, None) };
        let cut = Standing { predicted: 3.0, is_cut: true, ..whole };
        assert_eq!(whole.over(&cut), Some(Advantage::Cut));
        assert_eq!(whole.over(&Standing { is_cut: false, ..cut }), None);
    }

    #[test]
    fn what_is_out_of_reach_stands_beside_the_ranges_that_say_so() {
        let design = task(Planform::Groove);
        let material = design.material.clone().unwrap().material;
        let loads = design.loads(&material).unwrap().0;
        let pattern = Pattern::new(Planform::Groove, 120e-6, 300e-6, 15e-6).unwrap();
        let taken_back = |is_on_target, is_whole| {
            let budget = TimeBudget::new(&Unwatched, None);
            let (loads, timings) = (loads.clone(), &mut Timings::default());
            let new = MultiFidelityLoop::new(&design, &material, loads, Vec::new(), budget, &Unwatched, timings);
            let mut found = new.unwrap();
            let response = found.model.respond(&pattern).unwrap();
            let misfit = design.target.misfit(&response.value);
            let best = Some(Candidate { design: pattern, response, misfit, violations: Vec::new() });
            let range = |lowest| ReachableRange {
                pressure_pa: 0.65e6,
                lowest,
                lowest_design: pattern,
                highest: 1.0,
                highest_design: pattern,
            };
            // The first search saw the target within what is reached, and the second, which knows more, does not.
            let of = |lowest| Round { best: best.clone(), reachable: vec![range(lowest)], ..Round::default() };
            (found.status, found.rounds, found.round) = (Status::Unreachable, 2, of(0.95));
            found.kept = Some(KeptRound {
                number: 1,
                round: of(0.85),
                further: Vec::new(),
                standing: standing(0.0, is_on_target, Some(1.1)),
                is_whole,
                over: Vec::new(),
            });
            found.note_worse(Advantage::Limits);
            found.take_the_kept(&design);
            (found.status, found.round.reachable[0].lowest, found.taken_back.unwrap())
        };
        let said = "the design of search 1 of 2: what search 2 found breaks limits by more".to_owned();
        assert_eq!(taken_back(false, true), (Status::Unreachable, 0.95, said.clone()));
        assert_eq!(taken_back(true, true), (Status::Met, 0.85, said.clone()));
        // Of a goal more may be reached than what was confirmed before its search was cut short.
        assert_eq!(taken_back(true, false), (Status::Budget, 0.85, said));
    }

    #[test]
    fn a_design_that_waits_is_run_in_place_of_one_that_is_expected_to_miss_by_more() {
        let design = task(Planform::Groove);
        let material = design.material.clone().unwrap().material;
        let loads = design.loads(&material).unwrap().0;
        let (budget, timings) = (TimeBudget::new(&Unwatched, None), &mut Timings::default());
        let new = MultiFidelityLoop::new(&design, &material, loads, Vec::new(), budget, &Unwatched, timings);
        let mut found = new.unwrap();
        let [first, second, third] = [120e-6, 130e-6, 140e-6].map(|width_m| {
            let pattern = Pattern::new(Planform::Groove, width_m, 300e-6, 15e-6).unwrap();
            let response = found.model.respond(&pattern).unwrap();
            let misfit = design.target.misfit(&response.value);
            Candidate { design: pattern, response, misfit, violations: Vec::new() }
        });
        let best = |found: &MultiFidelityLoop<'_>| found.round.best.as_ref().unwrap().design;
        found.round = Round { best: Some(first.clone()), searched: 10, ..Round::default() };
        found.wait(1.4);
        // What is expected to miss by more does not take its place.
        found.round = Round { best: Some(second.clone()), searched: 20, ..Round::default() };
        found.wait(1.6);
        assert!(found.waits(&first.design) && !found.waits(&second.design));
        found.round = Round { best: Some(third.clone()), searched: 30, ..Round::default() };
        assert!(!found.take_the_waiting(&design, 1.2) && best(&found) == third.design);
        assert!(found.take_the_waiting(&design, 1.5) && best(&found) == first.design);
        // What can be reached is known by the last search, and nothing waits any more.
        assert!(found.round.searched == 30 && !found.waits(&first.design) && !found.take_the_waiting(&design, 9.0));
    }

    #[test]
    fn a_design_that_waits_is_run_where_no_second_is_left_to_search() {
        let mut design = task(Planform::Groove);
        design.specimen.outline = slipgrid_export::Outline::Disc { diameter_m: 2e-3 };
        design.layer = Layer { length_m: 2e-3, height_m: 60e-6, block_m: 20e-6, thickness_m: None };
        let material = design.material.clone().unwrap().material;
        let loads = design.loads(&material).unwrap().0;
        let (budget, timings) = (TimeBudget::new(&Unwatched, None), &mut Timings::default());
        let new = MultiFidelityLoop::new(&design, &material, loads, Vec::new(), budget, &Unwatched, timings);
        let mut found = new.unwrap();
        let pattern = Pattern::new(Planform::Groove, 120e-6, 300e-6, 15e-6).unwrap();
        let response = found.model.respond(&pattern).unwrap();
        let best = Candidate {
            design: pattern,
            misfit: design.target.misfit(&response.value),
            response,
            violations: Vec::new(),
        };
        found.round = Round { best: Some(best), confirming: found.scene.run, ..Round::default() };
        found.wait(1.4);
        found.end_without_search(&design, timings).unwrap();
        assert_eq!((found.runs, found.status, found.round.best.as_ref().unwrap().design), (1, Status::Budget, pattern));
        assert!(found.kept.is_some() && found.confirmed_values().is_some() && !found.waits(&pattern));
    }

    /// A target that the model meets and runs in time miss, so that searches follow one another.
    fn searched(most: usize, threads: usize) -> crate::DesignReport {
        let mut task = task(Planform::Groove);
        let point = TargetPoint { pressure_pa: 2.6e6, value: 0.9 };
        task.target = Target::new(Quantity::Ratio, vec![point], 1e-4).unwrap();
        task.specimen.outline = slipgrid_export::Outline::Disc { diameter_m: 2e-3 };
        task.layer = Layer { length_m: 2e-3, height_m: 60e-6, block_m: 20e-6, thickness_m: None };
        task.max_evaluations = most;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut report = pool.install(|| run(&task, &mut NoCache, &Unwatched)).unwrap().report;
        (report.timings_s, report.wall_s, report.threads) = Default::default();
        report
    }

    #[test]
    fn designs_off_target_without_time_are_not_run_in_time() {
        let found = searched(4000, 2);
        assert!(found.runs > 1 && found.rounds > found.runs, "{} {}", found.rounds, found.runs);
        // What is reported was run in time, whatever was known before.
        let confirmed = &found.confirmed[0];
        assert!(confirmed.ratio_time_change.is_some() && confirmed.steps.is_some());
        assert_eq!(found, searched(4000, 1));
    }

    #[test]
    fn a_search_that_is_cut_short_takes_nothing_back_and_none_begins_without_its_sample() {
        let missed = |report: &crate::DesignReport| report.misfit.confirmed.unwrap();
        let grooves = task(Planform::Groove);
        let least = least_evaluations(&grooves.space, &grooves.constraints).unwrap();
        // The fewest evaluations with which a second search begins: those of the first and its own sample.
        let (mut one, mut two) = (least, 3 * least);
        while two - one > 1 {
            let most = one.midpoint(two);
            if searched(most, 2).rounds == 1 { one = most } else { two = most }
        }
        let (first, cut) = (searched(one, 2), searched(two, 2));
        assert_eq!((first.rounds, cut.rounds, first.evaluations + least), (1, 2, two));
        // Of two designs the one that is expected nearer is run: what time adds differs between them by some thousandths, at most.
        assert!(missed(&first) > 1.0 && missed(&cut) <= missed(&first) + 30.0, "{} {}", missed(&cut), missed(&first));
        assert_eq!(cut, searched(two, 1));
    }
}
