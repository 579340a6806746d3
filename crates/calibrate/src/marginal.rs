//! Errors of local coefficients that do not take the area law for known.
//!
//! Measured is flat friction mu_flat = mu_d f(P): the coefficient mu_d is off by what the measurement is off, and by what f
//! is off at its pressure, because Young's modulus or the law's own factors are.

use slipgrid_material::{AreaLaw, MaterialError};

/// A measured load behind a coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatLoad {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// How much it counts in the coefficient: 1 where it is the only one.
    pub weight: f64,
}

/// Standard deviation of mu_d over itself, where it is `conditional` at a given `law`, the logarithm of Young's modulus has
/// the standard deviation `log_modulus_std`, and the law carries its own errors. `loads` are those that the coefficient was
/// fitted to.
///
/// # Errors
/// [`MaterialError`] where the law cannot be moved.
pub fn marginal_relative_std(
    conditional: f64,
    law: &AreaLaw,
    log_modulus_std: f64,
    loads: &[FlatLoad],
) -> Result<f64, MaterialError> {
    let (softer, stiffer) = (law.at_modulus((-log_modulus_std).exp())?, law.at_modulus(log_modulus_std.exp())?);
    let off = law.with_factors_off_by(1.0);
    let total: f64 = loads.iter().map(|load| load.weight).sum();
    let mean =
        |of: &dyn Fn(f64) -> f64| loads.iter().map(|load| load.weight * of(load.pressure_pa)).sum::<f64>() / total;
    // d ln mu_d = -d ln f
    let of_modulus = mean(&|at_pa| 0.5 * (softer.factor(at_pa) / stiffer.factor(at_pa)).ln());
    let of_law = mean(&|at_pa| (off.factor(at_pa) / law.factor(at_pa)).ln());
    Ok(conditional.hypot(of_modulus).hypot(of_law))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_is_off_by_what_the_factor_at_its_pressure_is() {
        // A = 1 - exp(-P / S), S as Young's modulus: d ln f / d ln E = g(P0) - g(P), g = -x e^-x / (1 - e^-x) at x = P / S.
        let pressure_pa: Vec<f64> = (1..600).map(|i| 0.05e6 * f64::from(i)).collect();
        let area: Vec<f64> = pressure_pa.iter().map(|p| 1.0 - (-p / 4e6_f64).exp()).collect();
        let law = AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap();
        let g = |pressure_pa: f64| {
            let x = pressure_pa / 4e6;
            -x * (-x).exp() / (1.0 - (-x).exp())
        };
        let at = |pressure_pa: f64, weight: f64| FlatLoad { pressure_pa, weight };
        let one = marginal_relative_std(0.01, &law, 0.2, &[at(5e6, 1.0)]).unwrap();
        let none = marginal_relative_std(0.01, &law, 0.2, &[at(0.3e6, 1.0)]).unwrap();
        let known = marginal_relative_std(0.01, &law, 0.0, &[at(5e6, 1.0)]).unwrap();
        let slope = |found: f64| (found * found - 1e-4).max(0.0).sqrt() / 0.2;
        assert!((known - 0.01).abs() < 1e-12 && slope(none) < 1e-6, "{known} {none}");
        assert!((slope(one) / (g(5e6) - g(0.7e6)).abs() - 1.0).abs() < 0.03, "{one}");
        let both = marginal_relative_std(0.01, &law, 0.2, &[at(5e6, 3.0), at(0.3e6, 1.0)]).unwrap();
        assert!((slope(both) / slope(one) - 0.75).abs() < 1e-3, "{both}");
        let factor_std = law.factors().iter().map(|f| 0.03 * f).collect();
        let errors = law.with_factor_std(factor_std).unwrap();
        let wide = marginal_relative_std(0.01, &errors, 0.0, &[at(5e6, 1.0)]).unwrap();
        assert!((wide - 0.01_f64.hypot(1.03_f64.ln())).abs() < 1e-3, "{wide}");
    }
}
