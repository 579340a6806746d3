//! Rim heights of edge segments, of sides and of cavities, and their scatter.

use std::collections::BTreeMap;

use super::Estimate;
use super::rims::{MIN_STRETCHES, Stretch};

/// Rim heights of all edge segments for one profile and width.
pub(super) struct Heights {
    /// Region, side (see [`Stretch`]), length in metres, which is the weight, and rim height in metres of each segment,
    /// in order along the edges.
    stretches: Vec<(u32, (usize, bool), f64, f64)>,
    mean_m: f64,
    /// Variance of a segment's height about the mean of its cavity, times the segment's length and `inflation`, in m^3.
    unit_variance: f64,
    /// Factor by which the variance of a mean over neighbouring segments exceeds that of independent segments.
    inflation: f64,
}

impl Heights {
    pub(super) fn new(stretches: &[Stretch], weights: &[f64], mean_m: f64) -> Self {
        let height_m = |residual: &[f64]| mean_m + residual.iter().zip(weights).map(|(r, a)| r * a).sum::<f64>();
        let stretches: Vec<_> = stretches
            .iter()
            .map(|stretch| (stretch.region, stretch.side, stretch.length_m, height_m(&stretch.residual)))
            .collect();
        let mut heights = Self { stretches, mean_m, unit_variance: 0.0, inflation: 1.0 };
        let cavities = heights.grouped(|&(region, ..)| region);
        let about = |region: u32, value: f64| value - cavities.get(&region).map_or(mean_m, |group| group.1);
        let (mut square, mut beside) = (0.0, 0.0);
        for (number, &(region, side, weight, value)) in heights.stretches.iter().enumerate() {
            square += weight * about(region, value).powi(2);
            if let Some(&(next, next_side, next_weight, next_value)) = heights.stretches.get(number + 1)
                && (next, next_side) == (region, side)
            {
                beside += (weight * next_weight).sqrt() * about(region, value) * about(next, next_value);
            }
        }
        let free = heights.stretches.len().saturating_sub(cavities.len());
        // Neighbouring segments are correlated: 1 + 2 rho
        heights.inflation = if square > 0.0 { 1.0 + 2.0 * (beside / square).max(0.0) } else { 1.0 };
        if free > 0 {
            heights.unit_variance = heights.inflation * square / free as f64;
        }
        heights
    }

    /// Total length and mean rim height, both in metres, and number of the segments with equal `key`.
    fn grouped<K: Ord>(&self, key: impl Fn(&(u32, (usize, bool), f64, f64)) -> K) -> BTreeMap<K, (f64, f64, usize)> {
        let mut groups: BTreeMap<K, (f64, f64, usize)> = BTreeMap::new();
        for stretch in &self.stretches {
            let group = groups.entry(key(stretch)).or_insert((0.0, 0.0, 0));
            group.0 += stretch.2;
            group.1 += stretch.2 * stretch.3;
            group.2 += 1;
        }
        for group in groups.values_mut() {
            group.1 /= group.0;
        }
        groups
    }

    /// Standard error of the mean rim height, in metres: from the scatter of segments about the mean of their cavity,
    /// or from the scatter of cavities if this gives a larger error.
    pub(super) fn error_m(&self) -> f64 {
        let total: f64 = self.stretches.iter().map(|stretch| stretch.2).sum();
        let within = self.unit_variance / total;
        let cavities = self.grouped(|&(region, ..)| region);
        let count = cavities.len() as f64;
        let square: f64 =
            cavities.values().map(|(weight, mean_m, _)| (weight / total * (mean_m - self.mean_m)).powi(2)).sum();
        let between = if count >= MIN_STRETCHES as f64 { square * count / (count - 1.0) } else { 0.0 };
        within.max(between).sqrt()
    }

    pub(super) fn of_cavities(&self) -> BTreeMap<u32, Estimate> {
        let cavities = self.grouped(|&(region, ..)| region).into_iter();
        cavities
            .map(|(region, (weight, mean_m, _))| {
                let error = (self.unit_variance > 0.0).then(|| (self.unit_variance / weight).sqrt());
                (region, Estimate { value: mean_m, error })
            })
            .collect()
    }

    /// Standard deviation of rim heights between cavities, in metres; `None` if the scatter cannot be estimated.
    pub(super) fn std_m(&self) -> Option<Estimate> {
        let cavities: Vec<_> = self.grouped(|&(region, ..)| region).into_values().collect();
        if self.unit_variance == 0.0 && self.stretches.len() == cavities.len() {
            return None;
        }
        let mean_m = cavities.iter().map(|cavity| cavity.1).sum::<f64>() / cavities.len() as f64;
        let square: f64 = cavities.iter().map(|cavity| (cavity.1 - mean_m).powi(2)).sum();
        let noise = cavities.iter().map(|cavity| self.unit_variance / cavity.0).sum::<f64>() / cavities.len() as f64;
        beyond_noise(square, cavities.len().checked_sub(1)?, noise)
    }

    /// Standard deviation of rim heights between the sides of a cavity, in metres; `None` with fewer than four segments
    /// per side on average.
    pub(super) fn side_std_m(&self) -> Option<Estimate> {
        let sides = self.grouped(|&(region, side, ..)| (region, side));
        // Sides with two or more segments show the noise of their mean.
        let mut noise_square = 0.0;
        for &(region, side, weight, value) in &self.stretches {
            let (_, mean_m, _) = sides[&(region, side)];
            noise_square += weight * (value - mean_m).powi(2);
        }
        if self.stretches.len() < MIN_STRETCHES * sides.len() {
            return None;
        }
        let unit_variance = self.inflation * noise_square / (self.stretches.len() - sides.len()) as f64;
        let mut cavities: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        for ((region, _), (weight, mean_m, _)) in sides {
            cavities.entry(region).or_default().push((weight, mean_m));
        }
        let (mut square, mut free, mut noise, mut count) = (0.0, 0, 0.0, 0.0);
        for sides in cavities.values() {
            let mean_m = sides.iter().map(|side| side.1).sum::<f64>() / sides.len() as f64;
            square += sides.iter().map(|side| (side.1 - mean_m).powi(2)).sum::<f64>();
            free += sides.len() - 1;
            noise += sides.iter().map(|side| unit_variance / side.0).sum::<f64>();
            count += sides.len() as f64;
        }
        beyond_noise(square, free, noise / count)
    }
}

/// Standard deviation, and its error, from a sum of squares with `free` degrees of freedom after subtracting the
/// variance `noise`; `None` without degrees of freedom.
fn beyond_noise(square: f64, free: usize, noise: f64) -> Option<Estimate> {
    if free == 0 {
        return None;
    }
    let variance = square / free as f64;
    let std = (variance - noise).max(0.0).sqrt();
    // The variance has the standard error v sqrt(2/n); half of that over the standard deviation is the error, at most
    // the root. Waves that raise all sides of a cavity make the noise up to as large again.
    let stray = variance * (2.0 / free as f64).sqrt();
    let error = if std > 0.0 { (0.5 * stray / std).min(stray.sqrt()) } else { stray.sqrt() }.hypot(noise.sqrt());
    Some(Estimate { value: std, error: Some(error) })
}
