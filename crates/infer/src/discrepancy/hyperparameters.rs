//! Prior of the discrepancy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::discrepancy::{DiscrepancyError, Features, Form};

/// Prior of the discrepancy, before any measurement. Standard deviations refer to the logarithm of the ratio at the
/// reference texture. The keys of a file are the standard deviations.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Hyperparameters {
    /// Texture at which every form is 1. Default: the published squares, the only texture with a published discrepancy,
    /// 0.19.
    #[serde(skip)]
    pub reference: Features,
    // Of alpha, as large as the published discrepancy.
    /// Size of the discrepancy at the published squares; 0.2 when absent.
    pub amplitude_std: f64,
    // Of beta. The published samples show no such trend from 0.6 to 2.5 MPa.
    /// Slope along (P - P0) / P0, with P0 the mean measured pressure; 0.06 when absent.
    pub pressure_std: f64,
    // Of gamma. A film of water, adhesion or a meniscus adds a force, whose effect decreases with load.
    /// Slope along P1 / P at each humidity, with P1 the lowest pressure, as of a film that bears a force; 0.08 when absent.
    pub inverse_pressure_std: f64,
    // Of kappa, along ln(v / v0). The published samples show 0.036 +- 0.009.
    /// Change for a speed e = 2.72 times as high; 0.05 when absent.
    pub speed_std: f64,
    // Of eta, with gamma at the lowest pressure together 0.1. The published samples differ by 0.13 between 40 and 80 %.
    /// Change from one humidity to another at high pressures; 0.06 when absent.
    pub humidity_std: f64,
    /// Correlation length of the humidity coefficients eta and gamma in relative humidity, which is from 0 to 1: the
    /// correlation is exp(-(dH / length)^2 / 2), a quarter at the published difference from 40 to 80 %.
    #[serde(skip)]
    pub humidity_length: f64,
    /// Pairs of a factor on the standard deviations of all coefficients, and its weight; weights sum to 1. Many
    /// mechanisms have a small effect.
    #[serde(skip)]
    pub scales: Vec<(f64, f64)>,
    /// Pairs of the standard deviation of the residual c over `amplitude_std`, and its weight; weights sum to 1. The
    /// residual is the deviation from a form, as a smooth function of the dimensions and of pressure.
    #[serde(skip)]
    pub residuals: Vec<(f64, f64)>,
    /// Correlation length of the residual c in the logarithms of width, pitch and depth.
    #[serde(skip)]
    pub residual_length: f64,
    /// Correlation length of the residual c in the logarithm of pressure.
    #[serde(skip)]
    pub residual_pressure_length: f64,
    // Of t.
    /// Scatter between samples of one texture, until trials show otherwise; 0.02 when absent.
    pub sample_std: f64,
    /// Pairs of a factor on the stated scatter of samples, and its weight; weights sum to 1. The stated scatter holds
    /// unless trials show more or less. The tail is heavy, so that any scatter is possible.
    #[serde(skip)]
    pub scatters: Vec<(f64, f64)>,
    /// Minimum relative standard error of a measurement; 0.005 when absent.
    pub least_measured_std: f64,
    /// Forms with their prior weights, which sum to 1.
    #[serde(skip)]
    pub forms: Vec<(Form, f64)>,
}

/// Default standard deviation of ln(ratio) between samples of one texture, which holds until trials show otherwise.
/// Laboratories repeat dry friction to 2 to 7 %, and ASTM D2534 states a standard deviation of 0.02 for a coefficient.
const USUAL_SAMPLE_STD: f64 = 0.02;

impl Default for Hyperparameters {
    fn default() -> Self {
        Self {
            reference: Features {
                areal_density: 0.0676,
                edge_1_m: 2080.0,
                width_m: 130e-6,
                pitch_m: 500e-6,
                depth_m: 5.2e-6,
                face_share: 1.0,
            },
            amplitude_std: 0.2,
            pressure_std: 0.06,
            inverse_pressure_std: 0.08,
            speed_std: 0.05,
            humidity_std: 0.06,
            humidity_length: 0.25,
            scales: vec![(0.3, 0.4), (1.0, 0.6)],
            residuals: vec![(0.1, 0.5), (0.4, 0.5)],
            residual_length: 0.8,
            residual_pressure_length: 2.0,
            sample_std: USUAL_SAMPLE_STD,
            scatters: vec![(1.0, 0.7), (0.25, 0.2), (3.0, 0.07), (10.0, 0.03)],
            least_measured_std: 0.005,
            forms: Form::usual(),
        }
    }
}

/// Reference pressures and speed, from the flat sample's measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// P0 in the term (P - P0) / P0: the mean of the measured pressures, in pascals.
    pub reference_pressure_pa: f64,
    /// P1 in the term P1 / P: the minimum of the measured pressures, in pascals.
    pub lowest_pressure_pa: f64,
    /// v0 in the term ln(v / v0): the geometric mean of the measured speeds, in m/s.
    pub reference_speed_m_s: f64,
}

impl Default for Conditions {
    /// Conditions of the published measurements.
    fn default() -> Self {
        Self { reference_pressure_pa: 1.5e6, lowest_pressure_pa: 0.65e6, reference_speed_m_s: 2e-3 }
    }
}

impl Hyperparameters {
    /// Checks that all hyperparameters are valid.
    ///
    /// # Errors
    /// [`DiscrepancyError::Hyperparameter`] of the first invalid one.
    pub(crate) fn check(&self) -> Result<(), DiscrepancyError> {
        let bounded = |name, value: f64| (name, value, (0.0..=10.0).contains(&value), "a number from 0 to 10");
        let positive = |name, value: f64| (name, value, value > 0.0 && value.is_finite(), "a positive finite number");
        // Without information from trials, the first scatter is used.
        let (first, weight) = self.scatters.first().copied().unwrap_or((f64::NAN, 0.0));
        let mut numbers = vec![
            bounded("amplitude_std", self.amplitude_std),
            bounded("pressure_std", self.pressure_std),
            bounded("inverse_pressure_std", self.inverse_pressure_std),
            bounded("speed_std", self.speed_std),
            bounded("humidity_std", self.humidity_std),
            bounded("sample_std", self.sample_std),
            positive("least_measured_std", self.least_measured_std),
            positive("humidity_length", self.humidity_length),
            positive("residual_length", self.residual_length),
            positive("residual_pressure_length", self.residual_pressure_length),
            positive("areal density of the reference", self.reference.areal_density),
            positive("edge length of the reference", self.reference.edge_1_m),
            positive("depth of the reference", self.reference.depth_m),
            ("first of the scatters", first, first == 1.0 && weight > 0.0, "1, the stated one, with a weight"),
        ];
        let forms: Vec<(f64, f64)> = self.forms.iter().map(|(_, weight)| (1.0, *weight)).collect();
        for (name, all) in [
            ("sum of the forms' weights", &forms),
            ("sum of the scales' weights", &self.scales),
            ("sum of the residuals' weights", &self.residuals),
            ("sum of the scatters' weights", &self.scatters),
        ] {
            let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
            let is_valid = all.iter().all(|(_, weight)| *weight >= 0.0) && (sum - 1.0).abs() <= 1e-6;
            numbers.push((name, sum, is_valid, "1, each of them 0 or more"));
            for (size, _) in all {
                numbers.push(("a scale, residual or scatter", *size, (0.0..=100.0).contains(size), "from 0 to 100"));
            }
        }
        match numbers.into_iter().find(|(_, _, is_valid, _)| !is_valid) {
            Some((name, value, _, expected)) => Err(DiscrepancyError::Hyperparameter { name, value, expected }),
            None => Ok(()),
        }
    }
}
