//! Writing of files for Python: as on the command line, input files of a run and files of other programs are never replaced.

use std::io;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use slipgrid::disk::{Place, PlaceError};

use crate::errors;

/// Converts a refused path to `InputError`, and a system error to `OSError`.
fn misplaced(py: Python<'_>, error: &PlaceError) -> PyErr {
    match error {
        PlaceError::Refused(refused) => errors::input(py, refused),
        PlaceError::Unwritable(error) => io::Error::new(error.source.kind(), error.to_string()).into(),
    }
}

const fn folder_at(path: &Path) -> Place<'_> {
    Place { flag: "folder", path }
}

const fn file_at(path: &Path) -> Place<'_> {
    Place { flag: "path", path }
}

/// Writes `files`, by name, into `folder`, which is made if needed; `inputs` are files that the results were made from.
#[pyfunction]
pub fn write_folder(
    py: Python<'_>,
    files: Vec<(String, Vec<u8>)>,
    folder: PathBuf,
    inputs: Vec<PathBuf>,
) -> PyResult<()> {
    let written = py.detach(|| slipgrid::disk::write_folder(folder_at(&folder), &files, &inputs));
    written.map_err(|error| misplaced(py, &error))
}

/// Writes one file; `inputs` are files that the content was made from.
#[pyfunction]
pub fn write_file(py: Python<'_>, content: &[u8], path: PathBuf, inputs: Vec<PathBuf>) -> PyResult<()> {
    slipgrid::disk::write_file(file_at(&path), content, &inputs).map_err(|error| misplaced(py, &error))
}

/// Checks before a long computation that the file can be written; raises an error otherwise.
#[pyfunction]
pub fn check_file(py: Python<'_>, path: PathBuf, inputs: Vec<PathBuf>) -> PyResult<()> {
    slipgrid::disk::check_file(file_at(&path), &inputs).map_err(|error| misplaced(py, &error))
}
