//! Land of a patterned surface: the remaining original surface, and its level.

use slipgrid_base::monitor::Monitor;

use crate::topography::form::Form;
use crate::topography::order::{median, nth};
use crate::topography::{HeightMap, MapError};

/// Number of histogram classes for the separation of land and cavities.
const CLASSES: usize = 1024;
/// Fraction of the heights at either end that does not determine the range of the histogram, because of spikes.
const SPIKES: f64 = 1e-3;
/// Number of heights between two checks for cancellation.
const CANCEL_CHECK_INTERVAL: usize = 1 << 16;
/// Minimum distance of the means of the two groups of heights, in standard deviations within groups: a uniform ramp has
/// 3.5, a Gaussian 2.7.
const MIN_SEPARATION: f64 = 4.0;
/// Maximum number of rounds of fitting the form to the land and finding the land again.
const MAX_ROUNDS: usize = 20;

/// Heights above the land, and the separation of land and cavities.
pub(super) struct Land {
    /// Heights above the fitted land, row by row, NaN where missing.
    pub(super) height_m: Vec<f64>,
    /// Threshold half-way between the land and the floors, as a height above the land.
    pub(super) threshold_m: f64,
    /// Whether each point is land away from cavities.
    pub(super) is_land: Vec<bool>,
}

/// Separation of heights into two groups.
#[derive(Clone, Copy)]
struct Groups {
    threshold_m: f64,
    separation: f64,
}

impl Land {
    /// Finds the land of `map` and fits the form to it.
    pub(super) fn find(map: &HeightMap, form: Form, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let all = |_| true;
        let mut height_m = map.fit_form(form, all, monitor)?.above_m(map, monitor)?;
        let mut groups = groups(&height_m, monitor)?;
        let mut land: Vec<bool> = Vec::new();
        for _ in 0..MAX_ROUNDS {
            let found: Vec<bool> = height_m.iter().map(|&height| height > groups.threshold_m).collect();
            if found == land {
                break;
            }
            monitor.heed()?;
            land = found;
            height_m = map.fit_form(form, |n| land[n], monitor)?.above_m(map, monitor)?;
            groups = self::groups(&height_m, monitor)?;
        }
        if groups.separation < MIN_SEPARATION {
            return Err(MapError::NoCavities { reason: "heights do not part into land and floors" });
        }
        monitor.heed()?;
        Self::new(height_m, groups.threshold_m, monitor)
    }

    /// Fits the form again to points farther than `margin` pixels, along x and y, from cavities, which excludes rims
    /// and walls.
    pub(super) fn refined(
        self,
        map: &HeightMap,
        form: Form,
        margin: [usize; 2],
        monitor: &dyn Monitor,
    ) -> Result<Self, MapError> {
        let near = near(&self.height_m, map.cols(), self.threshold_m, margin, monitor)?;
        let far = near.iter().zip(&self.height_m).filter(|(near, height)| !**near && !height.is_nan()).count();
        // Land too narrow for a margin keeps the previous result.
        if far * 20 < near.len() {
            return Ok(self);
        }
        match map.fit_form(form, |n| !near[n], monitor) {
            Ok(fitted) => {
                let refined = Self::new(fitted.above_m(map, monitor)?, self.threshold_m, monitor)?;
                Ok(Self { is_land: near.into_iter().map(|near| !near).collect(), ..refined })
            }
            Err(MapError::Cancelled) => Err(MapError::Cancelled),
            Err(_) => Ok(self),
        }
    }

    /// Root mean square height of the land about its form, in metres.
    pub(super) fn sq_m(&self) -> f64 {
        let heights = || self.height_m.iter().zip(&self.is_land).filter(|(h, land)| **land && !h.is_nan());
        let square: f64 = heights().map(|(height, _)| height * height).sum();
        (square / heights().count().max(1) as f64).sqrt()
    }

    /// Sets the threshold half-way between the medians of both groups.
    fn new(height_m: Vec<f64>, threshold_m: f64, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let median = |cavity: bool| {
            let is_of = |height: &f64| !height.is_nan() && (*height <= threshold_m) == cavity;
            let group: Vec<f64> = height_m.iter().copied().filter(is_of).collect();
            median(&group, monitor)
        };
        let threshold_m = match (median(true)?, median(false)?) {
            (Some(floor), Some(land)) => 0.5 * (floor + land),
            _ => threshold_m,
        };
        let is_land = height_m.iter().map(|&height| height > threshold_m).collect();
        Ok(Self { height_m, threshold_m, is_land })
    }
}

/// If all heights lie within this range, they count as equal: above a fitted plane only rounding errors are left.
const MIN_RANGE_M: f64 = 1e-13;

/// Separates heights into two groups with minimum variance within groups (Otsu).
fn groups(height_m: &[f64], monitor: &dyn Monitor) -> Result<Groups, MapError> {
    let present: Vec<f64> = height_m.iter().copied().filter(|height| !height.is_nan()).collect();
    let spikes = (present.len() as f64 * SPIKES) as usize;
    let low = nth(&present, spikes, monitor)?;
    let high = nth(&present, present.len().saturating_sub(1 + spikes), monitor)?;
    let Some((low, high)) = low.zip(high).filter(|(low, high)| high - low > MIN_RANGE_M) else {
        return Err(MapError::NoCavities { reason: "all heights are equal" });
    };
    let mut counts = vec![0.0; CLASSES];
    for some in present.chunks(CANCEL_CHECK_INTERVAL) {
        monitor.heed()?;
        for height in some {
            let class = (height - low) / (high - low) * CLASSES as f64;
            // The cast saturates: spikes join the classes at the ends.
            counts[(class as usize).min(CLASSES - 1)] += 1.0;
        }
    }
    let moments = |classes: std::ops::Range<usize>| {
        let sums = classes.fold([0.0; 3], |[n, s, q], class| {
            let (count, value) = (counts[class], class as f64 + 0.5);
            [n + count, s + count * value, q + count * value * value]
        });
        (sums[0], sums[1] / sums[0], (sums[2] / sums[0] - (sums[1] / sums[0]).powi(2)).max(0.0))
    };
    let (total, mean, _) = moments(0..CLASSES);
    let (mut best, mut most) = (0, 0.0);
    let (mut count, mut sum) = (0.0, 0.0);
    for (class, in_class) in counts.iter().enumerate() {
        count += in_class;
        sum += in_class * (class as f64 + 0.5);
        // Variance between the groups: n1 n2 (mean1 - mean2)^2 / n^2
        let between =
            if count > 0.0 && count < total { (mean * count - sum).powi(2) / (count * (total - count)) } else { 0.0 };
        if between > most {
            (best, most) = (class, between);
        }
    }
    let ((below, mean_below, variance_below), (over, mean_over, variance_over)) =
        (moments(0..best + 1), moments(best + 1..CLASSES));
    // The standard deviation is at least one class, the resolution.
    let within = ((below * variance_below + over * variance_over) / total + 1.0).sqrt();
    // Half-way between the means, because Otsu's threshold is arbitrary among empty classes.
    let threshold = 0.5 * (mean_below + mean_over);
    Ok(Groups {
        threshold_m: low + threshold / CLASSES as f64 * (high - low),
        separation: (mean_over - mean_below) / within,
    })
}

/// Whether each point lies in a cavity, or within `margin` pixels of a cavity along both axes.
fn near(
    height_m: &[f64],
    cols: usize,
    threshold_m: f64,
    margin: [usize; 2],
    monitor: &dyn Monitor,
) -> Result<Vec<bool>, MapError> {
    let rows = height_m.len() / cols;
    let mut near: Vec<bool> = height_m.iter().map(|&height| height <= threshold_m).collect();
    let mut widen = |first: usize, step: usize, count: usize, margin: usize| {
        let line: Vec<bool> = (0..count).map(|k| near[first + k * step]).collect();
        // Pixels since the last cavity, from both ends.
        let mut since = usize::MAX;
        for (k, &cavity) in line.iter().enumerate() {
            since = if cavity { 0 } else { since.saturating_add(1) };
            near[first + k * step] |= since <= margin;
        }
        since = usize::MAX;
        for (k, &cavity) in line.iter().enumerate().rev() {
            since = if cavity { 0 } else { since.saturating_add(1) };
            near[first + k * step] |= since <= margin;
        }
    };
    for j in 0..cols {
        monitor.heed()?;
        widen(j, cols, rows, margin[0]);
    }
    for i in 0..rows {
        monitor.heed()?;
        widen(i * cols, 1, cols, margin[1]);
    }
    Ok(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn two_groups_are_parted_half_way_and_one_is_not() {
        let two: Vec<f64> = (0..1000).map(|n| if n % 10 == 0 { -5.0 } else { 0.0 } + 0.01 * f64::from(n % 7)).collect();
        let found = groups(&two, &Unwatched).unwrap();
        assert!((found.threshold_m + 2.5).abs() < 0.1 && found.separation > 20.0, "{}", found.separation);
        let ramp: Vec<f64> = (0..1000).map(f64::from).collect();
        assert!((groups(&ramp, &Unwatched).unwrap().separation - 3.46).abs() < 0.1);
        assert!(groups(&[1.0; 50], &Unwatched).is_err());
    }

    #[test]
    fn margins_widen_cavities_along_both_axes() {
        let mut heights = vec![0.0; 7 * 9];
        heights[3 * 9 + 4] = -1.0;
        let near = near(&heights, 9, -0.5, [1, 2], &Unwatched).unwrap();
        assert_eq!(near.iter().filter(|near| **near).count(), 3 * 5);
        assert!(near[2 * 9 + 2] && near[4 * 9 + 6] && !near[9 + 4]);
    }
}
