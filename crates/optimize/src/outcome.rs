//! What a search found.

use crate::{Constraints, Misfit, Response, Target, Violation};
use slipgrid_pattern::Pattern;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The best design does what is demanded at every pressure and respects every constraint. With a goal: and
    /// the search ended by itself, without a better one.
    Met,
    /// The search ended by itself without such a design: see [`SearchOutcome::reachable`].
    Unreachable,
    /// The evaluations allowed were spent before the search had ended.
    Budget,
    /// The search was asked to stop before it had met the target. What it had found is reported.
    Cancelled,
}

impl Status {
    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Unreachable => "unreachable",
            Self::Budget => "budget",
            Self::Cancelled => "cancelled",
        }
    }
}

/// A design with its predicted response. Lengths are those of the design that would be made, so the
/// prediction is its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The design.
    pub design: Pattern,
    /// What the model says of it.
    pub response: Response,
    /// Its distance from the target.
    pub misfit: Misfit,
    /// The constraints that it breaks; empty where it is feasible.
    pub violations: Vec<Violation>,
}

impl Candidate {
    /// `design` as `target` and `constraints` take what the model says of it.
    #[must_use]
    pub fn new(target: &Target, constraints: &Constraints, design: Pattern, response: Response) -> Self {
        let violations = constraints.violations(&design, &response);
        Self { design, misfit: target.misfit(&response.value), response, violations }
    }

    /// Accepted at every pressure, and feasible.
    #[must_use]
    pub fn meets_target(&self) -> bool {
        self.violations.is_empty() && self.misfit.is_met()
    }

    /// Sum of the relative excesses over broken constraints.
    #[must_use]
    pub fn excess(&self) -> f64 {
        self.violations.iter().map(Violation::excess).sum()
    }

    /// Whether this design is to be preferred: feasible ones first, then those that meet the target,
    /// then the smaller merit ([`Misfit::merit`]). Among designs that are not feasible, the smaller excess.
    #[must_use]
    pub fn is_better_than(&self, other: &Self) -> bool {
        match (self.violations.is_empty(), other.violations.is_empty()) {
            (true, false) => true,
            (false, true) => false,
            (false, false) => self.excess() < other.excess(),
            (true, true) => match (self.misfit.is_met(), other.misfit.is_met()) {
                (true, false) => true,
                (false, true) => false,
                _ => self.misfit.merit < other.misfit.merit,
            },
        }
    }
}

/// A design that the model could not compute.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedTrial {
    /// The design.
    pub design: Pattern,
    /// Why it failed.
    pub reason: String,
}

/// Lowest and highest value among feasible designs tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachableRange {
    /// Nominal pressure of the target point, in pascals.
    pub pressure_pa: f64,
    /// Lowest value.
    pub lowest: f64,
    /// Highest value.
    pub highest: f64,
    /// The design with the lowest value.
    pub lowest_design: Pattern,
    /// The design with the highest value.
    pub highest_design: Pattern,
}

/// The best design after a number of evaluations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryPoint {
    /// Evaluations up to and including the one that improved, in the search's own order.
    pub evaluation: usize,
    /// Misfit of the best design from here on.
    pub misfit: Misfit,
    /// Whether it respects the constraints.
    pub feasible: bool,
}

/// Result of a search. Equal inputs and seeds give equal outcomes at any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchOutcome {
    /// How the search ended.
    pub status: Status,
    /// The best design tried.
    pub best: Candidate,
    /// Other designs that meet the target, best first, each unlike the best and one another.
    pub alternatives: Vec<Candidate>,
    /// Distinct designs evaluated, failed trials included.
    pub evaluations: usize,
    /// Distinct designs of which a guide was asked; 0 in a search without one.
    pub guide_evaluations: usize,
    /// Designs that the model could not compute.
    pub failed_trials: Vec<FailedTrial>,
    /// Range of the value at each target pressure over all feasible designs tried; empty where none
    /// was feasible. Before a search ends as [`Status::Unreachable`] it looks for these extremes.
    pub reachable: Vec<ReachableRange>,
    /// Every design tried that meets the target, in the search's own order.
    pub meeting: Vec<Candidate>,
    /// Improvements of the best design.
    pub history: Vec<HistoryPoint>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bound, Limit};
    use slipgrid_pattern::Planform;

    fn candidate(max: f64, cost: f64, peak_pressure_pa: f64) -> Candidate {
        let bound = Bound::AtMost(10e6);
        let limit =
            Limit { name: "peak pressure", unit: "MPa", unit_si: 1e6, bound, scale: 10e6, loosest: f64::INFINITY };
        let constraints = Constraints { quantities: vec![limit], ..Constraints::default() };
        let design = Pattern::new(Planform::Groove, 1e-4, 3e-4, 1e-5).unwrap();
        let response = Response { value: vec![0.9], limited: vec![peak_pressure_pa] };
        let violations = constraints.violations(&design, &response);
        Candidate { design, response, misfit: Misfit { max, rms: cost, cost, merit: max }, violations }
    }

    #[test]
    fn feasible_then_met_then_nearest() {
        // Each is better than all that follow.
        let ranked = [
            candidate(0.9, 0.6, 1e6),
            candidate(1.0, 0.5, 1e6),
            candidate(1.1, 0.4, 1e6),
            candidate(9.0, 8.0, 1e6),
            candidate(0.5, 0.5, 11e6),
            candidate(0.1, 0.1, 12e6),
        ];
        for (rank, better) in ranked.iter().enumerate() {
            assert!(!better.is_better_than(better));
            for worse in &ranked[rank + 1..] {
                assert!(better.is_better_than(worse) && !worse.is_better_than(better));
            }
        }
        assert!((ranked[4].excess() - 0.1).abs() < 1e-12 && !ranked[4].meets_target());
    }
}
