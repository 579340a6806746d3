//! Speed from a recorded position.

use super::time_series::{median, sample_noise};

/// Travel between two samples is trusted if it is at least this many quantization steps of the position (or standard
/// deviations of its noise, if larger).
const MIN_QUANTIZATION_STEPS: f64 = 5.0;
/// Minimum number of comparison intervals in the window: samples are compared over at most a fiftieth of the window, so
/// that no comparison spans a reversal.
const MIN_STEPS_PER_WINDOW: usize = 50;
/// In reciprocating sliding, speeds above this fraction of the highest speed (the 98 % quantile) count as the middle of
/// a stroke.
const MID_STROKE_SPEED: f64 = 0.5;

/// Estimates the speed from a recorded position, in m/s: the median of |dx/dt| over the samples from `from_s` to
/// `to_s`, in seconds since `start_s` on the clock of `time_s`. In reciprocating sliding only speeds in the middle of
/// the strokes count. Returns `None` if the position was not recorded, does not change, or is too coarse. Values that
/// are not finite are skipped; surplus elements of the longer slice are ignored.
pub fn speed_of_position(
    time_s: &[f64],
    start_s: f64,
    position_m: &[f64],
    [from_s, to_s]: [f64; 2],
    reciprocating: bool,
) -> Option<f64> {
    let samples: Vec<(f64, f64)> = time_s
        .iter()
        .zip(position_m)
        .map(|(t, x)| (t - start_s, *x))
        .filter(|(t, x)| *t >= from_s && *t <= to_s && x.is_finite())
        .collect();
    let positions: Vec<f64> = samples.iter().map(|(_, x)| *x).collect();
    let steps = positions.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let finest = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let grain = finest.max(sample_noise(&positions));
    let mut step = 1;
    while step * MIN_STEPS_PER_WINDOW <= samples.len() {
        let pairs = || samples.iter().zip(&samples[step..]).filter(|((t, _), (later, _))| later > t);
        let ways: Vec<f64> = pairs().map(|((_, x), (_, later))| (later - x).abs()).collect();
        if median(ways) >= MIN_QUANTIZATION_STEPS * grain {
            let mut rates: Vec<f64> = pairs().map(|((t, x), (later, y))| ((y - x) / (later - t)).abs()).collect();
            if reciprocating {
                rates.sort_by(f64::total_cmp);
                let fastest = rates.get(rates.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(0.0);
                rates.retain(|rate| *rate > MID_STROKE_SPEED * fastest);
            }
            return Some(median(rates)).filter(|speed| *speed > 0.0);
        }
        step *= 2;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::statistics::Noise;

    const WINDOW_S: [f64; 2] = [10.0, 40.0];

    /// Speed found for `position` at 50 Hz over 45 s, on a clock that begins at 7 s.
    fn found(reciprocating: bool, position: impl FnMut(f64) -> f64) -> Option<f64> {
        let time_s: Vec<f64> = (0..=2250).map(|i| 0.02 * f64::from(i)).collect();
        let position_m: Vec<f64> = time_s.iter().copied().map(position).collect();
        let clock: Vec<f64> = time_s.iter().map(|t| t + 7.0).collect();
        speed_of_position(&clock, 7.0, &position_m, WINDOW_S, reciprocating)
    }

    #[test]
    fn the_speed_of_lines_strokes_and_cranks() {
        let close = |speed: Option<f64>, expected: f64, within: f64| {
            assert!(speed.is_some_and(|speed| (speed / expected - 1.0).abs() < within), "{speed:?}, not {expected}");
        };
        close(found(false, |t| 2e-3 * t), 2e-3, 1e-9);
        // The sample is at rest outside the window.
        close(found(false, |t| 2e-3 * t.clamp(9.0, 41.0)), 2e-3, 1e-9);
        let triangle = |t: f64| 2e-3 * (t % 2.0 - 1.0).abs();
        close(found(true, triangle), 2e-3, 1e-9);
        // 1 s per turn, amplitude 1 mm: 6.3 mm/s in the middle; the mean over the middle half of a stroke is nine
        // tenths of it.
        let crank = |t: f64| 1e-3 * (std::f64::consts::TAU * t).sin();
        close(found(true, crank), 0.9 * 1e-3 * std::f64::consts::TAU, 0.1);
        let mut noise = Noise::new(4);
        close(found(false, |t| 2e-3 * t + 1e-5 * noise.normal()), 2e-3, 0.05);
        // Positions rounded to 0.1 mm: 2.5 samples per quantization step, so that travel is known to half a step in
        // five.
        close(found(false, |t| (2e-3 * t / 1e-4).round() * 1e-4), 2e-3, 0.1);
    }

    #[test]
    fn a_position_that_says_nothing_has_no_speed() {
        let mut noise = Noise::new(4);
        assert_eq!(found(false, |_| 0.012), None);
        assert_eq!(found(false, |_| 0.012 + 1e-6 * noise.normal()), None);
        assert_eq!(found(false, |t| (2e-3 * t / 0.01).round() * 0.01), None);
        assert_eq!(found(false, |_| f64::NAN), None);
        for times in [&[][..], &[0.0], &[0.0; 40], &[f64::NAN; 40]] {
            assert_eq!(speed_of_position(times, 0.0, &[0.0; 40], WINDOW_S, true), None);
        }
    }
}
