//! One trace of an export: samples in SI units.

use crate::columns::Channel;
use crate::missing_numbers::{Longest, Missing, MissingRows};
use crate::time_series::median;
use crate::{Tangential, TraceChannels};

/// One recorded repeat of a test: a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Number of the repeat in the file, from 1.
    pub number: usize,
    /// Time, friction and normal force.
    pub channels: TraceChannels,
    /// Line of every sample in the file, from 1.
    pub lines: Vec<u32>,
    /// Friction coefficient computed by the instrument at every sample, next to a torque or friction force; NaN where
    /// it is missing, empty without such a column.
    pub coefficient: Vec<f64>,
    /// Mean absolute value of the sliding speed, in m/s, from the speed column or from the revolutions column; `None`
    /// without either.
    pub speed_m_s: Option<f64>,
    /// Mean recorded relative humidity, 0 to 1; `None` without a humidity column.
    pub humidity: Option<f64>,
    /// Recorded position at every sample, in metres; NaN where it is missing, empty without such a column with a unit.
    pub position_m: Vec<f64>,
    /// Rows that were skipped because a needed number is missing; `None` if no row was.
    pub missing: Option<Missing>,
    /// Number of rows that were skipped because they equal the row before.
    pub repeated_rows: usize,
    /// Line at which the clock restarts, if only this restart separates the trace from the one before; otherwise
    /// `None`.
    pub clock_restarts_in_line: Option<u32>,
}

impl Recorded {
    /// Line, from 1, of the sample at `time_s`, in seconds since the trace begins; `None` if there is no such sample.
    pub fn line_at(&self, time_s: f64) -> Option<u32> {
        let sample = self.channels.time_s.iter().position(|t| t - self.channels.start_s == time_s)?;
        self.lines.get(sample).copied()
    }

    /// Median absolute value of the friction coefficient computed by the instrument, from `from_s` to `to_s`, in
    /// seconds since the trace begins; `None` without such values.
    pub fn usual_coefficient(&self, [from_s, to_s]: [f64; 2]) -> Option<f64> {
        let times = self.channels.time_s.iter().map(|t| t - self.channels.start_s);
        let inside = times.zip(&self.coefficient).filter(|(t, mu)| *t >= from_s && *t <= to_s && mu.is_finite());
        let amounts: Vec<f64> = inside.map(|(_, mu)| mu.abs()).collect();
        (!amounts.is_empty()).then(|| median(amounts))
    }
}

/// Values of a row by channel, in SI units; `None` where a number is missing.
#[derive(Clone, Default, PartialEq)]
pub(crate) struct Row([Option<f64>; Channel::COUNT]);

impl Row {
    pub(crate) fn get(&self, channel: Channel) -> Option<f64> {
        self.0[channel as usize]
    }

    pub(crate) fn set(&mut self, channel: Channel, value: f64) {
        self.0[channel as usize] = Some(value).filter(|value| !value.is_nan());
    }
}

/// Samples of a repeat while it is read.
#[derive(Default)]
pub(crate) struct Table {
    /// Numbers of each channel, in SI units: absolute values of speeds, and NaN where a coefficient or a position is
    /// missing.
    values: [Vec<f64>; Channel::COUNT],
    /// Line of every sample in the file, from 1.
    lines: Vec<u32>,
    /// Time of the first row on the clock of the file, in seconds, even if the row lacks other numbers; `None` before
    /// any row with a time.
    start_s: Option<f64>,
    missing: MissingRows,
    repeated: usize,
    last: Option<Row>,
    has_rows: bool,
    clock_restarts_in_line: Option<u32>,
}

impl Table {
    /// Creates an empty table. `clock_restarts_in_line` is the line of the table's first row if the table begins
    /// because the clock restarts, otherwise `None`.
    pub(crate) fn restarted_by_clock(clock_restarts_in_line: Option<u32>) -> Self {
        Self { clock_restarts_in_line, ..Self::default() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.values[Channel::Time as usize].is_empty()
    }

    /// Whether any row was added, with or without missing numbers.
    pub(crate) const fn has_rows(&self) -> bool {
        self.has_rows
    }

    /// The longest sequence of rows that lack a needed number; `None` if there is none.
    pub(crate) fn longest_missing(self) -> Option<Longest> {
        self.missing.longest()
    }

    /// Adds the row in line `number`; `without` are the needed columns in which the row has no number. A row without a
    /// time or with columns in `without` is counted as missing instead.
    pub(crate) fn push<'a>(&mut self, number: u32, row: &Row, without: impl Iterator<Item = &'a str>) {
        let mut without = without.peekable();
        self.has_rows = true;
        self.start_s = self.start_s.or(row.get(Channel::Time));
        match row.get(Channel::Time) {
            Some(_) if without.peek().is_none() => {}
            time_s => return self.missing.add(number, time_s, without),
        }
        self.missing.end();
        if self.last.as_ref() == Some(row) {
            self.repeated += 1;
            return;
        }
        self.last = Some(row.clone());
        self.lines.push(number);
        for channel in Channel::ALL {
            let value = row.get(channel);
            self.values[channel as usize].extend(match channel {
                Channel::Speed | Channel::Revolutions => value.map(f64::abs),
                Channel::Coefficient | Channel::Position => value.or(Some(f64::NAN)),
                // These numbers divide the rows and hold no signal.
                Channel::Repeat | Channel::Step => None,
                _ => value,
            });
        }
    }

    /// Converts the table into a trace with this `number` in the file; `radius_m` converts rotational speed to sliding
    /// speed.
    pub(crate) fn recorded(mut self, number: usize, radius_m: f64) -> Recorded {
        let mut of = |channel: Channel| std::mem::take(&mut self.values[channel as usize]);
        let mean = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            mean.is_finite().then_some(mean)
        };
        let where_recorded =
            |values: Vec<f64>| if values.iter().any(|value| value.is_finite()) { values } else { Vec::new() };
        let start_s = self.start_s.unwrap_or(0.0);
        // v = 2 pi n r_eff
        let turning = mean(&of(Channel::Revolutions)).map(|turns| std::f64::consts::TAU * turns * radius_m);
        let [torque_nm, friction_n, coefficient] =
            [Channel::Torque, Channel::FrictionForce, Channel::Coefficient].map(&mut of);
        let (tangential, coefficient) = if !torque_nm.is_empty() {
            (Tangential::TorqueNm(torque_nm), coefficient)
        } else if !friction_n.is_empty() {
            (Tangential::ForceN(friction_n), coefficient)
        } else {
            (Tangential::Coefficient(coefficient), Vec::new())
        };
        let (time_s, normal_force_n) = (of(Channel::Time), of(Channel::NormalForce));
        Recorded {
            number,
            lines: self.lines,
            coefficient: where_recorded(coefficient),
            speed_m_s: mean(&of(Channel::Speed)).or(turning).filter(|speed| speed.is_finite()),
            humidity: mean(&of(Channel::Humidity)),
            position_m: where_recorded(of(Channel::Position)),
            missing: self.missing.found(start_s, time_s.len() + self.repeated),
            repeated_rows: self.repeated,
            clock_restarts_in_line: self.clock_restarts_in_line,
            channels: TraceChannels { tangential, time_s, start_s, normal_force_n },
        }
    }
}
