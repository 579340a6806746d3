//! From the file of an altitude map to a map ready for computation.

use std::io::BufReader;
use std::path::Path;

use slipgrid_contact::{periodic_component, side_step_ratio};
use slipgrid_topography::{
    Form, HeightMap, MapFormat, MapOption, MapWarning, ReadError, ReadMap, ReadOptions, limits, read_map,
};

use crate::input;
use slipgrid_formats::Diagnostic;
use slipgrid_formats::file_kind::FileKind;
use slipgrid_formats::source::read_text;
use slipgrid_formats::surface::{MapOptions, Missing};

/// Rms step across opposite sides, over that between neighbours, up to which a map is taken as one period: a
/// period has about 1, a piece of a smooth surface many times that.
const PERIOD_STEP_RATIO: f64 = 1.5;

/// What a file should be.
const EXPECTED: &str = "the file of an altitude map";

/// A map ready for computation.
#[derive(Clone, Debug)]
pub struct SurfaceMap {
    /// The map, complete.
    pub map: HeightMap,
    /// The file says of itself that it is synthetic.
    pub synthetic: bool,
    /// The file says of itself that it is one whole period.
    pub period: bool,
    /// The file's format.
    pub format: MapFormat,
    /// Missing points of the file, row by row; empty if none are.
    pub filled: Vec<bool>,
    /// Arithmetic mean height Sa, in metres.
    pub sa_m: f64,
    /// Rms slope, from the spectrum.
    pub rms_slope: f64,
    /// What was done to it.
    pub notes: Vec<String>,
    /// What makes numbers computed from it doubtful; each begins with its name.
    pub warnings: Vec<String>,
}

impl SurfaceMap {
    /// Reads the map at `path` as one period, for a contact computation: a map whose opposite sides do not continue
    /// each other is replaced by its periodic component.
    ///
    /// # Errors
    /// [`Diagnostic`] if the file cannot be read or is no map, or no surface has its slope.
    pub fn read_period(path: &Path, options: &MapOptions) -> Result<Self, Diagnostic> {
        let surface = Self::build(path, open(path, &options.read)?, options, true)?;
        let [least, most] = limits::POSSIBLE_SLOPE;
        if (least..=most).contains(&surface.rms_slope) {
            return Ok(surface);
        }
        let mut reason = format!("the rms slope is {:.2e}: its contact area means nothing", surface.rms_slope);
        for warning in &surface.warnings {
            reason += &format!("; {warning}");
        }
        Err(Diagnostic::file(path, reason).expected(format!("a slope from {least:e} to {most}; see the units")))
    }

    /// Fills what is missing in the map that was `read` and removes its form.
    ///
    /// # Errors
    /// [`Diagnostic`] if points are missing that must not, nearly all are, or they do not determine the form.
    pub fn new(path: &Path, read: ReadMap, options: &MapOptions) -> Result<Self, Diagnostic> {
        Self::build(path, read, options, false)
    }

    fn build(path: &Path, read: ReadMap, options: &MapOptions, one_period: bool) -> Result<Self, Diagnostic> {
        let refuse = |error: &dyn std::fmt::Display| Diagnostic::file(path, error.to_string());
        let synthetic = read.is_synthetic();
        // A part of a period is none.
        let mut period = read.whole && is_period(&read.comments);
        let mut map = read.map;
        let mut notes = read.notes;
        if options.missing == Missing::Refuse {
            map.require_complete().map_err(|error| refuse(&error))?;
        }
        let (missing, points) = (map.missing(), map.rows() * map.cols());
        if missing as f64 > limits::MOST_MISSING_SHARE * points as f64 {
            let reason = format!("{missing} of {points} points are missing: what would fill them is no measurement");
            let expected = format!("at most {:.0} %; crop the map", 100.0 * limits::MOST_MISSING_SHARE);
            return Err(Diagnostic::file(path, reason).expected(expected));
        }
        if options.despike {
            notes.push(despiked(&mut map));
        }
        let spiked = map.spike_warning();
        let spike_points = match &spiked {
            Some(MapWarning::Spikes { spikes, .. }) => spikes.points(),
            _ => 0,
        };
        let mut warnings: Vec<String> = spiked.map(told).into_iter().collect();
        warnings.extend(map.missing_warning().map(told));
        let filled = match map.missing() {
            0 => Vec::new(),
            _ => map.heights_m().iter().map(|height| height.is_nan()).collect(),
        };
        let filling = map.fill_missing();
        if filling.points > 0 {
            let residual = if filling.converged { ", to a residual of 1e-10 of the start" } else { "" };
            notes.push(format!(
                "{} of {points} points ({:.1} %) were missing and have been filled by the smoothest surface{residual}",
                filling.points,
                100.0 * filling.points as f64 / points as f64,
            ));
            if !filling.converged {
                notes.push(format!(
                    "the filled heights are approximate: residual {:.1e} of the start after {} iterations",
                    filling.residual, filling.iterations
                ));
            }
        }
        let step_ratio = side_step_ratio(&map).map_err(|error| refuse(&error))?;
        period |= one_period && step_ratio <= PERIOD_STEP_RATIO;
        // A plane through one period would leave a step where the period closes.
        match options.form {
            Form::Plane if !period => {
                map.subtract_plane().map_err(|error| refuse(&error))?;
                notes.push("the least-squares plane has been subtracted".to_owned());
            }
            Form::SecondOrder if !period => {
                map.remove_form(Form::SecondOrder).map_err(|error| refuse(&error))?;
                notes.push("the least-squares surface of second order has been subtracted".to_owned());
            }
            _ => {
                map.subtract_mean();
                notes.push("no plane has been subtracted".to_owned());
            }
        }
        if one_period && !period && options.form != Form::Mean {
            map = periodic_component(&map).map_err(|error| refuse(&error))?;
            notes.push(format!(
                "opposite sides do not continue each other (steps {step_ratio:.1} times those between neighbours): the \
                 map is taken as its periodic component (Moisan)"
            ));
        } else if one_period {
            notes.push("the map is taken as one period as it is".to_owned());
        }
        let rms_slope = map.rms_slope_spectral().map_err(|error| refuse(&error))?;
        // High points that are spikes are no debris beside.
        let is_new =
            |warning: &MapWarning| !matches!(warning, MapWarning::Raised { points, .. } if *points <= spike_points);
        warnings.extend(map.height_warnings(rms_slope).into_iter().filter(is_new).map(told));
        Ok(Self { sa_m: map.sa_m(), rms_slope, format: read.format, map, synthetic, period, filled, notes, warnings })
    }

    /// Pixel size along the sliding direction, in metres.
    #[must_use]
    pub const fn pixel_m(&self) -> f64 {
        self.map.dx_m()
    }
}

/// Removes spikes and says which.
pub fn despiked(map: &mut HeightMap) -> String {
    let spikes = map.despike();
    if spikes.points() == 0 {
        return "despiked: no spikes were found".to_owned();
    }
    format!("despiked: {spikes} and have been replaced by the median of the points about them")
}

/// A warning with what can be done about it.
fn told(warning: MapWarning) -> String {
    match &warning {
        MapWarning::Spikes { .. } => format!("{warning}; --despike, or despike = true in [surface], replaces them"),
        _ => warning.to_string(),
    }
}

/// Reads the map at `path` as it is.
///
/// # Errors
/// [`Diagnostic`] if the file cannot be read or is no map.
pub fn open(path: &Path, options: &ReadOptions) -> Result<ReadMap, Diagnostic> {
    let file = input::open(path, EXPECTED)?;
    read_map(BufReader::new(file), options).map_err(|error| {
        // A file of settings in place of a map is told by its name: maps may be large.
        let text = path
            .extension()
            .filter(|&extension| extension == "toml")
            .map(|_| read_text(&input::disk(), path, EXPECTED));
        let found = text.and_then(Result::ok).and_then(|text| FileKind::of(&text));
        match (found, error) {
            (Some(kind), _) => Diagnostic::file(path, kind.seems()).expected(EXPECTED),
            (None, ReadError::NotGiven { what, expected, option }) => {
                Diagnostic::file(path, format!("the {what} is not known"))
                    .expected(format!("{expected} ({})", how_to_give(option)))
            }
            (None, error) => Diagnostic::file(path, error.to_string()),
        }
    })
}

/// What gives an option on the command line and in a calibration file.
const fn how_to_give(option: MapOption) -> &'static str {
    match option {
        MapOption::HeightUnit => "--height-unit um; in a calibration's [surface]: height_unit = \"um\"",
        MapOption::LateralUnit => "--lateral-unit um; in a calibration's [surface]: lateral_unit = \"um\"",
        MapOption::Pixel => "--pixel-um 0.5; in a calibration's [surface]: pixel_um = 0.5",
    }
}

/// Whether a file says of its map that it is one whole period, as synthetic ones do.
fn is_period(comments: &[String]) -> bool {
    comments.iter().any(|comment| comment.contains("one period"))
}
