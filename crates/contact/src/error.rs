use slipgrid_topography::MapError;

/// Why a contact problem was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A number outside its meaning; SI units.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Which number.
        quantity: &'static str,
        /// The number given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The surface cannot be solved on.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// Refuses `value` unless it lies in `range`, which `expected` describes.
pub(crate) fn within(
    quantity: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<f64, ContactError> {
    if range.contains(&value) { Ok(value) } else { Err(ContactError::OutOfRange { quantity, value, expected }) }
}
