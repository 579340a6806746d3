//! The call into the fit.

use slipgrid_calibrate::{AreaLawScale, CalibrationError, Measurement, Problem, StaticPeak, calibrate};

use slipgrid_material::THRESHOLD_PRESSURE_PA;

use super::details::FitDetails;
use super::{CalibrationInput, Fit, FittedPair};
use crate::CliError;
use crate::commands::area_curve::persson_curve;
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
    let scale = input.area_law_scale_pa.map(persson_scale).transpose()?;
    let problem = Problem {
        elastic: input.elastic,
        area_law: input.area_law.clone(),
        area_law_scale: scale.clone(),
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
        details: FitDetails::new(&fitted, scale.as_ref()),
        notes: fitted.notes,
    })
}

/// Tabulated pressures of a law that is fitted: dense, so that it bends smoothly.
const SCALED_POINTS: usize = 241;

/// Persson's contact area against P / (E* h'rms), from far below the threshold at any scale to full contact.
fn persson_scale(bounds_pa: [f64; 2]) -> Result<AreaLawScale, CliError> {
    let [from, to] = [
        1e-4_f64.min(0.1 * THRESHOLD_PRESSURE_PA / bounds_pa[1]),
        10.0_f64.max(2.0 * THRESHOLD_PRESSURE_PA / bounds_pa[0]),
    ];
    let pressure_over_scale: Vec<f64> =
        (0..SCALED_POINTS).map(|i| from * (to / from).powf(i as f64 / (SCALED_POINTS - 1) as f64)).collect();
    let curve = persson_curve(1.0, 1.0, &pressure_over_scale).map_err(|error| CliError::Other(error.to_string()))?;
    Ok(AreaLawScale {
        area_fraction: curve.iter().map(|point| point.area_fraction).collect(),
        pressure_over_scale,
        bounds_pa,
    })
}
