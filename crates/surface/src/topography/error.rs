use slipgrid_base::monitor::Cancelled;

use crate::topography::cavities::Crossing;

/// Reason for refusing an altitude map or an operation on one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A number outside its valid range, in SI units.
    #[error("{quantity} is {}: expected {expected}", plain(*value))]
    OutOfRange {
        /// Name of the quantity.
        quantity: &'static str,
        /// Value given.
        value: f64,
        /// Values accepted.
        expected: &'static str,
    },
    /// The number of heights differs from that of the grid's points.
    #[error("{found} heights for {rows} rows of {cols}: expected {rows} x {cols}")]
    WrongLength {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// Heights given.
        found: usize,
    },
    /// A grid with fewer than two rows or columns.
    #[error("the map has {rows} rows and {cols} columns: expected at least 2 of each")]
    TooFewPoints {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// More points than fit in memory together with what is computed from them.
    #[error("the map has {points:.3e} points: expected at most {most}")]
    TooManyPoints {
        /// Number of points requested.
        points: f64,
        /// Largest number allowed.
        most: usize,
    },
    /// Every point of the map is missing.
    #[error("the map has no height: all {points} points are missing")]
    NoHeights {
        /// Points of the grid.
        points: usize,
    },
    /// The operation needs all heights, and some are missing.
    #[error("{missing} of {points} heights are missing: fill them first")]
    MissingPoints {
        /// Missing points.
        missing: usize,
        /// Points of the grid.
        points: usize,
    },
    /// The points present do not determine the form to be removed.
    #[error("the {points} heights present do not determine a {form}: expected more, spread over the map")]
    FormUndetermined {
        /// Name of the form.
        form: &'static str,
        /// Points present.
        points: usize,
    },
    /// No measurable cavity was found.
    #[error("no cavities found: {reason}")]
    NoCavities {
        /// Reason.
        reason: &'static str,
    },
    /// The cavities merge, so there is no mean period.
    #[error("the cavities have no mean period: {0}")]
    Crossing(Crossing),
    /// The mean period of a pattern cannot be computed.
    #[error("the {whole} whole cavities have no mean period: {reason}")]
    NoPeriod {
        /// Number of cavities not cut by the map's sides.
        whole: usize,
        /// Reason.
        reason: &'static str,
    },
    /// The monitor has cancelled the operation.
    #[error("the work on the map was cancelled")]
    Cancelled,
}

impl From<Cancelled> for MapError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// A quantity that [`ReadOptions`](crate::topography::ReadOptions) can supply for a file that lacks it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapOption {
    /// Unit of the heights.
    HeightUnit,
    /// Unit of x and y.
    LateralUnit,
    /// Pixel size.
    Pixel,
}

/// A quantity given neither by the file nor by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotGiven {
    /// Name of the quantity.
    pub what: &'static str,
    /// Way to supply the quantity.
    pub expected: &'static str,
    /// Option that supplies the quantity.
    pub option: MapOption,
}

/// Lists all `missing` quantities at once, because the user must read the file again after each refusal.
fn not_given(missing: &[NotGiven]) -> String {
    let whats: Vec<String> = missing.iter().map(|missing| format!("the {}", missing.what)).collect();
    let ways: Vec<&str> = missing.iter().map(|missing| missing.expected).collect();
    let verb = if missing.len() == 1 { "is" } else { "are" };
    format!("{} {verb} not known: expected {}", whats.join(" and "), ways.join("; and "))
}

/// Reason for refusing a file as an altitude map. Lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// A field that is not a number.
    #[error("line {line}, column {column}: \"{value}\": expected {expected}")]
    NotANumber {
        /// Line number, counted from 1.
        line: usize,
        /// Position of the field in the line, counted from 1.
        column: usize,
        /// Text of the field, truncated if long.
        value: String,
        /// Text accepted.
        expected: &'static str,
    },
    /// A row whose length differs from that of the others.
    #[error("line {line}: {found} values: expected {expected}")]
    RowLength {
        /// Line number, counted from 1.
        line: usize,
        /// Values on the line.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A header entry that cannot be understood.
    #[error("line {line}: {key} is \"{value}\": expected {expected}")]
    Header {
        /// Line number, counted from 1.
        line: usize,
        /// The entry's key.
        key: &'static str,
        /// The entry's value.
        value: String,
        /// Values accepted.
        expected: &'static str,
    },
    /// Needed quantities given neither by the header nor by the caller.
    #[error("{}", not_given(missing))]
    NotGiven {
        /// The missing quantities.
        missing: Vec<NotGiven>,
    },
    /// A number with a decimal comma, in a file that also lacks needed quantities.
    #[error("line {line}, column {column}: \"{value}\": expected {expected}; then, too, {}", not_given(missing))]
    DecimalComma {
        /// Line number, counted from 1.
        line: usize,
        /// Position of the field in the line, counted from 1.
        column: usize,
        /// Text of the field.
        value: String,
        /// Text accepted.
        expected: &'static str,
        /// Needed quantities that the file lacks.
        missing: Vec<NotGiven>,
    },
    /// A matrix whose sides and counts give elongated pixels, mostly because rows are missing.
    #[error(
        "{rows} rows and {cols} columns on the header's height of {} um and width of {} um make pixels of {} x {} um, as of {}, or, \
         where pixels are oblong, `# Rows: {rows}` in the header or the sides of a pixel by option",
        um(sides_m[0]), um(sides_m[1]), um(sides_m[1] / *cols as f64), um(sides_m[0] / *rows as f64),
        cut(sides_m[0] / *rows as f64 > sides_m[1] / *cols as f64)
    )]
    Oblong {
        /// Sides given by the header, along y (across lines) and along x, in metres.
        sides_m: [f64; 2],
        /// Rows of the file.
        rows: usize,
        /// Columns of the file.
        cols: usize,
    },
    /// An entry of a binary header that cannot be understood.
    #[error("{format}: {field} is \"{value}\": expected {expected}")]
    Field {
        /// Name of the format.
        format: &'static str,
        /// Name of the entry.
        field: &'static str,
        /// Value of the entry; empty if absent.
        value: String,
        /// Values accepted.
        expected: &'static str,
    },
    /// The file holds less or more data than its header says.
    #[error("{format}: the {what} end after {found} of {expected}")]
    Ended {
        /// Name of the format.
        format: &'static str,
        /// Part of the file.
        what: &'static str,
        /// Number of bytes or heights given by the header.
        expected: u64,
        /// Number of bytes or heights found.
        found: u64,
    },
    /// Any other reason; the text says where it was found and what was expected.
    #[error("{0}")]
    Refused(String),
    /// The heights and pixel sides do not make a valid map.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl ReadError {
    /// Error for a source that could not be read at `line`.
    pub(crate) fn source(line: usize, error: &std::io::Error) -> Self {
        Self::Refused(format!("line {line}: reading failed: {error}"))
    }

    /// Adds the quantities `missing` from the file to a refused decimal comma; returns any other error unchanged.
    pub(crate) fn with_missing(self, missing: Vec<NotGiven>) -> Self {
        match self {
            Self::NotANumber { line, column, value, expected } if value.contains(',') && !missing.is_empty() => {
                Self::DecimalComma { line, column, value, expected, missing }
            }
            other => other,
        }
    }
}

/// Formats a number with an exponent where plain notation would take many digits.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-6..1e9).contains(&size) || !size.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Cause of oblong pixels, and what would be accepted in its place.
const fn cut(is_short_of_rows: bool) -> &'static str {
    if is_short_of_rows {
        "a file that was cut short: expected all rows"
    } else {
        "lines that were cut short, or of a width that is not theirs: expected all columns"
    }
}

/// Formats a length given in metres in micrometres, to six significant digits.
fn um(length_m: f64) -> String {
    significant(length_m * 1e6, 6)
}

/// Formats `value` to the given number of significant digits.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    plain(slipgrid_base::units::significant(value, digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_takes_a_line_of_digits() {
        for (value, text) in [(1e300, "1e300"), (-2.5e-9, "-2.5e-9"), (0.25, "0.25"), (0.0, "0"), (1.5e6, "1500000")] {
            assert_eq!(plain(value), text);
        }
    }
}
