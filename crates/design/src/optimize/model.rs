//! Failures of a model.

/// Reason why a model gives no result for a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelFailure {
    /// Failure of this design only, with the reason; the search continues.
    #[error("{0}")]
    Trial(String),
    /// Failure of all designs, with the reason: the search ends with an error.
    #[error("{0}")]
    Broken(String),
    /// Cancelled: the search ends with its best design so far.
    #[error("cancelled")]
    Cancelled,
}
