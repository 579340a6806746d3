use crate::topography::MapError;

/// Reason why a contact problem was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A parameter is out of range; the value is in SI units.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Name of the parameter.
        quantity: &'static str,
        /// Value that was given.
        value: f64,
        /// Description of the accepted values.
        expected: &'static str,
    },
    /// The residual did not fall to the tolerance.
    #[error(
        "contact at {} MPa did not converge: residual {residual:.1e} after {iterations} iterations, tolerance {tolerance:.0e}; choose \
         a larger tolerance or leave this pressure out", pressure_pa / 1e6
    )]
    NotConverged {
        /// Nominal pressure, in pascals.
        pressure_pa: f64,
        /// Lowest residual reached.
        residual: f64,
        /// Required residual.
        tolerance: f64,
        /// Number of iterations.
        iterations: usize,
    },
    /// The contact area falls while the pressure rises.
    #[error(
        "contact area falls from {} at {} MPa to {} at {} MPa, which is impossible; choose a smaller tolerance",
        area_fractions[0], pressures_pa[0] / 1e6, area_fractions[1], pressures_pa[1] / 1e6
    )]
    FallingArea {
        /// Two successive nominal pressures, in pascals.
        pressures_pa: [f64; 2],
        /// Area fractions computed at the two pressures.
        area_fractions: [f64; 2],
    },
    /// The height map is incomplete or otherwise unusable.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// Returns `value` if it lies in `range`; otherwise an error that quotes `expected`.
pub(crate) fn require_within(
    quantity: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<f64, ContactError> {
    if range.contains(&value) { Ok(value) } else { Err(ContactError::OutOfRange { quantity, value, expected }) }
}
