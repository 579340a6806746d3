//! Writing of files for Python: as on the command line, input files of a run and files of other programs are never replaced.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use slipgrid::disk::Place;
use slipgrid::report::{Content, Outputs};

use crate::errors::{Failure, failed};

/// Text of a result as the command line prints it, warnings about the input and the result, and files that it was made from.
pub type Told = (String, Vec<String>, Vec<PathBuf>);
/// Name and content of a file.
pub type Named = (String, Vec<u8>);

/// Contents of files by name.
///
/// # Errors
/// [`Failure`] if a content cannot be made.
pub fn contents(outputs: &Outputs) -> Result<Vec<Named>, Failure> {
    let content = |(name, content): (&str, &Content)| {
        let mut bytes = Vec::new();
        content(&mut bytes).map_err(failed)?;
        Ok((name.to_owned(), bytes))
    };
    outputs.iter().map(content).collect()
}

const fn file_at(path: &Path) -> Place<'_> {
    Place { flag: "path", path }
}

/// Writes `files`, by name, into `folder`, which is made if needed; neither `inputs`, the files that the results were
/// made from, nor files of other programs are replaced.
#[pyfunction]
pub fn write_folder(py: Python<'_>, files: Vec<Named>, folder: PathBuf, inputs: Vec<PathBuf>) -> Result<(), Failure> {
    Ok(py.detach(|| slipgrid::disk::write_folder(Place { flag: "folder", path: &folder }, &files, &inputs))?)
}

/// Writes one file; refuses to replace one of `inputs`, the files that the content was made from.
#[pyfunction]
pub fn write_file(content: &[u8], path: PathBuf, inputs: Vec<PathBuf>) -> Result<(), Failure> {
    Ok(slipgrid::disk::write_file(file_at(&path), content, &inputs, &|| false)?)
}

/// Checks before a long computation that the file can be written and is none of `inputs`; raises an error otherwise.
#[pyfunction]
pub fn check_file(path: PathBuf, inputs: Vec<PathBuf>) -> Result<(), Failure> {
    Ok(slipgrid::disk::check_file(file_at(&path), &inputs)?)
}
