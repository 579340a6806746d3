//! What the command line says on stderr, as warnings of Python: of doubtful input and results, and of what takes long.

use std::ffi::CString;

use pyo3::prelude::*;

/// Frames from here to the caller: the method of `slipgrid` that called, and who called it.
const CALLER: i32 = 2;

/// What a warning is about.
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

/// Warns Python's caller of `text`.
///
/// # Errors
/// The warning itself where the caller's filters make it an exception.
pub fn warn(py: Python<'_>, category: Category, text: &str) -> PyResult<()> {
    let class = py.import("slipgrid.errors")?.getattr(category.class())?;
    // The zeros are gone: nothing else is refused.
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &class, &text, CALLER)
}

/// Warns of each of `doubts`.
///
/// # Errors
/// As [`warn`].
pub fn warn_of(py: Python<'_>, doubts: &[String]) -> PyResult<()> {
    doubts.iter().try_for_each(|doubt| warn(py, Category::Doubt, doubt))
}
