//! Stick-slip: friction rises slowly while the sample sticks and falls fast when it slips.
//!
//! Friction that wanders by itself turns up and down as well, and among a few turns its falls may happen to be short. But it
//! looks alike forwards and backwards in time, as every stationary Gaussian noise does: which of its swings are falls is then a
//! toss of coins, and the rank sum of their durations among all swings has a known distribution. Stick-slip is what
//! this excludes. A swing without such an arrow of time is an oscillation if its periods are alike, and noise otherwise.

use super::time_series::{median, median_of_three, sample_noise};

/// A reversal counts from this multiple of the sample noise on. The range of three thousand samples of
/// white noise is seven.
const NOISE_FACTOR: f64 = 8.0;
/// ... and from this part of the mean on: smaller ones are of no interest.
const MIN_RELATIVE: f64 = 0.01;
/// Slips in the window that make a regime.
const FEWEST_SLIPS: usize = 4;
/// A slip takes less than this part of a stick.
const MAX_FALL_OVER_RISE: f64 = 0.5;
/// Falls are shorter than rises by this many standard deviations of their rank sum, which are 1 % by chance; four falls shorter than
/// four rises just reach it.
const MIN_ARROW: f64 = 2.3;
/// Periods of an oscillation that is no stick-slip spread by less than this part of their median; those of noise spread by half.
const REGULAR: f64 = 0.15;
/// Periods that are enough to say so.
const FEWEST_PERIODS: usize = 7;

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
    /// By how much falls are shorter than rises, in standard deviations of their rank sum if neither were.
    pub arrow: f64,
}

impl StickSlip {
    /// Falls are much faster than rises, and not by chance: relaxation, not a swing.
    #[must_use]
    pub fn is_relaxation(&self) -> bool {
        self.fall_over_rise < MAX_FALL_OVER_RISE && self.arrow > MIN_ARROW
    }

    /// Periods are alike, and enough of them to say so.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        self.slips > FEWEST_PERIODS && self.period_spread_s < REGULAR * self.period_s
    }
}

/// Oscillation in a window, if there is one: of relaxation or not. `mean` is the mean of `mu`.
pub fn oscillation(time_s: &[f64], mu: &[f64], mean: f64) -> Option<StickSlip> {
    let threshold = (NOISE_FACTOR * sample_noise(mu)).max(MIN_RELATIVE * mean.abs());
    // Along a slope of the whole window every rise is longer than a fall, or shorter.
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
    if drops.len() < FEWEST_SLIPS {
        return None;
    }
    let periods: Vec<f64> = crests.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let arrow = arrow(&falls, &rises);
    let (fall, rise) = (median(falls), median(rises));
    Some(StickSlip {
        amplitude_spread: spread(&drops),
        period_spread_s: spread(&periods),
        slips: drops.len(),
        amplitude: median(drops),
        period_s: median(periods),
        fall_over_rise: fall / rise.max(f64::MIN_POSITIVE),
        arrow,
    })
}

/// The values less their least-squares line, about their mean time.
fn without_slope(time_s: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let count = values.len().max(1) as f64;
    let middle_s = time_s.iter().sum::<f64>() / count;
    let times = || time_s.iter().map(|t| t - middle_s);
    let squares: f64 = times().map(|t| t * t).sum();
    let slope = times().zip(&values).map(|(t, value)| t * value).sum::<f64>() / squares.max(f64::MIN_POSITIVE);
    values.iter_mut().zip(times()).for_each(|(value, t)| *value -= slope * t);
    values
}

/// By how many standard deviations the rank sum of `falls` among all durations lies below what it is on average if falls and
/// rises last alike (Mann and Whitney).
fn arrow(falls: &[f64], rises: &[f64]) -> f64 {
    let mut sorted = rises.to_vec();
    sorted.sort_by(f64::total_cmp);
    // Pairs of which the fall is the longer one; equal ones count half.
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

    /// Red noise: AR(1) of unit deviation and a correlation time, in seconds, every `step_s`.
    fn red(deviates: &mut Noise, count: u32, step_s: f64, correlation_s: f64) -> Vec<f64> {
        let kept = (-step_s / correlation_s).exp();
        let mut value = deviates.normal();
        let next = |_| {
            value = kept * value + (1.0 - kept * kept).sqrt() * deviates.normal();
            value
        };
        (0..count).map(next).collect()
    }

    /// Steps and correlation times of red noise, in seconds.
    const RED: [[f64; 2]; 12] = [
        [0.01, 0.05],
        [0.01, 0.2],
        [0.01, 0.8],
        [0.01, 1.6],
        [0.01, 3.2],
        [0.01, 10.0],
        [0.05, 0.2],
        [0.05, 0.8],
        [0.05, 1.6],
        [0.05, 3.2],
        [0.05, 10.0],
        [0.001, 1.6],
    ];

    #[test]
    fn red_noise_is_neither_stick_slip_nor_an_oscillation() {
        // Half a minute of friction about 0.3. The fourth fall that is shorter by half was enough in up to a tenth of these.
        for [step_s, correlation_s] in RED {
            let seeds = if step_s < 0.01 { 100 } else { 400 };
            let (mut slips, mut swings) = (0, 0);
            for seed in 0..seeds {
                let mut deviates = Noise::new(1000 + seed);
                let count = (30.0 / step_s) as u32;
                let time: Vec<f64> = (0..count).map(|i| f64::from(i) * step_s).collect();
                let deviation = [0.002, 0.006, 0.02][seed as usize % 3];
                let noise = red(&mut deviates, count, step_s, correlation_s).into_iter();
                let mu: Vec<f64> = noise.map(|value| 0.3 + deviation * value).collect();
                let Some(found) = oscillation(&time, &mu, 0.3) else { continue };
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
            // Four slips and more in half a minute; sticks and drops differ by a fifth from one to the next.
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
                swing.is_some_and(|swing| swing.is_relaxation() && (swing.period_s / period_s - 1.0).abs() < 0.2);
            found += u32::from(good);
        }
        assert!(100 * found >= 95 * all, "{found} of {all}");
    }

    #[test]
    fn a_swing_that_rises_as_it_falls_is_told_apart() {
        let (time, mu) = sampled(|t| 0.3 + 0.02 * (2.0 * t).sin(), 5e-4);
        let found = oscillation(&time, &mu, 0.3).unwrap();
        assert!(!found.is_relaxation() && (found.period_s - std::f64::consts::PI).abs() < 0.1, "{found:?}");
        assert!((found.amplitude - 0.04).abs() < 0.003, "{found:?}");
    }
}
