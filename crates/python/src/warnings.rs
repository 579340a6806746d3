//! Python warnings for messages that the command line prints on stderr: doubtful input or results, and long computations.

use std::ffi::CString;

use pyo3::prelude::*;

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
    PyErr::warn(py, &class, &text, caller_level(py)?)
}

/// Stack level of the first caller outside the package, to which a warning belongs.
fn caller_level(py: Python<'_>) -> PyResult<i32> {
    let frame = py.import("sys")?.getattr("_getframe")?;
    let mut level = 0;
    while let Ok(frame) = frame.call1((level,)) {
        let module: String = frame.getattr("f_globals")?.get_item("__name__")?.extract()?;
        if module != "slipgrid" && !module.starts_with("slipgrid.") {
            break;
        }
        level += 1;
    }
    // A warning counts the calling frame as 1.
    Ok(level + 1)
}

/// Gives a warning for each of `doubts`, sentences about input or results.
#[pyfunction]
pub fn give_warnings(py: Python<'_>, doubts: Vec<String>) -> PyResult<()> {
    warn_all(py, &doubts)
}

/// Gives a Python warning for each of `doubts`.
///
/// # Errors
/// Same as [`warn`].
pub fn warn_all(py: Python<'_>, doubts: &[String]) -> PyResult<()> {
    doubts.iter().try_for_each(|doubt| warn(py, Category::Doubt, doubt))
}
