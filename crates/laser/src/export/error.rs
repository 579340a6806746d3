/// Reason why nothing can be exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// A number is not positive and finite.
    #[error("{quantity} is {}: expected a positive number", tidy(*value))]
    NotPositive {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value given, in this unit.
        value: f64,
    },
    /// The hole of a ring is not smaller than the ring.
    #[error("a ring of {} mm has a hole of {} mm: expected a smaller hole", mm(*outer_diameter_m), mm(*inner_diameter_m))]
    NoRing {
        /// Outer diameter, in metres.
        outer_diameter_m: f64,
        /// Diameter of the hole, in metres.
        inner_diameter_m: f64,
    },
    /// The specimen is too small for a cavity.
    #[error(
        "no cavity {} um wide fits whole on the specimen: expected an extent of at least {} mm, but it is {} mm",
        mm(1e3 * width_m), mm(*needed_m), mm(*extent_m)
    )]
    NoCavityFits {
        /// Width of a cavity, in metres.
        width_m: f64,
        /// Extent of the specimen that is too small, in metres.
        extent_m: f64,
        /// Minimum extent for one cavity, in metres.
        needed_m: f64,
    },
    /// The number of sectors is out of range.
    #[error("{count} textures on sectors of one specimen: expected 2 to {most}, one for each sector")]
    Sectors {
        /// The number given.
        count: usize,
        /// Maximum number of sectors.
        most: usize,
    },
    /// A sector is too small for its pattern to be measured separately.
    #[error(
        "sectors hold circles of {} mm, fewer than {periods} periods of {} um: expected fewer sectors or a finer pattern",
        mm(*circle_m), mm(1e3 * pitch_m)
    )]
    SectorTooSmall {
        /// Longest period of the pattern, in metres.
        pitch_m: f64,
        /// Diameter of the largest circle on the smallest sector, in metres.
        circle_m: f64,
        /// Minimum number of periods in the circle.
        periods: f64,
    },
    /// There are too many cavities for a usable file.
    #[error("about {cavities:.0} cavities fit on the specimen: expected at most {most}")]
    TooManyCavities {
        /// Estimated number of cavities.
        cavities: f64,
        /// Maximum number.
        most: usize,
    },
    /// The laser cannot make a pattern, or a setting is out of range.
    #[error("{what} of {} um is {relation} {limit}, {} um", tidy(*value_um), tidy(*limit_um))]
    BeyondLaser {
        /// Quantity that is out of range.
        what: &'static str,
        /// Value of the quantity, in um.
        value_um: f64,
        /// `above` or `below`.
        relation: &'static str,
        /// Name of the limit.
        limit: &'static str,
        /// The limit, in um.
        limit_um: f64,
    },
    /// Pulses along a line do not touch.
    #[error(
        "pulses lie {} um apart, speed_mm_s = {speed_mm_s} over repetition_hz = {repetition_hz}, and do not meet: expected at most spot_um, {} um",
        tidy(*pulse_um), tidy(*spot_um)
    )]
    PulsesApart {
        /// Distance between pulses, in um.
        pulse_um: f64,
        /// Speed of the spot, in mm/s.
        speed_mm_s: f64,
        /// Pulse repetition rate, in Hz.
        repetition_hz: f64,
        /// Diameter of the spot, in um.
        spot_um: f64,
    },
    /// The taper of walls is out of range.
    #[error("wall_taper_deg is {taper_deg}: expected 0 to {most_deg} degrees from upright")]
    TaperOutOfRange {
        /// The value given, in degrees.
        taper_deg: f64,
        /// Maximum taper, in degrees.
        most_deg: f64,
    },
    /// A format requires a key that the design does not have.
    #[error("{what} needs {key}")]
    Needs {
        /// Name of the format, or of a part of it.
        what: &'static str,
        /// The key that is required.
        key: &'static str,
    },
    /// A file of lines is requested for a mask.
    #[error(
        "{what} holds the lines of a spot, but a mask exposes whole cavities and follows none (laser.exposure = \"mask\"): \
         expected --format dxf, plt or corners for the contours, or csv for the places of cavities"
    )]
    NoLines {
        /// Name of the format.
        what: &'static str,
    },
    /// The border of the specimen would cut the sloping walls of a solid.
    #[error("STL holds no leaning walls that the rim cuts: expected whole cavities, or wall_taper_deg = 0")]
    TaperAndCut,
    /// A sloping wall of a solid does not reach the floor.
    #[error(
        "STL holds no cavity of which a leaning wall ends above the floor: expected longer edges of the outline, or a smaller wall_taper_deg"
    )]
    TaperToNothing,
    /// The number of pixels of a height map is out of range.
    #[error("pixels of {} um make a height map {pixels:.0} wide: expected 1 to {most}", tidy(*pixel_um))]
    NoHeightMap {
        /// Side of a pixel, in um.
        pixel_um: f64,
        /// Pixels along the longer side.
        pixels: f64,
        /// Maximum number of pixels.
        most: u32,
    },
    /// There are too few fluences to fit a law with two coefficients and errors.
    #[error("depth per burst is given at {fluences} different fluences: expected at least three")]
    TooFewFluences {
        /// Number of different fluences.
        fluences: usize,
    },
    /// Measurements, or a fluence, at which nothing is removed.
    #[error("{quantity} is {value}: expected {expected}")]
    NoAblation {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Description of what is accepted.
        expected: &'static str,
    },
    /// The depth is not a multiple of the depth per pass or burst.
    #[error(
        "the depth of {} um is no whole number of {of} of {} um: expected for instance {} um",
        tidy(*depth_um), tidy(*step_um), tidy(*nearest_um)
    )]
    NoWholeSteps {
        /// The depth, in um.
        depth_um: f64,
        /// `passes` or `bursts`.
        of: &'static str,
        /// Depth per pass or burst, in um.
        step_um: f64,
        /// Nearest possible depth, in um.
        nearest_um: f64,
    },
    /// The process sheet could not be written as TOML.
    #[error("the process sheet cannot be written as TOML: {reason}")]
    Unwritable {
        /// Message of the TOML writer.
        reason: String,
    },
}

/// Checks that `value` is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, ExportError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(ExportError::NotPositive { quantity, value }) }
}

/// Rounds to 6 digits for messages, because derived lengths have many digits.
fn tidy(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

fn mm(length_m: f64) -> f64 {
    tidy(length_m * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_units_of_files() {
        let refused = ExportError::NoCavityFits { width_m: 4e-4, extent_m: 0.3e-3, needed_m: 0.1 + 0.2 };
        assert_eq!(
            refused.to_string(),
            "no cavity 400 um wide fits whole on the specimen: expected an extent of at least 300 mm, but it is 0.3 mm"
        );
        let refused =
            ExportError::NoCavityFits { width_m: 7e-3, extent_m: 6e-3, needed_m: 7e-3 * std::f64::consts::SQRT_2 };
        assert!(refused.to_string().contains("expected an extent of at least 9.89949 mm, but it is 6 mm"), "{refused}");
        let refused = ExportError::NoHeightMap { pixel_um: 0.09999999999999999, pixels: 1e5, most: 65535 };
        assert_eq!(refused.to_string(), "pixels of 0.1 um make a height map 100000 wide: expected 1 to 65535");
    }
}
