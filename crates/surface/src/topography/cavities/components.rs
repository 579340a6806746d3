//! Connected regions below a threshold, and the chords that lines along x and y cut out of them.

use slipgrid_base::monitor::{Cancelled, Monitor};

/// Section of one line of pixels within one region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chord {
    pub(super) region: u32,
    /// Index of the line: a column for chords along x, a row for chords along y.
    pub(super) line: usize,
    /// Start: position where the height crosses the threshold, in pixels; `None` if the map ends first.
    pub(super) from: Option<f64>,
    /// End: position where the height crosses the threshold again, in pixels; `None` if the map ends first.
    pub(super) to: Option<f64>,
}

/// Labelled regions of a grid: labels start at 1, and points outside of all regions have the label 0.
pub(super) struct Regions {
    pub(super) label: Vec<u32>,
    /// Number of points of each region, by label; 0 for label 0.
    pub(super) points: Vec<usize>,
    rows: usize,
    /// Number of points in a row of the grid.
    pub(super) cols: usize,
}

impl Regions {
    /// Finds regions of points at or below `threshold` that are connected along sides. Regions smaller than
    /// `smallest_share` of the mean size are dropped; the mean is weighted with the number of points, so that specks
    /// hardly change it. A region at the map's sides has at least the size of the square of its length along them: most
    /// of it may lie beyond, and a dropped sliver of a cavity would count as land.
    pub(super) fn find(
        height: &[f64],
        cols: usize,
        threshold: f64,
        smallest_share: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let rows = height.len() / cols;
        let mut label = vec![0_u32; height.len()];
        // Parent of each label; a root is its own parent.
        let mut parent = vec![0_u32];
        for n in 0..height.len() {
            if n % cols == 0 {
                monitor.heed()?;
            }
            // A missing height compares false.
            if height[n].is_nan() || height[n] > threshold {
                continue;
            }
            let above = if n >= cols { label[n - cols] } else { 0 };
            let left = if n % cols > 0 { label[n - 1] } else { 0 };
            label[n] = match (above, left) {
                (0, 0) => {
                    // At most 2^28 points: the cast is exact.
                    parent.push(parent.len() as u32);
                    parent.len() as u32 - 1
                }
                (one, 0) | (0, one) => one,
                (one, other) => join(&mut parent, one, other),
            };
        }
        let mut points = vec![0_usize; parent.len()];
        let mut at_sides = vec![0_usize; parent.len()];
        for (i, row) in label.chunks_mut(cols).enumerate() {
            monitor.heed()?;
            for (j, label) in row.iter_mut().enumerate() {
                *label = root(&mut parent, *label);
                points[*label as usize] += 1;
                at_sides[*label as usize] += usize::from(i == 0 || i + 1 == rows || j == 0 || j + 1 == cols);
            }
        }
        points[0] = 0;
        // Mean size over points, sum of n^2 over sum of n, which many specks hardly change.
        let total: f64 = points.iter().map(|&n| n as f64).sum();
        let mean = points.iter().map(|&n| (n as f64).powi(2)).sum::<f64>() / total.max(1.0);
        let least = (smallest_share * mean).max(1.0);
        let mut new = vec![0_u32; parent.len()];
        let mut kept = vec![0];
        for (old, (&count, at_sides)) in points.iter().zip(at_sides).enumerate() {
            if count > 0 && (count as f64).max((at_sides as f64).powi(2)) >= least {
                new[old] = kept.len() as u32;
                kept.push(count);
            }
        }
        monitor.heed()?;
        for label in &mut label {
            *label = new[*label as usize];
        }
        Ok(Self { label, points: kept, rows, cols })
    }

    pub(super) fn count(&self) -> usize {
        self.points.len() - 1
    }

    /// Returns the chords along `axis`, 0 for x and 1 for y, line by line in order. A chord extends from the first to
    /// the last point of a region on a line and ends where the height crosses the region's own threshold; a line that
    /// stays above the threshold has no chord.
    pub(super) fn chords(
        &self,
        height: &[f64],
        threshold: impl Fn(u32) -> f64,
        axis: usize,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Chord>, Cancelled> {
        let (lines, length, along, across) =
            if axis == 0 { (self.cols, self.rows, self.cols, 1) } else { (self.rows, self.cols, 1, self.cols) };
        let mut chords: Vec<Chord> = Vec::new();
        for line in 0..lines {
            monitor.heed()?;
            let at = |k: usize| line * across + k * along;
            let first_of_line = chords.len();
            let mut k = 0;
            while k < length {
                let region = self.label[at(k)];
                if region == 0 {
                    k += 1;
                    continue;
                }
                let start = k;
                while k < length && self.label[at(k)] == region {
                    k += 1;
                }
                let profile = |k: usize| height[at(k)];
                if (start..k).all(|k| profile(k) > threshold(region)) {
                    continue;
                }
                let from = crossing(profile, threshold(region), [start, k - 1], true, length);
                let to = crossing(profile, threshold(region), [k - 1, start], false, length);
                match chords[first_of_line..].last_mut() {
                    // A spike within a cavity does not split the chord.
                    Some(last) if last.region == region => last.to = to,
                    _ => chords.push(Chord { region, line, from, to }),
                }
            }
        }
        Ok(chords)
    }
}

/// Position where `profile` crosses `threshold` next to the end `edge` of a run of points, in pixels; `None` if the map
/// ends first. `other` is the other end of the run, and `forward` tells whether the run extends towards larger indices
/// from `edge`.
fn crossing(
    profile: impl Fn(usize) -> f64,
    threshold: f64,
    [edge, other]: [usize; 2],
    forward: bool,
    length: usize,
) -> Option<f64> {
    let inwards = |k: usize| if forward { k + 1 } else { k - 1 };
    let outwards = |k: usize| if forward { k.checked_sub(1) } else { Some(k + 1).filter(|&k| k < length) };
    let mut inside = edge;
    // Go into the run until it is deep enough, then out of it until it is not.
    while profile(inside) > threshold && inside != other {
        inside = inwards(inside);
    }
    let mut outside = outwards(inside)?;
    while profile(outside) <= threshold {
        inside = outside;
        outside = outwards(outside)?;
    }
    let (out, within) = (profile(outside), profile(inside));
    let share = if out > within { ((out - threshold) / (out - within)).clamp(0.0, 1.0) } else { 0.5 };
    Some(outside as f64 + share * (inside as f64 - outside as f64))
}

fn root(parent: &mut [u32], mut label: u32) -> u32 {
    while parent[label as usize] != label {
        parent[label as usize] = parent[parent[label as usize] as usize];
        label = parent[label as usize];
    }
    label
}

fn join(parent: &mut [u32], one: u32, other: u32) -> u32 {
    let (one, other) = (root(parent, one), root(parent, other));
    let (low, high) = (one.min(other), one.max(other));
    parent[high as usize] = low;
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;

    /// `#` is at -1, everything else at 1.
    fn grid(text: &[&str]) -> (Vec<f64>, usize) {
        let heights = text.iter().flat_map(|row| row.bytes()).map(|b| if b == b'#' { -1.0 } else { 1.0 }).collect();
        (heights, text[0].len())
    }

    #[test]
    fn regions_join_across_arms_and_specks_are_dropped() {
        let (heights, cols) = grid(&["#.#...#", "#.#....", "###..##", ".....##"]);
        let regions = Regions::find(&heights, cols, 0.0, 0.3, &Unwatched).unwrap();
        assert_eq!(regions.points, [0, 7, 4]);
        assert_eq!((regions.label[2], regions.label[6], regions.label[27]), (1, 0, 2));
        assert_eq!(Regions::find(&heights, cols, 0.0, 0.0, &Unwatched).unwrap().count(), 3);
        assert_eq!(Regions::find(&heights, cols, -2.0, 0.5, &Unwatched).unwrap().count(), 0);
    }

    #[test]
    fn slivers_of_regions_at_the_sides_stay_and_specks_there_are_dropped() {
        let (heights, cols) =
            grid(&["#..####..#", "..........", "..####....", "..####...#", "..####....", "..####...."]);
        let regions = Regions::find(&heights, cols, 0.0, 0.5, &Unwatched).unwrap();
        assert_eq!(regions.points, [0, 4, 16]);
    }

    #[test]
    fn chords_end_where_the_threshold_is_crossed_or_the_map_ends() {
        let (heights, cols) = grid(&["....", ".##.", ".##.", "....", "#...", "#..."]);
        let regions = Regions::find(&heights, cols, 0.0, 0.0, &Unwatched).unwrap();
        let along_x = regions.chords(&heights, |_| 0.0, 0, &Unwatched).unwrap();
        assert_eq!(along_x[0], Chord { region: 2, line: 0, from: Some(3.5), to: None });
        assert_eq!(along_x[1], Chord { region: 1, line: 1, from: Some(0.5), to: Some(2.5) });
        let along_y = regions.chords(&heights, |_| 0.5, 1, &Unwatched).unwrap();
        assert_eq!(along_y[0], Chord { region: 1, line: 1, from: Some(0.25), to: Some(2.75) });
        assert_eq!(along_y[2], Chord { region: 2, line: 4, from: None, to: Some(0.75) });
    }

    #[test]
    fn an_edge_moves_in_or_out_to_the_region_s_own_threshold() {
        let profile = |k: usize| [3.0, 2.0, 1.0, 0.0, -1.0, -1.0, 1.0, 3.0, 5.0][k];
        for (threshold, from, to) in [(0.5, 2.5, 5.75), (1.5, 1.5, 6.25), (-0.5, 3.5, 5.25)] {
            assert_eq!(crossing(profile, threshold, [3, 5], true, 9), Some(from), "{threshold}");
            assert_eq!(crossing(profile, threshold, [5, 3], false, 9), Some(to), "{threshold}");
        }
        assert_eq!(crossing(profile, 4.0, [3, 5], true, 9), None);
        assert_eq!(crossing(profile, 4.0, [5, 3], false, 9), Some(7.5));
    }

    #[test]
    fn a_spike_does_not_cut_a_chord() {
        let (heights, cols) = grid(&["........", ".##.###.", ".######.", "........"]);
        let chords = Regions::find(&heights, cols, 0.0, 0.0, &Unwatched)
            .unwrap()
            .chords(&heights, |_| 0.0, 1, &Unwatched)
            .unwrap();
        assert_eq!(chords.len(), 2);
        assert_eq!((chords[0].from, chords[0].to), (Some(0.5), Some(6.5)));
    }
}
