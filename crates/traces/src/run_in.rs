//! Run-in: the change of friction between the onset of sliding and the window.
//!
//! Friction with correlated noise differs between any two times. A change counts as run-in only if the mean over a
//! first part after the onset differs from the settled friction (the mean over the second half of the time before the
//! window) by more than such means scatter by noise. This scatter is that of means over parts of equal length within
//! the window, which includes the correlation of the noise.

use slipgrid_base::statistics::Confidence;
use slipgrid_base::units::significant;

use super::static_peak::ONSET_SLIP_M;
use super::time_series::{line_through, mean_between};

/// Maximum length of the first part: the smaller of these fractions of the time before the window and of the window's
/// length, in this order.
const MAX_PART: [f64; 2] = [1.0 / 4.0, 1.0 / 8.0];
/// Number of lengths of the first part that are tried, each half of the previous one, because run-in may be over soon.
const HALVINGS: i32 = 4;
/// Minimum number of sampling intervals in a part.
const MIN_INTERVALS: f64 = 3.0;
/// Confidence of the significance test for each length of the first part. With all lengths tested, fewer than 5 % of
/// traces without run-in are reported to have it.
const CONFIDENCE: Confidence = Confidence::PERCENT_99_5;
/// Minimum change of friction in run-in, relative to the settled friction.
const MIN_RELATIVE: f64 = 0.01;

/// A slow change of friction before the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunIn {
    /// Change of the friction coefficient from the onset to the settled friction; negative if friction falls.
    pub change: f64,
    /// `change` as a fraction of the settled friction.
    pub relative: f64,
    /// Onset, in seconds since the trace begins.
    pub from_s: f64,
    /// Time at which half of the change is over, in seconds since the trace begins.
    pub half_s: f64,
}

impl RunIn {
    /// Describes the run-in at `speed_m_s`; `peak` says whether a static peak comes before it.
    pub fn words(&self, peak: bool, speed_m_s: f64) -> String {
        let half_s = self.half_s - self.from_s;
        format!(
            "friction {} by {:.4}, {:.0} %, after {:.2} s, half of it within {half_s:.2} s or {} mm: run-in{}",
            if self.change < 0.0 { "falls" } else { "rises" },
            self.change.abs(),
            100.0 * self.relative.abs(),
            self.from_s,
            significant(1e3 * half_s * speed_m_s, 2),
            match (peak, self.change < 0.0) {
                (true, _) => " behind a static peak".to_owned(),
                (false, true) if half_s * speed_m_s > ONSET_SLIP_M => {
                    format!(", no static peak, which is over within {} mm", 1e3 * ONSET_SLIP_M)
                }
                // It falls as fast, but stands below the friction in the window, or not out of the noise.
                (false, true) => ", no static peak".to_owned(),
                (false, false) => String::new(),
            }
        )
    }
}

/// Finds run-in between the onset of sliding at `from_s` and the window; `None` if friction does not change
/// significantly. `pause_s` is the sampling interval; times are in seconds since the trace begins.
pub fn find_run_in(time_s: &[f64], mu: &[f64], from_s: f64, window_s: [f64; 2], pause_s: f64) -> Option<RunIn> {
    let (before_s, length_s) = (window_s[0] - from_s, window_s[1] - window_s[0]);
    let longest_s = (MAX_PART[0] * before_s).min(MAX_PART[1] * length_s);
    let mean = |from: f64, to: f64| mean_between(time_s, mu, from, to);
    let parts = |from: f64, to: f64, part_s: f64| -> Vec<f64> {
        let count = ((to - from) / part_s * (1.0 + 1e-9)).floor() as u32;
        (0..count).map(|i| from + f64::from(i) * part_s).map(|at| mean(at, (at + part_s).min(to))).collect()
    };
    let settled = mean(from_s + before_s / 2.0, window_s[0]);
    let (mut settled_variance, mut shortest_s) = (0.0, None);
    for halving in 0..HALVINGS {
        let part_s = longest_s * 0.5_f64.powi(halving);
        if part_s.is_nan() || part_s < MIN_INTERVALS * pause_s {
            break;
        }
        let steady = parts(window_s[0], window_s[1], part_s);
        if steady.len() < 3 {
            return None;
        }
        let variance = line_through(&steady).variance;
        if halving == 0 {
            settled_variance = variance * part_s / (before_s / 2.0);
        }
        let departs = mean(from_s, from_s + part_s) - settled;
        let error = (variance + settled_variance).sqrt();
        if departs.abs() > CONFIDENCE.student_t(steady.len() - 2) * error {
            shortest_s = Some(part_s);
        }
    }
    let mut part_s = shortest_s?;
    // A mean over the first part misses the begin of a fast change: the part is halved as long as that adds to the
    // change more than its scatter.
    while part_s >= 2.0 * pause_s {
        let half_s = part_s / 2.0;
        let steady = parts(window_s[0], window_s[1], half_s);
        let error = (2.0 * line_through(&steady).variance).sqrt();
        let [whole, half] = [part_s, half_s].map(|part_s| (mean(from_s, from_s + part_s) - settled).abs());
        if half - whole <= CONFIDENCE.student_t(steady.len() - 2) * error {
            break;
        }
        part_s = half_s;
    }
    let means = parts(from_s, window_s[0], part_s);
    let [first, second] = *means.first_chunk()?;
    // The line through the means of the first two parts, at the onset.
    let onset = first + (first - second) / 2.0;
    let change = settled - onset;
    if change.abs() < MIN_RELATIVE * settled.abs() {
        return None;
    }
    // Remaining fraction of the change at the onset and in the middle of every part, with the time since the onset.
    let middles =
        means.iter().zip(0..).map(|(mean, part)| ((f64::from(part) + 0.5) * part_s, (settled - mean) / change));
    let left: Vec<(f64, f64)> = std::iter::once((0.0, 1.0)).chain(middles).collect();
    let passed = left.iter().position(|(_, left)| *left <= 0.5)?;
    let (before, after) = (left[passed - 1], left[passed]);
    let share = (before.1 - 0.5) / (before.1 - after.1);
    let half_s = from_s + before.0 + share * (after.0 - before.0);
    Some(RunIn { change, relative: change / settled, from_s, half_s })
}
