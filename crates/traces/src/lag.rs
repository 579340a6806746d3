//! Delay between the reversals of the position and the sign changes of friction in reciprocating sliding.

use std::ops::Range;

use super::time_series::median;
use super::{Tangential, TraceChannels, TraceOptions, samples_between, sampling_interval, zero};

/// Number of loops of friction against position that `friction_loops` returns.
const LOOPS: usize = 2;
/// Minimum number of reversals of the position, and of sign changes of friction, from which a lag is computed.
const MIN_TURNS: usize = 5;
/// The position counts as at the end of a stroke within this fraction of the stroke length from the extreme position.
const STROKE_END_FRACTION: f64 = 0.01;

/// Delay of the sign changes of friction after the reversals of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Lag, in seconds; negative if friction changes its sign before the position reverses.
    pub lag_s: f64,
    /// Median duration of a stroke, in seconds.
    pub stroke_s: f64,
}

/// Median lag of the sign changes of friction behind the reversals of the position within `window_s` (seconds since the
/// trace begins). `position_m` has one value per sample, in metres. `None` if there are too few reversals, if the
/// position was not recorded, or if the lag is below two sampling intervals.
pub fn lag_of_friction(channels: &TraceChannels, position_m: &[f64], window_s: [f64; 2]) -> Option<Lag> {
    let (time_s, inside) = recorded(channels, position_m, window_s)?;
    let friction = &channels.tangential.values()[inside.clone()];
    let (time_s, position) = (&time_s[inside.clone()], &position_m[inside]);
    let turns = turning_times(time_s, position);
    let changes: Vec<f64> =
        crossings(time_s, friction).into_iter().map(|at| (time_s[at - 1] + time_s[at]) / 2.0).collect();
    if turns.len() < MIN_TURNS || changes.len() < MIN_TURNS {
        return None;
    }
    let stroke_s = median(turns.windows(2).map(|pair| pair[1] - pair[0]).collect());
    let nearest = |turn_s: &f64| {
        let next = changes.partition_point(|change| change < turn_s);
        let around = changes[next.saturating_sub(1)..(next + 1).min(changes.len())].iter();
        around.map(|change| change - turn_s).min_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    let lag_s = median(turns.iter().filter_map(nearest).collect());
    (lag_s.abs() > 2.0 * sampling_interval(time_s)).then_some(Lag { lag_s, stroke_s })
}

/// Times in seconds since the trace begins, and the indices of the samples within `window_s`; `None` without samples,
/// or if the position of any was not recorded.
fn recorded(channels: &TraceChannels, position_m: &[f64], window_s: [f64; 2]) -> Option<(Vec<f64>, Range<usize>)> {
    if [channels.tangential.values().len(), channels.time_s.len()] != [position_m.len(); 2] {
        return None;
    }
    let time_s: Vec<f64> = channels.time_s.iter().map(|t| t - channels.start_s).collect();
    let inside = samples_between(&time_s, window_s);
    let is_known = !inside.is_empty() && position_m[inside.clone()].iter().all(|x| x.is_finite());
    is_known.then_some((time_s, inside))
}

/// Pairs of position, in metres, and friction coefficient with its recorded sign, in the last two loops within the
/// averaging window. Empty if the position was not recorded, if there are too few strokes, or if the zero of the
/// sensors in `options` is refused.
pub fn friction_loops(channels: &TraceChannels, position_m: &[f64], options: &TraceOptions) -> Vec<[f64; 2]> {
    let Some((time_s, inside)) = recorded(channels, position_m, options.window_s) else { return Vec::new() };
    if let Some(span_s) = options.zero_s {
        let zeroed = zero::subtract(channels, &time_s, &inside, span_s, options.window_s[0]);
        let options = TraceOptions { zero_s: None, ..*options };
        return zeroed.map_or_else(|_| Vec::new(), |(channels, ..)| friction_loops(&channels, position_m, &options));
    }
    let tangential = channels.tangential.values();
    let turns = crossings(&time_s[inside.clone()], &position_m[inside.clone()]);
    let Some(from) = turns.len().checked_sub(2 * LOOPS + 1) else { return Vec::new() };
    let force_n = |at: usize| channels.normal_force_n.get(at).copied().or(options.nominal_force_n).map(f64::abs);
    let coefficient = |at: usize| {
        Some(match channels.tangential {
            Tangential::TorqueNm(_) => tangential[at] / (force_n(at)? * options.effective_radius_m),
            Tangential::ForceN(_) => tangential[at] / force_n(at)?,
            Tangential::Coefficient(_) => tangential[at],
        })
    };
    let all = (inside.start + turns[from]..=inside.start + turns[turns.len() - 1]).map(|at| (at, coefficient(at)));
    all.filter_map(|(at, mu)| Some([position_m[at], mu.filter(|mu| mu.is_finite())?])).collect()
}

/// Indices at which `values` change from one side of the middle of their range to the other, by a quarter of the range
/// on each side. The range lies between the 5 % and 95 % quantiles. Of several crossings during a change the last
/// counts.
fn crossings(time_s: &[f64], values: &[f64]) -> Vec<usize> {
    if values.is_empty() {
        return Vec::new();
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let quantile = |part: f64| sorted[((sorted.len() - 1) as f64 * part).round() as usize];
    let (low, high) = (quantile(0.05), quantile(0.95));
    let (middle, far) = ((low + high) / 2.0, (high - low) / 4.0);
    let (mut found, mut side, mut crossed) = (Vec::new(), None, 0);
    for at in 1..time_s.len() {
        if (values[at] >= middle) != (values[at - 1] >= middle) {
            crossed = at;
        }
        if (values[at] - middle).abs() >= far {
            let is_above = values[at] > middle;
            if side.is_some_and(|before| before != is_above) && crossed > 0 {
                found.push(crossed);
            }
            side = Some(is_above);
        }
    }
    found
}

/// Times of the reversals of the position, in seconds.
pub(crate) fn turning_times(time_s: &[f64], position: &[f64]) -> Vec<f64> {
    crossings(time_s, position).windows(2).map(|pair| turning_time(time_s, position, pair[0], pair[1])).collect()
}

/// Time of a reversal, in seconds: the midpoint of the time that the position spends at the end of the stroke between
/// two crossings of the stroke's centre, at the indices `from` and `to`.
fn turning_time(time_s: &[f64], position: &[f64], from: usize, to: usize) -> f64 {
    let middle = (position[from] + position[to]) / 2.0;
    let distance = |at: &usize| (position[*at] - middle).abs();
    let farthest = (from..to).map(|at| distance(&at)).fold(0.0, f64::max);
    let mut at_the_end = (from..to).filter(|at| distance(at) >= (1.0 - 2.0 * STROKE_END_FRACTION) * farthest);
    let first = at_the_end.next().unwrap_or(from);
    let last = at_the_end.next_back().unwrap_or(first);
    (time_s[first] + time_s[last]) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tangential;

    /// Strokes of half a second at 200 Hz by a crank or at constant speed, with their positions; friction lags by `lag_s`.
    fn strokes(lag_s: f64, is_crank: bool) -> (TraceChannels, Vec<f64>) {
        let time_s: Vec<f64> = (0..4000).map(|i| 3.0 + 0.005 * f64::from(i)).collect();
        let triangle = |t: f64| if t.rem_euclid(1.0) < 0.5 { t.rem_euclid(1.0) } else { 1.0 - t.rem_euclid(1.0) };
        let position = |t: f64| if is_crank { -(std::f64::consts::TAU * t).cos() } else { triangle(t) };
        let position_m: Vec<f64> = time_s.iter().map(|&t| 0.01 * position(t)).collect();
        let force_n = |t: f64| if (t - lag_s).rem_euclid(1.0) < 0.5 { 2.0 } else { -2.0 };
        let friction: Vec<f64> = time_s.iter().map(|&t| force_n(t)).collect();
        let tangential = Tangential::ForceN(friction);
        let normal_force_n = vec![10.0; time_s.len()];
        (TraceChannels { start_s: 3.0, normal_force_n, time_s, tangential }, position_m)
    }

    fn found(lag_s: f64, is_crank: bool) -> Option<Lag> {
        let (channels, position_m) = strokes(lag_s, is_crank);
        lag_of_friction(&channels, &position_m, [2.0, 18.0])
    }

    #[test]
    fn the_last_loops_have_both_directions_of_every_position() {
        let (channels, position_m) = strokes(0.0, true);
        let options = TraceOptions {
            window_s: [2.0, 18.0],
            nominal_force_n: None,
            static_peak: false,
            stroke_share: Some(0.5),
            ..crate::tests::OPTIONS
        };
        let loops = friction_loops(&channels, &position_m, &options);
        // Two loops of a second at 200 Hz.
        assert!(loops.len().abs_diff(400) <= 2, "{}", loops.len());
        for side in [-1.0, 1.0] {
            let own: Vec<f64> = loops.iter().filter(|[_, mu]| *mu == 0.2 * side).map(|[x, _]| *x).collect();
            let (least, most) = own.iter().fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
            assert!(own.len() > 180 && least < -0.0099 && most > 0.0099, "{least} {most}");
        }
        // Sensors that read 0.5 N too much of the normal force and 0.4 N of friction before touchdown give the same loops.
        let mut offset = channels.clone();
        let is_loaded = |at: usize| if at < 300 { 0.0 } else { 1.0 };
        offset.normal_force_n.iter_mut().enumerate().for_each(|(at, force)| *force = *force * is_loaded(at) + 0.5);
        let Tangential::ForceN(friction) = &mut offset.tangential else { panic!() };
        friction.iter_mut().enumerate().for_each(|(at, force)| *force = *force * is_loaded(at) + 0.4);
        let zeroed = friction_loops(&offset, &position_m, &TraceOptions { zero_s: Some([0.0, 1.0]), ..options });
        assert_eq!(zeroed.len(), loops.len());
        assert!(zeroed.iter().zip(&loops).all(|(a, b)| a[0] == b[0] && (a[1] - b[1]).abs() < 1e-12));
        assert!(friction_loops(&channels, &[], &options).is_empty());
        assert!(friction_loops(&channels, &position_m, &TraceOptions { window_s: [2.0, 3.0], ..options }).is_empty());
    }

    #[test]
    fn a_lag_is_found_and_no_lag_is_none() {
        for is_crank in [false, true] {
            for lag_s in [0.04, 0.1, -0.05] {
                let lag = found(lag_s, is_crank).unwrap();
                assert!((lag.lag_s - lag_s).abs() < 0.006 && (lag.stroke_s - 0.5).abs() < 0.006, "{lag_s}: {lag:?}");
            }
            assert_eq!(found(0.0, is_crank), None);
        }
    }
}
