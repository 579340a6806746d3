use crate::Pattern;

/// What the laser can make. Absent limits do not bind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManufacturingLimits {
    /// Smallest gap between two cavities, in metres.
    pub min_land_m: Option<f64>,
    /// Diameter of the laser spot, in metres: no cavity can be narrower.
    pub spot_m: Option<f64>,
    /// Depth that one burst removes, in metres: depths are whole multiples of it.
    pub depth_per_burst_m: Option<f64>,
}

/// A limit that a pattern breaks. `excess` is dimensionless: 0 at the limit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LimitViolation {
    /// The land between two cavities is narrower than allowed.
    #[error("land of {land_m:.3e} m is narrower than the smallest allowed, {min_land_m:.3e} m")]
    LandTooNarrow {
        /// The pattern's spacing, in metres.
        land_m: f64,
        /// The limit, in metres.
        min_land_m: f64,
    },
    /// The cavity is narrower than the laser spot.
    #[error("cavity of {width_m:.3e} m is narrower than the laser spot, {spot_m:.3e} m")]
    NarrowerThanSpot {
        /// The cavity's width, in metres.
        width_m: f64,
        /// The spot's diameter, in metres.
        spot_m: f64,
    },
}

impl LimitViolation {
    /// How far beyond the limit, relative to the limit.
    #[must_use]
    pub fn excess(&self) -> f64 {
        match *self {
            Self::LandTooNarrow { land_m, min_land_m } => 1.0 - land_m / min_land_m,
            Self::NarrowerThanSpot { width_m, spot_m } => 1.0 - width_m / spot_m,
        }
    }
}

impl ManufacturingLimits {
    /// The limits that `pattern` breaks; empty if the laser can make it.
    #[must_use]
    pub fn violations(&self, pattern: &Pattern) -> Vec<LimitViolation> {
        let mut broken = Vec::new();
        if let Some(min_land_m) = self.min_land_m
            && pattern.spacing_m() < min_land_m
        {
            broken.push(LimitViolation::LandTooNarrow { land_m: pattern.spacing_m(), min_land_m });
        }
        if let Some(spot_m) = self.spot_m
            && pattern.width_m() < spot_m
        {
            broken.push(LimitViolation::NarrowerThanSpot { width_m: pattern.width_m(), spot_m });
        }
        broken
    }

    /// Bursts for a depth, rounded to the nearest whole number and at least one; `None` without a
    /// depth per burst.
    #[must_use]
    pub fn bursts(&self, depth_m: f64) -> Option<u32> {
        // A depth is finite and positive, a burst count far below 2^32: the cast cannot overflow.
        self.depth_per_burst_m.map(|per_burst_m| (depth_m / per_burst_m).round().clamp(1.0, 1e9) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Planform;

    #[test]
    fn the_published_pattern_takes_two_bursts() {
        let limits = ManufacturingLimits { depth_per_burst_m: Some(2.6e-6), ..Default::default() };
        assert_eq!(limits.bursts(5.2e-6), Some(2));
        assert_eq!(ManufacturingLimits::default().bursts(5.2e-6), None);
    }

    #[test]
    fn broken_limits_are_named_with_their_excess() {
        let limits = ManufacturingLimits { min_land_m: Some(40e-6), spot_m: Some(23e-6), depth_per_burst_m: None };
        let pattern = Pattern::new(Planform::Groove, 20e-6, 30e-6, 5e-6).unwrap();
        let broken = limits.violations(&pattern);
        assert_eq!(broken.len(), 2);
        assert!((broken[0].excess() - 0.25).abs() < 1e-12);
        assert!(limits.violations(&Pattern::new(Planform::Groove, 23e-6, 40e-6, 5e-6).unwrap()).is_empty());
    }
}
