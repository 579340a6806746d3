//! Walls and floors of cavities.

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::edge::Edges;
use super::found::Found;

/// Fractions of the depth between which a wall's slope is measured.
const SHARES: [f64; 2] = [0.2, 0.8];
/// Number of bins of wall profiles per larger side of a pixel.
const BINS_PER_PIXEL: f64 = 2.0;
/// Maximum difference of the upper end of a wall from the straight line through [`SHARES`], in bins.
const MAX_OFF_LINE: f64 = 0.5;
/// Minimum length of a wall above the land, in bins: the first pixel of a rim, one bin beyond the wall, may lie on the
/// wall's line by chance.
const MIN_ABOVE_LAND: f64 = 1.25;
/// Width of a wall, in larger sides of a pixel, from which on its slope is measured: the mean over a pixel leaves the
/// line between [`SHARES`] of a wall of 2.5 pixels and more as it is, and bins and edges take the rest.
const RESOLVED_PIXELS: f64 = 3.0;
/// Minimum number of points of a floor for the fit of a plane.
const MIN_FLOOR: f64 = 12.0;

/// Measurements on walls and floors, by label of the region.
pub(super) struct Walls {
    /// Distance from the edge at half depth to the upper end of the wall, in metres, from the mean profile of all
    /// cavities.
    pub(super) top_m: f64,
    pub(super) angle_deg: Vec<Option<f64>>,
    pub(super) floor_sq_m: Vec<Option<f64>>,
}

/// Slope of a wall that is `depth_m` deep and [`RESOLVED_PIXELS`] wide, in degrees from the horizontal.
pub(super) fn resolved_deg(depth_m: f64, pixel_m: [f64; 2]) -> f64 {
    libm::atan(depth_m / (RESOLVED_PIXELS * pixel_m[0].max(pixel_m[1]))).to_degrees()
}

/// Measures the walls of the regions that count, from the mean depth fraction at equal distances from their edges, up
/// to `reach_m` outward.
pub(super) fn measure(
    found: &Found,
    edges: &Edges,
    counts: &[bool],
    reach_m: f64,
    monitor: &dyn Monitor,
) -> Result<Walls, Cancelled> {
    let bin_m = found.pixel_m[0].max(found.pixel_m[1]) / BINS_PER_PIXEL;
    let outward = (reach_m / bin_m).ceil();
    let mut profiles: Vec<Profile> = counts.iter().map(|_| Profile::default()).collect();
    let mut all = Profile::default();
    for (n, (&height_m, &label)) in found.land.height_m.iter().zip(&found.regions.label).enumerate() {
        if n % found.cols() == 0 {
            monitor.heed()?;
        }
        if height_m.is_nan() {
            continue;
        }
        let Some((number, distance_m)) = edges.distance_m(n) else { continue };
        let region = edges.points[number].region;
        // Specks and other cavities are not part of this wall.
        if label != region && (label != 0 || distance_m < -bin_m) || !counts[region as usize] {
            continue;
        }
        let Some(floor) = found.floors[region as usize] else { continue };
        // Bins count from outside in; the cast saturates at the first.
        let bin = outward - distance_m / bin_m;
        if bin >= 0.0 {
            let share = (floor.land_m - height_m) / floor.depth_m;
            for profile in [&mut profiles[region as usize], &mut all] {
                profile.add(bin as usize, distance_m, share);
            }
        }
    }
    let angle_deg = profiles
        .iter()
        .zip(&found.floors)
        .map(|(profile, floor)| {
            let [upper_m, lower_m] = Profile::crossings_m(&profile.known())?;
            let drop_m = (SHARES[1] - SHARES[0]) * floor.as_ref()?.depth_m;
            Some(libm::atan2(drop_m, upper_m - lower_m).to_degrees())
        })
        .collect();
    let top_m = all.top_m(bin_m).unwrap_or(bin_m);
    Ok(Walls { top_m: top_m.max(bin_m), angle_deg, floor_sq_m: floors_sq_m(found, monitor)? })
}

/// Number of points, and sums of their distances in metres and depth fractions, by bin from outside in.
#[derive(Clone, Default)]
struct Profile {
    bins: Vec<[f64; 3]>,
}

impl Profile {
    fn add(&mut self, bin: usize, distance_m: f64, share: f64) {
        if bin >= self.bins.len() {
            self.bins.resize(bin + 1, [0.0; 3]);
        }
        for (sum, term) in self.bins[bin].iter_mut().zip([1.0, distance_m, share]) {
            *sum += term;
        }
    }

    /// Mean distance from the edge in metres, and mean depth fraction, in each bin with points, from outside in.
    fn known(&self) -> Vec<[f64; 2]> {
        let known = self.bins.iter().filter(|[count, ..]| *count > 0.0);
        known.map(|[count, distance_m, share]| [distance_m / count, share / count]).collect()
    }

    /// Distances from the edge, in metres, at which the mean depth fraction first exceeds the greater of [`SHARES`], and
    /// last exceeds the smaller one outward of that; `None` if it does not exceed both.
    fn crossings_m(known: &[[f64; 2]]) -> Option<[f64; 2]> {
        let crosses = |wanted: f64| move |pair: &[[f64; 2]]| pair[0][1] < wanted && pair[1][1] >= wanted;
        let at_m = |wanted: f64, pair: &[[f64; 2]]| {
            let part = (wanted - pair[0][1]) / (pair[1][1] - pair[0][1]);
            pair[0][0] + part * (pair[1][0] - pair[0][0])
        };
        let lower = known.windows(2).position(crosses(SHARES[1]))?;
        let upper = known[..lower + 2].windows(2).rposition(crosses(SHARES[0]))?;
        let [upper_m, lower_m] = [at_m(SHARES[0], &known[upper..]), at_m(SHARES[1], &known[lower..])];
        (upper_m > lower_m).then_some([upper_m, lower_m])
    }

    /// Distance from the edge to the upper end of the wall, in metres: where the straight line through [`SHARES`]
    /// reaches the land, or beyond the land, up a rim, the last bin of `bin_m` on that line.
    fn top_m(&self, bin_m: f64) -> Option<f64> {
        let known = self.known();
        let [upper_m, lower_m] = Self::crossings_m(&known)?;
        // Depth fraction that the wall loses per metre outward.
        let slope = (SHARES[1] - SHARES[0]) / (upper_m - lower_m);
        let is_on_line = |[distance_m, share]: &[f64; 2]| {
            let line = SHARES[0] - slope * (distance_m - upper_m);
            (share - line).abs() <= MAX_OFF_LINE * slope * bin_m
        };
        let beyond = known.iter().rev().skip_while(|[distance_m, _]| *distance_m < upper_m);
        let end_m = beyond.take_while(|point| is_on_line(point)).last().map_or(upper_m, |[distance_m, _]| *distance_m);
        let land_m = upper_m + SHARES[0] / slope;
        Some(if end_m > land_m + MIN_ABOVE_LAND * bin_m { end_m } else { land_m })
    }
}

/// Root mean square height of each region's middle third about its least-squares plane, in metres; `None` if the points
/// do not determine the plane.
fn floors_sq_m(found: &Found, monitor: &dyn Monitor) -> Result<Vec<Option<f64>>, Cancelled> {
    let points = || {
        let labels = found.regions.label.iter().zip(&found.middle).enumerate();
        labels.filter(|(n, (label, middle))| **label != 0 && **middle && !found.land.height_m[*n].is_nan()).map(
            |(n, (label, _))| {
                (*label as usize, [(n / found.cols()) as f64, (n % found.cols()) as f64, found.land.height_m[n]])
            },
        )
    };
    monitor.heed()?;
    let mut means = vec![[0.0; 4]; found.regions.count() + 1];
    for (region, point) in points() {
        means[region][3] += 1.0;
        for (sum, part) in means[region].iter_mut().zip(point) {
            *sum += part;
        }
    }
    for [i, j, height_m, count] in &mut means {
        for sum in [i, j, height_m] {
            *sum /= *count;
        }
    }
    monitor.heed()?;
    // Sums of ii, ij, jj, ih, jh, hh about the means.
    let mut squares = vec![[0.0; 6]; means.len()];
    for (region, point) in points() {
        let [i, j, h] = [0, 1, 2].map(|part| point[part] - means[region][part]);
        for (sum, term) in squares[region].iter_mut().zip([i * i, i * j, j * j, i * h, j * h, h * h]) {
            *sum += term;
        }
    }
    let sq_m = |([.., count], [ii, ij, jj, ih, jh, hh]): ([f64; 4], [f64; 6])| {
        let determinant = ii * jj - ij * ij;
        if count < MIN_FLOOR || determinant <= 1e-9 * ii * jj {
            return None;
        }
        // [ii ij; ij jj] [a; b] = [ih; jh]; residual hh - a ih - b jh over the degrees of freedom after three terms
        let (a, b) = ((ih * jj - jh * ij) / determinant, (jh * ii - ih * ij) / determinant);
        Some(((hh - a * ih - b * jh).max(0.0) / (count - 3.0)).sqrt())
    };
    Ok(means.into_iter().zip(squares).map(sq_m).collect())
}
