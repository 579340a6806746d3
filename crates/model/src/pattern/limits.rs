use crate::pattern::Pattern;
use crate::pattern::error::um;

/// Relative tolerance for rounding when a depth is compared with the depth at which walls meet.
const ROUNDING: f64 = 1e-9;

/// Limits of the laser; absent limits are not applied.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManufacturingLimits {
    /// Minimum gap between two cavities, in metres.
    pub min_land_m: Option<f64>,
    /// Diameter of the laser spot, in metres, which is the minimum width of a cavity.
    pub spot_m: Option<f64>,
    /// Depth removed by a burst, in metres, of which depths of cavities are multiples; `None` if passes over lines give
    /// the depth.
    pub depth_per_burst_m: Option<f64>,
    /// Horizontal extent of a sloping wall over its height. Opposite walls must not meet above the floor of the cavity.
    pub wall_slope: Option<f64>,
}

/// A limit that a pattern violates.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LimitViolation {
    /// The land between two cavities is too narrow.
    #[error("land of {} um is narrower than the smallest allowed, {} um", um(*land_m), um(*min_land_m))]
    LandTooNarrow {
        /// Minimum distance between two cavities of the pattern, in metres.
        land_m: f64,
        /// Minimum distance between two cavities that the laser can make, in metres.
        min_land_m: f64,
    },
    /// The cavity is narrower than the laser spot.
    #[error("cavity of {} um is narrower than the laser spot, {} um", um(*width_m), um(*spot_m))]
    NarrowerThanSpot {
        /// Smallest extent of the cavity seen from above, in metres.
        width_m: f64,
        /// Diameter of the spot, in metres.
        spot_m: f64,
    },
    /// The sloping walls of the cavity meet above its floor.
    #[error("cavity of {} um is narrower than what two walls that lean take at its depth, {} um", um(*extent_m), um(*walls_m))]
    WallsMeet {
        /// Smallest extent of the cavity seen from above, in metres.
        extent_m: f64,
        /// Horizontal extent of two walls at the depth of the cavity, in metres.
        walls_m: f64,
    },
}

impl LimitViolation {
    /// Amount by which the limit is violated, as a fraction of the limit.
    pub fn excess(&self) -> f64 {
        match *self {
            Self::LandTooNarrow { land_m, min_land_m } => 1.0 - land_m / min_land_m,
            Self::NarrowerThanSpot { width_m, spot_m } => 1.0 - width_m / spot_m,
            Self::WallsMeet { extent_m, walls_m } => 1.0 - extent_m / walls_m,
        }
    }
}

impl ManufacturingLimits {
    /// Limits that `pattern` violates; empty if the laser can make the pattern.
    pub fn violations(&self, pattern: &Pattern) -> Vec<LimitViolation> {
        let mut broken = Vec::new();
        if let Some(min_land_m) = self.min_land_m
            && pattern.least_land_m() < min_land_m
        {
            broken.push(LimitViolation::LandTooNarrow { land_m: pattern.least_land_m(), min_land_m });
        }
        if let Some(spot_m) = self.spot_m
            && pattern.least_extent_m() < spot_m
        {
            broken.push(LimitViolation::NarrowerThanSpot { width_m: pattern.least_extent_m(), spot_m });
        }
        if self.walls_meet(pattern) {
            let walls_m = 2.0 * self.wall_slope.unwrap_or(0.0) * pattern.depth_m();
            broken.push(LimitViolation::WallsMeet { extent_m: pattern.least_extent_m(), walls_m });
        }
        broken
    }

    /// Whether the sloping walls of the cavities of `pattern` meet above the floor.
    pub fn walls_meet(&self, pattern: &Pattern) -> bool {
        self.deepest_m(pattern).is_some_and(|deepest_m| pattern.depth_m() > deepest_m * (1.0 + ROUNDING))
    }

    /// Depth at which the walls of cavities as wide as those of `pattern` meet, in metres; `None` for vertical walls.
    pub fn deepest_m(&self, pattern: &Pattern) -> Option<f64> {
        // w = 2 d tan(taper)
        self.wall_slope.filter(|slope| *slope > 0.0).map(|slope| pattern.least_extent_m() / (2.0 * slope))
    }

    /// Number of bursts for a depth, rounded to the nearest integer and at least one; `None` without a depth per burst.
    pub fn bursts(&self, depth_m: f64) -> Option<u32> {
        // A depth is finite and positive, and the count far below 2^32, so that the cast cannot overflow.
        self.depth_per_burst_m.map(|per_burst_m| (depth_m / per_burst_m).round().clamp(1.0, 1e9) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Planform, Texture};

    #[test]
    fn the_published_pattern_takes_two_bursts() {
        let limits = ManufacturingLimits { depth_per_burst_m: Some(2.6e-6), ..Default::default() };
        assert_eq!(limits.bursts(5.2e-6), Some(2));
        assert_eq!(ManufacturingLimits::default().bursts(5.2e-6), None);
    }

    #[test]
    fn broken_limits_are_named_with_their_excess() {
        let limits = ManufacturingLimits { min_land_m: Some(40e-6), spot_m: Some(23e-6), ..Default::default() };
        let pattern = Pattern::new(Planform::Groove, 20e-6, 30e-6, 5e-6).unwrap();
        let broken = limits.violations(&pattern);
        assert_eq!(broken.len(), 2);
        assert!((broken[0].excess() - 0.25).abs() < 1e-12);
        assert!(limits.violations(&Pattern::new(Planform::Groove, 23e-6, 40e-6, 5e-6).unwrap()).is_empty());
    }

    #[test]
    fn the_narrowest_land_and_the_smallest_extent_decide() {
        let limits = ManufacturingLimits { min_land_m: Some(40e-6), spot_m: Some(23e-6), ..Default::default() };
        let rectangle = Texture::new(Planform::Rectangle);
        let close_rows = rectangle.with_length_m(80e-6).unwrap().with_spacing_across_m(30e-6).unwrap();
        let broken = limits.violations(&Pattern::new(close_rows, 50e-6, 60e-6, 5e-6).unwrap());
        assert_eq!(broken, [LimitViolation::LandTooNarrow { land_m: 30e-6, min_land_m: 40e-6 }]);
        let short = rectangle.with_length_m(20e-6).unwrap();
        let broken = limits.violations(&Pattern::new(short, 50e-6, 60e-6, 5e-6).unwrap());
        assert_eq!(broken, [LimitViolation::NarrowerThanSpot { width_m: 20e-6, spot_m: 23e-6 }]);
    }

    #[test]
    fn walls_that_lean_meet_at_half_the_smallest_extent_over_their_slope() {
        let limits = ManufacturingLimits { wall_slope: Some(0.5), ..Default::default() };
        let short = Texture::new(Planform::Rectangle).with_length_m(30e-6).unwrap();
        let broken = |depth_m: f64| limits.violations(&Pattern::new(short, 60e-6, 60e-6, depth_m).unwrap());
        assert!(broken(30e-6).is_empty());
        assert_eq!(broken(40e-6), [LimitViolation::WallsMeet { extent_m: 30e-6, walls_m: 40e-6 }]);
        assert!((broken(40e-6)[0].excess() - 0.25).abs() < 1e-12);
    }
}
