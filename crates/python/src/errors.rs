//! Conversion of errors to exceptions of `slipgrid.errors`.

use pyo3::exceptions::{PyRuntimeError, PyTimeoutError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipgrid::campaign::CampaignError;
use slipgrid::design::DesignError;
use slipgrid::formats::Diagnostic;
use slipgrid::formats::calibrated::Uncalibrated;
use slipgrid::formats::design::Design;

/// `slipgrid.errors.InputError` with the position of the error and the accepted values; for a file that does not exist, its
/// subclass `MissingFileError`.
pub fn input(py: Python<'_>, refused: &Diagnostic) -> PyErr {
    of_class(py, if refused.is_absent { "MissingFileError" } else { "InputError" }, refused)
}

/// `slipgrid.errors.TooLargeError`, a subclass of `InputError` and of Python's `MemoryError`.
pub fn too_large(py: Python<'_>, refused: &Diagnostic) -> PyErr {
    of_class(py, "TooLargeError", refused)
}

fn of_class(py: Python<'_>, class: &str, refused: &Diagnostic) -> PyErr {
    let made = || {
        let named = PyDict::new(py);
        named.set_item("file", refused.file.as_ref().map(|file| file.display().to_string()))?;
        named.set_item("line", refused.line)?;
        named.set_item("key", refused.key.as_deref())?;
        named.set_item("value", refused.value.as_deref())?;
        named.set_item("expected", refused.expected.as_deref())?;
        py.import("slipgrid.errors")?.getattr(class)?.call((refused.to_string(),), Some(&named))
    };
    match made() {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// `slipgrid.errors.ComputationError`.
pub fn failed(py: Python<'_>, reason: &str) -> PyErr {
    let made = || py.import("slipgrid.errors")?.getattr("ComputationError")?.call1((reason,));
    match made() {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// Exception for work that was cancelled without a Python exception.
pub fn stopped() -> PyErr {
    PyRuntimeError::new_err("stopped")
}

/// Exception for a calibration that was refused or failed.
pub fn uncalibrated(py: Python<'_>, error: &Uncalibrated) -> PyErr {
    match error {
        Uncalibrated::Refused(refused) => input(py, refused),
        Uncalibrated::Cancelled => stopped(),
        Uncalibrated::Failed(reason) => failed(py, reason),
    }
}

/// Exception for a job of `design` that was refused or failed.
pub fn undesigned(py: Python<'_>, error: &DesignError, design: &Design) -> PyErr {
    match error {
        DesignError::Refused(refused) => input(py, &design.refuse(refused)),
        DesignError::Cancelled => stopped(),
        DesignError::OutOfTime(reason) => PyTimeoutError::new_err(reason.clone()),
        error => failed(py, &error.to_string()),
    }
}

/// Exception for a campaign that was refused or failed.
pub fn campaign(py: Python<'_>, error: &CampaignError) -> PyErr {
    match error {
        CampaignError::Refused(refused) => input(py, refused),
        CampaignError::Cancelled => stopped(),
        error => failed(py, &error.to_string()),
    }
}
