//! Parsing of table cells, as written by instruments and spreadsheets of different locales.

/// Separators that a table may use, in the order in which a header is searched for them.
pub const SEPARATORS: [char; 3] = ['\t', ';', ','];

/// Returns the separator of a table with this header line; `None` for a line without a separator.
pub fn separator(header: &str) -> Option<char> {
    SEPARATORS.into_iter().find(|&separator| header.contains(separator))
}

/// Splits a line into cells; separators within quotes do not split.
pub fn cut(line: &str, separator: char) -> Vec<&str> {
    let (mut cells, mut start, mut quoted) = (Vec::new(), 0, false);
    for (at, letter) in line.char_indices() {
        if letter == '"' {
            quoted = !quoted;
        } else if letter == separator && !quoted {
            cells.push(line[start..at].trim());
            start = at + letter.len_utf8();
        }
    }
    cells.push(line[start..].trim());
    cells
}

/// Removes the quotes around a cell.
pub fn unquoted(cell: &str) -> &str {
    cell.trim_matches('"').trim()
}

/// Parses the number in a cell; `None` if the cell is no finite number. A decimal comma is accepted if commas are not
/// the separator, or if the cell is quoted.
pub fn number_in(cell: &str, separator: char) -> Option<f64> {
    let bare = unquoted(cell);
    if let Ok(value) = bare.parse::<f64>() {
        // "inf" and "nan" parse as numbers, but are no measurements.
        return value.is_finite().then_some(value).filter(|_| bare.ends_with(|c: char| c.is_ascii_digit() || c == '.'));
    }
    let may_be_comma = separator != ',' || cell.starts_with('"');
    (may_be_comma && bare.matches(',').count() == 1 && !bare.contains('.'))
        .then(|| bare.replace(',', ".").parse::<f64>().ok())
        .flatten()
}

/// Describes for messages how many values a row with `found` values below `titles` titles should have.
pub fn expected_values(found: usize, titles: usize, separator: char) -> String {
    let is_cut = separator == ',' && found > titles;
    let commas = if is_cut { "; decimal commas need semicolons between the values" } else { "" };
    format!("{titles}, as the header line{commas}")
}

/// A number as written in the file, with its position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Line, from 1.
    pub line: u32,
    /// Index of the column, in the numbering of the caller.
    pub column: usize,
    /// The number, without quotes.
    pub number: String,
}

/// The first decimal comma and the first decimal point of a table. In a table with decimal commas a point may separate
/// thousands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DecimalSigns {
    comma: Option<Written>,
    point: Option<Written>,
}

impl DecimalSigns {
    /// Records a cell that holds a number, at `[line, column]`. As soon as the table has numbers with a decimal comma
    /// and with a point, returns the first number with a point and the reason why the number is ambiguous; otherwise
    /// `None`.
    pub fn take(&mut self, cell: &str, [line, column]: [u32; 2]) -> Option<(&Written, String)> {
        let bare = unquoted(cell);
        let first = if bare.contains(',') {
            &mut self.comma
        } else if bare.contains('.') {
            &mut self.point
        } else {
            return None;
        };
        first.get_or_insert_with(|| Written { line, column: column as usize, number: bare.to_owned() });
        let (point, comma) = self.point.as_ref().zip(self.comma.as_ref())?;
        let reason = format!(
            "has a point, which may part decimals or thousands: \"{}\" in line {} has a decimal comma",
            comma.number, comma.line
        );
        Some((point, reason))
    }

    /// Description of the accepted decimal signs for messages.
    pub const EXPECTED: &'static str = "one decimal sign in all numbers of the table, and no sign between thousands";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_beside_decimal_commas_is_named_whichever_comes_first() {
        for cells in [["0,248", "1.000"], ["1.000", "\"0,248\""]] {
            let mut signs = DecimalSigns::default();
            assert_eq!(signs.take("500", [2, 0]), None);
            assert_eq!(signs.take(cells[0], [2, 3]), None);
            assert_eq!(signs.take("7e3", [3, 1]), None);
            let (point, reason) = signs.take(cells[1], [4, 0]).unwrap();
            assert_eq!(point.number, "1.000");
            assert!(reason.contains("\"0,248\" in line") && reason.contains("thousands"), "{reason}");
        }
    }
}
