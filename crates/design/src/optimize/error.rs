//! Errors of targets, bounds and models.

/// Reason why a target, bounds or tolerances were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SearchError {
    /// Number outside its valid range.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Name of the number.
        quantity: &'static str,
        /// Value of the number, in SI units.
        value: f64,
        /// Accepted values.
        expected: &'static str,
    },
    /// Target without points.
    #[error("the target has no points: expected at least one pressure with a value")]
    NoTargetPoints,
    /// Target with neither a demand nor a goal.
    #[error("the target wants nothing: expected a value or limit at some pressure, or a goal")]
    NothingWanted,
    /// Even goal at a single pressure.
    #[error("the target asks for even values at one pressure: expected at least two pressures")]
    OnePressure,
    /// Two target values at one pressure.
    #[error("the target has two values at {pressure_pa} Pa: expected one")]
    RepeatedPressure {
        /// Repeated pressure, in pascals.
        pressure_pa: f64,
    },
    /// Bounds whose lower end lies above the upper.
    #[error("{quantity} from {lower_m:e} m to {upper_m:e} m: expected the lower bound first")]
    BoundsReversed {
        /// `width`, `spacing` or `depth`.
        quantity: &'static str,
        /// The first bound, in metres.
        lower_m: f64,
        /// The second bound, in metres.
        upper_m: f64,
    },
}

/// Reason why a model gives no result for a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelFailure {
    /// Failure of this design only, with the reason; the search continues.
    #[error("{0}")]
    Trial(String),
    /// Failure of all designs, with the reason: the search ends with an error.
    #[error("{0}")]
    Broken(String),
    /// Cancelled: the search ends with its best design so far.
    #[error("cancelled")]
    Cancelled,
}

/// Returns `value` if it is finite and positive, otherwise [`SearchError::OutOfRange`] for `quantity`.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, SearchError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(SearchError::OutOfRange { quantity, value, expected: "a positive number" })
    }
}
