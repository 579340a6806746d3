//! Designs: the search for a design, and the samples to cut next.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use rayon::prelude::*;
use slipgrid::design::{
    BOUND_ROUNDING, DesignOutcome, Explored, NextOptions, NoCache, explore_bounds, next_trials, run,
};
use slipgrid::formats::calibrated::{complete_by, read_calibration};
use slipgrid::formats::calibration::Calibration;
use slipgrid::formats::confirmed_scene::steady_scene;
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::{Diagnostic, design::Design as Read};
use slipgrid::monitor::Monitor;
use slipgrid::pattern::Pattern;
use slipgrid::report::html::exploration;
use slipgrid::report::{LaserFile, Outputs, draw, files};
use slipgrid::results::{json, json_and_timings};
use slipgrid::units::{LENGTH_UM, PRESSURE_MPA, counted, tidy};

use crate::counts::{shown, to_count};
use crate::errors::{Failure, failed, undesigned};
use crate::origin::{Contents, Origin, Parts};
use crate::output::{Named, Told, contents};
use crate::progress::{Watch, watched};
use crate::threads::in_pool;
use crate::warnings::warn_all;

/// A design task.
#[pyclass(frozen, module = "slipgrid._slipgrid")]
pub struct Design {
    read: Read,
    inputs: Vec<PathBuf>,
    origin: Origin,
    /// What the first calibration gives. The lock must not be held during a computation: a pool thread that waits for
    /// others may start another call, which may need the lock.
    completed: Mutex<Option<Completed>>,
    /// Predictions over the bounds and their warnings, after the first call that needs them; the lock as above.
    bounds: Mutex<Option<Arc<Bounds>>>,
}

/// Design with its material, the calibration, and warnings about the design and its input files.
type Completed = (Read, Option<Calibration>, Vec<String>);

/// Predictions over the bounds of a design, with the warnings about them.
struct Bounds {
    found: Explored,
    warnings: Vec<String>,
}

/// Values, pressures in MPa, quantity, median and maximum error of interpolation, and warnings of [`Design::predict`].
type Predicted<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, &'static str, [f64; 2], Vec<String>);

/// Result of a design search.
#[pyclass(frozen, module = "slipgrid")]
pub struct Designed(DesignOutcome);

/// Number of predicted columns in addition to medians and intervals: chance, peak pressure in MPa, clearance in um,
/// areal density, and laser time in seconds.
const BESIDE: usize = 5;

impl Design {
    /// Returns the design with its material; calibrates at the first call only.
    fn completed(&self, watch: &Watch) -> Result<Completed, slipgrid::Failure> {
        let known = || self.completed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known().as_ref() {
            return Ok(known.clone());
        }
        let (mut read, files, mut warnings) = (self.read.clone(), self.origin.source(), self.warnings());
        let calibration = read_calibration(&read, &files)?;
        if let Some(calibration) = &calibration {
            // Warnings may explain a failure of the computation, and are given first.
            watch.warn(calibration.stated.notes.iter().cloned());
            complete_by(&mut read, calibration, &files, watch)?;
            warnings.extend(calibration.stated.notes.iter().cloned());
            let found = [read.contradictions(calibration), read.material_told()];
            warnings.extend(found.into_iter().flatten().map(|told| told.to_string()));
        }
        let completed = (read, calibration, warnings);
        *known() = Some(completed.clone());
        Ok(completed)
    }

    /// Gives those of `warnings` that were not given when the design was read.
    fn warn_of_found(&self, py: Python<'_>, warnings: &[String]) -> PyResult<()> {
        warn_all(py, &warnings[self.read.told.len().min(warnings.len())..])
    }

    /// Predictions over the bounds; computed, with their warnings, at the first call only.
    fn explored(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> Result<Arc<Bounds>, Failure> {
        let known = || self.bounds.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().clone();
        if let Some(found) = found {
            return Ok(found);
        }
        let found = watched(py, progress, |watch| {
            let (read, _, mut warnings) = self.completed(watch)?;
            let found = explore_bounds(&read.task, watch).map_err(|error| undesigned(error, &self.read))?;
            warnings.extend(found.doubts());
            Ok::<_, Failure>(Arc::new(Bounds { found, warnings }))
        })??;
        self.warn_of_found(py, &found.warnings)?;
        *known() = Some(Arc::clone(&found));
        Ok(found)
    }
}

#[pymethods]
impl Design {
    /// Parses the design in `text`, by default that of the file at `path`; relative paths in the text start from the
    /// folder of `path`. `objects` has contents by path that take precedence over files on disk. `copied`, for a copy:
    /// whether the text came from a file, and the contents of all its files; the disk is then not read.
    #[new]
    #[pyo3(signature = (text, path, objects=None, copied=None))]
    fn new(
        py: Python<'_>,
        text: Option<String>,
        path: PathBuf,
        objects: Option<Contents>,
        copied: Option<(bool, Contents)>,
    ) -> Result<Self, Failure> {
        let parse = Read::from_document;
        let (origin, read) = in_pool(py, || Origin::read(FileKind::Design, (text, objects, copied), path, parse))??;
        let inputs = origin.inputs(&read.inputs);
        let made = Self { read, inputs, origin, completed: Mutex::new(None), bounds: Mutex::new(None) };
        if !made.origin.is_copy {
            warn_all(py, &made.warnings())?;
        }
        Ok(made)
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the design, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyType>, Parts), Failure> {
        let parts = in_pool(py, || {
            // The calibration's files are usually read on demand; a copy may need them on another machine, so they are read now.
            read_calibration(&self.read, &self.origin.source())?;
            self.origin.parts()
        })??;
        Ok((py.get_type::<Self>(), parts))
    }

    fn __repr__(&self) -> String {
        let task = &self.read.task;
        format!(
            "<slipgrid.Design {:?}, {} at {}>",
            task.name,
            task.target.quantity().name(),
            counted(task.target.points().len(), "pressure")
        )
    }

    /// Files that the design was made from.
    #[getter]
    fn inputs(&self) -> Vec<PathBuf> {
        self.inputs.clone()
    }

    /// Warnings about the design, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.read.told.iter().map(ToString::to_string).collect()
    }

    /// Searches a design, confirms it by a transient run and explains it; returns result.json and timings.json as well.
    #[pyo3(signature = (progress=None))]
    fn optimize(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<([String; 2], Told, Designed), Failure> {
        let (found, warnings) = watched(py, progress, |watch| {
            let (mut read, _, mut warnings) = self.completed(watch)?;
            read.task.explorer = true;
            let found = run(&read.task, &mut NoCache, watch).map_err(|error| undesigned(error, &self.read))?;
            warnings.extend(found.report.doubts());
            Ok::<_, Failure>((found, warnings))
        })??;
        self.warn_of_found(py, &warnings)?;
        let records = json_and_timings(&found.report).map_err(failed)?;
        Ok((records, (found.report.summary(), warnings, self.inputs.clone()), Designed(found)))
    }

    /// HTML page with sliders that shows the predictions for any design within the bounds, without a search.
    #[pyo3(signature = (progress=None))]
    fn explore_html(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> Result<String, Failure> {
        let bounds = self.explored(py, progress)?;
        let found = &bounds.found;
        let scene = steady_scene(&found.task, &found.material, &found.loads, &found.pattern).map_err(failed)?;
        Ok(in_pool(py, || exploration(found, scene))?)
    }

    /// Predictions for `rows` of width, spacing and depth in micrometres, by the lattice of the page with sliders. Columns: medians of
    /// all target pressures, lower and upper ends of the 95 % interval, chance, peak pressure in MPa, clearance in micrometres,
    /// areal density, laser seconds; NaN for a NaN and beside textures without an answer. Beside them the pressures in MPa,
    /// the quantity of the target, errors of the interpolated medians (median and maximum over random textures), and warnings.
    #[pyo3(signature = (rows, progress=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Predicted<'py>, Failure> {
        let rows = rows.as_array();
        for (axis, name) in ["width_um", "spacing_um", "depth_um"].into_iter().enumerate() {
            let [from, to] = self.read.task.space.lengths_m()[axis].map(|length_m| LENGTH_UM.from_si(length_m));
            let within = from * (1.0 - BOUND_ROUNDING)..=to * (1.0 + BOUND_ROUNDING);
            if let Some(beyond) = rows.column(axis).iter().find(|length| !length.is_nan() && !within.contains(length)) {
                let refused = Diagnostic::flag(name, beyond.to_string(), "is beyond the bounds of the design");
                return Err(refused
                    .expected(if from == to { from.to_string() } else { format!("{from} to {to}") })
                    .into());
            }
        }
        let bounds = self.explored(py, progress)?;
        let found = &bounds.found;
        let points = found.task.target.points();
        let columns = 3 * points.len() + BESIDE;
        let mut values = vec![f64::NAN; rows.nrows() * columns];
        watched(py, None, |watch| {
            values.par_chunks_mut(columns).enumerate().try_for_each(|(row, value)| {
                watch.heed()?;
                let Some(own) = found.predict([0, 1, 2].map(|axis| rows[[row, axis]])) else { return Ok(()) };
                let beside = [
                    own.chance.unwrap_or(f64::NAN),
                    own.peak_pressure_mpa,
                    own.clearance_um,
                    own.areal_density,
                    own.laser_s.unwrap_or(f64::NAN),
                ];
                let parts = [&own.expected[..], &own.lower_95, &own.upper_95, &beside];
                value.copy_from_slice(&parts.concat());
                Ok::<_, Failure>(())
            })
        })??;
        let pressures = points.iter().map(|point| tidy(PRESSURE_MPA.from_si(point.pressure_pa)));
        let (pressures, quantity) = (PyArray1::from_iter(py, pressures), found.task.target.quantity().name());
        let errors = [found.explorer.median_error, found.explorer.worst_error];
        let values = PyArray1::from_vec(py, values).reshape([rows.nrows(), columns])?;
        Ok((values, pressures, quantity, errors, bounds.warnings.clone()))
    }

    /// The record of the `count` samples to cut next, as `slipgrid next --json` writes it; `candidates_um` are additional patterns whose probability is computed.
    #[pyo3(signature = (count, candidates_um, progress=None, one_disc=false, learn=false))]
    fn next_samples(
        &self,
        py: Python<'_>,
        count: &Bound<'_, PyAny>,
        candidates_um: Vec<[f64; 3]>,
        progress: Option<&Bound<'_, PyAny>>,
        one_disc: bool,
        learn: bool,
    ) -> Result<(String, Told), Failure> {
        let accepted = NextOptions::counts(one_disc);
        let refused = || {
            let [least, most] = [accepted.start(), accepted.end()];
            let on = if one_disc { " sectors of one_disc" } else { "" };
            PyValueError::new_err(format!("count is {}: expected {least} to {most}{on}", shown(count)))
        };
        if learn && (one_disc || !candidates_um.is_empty() || !count.eq(1)?) {
            let reason =
                "learn chooses both sectors of one disc itself: expected neither count, candidates_um nor one_disc";
            return Err(PyValueError::new_err(reason).into());
        }
        let count = to_count("count", count)?.filter(|count| accepted.contains(count)).ok_or_else(refused)?;
        let own = candidates_um.iter().map(|lengths_um| {
            let [width_m, spacing_m, depth_m] = lengths_um.map(|length_um| length_um * 1e-6);
            Pattern::new(*self.read.task.space.texture(), width_m, spacing_m, depth_m)
                .map_err(|error| PyValueError::new_err(format!("candidates_um: {error}")))
        });
        let own: Vec<Pattern> = own.collect::<PyResult<_>>()?;
        let (report, warnings) = watched(py, progress, |watch| {
            let (read, calibration, mut warnings) = self.completed(watch)?;
            let samples = calibration.map_or_else(Vec::new, |calibration| calibration.stated.trials.samples);
            let options = NextOptions { count, own, one_disc, learn, ..NextOptions::of_samples(&samples) };
            let found = next_trials(&read.task, &options, watch).map_err(|error| undesigned(error, &self.read))?;
            warnings.extend(found.report.doubts());
            Ok::<_, Failure>((found.report, warnings))
        })??;
        self.warn_of_found(py, &warnings)?;
        Ok((json(&report).map_err(failed)?, (report.text(), warnings, self.inputs.clone())))
    }
}

#[pymethods]
impl Designed {
    /// All files that the command line writes, by name.
    fn files(&self, py: Python<'_>) -> Result<Vec<Named>, Failure> {
        let outputs = in_pool(py, || {
            let mut outputs = files::of_design(&self.0)?;
            files::add_report(&self.0, &mut outputs)?;
            Ok::<_, slipgrid::Failure>(outputs)
        })?;
        contents(&outputs.map_err(failed)?)
    }

    /// The pattern in one of the laser's formats: name and content of the file.
    fn drawing(&self, py: Python<'_>, format: &str) -> Result<Named, Failure> {
        let named = LaserFile::EACH.into_iter().find(|(_, [name, _])| *name == format);
        let (named, _) = named.ok_or_else(|| {
            let names = LaserFile::EACH.map(|(_, [name, _])| name).join(", ");
            PyValueError::new_err(format!("format is {format:?}: expected one of {names}"))
        })?;
        let mut outputs = Outputs::default();
        in_pool(py, || draw(&files::drawing(&self.0), &[named], &mut outputs))?
            .map_err(|error| Diagnostic::flag("format", format, error.to_string()))?;
        contents(&outputs)?.pop().ok_or_else(|| failed("nothing was drawn"))
    }
}
