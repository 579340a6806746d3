//! Reads the file of an altitude map and prepares the map for computation.

use std::io::BufReader;
use std::path::Path;

use slipgrid_base::key_error::Refusal;
use slipgrid_base::monitor::{CancellableReader, Monitor};
use slipgrid_infer::calibrate::LandSlope;
use slipgrid_infer::calibrate::area_law::{AreaLawError, SurfaceWarning};
use slipgrid_model::material::MAX_FACTOR;
use slipgrid_surface::topography::{
    HeightMap, MapDoubt, MapError, MapOption, MapWarning, Preparation, PreparationError, PreparedMap, ReadError,
    ReadMap, ReadOptions, limits, read_map,
};

use crate::formats::Diagnostic;
use crate::formats::file_kind::FileKind;
use crate::formats::source::{Source, read_text, stream};
use crate::formats::surface::MapOptions;
use slipgrid_base::units::{LENGTH_UM, significant, tidy};

/// Description of the expected file in messages.
const EXPECTED: &str = "the file of an altitude map";

/// Reads the map at `path` and prepares it as one period of a periodic surface, for a contact computation.
///
/// # Errors
/// [`Diagnostic`] if the file cannot be read or is no map, if no real surface has the slope of the map, or if `monitor`
/// has cancelled.
pub fn read_period(
    source: &Source,
    path: &Path,
    options: &MapOptions,
    monitor: &dyn Monitor,
) -> Result<PreparedMap, Diagnostic> {
    let (read, how) = read_for(source, path, options, monitor)?;
    PreparedMap::one_period(read, how, monitor).map_err(|error| refuse(path, &error))
}

/// Maximum relative difference of the pixel sizes of two maps whose slopes are compared: the slope then changes by less
/// than half of this difference.
const SAME_PIXEL: f64 = 0.02;

/// Computes the rms slope of the land on the map of a cut sample at `path`, and the ratio of this slope to that of the
/// map `flat`. `options` are the options of the flat map; all except the crop are applied to the map of the cut sample.
///
/// # Errors
/// Errors of [`open`]; [`Diagnostic`] if the map shows no cavities or no land, or if its pixels differ from those of `flat`.
pub fn read_land(
    source: &Source,
    path: &Path,
    options: &MapOptions,
    flat: &PreparedMap,
    monitor: &dyn Monitor,
) -> Result<LandSlope, Diagnostic> {
    let whole = MapOptions { read: ReadOptions { crop: None, ..options.read }, ..options.clone() };
    let (read, how) = read_for(source, path, &whole, monitor)?;
    let refuse = |error: MapError| Diagnostic::file(path, error.to_string());
    let read = if how.despike { read.despiked(monitor).map_err(refuse)? } else { read };
    let sides_um = |map: &HeightMap| [map.dx_m(), map.dy_m()].map(|side_m| LENGTH_UM.from_si(side_m));
    let (own, other) = (sides_um(&read.map), sides_um(&flat.map));
    if own.iter().zip(other).any(|(own, other)| (own / other - 1.0).abs() > SAME_PIXEL) {
        let [own, other] = [own, other].map(|[x, y]| format!("{} x {} um", tidy(x), tidy(y)));
        let reason = format!("has pixels of {own}, and the slope of its land is compared with that of the flat sample");
        return Err(
            Diagnostic::file(path, reason).expected(format!("pixels of {other}, as on the map of the flat sample"))
        );
    }
    let land = read.map.land(how.form, monitor).map_err(refuse)?;
    LandSlope::of_maps(&land, &flat.map).ok_or_else(|| {
        Diagnostic::file(path, "shows too little land between its cavities for a slope").expected("a larger map")
    })
}

/// Reads the map at `path`, and returns it with the preparation that remains to be done. Spikes are removed before
/// points are joined, because a spike can no longer be found in a mean over several points.
///
/// # Errors
/// Errors of [`open`].
pub fn read_for(
    source: &Source,
    path: &Path,
    options: &MapOptions,
    monitor: &dyn Monitor,
) -> Result<(ReadMap, Preparation), Diagnostic> {
    let how = options.how;
    let Some(decimation) = options.read.decimation.filter(|_| how.despike) else {
        return Ok((open(source, path, &options.read, monitor)?, how));
    };
    let read = open(source, path, &ReadOptions { decimation: None, ..options.read }, monitor)?;
    let read = read.despiked(monitor).map_err(|error| Diagnostic::file(path, error.to_string()))?;
    let read = read.decimated(decimation).map_err(|error| Diagnostic::file(path, error.to_string()))?;
    Ok((read, Preparation { despike: false, ..how }))
}

/// Diagnostic for an error in the preparation of the map at `path`, with the accepted range or options.
pub fn refuse(path: &Path, error: &PreparationError) -> Diagnostic {
    let mut refused = Diagnostic::file(path, error.to_string());
    match error {
        PreparationError::Map(_) => refused,
        PreparationError::MostlyMissing { .. } => {
            refused.expected(format!("at most {:.0} %; crop the map", 100.0 * limits::MAX_MISSING_SHARE))
        }
        PreparationError::ImpossibleSlope { warnings, .. } => {
            let [least, most] = limits::POSSIBLE_SLOPE;
            refused.reason += &listed(warnings);
            refused.expected(format!(
                "a slope from {least:e} to {most}: see the units of heights (height_unit) and of pixels"
            ))
        }
    }
}

/// Joins warnings to a text that is appended to the reason of a refusal.
fn listed(warnings: &[MapWarning]) -> String {
    warnings.iter().map(|warning| format!("; {}", told(warning))).collect()
}

/// Texts of `warnings` about an area law; warnings about the map include advice.
pub fn law_warnings(warnings: &[SurfaceWarning]) -> Vec<String> {
    let text = |warning: &SurfaceWarning| match warning {
        SurfaceWarning::Map(warning) => told(warning),
        _ => warning.to_string(),
    };
    warnings.iter().map(text).collect()
}

/// Text of a warning about a map, with the options that would help.
pub fn told(warning: &MapWarning) -> String {
    match warning.doubt {
        MapDoubt::Spikes => format!("{warning}; --despike, or despike = true in [surface], replaces them"),
        MapDoubt::Curved => {
            format!("{warning}; --form second-order, or form = \"second-order\" in [surface], subtracts it")
        }
        MapDoubt::Pixels => {
            format!("{warning}; --pixel-um and --pixel-y-um, or pixel_um and pixel_y_um in [surface], give both")
        }
        _ => warning.to_string(),
    }
}

/// Reads the map at `path` with `options` and without further preparation.
///
/// # Errors
/// [`Diagnostic`] if the file cannot be read or is no map, or `monitor` has cancelled.
pub fn open(source: &Source, path: &Path, options: &ReadOptions, monitor: &dyn Monitor) -> Result<ReadMap, Diagnostic> {
    let file = stream(source, path, EXPECTED)?;
    read_map(BufReader::new(CancellableReader::new(file, monitor)), options).map_err(|error| {
        // A TOML file given in place of a map is recognised by its file name, because maps may be large.
        let text = path.extension().filter(|&extension| extension == "toml").map(|_| read_text(source, path, EXPECTED));
        let found = text.and_then(Result::ok).and_then(|text| FileKind::of(&text));
        match (found, error) {
            (Some(kind), _) => Diagnostic::file(path, kind.seems()).expected(EXPECTED),
            (None, error) => refuse_read(path, &error),
        }
    })
}

/// Diagnostic for an error in reading the map at `path`, with the options that would help, if any.
fn refuse_read(path: &Path, error: &ReadError) -> Diagnostic {
    let ways: Vec<String> = match error {
        ReadError::NotGiven { missing } | ReadError::DecimalComma { missing, .. } => {
            missing.iter().map(|missing| how_to_give(missing.option).to_owned()).collect()
        }
        &ReadError::Oblong { sides_m: [along_y_m, along_x_m], rows, cols } => {
            let pixel_m = [along_x_m / cols as f64, along_y_m / rows as f64];
            let [x, y] = pixel_m.map(|side_m| significant(LENGTH_UM.from_si(side_m), 6));
            vec![format!(
                "--pixel-um {x} --pixel-y-um {y}; in a calibration's [surface]: pixel_um = {x}, pixel_y_um = {y}"
            )]
        }
        _ => return Diagnostic::file(path, error.to_string()),
    };
    let refusal = Refusal::from_error(error);
    let expected = refusal.expected().unwrap_or_default();
    Diagnostic::file(path, refusal.to_string()).expected(format!("{expected} ({})", ways.join("; ")))
}

/// Example of how to give `option` on the command line and in a calibration file.
const fn how_to_give(option: MapOption) -> &'static str {
    match option {
        MapOption::HeightUnit => "--height-unit um; in a calibration's [surface]: height_unit = \"um\"",
        MapOption::LateralUnit => "--lateral-unit um; in a calibration's [surface]: lateral_unit = \"um\"",
        MapOption::Pixel => "--pixel-um 0.5; in a calibration's [surface]: pixel_um = 0.5",
    }
}

/// Diagnostic for an error in the area law of the map at `path`; `None` if the computation was cancelled.
pub fn refuse_law(path: &Path, error: &AreaLawError) -> Option<Diagnostic> {
    let mut refused = Diagnostic::file(path, error.to_string());
    match error {
        AreaLawError::Cancelled => return None,
        AreaLawError::FactorsAboveOne { warnings, .. } => {
            refused.reason += &listed(warnings);
            refused = refused.expected(format!(
                "contact area that grows no faster than pressure, f at most {MAX_FACTOR}: {}",
                cure(warnings)
            ));
        }
        AreaLawError::Contact(_) | AreaLawError::Windows(_) => {}
    }
    Some(refused)
}

/// Advice for a map whose area factor f exceeds 1, chosen by the warnings about the map.
fn cure(warnings: &[MapWarning]) -> &'static str {
    let is_any = |doubts: &[MapDoubt]| warnings.iter().any(|warning| doubts.contains(&warning.doubt));
    if is_any(&[MapDoubt::Hole, MapDoubt::MissingPoints]) {
        "crop the map to what was measured of the surface itself (--crop ROW,COL,ROWS,COLS; crop in [surface])"
    } else if is_any(&[MapDoubt::Spikes]) {
        "the spikes carry the load of the surface (--despike; despike = true in [surface])"
    } else if is_any(&[MapDoubt::Debris]) {
        "the debris carries the load of the surface: crop the map beside it (--crop ROW,COL,ROWS,COLS; crop in [surface]), or clean the \
         specimen and measure again"
    } else {
        "a few high points carry the load of the surface, which neither spikes, debris nor holes explain: a larger or another part of \
         it (--crop ROW,COL,ROWS,COLS; crop in [surface])"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_that_a_header_with_oblong_ones_makes_are_those_to_be_given() {
        let error = ReadError::Oblong { sides_m: [480e-6, 480e-6], rows: 240, cols: 320 };
        let said = refuse_read(Path::new("m.asc"), &error).to_string();
        assert!(said.contains("make pixels of 1.5 x 2 um"), "{said}");
        let given = "(--pixel-um 1.5 --pixel-y-um 2; in a calibration's [surface]: pixel_um = 1.5, pixel_y_um = 2)";
        assert!(said.ends_with(given), "{said}");
    }

    #[test]
    fn one_cure_is_named_for_a_map_whose_law_means_nothing() {
        let [spikes, hole, missing] = [MapDoubt::Spikes, MapDoubt::Hole, MapDoubt::MissingPoints]
            .map(|doubt| MapWarning { doubt, text: String::new() });
        for (warnings, crop, despike) in [
            (vec![spikes.clone()], false, true),
            (vec![spikes.clone(), hole], true, false),
            (vec![missing, spikes], true, false),
            (vec![], true, false),
        ] {
            let cure = cure(&warnings);
            assert_eq!([cure.contains("--crop"), cure.contains("--despike")], [crop, despike], "{warnings:?}");
        }
    }
}
