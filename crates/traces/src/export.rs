//! Reader of tribometer exports: tables with the names, units, separators and decimal signs of the instrument.
//!
//! A file holds one or several tables, each below a line of titles; other lines of the instrument may surround them. A
//! new repeat begins with each table, with a new number in a column of repeats, with a line such as `Run # 2`, and
//! where the clock restarts. Steps are numbered by a column or by lines such as `Step No. 2`; [`ExportOptions::step`]
//! selects one step.

use crate::cells::{DecimalSigns, cut, expected_values, number_in, separator, unquoted};
use crate::columns::{Channel, Column, Titles, columns};
pub use crate::export_error::ExportError;
use crate::layout::{Layout, Line, header, is_missing, no_header};
use crate::markers::{Marker, marker};
use crate::missing_numbers::Longest;
pub use crate::recorded::Recorded;
use crate::recorded::{Row, Table};

/// Repeats of one export file, and the columns that were used.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceFile {
    /// Repeats in the order of the file.
    pub repeats: Vec<Recorded>,
    /// Titles of columns that were not used.
    pub unused: Vec<String>,
    /// Channels of the columns that were used.
    pub used: Vec<Channel>,
}

/// Options for reading exports.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExportOptions<'a> {
    /// Distance from the axis to the centre of a specimen, in metres; needed for a torque, and to convert rotational
    /// speed to sliding speed; `None` if not given.
    pub effective_radius_m: Option<f64>,
    /// Custom titles of columns; `None` for the known titles only.
    pub titles: Option<&'a Titles>,
    /// Step to read, by its number in the file, or counted from 1 where the file has no numbers; `None` reads the whole
    /// file.
    pub step: Option<u32>,
}

/// Prefixes of comment lines.
const COMMENTS: [&str; 4] = ["#", "%", "//", "\"#"];
/// The clock counts as restarted if time falls back to within this fraction of the time span recorded so far from the
/// trace's beginning.
const CLOCK_ANEW: f64 = 0.01;
/// Minimum number of rows before a restart of the clock is recognized. A column that is no time falls back after fewer
/// rows.
const MIN_ROWS_OF_CLOCK: usize = 20;
/// Maximum number of summary lines (sums, means) below the last row: lines as long as a row, with words instead of a
/// time.
const MAX_SUMMARY_LINES: usize = 10;
/// Maximum number of steps listed in a message.
const MAX_LISTED_STEPS: usize = 12;

/// Parses the text of an export.
///
/// # Errors
/// [`ExportError`] with line and column of the text that was refused.
pub fn parse(text: &str, options: &ExportOptions<'_>) -> Result<TraceFile, ExportError> {
    let known = Titles::default();
    let titles = options.titles.unwrap_or(&known);
    let text = text.trim_start_matches('\u{feff}');
    // Lines are not trimmed at their end, because a tab there separates an empty cell.
    let lines = text.lines().zip(1..).map(|(line, number)| (number, line));
    let lines: Vec<Line<'_>> = lines.filter(|(_, line)| has_content(line)).collect();
    let mut reader = Reader { options: *options, ..Reader::default() };
    let mut at = 0;
    while let Some(&(number, line)) = lines.get(at) {
        at += 1;
        if reader.read_row(number, line)? {
            continue;
        }
        match header(line, titles) {
            Some(cells) => at += reader.begin_table(number, cells, &lines[at..], titles)?,
            None => reader.read_text(number, line)?,
        }
    }
    if !reader.has_table {
        return Err(no_header(lines.into_iter(), titles));
    }
    reader.finish()
}

/// Whether a line is neither empty nor a comment.
fn has_content(line: &str) -> bool {
    let start = line.trim_start();
    !start.is_empty() && !COMMENTS.iter().any(|mark| start.starts_with(mark))
}

/// Titles of the first table in the text of an export, each with the recognized channel, or `None`. If no title is
/// known, the cells above the first row of numbers are returned. Empty if there is no table.
pub fn titles_in(text: &str, titles: &Titles) -> Vec<(String, Option<Channel>)> {
    let lines = text.trim_start_matches('\u{feff}').lines();
    let mut above = None;
    for line in lines.filter(|line| has_content(line)) {
        let known = header(line, titles).map(|(_, cells)| cells);
        let is_row = |separator| cut(line, separator).iter().all(|cell| number_in(cell, separator).is_some());
        let ends = known.is_some() || separator(line).is_some_and(is_row);
        if !ends {
            above = separator(line).map(|separator| cut(line, separator));
            continue;
        }
        let cells = known.or(above).unwrap_or_default();
        // A title with an unknown unit gets no channel here; `parse` refuses the title with the reason.
        let columns = columns(&cells, titles).unwrap_or_else(|_| vec![None; cells.len()]);
        let channels = columns.into_iter().map(|column| column.map(|column| column.channel));
        return cells.iter().map(|cell| unquoted(cell).to_owned()).zip(channels).collect();
    }
    Vec::new()
}

/// State of the trace that is being read: number of its run and step, times of its first and last row, number of its
/// rows.
#[derive(Clone, Copy)]
struct Current {
    run: Option<f64>,
    step: Option<f64>,
    start_s: f64,
    last_s: f64,
    rows: usize,
    /// Whether no row of the trace has an earlier time than the row before.
    is_ordered: bool,
}

/// Number of a step, and the line number of its first row.
type NumberedStep = (f64, u32);

/// Reads a file line by line.
#[derive(Default)]
struct Reader<'a, 'o> {
    options: ExportOptions<'o>,
    layout: Option<Layout<'a>>,
    has_table: bool,
    unused: Vec<String>,
    used: Vec<Channel>,
    /// Run number in the last marker line (`Run # 2`); `None` before any.
    run: Option<f64>,
    /// Step number in the last marker line (`Step No. 2`); `None` before any.
    step: Option<f64>,
    /// Whether a header or a marker line came since the last row.
    is_apart: bool,
    current: Option<Current>,
    /// Number of traces begun so far, including those that are skipped.
    traces_begun: u32,
    tables: Vec<Table>,
    signs: DecimalSigns,
    /// The first text line since the last header or marker line, and whether the line has as many cells as a row;
    /// `None` before such a line.
    words: Option<(Line<'a>, bool)>,
    summary_lines: usize,
    steps: Vec<NumberedStep>,
    /// Whether any run has several steps that are separated by headers, marker lines or restarts of the clock.
    has_several_steps: bool,
}

impl<'a> Reader<'a, '_> {
    /// Begins a table with the separator and titles `cells` in line `number`. Returns how many of the lines `below`
    /// belong to the header.
    fn begin_table(
        &mut self,
        number: u32,
        cells: (char, Vec<&'a str>),
        below: &[Line<'a>],
        titles: &Titles,
    ) -> Result<usize, ExportError> {
        self.has_table = true;
        self.is_apart = true;
        self.words = None;
        self.summary_lines = 0;
        let is_other_step = self.step.is_some_and(|step| self.options.step.is_some_and(|one| f64::from(one) != step));
        match Layout::new(number, cells, below, titles, self.options.effective_radius_m.is_some()) {
            Ok(layout) => {
                for title in layout.unused() {
                    if !self.unused.contains(&title) {
                        self.unused.push(title);
                    }
                }
                self.used.extend(layout.columns.iter().flatten().map(|column| column.channel));
                let head = usize::from(layout.has_units);
                self.layout = Some(layout);
                Ok(head)
            }
            // Steps that are not read may have other columns.
            Err(_) if is_other_step => {
                self.layout = None;
                Ok(0)
            }
            Err(error) => Err(error),
        }
    }

    /// Reads `line` if it is a row of the current table, and returns whether it is one.
    fn read_row(&mut self, number: u32, line: &'a str) -> Result<bool, ExportError> {
        let Some(layout) = &self.layout else { return Ok(false) };
        let (separator, width) = (layout.separator, layout.titles.len());
        let cells = cut(line, separator);
        let time_s = number_at(layout, layout.time, &cells);
        let has_time = time_s.is_some() && cells.len() >= width;
        let is_numbers = !line.contains(|letter: char| letter.is_alphabetic() || letter == ':')
            && cells.iter().any(|cell| number_in(cell, separator).is_some());
        let lacks_time = cells.len() >= width && cells.get(layout.time).is_some_and(|cell| is_missing(cell));
        if !(has_time || is_numbers || (lacks_time && layout.words_for_numbers(&cells).is_none())) {
            return Ok(false);
        }
        if let Some((line, is_long)) = self.words.take() {
            // After words such as `Test completed` the next run may begin, with a restarted clock.
            let restarts_clock =
                time_s.zip(self.current).is_some_and(|(time_s, current)| current.restarts_clock(time_s, false));
            if is_long || !restarts_clock {
                return Err(self.text_error(line, is_long));
            }
        }
        let marked = |channel: Channel| layout.find(channel).and_then(|at| number_at(layout, at, &cells));
        let [run, step] = [marked(Channel::Repeat).or(self.run), marked(Channel::Step).or(self.step)];
        self.assign_row(number, time_s, run, step);
        let is_read = match (self.options.step, step) {
            (None, _) => true,
            (Some(one), Some(step)) => f64::from(one) == step,
            (Some(one), None) => one == self.traces_begun,
        };
        if is_read {
            self.read(number, &cells)?;
        }
        Ok(true)
    }

    /// Assigns the row in line `number` to the current trace, or begins another trace.
    fn assign_row(&mut self, number: u32, time_s: Option<f64>, run: Option<f64>, step: Option<f64>) {
        if let Some(step) = step.filter(|step| !self.steps.iter().any(|(known, _)| known == step)) {
            self.steps.push((step, number));
        }
        let is_apart = std::mem::take(&mut self.is_apart);
        let begins = match self.current {
            None => true,
            Some(current) => {
                let changes_step = step != current.step;
                let changes_run = run.is_some() && run != current.run;
                let restarts_clock = time_s.is_some_and(|time_s| current.restarts_clock(time_s, changes_step));
                if changes_step && !changes_run && (is_apart || restarts_clock) {
                    self.has_several_steps = true;
                }
                let by_clock = restarts_clock && !is_apart && !changes_run && !changes_step;
                let begins = is_apart || changes_run || restarts_clock || (changes_step && self.options.step.is_some());
                if begins {
                    self.tables.push(Table::restarted_by_clock(by_clock.then_some(number)));
                }
                begins
            }
        };
        if begins {
            self.traces_begun += 1;
            let start_s = time_s.unwrap_or(f64::NAN);
            self.current = Some(Current { run, step, start_s, last_s: start_s, rows: 0, is_ordered: true });
        }
        if let Some(current) = &mut self.current {
            (current.run, current.step) = (run, step);
            current.rows += 1;
            if let Some(time_s) = time_s {
                if time_s < current.last_s {
                    current.is_ordered = false;
                }
                current.start_s = if current.start_s.is_nan() { time_s } else { current.start_s };
                current.last_s = time_s;
            }
        }
    }

    /// Adds the numbers of the row `cells` in line `number` to the current trace.
    fn read(&mut self, number: u32, cells: &[&str]) -> Result<(), ExportError> {
        let Some(layout) = &self.layout else { return Ok(()) };
        let width = layout.titles.len();
        // A decimal comma between commas shifts the values behind it. Instruments end rows with empty cells.
        if cells.len() < width || cells[width..].iter().any(|cell| !unquoted(cell).is_empty()) {
            return Err(other_width(layout, number, cells.len()));
        }
        check_signs(layout, cells, number, &mut self.signs)?;
        let mut row = Row::default();
        for (column, cell) in layout.columns.iter().zip(cells) {
            let Some(column) = column else { continue };
            match number_in(cell, layout.separator) {
                Some(value) => row.set(column.channel, column.to_si(value)),
                None if is_missing(cell) || layout.may_hold_words(column) => {}
                None => return Err(ExportError::cell(number, column.name(), cell)),
            }
        }
        let is_lacking = |column: &&Column| layout.requires(column) && row.get(column.channel).is_none();
        let without = layout.columns.iter().flatten().filter(is_lacking).map(Column::name);
        if self.tables.is_empty() {
            self.tables.push(Table::default());
        }
        if let Some(table) = self.tables.last_mut() {
            table.push(number, &row, without);
        }
        Ok(())
    }

    /// Handles a line that is neither a row nor a header.
    fn read_text(&mut self, number: u32, line: &'a str) -> Result<(), ExportError> {
        match marker(line) {
            Some(Marker::Run(run)) => self.run = Some(run),
            Some(Marker::Step(step)) => self.step = Some(step),
            None => {
                let Some(layout) = &self.layout else { return Ok(()) };
                let is_long = cut(line, layout.separator).len() >= layout.titles.len();
                let words = *self.words.get_or_insert(((number, line), is_long));
                self.summary_lines += usize::from(is_long);
                if self.summary_lines > MAX_SUMMARY_LINES {
                    return Err(self.text_error(words.0, words.1));
                }
                return Ok(());
            }
        }
        self.is_apart = true;
        self.words = None;
        Ok(())
    }

    /// Creates the error for a text line between or instead of rows.
    fn text_error(&self, (number, line): Line<'_>, is_long: bool) -> ExportError {
        let Some(layout) = &self.layout else { return ExportError::at(Some(number), "is no row", "numbers") };
        let cells = cut(line, layout.separator);
        match layout.words_for_numbers(&cells) {
            Some((column, cell)) if is_long => ExportError::cell(number, column.name(), cell),
            _ => other_width(layout, number, cells.len()),
        }
    }

    /// Returns the traces that were read.
    fn finish(self) -> Result<TraceFile, ExportError> {
        if self.options.step.is_none() && self.has_several_steps {
            return Err(self.several_steps());
        }
        let radius_m = self.options.effective_radius_m.unwrap_or(f64::NAN);
        let words = self.words.map(|(line, is_long)| self.text_error(line, is_long)).filter(|_| self.traces_begun == 0);
        let no_such_step = self.options.step.map(|step| self.no_such_step(step));
        let tables: Vec<Table> = self.tables;
        let is_read = |table: &Table| self.options.step.is_none() || table.has_rows();
        let numbered = (1..).zip(tables.into_iter().filter(is_read));
        let (full, empty): (Vec<_>, Vec<_>) = numbered.partition(|(_, table)| !table.is_empty());
        let repeats: Vec<Recorded> = full.into_iter().map(|(number, table)| table.recorded(number, radius_m)).collect();
        if repeats.is_empty() {
            let missing = empty.into_iter().find_map(|(_, table)| table.longest_missing());
            return Err(words.or(no_such_step.filter(|_| missing.is_none())).unwrap_or_else(|| no_sample(missing)));
        }
        Ok(TraceFile { repeats, unused: self.unused, used: self.used })
    }

    /// Lists the steps of the file for messages.
    fn listed_steps(&self) -> String {
        let shown = self.steps.iter().take(MAX_LISTED_STEPS);
        let mut listed: Vec<String> = shown.map(|(step, line)| format!("{step} (from line {line})")).collect();
        if self.steps.len() > MAX_LISTED_STEPS {
            listed.push("...".to_owned());
        }
        listed.join(", ")
    }

    fn several_steps(&self) -> ExportError {
        let reason = format!("holds several steps, each with its own clock: {}", self.listed_steps());
        let example = self.steps.first().map_or(1.0, |(step, _)| *step);
        let expected = format!("the step of this condition, as `step = {example}` in its table or --step {example}");
        ExportError::at(None, reason, expected)
    }

    fn no_such_step(&self, step: u32) -> ExportError {
        if self.steps.is_empty() {
            let reason = format!(
                "has no step {step}: it numbers no steps, and the count of its tables is {}",
                self.traces_begun
            );
            return ExportError::at(None, reason, format!("a `step` from 1 to {}, or none", self.traces_begun));
        }
        ExportError::at(None, format!("has no step {step}"), format!("one of its steps: {}", self.listed_steps()))
    }
}

impl Current {
    /// Whether a row at `time_s` restarts the clock; a change of step needs only a time that goes back.
    fn restarts_clock(&self, time_s: f64, changes_step: bool) -> bool {
        let is_back = time_s <= self.start_s + CLOCK_ANEW * (self.last_s - self.start_s);
        let has_run = self.is_ordered && self.rows >= MIN_ROWS_OF_CLOCK;
        time_s < self.last_s && (changes_step || (is_back && has_run))
    }
}

/// The number in column `at` of a row, in SI units; `None` if the cell holds no number.
fn number_at(layout: &Layout<'_>, at: usize, cells: &[&str]) -> Option<f64> {
    let number = number_in(cells.get(at)?, layout.separator)?;
    layout.columns[at].as_ref().map(|column| column.to_si(number))
}

fn other_width(layout: &Layout<'_>, number: u32, found: usize) -> ExportError {
    let expected = expected_values(found, layout.titles.len(), layout.separator);
    ExportError::at(Some(number), format!("has {found} values"), expected)
}

/// Creates the error for a table without a sample; `rows` is the longest sequence of rows with missing numbers, `None`
/// if no row lacks numbers.
fn no_sample(rows: Option<Longest>) -> ExportError {
    let Some(Longest { rows, columns, lines: [first, _], .. }) = rows else {
        return ExportError::at(None, "has no rows", "samples below the header");
    };
    let reason = format!("none of the {rows} rows below the header has a number");
    let expected = "numbers of time, friction and normal force, in the same row";
    ExportError { column: Some(columns.join(", ")), ..ExportError::at(Some(first), reason, expected) }
}

/// Refuses a table that mixes decimal commas and points; `line` is the line number of `cells`.
fn check_signs(layout: &Layout<'_>, cells: &[&str], line: u32, signs: &mut DecimalSigns) -> Result<(), ExportError> {
    for ((column, cell), at) in layout.columns.iter().zip(cells).zip(0..) {
        let is_read = column.as_ref().is_some_and(|column| !layout.may_hold_words(column));
        if !is_read || number_in(cell, layout.separator).is_none() {
            continue;
        }
        if let Some((point, reason)) = signs.take(cell, [line, at]) {
            let column = layout.columns.get(point.column).and_then(Option::as_ref);
            return Err(ExportError {
                column: column.map(|column| column.name().to_owned()),
                value: Some(format!("\"{}\"", point.number)),
                ..ExportError::at(Some(point.line), reason, DecimalSigns::EXPECTED)
            });
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "export_tests.rs"]
mod tests;
