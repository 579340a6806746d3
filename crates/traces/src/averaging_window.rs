//! Mean, error and drift over the averaging window.

use super::time_series::{line_through, mean_between};

/// Batches into which the window is cut. More would be shorter than what friction remembers, fewer
/// would leave the error itself uncertain.
const BATCHES: usize = 10;

/// Friction over the window.
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
    let edge = |i: usize| from + length * i as f64 / BATCHES as f64;
    let means: Vec<f64> = (0..BATCHES).map(|i| mean_between(time_s, mu, edge(i), edge(i + 1))).collect();
    let line = line_through(&means);
    WindowMean {
        mu: line.mean,
        stderr: (line.variance / BATCHES as f64).sqrt(),
        drift: line.change,
        drift_stderr: line.change_stderr,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_mean_its_drift_and_no_error() {
        // Uneven samples: weights by time, not by number.
        let time: Vec<f64> = (0..500).map(|i| f64::from(i).powf(1.2) * 0.03).collect();
        let mu: Vec<f64> = time.iter().map(|t| 0.2 + 0.001 * t).collect();
        let found = window_mean(&time, &mu, [10.0, 40.0]);
        assert!((found.mu - 0.225).abs() < 1e-12 && (found.drift - 0.03).abs() < 1e-12, "{found:?}");
        assert!(found.stderr < 1e-12 && found.drift_stderr < 1e-12);
    }

    #[test]
    fn the_standard_error_of_white_noise_is_its_deviation_over_the_root_of_the_samples() {
        let mut noise = slipgrid_statistics::Noise::new(5);
        let time: Vec<f64> = (0..=4000).map(|i| f64::from(i) * 0.01).collect();
        let runs = 200;
        let (mut squares, mut stated) = (0.0, 0.0);
        for _ in 0..runs {
            let mu: Vec<f64> = time.iter().map(|_| 0.25 + 0.01 * noise.normal()).collect();
            let found = window_mean(&time, &mu, [10.0, 40.0]);
            squares += (found.mu - 0.25).powi(2);
            stated += found.stderr.powi(2);
        }
        // 0.01 / sqrt(3000); the spread of 200 runs is known to 5 %, the stated errors likewise.
        let expected = 0.01 / 3000.0_f64.sqrt();
        let spread = (squares / f64::from(runs)).sqrt();
        let stated = (stated / f64::from(runs)).sqrt();
        assert!((spread / expected - 1.0).abs() < 0.15 && (stated / expected - 1.0).abs() < 0.1, "{spread} {stated}");
    }
}
