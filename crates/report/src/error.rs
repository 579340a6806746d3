//! Errors of making a report.

use slipgrid_design::results::NoJsonForm;
use slipgrid_io::formats::confirmed_scene::UnwritableScene;
use slipgrid_laser::export::ExportError;

use slipgrid_base::monitor::Cancelled;

use crate::ChartError;

/// Error of making a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A picture cannot be drawn.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// The specimen cannot be drawn.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The scene of a design cannot be written.
    #[error(transparent)]
    Scene(#[from] UnwritableScene),
    /// The monitor has cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A record has no JSON form.
    #[error(transparent)]
    Json(#[from] NoJsonForm),
}

impl From<Cancelled> for ReportError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
