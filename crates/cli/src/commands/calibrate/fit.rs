//! The call into the fit.

use slipgrid_calibrate::{CalibrationError, Measurement, Problem, StaticPeak, calibrate};

use super::{CalibrationInput, Fit, FittedPair};
use crate::CliError;
use crate::formats::calibration::Coefficients;
use crate::formats::material::DEFAULT_STATIC_OVER_DYNAMIC;
use crate::progress::Progress;

/// Fits local coefficients to the measurements of `input`.
///
/// # Errors
/// [`CliError::Other`] if nothing can be fitted.
pub fn fit(input: &CalibrationInput, progress: &Progress) -> Result<Fit, CliError> {
    let area_m2 = std::f64::consts::PI * input.specimen_radius_m * input.specimen_radius_m;
    let measurements = input
        .measurements
        .iter()
        .map(|measured| Measurement {
            // P = F / (pi r^2)
            pressure_pa: measured.force_n / area_m2,
            speed_m_s: measured.speed_m_s,
            mu_dynamic: measured.mu_dynamic,
            mu_dynamic_std: measured.mu_dynamic_std,
            static_peak: measured.mu_static.zip(measured.mu_static_std).map(|(mu, std)| StaticPeak { mu, std }),
        })
        .collect();
    let problem = Problem {
        elastic: input.elastic,
        area_law: input.area_law.clone(),
        area_law_scale: None,
        layer: input.layer,
        measurements,
        coefficients: match input.coefficients {
            Coefficients::Single => slipgrid_calibrate::Coefficients::Single,
            Coefficients::PerCondition => slipgrid_calibrate::Coefficients::PerCondition,
        },
        relative_std: input.relative_std,
        static_over_dynamic: DEFAULT_STATIC_OVER_DYNAMIC,
        seed: input.seed,
    };
    let fitted = calibrate(&problem, progress).map_err(|error| match error {
        CalibrationError::Cancelled => CliError::Other("stopped".to_owned()),
        error => CliError::Other(format!("calibration: {error}")),
    })?;
    Ok(Fit {
        pairs: fitted
            .pairs
            .iter()
            .map(|pair| FittedPair {
                static_mean: pair.static_mean,
                static_std_error: pair.static_std_error,
                dynamic_mean: pair.dynamic_mean,
                dynamic_std_error: Some(pair.dynamic_std_error),
            })
            .collect(),
        residuals: fitted.predictions.iter().map(|prediction| prediction.residual).collect(),
        notes: fitted.notes,
    })
}
