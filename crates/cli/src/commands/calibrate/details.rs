//! Everything a fit found, for its report.

use serde::Serialize;
use slipgrid_calibrate::{AreaLawScale, Parameter};
use slipgrid_contact::AreaPoint;
use slipgrid_material::AreaLaw;

use super::Fit;
use crate::CliError;
use crate::commands::area_curve::persson_curve;
use slipgrid_formats::calibration::Calibration;
use slipgrid_report::charts::{Estimate, ResidualsChart, residuals as draw};
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Names of fitted numbers.
const DYNAMIC_MEAN: &str = "dynamic_mean";
const AREA_LAW_SCALE: &str = "area_law_scale_pa";

/// Numbers with their uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FitDetails {
    /// Fitted numbers.
    pub parameters: Vec<ParameterReport>,
    /// Their covariance; null where the data do not determine it.
    pub covariance: Vec<Vec<Option<f64>>>,
    /// Sum of squared residuals in standard deviations.
    pub chi_square: f64,
    /// Measured numbers less fitted ones.
    pub degrees_of_freedom: usize,
    /// The law of the fit, where its scale was fitted.
    #[serde(skip)]
    pub area_law: Option<AreaLaw>,
    /// The contact area behind it.
    #[serde(skip)]
    pub area_curve: Vec<AreaPoint>,
}

/// One fitted number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
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

impl FitDetails {
    /// Covariance of the one fitted `dynamic_mean`, whose standard error in all is `std_error`, and of the logarithm of
    /// the area law's scale; `None` where the scale was not fitted or the data do not determine it.
    pub fn scale_covariance(&self, std_error: Option<f64>) -> Option<Vec<Vec<f64>>> {
        let place = |name: &str| self.parameters.iter().position(|parameter| parameter.name == name);
        let (mean, scale) = (place(DYNAMIC_MEAN)?, place(AREA_LAW_SCALE)?);
        let entry = |i: usize, j: usize| self.covariance.get(i)?.get(j).copied().flatten();
        let variance = std_error.map_or(entry(mean, mean)?, |std_error| std_error * std_error);
        let shared = entry(mean, scale)?;
        Some(vec![vec![tidy(variance), tidy(shared)], vec![tidy(shared), tidy(entry(scale, scale)?)]])
    }

    /// What `fit` found; `scale` is the law whose scale was fitted.
    pub fn new(fit: &slipgrid_calibrate::Fit, scale: Option<&AreaLawScale>) -> Self {
        let finite = |value: f64| Some(tidy(value)).filter(|value| value.is_finite());
        let report = |parameter: &Parameter| ParameterReport {
            name: parameter.name.clone(),
            value: tidy(parameter.value),
            std_error: finite(parameter.std_error),
            bounds: parameter.bounds.map(tidy),
            at_bound: parameter.at_bound,
            interval_95: parameter.interval.map(|end| end.map(tidy)),
            profile: parameter.profile.iter().map(|point| point.map(tidy)).collect(),
        };
        let value = fit.parameters.iter().find(|parameter| parameter.name == "area_law_scale_pa");
        let area_curve = match (scale, value) {
            (Some(scale), Some(value)) => {
                let pressures: Vec<f64> = scale.pressure_over_scale.iter().map(|x| x * value.value).collect();
                // The numbers were accepted by the fit.
                persson_curve(1.0, value.value, &pressures).unwrap_or_default()
            }
            _ => Vec::new(),
        };
        Self {
            parameters: fit.parameters.iter().map(report).collect(),
            covariance: fit.covariance.iter().map(|row| row.iter().map(|&value| finite(value)).collect()).collect(),
            chi_square: tidy(fit.chi_square),
            degrees_of_freedom: fit.degrees_of_freedom,
            area_law: scale.and(fit.area_law.clone()),
            area_curve,
        }
    }

    /// Every number with its intervals.
    pub fn table(&self) -> String {
        if self.parameters.is_empty() {
            return String::new();
        }
        let mut table = Table::new(["parameter", "value", "+-", "95 % from", "to"]);
        for parameter in &self.parameters {
            let cell = |value: Option<f64>| {
                let digits = if parameter.value.abs() > 100.0 { 0 } else { 4 };
                fixed(value, digits)
            };
            table.row([
                parameter.name.clone(),
                cell(Some(parameter.value)),
                cell(parameter.std_error),
                cell(parameter.interval_95[0]),
                cell(parameter.interval_95[1]),
            ]);
        }
        format!("\nby profile likelihood; a dash is an end that the data leave open\n{table}")
    }

    /// Profiles as CSV.
    pub fn profiles(&self) -> String {
        let mut text = String::from("parameter,value,chi_square_increase\n");
        for parameter in &self.parameters {
            for [value, increase] in &parameter.profile {
                text += &format!("{},{value},{increase}\n", parameter.name);
            }
        }
        text
    }
}

/// Residuals of all measurements in standard deviations.
pub fn residuals(calibration: &Calibration, fit: &Fit) -> Result<String, CliError> {
    let labels: Vec<String> = calibration
        .flat
        .iter()
        .map(|m| {
            format!("{} N {} mm/s {} %", m.force_n, SPEED_MM_S.from_si(m.speed_m_s), HUMIDITY_PCT.from_si(m.humidity))
        })
        .collect();
    let residuals: Vec<Estimate> = calibration
        .flat
        .iter()
        .zip(&fit.residuals)
        .map(|(measured, residual)| Estimate { value: *residual, error: Some(measured.mu_dynamic_std) })
        .collect();
    let title = format!("{}: model minus measured dynamic friction of flat samples", calibration.name);
    draw(&ResidualsChart { title: &title, labels: &labels, residuals: &residuals })
        .map_err(|error| CliError::Other(error.to_string()))
}
