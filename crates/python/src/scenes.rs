//! Scenes: friction of a given surface at given loads.

use std::ffi::OsString;
use std::fmt::Arguments;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use slipgrid::design::{run_line, simulate_on};
use slipgrid::formats::Diagnostic;
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::run::Overrides;
use slipgrid::formats::scene::SceneInput;
use slipgrid::monitor::{Monitor, Stage};
use slipgrid::pattern::{Pattern, Texture};
use slipgrid::report::files;
use slipgrid::results::{SimulationReport, json_and_timings};
use slipgrid::springblock::{Extent, Fidelity, Simulation, Status};

use crate::copied::{Contents, Origin};
use crate::given;
use crate::refused;
use crate::threads::{detached, in_pool};
use crate::told::warn_of;
use crate::watched::watched;

/// A scene: a material, a pattern or none, loads, and the solution method.
#[pyclass(frozen, module = "slipgrid._slipgrid")]
pub struct Scene {
    input: SceneInput,
    inputs: Vec<PathBuf>,
    origin: Origin,
    fidelity: Option<String>,
    extent: Option<String>,
}

/// Text and path of a scene, `fidelity`, `extent`, whether the path is a file, and the files that the scene reads.
type Parts<'a> = (&'a str, OsString, Option<&'a str>, Option<&'a str>, bool, Contents);

/// A solved scene.
#[pyclass(frozen, module = "slipgrid")]
pub struct Solved {
    scene: slipgrid::springblock::Scene,
    simulation: Simulation,
    report: SimulationReport,
    warnings: Vec<String>,
    inputs: Vec<PathBuf>,
}

fn overrides(fidelity: Option<&str>, extent: Option<&str>) -> PyResult<Overrides> {
    let refuse = |what: &str, given: &str, names: Vec<&str>| {
        PyValueError::new_err(format!("{what} is {given:?}: expected one of {}", names.join(", ")))
    };
    let fidelity = fidelity.map(|given| {
        let all = Fidelity::ALL;
        let named = all.iter().copied().find(|own| own.name() == given);
        named.ok_or_else(|| refuse("fidelity", given, all.iter().map(|own| own.name()).collect()))
    });
    let extent = extent.map(|given| {
        let all = Extent::ALL;
        let named = all.iter().copied().find(|own| own.name() == given);
        named.ok_or_else(|| refuse("extent", given, all.iter().map(|own| own.name()).collect()))
    });
    Ok(Overrides { fidelity: fidelity.transpose()?, extent: extent.transpose()? })
}

impl Scene {
    fn of(
        py: Python<'_>,
        origin: Origin,
        fidelity: Option<String>,
        extent: Option<String>,
        warns: bool,
    ) -> PyResult<Self> {
        let overrides = overrides(fidelity.as_deref(), extent.as_deref())?;
        let read = || {
            let document = origin.document(FileKind::Scene)?;
            SceneInput::from_file(document.clone(), &document.parse()?, overrides)
        };
        let input = in_pool(py, read)?.map_err(|error| refused::input(py, &error))?;
        let inputs = origin.inputs(std::slice::from_ref(&origin.path));
        let made = Self { input, inputs, origin, fidelity, extent };
        if warns {
            warn_of(py, &made.warnings())?;
        }
        Ok(made)
    }
}

#[pymethods]
impl Scene {
    /// Parses the scene in `text` as a file at `path`; relative paths in the text start from the folder of `path`.
    /// `is_file` states that the file exists; `files` are the only available files, and None stands for the disk.
    #[new]
    #[pyo3(signature = (text, path, fidelity=None, extent=None, is_file=false, files=None))]
    fn new(
        py: Python<'_>,
        text: String,
        path: PathBuf,
        fidelity: Option<String>,
        extent: Option<String>,
        is_file: bool,
        files: Option<Contents>,
    ) -> PyResult<Self> {
        // A copy repeats no warnings: they were given when the original was made.
        let warns = files.is_none();
        Self::of(py, Origin::new(text, path, is_file, files), fidelity, extent, warns)
    }

    /// Reads the scene file at `path`.
    #[staticmethod]
    #[pyo3(signature = (path, fidelity=None, extent=None))]
    fn read(py: Python<'_>, path: PathBuf, fidelity: Option<String>, extent: Option<String>) -> PyResult<Self> {
        let origin = detached(py, || Origin::read(path, FileKind::Scene))?;
        Self::of(py, origin.map_err(|error| refused::input(py, &error))?, fidelity, extent, true)
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the scene, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyType>, Parts<'_>)> {
        let Origin { text, path, is_file, .. } = &self.origin;
        let files = detached(py, || self.origin.contents())?.map_err(|error| refused::input(py, &error))?;
        let (fidelity, extent) = (self.fidelity.as_deref(), self.extent.as_deref());
        Ok((py.get_type::<Self>(), (text, path.clone().into(), fidelity, extent, *is_file, files)))
    }

    /// Warnings about the scene, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.input.told.iter().map(ToString::to_string).collect()
    }

    /// Solves the scene.
    #[pyo3(signature = (progress=None))]
    fn simulate(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Solved> {
        let input = &self.input;
        let found = watched(py, progress, |watch| {
            let line = run_line(&input.scene, &input.uncertainty, input.condition.as_ref());
            line.iter().for_each(|line| watch.note(line));
            let stage = Stage::new(watch, input.scene.run.fidelity.name(), None);
            let solved = simulate_on(&input.scene, input.specimen.as_ref(), &stage);
            let simulation = solved.map_err(|error| Ok(input.refuse_on_specimen(&error)))?;
            let (simulation, report) = input.report(simulation).map_err(|error| Err(error.to_string()))?;
            let report = SimulationReport { wall_s: stage.finish(), threads: rayon::current_num_threads(), ..report };
            let warnings = self.warnings().into_iter().chain(report.doubts()).collect();
            Ok(Solved { scene: input.scene.clone(), simulation, report, warnings, inputs: self.inputs.clone() })
        })?;
        let found = found.map_err(|error| match error {
            Ok(refused) => refused::input(py, &refused),
            Err(reason) => refused::failed(py, &reason),
        })?;
        warn_of(py, &found.warnings[self.input.told.len()..])?;
        Ok(found)
    }

    /// The steady cell of the scene's texture, which computes ratios for any pattern.
    fn steady(&self) -> PyResult<SteadyCell> {
        let scene = &self.input.scene;
        let Some(pattern) = &scene.pattern else {
            return Err(PyValueError::new_err("a flat scene has no pattern to vary"));
        };
        let cell = slipgrid::springblock::SteadyCell::new(scene);
        Ok(SteadyCell { cell: Arc::new(cell), texture: *pattern.texture(), loads: scene.loads.len() })
    }
}

#[pymethods]
impl Solved {
    /// The record and its wall times, as in result.json and timings.json.
    fn json(&self, py: Python<'_>) -> PyResult<[String; 2]> {
        json_and_timings(&self.report).map_err(|error| refused::failed(py, &error.to_string()))
    }

    /// Files that the result was made from.
    #[getter]
    fn inputs(&self) -> Vec<PathBuf> {
        self.inputs.clone()
    }

    /// Text as the command line prints it.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        in_pool(py, || self.report.text())
    }

    /// Warnings about the input and the result, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// All files that the command line writes, by name.
    fn files(&self, py: Python<'_>) -> PyResult<Vec<(String, Vec<u8>)>> {
        let outputs = in_pool(py, || files::of_scene(&self.scene, &self.simulation, &self.report))?;
        crate::designs::contents(py, &outputs.map_err(|error| refused::failed(py, &error.to_string()))?)
    }
}

/// Number of patterns that are checked, within milliseconds, between two checks for Ctrl-C.
const ROWS_BETWEEN_SIGNALS: usize = 4096;

/// Maximum number of patterns per call: with their ratios, they take a few gigabytes.
const MAX_ROWS: usize = 10_000_000;

/// A steady cell: equilibrium of one period with every contact block sliding.
#[pyclass(frozen, module = "slipgrid")]
pub struct SteadyCell {
    cell: Arc<slipgrid::springblock::SteadyCell>,
    texture: Texture,
    loads: usize,
}

#[pymethods]
impl SteadyCell {
    /// Ratio of patterned to flat friction at each load, shape (loads,); NaN where there is none. A cell that would take too much
    /// memory is refused.
    fn ratios<'py>(
        &self,
        py: Python<'py>,
        width_um: f64,
        spacing_um: f64,
        depth_um: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let pattern =
            self.pattern(py, format_args!("width_um, spacing_um, depth_um"), [width_um, spacing_um, depth_um])?;
        let found = if self.cell.dimension().is_cheap_per_design() {
            detached(py, || self.cell.ratios(&pattern))?
        } else {
            watched(py, None, |watch| {
                let found = self.cell.solve_heeding(&pattern, watch);
                let is_whole = !watch.cancelled() && found.iter().all(|of| of.surface.status != Status::Cancelled);
                if is_whole { found.into_iter().map(|of| of.ratio).collect() } else { Vec::new() }
            })?
        };
        Ok(PyArray1::from_iter(py, found.into_iter().map(|ratio| ratio.unwrap_or(f64::NAN))))
    }

    /// Ratios of many patterns, rows of width, spacing and depth in micrometres: shape (patterns, loads), on all threads. Masked
    /// numbers are refused.
    fn ratios_of<'py>(&self, py: Python<'py>, patterns_um: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = numbers(patterns_um)?;
        let mut patterns: Vec<Pattern> = Vec::new();
        if rows.shape()[0] > MAX_ROWS || patterns.try_reserve_exact(rows.shape()[0]).is_err() {
            let reason = format!("has {} rows", rows.shape()[0]);
            let refused = Diagnostic { key: Some("patterns_um".into()), reason, ..Diagnostic::default() };
            return Err(refused::too_large(py, &refused.expected(format!("at most {MAX_ROWS}, and room for them"))));
        }
        for (row, own) in rows.as_array().rows().into_iter().enumerate() {
            if row % ROWS_BETWEEN_SIGNALS == 0 {
                py.check_signals()?;
            }
            patterns.push(self.pattern(py, format_args!("patterns_um[{row}]"), [own[0], own[1], own[2]])?);
        }
        let found = watched(py, None, |watch| self.cell.ratios_of_heeding(&patterns, watch))?;
        let found = found.map_err(|_| refused::stopped())?.into_iter().flatten().map(|ratio| ratio.unwrap_or(f64::NAN));
        PyArray1::from_iter(py, found).reshape([patterns.len(), self.loads])
    }
}

/// Converts an array of rows of three numbers.
fn numbers<'py>(patterns_um: &Bound<'py, PyAny>) -> PyResult<PyArrayLike2<'py, f64, AllowTypeChange>> {
    let expected = "expected rows of width, spacing and depth in micrometres";
    let rows = given::rows("patterns_um", patterns_um, expected)?;
    match rows.shape()[1] {
        3 => Ok(rows),
        columns => Err(PyValueError::new_err(format!("patterns_um has {columns} columns: {expected}"))),
    }
}

impl SteadyCell {
    /// Makes the pattern with these lengths from the argument `named`; refuses it if its cell is too large.
    fn pattern(&self, py: Python<'_>, named: Arguments<'_>, lengths_um: [f64; 3]) -> PyResult<Pattern> {
        let [width_m, spacing_m, depth_m] = lengths_um.map(|length_um| length_um * 1e-6);
        let pattern = Pattern::new(self.texture, width_m, spacing_m, depth_m)
            .map_err(|error| PyValueError::new_err(format!("{named}: {error}")))?;
        let (bytes, most_bytes) = (self.cell.bytes(&pattern), self.cell.most_bytes());
        if bytes > most_bytes {
            let given = lengths_um.map(|length_um| length_um.to_string()).join(", ");
            let refused =
                Diagnostic::flag(&named.to_string(), given, format!("makes a cell that takes {bytes:.1e} bytes"));
            let expected = format!("a smaller pattern or larger blocks, at most {most_bytes:.1e} bytes");
            return Err(refused::input(py, &refused.expected(expected)));
        }
        Ok(pattern)
    }
}
