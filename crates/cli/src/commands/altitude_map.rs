//! From the file of an altitude map to a map ready for computation.

use std::io::BufReader;
use std::path::Path;

use slipgrid_contact::{periodic_component, side_step_ratio};
use slipgrid_topography::{Form, HeightMap, MapFormat, MapOption, ReadError, ReadMap, ReadOptions, read_map};

use crate::diagnostic::Diagnostic;
use crate::formats::file_kind::FileKind;
use crate::formats::surface::{MapOptions, Missing};
use crate::input;

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
}

impl SurfaceMap {
    /// Reads the map at `path` as one period, for a contact computation: a map whose opposite sides do not continue
    /// each other is replaced by its periodic component.
    ///
    /// # Errors
    /// [`Diagnostic`] if the file cannot be read or is no map.
    pub fn read_period(path: &Path, options: &MapOptions) -> Result<Self, Diagnostic> {
        Self::build(path, open(path, &options.read)?, options, true)
    }

    /// Fills what is missing in the map that was `read` and removes its form.
    ///
    /// # Errors
    /// [`Diagnostic`] if points are missing that must not, or do not determine the form.
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
        let filled = match map.missing() {
            0 => Vec::new(),
            _ => map.heights_m().iter().map(|height| height.is_nan()).collect(),
        };
        let filling = map.fill_missing();
        if filling.points > 0 {
            let points = map.rows() * map.cols();
            notes.push(format!(
                "{} of {points} points ({:.1} %) were missing and have been filled by the smoothest surface",
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
        Ok(Self { sa_m: map.sa_m(), rms_slope, format: read.format, map, synthetic, period, filled, notes })
    }

    /// Pixel size along the sliding direction, in metres.
    #[must_use]
    pub const fn pixel_m(&self) -> f64 {
        self.map.dx_m()
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
        let text = path.extension().filter(|&extension| extension == "toml").map(|_| input::read_text(path, EXPECTED));
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
