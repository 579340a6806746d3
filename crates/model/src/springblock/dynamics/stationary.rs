//! Start of the stationary part of a record: the marginal standard error rule.
//!
//! From a record y_1 ... y_n of group means, the first d* means are left out, where d* minimizes the standard error of
//! the mean of the remaining ones,
//!
//! ```text
//! d* = arg min_d  1/(n - d)^2  sum_{i > d} (y_i - mean_{i > d})^2,
//! ```
//!
//! and the record is stationary if d* is at most half of the groups (White, Simulation 69, 1997, with groups of five:
//! MSER-5).

/// Number of values in a group.
const GROUP: usize = 5;
/// Minimum number of groups that remain; a record with fewer than twice this number is too short for a decision.
const MIN_GROUPS: usize = 8;
/// Noise level, relative to the mean of the remaining groups, below which changes are ignored, so that a record that
/// drifts only by rounding is stationary.
const NOISE_LEVEL: f64 = 1e-4;

/// Returns the number of leading values of `record` to leave out, or `None` if the record is too short. At least
/// `min_values` values remain, since a few values around the turning point of an oscillation hardly differ.
pub fn stationary_from(record: &[f64], min_values: usize) -> Option<usize> {
    let groups: Vec<f64> = record.chunks_exact(GROUP).map(|group| group.iter().sum::<f64>() / GROUP as f64).collect();
    let min_values = min_values.div_ceil(GROUP).max(MIN_GROUPS);
    if groups.len() < min_values.max(2 * MIN_GROUPS) {
        return None;
    }
    // From the end: mean and sum of squared deviations (Welford).
    let (mut mean, mut squares) = (0.0, 0.0);
    let mut best: Option<(f64, usize)> = None;
    for (kept, (first, value)) in (1..).zip(groups.iter().enumerate().rev()) {
        let n = f64::from(kept);
        let step = value - mean;
        mean += step / n;
        squares += step * (value - mean);
        let noise = NOISE_LEVEL * mean;
        let marginal = (squares + n * noise * noise) / (n * n);
        // Among equal errors prefer the start that leaves out the fewest values.
        if kept as usize >= min_values && best.is_none_or(|(min_values, _)| marginal <= min_values) {
            best = Some((marginal, first));
        }
    }
    best.map(|(_, first)| first * GROUP)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::tests::samples::uniform;

    fn noise(count: usize) -> Vec<f64> {
        let mut uniform = uniform(5);
        (0..count).map(|_| uniform() - 0.5).collect()
    }

    #[test]
    fn a_constant_and_noise_are_stationary_from_about_their_beginning() {
        assert_eq!(stationary_from(&[0.3; 200], 0), Some(0));
        let noisy: Vec<f64> = noise(2000).iter().map(|noise| 0.3 + 0.01 * noise).collect();
        assert!(stationary_from(&noisy, 0).unwrap() < 200);
        assert_eq!(stationary_from(&[0.3; 79], 0), None);
        let swinging: Vec<f64> = (0..2000).map(|i| 0.3 + 0.1 * (0.02 * f64::from(i)).sin()).collect();
        // Ten periods.
        assert_eq!(stationary_from(&swinging[..1000], 3142), None);
        assert!(stationary_from(&swinging.repeat(2), 3142).unwrap() < 900);
    }

    #[test]
    fn what_decays_is_left_out_and_what_does_not_end_is_not_stationary() {
        let decaying = |time: f64| -> Vec<f64> {
            noise(2000)
                .iter()
                .enumerate()
                .map(|(i, noise)| 0.3 - 0.2 * (-(i as f64) / time).exp() + 0.01 * noise)
                .collect()
        };
        let from = stationary_from(&decaying(50.0), 0).unwrap();
        // 0.2 exp(-t/50) falls below the noise of a mean at about 250.
        assert!((150..500).contains(&from), "{from}");
        assert!(stationary_from(&decaying(1000.0), 0).unwrap() > 1000);
        let ramp: Vec<f64> = (0..2000).map(|i| 1e-4 * f64::from(i)).collect();
        assert!(stationary_from(&ramp, 0).unwrap() > 1900);
    }
}
