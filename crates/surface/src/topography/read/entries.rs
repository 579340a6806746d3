//! Values of header entries: lengths, units, counts.

use super::comma::header_length;
use super::lines::{excerpt, number};
use super::scale::Scale;
use crate::topography::unit::unit_names;
use crate::topography::{LengthUnit, ReadError};

/// An entry of the header of a file in a format.
#[derive(Clone, Copy)]
pub(super) struct Entry<'a> {
    pub(super) format: &'static str,
    pub(super) name: &'static str,
    pub(super) text: &'a str,
}

impl<'a> Entry<'a> {
    pub(super) const fn new(format: &'static str, name: &'static str, text: &'a str) -> Self {
        Self { format, name, text }
    }

    pub(super) fn refused(self, expected: &'static str) -> ReadError {
        ReadError::Field { format: self.format, field: self.name, value: excerpt(self.text), expected }
    }

    /// The entry as a whole number above 0.
    pub(super) fn count(self) -> Result<u64, ReadError> {
        self.text.parse().ok().filter(|count| *count > 0).ok_or_else(|| self.refused("a whole number from 1 up"))
    }

    /// The entry as a number; refused unless `accepts` it.
    pub(super) fn number(self, accepts: fn(f64) -> bool, expected: &'static str) -> Result<f64, ReadError> {
        number(self.text).filter(|&number| accepts(number)).ok_or_else(|| self.refused(expected))
    }
}

/// Error for the entry `key` on line number `line` of a text, whose `value` is not what is `expected`.
pub(super) fn refused(line: usize, key: &'static str, value: &str, expected: &'static str) -> ReadError {
    ReadError::Header { line, key, value: excerpt(value), expected }
}

/// Parses a length with its unit, such as `1.5 mm`; returns it in metres.
pub(super) fn length(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    let expected = concat!("a positive length with its unit (", unit_names!(), "), for instance 1.5 mm");
    stated_length(value).map(|length| length.to_metres(1.0)).ok_or_else(|| refused(line, key, value, expected))
}

/// Parses a length with its unit; `None` unless `value` begins with a number.
pub(super) fn stated_length(value: &str) -> Option<Scale> {
    Scale::parse(value).filter(|_| value.trim().starts_with(|c: char| c.is_ascii_digit() || "+.".contains(c)))
}

/// Relative rounding error of a length: half a unit of its last digit, divided by the length.
pub(super) fn rounding(value: &str) -> f64 {
    let value = &header_length(value);
    let digits = value.split(|c: char| c.is_alphabetic() || c.is_whitespace()).next().unwrap_or_default();
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    // The cast saturates; no length has so many decimals.
    let unit = 0.1_f64.powi(i32::try_from(decimals).unwrap_or(i32::MAX));
    number(digits).map_or(0.0, |amount| 0.5 * unit / amount)
}

/// Parses a length given in nanometres; returns it in metres.
pub(super) fn nanometres(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    Ok(LengthUnit::Nanometre.to_metres(positive(line, key, value)?))
}

pub(super) fn positive(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    let expected = "a number of nanometres above 0";
    number(value).filter(|amount| *amount > 0.0).ok_or_else(|| refused(line, key, value, expected))
}

pub(super) fn whole(line: usize, key: &'static str, value: &str) -> Result<u64, ReadError> {
    let count = value.parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| refused(line, key, value, "a whole number from 1 up"))
}

pub(super) fn unit(line: usize, key: &'static str, value: &str) -> Result<Scale, ReadError> {
    Scale::parse(value).ok_or_else(|| refused(line, key, value, concat!("one of ", unit_names!())))
}
