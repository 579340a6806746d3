/// Why material data were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
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
    /// Two columns of a table that should have equal lengths.
    #[error("{quantity}: {left} pressures but {right} values")]
    LengthMismatch {
        /// Which table.
        quantity: &'static str,
        /// Number of pressures.
        left: usize,
        /// Number of values.
        right: usize,
    },
    /// A table without rows.
    #[error("{quantity}: the table is empty")]
    Empty {
        /// Which table.
        quantity: &'static str,
    },
    /// Pressures that do not increase.
    #[error("{quantity}: pressures must increase, but {next} Pa follows {previous} Pa")]
    NotIncreasing {
        /// Which table.
        quantity: &'static str,
        /// The earlier pressure.
        previous: f64,
        /// The later one.
        next: f64,
    },
    /// The condition asked for lies outside those measured.
    #[error(
        "no coefficients for {speed_mm_s} mm/s at {humidity_pct} % humidity, which is not between measured ones: the material has {available}"
    )]
    UnknownCondition {
        /// Speed asked for, mm/s.
        speed_mm_s: f64,
        /// Relative humidity asked for, per cent.
        humidity_pct: f64,
        /// The conditions there are, in words.
        available: String,
    },
    /// The material has coefficients per condition and none was named.
    #[error("the material has coefficients per condition: name one, for instance condition = {{ {example} }}")]
    ConditionMissing {
        /// A condition that would be accepted.
        example: String,
    },
}

/// `value` if it is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::OutOfRange { quantity, value, expected: "a positive number" })
    }
}

/// `value` if it is finite and not negative.
pub(crate) fn not_negative(quantity: &'static str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::OutOfRange { quantity, value, expected: "a number not below zero" })
    }
}

/// Checks that `pressures` increase strictly and are finite and not negative.
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
