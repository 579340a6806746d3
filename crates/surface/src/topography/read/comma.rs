//! Recognises decimal commas in text if no other reading is possible.
//!
//! A line of data has decimal commas if it is a row of numbers after replacing commas by points, and not without:
//! `0,5;1,5` and `0,5 1,5` are two numbers, `1,5,2` is three. Thousands separators look the same; a line in which every
//! comma stands before three digits, and after one to three digits that do not begin with zero, such as `1,234;5,678`,
//! is therefore not evidence of decimal commas.

use std::borrow::Cow;

use super::lines::{Delimiter, height, not_a_number};
use crate::topography::ReadError;

/// Decimal sign of a text, as far as known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DecimalSign {
    /// Commas, given by the caller.
    Given,
    /// Commas, recognised in a line of data.
    Found,
    /// Points, or commas between numbers, recognised in a line of data.
    Point,
    /// Unknown so far.
    Open,
}

/// Note on a map whose decimal commas were recognised.
pub(super) const FOUND: &str = "its numbers are written with decimal commas, and were read so";

impl DecimalSign {
    pub(super) const fn new(is_comma: bool) -> Self {
        if is_comma { Self::Given } else { Self::Open }
    }

    /// Returns `text`, on line number `line`, with decimal points; refuses decimal points once decimal commas were
    /// recognised.
    pub(super) fn with_points<'t>(&mut self, text: &'t str, line: usize) -> Result<Cow<'t, str>, ReadError> {
        match self {
            Self::Given => return Ok(text.replace(',', ".").into()),
            Self::Point => return Ok(text.into()),
            // Header lines contain ordinary commas in their text.
            _ if text.starts_with(['#', '%']) || !text.contains([',', '.']) => return Ok(text.into()),
            Self::Open if is_row(Delimiter::of(text), text) => *self = Self::Point,
            Self::Open if has_decimal_commas(text) => *self = Self::Found,
            _ => {}
        }
        if *self != Self::Found {
            return Ok(text.into());
        }
        let own = text.replace(',', ".");
        match text.split([';', '\t', ' ']).enumerate().find(|(_, field)| field.contains('.')) {
            Some((place, field)) => {
                let expected = "a decimal comma, as in the lines before, or decimal points everywhere";
                Err(not_a_number(line, place, field, expected))
            }
            None => Ok(own.into()),
        }
    }
}

/// Smallest number of values that show a comma within numbers to be decimal.
///
/// Columns of whole numbers beside each other hold the same heights: the chance that a value of unusual length stands in
/// a first column is a half, and that all of twenty do 1e-6.
const MIN_UNEQUAL: usize = 20;

/// Finds numbers with decimal commas in a table whose fields commas delimit, too: `112,3,98,7` are two numbers, but four
/// fields. Their decimals make every second column hold whole numbers without sign and with equally many digits, and
/// their whole parts make the columns before them hold others.
#[derive(Debug, Default)]
pub(super) struct SplitNumbers {
    /// Number of digits in every second column.
    digits: Option<usize>,
    /// Number of values of each pair of columns that show them to be parts of one number.
    unequal: Vec<usize>,
}

impl SplitNumbers {
    /// Takes a row of fields; returns whether the table may still hold split numbers.
    pub(super) fn push<'t>(&mut self, mut fields: impl Iterator<Item = &'t str>) -> bool {
        let is_whole = |field: &str| !field.is_empty() && field.bytes().all(|byte| byte.is_ascii_digit());
        let mut pair = 0;
        while let Some(whole) = fields.next() {
            let Some(decimals) = fields.next().filter(|decimals| is_whole(decimals)) else { return false };
            let digits = *self.digits.get_or_insert(decimals.len());
            if decimals.len() != digits || !is_whole(whole.strip_prefix('-').unwrap_or(whole)) {
                return false;
            }
            if self.unequal.len() == pair {
                self.unequal.push(0);
            }
            // No program writes zeros before a whole number.
            let has_zeros = digits > 1 && decimals.starts_with('0');
            self.unequal[pair] += usize::from(whole.len() != digits || has_zeros);
            pair += 1;
        }
        true
    }

    /// Refuses a table in which at least half of the pairs of columns have values that show split numbers.
    pub(super) fn check(&self) -> Result<(), ReadError> {
        let pairs = self.unequal.iter().filter(|count| **count > 0).count();
        if self.unequal.iter().sum::<usize>() < MIN_UNEQUAL || 2 * pairs < self.unequal.len() {
            return Ok(());
        }
        Err(ReadError::Refused(format!(
            "every second of the {} columns has whole numbers of length {}, as where commas both delimit numbers and are decimal \
             (\"112,3,98,7\"): expected decimal points, or semicolons, tabs or blanks between the numbers",
            2 * self.unequal.len(),
            self.digits.unwrap_or_default()
        )))
    }
}

/// Names what stands in `own` in an error on a field of `read`, which is `own` with decimal points for commas.
pub(super) fn as_written(error: ReadError, own: &str, read: &str) -> ReadError {
    match error {
        ReadError::NotANumber { line, column, value, expected } => {
            let written = read.find(&value).and_then(|at| own.get(at..at + value.len())).unwrap_or(&value);
            let expected = if written.matches(',').count() > 1 { ONE_COMMA } else { expected };
            ReadError::NotANumber { line, column, value: written.to_owned(), expected }
        }
        other => other,
    }
}

/// Expected text, for a message on a field with several commas.
const ONE_COMMA: &str = "one decimal comma in a number, and semicolons, tabs or blanks between numbers";

/// Whether `text` has at least two fields, all of which are heights or marks of missing points.
pub(super) fn is_row(delimiter: Delimiter, text: &str) -> bool {
    delimiter.fields(text).all(|field| height(field).is_some()) && delimiter.fields(text).nth(1).is_some()
}

/// Whether `text` is a row of numbers with decimal commas and nothing else.
fn has_decimal_commas(text: &str) -> bool {
    if text.contains('.') || is_row(Delimiter::Comma, text) {
        return false;
    }
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let own = text.replace(',', ".");
    let delimiter = [Delimiter::Semicolon, Delimiter::Tab].into_iter().find(|of| of.fields(text).nth(1).is_some());
    let delimiter = delimiter.unwrap_or(Delimiter::Space);
    let mut says = false;
    for (whole, decimals) in delimiter.fields(text).filter_map(|field| field.split_once(',')) {
        let whole = whole.trim_start_matches(['-', '+']);
        if !is_digits(whole) {
            return false;
        }
        let may_be_thousands =
            whole.len() <= 3 && !whole.starts_with('0') && decimals.len() == 3 && is_digits(decimals);
        says |= !may_be_thousands;
    }
    says && is_row(delimiter, &own)
}

/// Writes a header length such as `1,5 mm` with a decimal point. `1,500 mm` is ambiguous and stays unchanged.
pub(super) fn header_length(value: &str) -> Cow<'_, str> {
    match value.split_once(',') {
        Some((whole, rest)) if !rest.contains([',', '.']) => {
            let decimals = rest.bytes().take_while(u8::is_ascii_digit).count();
            let is_decimal = decimals > 0 && (decimals != 3 || whole.trim().starts_with('0'));
            if is_decimal { value.replace(',', ".").into() } else { value.into() }
        }
        _ => value.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::GIVEN;
    use super::*;
    use crate::topography::{ReadOptions, read_map};

    #[test]
    fn decimal_commas_are_told_where_nothing_else_is_meant() {
        for line in [
            "0,5;1,5",
            "0,5\t-1,5e-1",
            "0,5 1,5 2",
            "1;2;1,25",
            "0,123;0,456",
            "1,234;0,5",
            "NaN;1,5",
            "\"0,5\";\"1,5\"",
        ] {
            assert!(has_decimal_commas(line), "{line}");
        }
        for line in [
            "1,2,3",
            "1, 2, 3",
            "1,\t2,\t3",
            "0,5",
            "1,234;5,678",
            "1.5;2,5",
            "1,234.5;2",
            "a,5;b,5",
            "1;2;3",
            "1,2,3;4,5,6",
        ] {
            assert!(!has_decimal_commas(line), "{line}");
        }
    }

    #[test]
    fn a_map_with_decimal_commas_is_that_with_points() {
        let points = "0.5;0.25;1;2\n0;-1.5;0.125;2e-1\n1;1;1;3.25\n";
        // A matrix has no unit of x and y.
        let matrix = ReadOptions { lateral_unit: None, ..GIVEN };
        for mark in [";", "\t", " "] {
            let text = points.replace(';', mark);
            let plain = read_map(text.as_bytes(), &matrix).unwrap();
            let read = read_map(text.replace('.', ",").as_bytes(), &matrix).unwrap();
            assert_eq!(read.map, plain.map, "{mark:?}");
            assert!(plain.notes.is_empty() && read.notes == [FOUND], "{:?}", read.notes);
            let told = ReadOptions { decimal_comma: true, ..GIVEN };
            assert_eq!(read_map(text.replace('.', ",").as_bytes(), &told).unwrap().map, plain.map);
        }
        // Points x y z, and the sides in a header.
        let scan = "0;0;1,5\n0;0,5;2\n0,5;0;3\n0,5;0,5;1\n";
        assert_eq!(read_map(scan.as_bytes(), &GIVEN).unwrap().map.dx_m(), 0.5e-6);
        let sides = "# Width: 0,5 mm\n# Height: 1,5 mm\n# Value units: um\n1,5;2,5\n1,5;2,5\n1,5;2,5\n1,5;2,5\n1,5;2,5\n1,5;2,5\n";
        let map = read_map(sides.as_bytes(), &ReadOptions::default()).unwrap().map;
        assert!((map.dx_m() - 0.25e-3).abs() < 1e-12 && (map.dy_m() - 0.25e-3).abs() < 1e-12);
    }

    /// Rows of `cols` heights, a wave about `mean` with one of 7 periods per row, written by `write`.
    fn table(cols: usize, mean: f64, write: impl Fn(f64) -> String) -> String {
        let height = |i: usize, j: usize| mean + 20.0 * libm::sin((i * i + 3 * j) as f64);
        let row = |i: usize| (0..cols).map(|j| write(height(i, j))).collect::<Vec<_>>().join(",") + "\n";
        (0..24).map(row).collect()
    }

    #[test]
    fn decimal_commas_between_commas_are_refused_and_whole_numbers_are_not() {
        let read = |text: &str| read_map(text.as_bytes(), &ReadOptions { lateral_unit: None, ..GIVEN });
        let commas = |decimals: usize| move |height: f64| format!("{height:.decimals$}").replace('.', ",");
        for text in [
            table(8, 100.0, commas(1)),
            table(8, 300.0, commas(1)),
            table(8, 0.0, commas(1)),
            table(16, 50.0, commas(2)),
            table(9, 0.0, commas(3)),
        ] {
            let said = read(&text).unwrap_err().to_string();
            assert!(said.contains("every second of the") && said.contains("semicolons, tabs or blanks"), "{said}");
        }
        let whole = |height: f64| format!("{height:.0}");
        for mean in [0.0, 50.0, 100.0, 300.0, 1000.0] {
            assert_eq!(read(&table(8, mean, whole)).unwrap().map.rows(), 8, "{mean}");
        }
        // A first column of other numbers, and single values below the others.
        let text = table(8, 300.0, whole);
        let lines = (1..).zip(text.lines());
        let counted: String = lines.map(|(n, line)| format!("{n},{line},300\n")).collect();
        assert!(read(&counted).is_ok());
        assert!(read(&text.replacen("300", "7", 3)).is_ok());
    }

    #[test]
    fn a_field_of_several_commas_is_quoted_as_written() {
        let given = ReadOptions { decimal_comma: true, ..GIVEN };
        let said = read_map("-0,101,-0,079\n0,1,0,2\n".as_bytes(), &given).unwrap_err().to_string();
        assert!(said.starts_with("line 1, column 1: \"-0,101,-0,079\": expected one decimal comma"), "{said}");
    }

    #[test]
    fn what_may_be_marks_of_thousands_or_is_mixed_is_refused_with_the_key() {
        let refused = |text: &str| read_map(text.as_bytes(), &GIVEN).unwrap_err().to_string();
        let said = refused("1,234;5,678;1,111;2,222\n");
        assert!(said.contains("line 1, column 1: \"1,234\"") && said.contains("decimal_comma = true"), "{said}");
        let said = refused("0,5;1,5;1;2\n0,5;1.5;1;2\n");
        assert!(
            said.contains("line 2, column 2: \"1.5\"") && said.contains("decimal comma, as in the lines before"),
            "{said}"
        );
        let said = refused("0.5;1.5;1;2\n0,5;1,5;1;2\n");
        assert!(said.contains("line 2, column 1: \"0,5\"") && said.contains("decimal_comma = true"), "{said}");
    }
}
