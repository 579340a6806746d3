//! Design space: bounds of width, spacing and depth.

use crate::optimize::SearchError;
use slipgrid_model::pattern::{Pattern, PatternError, Texture};

/// Maximum accepted dimension, in metres.
const LONGEST_M: f64 = 1.0;

/// Bounds of a design, in metres. Equal bounds fix a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignSpace {
    texture: Texture,
    width_m: [f64; 2],
    spacing_m: [f64; 2],
    depth_m: [f64; 2],
}

impl DesignSpace {
    /// Creates the space of patterns of `texture` with width, spacing and depth in the given closed intervals, in metres.
    /// Rows are spaced like cavities along a row, if the texture leaves this open.
    ///
    /// # Errors
    /// [`SearchError::OutOfRange`] unless bounds are positive and at most a metre,
    /// [`SearchError::BoundsReversed`] where a lower bound exceeds the upper.
    pub fn new(
        texture: impl Into<Texture>,
        width_m: [f64; 2],
        spacing_m: [f64; 2],
        depth_m: [f64; 2],
    ) -> Result<Self, SearchError> {
        for (quantity, [lower_m, upper_m]) in [("width", width_m), ("spacing", spacing_m), ("depth", depth_m)] {
            for value in [lower_m, upper_m] {
                if !(value.is_finite() && value > 0.0 && value <= LONGEST_M) {
                    let expected = "a positive length of at most 1 m";
                    return Err(SearchError::OutOfRange { quantity, value, expected });
                }
            }
            if lower_m > upper_m {
                return Err(SearchError::BoundsReversed { quantity, lower_m, upper_m });
            }
        }
        Ok(Self { texture: texture.into(), width_m, spacing_m, depth_m })
    }

    /// The texture of every design.
    pub const fn texture(&self) -> &Texture {
        &self.texture
    }

    /// Lower and upper bound of the width, in metres.
    pub const fn width_m(&self) -> [f64; 2] {
        self.width_m
    }

    /// Lower and upper bound of the spacing, in metres.
    pub const fn spacing_m(&self) -> [f64; 2] {
        self.spacing_m
    }

    /// Lower and upper bound of the depth, in metres.
    pub const fn depth_m(&self) -> [f64; 2] {
        self.depth_m
    }

    /// Lower and upper bounds of width, spacing and depth, in metres.
    pub const fn lengths_m(&self) -> [[f64; 2]; 3] {
        [self.width_m, self.spacing_m, self.depth_m]
    }

    /// Builds the pattern with the given width, spacing and depth, in metres.
    ///
    /// # Errors
    /// [`PatternError`] for lengths that give no valid pattern.
    pub fn pattern(&self, lengths_m: [f64; 3]) -> Result<Pattern, PatternError> {
        let [width_m, spacing_m, depth_m] = lengths_m;
        Pattern::new(self.texture, width_m, spacing_m, depth_m)
    }

    /// Builds the pattern in the middle of the bounds: each length is the geometric mean of its two bounds.
    ///
    /// # Errors
    /// See [`DesignSpace::pattern`].
    pub fn middle(&self) -> Result<Pattern, PatternError> {
        self.pattern(self.lengths_m().map(|[lower_m, upper_m]| (lower_m * upper_m).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn bounds_that_mean_nothing_are_refused() {
        let um = |bounds: [f64; 2]| bounds.map(|um| um * 1e-6);
        let space = |width| DesignSpace::new(Planform::Groove, um(width), um([50.0, 300.0]), um([5.0, 30.0]));
        assert!(matches!(space([400.0, 40.0]), Err(SearchError::BoundsReversed { quantity: "width", .. })));
        for width in [[0.0, 40.0], [-1.0, 40.0], [f64::NAN, 40.0], [40.0, 2e6]] {
            assert!(matches!(space(width), Err(SearchError::OutOfRange { quantity: "width", .. })), "{width:?}");
        }
        let found = space([40.0, 40.0]).unwrap().middle().unwrap();
        assert!((found.width_m() - 40e-6).abs() < 1e-12 && (found.spacing_m() - 122.474e-6).abs() < 1e-9);
    }
}
