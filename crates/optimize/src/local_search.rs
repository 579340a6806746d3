//! Descent from one design.
//!
//! The simplex method knows no bounds: it moves in u, and the share t of a length's logarithm is
//!
//!   t = (1 - cos(pi u)) / 2,
//!
//! smooth, within [0, 1] for every u, and stationary at the bounds, so that a minimum on a bound is
//! an ordinary minimum in u.

use crate::evaluation_archive::{LocalArchive, Record};
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::space::Grid;
use crate::{COMFORTABLE_RMS, Candidate, gauss_newton, nelder_mead, sequential_linear_programming};
use slipgrid_pattern::Pattern;
use std::f64::consts::PI;

/// Edge of the first simplex in u: about the spacing of the sample, so that the descent neither
/// repeats the sample nor leaves its own valley.
const FIRST_EDGE: f64 = 0.12;
/// A restarted simplex is this much smaller than the one before.
const RESTART_SHRINK: f64 = 0.5;
/// The simplex has collapsed when its costs, in tolerances, scatter less than this: a hundredth of
/// what would matter to anybody, well above a model's own noise of 1e-4 of a ratio at tolerance 0.01.
const COLLAPSED_STD: f64 = 2e-3;
/// The simplex has stalled when this many calls for each free dimension brought less than
/// [`STALLED_GAIN`] tolerances: on a constraint, where the grid's steps scatter the penalty, or between
/// designs that the model cannot compute, its costs need never agree. Fewer calls end slow descents too soon.
const STALLED_CALLS: usize = 8;
const STALLED_GAIN: f64 = 0.01;
/// A restart that gains less than this share of the misfit, or than [`COMFORTABLE_RMS`], is the last.
const WORTHWHILE_GAIN: f64 = 0.02;
/// The same for a lowest or highest value, in tolerances.
const WORTHWHILE_EXTENSION: f64 = 0.1;
/// Cost of a design that the model cannot compute: worse than any other.
const FAILED_COST: f64 = 1e12;

/// What a descent minimizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Objective {
    /// The target's own: root-mean-square misfit, or its goal.
    Target,
    /// Largest misfit.
    Largest,
    /// The value at one target point, in tolerances.
    Lowest(usize),
    /// Its negative.
    Highest(usize),
}

/// An objective, and what constraints cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cost {
    pub(crate) objective: Objective,
    /// Change of a value that counts as 1 in a lowest or highest value.
    pub(crate) tolerance: f64,
    /// Cost of the target's own objective with which nothing is left to gain.
    pub(crate) comfortable: f64,
    /// Cost of a relative excess of 1. An exact penalty: above the objective's own slope, so that the
    /// minimum lies on the constraint and not beyond it.
    pub(crate) penalty: f64,
}

impl Cost {
    /// Cost of a design, in tolerances.
    pub(crate) fn of(&self, candidate: &Candidate) -> f64 {
        let objective = match self.objective {
            Objective::Target => candidate.misfit.cost,
            Objective::Largest => candidate.misfit.max,
            Objective::Lowest(point) => candidate.response.value[point] / self.tolerance,
            Objective::Highest(point) => -candidate.response.value[point] / self.tolerance,
        };
        objective + self.penalty * candidate.excess()
    }

    /// Cost below which a descent ends early.
    pub(crate) fn comfortable(&self) -> f64 {
        match self.objective {
            Objective::Target => self.comfortable,
            // Within the tolerance is all that is asked.
            Objective::Largest => 0.9,
            Objective::Lowest(_) | Objective::Highest(_) => f64::NEG_INFINITY,
        }
    }

    /// Gain below which a restart from `cost` was the last.
    fn worthwhile_gain(&self, cost: f64) -> f64 {
        match self.objective {
            // A goal's cost may be negative.
            Objective::Target | Objective::Largest => (WORTHWHILE_GAIN * cost.min(1.0)).max(COMFORTABLE_RMS),
            Objective::Lowest(_) | Objective::Highest(_) => WORTHWHILE_EXTENSION,
        }
    }
}

/// How a descent goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Few evaluations where the response is smooth; the target's own objective, where that is a root mean square.
    GaussNewton,
    /// Few evaluations; a goal.
    LinearSteps,
    /// Restarted simplex: any objective, kinks, noise.
    Simplex,
}

/// A descent still to be made or continued.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent {
    pub(crate) grid: Grid,
    pub(crate) start: Pattern,
    pub(crate) cost: Cost,
    method: Method,
    edge: f64,
    collapsed_std: f64,
}

impl Descent {
    pub(crate) const fn new(grid: Grid, start: Pattern, cost: Cost, method: Method) -> Self {
        Self { grid, start, cost, method, edge: FIRST_EDGE, collapsed_std: COLLAPSED_STD }
    }

    /// The same with a first simplex `edge` times as large, collapsed at `collapsed` times the scatter.
    pub(crate) const fn with_simplex(mut self, edge: f64, collapsed: f64) -> Self {
        self.edge *= edge;
        self.collapsed_std *= collapsed;
        self
    }

    /// Descends until nothing is gained; `None`, or, where the local archive was interrupted, the descent
    /// that would continue this one.
    pub(crate) fn run(mut self, local: &mut LocalArchive<'_>) -> Option<Self> {
        match self.method {
            Method::GaussNewton | Method::LinearSteps => {
                let descend = if self.method == Method::GaussNewton {
                    gauss_newton::descend
                } else {
                    sequential_linear_programming::descend
                };
                let end = descend(&self.grid, &self.start, &self.cost, local);
                self.start = end.unwrap_or(self.start);
                local.interruption.is_some().then_some(self)
            }
            Method::Simplex => self.restarted_simplex(local),
        }
    }

    fn restarted_simplex(mut self, local: &mut LocalArchive<'_>) -> Option<Self> {
        let free = self.grid.free_axes();
        let mut least = FAILED_COST;
        loop {
            let (best, cost) = self.simplex(&free, local);
            if let Some(best) = best {
                self.start = best;
            }
            if local.interruption.is_some() {
                return Some(self);
            }
            let gain = least - cost;
            if free.is_empty() || cost <= self.cost.comfortable() || gain < self.cost.worthwhile_gain(cost) {
                return None;
            }
            least = cost;
            self.edge *= RESTART_SHRINK;
        }
    }

    /// One run of the simplex: the best design it saw, and its cost.
    fn simplex(&self, free: &[usize], local: &mut LocalArchive<'_>) -> (Option<Pattern>, f64) {
        let shares = self.grid.shares(&self.start);
        // u = acos(1 - 2 t) / pi
        let start: Vec<f64> =
            free.iter().map(|&axis| (1.0 - 2.0 * shares[axis]).clamp(-1.0, 1.0).acos() / PI).collect();
        let place = Place { grid: self.grid, free, shares };
        let mut simplex = vec![start.clone()];
        simplex.extend((0..free.len()).map(|coordinate| place.other_vertex(&start, coordinate, self.edge)));
        let mut visit = Visit { local, best: None, calls: 0, landmark: (f64::INFINITY, 0) };
        let ends = (self.collapsed_std, self.cost.comfortable());
        // An interruption or a stall ends the descent; what was seen before it stands in `visit`.
        let _ = nelder_mead::descend(simplex, ends, |u| visit.cost(&self.cost, free.len(), place.design(u)));
        visit.best.map_or((None, FAILED_COST), |(design, cost)| (Some(design), cost))
    }
}

/// What a descent by the simplex method has seen.
struct Visit<'a, 'b> {
    local: &'a mut LocalArchive<'b>,
    best: Option<(Pattern, f64)>,
    calls: usize,
    /// Cost at the last gain worth the name, and the call that brought it.
    landmark: (f64, usize),
}

impl Visit<'_, '_> {
    /// Cost of a design of `free` free dimensions, unless the descent has stalled or is interrupted.
    fn cost(&mut self, cost: &Cost, free: usize, design: Option<Pattern>) -> Option<f64> {
        self.calls += 1;
        if self.calls > free + 1 && self.calls > self.landmark.1 + STALLED_CALLS * free {
            return None;
        }
        let Some(design) = design else { return Some(FAILED_COST) };
        let Record::Computed(candidate) = self.local.look(&design)? else { return Some(FAILED_COST) };
        let cost = cost.of(candidate);
        if self.best.is_none_or(|(_, least)| cost < least) {
            self.best = Some((design, cost));
        }
        if cost < self.landmark.0 - STALLED_GAIN {
            self.landmark = (cost, self.calls);
        }
        Some(cost)
    }
}

/// Where the simplex stands among designs.
struct Place<'a> {
    grid: Grid,
    free: &'a [usize],
    /// Of the dimensions that are not free.
    shares: [f64; MOST_DIMENSIONS],
}

impl Place<'_> {
    fn design(&self, u: &[f64]) -> Option<Pattern> {
        let mut shares = self.shares;
        for (&axis, &u) in self.free.iter().zip(u) {
            // t = (1 - cos(pi u)) / 2
            shares[axis] = 0.5 * (1.0 - (PI * u).cos());
        }
        self.grid.design(&shares)
    }

    /// `start` with one coordinate moved inwards by `edge`, or by as many edges as another grid
    /// value takes.
    fn other_vertex(&self, start: &[f64], coordinate: usize, edge: f64) -> Vec<f64> {
        let mut vertex = start.to_vec();
        let inwards = if start[coordinate] <= 0.5 { edge } else { -edge };
        let here = self.design(start);
        for _ in 0..((1.0 / edge) as usize) {
            vertex[coordinate] += inwards;
            if self.design(&vertex) != here {
                break;
            }
        }
        vertex
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation_archive::{Archive, Evaluator, Interruption};
    use crate::{Constraints, DesignSpace, ModelFailure, Quantity, Response, Target, TargetPoint};
    use slipgrid_monitor::Unwatched;
    use slipgrid_pattern::Planform;

    /// Descends on value = section density, wanted 0.3 within 0.01, over width and spacing. Widths above
    /// 300 um fail. Returns the best design, the evaluations, and what interrupted them.
    fn descend(objective: Objective, budget: usize) -> (Pattern, usize, Option<Interruption>) {
        let model = |design: &Pattern| match design.width_m() {
            width_m if width_m > 300e-6 => Err(ModelFailure::Trial { reason: "too wide".to_owned() }),
            _ => Ok(Response { value: vec![design.section_density()], limited: Vec::new() }),
        };
        let point = TargetPoint { pressure_pa: 1e6, value: 0.3 };
        let target = Target::new(Quantity::Ratio, vec![point], 0.01).unwrap();
        let constraints = Constraints::default();
        let space = DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [50e-6, 900e-6], [5e-6; 2]).unwrap();
        let grid = Grid::new(&space, &constraints).unwrap();
        let evaluator = Evaluator::new(&model, &target, &constraints, budget, &Unwatched);
        let mut archive = Archive::default();
        let mut local = LocalArchive::new(&evaluator, &archive, budget);
        let cost = Cost { objective, tolerance: 0.01, comfortable: COMFORTABLE_RMS, penalty: 1.0 };
        let start = Pattern::new(Planform::Groove, 150e-6, 200e-6, 5e-6).unwrap();
        let rest = Descent::new(grid, start, cost, Method::Simplex).run(&mut local);
        let (records, interruption) = local.close();
        assert_eq!(rest.is_some(), interruption.is_some());
        archive.absorb(records);
        let cheapest = archive.candidates().min_by(|left, right| cost.of(left).total_cmp(&cost.of(right)));
        (cheapest.unwrap().design, archive.records().len(), interruption)
    }

    #[test]
    fn the_simplex_meets_a_target_and_stops_there() {
        let (best, evaluations, interruption) = descend(Objective::Target, 200);
        assert!((best.section_density() - 0.3).abs() <= 0.01 * COMFORTABLE_RMS);
        assert!(evaluations < 40 && interruption.is_none(), "{evaluations}");
    }

    #[test]
    fn the_simplex_finds_extremes_on_a_bound_and_beside_failed_trials() {
        let (lowest, evaluations, _) = descend(Objective::Lowest(0), 200);
        assert!(
            (lowest.section_density() - 40.0 / 940.0).abs() < 1e-3 && evaluations < 120,
            "{lowest:?} {evaluations}"
        );
        // Highest at width 300 um, where trials begin to fail, and spacing 50 um.
        let (highest, evaluations, _) = descend(Objective::Highest(0), 200);
        assert!((highest.section_density() - 300.0 / 350.0).abs() < 5e-3, "{highest:?}");
        assert!(evaluations < 160, "{evaluations}");
    }

    #[test]
    fn an_interrupted_descent_can_be_continued() {
        for budget in 1..20 {
            let (_, evaluations, interruption) = descend(Objective::Lowest(0), budget);
            assert_eq!((evaluations, interruption), (budget, Some(Interruption::Budget)));
        }
    }
}
