//! Why a report could not be made.

use slipgrid_results::NoJsonForm;

use crate::ChartError;

/// Why a report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A picture cannot be drawn.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// A record has no JSON form.
    #[error(transparent)]
    Json(#[from] NoJsonForm),
}
