//! Texture patterns: a periodic array of cavities with one width, one spacing and one depth.
//!
//! `pitch = width + spacing`; `spacing` is the gap between two cavities. A [`Pattern`] names its
//! [`Planform`], the shape seen from above. The share of the surface that is cavity is
//!
//! | planform | areal density |
//! |---|---|
//! | groove, across the sliding direction | width / pitch |
//! | square cavities on a square lattice | (width / pitch)^2 |
//!
//! | type | role |
//! |---|---|
//! | [`Pattern`] | a valid pattern, SI units |
//! | [`Planform`] | what a cavity looks like from above |
//! | [`ManufacturingLimits`] | what a laser can make, and the [`LimitViolation`]s of a pattern |
//!
//! This crate knows no solver and opens no files.
//!
//! ```
//! use slipgrid_pattern::{Pattern, Planform};
//! let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6)?;
//! assert!((squares.areal_density() - 0.0676).abs() < 1e-12);
//! # Ok::<(), slipgrid_pattern::PatternError>(())
//! ```

mod limits;

pub use limits::{LimitViolation, ManufacturingLimits};

use std::fmt;
use std::str::FromStr;

/// What a cavity looks like from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Planform {
    /// A groove across the sliding direction, as long as the surface: what the vertical plane models.
    Groove,
    /// A square cavity on a square lattice, sides along and across the sliding direction.
    Square,
}

impl Planform {
    /// All planforms, in the order in which help texts list them.
    pub const ALL: [Self; 2] = [Self::Groove, Self::Square];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Groove => "groove",
            Self::Square => "square",
        }
    }

    /// Dimensions that a model of this planform needs: 2 where every vertical section along the
    /// sliding direction is the same, otherwise 3.
    #[must_use]
    pub const fn dimensions(self) -> u8 {
        match self {
            Self::Groove => 2,
            Self::Square => 3,
        }
    }
}

impl fmt::Display for Planform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Planform {
    type Err = PatternError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|planform| planform.name() == name)
            .ok_or_else(|| PatternError::UnknownPlanform { name: name.to_owned() })
    }
}

/// Why a pattern was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatternError {
    /// A length that is not a positive, finite number.
    #[error("{quantity} of {value_m} m is not a positive length")]
    NotALength {
        /// `width`, `spacing` or `depth`.
        quantity: &'static str,
        /// The value given, in metres.
        value_m: f64,
    },
    /// A planform that this version does not know.
    #[error("unknown planform \"{name}\": expected \"groove\" or \"square\"")]
    UnknownPlanform {
        /// The name given.
        name: String,
    },
}

/// A periodic array of equal cavities. Lengths in metres, all positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    planform: Planform,
    width_m: f64,
    spacing_m: f64,
    depth_m: f64,
}

impl Pattern {
    /// A pattern of cavities `width_m` wide, `spacing_m` apart and `depth_m` deep.
    ///
    /// # Errors
    /// [`PatternError::NotALength`] if one of the lengths is not positive and finite.
    pub fn new(planform: Planform, width_m: f64, spacing_m: f64, depth_m: f64) -> Result<Self, PatternError> {
        for (quantity, value_m) in [("width", width_m), ("spacing", spacing_m), ("depth", depth_m)] {
            if !(value_m.is_finite() && value_m > 0.0) {
                return Err(PatternError::NotALength { quantity, value_m });
            }
        }
        Ok(Self { planform, width_m, spacing_m, depth_m })
    }

    /// The shape seen from above.
    #[must_use]
    pub const fn planform(&self) -> Planform {
        self.planform
    }

    /// Width of a cavity along the sliding direction, in metres.
    #[must_use]
    pub const fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Gap between two neighbouring cavities, in metres.
    #[must_use]
    pub const fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// Depth of a cavity, in metres.
    #[must_use]
    pub const fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Period of the array, width + spacing, in metres.
    #[must_use]
    pub fn pitch_m(&self) -> f64 {
        self.width_m + self.spacing_m
    }

    /// Share of a vertical section through the cavities' centres that is cavity, width / pitch.
    #[must_use]
    pub fn section_density(&self) -> f64 {
        self.width_m / self.pitch_m()
    }

    /// Share of the surface that is cavity.
    #[must_use]
    pub fn areal_density(&self) -> f64 {
        let section = self.section_density();
        match self.planform {
            Planform::Groove => section,
            Planform::Square => section * section,
        }
    }

    /// The strip estimate of the friction ratio of a pattern whose vertical section, taken as a
    /// groove, has the ratio `ratio_groove`: strips between the rows of cavities count as flat.
    #[must_use]
    pub fn strip_estimate(&self, ratio_groove: f64) -> f64 {
        match self.planform {
            Planform::Groove => ratio_groove,
            // ratio = 1 - (width/pitch) (1 - ratio_groove)
            Planform::Square => 1.0 - self.section_density() * (1.0 - ratio_groove),
        }
    }

    /// The same section as grooves across the sliding direction.
    #[must_use]
    pub const fn as_groove(mut self) -> Self {
        self.planform = Planform::Groove;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_of_the_published_pattern() {
        let pattern = |planform| Pattern::new(planform, 130e-6, 370e-6, 20e-6).unwrap();
        assert!((pattern(Planform::Groove).areal_density() - 0.26).abs() < 1e-12);
        assert!((pattern(Planform::Square).areal_density() - 0.0676).abs() < 1e-12);
        assert!((pattern(Planform::Square).strip_estimate(0.827) - 0.95502).abs() < 1e-9);
        assert!((pattern(Planform::Groove).strip_estimate(0.827) - 0.827).abs() < 1e-15);
    }

    #[test]
    fn lengths_that_mean_nothing_are_refused() {
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            let refused = Pattern::new(Planform::Groove, 1e-4, bad, 1e-5).unwrap_err();
            assert!(refused.to_string().contains("spacing"));
        }
    }

    #[test]
    fn names_read_back() {
        for planform in Planform::ALL {
            assert_eq!(planform.name().parse::<Planform>().unwrap(), planform);
        }
        assert!("hexagon".parse::<Planform>().unwrap_err().to_string().contains("hexagon"));
    }
}
