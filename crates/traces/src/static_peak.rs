//! The static peak: the highest friction at the onset of sliding.
//!
//! A static peak is over once the junctions that held it have slipped: within the memory distance of dry friction, a
//! few to some tens of micrometres (Rabinowicz, Proc. Phys. Soc. 71, 668; Dieterich, J. Geophys. Res. 84, 2161). Run-in
//! changes friction as well, but over millimetres to metres of sliding. To distinguish the two, the fall of friction
//! within [`ONSET_SLIP_M`] after its highest value is compared with the fall within the next slip of equal length. This
//! slip is the same at all sampling rates; a trace with fewer than two samples in it has no static peak, because run-in
//! would look alike.
//!
//! A peak is looked for where friction rises to the level of sliding, and within one slip after this rise. Higher
//! values later are noise: the highest value in seconds of sliding always stands out.

use super::run_in::{RunIn, find_run_in};
use super::time_series::{highest, mean_between, median, median_of_three, sample_noise};

/// Minimum height of a static peak, in standard deviations of the noise.
const MIN_SIGNAL_TO_NOISE: f64 = 5.0;
/// Minimum height of a static peak, relative to the friction after it.
const MIN_RELATIVE: f64 = 0.01;
/// Friction after the peak must have fallen within this fraction of the time from the peak to the window.
const SETTLING_FRACTION: f64 = 0.5;
/// Slip within which a static peak is over, in metres: several times the memory distance of dry friction.
pub(super) const ONSET_SLIP_M: f64 = 100e-6;
/// Maximum sampling interval, in onset slips, of a trace that resolves them; above 1/2 by the rounding of clocks. With
/// one sample per slip the phase of the samples decides: falls to 1/e within half a slip are missed.
const MAX_INTERVAL: f64 = 0.505;
/// Length of the slip in which a peak is looked for in coarser traces, in sampling intervals.
const MIN_INTERVALS: f64 = 3.0;
/// Minimum ratio of the fall within the onset slip to the fall within the next slip of equal length. A steady fall, as
/// in run-in, has 1 to 1.5; an exponential fall has 4 if it reaches 1/e after 1.3 slips.
const MIN_FALL_RATIO: f64 = 4.0;
/// Minimum ratio of the peak's height to that of the highest similar peak during steady sliding, because correlated
/// noise falls as fast.
const MIN_HEIGHT_RATIO: f64 = 1.25;
/// Length, in onset slips, of the intervals of steady sliding in each of which the highest value is looked for.
const SLIPS_PER_PEAK: f64 = 3.0;
/// Friction has not begun to fall where it is below the top by at most this many standard deviations of the noise:
/// samples on both sides of the true top may be equal.
const TOP_NOISE: f64 = 3.0;
/// Minimum number of samples near the top; with fewer, sampling may have cut off the peak.
const MIN_SAMPLES_AT_TOP: usize = 3;
/// The specimen slides if friction exceeds this fraction of steady friction.
const SLIDING_FRACTION: f64 = 0.5;
/// The specimen rests if friction is below this fraction of steady friction.
const RESTING_FRACTION: f64 = 0.1;
/// Friction still rises while the drive loads elastic parts if it gains [`MIN_RISE`] of steady friction within this
/// many onset slips, and within at least [`MIN_SAMPLES_PER_RISE`] samples. A slower rise is not elastic loading,
/// because it would need more than a centimetre of travel of the drive.
const SLIPS_PER_RISE: f64 = 2.0;
/// Minimum number of samples within which a continued rise is looked for.
const MIN_SAMPLES_PER_RISE: usize = 5;
/// Friction still rises if it gains at least this fraction of steady friction.
const MIN_RISE: f64 = 0.02;

/// Static peak: the highest friction at the onset of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePeak {
    /// Highest friction coefficient at the onset; single outliers do not count.
    pub mu: f64,
    /// Standard deviation of `mu`: root of the sum of squares of `noise` and `missed`.
    pub std: f64,
    /// Standard deviation of the noise of a single reading of the friction coefficient.
    pub noise: f64,
    /// Part of the peak's friction coefficient that sampling may have missed: the smaller change to the samples before
    /// and after the peak (two samples away if the signal was smoothed), or the only change if one of them is missing.
    pub missed: f64,
    /// Time of the peak, in seconds since the trace begins.
    pub time_s: f64,
    /// Number of samples in the upper quarter of the peak's height above the friction that follows.
    pub samples_at_top: usize,
}

impl TracePeak {
    /// Whether so few samples are near the top that the peak may have been higher.
    pub const fn is_coarse(&self) -> bool {
        self.samples_at_top < MIN_SAMPLES_AT_TOP
    }
}

/// Behaviour of friction before the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeforeWindow {
    /// Static peak at the onset of sliding; `None` if no peak stands out.
    pub peak: Option<TracePeak>,
    /// Highest friction at the onset of sliding where samples are too far apart to tell a static peak from run-in;
    /// `None` if they are not, or if it does not stand out.
    pub unresolved: Option<TracePeak>,
    /// Run-in after the onset; `None` if friction does not change significantly.
    pub run_in: Option<RunIn>,
}

/// A trace up to the end of its window.
struct UpToWindow<'a> {
    time_s: &'a [f64],
    mu: &'a [f64],
    /// Running median of three samples of friction.
    smooth: Vec<f64>,
    /// Number of samples before the window.
    before: usize,
    /// Standard deviation of the noise of single readings while the specimen slides.
    noise: f64,
    /// Mean friction in the window.
    steady: f64,
    window_start_s: f64,
}

/// Rise of friction to the level of sliding, as sample indices.
#[derive(Clone, Copy)]
struct Onset {
    /// Last sample at rest before sliding; 0 if there is none.
    rest: usize,
    /// First sample at which the specimen slides.
    first: usize,
    /// Sample at the end of the rise.
    end: usize,
}

/// Finds static peak and run-in before a window with the limits `window_s` and the mean friction `steady`. Times are in
/// seconds since the trace begins; `pause_s` is the sampling interval.
pub fn before_window(
    time_s: &[f64],
    mu: &[f64],
    (window_s, steady): ([f64; 2], f64),
    speed_m_s: f64,
    pause_s: f64,
) -> BeforeWindow {
    let until = time_s.partition_point(|&t| t <= window_s[1]);
    let (time_s, mu) = (&time_s[..until], &mu[..until]);
    let mut trace = UpToWindow {
        time_s,
        mu,
        smooth: median_of_three(mu),
        before: time_s.partition_point(|&t| t < window_s[0]),
        noise: 0.0,
        steady,
        window_start_s: window_s[0],
    };
    let is_resolved = pause_s <= MAX_INTERVAL * ONSET_SLIP_M / speed_m_s;
    let slip_s = if is_resolved { ONSET_SLIP_M / speed_m_s } else { MIN_INTERVALS * pause_s };
    let Some(onset) = trace.onset(slip_s) else { return BeforeWindow::default() };
    // At rest the sensor may show no noise.
    trace.noise = sample_noise(&mu[onset.first..]);
    let peak = trace.peak(onset, slip_s);
    if !is_resolved && peak.is_some() {
        return BeforeWindow { unresolved: peak, ..BeforeWindow::default() };
    }
    let end_s = time_s[onset.end];
    let found_from = |from_s: f64| find_run_in(time_s, mu, from_s, window_s, pause_s);
    let run_in = match peak {
        Some(peak) => found_from(peak.time_s + 3.0 * slip_s),
        // Elastic parts are loaded while friction rises. A rise that continues for as long again is not run-in.
        None => found_from(end_s)
            .filter(|found| found.change < 0.0)
            .or_else(|| found_from(2.0 * end_s - time_s[onset.rest])),
    };
    // Of a fall within a few coarse samples it is not known either.
    let is_slow = |found: &RunIn| is_resolved || found.half_s - found.from_s >= slip_s;
    BeforeWindow { peak, unresolved: None, run_in: run_in.filter(is_slow) }
}

impl UpToWindow<'_> {
    /// Index of the last sample within `seconds` after `sample`, at least `fewest` samples after it, and always before
    /// the window.
    fn within(&self, sample: usize, seconds: f64, fewest: usize) -> usize {
        let to = self.time_s.partition_point(|&t| t <= self.time_s[sample] + seconds);
        (to - 1).max(sample + fewest).min(self.before - 1)
    }

    /// Finds the onset of sliding; `slip_s` is the duration of the onset slip. The onset is the first sample if the
    /// trace begins while the specimen slides; `None` if friction never reaches the level of sliding.
    fn onset(&self, slip_s: f64) -> Option<Onset> {
        let ahead = |sample: usize| self.within(sample, SLIPS_PER_RISE * slip_s, MIN_SAMPLES_PER_RISE);
        let slides = SLIDING_FRACTION * self.steady;
        // A knock when the load is set down is over at once.
        let stays = |&i: &usize| self.smooth[i] >= slides && median(self.mu[i..=ahead(i)].to_vec()) >= slides;
        let first = (0..self.before).find(stays)?;
        let rest = (0..first).rev().find(|&i| self.smooth[i] < RESTING_FRACTION * self.steady).unwrap_or(0);
        let mut end = first;
        loop {
            let next = highest(&self.smooth, end..ahead(end) + 1);
            if self.smooth[next] - self.smooth[end] < MIN_RISE * self.steady || next == end {
                return Some(Onset { rest, first, end });
            }
            end = next;
        }
    }

    fn stands_out(&self, fall: f64, over: f64) -> bool {
        fall >= (MIN_SIGNAL_TO_NOISE * self.noise).max(MIN_RELATIVE * over.abs())
    }

    /// Index of the highest sample between the onset and the sample `to`; `None` unless it ends the rise and is no
    /// outlier.
    fn end_of_rise(&self, onset: Onset, to: usize, smooth: f64) -> Option<usize> {
        let mu = self.mu;
        let top = highest(mu, onset.first.saturating_sub(1)..to + 1);
        let (&last, &own) = (mu.get(top.checked_sub(1)?)?, mu.get(top)?);
        let rise = top.checked_sub(2).map_or(0.0, |i| last - mu[i]).max(0.0);
        let noise = MIN_SIGNAL_TO_NOISE * self.noise;
        let ends = last < SLIDING_FRACTION * self.steady || own <= last + rise + noise;
        (ends && own > smooth + noise).then_some(top)
    }

    /// Finds the static peak at the onset; `None` if no peak stands out. `slip_s` is the duration of the onset slip.
    fn peak(&self, onset: Onset, slip_s: f64) -> Option<TracePeak> {
        let Self { time_s, mu, before, noise, .. } = *self;
        let to = self.within(onset.end, slip_s, MIN_INTERVALS as usize);
        let flat = highest(&self.smooth, onset.first..to + 1);
        // The median of three removes a top that is a single sample.
        let sharp = self.end_of_rise(onset, to, self.smooth[flat]);
        let (top, values) = sharp.map_or((flat, &self.smooth[..]), |top| (top, mu));
        let value = values[top];
        let left_s = self.window_start_s - time_s[top];
        // Settled friction after the peak and before the window.
        let after = time_s.partition_point(|&t| t < time_s[top] + SETTLING_FRACTION * left_s).min(before - 1);
        let settled = median(mu[after..before].to_vec());
        let slip_s = slip_s.min(left_s / 3.0);
        let at_top = values[top..to].iter().take_while(|own| value - **own <= TOP_NOISE * noise).count();
        let falls_s = time_s[top + at_top.saturating_sub(1)];
        let [next, later] = [1.0, 2.0].map(|slips| self.level_after(falls_s, slips * slip_s, slip_s));
        let height = value - next;
        let lowest = height.min(value - settled).min(value - self.steady);
        if !self.stands_out(lowest, settled) || height < MIN_FALL_RATIO * (next - later) {
            return None;
        }
        if height < MIN_HEIGHT_RATIO * self.highest_later(slip_s) {
            return None;
        }
        let is_near = |value: &&f64| **value > next + 0.75 * height;
        let near = values[top..before].iter().take_while(is_near).count()
            + values[..top].iter().rev().take_while(is_near).count();
        // The median of three flattens the top, so that the change to the samples beyond the top's neighbours counts. A
        // trace that begins at its peak has neighbours on one side only.
        let far = if sharp.is_some() { 1 } else { 2 };
        let beside = [top.checked_sub(far), Some(top + far).filter(|i| *i < before)];
        let steps = beside.into_iter().flatten().map(|i| (value - values[i]).abs());
        let missed = steps.reduce(f64::min).unwrap_or(0.0);
        Some(TracePeak {
            mu: value,
            std: noise.hypot(missed),
            noise,
            missed,
            time_s: time_s[top],
            samples_at_top: near,
        })
    }

    /// Mean friction over `slip_s` seconds that begin `after_s` seconds after `top_s`.
    fn level_after(&self, top_s: f64, after_s: f64, slip_s: f64) -> f64 {
        mean_between(self.time_s, &self.smooth, top_s + after_s, top_s + after_s + slip_s)
    }

    /// Maximum height of friction in the window above its level one to two onset slips (of `slip_s` seconds) later.
    fn highest_later(&self, slip_s: f64) -> f64 {
        let at = |time: f64| self.time_s.partition_point(|&t| t < time);
        let (mut most, mut from) = (0.0_f64, self.before);
        while let Some(&start_s) = self.time_s.get(from) {
            let to = at(start_s + SLIPS_PER_PEAK * slip_s).max(from + 1);
            let top = highest(&self.smooth, from..to);
            let top_s = self.time_s[top];
            if self.time_s.last().is_none_or(|end_s| top_s + slip_s > *end_s) {
                break;
            }
            most = most.max(self.smooth[top] - self.level_after(top_s, slip_s, slip_s));
            from = to;
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::averaging_window::window_mean;
    use crate::tests::red;
    use slipgrid_base::statistics::Noise;

    fn trace(peak: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut deviates = Noise::new(11);
        let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 0.05).collect();
        let mu = time
            .iter()
            .map(|&t| {
                let clean = if t < 0.5 { peak * t / 0.5 } else { 0.25 + (peak - 0.25) * (-(t - 0.5) / 0.4).exp() };
                clean + noise * deviates.normal()
            })
            .collect();
        (time, mu)
    }

    /// Peak found with the window from `window_start_s` to the end.
    fn before(time: &[f64], mu: &[f64], window_start_s: f64, speed_m_s: f64, pause_s: f64) -> BeforeWindow {
        let window_s = [window_start_s, time[time.len() - 1]];
        before_window(time, mu, (window_s, window_mean(time, mu, window_s).mu), speed_m_s, pause_s)
    }

    /// Static peak at 50 um/s, where a fall within 0.4 s is one within 20 um.
    fn static_peak(time: &[f64], mu: &[f64], window_start_s: f64) -> Option<TracePeak> {
        before(time, mu, window_start_s, 50e-6, 0.05).peak
    }

    #[test]
    fn a_peak_is_found_where_it_stands_out() {
        let (time, mu) = trace(0.31, 0.001);
        let peak = static_peak(&time, &mu, 10.0).unwrap();
        assert!((peak.mu - 0.31).abs() < 2.0 * peak.std && (peak.time_s - 0.5).abs() < 0.11, "{peak:?}");
        assert!(peak.std > 0.001 && peak.std < 0.03, "{peak:?}");
    }

    #[test]
    fn no_peak_is_made_of_noise_or_of_a_rise() {
        for noise in [0.0, 0.001, 0.01] {
            let (time, mu) = trace(0.25, noise);
            assert_eq!(static_peak(&time, &mu, 10.0), None, "{noise}");
        }
        let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 0.05).collect();
        let rising: Vec<f64> = time.iter().map(|t| 0.2 + 0.002 * t).collect();
        assert_eq!(static_peak(&time, &rising, 10.0), None);
    }

    #[test]
    fn noise_that_wanders_has_no_static_peak_and_hides_none_that_is_higher() {
        // 2 mm/s, 100 samples per second, noise with correlation times of 0.05 to 0.5 s.
        let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.01).collect();
        let (mut false_ones, mut found) = (0, 0);
        for seed in 0..200 {
            let noise = red_noise(&time, 0.008, 0.05 * 10_f64.powf(seed as f64 / 200.0), seed);
            let is_peak = |of: &dyn Fn(f64) -> f64| {
                let mu: Vec<f64> = time.iter().zip(&noise).map(|(&t, noise)| of(t) + noise).collect();
                before(&time, &mu, 8.0, 2e-3, 0.01).peak.is_some()
            };
            false_ones += usize::from(is_peak(&|_| 0.25));
            found += usize::from(is_peak(&|t| 0.25 + 0.1 * (-t / 0.02_f64).exp()));
        }
        assert!(false_ones <= 4 && found >= 196, "{false_ones} {found}");
    }

    /// Noise with the correlation time `memory_s` and the standard deviation `std`.
    fn red_noise(time: &[f64], std: f64, memory_s: f64, seed: u64) -> Vec<f64> {
        let noise = red(&mut Noise::new(seed), time.len(), time[1] - time[0], memory_s);
        noise.into_iter().map(|value| std * value).collect()
    }

    fn add(time: &[f64], noise: &[f64], friction: impl Fn(f64) -> f64) -> Vec<f64> {
        time.iter().zip(noise).map(|(&t, noise)| friction(t) + noise).collect()
    }

    #[test]
    fn steady_noise_has_neither_peak_nor_run_in_and_hides_neither() {
        // 50 samples per second for 60 s at 2 mm/s: friction of 0.28 with correlated noise of 0.0048.
        let time: Vec<f64> = (0..=3000).map(|i| f64::from(i) * 0.02).collect();
        for (memory_s, start_s) in [(0.4, 10.0), (0.4, 20.0), (0.1, 10.0), (2.0, 10.0)] {
            let [mut peaks, mut run_ins, mut found_peaks, mut rises, mut falls] = [0; 5];
            for seed in 0..180 {
                let noise = red_noise(&time, 0.0048, memory_s, seed);
                let read = |friction: &dyn Fn(f64) -> f64| {
                    before(
                        &time[..=2000 + 1000 * usize::from(start_s > 10.0)],
                        &add(&time, &noise, friction),
                        start_s,
                        2e-3,
                        0.02,
                    )
                };
                let steady = read(&|_| 0.28);
                peaks += usize::from(steady.peak.is_some());
                run_ins += usize::from(steady.run_in.is_some());
                // At rest for a second, then a peak of 0.36 that is over within 40 um; its first sample alone has most
                // of the height.
                let peak = read(&|t| if t < 1.0 { -0.28 } else { 0.08 * (-(t - 1.0) / 0.02).exp() } + 0.28).peak;
                found_peaks += usize::from(
                    peak.is_some_and(|peak| (peak.mu - 0.36).abs() < 0.02 && (peak.time_s - 1.0).abs() < 0.03),
                );
                let rise = read(&|t| 0.28 * (1.0 - 0.08 * (-t / 4.0).exp())).run_in;
                rises +=
                    usize::from(rise.is_some_and(|found| found.change > 0.0 && (found.change - 0.022).abs() < 0.015));
                let fall = read(&|t| 0.28 * (1.0 + 0.08 * (-t / 4.0).exp())).run_in;
                falls += usize::from(fall.is_some_and(|found| found.change < 0.0));
            }
            let told = format!("{memory_s} {start_s}: {peaks} {run_ins} of 180; {found_peaks} {rises} {falls}");
            assert!(peaks < 3 && run_ins < 9 && found_peaks >= 176, "{told}");
            assert!(memory_s > 1.0 || (rises >= 160 && falls >= 160), "{told}");
        }
    }

    #[test]
    fn the_end_of_the_rise_is_a_peak_and_a_lone_sample_behind_it_none() {
        let time: Vec<f64> = (0..=3000).map(|i| f64::from(i) * 0.02).collect();
        for seed in 0..40 {
            let noise = red_noise(&time, 0.001, 1e-3, seed);
            let onset = |t: f64| if t < 3.01 { 0.0 } else { 0.28 + 0.09 * (-(t - 3.02) / 0.013).exp() };
            let mu = add(&time, &noise, onset);
            let peak = before(&time, &mu, 10.0, 2e-3, 0.02).peak.unwrap();
            assert!((peak.mu - 0.37).abs() < 0.004 && peak.samples_at_top == 1, "{peak:?}");
            assert!((peak.missed - 0.07).abs() < 0.01 && peak.std >= peak.missed && peak.noise < 0.0015, "{peak:?}");
            // An electronic spike soon after the onset, or seconds later.
            for spike in [155, 200, 400] {
                let mut mu = add(&time, &noise, |t| if t < 3.01 { 0.0 } else { 0.28 });
                mu[spike] += 0.1;
                assert_eq!(before(&time, &mu, 10.0, 2e-3, 0.02).peak, None, "{spike}");
            }
        }
    }

    #[test]
    fn a_trace_that_begins_at_its_peak_may_have_missed_as_much_as_any_other() {
        let time: Vec<f64> = (0..=3000).map(|i| f64::from(i) * 0.02).collect();
        let mu = add(&time, &red_noise(&time, 0.0005, 1e-3, 1), |t| 0.28 + 0.09 * (-t / 0.02).exp());
        let peak = before(&time, &mu, 10.0, 2e-3, 0.02).peak.unwrap();
        assert!(peak.time_s == 0.0 && (peak.mu - 0.37).abs() < 0.003, "{peak:?}");
        assert!(peak.missed > 0.05 && peak.std >= peak.missed, "{peak:?}");
    }

    #[test]
    fn noise_is_that_of_sliding_however_long_the_sample_rests() {
        let time: Vec<f64> = (0..=3000).map(|i| f64::from(i) * 0.02).collect();
        let noise = red_noise(&time, 0.001, 1e-3, 4);
        let onset = |t: f64| 0.28 + 0.09 * (-(t - 40.0) / 0.013).exp();
        let mu: Vec<f64> = time.iter().zip(noise).map(|(&t, n)| if t < 40.0 { 0.0 } else { onset(t) + n }).collect();
        let peak = before(&time, &mu, 45.0, 2e-3, 0.02).peak.unwrap();
        assert!((peak.noise - 0.001).abs() < 0.0003, "{peak:?}");
    }

    #[test]
    fn run_in_over_seconds_of_sliding_is_no_static_peak() {
        // 2 mm/s, 100 samples per second: friction rises within 0.2 s and falls from 0.31 within 4 s, or 8 mm.
        let time: Vec<f64> = (0..4500).map(|i| f64::from(i) * 0.01).collect();
        let run_in = |t: f64| 0.25 + 0.06 * (-t / 4.0).exp();
        for (noise, seed) in [(0.0, 0), (0.001, 1), (0.003, 2), (0.006, 3)] {
            let mut deviates = Noise::new(seed);
            let rise = |t: f64| 1.0 - (-t / 0.05_f64).exp();
            let mut sample = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
                time.iter().map(|&t| shape(t) + noise * deviates.normal()).collect()
            };
            let slow = sample(&|t| rise(t) * run_in(t));
            let found = before(&time, &slow, 10.0, 2e-3, 0.01);
            let BeforeWindow { peak: None, run_in: Some(slow), .. } = found else { panic!("{noise}: {found:?}") };
            assert!((slow.half_s - slow.from_s - 1.8).abs() < 0.6 && (-slow.change - 0.05).abs() < 0.015, "{slow:?}");
            // A static peak on top of this run-in falls within 20 um.
            let both = sample(&|t| rise(t) * (run_in(t) + 0.08 * (-(t - 0.2).max(0.0) / 0.01).exp()));
            let found = before(&time, &both, 10.0, 2e-3, 0.01);
            let BeforeWindow { peak: Some(peak), run_in: Some(_), .. } = found else { panic!("{noise}: {found:?}") };
            assert!((peak.mu - 0.38).abs() < 0.02 && (peak.time_s - 0.2).abs() < 0.06, "{peak:?}");
        }
        // At 2 um/s the same fall takes 8 um and is a static peak.
        let slow: Vec<f64> = time.iter().map(|&t| run_in(t)).collect();
        assert!(before(&time, &slow, 20.0, 2e-6, 0.01).peak.is_some());
    }
    #[test]
    fn the_sampling_rate_makes_no_run_in_a_static_peak_and_no_other_fall_of_it() {
        // 2 mm/s: friction rises within 0.05 s to 0.33 and falls to 0.25 with a decay of 40 or 80 um, or of 200 to 800 um.
        for (decay_s, is_static) in [(0.02, true), (0.04, true), (0.1, false), (0.2, false), (0.4, false)] {
            for pause_s in [0.002, 0.005, 0.02, 0.025, 0.05, 0.1, 0.2] {
                for seed in 0..20_u8 {
                    let mut noise = Noise::new(seed.into());
                    let start_s = 3.0 + pause_s * f64::from(seed) / 20.0;
                    let clean = |since_s: f64| match since_s {
                        ..0.0 => 0.0,
                        0.0..0.05 => 0.33 * since_s / 0.05,
                        _ => 0.25 + 0.08 * (-(since_s - 0.05) / decay_s).exp(),
                    };
                    let time: Vec<f64> = (0..(45.0 / pause_s) as u32).map(|i| f64::from(i) * pause_s).collect();
                    let mu: Vec<f64> =
                        time.iter().map(|t| clean(t - start_s) * (1.0 + 0.003 * noise.normal())).collect();
                    let found = before(&time, &mu, 10.0, 2e-3, pause_s);
                    let case = format!("{decay_s} {pause_s} {seed}: {found:?}");
                    // A coarse sample may miss the whole of a peak.
                    let is_resolved = pause_s <= 0.025;
                    assert!(found.peak.is_none() || (is_static && is_resolved), "{case}");
                    assert!(!is_resolved || found.peak.is_some() == is_static, "{case}");
                    assert!(found.unresolved.is_none() || !is_resolved, "{case}");
                    assert!(found.run_in.is_none() || is_resolved || !is_static, "{case}");
                    if let Some(run_in) = found.run_in.filter(|_| !is_static && pause_s <= 0.25 * decay_s) {
                        // The fall from the highest sample on, and half of it within ln 2 decays.
                        let fall = time.iter().map(|t| clean(t - start_s)).fold(0.0, f64::max) - 0.25;
                        assert!((-run_in.change / fall - 1.0).abs() < 0.15, "{case}");
                        assert!((run_in.relative - run_in.change / 0.25).abs() < 0.01, "{case}");
                        let half_s = run_in.half_s - run_in.from_s;
                        let expected_s = decay_s * std::f64::consts::LN_2;
                        assert!((half_s - expected_s).abs() < 0.2 * expected_s + pause_s, "{case}");
                    }
                    assert!(is_static || !is_resolved || found.run_in.is_some(), "{case}");
                }
            }
        }
    }
}
