//! Presentation of results: charts, pages and tables drawn from typed records, and files for the laser.
//!
//! | module | role |
//! |---|---|
//! | [`charts`] | pictures of numbers, as SVG |
//! | [`files`] | all files of a design or a scene |
//! | [`html`] | self-contained pages: report.html |
//! | [`pictures`], [`target`], [`trade_offs`], [`lattice`], [`csv`] | pictures and tables of one result |
//! | [`calibration`], [`area_law`], [`surface`], [`traces`] | reports on calibrations, contact, maps and tribometer traces |
//! | [`laser_files`] | files for the laser, by format |
//! | [`Outputs`] | files of one result, in memory |
//!
//! The crate opens no files, reads no clock, prints nothing, and does not access the environment.
//!
//! ```
//! use slipgrid_report::Outputs;
//! let mut outputs = Outputs::default();
//! outputs.add("ratio.csv", "pressure_mpa,ratio\n2.6,0.83\n");
//! assert_eq!(outputs.names(), ["ratio.csv"]);
//! assert!(outputs.text("ratio.csv").is_some_and(|text| text.ends_with("0.83\n")));
//! ```

pub mod area_law;
pub mod calibration;
pub mod charts;
pub mod csv;
mod error;
pub mod files;
pub mod html;
pub mod laser_files;
pub mod lattice;
mod outputs;
pub mod pictures;
pub mod surface;
pub mod target;
pub mod traces;
pub mod trade_offs;
pub mod trials;
pub mod written;

pub use charts::ChartError;
pub use error::ReportError;
pub use laser_files::{DrawingInput, LaserFile, Unwritten, draw, draw_next, draw_with};
pub use outputs::{Content, Outputs};
