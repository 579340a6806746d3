//! Numbers that arguments give: whole ones of any size, and arrays of real ones.

use numpy::{AllowTypeChange, PyArrayLike2};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Kinds of arrays that hold real numbers: of floating point, whole, without sign, and objects that may be any of them.
const REAL: [&str; 4] = ["f", "i", "u", "O"];
/// Letters of a number that a message repeats.
const LONGEST: usize = 30;

/// The argument `name` as a count; nothing where it is below 0 or beyond what a processor counts.
pub fn counted(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    match given.extract() {
        Ok(count) => Ok(Some(count)),
        Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => Ok(None),
        Err(_) => Err(PyTypeError::new_err(format!("{name} is {}: expected a whole number", shown(given)))),
    }
}

/// What was given, as a message repeats it.
pub fn shown(given: &Bound<'_, PyAny>) -> String {
    slipgrid::formats::diagnostic::printable(&given.to_string(), LONGEST)
}

/// The argument `name` as an array of rows of real numbers, of any type that these have; `expected` says what is accepted.
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
