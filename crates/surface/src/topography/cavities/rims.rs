//! Rims: the relief along the edges of cavities above the adjacent land.
//!
//! Heights are averaged at equal distances from the edge, over edge segments as long as the profile reaches, and over
//! all edges; roughness, which does not follow edges, averages out. The mean profile is fitted by level + h phi((d -
//! d0)/w) with generalized least squares, where phi is a [`RimProfile`] and d0 the upper end of the wall. The
//! correlation of the noise is that of the segments about their mean. h is the height of the profile phi, not the
//! maximum of noisy heights, which is larger. Errors come from the segments, or from cavities if their heights scatter
//! more.

use std::collections::BTreeMap;

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::heights::Heights;
use super::kriging::{Kriging, Shape, Variogram};
use super::scene::{MAX_BINS, Scene};
use super::share::share_of_edge;
use super::{Estimate, RimProfile};
use slipgrid_base::statistics::splitmix64;

/// Minimum number of bins for the detection of a rim.
const MIN_BINS: usize = 5;
/// Minimum number of edge segments for the detection of a rim.
pub(super) const MIN_STRETCHES: usize = 4;
/// Number of parts of a bin in which the positions of points are recorded, since edges cross pixels at arbitrary
/// positions.
const PARTS: usize = 8;
/// Minimum fraction of the length of all edges that must have heights in a bin of the mean profile.
const MIN_COVERED: f64 = 0.3;
/// Minimum height of a rim in standard errors: without a rim, the best of a hundred profiles and widths rarely reaches
/// 3.5.
const MIN_SIGNIFICANCE: f64 = 4.0;
/// Minimum width of a rim in the search, in bins.
const MIN_WIDTH: f64 = 2.0;
/// Minimum width of a rim whose height is reported, in bins; for narrower rims only the product of height and width is
/// determined.
const MIN_TOLD_WIDTH: f64 = 4.0;
/// Maximum width of a rim over the reach of the profile. Wider rims, up to the profile's end, are searched to find that
/// no land is left beyond the rims.
const MAX_WIDTH: f64 = 0.75;
/// Step of the trial widths, in bins.
const WIDTH_STEP: f64 = 0.25;
/// Deviation of real rims, blurred by edges and pixels, from the fitted profiles, relative to the range of heights of
/// the mean profile.
const MODEL_ERROR: f64 = 0.02;
/// Maximum root mean square deviation of the mean profile from the fitted rim, in standard errors that include
/// [`MODEL_ERROR`]: rims of all profiles, 0.1 to 3 um high on rough maps with holes, have up to 1.
const MAX_MISFIT: f64 = 3.0;
/// Minimum height of a rim, and fall of the land from rims that meet, relative to half the depth: in a map without noise
/// any is significant.
const MIN_RELIEF: f64 = 1e-3;
/// Width at which the height of an undetected rim is fitted, relative to the mean width of the cavities.
const NOMINAL_WIDTH: f64 = 0.1;
/// Number of bootstrap draws.
const DRAWS: u64 = 120;
/// Minimum number of cavities at which the bootstrap draws cavities instead of segments.
const MANY_CAVITIES: usize = 8;

/// Mean height at a distance from the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeHeight {
    /// Outward distance from the edge at half depth, in metres.
    pub distance_m: f64,
    /// Mean height above the land, in metres.
    pub height_m: f64,
    /// Standard error from the scatter between edge segments, in metres; 0 for a single segment.
    pub error_m: f64,
}

/// Reason why the height of rims is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimUnknown {
    /// The profile is too short for a rim and adjacent land, there are fewer than four edge segments, or the rim is
    /// narrower than four pixels.
    TooSmall,
    /// Rims extend so far that no level land is left beyond them.
    NoLand,
    /// The mean profile deviates from every rim by many of its errors.
    Misfit,
}

/// Rims of all cavities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RimMetrology {
    /// Maximum height of the rim above the land, in metres, averaged over the edges of all cavities, including segments
    /// without a rim.
    ///
    /// If no rim is significant (below 4 standard errors), the value is the mean relief of a hypothetical round rim a
    /// tenth of a cavity wide, which may be negative. `None` for the reason `unknown`.
    pub height_m: Option<Estimate>,
    /// Reason why the height is not known; `None` if it is.
    pub unknown: Option<RimUnknown>,
    /// Standard deviation of the heights from cavity to cavity, in metres, with sampling noise subtracted; `None`
    /// without a rim and for a single cavity.
    pub height_std_m: Option<Estimate>,
    /// Standard deviation from side to side of one cavity, in metres, with sampling noise subtracted; `None` without a
    /// rim, and if sides are too short for four segments each.
    pub side_std_m: Option<Estimate>,
    /// Distance from the upper end of the wall to the end of the rim, in metres; `None` without a rim.
    pub width_m: Option<Estimate>,
    /// Best-fitting profile; `None` without a rim.
    pub profile: Option<RimProfile>,
    /// Fraction of the edges' length, from 0 to 1, along which the relief exceeds half of a rim's height, corrected for
    /// the false decisions counted on land farther out. 0 without a rim; `None` if there is no such land or roughness
    /// dominates.
    pub share_of_edge: Option<Estimate>,
    /// Distance from the edge at half depth to the upper end of the wall, where the rim begins, in metres.
    pub start_m: f64,
    /// Mean heights against the distance from the edge, from one pixel beyond the wall on.
    pub edge_profile: Vec<EdgeHeight>,
}

impl RimMetrology {
    /// Height of the fitted rim at the distance `distance_m` from the edge at half depth, in metres; 0 without a rim.
    pub fn fitted_m(&self, distance_m: f64) -> f64 {
        match (self.height_m, self.width_m, self.profile) {
            (Some(height), Some(width), Some(profile)) => {
                height.value * profile.height((distance_m - self.start_m) / width.value)
            }
            _ => 0.0,
        }
    }
}

/// An edge segment with its mean profile.
pub(super) struct Stretch {
    pub(super) region: u32,
    /// Side of the region: axis, and whether lines leave the region on this side.
    pub(super) side: (usize, bool),
    pub(super) length_m: f64,
    /// Height minus the mean over all segments in each known bin of the profile, in metres; 0 if the segment has no
    /// height in the bin.
    pub(super) residual: Vec<f64>,
}

/// Mean profile and its segments, in order along the edges.
struct Profile {
    stretches: Vec<Stretch>,
    /// Indices of the known bins, which have heights along at least [`MIN_COVERED`] of the edges.
    bins: Vec<usize>,
    /// Mean distance from the edge in each known bin, in metres.
    distance_m: Vec<f64>,
    /// Mean height in each known bin, in metres.
    mean_m: Vec<f64>,
    /// For each part of each known bin: fraction of the bin's points in the part, and their mean distance from the
    /// upper end of the wall, in metres. Parts without points are omitted.
    parts: Vec<Vec<[f64; 2]>>,
}

impl Profile {
    fn gather(scene: &Scene<'_>, monitor: &dyn Monitor) -> Result<Self, Cancelled> {
        let (bin_m, reach_m) = (scene.bin_m, scene.reach_m());
        let first_m = scene.start_m + bin_m;
        // The cast saturates at zero.
        let count = (((reach_m - first_m) / bin_m) as usize).min(MAX_BINS);
        let mut numbers: BTreeMap<(u32, usize, bool, usize), usize> = BTreeMap::new();
        let of_point: Vec<usize> = scene
            .edges
            .points
            .iter()
            .map(|edge| {
                let block = (edge.line as f64 * scene.pixel_m[1 - edge.axis] / reach_m) as usize;
                let next = numbers.len();
                *numbers.entry((edge.region, edge.axis, edge.behind, block)).or_insert(next)
            })
            .collect();
        let mut length_m = vec![0.0; numbers.len()];
        for (edge, &number) in scene.edges.points.iter().zip(&of_point) {
            length_m[number] += edge.length_m;
        }
        // Number of points and sums of distances and heights, in each bin of each segment.
        let mut sums = vec![vec![[0.0; 3]; count]; numbers.len()];
        let mut points = vec![[[0.0; 2]; PARTS]; count];
        scene.for_land(monitor, |number, distance_m, height_m| {
            let bin = ((distance_m - first_m) / bin_m).floor();
            if bin >= 0.0 && bin < count as f64 {
                let part = ((distance_m - first_m) / bin_m - bin) * PARTS as f64;
                let part = &mut points[bin as usize][(part as usize).min(PARTS - 1)];
                part[0] += 1.0;
                part[1] += distance_m - scene.start_m;
                for (sum, term) in sums[of_point[number]][bin as usize].iter_mut().zip([1.0, distance_m, height_m]) {
                    *sum += term;
                }
            }
        })?;
        let counted = numbers.iter().filter(|((region, ..), _)| scene.counts[*region as usize]);
        let total_m: f64 = counted.map(|(_, &number)| length_m[number]).sum();
        let (mut bins, mut distance_m, mut mean_m, mut parts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for bin in 0..count {
            let mut weighted = [0.0; 3];
            for (sums, length_m) in sums.iter().zip(&length_m) {
                let [points, distances, heights] = sums[bin];
                if points > 0.0 {
                    for (sum, term) in weighted.iter_mut().zip([1.0, distances / points, heights / points]) {
                        *sum += length_m * term;
                    }
                }
            }
            // Near neighbours cut some profiles short.
            if weighted[0] > MIN_COVERED * total_m {
                bins.push(bin);
                distance_m.push(weighted[1] / weighted[0]);
                mean_m.push(weighted[2] / weighted[0]);
                let all: f64 = points[bin].iter().map(|part| part[0]).sum();
                let known = points[bin].iter().filter(|part| part[0] > 0.0);
                parts.push(known.map(|[count, beyond_m]| [count / all, beyond_m / count]).collect());
            }
        }
        let stretches = numbers
            .into_iter()
            .filter(|((region, ..), number)| {
                let known = bins.iter().filter(|&&bin| sums[*number][bin][0] > 0.0).count();
                scene.counts[*region as usize] && 2 * known >= bins.len()
            })
            .map(|((region, axis, behind, _), number)| {
                let residual = bins.iter().zip(&mean_m).map(|(&bin, mean_m)| {
                    let [points, _, heights] = sums[number][bin];
                    if points > 0.0 { heights / points - mean_m } else { 0.0 }
                });
                Stretch { region, side: (axis, behind), length_m: length_m[number], residual: residual.collect() }
            })
            .collect();
        Ok(Self { stretches, bins, distance_m, mean_m, parts })
    }

    /// Semivariances of the segments about their mean, in square metres, at lags from one bin on.
    fn semivariances(&self) -> Vec<f64> {
        let count = self.stretches.len() as f64;
        (1..=self.bins.len() / 2)
            .map(|lag| {
                let (mut sum, mut weight) = (0.0, 0.0);
                for stretch in &self.stretches {
                    for (one, other) in stretch.residual.iter().zip(&stretch.residual[lag..]) {
                        sum += stretch.length_m * (one - other).powi(2);
                        weight += stretch.length_m;
                    }
                }
                0.5 * sum / weight * count / (count - 1.0)
            })
            .collect()
    }

    /// Standard error of the mean height in the known bin `bin`, in metres.
    fn error_m(&self, bin: usize) -> f64 {
        let count = self.stretches.len() as f64;
        let total: f64 = self.stretches.iter().map(|stretch| stretch.length_m).sum();
        let square: f64 = self.stretches.iter().map(|stretch| (stretch.length_m * stretch.residual[bin]).powi(2)).sum();
        if count > 1.0 { (square * count / (count - 1.0)).sqrt() / total } else { 0.0 }
    }
}

/// A trial rim: profile, width, and the shape prepared for the fit.
struct Candidate {
    profile: RimProfile,
    width_m: f64,
    shape: Shape,
}

/// Measures the rims; also returns the rim height of each region, by label, with its error in metres.
pub(super) fn measure(
    scene: &Scene<'_>,
    monitor: &dyn Monitor,
) -> Result<(RimMetrology, BTreeMap<u32, Estimate>), Cancelled> {
    let profile = Profile::gather(scene, monitor)?;
    let edge_profile = |level_m: f64| {
        let places = profile.distance_m.iter().zip(&profile.mean_m).enumerate();
        places
            .map(|(bin, (&distance_m, &mean_m))| EdgeHeight {
                distance_m,
                height_m: mean_m - level_m,
                error_m: profile.error_m(bin),
            })
            .collect()
    };
    let nothing = RimMetrology {
        unknown: Some(RimUnknown::TooSmall),
        start_m: scene.start_m,
        edge_profile: edge_profile(profile.mean_m.last().copied().unwrap_or(0.0)),
        ..RimMetrology::default()
    };
    if profile.bins.len() < MIN_BINS || profile.stretches.len() < MIN_STRETCHES {
        return Ok((nothing, BTreeMap::new()));
    }
    let Some(fit) = Fit::new(scene, &profile) else { return Ok((nothing, BTreeMap::new())) };
    let ready = fit.kriging.whiten(&profile.mean_m);
    let best = fit.best(&ready).map(|(best, height_m)| {
        (best, height_m, Heights::new(&profile.stretches, &fit.kriging.weights(&best.shape), height_m))
    });
    let is_significant = |height_m: f64, heights: &Heights| {
        height_m >= (MIN_SIGNIFICANCE * heights.error_m()).max(MIN_RELIEF * scene.threshold_m.abs())
    };
    let best = best.filter(|(_, height_m, heights)| is_significant(*height_m, heights));
    let level_m = |shape: &[f64], height_m: f64| {
        let land: Vec<f64> = profile.mean_m.iter().zip(shape).map(|(mean, shape)| mean - height_m * shape).collect();
        fit.kriging.level(&land)
    };
    let Some((best, height_m, heights)) = best else {
        // Ramps that meet are a slope, which is fitted beside every rim.
        let slope = fit.kriging.slope();
        let (rise_m, _) = fit.kriging.height(&slope, &ready);
        if is_significant(-rise_m, &Heights::new(&profile.stretches, &fit.kriging.weights(&slope), rise_m)) {
            return Ok((RimMetrology { unknown: Some(RimUnknown::NoLand), ..nothing }, BTreeMap::new()));
        }
        // A width selected from noise would exaggerate the height; a nominal width does not.
        let width_m = (NOMINAL_WIDTH * scene.width_m).clamp(MIN_WIDTH * scene.bin_m, fit.most_width_m);
        let values = fit.values(scene, &profile, RimProfile::Round, width_m);
        let shape = fit.kriging.shape(&values);
        if !shape.is_determined() {
            return Ok((nothing, BTreeMap::new()));
        }
        let (height_m, _) = fit.kriging.height(&shape, &ready);
        let error_m = Heights::new(&profile.stretches, &fit.kriging.weights(&shape), height_m).error_m();
        let none = RimMetrology {
            height_m: Some(Estimate { value: height_m, error: Some(error_m) }),
            unknown: None,
            share_of_edge: Some(Estimate { value: 0.0, error: None }),
            edge_profile: edge_profile(level_m(&values, height_m)),
            ..nothing
        };
        return Ok((none, BTreeMap::new()));
    };
    let values = fit.values(scene, &profile, best.profile, best.width_m);
    let edge_profile = edge_profile(level_m(&values, height_m));
    let unknown = if best.width_m > fit.most_width_m {
        Some(RimUnknown::NoLand)
    } else if best.width_m < (MIN_TOLD_WIDTH - 0.5 * WIDTH_STEP) * scene.bin_m {
        Some(RimUnknown::TooSmall)
    } else {
        let misfit = fit.kriging.misfit(&best.shape, &ready, profile.stretches.len());
        (misfit > MAX_MISFIT).then_some(RimUnknown::Misfit)
    };
    if unknown.is_some() {
        return Ok((RimMetrology { unknown, edge_profile, ..nothing }, BTreeMap::new()));
    }
    let [height_error_m, width_error_m] = bootstrap(&profile, &fit, monitor)?;
    let error_m = height_error_m.max(heights.error_m()).hypot(MODEL_ERROR * height_m);
    let found = RimMetrology {
        height_m: Some(Estimate { value: height_m, error: Some(error_m) }),
        unknown: None,
        height_std_m: heights.std_m(),
        side_std_m: heights.side_std_m(),
        width_m: Some(Estimate { value: best.width_m, error: Some(width_error_m.max(WIDTH_STEP * scene.bin_m)) }),
        profile: Some(best.profile),
        share_of_edge: share_of_edge(scene, best.profile, best.width_m, monitor)?,
        edge_profile,
        ..nothing
    };
    Ok((found, heights.of_cavities()))
}

/// All trial profiles and widths, prepared for the fit.
struct Fit {
    kriging: Kriging,
    candidates: Vec<Candidate>,
    most_width_m: f64,
}

impl Fit {
    fn new(scene: &Scene<'_>, profile: &Profile) -> Option<Self> {
        let last_m = *profile.distance_m.last()?;
        let bin_m = scene.bin_m;
        let land_m = last_m - scene.start_m;
        let most_width_m = MAX_WIDTH * land_m;
        if most_width_m <= MIN_WIDTH * bin_m {
            return None;
        }
        // The covariance is that of one segment; that of the mean is smaller by their number, but the model error is
        // not.
        let range = |pick: fn(f64, f64) -> f64| profile.mean_m.iter().copied().reduce(pick).unwrap_or(0.0);
        let model_m = MODEL_ERROR * (range(f64::max) - range(f64::min));
        let extra = model_m.powi(2) * profile.stretches.len() as f64;
        let variogram = Variogram::fit(&profile.semivariances());
        let kriging = Kriging::new(variogram, &profile.bins, extra)?;
        let mut fit = Self { kriging, candidates: Vec::new(), most_width_m };
        let widths = ((land_m / bin_m - MIN_WIDTH) / WIDTH_STEP) as usize;
        for shape in RimProfile::ALL {
            for step in 0..=widths {
                let width_m = (MIN_WIDTH + step as f64 * WIDTH_STEP) * bin_m;
                let candidate = fit.kriging.shape(&fit.values(scene, profile, shape, width_m));
                if candidate.is_determined() {
                    fit.candidates.push(Candidate { profile: shape, width_m, shape: candidate });
                }
            }
        }
        Some(fit)
    }

    /// Heights of a rim of height 1 in the bins of `profile`: means over a pixel around each of their points.
    fn values(&self, scene: &Scene<'_>, profile: &Profile, shape: RimProfile, width_m: f64) -> Vec<f64> {
        let half_m = 0.5 * scene.bin_m;
        let mean = |[share, at_m]: &[f64; 2]| share * shape.mean(width_m, at_m - half_m, at_m + half_m);
        profile.parts.iter().map(|parts| parts.iter().map(mean).sum()).collect()
    }

    /// Returns the candidate with positive height that decreases the sum of squares of the whitened profile `ready`
    /// most, and the height in metres; `None` if no candidate has a positive height.
    fn best(&self, ready: &[f64]) -> Option<(&Candidate, f64)> {
        let mut best: Option<(&Candidate, f64)> = None;
        let mut most = 0.0;
        for candidate in &self.candidates {
            let (height_m, gain) = self.kriging.height(&candidate.shape, ready);
            if height_m > 0.0 && gain > most {
                (best, most) = (Some((candidate, height_m)), gain);
            }
        }
        best
    }
}

/// Standard deviations of height and width, in metres, over bootstrap draws of cavities, or of segments if there are
/// few cavities. They include the error from the selection of profile and width (B. Efron, Ann. Stat. 7, 1).
fn bootstrap(profile: &Profile, fit: &Fit, monitor: &dyn Monitor) -> Result<[f64; 2], Cancelled> {
    let mut regions: Vec<u32> = profile.stretches.iter().map(|stretch| stretch.region).collect();
    regions.dedup();
    let many = regions.len() >= MANY_CAVITIES;
    // Weighted residuals and weight of each unit.
    let mut units: BTreeMap<usize, (f64, Vec<f64>)> = BTreeMap::new();
    for (number, stretch) in profile.stretches.iter().enumerate() {
        let unit = if many { stretch.region as usize } else { number };
        let entry = units.entry(unit).or_insert_with(|| (0.0, vec![0.0; profile.bins.len()]));
        entry.0 += stretch.length_m;
        for (sum, residual) in entry.1.iter_mut().zip(&stretch.residual) {
            *sum += stretch.length_m * residual;
        }
    }
    let units: Vec<(f64, Vec<f64>)> = units.into_values().collect();
    let mut drawn: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    for draw in 0..DRAWS {
        monitor.heed()?;
        let (mut length_m, mut sums) = (0.0, vec![0.0; profile.bins.len()]);
        for turn in 0..units.len() as u64 {
            let bits = splitmix64(splitmix64(draw << 32 | turn));
            // At most 2^28 segments: the bias of the remainder is negligible.
            let (unit_m, unit) = &units[(bits % units.len() as u64) as usize];
            length_m += unit_m;
            for (sum, term) in sums.iter_mut().zip(unit) {
                *sum += term;
            }
        }
        let mean: Vec<f64> = profile.mean_m.iter().zip(&sums).map(|(mean, sum)| mean + sum / length_m).collect();
        if let Some((best, height_m)) = fit.best(&fit.kriging.whiten(&mean)) {
            drawn[0].push(height_m);
            drawn[1].push(best.width_m);
        }
    }
    let std =
        |values: Vec<f64>| slipgrid_base::statistics::mean_and_std(values).and_then(|(_, std)| std).unwrap_or(0.0);
    Ok(drawn.map(std))
}
