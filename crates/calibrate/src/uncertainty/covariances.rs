//! Covariances of what is not known exactly of a material and of the model.

use slipgrid_material::{AreaLaw, MaterialError};
use slipgrid_springblock::Load;

use crate::Discrepancy;

/// Row by row.
pub type Covariance = Vec<Vec<f64>>;

/// Covariance of the relative errors of flat friction mu_d f at `loads` and of the logarithm of the law's scale, from that
/// of mu_d and the scale: d ln(mu_d f) = d ln(mu_d) + (d ln f / d ln s) d ln s.
///
/// # Errors
/// [`MaterialError`] where the law cannot be moved.
pub fn with_scale(known: &[[f64; 2]; 2], law: &AreaLaw, loads: &[Load]) -> Result<Covariance, MaterialError> {
    const STEP: f64 = 0.02;
    let at = |log_scale: f64| law.at_modulus(log_scale.exp());
    let (less, more) = (at(-STEP)?, at(STEP)?);
    let slope = |load: &Load| (more.factor(load.pressure_pa).ln() - less.factor(load.pressure_pa).ln()) / (2.0 * STEP);
    let rows: Vec<[f64; 2]> = loads.iter().map(|load| [1.0, slope(load)]).chain([[0.0, 1.0]]).collect();
    let entry = |left: &[f64; 2], right: &[f64; 2]| {
        (0..2).map(|i| (0..2).map(|j| left[i] * known[i][j] * right[j]).sum::<f64>()).sum()
    };
    Ok(rows.iter().map(|left| rows.iter().map(|right| entry(left, right)).collect()).collect())
}

/// Covariance of the logarithmic errors of corrected ratios at `loads`, at a given Young's modulus: of the fitted
/// coefficients and of the scatter between conditions, widened for the few of them as Student's t is.
#[must_use]
pub fn log_covariance(found: &Discrepancy, loads: &[Load]) -> Covariance {
    let rows: Vec<Vec<f64>> = loads.iter().map(|load| found.row(load.pressure_pa)).collect();
    // The interval's reach over the normal one's.
    let interval = found.correct(found.reference_pressure_pa, 1.0, 0.0);
    let widened = (interval.interval[1] / interval.ratio).ln() / (1.959_964 * interval.log_std);
    let widened = if widened.is_finite() { widened * widened } else { 1.0 };
    let shared = |left: &[f64], right: &[f64]| {
        let of_fit: f64 = found
            .covariance
            .iter()
            .zip(left)
            .map(|(line, l)| l * line.iter().zip(right).map(|(entry, r)| entry * r).sum::<f64>())
            .sum();
        widened * of_fit
    };
    let own = |i: usize, j: usize| if i == j { widened * found.scatter * found.scatter } else { 0.0 };
    (0..rows.len()).map(|i| (0..rows.len()).map(|j| shared(&rows[i], &rows[j]) + own(i, j)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DiscrepancyForm, RatioPoint, estimate_discrepancy};
    use slipgrid_material::LocalFriction;

    fn loads(pressures_mpa: &[f64]) -> Vec<Load> {
        let friction = LocalFriction::new(0.3, 0.27, 0.05).unwrap();
        pressures_mpa.iter().map(|p| Load { pressure_pa: p * 1e6, friction }).collect()
    }

    #[test]
    fn flat_friction_is_off_with_the_coefficient_and_with_the_scale() {
        // A = 1 - exp(-P / S): d ln f / d ln S = g(P0) - g(P), g(x) = -x e^-x / (1 - e^-x) at x = P / S.
        let scale_pa = 5e6;
        let pressure_pa: Vec<f64> = (1..600).map(|i| 0.05e6 * f64::from(i)).collect();
        let area: Vec<f64> = pressure_pa.iter().map(|p| 1.0 - (-p / scale_pa).exp()).collect();
        let law = AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap();
        let loads = loads(&[0.5, 1.3, 2.6]);
        let known = [[4e-4, -1.5e-4], [-1.5e-4, 1e-2]];
        let covariance = with_scale(&known, &law, &loads).unwrap();
        let g = |pressure_pa: f64| {
            let x = pressure_pa / scale_pa;
            -x * (-x).exp() / (1.0 - (-x).exp())
        };
        let slope = |pressure_pa: f64| if pressure_pa < 0.7e6 { 0.0 } else { g(pressure_pa) - g(0.7e6) };
        let rows: Vec<[f64; 2]> = loads.iter().map(|load| [1.0, slope(load.pressure_pa)]).chain([[0.0, 1.0]]).collect();
        for (i, left) in rows.iter().enumerate() {
            for (j, right) in rows.iter().enumerate() {
                let of = |a: usize, b: usize| left[a] * known[a][b] * right[b];
                let expected = of(0, 0) + of(0, 1) + of(1, 0) + of(1, 1);
                // Below its first pressure a law goes on as its first chord: its slope is off by half a hundredth.
                assert!((covariance[i][j] - expected).abs() < 4e-6, "{i} {j}: {} {expected}", covariance[i][j]);
            }
        }
    }

    #[test]
    fn the_discrepancy_reaches_as_far_as_its_own_interval() {
        let points: Vec<RatioPoint> = [0.6e6, 1.2e6, 1.8e6, 2.4e6, 3.0e6]
            .into_iter()
            .zip([0.84, 0.80, 0.86, 0.79, 0.83])
            .map(|(pressure_pa, measured)| RatioPoint {
                pressure_pa,
                measured,
                measured_std: 0.01,
                modelled: 0.95,
                modulus_sensitivity: 0.0,
            })
            .collect();
        for form in [DiscrepancyForm::Constant, DiscrepancyForm::Linear] {
            let found = estimate_discrepancy(&points, form, 0.0).unwrap();
            assert!(found.scatter > 0.0);
            let loads = loads(&[0.6, 1.5, 2.9]);
            let covariance = log_covariance(&found, &loads);
            for (place, load) in loads.iter().enumerate() {
                let own = found.correct(load.pressure_pa, 0.9, 0.0);
                let reach = 1.959_964 * covariance[place][place].sqrt();
                assert!((reach / (own.interval[1] / own.ratio).ln() - 1.0).abs() < 1e-9);
            }
            // What the fit is off is shared between loads, what conditions scatter is not.
            assert!(covariance[0][1] > 0.0 && covariance[0][1] < covariance[0][0].min(covariance[1][1]));
            assert!((covariance[0][2] - covariance[2][0]).abs() < 1e-15);
        }
    }
}
