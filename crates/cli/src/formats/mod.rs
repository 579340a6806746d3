//! File formats: types of their own, converted once into the validated types of the library crates.

pub mod calibration;
pub mod condition_ranges;
pub mod design;
pub mod discrepancy;
pub mod document;
pub mod file_kind;
pub mod laser;
pub mod limits;
pub mod material;
pub mod material_uncertainty;
pub mod measured;
pub mod measurements;
pub mod pattern;
pub mod run;
pub mod scene;
pub mod surface;
pub mod target;
pub mod tolerances;
pub mod trace_columns;
pub mod trace_file;
pub mod traces;
pub mod trade_offs;
pub mod unusual;
pub mod values;

pub use document::Document;
