/// Why nothing can be exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// A number that is not positive and finite.
    #[error("{quantity} is {value}: expected a positive number")]
    NotPositive {
        /// The quantity, its unit in its name.
        quantity: &'static str,
        /// The value given, in that unit.
        value: f64,
    },
    /// The specimen is too small for a single cavity.
    #[error(
        "no cavity {width_m:e} m wide fits whole on the specimen: \
         expected an extent of at least {needed_m:e} m, but it is {extent_m:e} m"
    )]
    NoCavityFits {
        /// Width of a cavity, in metres.
        width_m: f64,
        /// Extent of the specimen that falls short, in metres.
        extent_m: f64,
        /// Extent on which one cavity fits, in metres.
        needed_m: f64,
    },
    /// More cavities than any file of them could be used for.
    #[error("about {cavities:.0} cavities fit on the specimen: expected at most {most}")]
    TooManyCavities {
        /// Estimate of their number.
        cavities: f64,
        /// The limit.
        most: usize,
    },
    /// The process sheet could not be written as TOML.
    #[error("the process sheet cannot be written as TOML: {reason}")]
    Unwritable {
        /// What the TOML writer said.
        reason: String,
    },
}

/// `value` if it is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, ExportError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(ExportError::NotPositive { quantity, value }) }
}
