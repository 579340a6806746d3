//! Reasons for refusing a trace, and warnings about an accepted one.

use std::fmt;

use super::load::LoadMistake;
use super::run_in::RunIn;
use super::zero::SensorZero;

/// Reason why a trace was refused. Times are seconds since the trace begins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// A value is not finite.
    #[error("sample {sample}: {channel} is {value}: expected a finite number")]
    NotFinite {
        /// Index of the sample, from 1.
        sample: usize,
        /// Channel of the value.
        channel: &'static str,
        /// The value.
        value: f64,
    },
    /// Channels have different lengths.
    #[error("{channel} has {found} samples: expected {expected}, as time")]
    LengthMismatch {
        /// Channel with another length than time.
        channel: &'static str,
        /// Number of its samples.
        found: usize,
        /// Number of time samples.
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
        /// Channel that rises throughout, as time would.
        likely: Option<&'static str>,
    },
    /// The averaging window has no length or begins before the trace.
    #[error("the window from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on")]
    Window {
        /// Beginning of the window.
        from_s: f64,
        /// End of the window.
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
        /// Sampling interval.
        pause_s: f64,
    },
    /// The window has too few samples for a mean with an error.
    #[error(
        "the window holds {found} samples, one every {} s: expected at least {expected}; if they were recorded faster, time \
         is in another unit than its title says, as `Time [s]`",
        short(*pause_s)
    )]
    TooFewSamples {
        /// Samples in the window.
        found: usize,
        /// Samples needed.
        expected: usize,
        /// Sampling interval.
        pause_s: f64,
    },
    /// Samples are missing inside the window.
    #[error("no samples from {from_s:.2} to {to_s:.2} s, inside the averaging window")]
    Gap {
        /// Last sample before the gap.
        from_s: f64,
        /// First sample after the gap.
        to_s: f64,
    },
    /// The load is lost in the window.
    #[error("the normal force falls to {force_n} N at {time_s:.2} s, of {median_n:.2} N: expected a sample under load")]
    NoLoad {
        /// Time of the first unloaded sample.
        time_s: f64,
        /// Normal force there.
        force_n: f64,
        /// Median normal force in the window.
        median_n: f64,
    },
    /// The load is far from the nominal one.
    #[error(
        "the normal force is {} N in the window: expected about {nominal_n} N, as the condition says{}", short(*found_n),
        likely.map_or_else(String::new, |likely| format!("; {likely}"))
    )]
    WrongLoad {
        /// Mean normal force in the window.
        found_n: f64,
        /// Nominal normal force.
        nominal_n: f64,
        /// Likely cause.
        likely: Option<LoadMistake>,
    },
    /// Friction changes its sign in the window.
    #[error(
        "friction changes its sign in the window ({opposite} of {samples} samples are against the mean): expected \
         sliding in one direction; of a sample that slides back and forth, `reciprocating = true` in [traces] or --reciprocating"
    )]
    WrongSign {
        /// Samples of the opposite sign.
        opposite: usize,
        /// Samples in the window.
        samples: usize,
    },
    /// The sensor is saturated.
    #[error("the {channel} stands at {value} in {samples} samples of the window: expected a sensor within its range")]
    Saturated {
        /// Saturated channel.
        channel: &'static str,
        /// Value, in the channel's SI unit.
        value: f64,
        /// Samples with exactly this value.
        samples: usize,
    },
    /// There is no friction.
    #[error(
        "friction is {mu:.6} in the window, as of a sample that does not slide: expected torque or friction force \
         while the sample slides, and its unit in the header"
    )]
    NoFriction {
        /// Mean friction coefficient in the window.
        mu: f64,
    },
    /// Friction changes as in a sample that is only loaded, or that has hardly traces_begun to slide.
    #[error(
        "friction changes by {:+.0} % of its mean over the window: the sample sticks or has not settled; expected \
         steady sliding, or a window_s that holds it", 100.0 * relative
    )]
    Unsettled {
        /// Change of mu over the window, relative to the mean.
        relative: f64,
    },
    /// The window holds too few strokes.
    #[error(
        "the window holds {found} strokes back and forth: expected at least {expected}, in a longer window; of a sample \
         that slides in one direction, no `reciprocating`"
    )]
    TooFewStrokes {
        /// Strokes in the window.
        found: usize,
        /// Strokes needed.
        expected: usize,
    },
    /// A stroke has too few samples.
    #[error(
        "the stroke from {at_s:.3} s on has {samples} samples in its middle: expected at least {expected}, recorded at \
         a higher rate or with a larger `stroke_share`"
    )]
    StrokeTooCoarse {
        /// Beginning of the stroke.
        at_s: f64,
        /// Samples in the middle of the stroke.
        samples: usize,
        /// Samples needed.
        expected: usize,
    },
    /// The fraction of a stroke is out of range.
    #[error("the part of a stroke is {value}: expected a number above 0 up to 1")]
    StrokeShare {
        /// The fraction given.
        value: f64,
    },
    /// The span for the zero of the sensors has no length or begins before the trace.
    #[error("the zero from {from_s} to {to_s} s has no meaning: expected two increasing times from 0 on in zero_s")]
    Zero {
        /// Beginning of the span.
        from_s: f64,
        /// End of the span.
        to_s: f64,
    },
    /// The span for the zero reaches into the averaging window.
    #[error("the zero ends at {to_s} s: expected a zero_s that ends before the window begins, at {window_from_s} s")]
    ZeroInWindow {
        /// End of the span.
        to_s: f64,
        /// Beginning of the window.
        window_from_s: f64,
    },
    /// The span for the zero has too few samples for a mean.
    #[error(
        "the zero from {from_s} to {to_s} s holds {found} samples, one every {} s: expected a zero_s with at least {expected} of them before \
         touchdown", short(*pause_s)
    )]
    ZeroTooShort {
        /// Beginning of the span.
        from_s: f64,
        /// End of the span.
        to_s: f64,
        /// Samples in the span.
        found: usize,
        /// Samples needed.
        expected: usize,
        /// Sampling interval.
        pause_s: f64,
    },
    /// The sample is loaded during the span for the zero.
    #[error(
        "the normal force is {force_n} N at {at_s:.2} s, within the zero from {from_s} to {to_s} s, of {median_n:.2} N in the window: expected \
         a zero_s before touchdown, while the head hangs free"
    )]
    ZeroUnderLoad {
        /// Beginning of the span.
        from_s: f64,
        /// End of the span.
        to_s: f64,
        /// Time of the first loaded sample.
        at_s: f64,
        /// Normal force there.
        force_n: f64,
        /// Median normal force in the window.
        median_n: f64,
    },
    /// A zero is requested, but only the instrument's coefficient was recorded.
    #[error(
        "the export has a friction coefficient and neither torque nor friction force, so no zero can be subtracted: expected one of \
         these with the normal force, or no zero_s"
    )]
    ZeroOfCoefficient,
    /// A zero is requested, but no load was recorded that shows touchdown.
    #[error(
        "no normal force is recorded, so that touchdown is not known and no zero can be subtracted: expected no zero_s"
    )]
    ZeroOfStatedLoad,
    /// Only a torque or friction force was recorded, and no force is stated.
    #[error("no normal force is recorded and none is stated: expected one of the two to divide the {channel} by")]
    NoStatedLoad {
        /// `torque` or `friction force`.
        channel: &'static str,
    },
    /// A torque was recorded, and the radius is missing or invalid.
    #[error(
        "the effective radius is {value_m} m: expected a positive length, torque / (normal force x radius) is friction"
    )]
    Radius {
        /// The radius given.
        value_m: f64,
    },
}

/// Rounds a number to three digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Warning about a trace that was accepted.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceFlag {
    /// Friction drifts through the window.
    Drift {
        /// Change of mu over the window, relative to the mean.
        relative: f64,
        /// Standard error of `relative`.
        stderr: f64,
    },
    /// Friction is recorded as negative; its sign was changed.
    FrictionTurned,
    /// The normal force is recorded as negative; its sign was changed.
    LoadTurned,
    /// The normal force departs from the nominal one.
    LoadOff {
        /// Mean force in the window, in newtons.
        found_n: f64,
        /// Nominal force, in newtons.
        nominal_n: f64,
        /// Likely cause.
        likely: Option<LoadMistake>,
    },
    /// Only the coefficient was recorded, and no normal force.
    LoadNotRecorded,
    /// Only a torque or friction force was recorded; it was divided by the stated normal force.
    LoadStated {
        /// Stated force on the whole sample holder, in newtons.
        nominal_n: f64,
    },
    /// The normal force is unsteady.
    LoadUnsteady {
        /// Standard deviation in the window over the mean.
        relative_std: f64,
    },
    /// Samples are missing, but so few that the mean hardly changes.
    Gap {
        /// Last sample before the longest gap.
        from_s: f64,
        /// First sample after it.
        to_s: f64,
        /// Number of gaps.
        count: usize,
    },
    /// Friction changes slowly before the window.
    RunIn {
        /// Amount and time of the change.
        run_in: RunIn,
        /// Whether a static peak precedes it.
        peak: bool,
    },
    /// The sensor was saturated before the window, so that no static peak is reported.
    PeakSaturated {
        /// Value, in the channel's SI unit.
        value: f64,
    },
    /// The static peak has few samples and may have been higher.
    PeakCoarse {
        /// Samples in the upper quarter of the peak.
        samples: usize,
        /// Amount that sampling may have missed.
        missed: f64,
    },
    /// The sensors do not read zero before touchdown.
    ZeroOff(SensorZero),
    /// The readings of the sensors before touchdown were subtracted.
    ZeroTaken(SensorZero),
    /// The recorded numbers are so coarse that few different values occur.
    Coarse {
        /// Number of different values in the window.
        levels: usize,
    },
    /// The two directions of strokes differ: the sensor has an offset, or the sample is tilted.
    StrokesDiffer {
        /// Mean of signed friction over both directions, which should be zero.
        offset: f64,
        /// `offset` over friction.
        relative: f64,
    },
    /// Strokes have unequal durations.
    StrokesUneven {
        /// Number of unusual strokes.
        count: usize,
        /// Number of strokes.
        of: usize,
        /// Median duration of a stroke, in seconds.
        usual_s: f64,
    },
    /// Friction is recorded with an equal sign in both directions.
    SignNotRecorded,
    /// A regular oscillation that falls as slowly as it rises, so that it is no stick-slip.
    Oscillation {
        /// Amplitude, peak to peak.
        amplitude: f64,
        /// Period.
        period_s: f64,
    },
    /// An oscillation with the shape of stick-slip, but with slips farther apart than elastic deformation allows; not
    /// counted as stick-slip.
    SlipTooLong {
        /// Median drop of mu.
        amplitude: f64,
        /// Period.
        period_s: f64,
        /// Travel of the drive in a period, in metres.
        travel_m: f64,
        /// Largest possible travel between slips, in metres.
        max_travel_m: f64,
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
            Self::SlipTooLong { amplitude, period_s, travel_m, max_travel_m } => write!(
                f,
                "friction falls by {amplitude:.4} every {period_s:.2} s, on a way of {:.1} mm: no stick-slip, between slips of which a drive goes \
                 {} mm at most, as far as arm and specimen yield",
                1e3 * travel_m,
                1e3 * max_travel_m
            ),
        }
    }
}
