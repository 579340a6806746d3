use crate::export::six_digits;

/// Reason why nothing can be exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// The specimen is too small for a cavity.
    #[error(
        "no cavity {} um wide fits whole on the specimen: expected an extent of at least {} mm, but it is {} mm",
        mm(1e3 * width_m), mm(*needed_m), mm(*extent_m)
    )]
    NoCavityFits {
        /// Width of a cavity, in metres.
        width_m: f64,
        /// Extent of the specimen that is too small, in metres.
        extent_m: f64,
        /// Minimum extent for one cavity, in metres.
        needed_m: f64,
    },
    /// The specimen is shorter than a period, so that it shows nothing of the pattern.
    #[error("the pattern repeats every {} mm, more than the specimen's {} mm", mm(*pitch_m), mm(*extent_m))]
    NoPeriodFits {
        /// Pitch of the pattern, in metres.
        pitch_m: f64,
        /// Largest extent of the specimen, in metres.
        extent_m: f64,
    },
    /// There are too many cavities for a usable file.
    #[error("about {cavities:.0} cavities fit on the specimen: expected at most {most}")]
    TooManyCavities {
        /// Estimated number of cavities.
        cavities: f64,
        /// Maximum number of cavities.
        most: usize,
    },
    /// The laser cannot make a pattern, or a setting is out of range.
    #[error("{what} of {} um is {relation} {limit}, {} um", six_digits(*value_um), six_digits(*limit_um))]
    BeyondLaser {
        /// Name of the quantity that is out of range.
        what: &'static str,
        /// Value of the quantity, in um.
        value_um: f64,
        /// `above` or `below`: side of the limit on which the value lies.
        relation: &'static str,
        /// Name of the limit, for example `spot_um`.
        limit: &'static str,
        /// The limit, in um.
        limit_um: f64,
    },
    /// Pulses along a line do not touch.
    #[error(
        "pulses lie {} um apart, speed_mm_s = {speed_mm_s} over repetition_hz = {repetition_hz}, and do not meet: expected at most spot_um, {} um",
        six_digits(*pulse_um), six_digits(*spot_um)
    )]
    PulsesApart {
        /// Distance between pulses, in um.
        pulse_um: f64,
        /// Speed of the spot, in mm/s.
        speed_mm_s: f64,
        /// Pulse repetition rate, in Hz.
        repetition_hz: f64,
        /// Diameter of the spot, in um.
        spot_um: f64,
    },
    /// Any other reason, in words: a number out of range, a missing key that a format needs, or a layout that a format
    /// cannot hold.
    #[error("{0}")]
    Refused(String),
}

impl ExportError {
    /// Creates the error for a number out of range; `value` is in the unit that the name `quantity` states.
    pub(crate) fn out_of_range(quantity: &str, value: f64, expected: &str) -> Self {
        Self::Refused(format!("{quantity} is {}: expected {expected}", six_digits(value)))
    }
}

/// Checks that `value` is finite and positive; the error names `quantity`.
pub(crate) fn positive(quantity: &str, value: f64) -> Result<(), ExportError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(ExportError::out_of_range(quantity, value, "a positive number"))
}

/// Checks that every given value is finite and positive; the error names the quantity.
pub(crate) fn all_positive(all: impl IntoIterator<Item = (&'static str, Option<f64>)>) -> Result<(), ExportError> {
    all.into_iter().try_for_each(|(quantity, value)| value.map_or(Ok(()), |value| positive(quantity, value)))
}

/// Converts metres to millimetres, rounded for messages.
pub(crate) fn mm(length_m: f64) -> f64 {
    six_digits(length_m * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_units_of_files() {
        let refused = ExportError::NoCavityFits { width_m: 4e-4, extent_m: 0.3e-3, needed_m: 0.1 + 0.2 };
        assert_eq!(
            refused.to_string(),
            "no cavity 400 um wide fits whole on the specimen: expected an extent of at least 300 mm, but it is 0.3 mm"
        );
        let refused =
            ExportError::NoCavityFits { width_m: 7e-3, extent_m: 6e-3, needed_m: 7e-3 * std::f64::consts::SQRT_2 };
        assert!(refused.to_string().contains("expected an extent of at least 9.89949 mm, but it is 6 mm"), "{refused}");
    }
}
