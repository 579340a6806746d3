//! Rims: recast material from laser ablation along the edge of a cavity.
//!
//! The rim of a cavity covers the land over its width w. At the distance d from the edge the land is raised by
//!
//! ```text
//! r(d) = h phi(d / w),     phi(s) = 1 (flat), 1 - s (ramp), 1 - s^2 (round), sin(pi s) (half-sine),     0 <= s <= 1
//! ```
//!
//! Between two cavities closer than two rim widths, the rims end half-way, so that each point belongs to the nearest
//! edge.

use std::f64::consts::PI;

use crate::pattern::PatternError;
use crate::pattern::error::{length, um};

/// Maximum height of a rim, in metres.
const MAX_HEIGHT_M: f64 = 1e-3;

/// Profile of a rim against s, the distance from the edge of its cavity over the rim's width, from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RimProfile {
    /// Parabola with its crest at the edge: 1 - s^2.
    #[default]
    Round,
    /// Constant height up to s = 1.
    Flat,
    /// Linear fall: 1 - s.
    Ramp,
    /// Arch with its crest at half the width: sin(pi s), as observed on some measured rims.
    HalfSine,
}

slipgrid_base::names!(RimProfile { Round = "round", Flat = "flat", Ramp = "ramp", HalfSine = "half-sine" });

impl RimProfile {
    /// Profiles allowed in pattern files, in the order in which help texts list them.
    pub const IN_FILES: [Self; 3] = [Self::Round, Self::Flat, Self::Ramp];

    /// Height over the maximum height at `s`, the distance from the edge over the rim's width; 0 unless `s` is within 0
    /// to 1.
    pub fn height(self, s: f64) -> f64 {
        match self {
            _ if !(0.0..=1.0).contains(&s) => 0.0,
            Self::Round => 1.0 - s * s,
            Self::Flat => 1.0,
            Self::Ramp => 1.0 - s,
            Self::HalfSine => libm::sin(PI * s),
        }
    }

    /// Integral of [`Self::height`] from 0, the edge, to the relative distance `s`.
    pub fn integral(self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        match self {
            Self::Round => s * (1.0 - s * s / 3.0),
            Self::Flat => s,
            Self::Ramp => s * (1.0 - 0.5 * s),
            Self::HalfSine => (1.0 - libm::cos(PI * s)) / PI,
        }
    }

    /// Integral, in metres, of the relative height of a rim `width_m` wide between the distances `from_m` and `to_m`
    /// from the edge.
    pub fn integral_m(self, width_m: f64, from_m: f64, to_m: f64) -> f64 {
        let to = |distance_m: f64| self.integral(distance_m / width_m);
        width_m * (to(to_m) - to(from_m))
    }

    /// Mean relative height of a rim `width_m` wide between the distances `from_m` and `to_m` from the edge.
    pub fn mean(self, width_m: f64, from_m: f64, to_m: f64) -> f64 {
        self.integral_m(width_m, from_m, to_m) / (to_m - from_m)
    }

    /// Negative derivative of [`Self::height`] at `s`, from 0 to 1.
    pub(super) fn fall(self, s: f64) -> f64 {
        match self {
            Self::Round => 2.0 * s,
            Self::Flat => 0.0,
            Self::Ramp => 1.0,
            Self::HalfSine => -PI * libm::cos(PI * s),
        }
    }
}

/// Rim of every cavity of a texture. Lengths are in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// Depth of a cavity and height of its rim, by increasing depth; the first `known` pairs are valid.
    heights_m: [[f64; 2]; Self::MAX_HEIGHTS],
    known: usize,
    width_m: f64,
    profile: RimProfile,
    height_std_m: f64,
}

impl Rim {
    /// Maximum number of depths for which a height can be given.
    pub const MAX_HEIGHTS: usize = 8;

    /// Creates a rim with the maximum height `height_m` and the width `width_m`, independent of the cavity's depth.
    ///
    /// # Errors
    /// [`PatternError::Refused`] unless the height is between 0 and 1 mm and the width positive.
    pub fn new(height_m: f64, width_m: f64, profile: RimProfile) -> Result<Self, PatternError> {
        Self::following_depth(&[[0.0, height_m]], width_m, profile)
    }

    /// Creates a rim whose height depends on the depth of its cavity. `heights_m` holds pairs of depth and height by
    /// increasing depth; heights are interpolated linearly, and constant outside the table.
    ///
    /// # Errors
    /// The errors of [`Self::new`], and [`PatternError::Refused`] for no pair, more than 8 pairs, or depths that do
    /// not increase.
    pub fn following_depth(heights_m: &[[f64; 2]], width_m: f64, profile: RimProfile) -> Result<Self, PatternError> {
        let ascends = heights_m.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let is_depth = heights_m.iter().all(|[depth_m, _]| depth_m.is_finite() && *depth_m >= 0.0);
        if heights_m.is_empty() || heights_m.len() > Self::MAX_HEIGHTS || !ascends || !is_depth {
            return Err(PatternError::Refused(format!(
                "{} pairs of depth and rim height: expected 1 to {} pairs whose depths ascend and are not below zero",
                heights_m.len(),
                Self::MAX_HEIGHTS
            )));
        }
        for [_, height_m] in heights_m {
            height("rim height", *height_m)?;
        }
        let mut known = [[0.0; 2]; Self::MAX_HEIGHTS];
        known[..heights_m.len()].copy_from_slice(heights_m);
        let width_m = length("rim width", width_m)?;
        Ok(Self { heights_m: known, known: heights_m.len(), width_m, profile, height_std_m: 0.0 })
    }

    /// Sets the standard deviation of heights from rim to rim, in metres.
    ///
    /// # Errors
    /// [`PatternError::Refused`] unless it is between 0 and 1 mm.
    pub fn with_height_std_m(mut self, height_std_m: f64) -> Result<Self, PatternError> {
        self.height_std_m = height("scatter of rim heights", height_std_m)?;
        Ok(self)
    }

    /// Adds `by_m` to all heights and limits the sums to 0 to 1 mm.
    #[must_use]
    pub fn raised(mut self, by_m: f64) -> Self {
        for [_, height_m] in &mut self.heights_m[..self.known] {
            *height_m = (*height_m + by_m).clamp(0.0, MAX_HEIGHT_M);
        }
        self
    }

    /// Multiplies all heights by `factor` and limits the products to 0 to 1 mm.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        for [_, height_m] in &mut self.heights_m[..self.known] {
            *height_m = (*height_m * factor).clamp(0.0, MAX_HEIGHT_M);
        }
        self
    }

    /// Whether the rim rises above the land: a height or the scatter is not zero.
    pub fn stands(&self) -> bool {
        self.height_std_m > 0.0 || self.heights_m().iter().any(|[_, height_m]| *height_m > 0.0)
    }

    /// Maximum height of the rim of a cavity of depth `depth_m` above the land, in metres.
    pub fn height_m(&self, depth_m: f64) -> f64 {
        let known = self.heights_m();
        let after = known.partition_point(|[at_m, _]| *at_m <= depth_m);
        match (after.checked_sub(1).map(|before| known[before]), known.get(after)) {
            (Some([d0, h0]), Some([d1, h1])) => h0 + (h1 - h0) * (depth_m - d0) / (d1 - d0),
            (Some([_, height_m]), None) => height_m,
            (None, first) => first.map_or(0.0, |[_, height_m]| *height_m),
        }
    }

    /// Pairs of depth and height, in metres, by increasing depth; a single pair if heights do not depend on depth.
    pub fn heights_m(&self) -> &[[f64; 2]] {
        &self.heights_m[..self.known]
    }

    /// Distance from the edge at which the rim ends, in metres.
    pub const fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Largest block size, in metres, that divides `block_m` and is at most half the rim's width, so that the blocks
    /// resolve the profile.
    pub fn block_m(&self, block_m: f64) -> f64 {
        // A rim of two blocks within rounding has two blocks.
        block_m / (2.0 * block_m / self.width_m - 1e-9).ceil().max(1.0)
    }

    /// Profile from the edge outward.
    pub const fn profile(&self) -> RimProfile {
        self.profile
    }

    /// Standard deviation of heights from rim to rim, in metres.
    pub const fn height_std_m(&self) -> f64 {
        self.height_std_m
    }

    /// Integral, in metres, of the relative height between the distances `from_m` and `to_m` from the edge.
    pub fn integral_m(&self, from_m: f64, to_m: f64) -> f64 {
        self.profile.integral_m(self.width_m, from_m, to_m)
    }
}

fn height(quantity: &str, value_m: f64) -> Result<f64, PatternError> {
    if (0.0..=MAX_HEIGHT_M).contains(&value_m) {
        // Adding zero removes the sign of a negative zero, which would be printed.
        Ok(value_m + 0.0)
    } else {
        Err(PatternError::Refused(format!("{quantity} of {} um: expected a number from 0 to 1000", um(value_m))))
    }
}

#[cfg(test)]
mod tests;
