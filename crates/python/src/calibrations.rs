//! Calibrations: fits a material to measurements on samples, and learns from trials.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyType;
use slipgrid::calibrate::Selection;
use slipgrid::disk::{Disk, disk};
use slipgrid::formats::calibrated::{calibrate, learn};
use slipgrid::formats::calibration::Calibration as Read;
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::made_from::MadeFrom;
use slipgrid::formats::material::read_known;
use slipgrid::formats::scene::DEFAULT_SAMPLE;
use slipgrid::formats::source::Source;
use slipgrid::formats::written_material::material_toml;
use slipgrid::formats::{Diagnostic, Document};
use slipgrid::report::calibration::Fitted as Found;
use slipgrid::report::trials::TrialsReport;
use slipgrid::results::json;

use crate::errors::{Failure, failed};
use crate::origin::{Contents, Origin, Parts, to_absolute};
use crate::output::{Named, Told, contents};
use crate::progress::watched;
use crate::threads::{detached, in_pool};
use crate::warnings::warn_all;

/// Checks the material file at `path`, or `text` in its place; returns the text and its warnings.
#[pyfunction]
#[pyo3(signature = (path, text=None))]
pub fn read_material(py: Python<'_>, path: PathBuf, text: Option<String>) -> Result<(String, Vec<String>), Failure> {
    let read: Result<_, Diagnostic> = in_pool(py, || {
        let document = match text {
            Some(text) => Document::new(path, text),
            None => Document::read(&disk(), &path, FileKind::Material)?,
        };
        let (material, _) = read_known(&document, &document.parse()?, &(0..0))?;
        Ok((document.text().to_owned(), material.provenance.warnings))
    })?;
    Ok(read?)
}

/// A calibration, ready to be fitted.
#[pyclass(frozen, module = "slipgrid._slipgrid")]
pub struct Calibration {
    read: Read,
    inputs: Vec<PathBuf>,
    origin: Origin,
}

/// A fitted calibration.
#[pyclass(frozen, module = "slipgrid")]
pub struct Fitted {
    found: Found,
    path: PathBuf,
    disk: Disk,
}

#[pymethods]
impl Calibration {
    /// Parses the calibration in `text`, by default that of the file at `path`; relative paths in the text start from
    /// the folder of `path`. `objects` has contents by path that take precedence over files on disk. `copied`, for a
    /// copy: whether the text came from a file, and the contents of all its files; the disk is then not read.
    #[new]
    #[pyo3(signature = (text, path, objects=None, copied=None))]
    fn new(
        py: Python<'_>,
        text: Option<String>,
        path: PathBuf,
        objects: Option<Contents>,
        copied: Option<(bool, Contents)>,
    ) -> Result<Self, Failure> {
        let parse = |document| Read::from_document(&document);
        let (origin, read) =
            in_pool(py, || Origin::read(FileKind::Calibration, (text, objects, copied), path, parse))??;
        if !origin.is_copy {
            warn_all(py, &read.stated.notes)?;
        }
        Ok(Self { inputs: origin.inputs(&read.inputs), read, origin })
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the calibration, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyType>, Parts), Failure> {
        Ok((py.get_type::<Self>(), detached(py, || self.origin.parts())??))
    }

    fn __repr__(&self) -> String {
        format!("<slipgrid.Calibration {:?}>", self.read.stated.name)
    }

    /// Warnings about the calibration, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.read.stated.notes.clone()
    }

    /// Fits local coefficients to the flat samples and learns from trials. Returns fit.json and the material file as well.
    #[pyo3(signature = (progress=None))]
    fn fit(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> Result<([String; 2], Told, Fitted), Failure> {
        let (found, records) = watched(py, progress, |watch| {
            let (path, files) = (&self.origin.path, self.origin.source());
            let fit = calibrate(&self.read, path, &files, DEFAULT_SAMPLE, Selection::default(), watch)?;
            let found = Found::new(self.read.clone(), fit, watch)?;
            let material = material_toml(&found.task, &found.outcome, None).map_err(failed)?;
            let records = [found.fit_json().map_err(failed)?, material];
            Ok::<_, Failure>((found, records))
        })??;
        let of_material = &found.outcome.material.provenance.warnings;
        warn_all(py, of_material)?;
        let warnings = [self.read.stated.notes.clone(), of_material.clone()].concat();
        let told = (found.summary(), warnings, self.inputs.clone());
        Ok((records, told, Fitted { found, path: self.origin.path.clone(), disk: self.origin.disk.clone() }))
    }

    /// Ledger of the trials: JSON as `slipgrid trials --json` writes it, and text.
    #[pyo3(signature = (progress=None))]
    fn trials(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> Result<[String; 2], Failure> {
        let report = watched(py, progress, |watch| {
            let (task, learned) = learn(&self.read, &self.origin.path, &self.origin.source(), DEFAULT_SAMPLE, watch)?;
            Ok::<_, slipgrid::Failure>(TrialsReport::of_samples(&self.read, &task, &learned, watch)?)
        })??;
        warn_all(py, &report.warnings)?;
        Ok([json(&report).map_err(failed)?, report.text()])
    }
}

#[pymethods]
impl Fitted {
    /// The material file at `output`, with `[made_from]` if the calibration is a file.
    fn material_toml(&self, py: Python<'_>, output: PathBuf) -> Result<String, Failure> {
        let output = to_absolute(&self.disk, output);
        let files: Source = Arc::new(self.disk.clone());
        let made_from = MadeFrom::new(&self.found.calibration, &self.path, &output, &files);
        in_pool(py, || material_toml(&self.found.task, &self.found.outcome, made_from))?.map_err(failed)
    }

    /// All files of the fit that the command line writes, by name.
    fn files(&self, py: Python<'_>) -> Result<Vec<Named>, Failure> {
        contents(&in_pool(py, || self.found.files())?.map_err(failed)?)
    }
}
