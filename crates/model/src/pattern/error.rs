use crate::pattern::Planform;

/// Reason why a texture or a pattern was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatternError {
    /// A property was set that cavities of the planform do not have.
    #[error("{property} has no meaning for planform \"{planform}\": expected {expected}")]
    NoSuchProperty {
        /// Name of the property, for example `a length`, `an outline`, `a staggered arrangement` or `a groove angle`.
        property: &'static str,
        /// Planform of the cavities.
        planform: Planform,
        /// Description of the planforms or settings that are accepted.
        expected: &'static str,
    },
    /// A number out of range, an outline that encloses nothing or meets itself, rows that overlap, or a relief that does
    /// not fit the pattern, in words.
    #[error("{0}")]
    Refused(String),
}

/// Returns `value_m` if it is a positive, finite length, and an error that names `quantity` otherwise.
pub(crate) fn length(quantity: &str, value_m: f64) -> Result<f64, PatternError> {
    if value_m.is_finite() && value_m > 0.0 {
        return Ok(value_m);
    }
    Err(PatternError::Refused(format!("{quantity} of {} um is not a positive length", um(value_m))))
}

/// Converts a length to um and rounds it to 12 digits, which removes the rounding errors of unit conversions.
pub(crate) fn um(length_m: f64) -> f64 {
    let length_um = length_m * 1e6;
    format!("{length_um:.11e}").parse().unwrap_or(length_um)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_units_of_files() {
        for (value_m, says) in [(-1.3e-4, "width of -130 um is"), (0.0, "width of 0 um is"), (f64::NAN, "of NaN um")] {
            let refused = length("width", value_m).unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
