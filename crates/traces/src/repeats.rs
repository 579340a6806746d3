//! Repeats of one condition: means with their spread.

use super::{TraceFindings, TracePeak};

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
    let missed = peaks.iter().map(|peak| peak.missed).sum::<f64>() / peaks.len() as f64;
    // Evenly spread from 0 to `missed`.
    MeanStd { std: found.std.hypot(missed / 12.0_f64.sqrt()), ..found }
}
