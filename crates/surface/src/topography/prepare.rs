//! Prepares a map as read for computation: fills missing points, removes spikes and form.

use serde::Deserialize;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::significant;

use crate::topography::{
    Decimation, Form, HeightMap, MapError, MapFormat, MapWarning, ReadError, ReadMap, Sides, limits,
    periodic_component, side_step_ratio,
};

/// Largest ratio of the rms step across opposite sides to the rms step between neighbours at which a map is taken as
/// one period. A period has about 1, a piece of a smooth surface many times that.
const PERIOD_STEP_RATIO: f64 = 1.5;

/// Treatment of missing points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// Missing points are filled by the smoothest surface.
    #[default]
    Fill,
    /// A map with missing points is refused.
    Refuse,
}

slipgrid_base::names!(Missing { Fill = "fill", Refuse = "refuse" });

/// Options for preparing a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Preparation {
    /// Form subtracted from the heights.
    pub form: Form,
    /// Treatment of missing points.
    pub missing: Missing,
    /// Whether spikes are replaced by the median of the surrounding points.
    pub despike: bool,
}

/// Reason why a map cannot be prepared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PreparationError {
    /// An operation on the map was refused.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Nearly all points are missing.
    #[error("{missing} of {points} points are missing: what would fill them is no measurement")]
    MostlyMissing {
        /// Number of missing points.
        missing: usize,
        /// Points of the map.
        points: usize,
    },
    /// The slope is impossible for a surface; see [`limits::POSSIBLE_SLOPE`].
    #[error("the rms slope is {}, which no measured surface has", significant(*rms_slope, 3))]
    ImpossibleSlope {
        /// Rms slope.
        rms_slope: f64,
        /// Other warnings about the map.
        warnings: Vec<MapWarning>,
    },
}

/// A height map ready for computation: missing points are filled and the form is subtracted.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedMap {
    /// The complete map.
    pub map: HeightMap,
    /// Whether the file states that the map is synthetic.
    pub synthetic: bool,
    /// Whether the map is one whole period, as stated in the file or found from the heights.
    pub period: bool,
    /// Whether the map was replaced by its periodic component, because opposite sides did not continue each other.
    pub is_component: bool,
    /// The file's format.
    pub format: MapFormat,
    /// Form that was subtracted; only the mean for a period, because a plane would leave a step where the period
    /// closes.
    pub form: Form,
    /// Whether each point was missing in the file, row by row; empty if no point was missing.
    pub filled: Vec<bool>,
    /// Arithmetic mean height Sa, in metres.
    pub sa_m: f64,
    /// Spectral rms slope; if opposite sides of the map do not continue each other, that of its periodic component.
    pub rms_slope: f64,
    /// Preparation steps, one sentence each.
    pub notes: Vec<String>,
    /// Warnings that make numbers computed from the map doubtful.
    pub warnings: Vec<MapWarning>,
}

impl PreparedMap {
    /// Prepares a map as one period for a contact computation. If opposite sides do not continue each other, the map is
    /// replaced by its periodic component.
    ///
    /// # Errors
    /// The errors of [`PreparedMap::new`], and [`PreparationError::ImpossibleSlope`].
    pub fn one_period(read: ReadMap, how: Preparation, monitor: &dyn Monitor) -> Result<Self, PreparationError> {
        let surface = Self::build(read, how, true, monitor)?.possible()?;
        let is_flat = surface.rms_slope < limits::POSSIBLE_SLOPE[0];
        if is_flat { Err(surface.impossible()) } else { Ok(surface) }
    }

    /// Returns the map unless it is steeper than any surface, which means that heights or pixels are in a wrong unit.
    ///
    /// # Errors
    /// [`PreparationError::ImpossibleSlope`].
    pub fn possible(self) -> Result<Self, PreparationError> {
        if self.rms_slope <= limits::POSSIBLE_SLOPE[1] { Ok(self) } else { Err(self.impossible()) }
    }

    fn impossible(self) -> PreparationError {
        PreparationError::ImpossibleSlope { rms_slope: self.rms_slope, warnings: self.warnings }
    }

    /// Prepares a map as read: removes spikes if requested, fills missing points and removes the form.
    ///
    /// # Errors
    /// [`PreparationError`] if points are missing although this is not allowed, if nearly all are missing, if the
    /// points present do not determine the form, and once `monitor` has cancelled.
    pub fn new(read: ReadMap, how: Preparation, monitor: &dyn Monitor) -> Result<Self, PreparationError> {
        Self::build(read, how, false, monitor)
    }

    fn build(
        read: ReadMap,
        how: Preparation,
        one_period: bool,
        monitor: &dyn Monitor,
    ) -> Result<Self, PreparationError> {
        let heed = || monitor.heed().map_err(MapError::from);
        heed()?;
        let synthetic = read.is_synthetic();
        // A cropped part of a period is not a period.
        let mut period = read.whole && is_period(&read.comments);
        let mut map = read.map;
        let mut notes = read.notes;
        if how.missing == Missing::Refuse {
            map.require_complete()?;
        }
        let (missing, points) = (map.missing(), map.rows() * map.cols());
        if missing as f64 > limits::MAX_MISSING_SHARE * points as f64 {
            return Err(PreparationError::MostlyMissing { missing, points });
        }
        let zeros = map.zeros_warning();
        if how.despike {
            notes.push(despiked(&mut map, monitor)?);
        }
        let spiked = map.spike_warning(monitor).map_err(MapError::from)?;
        let spike_points = spiked.as_ref().map_or(0, |found| found.spikes.points());
        let mut warnings = Vec::new();
        match spiked {
            Some(found) if found.matter => warnings.push(found.warning),
            Some(found) => notes.push(format!(
                "{}; they change neither the rms slope by {:.0} % nor the highest point by {:.0} %, and do not matter",
                found.spikes,
                100.0 * limits::SPIKE_SLOPE,
                100.0 * limits::SPIKE_PEAK
            )),
            None => {}
        }
        warnings.extend(map.missing_warning());
        warnings.extend(map.pixel_warning().into_iter().chain(zeros));
        let filled = match map.missing() {
            0 => Vec::new(),
            _ => map.heights_m().iter().map(|height| height.is_nan()).collect(),
        };
        heed()?;
        let filling = map.fill_missing(monitor);
        heed()?;
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
        period |= one_period && side_step_ratio(&map, monitor)? <= PERIOD_STEP_RATIO;
        let is_kept = !period && how.form != Form::SecondOrder;
        let curved = if is_kept { map.form_warning(monitor).map_err(MapError::from)? } else { None };
        // Subtracting a plane through one period would leave a step where the period closes.
        let form = if period { Form::Mean } else { how.form };
        map.remove_form(form, monitor)?;
        let subtracted = match form {
            Form::Plane => "the least-squares plane has been subtracted",
            Form::SecondOrder => "the least-squares surface of second order has been subtracted",
            Form::Mean => "no plane has been subtracted",
        };
        notes.push(subtracted.to_owned());
        heed()?;
        // Steps across the sides caused by a tilt or a bow are removed with the form.
        let step_ratio = side_step_ratio(&map, monitor)?;
        period |= one_period && step_ratio <= PERIOD_STEP_RATIO;
        let is_component = one_period && !period && how.form != Form::Mean;
        if is_component {
            map = periodic_component(&map, monitor)?;
            notes.push(format!(
                "opposite sides do not continue each other (steps {step_ratio:.1} times those between neighbours): the \
                 map is taken as its periodic component (Moisan)"
            ));
        } else if one_period {
            notes.push("the map is taken as one period as it is".to_owned());
        }
        heed()?;
        // The spectrum of a map that is not a period would count the step between opposite sides as slope.
        let closes = period || one_period || step_ratio <= PERIOD_STEP_RATIO;
        let rms_slope = if closes {
            map.rms_slope_spectral(monitor)?
        } else {
            periodic_component(&map, monitor)?.rms_slope_spectral(monitor)?
        };
        let hole = map.hole_warning();
        // A hole also bends the second-order form, so that only the hole is reported.
        warnings.extend(curved.filter(|_| hole.is_none()));
        warnings.extend(hole);
        heed()?;
        warnings.extend(map.height_warnings(rms_slope, spike_points));
        heed()?;
        let (sa_m, format) = (map.sa_m(), read.format);
        Ok(Self { sa_m, rms_slope, is_component, format, map, synthetic, period, form, filled, notes, warnings })
    }

    /// How the map continues past its sides.
    pub const fn sides(&self) -> Sides {
        if self.period { Sides::Periodic } else { Sides::Open }
    }

    /// Pixel size along the sliding direction, in metres.
    pub const fn pixel_m(&self) -> f64 {
        self.map.dx_m()
    }
}

impl ReadMap {
    /// Removes spikes and adds a note about them.
    ///
    /// # Errors
    /// [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn despiked(mut self, monitor: &dyn Monitor) -> Result<Self, MapError> {
        self.notes.push(despiked(&mut self.map, monitor)?);
        Ok(self)
    }

    /// Decimates the map, with the same result as decimation by the reader.
    ///
    /// # Errors
    /// [`ReadError`] if no points are left.
    pub fn decimated(mut self, decimation: Decimation) -> Result<Self, ReadError> {
        let is_whole = |points: usize| points.is_multiple_of(decimation.factor.max(1));
        self.whole &= is_whole(self.map.rows()) && is_whole(self.map.cols());
        self.map = self.map.windowed(None, Some(decimation))?;
        Ok(self)
    }
}

/// Removes spikes; returns the note about them.
fn despiked(map: &mut HeightMap, monitor: &dyn Monitor) -> Result<String, MapError> {
    let spikes = map.despike(monitor)?;
    Ok(match spikes.points() {
        0 => "despiked: no spikes were found".to_owned(),
        _ => format!("despiked: {spikes}; the median of the points about them takes their place"),
    })
}

/// Whether a file's comments state that the map is one whole period, as those of synthetic maps do.
fn is_period(comments: &[String]) -> bool {
    comments.iter().any(|comment| comment.contains("one period"))
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::*;
    use crate::topography::{Crop, DecimationMethod, MapDoubt, SelfAffine};

    /// Prepares a map, tilted by `tilt_m` from its first to its last line, as one period.
    fn prepared_with_tilt(map: &HeightMap, tilt_m: f64) -> PreparedMap {
        let (rows, cols) = (map.rows() as f64, map.cols());
        let tilted = map.changed(|n, height_m| height_m + tilt_m * (n / cols) as f64 / rows);
        PreparedMap::one_period(read(tilted), Preparation::default(), &Unwatched).unwrap()
    }

    fn read(map: HeightMap) -> ReadMap {
        ReadMap { map, whole: true, format: MapFormat::Matrix, comments: Vec::new(), notes: Vec::new() }
    }

    #[test]
    fn spikes_are_removed_before_points_are_joined() {
        let clean = SelfAffine { pixels: 64, max_wave: 16, ..SelfAffine::STAND_IN }.map().unwrap();
        let read =
            |spike_m: f64| read(clean.changed(|n, height_m| height_m + if n == 20 * 64 + 31 { spike_m } else { 0.0 }));
        let of_two = |method| Decimation { factor: 2, method };
        let slope = |read: &ReadMap| read.map.rms_slope_spectral(&Unwatched).unwrap();
        for method in [DecimationMethod::Mean, DecimationMethod::Pick] {
            let own = read(0.0).decimated(of_two(method)).unwrap();
            let despiked = read(2e-6).despiked(&Unwatched).unwrap();
            assert!(despiked.notes[0].starts_with("despiked: 1 point"), "{:?}", despiked.notes);
            let despiked = despiked.decimated(of_two(method)).unwrap();
            assert_eq!([despiked.map.rows(), despiked.map.cols(), usize::from(despiked.whole)], [32, 32, 1]);
            assert!((slope(&despiked) / slope(&own) - 1.0).abs() < 0.02, "{} {}", slope(&despiked), slope(&own));
        }
        let spoilt = read(20e-6).decimated(of_two(DecimationMethod::Mean)).unwrap();
        let own = read(0.0).decimated(of_two(DecimationMethod::Mean)).unwrap();
        assert!(slope(&spoilt) > 1.2 * slope(&own), "{} {}", slope(&spoilt), slope(&own));
        assert!(!read(0.0).decimated(Decimation { factor: 5, method: DecimationMethod::Mean }).unwrap().whole);
    }

    #[test]
    fn a_curved_specimen_is_told_until_its_form_is_removed() {
        let rough = SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
        let curved = |bow_m: f64, form: Form| {
            let u = |n: usize| 2.0 * n as f64 / 63.0 - 1.0;
            let read = read(rough.changed(|n, height_m| height_m + bow_m * u(n / 64).powi(2)));
            let found = PreparedMap::new(read, Preparation { form, ..Preparation::default() }, &Unwatched).unwrap();
            found.warnings.into_iter().find(|warning| warning.doubt == MapDoubt::Curved)
        };
        let bow_m = 20.0 * rough.sa_m();
        for form in [Form::Plane, Form::Mean] {
            assert!(curved(bow_m, form).is_some(), "{form:?}");
            assert_eq!(curved(0.0, form), None);
            assert_eq!(curved(0.5 * rough.sa_m(), form), None);
        }
        assert_eq!(curved(bow_m, Form::SecondOrder), None);
    }

    #[test]
    fn a_tilt_alone_is_no_step_between_opposite_sides() {
        let level = SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
        let steps = |prepared: &PreparedMap| {
            prepared.notes.iter().find(|note| note.contains("do not continue each other")).cloned()
        };
        for tilt_m in [0.0, 2e-5, -1e-3] {
            let prepared = prepared_with_tilt(&level, tilt_m);
            assert_eq!(steps(&prepared), None, "{tilt_m} m: {:?}", prepared.notes);
            assert!(prepared.period);
            assert_eq!(prepared.notes[0] == "the least-squares plane has been subtracted", tilt_m != 0.0);
            // The plane of the period itself is removed together with the tilt.
            let slope = prepared.rms_slope / prepared_with_tilt(&level, 0.0).rms_slope;
            assert!((slope - 1.0).abs() < 0.02, "{tilt_m} m: {slope}");
        }
        // A piece of the map is not a period: its steps are reported with or without tilt, and are the same.
        let piece = level.windowed(Some(Crop { first_row: 0, first_col: 0, rows: 40, cols: 48 }), None).unwrap();
        let said = steps(&prepared_with_tilt(&piece, 0.0)).unwrap();
        assert_eq!(steps(&prepared_with_tilt(&piece, 3e-5)).unwrap(), said);
    }
}
