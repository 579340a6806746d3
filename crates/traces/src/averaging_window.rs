//! Mean, error and drift over the averaging window.

use super::correlated_noise::{LineErrors, line_errors};
use super::time_series::{line_through, mean_between};

/// Batches into which the window is cut, at most: more tell more of what friction remembers.
const MAX_BATCHES: usize = 20;
/// Batches at least.
const FEWEST_BATCHES: usize = 10;
/// Samples in a batch, at least.
const FEWEST_IN_BATCH: usize = 2;

/// Friction over the window.
///
/// Both errors take the noise of friction for one whose correlation falls exponentially, with a time that the window itself must tell. They
/// are roots of mean variances over what it may be, so that a normal interval holds the truth about as often as it says: the mean is within
/// 1.96 stated errors of the truth in 97 % of windows with white noise, and in 95 % or more with correlation times up to a tenth of
/// the window. The root mean square of the stated errors is then 1.4 to 1.7 times the true spread, as some windows let a longer time seem
/// possible. Still longer correlation times look like a drift: at a sixth of the window 91 % of intervals hold the truth, at a third 77 %. Of
/// two processes at once, one of a hundredth of the window with four times the variance of one of a sixth, 86 % do. An
/// oscillation whose period is within some per cent of a batch, a twentieth of the window, or of a whole fraction of one, averages out in every
/// batch: what its last, incomplete period does to the mean, at most a hundredth of the amplitude, is then known to half of it only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowMean {
    /// Mean over time.
    pub mu: f64,
    /// Standard error of the mean, from batch means about their line.
    pub stderr: f64,
    /// Change of mu over the window by the line through the batch means.
    pub drift: f64,
    /// Its standard error.
    pub drift_stderr: f64,
}

/// Mean and drift of `mu` over `window_s`. Samples weigh by the time they stand for.
pub fn window_mean(time_s: &[f64], mu: &[f64], window_s: [f64; 2]) -> WindowMean {
    let [from, to] = window_s;
    let length = to - from;
    let inside = time_s.partition_point(|&t| t <= to) - time_s.partition_point(|&t| t < from);
    let batches = (inside / FEWEST_IN_BATCH).clamp(FEWEST_BATCHES, MAX_BATCHES);
    let edge = |i: usize| from + length * i as f64 / batches as f64;
    let means: Vec<f64> = (0..batches).map(|i| mean_between(time_s, mu, edge(i), edge(i + 1))).collect();
    let line = line_through(&means);
    let LineErrors { mean, change } = line_errors(&means);
    WindowMean { mu: line.mean, stderr: mean, drift: line.change, drift_stderr: change }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_statistics::Noise;

    #[test]
    fn a_line_has_its_mean_its_drift_and_no_error() {
        // Uneven samples: weights by time, not by number.
        let time: Vec<f64> = (0..500).map(|i| f64::from(i).powf(1.2) * 0.03).collect();
        let mu: Vec<f64> = time.iter().map(|t| 0.2 + 0.001 * t).collect();
        let found = window_mean(&time, &mu, [10.0, 40.0]);
        assert!((found.mu - 0.225).abs() < 1e-12 && (found.drift - 0.03).abs() < 1e-12, "{found:?}");
        assert!(found.stderr < 1e-12 && found.drift_stderr < 1e-12);
    }

    /// What the errors of windows from 10 to 40 s say, and what is true.
    struct Judged {
        /// Root mean square of stated errors over the true spread, of the mean and of the drift.
        stated_over_true: [f64; 2],
        /// Share of windows in which the mean is within 1.96 stated errors of the truth.
        held: f64,
        /// Share of windows whose drift exceeds as many of its errors as are told.
        told: f64,
    }

    /// Windows of noise with samples every `step_s`: `noise` makes as many samples as it is given.
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
            told += u32::from(off[1].abs() > crate::DRIFT_ERRORS * found.drift_stderr);
        }
        let [mean, drift] = [0, 1].map(|place: usize| (stated[place] / spread[place]).sqrt());
        let share = |count: u32| f64::from(count) / f64::from(runs);
        Judged { stated_over_true: [mean, drift], held: share(held), told: share(told) }
    }

    /// Noise whose correlation falls as exp(-t / `memory_s`), at steps of `step_s`; white at 0.
    fn red(noise: &mut Noise, samples: usize, step_s: f64, memory_s: f64) -> Vec<f64> {
        let kept = if memory_s > 0.0 { (-step_s / memory_s).exp() } else { 0.0 };
        let mut value = noise.normal();
        (0..samples)
            .map(|_| {
                let now = value;
                value = kept * value + (1.0 - kept * kept).sqrt() * noise.normal();
                now
            })
            .collect()
    }

    /// Ten batches about their line stated 0.65 of the true spread at 2 s and 0.41 at 5 s, and held the mean in 75 and 55 % of windows.
    #[test]
    fn errors_of_noise_that_remembers_are_about_what_they_say() {
        let mut noise = Noise::new(5);
        // Of 1000 windows a share of 0.95 is known to 0.007, and a ratio to 3 %.
        for (memory_s, mean, drift, held) in [
            (0.0, [1.25, 1.6], [1.1, 1.45], 0.945),
            (0.05, [1.25, 1.6], [1.1, 1.45], 0.945),
            (0.5, [1.3, 1.8], [1.15, 1.5], 0.93),
            (2.0, [1.5, 2.0], [1.25, 1.6], 0.93),
            (3.0, [1.3, 1.65], [1.1, 1.4], 0.92),
            (5.0, [0.95, 1.25], [0.85, 1.15], 0.88),
            // What remains.
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
}
