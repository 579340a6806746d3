//! Units of files and their conversion to SI, with the ranges of accepted numbers.
//!
//! ```text
//! SI = number x factor,     min (<) number <= max
//! ```
//!
//! | item | role |
//! |---|---|
//! | [`Quantity`] | a unit with its factor and range; formatted for error messages |
//! | [`LENGTH_UM`], [`PRESSURE_MPA`] and others | one quantity for each kind of key |
//! | [`LengthUm`], [`SpeedMmS`] and others | serde adapters between SI units and units of files |
//! | [`tidy`] | removes rounding errors of unit conversions |
//! | [`counted`] | number and noun, in the plural if required |
//!
//! This module does not depend on keys or files.
//!
//! ```
//! use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA};
//! assert_eq!(LENGTH_UM.to_si(130.0), 130e-6);
//! assert_eq!(PRESSURE_MPA.from_si(2.6e6), 2.6);
//! // A pressure in pascals where megapascals are asked for is out of range.
//! assert!(!PRESSURE_MPA.accepts(2.6e6));
//! assert_eq!(PRESSURE_MPA.to_string(), "a number above 0 up to 100000 MPa");
//! ```

mod in_files;

pub use in_files::{HumidityPct, InFiles, LengthUm, SpeedMmS, StepNs};

use std::fmt;

/// Conversion of a file's unit to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    /// SI = number x factor.
    Times(f64),
    /// SI = number / divisor: exact where the factor (for example 1e-6) has no exact binary representation.
    Over(f64),
}

/// A quantity in files: its unit and the accepted range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    scale: Scale,
    unit: &'static str,
    min: f64,
    /// Whether the minimum itself is refused.
    above: bool,
    max: f64,
}

impl Quantity {
    const fn new(scale: Scale, unit: &'static str, min: f64, above: bool, max: f64) -> Self {
        Self { scale, unit, min, above, max }
    }

    /// Whether `value`, in the file's unit, is within the range.
    pub fn accepts(&self, value: f64) -> bool {
        value.is_finite() && value <= self.max && if self.above { value > self.min } else { value >= self.min }
    }

    /// Converts `value` to SI units.
    pub fn to_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Times(factor) => value * factor,
            Scale::Over(divisor) => value / divisor,
        }
    }

    /// Converts `si` to the file's unit, rounded to 12 digits, so that a number read from a file is written back
    /// unchanged.
    pub fn from_si(&self, si: f64) -> f64 {
        tidy(match self.scale {
            Scale::Times(factor) => si / factor,
            Scale::Over(divisor) => si * divisor,
        })
    }

    /// Returns the number, in SI units, that is read back after `si` was written to a file with 12 digits.
    pub fn as_written(&self, si: f64) -> f64 {
        self.to_si(self.from_si(si))
    }

    /// This quantity with zero as the accepted minimum.
    #[must_use]
    pub const fn or_zero(mut self) -> Self {
        (self.min, self.above) = (0.0, false);
        self
    }

    /// This quantity with the maximum `max`, in the file's unit.
    #[must_use]
    pub const fn at_most(mut self, max: f64) -> Self {
        self.max = max;
        self
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = if self.above { "above" } else { "from" };
        write!(f, "a number {from} {} up to {}", self.min, self.max)?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// Lengths of patterns and layers: from a picometre, far below an atom, to 10 m, which detects metres given instead of
/// micrometres.
pub const LENGTH_UM: Quantity = Quantity::new(Scale::Over(1e6), "um", 1e-6, false, 1e7);
/// Sides of pixels, from a ten-thousandth of a nanometre: no map has smaller pixels.
pub const PIXEL_UM: Quantity = Quantity { min: 1e-7, above: false, ..LENGTH_UM };
/// Standard deviations of lengths.
pub const LENGTH_STD_UM: Quantity = LENGTH_UM.or_zero();
/// Heights of rims, and standard deviations of these heights.
pub const RIM_HEIGHT_UM: Quantity = LENGTH_UM.or_zero().at_most(1000.0);
/// Correlation coefficients, from -1 to 1.
pub const CORRELATION: Quantity = Quantity::new(Scale::Times(1.0), "", -1.0, false, 1.0);
/// Lengths of specimens, from a nanometre.
pub const LENGTH_MM: Quantity = Quantity::new(Scale::Over(1e3), "mm", 1e-6, false, 1e4);
/// Nominal pressures, up to the yield pressure of diamond, 100 GPa.
pub const PRESSURE_MPA: Quantity = Quantity::new(Scale::Times(1e6), "MPa", 0.0, true, 1e5);
/// Maximum Young's modulus in files: diamond has 1220 GPa.
pub const MAX_MODULUS_GPA: f64 = 1250.0;
/// Young's moduli.
pub const MODULUS_GPA: Quantity = Quantity::new(Scale::Times(1e9), "GPa", 0.0, true, MAX_MODULUS_GPA);
/// Standard deviations of Young's modulus.
pub const MODULUS_STD_GPA: Quantity = MODULUS_GPA.or_zero();
/// Maximum density in files: osmium has 22.6 g/cm3.
pub const MAX_DENSITY_G_CM3: f64 = 23.0;
/// Densities.
pub const DENSITY_G_CM3: Quantity = Quantity::new(Scale::Times(1e3), "g/cm3", 0.0, true, MAX_DENSITY_G_CM3);
/// Sliding speeds.
pub const SPEED_MM_S: Quantity = Quantity::new(Scale::Over(1e3), "mm/s", 0.0, true, 1e5);
/// Relative humidity.
pub const HUMIDITY_PCT: Quantity = Quantity::new(Scale::Over(1e2), "%", 0.0, false, 100.0);
/// Normal forces.
pub const FORCE_N: Quantity = Quantity::new(Scale::Times(1.0), "N", 0.0, true, 1e7);
/// Friction coefficients, from above 0 to 10.
pub const FRICTION: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, true, 10.0);
/// Standard deviations of friction coefficients.
pub const FRICTION_STD: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 10.0);
/// Standard deviations of local friction coefficients over their means; above one half the negative tail of the
/// Gaussian matters.
pub const RELATIVE_STD: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 0.5);
/// Factors f(P) of the area law: real contact area relative to growth in proportion to pressure; dimensionless.
pub const FACTOR: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 10.0);
/// Standard errors of the area law's factors.
pub const FACTOR_STD: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 10.0);
/// Fractions of the nominal area that are in real contact, from 0 to 1.
pub const FRACTION: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 1.0);
/// Ratios of dynamic to steady friction.
pub const EXCESS: Quantity = Quantity::new(Scale::Times(1.0), "", 0.1, true, 10.0);
/// Friction ratios, patterned over flat.
pub const RATIO: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, true, 5.0);
/// Half-widths of target bands, and requested standard errors of friction coefficients.
pub const TOLERANCE: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, true, 1.0);
/// Fractions of a stroke, above zero.
pub const STROKE_SHARE: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, true, 1.0);
/// Weights of values in a mean.
pub const WEIGHT: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, true, 1e6);
/// Rms slopes of surfaces: below the minimum all surfaces are in full contact, above the maximum none has been
/// measured.
pub const SLOPE: Quantity = Quantity::new(Scale::Times(1.0), "", 1e-7, false, 10.0);
/// Damping frequency over sqrt(k/m), k the stiffness of a spring and m the mass of a block.
pub const DAMPING: Quantity = Quantity::new(Scale::Times(1.0), "", 0.0, false, 2.0);
/// Times in a friction test.
pub const TIME_S: Quantity = Quantity::new(Scale::Times(1.0), "s", 0.0, false, 1e6);
/// Time steps.
pub const STEP_NS: Quantity = Quantity::new(Scale::Over(1e9), "ns", 0.0, true, 1e6);
/// Poisson's ratios of an isotropic solid.
pub const POISSON: Quantity = Quantity::new(Scale::Times(1.0), "", -1.0, true, 0.5);
/// Angles of grooves from the direction across the specimen's X axis: a rotation by 180 degrees changes nothing.
pub const GROOVE_ANGLE_DEG: Quantity = Quantity::new(Scale::Times(1.0), "degrees", -90.0, false, 90.0);
/// Angles between two families of grooves.
pub const CROSSING_ANGLE_DEG: Quantity = Quantity::new(Scale::Times(1.0), "degrees", 10.0, false, 90.0);
/// Angles of the sliding direction from the specimen's X axis.
pub const SLIDING_ANGLE_DEG: Quantity = Quantity::new(Scale::Times(1.0), "degrees", -180.0, false, 180.0);
/// Angles of walls from vertical.
pub const WALL_TAPER_DEG: Quantity = Quantity::new(Scale::Times(1.0), "degrees", 0.0, false, 80.0);
/// Positive laser settings, each in its own unit; a value below a millionth has no effect.
pub const POSITIVE: Quantity = Quantity::new(Scale::Times(1.0), "", 1e-6, false, 1e12);

/// Rounds `value` to 12 significant digits, which removes rounding errors of unit conversions.
pub fn tidy(value: f64) -> f64 {
    significant(value, 12)
}

/// Relative difference up to which two stated numbers (forces, pressures, speeds, humidities) are equal: files round to
/// 6 to 12 digits, and no two settings of a tribometer are so close.
pub const SAME: f64 = 1e-6;

/// Whether two stated numbers are equal, within [`SAME`].
pub fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// `count` and `noun`, in the plural unless `count` is 1.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = match noun {
        _ if count == 1 => "",
        _ if noun.ends_with('s') => "es",
        _ => "s",
    };
    format!("{count} {noun}{plural}")
}

/// Rounds `value` to `digits` significant digits.
pub fn significant(value: f64, digits: usize) -> f64 {
    if value.is_finite() { format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value) } else { value }
}

/// Formats `value` with all digits that it needs; magnitudes below 1e-9 and from 1e16 on have an exponent.
pub fn in_digits(value: f64) -> String {
    let is_plain = value == 0.0 || (1e-9..1e16).contains(&value.abs());
    if is_plain { value.to_string() } else { format!("{value:e}") }
}

/// Rounds a positive `value` to `digits` significant digits with `to`: `f64::ceil` rounds up, `f64::floor` down.
pub fn significant_to(value: f64, digits: usize, to: fn(f64) -> f64) -> f64 {
    let unit = 10_f64.powf(value.log10().floor() + 1.0 - digits as f64);
    significant(to(value / unit) * unit, digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_survives_the_way_to_si_and_back() {
        for hundredths in 1..100_000_u32 {
            let written = f64::from(hundredths) / 100.0;
            for quantity in [LENGTH_UM, LENGTH_MM, PRESSURE_MPA, SPEED_MM_S, HUMIDITY_PCT] {
                assert_eq!(quantity.from_si(quantity.to_si(written)), written, "{quantity}");
            }
        }
        assert_eq!(LENGTH_UM.to_si(10.0), 1e-5);
    }

    #[test]
    fn numbers_are_equal_to_one_part_in_a_million() {
        // 50 N on a face of 5 mm radius, through pressure and back with the digits of a file.
        let pressure_mpa = significant(50.0 / (std::f64::consts::PI * 25.0), 7);
        assert!(is_same(50.0, pressure_mpa * std::f64::consts::PI * 25.0) && is_same(0.0, 0.0) && is_same(-1.0, -1.0));
        assert!(
            !is_same(1.0, 1.000_002) && !is_same(1.0, -1.0) && !is_same(0.0, 1e-12) && !is_same(f64::NAN, f64::NAN)
        );
    }

    #[test]
    fn no_number_fills_a_line_with_digits() {
        assert_eq!([0.0, -2.5, 800.0, 1e-300, 2e20].map(in_digits), ["0", "-2.5", "800", "1e-300", "2e20"]);
    }

    #[test]
    fn ranges_say_what_they_accept() {
        assert!(PRESSURE_MPA.accepts(2.6) && !PRESSURE_MPA.accepts(0.0) && PRESSURE_MPA.or_zero().accepts(0.0));
        for quantity in [LENGTH_UM, LENGTH_MM, POSITIVE] {
            assert!(
                quantity.accepts(1e-6) && !quantity.accepts(5e-324) && quantity.or_zero().accepts(0.0),
                "{quantity}"
            );
        }
        assert_eq!(LENGTH_UM.to_string(), "a number from 0.000001 up to 10000000 um");
        assert!(!PRESSURE_MPA.accepts(2.6e6));
        assert!(HUMIDITY_PCT.accepts(0.0) && !HUMIDITY_PCT.accepts(-1.0) && !HUMIDITY_PCT.accepts(f64::NAN));
        assert_eq!(DENSITY_G_CM3.to_string(), "a number above 0 up to 23 g/cm3");
    }
}
