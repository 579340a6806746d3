use slipgrid_base::monitor::Cancelled;

use crate::topography::cavities::Crossing;
use crate::topography::read::Foreign;

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
        /// The form.
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
    /// The points present lie on one line.
    #[error("the {points} heights present lie on one line: expected points that span a plane")]
    PlaneUndetermined {
        /// Points present.
        points: usize,
    },
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
    /// Way to supply it.
    pub expected: &'static str,
    /// Option that supplies it.
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
    /// The source could not be read.
    #[error("line {line}: reading failed: {reason}")]
    Source {
        /// Line that was being read.
        line: usize,
        /// Error message of the source.
        reason: String,
    },
    /// A line longer than in any map.
    #[error("line {line}: longer than {most_bytes} bytes: expected one row of a map a line")]
    LineTooLong {
        /// Line number.
        line: usize,
        /// Longest line allowed.
        most_bytes: usize,
    },
    /// A field that is not a number.
    #[error("line {line}, column {column}: \"{value}\": expected {expected}")]
    NotANumber {
        /// Line number.
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
        /// Line number.
        line: usize,
        /// Values on the line.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A table of a single profile instead of a map.
    #[error(
        "{lines} lines of {columns} values are a profile, not a map: expected a matrix of heights, or points x y z"
    )]
    Profile {
        /// Lines of the table.
        lines: usize,
        /// Values on each line.
        columns: usize,
    },
    /// A table with a column of coordinates that is not a list of points x y z.
    #[error(
        "column {column} runs in equal steps, as coordinates do, which are no heights: expected a matrix of heights alone, or the three \
         columns x y z"
    )]
    Coordinates {
        /// The column, counted from 1.
        column: usize,
    },
    /// A header entry that cannot be understood.
    #[error("line {line}: {key} is \"{value}\": expected {expected}")]
    Header {
        /// Line number.
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
        /// Line number.
        line: usize,
        /// Position of the field in the line, counted from 1.
        column: usize,
        /// Text of the field.
        value: String,
        /// Text accepted.
        expected: &'static str,
        /// The other quantities missing.
        missing: Vec<NotGiven>,
    },
    /// A matrix whose sides and counts give elongated pixels, mostly because rows are missing.
    #[error(
        "{rows} rows and {cols} columns on the header's height of {} um and width of {} um make pixels of {} x {} um, as of a file that \
         was cut short: expected all rows, or, where pixels are oblong, `# Rows: {rows}` in the header or the sides of a pixel by option",
        um(sides_m[1]), um(sides_m[0]), um(sides_m[1] / *cols as f64), um(sides_m[0] / *rows as f64)
    )]
    Oblong {
        /// Sides given by the header, along y (across lines) and along x, in metres.
        sides_m: [f64; 2],
        /// Rows of the file.
        rows: usize,
        /// Columns of the file.
        cols: usize,
    },
    /// The text holds no data.
    #[error("no data after {lines} lines: expected rows of heights, or points x y z")]
    NoData {
        /// Lines read.
        lines: usize,
    },
    /// A point that lies off the regular grid of the other points.
    #[error("line {line}: {axis} = {} lies between grid lines {} apart: expected a regular grid", plain(*value), plain(*step))]
    OffGrid {
        /// Line number.
        line: usize,
        /// Axis, `x` or `y`.
        axis: &'static str,
        /// Coordinate in the file's unit.
        value: f64,
        /// Spacing of the grid lines found, in the file's unit.
        step: f64,
    },
    /// All points have the same coordinate on one axis.
    #[error("all points have {axis} = {}, as of a profile: expected a map, on a grid of at least 2 x 2", plain(*value))]
    OneLine {
        /// Axis, `x` or `y`.
        axis: &'static str,
        /// Coordinate in the file's unit.
        value: f64,
    },
    /// Two points at the same position.
    #[error("line {line}: x = {}, y = {} was given on line {earlier} already: expected one height per point", plain(*x), plain(*y))]
    Duplicate {
        /// Line of the later point.
        line: usize,
        /// Line of the earlier point.
        earlier: usize,
        /// Coordinate along x in the file's unit.
        x: f64,
        /// Coordinate along y in the file's unit.
        y: f64,
    },
    /// Too few points for the grid found from them, which is therefore not the measured grid.
    #[error(
        "{points} points on a grid of {} x {}: expected at least one point in {most_nodes_per_point} grid nodes",
        plain(rows.round()),
        plain(cols.round())
    )]
    Sparse {
        /// Number of points given.
        points: usize,
        /// Rows of the grid found.
        rows: f64,
        /// Columns of the grid found.
        cols: f64,
        /// Limit on the number of grid points.
        most_nodes_per_point: usize,
    },
    /// A binary file in an unsupported format.
    #[error(
        "the file begins with \"{beginning}\": expected text, .gsf, .npy, .sdf, .sur or .x3p (export one of these)"
    )]
    Unrecognized {
        /// The first bytes, escaped.
        beginning: String,
    },
    /// A file of an unsupported instrument format.
    #[error("this is a {}, which is not read: export {}", .0.format, .0.export)]
    Foreign(Foreign),
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
    /// A header longer than in any map.
    #[error("{format}: the header is longer than {most_bytes} bytes")]
    HeaderTooLong {
        /// Name of the format.
        format: &'static str,
        /// Longest header allowed.
        most_bytes: usize,
    },
    /// The file holds less or more data than its header says.
    #[error("{format}: the {what} end after {found} of {expected}")]
    Ended {
        /// Name of the format.
        format: &'static str,
        /// Part of the file.
        what: &'static str,
        /// Amount given by the header: bytes or heights.
        expected: u64,
        /// Amount found.
        found: u64,
    },
    /// The file holds more data than its header says.
    #[error("{format}: data go on behind the heights that the header announces: expected the file to end there")]
    GoesOn {
        /// Name of the format.
        format: &'static str,
    },
    /// The source could not be read, or its compressed data are damaged.
    #[error("{format}: cannot be read: {reason}")]
    Unreadable {
        /// Name of the format.
        format: &'static str,
        /// Error message of the source or of the decompression library.
        reason: String,
    },
    /// Compressed data that expand far more than measured heights do.
    #[error(
        "{format}: what is packed in {packed} bytes unpacks to {unpacked} bytes: expected at most {most_expansion} times as many"
    )]
    Bomb {
        /// Name of the format.
        format: &'static str,
        /// Bytes after decompression.
        unpacked: u64,
        /// Bytes in the file.
        packed: u64,
        /// Largest expansion allowed.
        most_expansion: u64,
    },
    /// A crop that reaches beyond the map.
    #[error("the crop takes {axis} {first} to {}: the file has {available} {axis}, from 0", first.saturating_add(count.saturating_sub(1)))]
    CropOutside {
        /// `rows` or `columns`.
        axis: &'static str,
        /// First row or column requested.
        first: usize,
        /// Number of rows or columns requested.
        count: usize,
        /// Rows or columns of the file.
        available: u64,
    },
    /// The heights and pixel sides do not make a valid map.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl ReadError {
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
fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-6..1e9).contains(&size) || !size.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A length in micrometres, to six digits.
fn um(length_m: f64) -> String {
    significant(length_m * 1e6, 6)
}

/// Formats `value` to the given number of digits.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    let written = format!("{value:.*e}", digits.saturating_sub(1));
    written.parse().map_or(written, plain)
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
