//! Sorting and order statistics of many heights, in passes that a monitor can end.

use std::cmp::Ordering;

use slipgrid_base::monitor::{Cancelled, Monitor};

/// Number of heights between two checks for cancellation.
const CANCEL_CHECK_INTERVAL: usize = 1 << 16;
/// Number of sampled heights that bound the parts into which heights are divided to be sorted one part at a time.
const PARTS: usize = 64;
/// Number of sampled heights, two of which bracket an order statistic.
const SAMPLE: usize = 4096;
/// Distance of the brackets from the expected position in the sorted sample, in elements: six standard deviations.
const SAMPLE_MARGIN: usize = 192;
/// Distance between successive sampled positions over the length of the map, modulo 1: the positions lie evenly over
/// the rows, and out of step with the columns.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// Sorted sample of `count` of the `heights`, or of all if there are fewer.
fn sample(heights: &[f64], count: usize) -> Vec<f64> {
    let mut sample: Vec<f64> = if heights.len() <= count {
        heights.to_vec()
    } else {
        // The product is below the length, so the cast is exact.
        let place = |n: usize| ((n as f64 * GOLDEN_RATIO).fract() * heights.len() as f64) as usize;
        (0..count).map(|n| heights[place(n)]).collect()
    };
    sample.sort_unstable_by(f64::total_cmp);
    sample
}

/// Sorts `heights` in descending order; none may be NaN.
pub(crate) fn descending(heights: &[f64], monitor: &dyn Monitor) -> Result<Vec<f64>, Cancelled> {
    let bounds = sample(heights, PARTS);
    let mut parts = vec![Vec::new(); bounds.len() + 1];
    for some in heights.chunks(CANCEL_CHECK_INTERVAL) {
        monitor.heed()?;
        for height in some {
            parts[bounds.partition_point(|bound| bound.total_cmp(height) == Ordering::Less)].push(*height);
        }
    }
    let mut descending = Vec::with_capacity(heights.len());
    for mut part in parts.into_iter().rev() {
        monitor.heed()?;
        part.sort_unstable_by(|a, b| b.total_cmp(a));
        descending.append(&mut part);
    }
    Ok(descending)
}

/// The element of `heights` at index `place` in ascending order, `None` if `place` is out of range; no height may be
/// NaN.
pub(crate) fn nth(heights: &[f64], place: usize, monitor: &dyn Monitor) -> Result<Option<f64>, Cancelled> {
    if place >= heights.len() {
        return Ok(None);
    }
    let sample = sample(heights, SAMPLE);
    // The product is below the length, so the cast is exact.
    let near = (place as f64 / heights.len() as f64 * sample.len() as f64) as usize;
    let least = near.checked_sub(SAMPLE_MARGIN).map_or(f64::NEG_INFINITY, |n| sample[n]);
    let most = sample.get(near + SAMPLE_MARGIN).copied().unwrap_or(f64::INFINITY);
    let (mut below, mut between) = (0, Vec::new());
    for some in heights.chunks(CANCEL_CHECK_INTERVAL) {
        monitor.heed()?;
        for height in some {
            if height.total_cmp(&least) == Ordering::Less {
                below += 1;
            } else if height.total_cmp(&most) != Ordering::Greater {
                between.push(*height);
            }
        }
    }
    let (within, mut heights) = match place.checked_sub(below) {
        Some(within) if within < between.len() => (within, between),
        // The element lies outside the brackets taken from the sample.
        _ => (place, heights.to_vec()),
    };
    monitor.heed()?;
    Ok(Some(*heights.select_nth_unstable_by(within, f64::total_cmp).1))
}

/// Median of `heights`: the mean of the two middle ones if their count is even, `None` if empty; no height may be NaN.
pub(crate) fn median(heights: &[f64], monitor: &dyn Monitor) -> Result<Option<f64>, Cancelled> {
    let middle = heights.len() / 2;
    let upper = nth(heights, middle, monitor)?;
    if middle == 0 || !heights.len().is_multiple_of(2) {
        return Ok(upper);
    }
    Ok(nth(heights, middle - 1, monitor)?.zip(upper).map(|(lower, upper)| 0.5 * (lower + upper)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;
    use slipgrid_base::statistics::splitmix64;

    #[test]
    fn every_place_is_that_of_a_plain_sort() {
        fn rough(n: u64) -> f64 {
            splitmix64(n) as f64 / 2f64.powi(64) - 0.5
        }
        let stepped = |n: u64| (8.0 * rough(n)).round();
        let hostile = |n: u64| if n.is_multiple_of(2) { n as f64 } else { -0.0 };
        let cases: [(u64, &dyn Fn(u64) -> f64); 6] =
            [(0, &rough), (1, &rough), (2, &rough), (9999, &rough), (20_000, &stepped), (20_000, &hostile)];
        for (count, of) in cases {
            let heights: Vec<f64> = (0..count).map(of).collect();
            let mut sorted = heights.clone();
            sorted.sort_by(f64::total_cmp);
            let bits = |heights: &[f64]| heights.iter().map(|height| height.to_bits()).collect::<Vec<u64>>();
            let mut down = descending(&heights, &Unwatched).unwrap();
            down.reverse();
            assert_eq!(bits(&down), bits(&sorted));
            for place in [0, 1, heights.len() / 1000, heights.len() / 2, heights.len().saturating_sub(1), heights.len()]
            {
                let found = nth(&heights, place, &Unwatched).unwrap();
                assert_eq!(
                    found.map(f64::to_bits),
                    sorted.get(place).map(|height| height.to_bits()),
                    "{place} of {count}"
                );
            }
            assert_eq!(median(&heights, &Unwatched).unwrap(), slipgrid_base::statistics::median(&mut heights.clone()));
        }
    }
}
