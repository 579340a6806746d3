//! A refused calibration, at the file, line and key that it is about.

use std::path::Path;

use slipgrid_calibrate::area_law::AreaLawError;
use slipgrid_calibrate::{CalibrationError, FitError, Measurement};

use crate::CliError;
use crate::commands::altitude_map::refuse_law;
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::surface::Surface;

/// What is wrong with the calibration at `path`.
pub fn refuse(error: &CalibrationError, path: &Path, calibration: &Calibration) -> CliError {
    let at_key = || Diagnostic { key: error.field().map(Into::into), ..Diagnostic::file(path, error.to_string()) };
    match (error, &calibration.surface) {
        (CalibrationError::Cancelled, _) => CliError::Interrupted,
        (CalibrationError::AreaLaw(AreaLawError::Windows(_)), _) => at_key().into(),
        (CalibrationError::AreaLaw(error), Surface::Map { path, .. }) => refuse_law(path, error),
        (CalibrationError::MapAfter(reason), Surface::Map { after: Some(path), .. }) => {
            Diagnostic::file(path, reason.clone()).into()
        }
        (CalibrationError::NoAreaLaw(_) | CalibrationError::OutOfRange { .. }, _) => {
            Diagnostic::file(path, error.to_string()).into()
        }
        (CalibrationError::Fit { error, measurement }, _) => refuse_fit(error, measurement.as_ref(), path, calibration),
        _ => CliError::Other(error.to_string()),
    }
}

/// A refused fit, at the measurement that it is about.
fn refuse_fit(error: &FitError, measurement: Option<&Measurement>, path: &Path, calibration: &Calibration) -> CliError {
    let change = match error {
        FitError::NoSliding { status, .. } => match *status {
            "no_onset" => {
                "friction and a load at which the modelled layer slides as a whole, or no mu_static in this row"
            }
            _ => "a load and a speed at which the modelled layer slides",
        },
        FitError::PeakTooHigh { .. } => "a smaller mu_static, or nothing in mu_static and mu_static_std",
        FitError::BeyondLaw { .. } => "another [surface], or a smaller load",
        FitError::Inertia { .. } => "a larger force_n or a smaller speed_mm_s",
        FitError::NotQuasiStatic { .. } => {
            "a larger force_n, a smaller speed_mm_s, or mu_dynamic below 1, above which the modelled layer hardly slides steadily"
        }
        FitError::TooManySteps { .. } => "a larger speed_mm_s, or a row less",
        FitError::TooManyCoefficients { .. } => "fewer conditions, or coefficients = \"single\" in [fit]",
        FitError::TooMuchWork { .. } => "fewer rows, or larger speeds",
        _ => return CliError::Other(format!("calibration: {error}")),
    };
    let text = error.to_string();
    let reason = text.split_once(": expected").map_or(text.as_str(), |(reason, _)| reason);
    let row = measurement.and_then(|measurement| calibration.place(measurement));
    let Some(row) = row else { return Diagnostic::file(path, reason).expected(change).into() };
    // The row is named by its condition instead of by its number.
    let reason = reason.split_once(": ").map_or(reason, |(_, reason)| reason);
    let reason = format!("({}): {reason}", row.condition());
    CliError::from(Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) }.expected(change))
}
