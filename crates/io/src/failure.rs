//! Reasons why work on files gave no result.

use slipgrid_base::monitor::Cancelled;
use slipgrid_design::results::NoJsonForm;

use crate::disk::WriteError;
use crate::formats::Diagnostic;

/// Reason why work on files gave no result.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A file was refused, or a result would replace a file that must not be lost.
    #[error(transparent)]
    Refused(#[from] Diagnostic),
    /// Several files were refused, as the text says.
    #[error("{0}")]
    SeveralRefused(String),
    /// A file could not be written.
    #[error(transparent)]
    Unwritable(#[from] WriteError),
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
    /// Anything else, as the text says.
    #[error("{0}")]
    Failed(String),
}

impl Failure {
    /// Creates a failure with the text of `error`.
    pub fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<NoJsonForm> for Failure {
    fn from(error: NoJsonForm) -> Self {
        Self::failed(error)
    }
}
