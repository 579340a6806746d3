//! Full record of a fit: parameters, covariance, profiles and residuals.

use schemars::JsonSchema;
use serde::Serialize;
use slipgrid_infer::calibrate::{CalibrationOutcome, CalibrationTask, Fit, Parameter, split_parameter_name};

use super::static_friction::{StaticRow, rows};
use crate::ReportError;
use crate::charts::{self, Estimate};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::{SCHEMA, Table, VERSION, fixed};

/// Record of a fit, as in fit.json.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct FitReport {
    /// Program name: `slipgrid`.
    pub program: &'static str,
    /// Program version.
    pub version: &'static str,
    /// Schema version of the record.
    pub schema: u32,
    /// Fitted parameters.
    pub parameters: Vec<Parameter>,
    /// Covariance of the parameters; null where the data do not determine it.
    pub covariance: Vec<Vec<Option<f64>>>,
    /// Sum of squared residuals, each divided by the standard deviation of the measured value.
    pub chi_square: f64,
    /// Number of measurements minus number of parameters.
    pub degrees_of_freedom: usize,
    /// The fit converged within its maximum number of rounds.
    pub settled: bool,
    /// Warnings about fitted values.
    pub warnings: Vec<String>,
    /// Measured and modelled static peaks.
    pub static_friction: Vec<StaticRow>,
}

/// Parameters of `fit`, rounded so that rounding errors of the last digits do not show.
fn parameters(fit: &Fit) -> Vec<Parameter> {
    let rounded = |parameter: &Parameter| Parameter {
        value: tidy(parameter.value),
        std_error: tidy(parameter.std_error),
        bounds: parameter.bounds.map(tidy),
        interval: parameter.interval.map(|end| end.map(tidy)),
        profile: parameter.profile.iter().map(|point| point.map(tidy)).collect(),
        ..parameter.clone()
    };
    fit.parameters.iter().map(rounded).collect()
}

fn finite(value: f64) -> Option<f64> {
    Some(tidy(value)).filter(|value| value.is_finite())
}

/// Serializes the fit as in fit.json.
///
/// # Errors
/// [`ReportError`] if the fit has no JSON form.
pub fn fit_json(task: &CalibrationTask, outcome: &CalibrationOutcome) -> Result<String, ReportError> {
    let fit = &outcome.fit;
    let details = FitReport {
        program: "slipgrid",
        version: VERSION,
        schema: SCHEMA,
        parameters: parameters(fit),
        covariance: fit.covariance.iter().map(|row| row.iter().map(|&value| finite(value)).collect()).collect(),
        chi_square: tidy(fit.chi_square),
        degrees_of_freedom: fit.degrees_of_freedom,
        settled: fit.settled,
        warnings: outcome.material.provenance.warnings.clone(),
        static_friction: rows(task, outcome),
    };
    Ok(slipgrid_design::results::json(&details)?)
}

/// Describes a fitted parameter together with its measurement, for example `dynamic_mean 200 N, 2 mm/s, 50 %` for
/// `dynamic_mean 4`.
pub fn in_words(outcome: &CalibrationOutcome, name: &str) -> String {
    let placed = split_parameter_name(name, &outcome.measurements);
    placed.map_or_else(|| name.to_owned(), |(what, at)| format!("{what} {}", at.condition_in_words()))
}

/// Explains which error sources the standard errors of the parameters include, and how these errors differ from those
/// in the table of coefficients.
pub fn which_errors(outcome: &CalibrationOutcome) -> &'static str {
    if outcome.fit.pairs.iter().any(|pair| pair.dynamic_std_error_given_law.is_some()) {
        "at the given area law and modulus, as flat friction is known; the errors of mu_d in the table above have those of the law and of \
         Young's modulus in them"
    } else {
        "at the given area law and modulus"
    }
}

/// Table of all fitted parameters with standard errors and 95 % intervals; pressures in MPa.
pub fn parameter_table(outcome: &CalibrationOutcome) -> Table {
    let parameters = parameters(&outcome.fit);
    let cell = |of: &Parameter, value: Option<f64>| match of.name.ends_with("_pa") {
        true => fixed(value.map(|pa| PRESSURE_MPA.from_si(pa)), 3),
        false => fixed(value, 4),
    };
    let mut table = Table::of(&parameters);
    table.column("parameter", |of| match of.name.strip_suffix("_pa") {
        Some(name) => format!("{name}, MPa"),
        None => in_words(outcome, &of.name),
    });
    table.column("value", |of| cell(of, Some(of.value)));
    table.column("+-", |of| cell(of, Some(of.std_error)));
    table.column("95 % from", |of| cell(of, of.interval[0]));
    table.column("to", |of| cell(of, of.interval[1]));
    table.table()
}

/// Formats the likelihood profiles of all parameters as CSV, one row per point of a profile.
pub fn profiles(fit: &Fit) -> String {
    let mut text = String::from("parameter,value,chi_square_increase\n");
    for parameter in &parameters(fit) {
        for [value, increase] in &parameter.profile {
            text += &format!("{},{value},{increase}\n", parameter.name);
        }
    }
    text
}

/// Draws the residuals of all measurements, with the measured standard deviations as error bars.
pub fn residuals(name: &str, outcome: &CalibrationOutcome) -> Result<String, ReportError> {
    let of = outcome.measurements.iter().zip(&outcome.fit.predictions);
    let residuals: Vec<(String, Estimate)> = of
        .map(|(m, predicted)| {
            let (speed, humidity) = (SPEED_MM_S.from_si(m.speed_m_s), HUMIDITY_PCT.from_si(m.humidity));
            let label = format!("{} N {speed} mm/s {humidity} %", m.force_n);
            (label, Estimate { value: predicted.residual, error: Some(m.mu_dynamic_std) })
        })
        .collect();
    let title = format!("{name}: model minus measured dynamic friction of flat samples");
    Ok(charts::residuals(&title, &residuals)?)
}
