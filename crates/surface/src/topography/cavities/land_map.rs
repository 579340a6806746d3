//! Map of the land alone.

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::Sought;
use super::edge::Edges;
use super::found::Found;
use crate::topography::form::Form;
use crate::topography::{HeightMap, MapError};

impl HeightMap {
    /// Heights of the land above `form` fitted to it; points in cavities, on their walls and on rims are missing.
    ///
    /// # Errors
    /// [`MapError`] as for [`Self::measure_cavities`], and [`MapError::NoHeights`] if no land is left.
    pub fn land(&self, form: Form, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let (found, is_land) = self.found_land(form, monitor)?;
        let heights = found.land.height_m.iter().zip(is_land);
        let heights = heights.map(|(height_m, is_land)| if is_land { *height_m } else { f64::NAN }).collect();
        Self::new(self.rows(), self.cols(), self.dx_m(), self.dy_m(), heights)
    }

    /// Finds the cavities; also returns whether each point is land away from cavities and beyond their rims.
    pub(super) fn found_land(&self, form: Form, monitor: &dyn Monitor) -> Result<(Found, Vec<bool>), MapError> {
        let (found, Sought { edges, rim, .. }) = Sought::with_rims(Found::find(self, form, monitor)?, monitor)?;
        let rim_end_m = rim.width_m.map_or(0.0, |width| rim.start_m + width.value);
        let is_land = far_land(&found, &edges, rim_end_m, monitor)?;
        Ok((found, is_land))
    }
}

/// Whether each point is land away from cavities and more than `rim_end_m` from their edges.
fn far_land(found: &Found, edges: &Edges, rim_end_m: f64, monitor: &dyn Monitor) -> Result<Vec<bool>, Cancelled> {
    let beyond = |n: usize| edges.distance_m(n).is_none_or(|(_, distance_m)| distance_m > rim_end_m);
    let mut far = Vec::with_capacity(found.land.is_land.len());
    for (i, row) in found.land.is_land.chunks_exact(found.cols()).enumerate() {
        monitor.heed()?;
        far.extend((i * found.cols()..).zip(row).map(|(n, &is_land)| is_land && beyond(n)));
    }
    Ok(far)
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::*;
    use crate::topography::SelfAffine;
    use crate::topography::cavities::tests::PUBLISHED;
    use crate::topography::cavities::{CutPattern, CutRim, RimProfile};

    /// The land of a cut surface is the surface before the cut, at the points that neither cavity nor rim reaches.
    #[test]
    fn the_land_of_a_cut_surface_has_the_slope_of_the_surface() {
        let flat = SelfAffine { side_m: 2.56e-3, ..SelfAffine::STAND_IN }.map().unwrap();
        let rim = CutRim { height_m: 1e-6, width_m: 60e-6, profile: RimProfile::Round, height_std_m: 0.0 };
        for rim in [None, Some(rim)] {
            let mut cut = flat.clone();
            let pattern = CutPattern { width_std_m: 0.0, pitch_std_m: 0.0, depth_std_m: 0.0, rim, ..PUBLISHED };
            cut.cut_cavities(&pattern).unwrap();
            let land = cut.land(Form::Plane, &Unwatched).unwrap();
            let share = 1.0 - land.missing() as f64 / land.heights_m().len() as f64;
            assert!(share > 0.3 && share < 0.74, "{share}");
            // The same points of the surface before the cut.
            let same = flat.changed(|n, height| if land.heights_m()[n].is_nan() { f64::NAN } else { height });
            let [(found, _), (expected, _)] = [&land, &same].map(|map| map.windowed_slope(4));
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
            // Few places of a surface have the slope of all within the error that the windows give.
            let (of_flat, std) = flat.windowed_slope(4);
            let std = std.unwrap();
            assert!(std < 0.05 && (found / of_flat).ln().abs() < 4.0 * std, "{found} {of_flat} {std}");
        }
    }
}
