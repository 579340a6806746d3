//! Standard errors of local coefficients that include the errors of the area law.
//!
//! The measured quantity is flat friction mu_flat = mu_d f(P), local coefficient times area factor. The error of mu_d
//! therefore includes the error of the measurement, and that of f at its pressure, which comes from Young's modulus and
//! from the law's own factors.

use slipgrid_model::material::{AreaLaw, MaterialError};

use crate::calibrate::{Fit, Measurement, Problem};

/// Relative standard deviation of the local coefficient mu_d, including the errors of the area law. `conditional` is
/// the relative standard deviation for a given `law`, `log_modulus_std` the standard deviation of the logarithm of
/// Young's modulus, and `loads` are the measurements from which the coefficient was fitted: pairs of nominal pressure,
/// in pascals, and weight in the coefficient.
///
/// # Errors
/// [`MaterialError`] if the law cannot be shifted.
pub fn marginal_relative_std(
    conditional: f64,
    law: &AreaLaw,
    log_modulus_std: f64,
    loads: &[(f64, f64)],
) -> Result<f64, MaterialError> {
    let (softer, stiffer) = (law.at_modulus((-log_modulus_std).exp())?, law.at_modulus(log_modulus_std.exp())?);
    let shifted = law.with_factors_off_by(1.0);
    let total: f64 = loads.iter().map(|(_, weight)| weight).sum();
    let mean = |value: &dyn Fn(f64) -> f64| {
        loads.iter().map(|(pressure_pa, weight)| weight * value(*pressure_pa)).sum::<f64>() / total
    };
    // d ln mu_d = -d ln f
    let from_modulus = mean(&|at_pa| 0.5 * (softer.factor(at_pa) / stiffer.factor(at_pa)).ln());
    let from_law = mean(&|at_pa| (shifted.factor(at_pa) / law.factor(at_pa)).ln());
    Ok(conditional.hypot(from_modulus).hypot(from_law))
}

impl Fit {
    /// Adds the errors of Young's modulus (given as a relative standard deviation) and of the area law to the errors of
    /// the coefficients. The errors of a fitted scale are already included.
    ///
    /// # Errors
    /// [`MaterialError`] if the law cannot be shifted.
    pub fn include_law_errors(
        &mut self,
        problem: &Problem,
        modulus_relative_std: Option<f64>,
    ) -> Result<(), MaterialError> {
        let log_modulus_std = modulus_relative_std.unwrap_or(0.0);
        let Some(law) = problem.area_law.as_ref().filter(|_| problem.area_law_scale.is_none()) else { return Ok(()) };
        if log_modulus_std == 0.0 && law.factor_std().is_none() {
            return Ok(());
        }
        // Weights in sum [(mu_d f_i - mu_i) / s_i]^2.
        let load = |measured: &Measurement| {
            let pressure_pa = problem.pressure_pa(measured);
            (pressure_pa, (law.factor(pressure_pa) / measured.mu_dynamic_std).powi(2))
        };
        let loads: Vec<(f64, f64)> = problem.measurements.iter().map(load).collect();
        let single = self.pairs.len() == 1;
        for (place, pair) in self.pairs.iter_mut().enumerate() {
            let Some(error) = pair.dynamic_std_error else { continue };
            let own = if single { &loads[..] } else { &loads[place..=place] };
            let relative = marginal_relative_std(error / pair.dynamic_mean, law, log_modulus_std, own)?;
            pair.dynamic_std_error_given_law = Some(error);
            pair.dynamic_std_error = Some(relative * pair.dynamic_mean);
        }
        self.notes.push(
            "dynamic_std_error: with what Young's modulus and the area law leave open of the local coefficient; \
             dynamic_std_error_given_law: at the given law, as flat friction is known, which errors of friction and of ratios are made of"
                .to_owned(),
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::uncertainty::covariances::tests::{exponential_law, g};

    #[test]
    fn a_coefficient_is_off_by_what_the_factor_at_its_pressure_is() {
        // S is proportional to Young's modulus.
        let law = exponential_law(4e6, 0.7e6);
        let g = |pressure_pa: f64| g(pressure_pa / 4e6);
        let one = marginal_relative_std(0.01, &law, 0.2, &[(5e6, 1.0)]).unwrap();
        let none = marginal_relative_std(0.01, &law, 0.2, &[(0.3e6, 1.0)]).unwrap();
        let known = marginal_relative_std(0.01, &law, 0.0, &[(5e6, 1.0)]).unwrap();
        let slope = |found: f64| (found * found - 1e-4).max(0.0).sqrt() / 0.2;
        assert!((known - 0.01).abs() < 1e-12 && slope(none) < 1e-6, "{known} {none}");
        assert!((slope(one) / (g(5e6) - g(0.7e6)).abs() - 1.0).abs() < 0.03, "{one}");
        let both = marginal_relative_std(0.01, &law, 0.2, &[(5e6, 3.0), (0.3e6, 1.0)]).unwrap();
        assert!((slope(both) / slope(one) - 0.75).abs() < 1e-3, "{both}");
        let factor_std = law.factors().iter().map(|f| 0.03 * f).collect();
        let errors = law.with_factor_std(factor_std).unwrap();
        let wide = marginal_relative_std(0.01, &errors, 0.0, &[(5e6, 1.0)]).unwrap();
        assert!((wide - 0.01_f64.hypot(1.03_f64.ln())).abs() < 1e-3, "{wide}");
    }
}
