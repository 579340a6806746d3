/// Reason why material data were refused, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct MaterialError(pub(crate) String);

impl MaterialError {
    /// A number out of range, in SI units.
    pub(crate) fn out_of_range(quantity: &str, value: f64, expected: &str) -> Self {
        Self(format!("{quantity} is {value}: expected {expected}"))
    }
}

/// Checks that the table named `table` has as many values as pressures.
pub(crate) fn same_length(table: &str, pressures: usize, values: usize) -> Result<(), MaterialError> {
    if pressures == values {
        return Ok(());
    }
    Err(MaterialError(format!("{table}: {pressures} pressures but {values} values")))
}

/// Returns `value` if it is finite and positive, and an error that names `quantity` otherwise.
pub(crate) fn positive(quantity: &str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::out_of_range(quantity, value, "a positive number"))
    }
}

/// Returns `value` if it is finite and not negative, and an error that names `quantity` otherwise.
pub(crate) fn not_negative(quantity: &str, value: f64) -> Result<f64, MaterialError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(MaterialError::out_of_range(quantity, value, "a number not below zero"))
    }
}

/// Checks that `pressures_pa` has values that are finite, not negative and strictly increasing.
pub(crate) fn increasing(table: &str, pressures_pa: &[f64]) -> Result<(), MaterialError> {
    if pressures_pa.is_empty() {
        return Err(MaterialError(format!("{table}: the table is empty")));
    }
    for &pressure_pa in pressures_pa {
        not_negative("pressure", pressure_pa)?;
    }
    match pressures_pa.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some([previous, next]) => {
            Err(MaterialError(format!("{table}: pressures must increase, but {next} Pa follows {previous} Pa")))
        }
        _ => Ok(()),
    }
}
