//! Why a search was refused.

/// Why a search was refused or could not go on. A target that no design reaches is no error but a
/// [`Status`](crate::Status).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SearchError {
    /// A number outside its meaning.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// What the number is.
        quantity: &'static str,
        /// The number given, SI units.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A target without points.
    #[error("the target has no points: expected at least one pressure with a value")]
    NoTargetPoints,
    /// A target with neither a demand nor a goal.
    #[error("the target wants nothing: expected a value or limit at some pressure, or a goal")]
    NothingWanted,
    /// Values at one pressure that should be even.
    #[error("the target asks for even values at one pressure: expected at least two pressures")]
    OnePressure,
    /// Two target values at one pressure.
    #[error("the target has two values at {pressure_pa} Pa: expected one")]
    RepeatedPressure {
        /// The pressure given twice, in pascals.
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
    /// A manufacturing limit leaves nothing of the bounds.
    #[error("{quantity} is at most {upper_m:e} m, but the {limit} asks for at least {limit_m:e} m")]
    LimitAboveBounds {
        /// `width`, `spacing`, `length` or `spacing across`.
        quantity: &'static str,
        /// The upper bound, in metres.
        upper_m: f64,
        /// Which limit.
        limit: &'static str,
        /// The limit, in metres.
        limit_m: f64,
    },
    /// No whole number of bursts gives a depth within the bounds.
    #[error(
        "no whole number of bursts of {depth_per_burst_m:e} m gives a depth from {lower_m:e} m to {upper_m:e} m: \
         the nearest possible is {nearest_m:e} m"
    )]
    NoWholeBurst {
        /// Lower bound of the depth, in metres.
        lower_m: f64,
        /// Upper bound of the depth, in metres.
        upper_m: f64,
        /// Depth that one burst removes, in metres.
        depth_per_burst_m: f64,
        /// The whole-burst depth nearest to the bounds, in metres.
        nearest_m: f64,
    },
    /// The model could compute none of the designs that were tried.
    #[error("the model could not compute any of the {trials} designs that were tried; for the first because {reason}")]
    EveryTrialFailed {
        /// Designs tried.
        trials: usize,
        /// Why the first one failed.
        reason: String,
    },
    /// The model is broken, whatever the design.
    #[error("the model cannot be evaluated: {reason}")]
    BrokenModel {
        /// What the model said.
        reason: String,
    },
    /// The model answers another question than the target asks.
    #[error("the model returned {got} values: expected {expected}, one per target pressure")]
    WrongResponse {
        /// Number of target points.
        expected: usize,
        /// Number of values returned.
        got: usize,
    },
    /// The model gives other quantities than the constraints limit.
    #[error("the model returned {got} limited quantities: expected {expected}, one per limit")]
    WrongLimited {
        /// Number of limits.
        expected: usize,
        /// Number of quantities returned.
        got: usize,
    },
    /// The search was cancelled before a single design had been evaluated.
    #[error("cancelled before the first design was evaluated")]
    CancelledAtStart,
}

/// `value` if it is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, SearchError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(SearchError::OutOfRange { quantity, value, expected: "a positive number" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designs_that_were_tried_are_not_called_trials() {
        let failed = SearchError::EveryTrialFailed { trials: 40, reason: "cavities close".to_owned() }.to_string();
        let words =
            "the model could not compute any of the 40 designs that were tried; for the first because cavities close";
        assert_eq!(failed, words);
    }
}
