//! Records of results: one type per concept, with units in the names of fields, and the sentences that describe them.
//!
//! A record is the content of `result.json`. Text tables, charts and pages are drawn from the same type, so that a
//! renamed field breaks the build instead of a page.
//!
//! | type | holds |
//! |---|---|
//! | [`PatternReport`] | texture |
//! | [`SimulationReport`], [`LoadReport`] | results of a scene, and at one pressure |
//! | [`ErrorsReport`], [`PressureErrors`], [`ErrorReport`] | errors of results, and their parts |
//! | [`CorrectedReport`] | results corrected by the discrepancy of patterned samples |
//! | [`Table`] | numbers in columns of text |
//! | [`json`], [`json_and_timings`] | records as JSON, with and without the values that differ from run to run |
//!
//! This module opens no files, reads no clock, prints nothing, and does not touch the environment.
//!
//! ```
//! use slipgrid_design::results::{Table, fixed, with_error};
//! // The error is a standard deviation with as many decimals; a number that is not known is a dash.
//! assert_eq!(with_error(0.91531, Some(0.01144), 4), "0.9153 +- 0.0114");
//! let mut table = Table::new(["P MPa", "ratio"]);
//! table.row([fixed(Some(2.6), 1), fixed(None, 4)]);
//! assert_eq!(table.to_string(), "  P MPa  ratio\n    2.6      -\n");
//! ```

mod believed;
mod corrected;
mod csv;
pub mod errors;
mod notes;
mod pattern;
mod simulation;
mod simulation_text;
mod table;
mod timings;

pub use believed::{BELIEVED, believed, believed_interval, believed_std};
pub use corrected::{CorrectedAt, CorrectedReport};
pub use csv::guard_formula;
pub use errors::{ErrorReport, ErrorsReport, PartsReport, PressureErrors};
pub use notes::{ABOUT_MATERIAL, SCREEN_WIDTH, WHERE_ALL, doubt_in_brief, doubts_in_brief, notes, wrapped};
pub use pattern::{PatternReport, duration_in_words, length_in_words};
pub use simulation::{
    LoadReport, SimulationReport, beyond_measured, beyond_measured_range, load_reports, material_doubts,
    measured_range, section_note, unresolved, warnings,
};
pub use slipgrid_laser::export::MadeBy;
pub use table::{Records, Table, fixed, with_error};
pub use timings::{TIMES, json_and_timings};

/// Version of the program, written into every file.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Schema version of files that are written and may be read back. After the first release it increases when a key is
/// removed or changes its meaning, not when a key is added. Files without a schema version have version 1.
pub const SCHEMA: u32 = 1;

/// Error of a record that cannot be written as JSON.
#[derive(Debug, thiserror::Error)]
#[error("the result has no JSON form: {0}")]
pub struct NoJsonForm(serde_json::Error);

/// Formats `value` as indented JSON with a newline at the end; numbers that are not finite become null.
///
/// # Errors
/// [`NoJsonForm`] if a value cannot be written as JSON.
pub fn json(value: &impl serde::Serialize) -> Result<String, NoJsonForm> {
    serde_json::to_string_pretty(value).map(|text| text + "\n").map_err(NoJsonForm)
}
