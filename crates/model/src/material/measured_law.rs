//! Measured flat friction as the law of local friction: mu(p) = mu_flat(P = p).
//!
//! In the area law, friction of a contact grows less than its load, because real contact area grows less than load. If
//! flat friction nevertheless rises with nominal pressure, the fitted mu_d rises with load. The alternative
//! interpretation of these measurements is that friction depends on local pressure as it does on nominal pressure.
//! Under the edges of cavities friction is then higher instead of lower. Flat samples alone cannot distinguish the two
//! interpretations.

use crate::material::error::{positive, same_length};
use crate::material::{AreaLaw, MaterialError};

/// Extrapolation of a measured law above its last pressure; below the first pressure it is constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extrapolation {
    /// Constant, as at the last pressure.
    Constant,
    /// Linear in the logarithm of pressure, through the first and last measured points, and not below zero.
    Logarithmic,
}

slipgrid_base::names!(Extrapolation { Constant = "constant", Logarithmic = "logarithmic" });

/// Maximum tabulated local pressure, in pascals; no polymer carries a higher pressure.
const MAX_PRESSURE_PA: f64 = 1e9;
/// Number of tabulated pressures above the last measured one, in geometric progression.
const EXTRAPOLATED_POINTS: u32 = 64;

impl AreaLaw {
    /// Computes the factors f(p) = mu(p) / mu(P1), P1 being the first pressure, from flat friction `mu_flat` measured
    /// at the increasing pressures `pressure_pa`: linear between measurements, 1 below the first, and by
    /// `extrapolation` above the last.
    ///
    /// # Errors
    /// [`MaterialError`] if pressures do not increase from a positive first pressure, or a coefficient is not positive.
    pub fn from_flat_friction(
        pressure_pa: &[f64],
        mu_flat: &[f64],
        extrapolation: Extrapolation,
    ) -> Result<Self, MaterialError> {
        same_length("measured law", pressure_pa.len(), mu_flat.len())?;
        for &mu in mu_flat {
            positive("measured flat friction", mu)?;
        }
        let (Some((&first_pa, &last_pa)), Some((&first, &last))) =
            (pressure_pa.first().zip(pressure_pa.last()), mu_flat.first().zip(mu_flat.last()))
        else {
            return Self::new(Vec::new(), Vec::new());
        };
        // mu(p) = mu_n + (mu_n - mu_1) ln(p / P_n) / ln(P_n / P_1)
        let slope = match extrapolation {
            Extrapolation::Logarithmic if last_pa > first_pa => (last - first) / (last_pa / first_pa).ln(),
            _ => 0.0,
        };
        let (mut pressures, mut factors) =
            (pressure_pa.to_vec(), mu_flat.iter().map(|mu| mu / first).collect::<Vec<_>>());
        let reach = (MAX_PRESSURE_PA / last_pa).ln();
        for point in 1..=EXTRAPOLATED_POINTS {
            let log = reach * f64::from(point) / f64::from(EXTRAPOLATED_POINTS);
            if log > 0.0 {
                pressures.push(last_pa * log.exp());
                factors.push(((last + slope * log) / first).max(0.0));
            }
        }
        Self::new(pressures, factors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_at_a_local_pressure_is_that_of_the_flat_sample_at_it() {
        let pressure_pa = [0.6e6, 1.3e6, 2.6e6];
        let mu = [0.248, 0.263, 0.278];
        for extrapolation in Extrapolation::ALL {
            let law = AreaLaw::from_flat_friction(&pressure_pa, &mu, extrapolation).unwrap();
            for (p, mu) in pressure_pa.iter().zip(mu) {
                assert!((0.248 * law.factor(*p) - mu).abs() < 1e-12);
            }
            assert!((0.248 * law.factor(1.95e6) - 0.2705).abs() < 1e-12);
            assert_eq!(law.factor(0.1e6), 1.0);
        }
        let at =
            |extrapolation| AreaLaw::from_flat_friction(&pressure_pa, &mu, extrapolation).unwrap().factor(26e6) * 0.248;
        assert!((at(Extrapolation::Constant) - 0.278).abs() < 1e-9);
        let expected = 0.278 + 0.030 * 10.0_f64.ln() / (2.6_f64 / 0.6).ln();
        assert!((at(Extrapolation::Logarithmic) - expected).abs() < 1e-4, "{}", at(Extrapolation::Logarithmic));
        let one = AreaLaw::from_flat_friction(&[1e6], &[0.3], Extrapolation::Logarithmic).unwrap();
        assert!((one.factor(5e6) - 1.0).abs() < 1e-12);
        assert!(AreaLaw::from_flat_friction(&[], &[], Extrapolation::Constant).is_err());
        assert!(AreaLaw::from_flat_friction(&[1e6, 2e6], &[0.3, 0.0], Extrapolation::Constant).is_err());
        assert!(AreaLaw::from_flat_friction(&[1e6], &[0.3, 0.2], Extrapolation::Constant).is_err());
    }
}
