//! Repeats of one condition: means with their spread.

use slipgrid_statistics::{Confidence, mean_and_std};

use super::{TraceFindings, TracePeak};

/// Departure of a repeat from the mean of the others, relative to it, below which nothing is said: friction scatters by some per cent.
const ODD: f64 = 0.05;
/// Difference of two repeats, relative to their mean, from which it is told: neither says which of them is odd.
const PAIR_DIFFERS: f64 = 0.1;
/// A difference is no noise from this many standard errors on.
const BEYOND_NOISE: f64 = 4.0;

/// A repeat that is not like the others of its condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OddRepeat {
    /// Which, from 0.
    pub index: usize,
    /// Mean dynamic friction of the others.
    pub others: f64,
    /// Its departure from that mean, relative to the mean.
    pub relative: f64,
    /// Largest difference among the others, relative to their mean; `None` of a single other one.
    pub others_differ: Option<f64>,
}

/// Repeats whose dynamic friction is not like that of the others, from its values and their standard errors.
///
/// Of three or more a repeat is odd that lies outside the interval in which the others, by their own scatter, expect one more in 95 of 100 cases
/// (Student's t), and that also departs from their mean by more than 5 % and by more than noise. Of two, which are odd to each other, the
/// second is returned, where they differ by more than 10 % of their mean and by more than noise. Of one there is none.
#[must_use]
pub fn odd_repeats(values: &[(f64, f64)]) -> Vec<OddRepeat> {
    let odd = |index: usize| {
        let (mu, error) = values[index];
        let others: Vec<(f64, f64)> =
            values.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, value)| *value).collect();
        let count = others.len() as f64;
        let (mean, std) = mean_and_std(others.iter().map(|(mu, _)| *mu))?;
        let noise =
            (error * error + others.iter().map(|(_, error)| error * error).sum::<f64>() / (count * count)).sqrt();
        let distance = (mu - mean).abs();
        let allowed = match std {
            None => PAIR_DIFFERS * (mu + mean).abs() / 2.0,
            Some(std) => {
                let expected = Confidence::PERCENT_95.student_t(others.len() - 1) * std * (1.0 + 1.0 / count).sqrt();
                expected.max(ODD * mean.abs())
            }
        };
        let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max]
            .map(|of| others.iter().map(|(mu, _)| *mu).reduce(of).unwrap_or(mean));
        (distance > allowed.max(BEYOND_NOISE * noise)).then(|| OddRepeat {
            index,
            others: mean,
            relative: mu / mean - 1.0,
            others_differ: std.map(|_| (most - least) / mean),
        })
    };
    let first = usize::from(values.len() == 2);
    (first..values.len()).filter_map(odd).collect()
}

/// A mean with what spreads about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanStd {
    /// Mean of the repeats.
    pub mean: f64,
    /// Standard deviation between repeats, n - 1 in the denominator; at least the error within one. It says
    /// how far another repeat may lie.
    pub std: f64,
}

/// Repeats of one condition taken together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// How many.
    pub count: usize,
    /// Dynamic friction.
    pub mu_dynamic: MeanStd,
    /// Static friction; `None` unless every repeat shows a peak.
    pub mu_static: Option<MeanStd>,
    /// The part of the deviation of `mu_static` that is no scatter of repeats: what sampling may have missed of their peaks.
    pub mu_static_missed: Option<f64>,
    /// Repeats that show a static peak.
    pub peaks: usize,
    /// Repeats that show stick-slip.
    pub stick_slips: usize,
    /// Mean normal force in the window, in newtons.
    pub normal_force_n: f64,
}

/// Averages repeats; `None` of none. One repeat has the error of its own mean for a deviation.
pub fn average(repeats: &[TraceFindings]) -> Option<Repeats> {
    let count = repeats.len();
    if count == 0 {
        return None;
    }
    let dynamic: Vec<(f64, f64)> = repeats.iter().map(|found| (found.window.mu, found.window.stderr)).collect();
    let peaks: Vec<TracePeak> = repeats.iter().filter_map(|found| found.static_peak).collect();
    Some(Repeats {
        count,
        mu_dynamic: mean_std(&dynamic),
        mu_static: (peaks.len() == count).then(|| static_peak(&peaks)),
        mu_static_missed: (peaks.len() == count).then(|| missed(&peaks)),
        peaks: peaks.len(),
        stick_slips: repeats.iter().filter(|found| found.stick_slip.is_some()).count(),
        normal_force_n: repeats.iter().map(|found| found.normal_force_n).sum::<f64>() / count as f64,
    })
}

/// Mean of values with their errors, and what spreads about it.
fn mean_std(values: &[(f64, f64)]) -> MeanStd {
    let count = values.len() as f64;
    let mean = values.iter().map(|(value, _)| value).sum::<f64>() / count;
    let squares: f64 = values.iter().map(|(value, _)| (value - mean).powi(2)).sum();
    let between = if values.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 };
    let within = (values.iter().map(|(_, error)| error * error).sum::<f64>() / count).sqrt();
    MeanStd { mean, std: between.max(within) }
}

/// Static friction of repeats. Sampling reads every peak too low, in recordings that a trigger starts by the same part of what it may
/// have missed each time: their scatter does not hold it. Of several repeats its deviation is that of a part which may be any.
fn static_peak(peaks: &[TracePeak]) -> MeanStd {
    if let [peak] = peaks {
        return MeanStd { mean: peak.mu, std: peak.std };
    }
    let found = mean_std(&peaks.iter().map(|peak| (peak.mu, peak.noise)).collect::<Vec<_>>());
    MeanStd { std: found.std.hypot(missed(peaks)), ..found }
}

/// What sampling may have missed of `peaks`, as a standard deviation.
fn missed(peaks: &[TracePeak]) -> f64 {
    if let [peak] = peaks {
        return peak.missed;
    }
    let missed = peaks.iter().map(|peak| peak.missed).sum::<f64>() / peaks.len() as f64;
    // Evenly spread from 0 to `missed`.
    missed / 12.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_statistics::Noise;

    fn odd(values: &[f64]) -> Vec<usize> {
        let values: Vec<(f64, f64)> = values.iter().map(|mu| (*mu, 3e-4)).collect();
        odd_repeats(&values).iter().map(|odd| odd.index).collect()
    }

    #[test]
    fn a_spoilt_repeat_is_named_and_none_of_like_ones() {
        assert_eq!(odd(&[0.305, 0.308, 0.416]), [2]);
        assert_eq!(odd(&[0.2, 0.305, 0.3, 0.302]), [0]);
        // Others that differ as much themselves, and what is no more than repeats scatter.
        for like in [&[0.30, 0.36, 0.42][..], &[0.3050, 0.3051, 0.3150], &[0.30], &[0.30, 0.32], &[]] {
            assert!(odd(like).is_empty(), "{like:?}");
        }
        assert_eq!(odd(&[0.30, 0.42]), [1]);
        let found = odd_repeats(&[(0.305, 1e-4), (0.308, 1e-4), (0.416, 1e-4)])[0];
        assert!((found.others - 0.3065).abs() < 1e-12 && (found.relative - 0.357_259).abs() < 1e-6, "{found:?}");
        assert!((found.others_differ.unwrap() - 0.009_788).abs() < 1e-6);
        // Noise explains it.
        assert!(odd_repeats(&[(0.305, 0.05), (0.308, 0.05), (0.416, 0.05)]).is_empty());
    }

    #[test]
    fn repeats_that_scatter_by_one_or_two_per_cent_are_seldom_odd() {
        let mut noise = Noise::new(11);
        for count in 2..=6 {
            let named = (0..2000)
                .filter(|_| {
                    !odd(&(0..count).map(|_| 0.3 * (1.0 + 0.015 * noise.normal())).collect::<Vec<_>>()).is_empty()
                })
                .count();
            assert!(named < 100, "{count} repeats: {named} of 2000");
        }
    }
}
