//! Scenes: friction of a given surface at given loads.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::PathBuf;

use numpy::ndarray::{Array2, ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use rayon::prelude::*;
use slipgrid::design::{check_pressures, loads, run_line, simulate_on};
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::run::Overrides;
use slipgrid::formats::scene::SceneInput;
use slipgrid::formats::{Diagnostic, checked};
use slipgrid::monitor::{Cancelled, Monitor, Stage, Unwatched};
use slipgrid::pattern::{Pattern, Texture};
use slipgrid::report::files;
use slipgrid::results::{SimulationReport, beyond_measured, json_and_timings};
use slipgrid::springblock::{self, Extent, Fidelity, Load, Simulation, SteadyCell as Cell};
use slipgrid::units::{PRESSURE_MPA, tidy};

use crate::errors;
use crate::origin::{Contents, Origin};
use crate::progress::watched;
use crate::threads::{detached, in_pool};
use crate::warnings::warn_all;

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
        let input = in_pool(py, read)?.map_err(|error| errors::input(py, &error))?;
        let inputs = origin.inputs(std::slice::from_ref(&origin.path));
        let made = Self { input, inputs, origin, fidelity, extent };
        if warns {
            warn_all(py, &made.warnings())?;
        }
        Ok(made)
    }
}

#[pymethods]
impl Scene {
    /// Parses the scene in `text` as a file at `path`; relative paths in the text start from the folder of `path`.
    /// `is_file` states that the file exists; `files` are the only available files, and None stands for the disk, before which
    /// `objects` are looked at.
    #[new]
    #[allow(clippy::too_many_arguments, reason = "they are what a scene is made of, and Python's interpreter")]
    #[pyo3(signature = (text, path, fidelity=None, extent=None, is_file=false, files=None, objects=None))]
    fn new(
        py: Python<'_>,
        text: String,
        path: PathBuf,
        fidelity: Option<String>,
        extent: Option<String>,
        is_file: bool,
        files: Option<Contents>,
        objects: Option<Contents>,
    ) -> PyResult<Self> {
        // A copy repeats no warnings: they were given when the original was made.
        let warns = files.is_none();
        Self::of(py, Origin::new(text, path, is_file, files, objects), fidelity, extent, warns)
    }

    /// Reads the scene file at `path`.
    #[staticmethod]
    #[pyo3(signature = (path, fidelity=None, extent=None))]
    fn read(py: Python<'_>, path: PathBuf, fidelity: Option<String>, extent: Option<String>) -> PyResult<Self> {
        let origin = detached(py, || Origin::read(path, FileKind::Scene))?;
        Self::of(py, origin.map_err(|error| errors::input(py, &error))?, fidelity, extent, true)
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the scene, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyType>, Parts<'_>)> {
        let Origin { text, path, is_file, .. } = &self.origin;
        let files = detached(py, || self.origin.contents())?.map_err(|error| errors::input(py, &error))?;
        let (fidelity, extent) = (self.fidelity.as_deref(), self.extent.as_deref());
        Ok((py.get_type::<Self>(), (text, path.clone().into(), fidelity, extent, *is_file, files)))
    }

    fn __repr__(&self) -> String {
        let scene = &self.input.scene;
        let of = scene.pattern.as_ref().map_or("flat", |pattern| pattern.planform().name());
        format!("<slipgrid.Scene {of}, {} loads, {}>", scene.loads.len(), scene.run.fidelity.name())
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
            Ok(refused) => errors::input(py, &refused),
            Err(reason) => errors::failed(py, &reason),
        })?;
        warn_all(py, &found.warnings[self.input.told.len()..])?;
        Ok(found)
    }

    /// The steady cell of the scene's texture, which computes ratios for any pattern.
    fn steady(&self) -> PyResult<SteadyCell> {
        match &self.input.scene.pattern {
            Some(pattern) => Ok(SteadyCell { input: self.input.clone(), texture: *pattern.texture() }),
            None => Err(PyValueError::new_err("a flat scene has no pattern to vary")),
        }
    }
}

#[pymethods]
impl Solved {
    /// The record and its wall times, as in result.json and timings.json.
    fn json(&self, py: Python<'_>) -> PyResult<[String; 2]> {
        json_and_timings(&self.report).map_err(|error| errors::failed(py, &error.to_string()))
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
        crate::designs::contents(py, &outputs.map_err(|error| errors::failed(py, &error.to_string()))?)
    }
}

/// Number of rows that are checked, within milliseconds, between two checks for Ctrl-C.
const ROWS_BETWEEN_SIGNALS: usize = 4096;
/// Number of loads of one texture up to which a solve takes some milliseconds.
const QUICK_LOADS: usize = 16;
/// Number of values per row that a steady cell computes: ratio, dynamic friction, peak pressure in MPa.
const VALUES: usize = 3;

/// A steady cell: equilibrium of one period with every contact block sliding.
#[pyclass(frozen, module = "slipgrid")]
pub struct SteadyCell {
    input: SceneInput,
    texture: Texture,
}

#[pymethods]
impl SteadyCell {
    /// Nominal pressures of the scene in MPa.
    #[getter]
    fn pressure_mpa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let loads = self.input.scene.loads.iter();
        PyArray1::from_iter(py, loads.map(|load| tidy(PRESSURE_MPA.from_si(load.pressure_pa))))
    }

    /// Ratio, dynamic friction and peak pressure in MPa, shape (rows, 3), for rows of width, spacing and depth in micrometres and
    /// pressure in MPa. A row with a NaN, and a load without friction, gives NaN.
    fn solve<'py>(&self, py: Python<'py>, rows: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = rows.as_array();
        let groups = self.groups(py, rows)?;
        let loads = self.loads(py, groups.values().flat_map(|(_, places)| places.keys().copied()))?;
        let solve = |(pattern, places): &Group, monitor: &dyn Monitor| {
            monitor.heed()?;
            let scene = springblock::Scene {
                loads: places.keys().map(|bits| loads[bits].0).collect(),
                ..self.input.scene.clone()
            };
            let found = Cell::of_texture(&scene, &self.texture).solve_heeding(pattern, monitor);
            // A solve that was cancelled has no valid result.
            monitor.heed().map(|()| found)
        };
        let groups: Vec<&Group> = groups.values().collect();
        let is_quick = Cell::of_texture(&self.input.scene, &self.texture).dimension().is_cheap_per_design();
        let solved: Result<Vec<_>, Cancelled> = match groups[..] {
            // Waking a thread of the pool would take as long as the solve.
            [group] if is_quick && group.1.len() <= QUICK_LOADS => {
                detached(py, || Ok(vec![solve(group, &Unwatched)?]))?
            }
            _ => watched(py, None, |watch| groups.par_iter().map(|group| solve(group, watch)).collect())?,
        };
        let mut values = Array2::from_elem((rows.nrows(), VALUES), f64::NAN);
        for ((_, places), outcomes) in groups.iter().zip(solved.map_err(|_| errors::stopped())?) {
            for ((bits, rows), outcome) in places.iter().zip(outcomes) {
                let ratio = outcome.ratio.unwrap_or(f64::NAN);
                let peak_mpa = PRESSURE_MPA.from_si(outcome.surface.peak_pressure_pa);
                let own = [ratio, ratio * loads[bits].1, if ratio.is_nan() { f64::NAN } else { peak_mpa }];
                rows.iter().for_each(|row| values.row_mut(*row).assign(&ArrayView1::from(&own)));
            }
        }
        Ok(PyArray2::from_owned_array(py, values))
    }
}

/// Pattern, and the rows that ask for it by the bits of their pressure in MPa, which sort as positive numbers do.
type Group = (Pattern, BTreeMap<u64, Vec<usize>>);

impl SteadyCell {
    /// Groups the rows by texture, so that each is condensed once for all its loads.
    fn groups(&self, py: Python<'_>, rows: ArrayView2<'_, f64>) -> PyResult<BTreeMap<[u64; 3], Group>> {
        let largest = Cell::of_texture(&self.input.scene, &self.texture);
        let mut groups: BTreeMap<[u64; 3], Group> = BTreeMap::new();
        for (row, own) in rows.rows().into_iter().enumerate() {
            if row % ROWS_BETWEEN_SIGNALS == 0 {
                py.check_signals()?;
            }
            let [width, spacing, depth, pressure_mpa] = [own[0], own[1], own[2], own[3]];
            if own.iter().any(|value| value.is_nan()) {
                continue;
            }
            let group = match groups.entry([width, spacing, depth].map(f64::to_bits)) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    new.insert((self.pattern(py, &largest, [width, spacing, depth])?, BTreeMap::new()))
                }
            };
            group.1.entry(pressure_mpa.to_bits()).or_default().push(row);
        }
        Ok(groups)
    }

    /// Loads at pressures in MPa, by the bits of the pressure, each with the dynamic friction of the flat surface in time.
    fn loads(&self, py: Python<'_>, pressures: impl Iterator<Item = u64>) -> PyResult<BTreeMap<u64, (Load, f64)>> {
        let input = &self.input;
        let bits: Vec<u64> = pressures.collect::<BTreeSet<u64>>().into_iter().collect();
        let pressure = |bits: &u64| checked("pressure_mpa", f64::from_bits(*bits), PRESSURE_MPA);
        let pressures_pa: Vec<f64> =
            bits.iter().map(pressure).collect::<Result<_, _>>().map_err(|error| errors::input(py, &error))?;
        let refuse = |reason: String| {
            errors::input(py, &Diagnostic { key: Some("pressure_mpa".into()), reason, ..Diagnostic::default() })
        };
        check_pressures(&pressures_pa, &input.material).map_err(|error| refuse(error.reason))?;
        let condition = input.condition.as_ref();
        let (loads, outside) =
            loads(&input.material.friction, &pressures_pa, condition).map_err(|error| refuse(error.to_string()))?;
        let beyond =
            bits.iter().zip(&outside).filter(|(_, outside)| **outside).map(|(bits, _)| tidy(f64::from_bits(*bits)));
        // The least and the greatest stand for all: there may be as many as rows.
        let beyond_mpa: Vec<f64> = beyond.collect();
        let ends_mpa: Vec<f64> =
            beyond_mpa.first().into_iter().chain(beyond_mpa.last().filter(|_| beyond_mpa.len() > 1)).copied().collect();
        warn_all(py, &beyond_measured(&ends_mpa).into_iter().collect::<Vec<_>>())?;
        let excess = input.uncertainty.excess(&pressures_pa, condition);
        let flat_mu = |(place, load): (usize, &Load)| {
            load.flat_mu(input.scene.area_law.as_ref()) * excess.as_ref().map_or(1.0, |excess| excess[place])
        };
        let flat: Vec<f64> = loads.iter().enumerate().map(flat_mu).collect();
        Ok(bits.into_iter().zip(loads.into_iter().zip(flat)).collect())
    }

    /// Makes the pattern with these lengths; refuses it if its cell is too large.
    fn pattern(&self, py: Python<'_>, cell: &Cell, lengths_um: [f64; 3]) -> PyResult<Pattern> {
        const NAMED: &str = "width_um, spacing_um, depth_um";
        let given = || lengths_um.map(|length_um| length_um.to_string()).join(", ");
        let [width_m, spacing_m, depth_m] = lengths_um.map(|length_um| length_um * 1e-6);
        let pattern = Pattern::new(self.texture, width_m, spacing_m, depth_m)
            .map_err(|error| errors::input(py, &Diagnostic::flag(NAMED, given(), error.to_string())))?;
        let (bytes, max_bytes) = (cell.bytes(&pattern), cell.most_bytes());
        if bytes > max_bytes {
            let refused = Diagnostic::flag(NAMED, given(), format!("makes a cell that takes {bytes:.1e} bytes"));
            let expected = format!("a smaller pattern or larger blocks, at most {max_bytes:.1e} bytes");
            return Err(errors::input(py, &refused.expected(expected)));
        }
        Ok(pattern)
    }
}
