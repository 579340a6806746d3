//! Cells of tables as instruments and spreadsheets of any country write them.

/// Separators that a table may use; the first that occurs in its header.
pub const SEPARATORS: [char; 3] = ['\t', ';', ','];

/// The separator of a table with this header.
#[must_use]
pub fn separator(header: &str) -> Option<char> {
    SEPARATORS.into_iter().find(|&separator| header.contains(separator))
}

/// The cells of a line; separators in quotes do not cut.
#[must_use]
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

/// A cell without quotes.
#[must_use]
pub fn unquoted(cell: &str) -> &str {
    cell.trim_matches('"').trim()
}

/// The number in a cell, with a decimal point, or a decimal comma where commas do not separate or the cell is quoted.
#[must_use]
pub fn number_in(cell: &str, separator: char) -> Option<f64> {
    let bare = unquoted(cell);
    if let Ok(value) = bare.parse::<f64>() {
        // "inf" and "nan" are words, not measurements.
        return value.is_finite().then_some(value).filter(|_| bare.ends_with(|c: char| c.is_ascii_digit() || c == '.'));
    }
    let may_be_comma = separator != ',' || cell.starts_with('"');
    (may_be_comma && bare.matches(',').count() == 1 && !bare.contains('.'))
        .then(|| bare.replace(',', ".").parse::<f64>().ok())
        .flatten()
}
