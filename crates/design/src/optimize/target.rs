//! Target of friction.

use crate::optimize::SearchError;
use crate::optimize::error::positive;

/// Smallest significant change of a ratio if a goal is given, unless a tolerance is smaller.
const RATIO_STEP: f64 = 0.01;
/// Smallest significant change of a friction coefficient if a goal is given, unless a tolerance is smaller: 1 % of
/// 0.25, the coefficient of most dry polymers.
const FRICTION_STEP: f64 = 0.0025;
/// Quantity that the target prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Dynamic friction coefficient over that of the flat surface.
    Ratio,
    /// Dynamic friction coefficient.
    DynamicFriction,
}

slipgrid_base::names!(Quantity { Ratio = "ratio", DynamicFriction = "mu_dynamic" });

/// Target value at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Target value, dimensionless.
    pub value: f64,
}

/// Accepted values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// Any value: a goal alone decides.
    Anything,
    /// Values within `tolerance` of `value`.
    Near {
        /// Target value.
        value: f64,
        /// Largest accepted distance from `value`.
        tolerance: f64,
    },
    /// Values from `lowest` to `highest`; without a goal the search aims at the middle.
    Between {
        /// Lowest accepted value.
        lowest: f64,
        /// Highest accepted value.
        highest: f64,
    },
    /// Values of at least `lowest`; the search aims at `margin` above.
    AtLeast {
        /// Lowest accepted value.
        lowest: f64,
        /// Distance inside the limit at which the search aims; values farther inside are not better.
        margin: f64,
    },
    /// Values of at most `highest`; the search aims at `margin` below.
    AtMost {
        /// Highest accepted value.
        highest: f64,
        /// Distance inside the limit at which the search aims; values farther inside are not better.
        margin: f64,
    },
}

impl Wanted {
    /// Lowest and highest accepted value; `None` without such a limit. No band goes below 0, as friction does not.
    pub fn band(&self) -> [Option<f64>; 2] {
        match *self {
            Self::Anything => [None; 2],
            Self::Near { value, tolerance } => [Some((value - tolerance).max(0.0)), Some(value + tolerance)],
            Self::Between { lowest, highest } => [Some(lowest), Some(highest)],
            Self::AtLeast { lowest, .. } => [Some(lowest), None],
            Self::AtMost { highest, .. } => [None, Some(highest)],
        }
    }

    /// Half the width of the accepted band; for a single limit, the distance inside it at which the search aims; `None`
    /// if nothing is demanded.
    pub fn tolerance(&self) -> Option<f64> {
        match *self {
            Self::Anything => None,
            Self::Near { value, tolerance } => Some(0.5 * (tolerance + tolerance.min(value))),
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

/// Demand at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Accepted values.
    pub wanted: Wanted,
    /// Weight of this pressure in means over the pressures; it does not affect whether the target is met.
    pub weight: f64,
}

/// Goal to optimize among designs that meet the demands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Goal {
    /// Minimum mean value over the pressures.
    Lowest,
    /// Maximum mean value over the pressures.
    Highest,
    /// Minimum standard deviation over the pressures, relative to the mean.
    Even,
}

slipgrid_base::names!(Goal { Lowest = "lowest", Highest = "highest", Even = "even" });

/// Target: demands on friction and an optional goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    quantity: Quantity,
    demands: Vec<Demand>,
    goal: Option<Goal>,
}

impl Target {
    /// Creates a target of `quantity` at `points`, met if every value lies within `tolerance`.
    ///
    /// # Errors
    /// See [`Target::of`].
    pub fn new(quantity: Quantity, points: Vec<TargetPoint>, tolerance: f64) -> Result<Self, SearchError> {
        let demand = |point: TargetPoint| {
            let wanted = Wanted::Near { value: point.value, tolerance };
            Demand { pressure_pa: point.pressure_pa, wanted, weight: 1.0 }
        };
        Self::of(quantity, points.into_iter().map(demand).collect(), None)
    }

    /// Creates a target of `quantity` that meets every demand and optimizes the goal, if given.
    ///
    /// # Errors
    /// [`SearchError::NoTargetPoints`], [`SearchError::RepeatedPressure`], [`SearchError::NothingWanted`] without
    /// demand and goal, [`SearchError::OnePressure`] for an even goal at a single pressure, and
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
        Ok(Self { quantity, demands, goal })
    }

    /// Quantity that the target prescribes.
    pub const fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// Demands at each pressure, in the order given; they are equal at every condition.
    pub fn points(&self) -> &[Demand] {
        &self.demands
    }

    /// Goal; `None` if the target has only demands.
    pub const fn goal(&self) -> Option<Goal> {
        self.goal
    }

    /// Whether some pressure has a demand.
    pub fn has_demands(&self) -> bool {
        self.demands.iter().any(|demand| demand.wanted != Wanted::Anything)
    }

    /// Smallest significant change of a value: the smallest tolerance; with a goal, at most 0.01 for a ratio and 0.0025
    /// for a friction coefficient.
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
}
