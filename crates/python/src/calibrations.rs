//! Calibrations: fits a material to measurements on samples, and learns from trials.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyType;
use slipgrid::calibrate::{CalibrationOutcome, CalibrationTask, Selection};
use slipgrid::disk::disk;
use slipgrid::formats::calibrated::{Uncalibrated, calibrate, learn};
use slipgrid::formats::calibration::Calibration as Read;
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::made_from::MadeFrom;
use slipgrid::formats::material_uncertainty::read_known;
use slipgrid::formats::scene::DEFAULT_SPECIMEN;
use slipgrid::formats::written_material::material_toml;
use slipgrid::formats::{Diagnostic, Document};
use slipgrid::report::calibration::{files, fit_json, ledger, summary};
use slipgrid::report::trials::TrialsReport;
use slipgrid::results::json;

use crate::errors;
use crate::origin::{Anchored, Contents, Origin};
use crate::progress::watched;
use crate::threads::{detached, in_pool};
use crate::warnings::warn_all;

/// Seed of the flat sample's local coefficients.
const SEED: u64 = 1;

/// Checks the material file at `path`, or `text` in its place; returns the text and its warnings.
#[pyfunction]
#[pyo3(signature = (path, text=None))]
pub fn read_material(py: Python<'_>, path: PathBuf, text: Option<String>) -> PyResult<(String, Vec<String>)> {
    let read = in_pool(py, || {
        let document = match text {
            Some(text) => Document::new(path, text),
            None => Document::read(&disk(), &path, FileKind::Material)?,
        };
        let (material, _) = read_known(&document, &document.parse()?, &(0..0))?;
        Ok((document.text().to_owned(), material.provenance.warnings))
    })?;
    read.map_err(|error: Diagnostic| errors::input(py, &error))
}

/// A calibration, ready to be fitted.
#[pyclass(frozen, module = "slipgrid._slipgrid")]
pub struct Calibration {
    read: Read,
    inputs: Vec<PathBuf>,
    origin: Origin,
}

/// Text and path of a calibration, whether the path is a file, and the files that the calibration reads.
type Parts<'a> = (&'a str, OsString, bool, Contents);

/// A fitted calibration.
#[pyclass(frozen, module = "slipgrid")]
pub struct Fitted {
    read: Read,
    path: PathBuf,
    disk: Anchored,
    inputs: Vec<PathBuf>,
    task: CalibrationTask,
    outcome: CalibrationOutcome,
    ledger: Option<TrialsReport>,
}

impl Calibration {
    fn of(py: Python<'_>, origin: Origin, warns: bool) -> PyResult<Self> {
        let read = in_pool(py, || Read::from_document(&origin.document(FileKind::Calibration)?))?;
        let read = read.map_err(|error| errors::input(py, &error))?;
        let inputs = origin.inputs(&read.inputs);
        if warns {
            warn_all(py, &read.told)?;
        }
        Ok(Self { read, inputs, origin })
    }
}

#[pymethods]
impl Calibration {
    /// Parses the calibration in `text` as a file at `path`; relative paths in the text start from the folder of `path`.
    /// `is_file` states that the file exists; `files` are the only available files, and None stands for the disk, before which
    /// `objects` are looked at.
    #[new]
    #[pyo3(signature = (text, path, is_file=false, files=None, objects=None))]
    fn new(
        py: Python<'_>,
        text: String,
        path: PathBuf,
        is_file: bool,
        files: Option<Contents>,
        objects: Option<Contents>,
    ) -> PyResult<Self> {
        // A copy repeats no warnings: they were given when the original was made.
        let warns = files.is_none();
        Self::of(py, Origin::new(text, path, is_file, files, objects), warns)
    }

    /// Reads the calibration file at `path`.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let origin = detached(py, || Origin::read(path, FileKind::Calibration))?;
        Self::of(py, origin.map_err(|error| errors::input(py, &error))?, true)
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the calibration, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyType>, Parts<'_>)> {
        let Origin { text, path, is_file, .. } = &self.origin;
        let files = detached(py, || self.origin.contents())?.map_err(|error| errors::input(py, &error))?;
        Ok((py.get_type::<Self>(), (text, path.clone().into(), *is_file, files)))
    }

    fn __repr__(&self) -> String {
        format!("<slipgrid.Calibration {:?}>", self.read.name)
    }

    /// Warnings about the calibration, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.read.told.clone()
    }

    /// Fits local coefficients to the flat samples and learns from trials.
    #[pyo3(signature = (progress=None))]
    fn fit(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Fitted> {
        let sample = (DEFAULT_SPECIMEN, SEED);
        let found = watched(py, progress, |watch| {
            let (path, files) = (&self.origin.path, self.origin.source());
            let (task, outcome) = calibrate(&self.read, path, &files, sample, Selection::default(), watch)?;
            let ledger = ledger(&self.read, &outcome, watch)?;
            Ok((task, outcome, ledger))
        })?;
        let (task, outcome, ledger) = found.map_err(|error: Uncalibrated| errors::uncalibrated(py, &error))?;
        warn_all(py, &outcome.material.provenance.warnings)?;
        let (read, path, inputs) = (self.read.clone(), self.origin.path.clone(), self.inputs.clone());
        Ok(Fitted { read, path, disk: self.origin.disk.clone(), inputs, task, outcome, ledger })
    }

    /// Ledger of the trials: JSON as `slipgrid trials --json` writes it, and text.
    #[pyo3(signature = (progress=None))]
    fn trials(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<[String; 2]> {
        let sample = (DEFAULT_SPECIMEN, SEED);
        let found = watched(py, progress, |watch| {
            let (task, learned) = learn(&self.read, &self.origin.path, &self.origin.source(), sample, watch)?;
            let report =
                TrialsReport::new(&self.read.name, &task.flat, &task.trials.samples, &learned.discrepancy, watch)?
                    .with_pending(&learned)
                    .with_warnings(self.read.doubts.clone());
            let record = json(&report).map_err(|error| Uncalibrated::Failed(error.to_string()))?;
            Ok(([record, report.text()], report.warnings))
        })?;
        let (found, warnings) = found.map_err(|error: Uncalibrated| errors::uncalibrated(py, &error))?;
        warn_all(py, &warnings)?;
        Ok(found)
    }
}

#[pymethods]
impl Fitted {
    /// The material file; includes `[made_from]` if `output`, its path, is given and the calibration is a file.
    #[pyo3(signature = (output=None))]
    fn material_toml(&self, py: Python<'_>, output: Option<PathBuf>) -> PyResult<String> {
        let made_from = output.and_then(|output| {
            let output = self.disk.to_absolute(output);
            MadeFrom::new(&self.read, &self.path, &output, &self.disk.source())
        });
        let text = in_pool(py, || material_toml(&self.task, &self.outcome, made_from))?;
        text.map_err(|error| errors::failed(py, &error.to_string()))
    }

    /// Files that the calibration was made from.
    #[getter]
    fn inputs(&self) -> Vec<PathBuf> {
        self.inputs.clone()
    }

    /// The fit as in fit.json.
    fn fit_json(&self, py: Python<'_>) -> PyResult<String> {
        in_pool(py, || fit_json(&self.task, &self.outcome))?.map_err(|error| errors::failed(py, &error.to_string()))
    }

    /// Text as the command line prints it.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        in_pool(py, || summary(&self.read, &self.task, &self.outcome, self.ledger.as_ref()))
    }

    /// Warnings about the measurements and the material, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        [self.read.told.clone(), self.outcome.material.provenance.warnings.clone()].concat()
    }

    /// All files of the fit that the command line writes, by name.
    fn files(&self, py: Python<'_>) -> PyResult<Vec<(String, Vec<u8>)>> {
        let outputs = in_pool(py, || files(&self.read, &self.task, &self.outcome, self.ledger.as_ref()))?;
        crate::designs::contents(py, &outputs.map_err(|error| errors::failed(py, &error.to_string()))?)
    }
}
