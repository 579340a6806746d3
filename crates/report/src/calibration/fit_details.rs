//! Everything a fit found, for its report.

use serde::Serialize;
use slipgrid_calibrate::{CalibrationOutcome, CalibrationTask, Fit, Parameter, split_parameter_name};

use super::static_friction::{StaticRow, rows};
use crate::ReportError;
use crate::charts::{Estimate, ResidualsChart, residuals as draw};
use slipgrid_results::{SCHEMA, Table, VERSION, fixed};
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Numbers with their uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct FitDetails {
    /// `slipgrid`.
    pub program: &'static str,
    /// Its version.
    pub version: &'static str,
    /// Schema of the file.
    pub schema: u32,
    /// Fitted numbers.
    pub parameters: Vec<ParameterReport>,
    /// Their covariance; null where the data do not determine it.
    pub covariance: Vec<Vec<Option<f64>>>,
    /// Sum of squared residuals in standard deviations.
    pub chi_square: f64,
    /// Measured numbers less fitted ones.
    pub degrees_of_freedom: usize,
    /// Whether the fit settled within its rounds.
    pub settled: bool,
    /// What makes fitted values doubtful.
    pub warnings: Vec<String>,
    /// Measured static peaks beside those of the model.
    pub static_friction: Vec<StaticRow>,
}

/// One fitted number.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct ParameterReport {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard error from the curvature; null where it is infinite.
    pub std_error: Option<f64>,
    /// Least and greatest value allowed.
    pub bounds: [f64; 2],
    /// It ended at a bound.
    pub at_bound: bool,
    /// Ends of the 95 % interval by the profile; null where it reaches a bound.
    pub interval_95: [Option<f64>; 2],
    /// Value and increase of chi-square.
    pub profile: Vec<[f64; 2]>,
}

/// The fitted numbers of `fit`.
fn parameters(fit: &Fit) -> Vec<ParameterReport> {
    let report = |parameter: &Parameter| ParameterReport {
        name: parameter.name.clone(),
        value: tidy(parameter.value),
        std_error: finite(parameter.std_error),
        bounds: parameter.bounds.map(tidy),
        at_bound: parameter.at_bound,
        interval_95: parameter.interval.map(|end| end.map(tidy)),
        profile: parameter.profile.iter().map(|point| point.map(tidy)).collect(),
    };
    fit.parameters.iter().map(report).collect()
}

fn finite(value: f64) -> Option<f64> {
    Some(tidy(value)).filter(|value| value.is_finite())
}

/// Everything that was found, as JSON.
pub fn json(task: &CalibrationTask, outcome: &CalibrationOutcome) -> Result<String, ReportError> {
    let fit = &outcome.fit;
    let details = FitDetails {
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
    Ok(slipgrid_results::json(&details)?)
}

/// A fitted number's name with the measurement that it belongs to: `dynamic_mean 200 N, 2 mm/s, 50 %` for the name `dynamic_mean 4`.
pub fn in_words(outcome: &CalibrationOutcome, name: &str) -> String {
    let placed = split_parameter_name(name, &outcome.measurements);
    placed.map_or_else(|| name.to_owned(), |(what, at)| format!("{what} {}", at.condition_in_words()))
}

/// What the errors of fitted numbers have in them, beside those of the table of coefficients.
pub fn which_errors(outcome: &CalibrationOutcome) -> &'static str {
    if outcome.fit.pairs.iter().any(|pair| pair.dynamic_std_error_given_law.is_some()) {
        "at the given area law and modulus, as flat friction is known; the errors of mu_d in the table above have those of the law and of \
         Young's modulus in them"
    } else {
        "at the given area law and modulus"
    }
}

/// Every number with its intervals.
pub fn table(outcome: &CalibrationOutcome) -> String {
    let parameters = parameters(&outcome.fit);
    if parameters.is_empty() {
        return String::new();
    }
    let mut table = Table::new(["parameter", "value", "+-", "95 % from", "to"]);
    for parameter in &parameters {
        let cell = |value: Option<f64>| {
            let digits = if parameter.value.abs() > 100.0 { 0 } else { 4 };
            fixed(value, digits)
        };
        table.row([
            in_words(outcome, &parameter.name),
            cell(Some(parameter.value)),
            cell(parameter.std_error),
            cell(parameter.interval_95[0]),
            cell(parameter.interval_95[1]),
        ]);
    }
    let which = which_errors(outcome);
    format!("\nby profile likelihood, {which}; a dash is an end that the data leave open\n{table}")
}

/// Profiles as CSV.
pub fn profiles(fit: &Fit) -> String {
    let mut text = String::from("parameter,value,chi_square_increase\n");
    for parameter in &parameters(fit) {
        for [value, increase] in &parameter.profile {
            text += &format!("{},{value},{increase}\n", parameter.name);
        }
    }
    text
}

/// Residuals of all measurements in standard deviations.
pub fn residuals(name: &str, outcome: &CalibrationOutcome) -> Result<String, ReportError> {
    let labels: Vec<String> = outcome
        .measurements
        .iter()
        .map(|m| {
            format!("{} N {} mm/s {} %", m.force_n, SPEED_MM_S.from_si(m.speed_m_s), HUMIDITY_PCT.from_si(m.humidity))
        })
        .collect();
    let residuals: Vec<Estimate> = outcome
        .measurements
        .iter()
        .zip(&outcome.fit.predictions)
        .map(|(measured, predicted)| Estimate { value: predicted.residual, error: Some(measured.mu_dynamic_std) })
        .collect();
    let title = format!("{}: model minus measured dynamic friction of flat samples", name);
    Ok(draw(&ResidualsChart { title: &title, labels: &labels, residuals: &residuals })?)
}
