//! Scatter of the dimensions of samples about a design.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::units::LENGTH_UM;
use slipgrid_model::pattern::Pattern;

use crate::optimize::SearchError;

/// Number of lengths: width, spacing, depth.
const AXES: usize = 3;

/// Standard deviations of the mean dimensions of a whole sample about the designed dimensions, normally distributed.
/// Scatter of the cavities within one sample is excluded: friction averages over the cavities, and their scatter enters
/// only through the curvature of friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Standard deviation of a sample's mean width; 0 when absent.
    pub width_std_um: f64,
    /// Standard deviation of a sample's mean spacing; 0 when absent.
    pub spacing_std_um: f64,
    /// Standard deviation of a sample's mean depth; 0 when absent.
    pub depth_std_um: f64,
    // A height below the land counts as equally far above it, so that the rim heights of a design without rims are
    // half-normal.
    /// Standard deviation of the mean height of a sample's rims; 0 when absent.
    pub rim_height_std_um: f64,
    /// Correlation of width and spacing, -1 where the pitch is exact; 0 when absent.
    pub width_spacing_correlation: f64,
}

impl Tolerances {
    /// Standard deviations of width, spacing and depth, in metres.
    pub fn std_m(&self) -> [f64; AXES] {
        [self.width_std_um, self.spacing_std_um, self.depth_std_um].map(|std_um| LENGTH_UM.to_si(std_um))
    }

    /// Standard deviation of the mean rim height of a sample, in metres.
    pub fn rim_height_std_m(&self) -> f64 {
        LENGTH_UM.to_si(self.rim_height_std_um)
    }

    /// Checks that the numbers can be standard deviations and a correlation.
    ///
    /// # Errors
    /// [`SearchError::OutOfRange`] for a negative or infinite standard deviation, or a correlation beyond -1 to 1.
    pub fn check(&self) -> Result<(), SearchError> {
        let [width_m, spacing_m, depth_m] = self.std_m();
        let stds_m = [width_m, spacing_m, depth_m, self.rim_height_std_m()];
        if let Some(value) = stds_m.into_iter().find(|std_m| !(std_m.is_finite() && *std_m >= 0.0)) {
            let (quantity, expected) = ("standard deviation of a dimension", "a number that is not negative");
            return Err(SearchError::OutOfRange { quantity, value, expected });
        }
        let value = self.width_spacing_correlation;
        if !(-1.0..=1.0).contains(&value) {
            let (quantity, expected) = ("correlation of width and spacing", "a number from -1 to 1");
            return Err(SearchError::OutOfRange { quantity, value, expected });
        }
        Ok(())
    }

    /// Independent errors that are not zero, each as changes of width, spacing and depth by one standard deviation, in
    /// metres.
    pub fn independent_m(&self) -> Vec<[f64; AXES]> {
        let [width, spacing, depth] = self.std_m();
        let correlation = self.width_spacing_correlation;
        // Rows of the factor's transpose: spacing = rho s z_1 + sqrt(1 - rho^2) s z_2
        let free = (1.0 - correlation * correlation).max(0.0).sqrt();
        let with_width = if width > 0.0 { correlation * spacing } else { 0.0 };
        let alone = if width > 0.0 { free * spacing } else { spacing };
        let all = [[width, with_width, 0.0], [0.0, alone, 0.0], [0.0, 0.0, depth]];
        all.into_iter().filter(|shift| shift.iter().any(|by_m| *by_m != 0.0)).collect()
    }
}

/// Returns the design with the mean rim height changed by `by_m`: |h + by|, as a height below the land counts as equally
/// far above it.
pub fn with_rim_off(design: &Pattern, by_m: f64) -> Pattern {
    let height_m = design.rim_height_m();
    let raised = design.texture().rim().map(|rim| rim.raised((height_m + by_m).abs() - height_m));
    design.to_owned().with_rim(raised)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_that_means_nothing_is_refused() {
        let scatter = Tolerances { width_std_um: 8.0, spacing_std_um: 13.0, ..Tolerances::default() };
        assert_eq!(scatter.check(), Ok(()));
        for wrong in [
            Tolerances { width_std_um: -1.0, ..scatter },
            Tolerances { width_std_um: f64::NAN, ..scatter },
            Tolerances { rim_height_std_um: -1e-2, ..scatter },
            Tolerances { width_spacing_correlation: 1.5, ..scatter },
        ] {
            assert!(matches!(wrong.check(), Err(SearchError::OutOfRange { .. })), "{wrong:?}");
        }
        // With an exact pitch, a wider cavity reduces the spacing: their sum stays constant.
        let exact_pitch =
            Tolerances { width_std_um: 8.0, spacing_std_um: 8.0, width_spacing_correlation: -1.0, ..scatter };
        assert_eq!(exact_pitch.independent_m(), [[8e-6, -8e-6, 0.0]]);
    }
}
