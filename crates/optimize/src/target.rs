//! What friction should be.

use crate::SearchError;
use crate::error::positive;

/// Change of a value that matters where a goal alone is given: of a ratio, and of a friction coefficient, which is a
/// quarter of one for most dry polymers.
const RATIO_STEP: f64 = 0.01;
const FRICTION_STEP: f64 = 0.0025;
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

    /// Half the width of what is accepted, of a limit alone its margin; `None` where nothing is demanded.
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
        Ok(Self { quantity, demands, goal })
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
}
