//! The model's error on patterned samples: measured over modelled ratio, apart from the physics.
//!
//! ```text
//! ln(measured_i / modelled_i) = a + b (P_i - P0) / P0 + u_i + e_i
//! ```
//!
//! e is the measured ratio's error, u what is left between conditions (standard deviation tau, by the
//! method of Paule and Mandel, J. Res. Natl. Bur. Stand. 87, 377). Young's modulus is one number for all
//! conditions: were it larger by dE/E, every modelled ratio would move by g dE/E, and a and b with it. A
//! corrected ratio moves by what is left, (g - g of the fit) dE/E: most of it cancels.

use nalgebra::{DMatrix, DVector};
use slipgrid_statistics::Confidence;

use crate::FitError;

/// A measured ratio beside the modelled one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Measured ratio, patterned over flat.
    pub measured: f64,
    /// Its standard deviation.
    pub measured_std: f64,
    /// Modelled ratio.
    pub modelled: f64,
    /// g = d ln(modelled) / d ln(E).
    pub modulus_sensitivity: f64,
}

/// How the discrepancy depends on pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscrepancyForm {
    /// One factor.
    Constant,
    /// Its logarithm is linear in pressure.
    Linear,
}

impl DiscrepancyForm {
    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }
}

/// A discrepancy with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrepancy {
    /// a, and b where the form is linear.
    pub coefficients: Vec<f64>,
    /// Their covariance at the given Young's modulus, tau included.
    pub covariance: Vec<Vec<f64>>,
    /// P0, in pascals.
    pub reference_pressure_pa: f64,
    /// tau: scatter between conditions, of the ratio's logarithm.
    pub scatter: f64,
    /// How a and b fall with ln E: the fit's own g.
    pub modulus_sensitivity: Vec<f64>,
    /// Relative standard deviation of Young's modulus.
    pub modulus_relative_std: f64,
    /// Least and greatest pressure measured, in pascals.
    pub pressure_range_pa: [f64; 2],
    /// Sum of squared residuals in measured standard deviations, without tau.
    pub chi_square: f64,
    /// Measured ratios less coefficients.
    pub degrees_of_freedom: usize,
}

/// A ratio with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioInterval {
    /// The ratio.
    pub ratio: f64,
    /// Standard deviation of its logarithm: of a condition's true ratio, not of one more measurement.
    pub log_std: f64,
    /// Ends of the 95 % interval.
    pub interval: [f64; 2],
    /// The pressure lies outside the measured ones.
    pub outside_measured_range: bool,
}

/// Estimates the discrepancy of `points`.
///
/// # Errors
/// [`FitError`] if a number has no meaning or there are fewer points than coefficients.
pub fn estimate_discrepancy(
    points: &[RatioPoint],
    form: DiscrepancyForm,
    modulus_relative_std: f64,
) -> Result<Discrepancy, FitError> {
    for (number, point) in points.iter().enumerate() {
        for (quantity, value) in [
            ("pressure_pa", point.pressure_pa),
            ("measured ratio", point.measured),
            ("standard deviation of the ratio", point.measured_std),
            ("modelled ratio", point.modelled),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(FitError::Measurement { number: number + 1, quantity, value });
            }
        }
    }
    let needed = match form {
        DiscrepancyForm::Constant => 1,
        DiscrepancyForm::Linear => 2,
    };
    let count = points.len();
    if count < needed {
        return Err(FitError::NoMeasurement);
    }
    let reference_pressure_pa = points.iter().map(|point| point.pressure_pa).sum::<f64>() / count as f64;
    let design = DMatrix::from_fn(count, needed, |i, j| {
        if j == 0 { 1.0 } else { (points[i].pressure_pa - reference_pressure_pa) / reference_pressure_pa }
    });
    let logarithm = DVector::from_fn(count, |i, _| (points[i].measured / points[i].modelled).ln());
    let variance = |i: usize| (points[i].measured_std / points[i].measured).powi(2);
    let solve = |tau_square: f64| {
        let weight = |i: usize| 1.0 / (variance(i) + tau_square);
        let weighted = DMatrix::from_fn(count, needed, |i, j| weight(i) * design[(i, j)]);
        let inverse = weighted.tr_mul(&design).try_inverse()?;
        let coefficients = &inverse * weighted.tr_mul(&logarithm);
        let residual = &logarithm - &design * &coefficients;
        let chi_square: f64 = (0..count).map(|i| weight(i) * residual[i] * residual[i]).sum();
        Some((coefficients, inverse, chi_square, weighted))
    };
    let singular = FitError::OutOfRange {
        quantity: "number of different pressures",
        value: 1.0,
        expected: "two or more for a discrepancy linear in pressure",
    };
    let degrees_of_freedom = count - needed;
    let (_, _, chi_square, _) = solve(0.0).ok_or_else(|| singular.clone())?;
    let tau_square = scatter(degrees_of_freedom, |tau_square| solve(tau_square).map_or(0.0, |found| found.2));
    let (coefficients, inverse, _, weighted) = solve(tau_square).ok_or(singular)?;
    let sensitivity = DVector::from_fn(count, |i, _| points[i].modulus_sensitivity);
    let modulus_sensitivity = &inverse * weighted.tr_mul(&sensitivity);
    let pressures = || points.iter().map(|point| point.pressure_pa);
    Ok(Discrepancy {
        coefficients: coefficients.iter().copied().collect(),
        covariance: (0..needed).map(|i| inverse.row(i).iter().copied().collect()).collect(),
        reference_pressure_pa,
        scatter: tau_square.sqrt(),
        modulus_sensitivity: modulus_sensitivity.iter().copied().collect(),
        modulus_relative_std,
        pressure_range_pa: [pressures().fold(f64::INFINITY, f64::min), pressures().fold(0.0, f64::max)],
        chi_square,
        degrees_of_freedom,
    })
}

/// tau^2 at which the weighted squares are as many as the degrees of freedom; zero where they are fewer
/// without it. `squares` falls with tau.
fn scatter(degrees_of_freedom: usize, squares: impl Fn(f64) -> f64) -> f64 {
    let wanted = degrees_of_freedom as f64;
    if degrees_of_freedom == 0 || squares(0.0) <= wanted {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while squares(high) > wanted {
        high *= 4.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if squares(middle) > wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

impl Discrepancy {
    /// What the coefficients are multiplied by at `pressure_pa`: 1 and, where the form is linear, (P - P0) / P0.
    #[must_use]
    pub fn row(&self, pressure_pa: f64) -> Vec<f64> {
        let x = (pressure_pa - self.reference_pressure_pa) / self.reference_pressure_pa;
        [1.0, x].into_iter().take(self.coefficients.len()).collect()
    }

    /// The discrepancy `share` of the way from this one to `other`, which rests on samples of its own: the logarithm of the
    /// factor is linear in between. `None` where one is linear in pressure and the other is not.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f64) -> Option<Self> {
        if self.coefficients.len() != other.coefficients.len() {
            return None;
        }
        let (first, second) = (self, other.about(self.reference_pressure_pa));
        let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
        let all = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| mix(*a, *b)).collect::<Vec<f64>>();
        // cov((1 - t) a + t b) = (1 - t)^2 cov(a) + t^2 cov(b)
        let covariance = first.covariance.iter().zip(&second.covariance).map(|(left, right)| {
            left.iter().zip(right).map(|(a, b)| (1.0 - share).powi(2) * a + share.powi(2) * b).collect()
        });
        let ([from, to], [other_from, other_to]) = (first.pressure_range_pa, second.pressure_range_pa);
        Some(Self {
            coefficients: all(&first.coefficients, &second.coefficients),
            covariance: covariance.collect(),
            reference_pressure_pa: first.reference_pressure_pa,
            scatter: mix(first.scatter, second.scatter),
            modulus_sensitivity: all(&first.modulus_sensitivity, &second.modulus_sensitivity),
            modulus_relative_std: first.modulus_relative_std,
            // What both were measured at.
            pressure_range_pa: [from.max(other_from), to.min(other_to)],
            chi_square: first.chi_square + second.chi_square,
            degrees_of_freedom: first.degrees_of_freedom.min(second.degrees_of_freedom),
        })
    }

    /// The same with another reference pressure P1: a + b (P - P0) / P0 = (a + b (P1 - P0) / P0) + (b P1 / P0) (P - P1) / P1.
    fn about(&self, reference_pressure_pa: f64) -> Self {
        if self.coefficients.len() < 2 {
            return Self { reference_pressure_pa, ..self.clone() };
        }
        let row = self.row(reference_pressure_pa);
        let rows = [row, vec![0.0, reference_pressure_pa / self.reference_pressure_pa]];
        let moved = |values: &[f64]| rows.iter().map(|row| dot(row, values)).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = self.covariance.iter().map(|line| moved(line)).collect();
        let covariance = rows
            .iter()
            .map(|row| (0..2).map(|j| row.iter().zip(&columns).map(|(x, line)| x * line[j]).sum()).collect());
        Self {
            coefficients: moved(&self.coefficients),
            covariance: covariance.collect(),
            modulus_sensitivity: moved(&self.modulus_sensitivity),
            reference_pressure_pa,
            ..self.clone()
        }
    }

    /// The factor on a modelled ratio at `pressure_pa`.
    #[must_use]
    pub fn factor(&self, pressure_pa: f64) -> f64 {
        dot(&self.row(pressure_pa), &self.coefficients).exp()
    }

    /// How the logarithm of the factor falls with ln E at `pressure_pa`: what a stiffer surface would have left the fit
    /// less to correct.
    #[must_use]
    pub fn modulus_sensitivity_at(&self, pressure_pa: f64) -> f64 {
        dot(&self.row(pressure_pa), &self.modulus_sensitivity)
    }

    /// A modelled ratio, corrected. `modulus_sensitivity` is d ln(modelled) / d ln(E).
    #[must_use]
    pub fn correct(&self, pressure_pa: f64, modelled: f64, modulus_sensitivity: f64) -> RatioInterval {
        let row = self.row(pressure_pa);
        let of_fit: f64 = self.covariance.iter().zip(&row).map(|(line, x)| x * dot(line, &row)).sum();
        let of_modulus = (modulus_sensitivity - self.modulus_sensitivity_at(pressure_pa)) * self.modulus_relative_std;
        let variance = of_fit + self.scatter.powi(2) + of_modulus.powi(2);
        let student = Confidence::PERCENT_95.student_t(self.degrees_of_freedom);
        let outside = self.is_outside_measured_range(pressure_pa);
        interval(modelled * self.factor(pressure_pa), variance.sqrt(), student, outside)
    }

    /// Whether the patterned samples were measured at lower or higher pressures than `pressure_pa` only.
    #[must_use]
    pub fn is_outside_measured_range(&self, pressure_pa: f64) -> bool {
        let [from, to] = self.pressure_range_pa;
        // A pressure within a part in a million of an end counts as that end.
        pressure_pa < from * (1.0 - 1e-6) || pressure_pa > to * (1.0 + 1e-6)
    }
}

/// A modelled ratio as it is, with what Young's modulus leaves open.
#[must_use]
pub fn uncorrected(modelled: f64, modulus_sensitivity: f64, modulus_relative_std: f64) -> RatioInterval {
    interval(modelled, (modulus_sensitivity * modulus_relative_std).abs(), 1.959_964, false)
}

fn interval(ratio: f64, log_std: f64, student: f64, outside_measured_range: bool) -> RatioInterval {
    let reach = (student * log_std).exp();
    RatioInterval { ratio, log_std, interval: [ratio / reach, ratio * reach], outside_measured_range }
}

/// Every point predicted by the discrepancy of all others; the measured ratio's own error is added, so that
/// the interval is one for the measured number. `None` where the others are too few.
#[must_use]
pub fn leave_one_out(
    points: &[RatioPoint],
    form: DiscrepancyForm,
    modulus_relative_std: f64,
) -> Vec<Option<RatioInterval>> {
    (0..points.len())
        .map(|left| {
            let others: Vec<RatioPoint> =
                points.iter().enumerate().filter(|(i, _)| *i != left).map(|(_, point)| *point).collect();
            let found = estimate_discrepancy(&others, form, modulus_relative_std).ok()?;
            if found.degrees_of_freedom == 0 {
                return None;
            }
            let point = &points[left];
            let true_ratio = found.correct(point.pressure_pa, point.modelled, point.modulus_sensitivity);
            let log_std = true_ratio.log_std.hypot(point.measured_std / point.measured);
            let student = Confidence::PERCENT_95.student_t(found.degrees_of_freedom);
            Some(interval(true_ratio.ratio, log_std, student, true_ratio.outside_measured_range))
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_noise::Noise;

    fn points(count: usize, tau: f64, noise: &mut Noise) -> Vec<RatioPoint> {
        (0..count)
            .map(|i| {
                let pressure_pa = 0.5e6 + 2e6 * i as f64 / count as f64;
                let modelled = 0.95 - 0.03e-6 * pressure_pa;
                let clean = modelled * 0.9 * (tau * noise.normal()).exp();
                let measured_std = 0.01;
                let measured = clean + measured_std * noise.normal();
                RatioPoint { pressure_pa, measured, measured_std, modelled, modulus_sensitivity: 0.1 }
            })
            .collect()
    }

    #[test]
    fn equal_weights_give_the_mean_and_its_error() {
        let mut noise = Noise::new(1);
        let data = points(6, 0.0, &mut noise);
        let found = estimate_discrepancy(&data, DiscrepancyForm::Constant, 0.2).unwrap();
        let weight = |p: &RatioPoint| (p.measured / p.measured_std).powi(2);
        let total: f64 = data.iter().map(weight).sum();
        let mean: f64 = data.iter().map(|p| weight(p) * (p.measured / p.modelled).ln()).sum::<f64>() / total;
        if found.scatter == 0.0 {
            assert!(
                (found.coefficients[0] - mean).abs() < 1e-12 && (found.covariance[0][0] * total - 1.0).abs() < 1e-9
            );
        }
        assert!((found.factor(1e6) - 0.9).abs() < 0.03);
        // All sensitivities are equal: what the modulus leaves open cancels.
        let inside = found.correct(1e6, 0.9, 0.1).log_std;
        assert!((inside - found.covariance[0][0].sqrt().hypot(found.scatter)).abs() < 1e-12);
        assert!(found.correct(1e6, 0.9, 0.4).log_std > 0.3 * 0.2);
        assert!((uncorrected(0.9, 0.1, 0.2).log_std - 0.02).abs() < 1e-15);
    }

    #[test]
    fn scatter_and_coverage_over_many_replicates() {
        const REPLICATES: usize = 200;
        let mut noise = Noise::new(9);
        let (mut covered, mut left_out, mut scatter) = (0, 0, 0.0);
        for _ in 0..REPLICATES {
            let data = points(12, 0.05, &mut noise);
            let found = estimate_discrepancy(&data, DiscrepancyForm::Constant, 0.0).unwrap();
            scatter += found.scatter / REPLICATES as f64;
            let reach = Confidence::PERCENT_95.student_t(11) * found.covariance[0][0].sqrt();
            covered += usize::from((found.coefficients[0] - 0.9_f64.ln()).abs() < reach);
            let predicted = leave_one_out(&data, DiscrepancyForm::Constant, 0.0);
            left_out += predicted
                .iter()
                .zip(&data)
                .filter(|(found, point)| {
                    let [from, to] = found.unwrap().interval;
                    (from..=to).contains(&point.measured)
                })
                .count();
        }
        // 95 % of 200 is 190 +- 3.1; the twelve of one replicate are nearly independent.
        assert!((181..=199).contains(&covered), "{covered}");
        let share = left_out as f64 / (12 * REPLICATES) as f64;
        assert!((share - 0.95).abs() < 0.02, "{share}");
        assert!((scatter / 0.05 - 1.0).abs() < 0.06, "{scatter}");
    }

    #[test]
    fn a_line_in_pressure_is_recovered() {
        let data: Vec<RatioPoint> = [0.6e6, 1.2e6, 1.8e6, 2.4e6]
            .map(|pressure_pa| RatioPoint {
                pressure_pa,
                measured: 0.9 * (-0.1 + 0.05 * (pressure_pa - 1.5e6) / 1.5e6_f64).exp(),
                measured_std: 0.01,
                modelled: 0.9,
                modulus_sensitivity: 0.0,
            })
            .to_vec();
        let found = estimate_discrepancy(&data, DiscrepancyForm::Linear, 0.2).unwrap();
        assert!((found.coefficients[0] + 0.1).abs() < 1e-12 && (found.coefficients[1] - 0.05).abs() < 1e-12);
        assert!(found.scatter == 0.0 && found.correct(3e6, 0.9, 0.0).outside_measured_range);
        let same = vec![data[0]; 3];
        assert!(matches!(estimate_discrepancy(&same, DiscrepancyForm::Linear, 0.2), Err(FitError::OutOfRange { .. })));
        assert!(matches!(estimate_discrepancy(&[], DiscrepancyForm::Constant, 0.2), Err(FitError::NoMeasurement)));
    }

    #[test]
    fn points_of_students_t() {
        for (n, t) in [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (10, 2.228), (30, 2.042)] {
            assert!(
                (Confidence::PERCENT_95.student_t(n) - t).abs() < 0.01,
                "{n}: {}",
                Confidence::PERCENT_95.student_t(n)
            );
        }
    }

    #[test]
    fn between_two_the_factor_is_linear_in_its_logarithm_and_errors_are_shared() {
        let points = |at: [f64; 4], measured: [f64; 4]| -> Vec<RatioPoint> {
            let point = |(pressure_mpa, measured): (f64, f64)| RatioPoint {
                pressure_pa: pressure_mpa * 1e6,
                measured,
                measured_std: 0.01,
                modelled: 0.95,
                modulus_sensitivity: 0.05 * pressure_mpa,
            };
            at.into_iter().zip(measured).map(point).collect()
        };
        let dry = points([0.6, 1.2, 1.8, 2.4], [0.80, 0.84, 0.79, 0.83]);
        let humid = points([0.8, 1.4, 2.0, 3.2], [0.70, 0.76, 0.72, 0.69]);
        for form in [DiscrepancyForm::Constant, DiscrepancyForm::Linear] {
            let [a, b] = [&dry, &humid].map(|points| estimate_discrepancy(points, form, 0.2).unwrap());
            let between = a.towards(&b, 0.25).unwrap();
            for pressure_pa in [0.7e6, 1.5e6, 3e6] {
                let [own, left, right] = [&between, &a, &b].map(|of| of.factor(pressure_pa).ln());
                assert!((own - 0.75 * left - 0.25 * right).abs() < 1e-12);
                // Independent errors of the fits, with their shares; what a stiffer surface takes away likewise.
                let variance = |of: &Discrepancy| {
                    let row = of.row(pressure_pa);
                    of.covariance.iter().zip(&row).map(|(line, x)| x * dot(line, &row)).sum::<f64>()
                };
                let expected = 0.75_f64.powi(2) * variance(&a) + 0.25_f64.powi(2) * variance(&b);
                assert!((variance(&between) / expected - 1.0).abs() < 1e-9);
                let [own, left, right] = [&between, &a, &b].map(|of| of.modulus_sensitivity_at(pressure_pa));
                assert!((own - 0.75 * left - 0.25 * right).abs() < 1e-12);
            }
            assert_eq!(between.pressure_range_pa, [0.8e6, 2.4e6]);
            assert!((between.scatter - 0.75 * a.scatter - 0.25 * b.scatter).abs() < 1e-12);
        }
        let constant = estimate_discrepancy(&dry, DiscrepancyForm::Constant, 0.2).unwrap();
        assert_eq!(constant.towards(&estimate_discrepancy(&humid, DiscrepancyForm::Linear, 0.2).unwrap(), 0.5), None);
    }
}
