/// Reason why material data were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// A number is out of range.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Name of the number.
        quantity: &'static str,
        /// Number given, in SI units.
        value: f64,
        /// Description of what is accepted.
        expected: &'static str,
    },
    /// Two columns of a table have different lengths.
    #[error("{quantity}: {left} pressures but {right} values")]
    LengthMismatch {
        /// Name of the table.
        quantity: &'static str,
        /// Number of pressures.
        left: usize,
        /// Number of values.
        right: usize,
    },
    /// A table is empty.
    #[error("{quantity}: the table is empty")]
    Empty {
        /// Name of the table.
        quantity: &'static str,
    },
    /// Pressures do not increase.
    #[error("{quantity}: pressures must increase, but {next} Pa follows {previous} Pa")]
    NotIncreasing {
        /// Name of the table.
        quantity: &'static str,
        /// Earlier pressure, in pascals.
        previous: f64,
        /// Later pressure, in pascals.
        next: f64,
    },
    /// The requested condition is outside the measured ones.
    #[error(
        "no coefficients for {speed_mm_s} mm/s at {humidity_pct} % humidity, which is not between measured ones: the material has {available}"
    )]
    UnknownCondition {
        /// Requested speed, in mm/s.
        speed_mm_s: f64,
        /// Requested relative humidity, in per cent.
        humidity_pct: f64,
        /// List of the measured conditions.
        available: String,
    },
    /// The material has coefficients per condition, and none was requested.
    #[error("the material has coefficients per condition: name one, for instance condition = {{ {example} }}")]
    ConditionMissing {
        /// Example of a condition.
        example: String,
    },
}

/// Checks that `value` is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::OutOfRange { quantity, value, expected: "a positive number" })
    }
}

/// Checks that `value` is finite and not negative.
pub(crate) fn not_negative(quantity: &'static str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::OutOfRange { quantity, value, expected: "a number not below zero" })
    }
}

/// Checks that `pressures_pa` are finite, not negative and strictly increasing.
pub(crate) fn increasing(quantity: &'static str, pressures_pa: &[f64]) -> Result<(), MaterialError> {
    if pressures_pa.is_empty() {
        return Err(MaterialError::Empty { quantity });
    }
    for &pressure_pa in pressures_pa {
        not_negative("pressure", pressure_pa)?;
    }
    for pair in pressures_pa.windows(2) {
        if pair[1] <= pair[0] {
            return Err(MaterialError::NotIncreasing { quantity, previous: pair[0], next: pair[1] });
        }
    }
    Ok(())
}
