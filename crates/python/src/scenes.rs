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
use slipgrid::units::{PRESSURE_MPA, counted, tidy};

use crate::errors::{Failure, failed};
use crate::origin::{Contents, Origin};
use crate::output::{Named, Told, contents};
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

/// Arguments from which a copy is made: text, path, `fidelity`, `extent`, no objects, and the value of `copied`.
type Parts<'a> = (String, OsString, Option<&'a str>, Option<&'a str>, Option<Contents>, (bool, Contents));

/// A solved scene.
#[pyclass(frozen, module = "slipgrid")]
pub struct Solved {
    scene: slipgrid::springblock::Scene,
    simulation: Simulation,
    report: SimulationReport,
}

/// Returns the value of `all` with the name `given`; otherwise a `ValueError` that names the argument `what`.
pub fn named<T: Copy>(what: &str, given: &str, all: &[T], name: impl Fn(T) -> &'static str) -> PyResult<T> {
    all.iter().copied().find(|own| name(*own) == given).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|own| name(*own)).collect();
        PyValueError::new_err(format!("{what} is {given:?}: expected one of {}", names.join(", ")))
    })
}

#[pymethods]
impl Scene {
    /// Parses the scene in `text`, by default that of the file at `path`; relative paths in the text start from the
    /// folder of `path`. `fidelity` and `extent` override those of the text. `objects` has contents by path that take
    /// precedence over files on disk. `copied`, for a copy: whether the text came from a file, and the contents of all
    /// its files; the disk is then not read.
    #[new]
    #[pyo3(signature = (text, path, fidelity=None, extent=None, objects=None, copied=None))]
    fn new(
        py: Python<'_>,
        text: Option<String>,
        path: PathBuf,
        fidelity: Option<String>,
        extent: Option<String>,
        objects: Option<Contents>,
        copied: Option<(bool, Contents)>,
    ) -> Result<Self, Failure> {
        let overrides = Overrides {
            fidelity: fidelity
                .as_deref()
                .map(|own| named("fidelity", own, &Fidelity::ALL, Fidelity::name))
                .transpose()?,
            extent: extent.as_deref().map(|own| named("extent", own, &Extent::ALL, Extent::name)).transpose()?,
        };
        let parse = |document| SceneInput::from_document(document, overrides);
        let (origin, input) = in_pool(py, || Origin::read(FileKind::Scene, (text, objects, copied), path, parse))??;
        let inputs = origin.inputs(std::slice::from_ref(&origin.path));
        let made = Self { input, inputs, origin, fidelity, extent };
        if !made.origin.is_copy {
            warn_all(py, &made.warnings())?;
        }
        Ok(made)
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the scene, on any machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyType>, Parts<'_>), Failure> {
        let (text, path, objects, copied) = detached(py, || self.origin.parts())??;
        let (fidelity, extent) = (self.fidelity.as_deref(), self.extent.as_deref());
        Ok((py.get_type::<Self>(), (text, path, fidelity, extent, objects, copied)))
    }

    fn __repr__(&self) -> String {
        let scene = &self.input.scene;
        let of = scene.pattern.as_ref().map_or("flat", |pattern| pattern.planform().name());
        format!("<slipgrid.Scene {of}, {}, {}>", counted(scene.loads.len(), "load"), scene.run.fidelity.name())
    }

    /// Warnings about the scene, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.input.told.iter().map(ToString::to_string).collect()
    }

    /// Solves the scene; returns result.json and timings.json as well.
    #[pyo3(signature = (progress=None))]
    fn simulate(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<([String; 2], Told, Solved), Failure> {
        let input = &self.input;
        let found = watched(py, progress, |watch| {
            let line = run_line(&input.scene, &input.uncertainty, input.condition.as_ref());
            line.iter().for_each(|line| watch.note(line));
            let stage = Stage::new(watch, input.scene.run.fidelity.name(), None);
            let solved = simulate_on(&input.scene, input.specimen.as_ref(), &stage);
            let simulation = solved.map_err(|error| input.refuse_on_specimen(&error))?;
            let (simulation, report) = input.report(simulation).map_err(failed)?;
            let report = SimulationReport { wall_s: stage.finish(), threads: rayon::current_num_threads(), ..report };
            Ok::<_, Failure>(Solved { scene: input.scene.clone(), simulation, report })
        })??;
        let doubts = found.report.doubts();
        warn_all(py, &doubts)?;
        let warnings = self.warnings().into_iter().chain(doubts).collect();
        let records = json_and_timings(&found.report).map_err(failed)?;
        Ok((records, (found.report.text(), warnings, self.inputs.clone()), found))
    }

    /// Returns the steady cell of the scene's texture, which computes friction ratios for any width, spacing and depth;
    /// a `ValueError` for a flat scene.
    fn steady(&self) -> PyResult<SteadyCell> {
        match &self.input.scene.pattern {
            Some(pattern) => Ok(SteadyCell { input: self.input.clone(), texture: *pattern.texture() }),
            None => Err(PyValueError::new_err("a flat scene has no pattern to vary")),
        }
    }
}

#[pymethods]
impl Solved {
    /// All files that the command line writes, by name.
    fn files(&self, py: Python<'_>) -> Result<Vec<Named>, Failure> {
        let outputs = in_pool(py, || files::of_scene(&self.scene, &self.simulation, &self.report))?;
        contents(&outputs.map_err(failed)?)
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
    fn solve<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
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
        for ((_, places), outcomes) in groups.iter().zip(solved?) {
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

/// Pattern, and the indices of the rows with it, by the bits of their pressure in MPa, which sort as positive numbers
/// do.
type Group = (Pattern, BTreeMap<u64, Vec<usize>>);

impl SteadyCell {
    /// Groups the rows by width, spacing and depth, so that each texture is condensed once for all its loads. Rows with
    /// a NaN are left out.
    fn groups(&self, py: Python<'_>, rows: ArrayView2<'_, f64>) -> Result<BTreeMap<[u64; 3], Group>, Failure> {
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
                Entry::Vacant(new) => new.insert((self.pattern(&largest, [width, spacing, depth])?, BTreeMap::new())),
            };
            group.1.entry(pressure_mpa.to_bits()).or_default().push(row);
        }
        Ok(groups)
    }

    /// Loads by the bits of their pressures in MPa, each with the dynamic friction coefficient of the flat surface.
    fn loads(
        &self,
        py: Python<'_>,
        pressures: impl Iterator<Item = u64>,
    ) -> Result<BTreeMap<u64, (Load, f64)>, Failure> {
        let input = &self.input;
        let bits: Vec<u64> = pressures.collect::<BTreeSet<u64>>().into_iter().collect();
        let pressure = |bits: &u64| checked("pressure_mpa", f64::from_bits(*bits), PRESSURE_MPA);
        let pressures_pa: Vec<f64> = bits.iter().map(pressure).collect::<Result<_, _>>()?;
        let refuse = |reason: String| Diagnostic::key("pressure_mpa", reason);
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
    fn pattern(&self, cell: &Cell, lengths_um: [f64; 3]) -> Result<Pattern, Diagnostic> {
        const NAMED: &str = "width_um, spacing_um, depth_um";
        let given = || lengths_um.map(|length_um| length_um.to_string()).join(", ");
        let [width_m, spacing_m, depth_m] = lengths_um.map(|length_um| length_um * 1e-6);
        let pattern = Pattern::new(self.texture, width_m, spacing_m, depth_m)
            .map_err(|error| Diagnostic::flag(NAMED, given(), error.to_string()))?;
        let (bytes, max_bytes) = (cell.bytes(&pattern), cell.most_bytes());
        if bytes > max_bytes {
            let refused = Diagnostic::flag(NAMED, given(), format!("makes a cell that takes {bytes:.1e} bytes"));
            let expected = format!("a smaller pattern or larger blocks, at most {max_bytes:.1e} bytes");
            return Err(refused.expected(expected));
        }
        Ok(pattern)
    }
}
