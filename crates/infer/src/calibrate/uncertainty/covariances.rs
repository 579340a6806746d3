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
pub mod tests {
    use super::*;
    use slipgrid_model::material::LocalFriction;

    /// Area law of the contact area A = 1 - exp(-P / S) from `threshold_pa` on, with S = `scale_pa`, up to 30 MPa.
    pub fn exponential_law(scale_pa: f64, threshold_pa: f64) -> AreaLaw {
        let pressure_pa: Vec<f64> = (1..1500).map(|i| 0.02e6 * f64::from(i)).collect();
        let area: Vec<f64> = pressure_pa.iter().map(|p| 1.0 - (-p / scale_pa).exp()).collect();
        AreaLaw::from_area_curve(&pressure_pa, &area, threshold_pa).unwrap()
    }

    /// d ln f / d ln S = g(P0) - g(P) of this law, with g(x) = -x e^-x / (1 - e^-x) at x = P / S.
    pub fn g(x: f64) -> f64 {
        -x * (-x).exp() / (1.0 - (-x).exp())
    }

    #[test]
    fn flat_friction_is_off_with_the_coefficient_and_with_the_scale() {
        let scale_pa = 5e6;
        let law = exponential_law(scale_pa, 0.7e6);
        let friction = LocalFriction::new(0.3, 0.27, 0.05).unwrap();
        let loads = [0.5e6, 1.3e6, 2.6e6].map(|pressure_pa| Load { pressure_pa, friction });
        let known = [[4e-4, -1.5e-4], [-1.5e-4, 1e-2]];
        let covariance = with_scale(&known, &law, &loads).unwrap();
        let g = |pressure_pa: f64| g(pressure_pa / scale_pa);
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
