//! Errors of calls, as exceptions of `slipgrid.errors`.

use std::fmt::Display;

use pyo3::exceptions::{PyRuntimeError, PyTimeoutError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipgrid::design::DesignError;
use slipgrid::formats::Diagnostic;
use slipgrid::formats::design::Design;
use slipgrid::monitor::Cancelled;

/// Error of a call.
pub enum Failure {
    /// `InputError` with the position of the error and the accepted values; for a file that does not exist, its subclass
    /// `MissingFileError`.
    Refused(Diagnostic),
    /// `TooLargeError`, a subclass of `InputError` and of Python's `MemoryError`.
    TooLarge(Diagnostic),
    /// `ComputationError`.
    Failed(String),
    /// Exception for work that was cancelled without a Python exception.
    Stopped,
    /// Any other exception, such as `OSError` for a file that cannot be written.
    Raised(PyErr),
}

/// `ComputationError` with the reason.
pub fn failed(reason: impl Display) -> Failure {
    Failure::Failed(reason.to_string())
}

/// Converts the error of a search for `design` to the error of a call.
pub fn undesigned(error: DesignError, design: &Design) -> Failure {
    match error {
        DesignError::Refused(refused) => Failure::Refused(design.refuse(&refused)),
        DesignError::Cancelled => Failure::Stopped,
        DesignError::OutOfTime(reason) => Failure::Raised(PyTimeoutError::new_err(reason)),
        error => failed(error),
    }
}

impl From<Diagnostic> for Failure {
    fn from(refused: Diagnostic) -> Self {
        Self::Refused(refused)
    }
}

impl From<PyErr> for Failure {
    fn from(raised: PyErr) -> Self {
        Self::Raised(raised)
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Stopped
    }
}

impl From<slipgrid::Failure> for Failure {
    fn from(failure: slipgrid::Failure) -> Self {
        match failure {
            slipgrid::Failure::Refused(refused) => Self::Refused(refused),
            slipgrid::Failure::Unwritable(error) => {
                Self::Raised(std::io::Error::new(error.source.kind(), error.to_string()).into())
            }
            slipgrid::Failure::Cancelled => Self::Stopped,
            error => failed(error),
        }
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let (class, refused) = match failure {
            Failure::Refused(refused) if refused.is_absent => ("MissingFileError", refused),
            Failure::Refused(refused) => ("InputError", refused),
            Failure::TooLarge(refused) => ("TooLargeError", refused),
            Failure::Failed(reason) => {
                return Python::attach(|py| made(py, "ComputationError", &in_python(&reason), None));
            }
            Failure::Stopped => return PyRuntimeError::new_err("stopped"),
            Failure::Raised(raised) => return raised,
        };
        Python::attach(|py| made(py, class, &in_python(&refused.to_string()), Some(&refused)))
    }
}

/// Commands that messages of the library name, and what takes their place in Python.
const IN_PYTHON: [(&str, &str); 7] = [
    ("`slipgrid simulate`", "`Scene`"),
    ("`slipgrid optimize`", "`Design`"),
    ("`slipgrid calibrate`", "`Calibration`"),
    ("`slipgrid campaign plan`", "`slipgrid.campaign`"),
    ("`slipgrid surface` and `area-law` take", "`Map` takes"),
    ("`traces` a recording", "`Calibration` recordings"),
    (", which `slipgrid export` takes", ""),
];

/// Puts a `message` of the library in terms of Python: classes in place of commands, and arguments in place of options,
/// `pixel_um` for `--pixel-um`.
fn in_python(message: &str) -> String {
    let said = IN_PYTHON.iter().fold(message.to_owned(), |said, (command, here)| said.replace(command, here));
    let mut parts = said.split("--");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-').unwrap_or(part.len());
        let is_option = end > 0 && text.chars().next_back().is_none_or(|before| " (".contains(before));
        let (option, rest) = part.split_at(if is_option { end } else { 0 });
        text += &if is_option { option.replace('-', "_") } else { "--".to_owned() };
        text += rest;
    }
    text
}

/// Makes an exception of `slipgrid.errors`, with the position and the accepted values of refused input.
fn made(py: Python<'_>, class: &str, reason: &str, refused: Option<&Diagnostic>) -> PyErr {
    let made = || {
        let named = PyDict::new(py);
        if let Some(refused) = refused {
            named.set_item("file", refused.file.as_ref().map(|file| file.display().to_string()))?;
            named.set_item("line", refused.line)?;
            named.set_item("key", refused.key.as_deref())?;
            named.set_item("value", refused.value.as_deref())?;
            named.set_item("expected", refused.expected.as_deref().map(in_python))?;
        }
        py.import("slipgrid.errors")?.getattr(class)?.call((reason,), Some(&named))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}
