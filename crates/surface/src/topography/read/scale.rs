//! Units of heights and of x and y as written in headers: `nm`, `Angstrom`, `10 nm`, `0.063 um per count`.

use std::fmt;

use super::comma::header_length;
use super::lines::number;
use crate::topography::LengthUnit;

/// A unit of length times a factor: the length that a value of 1 represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    factor: f64,
    unit: LengthUnit,
}

/// Names of further units than those of [`LengthUnit`], in lower case and separated by blanks, each with its factor and
/// unit.
const NAMES: [(&str, f64, LengthUnit); 8] = [
    ("angstrom angstroms å ångström ångstrom", 100.0, LengthUnit::Picometre),
    ("nanometer nanometers nanometre nanometres", 1.0, LengthUnit::Nanometre),
    ("micron microns micrometer micrometers micrometre micrometres mikrometer mum", 1.0, LengthUnit::Micrometre),
    ("millimeter millimeters millimetre millimetres", 1.0, LengthUnit::Millimetre),
    ("meter meters metre metres", 1.0, LengthUnit::Metre),
    ("inch inches in", 25.4, LengthUnit::Millimetre),
    ("mil mils thou", 25.4, LengthUnit::Micrometre),
    ("microinch uin", 25.4, LengthUnit::Nanometre),
];

/// Spellings of `um`, `mm` and `nm` with special characters: the Greek letter, units as single characters, and the
/// bytes of the Greek letter in Shift-JIS, GBK and EUC-KR, read as Latin-1.
const LETTERS: [(&str, &str); 9] = [
    ("\u{3bc}", "u"),
    ("\u{b5}", "u"),
    ("\u{339b}", "um"),
    ("\u{339c}", "mm"),
    ("\u{339a}", "nm"),
    ("\u{212b}", "å"),
    ("\u{83}\u{ca}", "u"),
    ("\u{a6}\u{cc}", "u"),
    ("\u{a5}\u{ec}", "u"),
];

/// Words that may follow `per` in a scale such as `um per count`; a length per time is not a scale.
const COUNTED: [&str; 12] =
    ["count", "counts", "bit", "lsb", "digit", "unit", "value", "pixel", "px", "point", "step", "line"];

impl Scale {
    /// `factor` times `unit`.
    pub(super) const fn new(factor: f64, unit: LengthUnit) -> Self {
        Self { factor, unit }
    }

    /// Converts `value` to metres.
    pub(super) fn to_metres(self, value: f64) -> f64 {
        self.unit.to_metres(self.factor * value)
    }

    /// This scale multiplied by `factor`.
    pub(super) fn times(self, factor: f64) -> Self {
        Self { factor: factor * self.factor, ..self }
    }

    /// Parses a scale: a unit, or a positive number and a unit, optionally per count or pixel; `None` for other texts.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let text = header_length(text.trim());
        let digits = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(text.len());
        let (amount, rest) = text.split_at(digits);
        let amount = if amount.is_empty() { 1.0 } else { number(amount).filter(|amount| *amount > 0.0)? };
        let rest = rest.replace('/', " per ");
        let mut words = rest.split_whitespace();
        let unit = Self::named(words.next()?)?;
        match (words.next(), words.next(), words.next()) {
            (None, ..) => {}
            (Some("per" | "pro" | "par"), Some(counted), None) if COUNTED.contains(&&counted.to_lowercase()[..]) => {}
            _ => return None,
        }
        Some(unit.times(amount))
    }

    /// The unit with the given name; `None` if it is not known.
    fn named(name: &str) -> Option<Self> {
        let name = LETTERS.iter().fold(name.trim().to_owned(), |name, (letters, plain)| name.replace(letters, plain));
        if let Ok(unit) = name.parse() {
            return Some(Self::new(1.0, unit));
        }
        let name = name.to_lowercase();
        let known = NAMES.iter().find(|(names, ..)| names.split(' ').any(|known| known == name));
        known.map(|&(_, factor, unit)| Self::new(factor, unit))
    }
}

impl From<LengthUnit> for Scale {
    fn from(unit: LengthUnit) -> Self {
        Self::new(1.0, unit)
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.factor == 1.0 { self.unit.fmt(f) } else { write!(f, "{} {}", self.factor, self.unit) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_read_as_headers_write_them() {
        for (text, metres) in [
            ("nm", 1e-9),
            ("\u{b5}m", 1e-6),
            ("\u{3bc}m", 1e-6),
            ("\u{339b}", 1e-6),
            ("\u{83}\u{ca}m", 1e-6),
            ("\u{a6}\u{cc}m", 1e-6),
            ("Angstrom", 1e-10),
            ("\u{c5}", 1e-10),
            ("micron", 1e-6),
            ("mil", 25.4e-6),
            ("10 nm", 1e-8),
            ("1.38900e-006 m", 1.389e-6),
            ("1,389 um", f64::NAN),
            ("1,3891 um", 1.3891e-6),
            ("0.063 um per count", 0.063e-6),
            ("0.5um/pixel", 0.5e-6),
        ] {
            match Scale::parse(text) {
                Some(scale) => assert!((scale.to_metres(1.0) / metres - 1.0).abs() < 1e-12, "{text}: {scale}"),
                None => assert!(metres.is_nan(), "{text}"),
            }
        }
        for text in ["", "3", "rad", "10 mm/s", "0 um", "-1 mm", "5 um wide", "nm nm", "counts"] {
            assert_eq!(Scale::parse(text), None, "{text}");
        }
        assert_eq!(
            [Scale::parse("um"), Scale::parse("10 nm")].map(|scale| scale.unwrap().to_string()),
            ["um", "10 nm"]
        );
    }
}
