//! Reads the design of a result.json back as a pattern.

use std::path::Path;

use slipgrid_base::key_error::Refusal;
use slipgrid_design::results::PatternReport;
use slipgrid_model::pattern::Pattern;

use crate::formats::diagnostic::Diagnostic;

/// Pattern of the `design` in the result at `path`.
///
/// # Errors
/// [`Diagnostic`] at the key whose value gives no valid pattern.
pub fn stored_pattern(path: &Path, design: &PatternReport) -> Result<Pattern, Diagnostic> {
    design.pattern().map_err(|error| Diagnostic {
        key: Some(format!("design.{}", error.key).into()),
        value: match &error.refusal {
            Refusal::OutOfRange { value, .. } => Some(value.to_string().into()),
            Refusal::UnknownName { name, .. } => Some(format!("\"{name}\"").into()),
            Refusal::Missing | Refusal::Rule { .. } => None,
        },
        expected: error.refusal.expected().map(Into::into),
        ..Diagnostic::file(path, error.refusal.to_string())
    })
}
