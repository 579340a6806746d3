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
    /// The residual did not reach the tolerance.
    #[error(
        "contact at {} MPa did not converge: residual {residual:.1e} after {iterations} iterations, tolerance {tolerance:.0e}; choose \
         a larger tolerance or leave this pressure out", pressure_pa / 1e6
    )]
    NotConverged {
        /// Nominal pressure, in pascals.
        pressure_pa: f64,
        /// The residual that was reached.
        residual: f64,
        /// The residual asked for.
        tolerance: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// The contact area falls where the pressure rises.
    #[error(
        "contact area falls from {} at {} MPa to {} at {} MPa, which is impossible; choose a smaller tolerance",
        area_fractions[0], pressures_pa[0] / 1e6, area_fractions[1], pressures_pa[1] / 1e6
    )]
    FallingArea {
        /// Two nominal pressures that follow each other, in pascals.
        pressures_pa: [f64; 2],
        /// The area fractions computed for them.
        area_fractions: [f64; 2],
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
