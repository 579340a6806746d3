//! Lines of a text that may be hostile: limited in length, in any encoding that instruments write.

use std::io::{BufRead, Read};

use crate::topography::map::{HEIGHT, MAX_HEIGHT_M};
use crate::topography::{MapError, ReadError};

/// Longest line, in bytes: fits a row of half a million heights of 30 characters.
const MAX_LINE_BYTES: usize = 1 << 24;

/// Reads a text line by line and counts the lines.
pub(crate) struct Lines<R> {
    source: R,
    line: usize,
    bytes: Vec<u8>,
    text: String,
}

impl<R: BufRead> Lines<R> {
    pub(crate) const fn new(source: R) -> Self {
        Self { source, line: 0, bytes: Vec::new(), text: String::new() }
    }

    /// Number of the line read last, counted from 1.
    pub(crate) const fn line(&self) -> usize {
        self.line
    }

    /// The next line, trimmed; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<&str>, ReadError> {
        Ok(self.read()?.map(str::trim))
    }

    /// The next line, trimmed except for tabs that may separate empty fields at its ends: tabs around tab-separated
    /// fields, around a single field, and those of a line of tabs only. `None` at the end.
    pub(crate) fn next_row(&mut self) -> Result<Option<&str>, ReadError> {
        let Some(text) = self.read()? else { return Ok(None) };
        let trimmed = text.trim();
        let may_part = trimmed.contains('\t') || !trimmed.contains(char::is_whitespace);
        if may_part && !trimmed.starts_with(['#', '%']) {
            return Ok(Some(text.trim_matches(|mark: char| mark.is_whitespace() && mark != '\t')));
        }
        Ok(Some(trimmed))
    }

    /// The next line unchanged, including its line end.
    fn read(&mut self) -> Result<Option<&str>, ReadError> {
        self.bytes.clear();
        self.line += 1;
        let mut bounded = (&mut self.source).take(MAX_LINE_BYTES as u64 + 1);
        let read = bounded.read_until(b'\n', &mut self.bytes).map_err(|error| ReadError::source(self.line, &error))?;
        if read == 0 {
            self.line -= 1;
            return Ok(None);
        }
        if read > MAX_LINE_BYTES {
            return Err(ReadError::Refused(format!(
                "line {}: longer than {MAX_LINE_BYTES} bytes: expected one row of a map a line",
                self.line
            )));
        }
        self.text.clear();
        match std::str::from_utf8(&self.bytes) {
            Ok(text) => self.text.push_str(text),
            // Not UTF-8, so Latin-1, in which instruments write the micro sign as the byte 0xB5.
            Err(_) => self.text.extend(self.bytes.iter().map(|&byte| char::from(byte))),
        }
        Ok(Some(if self.line == 1 { self.text.trim_start_matches('\u{feff}') } else { &self.text }))
    }
}

/// Delimiter between the fields of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Delimiter {
    Semicolon,
    Comma,
    Tab,
    Space,
}

impl Delimiter {
    /// The delimiter used in a line of data.
    pub(crate) fn of(line: &str) -> Self {
        if line.contains(';') {
            Self::Semicolon
        } else if line.contains(',')
            && !(line.contains('\t') && Self::Comma.fields(line).any(|field| field.contains('\t')))
        {
            // If fields between commas contain tabs, then tabs are the delimiters and the commas are decimal.
            Self::Comma
        } else if line.contains('\t') {
            Self::Tab
        } else {
            Self::Space
        }
    }

    /// The delimiter character; `None` for blanks.
    pub(crate) const fn mark(self) -> Option<char> {
        match self {
            Self::Semicolon => Some(';'),
            Self::Comma => Some(','),
            Self::Tab => Some('\t'),
            Self::Space => None,
        }
    }

    /// The part of `line` that holds its fields. Tabs at its ends delimit empty fields if tabs are the delimiters.
    pub(crate) fn row(self, line: &str) -> &str {
        if self == Self::Tab { line } else { line.trim() }
    }

    /// The fields of `line`, trimmed; a delimiter at the end of the line closes the last field.
    pub(crate) fn fields(self, line: &str) -> impl Iterator<Item = &str> {
        self.all_fields(self.mark().and_then(|mark| line.strip_suffix(mark)).unwrap_or(line))
    }

    /// The fields of `line`, trimmed; a delimiter at the end of the line is followed by an empty field.
    pub(crate) fn all_fields(self, line: &str) -> impl Iterator<Item = &str> {
        let mark = self.mark();
        // Some programs quote fields.
        let marked = mark.map(|mark| line.split(mark).map(|field| field.trim().trim_matches('"')));
        let spaced = mark.is_none().then(|| line.split_whitespace());
        marked.into_iter().flatten().chain(spaced.into_iter().flatten())
    }

    /// Whether `line` ends with a delimiter, either after its last field or before an empty one.
    pub(crate) fn ends(self, line: &str) -> bool {
        self.mark().is_some_and(|mark| line.ends_with(mark))
    }
}

/// Beginning of a field for a message, without control characters, with which a hostile file could control a terminal.
pub(crate) fn excerpt(field: &str) -> String {
    field.chars().take(40).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// Error for the `field` at `place`, counted from 0, on line number `line`, which is not what is `expected`.
pub(crate) fn not_a_number(line: usize, place: usize, field: &str, expected: &'static str) -> ReadError {
    ReadError::NotANumber { line, column: place + 1, value: excerpt(field), expected }
}

/// The height of greatest magnitude in a text, as written, for a message.
#[derive(Debug, Default)]
pub(super) struct Greatest {
    size: f64,
    line: usize,
    place: usize,
    field: String,
}

impl Greatest {
    /// Takes the height `value`, written as `field` at `place`, counted from 0, on line number `line`.
    pub(super) fn take(&mut self, value: f64, line: usize, place: usize, field: &str) {
        // In no unit are smaller heights refused.
        if value.abs() > self.size.max(MAX_HEIGHT_M) {
            *self = Self { size: value.abs(), line, place, field: field.to_owned() };
        }
    }

    /// Adds the place of the height to an error for a height that is too great; returns any other error unchanged.
    pub(super) fn named(&self, error: ReadError) -> ReadError {
        match error {
            ReadError::Map(MapError::OutOfRange { quantity: HEIGHT, expected, .. }) if self.line > 0 => {
                not_a_number(self.line, self.place, &self.field, expected)
            }
            other => other,
        }
    }
}

/// Whether `field` holds several numbers, which means that commas delimit fields and are decimal commas too.
fn is_several(field: &str) -> bool {
    field.split_whitespace().nth(1).is_some_and(|second| second.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
}

/// Expected text, for a message on a `field` that is not a height.
pub(crate) fn expected_height(field: &str) -> &'static str {
    if is_several(field) {
        "one height between two commas; for decimal commas decimal_comma = true in a file, or --decimal-comma"
    } else if field.contains(',') {
        "a height with a decimal point; for decimal commas decimal_comma = true in a file, or --decimal-comma"
    } else {
        "a height with a decimal point, or NaN, BAD, --- where it is missing"
    }
}

/// Expected text, for a message on a `field` that is not a coordinate.
pub(crate) fn expected_coordinate(field: &str) -> &'static str {
    if is_several(field) {
        "one coordinate between two commas; for decimal commas decimal_comma = true in a file, or --decimal-comma"
    } else if field.contains(',') {
        "a coordinate with a decimal point; for decimal commas decimal_comma = true in a file, or --decimal-comma"
    } else {
        "a coordinate: a number with a decimal point, such as 1.5"
    }
}

/// Parses a height: `Some(None)` if the field marks a missing point, `None` if it is neither a number nor such a mark.
pub(crate) fn height(field: &str) -> Option<Option<f64>> {
    // The last four are forms of NaN written by C programs on Windows.
    const MISSING: [&str; 11] =
        ["", "nan", "bad", "---", "***", "no data", "nodata", "-nan", "nan(ind)", "-nan(ind)", "-1.#ind"];
    if MISSING.iter().any(|name| name.eq_ignore_ascii_case(field)) {
        return Some(None);
    }
    number(field).map(Some)
}

/// Parses a finite number; `None` for any other text.
pub(crate) fn number(field: &str) -> Option<f64> {
    field.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_any_encoding_and_ending() {
        let mut lines = Lines::new(&b"\xEF\xBB\xBFa \xC2\xB5m\r\n\xB5m\n\nlast"[..]);
        assert_eq!(lines.next().unwrap(), Some("a \u{b5}m"));
        assert_eq!(lines.next().unwrap(), Some("\u{b5}m"));
        assert_eq!(lines.next().unwrap(), Some(""));
        assert_eq!(lines.next().unwrap(), Some("last"));
        assert_eq!(lines.next().unwrap(), None);
        assert_eq!(lines.line(), 4);
    }

    #[test]
    fn tabs_that_may_part_empty_fields_stay() {
        let text = "\t1\t2\t\r\n\t1 2\t\n 5\t\t\n\t\t \n\t# a\tb\t\n \n";
        let mut lines = Lines::new(text.as_bytes());
        let rows: Vec<String> = std::iter::from_fn(|| lines.next_row().unwrap().map(str::to_owned)).collect();
        assert_eq!(rows, ["\t1\t2\t", "1 2", "5\t\t", "\t\t", "# a\tb", ""]);
    }

    #[test]
    fn an_endless_line_is_refused_within_bounded_memory() {
        let endless = std::io::BufReader::new(std::io::repeat(b'1'));
        let refused = Lines::new(endless).next().unwrap_err();
        assert!(refused.to_string().starts_with("line 1: longer than"), "{refused}");
    }

    #[test]
    fn fields_of_every_delimiter() {
        for line in ["1 2  3", "1\t2\t3\t", "1, 2, 3", "1;2;3;"] {
            assert_eq!(Delimiter::of(line).fields(line).collect::<Vec<_>>(), ["1", "2", "3"], "{line}");
        }
        assert_eq!(Delimiter::Semicolon.fields("1;;3").collect::<Vec<_>>(), ["1", "", "3"]);
        assert_eq!(Delimiter::of("1,5;2,5"), Delimiter::Semicolon);
        assert_eq!(Delimiter::of("1,5\t2,5"), Delimiter::Tab);
        assert_eq!(Delimiter::of("1,\t2,\t3"), Delimiter::Comma);
        assert_eq!(Delimiter::Comma.fields("\"1\", \"2\"").collect::<Vec<_>>(), ["1", "2"]);
    }

    #[test]
    fn missing_points_and_numbers() {
        for name in ["NaN", "nan", "BAD", "---", "***", "No Data", "-nan(ind)", ""] {
            assert_eq!(height(name), Some(None), "{name}");
        }
        assert_eq!(height("-1.5e-3"), Some(Some(-1.5e-3)));
        for bad in ["1,5", "inf", "1e999", "x", "--", "1.2.3"] {
            assert_eq!(height(bad), None, "{bad}");
        }
    }
}
