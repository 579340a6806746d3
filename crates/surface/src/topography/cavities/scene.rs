//! Land in front of the edges of cavities, on which rims are measured.

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::edge::Edges;

/// Number of points between two checks for cancellation.
const CANCEL_CHECK_INTERVAL: usize = 1 << 14;
/// Maximum number of bins of a profile.
pub(super) const MAX_BINS: usize = 160;

/// Input of the rim measurement.
pub(super) struct Scene<'a> {
    pub(super) edges: &'a Edges,
    /// Heights above the form, in metres, NaN where missing.
    pub(super) height_m: &'a [f64],
    /// Label of each point's region, 0 for none.
    pub(super) label: &'a [u32],
    /// Height of half depth above the form, in metres; lower points outside of cavities are specks.
    pub(super) threshold_m: f64,
    /// Whether the edges of each region, by label, are used.
    pub(super) counts: &'a [bool],
    pub(super) pixel_m: [f64; 2],
    /// Size of a bin: the side of a pixel along which lines cross the edges, the larger one if they do along both.
    pub(super) bin_m: f64,
    /// Distance from the cavity's edge, which is taken at half depth, to the start of the rim.
    pub(super) start_m: f64,
    /// Mean width of the cavities, the smaller of those along x and y.
    pub(super) width_m: f64,
    /// Mean land between cavities, the smaller of those along x and y, if known.
    pub(super) spacing_m: Option<f64>,
}

impl Scene<'_> {
    /// Reach of profiles from the edge, in metres: half-way to the next cavity, at most two widths and [`MAX_BINS`]
    /// bins.
    pub(super) fn reach_m(&self) -> f64 {
        let beyond_m = self.start_m + self.bin_m + MAX_BINS as f64 * self.bin_m;
        self.spacing_m.map_or(f64::INFINITY, |spacing_m| 0.5 * spacing_m).min(2.0 * self.width_m).min(beyond_m)
    }

    /// Calls `take` with the index of the edge point, the distance from the edge and the height, both in metres, for
    /// every measured point on land in front of an edge that counts.
    pub(super) fn for_land(
        &self,
        monitor: &dyn Monitor,
        mut take: impl FnMut(usize, f64, f64),
    ) -> Result<(), Cancelled> {
        for (n, (&height_m, &label)) in self.height_m.iter().zip(self.label).enumerate() {
            if n % CANCEL_CHECK_INTERVAL == 0 {
                monitor.heed()?;
            }
            if label != 0 || height_m.is_nan() || height_m <= self.threshold_m {
                continue;
            }
            if let Some((number, distance_m)) = self.edges.distance_m(n)
                && self.counts[self.edges.points[number].region as usize]
            {
                take(number, distance_m, height_m);
            }
        }
        Ok(())
    }
}
