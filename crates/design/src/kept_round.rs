//! The best round of searches and confirming runs: what a later one found need not be nearer.

use slipgrid_optimize::{Candidate, ForwardModel, ReachableRange, Status};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{RunOptions, Simulation};

use crate::multi_fidelity::MultiFidelityLoop;
use crate::robust_search::RobustChoice;
use crate::selection::Chosen;
use crate::task::DesignTask;

/// What a round found, and what its confirming runs made of it.
#[derive(Clone, Debug)]
pub struct KeptRound {
    /// Which it was, from 1.
    number: usize,
    best: Candidate,
    predicted: Option<Simulation>,
    confirmed: Option<Simulation>,
    further: Vec<Option<Simulation>>,
    confirming: RunOptions,
    alternatives: Vec<Pattern>,
    reachable: Vec<ReachableRange>,
    choice: Option<RobustChoice>,
    selection: Option<Chosen>,
    standing: Standing,
    /// Its search and its confirming runs ended by themselves.
    is_whole: bool,
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
    /// Whether a round that stands so is kept in place of a later one: the one that respects every limit, then the one confirmed on
    /// target, then the one nearer by its confirming runs. Without these the later is kept, whose model knows more, unless its search was
    /// cut short of what the earlier had found.
    fn stays_before(&self, later: &Self) -> bool {
        if self.excess != later.excess {
            return self.excess < later.excess;
        }
        if self.is_on_target != later.is_on_target {
            return self.is_on_target;
        }
        match (self.confirmed, later.confirmed) {
            (Some(own), Some(later)) => own < later,
            (Some(_), None) => true,
            (None, Some(_)) => false,
            (None, None) => later.is_cut && self.predicted < later.predicted,
        }
    }
}

impl MultiFidelityLoop<'_> {
    /// How the round that has just ended stands; `is_cut` says whether its search was cut short. `None` before there is a design.
    fn standing(&self, design: &DesignTask, is_cut: bool) -> Option<Standing> {
        let best = self.best.as_ref()?;
        Some(Standing {
            excess: best.excess(),
            is_on_target: best.violations.is_empty() && self.is_confirmed(design),
            confirmed: self.confirmed_values().map(|values| design.target.misfit(&values).merit),
            predicted: best.misfit.merit,
            is_cut,
        })
    }

    /// Keeps the round that has just ended, unless the one kept before is better. `has_ended` says whether its search ended by itself.
    pub(super) fn keep_round(&mut self, design: &DesignTask, has_ended: bool, is_whole: bool) {
        let (Some(best), Some(standing)) = (self.best.clone(), self.standing(design, !has_ended)) else { return };
        if self.kept.as_ref().is_some_and(|kept| kept.standing.stays_before(&standing)) {
            return;
        }
        self.kept = Some(KeptRound {
            number: self.rounds,
            best,
            predicted: self.predicted.clone(),
            confirmed: self.confirmed.clone(),
            further: self.further.iter().map(|at| at.confirmed.clone()).collect(),
            confirming: self.confirming,
            alternatives: self.alternatives.clone(),
            reachable: self.reachable.clone(),
            choice: self.choice.clone(),
            selection: self.selection.clone(),
            standing,
            is_whole: has_ended && is_whole,
        });
    }

    /// Whether a search that was cut short found something better than what is kept, as far as the model says: otherwise it is not worth
    /// a confirming run.
    pub(super) fn may_beat_the_kept(&self, found: &Candidate) -> bool {
        let Some(kept) = &self.kept else { return true };
        let known = kept.standing.confirmed.unwrap_or(kept.standing.predicted);
        found.excess() < kept.standing.excess || (found.excess() == kept.standing.excess && found.misfit.merit < known)
    }

    /// Goes back to the round kept, where a later one was worse, and corrects the model by its confirming run.
    pub(super) fn take_the_kept(&mut self) {
        let Some(kept) = self.kept.take().filter(|kept| kept.number != self.rounds) else { return };
        self.best = Some(kept.best);
        self.predicted = kept.predicted;
        self.confirmed = kept.confirmed;
        self.further.iter_mut().zip(kept.further).for_each(|(at, run)| at.confirmed = run);
        self.confirming = kept.confirming;
        self.alternatives = kept.alternatives;
        self.reachable = kept.reachable;
        self.choice = kept.choice;
        self.selection = kept.selection;
        self.taken_back = Some(kept.number);
        if kept.standing.is_on_target && kept.is_whole {
            self.status = Status::Met;
        }
        let Some(pattern) = self.best.as_ref().map(|best| best.design) else { return };
        if let Ok(now) = self.model.respond(&pattern) {
            let confirmed = self.confirmed_each();
            self.missed = self.model.correct(&pattern, &now.value, &confirmed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::next_trial::tests::task;
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
            assert!(!own.stays_before(own));
            for other in &ranked[place + 1..] {
                assert!(own.stays_before(other) && !other.stays_before(own));
            }
        }
    }

    #[test]
    fn a_search_cut_short_takes_nothing_back_that_was_found_before() {
        let whole = Standing { predicted: 1.0, ..standing(0.0, false, None) };
        let cut = Standing { predicted: 3.0, is_cut: true, ..whole };
        assert!(whole.stays_before(&cut) && !whole.stays_before(&Standing { is_cut: false, ..cut }));
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
    fn a_search_that_is_cut_short_takes_nothing_back_and_none_begins_without_its_sample() {
        let missed = |report: &crate::DesignReport| report.misfit.confirmed.unwrap();
        let least = least_evaluations(&task(Planform::Groove).space);
        // The fewest evaluations with which a second search begins: those of the first and its own sample.
        let (mut one, mut two) = (least, 3 * least);
        while two - one > 1 {
            let most = one.midpoint(two);
            if searched(most, 2).rounds == 1 { one = most } else { two = most }
        }
        let (first, cut) = (searched(one, 2), searched(two, 2));
        assert_eq!((first.rounds, cut.rounds, first.evaluations + least), (1, 2, two));
        assert!(missed(&first) > 1.0 && missed(&cut) <= missed(&first), "{} {}", missed(&cut), missed(&first));
        assert_eq!(cut, searched(two, 1));
    }
}
