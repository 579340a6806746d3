//! Rounding of written numbers.

use std::fmt::Write as _;

use slipgrid_base::units::significant;

/// Decimals of a coordinate in millimetres, in DXF, SVG and CSV: one nanometre.
pub const COORDINATE_DECIMALS: usize = 6;

/// Decimals of a length in micrometres: one nanometre.
pub(crate) const MICROMETRE_DECIMALS: usize = 3;

/// Appends `value` with at most `decimals` decimals, without trailing zeros or a negative zero.
pub(crate) fn push_decimal(out: &mut String, value: f64, decimals: usize) {
    let start = out.len();
    // Writing to a String cannot fail.
    let _ = write!(out, "{value:.decimals$}");
    if decimals > 0 {
        let kept = out[start..].trim_end_matches('0').trim_end_matches('.').len();
        out.truncate(start + kept);
    }
    if &out[start..] == "-0" {
        out.replace_range(start..=start, "");
    }
}

/// Formats `value` with at most `decimals` decimals, without trailing zeros or a negative zero.
pub(crate) fn decimal(value: f64, decimals: usize) -> String {
    let mut out = String::new();
    push_decimal(&mut out, value, decimals);
    out
}

/// Rounds `value` to the double nearest to its `decimals` decimals, which prints without a tail of nines.
pub(crate) fn round_decimals(value: f64, decimals: usize) -> f64 {
    decimal(value, decimals).parse().unwrap_or(value)
}

/// Rounds `value` to six significant digits: derived quantities (areas, volumes, times), and lengths in messages.
pub(crate) fn six_digits(value: f64) -> f64 {
    significant(value, 6)
}

/// Length in micrometres below which a nanometre leaves fewer than three digits.
const FINE_UM: f64 = 0.1;

/// Rounds a depth in micrometres to one nanometre, and one below a tenth of a micrometre, as of one burst, to six
/// significant digits.
pub(crate) fn depth(depth_um: f64) -> f64 {
    if depth_um.abs() < FINE_UM { six_digits(depth_um) } else { round_decimals(depth_um, MICROMETRE_DECIMALS) }
}

/// Formats a depth in micrometres with at most `decimals` decimals, or with three significant digits where these leave
/// fewer than two.
pub(crate) fn depth_words(depth_um: f64, decimals: usize) -> String {
    let is_fine = depth_um.abs() < FINE_UM * 10_f64.powi(2 - decimals as i32);
    if is_fine { significant(depth_um, 3).to_string() } else { decimal(depth_um, decimals) }
}

/// Converts metres to micrometres, rounded to one nanometre.
pub(crate) fn micrometres(length_m: f64) -> f64 {
    round_decimals(length_m * 1e6, MICROMETRE_DECIMALS)
}

/// Converts metres to millimetres, rounded to one nanometre.
pub(crate) fn millimetres(length_m: f64) -> f64 {
    round_decimals(length_m * 1e3, COORDINATE_DECIMALS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_rounded_away() {
        assert_eq!(micrometres(130e-6 + 370e-6), 500.0);
        assert_eq!(micrometres(0.000_129_999_999_99), 130.0);
        assert_eq!(millimetres(10e-3), 10.0);
    }

    #[test]
    fn a_depth_that_is_not_zero_is_not_written_as_zero() {
        for (depth_um, written, one, two) in [
            (12.345_67, 12.346, "12.3", "12.35"),
            (0.123_456, 0.123, "0.123", "0.12"),
            (0.04, 0.04, "0.04", "0.04"),
            (0.000_123_456_789, 0.000_123_457, "0.000123", "0.000123"),
            (0.0, 0.0, "0", "0"),
        ] {
            assert_eq!(depth(depth_um), written);
            assert_eq!([1, 2].map(|decimals| depth_words(depth_um, decimals)), [one, two]);
        }
    }

    #[test]
    fn zeros_at_the_end_are_left_out_and_zero_has_no_sign() {
        assert_eq!(decimal(-1e-12, 6), "0");
        assert_eq!(decimal(0.250, 6), "0.25");
        assert_eq!(decimal(100.0, 6), "100");
        assert_eq!(decimal(100.0, 0), "100");
        assert_eq!(decimal(-0.4, 0), "0");
    }
}
