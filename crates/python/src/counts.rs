//! Conversion of counts, which in Python are integers of any size.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;

/// Maximum number of characters of an argument repeated in a message.
const LONGEST: usize = 30;

/// Converts the argument `name` to a count; `None` if it is negative or exceeds the range of `usize`.
pub fn to_count(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    match given.extract() {
        Ok(count) => Ok(Some(count)),
        Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => Ok(None),
        Err(_) => Err(PyTypeError::new_err(format!("{name} is {}: expected a whole number", shown(given)))),
    }
}

/// Formats an argument for a message.
pub fn shown(given: &Bound<'_, PyAny>) -> String {
    slipgrid::formats::diagnostic::printable(&given.to_string(), LONGEST)
}
