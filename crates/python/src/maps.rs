//! Altitude maps.

use std::path::PathBuf;

use numpy::ndarray::{ArrayView2, ShapeBuilder};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use slipgrid::calibrate::area_law::{AreaLawError, AreaLawRequest, DEFAULT_PRESSURES_MPA, surface_area_law};
use slipgrid::formats::altitude_map::{open, refuse, refuse_law};
use slipgrid::formats::plausible::checked_pressures;
use slipgrid::formats::{Diagnostic, checked};
use slipgrid::report::area_law::AreaLawOptions;
use slipgrid::report::surface::{Measured, SurfaceReport};
use slipgrid::topography::{
    Crop, Decimation, DecimationMethod, Form, HeightMap, MAX_POINTS, MapFormat, Missing, Preparation, PreparedMap,
    ReadMap, ReadOptions,
};
use slipgrid::units::{MODULUS_GPA, PIXEL_UM, POISSON, PRESSURE_MPA, TOLERANCE};

use crate::counts::{shown, to_count};
use crate::errors::{Failure, failed};
use crate::progress::{Watch, watched};
use crate::scenes::named;
use slipgrid::disk::disk;

/// Side, in points, of the square tiles in which an array is transposed.
const SQUARE: usize = 32;

/// An altitude map as read or given: heights in metres, missing points NaN.
#[pyclass(frozen, module = "slipgrid._slipgrid")]
pub struct Map {
    read: ReadMap,
    path: PathBuf,
}

fn preparation(form: &str, missing: &str, despike: bool) -> PyResult<Preparation> {
    let form = named("form", form, &Form::ALL, Form::name)?;
    let missing = named("missing", missing, &Missing::ALL, Missing::name)?;
    Ok(Preparation { form, missing, despike })
}

/// Restores a map that was read from `path` in `format`, with all its data; used by copies.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are what a map is made of")]
pub fn restore_map(
    heights_m: PyReadonlyArray2<'_, f64>,
    sides_m: [f64; 2],
    whole: bool,
    format: &str,
    comments: Vec<String>,
    notes: Vec<String>,
    path: PathBuf,
) -> Result<Map, Failure> {
    let format = named("format", format, &MapFormat::ALL, MapFormat::name)?;
    let map = height_map(&heights_m, sides_m)?;
    Ok(Map { read: ReadMap { map, whole, format, comments, notes }, path })
}

/// Converts an array of heights in metres, whose rows are lines of the map along x; pixels have the sides `dx_m` and
/// `dy_m`.
fn height_map(lines_m: &PyReadonlyArray2<'_, f64>, [dx_m, dy_m]: [f64; 2]) -> Result<HeightMap, Failure> {
    let lines = lines_m.as_array();
    let (count, length) = lines.dim();
    let points = count.saturating_mul(length);
    let refused = |reason: String| Diagnostic::key("heights_m", reason);
    let mut heights: Vec<f64> = Vec::new();
    if points > MAX_POINTS || heights.try_reserve_exact(points).is_err() {
        let expected = format!("at most {MAX_POINTS}, and room for them");
        return Err(Failure::TooLarge(refused(format!("has {points} points")).expected(expected)));
    }
    heights.resize(points, 0.0);
    // Tile by tile, so that source and destination stay in the cache.
    for (from, to) in (0..count).step_by(SQUARE).flat_map(|j| (0..length).step_by(SQUARE).map(move |i| (j, i))) {
        for j in from..(from + SQUARE).min(count) {
            for i in to..(to + SQUARE).min(length) {
                heights[i * count + j] = lines[[j, i]];
            }
        }
    }
    Ok(HeightMap::new(length, count, dx_m, dy_m, heights).map_err(|error| refused(error.to_string()))?)
}

#[pymethods]
impl Map {
    /// Makes a map of `heights_m`, whose rows are lines along x, the sliding direction, with pixels of `pixel_um` along x by
    /// `pixel_y_um` micrometres.
    #[new]
    #[pyo3(signature = (heights_m, pixel_um, pixel_y_um=None))]
    fn new(heights_m: PyReadonlyArray2<'_, f64>, pixel_um: f64, pixel_y_um: Option<f64>) -> Result<Self, Failure> {
        let dx_m = checked("pixel_um", pixel_um, PIXEL_UM)?;
        let dy_m = pixel_y_um.map_or(Ok(dx_m), |pixel_um| checked("pixel_y_um", pixel_um, PIXEL_UM))?;
        let map = height_map(&heights_m, [dx_m, dy_m])?;
        let (format, comments, notes) = (MapFormat::Matrix, Vec::new(), Vec::new());
        Ok(Self { read: ReadMap { map, whole: true, format, comments, notes }, path: PathBuf::from("array") })
    }

    /// Reads the map in the file at `path`, x along its lines, in any format that `slipgrid surface` reads.
    #[staticmethod]
    #[pyo3(signature = (path, *, pixel_um=None, pixel_y_um=None, height_unit=None, lateral_unit=None, decimal_comma=false,
                        crop=None, decimate=None, decimate_by="mean"))]
    #[allow(clippy::too_many_arguments, reason = "they are named where it is called")]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        pixel_um: Option<f64>,
        pixel_y_um: Option<f64>,
        height_unit: Option<&str>,
        lateral_unit: Option<&str>,
        decimal_comma: bool,
        crop: Option<[usize; 4]>,
        decimate: Option<usize>,
        decimate_by: &str,
    ) -> Result<Self, Failure> {
        let unit = |name: Option<&str>| {
            name.map(str::parse)
                .transpose()
                .map_err(|error: slipgrid::topography::UnknownUnit| PyValueError::new_err(error.to_string()))
        };
        let x_m = pixel_um.map(|pixel_um| checked("pixel_um", pixel_um, PIXEL_UM)).transpose()?;
        let y_m = pixel_y_um.map(|pixel_um| checked("pixel_y_um", pixel_um, PIXEL_UM)).transpose()?;
        if x_m.is_none() && y_m.is_some() {
            let reason = "pixel_y_um is given without pixel_um: expected both, or pixel_um alone";
            return Err(PyValueError::new_err(reason).into());
        }
        let method = || named("decimate_by", decimate_by, &DecimationMethod::ALL, DecimationMethod::name);
        let decimation = |factor| Ok::<_, PyErr>(Decimation { factor, method: method()? });
        let options = ReadOptions {
            pixel_m: x_m.map(|x_m| [x_m, y_m.unwrap_or(x_m)]),
            height_unit: unit(height_unit)?,
            lateral_unit: unit(lateral_unit)?,
            decimal_comma,
            crop: crop.map(|[first_row, first_col, rows, cols]| Crop { first_row, first_col, rows, cols }),
            decimation: decimate.map(decimation).transpose()?,
            ..ReadOptions::default()
        };
        Ok(Self { read: watched(py, None, |watch| open(&disk(), &path, &options, watch))??, path })
    }

    /// Constructor and arguments from which `pickle` and `copy` restore the map, on any machine.
    fn __reduce__<'py>(this: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let py = this.py();
        let Self { read: ReadMap { map, whole, format, comments, notes }, path } = this.get();
        let (heights_m, sides_m) = (Self::heights_m(this)?, [map.dx_m(), map.dy_m()]);
        let parts = (heights_m, sides_m, *whole, format.name(), comments, notes, path.as_os_str());
        Ok((py.import("slipgrid._slipgrid")?.getattr("restore_map")?, parts.into_pyobject(py)?))
    }

    /// Heights in metres, whose rows are lines along x, the sliding direction: a read-only view of the map's data.
    #[getter]
    fn heights_m<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let map = &this.get().read.map;
        // In the map, the points of a line are `cols` apart.
        let shape = (map.cols(), map.rows()).strides((1, map.cols()));
        let view = ArrayView2::from_shape(shape, map.heights_m());
        let view = view.map_err(|error| PyValueError::new_err(error.to_string()))?;
        // The array keeps the map alive, and a frozen class never moves or changes its heights.
        #[allow(unsafe_code)]
        let lent = unsafe { PyArray2::borrow_from_array(&view, this.clone().into_any()) };
        let flags = pyo3::types::PyDict::new(this.py());
        flags.set_item("write", false)?;
        lent.call_method("setflags", (), Some(&flags))?;
        Ok(lent)
    }

    /// Sides of a pixel in micrometres: along x, from point to point of a row, and along y, from row to row.
    #[getter]
    fn pixel_um(&self) -> (f64, f64) {
        let um = |side_m: f64| slipgrid::units::tidy(side_m * 1e6);
        (um(self.read.map.dx_m()), um(self.read.map.dy_m()))
    }

    /// Sides of a pixel in metres, along x and along y, to the last bit.
    #[getter]
    fn sides_m(&self) -> (f64, f64) {
        (self.read.map.dx_m(), self.read.map.dy_m())
    }

    /// The file states that the surface is synthetic.
    #[getter]
    fn is_synthetic(&self) -> bool {
        self.read.is_synthetic()
    }

    /// Parameters of the map, as `slipgrid surface --json` writes them.
    #[pyo3(signature = (*, form="plane", missing="fill", despike=false))]
    fn measure_json(&self, py: Python<'_>, form: &str, missing: &str, despike: bool) -> Result<String, Failure> {
        let how = preparation(form, missing, despike)?;
        Ok(watched(py, None, |watch| self.measure(how, watch))??)
    }

    /// Real contact area and area law at `pressures_mpa`, as `slipgrid area-law --json` writes them.
    #[pyo3(signature = (*, youngs_modulus_gpa, poisson_ratio=1.0/3.0, pressures_mpa=None, threshold_mpa=None,
                        tolerance=1e-8, form="plane", missing="fill", despike=false, windows=None, progress=None))]
    #[allow(clippy::too_many_arguments, reason = "they are named where it is called")]
    fn area_law_json(
        &self,
        py: Python<'_>,
        youngs_modulus_gpa: f64,
        poisson_ratio: f64,
        pressures_mpa: Option<Vec<f64>>,
        threshold_mpa: Option<f64>,
        tolerance: f64,
        form: &str,
        missing: &str,
        despike: bool,
        windows: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<String, Failure> {
        let how = preparation(form, missing, despike)?;
        let pressures_mpa = pressures_mpa.unwrap_or_else(|| DEFAULT_PRESSURES_MPA.to_vec());
        checked("youngs_modulus_gpa", youngs_modulus_gpa, MODULUS_GPA)?;
        let wanted = AreaLawOptions {
            youngs_modulus_gpa,
            poisson_ratio: checked("poisson_ratio", poisson_ratio, POISSON)?,
            tolerance: checked("tolerance", tolerance, TOLERANCE)?,
            threshold_pa: threshold_mpa.map(|mpa| checked("threshold_mpa", mpa, PRESSURE_MPA)).transpose()?,
            pressures_pa: checked_pressures("pressures_mpa", &pressures_mpa)?,
        };
        let per_side = |given: &Bound<'_, PyAny>| {
            let refused = Diagnostic::flag("windows", shown(given), "is no number of windows");
            let refused = || refused.expected("1 for none, 2 or more, or None");
            to_count("windows", given)?.filter(|count| *count > 0).ok_or_else(|| Failure::from(refused()))
        };
        let windows = windows.map(per_side).transpose()?;
        let report = watched(py, progress, |watch| {
            let surface =
                PreparedMap::one_period(self.read.clone(), how, watch).map_err(|error| refuse(&self.path, &error))?;
            let wanted = wanted.on_surface(surface.rms_slope, Some(surface.map.rows() * surface.map.cols()));
            let request = AreaLawRequest { windows, ..wanted.law() };
            let found = surface_area_law(&surface, &request, watch).map_err(|error| match (&error, windows) {
                (AreaLawError::Windows(_), Some(per_side)) => {
                    Diagnostic::flag("windows", per_side.to_string(), error.to_string())
                }
                (error, _) => refuse_law(&self.path, error).unwrap_or_default(),
            })?;
            Ok::<_, Diagnostic>(wanted.of_map(&self.path.display().to_string(), &surface, &found, &[]))
        })??;
        slipgrid::results::json(&report).map_err(failed)
    }

    fn __repr__(&self) -> String {
        let map = &self.read.map;
        let (dx_um, dy_um) = self.pixel_um();
        format!("<slipgrid.Map {} x {} pixels of {dx_um} x {dy_um} um>", map.cols(), map.rows())
    }
}

impl Map {
    fn measure(&self, how: Preparation, watch: &Watch) -> Result<String, Diagnostic> {
        let plain = |reason: String| Diagnostic::file(&self.path, reason);
        let surface = PreparedMap::new(self.read.clone(), how, watch).map_err(|error| refuse(&self.path, &error))?;
        let report = Measured::new(surface, None, watch).and_then(|of| SurfaceReport::new(&self.path, &of, watch));
        let report = report.map_err(|error| plain(error.to_string()))?;
        slipgrid::results::json(&report).map_err(|error| plain(error.to_string()))
    }
}
