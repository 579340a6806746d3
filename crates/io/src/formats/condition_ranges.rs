//! Speeds and humidities at which a design must meet its target, each a number or a range.

use crate::formats::spanned::Spanned;
use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_model::material::ConditionRange;

use super::document::Document;
use super::values::{Numbers, range};
use crate::formats::diagnostic::Diagnostic;
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S};

/// A condition or a range of conditions in the form of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionRangeFile {
    /// Sliding speed: one number, or minimum and maximum.
    speed_mm_s: Spanned<Numbers>,
    /// Relative humidity: one number, or minimum and maximum.
    humidity_pct: Spanned<Numbers>,
}

impl ConditionRangeFile {
    /// Humidity as written.
    pub(crate) const fn humidity(&self) -> &Spanned<Numbers> {
        &self.humidity_pct
    }
}

/// Reads a condition or a range of conditions.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, a list has not two entries, or the ends are in the wrong order.
pub fn read_conditions(document: &Document, file: &ConditionRangeFile) -> Result<ConditionRange, Diagnostic> {
    const EXPECTED: &str = "one number, or [lowest, highest]";
    let speed_m_s = range(document, &file.speed_mm_s, SPEED_MM_S, EXPECTED)?;
    let humidity = range(document, &file.humidity_pct, HUMIDITY_PCT, EXPECTED)?;
    ConditionRange::new(speed_m_s, humidity).map_err(|error| document.refuse(file.speed_mm_s.span(), error.to_string()))
}
