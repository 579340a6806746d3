use slipgrid_monitor::Cancelled;

use crate::cavities::Crossing;
use crate::read::Foreign;

/// Why an altitude map, or an operation on one, was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A number outside its meaning; SI units.
    #[error("{quantity} is {}: expected {expected}", plain(*value))]
    OutOfRange {
        /// Which number.
        quantity: &'static str,
        /// The number given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// Heights that do not fill the grid.
    #[error("{found} heights for {rows} rows of {cols}: expected {rows} x {cols}")]
    WrongLength {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// Heights given.
        found: usize,
    },
    /// A grid without area.
    #[error("the map has {rows} rows and {cols} columns: expected at least 2 of each")]
    TooFewPoints {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// More points than fit in memory with what is computed from them.
    #[error("the map has {points:.3e} points: expected at most {most}")]
    TooManyPoints {
        /// Points asked for.
        points: f64,
        /// The limit.
        most: usize,
    },
    /// Every point of the map is missing.
    #[error("the map has no height: all {points} points are missing")]
    NoHeights {
        /// Points of the grid.
        points: usize,
    },
    /// The operation needs every height.
    #[error("{missing} of {points} heights are missing: fill them first")]
    MissingPoints {
        /// Missing points.
        missing: usize,
        /// Points of the grid.
        points: usize,
    },
    /// The points present do not determine the form to remove.
    #[error("the {points} heights present do not determine a {form}: expected more, spread over the map")]
    FormUndetermined {
        /// The form.
        form: &'static str,
        /// Points present.
        points: usize,
    },
    /// No cavities that could be measured.
    #[error("no cavities found: {reason}")]
    NoCavities {
        /// Why.
        reason: &'static str,
    },
    /// No mean period of cavities that are one.
    #[error("the cavities have no mean period: {0}")]
    Crossing(Crossing),
    /// No mean period of a pattern.
    #[error("the {whole} whole cavities have no mean period: {reason}")]
    NoPeriod {
        /// Cavities that the map's sides do not cut off.
        whole: usize,
        /// Why.
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

/// What [`ReadOptions`](crate::ReadOptions) can say of a file that does not say it itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapOption {
    /// Unit of the heights.
    HeightUnit,
    /// Unit of x and y.
    LateralUnit,
    /// Pixel size.
    Pixel,
}

/// Something that neither a file nor the caller says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotGiven {
    /// What is needed.
    pub what: &'static str,
    /// How to give it.
    pub expected: &'static str,
    /// The option that gives it.
    pub option: MapOption,
}

/// Everything that is `missing` at once: a file is read again for each refusal.
fn not_given(missing: &[NotGiven]) -> String {
    let whats: Vec<String> = missing.iter().map(|missing| format!("the {}", missing.what)).collect();
    let ways: Vec<&str> = missing.iter().map(|missing| missing.expected).collect();
    let verb = if missing.len() == 1 { "is" } else { "are" };
    format!("{} {verb} not known: expected {}", whats.join(" and "), ways.join("; and "))
}

/// Why a file was refused as an altitude map. Lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// The source failed.
    #[error("line {line}: reading failed: {reason}")]
    Source {
        /// The line that was being read.
        line: usize,
        /// What the source said.
        reason: String,
    },
    /// A line longer than any map's.
    #[error("line {line}: longer than {most_bytes} bytes: expected one row of a map a line")]
    LineTooLong {
        /// The line.
        line: usize,
        /// The limit.
        most_bytes: usize,
    },
    /// A field that is no number.
    #[error("line {line}, column {column}: \"{value}\": expected {expected}")]
    NotANumber {
        /// The line.
        line: usize,
        /// The field within the line, from 1.
        column: usize,
        /// The field's text, its beginning if it is long.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A row that differs from the others in length.
    #[error("line {line}: {found} values: expected {expected}")]
    RowLength {
        /// The line.
        line: usize,
        /// Values on it.
        found: usize,
        /// Values that it should have.
        expected: usize,
    },
    /// A table of one profile, not of a map.
    #[error(
        "{lines} lines of {columns} values are a profile, not a map: expected a matrix of heights, or points x y z"
    )]
    Profile {
        /// Lines of the table.
        lines: usize,
        /// Values of each.
        columns: usize,
    },
    /// A table with a column of coordinates that is no list of points x y z.
    #[error(
        "column {column} runs in equal steps, as coordinates do, which are no heights: expected a matrix of heights alone, or the three \
         columns x y z"
    )]
    Coordinates {
        /// The column, from 1.
        column: usize,
    },
    /// A header entry that cannot be understood.
    #[error("line {line}: {key} is \"{value}\": expected {expected}")]
    Header {
        /// The line.
        line: usize,
        /// The entry's key.
        key: &'static str,
        /// The entry's value.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// Neither the header nor the caller gave what is needed.
    #[error("{}", not_given(missing))]
    NotGiven {
        /// All of it.
        missing: Vec<NotGiven>,
    },
    /// A number with a decimal comma, in a file that does not say all that is needed either.
    #[error("line {line}, column {column}: \"{value}\": expected {expected}; then, too, {}", not_given(missing))]
    DecimalComma {
        /// The line.
        line: usize,
        /// The field within the line, from 1.
        column: usize,
        /// The field's text.
        value: String,
        /// What would be accepted.
        expected: &'static str,
        /// What is needed beside.
        missing: Vec<NotGiven>,
    },
    /// Sides and counts of a matrix whose pixels are oblong: rows are missing, mostly.
    #[error(
        "{rows} rows and {cols} columns on the header's height of {} um and width of {} um make pixels of {} x {} um, as of a file that \
         was cut short: expected all rows, or, where pixels are oblong, `# Rows: {rows}` in the header or the sides of a pixel by option",
        um(sides_m[1]), um(sides_m[0]), um(sides_m[1] / *cols as f64), um(sides_m[0] / *rows as f64)
    )]
    Oblong {
        /// The header's sides along y, across lines, and along x, in metres.
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
    /// A point off the regular grid that the others lie on.
    #[error("line {line}: {axis} = {} lies between grid lines {} apart: expected a regular grid", plain(*value), plain(*step))]
    OffGrid {
        /// The line.
        line: usize,
        /// `x` or `y`.
        axis: &'static str,
        /// The coordinate, in the text's unit.
        value: f64,
        /// Distance of the grid lines found, in the text's unit.
        step: f64,
    },
    /// All points share one coordinate.
    #[error("all points have {axis} = {}, as of a profile: expected a map, on a grid of at least 2 x 2", plain(*value))]
    OneLine {
        /// `x` or `y`.
        axis: &'static str,
        /// The coordinate, in the text's unit.
        value: f64,
    },
    /// Two points at one place.
    #[error("line {line}: x = {}, y = {} was given on line {earlier} already: expected one height per point", plain(*x), plain(*y))]
    Duplicate {
        /// The later line.
        line: usize,
        /// The earlier line.
        earlier: usize,
        /// Coordinate in the text's unit.
        x: f64,
        /// Coordinate in the text's unit.
        y: f64,
    },
    /// So few points that the grid found cannot be the one measured on.
    #[error(
        "{points} points on a grid of {} x {}: expected at least one point in {most_nodes_per_point} grid nodes",
        plain(rows.round()),
        plain(cols.round())
    )]
    Sparse {
        /// Points given.
        points: usize,
        /// Rows of the grid that holds them.
        rows: f64,
        /// Columns of the grid that holds them.
        cols: f64,
        /// The limit.
        most_nodes_per_point: usize,
    },
    /// A binary file of no format that is read.
    #[error(
        "the file begins with \"{beginning}\": expected text, .gsf, .npy, .sdf, .sur or .x3p (export one of these)"
    )]
    Unrecognized {
        /// The first bytes, escaped.
        beginning: String,
    },
    /// A file of an instrument that is not read.
    #[error("this is a {}, which is not read: export {}", .0.format, .0.export)]
    Foreign(Foreign),
    /// An entry of a binary file's header that cannot be understood.
    #[error("{format}: {field} is \"{value}\": expected {expected}")]
    Field {
        /// The format.
        format: &'static str,
        /// The entry.
        field: &'static str,
        /// Its value; empty where it is absent.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A header longer than any map's.
    #[error("{format}: the header is longer than {most_bytes} bytes")]
    HeaderTooLong {
        /// The format.
        format: &'static str,
        /// The limit.
        most_bytes: usize,
    },
    /// The file holds less or more than its header says.
    #[error("{format}: the {what} end after {found} of {expected}")]
    Ended {
        /// The format.
        format: &'static str,
        /// Which part.
        what: &'static str,
        /// How much the header says there is: bytes, or heights.
        expected: u64,
        /// How much there is.
        found: u64,
    },
    /// The file holds more than its header says.
    #[error("{format}: data go on behind the heights that the header announces: expected the file to end there")]
    GoesOn {
        /// The format.
        format: &'static str,
    },
    /// The source failed, or what it packs is damaged.
    #[error("{format}: cannot be read: {reason}")]
    Unreadable {
        /// The format.
        format: &'static str,
        /// What the source or the library that unpacks said.
        reason: String,
    },
    /// Packed data that unpack to far more than measured heights ever do.
    #[error(
        "{format}: what is packed in {packed} bytes unpacks to {unpacked} bytes: expected at most {most_expansion} times as many"
    )]
    Bomb {
        /// The format.
        format: &'static str,
        /// Bytes that it unpacks to.
        unpacked: u64,
        /// Bytes in the file.
        packed: u64,
        /// The limit.
        most_expansion: u64,
    },
    /// A crop beyond the map.
    #[error("the crop takes {axis} {first} to {}: the file has {available} {axis}, from 0", first.saturating_add(count.saturating_sub(1)))]
    CropOutside {
        /// `rows` or `columns`.
        axis: &'static str,
        /// First row or column asked for.
        first: usize,
        /// How many.
        count: usize,
        /// Rows or columns of the file.
        available: u64,
    },
    /// The numbers make no map.
    #[error(transparent)]
    Map(#[from] MapError),
}

impl ReadError {
    /// A refused decimal comma with what is `missing` beside; any other error as it is.
    pub(crate) fn with_missing(self, missing: Vec<NotGiven>) -> Self {
        match self {
            Self::NotANumber { line, column, value, expected } if value.contains(',') && !missing.is_empty() => {
                Self::DecimalComma { line, column, value, expected, missing }
            }
            other => other,
        }
    }
}

/// A number as people write it: with an exponent where it would take many digits.
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

/// `value` to so many digits.
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
