//! Stick-slip: friction rises slowly while the sample sticks and falls fast when it slips.
//!
//! Correlated noise rises and falls as well, and among a few reversals the falls may be short by chance. But every
//! stationary Gaussian noise is statistically equal forwards and backwards in time: falls and rises then have equal
//! distributions of durations, and the rank sum of the durations of falls has a known distribution. Stick-slip is an
//! oscillation for which this hypothesis is rejected. Other oscillations are reported if their periods are regular, and
//! are taken for noise otherwise.

use super::time_series::{median, median_of_three, sample_noise};

/// Minimum height of a reversal, in standard deviations of the sample noise (the range of three thousand samples of
/// white noise is about seven).
const NOISE_FACTOR: f64 = 8.0;
/// Minimum height of a reversal, relative to mean friction, because smaller reversals do not matter.
const MIN_RELATIVE: f64 = 0.01;
/// Minimum number of slips in the window.
const MIN_SLIPS: usize = 4;
/// Maximum ratio of the median duration of falls to that of rises in stick-slip.
const MAX_FALL_OVER_RISE: f64 = 0.5;
/// Minimum number of standard deviations, in stick-slip, by which the rank sum of falls is below that expected for
/// equal falls and rises. Noise exceeds this number in 1 % of cases; four falls that are all shorter than four rises
/// just reach it.
const MIN_RANK_DEVIATION: f64 = 2.3;
/// Maximum spread of the periods of a regular oscillation, relative to the median period. Periods of noise spread by
/// half.
const MAX_PERIOD_SPREAD: f64 = 0.15;
/// Minimum number of periods of a regular oscillation.
const MIN_PERIODS: usize = 7;

/// Repeated slips, or another oscillation of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickSlip {
    /// Median drop of the friction coefficient in a slip.
    pub amplitude: f64,
    /// Median time from slip to slip, in seconds.
    pub period_s: f64,
    /// Spread of the periods, in seconds: half the range of their middle two thirds.
    pub period_spread_s: f64,
    /// Number of slips in the window.
    pub slips: usize,
    /// Median duration of falls over median duration of rises.
    pub fall_over_rise: f64,
    /// Number of standard deviations by which the rank sum of the durations of falls is below that expected for equal
    /// falls and rises.
    pub arrow: f64,
}

impl StickSlip {
    /// Whether falls are significantly faster than rises: a relaxation oscillation, or stick-slip.
    pub fn is_relaxation(&self) -> bool {
        self.fall_over_rise < MAX_FALL_OVER_RISE && self.arrow > MIN_RANK_DEVIATION
    }

    /// Whether periods are regular, and enough of them were seen.
    pub fn is_regular(&self) -> bool {
        self.slips > MIN_PERIODS && self.period_spread_s < MAX_PERIOD_SPREAD * self.period_s
    }
}

/// Finds the oscillation in a window, with the times of its crests; `None` if there are too few reversals. `mean` is the
/// mean of `mu`.
pub fn oscillation(time_s: &[f64], mu: &[f64], mean: f64) -> Option<(StickSlip, Vec<f64>)> {
    let threshold = (NOISE_FACTOR * sample_noise(mu)).max(MIN_RELATIVE * mean.abs());
    // A slope over the window would lengthen all rises, or all falls.
    let smooth = without_slope(time_s, median_of_three(mu));
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
    if drops.len() < MIN_SLIPS {
        return None;
    }
    let periods: Vec<f64> = crests.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let arrow = arrow(&falls, &rises);
    let (fall, rise) = (median(falls), median(rises));
    let swing = StickSlip {
        period_spread_s: spread(&periods),
        slips: drops.len(),
        amplitude: median(drops),
        period_s: median(periods),
        fall_over_rise: fall / rise.max(f64::MIN_POSITIVE),
        arrow,
    };
    Some((swing, crests))
}

/// Subtracts the least-squares slope, about the mean time.
fn without_slope(time_s: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let count = values.len().max(1) as f64;
    let middle_s = time_s.iter().sum::<f64>() / count;
    let times = || time_s.iter().map(|t| t - middle_s);
    let squares: f64 = times().map(|t| t * t).sum();
    let slope = times().zip(&values).map(|(t, value)| t * value).sum::<f64>() / squares.max(f64::MIN_POSITIVE);
    values.iter_mut().zip(times()).for_each(|(value, t)| *value -= slope * t);
    values
}

/// Number of standard deviations by which the rank sum of `falls` is below that expected if falls and rises have equal
/// durations (Mann and Whitney). Both are durations in seconds.
fn arrow(falls: &[f64], rises: &[f64]) -> f64 {
    let mut sorted = rises.to_vec();
    sorted.sort_by(f64::total_cmp);
    // Number of pairs in which the fall is longer; ties count half.
    let longer: f64 = falls
        .iter()
        .map(|fall| {
            (sorted.partition_point(|rise| rise < fall) + sorted.partition_point(|rise| rise <= fall)) as f64 / 2.0
        })
        .sum();
    let (m, n) = (falls.len() as f64, rises.len() as f64);
    (m * n / 2.0 - longer) / (m * n * (m + n + 1.0) / 12.0).sqrt().max(f64::MIN_POSITIVE)
}

/// Half the range of the middle two thirds of the values.
fn spread(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get((share * sorted.len().saturating_sub(1) as f64).round() as usize).copied();
    (at(5.0 / 6.0).unwrap_or(0.0) - at(1.0 / 6.0).unwrap_or(0.0)) / 2.0
}

/// Indices of crests and troughs, alternating, whose values differ by at least `threshold`.
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
    use crate::tests::red;
    use slipgrid_base::statistics::Noise;

    fn sampled(shape: impl Fn(f64) -> f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut deviates = Noise::new(7);
        let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.01).collect();
        let mu = time.iter().map(|&t| shape(t) + noise * deviates.normal()).collect();
        (time, mu)
    }

    #[test]
    fn a_sawtooth_has_its_amplitude_and_period() {
        // Rises for 0.72 s and falls within 0.03 s; the period is no whole number of samples.
        let saw = |t: f64| {
            let phase = (t / 0.753).fract();
            0.3 + 0.04 * if phase < 0.96 { phase / 0.96 } else { (1.0 - phase) / 0.04 }
        };
        let (time, mu) = sampled(saw, 0.001);
        let (found, _) = oscillation(&time, &mu, 0.32).unwrap();
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
    fn red_noise_is_neither_stick_slip_nor_an_oscillation() {
        // Half a minute of friction of about 0.3. A test of four falls shorter by half was wrong in up to a tenth of
        // these.
        let times_s = [0.05, 0.2, 0.8, 1.6, 3.2, 10.0];
        let all = [(0.01, &times_s[..]), (0.05, &times_s[1..]), (0.001, &times_s[3..4])].into_iter();
        for (step_s, correlation_s) in all.flat_map(|(step_s, of)| of.iter().map(move |&time_s| (step_s, time_s))) {
            let seeds = if step_s < 0.01 { 100 } else { 400 };
            let (mut slips, mut swings) = (0, 0);
            for seed in 0..seeds {
                let mut deviates = Noise::new(1000 + seed);
                let count = (30.0 / step_s) as u32;
                let time: Vec<f64> = (0..count).map(|i| f64::from(i) * step_s).collect();
                let deviation = [0.002, 0.006, 0.02][seed as usize % 3];
                let noise = red(&mut deviates, time.len(), step_s, correlation_s).into_iter();
                let mu: Vec<f64> = noise.map(|value| 0.3 + deviation * value).collect();
                let Some((found, _)) = oscillation(&time, &mu, 0.3) else { continue };
                slips += u64::from(found.is_relaxation());
                swings += u64::from(!found.is_relaxation() && found.is_regular());
            }
            assert!(
                50 * slips < seeds && 50 * swings < seeds,
                "{step_s} {correlation_s}: {slips} and {swings} of {seeds}"
            );
        }
    }

    #[test]
    fn stick_slip_is_found_in_noise_and_where_it_is_not_regular() {
        let (mut found, mut all) = (0, 0);
        for seed in 0..200_u64 {
            let mut deviates = Noise::new(seed);
            let mut next = |from: f64, to: f64| from + (to - from) * deviates.uniform();
            // Four or more slips in half a minute; durations and drops vary by a fifth.
            let (period_s, drop, fall, step_s) = (next(0.2, 6.0), next(0.02, 0.08), next(0.03, 0.15), 0.01);
            let (mut since_s, mut lasts_s, mut from, mut top) = (0.0, period_s, 0.3, 0.3 + drop);
            let mut mu = Vec::new();
            for _ in 0..3000 {
                since_s += step_s;
                if since_s > lasts_s {
                    (since_s, lasts_s) = (0.0, period_s * next(0.8, 1.2));
                    (from, top) = (0.3, 0.3 + drop * next(0.8, 1.2));
                }
                let phase = since_s / lasts_s;
                mu.push(if phase < 1.0 - fall {
                    from + (top - from) * phase / (1.0 - fall)
                } else {
                    from + (top - from) * (1.0 - phase) / fall
                });
            }
            let noise = red(&mut Noise::new(900 + seed), 3000, step_s, 1.6);
            let white = red(&mut Noise::new(5000 + seed), 3000, step_s, 1e-6);
            let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * step_s).collect();
            let mu: Vec<f64> =
                mu.iter().zip(noise).zip(white).map(|((mu, red), white)| mu + 0.003 * red + 5e-4 * white).collect();
            let swing = oscillation(&time, &mu, 0.32);
            all += 1;
            let good =
                swing.is_some_and(|(swing, _)| swing.is_relaxation() && (swing.period_s / period_s - 1.0).abs() < 0.2);
            found += u32::from(good);
        }
        assert!(100 * found >= 95 * all, "{found} of {all}");
    }

    #[test]
    fn a_swing_that_rises_as_it_falls_is_told_apart() {
        let (time, mu) = sampled(|t| 0.3 + 0.02 * (2.0 * t).sin(), 5e-4);
        let (found, _) = oscillation(&time, &mu, 0.3).unwrap();
        assert!(!found.is_relaxation() && (found.period_s - std::f64::consts::PI).abs() < 0.1, "{found:?}");
        assert!((found.amplitude - 0.04).abs() < 0.003, "{found:?}");
    }
}
