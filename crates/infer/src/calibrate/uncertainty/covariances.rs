//! Covariances of uncertain numbers of a material and of the model.

use slipgrid_model::material::{AreaLaw, MaterialError};
use slipgrid_model::springblock::Load;

/// Covariance matrix as rows.
pub type Covariance = Vec<Vec<f64>>;

/// Covariance of the relative errors of flat friction mu_d f (local coefficient times area factor) at `loads` and,
/// last, of the logarithm of the law's scale s. `known` is the covariance of ln mu_d and ln s:
/// d ln(mu_d f) = d ln(mu_d) + (d ln f / d ln s) d ln s.
///
/// # Errors
/// [`MaterialError`] if the law cannot be shifted.
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

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::material::LocalFriction;

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
                // Below its first pressure the law continues along its first chord, so that its slope deviates by half
                // a hundredth.
                assert!((covariance[i][j] - expected).abs() < 4e-6, "{i} {j}: {} {expected}", covariance[i][j]);
            }
        }
    }
}
