use crate::pattern::Planform;

/// Reason why a texture or a pattern was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatternError {
    /// A length is not positive and finite.
    #[error("{quantity} of {} um is not a positive length", um(*value_m))]
    NotALength {
        /// `width`, `spacing`, `depth`, `length` or `spacing across`.
        quantity: &'static str,
        /// The value given, in metres.
        value_m: f64,
    },
    /// An angle is out of range.
    #[error("{quantity} of {value_deg} degrees: expected -{most_deg} to {most_deg}")]
    AngleOutOfRange {
        /// `groove angle` or `sliding angle`.
        quantity: &'static str,
        /// The value given, in degrees.
        value_deg: f64,
        /// Maximum angle, in degrees.
        most_deg: f64,
    },
    /// Cavities of this planform do not have the property.
    #[error("{property} has no meaning for planform \"{planform}\": expected {expected}")]
    NoSuchProperty {
        /// `a length`, `an outline`, `a spacing across`, `a staggered arrangement`, `a groove angle` or `a crossing angle`.
        property: &'static str,
        /// Planform of the cavities.
        planform: Planform,
        /// Description of what is accepted.
        expected: &'static str,
    },
    /// A spacing across was given for a hexagonal arrangement, which determines it.
    #[error("rows of a hexagonal arrangement are sqrt(3)/2 of a pitch apart: expected no spacing across")]
    HexagonalRows,
    /// The angle between two families of grooves is out of range.
    #[error("crossing angle of {value_deg} degrees: expected {least_deg} to {most_deg}")]
    CrossingAngle {
        /// The value given, in degrees.
        value_deg: f64,
        /// Minimum angle, in degrees.
        least_deg: f64,
        /// Maximum angle, in degrees.
        most_deg: f64,
    },
    /// Rows of cavities would overlap.
    #[error(
        "hexagonal rows are {} um apart, cavities {} um long: they run into each other; expected a larger spacing", um(*pitch_across_m), um(*length_m)
    )]
    RowsOverlap {
        /// Distance between rows, in metres.
        pitch_across_m: f64,
        /// Extent of a cavity across its row, in metres.
        length_m: f64,
    },
    /// A rim height, or the scatter of rim heights, is out of range.
    #[error("{quantity} of {} um: expected a number from 0 to 1000", um(*value_m))]
    RimHeight {
        /// `rim height` or `scatter of rim heights`.
        quantity: &'static str,
        /// The value given, in metres.
        value_m: f64,
    },
    /// The table of rim heights by depth is invalid.
    #[error(
        "{count} pairs of depth and rim height: expected 1 to {most} pairs whose depths ascend and are not below zero"
    )]
    RimHeights {
        /// Number of pairs given.
        count: usize,
        /// Maximum number of pairs.
        most: usize,
    },
    /// The number of heights of a relief does not match its pixels.
    #[error("{finite} finite heights of a relief of {expected} pixels: expected one for each")]
    ReliefHeights {
        /// Number of finite heights given.
        finite: usize,
        /// Number of pixels.
        expected: usize,
    },
    /// The relief and the pattern have different periods.
    #[error(
        "a relief of {} x {} um for cells of {} x {} um: expected one period of the pattern, its sides within 2 %",
        um(relief_m[0]), um(relief_m[1]), um(cell_m[0]), um(cell_m[1])
    )]
    ReliefMisfit {
        /// Sides of the relief, in metres.
        relief_m: [f64; 2],
        /// Sides of the pattern's cell, in metres.
        cell_m: [f64; 2],
    },
    /// The cavities of the relief and of the pattern are at different places.
    #[error(
        "the cavity of the relief is not where the pattern has its own: expected one period with a cavity in its middle{}",
        if *across { ", as this map would have it if it were turned by a right angle" } else { "" }
    )]
    ReliefElsewhere {
        /// Whether the map would be accepted if it were turned by 90 degrees.
        across: bool,
    },
    /// The cavity of the relief matches the pattern with width and spacing exchanged.
    #[error(
        "the cavity of the relief is not {} um wide beside gaps of {} um, but rather the other way round: expected the width of a cavity as \
         width and the gap between two as spacing; they seem to be exchanged",
        um(*width_m), um(*spacing_m)
    )]
    ReliefExchanged {
        /// Width of the pattern, in metres.
        width_m: f64,
        /// Spacing of the pattern, in metres.
        spacing_m: f64,
    },
}

/// Checks that `value_m` is a positive, finite length.
pub(crate) fn length(quantity: &'static str, value_m: f64) -> Result<f64, PatternError> {
    if value_m.is_finite() && value_m > 0.0 { Ok(value_m) } else { Err(PatternError::NotALength { quantity, value_m }) }
}

/// Converts a length to um and rounds it to 12 digits, which removes the rounding errors of unit conversions.
pub(crate) fn um(length_m: f64) -> f64 {
    let length_um = length_m * 1e6;
    format!("{length_um:.11e}").parse().unwrap_or(length_um)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_units_of_files() {
        for (value_m, says) in [(-1.3e-4, "width of -130 um is"), (0.0, "width of 0 um is"), (f64::NAN, "of NaN um")] {
            let refused = length("width", value_m).unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
