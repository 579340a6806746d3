/// Why nothing can be exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// A number that is not positive and finite.
    #[error("{quantity} is {}: expected a positive number", tidy(*value))]
    NotPositive {
        /// The quantity, its unit in its name.
        quantity: &'static str,
        /// The value given, in that unit.
        value: f64,
    },
    /// A ring whose hole leaves nothing of it.
    #[error("a ring of {} mm has a hole of {} mm: expected a smaller hole", mm(*outer_diameter_m), mm(*inner_diameter_m))]
    NoRing {
        /// Diameter of the rim, in metres.
        outer_diameter_m: f64,
        /// Diameter of the hole, in metres.
        inner_diameter_m: f64,
    },
    /// The specimen is too small for a single cavity.
    #[error(
        "no cavity {} um wide fits whole on the specimen: expected an extent of at least {} mm, but it is {} mm",
        mm(1e3 * width_m), mm(*needed_m), mm(*extent_m)
    )]
    NoCavityFits {
        /// Width of a cavity, in metres.
        width_m: f64,
        /// Extent of the specimen that falls short, in metres.
        extent_m: f64,
        /// Extent on which one cavity fits, in metres.
        needed_m: f64,
    },
    /// A number of sectors that no specimen is divided into.
    #[error("{count} textures on sectors of one specimen: expected 2 to {most}, one for each sector")]
    Sectors {
        /// The number given.
        count: usize,
        /// The most accepted.
        most: usize,
    },
    /// A sector that does not hold enough of a pattern to be measured by itself.
    #[error(
        "sectors hold circles of {} mm, fewer than {periods} periods of {} um: expected fewer sectors or a finer pattern",
        mm(*circle_m), mm(1e3 * pitch_m)
    )]
    SectorTooSmall {
        /// Longest period of the pattern, in metres.
        pitch_m: f64,
        /// Diameter of the largest circle on the smallest sector, in metres.
        circle_m: f64,
        /// Periods that it must hold.
        periods: f64,
    },
    /// More cavities than any file of them could be used for.
    #[error("about {cavities:.0} cavities fit on the specimen: expected at most {most}")]
    TooManyCavities {
        /// Estimate of their number.
        cavities: f64,
        /// The limit.
        most: usize,
    },
    /// A pattern or a setting that the laser cannot make.
    #[error("{what} of {} um is {relation} {limit}, {} um", tidy(*value_um), tidy(*limit_um))]
    BeyondLaser {
        /// What is too fine, or too far apart.
        what: &'static str,
        /// Its value, in um.
        value_um: f64,
        /// `above` or `below`.
        relation: &'static str,
        /// The limit's name.
        limit: &'static str,
        /// The limit, in um.
        limit_um: f64,
    },
    /// Pulses along a line that do not meet.
    #[error(
        "pulses lie {} um apart, speed_mm_s = {speed_mm_s} over repetition_hz = {repetition_hz}, and do not meet: expected at most spot_um, {} um",
        tidy(*pulse_um), tidy(*spot_um)
    )]
    PulsesApart {
        /// Distance of pulses, in um.
        pulse_um: f64,
        /// Speed of the spot, in mm/s.
        speed_mm_s: f64,
        /// Pulses a second.
        repetition_hz: f64,
        /// Diameter of the spot, in um.
        spot_um: f64,
    },
    /// Walls that lean backwards, or hardly rise.
    #[error("wall_taper_deg is {taper_deg}: expected 0 to {most_deg} degrees from upright")]
    TaperOutOfRange {
        /// The value given, in degrees.
        taper_deg: f64,
        /// The largest accepted, in degrees.
        most_deg: f64,
    },
    /// A format that needs what the design does not give.
    #[error("{what} needs {key}")]
    Needs {
        /// The format, or a part of it.
        what: &'static str,
        /// The key of a design.
        key: &'static str,
    },
    /// Lines of a laser that follows none.
    #[error(
        "{what} holds the lines of a spot, but a mask exposes whole cavities and follows none (laser.exposure = \"mask\"): \
         expected --format dxf, plt or corners for the contours, or csv for the places of cavities"
    )]
    NoLines {
        /// The format.
        what: &'static str,
    },
    /// A solid whose leaning walls the rim would cut.
    #[error("STL holds no leaning walls that the rim cuts: expected whole cavities, or wall_taper_deg = 0")]
    TaperAndCut,
    /// A solid of which a leaning wall does not reach the floor.
    #[error(
        "STL holds no cavity of which a leaning wall ends above the floor: expected longer edges of the outline, or a smaller wall_taper_deg"
    )]
    TaperToNothing,
    /// A height map of too many or too few pixels.
    #[error("pixels of {} um make a height map {pixels:.0} wide: expected 1 to {most}", tidy(*pixel_um))]
    NoHeightMap {
        /// Side of a pixel, in um.
        pixel_um: f64,
        /// Pixels along the longer side.
        pixels: f64,
        /// The most accepted.
        most: u32,
    },
    /// Too few measurements for a law of two coefficients and its error.
    #[error("depth per burst is given at {fluences} different fluences: expected at least three")]
    TooFewFluences {
        /// Different fluences.
        fluences: usize,
    },
    /// Measurements or a fluence at which nothing is removed.
    #[error("{quantity} is {value}: expected {expected}")]
    NoAblation {
        /// What was found, its unit in its name.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A depth between those that whole passes or bursts give.
    #[error(
        "the depth of {} um is no whole number of {of} of {} um: expected for instance {} um",
        tidy(*depth_um), tidy(*step_um), tidy(*nearest_um)
    )]
    NoWholeSteps {
        /// The depth, in um.
        depth_um: f64,
        /// `passes` or `bursts`.
        of: &'static str,
        /// Depth that one of them gives, in um.
        step_um: f64,
        /// The nearest depth that can be cut, in um.
        nearest_um: f64,
    },
    /// The process sheet could not be written as TOML.
    #[error("the process sheet cannot be written as TOML: {reason}")]
    Unwritable {
        /// What the TOML writer said.
        reason: String,
    },
}

/// `value` if it is finite and positive.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, ExportError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(ExportError::NotPositive { quantity, value }) }
}

/// `value` to 6 digits, which is as much as a reader can use: lengths that follow from others have no end of digits.
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
