//! Refusals of tribometer exports.

use crate::cells::unquoted;
use crate::columns::UnknownUnit;

/// Reason why an export was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{reason}; expected {expected}", .line.map_or_else(String::new, |line| format!("line {line}: ")))]
pub struct ExportError {
    /// Line in the file, from 1; `None` for the file as a whole.
    pub line: Option<u32>,
    /// Column name, as in the file; `None` if no column is concerned.
    pub column: Option<String>,
    /// Text of the refused cell; `None` if no cell is concerned.
    pub value: Option<String>,
    /// Reason for the refusal.
    pub reason: String,
    /// Description of what is accepted.
    pub expected: String,
}

impl ExportError {
    pub(crate) fn at(line: Option<u32>, reason: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { line, column: None, value: None, reason: reason.into(), expected: expected.into() }
    }

    /// Creates the error for a column with an unknown unit in line `line`.
    pub(crate) fn unit(line: u32, unknown: &UnknownUnit) -> Self {
        let [reason, expected] = unknown.words();
        Self { column: Some(unknown.name.clone()), ..Self::at(Some(line), reason, expected) }
    }

    /// Creates the error for a cell of `column` in line `line` that is not a number.
    pub(crate) fn cell(line: u32, column: &str, cell: &str) -> Self {
        let has_digit = |part: &str| part.contains(|letter: char| letter.is_ascii_digit());
        let expected = if cell.contains(':') && cell.split(':').all(has_digit) {
            "seconds from the beginning, as 75.5, no time of day"
        } else {
            "a number, or nothing where it was not measured"
        };
        Self {
            column: Some(column.to_owned()),
            value: Some(format!("\"{}\"", unquoted(cell))),
            ..Self::at(Some(line), "is no number", expected)
        }
    }
}
