//! Why a target is out of reach: the search again, with each restriction relaxed.

use crate::{Candidate, Constraints, DesignSpace, SearchError, SearchOutcome, Status};

/// A design this near to a bound, relative to it, rests on it.
const AT_BOUND: f64 = 0.01;
/// Misfit up to which a relaxed limit is tightened again: the rest of the tolerance is left to what confirms the design.
const SUFFICIENT_MISFIT: f64 = 0.7;
/// A relaxation helps where it lowers the cost by this share, and by as much in tolerances.
const WORTHWHILE: f64 = 0.02;

/// One of the lengths of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Width of a cavity.
    Width,
    /// Gap between two cavities.
    Spacing,
    /// Depth of a cavity.
    Depth,
}

/// Something that keeps designs from a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Restriction {
    /// One of the constraints' quantities, by its place.
    Quantity(usize),
    /// The smallest land that can be made, with a lower bound of the spacing that says the same.
    SmallestLand,
    /// A lower bound on which the best design rests.
    LowerBound(Dimension),
    /// An upper one.
    UpperBound(Dimension),
}

/// What relaxing one restriction gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The restriction.
    pub restriction: Restriction,
    /// Its limit, SI units.
    pub limit: f64,
    /// The limit with which `best` is allowed: the tightest found where that suffices. SI units.
    pub relaxed: f64,
    /// Whether the target is met then.
    pub suffices: bool,
    /// The best design then.
    pub best: Candidate,
}

/// Why a target is out of reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Restrictions that bind: relaxing them alone helps. Those that suffice first, the smallest changes first; then
    /// the nearest misses first.
    pub reliefs: Vec<Relief>,
    /// Restrictions tried, with the loosest that each was relaxed to. SI units.
    pub tried: Vec<(Restriction, f64)>,
    /// The best design with all of them relaxed, where none suffices alone.
    pub together: Option<Candidate>,
}

/// Says which restrictions keep the best design of a search, `best`, from its target, and what relaxing them gives.
/// `solve` is that search with another space and other constraints; bounds are relaxed to those of `widest`. Where one
/// suffices, its limit is tightened again by `halvings` bisections, each one search more.
///
/// # Errors
/// Those of `solve`, but for relaxed problems that leave nothing to search.
pub fn explain_infeasibility(
    space: &DesignSpace,
    constraints: &Constraints,
    best: &Candidate,
    widest: &DesignSpace,
    halvings: usize,
    solve: &mut dyn FnMut(&DesignSpace, &Constraints) -> Result<SearchOutcome, SearchError>,
) -> Result<Explanation, SearchError> {
    let problem = Problem { space, constraints, widest };
    let mut reliefs = Vec::new();
    let restrictions = problem.restrictions(best);
    let step = |merit: f64| WORTHWHILE * merit.abs().max(1.0);
    for &restriction in &restrictions {
        let (limit, loosest) = problem.range(restriction);
        let Some(found) = attempt(&problem, &[(restriction, loosest)], solve)? else { continue };
        // A better design that respects the limit as it is owes nothing to relaxing it.
        let relaxed = own(restriction, &found);
        let is_beyond = (relaxed - limit) * (loosest - limit) > 0.0;
        let helps = found.is_better_than(best)
            && (found.meets_target() || is_beyond)
            && (found.meets_target()
                || !best.violations.is_empty()
                || found.misfit.merit < best.misfit.merit - step(best.misfit.merit));
        if !helps {
            continue;
        }
        let mut relief = Relief { restriction, limit, relaxed, suffices: found.meets_target(), best: found };
        let suffices = |found: &Candidate| found.meets_target() && found.misfit.max <= SUFFICIENT_MISFIT;
        // Between the limit, which does not suffice, and what the design found has, which does.
        let mut tight = limit;
        for _ in 0..if relief.suffices { halvings } else { 0 } {
            let between = f64::midpoint(tight, relief.relaxed);
            match attempt(&problem, &[(restriction, between)], solve)?.filter(suffices) {
                Some(found) => (relief.relaxed, relief.best) = (own(restriction, &found), found),
                None => tight = between,
            }
        }
        reliefs.push(relief);
    }
    let change = |relief: &Relief| (relief.relaxed - relief.limit).abs() / relief.limit.abs().max(f64::MIN_POSITIVE);
    reliefs.sort_by(|left, right| match (left.suffices, right.suffices) {
        (true, true) => change(left).total_cmp(&change(right)),
        (false, false) => left.best.misfit.merit.total_cmp(&right.best.misfit.merit),
        (left, right) => right.cmp(&left),
    });
    let tried: Vec<(Restriction, f64)> =
        restrictions.iter().map(|&restriction| (restriction, problem.range(restriction).1)).collect();
    let together = if reliefs.iter().any(|relief| relief.suffices) || restrictions.is_empty() {
        None
    } else {
        attempt(&problem, &tried, solve)?
    };
    Ok(Explanation { reliefs, tried, together })
}

/// The best design with the limits given; `None` where they leave nothing to search.
fn attempt(
    problem: &Problem<'_>,
    limits: &[(Restriction, f64)],
    solve: &mut dyn FnMut(&DesignSpace, &Constraints) -> Result<SearchOutcome, SearchError>,
) -> Result<Option<Candidate>, SearchError> {
    let Some((space, constraints)) = problem.with(limits) else { return Ok(None) };
    match solve(&space, &constraints) {
        Ok(outcome) if outcome.status == Status::Cancelled => Ok(None),
        Ok(outcome) => Ok(Some(outcome.best)),
        Err(
            SearchError::EveryTrialFailed { .. }
            | SearchError::LimitAboveBounds { .. }
            | SearchError::NoWholeBurst { .. }
            | SearchError::CancelledAtStart,
        ) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The number of `candidate` that `restriction` is about.
fn own(restriction: Restriction, candidate: &Candidate) -> f64 {
    let design = &candidate.design;
    match restriction {
        Restriction::Quantity(place) => candidate.response.limited[place],
        Restriction::SmallestLand => design.least_land_m(),
        Restriction::LowerBound(dimension) | Restriction::UpperBound(dimension) => match dimension {
            Dimension::Width => design.width_m(),
            Dimension::Spacing => design.spacing_m(),
            Dimension::Depth => design.depth_m(),
        },
    }
}

struct Problem<'a> {
    space: &'a DesignSpace,
    constraints: &'a Constraints,
    widest: &'a DesignSpace,
}

impl Problem<'_> {
    /// What may keep designs from the target: every limit, and the bounds on which `best` rests.
    fn restrictions(&self, best: &Candidate) -> Vec<Restriction> {
        let limits = &self.constraints.limits;
        let mut all: Vec<Restriction> = (0..self.constraints.quantities.len()).map(Restriction::Quantity).collect();
        all.extend(limits.min_land_m.map(|_| Restriction::SmallestLand));
        for dimension in [Dimension::Width, Dimension::Spacing, Dimension::Depth] {
            let [lower_m, upper_m] = bounds(self.space, dimension);
            for (restriction, bound_m) in
                [(Restriction::LowerBound(dimension), lower_m), (Restriction::UpperBound(dimension), upper_m)]
            {
                if (own(restriction, best) / bound_m - 1.0).abs() <= AT_BOUND {
                    all.push(restriction);
                }
            }
        }
        all.retain(|&restriction| {
            let (limit, loosest) = self.range(restriction);
            limit != loosest && !self.is_said_by_a_limit(restriction)
        });
        all
    }

    /// Whether a bound says no more than a limit of the laser.
    fn is_said_by_a_limit(&self, restriction: Restriction) -> bool {
        let limits = &self.constraints.limits;
        let limit_m = match restriction {
            Restriction::LowerBound(Dimension::Width) => limits.spot_m,
            Restriction::LowerBound(Dimension::Spacing) => limits.min_land_m,
            _ => None,
        };
        limit_m.is_some_and(|limit_m| limit_m >= self.range(restriction).0 * (1.0 - AT_BOUND))
    }

    /// The limit, and the loosest there is.
    fn range(&self, restriction: Restriction) -> (f64, f64) {
        let limits = &self.constraints.limits;
        let [spacing_m, width_m] = [Dimension::Spacing, Dimension::Width].map(|d| bounds(self.widest, d)[0]);
        match restriction {
            Restriction::Quantity(place) => {
                let limit = &self.constraints.quantities[place];
                (limit.bound.limit(), limit.loosest)
            }
            Restriction::SmallestLand => {
                let limit_m = limits.min_land_m.unwrap_or(spacing_m);
                (limit_m, spacing_m.min(limit_m))
            }
            // No other laser is assumed: nothing narrower than its spot is tried.
            Restriction::LowerBound(Dimension::Width) => {
                let limit_m = bounds(self.space, Dimension::Width)[0];
                (limit_m, width_m.max(limits.spot_m.unwrap_or(0.0)).min(limit_m))
            }
            Restriction::LowerBound(dimension) => (bounds(self.space, dimension)[0], bounds(self.widest, dimension)[0]),
            Restriction::UpperBound(dimension) => (bounds(self.space, dimension)[1], bounds(self.widest, dimension)[1]),
        }
    }

    /// The problem with other limits; `None` where these are no problem.
    fn with(&self, limits: &[(Restriction, f64)]) -> Option<(DesignSpace, Constraints)> {
        let mut constraints = self.constraints.clone();
        let mut lengths_m = [Dimension::Width, Dimension::Spacing, Dimension::Depth].map(|d| bounds(self.space, d));
        // A bound that says the same as a limit goes along with it.
        let along = |bounds_m: &mut [f64; 2], from_m: Option<f64>, to_m: f64| {
            if from_m.is_some_and(|from_m| bounds_m[0] <= from_m && bounds_m[0] >= from_m * (1.0 - AT_BOUND)) {
                bounds_m[0] = bounds_m[0].min(to_m);
            }
        };
        for &(restriction, limit) in limits {
            match restriction {
                Restriction::Quantity(place) => {
                    let quantity = &mut constraints.quantities[place];
                    quantity.bound = quantity.bound.with_limit(limit);
                }
                Restriction::SmallestLand => {
                    along(&mut lengths_m[1], self.constraints.limits.min_land_m, limit);
                    constraints.limits.min_land_m = Some(limit);
                }
                Restriction::LowerBound(dimension) => lengths_m[dimension as usize][0] = limit,
                Restriction::UpperBound(dimension) => lengths_m[dimension as usize][1] = limit,
            }
        }
        let [width_m, spacing_m, depth_m] = lengths_m;
        let space = DesignSpace::new(*self.space.texture(), width_m, spacing_m, depth_m).ok()?;
        Some((space, constraints))
    }
}

fn bounds(space: &DesignSpace, dimension: Dimension) -> [f64; 2] {
    match dimension {
        Dimension::Width => space.width_m(),
        Dimension::Spacing => space.spacing_m(),
        Dimension::Depth => space.depth_m(),
    }
}
