//! Ratios as far as they are believed.

use crate::fixed;

/// Ratios of patterned to flat friction that are believed of a texture: beyond them a number says only that little is known.
const BELIEVED: [f64; 2] = [0.05, 2.0];

/// The end of an interval of ratios in words: `below 0.05` and `above 2` beyond what is believed.
#[must_use]
pub fn believed(ratio: f64, digits: usize) -> String {
    let [least, most] = BELIEVED;
    if ratio < least {
        format!("below {least}")
    } else if ratio > most {
        format!("above {most}")
    } else {
        format!("{ratio:.digits$}")
    }
}

/// An interval of ratios in words, to three digits.
#[must_use]
pub fn believed_interval(ends: [f64; 2]) -> String {
    let [low, high] = ends.map(|end| believed(end, 3));
    format!("{low} to {high}")
}

/// A standard deviation of a ratio's logarithm: `above 0.7` where it doubles the ratio, beyond which it says only that little is known.
#[must_use]
pub fn believed_std(std: f64) -> String {
    let most = (10.0 * std::f64::consts::LN_2).round() / 10.0;
    if std > most { format!("above {most}") } else { fixed(Some(std), 3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_believes_is_no_number() {
        let said = [0.002, 0.05, 0.8654, 2.0, 334.747].map(|ratio| believed(ratio, 3));
        assert_eq!(said, ["below 0.05", "0.050", "0.865", "2.000", "above 2"]);
        assert_eq!([0.0234, 2.845].map(believed_std), ["0.023", "above 0.7"]);
    }
}
