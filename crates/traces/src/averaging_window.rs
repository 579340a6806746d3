//! Mean, error and drift over the averaging window.

use super::correlated_noise::{LineErrors, line_errors};
use super::time_series::{line_through, mean_between};

/// Maximum number of batches into which the window is cut. More batches resolve the correlation of the noise better.
const MAX_BATCHES: usize = 20;
/// Minimum number of batches, even if samples are few.
const MIN_BATCHES: usize = 10;
/// Minimum number of samples in a batch.
const MIN_SAMPLES_PER_BATCH: usize = 2;

/// Mean, standard errors and drift of friction over the window.
///
/// The errors assume noise whose correlation falls exponentially, with a correlation time that is estimated from the
/// samples in the window ([`line_errors`]). Each stated variance is a mean over the possible correlation times, so that
/// a normal interval has about its nominal coverage: the mean is within 1.96 standard errors of the truth in 97 % of
/// windows with white noise, and in 95 % or more with correlation times up to a tenth of the window. The root mean
/// square of the stated errors is then 1.4 to 1.7 times the true spread, because some windows admit a longer
/// correlation time. Still longer correlation times look like a drift: coverage is 91 % at a sixth of the window and 77
/// % at a third. Coverage is 86 % for two processes at once, one with a hundredth of the window as its correlation time
/// and four times the variance of another with a sixth.
///
/// The means of an oscillation over batches differ by incomplete periods, and the stated errors are up to a hundred times
/// too large. Those of stick-slip and of regular oscillations therefore come from batches of whole periods
/// ([`WindowMean::of_swings`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowMean {
    /// Mean over time of the friction coefficient.
    pub mu: f64,
    /// Standard error of the mean, from the deviations of the batch means from their least-squares line, in quadrature
    /// with those of a subtracted zero.
    pub stderr: f64,
    /// Change of the friction coefficient over the window, from the line through the batch means.
    pub drift: f64,
    /// Standard error of the drift.
    pub drift_stderr: f64,
}

impl WindowMean {
    /// Returns mean and drift of `mu`, with their errors, over the whole swings between `crests_s` within `window_s`; this
    /// mean if there are fewer than [`MIN_BATCHES`].
    pub fn of_swings(self, time_s: &[f64], mu: &[f64], window_s: [f64; 2], crests_s: &[f64]) -> Self {
        let periods = crests_s.len().saturating_sub(1);
        if periods < MIN_BATCHES {
            return self;
        }
        let batches = periods.min(MAX_BATCHES);
        let edges_s: Vec<f64> = (0..=batches).map(|i| crests_s[i * periods / batches]).collect();
        let ends_s = [edges_s[0], edges_s[batches]];
        let whole = of_batches(time_s, mu, &edges_s);
        let longer = (window_s[1] - window_s[0]) / (ends_s[1] - ends_s[0]);
        Self {
            // Batches of equal numbers of periods differ in length.
            mu: mean_between(time_s, mu, ends_s[0], ends_s[1]),
            drift: longer * whole.drift,
            drift_stderr: longer * whole.drift_stderr,
            ..whole
        }
    }
}

/// Computes mean and drift of `mu` over `window_s`, with their errors. Samples are weighted by the time that they
/// cover.
pub fn window_mean(time_s: &[f64], mu: &[f64], window_s: [f64; 2]) -> WindowMean {
    let [from, to] = window_s;
    let length = to - from;
    let inside = time_s.partition_point(|&t| t <= to) - time_s.partition_point(|&t| t < from);
    let batches = (inside / MIN_SAMPLES_PER_BATCH).clamp(MIN_BATCHES, MAX_BATCHES);
    let edges_s: Vec<f64> = (0..=batches).map(|i| from + length * i as f64 / batches as f64).collect();
    of_batches(time_s, mu, &edges_s)
}

/// Mean of the means over the batches between `edges_s`, with the drift of their line from the first to the last edge.
fn of_batches(time_s: &[f64], mu: &[f64], edges_s: &[f64]) -> WindowMean {
    let means: Vec<f64> = edges_s.windows(2).map(|ends_s| mean_between(time_s, mu, ends_s[0], ends_s[1])).collect();
    let line = line_through(&means);
    let LineErrors { mean, change } = line_errors(&means);
    WindowMean { mu: line.mean, stderr: mean, drift: line.change, drift_stderr: change }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stick_slip::oscillation;
    use crate::tests::red;
    use slipgrid_base::statistics::Noise;

    #[test]
    fn a_line_has_its_mean_its_drift_and_no_error() {
        // Samples are uneven, so that weighting by time and by count differ.
        let time: Vec<f64> = (0..500).map(|i| f64::from(i).powf(1.2) * 0.03).collect();
        let mu: Vec<f64> = time.iter().map(|t| 0.2 + 0.001 * t).collect();
        let found = window_mean(&time, &mu, [10.0, 40.0]);
        assert!((found.mu - 0.225).abs() < 1e-12 && (found.drift - 0.03).abs() < 1e-12, "{found:?}");
        assert!(found.stderr < 1e-12 && found.drift_stderr < 1e-12);
    }

    /// Errors stated for windows from 10 to 40 s, compared with the truth.
    struct Judged {
        /// Root mean square of the stated errors over the true spread, for the mean and for the drift.
        stated_over_true: [f64; 2],
        /// Share of windows in which the mean is within 1.96 standard errors of the truth.
        held: f64,
        /// Share of windows in which the drift is flagged as significant.
        told: f64,
    }

    /// Judges windows of noise with a sample every `step_s`; `noise` makes the given number of samples.
    fn judge(runs: u32, step_s: f64, mut noise: impl FnMut(usize) -> Vec<f64>) -> Judged {
        let samples = (30.0 / step_s).round() as usize + 1;
        let time: Vec<f64> = (0..samples).map(|i| 10.0 + step_s * i as f64).collect();
        let (mut spread, mut stated, mut held, mut told) = ([0.0; 2], [0.0; 2], 0, 0);
        for _ in 0..runs {
            let mu: Vec<f64> = noise(samples).iter().map(|value| 0.25 + 0.01 * value).collect();
            let found = window_mean(&time, &mu, [10.0, 40.0]);
            let off = [found.mu - 0.25, found.drift];
            for (place, error) in [found.stderr, found.drift_stderr].into_iter().enumerate() {
                spread[place] += off[place] * off[place];
                stated[place] += error * error;
            }
            held += u32::from(off[0].abs() < 1.96 * found.stderr);
            told += u32::from(off[1].abs() > crate::FLAGGED_DRIFT_STDERRS * found.drift_stderr);
        }
        let [mean, drift] = [0, 1].map(|place: usize| (stated[place] / spread[place]).sqrt());
        let share = |count: u32| f64::from(count) / f64::from(runs);
        Judged { stated_over_true: [mean, drift], held: share(held), told: share(told) }
    }

    /// Errors from ten batches about their line were 0.65 of the true spread at 2 s and 0.41 at 5 s, with a coverage of
    /// 75 and 55 %.
    #[test]
    fn errors_of_noise_that_remembers_are_about_what_they_say() {
        let mut noise = Noise::new(5);
        // With 1000 windows a coverage of 0.95 is known to 0.007, and a ratio to 3 %.
        for (memory_s, mean, drift, held) in [
            (0.0, [1.25, 1.6], [1.1, 1.45], 0.945),
            (0.05, [1.25, 1.6], [1.1, 1.45], 0.945),
            (0.5, [1.3, 1.8], [1.15, 1.5], 0.93),
            (2.0, [1.5, 2.0], [1.25, 1.6], 0.93),
            (3.0, [1.3, 1.65], [1.1, 1.4], 0.92),
            (5.0, [0.95, 1.25], [0.85, 1.15], 0.88),
            // Known limit of the method.
            (10.0, [0.58, 0.76], [0.65, 0.84], 0.73),
        ] {
            let found = judge(1000, 0.1, |samples| red(&mut noise, samples, 0.1, memory_s));
            let words = format!("{memory_s} s: {:?}, {}, {}", found.stated_over_true, found.held, found.told);
            for (ratio, [least, most]) in found.stated_over_true.into_iter().zip([mean, drift]) {
                assert!(ratio > least && ratio < most, "{words}");
            }
            assert!(found.held > held && found.held < 0.985, "{words}");
            assert!(memory_s > 2.0 || found.told < 0.03, "{words}");
        }
    }

    #[test]
    fn sensor_noise_over_slow_friction_and_few_samples_leave_errors_what_they_are() {
        let mut noise = Noise::new(6);
        let both = judge(1000, 0.1, |samples| {
            red(&mut noise, samples, 0.1, 2.0).iter().map(|slow| slow + noise.normal()).collect()
        });
        assert!(both.stated_over_true[0] > 1.4 && both.held > 0.92, "{} {}", both.stated_over_true[0], both.held);
        // 21 samples make ten batches.
        let few = judge(1000, 1.5, |samples| red(&mut noise, samples, 1.5, 0.0));
        assert!(few.held > 0.94 && few.stated_over_true[0] < 1.8, "{} {}", few.stated_over_true[0], few.held);
    }

    #[test]
    fn an_oscillation_has_no_smaller_error_than_its_part_of_a_period() {
        let mut noise = Noise::new(7);
        for period_s in [0.5, 0.9, 3.1, 7.0] {
            let found = judge(400, 0.05, |samples| {
                let phase = noise.uniform();
                let at = |i: usize| (std::f64::consts::TAU * (0.05 * i as f64 / period_s + phase)).sin();
                (0..samples).map(|i| at(i) + 0.1 * noise.normal()).collect()
            });
            assert!(found.held > 0.93, "{period_s} s: {} {:?}", found.held, found.stated_over_true);
        }
    }

    /// Sawteeth with periods and heights that are equal, or vary by 20 %, with a random phase. Batches of equal length
    /// stated 18 to 50 times the spread of the means over whole swings, which is a third to a tenth of that over the
    /// window.
    #[test]
    fn errors_of_stick_slip_are_about_what_they_say() {
        let mut noise = Noise::new(7);
        for (period_s, irregular) in [(0.53, 0.0), (0.93, 0.2), (1.57, 0.0), (1.57, 0.2), (2.63, 0.0), (2.63, 0.2)] {
            let (mut held, mut spread, mut stated) = (0, 0.0, 0.0);
            for _ in 0..400 {
                // Friction rises during 9 tenths of a period from 0.25 - h / 2 to 0.25 + h / 2.
                let (mut time_s, mut height, mut lasts_s) = (vec![], 0.04, period_s);
                let mut since_s = noise.uniform() * period_s;
                let mut mu = Vec::new();
                for i in 0..=1500 {
                    time_s.push(10.0 + 0.02 * f64::from(i));
                    let phase: f64 = since_s / lasts_s;
                    let saw = if phase < 0.9 { phase / 0.9 } else { (1.0 - phase) / 0.1 };
                    mu.push(0.25 + height * (saw - 0.5) + 5e-4 * noise.normal());
                    since_s += 0.02;
                    if since_s > lasts_s {
                        since_s -= lasts_s;
                        lasts_s = period_s * (1.0 + irregular * (2.0 * noise.uniform() - 1.0));
                        height = 0.04 * (1.0 + irregular * (2.0 * noise.uniform() - 1.0));
                    }
                }
                let window_s = [10.0, 40.0];
                let found = window_mean(&time_s, &mu, window_s);
                let (_, crests_s) = oscillation(&time_s, &mu, found.mu).unwrap();
                let new = found.of_swings(&time_s, &mu, window_s, &crests_s);
                stated += new.stderr * new.stderr;
                spread += (new.mu - 0.25).powi(2);
                held += u32::from((new.mu - 0.25).abs() < 1.96 * new.stderr);
            }
            let ratio = (stated / spread).sqrt();
            assert!(ratio > 1.2 && ratio < 6.0 && held > 388, "{period_s} {irregular}: {held} of 400, {ratio}");
        }
    }
}
