//! Conversion of numeric arguments: integers of any size, and arrays of real numbers.

use numpy::{AllowTypeChange, PyArrayLike2};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;

/// NumPy kinds of arrays that may hold real numbers: floating point, signed, unsigned, and object.
const REAL: [&str; 4] = ["f", "i", "u", "O"];
/// Maximum number of characters of an argument repeated in a message.
const LONGEST: usize = 30;

/// Converts the argument `name` to a count; `None` if it is negative or exceeds the range of `usize`.
pub fn counted(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
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

/// Converts the argument `name` to an array of rows of real numbers of any numeric type; `expected` describes accepted values.
pub fn rows<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
    expected: &str,
) -> PyResult<PyArrayLike2<'py, f64, AllowTypeChange>> {
    let refused = || PyTypeError::new_err(format!("{name} is no array of numbers: {expected}"));
    let numpy = given.py().import("numpy")?;
    let array = numpy.call_method1("asanyarray", (given,)).map_err(|_| refused())?;
    if numpy.getattr("ma")?.call_method1("is_masked", (&array,))?.is_truthy()? {
        return Err(PyValueError::new_err(format!("{name} has masked numbers: {expected}, none of them masked")));
    }
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !REAL.contains(&kind.as_str()) {
        return Err(refused());
    }
    array.extract().map_err(|_| refused())
}
