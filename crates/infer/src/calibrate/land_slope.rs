//! Effect of the land of a cut sample that is steeper or less steep than the flat sample.
//!
//! Contact area depends on pressure over modulus and slope, A(P / (E* h'rms)). A land with q times the rms slope of the
//! flat sample has the area A(P / q). Friction is the local coefficient times f(p) = A(p) / (p lim A / P), with the
//! limit at small loads. The land therefore slides with f(p / q) / q in place of f(p), as on a body with q times the
//! modulus, except for the constant factor 1 / q:
//!
//! ```text
//! ln R_land(P) = ln R(P; q E) + ln [A(P / q) / A(P)]
//! A(P / q) / A(P) = f(P / q) / [q f(P)],     ln R(P; q E) = ln R(P) + g ln q
//! ```
//!
//! with g = d ln R / d ln E. The factor A(P / q) / A(P) is 1 / q where area is in proportion to load, and 1 in full
//! contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{PRESSURE_MPA, tidy};
use slipgrid_model::material::AreaLaw;
use slipgrid_surface::topography::HeightMap;

use crate::discrepancy::{DimensionShift, Features, Measured};

/// Number of windows along each side of a map. Their scatter gives the error of a slope; 16 windows determine this
/// error to a fifth.
const WINDOWS: usize = 4;
/// Step of ln P for numerical derivatives of the area law, which is tabulated.
const LOG_STEP: f64 = 0.02;

/// Rms slope of the land of a cut sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LandSlope {
    /// Rms slope of the land, by differences of neighbouring heights.
    pub rms_slope: f64,
    // q
    /// Rms slope over that of the flat sample.
    pub over_flat: f64,
    /// Standard error of the logarithm of `over_flat`, from windows of both maps.
    pub log_std: f64,
}

/// Land of a trial, and its effect on the modelled ratios.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LandEffect {
    /// Name of the trial.
    pub trial: String,
    /// Slope of the land.
    #[serde(flatten)]
    pub slope: LandSlope,
    /// Nominal pressures of the measured ratios.
    pub pressure_mpa: Vec<f64>,
    /// Factor on the modelled ratio at each pressure.
    pub factor: Vec<f64>,
    /// Slope and effect in words.
    pub words: String,
}

impl LandSlope {
    /// Compares `land`, a map that contains only the land, with the map `flat`; `None` if the land has no neighbouring
    /// points, or too few windows for an error.
    pub fn of_maps(land: &HeightMap, flat: &HeightMap) -> Option<Self> {
        let [(rms_slope, std), (of_flat, std_of_flat)] = [land, flat].map(|map| map.windowed_slope(WINDOWS));
        let (over_flat, log_std) = (rms_slope / of_flat, std?.hypot(std_of_flat?));
        (over_flat.is_finite() && over_flat > 0.0).then(|| Self {
            rms_slope: tidy(rms_slope),
            over_flat: tidy(over_flat),
            log_std: tidy(log_std),
        })
    }

    /// Multiplies the modelled ratios in `measured` by the effect of the land of `trial`, changes their derivatives
    /// with respect to Young's modulus accordingly, and adds the effect of the slope's error to the `shifts` of the
    /// sample with these `features`.
    pub(crate) fn apply(
        &self,
        trial: &str,
        law: &AreaLaw,
        measured: &mut [Measured],
        (shifts, features): (&mut Vec<DimensionShift>, Features),
    ) -> LandEffect {
        let log_q = libm::log(self.over_flat);
        let log_ratio = measured.iter().map(|at| {
            let by = |log_q: f64| log_factor(law, at, log_q);
            tidy(by(log_q + self.log_std) - by(log_q))
        });
        shifts.push(DimensionShift { log_ratio: log_ratio.collect(), above: features, below: None });
        let apply = |at: &mut Measured| {
            let pressure_pa = at.load.pressure_pa;
            let factor = libm::exp(log_factor(law, at, log_q));
            at.modelled = tidy(at.modelled * factor);
            // A(P / q) / A(P) depends on P / E alone: d ln / d ln E = a(P) - a(P / q), a = d ln A / d ln P.
            let slope = |pressure_pa: f64| {
                let f = |log: f64| libm::log(law.factor(pressure_pa * libm::exp(log)));
                (f(LOG_STEP) - f(-LOG_STEP)) / (2.0 * LOG_STEP)
            };
            at.sensitivity.modulus =
                tidy(at.sensitivity.modulus + slope(pressure_pa) - slope(pressure_pa / self.over_flat));
            [PRESSURE_MPA.from_si(pressure_pa), tidy(factor)]
        };
        let factors: Vec<[f64; 2]> = measured.iter_mut().map(apply).collect();
        let words = self.in_words(trial, &factors);
        let (pressure_mpa, factor) = factors.into_iter().map(Into::<(f64, f64)>::into).unzip();
        LandEffect { trial: trial.to_owned(), slope: *self, pressure_mpa, factor, words }
    }

    /// Describes the slope and its effect on `trial`; `factors` are pairs of the pressure in MPa and the factor on the
    /// modelled ratio.
    fn in_words(&self, trial: &str, factors: &[[f64; 2]]) -> String {
        let Self { rms_slope, over_flat, log_std } = self;
        let std = over_flat * log_std;
        let slope =
            format!("land of {trial}: rms slope {rms_slope:.3}, {over_flat:.2} +- {std:.2} times the flat sample's");
        let by_pressure = |a: &&[f64; 2], b: &&[f64; 2]| a[0].total_cmp(&b[0]);
        let ends = (factors.iter().min_by(by_pressure), factors.iter().max_by(by_pressure));
        let (Some(first), Some(last)) = ends else { return slope };
        let at = |[pressure_mpa, factor]: &[f64; 2]| format!("{factor:.3} at {pressure_mpa:.2} MPa");
        let and = if last[0] > first[0] { format!(" and {}", at(last)) } else { String::new() };
        format!("{slope}; this multiplies its modelled ratio by {}{and}", at(first))
    }
}

/// Logarithm of the factor on the modelled ratio by a land exp(`log_q`) times as steep as the flat sample, at the load
/// of `at`.
fn log_factor(law: &AreaLaw, at: &Measured, log_q: f64) -> f64 {
    let f = |pressure_pa: f64| libm::log(law.factor(pressure_pa));
    let pressure_pa = at.load.pressure_pa;
    at.sensitivity.modulus * log_q + f(pressure_pa * libm::exp(-log_q)) - log_q - f(pressure_pa)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrepancy::tests::{groove, measured};
    use crate::discrepancy::{Load, Sensitivity};

    fn applied(over_flat: f64, law: &AreaLaw, pressure_pa: f64, modulus: f64) -> (Measured, DimensionShift) {
        let load = Load { pressure_pa, speed_m_s: 2e-3, humidity: 0.4 };
        let features = groove(100.0, 300.0, 10.0);
        let (mut measured, mut shifts) = ([measured(load, -0.1, 0.01, Sensitivity::of_modulus(modulus))], Vec::new());
        let slope = LandSlope { rms_slope: 0.02, over_flat, log_std: 0.05 };
        let effect = slope.apply("cut", law, &mut measured, (&mut shifts, features));
        assert!((effect.factor[0] - measured[0].modelled / 0.9).abs() < 1e-5);
        // The error of the slope is no error of the texture.
        assert_eq!(shifts[0].above, features);
        (measured[0], shifts.remove(0))
    }

    #[test]
    fn area_in_proportion_to_load_divides_by_the_slope_and_full_contact_changes_nothing() {
        // Area in proportion to load up to 1 MPa, and constant above 10 MPa.
        let law = AreaLaw::new(vec![1e6, 10e6], vec![1.0, 0.5]).unwrap();
        let (same, _) = applied(1.0, &law, 3e6, 0.1);
        assert_eq!((same.modelled, same.sensitivity.modulus), (0.9, 0.1));
        let (light, shift) = applied(1.2, &law, 0.5e6, 0.0);
        assert!((light.modelled - 0.9 / 1.2).abs() < 1e-6 && (shift.log_ratio[0] + 0.05).abs() < 1e-6, "{light:?}");
        let (full, shift) = applied(1.2, &law, 40e6, 0.0);
        assert!((full.modelled - 0.9).abs() < 1e-6 && shift.log_ratio[0].abs() < 1e-6, "{full:?}");
    }

    /// Persson's area, erf(sqrt 2 P / s): the factor is that of the areas, times q^g.
    #[test]
    fn the_factor_is_that_of_the_areas_and_of_the_stiffer_pattern() {
        let area = |pressure_pa: f64| libm::erf(2.0_f64.sqrt() * pressure_pa / 4e6);
        let light_pa = 1e4;
        let pressures_pa: Vec<f64> = (0..200).map(|n| light_pa * 1.05_f64.powi(n)).collect();
        let unit = area(light_pa) / light_pa;
        let law =
            AreaLaw::new(pressures_pa.clone(), pressures_pa.iter().map(|p| area(*p) / p / unit).collect()).unwrap();
        for (q, g) in [(1.2_f64, 0.0), (0.8, 0.0), (1.25, 0.3)] {
            for pressure_pa in [0.3e6, 1e6, 3e6] {
                let (at, shift) = applied(q, &law, pressure_pa, g);
                let expected = area(pressure_pa / q) / area(pressure_pa) * q.powf(g);
                assert!((at.modelled / 0.9 - expected).abs() < 2e-4, "{q} {pressure_pa}: {at:?} {expected}");
                let above = q * 0.05_f64.exp();
                let moved = area(pressure_pa / above) / area(pressure_pa) * above.powf(g);
                assert!((shift.log_ratio[0] - (moved / expected).ln()).abs() < 5e-4, "{shift:?}");
                // The same on a body 10 % stiffer.
                let stiff = |p: f64| area(p / 1.1);
                let slope =
                    ((stiff(pressure_pa / q) / stiff(pressure_pa)).ln() - (expected / q.powf(g)).ln()) / 1.1_f64.ln();
                assert!((at.sensitivity.modulus - g - slope).abs() < 0.02, "{at:?} {slope}");
            }
        }
    }
}
