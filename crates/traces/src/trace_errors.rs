//! Reasons for refusing a trace, and warnings about an accepted one.

use std::fmt;

use slipgrid_base::units::significant;

use super::breaks::Break;
use super::zero::SensorZero;

/// Reason why a trace was refused. Times are seconds since the trace begins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// The trace ends before the averaging window does.
    #[error(
        "the trace ends at {end_s:.4} s, with a sample every {} s: expected one that covers the window up to {window_end_s} s, or \
         another window, window_s in [traces] or --window-s; if the trace was longer, time is in a larger unit than its title says, as \
         `Time [min]` where it says [s]", significant(*pause_s, 3)
    )]
    TooShort {
        /// Time of the last sample, in seconds since the trace begins.
        end_s: f64,
        /// End of the window, in seconds since the trace begins.
        window_end_s: f64,
        /// Sampling interval, in seconds.
        pause_s: f64,
    },
    /// The window has too few samples for a mean with a standard error.
    #[error(
        "the window holds {found} samples, one every {} s: expected at least {expected}; if they were recorded faster, time \
         is in a smaller unit than its title says, as `Time [ms]` where it says [s]",
        significant(*pause_s, 3)
    )]
    TooFewSamples {
        /// Number of samples in the window.
        found: usize,
        /// Minimum number of samples in the window.
        expected: usize,
        /// Sampling interval, in seconds.
        pause_s: f64,
    },
    /// Samples are missing inside the window.
    #[error("no samples from {from_s:.2} to {to_s:.2} s, inside the averaging window")]
    Gap {
        /// Time of the last sample before the gap, in seconds since the trace begins.
        from_s: f64,
        /// Time of the first sample after the gap, in seconds since the trace begins.
        to_s: f64,
    },
    /// Any other reason; the text says what was found and what was expected.
    #[error("{0}")]
    Refused(String),
}

/// Warning about a trace that was accepted. Times are seconds since the trace begins.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceFlag {
    /// No normal force was recorded; the friction coefficient is that of the instrument.
    LoadNotRecorded,
    /// The sensor was saturated before the window, so no static peak is taken.
    PeakSaturated {
        /// Value of the sensor, in the channel's SI unit.
        value: f64,
    },
    /// The sensors read an offset before touchdown.
    ZeroOff(SensorZero),
    /// The readings before touchdown were subtracted.
    ZeroTaken(SensorZero),
    /// Friction differs between strokes there and back, by a constant offset.
    StrokesDiffer {
        /// Offset of the friction coefficient: half of the sum of the signed friction in strokes there and back.
        offset: f64,
        /// The offset as a fraction of the mean friction.
        relative: f64,
    },
    /// Friction of strokes there and back has the same sign, so that the sign was not recorded.
    SignNotRecorded,
    /// A signal has a disturbed reading, or jumps, in the window.
    Broken {
        /// Name of the signal.
        signal: &'static str,
        /// Unit of the signal, after a space; empty for a coefficient.
        unit: &'static str,
        /// Time of the break, in seconds since the trace begins.
        time_s: f64,
        /// The break.
        found: Break,
    },
    /// Anything else; the text says what is odd.
    Odd(String),
}

impl fmt::Display for TraceFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LoadNotRecorded => {
                f.write_str("no normal force is recorded: it is not known that the nominal one acted")
            }
            Self::PeakSaturated { value } => {
                write!(f, "the sensor stood at {value} before the window: no static peak is taken")
            }
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
            Self::StrokesDiffer { offset, relative } => write!(
                f,
                "strokes there and back differ by an offset of {offset:+.4}, {:.0} % of friction: the width of the loop over the sum of both loads is taken",
                100.0 * relative.abs()
            ),
            Self::SignNotRecorded => f.write_str(
                "friction of strokes there and back is recorded alike: an offset of the sensor would not be seen",
            ),
            Self::Broken { signal, unit, time_s, found } => {
                let [before, after] = found.levels.map(|level| significant(level, 4));
                match found.disturbed {
                    Some(value) => write!(
                        f,
                        "{signal} is {}{unit} at {time_s:.2} s, beside {before}{unit}, which changes its mean by {}{unit}: a disturbed \
                         reading?",
                        significant(value, 4),
                        significant(found.shift, 2)
                    ),
                    None => write!(
                        f,
                        "{signal} jumps from {before}{unit} to {after}{unit} at {time_s:.2} s: its mean depends on when it is taken"
                    ),
                }
            }
            Self::Odd(text) => f.write_str(text),
        }
    }
}
