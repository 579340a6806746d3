//! Detects tables that look like a matrix of heights but are profiles, lists of coordinates, or matrices with axes.

use super::lines::{Delimiter, height, number};
use crate::topography::ReadError;

/// Largest number of columns of a table that is checked for coordinates; a map has more.
const MAX_LISTED_COLS: usize = 8;
/// Number of lines needed to recognise a list by its coordinates, and of values needed to recognise an axis by its
/// steps: a rough surface does not have so many equal steps.
const MIN_STEPS: usize = 8;
/// Relative difference up to which steps of rounded coordinates count as equal.
const SAME_STEP: f64 = 0.1;
/// Largest distance of a coordinate from equal steps, relative to the step.
const MAX_STEP_DEVIATION: f64 = 0.05;
/// Largest number of different steps of one coordinate: along a line, back to the next line, and one due to rounding.
const MAX_DISTINCT_STEPS: usize = 3;
/// If the second row rises by more than this fraction of the first row's rise, the map is a tilted plane and its first
/// row not an axis.
const MAX_SLOPE: f64 = 0.5;

/// Changes of a column from line to line.
#[derive(Clone, Debug, Default)]
struct Column {
    last: f64,
    rises: usize,
    falls: usize,
    different: Vec<f64>,
}

impl Column {
    fn push(&mut self, value: f64, is_first: bool) {
        let step = if is_first { 0.0 } else { value - self.last };
        self.last = value;
        self.rises += usize::from(step > 0.0);
        self.falls += usize::from(step < 0.0);
        let is_same = |known: &f64| (known - step).abs() <= SAME_STEP * known.abs().max(step.abs());
        if !is_first && self.different.len() <= MAX_DISTINCT_STEPS && !self.different.iter().any(is_same) {
            self.different.push(step);
        }
    }

    /// Whether the column rises at all of its `steps` steps, or falls at all of them.
    fn is_strict(&self, steps: usize) -> bool {
        self.rises == steps || self.falls == steps
    }

    /// Whether the column is a coordinate that runs along lines or from line to line.
    fn is_coordinate(&self, steps: usize) -> bool {
        let (most, least) = (self.rises.max(self.falls), self.rises.min(self.falls));
        let runs = most + least == steps && 4 * least <= most;
        let waits = most > 0 && least == 0;
        self.different.len() <= MAX_DISTINCT_STEPS && (runs || waits)
    }
}

/// Checks the first two columns of a narrow table for coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct CoordinateListCheck {
    lines: usize,
    cols: usize,
    columns: [Column; 2],
}

impl CoordinateListCheck {
    /// A check for a table of `cols` columns; `None` if it cannot be a list.
    pub(super) fn new(cols: usize) -> Option<Self> {
        (cols <= MAX_LISTED_COLS).then(|| Self { cols, ..Self::default() })
    }

    pub(super) fn push(&mut self, row: &[f64]) {
        for (column, &value) in self.columns.iter_mut().zip(row) {
            column.push(value, self.lines == 0);
        }
        self.lines += 1;
    }

    /// Refuses a profile or a list of coordinates.
    pub(super) fn check(&self) -> Result<(), ReadError> {
        let steps = self.lines.saturating_sub(1);
        if self.lines < MIN_STEPS {
            return Ok(());
        }
        if self.cols == 1 || self.cols == 2 && self.columns[0].is_strict(steps) {
            return Err(ReadError::Refused(format!(
                "{} lines of {} values are a profile, not a map: expected a matrix of heights, or points x y z",
                self.lines, self.cols
            )));
        }
        match (1..).zip(&self.columns).find(|(_, column)| column.is_coordinate(steps)) {
            Some((column, _)) => Err(ReadError::Refused(format!(
                "column {column} runs in equal steps, as coordinates do, which are no heights: expected a matrix of heights alone, or \
                 the three columns x y z"
            ))),
            None => Ok(()),
        }
    }
}

/// Steps of the axes above and to the left of a matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    /// Step along lines, and step from line to line, in the unit of the file.
    pub(super) steps: [f64; 2],
    delimiter: Delimiter,
}

/// Rows held back until it is decided whether the first row and the first column are axes.
#[derive(Debug, Default)]
pub(super) struct HeldRows {
    pub(super) rows: Vec<(String, usize)>,
}

impl HeldRows {
    /// Starts to hold rows if `first` may be an axis.
    pub(super) fn begin(first: &str) -> bool {
        let values = numbers(first);
        values.len() > MIN_STEPS && step(&values[1..]).is_some()
    }

    /// Whether enough rows are held to decide.
    pub(super) fn is_full(&self) -> bool {
        self.rows.len() > MIN_STEPS
    }

    /// The axes, if the rows have any.
    pub(super) fn axes(&self) -> Option<Axes> {
        let [(first, _), (second, _), ..] = &self.rows[..] else { return None };
        let delimiter = Delimiter::of(first);
        let above = numbers(first);
        let before: Vec<f64> =
            self.rows[1..].iter().map(|(row, _)| numbers(row).first().copied().unwrap_or(f64::NAN)).collect();
        let steps = [step(&above[1..])?, step(&before)?];
        let row = numbers(second);
        let rise = row.last()? - row.get(1)?;
        let is_plane = rise.abs() > MAX_SLOPE * (steps[0] * (above.len() - 2) as f64).abs();
        (!is_plane && row.len() == above.len()).then_some(Axes { steps, delimiter })
    }
}

impl Axes {
    /// `row` without its first field.
    pub(super) fn strip(self, row: &str) -> &str {
        match self.delimiter.mark() {
            Some(mark) => row.split_once(mark),
            None => row.trim_start().split_once(char::is_whitespace),
        }
        .map_or("", |(_, rest)| rest)
    }
}

/// The fields of a row, NaN for those that are not numbers.
fn numbers(row: &str) -> Vec<f64> {
    let value = |field| height(field).flatten().or_else(|| number(field)).unwrap_or(f64::NAN);
    Delimiter::of(row).fields(row).map(value).collect()
}

/// The step of `values`; `None` unless they are equally spaced and at least [`MIN_STEPS`] in number.
fn step(values: &[f64]) -> Option<f64> {
    let (first, last) = (*values.first()?, *values.last()?);
    let step = (last - first) / (values.len() - 1) as f64;
    let is_on = |(n, value): (usize, &f64)| (value - first - n as f64 * step).abs() <= MAX_STEP_DEVIATION * step.abs();
    let is_even = values.len() >= MIN_STEPS && step != 0.0 && values.iter().enumerate().all(is_on);
    is_even.then_some(step)
}

#[cfg(test)]
mod tests {
    use super::super::GIVEN;
    use crate::topography::{LengthUnit, ReadOptions, read_map};

    const MATRIX: ReadOptions = ReadOptions { lateral_unit: None, ..GIVEN };

    fn wave(i: usize, j: usize) -> f64 {
        ((7 * i + 3 * j) as f64).sin() + (i as f64 * 0.3).cos()
    }

    /// A table of 20 lines.
    fn table(line: impl Fn(usize) -> String) -> String {
        (0..20).map(|n| line(n) + "\n").collect()
    }

    #[test]
    fn profiles_and_lists_of_coordinates_are_refused_as_such() {
        let refused = |text: &str| read_map(text.as_bytes(), &MATRIX).unwrap_err().to_string();
        for text in [
            table(|n| format!("{:.3} {:.4}", 0.5 * n as f64, wave(n, 0))),
            table(|n| format!("{:.3};{:.4}", -0.01 * (n * n + n) as f64, wave(n, 0))),
            table(|n| format!("{:.4}", wave(n, 0))),
        ] {
            assert!(refused(&text).contains("profile"), "{}", refused(&text));
        }
        // Points with an index or an intensity, scanned in either order; several profiles over one coordinate.
        for (text, column) in [
            (table(|n| format!("{n} {} {} {:.4}", n % 5, n / 5, wave(n, 0))), 1),
            (
                table(|n| {
                    format!(
                        "{:.2},{:.2},{:.4},{}",
                        1.389 * (n % 5) as f64,
                        1.389 * (n / 5) as f64,
                        wave(n, 0),
                        7 * n % 13
                    )
                }),
                1,
            ),
            (table(|n| format!("{} {} {:.4} {:.4}", n / 5, n % 5, wave(n, 0), wave(n, 3))), 1),
            (table(|n| format!("{:.4} {:.1} {:.4} {:.4}", wave(n, 1), 0.1 * n as f64, wave(n, 0), wave(n, 3))), 2),
        ] {
            assert!(refused(&text).starts_with(&format!("column {column} runs in equal steps")), "{}", refused(&text));
        }
        // A narrow map stays a map.
        for text in [
            table(|n| format!("{:.4} {:.4}", wave(n, 0), wave(n, 1))),
            table(|n| format!("{} {} 0 1", n % 2, (n / 3) % 2)),
            table(|n| format!("{:.4} {:.4} {:.4} {:.4}", wave(n, 0), wave(n, 1), wave(n, 2), wave(n, 3))),
            "1 2 3 4\n".repeat(20),
        ] {
            assert!(read_map(text.as_bytes(), &MATRIX).is_ok(), "{text}");
        }
    }

    #[test]
    fn a_matrix_with_axes_is_read_without_them_and_says_so() {
        let heights = |i: usize| (0..12).map(|j| format!("{:.4}", wave(i, j))).collect::<Vec<_>>();
        let plain: String = (0..10).map(|i| heights(i).join(",") + "\n").collect();
        let expected = read_map(plain.as_bytes(), &MATRIX).unwrap().map;
        for (corner, mark, step) in [("0", "\t", 0.5), ("", ",", 1.389), ("NaN", " ", -2.0), ("0", ";", 1.0)] {
            let axis = (0..12).map(|j| format!("{:.2}", step * f64::from(j))).collect::<Vec<_>>();
            let rows = (0..10).map(|i| format!("{:.2}{mark}{}\n", 2.0 * i as f64, heights(i).join(mark)));
            let text = format!("{corner}{mark}{}\n{}", axis.join(mark), rows.collect::<String>());
            let read = read_map(text.as_bytes(), &MATRIX).unwrap();
            assert_eq!(read.map, expected, "{mark:?}");
            assert!(read.notes[0].starts_with("the first row and the first column are axes"), "{:?}", read.notes);
            // The axes give the pixel size if their unit is known.
            let um = Some(LengthUnit::Micrometre);
            let options = ReadOptions { height_unit: um, lateral_unit: um, ..ReadOptions::default() };
            let read = read_map(text.as_bytes(), &options).unwrap();
            assert!(
                (read.map.dx_m() / (1e-6 * f64::abs(step)) - 1.0).abs() < 1e-3
                    && (read.map.dy_m() - 2e-6).abs() < 1e-15
            );
            assert_eq!(read.notes.len(), 1, "{:?}", read.notes);
        }
        // A tilted plane has no axes, and few rows are not enough to decide.
        let plane: String =
            (0..12).map(|i| (0..12).map(|j| format!("{} ", 3 * i + 2 * j)).collect::<String>() + "\n").collect();
        for text in [plane.clone(), plane.lines().take(5).collect::<Vec<_>>().join("\n")] {
            let read = read_map(text.as_bytes(), &MATRIX).unwrap();
            assert_eq!((read.map.rows(), read.map.cols(), read.notes.len()), (12, text.lines().count(), 0));
        }
    }
}
