//! Why a campaign could not be planned, done or merged.

use std::io;
use std::path::PathBuf;

use slipgrid_formats::Diagnostic;

/// Why a campaign could not be planned, done or merged.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file was refused.
    #[error(transparent)]
    Refused(#[from] Diagnostic),
    /// A file could not be written.
    #[error("{path}: cannot be written: {source}", path = path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}
