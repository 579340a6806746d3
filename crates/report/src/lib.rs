//! Presentation of results: charts, pages and tables drawn from typed records, and files for the laser.
//!
//! | module | role |
//! |---|---|
//! | [`charts`] | pictures of numbers, as SVG |
//! | [`files`] | all files of a design or a scene |
//! | [`html`] | self-contained pages: report.html |
//! | [`pictures`], [`csv`] | pictures and tables of one result |
//! | [`calibration`], [`area_law`], [`surface`], [`traces`] | reports on calibrations, contact, maps and tribometer traces |
//! | [`friction_sheet`], [`uncertainty_budget`] | what a publication states of measurements, and of uncertainty |
//! | [`linked_data`] | records for catalogues of data |
//! | [`laser_files`] | files for the laser, by format |
//!
//! The crate opens no files, reads no clock, prints nothing, and does not access the environment.

pub mod area_law;
pub mod calibration;
pub mod charts;
pub mod csv;
pub mod files;
pub mod friction_sheet;
pub mod html;
pub mod laser_files;
pub mod linked_data;
mod literature;
pub mod pictures;
pub mod surface;
pub mod traces;
pub mod trials;
pub mod uncertainty_budget;

pub use charts::ChartError;
pub use laser_files::{DrawingInput, LaserFile, Unwritten, draw, draw_next, draw_with};
pub use slipgrid_io::{Content, Failure, Outputs};
pub use slipgrid_laser::export::ProcessInput;

/// Formats every one of `lines` as a line that begins with `mark` and a blank.
pub fn marked<T: std::fmt::Display>(mark: &str, lines: impl IntoIterator<Item = T>) -> String {
    lines.into_iter().map(|line| format!("{mark} {line}\n")).collect()
}

impl From<ChartError> for Failure {
    fn from(error: ChartError) -> Self {
        Self::failed(error)
    }
}
