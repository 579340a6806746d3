//! Checks of a trace before it is averaged: its clock, gaps, saturation and sign.

use std::ops::Range;

use crate::time_series::median;
use crate::{Tangential, TraceChannels, TraceError, TraceFlag, TraceOptions};

/// Minimum number of samples in the window for a mean: two in each of the batches from which the error of the mean is
/// estimated.
pub(crate) const MIN_SAMPLES: usize = 20;
/// A pause between samples counts as a gap if it is longer than this many sampling intervals.
const GAP_FACTOR: f64 = 10.0;
/// Maximum length of a gap, as a fraction of the window; a longer gap cannot be interpolated.
const MAX_GAP_OVER_WINDOW: f64 = 0.02;
/// Maximum fraction of samples with the opposite sign that is attributed to noise.
pub(crate) const MAX_OPPOSITE_SIGN: f64 = 0.05;
/// A sensor counts as saturated if at least this many samples in a row equal its extreme value.
const MIN_SATURATED_RUN: usize = 5;
/// Saturation is not tested if the window has at most this many different values, because equal values then occur in a
/// row by chance. A value that never changes is refused in any case.
const MAX_COARSE_LEVELS: usize = 10;

/// Refuses channels of different lengths or with too few samples, numbers that are not finite, a clock that goes back,
/// and options out of range.
pub(crate) fn check_channels(channels: &TraceChannels, options: &TraceOptions) -> Result<(), TraceError> {
    let time_s = &channels.time_s;
    let name = channels.tangential.name();
    let columns =
        [("time", &time_s[..]), (name, channels.tangential.values()), ("normal force", &channels.normal_force_n[..])];
    for (channel, values) in columns {
        let is_stated = channel == columns[2].0 && values.is_empty();
        if values.len() != time_s.len() && !is_stated {
            return Err(TraceError::Refused(format!(
                "{channel} has {} samples: expected {}, as time",
                values.len(),
                time_s.len()
            )));
        }
        if let Some(i) = values.iter().position(|value| !value.is_finite()) {
            return Err(TraceError::Refused(format!(
                "sample {}: {channel} is {}: expected a finite number",
                i + 1,
                values[i]
            )));
        }
    }
    if time_s.len() < MIN_SAMPLES {
        return Err(too_few(time_s.len(), time_s));
    }
    if let Some(i) = time_s.windows(2).position(|pair| pair[1] < pair[0]) {
        let rises = |values: &[f64]| !values.is_empty() && values.windows(2).all(|pair| pair[1] > pair[0]);
        let likely = columns[1..].iter().find(|(_, values)| rises(values)).map(|(channel, _)| *channel);
        let likely = likely.map_or_else(String::new, |channel| {
            format!("; the {channel} rises throughout, so that time and {channel} are likely in each other's place")
        });
        return Err(clock_back(i + 2, [time_s[i], time_s[i + 1]], &likely));
    }
    if !(channels.start_s.is_finite() && channels.start_s <= time_s[0]) {
        return Err(clock_back(1, [channels.start_s, time_s[0]], ""));
    }
    let [from_s, to_s] = options.window_s;
    if !(from_s >= 0.0 && to_s > from_s && to_s.is_finite()) {
        return Err(TraceError::Refused(format!(
            "the window from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on"
        )));
    }
    if let Some(value) = options.stroke_share.filter(|share| !(*share > 0.0 && *share <= 1.0)) {
        return Err(TraceError::Refused(format!("the part of a stroke is {value}: expected a number above 0 up to 1")));
    }
    let radius = options.effective_radius_m;
    if matches!(channels.tangential, Tangential::TorqueNm(_)) && !(radius.is_finite() && radius > 0.0) {
        return Err(TraceError::Refused(format!(
            "the effective radius is {radius} m: expected a positive length, torque / (normal force x radius) is friction"
        )));
    }
    Ok(())
}

/// Creates the error for `found` samples where more are needed.
fn too_few(found: usize, time_s: &[f64]) -> TraceError {
    TraceError::TooFewSamples { found, expected: MIN_SAMPLES, pause_s: sampling_interval(time_s) }
}

/// Creates the error for a clock that goes back from `from_s` to `to_s`, in seconds, at `sample`, counted from 1;
/// `likely` states the likely cause.
fn clock_back(sample: usize, [from_s, to_s]: [f64; 2], likely: &str) -> TraceError {
    TraceError::Refused(format!("the clock goes back at sample {sample}: from {from_s} s to {to_s} s{likely}"))
}

/// Creates the error for a mean friction coefficient of almost zero.
pub(crate) fn no_friction(mu: f64) -> TraceError {
    TraceError::Refused(format!(
        "friction is {mu:.6} in the window, as of a sample that does not slide: expected torque or friction force \
         while the sample slides, and its unit in the header"
    ))
}

/// Indices of the samples within a time span, including its ends.
pub(crate) fn samples_between(time_s: &[f64], [from, to]: [f64; 2]) -> Range<usize> {
    time_s.partition_point(|&t| t < from)..time_s.partition_point(|&t| t <= to)
}

/// Indices of the samples in the window; refuses a trace that ends before the window does, or has too few samples in
/// the window.
pub(crate) fn window_samples(time_s: &[f64], window_s: [f64; 2]) -> Result<Range<usize>, TraceError> {
    let end_s = time_s[time_s.len() - 1];
    // A trace may end one sampling interval before the end of the window.
    if end_s + sampling_interval(time_s) < window_s[1] {
        return Err(TraceError::TooShort { end_s, window_end_s: window_s[1], pause_s: sampling_interval(time_s) });
    }
    let inside = samples_between(time_s, window_s);
    if inside.len() < MIN_SAMPLES {
        return Err(too_few(inside.len(), time_s));
    }
    Ok(inside)
}

/// Median sampling interval, in the unit of `time_s`; for a coarse clock, the interval between its ticks. Zero if all
/// times are equal.
pub(crate) fn sampling_interval(time_s: &[f64]) -> f64 {
    median(time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|pause| *pause > 0.0).collect())
}

/// Flags gaps between samples; refuses a gap that takes too much of the window.
pub(crate) fn find_gaps(time_s: &[f64], window_s: [f64; 2]) -> Result<Vec<TraceFlag>, TraceError> {
    let usual = sampling_interval(time_s);
    let (mut longest, mut count) = ([0.0, 0.0], 0);
    // Rows before the first sample may lack numbers.
    let before = (0.0, time_s[0]);
    for (from_s, to_s) in [before].into_iter().chain(time_s.windows(2).map(|pair| (pair[0], pair[1]))) {
        if to_s - from_s <= GAP_FACTOR * usual || from_s >= window_s[1] {
            continue;
        }
        let missing = to_s.min(window_s[1]) - from_s.max(window_s[0]);
        if missing > MAX_GAP_OVER_WINDOW * (window_s[1] - window_s[0]) {
            return Err(TraceError::Gap { from_s, to_s });
        }
        count += 1;
        if to_s - from_s > longest[1] - longest[0] {
            longest = [from_s, to_s];
        }
    }
    let between = format!("no samples from {:.2} to {:.2} s", longest[0], longest[1]);
    Ok(match count {
        0 => Vec::new(),
        1 => vec![TraceFlag::Odd(between)],
        _ => vec![TraceFlag::Odd(format!("{count} gaps; the longest has {between}"))],
    })
}

/// Refuses a friction sensor that is saturated in the window; flags a sensor that is saturated only before the window.
pub(crate) fn check_saturation(
    channels: &TraceChannels,
    inside: &Range<usize>,
    flags: &mut Vec<TraceFlag>,
) -> Result<(), TraceError> {
    let values = channels.tangential.values();
    let window = &values[inside.clone()];
    let mut distinct = window.to_vec();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    let levels = distinct.len();
    // A sensor that never changes is saturated or disconnected.
    let stuck = levels == 1;
    if let Some((value, samples)) = run_at_extreme(window).filter(|_| stuck || levels > MAX_COARSE_LEVELS) {
        let channel = channels.tangential.name();
        return Err(TraceError::Refused(format!(
            "the {channel} stands at {value} in {samples} samples of the window: expected a sensor within its range"
        )));
    }
    if levels <= MAX_COARSE_LEVELS {
        flags.push(TraceFlag::Odd(format!("only {levels} different values occur in the window")));
    } else if let Some((value, _)) = run_at_extreme(&values[..inside.start]).filter(|(value, _)| {
        // At rest a sensor shows the same small value for long; only the largest friction means saturation.
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        value.abs() >= largest(window)
    }) {
        flags.push(TraceFlag::PeakSaturated { value });
    }
    Ok(())
}

/// Maximum or minimum of `values` if it occurs at least `MIN_SATURATED_RUN` times in a row, with its total count;
/// otherwise `None`.
fn run_at_extreme(values: &[f64]) -> Option<(f64, usize)> {
    let extremes = [f64::max as fn(f64, f64) -> f64, f64::min]
        .map(|extreme| values.iter().copied().reduce(extreme).unwrap_or(f64::NAN));
    extremes.into_iter().find_map(|end| {
        let longest = values.chunk_by(|a, b| a == b).filter(|run| run[0] == end).map(<[f64]>::len).max();
        let all = values.iter().filter(|&&value| value == end).count();
        longest.filter(|&run| run >= MIN_SATURATED_RUN).map(|_| (end, all))
    })
}

/// Changes the sign of friction that is recorded as negative, and returns whether the sign was changed. Refuses
/// friction that changes its sign in the window.
pub(crate) fn correct_sign(time_s: &[f64], mu: &mut [f64], window_s: [f64; 2]) -> Result<bool, TraceError> {
    let inside = samples_between(time_s, window_s);
    let window = &mu[inside];
    let negative = window.iter().filter(|&&value| value < 0.0).count();
    let opposite = negative.min(window.len() - negative);
    if opposite as f64 > MAX_OPPOSITE_SIGN * window.len() as f64 {
        return Err(TraceError::Refused(format!(
            "friction changes its sign in the window ({opposite} of {} samples are against the mean): expected \
             sliding in one direction; of a sample that slides back and forth, `reciprocating = true` in [traces] or --reciprocating",
            window.len()
        )));
    }
    let turned = 2 * negative > window.len();
    if turned {
        mu.iter_mut().for_each(|value| *value = -*value);
    }
    Ok(turned)
}
