//! The call into the fit.

use std::path::Path;

use slipgrid_calibrate::{
    AreaLawScale, CalibrationError, FlatLoad, Measurement, Problem, StaticPeak, calibrate, marginal_relative_std,
    planned_steps,
};

use slipgrid_material::{MaterialError, THRESHOLD_PRESSURE_PA};

use super::details::FitDetails;
use super::{CalibrationInput, Fit, FittedPair};
use crate::CliError;
use crate::commands::area_curve::persson_curve;
use crate::progress::Progress;
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibration::{Calibration, Coefficients};
use slipgrid_formats::material::DEFAULT_STATIC_OVER_DYNAMIC;

/// What is fitted to the measurements of `input`.
///
/// # Errors
/// [`CliError::Other`] if the law that is to be fitted has no curve.
pub fn problem(input: &CalibrationInput) -> Result<Problem, CliError> {
    let measurements = input
        .measurements
        .iter()
        .map(|measured| Measurement {
            // P = F / A
            pressure_pa: measured.force_n / input.specimen_area_m2,
            speed_m_s: measured.speed_m_s,
            mu_dynamic: measured.mu_dynamic,
            mu_dynamic_std: measured.mu_dynamic_std,
            static_peak: measured.mu_static.zip(measured.mu_static_std).map(|(mu, std)| StaticPeak { mu, std }),
        })
        .collect();
    Ok(Problem {
        elastic: input.elastic,
        area_law: input.area_law.clone(),
        area_law_scale: input.area_law_scale_pa.map(persson_scale).transpose()?,
        layer: input.layer,
        measurements,
        coefficients: match input.coefficients {
            Coefficients::Single => slipgrid_calibrate::Coefficients::Single,
            Coefficients::PerCondition => slipgrid_calibrate::Coefficients::PerCondition,
        },
        relative_std: input.relative_std,
        static_over_dynamic: DEFAULT_STATIC_OVER_DYNAMIC,
        seed: input.seed,
    })
}

/// Time steps of a lattice of 20,000 blocks in a second on one core, about.
const STEPS_PER_S: f64 = 1e4;
/// A fit that is estimated to take longer says so before it begins, in minutes.
const LONG_MIN: f64 = 0.5;

/// Says how long the fit will take, where that is long.
pub fn estimate(problem: &Problem) -> Option<String> {
    let steps: u64 = planned_steps(problem).ok()?.iter().fold(0, |sum, steps| sum.saturating_add(*steps));
    let blocks = problem.layer.columns() as f64 * problem.layer.rows() as f64;
    // Two rounds, each of two runs where peaks are fitted.
    let runs = if problem.measurements.iter().any(|measured| measured.static_peak.is_some()) { 4.0 } else { 2.0 };
    // Each run has one thread.
    let threads = rayon::current_num_threads().min(problem.measurements.len()) as f64;
    let minutes = runs * steps as f64 * (blocks / 2e4) / (STEPS_PER_S * threads) / 60.0;
    (minutes > LONG_MIN).then(|| {
        format!("the runs of the flat sample take {steps} time steps a round, roughly {minutes:.1} minutes in all; slow sliding and heavy loads take the most")
    })
}

/// A refused fit, at the measurement that it is about.
pub fn refuse(error: &CalibrationError, path: &Path, calibration: &Calibration) -> CliError {
    let change = match error {
        CalibrationError::Cancelled => return CliError::Other("stopped".to_owned()),
        CalibrationError::NoSliding { status, .. } => match *status {
            "no_onset" => {
                "friction and a load at which the modelled layer slides as a whole, or no mu_static in this row"
            }
            _ => "a load and a speed at which the modelled layer slides",
        },
        CalibrationError::PeakTooHigh { .. } => "a smaller mu_static, or nothing in mu_static and mu_static_std",
        CalibrationError::BeyondLaw { .. } => "another [surface], or a smaller load",
        CalibrationError::Inertia { .. } => "a larger force_n or a smaller speed_mm_s",
        CalibrationError::NotQuasiStatic { .. } => {
            "a larger force_n, a smaller speed_mm_s, or mu_dynamic below 1, above which the modelled layer hardly slides steadily"
        }
        CalibrationError::TooManySteps { .. } => "a larger speed_mm_s, or a row less",
        CalibrationError::TooManyCoefficients { .. } => "fewer conditions, or coefficients = \"single\" in [fit]",
        CalibrationError::TooMuchWork { .. } => "fewer rows, or larger speeds",
        _ => return CliError::Other(format!("calibration: {error}")),
    };
    let text = error.to_string();
    let reason = text.split_once(": expected").map_or(text.as_str(), |(reason, _)| reason);
    let row = error.measurement().and_then(|number| calibration.place(calibration.flat.get(number - 1)?));
    let Some(row) = row else { return Diagnostic::file(path, reason).expected(change).into() };
    // The row is named by its condition instead of by its number.
    let reason = reason.split_once(": ").map_or(reason, |(_, reason)| reason);
    let reason = format!("({}): {reason}", row.condition());
    CliError::from(Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) }.expected(change))
}

/// Fits local coefficients to the measurements of `problem`.
///
/// # Errors
/// [`CalibrationError`] if nothing can be fitted.
pub fn fit(problem: &Problem, progress: &Progress) -> Result<Fit, CalibrationError> {
    let fitted = calibrate(problem, progress)?;
    Ok(Fit {
        pairs: fitted
            .pairs
            .iter()
            .map(|pair| FittedPair {
                static_mean: pair.static_mean,
                static_std_error: pair.static_std_error.filter(|error| error.is_finite()),
                dynamic_mean: pair.dynamic_mean,
                dynamic_std_error: Some(pair.dynamic_std_error).filter(|error| error.is_finite()),
                dynamic_std_error_given_law: None,
            })
            .collect(),
        residuals: fitted.predictions.iter().map(|prediction| prediction.residual).collect(),
        dynamic_over_steady: dynamic_over_steady(&fitted, problem),
        details: FitDetails::new(&fitted, problem.area_law_scale.as_ref()),
        notes: fitted.notes,
    })
}

/// Dynamic friction of the flat sample over mu_d f(P), that of an endless one in steady sliding, one per measurement.
fn dynamic_over_steady(fitted: &slipgrid_calibrate::Fit, problem: &Problem) -> Vec<f64> {
    let at = |(place, measured): (usize, &Measurement)| {
        let pair = fitted.pairs.get(place).or(fitted.pairs.first())?;
        let factor = fitted.area_law.as_ref().map_or(1.0, |law| law.factor(measured.pressure_pa));
        Some(fitted.predictions.get(place)?.mu_dynamic / (pair.dynamic_mean * factor))
    };
    problem.measurements.iter().enumerate().filter_map(at).collect()
}

/// Adds to the errors of `fit`, which take the area law for known, what Young's modulus and the law's own errors leave open.
/// A law whose scale was fitted is in them already.
///
/// # Errors
/// [`MaterialError`] where the law cannot be moved.
pub fn marginal(fit: &mut Fit, calibration: &Calibration, input: &CalibrationInput) -> Result<(), MaterialError> {
    let moves = |_: &f64| calibration.measured_law.is_none();
    let log_modulus_std = calibration.modulus_relative_std().filter(moves).unwrap_or(0.0);
    let Some(law) = input.area_law.as_ref().filter(|_| input.area_law_scale_pa.is_none()) else { return Ok(()) };
    if log_modulus_std == 0.0 && law.factor_std().is_none() {
        return Ok(());
    }
    let loads: Vec<FlatLoad> = input
        .measurements
        .iter()
        .map(|measured| {
            let pressure_pa = measured.force_n / input.specimen_area_m2;
            // Of sum [(mu_d f_i - mu_i) / s_i]^2.
            FlatLoad { pressure_pa, weight: (law.factor(pressure_pa) / measured.mu_dynamic_std).powi(2) }
        })
        .collect();
    let single = fit.pairs.len() == 1;
    for (place, pair) in fit.pairs.iter_mut().enumerate() {
        let Some(error) = pair.dynamic_std_error else { continue };
        let own = if single { &loads[..] } else { &loads[place..=place] };
        let relative = marginal_relative_std(error / pair.dynamic_mean, law, log_modulus_std, own)?;
        pair.dynamic_std_error_given_law = Some(error);
        pair.dynamic_std_error = Some(relative * pair.dynamic_mean);
    }
    fit.notes.push(
        "dynamic_std_error: with what Young's modulus and the area law leave open of the local coefficient; \
         dynamic_std_error_given_law: at the given law, as flat friction is known, which errors of friction and of ratios are made of"
            .to_owned(),
    );
    Ok(())
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
