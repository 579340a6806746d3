//! Results as files and people read them.

pub mod corrected;
pub mod csv;
pub mod errors;
pub mod html;
pub mod simulation;
pub mod specimen;
pub mod table;
pub mod timings;

pub use table::Table;
pub use timings::json_and_timings;

/// The program's version, for everything that is written.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// `value` as indented JSON with a newline at the end; numbers that are not finite become null.
///
/// # Errors
/// [`crate::CliError::Other`] if a value has no JSON form.
pub fn json(value: &impl serde::Serialize) -> Result<String, crate::CliError> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| crate::CliError::Other(format!("the result has no JSON form: {error}")))
}
