//! Reciprocating sliding: friction of every stroke without its ends.
//!
//! At the ends of a stroke the sample stops, and the drive loads its elastic parts before it slides again. Therefore
//! friction is taken in the middle of every stroke, as half the width of the friction loop of two successive strokes,
//!
//! ```text
//! mu_k = |F_k - F_(k+1)| / (N_k + N_(k+1)),     F_k, N_k = means over the middle of stroke k, F with its sign
//! ```
//!
//! so that an offset of the force sensor and a tilt of the sample along the stroke cancel, also where the normal force
//! depends on the direction.

use super::time_series::{mean_between, median};
use crate::checks::{MAX_OPPOSITE_SIGN, MIN_SAMPLES, no_friction, samples_between};
use crate::{MIN_FRICTION, TraceError, TraceFlag};

/// Default central fraction of every stroke that is used.
pub const DEFAULT_STROKE_SHARE: f64 = 0.5;
/// A stroke begins where friction, with the new sign, exceeds this fraction of half the width of the friction loop (of
/// median friction if the sign was not recorded).
const STROKE_START_FRACTION: f64 = 0.5;
/// Minimum number of samples in the middle of a stroke.
const MIN_SAMPLES_PER_STROKE: usize = 4;
/// A stroke is flagged if its duration deviates from the median duration by more than this fraction of the median.
const MAX_DURATION_DEVIATION: f64 = 0.3;
/// An offset of friction between the two sliding directions is flagged if it exceeds this fraction of mean friction.
const MAX_STROKE_OFFSET: f64 = 0.05;

/// A stroke: beginning and end, in seconds since the trace begins, and means of friction signal, with its sign, and of
/// the load by which it is divided.
struct Stroke {
    from_s: f64,
    to_s: f64,
    friction: f64,
    load: f64,
}

impl Stroke {
    fn mu(&self) -> f64 {
        self.friction / self.load
    }
}

/// Returns times, in seconds since the trace begins, and friction coefficients: one per pair of successive strokes, or
/// one per stroke if the sign was not recorded. `mu` is friction over `load`, sample by sample; `share` is the central
/// fraction of a stroke that is used.
pub(super) fn friction_of_strokes(
    time_s: &[f64],
    [mu, load]: [&[f64]; 2],
    window_s: [f64; 2],
    share: f64,
    flags: &mut Vec<TraceFlag>,
) -> Result<(Vec<f64>, Vec<f64>), TraceError> {
    let mut sorted = mu[samples_between(time_s, window_s)].to_vec();
    sorted.sort_by(f64::total_cmp);
    let quantile = |part: f64| sorted[((sorted.len() - 1) as f64 * part).round() as usize];
    let negative = sorted.partition_point(|&value| value < 0.0);
    let opposite = negative.min(sorted.len() - negative);
    let signed = opposite as f64 > MAX_OPPOSITE_SIGN * sorted.len() as f64;
    let (middle, usual) = if signed {
        ((quantile(0.1) + quantile(0.9)) / 2.0, (quantile(0.9) - quantile(0.1)) / 2.0)
    } else {
        (0.0, quantile(0.5))
    };
    if usual.abs() < MIN_FRICTION {
        return Err(no_friction(usual));
    }
    let strokes = strokes(time_s, [mu, load], [middle, usual], signed, share)?;
    let (times, friction): (Vec<f64>, Vec<f64>) = if signed {
        let half_width = |a: &Stroke, b: &Stroke| (a.friction - b.friction).abs() / (a.load + b.load);
        strokes.windows(2).map(|pair| (pair[0].to_s, half_width(&pair[0], &pair[1]))).unzip()
    } else {
        flags.push(TraceFlag::SignNotRecorded);
        strokes.iter().map(|stroke| ((stroke.from_s + stroke.to_s) / 2.0, stroke.mu().abs())).unzip()
    };
    let inside = samples_between(&times, window_s);
    if inside.len() < MIN_SAMPLES {
        return Err(TraceError::Refused(format!(
            "the window holds {} strokes back and forth: expected at least {MIN_SAMPLES}, in a longer window; of a sample \
             that slides in one direction, no `reciprocating`",
            inside.len()
        )));
    }
    let in_window: Vec<&Stroke> =
        strokes.iter().filter(|stroke| stroke.to_s > window_s[0] && stroke.from_s < window_s[1]).collect();
    let durations: Vec<f64> = in_window.iter().map(|stroke| stroke.to_s - stroke.from_s).collect();
    let usual_s = median(durations.clone());
    let uneven =
        durations.iter().filter(|duration| (**duration / usual_s - 1.0).abs() > MAX_DURATION_DEVIATION).count();
    if uneven > 0 {
        let of = durations.len();
        flags.push(TraceFlag::Odd(format!("{uneven} of {of} strokes do not last the usual {usual_s:.3} s")));
    }
    if signed {
        let mean = friction[inside.clone()].iter().sum::<f64>() / inside.len() as f64;
        let offset = in_window.windows(2).map(|pair| (pair[0].mu() + pair[1].mu()) / 2.0).sum::<f64>()
            / (in_window.len() - 1) as f64;
        if offset.abs() > MAX_STROKE_OFFSET * mean {
            flags.push(TraceFlag::StrokesDiffer { offset, relative: offset / mean });
        }
    }
    Ok((times, friction))
}

/// Finds the complete strokes of a trace; a stroke that is cut off by an end of the trace is left out. `middle` and
/// `usual` are the middle of the friction loop and half its width; without signs, zero and the median friction.
fn strokes(
    time_s: &[f64],
    [mu, load]: [&[f64]; 2],
    [middle, usual]: [f64; 2],
    signed: bool,
    share: f64,
) -> Result<Vec<Stroke>, TraceError> {
    // Runs of samples with one sign: first, last, and whether the sign is positive.
    let mut runs: Vec<(usize, usize, bool)> = Vec::new();
    let mut ended = false;
    for (i, value) in mu.iter().enumerate() {
        let over = (value - middle) / usual;
        if over.abs() < STROKE_START_FRACTION || (!signed && over < 0.0) {
            // Unsigned friction ends a stroke by falling; signed friction only by changing its sign.
            ended |= !signed && over < STROKE_START_FRACTION / 2.0;
            continue;
        }
        match runs.last_mut() {
            Some((_, last, side)) if *side == (over > 0.0) && !ended => *last = i,
            _ => runs.push((i, i, over > 0.0)),
        }
        ended = false;
    }
    let turned_s =
        |before: &(usize, usize, bool), after: &(usize, usize, bool)| (time_s[before.1] + time_s[after.0]) / 2.0;
    let friction: Vec<f64> = mu.iter().zip(load).map(|(mu, load)| mu * load).collect();
    let mut found = Vec::new();
    for around in runs.windows(3) {
        let [before, own, after] = around else { continue };
        let (from_s, to_s) = (turned_s(before, own), turned_s(own, after));
        let cut_s = (1.0 - share) / 2.0 * (to_s - from_s);
        let [a, b] = [from_s + cut_s, to_s - cut_s];
        let samples = samples_between(time_s, [a, b]).len();
        if samples < MIN_SAMPLES_PER_STROKE {
            return Err(TraceError::Refused(format!(
                "the stroke from {from_s:.3} s on has {samples} samples in its middle: expected at least {MIN_SAMPLES_PER_STROKE}, \
                 recorded at a higher rate or with a larger `stroke_share`"
            )));
        }
        let [friction, load] = [&friction[..], load].map(|values| mean_between(time_s, values, a, b));
        found.push(Stroke { from_s, to_s, friction, load });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Tangential, TraceChannels, TraceOptions, analyse};
    use slipgrid_base::statistics::Noise;

    /// Friction of 0.25 under 20 N, strokes of half a second at 200 Hz, loaded for 0.05 s after a turn. `seen` maps
    /// friction to the sensor's reading.
    fn recorded(noise: f64, seen: impl Fn(f64) -> f64) -> TraceChannels {
        let mut random = Noise::new(8);
        let time_s: Vec<f64> = (0..=9000).map(|i| f64::from(i) * 0.005).collect();
        let friction = |t: f64| {
            let (stroke, since) = ((t / 0.5).floor(), t.rem_euclid(0.5));
            let side = if stroke.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
            side * 0.25 * (2.0 * since / 0.05 - 1.0).min(1.0)
        };
        let force_n = time_s.iter().map(|&t| 20.0 * seen(friction(t) + noise * random.normal())).collect();
        let normal_force_n = time_s.iter().map(|_| 20.0).collect();
        TraceChannels { time_s, start_s: 0.0, tangential: Tangential::ForceN(force_n), normal_force_n }
    }

    const OPTIONS: TraceOptions = TraceOptions {
        nominal_force_n: Some(20.0),
        speed_m_s: 5e-3,
        stroke_share: Some(DEFAULT_STROKE_SHARE),
        ..crate::tests::OPTIONS
    };

    #[test]
    fn half_the_width_of_the_loop_is_friction_whatever_the_sensors_offset() {
        for (offset, flagged) in [(0.0, false), (0.01, false), (-0.08, true)] {
            let found = analyse(&recorded(0.002, |mu| mu + offset), &OPTIONS).unwrap();
            assert!((found.window.mu - 0.25).abs() < 4.0 * found.window.stderr, "{offset}: {:?}", found.window);
            assert!(found.window.stderr < 2e-4 && found.static_peak.is_none() && found.stick_slip.is_none());
            match &found.flags[..] {
                [] => assert!(!flagged),
                [TraceFlag::StrokesDiffer { offset: told, .. }] => assert!(flagged && (told - offset).abs() < 1e-3),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn an_offset_cancels_where_the_load_differs_by_direction() {
        // Offset of 0.6 N of 20 N, load (1 +- a) 20 N: halves of F / N would be off by a (0.6 / 20) / 0.25 = 1.2 %.
        for a in [0.0, 0.1, -0.1] {
            let mut trace = recorded(1e-9, |mu| mu);
            let Tangential::ForceN(force_n) = &mut trace.tangential else { panic!() };
            for (force_n, load_n) in force_n.iter_mut().zip(&mut trace.normal_force_n) {
                let factor = 1.0 + a * force_n.signum();
                *load_n *= factor;
                *force_n = *force_n * factor + 0.6;
            }
            let ratio = force_n.iter().zip(&trace.normal_force_n).map(|(force_n, load_n)| force_n / load_n).collect();
            let divided = TraceChannels { tangential: Tangential::Coefficient(ratio), ..trace.clone() };
            for trace in [trace, divided] {
                let found = analyse(&trace, &OPTIONS).unwrap();
                assert!((found.window.mu - 0.25).abs() < 1e-7, "{a}: {:?}", found.window);
            }
        }
    }

    #[test]
    fn without_noise_the_middle_of_a_stroke_is_exact_and_its_ends_are_not_part_of_it() {
        let smooth = |mu: f64| mu * (1.0 + 1e-9 * mu);
        let found = analyse(&recorded(1e-9, smooth), &OPTIONS).unwrap();
        assert!((found.window.mu - 0.25).abs() < 1e-8, "{:?}", found.window);
        // The whole stroke includes the turn: 0.05 s of 0.5 s with a mean friction of zero.
        let whole = analyse(&recorded(1e-9, smooth), &TraceOptions { stroke_share: Some(1.0), ..OPTIONS }).unwrap();
        assert!((0.22..0.245).contains(&whole.window.mu), "{:?}", whole.window);
    }

    #[test]
    fn friction_without_its_sign_is_read_and_told() {
        let found = analyse(&recorded(0.002, f64::abs), &OPTIONS).unwrap();
        assert!(
            (found.window.mu - 0.25).abs() < 4.0 * found.window.stderr && found.flags == [TraceFlag::SignNotRecorded]
        );
    }
}
