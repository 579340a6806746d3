//! Stick-slip: friction rises slowly while the sample sticks and falls fast when it slips.

use super::time_series::{median, median_of_three, sample_noise};

/// A reversal counts from this multiple of the sample noise on. The range of three thousand samples of
/// white noise is seven.
const NOISE_FACTOR: f64 = 8.0;
/// ... and from this part of the mean on: smaller ones are of no interest.
const LEAST_RELATIVE: f64 = 0.01;
/// Slips in the window that make a regime.
const FEWEST_SLIPS: usize = 4;
/// A slip takes less than this part of a stick.
const MOST_FALL_OVER_RISE: f64 = 0.5;

/// Repeated slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickSlip {
    /// Median drop of mu in a slip.
    pub amplitude: f64,
    /// Spread of the drops: half of what holds the middle two thirds.
    pub amplitude_spread: f64,
    /// Median time from slip to slip, in seconds.
    pub period_s: f64,
    /// Spread of the periods.
    pub period_spread_s: f64,
    /// Slips in the window.
    pub slips: usize,
    /// Median duration of a fall over that of a rise.
    pub fall_over_rise: f64,
}

impl StickSlip {
    /// Falls are much faster than rises: relaxation, not a swing.
    #[must_use]
    pub fn is_relaxation(&self) -> bool {
        self.fall_over_rise < MOST_FALL_OVER_RISE
    }
}

/// Oscillation in a window, if there is one: of relaxation or not. `mean` is the mean of `mu`.
pub fn oscillation(time_s: &[f64], mu: &[f64], mean: f64) -> Option<StickSlip> {
    let threshold = (NOISE_FACTOR * sample_noise(mu)).max(LEAST_RELATIVE * mean.abs());
    let smooth = median_of_three(mu);
    let turns = reversals(&smooth, threshold);
    let (mut drops, mut falls, mut rises, mut crests) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for pair in turns.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let lasted = time_s[to] - time_s[from];
        if smooth[to] < smooth[from] {
            drops.push(smooth[from] - smooth[to]);
            falls.push(lasted);
            crests.push(time_s[from]);
        } else {
            rises.push(lasted);
        }
    }
    if drops.len() < FEWEST_SLIPS {
        return None;
    }
    let periods: Vec<f64> = crests.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (fall, rise) = (median(falls), median(rises));
    Some(StickSlip {
        amplitude_spread: spread(&drops),
        period_spread_s: spread(&periods),
        slips: drops.len(),
        amplitude: median(drops),
        period_s: median(periods),
        fall_over_rise: fall / rise.max(f64::MIN_POSITIVE),
    })
}

/// Half the range of the middle two thirds of the values.
fn spread(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get((share * sorted.len().saturating_sub(1) as f64).round() as usize).copied();
    (at(5.0 / 6.0).unwrap_or(0.0) - at(1.0 / 6.0).unwrap_or(0.0)) / 2.0
}

/// Samples where the values turn by at least `threshold`, crests and troughs in turn.
fn reversals(values: &[f64], threshold: f64) -> Vec<usize> {
    let mut turns = Vec::new();
    let (mut low, mut high) = (0, 0);
    let mut rising = None;
    for i in 0..values.len() {
        if values[i] > values[high] {
            high = i;
        }
        if values[i] < values[low] {
            low = i;
        }
        if rising != Some(false) && values[high] - values[i] >= threshold {
            turns.push(high);
            (rising, low) = (Some(false), i);
        } else if rising != Some(true) && values[i] - values[low] >= threshold {
            turns.push(low);
            (rising, high) = (Some(true), i);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_statistics::Noise;

    fn sampled(shape: impl Fn(f64) -> f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut deviates = Noise::new(7);
        let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.01).collect();
        let mu = time.iter().map(|&t| shape(t) + noise * deviates.normal()).collect();
        (time, mu)
    }

    #[test]
    fn a_sawtooth_has_its_amplitude_and_period() {
        // Rises for 0.72 s, falls within 0.03 s; the period is not a whole number of samples.
        let saw = |t: f64| {
            let phase = (t / 0.753).fract();
            0.3 + 0.04 * if phase < 0.96 { phase / 0.96 } else { (1.0 - phase) / 0.04 }
        };
        let (time, mu) = sampled(saw, 0.001);
        let found = oscillation(&time, &mu, 0.32).unwrap();
        assert!((found.amplitude - 0.04).abs() < 0.003, "{found:?}");
        assert!((found.period_s - 0.753).abs() < 0.01 && found.period_spread_s < 0.02, "{found:?}");
        assert!((38..=40).contains(&found.slips) && found.is_relaxation(), "{found:?}");
    }

    #[test]
    fn noise_alone_and_drift_are_no_stick_slip() {
        for seed in 0..20 {
            let mut deviates = Noise::new(seed);
            let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 0.005).collect();
            let mu: Vec<f64> = time.iter().map(|t| 0.25 + 0.001 * t + 0.01 * deviates.normal()).collect();
            assert_eq!(oscillation(&time, &mu, 0.25), None);
        }
    }

    #[test]
    fn a_swing_that_rises_as_it_falls_is_told_apart() {
        let (time, mu) = sampled(|t| 0.3 + 0.02 * (2.0 * t).sin(), 5e-4);
        let found = oscillation(&time, &mu, 0.3).unwrap();
        assert!(!found.is_relaxation() && (found.period_s - std::f64::consts::PI).abs() < 0.1, "{found:?}");
        assert!((found.amplitude - 0.04).abs() < 0.003, "{found:?}");
    }
}
