//! Contact problems with closed-form solutions, for quick estimates.

use std::f64::consts::SQRT_2;

use crate::contact::ContactError;
use crate::contact::error::require_within;

/// Real contact area fraction of a self-affine surface, erf(sqrt 2 P / (E* h'rms)).
///
/// Diffusion theory of B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001). The rms slope is the only property of the
/// surface that enters. At light loads the area rises more slowly with pressure than computed areas do, so the formula
/// does not replace a map.
///
/// # Errors
/// [`ContactError::OutOfRange`] if the pressure is negative, or the modulus or slope is not positive.
pub fn persson_area_fraction(pressure_pa: f64, contact_modulus_pa: f64, rms_slope: f64) -> Result<f64, ContactError> {
    require_within("pressure", pressure_pa, 0.0..=1e30, "a number not below zero")?;
    require_within("contact modulus", contact_modulus_pa, 1e-30..=1e30, "a positive number")?;
    require_within("rms slope", rms_slope, 1e-30..=1e30, "a positive number")?;
    Ok(libm::erf(SQRT_2 * (pressure_pa / contact_modulus_pa / rms_slope)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_the_theory() {
        // Light loads: A = sqrt(8/pi) P / (E* h'rms)
        let light = persson_area_fraction(1e2, 427.5e6, 0.0137).unwrap();
        assert!((light / ((8.0 / std::f64::consts::PI).sqrt() * 1e2 / (427.5e6 * 0.0137)) - 1.0).abs() < 1e-8);
        assert_eq!(persson_area_fraction(1e9, 427.5e6, 0.0137).unwrap(), 1.0);
        assert_eq!(persson_area_fraction(0.0, 427.5e6, 0.0137).unwrap(), 0.0);
        assert!(persson_area_fraction(1e6, 427.5e6, 0.0).unwrap_err().to_string().contains("rms slope is 0"));
    }
}
