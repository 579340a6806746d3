//! Python warnings for messages that the command line prints on stderr: doubtful input or results, and long computations.

use std::ffi::CString;

use pyo3::prelude::*;

/// Stack level of the caller: the called method of `slipgrid`, and its caller.
const CALLER: i32 = 2;

/// Category of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Doubtful input or results: `slipgrid.errors.SlipgridWarning`.
    Doubt,
    /// Time or memory: `slipgrid.errors.CostWarning`.
    Cost,
}

impl Category {
    const fn class(self) -> &'static str {
        match self {
            Self::Doubt => "SlipgridWarning",
            Self::Cost => "CostWarning",
        }
    }
}

/// Gives Python's caller the warning `text`.
///
/// # Errors
/// The warning itself if the caller's filters turn it into an exception.
pub fn warn(py: Python<'_>, category: Category, text: &str) -> PyResult<()> {
    let class = py.import("slipgrid.errors")?.getattr(category.class())?;
    // Zero bytes, the only cause of an error, were replaced.
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &class, &text, CALLER)
}

/// Gives a warning for each of `doubts`.
///
/// # Errors
/// Same as [`warn`].
pub fn warn_of(py: Python<'_>, doubts: &[String]) -> PyResult<()> {
    doubts.iter().try_for_each(|doubt| warn(py, Category::Doubt, doubt))
}
