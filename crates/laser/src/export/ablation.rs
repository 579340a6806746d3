//! Depth d removed by one burst as a function of the fluence F: d = delta ln(F / F_th).
//!
//! The law is Beer-Lambert absorption with a threshold: at the depth z fluence has decayed as exp(-z / delta), and
//! material is removed where it exceeds F_th. The straight line of d against ln F is fitted by least squares.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::export::{ExportError, all_positive, positive, six_digits};

/// A measured depth per burst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AblationPoint {
    /// Peak fluence of a burst, in J/cm^2.
    pub fluence_j_cm2: f64,
    /// Depth removed by one burst, in um.
    pub depth_um: f64,
    /// Standard deviation of the depth, in um; `None` if not known.
    pub depth_std_um: Option<f64>,
}

/// Fitted ablation law, and the depth per burst at the fluence used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ablation {
    /// delta, the depth removed at e times the threshold fluence, in um.
    pub delta_um: f64,
    /// Standard error of delta, in um.
    pub delta_stderr_um: f64,
    /// F_th, the fluence below which nothing is removed, in J/cm^2.
    pub threshold_j_cm2: f64,
    /// Standard error of F_th, in J/cm^2.
    pub threshold_stderr_j_cm2: f64,
    /// Fluence used, in J/cm^2.
    pub fluence_j_cm2: f64,
    /// Depth per burst at the fluence used, in um.
    pub depth_per_burst_um: f64,
    /// Standard error of the depth per burst, in um.
    pub depth_per_burst_stderr_um: f64,
    /// Number of fitted measurements.
    pub points: usize,
}

impl Ablation {
    /// Fits the ablation law to `points` and evaluates it at `fluence_j_cm2`.
    ///
    /// If all points have standard deviations, these give the weights and the standard errors; otherwise weights are
    /// equal, and standard errors follow from the scatter about the line.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if a number is not positive, fewer than three fluences differ, depth does not increase with
    /// fluence, or `fluence_j_cm2` lies below the threshold.
    pub fn fit(points: &[AblationPoint], fluence_j_cm2: f64) -> Result<Self, ExportError> {
        positive("fluence_j_cm2", fluence_j_cm2)?;
        for point in points {
            positive("ablation fluence_j_cm2", point.fluence_j_cm2)?;
            positive("ablation depth_um", point.depth_um)?;
            all_positive([("ablation depth_std_um", point.depth_std_um)])?;
        }
        let mut fluences: Vec<f64> = points.iter().map(|point| point.fluence_j_cm2).collect();
        fluences.sort_by(f64::total_cmp);
        fluences.dedup();
        if fluences.len() < 3 {
            return Err(ExportError::Refused(format!(
                "depth per burst is given at {} different fluences: expected at least three",
                fluences.len()
            )));
        }
        let deviations: Option<Vec<f64>> = points.iter().map(|point| point.depth_std_um).collect();
        let weights: Vec<f64> = deviations
            .as_ref()
            .map_or(vec![1.0; points.len()], |all| all.iter().map(|std| 1.0 / (std * std)).collect());
        let sum = |value: &dyn Fn(&AblationPoint) -> f64| -> f64 {
            points.iter().zip(&weights).map(|(point, weight)| weight * value(point)).sum()
        };
        // Relative to the mean of x = ln F, slope delta and mean depth are uncorrelated.
        let x = |point: &AblationPoint| libm::log(point.fluence_j_cm2);
        let weight = sum(&|_| 1.0);
        let (mean_x, mean_d) = (sum(&x) / weight, sum(&|point| point.depth_um) / weight);
        let square = sum(&|point| (x(point) - mean_x) * (x(point) - mean_x));
        let delta = sum(&|point| (x(point) - mean_x) * (point.depth_um - mean_d)) / square;
        // NaN if a weight overflows; refused as well.
        if delta.is_nan() || delta <= 0.0 {
            return Err(ExportError::Refused("depths per burst do not grow with fluence".to_owned()));
        }
        let residual = sum(&|point| {
            let left = point.depth_um - mean_d - delta * (x(point) - mean_x);
            left * left
        });
        let variance = if deviations.is_some() { 1.0 } else { residual / (points.len() - 2) as f64 };
        let (var_delta, var_mean) = (variance / square, variance / weight);
        // ln F_th = <x> - <d> / delta
        let threshold = libm::exp(mean_x - mean_d / delta);
        let var_ln_threshold = var_mean / (delta * delta) + mean_d * mean_d * var_delta / delta.powi(4);
        // d = <d> + delta (ln F - <x>)
        let from_mean = libm::log(fluence_j_cm2) - mean_x;
        let depth_um = mean_d + delta * from_mean;
        if depth_um.is_nan() || depth_um <= 0.0 {
            let expected = "a fluence above the fitted threshold";
            return Err(ExportError::out_of_range("fluence_j_cm2", fluence_j_cm2, expected));
        }
        Ok(Self {
            delta_um: six_digits(delta),
            delta_stderr_um: six_digits(var_delta.sqrt()),
            threshold_j_cm2: six_digits(threshold),
            threshold_stderr_j_cm2: six_digits(threshold * var_ln_threshold.sqrt()),
            fluence_j_cm2,
            depth_per_burst_um: six_digits(depth_um),
            depth_per_burst_stderr_um: six_digits((var_mean + from_mean * from_mean * var_delta).sqrt()),
            points: points.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(depth: impl Fn(f64) -> f64, std: Option<f64>) -> Vec<AblationPoint> {
        [1.0, 2.0, 4.0, 8.0]
            .map(|fluence_j_cm2| AblationPoint { fluence_j_cm2, depth_um: depth(fluence_j_cm2), depth_std_um: std })
            .to_vec()
    }

    #[test]
    fn an_exact_law_is_found_with_no_scatter() {
        let law = Ablation::fit(&points(|f| 0.8 * (f / 0.5).ln(), None), 3.0).unwrap();
        assert!((law.delta_um - 0.8).abs() < 1e-6 && (law.threshold_j_cm2 - 0.5).abs() < 1e-6);
        assert!((law.depth_per_burst_um - 0.8 * 6.0_f64.ln()).abs() < 1e-5);
        assert!(law.delta_stderr_um < 1e-9 && law.depth_per_burst_stderr_um < 1e-9);
    }

    #[test]
    fn errors_are_those_of_the_textbook() {
        // x = ln F evenly spaced by ln 2: sum (x - <x>)^2 = 5 ln(2)^2, four weights 1/s^2.
        let law = Ablation::fit(&points(|f| 0.8 * (f / 0.5).ln(), Some(0.1)), 8_f64.sqrt()).unwrap();
        assert!((law.delta_stderr_um - 0.1 / (5_f64.sqrt() * 2_f64.ln())).abs() < 1e-6);
        // At the mean of ln F the depth has the standard error of the mean of four.
        assert!((law.depth_per_burst_stderr_um - 0.05).abs() < 1e-6);
        // Standard error of the threshold: ln F_th = <x> - <d>/delta.
        let (mean, delta): (f64, f64) = (0.8 * (8_f64.sqrt() / 0.5).ln(), 0.8);
        let var = 0.0025 / (delta * delta) + mean * mean * law.delta_stderr_um.powi(2) / delta.powi(4);
        assert!((law.threshold_stderr_j_cm2 - 0.5 * var.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn scatter_about_the_line_is_the_error_where_none_is_given() {
        // Residuals +-e in the pattern + - - +: orthogonal to line and mean.
        let e = 0.03;
        let bent = |f: f64| 0.8 * (f / 0.5).ln() + if f == 1.0 || f == 8.0 { e } else { -e };
        let law = Ablation::fit(&points(bent, None), 2.0).unwrap();
        assert!((law.delta_um - 0.8).abs() < 1e-6);
        // s^2 = 4 e^2 / (4 - 2)
        assert!((law.delta_stderr_um - (2.0 * e * e / 5.0).sqrt() / 2_f64.ln()).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let good = points(|f| 0.8 * (f / 0.5).ln(), None);
        let refused = |points: &[AblationPoint], fluence| Ablation::fit(points, fluence).unwrap_err().to_string();
        assert!(refused(&good[..2], 2.0).contains("three"));
        assert!(refused(&[good[0], good[0], good[1], good[1]], 2.0).contains("2 different"));
        assert!(refused(&points(|f| 5.0 - f / 2.0, None), 2.0).contains("do not grow with fluence"));
        assert!(refused(&good, 0.49).contains("above the fitted threshold"));
        assert!(refused(&good, f64::NAN).contains("fluence_j_cm2"));
        assert!(refused(&points(|_| -1.0, None), 2.0).contains("depth_um"));
    }
}
