//! `[surface]` of a calibration file: source of the area law, and options for reading an altitude map.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::monitor::Monitor;
use slipgrid_infer::calibrate::{MapSurface, Measurement, Surface, flat_friction_law};
use slipgrid_model::material::Extrapolation;
use slipgrid_surface::topography::{
    Crop, Decimation, DecimationMethod, Form, LengthUnit, Missing, Preparation, ReadOptions,
};

use super::altitude_map::read_period;
use super::material::existing;
use super::values::Number;
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{LENGTH_UM, SLOPE};

/// The table `[surface]` of a calibration file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// Altitude map of a flat sample before the test, from which the area law is computed.
    map: Option<Spanned<String>>,
    /// Altitude map of a flat sample after the test; its difference from `map` is reported.
    map_after: Option<Spanned<String>>,
    /// Dependence of local friction on local pressure: `area` follows real contact area, `measured` follows flat
    /// friction as measured; `area` when absent.
    local_law: Option<Spanned<String>>,
    /// Extrapolation of a measured law above the last measured pressure: `constant` or `logarithmic`.
    extrapolation: Option<Spanned<String>>,
    /// Rms slope for Persson's law, if there is no map.
    persson_rms_slope: Option<Number>,
    /// The map is synthetic, not measured; false when absent.
    synthetic: Option<bool>,
    /// Distance of points along x, on one line of the file, if the file does not state it.
    pixel_um: Option<Number>,
    /// Distance of points along y, from line to line; as along x when absent.
    pixel_y_um: Option<Number>,
    /// Unit of heights, if the file does not state it: `m`, `cm`, `mm`, `um`, `nm` or `pm`.
    height_unit: Option<Spanned<String>>,
    /// Unit of x and y in lists of points x y z; takes the values of `height_unit`.
    lateral_unit: Option<Spanned<String>>,
    /// Numbers are written with a decimal comma; false when absent, and needed only if commas may be thousands
    /// separators, as in 1,234.
    decimal_comma: Option<bool>,
    /// Part of the map to use: first row, first column, rows, columns.
    crop: Option<Spanned<Vec<usize>>>,
    /// Number N of points along each side that are joined into one: N x N points become one.
    decimate: Option<Spanned<usize>>,
    /// Value of joined points: `mean` of the points or `pick` the first; `mean` when absent.
    decimate_by: Option<Spanned<String>>,
    /// Treatment of points that were not measured: `fill` them, or `refuse` the map; `fill` when absent.
    #[schemars(with = "Option<String>")]
    missing: Option<Missing>,
    /// Replace spikes by the median of the neighbouring points; false when absent.
    despike: Option<bool>,
    /// Form that is subtracted from the map: `mean`, `plane` or `second-order`; `plane` when absent.
    /// From a map of exactly one period only the mean is subtracted.
    #[schemars(with = "Option<String>")]
    form: Option<Form>,
    /// Pressure up to which friction counts as proportional to load; without the key, area factors are relative to the
    /// limit at small loads.
    pub threshold_mpa: Option<Number>,
    /// Number of windows along each side of the map, whose scatter gives the errors of the law: 0 or 1 for none;
    /// without the key 2, if the map is large enough.
    windows: Option<Spanned<usize>>,
}

/// Options for reading a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// Known properties of the file, and the part to use.
    pub read: ReadOptions,
    /// Preparation of the map after reading. From a map of one whole period, only the mean is subtracted, not the form.
    pub how: Preparation,
}

/// Altitude map of a calibration, from which its area law is computed, with the options for reading the map.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMap {
    /// Path of the map.
    pub path: PathBuf,
    /// Whether the calibration file declares the map synthetic.
    pub synthetic: bool,
    /// Options for reading the map.
    pub options: MapOptions,
    /// Number of windows along each side of the map whose scatter gives the standard errors of the law; fewer than 2 for
    /// none, `None` for the default.
    pub windows: Option<usize>,
    /// Path of the map of a flat sample after the test, which is read with the same options and only compared with
    /// `path`.
    pub after: Option<PathBuf>,
}

impl NamedMap {
    /// Reads and prepares the maps.
    ///
    /// # Errors
    /// Errors of [`read_period`].
    pub(crate) fn read(&self, files: &Source, monitor: &dyn Monitor) -> Result<MapSurface, Diagnostic> {
        let period = |path: &PathBuf| read_period(files, path, &self.options, monitor);
        Ok(MapSurface {
            map: period(&self.path)?,
            synthetic: self.synthetic,
            windows: self.windows,
            after: self.after.as_ref().map(period).transpose()?,
        })
    }
}

/// Reads the table `[surface]`: the source of the area law, or the map of which it is computed. `flat` are the
/// measurements on flat samples, on a specimen of the area `area_m2`.
///
/// # Errors
/// [`Diagnostic`] unless the table names one of a map, a slope and a measured law, and every value is valid.
pub(crate) fn read_surface(
    document: &Document,
    file: &Spanned<SurfaceFile>,
    (flat, area_m2): (&[Measurement], f64),
) -> Result<(Surface, Option<NamedMap>), Diagnostic> {
    let surface = file.get_ref();
    let law = |law| document.choice(law, &[true, false], |measured| if measured { "measured" } else { "area" });
    if surface.local_law.as_ref().map(law).transpose()? == Some(true) {
        return Ok((measured_law(document, file, flat, area_m2)?, None));
    }
    if let Some(extrapolation) = &surface.extrapolation {
        return Err(document
            .refuse(extrapolation.span(), "stands without a measured law")
            .expected("`local_law = \"measured\"` beside it, or none"));
    }
    if let (Some(after), None) = (&surface.map_after, &surface.map) {
        return Err(document.refuse(after.span(), "stands alone").expected("`map` beside it: the map before the test"));
    }
    let existing = |path: &Spanned<String>| existing(document, path, path.get_ref());
    match (&surface.map, &surface.persson_rms_slope, &surface.windows) {
        (Some(_), Some(slope), _) => {
            Err(document.refuse(slope.span(), "stands beside a map").expected("either `map` or `persson_rms_slope`"))
        }
        (None, None, _) => Err(document.missing(file.span(), "map").expected("`map` or `persson_rms_slope`")),
        (None, Some(_), Some(windows)) => {
            Err(document.refuse(windows.span(), "stands without a map").expected("windows only of a map"))
        }
        (None, Some(slope), None) => Ok((Surface::RmsSlope(document.number(slope, SLOPE)?), None)),
        (Some(map), None, windows) => {
            let map = NamedMap {
                path: existing(map)?,
                synthetic: surface.synthetic.unwrap_or(false),
                options: options(document, surface)?,
                windows: windows.as_ref().map(|windows| *windows.get_ref()),
                after: surface.map_after.as_ref().map(existing).transpose()?,
            };
            Ok((Surface::None, Some(map)))
        }
    }
}

/// Area law that follows from the measured friction of flat samples, which `local_law = "measured"` asks for.
fn measured_law(
    document: &Document,
    table: &Spanned<SurfaceFile>,
    flat: &[Measurement],
    area_m2: f64,
) -> Result<Surface, Diagnostic> {
    let file = table.get_ref();
    let maps = file.map.as_ref().or(file.map_after.as_ref()).map(Spanned::span);
    if let Some(stray) = maps.or(file.persson_rms_slope.as_ref().map(Spanned::span)) {
        return Err(document
            .refuse(stray, "stands beside local_law = \"measured\", which takes no surface")
            .expected("either local_law = \"measured\" alone, or a surface by map or persson_rms_slope"));
    }
    let Some(extrapolation) = &file.extrapolation else {
        let expected = "\"constant\" or \"logarithmic\": how friction goes on above the last measured pressure";
        return Err(document.missing(table.span(), "extrapolation").expected(expected));
    };
    let extrapolation = document.choice(extrapolation, &Extrapolation::ALL, Extrapolation::name)?;
    let law = flat_friction_law(flat, area_m2, extrapolation)
        .map_err(|error| document.refuse(table.span(), error.to_string()))?;
    let law = law.ok_or_else(|| {
        let reason = "takes flat friction for the law of local pressure, and no condition has it at several pressures";
        document
            .refuse(table.span(), reason)
            .expected("flat samples measured at one speed and humidity at two forces or more, the lightest among them")
    })?;
    Ok(Surface::FlatFriction { law, extrapolation })
}

fn options(document: &Document, file: &SurfaceFile) -> Result<MapOptions, Diagnostic> {
    let unit = |name: &Option<Spanned<String>>| name.as_ref().map(|name| unit(document, name)).transpose();
    let read = ReadOptions {
        pixel_m: pixel(document, file)?,
        height_unit: unit(&file.height_unit)?,
        lateral_unit: unit(&file.lateral_unit)?,
        decimal_comma: file.decimal_comma.unwrap_or(false),
        crop: file.crop.as_ref().map(|crop| self::crop(document, crop)).transpose()?,
        decimation: decimation(document, file)?,
        ..ReadOptions::default()
    };
    let how = Preparation {
        form: file.form.unwrap_or_default(),
        missing: file.missing.unwrap_or_default(),
        despike: file.despike.unwrap_or(false),
    };
    Ok(MapOptions { read, how })
}

fn pixel(document: &Document, file: &SurfaceFile) -> Result<Option<[f64; 2]>, Diagnostic> {
    let along_y_m = document.optional(file.pixel_y_um.as_ref(), LENGTH_UM)?;
    match (document.optional(file.pixel_um.as_ref(), LENGTH_UM)?, &file.pixel_y_um) {
        (Some(along_x_m), _) => Ok(Some([along_x_m, along_y_m.unwrap_or(along_x_m)])),
        (None, Some(along_y)) => Err(document.refuse(along_y.span(), "stands alone").expected("`pixel_um` beside it")),
        (None, None) => Ok(None),
    }
}

fn unit(document: &Document, name: &Spanned<String>) -> Result<LengthUnit, Diagnostic> {
    name.get_ref().parse().map_err(|_| document.refuse(name.span(), "is no unit of length").expected(LengthUnit::NAMES))
}

fn crop(document: &Document, crop: &Spanned<Vec<usize>>) -> Result<Crop, Diagnostic> {
    match crop.get_ref()[..] {
        [first_row, first_col, rows, cols] if rows > 1 && cols > 1 => Ok(Crop { first_row, first_col, rows, cols }),
        _ => Err(document
            .refuse(crop.span(), "is no part of a map")
            .expected("first row, first column, rows, columns, the last two from 2 up, as [0, 0, 512, 512]")),
    }
}

fn decimation(document: &Document, file: &SurfaceFile) -> Result<Option<Decimation>, Diagnostic> {
    let choice = |name| document.choice(name, &DecimationMethod::ALL, DecimationMethod::name);
    let method = file.decimate_by.as_ref().map(choice).transpose()?;
    match (&file.decimate, &file.decimate_by) {
        (Some(factor), _) if *factor.get_ref() == 0 => {
            Err(document.refuse(factor.span(), "is out of range").expected("a whole number from 1 up"))
        }
        (Some(factor), _) => Ok(Some(Decimation { factor: *factor.get_ref(), method: method.unwrap_or_default() })),
        (None, Some(name)) => Err(document.refuse(name.span(), "stands alone").expected("`decimate` beside it")),
        (None, None) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> MapOptions {
        let document = Document::new("calibration.toml", text);
        options(&document, &document.parse().unwrap()).unwrap()
    }

    #[test]
    fn every_key_arrives_at_the_reader() {
        let found = read(
            "pixel_um = 0.5\npixel_y_um = 2.0\nheight_unit = \"nm\"\nlateral_unit = \"mm\"\ndecimal_comma = true\ncrop = [1, 2, 30, 40]\n\
             decimate = 3\ndecimate_by = \"pick\"\nmissing = \"refuse\"\ndespike = true\nform = \"second-order\"\n",
        );
        let read = ReadOptions {
            format: None,
            pixel_m: Some([0.5e-6, 2e-6]),
            height_unit: Some(LengthUnit::Nanometre),
            lateral_unit: Some(LengthUnit::Millimetre),
            decimal_comma: true,
            crop: Some(Crop { first_row: 1, first_col: 2, rows: 30, cols: 40 }),
            decimation: Some(Decimation { factor: 3, method: DecimationMethod::Pick }),
        };
        let how = Preparation { form: Form::SecondOrder, missing: Missing::Refuse, despike: true };
        assert_eq!(found, MapOptions { read, how });
    }

    #[test]
    fn without_keys_the_whole_map_is_filled_and_levelled() {
        let how = Preparation { form: Form::Plane, missing: Missing::Fill, despike: false };
        let expected = |form| MapOptions { read: ReadOptions::default(), how: Preparation { form, ..how } };
        assert_eq!(read(""), expected(Form::Plane));
        assert_eq!(read("form = \"mean\""), expected(Form::Mean));
        let by_mean = Decimation { factor: 2, method: DecimationMethod::Mean };
        assert_eq!(read("decimate = 2").read.decimation, Some(by_mean));
    }
}
