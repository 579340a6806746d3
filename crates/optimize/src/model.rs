//! Why a model has no answer.

/// Why a design has no response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelFailure {
    /// This design cannot be computed; the next one may. The search goes on.
    #[error("{reason}")]
    Trial {
        /// What went wrong.
        reason: String,
    },
    /// No design can be computed: the search ends with an error.
    #[error("{reason}")]
    Broken {
        /// What went wrong.
        reason: String,
    },
    /// The model was asked to stop: the search ends with its best design so far.
    #[error("cancelled")]
    Cancelled,
}
