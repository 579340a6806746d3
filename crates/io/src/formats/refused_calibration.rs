//! Converts calibration errors to diagnostics at file, line and key.

use std::path::Path;

use slipgrid_infer::calibrate::area_law::AreaLawError;
use slipgrid_infer::calibrate::{CalibrationError, FitError, Measurement};

use crate::formats::Diagnostic;
use crate::formats::altitude_map::refuse_law;
use crate::formats::calibration::Calibration;
use crate::formats::plausible::MODULUS;
use crate::formats::surface::Surface;
use slipgrid_base::units::{MODULUS_GPA, SPEED_MM_S, significant_to, tidy};

/// Diagnostic for an error in the calibration at `path`; `None` if the input did not cause the error.
pub fn refuse(error: &CalibrationError, path: &Path, calibration: &Calibration) -> Option<Diagnostic> {
    let at_key = || Diagnostic { key: error.field().map(Into::into), ..Diagnostic::file(path, error.to_string()) };
    match (error, &calibration.surface) {
        (CalibrationError::Cancelled, _) => None,
        (CalibrationError::AreaLaw(AreaLawError::Windows(_)), _) => Some(at_key()),
        (CalibrationError::AreaLaw(error), Surface::Map { path, .. }) => refuse_law(path, error),
        (CalibrationError::MapAfter(reason), Surface::Map { after: Some(path), .. }) => {
            Some(Diagnostic::file(path, reason.clone()))
        }
        (
            CalibrationError::NoAreaLaw(_)
            | CalibrationError::OutOfRange { .. }
            | CalibrationError::Scene(_)
            | CalibrationError::Specimen(_),
            _,
        ) => Some(Diagnostic::file(path, error.to_string())),
        (CalibrationError::Fit { error, measurement }, _) => refuse_fit(error, measurement.as_ref(), path, calibration),
        _ => None,
    }
}

/// Diagnostic for an error of the fit, at the measurement concerned; `None` if the input did not cause the error.
fn refuse_fit(
    error: &FitError,
    measurement: Option<&Measurement>,
    path: &Path,
    calibration: &Calibration,
) -> Option<Diagnostic> {
    let (speed, change);
    let expected = match error {
        FitError::NoSliding { status: "no_onset", .. } => {
            "friction and a load at which the modelled layer slides as a whole, or no mu_static in this row"
        }
        FitError::NoSliding { .. } => {
            "a load and a speed at which the modelled layer slides evenly: a lower speed or a higher load, where it slides in waves (sliding_waves)"
        }
        FitError::PeakTooHigh { .. } => "a smaller mu_static, or nothing in mu_static and mu_static_std",
        FitError::BeyondLaw { .. } => "another [surface], or a smaller load",
        FitError::TooFast { most_m_s, modulus_pa, most_modulus_pa, .. } => {
            let most_mm_s = significant_to(SPEED_MM_S.from_si(*most_m_s), 2, f64::floor);
            let [modulus_gpa, most_gpa] = [*modulus_pa, *most_modulus_pa].map(|pa| tidy(MODULUS_GPA.from_si(pa)));
            let slip = MODULUS.within([0.0, most_gpa]).slip(modulus_gpa);
            let slip = slip.map_or_else(String::new, |slip| format!(" ({slip})"));
            let most_gpa = significant_to(most_gpa, 2, f64::floor);
            // The highest speed is proportional to the pressure.
            let force = measurement.map_or_else(String::new, |row| {
                let least_n = significant_to(row.force_n * row.speed_m_s / most_m_s, 2, f64::ceil);
                format!("force_n of at least {least_n}, ")
            });
            change =
                format!("{force}speed_mm_s of at most {most_mm_s}, or youngs_modulus_gpa of at most {most_gpa}{slip}");
            &change
        }
        FitError::NotQuasiStatic { .. } => {
            "a larger force_n, a smaller speed_mm_s, or mu_dynamic below 1, above which the modelled layer hardly slides steadily; is its \
             unit right, that of a friction force in traces among them?"
        }
        FitError::TooManySteps { least_m_s, .. } => {
            let least_mm_s = significant_to(SPEED_MM_S.from_si(*least_m_s), 2, f64::ceil);
            speed = format!("speed_mm_s of at least {least_mm_s}, or this row left out");
            &speed
        }
        FitError::TooManyCoefficients { .. } => "fewer conditions, or coefficients = \"single\" in [fit]",
        FitError::TooMuchWork { .. } => "fewer rows, or larger speeds",
        _ => return None,
    };
    let text = error.to_string();
    let reason = text.split_once(": expected").map_or(text.as_str(), |(reason, _)| reason);
    let row = measurement.and_then(|measurement| calibration.place(measurement));
    let Some(row) = row else { return Some(Diagnostic::file(path, reason).expected(expected)) };
    // The condition replaces the row number in the message.
    let reason = reason.split_once(": ").map_or(reason, |(_, reason)| reason);
    let measured = match error {
        FitError::NotQuasiStatic { .. } | FitError::NoSliding { .. } => {
            format!(", mu_dynamic {}", tidy(row.measurement.mu_dynamic))
        }
        _ => String::new(),
    };
    let reason = format!("({}{measured}): {reason}", row.condition());
    Some(Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) }.expected(expected))
}
