//! The table `[discrepancy]` of a material file: the model's error on patterned samples.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::{Discrepancy, DiscrepancyByHumidity, Trial, TrialDomain};
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
) -> Result<DiscrepancyByHumidity, Diagnostic> {
    let table = file.get_ref();
    let read = |estimate: &EstimateFile| {
        estimate.read().ok_or_else(|| {
            document.refuse(file.span(), "holds no estimate").expected(
                "one or two coefficients, their covariance and positive pressures, as `slipgrid calibrate` writes them",
            )
        })
    };
    let own = |own: &HumidityFile| Ok((document.number(&own.humidity_pct, HUMIDITY_PCT)?, read(&own.estimate)?));
    Ok(DiscrepancyByHumidity {
        all: read(&table.all)?,
        by_humidity: table.humidity.iter().map(own).collect::<Result<_, Diagnostic>>()?,
    })
}
