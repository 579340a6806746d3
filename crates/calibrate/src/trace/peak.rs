//! The static peak: what friction reached before sliding settled.

use super::series::{median, median_of_three, sample_noise};

/// The peak stands out by this multiple of the noise, or it is none.
const STANDS_OUT: f64 = 5.0;
/// ... and by this part of what follows.
const LEAST_RELATIVE: f64 = 0.01;
/// Share of the time up to the window behind the peak in which friction must have fallen.
const AFTERMATH: f64 = 0.5;
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

/// The static peak in the samples before the window, if friction stands out there.
pub fn static_peak(time_s: &[f64], mu: &[f64], window_start_s: f64) -> Option<TracePeak> {
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
    let height = smooth[top] - settled;
    if height < (STANDS_OUT * noise).max(LEAST_RELATIVE * settled.abs()) {
        return None;
    }
    let near = smooth[..before].iter().filter(|&&value| value > settled + 0.75 * height).count();
    // The median of three flattens the top: the change to the samples beyond its neighbours counts.
    let step = [top.saturating_sub(2), (top + 2).min(before - 1)].map(|i| smooth[top] - smooth[i]);
    let std = noise.hypot(step[0].min(step[1]));
    Some(TracePeak { mu: smooth[top], std, time_s: time_s[top], samples_at_top: near })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

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
}
