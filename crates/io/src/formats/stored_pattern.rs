//! Converts the design and the specimen stored in a result.json.

use std::path::Path;

use serde::Serialize;
use slipgrid_base::key_error::{KeyError, Refusal};
use slipgrid_design::results::PatternReport;
use slipgrid_laser::export::{Specimen, SpecimenRecord};
use slipgrid_model::pattern::Pattern;

use crate::formats::diagnostic::Diagnostic;

/// Pattern of the `design` in the result at `path`.
///
/// # Errors
/// [`Diagnostic`] at the key whose value gives no valid pattern.
pub fn stored_pattern(path: &Path, design: &PatternReport) -> Result<Pattern, Diagnostic> {
    design.pattern().map_err(|error| refuse(path, ("design", design), &error))
}

/// Specimen of the result at `path`.
///
/// # Errors
/// [`Diagnostic`] at the key whose value gives no valid specimen.
pub fn stored_specimen(path: &Path, specimen: &SpecimenRecord) -> Result<Specimen, Diagnostic> {
    specimen.specimen().map_err(|error| refuse(path, ("specimen", specimen), &error))
}

/// Creates a diagnostic for `error`, which concerns a key of `record`, the table `name` of the result at `path`.
fn refuse(path: &Path, (name, record): (&str, &impl Serialize), error: &KeyError) -> Diagnostic {
    let value = serde_json::to_value(record).ok().and_then(|record| record.get(error.key).cloned());
    let value = value.map(|value| match &error.refusal {
        // The number of the list that is refused.
        Refusal::OutOfRange { value: number, .. } if value.is_array() => number.to_string(),
        _ => value.to_string(),
    });
    Diagnostic {
        key: Some(format!("{name}.{}", error.key).into()),
        value: value.map(Into::into),
        expected: error.refusal.expected().map(Into::into),
        ..Diagnostic::file(path, error.refusal.to_string())
    }
}
