//! The zero of the sensors: what they read before the sample touches down, while the head hangs free.
//!
//! An offset of the normal force counts in every friction coefficient, the more the smaller the load; it makes friction seem to depend on load.

use std::fmt;
use std::ops::Range;

use super::time_series::{median, sample_noise};
use super::{Tangential, TraceChannels, TraceError, UNLOADED, between, usual_pause};

/// Samples of which a zero is taken, at least.
const FEWEST: usize = 5;
/// Departure of a sample from the zero, over the load in the window, from which it is no longer before touchdown.
const TOUCHES: f64 = 0.1;
/// Offset of a sensor over what it reads in the window that is told: half of what friction is known to at best ...
const OFF: f64 = 0.002;
/// ... if it is also beyond this many standard errors of its mean.
const BEYOND_NOISE: f64 = 4.0;
/// Difference of the two halves of the span, over the mean, up to which it is an offset: of a slow loading it is 1.
const STEADY: f64 = 0.25;

/// What the sensors read before touchdown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorZero {
    /// From when to when, in seconds since the trace begins.
    pub span_s: [f64; 2],
    /// Normal force, in newtons.
    pub force_n: f64,
    /// What friction was read from: `torque` or `friction force`.
    pub channel: &'static str,
    /// Its mean, in `unit`.
    pub tangential: f64,
    /// `N m` of a torque, `N` of a force.
    pub unit: &'static str,
}

impl fmt::Display for SensorZero {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { force_n, channel, tangential, unit, .. } = self;
        write!(f, "the normal force {force_n:.3} N and the {channel} {tangential:.4} {unit}")
    }
}

/// `channels` less what they read from `from_s` to `to_s`; `inside` are the samples of the window, and `time_s` counts from the beginning of the trace.
///
/// # Errors
/// [`TraceError`] for a span that is none, that has too few samples, in which the sample is loaded, and for friction without a zero.
pub fn subtract(
    channels: &TraceChannels,
    time_s: &[f64],
    inside: &Range<usize>,
    span_s: [f64; 2],
    window_from_s: f64,
) -> Result<(TraceChannels, SensorZero), TraceError> {
    let [from_s, to_s] = span_s;
    if !(from_s >= 0.0 && to_s > from_s && to_s.is_finite()) {
        return Err(TraceError::Zero { from_s, to_s });
    }
    if to_s > window_from_s {
        return Err(TraceError::ZeroInWindow { to_s, window_from_s });
    }
    let Some(kind) = kind(&channels.tangential) else { return Err(TraceError::ZeroOfCoefficient) };
    let span = between(time_s, span_s);
    if span.len() < FEWEST {
        let pause_s = usual_pause(time_s);
        return Err(TraceError::ZeroTooShort { from_s, to_s, found: span.len(), expected: FEWEST, pause_s });
    }
    let zero = read(channels, &span, span_s, kind);
    let usual_n = median(channels.normal_force_n[inside.clone()].to_vec());
    let is_loaded = |force_n: f64| (force_n - zero.force_n).abs() >= TOUCHES * (usual_n - zero.force_n).abs();
    let loaded = span.clone().find(|&i| is_loaded(channels.normal_force_n[i]));
    // A span that is under load throughout is as even as one before touchdown.
    let loaded = loaded.or((zero.force_n.abs() >= UNLOADED * usual_n.abs()).then_some(span.start));
    if let Some(at) = loaded {
        let (at_s, force_n) = (time_s[at], channels.normal_force_n[at]);
        return Err(TraceError::ZeroUnderLoad { from_s, to_s, at_s, force_n, usual_n });
    }
    let less = |values: &[f64], zero: f64| values.iter().map(|value| value - zero).collect::<Vec<f64>>();
    let zeroed = TraceChannels {
        time_s: channels.time_s.clone(),
        start_s: channels.start_s,
        tangential: match &channels.tangential {
            Tangential::TorqueNm(values) => Tangential::TorqueNm(less(values, zero.tangential)),
            Tangential::ForceN(values) => Tangential::ForceN(less(values, zero.tangential)),
            Tangential::Coefficient(values) => Tangential::Coefficient(values.clone()),
        },
        normal_force_n: less(&channels.normal_force_n, zero.force_n),
    };
    Ok((zeroed, zero))
}

/// The zero of a trace that begins before touchdown, where a sensor's is not nil: told at every load by the same rule. The first half of the time
/// before the force first reaches half of the load counts, or of a slow loading as much less as leaves it out. Of a coefficient alone there
/// is none.
pub fn offset(channels: &TraceChannels, time_s: &[f64], inside: &Range<usize>) -> Option<SensorZero> {
    let kind = kind(&channels.tangential)?;
    let usual = |values: &[f64]| median(values[inside.clone()].to_vec());
    let usual_n = usual(&channels.normal_force_n);
    let touchdown = channels.normal_force_n.iter().position(|force| force / usual_n >= UNLOADED)?;
    let (mut end, mut found) = (touchdown / 2, None);
    while end >= FEWEST && found.is_none() {
        // To the hundredth of a second before its end, so that the span may be written as it is told.
        let span_s = [0.0, (100.0 * time_s[end - 1]).floor() / 100.0];
        let free = between(time_s, span_s);
        let zero = read(channels, &free, span_s, kind);
        let is_free = |force_n: &f64| (force_n - zero.force_n).abs() < TOUCHES * usual_n.abs();
        let is_all_free = free.len() >= FEWEST && channels.normal_force_n[free.clone()].iter().all(is_free);
        found = is_all_free.then_some((free, zero));
        end /= 2;
    }
    let (free, zero) = found?;
    let is_off = |values: &[f64], mean: f64| is_offset(&values[free.clone()], mean, usual(values));
    let tangential = channels.tangential.values();
    (is_off(&channels.normal_force_n, zero.force_n) || is_off(tangential, zero.tangential)).then_some(zero)
}

/// Whether `values` with this `mean` are those of a sensor that is off, where `usual` is what it reads in the window; not of one that rises.
fn is_offset(values: &[f64], mean: f64, usual: f64) -> bool {
    let count = values.len() as f64;
    let stderr = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
    let (first, second) = values.split_at(values.len() / 2);
    let of = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    // The difference of halves has twice the error of the mean, that of noise from sample to sample: a rise is none.
    let noise = 2.0 * sample_noise(values) / count.sqrt();
    let is_steady = (of(second) - of(first)).abs() <= (STEADY * mean.abs()).max(BEYOND_NOISE * noise);
    is_steady && mean.abs() > (OFF * usual.abs()).max(BEYOND_NOISE * stderr)
}

/// Name and unit of what friction is read from, where it has a zero.
const fn kind(of: &Tangential) -> Option<(&'static str, &'static str)> {
    match of {
        Tangential::TorqueNm(_) => Some((of.name(), "N m")),
        Tangential::ForceN(_) => Some((of.name(), "N")),
        Tangential::Coefficient(_) => None,
    }
}

fn read(
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
    use crate::{TraceFindings, TraceFlag, TraceOptions, analyse};
    use slipgrid_statistics::Noise;

    const FREE_S: f64 = 4.0;
    const OPTIONS: TraceOptions = TraceOptions {
        window_s: [10.0, 40.0],
        effective_radius_m: f64::NAN,
        nominal_force_n: None,
        speed_m_s: 2e-3,
        static_peak: true,
        stroke_share: None,
        zero_s: None,
    };

    /// The head hangs free for 4 s, loads within one, and slides at 0.25 under `load_n`; sensors with these offsets.
    fn recorded(load_n: f64, [force_n, friction_n]: [f64; 2]) -> TraceChannels {
        let mut noise = Noise::new(7);
        let time_s: Vec<f64> = (0..=800).map(|i| f64::from(i) * 0.05).collect();
        let load = |t: f64| load_n * (t - FREE_S).clamp(0.0, 1.0);
        let mut read = |value: f64, offset: f64| value + offset + 0.05 * noise.normal();
        let normal_force_n = time_s.iter().map(|t| read(load(*t), force_n)).collect();
        let friction = time_s.iter().map(|t| read(0.25 * load(*t), friction_n)).collect();
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
                // An offset may make run-in of the loading, which stands beside it.
                let [TraceFlag::ZeroOff(zero), ..] = raw.flags[..] else { panic!("{load_n}: {:?}", raw.flags) };
                assert!((zero.force_n - offsets[0]).abs() < 0.03 && (zero.tangential - offsets[1]).abs() < 0.03);
                let said = raw.flags[0].to_string();
                assert!(said.contains("`zero_s = [0, ") && zero.span_s[1] > 1.9 && zero.span_s[1] < FREE_S, "{said}");
                // As the note says it, and as one who knows the trace does. Four standard errors of 0.05 N of noise in both channels, over the
                // 40 samples of the former span and the 600 of the window.
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
        assert!(found.flags.iter().any(|flag| flag.to_string().contains("-2.4") && flag.to_string().contains("N m")));
    }

    #[test]
    fn nothing_is_told_of_sensors_at_nil_and_of_traces_that_begin_under_load() {
        let flags = |channels: &TraceChannels| analyse(channels, &OPTIONS).unwrap().flags;
        assert_eq!(flags(&recorded(30.0, [0.0, 0.0])), []);
        // The load rises slowly from nil: its beginning is no offset. With one behind a second at rest, the offset is told.
        let mut slow = recorded(150.0, [0.0, 0.0]);
        let rising = |t: f64, from_s: f64| 150.0 * ((t - from_s) / 8.0).clamp(0.0, 1.0);
        let times = slow.time_s.clone();
        slow.normal_force_n.iter_mut().zip(&times).for_each(|(force, t)| *force = rising(*t, 0.0));
        assert!(!flags(&slow).iter().any(|flag| matches!(flag, TraceFlag::ZeroOff(_))), "{:?}", flags(&slow));
        slow.normal_force_n.iter_mut().zip(&times).for_each(|(force, t)| *force = 2.4 + rising(*t, 1.0));
        assert!(flags(&slow).iter().any(|flag| matches!(flag, TraceFlag::ZeroOff(zero) if zero.force_n < 4.0)));
        // 0.1 % of the load is less than what is told.
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
    fn spans_that_have_no_zero_are_refused_by_name() {
        let channels = recorded(150.0, [2.4, 0.0]);
        let refused = |span_s: [f64; 2]| with(&channels, span_s).unwrap_err();
        for span_s in [[2.0, 2.0], [3.0, 1.0], [-1.0, 2.0], [0.0, f64::NAN], [0.0, f64::INFINITY]] {
            assert!(matches!(refused(span_s), TraceError::Zero { .. }), "{span_s:?}");
        }
        assert_eq!(refused([0.0, 12.0]), TraceError::ZeroInWindow { to_s: 12.0, window_from_s: 10.0 });
        assert_eq!(refused([50.0, 60.0]), TraceError::ZeroInWindow { to_s: 60.0, window_from_s: 10.0 });
        assert!(matches!(refused([1.0, 1.1]), TraceError::ZeroTooShort { found: 3, expected: 5, .. }));
        // Into the loading, and under load throughout.
        assert!(matches!(refused([0.0, 4.5]), TraceError::ZeroUnderLoad { at_s, .. } if at_s > 4.0 && at_s < 4.3));
        assert!(matches!(refused([6.0, 9.0]), TraceError::ZeroUnderLoad { .. }));
        assert!(refused([6.0, 9.0]).to_string().contains("expected a zero_s before touchdown"));
        let divided = TraceChannels { tangential: Tangential::Coefficient(vec![0.25; 801]), ..channels };
        assert_eq!(with(&divided, [0.0, 2.0]), Err(TraceError::ZeroOfCoefficient));
    }
}
