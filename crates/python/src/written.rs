//! Files that Python has written: nothing is replaced that a run reads or that slipgrid did not write, as on the command line.

use std::io;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use slipgrid_disk::{Place, PlaceError};

use crate::refused;

/// What was refused as `InputError`; what the system refuses as `OSError`.
fn misplaced(py: Python<'_>, error: &PlaceError) -> PyErr {
    match error {
        PlaceError::Refused(refused) => refused::input(py, refused),
        PlaceError::Unwritable(error) => io::Error::new(error.source.kind(), error.to_string()).into(),
    }
}

const fn folder_at(path: &Path) -> Place<'_> {
    Place { flag: "folder", path }
}

const fn file_at(path: &Path) -> Place<'_> {
    Place { flag: "path", path }
}

/// Writes `files`, by name, into `folder`, made where there is none; `inputs` are files that the results were made from.
#[pyfunction]
pub fn write_folder(
    py: Python<'_>,
    files: Vec<(String, Vec<u8>)>,
    folder: PathBuf,
    inputs: Vec<PathBuf>,
) -> PyResult<()> {
    let written = py.detach(|| slipgrid_disk::write_folder(folder_at(&folder), &files, &inputs));
    written.map_err(|error| misplaced(py, &error))
}

/// Writes one file; `inputs` are files that it was made from.
#[pyfunction]
pub fn write_file(py: Python<'_>, content: &[u8], path: PathBuf, inputs: Vec<PathBuf>) -> PyResult<()> {
    slipgrid_disk::write_file(file_at(&path), content, &inputs).map_err(|error| misplaced(py, &error))
}

/// Refuses, before long work starts, a file that could not be written then.
#[pyfunction]
pub fn check_file(py: Python<'_>, path: PathBuf, inputs: Vec<PathBuf>) -> PyResult<()> {
    slipgrid_disk::check_file(file_at(&path), &inputs).map_err(|error| misplaced(py, &error))
}
