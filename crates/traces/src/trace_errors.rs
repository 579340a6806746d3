//! Why a trace was refused, and what is odd about one that was not.

use std::fmt;

use super::load::LoadSlip;
use super::run_in::RunIn;
use super::zero::SensorZero;

/// Why nothing can be read from a trace. Times are seconds since the trace begins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// A number that was not measured.
    #[error("sample {sample}: {channel} is {value}: expected a finite number")]
    NotFinite {
        /// Its number, from 1.
        sample: usize,
        /// Which channel.
        channel: &'static str,
        /// The number.
        value: f64,
    },
    /// Channels of unequal lengths.
    #[error("{channel} has {found} samples: expected {expected}, as time")]
    LengthMismatch {
        /// Which channel.
        channel: &'static str,
        /// Its samples.
        found: usize,
        /// Samples of time.
        expected: usize,
    },
    /// The clock goes back.
    #[error(
        "the clock goes back at sample {sample}: from {from_s} s to {to_s} s{}",
        likely.map_or_else(String::new, |channel| {
            format!("; the {channel} rises throughout, so that time and {channel} are likely in each other's place")
        })
    )]
    ClockBack {
        /// Number of the later sample, from 1.
        sample: usize,
        /// Time before.
        from_s: f64,
        /// Time after.
        to_s: f64,
        /// The channel that rises throughout as time would.
        likely: Option<&'static str>,
    },
    /// The averaging window has no length or begins before the trace.
    #[error("the window from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on")]
    Window {
        /// Its beginning.
        from_s: f64,
        /// Its end.
        to_s: f64,
    },
    /// The trace ends before the averaging window does.
    #[error(
        "the trace ends at {end_s:.4} s, with a sample every {} s: expected one that covers the window up to {window_end_s} s, or \
         another window, window_s in [traces] or --window-s; if the trace was longer, time is in another unit than its title says, as \
         `Time [s]`", short(*pause_s)
    )]
    TooShort {
        /// Time of the last sample.
        end_s: f64,
        /// End of the window.
        window_end_s: f64,
        /// Usual time between samples.
        pause_s: f64,
    },
    /// Too few samples in the window for a mean with an error.
    #[error(
        "the window holds {found} samples, one every {} s: expected at least {expected}; if they were recorded faster, time \
         is in another unit than its title says, as `Time [s]`",
        short(*pause_s)
    )]
    TooFewSamples {
        /// Samples there are.
        found: usize,
        /// Samples needed.
        expected: usize,
        /// Usual time between samples.
        pause_s: f64,
    },
    /// Samples are missing inside the window.
    #[error("no samples from {from_s:.2} to {to_s:.2} s, inside the averaging window")]
    Gap {
        /// Last sample before.
        from_s: f64,
        /// First sample after.
        to_s: f64,
    },
    /// No load in the window.
    #[error("the normal force falls to {force_n} N at {time_s:.2} s, of {usual_n:.2} N: expected a sample under load")]
    NoLoad {
        /// When.
        time_s: f64,
        /// The force there.
        force_n: f64,
        /// Median force in the window.
        usual_n: f64,
    },
    /// The load is not the one that was meant.
    #[error(
        "the normal force is {} N in the window: expected about {nominal_n} N, as the condition says{}", short(*found_n),
        likely.map_or_else(String::new, |likely| format!("; {likely}"))
    )]
    WrongLoad {
        /// Mean force in the window.
        found_n: f64,
        /// Nominal force.
        nominal_n: f64,
        /// What has likely gone wrong.
        likely: Option<LoadSlip>,
    },
    /// Friction along the motion in part of the window.
    #[error(
        "friction changes its sign in the window ({opposite} of {samples} samples are against the mean): expected \
         sliding in one direction; of a sample that slides back and forth, `reciprocating = true` in [traces] or --reciprocating"
    )]
    WrongSign {
        /// Samples of the other sign.
        opposite: usize,
        /// Samples in the window.
        samples: usize,
    },
    /// The sensor stands at the end of its range.
    #[error("the {channel} stands at {value} in {samples} samples of the window: expected a sensor within its range")]
    Saturated {
        /// Which channel.
        channel: &'static str,
        /// The value, in the channel's SI unit.
        value: f64,
        /// Samples with exactly this value.
        samples: usize,
    },
    /// Nothing rubs.
    #[error(
        "friction is {mu:.6} in the window, as of a sample that does not slide: expected torque or friction force \
         while the sample slides, and its unit in the header"
    )]
    NoFriction {
        /// Mean friction coefficient in the window.
        mu: f64,
    },
    /// Friction changes as of a sample that is only loaded, or that has hardly begun to slide.
    #[error(
        "friction changes by {:+.0} % of its mean over the window: the sample sticks or has not settled; expected \
         steady sliding, or a window_s that holds it", 100.0 * relative
    )]
    Unsettled {
        /// Change of mu over the window, relative to the mean.
        relative: f64,
    },
    /// Sliding back and forth that turns too seldom.
    #[error(
        "the window holds {found} strokes back and forth: expected at least {expected}, in a longer window; of a sample \
         that slides in one direction, no `reciprocating`"
    )]
    TooFewStrokes {
        /// Strokes there are.
        found: usize,
        /// Strokes needed.
        expected: usize,
    },
    /// Strokes of which too little was recorded.
    #[error(
        "the stroke from {at_s:.3} s on has {samples} samples in its middle: expected at least {expected}, recorded at \
         a higher rate or with a larger `stroke_share`"
    )]
    StrokeTooCoarse {
        /// Its beginning.
        at_s: f64,
        /// Samples in its middle.
        samples: usize,
        /// Samples needed.
        expected: usize,
    },
    /// A part of a stroke that is none.
    #[error("the part of a stroke is {value}: expected a number above 0 up to 1")]
    StrokeShare {
        /// What was given.
        value: f64,
    },
    /// A span of the sensors' zero that has no length or begins before the trace.
    #[error("the zero from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on in zero_s")]
    Zero {
        /// Its beginning.
        from_s: f64,
        /// Its end.
        to_s: f64,
    },
    /// The same that reaches into the averaging window.
    #[error("the zero ends at {to_s} s: expected a zero_s that ends before the window begins, at {window_from_s} s")]
    ZeroInWindow {
        /// Its end.
        to_s: f64,
        /// Beginning of the window.
        window_from_s: f64,
    },
    /// The same with too few samples for a mean.
    #[error(
        "the zero from {from_s} to {to_s} s holds {found} samples, one every {} s: expected a zero_s with at least {expected} of them before \
         touchdown", short(*pause_s)
    )]
    ZeroTooShort {
        /// Its beginning.
        from_s: f64,
        /// Its end.
        to_s: f64,
        /// Samples there are.
        found: usize,
        /// Samples needed.
        expected: usize,
        /// Usual time between samples.
        pause_s: f64,
    },
    /// The same while the sample is loaded.
    #[error(
        "the normal force is {force_n} N at {at_s:.2} s, within the zero from {from_s} to {to_s} s, of {usual_n:.2} N in the window: expected \
         a zero_s before touchdown, while the head hangs free"
    )]
    ZeroUnderLoad {
        /// Its beginning.
        from_s: f64,
        /// Its end.
        to_s: f64,
        /// When.
        at_s: f64,
        /// The force there.
        force_n: f64,
        /// Median force in the window.
        usual_n: f64,
    },
    /// A zero is asked for of what the instrument divided.
    #[error(
        "the export has a friction coefficient and neither torque nor friction force, so no zero can be subtracted: expected one of \
         these with the normal force, or no zero_s"
    )]
    ZeroOfCoefficient,
    /// A zero is asked for where no load says when the sample touches down.
    #[error(
        "no normal force is recorded, so that touchdown is not known and no zero can be subtracted: expected no zero_s"
    )]
    ZeroOfStatedLoad,
    /// A torque or friction force alone, and no force is stated.
    #[error("no normal force is recorded and none is stated: expected one of the two to divide the {channel} by")]
    NoStatedLoad {
        /// `torque` or `friction force`.
        channel: &'static str,
    },
    /// A torque without the radius at which it acts.
    #[error(
        "the effective radius is {value_m} m: expected a positive length, torque / (normal force x radius) is friction"
    )]
    Radius {
        /// The radius given.
        value_m: f64,
    },
}

/// A number with three digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// What is odd about a trace from which something was read all the same.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceFlag {
    /// Friction drifts through the window.
    Drift {
        /// Change of mu over the window, relative to the mean.
        relative: f64,
        /// Its standard error.
        stderr: f64,
    },
    /// Friction is recorded with a negative sign; it has been turned.
    FrictionTurned,
    /// The normal force is recorded as negative; it has been turned.
    LoadTurned,
    /// The normal force departs from the nominal one.
    LoadOff {
        /// Mean force in the window, in newtons.
        found_n: f64,
        /// Nominal force, in newtons.
        nominal_n: f64,
        /// What has likely gone wrong.
        likely: Option<LoadSlip>,
    },
    /// No normal force was recorded beside the coefficient.
    LoadNotRecorded,
    /// No normal force was recorded beside a torque or friction force: it was divided by the stated one.
    LoadStated {
        /// Stated force on the whole sample holder, in newtons.
        nominal_n: f64,
    },
    /// The normal force is unsteady.
    LoadUnsteady {
        /// Its standard deviation in the window over its mean.
        relative_std: f64,
    },
    /// Samples are missing where the mean hardly notices.
    Gap {
        /// Last sample before the longest gap.
        from_s: f64,
        /// First sample after it.
        to_s: f64,
        /// Gaps in all.
        count: usize,
    },
    /// Friction changes slowly before the window.
    RunIn {
        /// By how much, and when.
        run_in: RunIn,
        /// A static peak stands before it.
        peak: bool,
    },
    /// The sensor was at the end of its range before the window: no static peak is taken.
    PeakSaturated {
        /// The value, in the channel's SI unit.
        value: f64,
    },
    /// The static peak rests on few samples: it may have been higher.
    PeakCoarse {
        /// Samples in its upper quarter.
        samples: usize,
        /// What sampling may have missed.
        missed: f64,
    },
    /// The sensors do not read nil before touchdown.
    ZeroOff(SensorZero),
    /// What they read there was subtracted.
    ZeroTaken(SensorZero),
    /// The recorded numbers are rounded so much that few different ones occur.
    Coarse {
        /// Different values in the window.
        levels: usize,
    },
    /// Strokes there and back differ: the sensor has an offset, or the sample is tilted.
    StrokesDiffer {
        /// Mean of friction there and back with their signs, which would be zero.
        offset: f64,
        /// The same over friction.
        relative: f64,
    },
    /// Strokes of unequal durations.
    StrokesUneven {
        /// How many.
        count: usize,
        /// Of how many.
        of: usize,
        /// The usual duration.
        usual_s: f64,
    },
    /// Friction of strokes there and back is recorded alike.
    SignNotRecorded,
    /// A regular oscillation that is no stick-slip: it falls as slowly as it rises.
    Oscillation {
        /// Peak to peak.
        amplitude: f64,
        /// Period.
        period_s: f64,
    },
    /// Falls and rises as of stick-slip, farther apart than anything yields: not taken for stick-slip.
    SlipTooLong {
        /// Median drop of mu.
        amplitude: f64,
        /// Period.
        period_s: f64,
        /// Way of the drive in it, in metres.
        way_m: f64,
        /// Longest way from slip to slip.
        longest_m: f64,
    },
}

impl fmt::Display for TraceFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drift { relative, stderr } => write!(
                f,
                "friction drifts by {:+.1} +- {:.1} % over the window: the mean depends on when it is taken",
                100.0 * relative,
                100.0 * stderr
            ),
            Self::FrictionTurned => f.write_str("friction is recorded as negative and was turned"),
            Self::LoadTurned => f.write_str("the normal force is recorded as negative and was turned"),
            Self::LoadOff { found_n, nominal_n, likely } => {
                write!(f, "the normal force is {found_n:.2} N, not the nominal {nominal_n} N")?;
                likely.map_or(Ok(()), |likely| write!(f, "; {likely}"))
            }
            Self::LoadNotRecorded => {
                f.write_str("no normal force is recorded: it is not known that the nominal one acted")
            }
            Self::LoadStated { nominal_n } => {
                write!(f, "no normal force is recorded: friction is over the stated {nominal_n} N, as of a dead weight")
            }
            Self::LoadUnsteady { relative_std } => {
                write!(f, "the normal force varies by {:.1} % in the window", 100.0 * relative_std)
            }
            Self::Gap { from_s, to_s, count: 1 } => write!(f, "no samples from {from_s:.2} to {to_s:.2} s"),
            Self::Gap { from_s, to_s, count } => {
                write!(f, "{count} gaps; the longest has no samples from {from_s:.2} to {to_s:.2} s")
            }
            Self::RunIn { run_in, peak } => write!(
                f,
                "friction {} by {:.4}, {:.0} %, after {:.2} s, half of it within {:.2} s: run-in{}",
                if run_in.change < 0.0 { "falls" } else { "rises" },
                run_in.change.abs(),
                100.0 * run_in.relative.abs(),
                run_in.from_s,
                run_in.half_s - run_in.from_s,
                match (*peak, run_in.change < 0.0) {
                    (true, _) => " behind a static peak",
                    (false, true) => ", no static peak",
                    (false, false) => "",
                }
            ),
            Self::PeakSaturated { value } => {
                write!(f, "the sensor stood at {value} before the window: no static peak is taken")
            }
            Self::PeakCoarse { samples, missed } => write!(
                f,
                "the static peak rests on {samples} sample{} and may have been higher: friction changes by {missed:.4} beside it",
                if *samples == 1 { "" } else { "s" }
            ),
            Self::ZeroOff(zero) => write!(
                f,
                "before touchdown, up to {:.2} s, {zero} are read: if the head hangs free there, this offset of the sensors counts in friction; \
                 `zero_s = [{}, {:.2}]` in [traces] or --zero-s subtracts it",
                zero.span_s[1], zero.span_s[0], zero.span_s[1]
            ),
            Self::ZeroTaken(zero) => write!(
                f,
                "{zero} were subtracted as the sensors' zero, from {} to {} s",
                zero.span_s[0], zero.span_s[1]
            ),
            Self::Coarse { levels } => write!(f, "only {levels} different values occur in the window"),
            Self::StrokesDiffer { offset, relative } => write!(
                f,
                "strokes there and back differ by an offset of {offset:+.4}, {:.0} % of friction: half the width of the loop is taken",
                100.0 * relative.abs()
            ),
            Self::StrokesUneven { count, of, usual_s } => {
                write!(f, "{count} of {of} strokes do not last the usual {usual_s:.3} s")
            }
            Self::SignNotRecorded => f.write_str(
                "friction of strokes there and back is recorded alike: an offset of the sensor would not be seen",
            ),
            Self::Oscillation { amplitude, period_s } => write!(
                f,
                "an oscillation of {amplitude:.4} with a period of {period_s:.2} s that rises as fast as it falls: no stick-slip"
            ),
            Self::SlipTooLong { amplitude, period_s, way_m, longest_m } => write!(
                f,
                "friction falls by {amplitude:.4} every {period_s:.2} s, on a way of {:.1} mm: no stick-slip, between slips of which a drive goes \
                 {} mm at most, as far as arm and specimen yield",
                1e3 * way_m,
                1e3 * longest_m
            ),
        }
    }
}
