//! Speed from a recorded position.

use super::lag::turning_times;
use super::time_series::{median, sample_noise, value_at};

/// Travel between two samples is trusted if it is at least this many quantization steps of the position (or standard
/// deviations of its noise, if larger).
const MIN_QUANTIZATION_STEPS: f64 = 5.0;
/// Minimum number of comparison intervals in the window: samples are compared over at most a fiftieth of the window, so
/// that no comparison spans a reversal.
const MIN_STEPS_PER_WINDOW: usize = 50;
/// Changes of travel below this fraction of the longest travel are rounding errors of the arithmetic.
const MIN_CHANGE: f64 = 1e-6;

/// Estimates the speed from a recorded position, in m/s, over the samples from `from_s` to `to_s`, in seconds since
/// `start_s` on the clock of `time_s`. In one direction it is the median of |dx/dt|. In reciprocating sliding it is the
/// median over the strokes of the mean speed in their middle, the fraction `stroke_share` of their duration; of a
/// distance that only rises, the median of the fastest samples, this fraction of them. Returns `None` if the position
/// was not recorded, does not change, or is too coarse. Values that are not finite are skipped; surplus elements of the
/// longer slice are ignored.
pub fn speed_of_position(
    time_s: &[f64],
    start_s: f64,
    position_m: &[f64],
    [from_s, to_s]: [f64; 2],
    stroke_share: Option<f64>,
) -> Option<f64> {
    let samples = time_s.iter().zip(position_m).map(|(t, x)| (t - start_s, *x));
    let (times, positions): (Vec<f64>, Vec<f64>) =
        samples.filter(|(t, x)| *t >= from_s && *t <= to_s && x.is_finite()).unzip();
    let steps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let longest = steps.iter().fold(0.0_f64, |longest, step| longest.max(step.abs()));
    // A line that is recorded exactly has equal steps; rounding makes them differ by one step of quantization.
    let changes = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let finest = changes.filter(|change| *change > MIN_CHANGE * longest).reduce(f64::min).unwrap_or(0.0);
    let least = MIN_QUANTIZATION_STEPS * finest.max(sample_noise(&positions));
    if let Some(share) = stroke_share {
        let (ways, rates) = middles(&times, &positions, share);
        if !rates.is_empty() {
            return Some(median(rates)).filter(|speed| *speed > 0.0 && median(ways) >= least);
        }
    }
    let mut step = 1;
    while step * MIN_STEPS_PER_WINDOW <= times.len() {
        let pairs = || (step..times.len()).map(|at| (at - step, at)).filter(|&(from, to)| times[to] > times[from]);
        if median(pairs().map(|(from, to)| (positions[to] - positions[from]).abs()).collect()) >= least {
            let mut rates: Vec<f64> = pairs()
                .map(|(from, to)| ((positions[to] - positions[from]) / (times[to] - times[from])).abs())
                .collect();
            rates.sort_by(|a, b| b.total_cmp(a));
            rates.truncate((stroke_share.unwrap_or(1.0) * rates.len() as f64).ceil() as usize);
            return Some(median(rates)).filter(|speed| *speed > 0.0);
        }
        step *= 2;
    }
    None
}

/// Travel, in metres, and mean speed, in m/s, over the middle of every complete stroke.
fn middles(times: &[f64], positions: &[f64], share: f64) -> (Vec<f64>, Vec<f64>) {
    let turns = turning_times(times, positions);
    let of_stroke = |turns: &[f64]| {
        let cut_s = (1.0 - share) / 2.0 * (turns[1] - turns[0]);
        let [from_s, to_s] = [turns[0] + cut_s, turns[1] - cut_s];
        let way = (value_at(times, positions, to_s) - value_at(times, positions, from_s)).abs();
        (way, way / (to_s - from_s))
    };
    turns.windows(2).filter(|turns| turns[1] > turns[0]).map(of_stroke).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::statistics::Noise;

    const WINDOW_S: [f64; 2] = [10.0, 40.0];

    /// Speed found for `position` at 50 Hz over 45 s, on a clock that begins at 7 s.
    fn found(share: Option<f64>, position: impl FnMut(f64) -> f64) -> Option<f64> {
        let time_s: Vec<f64> = (0..=2250).map(|i| 0.02 * f64::from(i)).collect();
        let position_m: Vec<f64> = time_s.iter().copied().map(position).collect();
        let clock: Vec<f64> = time_s.iter().map(|t| t + 7.0).collect();
        speed_of_position(&clock, 7.0, &position_m, WINDOW_S, share)
    }

    #[test]
    fn the_speed_of_lines_strokes_and_cranks() {
        let close = |speed: Option<f64>, expected: f64, within: f64| {
            assert!(speed.is_some_and(|speed| (speed / expected - 1.0).abs() < within), "{speed:?}, not {expected}");
        };
        close(found(None, |t| 2e-3 * t), 2e-3, 1e-9);
        // The sample is at rest outside the window.
        close(found(None, |t| 2e-3 * t.clamp(9.0, 41.0)), 2e-3, 1e-9);
        let triangle = |t: f64| 2e-3 * (t % 2.0 - 1.0).abs();
        close(found(Some(0.5), triangle), 2e-3, 1e-9);
        // 1 s per turn, amplitude 1 mm: v = 2 pi mm/s sin(pi s / 2) / (pi s / 2) over the middle s of a stroke.
        let crank = |t: f64| 1e-3 * (std::f64::consts::TAU * t).sin();
        let rectified =
            |t: f64| 4e-3 * (t * 2.0).floor() / 2.0 + 1e-3 * (1.0 - (std::f64::consts::TAU * (t % 0.5)).cos());
        for share in [0.2_f64, 0.5, 0.8, 0.95] {
            let angle = std::f64::consts::FRAC_PI_2 * share;
            let mean = 1e-3 * std::f64::consts::TAU * angle.sin() / angle;
            close(found(Some(share), crank), mean, 0.03);
            // A sliding distance, which rises in both directions.
            close(found(Some(share), rectified), mean, 0.12);
        }
        // 10 Hz, at which samples are 2 mm apart.
        let time_s: Vec<f64> = (0..=450).map(|i| 0.1 * f64::from(i)).collect();
        let position_m: Vec<f64> = time_s.iter().map(|t| 20e-3 * t).collect();
        close(speed_of_position(&time_s, 0.0, &position_m, WINDOW_S, None), 20e-3, 1e-9);
        let mut noise = Noise::new(4);
        close(found(None, |t| 2e-3 * t + 1e-5 * noise.normal()), 2e-3, 0.05);
        // Positions rounded to 0.1 mm: 2.5 samples per quantization step, so that travel is known to half a step in
        // five.
        close(found(None, |t| (2e-3 * t / 1e-4).round() * 1e-4), 2e-3, 0.1);
    }

    #[test]
    fn a_position_that_says_nothing_has_no_speed() {
        let mut noise = Noise::new(4);
        assert_eq!(found(None, |_| 0.012), None);
        assert_eq!(found(None, |_| 0.012 + 1e-6 * noise.normal()), None);
        assert_eq!(found(None, |t| (2e-3 * t / 0.01).round() * 0.01), None);
        assert_eq!(found(None, |_| f64::NAN), None);
        for times in [&[][..], &[0.0], &[0.0; 40], &[f64::NAN; 40]] {
            assert_eq!(speed_of_position(times, 0.0, &[0.0; 40], WINDOW_S, Some(0.5)), None);
        }
    }
}
