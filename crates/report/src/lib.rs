//! Results as people read them: charts, pages and tables drawn from records by their types, and the files of a laser.
//!
//! | module | role |
//! |---|---|
//! | [`charts`] | pictures of numbers, as SVG |
//! | [`html`] | pages that stand alone: report.html |
//! | [`pictures`], [`target`], [`trade_offs`], [`lattice`], [`csv`] | pictures and tables of one result |
//! | [`laser_files`] | what a laser takes, by format |
//! | [`Outputs`] | files of one result, in memory |
//!
//! This crate opens no files, reads no clock, prints nothing, and does not touch the environment.

pub mod charts;
pub mod csv;
pub mod html;
pub mod laser_files;
pub mod lattice;
mod outputs;
pub mod pages;
pub mod pictures;
pub mod target;
pub mod trade_offs;

pub use charts::ChartError;
pub use laser_files::{DrawingInput, LaserFile, draw, draw_with};
pub use outputs::{Content, Outputs};
