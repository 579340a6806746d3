//! Rows of an export without a number in a needed column, and whether they explain why a trace was refused.

use crate::TraceError;

/// Consecutive rows without a number in a needed column, the longest such sequence of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Longest {
    /// Number of rows.
    pub rows: usize,
    /// Titles of the columns in which numbers are missing.
    pub columns: Vec<String>,
    /// First and last line, from 1.
    pub lines: [u32; 2],
    /// First and last known time of the rows, in seconds; `None` if no row has a time.
    pub time_s: Option<[f64; 2]>,
}

/// Rows of a repeat that were skipped because of missing numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Number of rows without a number in a needed column.
    pub rows: usize,
    /// Number of all rows of the repeat.
    pub of: usize,
    /// The longest run of rows with missing numbers; times are seconds since the trace begins.
    pub longest: Longest,
}

impl Missing {
    /// Describes the missing numbers; with `of_column`, also the columns in which they are missing.
    pub fn words(&self, of_column: bool) -> String {
        let Longest { rows, columns, lines: [first, last], time_s } = &self.longest;
        let columns = if of_column { format!(" in {}", columns.join(", ")) } else { String::new() };
        let all = if *rows == self.rows { String::new() } else { format!(", {rows} of them one behind another") };
        let times = time_s.map_or_else(String::new, |[from_s, to_s]| format!(" from {from_s:.2} to {to_s:.2} s"));
        let lines = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
        let (count, are) = (self.rows, if self.rows == 1 { "has" } else { "have" });
        format!("{count} of {} rows {are} no number{columns}{all}{times} ({lines})", self.of)
    }

    /// Returns the explanation that missing rows caused the refusal of a trace with `error`, and a description of
    /// accepted traces. `None` if the rows do not explain the error. The window is given in seconds.
    pub fn explains(&self, error: &TraceError, [from_s, to_s]: [f64; 2]) -> Option<[String; 2]> {
        let reaches =
            |from: f64, to: f64| self.longest.time_s.is_none_or(|time_s| time_s[0] <= to && time_s[1] >= from);
        let left = match error {
            TraceError::TooShort { end_s, window_end_s, pause_s } => (self.longest.time_s?[1] + pause_s
                >= *window_end_s)
                .then(|| format!("the last number is at {end_s:.2} s")),
            TraceError::TooFewSamples { found, expected, .. } => {
                (found + self.rows >= *expected).then(|| format!("{found} of the {expected} samples needed are left"))
            }
            TraceError::Gap { from_s, to_s } => reaches(*from_s, *to_s).then(|| "the mean would miss them".to_owned()),
            _ => None,
        }?;
        let reason = format!("{}, and friction is averaged from {from_s} to {to_s} s: {left}", self.words(false));
        Some([reason, "numbers nearly everywhere in the window, or a window_s where there are".to_owned()])
    }
}

/// Collects rows with missing numbers.
#[derive(Default)]
pub(crate) struct MissingRows {
    rows: usize,
    longest: Option<Longest>,
    current: Option<Longest>,
}

impl MissingRows {
    /// Adds the row in line `number`; `without` are the needed columns in which the row has no number.
    pub(crate) fn add<'a>(&mut self, number: u32, time_s: Option<f64>, without: impl Iterator<Item = &'a str>) {
        self.rows += 1;
        let current = self.current.get_or_insert_with(|| Longest {
            rows: 0,
            columns: Vec::new(),
            lines: [number; 2],
            time_s: None,
        });
        current.rows += 1;
        current.lines[1] = number;
        if let Some(time_s) = time_s {
            current.time_s = Some([current.time_s.map_or(time_s, |times| times[0]), time_s]);
        }
        for column in without {
            if !current.columns.iter().any(|known| known == column) {
                current.columns.push(column.to_owned());
            }
        }
    }

    /// Ends a run of rows with missing numbers.
    pub(crate) fn end(&mut self) {
        let last = self.current.take();
        if last.as_ref().map_or(0, |last| last.rows) > self.longest.as_ref().map_or(0, |longest| longest.rows) {
            self.longest = last;
        }
    }

    /// The longest sequence of rows with missing numbers, with times on the clock of the file; `None` if no row lacks
    /// numbers.
    pub(crate) fn longest(mut self) -> Option<Longest> {
        self.end();
        self.longest
    }

    /// Returns the result for a repeat whose clock begins at `start_s`, in seconds, and which has `whole` complete
    /// rows; `None` if no row lacks numbers.
    pub(crate) fn found(self, start_s: f64, whole: usize) -> Option<Missing> {
        let rows = self.rows;
        let mut longest = self.longest()?;
        longest.time_s = longest.time_s.map(|times| times.map(|time_s| time_s - start_s));
        Some(Missing { rows, of: rows + whole, longest })
    }
}
