//! What friction should be.
//!
//! Residuals count in tolerances: r_i = (v_i - t_i) / T_i, met where every |r_i| is at most 1. What lies beyond a
//! one-sided limit by a margin costs nothing. A goal ranks what lies within.

use crate::error::positive;
use crate::{COMFORTABLE_RMS, SearchError};

/// A change of this share matters to a goal: goals count in per cent.
const GOAL_STEP: f64 = 0.01;
/// Change of a value that matters where a goal alone is given: of a ratio, and of a friction coefficient, which is a
/// quarter of one for most dry polymers.
const RATIO_STEP: f64 = 0.01;
const FRICTION_STEP: f64 = 0.0025;
/// Residual from which a goal pays for coming near the edge of a band, so that what confirms the design may
/// differ a little.
const NEAR_THE_EDGE: f64 = 0.9;
/// What a residual beyond that costs, over what a goal can gain by it.
const EDGE_STEEPNESS: f64 = 10.0;

/// Which number the target prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Dynamic friction coefficient over that of the flat surface.
    Ratio,
    /// Dynamic friction coefficient.
    DynamicFriction,
}

impl Quantity {
    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ratio => "ratio",
            Self::DynamicFriction => "mu_dynamic",
        }
    }
}

/// The wanted value at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Wanted value, dimensionless.
    pub value: f64,
}

/// What is accepted of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// Anything: a goal alone decides.
    Anything,
    /// `value`, give or take `tolerance`.
    Near {
        /// Wanted.
        value: f64,
        /// Largest accepted distance.
        tolerance: f64,
    },
    /// From `lowest` to `highest`; without a goal the middle is aimed at.
    Between {
        /// Lowest accepted.
        lowest: f64,
        /// Highest accepted.
        highest: f64,
    },
    /// `lowest` or more; `margin` more is aimed at.
    AtLeast {
        /// Lowest accepted.
        lowest: f64,
        /// Distance from the limit beyond which nothing is gained.
        margin: f64,
    },
    /// `highest` or less; `margin` less is aimed at.
    AtMost {
        /// Highest accepted.
        highest: f64,
        /// Distance from the limit beyond which nothing is gained.
        margin: f64,
    },
}

impl Wanted {
    /// Distance of `value` in tolerances: 0 at what is aimed at, -1 and 1 at what is just accepted.
    #[must_use]
    pub fn residual(&self, value: f64) -> f64 {
        match *self {
            Self::Anything => 0.0,
            // r = (v - t) / T
            Self::Near { value: wanted, tolerance } => (value - wanted) / tolerance,
            Self::Between { lowest, highest } => (value - f64::midpoint(lowest, highest)) / (0.5 * (highest - lowest)),
            // r = (v - (t + T)) / T below t + T, 0 above
            Self::AtLeast { lowest, margin } => ((value - lowest) / margin - 1.0).min(0.0),
            Self::AtMost { highest, margin } => ((value - highest) / margin + 1.0).max(0.0),
        }
    }

    /// Lowest and highest accepted value, where there are any.
    #[must_use]
    pub fn band(&self) -> [Option<f64>; 2] {
        match *self {
            Self::Anything => [None; 2],
            Self::Near { value, tolerance } => [Some(value - tolerance), Some(value + tolerance)],
            Self::Between { lowest, highest } => [Some(lowest), Some(highest)],
            Self::AtLeast { lowest, .. } => [Some(lowest), None],
            Self::AtMost { highest, .. } => [None, Some(highest)],
        }
    }

    /// Change of a value that is a residual of 1; `None` where nothing is demanded.
    #[must_use]
    pub fn tolerance(&self) -> Option<f64> {
        match *self {
            Self::Anything => None,
            Self::Near { tolerance, .. } => Some(tolerance),
            Self::Between { lowest, highest } => Some(0.5 * (highest - lowest)),
            Self::AtLeast { margin, .. } | Self::AtMost { margin, .. } => Some(margin),
        }
    }

    fn validate(&self) -> Result<(), SearchError> {
        match *self {
            Self::Anything => {}
            Self::Near { value, tolerance } => {
                positive("target value", value)?;
                positive("target tolerance", tolerance)?;
            }
            Self::Between { lowest, highest } => {
                positive("lowest value", lowest)?;
                positive("highest value", highest)?;
                if lowest >= highest {
                    let expected = "more than the lowest value";
                    return Err(SearchError::OutOfRange { quantity: "highest value", value: highest, expected });
                }
            }
            Self::AtLeast { lowest: limit, margin } | Self::AtMost { highest: limit, margin } => {
                positive("limit of the value", limit)?;
                positive("target tolerance", margin)?;
            }
        }
        Ok(())
    }
}

/// What is wanted at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// What is accepted.
    pub wanted: Wanted,
    /// How much this pressure counts in means over the pressures; whether the target is met does not depend on it.
    pub weight: f64,
}

/// What is to be as good as possible among designs that do what is demanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Goal {
    /// The lowest mean value over the pressures.
    Lowest,
    /// The highest.
    Highest,
    /// The least standard deviation over the pressures, relative to the mean.
    Even,
}

impl Goal {
    /// All goals.
    pub const ALL: [Self; 3] = [Self::Lowest, Self::Highest, Self::Even];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lowest => "lowest",
            Self::Highest => "highest",
            Self::Even => "even",
        }
    }
}

/// What friction should be, and how nearly.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    quantity: Quantity,
    demands: Vec<Demand>,
    goal: Option<Goal>,
    /// How many conditions the demands are made at.
    conditions: usize,
    /// Values at one condition, after which those at the next begin.
    period: usize,
    /// Values are those of samples of a design, of which the mean counts.
    of_samples: bool,
}

/// Distance of a response from the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Largest residual over the target's pressures: at most 1 where the target is met.
    pub max: f64,
    /// Root mean square of the residuals, by weight.
    pub rms: f64,
    /// What descents minimize: the root mean square, at the condition where it is largest; with a goal that goal, in
    /// per cent, with the price of coming near the edge of what is accepted.
    pub cost: f64,
    /// What designs are ranked by: the largest residual; with a goal, and over samples of a design, the cost.
    pub merit: f64,
}

impl Target {
    /// A target of `quantity` at `points`, met where every value lies within `tolerance`.
    ///
    /// # Errors
    /// As [`Target::of`].
    pub fn new(quantity: Quantity, points: Vec<TargetPoint>, tolerance: f64) -> Result<Self, SearchError> {
        let demand = |point: TargetPoint| {
            let wanted = Wanted::Near { value: point.value, tolerance };
            Demand { pressure_pa: point.pressure_pa, wanted, weight: 1.0 }
        };
        Self::of(quantity, points.into_iter().map(demand).collect(), None)
    }

    /// A target of `quantity`: every demand met, and with a goal as good as possible beside that.
    ///
    /// # Errors
    /// [`SearchError::NoTargetPoints`], [`SearchError::RepeatedPressure`], [`SearchError::NothingWanted`] where there is
    /// neither a demand nor a goal, [`SearchError::OnePressure`] where values at one pressure should be even, and
    /// [`SearchError::OutOfRange`] unless pressures, weights, values and tolerances are positive and finite.
    pub fn of(quantity: Quantity, demands: Vec<Demand>, goal: Option<Goal>) -> Result<Self, SearchError> {
        if demands.is_empty() {
            return Err(SearchError::NoTargetPoints);
        }
        for (index, demand) in demands.iter().enumerate() {
            positive("target pressure", demand.pressure_pa)?;
            positive("target weight", demand.weight)?;
            demand.wanted.validate()?;
            if demands[..index].iter().any(|earlier| earlier.pressure_pa == demand.pressure_pa) {
                return Err(SearchError::RepeatedPressure { pressure_pa: demand.pressure_pa });
            }
        }
        if goal.is_none() && demands.iter().all(|demand| demand.wanted == Wanted::Anything) {
            return Err(SearchError::NothingWanted);
        }
        if goal == Some(Goal::Even) && demands.len() < 2 {
            return Err(SearchError::OnePressure);
        }
        let period = demands.len();
        Ok(Self { quantity, demands, goal, conditions: 1, period, of_samples: false })
    }

    /// The same asked at each of `conditions` conditions, at least one: values are those at the first, then those at the
    /// second and so on, each in the order of [`Target::points`]. What the search minimizes is that of the worst of them.
    #[must_use]
    pub fn at_conditions(&self, conditions: usize) -> Self {
        Self { conditions: conditions.max(1), ..self.clone() }
    }

    /// How many conditions the target is asked at.
    #[must_use]
    pub const fn conditions(&self) -> usize {
        self.conditions
    }

    /// How many values it is compared with: one for each point at each condition.
    #[must_use]
    pub const fn values(&self) -> usize {
        self.conditions * self.demands.len()
    }

    /// The demand on each value.
    fn asked(&self) -> impl Iterator<Item = &Demand> {
        (0..self.conditions).flat_map(|_| &self.demands)
    }

    /// Of `values` those at one condition after the other, each with its demand.
    fn by_condition<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = Vec<(&'a Demand, f64)>> {
        let of = move |condition: usize| -> Vec<(&'a Demand, f64)> {
            let is_own = move |(place, _): &(usize, _)| place / self.period % self.conditions == condition;
            let pairs = self.asked().zip(values.iter().copied()).enumerate();
            pairs.filter(is_own).map(|(_, pair)| pair).collect()
        };
        (0..self.conditions).map(of).filter(|own| !own.is_empty())
    }

    /// Which number is prescribed.
    #[must_use]
    pub const fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The pressures and what is wanted there, in the order given: the same at every condition.
    #[must_use]
    pub fn points(&self) -> &[Demand] {
        &self.demands
    }

    /// What is to be as good as possible.
    #[must_use]
    pub const fn goal(&self) -> Option<Goal> {
        self.goal
    }

    /// Whether anything is demanded at some pressure.
    #[must_use]
    pub fn has_demands(&self) -> bool {
        self.demands.iter().any(|demand| demand.wanted != Wanted::Anything)
    }

    /// The smallest change of a value that matters: the smallest tolerance; where there is a goal, at most 0.01 of a
    /// ratio and 0.0025 of a friction coefficient.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        let smallest = self.demands.iter().filter_map(|demand| demand.wanted.tolerance()).reduce(f64::min);
        let step = match self.quantity {
            Quantity::Ratio => RATIO_STEP,
            Quantity::DynamicFriction => FRICTION_STEP,
        };
        match (smallest, self.goal) {
            (Some(smallest), None) => smallest,
            (smallest, _) => smallest.map_or(step, |smallest| smallest.min(step)),
        }
    }

    /// What the goal is about: the mean value, or for an even one standard deviation over mean; at the condition where that
    /// is worst.
    #[must_use]
    pub fn goal_value(&self, values: &[f64]) -> Option<f64> {
        let goal = self.goal?;
        let of = |own: Vec<(&Demand, f64)>| {
            let mean = mean(own.iter().copied());
            match goal {
                Goal::Lowest | Goal::Highest => mean,
                // s / m = sqrt( sum w_i (v_i - m)^2 / sum w_i ) / m
                Goal::Even => {
                    self::mean(own.iter().map(|(demand, value)| (*demand, (value - mean).powi(2)))).sqrt() / mean
                }
            }
        };
        let worst = if goal == Goal::Highest { f64::min } else { f64::max };
        self.by_condition(values).map(of).reduce(worst)
    }

    /// Residuals whose root mean square is the cost of `values` at one condition, and at several that of all their costs;
    /// `None` where it is none.
    #[must_use]
    pub fn residuals(&self, values: &[f64]) -> Option<Vec<f64>> {
        let residual: Vec<f64> = match self.goal {
            None => self.asked().zip(values).map(|(demand, value)| demand.wanted.residual(*value)).collect(),
            Some(Goal::Even) if !self.has_demands() => {
                let means: Vec<f64> = self.by_condition(values).map(|own| mean(own.into_iter())).collect();
                let of = |(place, value): (usize, &f64)| {
                    (value / means[place / self.period % self.conditions] - 1.0) / GOAL_STEP
                };
                values.iter().enumerate().map(of).collect()
            }
            Some(_) => return None,
        };
        let mean_weight = self.demands.iter().map(|demand| demand.weight).sum::<f64>() / self.demands.len() as f64;
        let weighted = |(demand, residual): (&Demand, f64)| residual * (demand.weight / mean_weight).sqrt();
        Some(self.asked().zip(residual).map(weighted).collect())
    }

    /// The same asked of `times` responses, one after the other.
    pub(crate) fn repeated(&self, times: usize) -> Self {
        Self { demands: self.demands.repeat(times), of_samples: true, ..self.clone() }
    }

    /// Misfit of `values`, one per point and condition; further values are ignored, and the largest residual of the first
    /// ones alone is theirs.
    #[must_use]
    pub fn misfit(&self, values: &[f64]) -> Misfit {
        let values = &values[..values.len().min(self.values())];
        let square = |(demand, value): (&'_ Demand, f64)| demand.wanted.residual(value).powi(2);
        let asked = || self.asked().zip(values.iter().copied());
        let max = asked().fold(0.0, |max: f64, (demand, value)| max.max(demand.wanted.residual(value).abs()));
        // rms = sqrt( sum w_i r_i^2 / sum w_i )
        let rms = mean(asked().map(|pair| (pair.0, square(pair)))).sqrt();
        let near_the_edge = || self.edge_price() * (max - NEAR_THE_EDGE).max(0.0);
        let worst = || {
            let of = |own: Vec<(&Demand, f64)>| mean(own.into_iter().map(|pair| (pair.0, square(pair)))).sqrt();
            if self.conditions == 1 { rms } else { self.by_condition(values).map(of).fold(0.0, f64::max) }
        };
        let cost = self.goal_cost(values).map_or_else(worst, |goal| goal + near_the_edge());
        let merit = if self.ranks_by_largest() { max } else { cost };
        Misfit { max, rms, cost, merit }
    }

    /// Whether every one of `values` is accepted: as [`Target::misfit`] says, and sooner.
    #[must_use]
    pub fn accepts(&self, values: &[f64]) -> bool {
        self.asked().zip(values).all(|(demand, value)| demand.wanted.residual(*value).abs() <= 1.0)
    }

    /// Whether designs are ranked by their largest residual.
    pub(crate) const fn ranks_by_largest(&self) -> bool {
        self.goal.is_none() && !self.of_samples
    }

    /// Mean of the residuals with their signs.
    pub(crate) fn mean_residual(&self, values: &[f64]) -> f64 {
        mean(self.asked().zip(values).map(|(demand, value)| (demand, demand.wanted.residual(*value))))
    }

    /// The goal in per cent, the less the better.
    pub(crate) fn goal_cost(&self, values: &[f64]) -> Option<f64> {
        let value = self.goal_value(values)?;
        Some(match self.goal? {
            // 100 ln(m): a hundredth of the mean is 1.
            Goal::Lowest => libm::log(value.max(f64::MIN_POSITIVE)) / GOAL_STEP,
            Goal::Highest => -libm::log(value.max(f64::MIN_POSITIVE)) / GOAL_STEP,
            Goal::Even => value / GOAL_STEP,
        })
    }

    /// How far `values` lie beyond the places near both edges of what is accepted that a goal may go to, in tolerances:
    /// at most 0 within.
    pub(crate) fn edges(&self, values: &[f64]) -> Vec<f64> {
        let residuals = || self.asked().zip(values).map(|(demand, value)| demand.wanted.residual(*value));
        let edges = |residual: f64| [residual - NEAR_THE_EDGE, -residual - NEAR_THE_EDGE];
        if self.has_demands() { residuals().flat_map(edges).collect() } else { Vec::new() }
    }

    /// Cost at which there is nothing left to gain.
    pub(crate) const fn comfortable_cost(&self) -> f64 {
        match self.goal {
            None | Some(Goal::Even) => COMFORTABLE_RMS,
            Some(Goal::Lowest | Goal::Highest) => f64::NEG_INFINITY,
        }
    }

    /// Price of a residual of 1 beyond what is accepted: ten times what a goal gains by it, in per cent.
    fn edge_price(&self) -> f64 {
        let widest = self.demands.iter().filter_map(|demand| {
            let reference = demand.wanted.band().into_iter().flatten().reduce(f64::min)?;
            Some(demand.wanted.tolerance()? / reference.max(GOAL_STEP))
        });
        EDGE_STEEPNESS * widest.fold(GOAL_STEP, f64::max) / GOAL_STEP
    }
}

/// Mean of numbers by the weight of their demands.
fn mean<'a>(numbers: impl Iterator<Item = (&'a Demand, f64)>) -> f64 {
    let add = |[sum, weight]: [f64; 2], (demand, number): (&Demand, f64)| {
        [sum + demand.weight * number, weight + demand.weight]
    };
    let [sum, weight] = numbers.fold([0.0; 2], add);
    sum / weight
}

impl Misfit {
    /// Whether every value is accepted.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.max <= 1.0
    }
}

#[cfg(test)]
mod tests;
