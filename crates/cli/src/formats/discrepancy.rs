//! The table `[discrepancy]` of a material file: the model's error on patterned samples.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::{Discrepancy, Trial, TrialDomain};
use slipgrid_pattern::Planform;
use toml::Spanned;

use super::document::Document;
use super::values::{Number, number};
use crate::diagnostic::Diagnostic;
use slipgrid_units::{FRACTION, HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, tidy};

/// `[discrepancy]` as a file writes it: ln(measured / modelled ratio) = a + b (P - P0) / P0.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DiscrepancyFile {
    /// The patterned samples behind it.
    pub pattern: String,
    /// Over all measured conditions.
    pub all: EstimateFile,
    /// At each humidity with enough measurements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub humidity: Vec<HumidityFile>,
    /// What was cut and measured; without it no design aims with the discrepancy.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trials: Vec<TrialFile>,
}

/// A pattern behind a discrepancy.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    /// Shape of its cavities.
    pub planform: Spanned<String>,
    /// Share of its face that is cavity.
    pub areal_density: Number,
    /// Depth of its cavities.
    pub depth_um: Number,
}

impl From<&Trial> for TrialFile {
    fn from(trial: &Trial) -> Self {
        Self {
            planform: Spanned::new(0..0, trial.planform.name().to_owned()),
            areal_density: number(tidy(trial.areal_density)),
            depth_um: number(tidy(LENGTH_UM.from_si(trial.depth_m))),
        }
    }
}

/// The estimate at one humidity.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct HumidityFile {
    /// Relative humidity.
    pub humidity_pct: Number,
    /// The estimate.
    pub estimate: EstimateFile,
}

/// A discrepancy with its uncertainty.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateFile {
    /// a, and b where it is linear in pressure.
    pub coefficients: Vec<f64>,
    /// Their covariance, scatter included.
    pub covariance: Vec<Vec<f64>>,
    /// P0.
    pub reference_pressure_mpa: f64,
    /// Scatter of the ratio's logarithm between conditions.
    pub scatter: f64,
    /// How a and b fall with the logarithm of Young's modulus.
    pub modulus_sensitivity: Vec<f64>,
    /// Relative standard deviation of Young's modulus.
    pub modulus_relative_std: f64,
    /// Least and greatest pressure measured.
    pub pressure_range_mpa: [f64; 2],
    /// Sum of squared residuals in measured standard deviations, without scatter.
    pub chi_square: f64,
    /// Ratios less coefficients.
    pub degrees_of_freedom: usize,
}

impl EstimateFile {
    /// An estimate as written.
    #[must_use]
    pub fn new(found: &Discrepancy) -> Self {
        let all = |values: &[f64]| values.iter().copied().map(tidy).collect::<Vec<f64>>();
        Self {
            coefficients: all(&found.coefficients),
            covariance: found.covariance.iter().map(|row| all(row)).collect(),
            reference_pressure_mpa: PRESSURE_MPA.from_si(found.reference_pressure_pa),
            scatter: tidy(found.scatter),
            modulus_sensitivity: all(&found.modulus_sensitivity),
            modulus_relative_std: tidy(found.modulus_relative_std),
            pressure_range_mpa: found.pressure_range_pa.map(|pressure_pa| PRESSURE_MPA.from_si(pressure_pa)),
            chi_square: tidy(found.chi_square),
            degrees_of_freedom: found.degrees_of_freedom,
        }
    }

    fn read(&self) -> Option<Discrepancy> {
        let count = self.coefficients.len();
        let square = self.covariance.len() == count && self.covariance.iter().all(|row| row.len() == count);
        let range =
            PRESSURE_MPA.accepts(self.pressure_range_mpa[0]) && PRESSURE_MPA.accepts(self.pressure_range_mpa[1]);
        let meaningful = (1..=2).contains(&count)
            && square
            && self.modulus_sensitivity.len() == count
            && PRESSURE_MPA.accepts(self.reference_pressure_mpa)
            && range
            && self.scatter >= 0.0
            && self.modulus_relative_std >= 0.0;
        meaningful.then(|| Discrepancy {
            coefficients: self.coefficients.clone(),
            covariance: self.covariance.clone(),
            reference_pressure_pa: PRESSURE_MPA.to_si(self.reference_pressure_mpa),
            scatter: self.scatter,
            modulus_sensitivity: self.modulus_sensitivity.clone(),
            modulus_relative_std: self.modulus_relative_std,
            pressure_range_pa: self.pressure_range_mpa.map(|pressure| PRESSURE_MPA.to_si(pressure)),
            chi_square: self.chi_square,
            degrees_of_freedom: self.degrees_of_freedom,
        })
    }
}

/// The discrepancy over all conditions, and at humidities that have one of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrepancies {
    all: Discrepancy,
    by_humidity: Vec<(f64, Discrepancy)>,
}

impl Discrepancies {
    /// The discrepancy for a humidity, from 0 to 1: its own where one was estimated, between two that have one what lies
    /// between theirs, that of all conditions otherwise.
    #[must_use]
    pub fn at(&self, humidity: Option<f64>) -> Discrepancy {
        let Some(humidity) = humidity else { return self.all.clone() };
        let is_own = |measured: f64| (humidity - measured).abs() <= 1e-6 * measured.max(1e-3);
        if let Some((_, own)) = self.by_humidity.iter().rfind(|(measured, _)| is_own(*measured)) {
            return own.clone();
        }
        let nearest = |is_on_side: &dyn Fn(f64) -> bool| {
            let on_side = self.by_humidity.iter().filter(|(measured, _)| is_on_side(*measured));
            on_side.min_by(|a, b| (a.0 - humidity).abs().total_cmp(&(b.0 - humidity).abs()))
        };
        let below = nearest(&|measured| measured < humidity);
        let above = nearest(&|measured| measured > humidity);
        let between = below
            .zip(above)
            .and_then(|((low, dry), (high, humid))| dry.towards(humid, (humidity - low) / (high - low)));
        between.unwrap_or_else(|| self.all.clone())
    }
}

/// The patterns that the discrepancy of a table is used for; `None` where it names no trials.
///
/// # Errors
/// [`Diagnostic`] for a trial that is none.
pub fn read_trials(document: &Document, file: &DiscrepancyFile) -> Result<Option<TrialDomain>, Diagnostic> {
    let trial = |trial: &TrialFile| {
        Ok(Trial {
            planform: document.choice(&trial.planform, &Planform::ALL, Planform::name)?,
            areal_density: document.number(&trial.areal_density, FRACTION)?,
            depth_m: document.number(&trial.depth_um, LENGTH_UM)?,
        })
    };
    Ok(TrialDomain::about(file.trials.iter().map(trial).collect::<Result<_, Diagnostic>>()?))
}

/// Reads every estimate of a table.
///
/// # Errors
/// [`Diagnostic`] if the numbers of one are no estimate.
pub fn read_discrepancies(
    document: &Document,
    file: &toml::Spanned<DiscrepancyFile>,
) -> Result<Discrepancies, Diagnostic> {
    let table = file.get_ref();
    let read = |estimate: &EstimateFile| {
        estimate.read().ok_or_else(|| {
            document.refuse(file.span(), "holds no estimate").expected(
                "one or two coefficients, their covariance and positive pressures, as `slipgrid calibrate` writes them",
            )
        })
    };
    let own = |own: &HumidityFile| Ok((document.number(&own.humidity_pct, HUMIDITY_PCT)?, read(&own.estimate)?));
    Ok(Discrepancies {
        all: read(&table.all)?,
        by_humidity: table.humidity.iter().map(own).collect::<Result<_, Diagnostic>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_measured_humidities_lies_what_lies_between_theirs() {
        let of = |coefficient: f64| Discrepancy {
            coefficients: vec![coefficient],
            covariance: vec![vec![1e-4]],
            reference_pressure_pa: 1.5e6,
            scatter: 0.02,
            modulus_sensitivity: vec![0.1],
            modulus_relative_std: 0.2,
            pressure_range_pa: [0.6e6, 2.5e6],
            chi_square: 4.0,
            degrees_of_freedom: 4,
        };
        let found =
            Discrepancies { all: of(-0.5), by_humidity: vec![(0.80, of(-0.4)), (0.15, of(-0.2)), (0.40, of(-0.1))] };
        let coefficient = |humidity: Option<f64>| found.at(humidity).coefficients[0];
        assert_eq!(
            [None, Some(0.15), Some(0.4), Some(0.1), Some(0.9)].map(coefficient),
            [-0.5, -0.2, -0.1, -0.5, -0.5]
        );
        assert!((coefficient(Some(0.275)) + 0.15).abs() < 1e-12 && (coefficient(Some(0.5)) + 0.175).abs() < 1e-12);
    }
}
