//! Errors of studies.

use slipgrid_base::monitor::Cancelled;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::calibrated::Failure;
use slipgrid_report::ChartError;

/// Error that ends a study without a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// Input was refused.
    #[error(transparent)]
    Input(#[from] Diagnostic),
    /// A picture could not be drawn.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// The monitor cancelled the study.
    #[error("cancelled")]
    Cancelled,
    /// Any other error.
    #[error("{0}")]
    Failed(String),
}

impl From<Cancelled> for StudyError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Failure> for StudyError {
    fn from(why: Failure) -> Self {
        match why {
            Failure::Refused(refused) => Self::Input(refused),
            Failure::Cancelled => Self::Cancelled,
            Failure::Failed(reason) => Self::Failed(reason),
        }
    }
}
