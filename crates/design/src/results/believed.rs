//! Formats ratios, and limits them to the range in which predicted ratios are believed.

use crate::results::fixed;

/// Range of ratios, patterned over flat, that is believed; a value outside says only that little is known.
pub const BELIEVED: [f64; 2] = [0.05, 2.0];

/// Formats a ratio with `digits` decimals; outside the believed range it is `below 0.05` or `above 2`.
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

/// Formats an interval of ratios with three decimals.
pub fn believed_interval(ends: [f64; 2]) -> String {
    let [low, high] = ends.map(|end| believed(end, 3));
    format!("{low} to {high}")
}

/// Formats the standard deviation of a ratio's logarithm with three decimals. Above 0.7, a factor of two in the ratio,
/// the text is `above 0.7`, because such a value says only that little is known.
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
