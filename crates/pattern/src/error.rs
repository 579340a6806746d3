use crate::Planform;

/// Why a texture or a pattern was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatternError {
    /// A length that is not a positive, finite number.
    #[error("{quantity} of {value_m} m is not a positive length")]
    NotALength {
        /// `width`, `spacing`, `depth`, `length` or `spacing across`.
        quantity: &'static str,
        /// The value given, in metres.
        value_m: f64,
    },
    /// An angle outside its range.
    #[error("{quantity} of {value_deg} degrees: expected -{most_deg} to {most_deg}")]
    AngleOutOfRange {
        /// `groove angle` or `sliding angle`.
        quantity: &'static str,
        /// The value given, in degrees.
        value_deg: f64,
        /// The largest accepted, in degrees.
        most_deg: f64,
    },
    /// A property that cavities of this planform do not have.
    #[error("{property} has no meaning for planform \"{planform}\": expected {expected}")]
    NoSuchProperty {
        /// `a length`, `a spacing across`, `a staggered arrangement` or `a groove angle`.
        property: &'static str,
        /// The planform.
        planform: Planform,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A planform that this version does not know.
    #[error("unknown planform \"{name}\": expected \"groove\", \"square\", \"rectangle\" or \"disc\"")]
    UnknownPlanform {
        /// The name given.
        name: String,
    },
    /// An arrangement that this version does not know.
    #[error("unknown arrangement \"{name}\": expected \"square\" or \"staggered\"")]
    UnknownArrangement {
        /// The name given.
        name: String,
    },
}

/// `value_m` if it is a positive, finite length.
pub(crate) fn length(quantity: &'static str, value_m: f64) -> Result<f64, PatternError> {
    if value_m.is_finite() && value_m > 0.0 { Ok(value_m) } else { Err(PatternError::NotALength { quantity, value_m }) }
}
