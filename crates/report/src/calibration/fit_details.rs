//! Full record of a fit: parameters, covariance, profiles and residuals.

use schemars::JsonSchema;
use serde::Serialize;
use slipgrid_infer::calibrate::{Measurement, ModelledRow, Parameter, split_parameter_name};

use super::{Fitted, StaticPeakFit};
use crate::ChartError;
use crate::charts::{self, Estimate};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::{MadeBy, NoJsonForm, SCHEMA, Table, fixed, json};

/// Record of a fit, as in fit.json.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct FitReport {
    /// Program that made the record.
    #[serde(flatten)]
    pub made_by: MadeBy,
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
    pub static_friction: Vec<StaticPeakFit>,
}

fn finite(value: f64) -> Option<f64> {
    Some(tidy(value)).filter(|value| value.is_finite())
}

/// Formats a `value` of a parameter, in MPa if the parameter is a pressure.
pub(crate) fn parameter_value(of: &Parameter, value: Option<f64>) -> String {
    match of.name.ends_with("_pa") {
        true => fixed(value.map(|pa| PRESSURE_MPA.from_si(pa)), 3),
        false => fixed(value, 4),
    }
}

impl Fitted {
    /// Parameters of the fit, rounded so that rounding errors of the last digits do not show.
    fn parameters(&self) -> Vec<Parameter> {
        let rounded = |parameter: &Parameter| Parameter {
            value: tidy(parameter.value),
            std_error: tidy(parameter.std_error),
            bounds: parameter.bounds.map(tidy),
            interval: parameter.interval.map(|end| end.map(tidy)),
            profile: parameter.profile.iter().map(|point| point.map(tidy)).collect(),
            ..parameter.clone()
        };
        self.outcome.fit.parameters.iter().map(rounded).collect()
    }

    /// Serializes the fit as in fit.json.
    ///
    /// # Errors
    /// [`NoJsonForm`] if the fit has no JSON form.
    pub fn fit_json(&self) -> Result<String, NoJsonForm> {
        let fit = &self.outcome.fit;
        json(&FitReport {
            made_by: MadeBy::slipgrid(SCHEMA),
            parameters: self.parameters(),
            covariance: fit.covariance.iter().map(|row| row.iter().map(|&value| finite(value)).collect()).collect(),
            chi_square: tidy(fit.chi_square),
            degrees_of_freedom: fit.degrees_of_freedom,
            settled: fit.settled,
            warnings: self.outcome.material.provenance.warnings.clone(),
            static_friction: self.static_rows(),
        })
    }

    /// Describes a fitted parameter together with its measurement, for example `dynamic_mean 200 N, 2 mm/s, 50 %` for
    /// `dynamic_mean 4`.
    pub(crate) fn in_words(&self, name: &str) -> String {
        let placed = split_parameter_name(name, &self.outcome.measurements);
        placed.map_or_else(|| name.to_owned(), |(what, at)| format!("{what} {}", at.condition_in_words()))
    }

    /// Explains which error sources the standard errors of the parameters include, and how these errors differ from
    /// those in the table of coefficients.
    pub(crate) fn which_errors(&self) -> &'static str {
        if self.outcome.fit.pairs.iter().any(|pair| pair.dynamic_std_error_given_law.is_some()) {
            "at the given area law and modulus, as flat friction is known; the errors of mu_d in the table above have those of the law and of \
             Young's modulus in them"
        } else {
            "at the given area law and modulus"
        }
    }

    /// Table of all fitted parameters with standard errors and 95 % intervals; pressures in MPa.
    pub(crate) fn parameter_table(&self) -> Table {
        let parameters = self.parameters();
        let mut table = Table::of(&parameters);
        table.column("parameter", |of| match of.name.strip_suffix("_pa") {
            Some(name) => format!("{name}, MPa"),
            None => self.in_words(&of.name),
        });
        table.column("value", |of| parameter_value(of, Some(of.value)));
        table.column("+-", |of| parameter_value(of, Some(of.std_error)));
        table.column("95 % from", |of| parameter_value(of, of.interval[0]));
        table.column("to", |of| parameter_value(of, of.interval[1]));
        table.table()
    }

    /// Formats the likelihood profiles of all parameters as CSV, one row per point of a profile.
    pub(super) fn profiles(&self) -> String {
        let mut text = String::from("parameter,value,chi_square_increase\n");
        for parameter in &self.parameters() {
            for [value, increase] in &parameter.profile {
                text += &format!("{},{value},{increase}\n", parameter.name);
            }
        }
        text
    }

    /// Draws the residuals of all measurements, with the measured standard deviations as error bars.
    pub(super) fn residuals(&self) -> Result<String, ChartError> {
        let residual = |(of, predicted): (&Measurement, &ModelledRow)| {
            let (speed, humidity) = (SPEED_MM_S.from_si(of.speed_m_s), HUMIDITY_PCT.from_si(of.humidity));
            let label = format!("{} N {speed} mm/s {humidity} %", of.force_n);
            (label, Estimate { value: predicted.residual, error: Some(of.mu_dynamic_std) })
        };
        let residuals: Vec<(String, Estimate)> = self.measured().map(residual).collect();
        let name = &self.calibration.stated.name;
        charts::residuals(&format!("{name}: model minus measured dynamic friction of flat samples"), &residuals)
    }
}
