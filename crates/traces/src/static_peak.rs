//! The static peak: what friction reached before sliding settled.
//!
//! A peak at the onset of sliding is over once the junctions that held it have slipped: within the memory distance of
//! dry friction, a few to some tens of micrometres (Rabinowicz, Proc. Phys. Soc. 71, 668; Dieterich, J. Geophys. Res.
//! 84, 2161). Run-in falls as well, but over millimetres to metres of sliding. The two are told apart by what friction
//! loses within [`ONSET_SLIP_M`] behind its highest value, against what it loses within the same slip after that.

use super::time_series::{median, median_of_three, sample_noise};

/// The peak stands out by this multiple of the noise, or it is none.
const STANDS_OUT: f64 = 5.0;
/// ... and by this part of what follows.
const LEAST_RELATIVE: f64 = 0.01;
/// Share of the time up to the window behind the peak in which friction must have fallen.
const AFTERMATH: f64 = 0.5;
/// Slip within which a static peak is over, in metres: several times the memory distances of dry friction.
const ONSET_SLIP_M: f64 = 100e-6;
/// Pauses between samples that the same takes at least: a coarser trace cannot resolve it.
const FEWEST_PAUSES: f64 = 3.0;
/// Fall within that slip over the fall within the next one. A steady fall, as of run-in, has 1 to 1.5; an exponential
/// one has 4 where it takes 80 % of the slip to fall to 1/e.
const PROMPT: f64 = 4.0;
/// Height over that of the highest peak of the same kind while friction slides steadily: noise that wanders, too, falls promptly.
const OVER_LATER: f64 = 1.25;
/// Slips in which the highest value of steady sliding is looked for at a time.
const SLIPS_A_PEAK: f64 = 3.0;
/// Samples near the top below which a peak may be blunted by the sampling.
const FEWEST_AT_TOP: usize = 3;

/// Friction at the onset of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePeak {
    /// Highest friction before the window, single outliers apart.
    pub mu: f64,
    /// Its deviation: the sample noise, and the smaller change to the next samples, which is what sampling may have
    /// missed.
    pub std: f64,
    /// When, in seconds since the first sample.
    pub time_s: f64,
    /// Samples in the upper quarter of its height over what follows.
    pub samples_at_top: usize,
}

impl TracePeak {
    /// So few samples at the top that it may have been higher.
    #[must_use]
    pub const fn is_coarse(&self) -> bool {
        self.samples_at_top < FEWEST_AT_TOP
    }
}

/// A slow fall of friction before the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunIn {
    /// Fall from the highest friction to what it settles at.
    pub fall: f64,
    /// When friction was highest, in seconds since the first sample.
    pub from_s: f64,
    /// When half of the fall was over, in seconds since the first sample.
    pub half_s: f64,
}

/// What stands out before the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BeforeWindow {
    /// A peak at the onset of sliding.
    Peak(TracePeak),
    /// Run-in.
    RunIn(RunIn),
}

/// What friction does before the window, if it stands out there; `pause_s` is the usual time between samples.
pub fn before_window(
    time_s: &[f64],
    mu: &[f64],
    window_start_s: f64,
    speed_m_s: f64,
    pause_s: f64,
) -> Option<BeforeWindow> {
    let before = time_s.partition_point(|&t| t < window_start_s);
    if before < 3 {
        return None;
    }
    let noise = sample_noise(mu);
    let smooth = median_of_three(&mu[..before]);
    let top = (0..before).fold(0, |best, i| if smooth[i] > smooth[best] { i } else { best });
    // What friction settles at: behind the peak, before the window.
    let from = time_s[top] + AFTERMATH * (window_start_s - time_s[top]);
    let after = time_s.partition_point(|&t| t < from);
    let settled = median(mu[after.min(before - 1)..].iter().take((before - after).max(1)).copied().collect());
    let stands_out = |fall: f64| fall >= (STANDS_OUT * noise).max(LEAST_RELATIVE * settled.abs());
    let fall = smooth[top] - settled;
    if !stands_out(fall) {
        return None;
    }
    // Friction within one slip behind the top, from one to two, from two to three.
    let slip_s = (ONSET_SLIP_M / speed_m_s).max(FEWEST_PAUSES * pause_s).min((window_start_s - time_s[top]) / 3.0);
    let level = |slips: f64| {
        let at = |slips: f64| time_s.partition_point(|&t| t < time_s[top] + slips * slip_s).min(before - 1);
        median(mu[at(slips)..=at(slips + 1.0)].to_vec())
    };
    let (next, later) = (level(1.0), level(2.0));
    let height = smooth[top] - next;
    if !stands_out(height) || height < PROMPT * (next - later) {
        // Under noise half is passed more than once: between the first time and the last.
        let is_below = |&i: &usize| smooth[i] <= settled + fall / 2.0;
        let first = (top..before).find(is_below).unwrap_or(before - 1);
        let last = (top..before).rev().find(|i| !is_below(i)).unwrap_or(top);
        let half_s = (time_s[first] + time_s[last]) / 2.0;
        return Some(BeforeWindow::RunIn(RunIn { fall, from_s: time_s[top], half_s }));
    }
    if height < OVER_LATER * highest_later(&time_s[before..], &mu[before..], slip_s) {
        return None;
    }
    let near = smooth[..before].iter().filter(|&&value| value > settled + 0.75 * fall).count();
    // The median of three flattens the top: the change to the samples beyond its neighbours counts.
    let step = [top.saturating_sub(2), (top + 2).min(before - 1)].map(|i| smooth[top] - smooth[i]);
    let std = noise.hypot(step[0].min(step[1]));
    Some(BeforeWindow::Peak(TracePeak { mu: smooth[top], std, time_s: time_s[top], samples_at_top: near }))
}

/// The most that friction is, in the steady part of a trace, above what follows from one to two slips of `slip_s` seconds later.
fn highest_later(time_s: &[f64], mu: &[f64], slip_s: f64) -> f64 {
    let smooth = median_of_three(mu);
    let at = |time: f64| time_s.partition_point(|&t| t < time);
    let (mut highest, mut from) = (0.0_f64, 0);
    while let Some(&start_s) = time_s.get(from) {
        let to = at(start_s + SLIPS_A_PEAK * slip_s).max(from + 1);
        let top = (from..to).fold(from, |best, i| if smooth[i] > smooth[best] { i } else { best });
        let behind = at(time_s[top] + slip_s)..(at(time_s[top] + 2.0 * slip_s) + 1).min(mu.len());
        if behind.is_empty() {
            break;
        }
        highest = highest.max(smooth[top] - median(mu[behind].to_vec()));
        from = to;
    }
    highest
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_statistics::Noise;

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

    /// The static peak at 50 um/s, at which a fall within 0.4 s is one within 20 um.
    fn static_peak(time: &[f64], mu: &[f64], window_start_s: f64) -> Option<TracePeak> {
        match before_window(time, mu, window_start_s, 50e-6, 0.05)? {
            BeforeWindow::Peak(peak) => Some(peak),
            BeforeWindow::RunIn(_) => None,
        }
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
        // 20 mm/s, 100 samples a second: noise that remembers itself over 0.05 to 0.5 s.
        let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.01).collect();
        let (mut false_ones, mut found) = (0, 0);
        for seed in 0..200 {
            let mut deviates = Noise::new(seed);
            let memory = (-0.01 / (0.05 * 10_f64.powf(seed as f64 / 200.0))).exp();
            let mut wander = 0.0;
            let noise: Vec<f64> = time
                .iter()
                .map(|_| {
                    wander = memory * wander + (1.0 - memory * memory).sqrt() * deviates.normal();
                    0.008 * wander
                })
                .collect();
            let is_peak = |of: &dyn Fn(f64) -> f64| {
                let mu: Vec<f64> = time.iter().zip(&noise).map(|(&t, noise)| of(t) + noise).collect();
                matches!(before_window(&time, &mu, 8.0, 20e-3, 0.01), Some(BeforeWindow::Peak(_)))
            };
            false_ones += usize::from(is_peak(&|_| 0.25));
            found += usize::from(is_peak(&|t| 0.25 + 0.1 * (-t / 0.02_f64).exp()));
        }
        assert!(false_ones <= 4 && found >= 196, "{false_ones} {found}");
    }

    #[test]
    fn run_in_over_seconds_of_sliding_is_no_static_peak() {
        // 2 mm/s, 100 samples a second: friction rises within 0.2 s, and falls from 0.31 within 4 s, which is 8 mm.
        let time: Vec<f64> = (0..4500).map(|i| f64::from(i) * 0.01).collect();
        let run_in = |t: f64| 0.25 + 0.06 * (-t / 4.0).exp();
        for (noise, seed) in [(0.0, 0), (0.001, 1), (0.003, 2), (0.006, 3)] {
            let mut deviates = Noise::new(seed);
            let rise = |t: f64| 1.0 - (-t / 0.05_f64).exp();
            let mut sample = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
                time.iter().map(|&t| shape(t) + noise * deviates.normal()).collect()
            };
            let slow = sample(&|t| rise(t) * run_in(t));
            let found = before_window(&time, &slow, 10.0, 2e-3, 0.01);
            let Some(BeforeWindow::RunIn(slow)) = found else { panic!("{noise}: {found:?}") };
            assert!((slow.half_s - slow.from_s - 1.8).abs() < 0.6 && (slow.fall - 0.05).abs() < 0.015, "{slow:?}");
            // A static peak on top of the same run-in falls within 20 um.
            let both = sample(&|t| rise(t) * (run_in(t) + 0.08 * (-(t - 0.2).max(0.0) / 0.01).exp()));
            let found = before_window(&time, &both, 10.0, 2e-3, 0.01);
            let Some(BeforeWindow::Peak(peak)) = found else { panic!("{noise}: {found:?}") };
            assert!((peak.mu - 0.38).abs() < 0.02 && (peak.time_s - 0.2).abs() < 0.06, "{peak:?}");
        }
        // At 2 um/s the same fall takes 8 um: it is a static peak.
        let slow: Vec<f64> = time.iter().map(|&t| run_in(t)).collect();
        assert!(matches!(before_window(&time, &slow, 20.0, 2e-6, 0.01), Some(BeforeWindow::Peak(_))));
    }
}
