//! Tribometer traces: from recorded torque or friction force and normal force to dynamic friction, static peak and
//! stick-slip.
//!
//! | item | role |
//! |---|---|
//! | [`export::parse`], [`export::TraceFile`] | parse the text of an instrument's export into repeats |
//! | [`columns`], [`columns::Titles`] | recognition of columns, and custom titles |
//! | [`cells`] | cells of a table with any separator and decimal sign |
//! | [`TraceChannels`], [`TraceOptions`] | recorded channels, and options for the analysis |
//! | [`analyse`], [`TraceFindings`] | friction against time with mean, static peak, stick-slip and flags |
//! | [`TraceError`], [`TraceFlag`] | reasons for refusing a trace, and warnings about an accepted one |
//! | [`TraceOptions::stroke_share`] | friction in the middle of every stroke, for reciprocating sliding |
//! | [`TraceOptions::zero_s`] | time span before touchdown, for the zero of the sensors |
//! | [`speed_of_position`], [`lag_of_friction`] | speed from a recorded position, lag of friction behind it |
//! | [`average`], [`Repeats`] | means over the repeats of a condition |
//! | [`moderate`] | scatter of repeats, pooled over conditions |
//! | [`odd_repeats`], [`OddRepeat`] | outliers among repeats |
//!
//! ```text
//! mu(t) = M(t) / (N(t) r_eff)   for a torque M,     mu(t) = F(t) / N(t)   for a friction force F
//! ```
//!
//! with the normal force N and the distance r_eff from the axis to the centre of a specimen. The mean of mu over the
//! averaging window is the dynamic friction. It is taken over time, because samples need not be even. This crate opens
//! no files and knows nothing of calibrations.
//!
//! In the example, a sample sticks for a second while the drive loads it to 0.3, then slides at 0.25 with a ripple that
//! averages out over whole periods:
//!
//! ```
//! use slipgrid_traces::{TraceOptions, analyse, export};
//! let mut text = String::from("Time [ms];Fx [N];Fz [N]\n");
//! for sample in 0..=300 {
//!     let t = f64::from(sample) * 0.01;
//!     let ripple = 0.001 * (std::f64::consts::TAU * 4.0 * t).sin();
//!     let mu = if t < 1.0 { 0.3 * t } else { 0.25 + ripple };
//!     text += &format!("{:.0};{};50\n", t * 1000.0, 50.0 * mu);
//! }
//! let file = export::parse(&text, &export::ExportOptions::default())?;
//! let options = TraceOptions {
//!     window_s: [1.5, 2.5],
//!     effective_radius_m: 1.0,
//!     nominal_force_n: Some(50.0),
//!     speed_m_s: 2e-3,
//!     static_peak: true,
//!     stroke_share: None,
//!     zero_s: None,
//! };
//! let found = analyse(&file.repeats[0].channels, &options)?;
//! assert!((found.window.mu - 0.25).abs() < 1e-9);
//! let peak = found.static_peak.ok_or("no static peak")?;
//! // The highest sample is 0.297; the standard deviation includes what sampling may have missed of the peak at 0.3.
//! assert!((peak.mu - 0.297).abs() < 1e-12 && peak.std >= 0.003);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod averaging_window;
mod breaks;
pub mod cells;
mod channels;
mod checks;
pub mod columns;
mod correlated_noise;
pub mod export;
mod export_error;
mod lag;
mod layout;
mod load;
mod markers;
pub mod missing_numbers;
mod position;
mod recorded;
mod repeats;
mod run_in;
mod static_peak;
mod stick_slip;
mod strokes;
mod time_series;
mod trace_errors;
mod zero;

pub use averaging_window::WindowMean;
pub use breaks::Break;
pub use lag::{Lag, friction_loops, lag_of_friction};
pub use position::speed_of_position;
pub use repeats::{MeanStd, OddRepeat, Repeats, average, moderate, odd_repeats};
pub use run_in::RunIn;
pub use static_peak::TracePeak;
pub use stick_slip::StickSlip;
pub use strokes::DEFAULT_STROKE_SHARE;
pub use trace_errors::{TraceError, TraceFlag};
pub use zero::SensorZero;

use slipgrid_base::units::{counted, significant};

use checks::{
    check_channels, check_saturation, correct_sign, find_gaps, no_friction, samples_between, sampling_interval,
    window_samples,
};
use static_peak::before_window;

/// A sample of the trace counts as unloaded if its normal force is below this fraction of the median normal force in
/// the window.
const UNLOADED_FRACTION: f64 = 0.5;
/// Minimum mean friction coefficient of a specimen that slides: a hundredth of the lowest dry friction of solids.
const MIN_FRICTION: f64 = 1e-4;
/// Maximum change of friction over the window, relative to mean friction, in steady sliding. If a specimen sticks
/// throughout, friction rises linearly with time, and this ratio is 2 (t2 - t1) / (t2 + t1) for a window from t1 to t2:
/// 1.2 for the default window.
const MAX_DRIFT: f64 = 0.6;
/// Maximum distance, in metres, that a drive moves between two slips: the elastic deformation of arm and specimen
/// before a slip. Tribometers deform by 1 um to 1 mm, sleds on a cord by some millimetres.
const MAX_SLIP_M: f64 = 0.01;
/// A drift of friction over the window is flagged if it exceeds this fraction of mean friction.
const FLAGGED_DRIFT: f64 = 0.02;
/// Number of standard errors that a flagged drift must also exceed. Noise alone exceeds this number in less than 2 % of
/// traces with correlation times up to a fifteenth of the window, and in 3 % at a sixth of the window.
const FLAGGED_DRIFT_STDERRS: f64 = 3.0;

/// Recorded friction signal.
#[derive(Clone, Debug, PartialEq)]
pub enum Tangential {
    /// Torque about the axis, in newton metres.
    TorqueNm(Vec<f64>),
    /// Friction force, in newtons.
    ForceN(Vec<f64>),
    /// Friction coefficient, computed by the instrument.
    Coefficient(Vec<f64>),
}

impl Tangential {
    /// Values of the signal, in the unit of its quantity.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::TorqueNm(values) | Self::ForceN(values) | Self::Coefficient(values) => values,
        }
    }

    const fn name(&self) -> &'static str {
        match self {
            Self::TorqueNm(_) => "torque",
            Self::ForceN(_) => "friction force",
            Self::Coefficient(_) => "friction coefficient",
        }
    }
}

/// A recorded trace.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceChannels {
    /// Time of every sample, in seconds.
    pub time_s: Vec<f64>,
    /// Time of the first row on the clock of `time_s`, in seconds: the beginning of the trace, even if this row lacks
    /// other numbers and is no sample.
    pub start_s: f64,
    /// Friction signal.
    pub tangential: Tangential,
    /// Normal force on the whole sample holder, in newtons; empty if it was not recorded.
    pub normal_force_n: Vec<f64>,
}

impl TraceChannels {
    /// Bits of the sums of squares of time, friction signal and normal force, in this order: nearly unique, to detect a
    /// trace that is given twice. Only the first number depends on the start of the clock.
    pub fn fingerprint(&self) -> [u64; 3] {
        [&self.time_s, self.tangential.values(), &self.normal_force_n]
            .map(|values| values.iter().map(|value| value * value).sum::<f64>().to_bits())
    }
}

/// Options for the analysis of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceOptions {
    /// Averaging window, in seconds since the trace begins.
    pub window_s: [f64; 2],
    /// Distance r_eff from the axis to the centre of a specimen, in metres; needed for a torque.
    pub effective_radius_m: f64,
    /// Nominal normal force on the whole sample holder, in newtons; `None` if unknown.
    pub nominal_force_n: Option<f64>,
    /// Sliding speed, in m/s; used to distinguish a static peak from run-in by the distance slid.
    pub speed_m_s: f64,
    /// Whether to look for a static peak and for run-in before the window.
    pub static_peak: bool,
    /// Central fraction of every stroke that is used in reciprocating sliding, above 0 up to 1; `None` for sliding in
    /// one direction. If given, neither static peak nor stick-slip is looked for.
    pub stroke_share: Option<f64>,
    /// Start and end of a span before touchdown, in seconds since the trace begins. The mean normal force and friction
    /// force (or torque) over the span are subtracted as the zero of the sensors; `None` subtracts nothing.
    pub zero_s: Option<[f64; 2]>,
}

/// Default averaging window in seconds, 10 to 40 s, as in Balestra et al., J. Tribol. 144, 031704.
pub const DEFAULT_WINDOW_S: [f64; 2] = [10.0, 40.0];

/// Results of the analysis of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceFindings {
    /// Time of every loaded sample, in seconds since the trace begins; in reciprocating sliding, of every pair of
    /// successive strokes (of every stroke if the sign was not recorded).
    pub time_s: Vec<f64>,
    /// Friction coefficient at each time in `time_s`, positive against the motion.
    pub mu: Vec<f64>,
    /// Averaging window, in seconds since the trace begins.
    pub window_s: [f64; 2],
    /// Mean, error and drift over the window.
    pub window: WindowMean,
    /// Static peak; `None` if friction does not stand out at the onset of sliding, or if no peak was looked for.
    pub static_peak: Option<TracePeak>,
    /// Stick-slip in the window; `None` if there is none.
    pub stick_slip: Option<StickSlip>,
    /// Median normal force in the window, in newtons.
    pub normal_force_n: f64,
    /// Number of recorded samples in the window.
    pub samples: usize,
    /// Warnings about the trace.
    pub flags: Vec<TraceFlag>,
}

/// Computes dynamic friction, static peak and stick-slip of a trace.
///
/// # Errors
/// [`TraceError`] if the trace is unusable.
pub fn analyse(channels: &TraceChannels, options: &TraceOptions) -> Result<TraceFindings, TraceError> {
    check_channels(channels, options)?;
    if channels.normal_force_n.is_empty() {
        let is_divided = matches!(channels.tangential, Tangential::Coefficient(_));
        if options.zero_s.is_some() {
            return Err(if is_divided { zero::of_coefficient() } else { zero::of_stated_load() });
        }
        // A coefficient needs no force: the nominal force stands in for the missing channel, and is not used for
        // checks. A friction force is divided by the nominal force, like that of a dead weight.
        let nominal_n = match options.nominal_force_n {
            Some(nominal_n) => nominal_n,
            None if is_divided => 1.0,
            None => {
                return Err(TraceError::Refused(format!(
                    "no normal force is recorded and none is stated: expected one of the two to divide the {} by",
                    channels.tangential.name()
                )));
            }
        };
        let flag = if is_divided {
            TraceFlag::LoadNotRecorded
        } else {
            TraceFlag::Odd(format!(
                "no normal force is recorded: friction is over the stated {nominal_n} N, as of a dead weight"
            ))
        };
        let filled = TraceChannels { normal_force_n: vec![nominal_n; channels.time_s.len()], ..channels.clone() };
        return analyse(&filled, options).map(|mut found| {
            found.flags.push(flag);
            found
        });
    }
    let time_s: Vec<f64> = channels.time_s.iter().map(|t| t - channels.start_s).collect();
    let inside = window_samples(&time_s, options.window_s)?;
    if let Some(span_s) = options.zero_s {
        let (zeroed, zero, errors) = zero::subtract(channels, &time_s, &inside, span_s, options.window_s[0])?;
        return analyse(&zeroed, &TraceOptions { zero_s: None, ..*options }).map(|mut found| {
            let arm =
                if matches!(channels.tangential, Tangential::TorqueNm(_)) { options.effective_radius_m } else { 1.0 };
            // Of two strokes the zero of friction cancels.
            let cancels = options.stroke_share.is_some() && !found.flags.contains(&TraceFlag::SignNotRecorded);
            let [force, friction] = errors.map(|error| error / found.normal_force_n);
            let friction = if cancels { 0.0 } else { friction / arm };
            // mu = (F - F_0) / (N - N_0)
            found.window.stderr = found.window.stderr.hypot(friction.hypot(found.window.mu * force));
            found.flags.push(TraceFlag::ZeroTaken(zero));
            found
        });
    }
    let mut flags = find_gaps(&time_s, options.window_s)?;
    let (median_n, load_turned) = load::check_load(channels, &time_s, &inside, options, &mut flags)?;
    check_saturation(channels, &inside, &mut flags)?;
    flags.extend(zero::find_offset(channels, &time_s, &inside).map(TraceFlag::ZeroOff));

    let load_sign = if load_turned { -1.0 } else { 1.0 };
    // Unloaded samples are dropped: torque over force is meaningless before the load acts.
    let loaded: Vec<usize> =
        (0..time_s.len()).filter(|&i| load_sign * channels.normal_force_n[i] >= UNLOADED_FRACTION * median_n).collect();
    // mu = T / (F r_eff), equation (1) of Balestra et al.
    let divisor = |i: usize| match channels.tangential {
        Tangential::TorqueNm(_) => load_sign * channels.normal_force_n[i] * options.effective_radius_m,
        Tangential::ForceN(_) => load_sign * channels.normal_force_n[i],
        Tangential::Coefficient(_) => 1.0,
    };
    let coefficient = |i: usize| channels.tangential.values()[i] / divisor(i);
    let mut mu: Vec<f64> = loaded.iter().map(|&i| coefficient(i)).collect();
    let mut time_s: Vec<f64> = loaded.iter().map(|&i| time_s[i]).collect();
    if let Some(share) = options.stroke_share {
        // An instrument that writes the coefficient has divided by the normal force.
        let load = |i: usize| match channels.tangential {
            Tangential::Coefficient(_) => load_sign * channels.normal_force_n[i],
            _ => divisor(i),
        };
        let load: Vec<f64> = loaded.iter().map(|&i| load(i)).collect();
        (time_s, mu) = strokes::friction_of_strokes(&time_s, [&mu, &load], options.window_s, share, &mut flags)?;
    } else if correct_sign(&time_s, &mut mu, options.window_s)? {
        flags.push(TraceFlag::Odd("friction is recorded as negative and was turned".to_owned()));
    }

    let window = averaging_window::window_mean(&time_s, &mu, options.window_s);
    if window.mu.abs() < MIN_FRICTION {
        return Err(no_friction(window.mu));
    }
    let in_window = samples_between(&time_s, options.window_s);
    let one_way = options.stroke_share.is_none();
    let found = stick_slip::oscillation(&time_s[in_window.clone()], &mu[in_window.clone()], window.mu);
    let (swing, crests_s) = found.filter(|_| one_way).unzip();
    let is_known = swing.as_ref().is_some_and(|swing: &StickSlip| swing.is_relaxation() || swing.is_regular());
    let crests_s = crests_s.filter(|_| is_known).unwrap_or_default();
    let window = window.of_swings(&time_s, &mu, options.window_s, &crests_s);
    if window.drift.abs() > (MAX_DRIFT * window.mu).max(FLAGGED_DRIFT_STDERRS * window.drift_stderr) {
        return Err(TraceError::Refused(format!(
            "friction changes by {:+.0} % of its mean over the window: the sample sticks or has not settled; expected \
             steady sliding, or a window_s that holds it",
            100.0 * (window.drift / window.mu)
        )));
    }
    let broken = breaks::find_break(&mu[in_window.clone()]).map(|found| (time_s[in_window.start + found.at], found));
    // A disturbed force disturbs friction as well.
    let is_told =
        |time_s: f64| flags.iter().any(|flag| matches!(flag, TraceFlag::Broken { time_s: at, .. } if *at == time_s));
    let broken = broken.filter(|(time_s, _)| !is_told(*time_s));
    if let Some((time_s, found)) = broken {
        flags.push(TraceFlag::Broken { signal: "friction", unit: "", time_s, found });
    }
    // A jump shows as drift, too.
    let is_jump = broken.is_some_and(|(_, found)| found.disturbed.is_none());
    if !is_jump && window.drift.abs() > (FLAGGED_DRIFT * window.mu).max(FLAGGED_DRIFT_STDERRS * window.drift_stderr) {
        flags.push(TraceFlag::Odd(format!(
            "friction drifts by {:+.1} +- {:.1} % over the window: the mean depends on when it is taken",
            100.0 * (window.drift / window.mu),
            100.0 * (window.drift_stderr / window.mu)
        )));
    }
    let saturated = flags.iter().any(|flag| matches!(flag, TraceFlag::PeakSaturated { .. }));
    let is_sought = one_way && options.static_peak && !saturated;
    let before = is_sought.then(|| {
        let window = (options.window_s, window.mu);
        before_window(&time_s, &mu, window, options.speed_m_s, sampling_interval(&time_s))
    });
    let static_peak = before.and_then(|found| found.peak);
    if let Some(run_in) = before.and_then(|found| found.run_in) {
        flags.push(TraceFlag::Odd(run_in.words(static_peak.is_some(), options.speed_m_s)));
    }
    if let Some(highest) = before.and_then(|found| found.unresolved) {
        flags.push(TraceFlag::Odd(format!(
            "friction is highest, {:.4}, at {:.2} s and falls; with one sample every {} mm run-in and a static peak, which is over \
             within {} mm, look alike: no static peak is taken",
            highest.mu,
            highest.time_s,
            significant(1e3 * sampling_interval(&time_s) * options.speed_m_s, 2),
            1e3 * static_peak::ONSET_SLIP_M
        )));
    }
    if let Some(peak) = static_peak.filter(TracePeak::is_coarse) {
        flags.push(TraceFlag::Odd(format!(
            "the static peak rests on {} and may have been higher: friction changes by {:.4} beside it",
            counted(peak.samples_at_top, "sample"),
            peak.missed
        )));
    }
    let travel_m = |swing: &StickSlip| swing.period_s * options.speed_m_s;
    let is_elastic = |swing: &StickSlip| travel_m(swing) <= MAX_SLIP_M;
    let slips = swing.filter(StickSlip::is_relaxation);
    match swing {
        Some(swing) if slips.is_some() && !is_elastic(&swing) => flags.push(TraceFlag::Odd(format!(
            "friction falls by {:.4} every {:.2} s, on a way of {:.1} mm: no stick-slip, between slips of which a drive goes \
             {} mm at most, as far as arm and specimen yield",
            swing.amplitude,
            swing.period_s,
            1e3 * travel_m(&swing),
            1e3 * MAX_SLIP_M
        ))),
        Some(swing) if slips.is_none() && swing.is_regular() => {
            flags.push(TraceFlag::Odd(format!(
                "an oscillation of {:.4} with a period of {:.2} s that rises as fast as it falls: no stick-slip",
                swing.amplitude, swing.period_s
            )));
        }
        _ => {}
    }
    Ok(TraceFindings {
        time_s,
        mu,
        window_s: options.window_s,
        window,
        static_peak,
        stick_slip: slips.filter(is_elastic),
        normal_force_n: median_n,
        samples: inside.len(),
        flags,
    })
}

#[cfg(test)]
mod instrument_tests;
#[cfg(test)]
mod tests;
