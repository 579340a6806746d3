//! Errors of planning, working on or merging a campaign.

use crate::disk::WriteError;
use crate::formats::Diagnostic;
use crate::formats::calibrated::Failure;

/// Reason why a campaign could not be planned, worked on or merged.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file was refused.
    #[error(transparent)]
    Refused(#[from] Diagnostic),
    /// Results in the campaign's folder are damaged.
    #[error("{} damaged {}; `slipgrid campaign work` on the same folder does their tasks again:{}",
        .0.len(), if .0.len() == 1 { "result" } else { "results" }, lines(.0))]
    Damaged(Vec<Diagnostic>),
    /// A file could not be written.
    #[error(transparent)]
    Unwritable(#[from] WriteError),
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
    /// Another error, described by the text.
    #[error("{0}")]
    Failed(String),
}

impl From<Failure> for CampaignError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Refused(refused) => Self::Refused(refused),
            Failure::Cancelled => Self::Cancelled,
            Failure::Failed(reason) => Self::Failed(reason),
        }
    }
}

/// Joins diagnostics, each on a line of its own.
fn lines(damaged: &[Diagnostic]) -> String {
    damaged.iter().map(|one| format!("\n  {one}")).collect()
}
