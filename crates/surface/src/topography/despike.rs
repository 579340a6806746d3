//! Spikes: single points, or clusters of a few points, at which the instrument measured a wrong height.
//!
//! A point is suspect if it differs from the median of the surrounding 5 x 5 points by more than T. T is eight standard
//! deviations of such differences over a sample of the map; the standard deviation is taken as 1.4826 times the median
//! absolute difference, which a few wrong points do not move. Suspects that touch form one cluster. A cluster is a
//! spike if it has at most twelve points and stands beyond *every* surrounding point by more than T; corners of
//! cavities, scratches and steep walls do not. This is the detail-preserving form of the median filter: all other
//! heights stay as they are.

use std::fmt;

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::{extremes, upper_median};
use slipgrid_base::units::counted;

use crate::topography::HeightMap;
use crate::topography::plausibility::limits::{MAX_SPIKE_POINTS, MIN_SPIKE_NEIGHBOURS, SPIKE_DEVIATIONS, SPIKE_REACH};

/// Ratio of the standard deviation of a normal distribution to the median of its absolute values.
pub(crate) const ROBUST_DEVIATION: f64 = 1.4826;

/// Largest number of points, spread evenly over the map, that are compared with their medians to find the threshold T:
/// enough for an error of 1 % in T.
const MAX_SAMPLED: usize = 1 << 14;
/// Fewest differences between heights and surrounding medians from which the threshold T is found; a map with fewer is
/// not searched for spikes.
const MIN_SAMPLED: usize = 64;
/// Differences up to this fraction of the map's range of heights count as rounding errors.
const ROUNDING: f64 = 1e-9;
/// If most differences vanish, the threshold T is found from the other differences, provided that these are more than
/// this fraction of all.
const MIN_UNEQUAL_SHARE: f64 = 0.01;
/// Number of points between two checks for cancellation.
const CANCEL_CHECK_INTERVAL: usize = 1 << 12;
/// Largest number of passes over a map: a spike can be hidden behind a larger one.
const MAX_PASSES: usize = 4;
/// Number of spikes described individually in the message.
const MAX_DESCRIBED: usize = 3;

/// A single point, or a cluster of a few points, with a wrong height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spike {
    /// Row of the cluster's point farthest from the median of its surroundings.
    pub row: usize,
    /// Column of the cluster's point farthest from the median of its surroundings.
    pub col: usize,
    /// Number of points in the cluster.
    pub points: usize,
    /// Height of the point at `row` and `col` above the median of its surroundings, in metres; negative if below.
    pub height_m: f64,
}

/// The spikes found in a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spikes {
    /// All spikes, the farthest from the surface first.
    pub list: Vec<Spike>,
}

impl Spikes {
    /// Number of points in all spikes.
    pub fn points(&self) -> usize {
        self.list.iter().map(|spike| spike.points).sum()
    }
}

impl fmt::Display for Spikes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let extent = |place: fn(&Spike) -> usize| {
            let places = || self.list.iter().map(place);
            let [first, last] = [places().min(), places().max()].map(Option::unwrap_or_default);
            if first == last { first.to_string() } else { format!("{first} to {last}") }
        };
        write!(
            f,
            "{} in {} stand{} alone, beyond all points around (rows {}, columns {}; worst at row, column: ",
            counted(self.points(), "point"),
            counted(self.list.len(), "place"),
            if self.points() == 1 { "s" } else { "" },
            // A row of a file runs along x, as a column does in this module: the indices are exchanged to match the
            // file.
            extent(|spike| spike.col),
            extent(|spike| spike.row)
        )?;
        for (n, spike) in self.list.iter().take(MAX_DESCRIBED).enumerate() {
            let comma = if n > 0 { "; " } else { "" };
            write!(f, "{comma}{}, {} by {:+.3} um", spike.col, spike.row, spike.height_m * 1e6)?;
        }
        f.write_str(")")
    }
}

impl HeightMap {
    /// Replaces each spike by the median of the surrounding points that are present and not in a spike, and returns the
    /// spikes. All other heights stay as they are; missing points stay missing.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn despike(&mut self, monitor: &dyn Monitor) -> Result<Spikes, Cancelled> {
        let mut found = Spikes::default();
        for _ in 0..MAX_PASSES {
            let Some(threshold_m) = self.spike_threshold_m(monitor)? else { break };
            let clusters = self.spike_clusters(threshold_m, monitor)?;
            if clusters.is_empty() {
                break;
            }
            for cluster in &clusters {
                found.list.push(cluster.spike);
                for &node in &cluster.nodes {
                    self.heights_mut()[node] = f64::NAN;
                }
            }
            for cluster in &clusters {
                let medians: Vec<f64> = cluster.nodes.iter().map(|&node| self.median_about(node)).collect();
                for (&node, median_m) in cluster.nodes.iter().zip(medians) {
                    self.heights_mut()[node] = median_m;
                }
            }
        }
        found.list.sort_by(|a, b| b.height_m.abs().total_cmp(&a.height_m.abs()));
        Ok(found)
    }

    /// Whether the map has spikes.
    pub(crate) fn has_spikes(&self, monitor: &dyn Monitor) -> Result<bool, Cancelled> {
        let Some(threshold_m) = self.spike_threshold_m(monitor)? else { return Ok(false) };
        Ok(!self.spike_clusters(threshold_m, monitor)?.is_empty())
    }

    /// Nodes of the square of half-width `reach` around `node`, row by row, without `node` itself.
    fn neighbours(&self, node: usize, reach: usize) -> impl Iterator<Item = usize> {
        let (i, j, cols) = (node / self.cols(), node % self.cols(), self.cols());
        let rows = i.saturating_sub(reach)..(i + reach + 1).min(self.rows());
        let nodes = move |row| (j.saturating_sub(reach)..(j + reach + 1).min(cols)).map(move |col| row * cols + col);
        rows.flat_map(nodes).filter(move |other| *other != node)
    }

    /// Median of the points present in the 5 x 5 square around `node`, without `node` itself; NaN if there are none.
    fn median_about(&self, node: usize) -> f64 {
        let around = self.neighbours(node, SPIKE_REACH).map(|other| self.heights_m()[other]);
        upper_median(&mut around.filter(|height| !height.is_nan()).collect::<Vec<f64>>()).unwrap_or(f64::NAN)
    }

    /// The threshold T, the distance from the median beyond which a point is suspect, in metres; `None` if the map is
    /// flat or has too few points.
    fn spike_threshold_m(&self, monitor: &dyn Monitor) -> Result<Option<f64>, Cancelled> {
        let heights = self.heights_m();
        let mut differences = Vec::new();
        for (n, node) in self.sampled(MAX_SAMPLED).enumerate() {
            if n % CANCEL_CHECK_INTERVAL == 0 {
                monitor.heed()?;
            }
            let difference = (heights[node] - self.median_about(node)).abs();
            differences.extend(Some(difference).filter(|difference| !difference.is_nan()));
        }
        let [least, most] = extremes(heights.iter().copied());
        Ok(threshold_m(&mut differences, ROUNDING * (most - least)))
    }

    /// Whether `node` lies more than `threshold_m` above or below the median of its surroundings, found by counting:
    /// more than half of the surrounding points must lie beyond the threshold on one side.
    fn is_suspect(&self, node: usize, threshold_m: f64) -> bool {
        let heights = self.heights_m();
        let (low, high) = (heights[node] - threshold_m, heights[node] + threshold_m);
        let (i, j, cols) = (node / self.cols(), node % self.cols(), self.cols());
        let columns = j.saturating_sub(SPIKE_REACH)..(j + SPIKE_REACH + 1).min(cols);
        let (mut below, mut above, mut present) = (0_usize, 0_usize, 0_usize);
        for row in i.saturating_sub(SPIKE_REACH)..(i + SPIKE_REACH + 1).min(self.rows()) {
            for &height in &heights[row * cols..][columns.clone()] {
                below += usize::from(height < low);
                above += usize::from(height > high);
                present += usize::from(!height.is_nan());
            }
        }
        // `present` counts the point itself.
        present > MIN_SPIKE_NEIGHBOURS && 2 * below.max(above) > present - 1
    }

    /// Clusters of suspect points in the current map that are spikes.
    fn spike_clusters(&self, threshold_m: f64, monitor: &dyn Monitor) -> Result<Vec<Cluster>, Cancelled> {
        let heights = self.heights_m();
        let mut suspects: Vec<usize> = Vec::new();
        for row in 0..self.rows() {
            monitor.heed()?;
            let nodes = row * self.cols()..(row + 1) * self.cols();
            suspects.extend(nodes.filter(|&node| !heights[node].is_nan() && self.is_suspect(node, threshold_m)));
        }
        let mut taken = vec![false; suspects.len()];
        let mut clusters = Vec::new();
        for first in 0..suspects.len() {
            if first % CANCEL_CHECK_INTERVAL == 0 {
                monitor.heed()?;
            }
            if taken[first] {
                continue;
            }
            taken[first] = true;
            let mut nodes = vec![suspects[first]];
            let mut next = 0;
            while next < nodes.len() {
                for other in self.neighbours(nodes[next], 1) {
                    if let Ok(place) = suspects.binary_search(&other)
                        && !taken[place]
                    {
                        taken[place] = true;
                        nodes.push(other);
                    }
                }
                next += 1;
            }
            clusters.extend(self.spike(nodes, threshold_m));
        }
        Ok(clusters)
    }

    /// Returns the cluster of the points `nodes` if it is a spike; otherwise `None`.
    fn spike(&self, nodes: Vec<usize>, threshold_m: f64) -> Option<Cluster> {
        if nodes.len() > MAX_SPIKE_POINTS {
            return None;
        }
        let heights = self.heights_m();
        let deviation = |node: usize| heights[node] - self.median_about(node);
        let farthest = nodes.iter().copied().max_by(|&a, &b| deviation(a).abs().total_cmp(&deviation(b).abs()))?;
        let height_m = deviation(farthest);
        let upright = |node: usize| height_m.signum() * heights[node];
        let (mut rim, mut around) = (f64::NEG_INFINITY, 0);
        for &node in &nodes {
            for other in self.neighbours(node, 1) {
                if !nodes.contains(&other) && !heights[other].is_nan() {
                    rim = rim.max(upright(other));
                    around += 1;
                }
            }
        }
        let stands_alone = around > 2 && upright(farthest) - rim > threshold_m;
        let (row, col) = (farthest / self.cols(), farthest % self.cols());
        let spike = Spike { row, col, points: nodes.len(), height_m };
        stands_alone.then_some(Cluster { spike, nodes })
    }
}

/// Threshold T, in metres, from the `differences` between heights and surrounding medians, in metres; differences up to
/// `rounding_m` are taken as rounding errors. `None` if there are too few differences or T is zero.
fn threshold_m(differences: &mut [f64], rounding_m: f64) -> Option<f64> {
    if differences.len() < MIN_SAMPLED {
        return None;
    }
    let middle_m = upper_median(differences)?;
    // Heights quantised in coarse steps mostly equal the median; the scatter is then found from the other points only.
    let mut unequal: Vec<f64> = differences.iter().copied().filter(|difference| *difference > rounding_m).collect();
    let deviation_m = if middle_m > rounding_m {
        middle_m
    } else if unequal.len() as f64 > MIN_UNEQUAL_SHARE * differences.len() as f64 {
        upper_median(&mut unequal)?
    } else {
        rounding_m
    };
    Some(SPIKE_DEVIATIONS * ROBUST_DEVIATION * deviation_m).filter(|threshold_m| *threshold_m > 0.0)
}

/// A spike and the nodes of its points.
struct Cluster {
    spike: Spike,
    nodes: Vec<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::SelfAffine;
    use slipgrid_base::monitor::Unwatched;

    const SIDE: usize = 200;

    fn rough(seed: u32) -> HeightMap {
        let size = SelfAffine { pixels: SIDE, side_m: 400e-6, min_wave: 2, max_wave: 60, ..SelfAffine::STAND_IN };
        SelfAffine { seed, ..size }.map().unwrap()
    }

    fn with(map: &HeightMap, places: &[(usize, f64)]) -> HeightMap {
        let added = |node: usize| places.iter().find(|place| place.0 == node).map_or(0.0, |place| place.1);
        map.changed(|node, height_m| height_m + added(node))
    }

    #[test]
    fn spikes_are_found_where_they_are_and_nothing_else_changes() {
        let map = rough(1);
        let high = 10.0 * map.sq_m();
        // One point, a pair, a square of four, one in a corner, one at a side, one downward.
        let bad = [5 * SIDE + 7, 60 * SIDE + 60, 60 * SIDE + 61, 100 * SIDE + 30, 100 * SIDE + 31, 101 * SIDE + 30]
            .into_iter()
            .chain([101 * SIDE + 31, 0, 90 * SIDE])
            .map(|node| (node, high))
            .chain([(150 * SIDE + 150, -2.0 * high)])
            .collect::<Vec<_>>();
        let mut spiked = with(&map, &bad);
        let spikes = spiked.despike(&Unwatched).unwrap();
        assert_eq!((spikes.list.len(), spikes.points()), (6, 10), "{spikes}");
        let worst = spikes.list[0];
        assert!((worst.row, worst.col, worst.points) == (150, 150, 1) && worst.height_m < -1.9 * high, "{worst:?}");
        assert!(spikes.to_string().starts_with("10 points in 6 places"), "{spikes}");
        assert!(spikes.to_string().contains("rows 0 to 150, columns 0 to 150; worst at row, column: 150, 150 by -"));
        for (n, (found, clean)) in spiked.heights_m().iter().zip(map.heights_m()).enumerate() {
            if bad.iter().any(|(node, _)| *node == n) {
                // The median of the surrounding points is within the roughness of 5 x 5 points.
                assert!((found - clean).abs() < 0.5 * map.sq_m(), "{n}: {found} {clean}");
            } else {
                assert_eq!(found, clean);
            }
        }
        // The slope, which the spikes had raised fourfold, is that of the clean map again.
        let slope = |map: &HeightMap| map.rms_slope_spectral(&Unwatched).unwrap();
        assert!(slope(&with(&map, &bad)) > 2.0 * slope(&map));
        assert!((slope(&spiked) / slope(&map) - 1.0).abs() < 2e-3);
        assert_eq!(spiked.clone().despike(&Unwatched).unwrap(), Spikes::default());
    }

    #[test]
    fn surfaces_without_spikes_stay_as_they_are() {
        for seed in 0..10 {
            for hurst in [0.05, 0.4, 1.0] {
                let size = SelfAffine { pixels: 128, min_wave: 1, max_wave: 63, ..SelfAffine::STAND_IN };
                let map = SelfAffine { seed, hurst, ..size }.map().unwrap();
                let mut same = map.clone();
                assert_eq!(same.despike(&Unwatched).unwrap(), Spikes::default(), "{hurst} {seed}");
                assert_eq!(same, map);
            }
        }
        let place = |n: usize| ((n / SIDE) as f64, (n % SIDE) as f64);
        let shaped = |shape: &dyn Fn(f64, f64) -> f64| {
            let heights = (0..SIDE * SIDE).map(|n| 1e-6 * shape(place(n).0, place(n).1)).collect();
            HeightMap::new(SIDE, SIDE, 1e-6, 1e-6, heights).unwrap().despike(&Unwatched).unwrap()
        };
        // A plane, a sphere on a plane, a sinusoid, the same sinusoid in steps of a tenth, sharp squares, discs, and a
        // scratch one point wide.
        let sphere = |x: f64, y: f64| 40.0 - ((x - 99.5).powi(2) + (y - 99.5).powi(2)) / 50.0;
        let wave = |x: f64, y: f64| (0.1 * x).sin() * (0.13 * y).cos();
        let shapes: [&dyn Fn(f64, f64) -> f64; 7] = [
            &|x, y| 0.3 * x - 0.2 * y,
            &|x, y| sphere(x, y).max(0.0),
            &wave,
            &|x, y| (10.0 * wave(x, y)).round() / 10.0,
            &|x, y| if x % 50.0 < 20.0 && y % 50.0 < 20.0 { -20.0 } else { 0.01 * wave(x, y) },
            &|x, y| if (x % 50.0 - 25.0).hypot(y % 50.0 - 25.0) < 12.0 { -20.0 } else { 0.01 * wave(x, y) },
            &|x, y| if x == (y / 3.0).floor() { -5.0 } else { 0.01 * wave(x, y) },
        ];
        for (n, shape) in shapes.iter().enumerate() {
            assert_eq!(shaped(shape), Spikes::default(), "shape {n}");
        }
    }

    #[test]
    fn coarse_steps_flat_maps_and_holes_do_not_hide_a_spike() {
        let steps = rough(2);
        let quantum = 0.3 * steps.sq_m();
        let rounded = steps.changed(|_, height| (height / quantum).round() * quantum);
        assert_eq!(rounded.clone().despike(&Unwatched).unwrap().points(), 0);
        assert_eq!(with(&rounded, &[(777, 60.0 * quantum)]).despike(&Unwatched).unwrap().points(), 1);
        let flat = HeightMap::new(SIDE, SIDE, 1e-6, 1e-6, vec![3e-6; SIDE * SIDE]).unwrap();
        assert_eq!(flat.clone().despike(&Unwatched).unwrap().points(), 0);
        let mut spiked = with(&flat, &[(777, 1e-6), (9000, -1e-3)]);
        assert_eq!(spiked.despike(&Unwatched).unwrap().points(), 2);
        assert_eq!(spiked, flat);
        let holed = rough(1).changed(|n, height| if n.is_multiple_of(3) { f64::NAN } else { height });
        assert_eq!(holed.clone().despike(&Unwatched).unwrap().points(), 0);
        let mut spiked = with(&holed, &[(5 * SIDE + 100, 1e-3)]);
        assert_eq!((spiked.despike(&Unwatched).unwrap().points(), spiked.missing()), (1, holed.missing()));
    }
}
