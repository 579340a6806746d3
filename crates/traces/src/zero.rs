//! Zero of the sensors: readings before touchdown, while the sample hangs free.
//!
//! An offset of the normal force enters every friction coefficient, more so at small loads, and makes friction seem to
//! depend on load.

use std::fmt;
use std::ops::Range;

use slipgrid_base::units::significant;

use super::averaging_window::window_mean;
use super::time_series::{median, sample_noise};
use super::{Tangential, TraceChannels, TraceError, UNLOADED_FRACTION, samples_between, sampling_interval};

/// Minimum number of samples in the span from which a zero is computed.
const MIN_ZERO_SAMPLES: usize = 5;
/// A sample counts as after touchdown if its normal force differs from the zero reading by at least this fraction of
/// the normal force in the window.
const TOUCHDOWN_FRACTION: f64 = 0.1;
/// Minimum sensor offset that is reported, relative to the reading in the window: half of the best accuracy of
/// friction.
pub(crate) const MIN_OFFSET: f64 = 0.002;
/// Number of standard errors that a reported offset must also exceed.
const NOISE_STDERRS: f64 = 4.0;
/// Maximum difference between the mean readings in the two halves of the span, relative to the mean over the span, for
/// a constant offset. A load that rises linearly from zero gives 1.
const MAX_HALF_DIFFERENCE: f64 = 0.25;

/// Friction before touchdown counts as that of sliding if its quotient with the normal force differs from the one in the
/// window by at most this factor: dry friction at a tenth and at the whole of a load differs by less.
const MAX_FRICTION_RATIO: f64 = 2.0;

/// Readings of the sensors before touchdown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorZero {
    /// Beginning and end of the span, in seconds since the trace begins.
    pub span_s: [f64; 2],
    /// Mean normal force over the span, in newtons.
    pub force_n: f64,
    /// Friction channel: `torque` or `friction force`.
    pub channel: &'static str,
    /// Mean of the friction channel over the span, in `unit`.
    pub tangential: f64,
    /// `N m` for a torque, `N` for a force.
    pub unit: &'static str,
}

impl fmt::Display for SensorZero {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { force_n, channel, tangential, unit, .. } = self;
        write!(f, "the normal force {force_n:.3} N and the {channel} {tangential:.4} {unit}")
    }
}

/// Creates the error for a requested zero (`zero_s`) if only the friction coefficient of the instrument was recorded.
pub fn of_coefficient() -> TraceError {
    TraceError::Refused(
        "the export has a friction coefficient and neither torque nor friction force, so no zero can be subtracted: expected one of \
         these with the normal force, or no zero_s"
            .to_owned(),
    )
}

/// Creates the error for a requested zero (`zero_s`) if no normal force was recorded, which would show touchdown.
pub fn of_stated_load() -> TraceError {
    TraceError::Refused(
        "no normal force is recorded, so that touchdown is not known and no zero can be subtracted: expected no zero_s"
            .to_owned(),
    )
}

/// Subtracts the mean readings over `span_s` from `channels`; returns the result, the zero, and the standard errors of
/// its normal force and friction. `inside` are the samples of the window, which begins at `window_from_s`; all times
/// except those in `channels` are in seconds since the trace begins.
///
/// # Errors
/// [`TraceError`] if the span is invalid, has too few samples, is under load or in sliding, or if friction is a
/// coefficient.
pub fn subtract(
    channels: &TraceChannels,
    time_s: &[f64],
    inside: &Range<usize>,
    span_s: [f64; 2],
    window_from_s: f64,
) -> Result<(TraceChannels, SensorZero, [f64; 2]), TraceError> {
    let [from_s, to_s] = span_s;
    if !(from_s >= 0.0 && to_s > from_s && to_s.is_finite()) {
        return Err(TraceError::Refused(format!(
            "the zero from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on in zero_s"
        )));
    }
    if to_s > window_from_s {
        return Err(TraceError::Refused(format!(
            "the zero ends at {to_s} s: expected a zero_s that ends before the window begins, at {window_from_s} s"
        )));
    }
    let Some(channel) = zero_channel(&channels.tangential) else { return Err(of_coefficient()) };
    let span = samples_between(time_s, span_s);
    if span.len() < MIN_ZERO_SAMPLES {
        return Err(TraceError::Refused(format!(
            "the zero from {from_s} to {to_s} s holds {} samples, one every {} s: expected a zero_s with at least {MIN_ZERO_SAMPLES} \
             of them before touchdown",
            span.len(),
            significant(sampling_interval(time_s), 3)
        )));
    }
    let zero = mean_readings(channels, &span, span_s, channel);
    let median_n = median(channels.normal_force_n[inside.clone()].to_vec());
    let is_loaded =
        |force_n: f64| (force_n - zero.force_n).abs() >= TOUCHDOWN_FRACTION * (median_n - zero.force_n).abs();
    let loaded = span.clone().find(|&i| is_loaded(channels.normal_force_n[i]));
    // A span that is under load throughout is as constant as one before touchdown.
    let loaded = loaded.or((zero.force_n.abs() >= UNLOADED_FRACTION * median_n.abs()).then_some(span.start));
    if let Some(at) = loaded {
        let (at_s, force_n) = (time_s[at], channels.normal_force_n[at]);
        return Err(TraceError::Refused(format!(
            "the normal force is {force_n} N at {at_s:.2} s, within the zero from {from_s} to {to_s} s, of {median_n:.2} N in the window: \
             expected a zero_s before touchdown, while the head hangs free"
        )));
    }
    if let Some(ratio) = friction_of_sliding(channels, [&span, inside], &zero, median_n) {
        return Err(TraceError::Refused(format!(
            "in the zero from {from_s} to {to_s} s {zero} are read, a friction {ratio:.2} times that in the window: the sample slides \
             under load; expected a zero_s before touchdown, while the head hangs free"
        )));
    }
    let subtract_from = |values: &[f64], zero: f64| values.iter().map(|value| value - zero).collect::<Vec<f64>>();
    let zeroed = TraceChannels {
        time_s: channels.time_s.clone(),
        start_s: channels.start_s,
        tangential: match &channels.tangential {
            Tangential::TorqueNm(values) => Tangential::TorqueNm(subtract_from(values, zero.tangential)),
            Tangential::ForceN(values) => Tangential::ForceN(subtract_from(values, zero.tangential)),
            Tangential::Coefficient(values) => Tangential::Coefficient(values.clone()),
        },
        normal_force_n: subtract_from(&channels.normal_force_n, zero.force_n),
    };
    let errors = [&channels.normal_force_n[..], channels.tangential.values()]
        .map(|values| window_mean(time_s, values, span_s).stderr);
    Ok((zeroed, zero, errors))
}

/// Finds a significant sensor offset in a trace that begins before touchdown, by a rule that is equal for all loads.
/// The first half of the time before the force reaches half of the load is used; this span is halved until it holds no
/// part of a slow loading. `None` without such an offset, if the sample slides there under a smaller load, or if only a
/// coefficient was recorded.
pub fn find_offset(channels: &TraceChannels, time_s: &[f64], inside: &Range<usize>) -> Option<SensorZero> {
    let channel = zero_channel(&channels.tangential)?;
    let usual = |values: &[f64]| median(values[inside.clone()].to_vec());
    let median_n = usual(&channels.normal_force_n);
    let touchdown = channels.normal_force_n.iter().position(|force| force / median_n >= UNLOADED_FRACTION)?;
    let (mut end, mut found) = (touchdown / 2, None);
    while end >= MIN_ZERO_SAMPLES && found.is_none() {
        // Round the end down to 0.01 s, so that the span can be copied from the message.
        let span_s = [0.0, (100.0 * time_s[end - 1]).floor() / 100.0];
        let free = samples_between(time_s, span_s);
        let zero = mean_readings(channels, &free, span_s, channel);
        let is_free = |force_n: &f64| (force_n - zero.force_n).abs() < TOUCHDOWN_FRACTION * median_n.abs();
        let is_all_free = free.len() >= MIN_ZERO_SAMPLES && channels.normal_force_n[free.clone()].iter().all(is_free);
        found = is_all_free.then_some((free, zero));
        end /= 2;
    }
    let (free, zero) =
        found.filter(|(free, zero)| friction_of_sliding(channels, [free, inside], zero, median_n).is_none())?;
    let is_off = |values: &[f64], mean: f64| is_offset(&values[free.clone()], mean, usual(values));
    let tangential = channels.tangential.values();
    (is_off(&channels.normal_force_n, zero.force_n) || is_off(tangential, zero.tangential)).then_some(zero)
}

/// Friction in `span` over that in the window, whose samples are `inside` and whose median normal force is `median_n`, if
/// the sample slides under load in `span`: if the force there is no longer one before touchdown, and friction is in proportion to it; `None` otherwise.
fn friction_of_sliding(
    channels: &TraceChannels,
    [span, inside]: [&Range<usize>; 2],
    zero: &SensorZero,
    median_n: f64,
) -> Option<f64> {
    let load = zero.force_n / median_n;
    if load.is_nan() || load < TOUCHDOWN_FRACTION {
        return None;
    }
    // Back and forth the mean is zero: T = sqrt(mean of T^2 - noise^2)
    let amount = |samples: &Range<usize>| {
        let values = &channels.tangential.values()[samples.clone()];
        let squares = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        (squares - sample_noise(values).powi(2)).max(0.0).sqrt()
    };
    // mu_0 / mu = (T_0 / T) / (N_0 / N)
    let ratio = amount(span) / amount(inside) / load;
    (1.0 / MAX_FRICTION_RATIO..=MAX_FRICTION_RATIO).contains(&ratio).then_some(ratio)
}

/// Whether `values` with the mean `mean` show a constant offset, not a rise, that exceeds the noise and is not
/// negligible compared with the reading `usual` in the window.
fn is_offset(values: &[f64], mean: f64, usual: f64) -> bool {
    let count = values.len() as f64;
    let stderr = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
    let (first, second) = values.split_at(values.len() / 2);
    let mean_of = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    // For white noise the difference of the halves has twice the standard error of the mean; a larger difference is a
    // rise.
    let noise = 2.0 * sample_noise(values) / count.sqrt();
    let is_steady =
        (mean_of(second) - mean_of(first)).abs() <= (MAX_HALF_DIFFERENCE * mean.abs()).max(NOISE_STDERRS * noise);
    is_steady && mean.abs() > (MIN_OFFSET * usual.abs()).max(NOISE_STDERRS * stderr)
}

/// Name and unit of the friction channel; `None` for a coefficient, which has no zero.
const fn zero_channel(tangential: &Tangential) -> Option<(&'static str, &'static str)> {
    match tangential {
        Tangential::TorqueNm(_) => Some((tangential.name(), "N m")),
        Tangential::ForceN(_) => Some((tangential.name(), "N")),
        Tangential::Coefficient(_) => None,
    }
}

fn mean_readings(
    channels: &TraceChannels,
    samples: &Range<usize>,
    span_s: [f64; 2],
    (channel, unit): (&'static str, &'static str),
) -> SensorZero {
    let mean = |values: &[f64]| values[samples.clone()].iter().sum::<f64>() / samples.len() as f64;
    SensorZero {
        span_s,
        force_n: mean(&channels.normal_force_n),
        channel,
        tangential: mean(channels.tangential.values()),
        unit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::red;
    use crate::{TraceFindings, TraceFlag, TraceOptions, analyse};
    use slipgrid_base::statistics::Noise;

    const FREE_S: f64 = 4.0;
    const OPTIONS: TraceOptions = TraceOptions { nominal_force_n: None, speed_m_s: 2e-3, ..crate::tests::OPTIONS };

    /// The sample hangs free for 4 s, is loaded within 1 s, and slides at 0.25 under `load_n`; the sensors have these
    /// offsets.
    fn recorded(load_n: f64, offsets: [f64; 2]) -> TraceChannels {
        noisy(load_n, offsets, &mut Noise::new(7), 0.0)
    }

    /// The same with noise of its own, which remembers for `memory_s`.
    fn noisy(load_n: f64, [force_n, friction_n]: [f64; 2], noise: &mut Noise, memory_s: f64) -> TraceChannels {
        let time_s: Vec<f64> = (0..=800).map(|i| f64::from(i) * 0.05).collect();
        let mut read = |factor: f64, offset: f64| -> Vec<f64> {
            let load = |t: f64| load_n * (t - FREE_S).clamp(0.0, 1.0);
            let noise = red(noise, time_s.len(), 0.05, memory_s);
            time_s.iter().zip(noise).map(|(t, noise)| factor * load(*t) + offset + 0.05 * noise).collect()
        };
        let (normal_force_n, friction) = (read(1.0, force_n), read(0.25, friction_n));
        TraceChannels { time_s, start_s: 0.0, tangential: Tangential::ForceN(friction), normal_force_n }
    }

    fn with(channels: &TraceChannels, zero_s: [f64; 2]) -> Result<TraceFindings, TraceError> {
        analyse(channels, &TraceOptions { zero_s: Some(zero_s), ..OPTIONS })
    }

    #[test]
    fn an_offset_is_told_at_every_load_and_its_zero_removes_it() {
        for load_n in [30.0, 150.0, 1000.0] {
            for offsets in [[2.4, 0.0], [2.4, -0.5], [-2.4, 0.5]] {
                let channels = recorded(load_n, offsets);
                let raw = analyse(&channels, &OPTIONS).unwrap();
                // mu = (0.25 N + offset) / (N + offset)
                let biased = (0.25 * load_n + offsets[1]) / (load_n + offsets[0]);
                assert!((raw.window.mu - biased).abs() < 3e-4, "{load_n} {offsets:?}: {}", raw.window.mu);
                // An offset may turn the loading into apparent run-in, which is another flag.
                let [TraceFlag::ZeroOff(zero), ..] = raw.flags[..] else { panic!("{load_n}: {:?}", raw.flags) };
                assert!((zero.force_n - offsets[0]).abs() < 0.03 && (zero.tangential - offsets[1]).abs() < 0.03);
                let said = raw.flags[0].to_string();
                assert!(said.contains("`zero_s = [0, ") && zero.span_s[1] > 1.9 && zero.span_s[1] < FREE_S, "{said}");
                // The span from the message, and a span chosen by hand. Four standard errors of 0.05 N of noise in both
                // channels, over the 40 samples of the longer span and the 600 of the window.
                let known = 4.0 * 0.05 * (1.0 / 40.0 + 1.0_f64 / 600.0).sqrt() * 1.0_f64.hypot(0.25) / load_n;
                for span_s in [zero.span_s, [0.5, 3.9]] {
                    let found = with(&channels, span_s).unwrap();
                    assert!((found.window.mu - 0.25).abs() < known, "{load_n} {offsets:?}: {}", found.window.mu);
                    assert!((found.normal_force_n / load_n - 1.0).abs() < 2e-3);
                    assert!(matches!(found.flags[..], [TraceFlag::ZeroTaken(_)]), "{:?}", found.flags);
                }
            }
        }
    }

    /// Without the errors of the zero, coverage is about a half after 2 s.
    #[test]
    fn the_error_of_friction_includes_those_of_the_zero() {
        let mut noise = Noise::new(11);
        // The scatter of five samples has some four degrees of freedom: 1.96 errors hold 85 to 88 % (Student's t).
        for (to_s, memory_s, least) in [(2.0, 0.0, 0.92), (3.9, 0.1, 0.92), (0.7, 0.0, 0.92), (0.2, 0.0, 0.82)] {
            let (mut held, mut stated, mut spread) = (0, 0.0, 0.0);
            for _ in 0..500 {
                let found = with(&noisy(60.0, [2.4, 0.8], &mut noise, memory_s), [0.0, to_s]).unwrap().window;
                held += u32::from((found.mu - 0.25).abs() < 1.96 * found.stderr);
                (stated, spread) = (stated + found.stderr.powi(2), spread + (found.mu - 0.25).powi(2));
            }
            let (held, ratio) = (f64::from(held) / 500.0, (stated / spread).sqrt());
            assert!(held > least && ratio < 1.8, "zero of {to_s} s, memory of {memory_s} s: {held} {ratio}");
        }
    }

    #[test]
    fn back_and_forth_the_error_of_the_friction_zero_cancels() {
        let mut trace = recorded(60.0, [0.0, 0.0]);
        let mut noise = Noise::new(5);
        let Tangential::ForceN(friction) = &mut trace.tangential else { panic!() };
        for (t, friction) in trace.time_s.iter().zip(friction) {
            let side = if t % 1.0 < 0.5 { 1.0 } else { -1.0 };
            *friction = if *t < FREE_S { noise.normal() } else { side * 15.0 + 0.05 * noise.normal() };
        }
        let found = analyse(&trace, &TraceOptions { zero_s: Some([0.0, 3.0]), stroke_share: Some(0.5), ..OPTIONS });
        // The friction zero is known to 1 N / sqrt(60) = 0.13 N, 0.002 of the load.
        let window = found.unwrap().window;
        assert!((window.mu - 0.25).abs() < 2e-4 && window.stderr < 2e-4, "{window:?}");
    }

    #[test]
    fn a_torque_has_its_zero_too_and_a_load_of_either_sign() {
        let channels = recorded(150.0, [2.4, 0.5]);
        let arm = |values: &[f64], by: f64| values.iter().map(|value| value * by).collect::<Vec<f64>>();
        let turned = TraceChannels {
            tangential: Tangential::TorqueNm(arm(channels.tangential.values(), 0.04)),
            normal_force_n: arm(&channels.normal_force_n, -1.0),
            ..channels.clone()
        };
        let found =
            analyse(&turned, &TraceOptions { effective_radius_m: 0.04, zero_s: Some([0.0, 3.0]), ..OPTIONS }).unwrap();
        assert!((found.window.mu - with(&channels, [0.0, 3.0]).unwrap().window.mu).abs() < 1e-12);
        let [TraceFlag::ZeroTaken(zero)] = found.flags[1..] else { panic!("{:?}", found.flags) };
        assert!((zero.force_n + 2.4).abs() < 0.03 && zero.unit == "N m", "{zero:?}");
    }

    #[test]
    fn nothing_is_told_of_sensors_at_nil_and_of_traces_that_begin_under_load() {
        let flags = |channels: &TraceChannels| analyse(channels, &OPTIONS).unwrap().flags;
        assert_eq!(flags(&recorded(30.0, [0.0, 0.0])), []);
        // A load that rises slowly from zero is no offset. An offset before the rise is reported.
        let mut slow = recorded(150.0, [0.0, 0.0]);
        let rising = |t: f64, from_s: f64| 150.0 * ((t - from_s) / 8.0).clamp(0.0, 1.0);
        let times = slow.time_s.clone();
        slow.normal_force_n.iter_mut().zip(&times).for_each(|(force, t)| *force = rising(*t, 0.0));
        assert!(!flags(&slow).iter().any(|flag| matches!(flag, TraceFlag::ZeroOff(_))), "{:?}", flags(&slow));
        slow.normal_force_n.iter_mut().zip(&times).for_each(|(force, t)| *force = 2.4 + rising(*t, 1.0));
        assert!(flags(&slow).iter().any(|flag| matches!(flag, TraceFlag::ZeroOff(zero) if zero.force_n < 4.0)));
        // An offset of 0.1 % of the load is below the limit.
        assert_eq!(flags(&recorded(1000.0, [1.0, 0.0])), []);
        let mut late = recorded(150.0, [2.4, 0.0]);
        late.time_s.iter_mut().for_each(|t| *t -= 8.0);
        let from = late.time_s.partition_point(|t| *t < 0.0);
        let late = TraceChannels {
            start_s: late.time_s[from],
            time_s: late.time_s.split_off(from),
            tangential: Tangential::ForceN(late.tangential.values()[from..].to_vec()),
            normal_force_n: late.normal_force_n.split_off(from),
        };
        assert_eq!(analyse(&late, &TraceOptions { window_s: [2.0, 30.0], ..OPTIONS }).unwrap().flags, []);
    }

    #[test]
    fn a_smaller_load_under_which_the_sample_slides_is_no_zero() {
        // 30 s at `first_n` with a friction of 0.3, then 50 N with 0.25; one way, and in strokes of a second.
        let steps = |first_n: f64, stroke_s: Option<f64>| {
            let mut channels = recorded(50.0, [0.0, 0.0]);
            let mut noise = Noise::new(3);
            let Tangential::ForceN(friction) = &mut channels.tangential else { panic!() };
            for ((t, force), friction) in channels.time_s.iter().zip(&mut channels.normal_force_n).zip(friction) {
                let (load_n, mu) = if *t < 15.0 { (first_n, 0.3) } else { (50.0, 0.25) };
                let side = stroke_s.map_or(1.0, |stroke_s| if (t / stroke_s) % 2.0 < 1.0 { 1.0 } else { -1.0 });
                *force = load_n + 0.05 * noise.normal();
                *friction = side * mu * load_n + 0.05 * noise.normal();
            }
            channels
        };
        for first_n in [5.5, 20.0, 24.0] {
            for stroke_s in [None, Some(0.5)] {
                let channels = steps(first_n, stroke_s);
                let options = TraceOptions {
                    window_s: [20.0, 40.0],
                    stroke_share: stroke_s.map(|_| 0.5),
                    static_peak: false,
                    ..OPTIONS
                };
                let found = analyse(&channels, &options).unwrap();
                assert!((found.window.mu - 0.25).abs() < 1e-3, "{first_n}: {:?}", found.window);
                assert_eq!(found.flags, [], "{first_n} {stroke_s:?}");
                let refused = analyse(&channels, &TraceOptions { zero_s: Some([0.0, 14.0]), ..options }).unwrap_err();
                let told = refused.to_string();
                assert!(told.contains("the sample slides under load; expected a zero_s before"), "{first_n}: {told}");
            }
        }
        // The weight of a free head is no sliding, and an offset of the friction sensor beside it neither.
        for offset_n in [0.0, 1.0] {
            let channels = recorded(50.0, [20.0, offset_n]);
            assert!((with(&channels, [0.0, 3.5]).unwrap().window.mu - 0.25).abs() < 1e-3, "{offset_n}");
        }
    }
}
