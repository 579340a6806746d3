//! Failures of a model.

/// Reason why a model gives no result for a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelFailure {
    /// Failure of this design only; the search continues.
    #[error("{reason}")]
    Trial {
        /// Reason of the failure.
        reason: String,
    },
    /// Failure of all designs: the search ends with an error.
    #[error("{reason}")]
    Broken {
        /// Reason of the failure.
        reason: String,
    },
    /// Cancelled: the search ends with its best design so far.
    #[error("cancelled")]
    Cancelled,
}
