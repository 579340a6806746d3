//! Reads texts: separates the header from the heights, and distinguishes matrices from points.

use std::io::{BufRead, Cursor, Read};

use super::comma::{self, DecimalSign, is_row};
use super::header::{ABOVE_DATA, Header, begins_with_a_word, names_a_value};
use super::lines::{Delimiter, Lines};
use super::matrix::MatrixReader;
use super::overridden::StatedValues;
use super::tables::{Axes, HeldRows};
use super::window::window_of;
use super::xyz::{XyzReader, is_point};
use super::{MapFormat, ReadMap, ReadOptions, wyko, zygo};
use crate::topography::ReadError;
use crate::topography::error::significant;

/// Bytes at the beginning of a text that are searched for the name of its format.
const MAX_SIGNATURE_BYTES: u64 = 2048;
/// Beginning of a CSV export of Keyence software, the same in every language.
const KEYENCE: &str = "ImageDataCsv";

enum Data {
    Matrix(Box<MatrixReader>),
    Xyz(XyzReader),
}

/// A text of heights, as far as it is read.
#[derive(Default)]
struct Text {
    options: ReadOptions,
    header: Header,
    data: Option<Data>,
    /// Line number and text of the first line of a preamble that an instrument may have written above the column
    /// titles.
    preamble: Option<(usize, String)>,
    /// Last lines of tabs only above all data: their number of tabs, and the number of consecutive lines that have it.
    tabs_above: Option<(usize, usize)>,
    /// Whether lines without comment mark stand above the data; programs that write tables then also separate them by
    /// lines of tabs.
    has_unmarked: bool,
    /// The first rows, while the first row and the first column may be axes.
    held: Option<HeldRows>,
    axes: Option<Axes>,
    /// Whether another map follows the one that is read.
    has_another: bool,
    has_decimal_commas: bool,
}

impl Text {
    /// Reads a line; returns whether more lines are needed.
    fn take(&mut self, row: &str, line: usize) -> Result<bool, ReadError> {
        let (text, before_data) = (row.trim(), self.data.is_none() && self.held.is_none());
        if text.is_empty() && !row.is_empty() {
            return self.take_tabs(row, line);
        }
        if !before_data && self.header.restates_side(text) {
            self.has_another = true;
            return Ok(false);
        }
        if before_data && self.header.keyence && !is_row(Delimiter::of(text), text) {
            self.header.keyence_line(text);
            return Ok(true);
        }
        self.has_unmarked |= before_data && begins_with_a_word(text);
        if text.is_empty() || ((before_data || text.starts_with(['#', '%'])) && self.header.take(text, line)?) {
            if self.header.titled {
                self.preamble = None;
            }
            return Ok(true);
        }
        if before_data && !self.header.titled && begins_with_a_word(text) {
            if names_a_value(text) {
                self.header.read_unmarked(text, line);
                return Ok(true);
            }
            self.preamble.get_or_insert_with(|| (line, text.to_owned()));
            return Ok(true);
        }
        // The data have no titles, so the lines above them are not a preamble; the first of them is refused.
        self.push_preamble()?;
        self.push(row, line)
    }

    /// Reads a line of tabs only: a row of missing points if rows have that many fields, otherwise ignored.
    fn take_tabs(&mut self, row: &str, line: usize) -> Result<bool, ReadError> {
        if self.held.is_some() {
            return self.push(row, line);
        }
        match &mut self.data {
            Some(Data::Matrix(matrix)) if matrix.is_row_of_missing(row) => {
                matrix.push(row, line)?;
                Ok(!matrix.is_full())
            }
            Some(_) => Ok(true),
            None => {
                self.tabs_above = match self.tabs_above {
                    Some((tabs, count)) if tabs == row.len() => Some((tabs, count + 1)),
                    _ => Some((row.len(), 1)),
                };
                Ok(true)
            }
        }
    }

    /// Refuses lines above data without titles.
    fn push_preamble(&mut self) -> Result<(), ReadError> {
        let Some((line, text)) = self.preamble.take() else { return Ok(()) };
        self.push(&text, line).map(|_| ()).map_err(|error| match error {
            ReadError::NotANumber { line, column, value, .. } => {
                ReadError::NotANumber { line, column, value, expected: ABOVE_DATA }
            }
            other => other,
        })
    }

    /// Adds the quantities that are missing, too, to an error on a decimal comma; other errors stay as they are.
    fn with_all_that_is_missing(&self, error: ReadError) -> ReadError {
        match &self.data {
            Some(Data::Matrix(_)) => error.with_missing(MatrixReader::missing(&self.header, &self.options)),
            Some(Data::Xyz(_)) => error.with_missing(XyzReader::missing(&self.header, &self.options)),
            None => error,
        }
    }

    fn push(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        if self.data.is_none() && self.held.is_none() {
            self.header.resolve_open_entries(self.has_decimal_commas)?;
            let is_matrix = self.options.format.is_none() && detect(&self.header, text) == MapFormat::Matrix;
            self.held = (is_matrix && HeldRows::begin(text)).then(HeldRows::default);
        }
        if let Some(held) = &mut self.held {
            held.rows.push((text.to_owned(), line));
            return if held.is_full() { self.release() } else { Ok(true) };
        }
        self.push_data(text, line)
    }

    /// Decides whether the rows held back have axes, and reads the rows.
    fn release(&mut self) -> Result<bool, ReadError> {
        let Some(held) = self.held.take() else { return Ok(true) };
        self.axes = if held.is_full() { held.axes() } else { None };
        if let Some(axes) = self.axes {
            let lateral = self.options.lateral_unit.map(Into::into);
            self.header.set_pixel_from_axes(axes.steps, lateral);
        }
        let rows = held.rows.iter().skip(usize::from(self.axes.is_some()));
        for (text, line) in rows {
            if !self.push_data(text, *line)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn push_data(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let text = self.axes.map_or(text, |axes| axes.strip(text));
        let target = match &mut self.data {
            Some(target) => target,
            None => self.data.insert(match self.options.format.unwrap_or_else(|| detect(&self.header, text)) {
                MapFormat::Xyz => Data::Xyz(XyzReader::default()),
                _ => {
                    let mut matrix = MatrixReader::new(text, line, &self.header, &self.options)?;
                    let tabs_above = self.tabs_above.filter(|_| !self.has_unmarked);
                    if let Some((tabs, count)) = tabs_above {
                        let missing = "\t".repeat(tabs);
                        if matrix.is_row_of_missing(&missing) {
                            (0..count).try_for_each(|_| matrix.push(&missing, line))?;
                        }
                    }
                    Data::Matrix(Box::new(matrix))
                }
            }),
        };
        match target {
            Data::Matrix(matrix) => {
                matrix.push(text, line)?;
                Ok(!matrix.is_full())
            }
            Data::Xyz(points) => points.push(text, line).map(|()| true),
        }
    }

    /// Notes on how the text was interpreted.
    fn notes(&self) -> Vec<String> {
        let axes = self.axes.map(|axes| {
            let [along, across] = axes.steps.map(|step| significant(step, 5));
            format!(
                "the first row and the first column are axes, in steps of {along} and {across}: they are no heights"
            )
        });
        let another = self.has_another.then(|| "the file holds several maps: the first is read".to_owned());
        let commas = self.has_decimal_commas.then(|| comma::FOUND.to_owned());
        axes.into_iter().chain(another).chain(self.header.notes()).chain(commas).collect()
    }
}

/// Reads a text in the dialect recognised from its beginning.
pub(super) fn read_text(mut source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut start = Vec::new();
    let read = (&mut source).take(MAX_SIGNATURE_BYTES).read_to_end(&mut start);
    read.map_err(|error| ReadError::source(1, &error))?;
    let head = String::from_utf8_lossy(&start).trim_start_matches('\u{feff}').to_owned();
    let source = Cursor::new(start).chain(source);
    if head.starts_with(wyko::MAGIC) {
        wyko::read(source, options)
    } else if zygo::MAGIC.iter().any(|magic| head.starts_with(magic)) {
        zygo::read(source, options)
    } else {
        read_table(source, head.contains(KEYENCE), options)
    }
}

/// Reads a matrix or points below header lines.
fn read_table(source: impl BufRead, is_keyence: bool, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut lines = Lines::new(source);
    let mut sign = DecimalSign::new(options.decimal_comma);
    let mut header = Header::default();
    header.keyence = is_keyence;
    let mut text = Text { options: *options, header, ..Text::default() };
    loop {
        let line = lines.line() + 1;
        let Some(own) = lines.next_row()? else { break };
        let with_points = sign.with_points(own, line);
        text.has_decimal_commas = sign == DecimalSign::Found;
        let more =
            with_points.and_then(|read| text.take(&read, line).map_err(|error| comma::as_written(error, own, &read)));
        if !more.map_err(|error| text.with_all_that_is_missing(error))? {
            break;
        }
    }
    text.push_preamble()?;
    let released = text.release();
    released.map_err(|error| text.with_all_that_is_missing(error))?;
    let mut notes = text.notes();
    let Text { header, data, axes, has_another, .. } = text;
    let ((map, whole), format, stated) = match data {
        None => {
            let lines = lines.line();
            let reason = format!("no data after {lines} lines: expected rows of heights, or points x y z");
            return Err(ReadError::Refused(reason));
        }
        Some(Data::Matrix(mut matrix)) => {
            // If the header gives only the sides, the pixel size depends on the number of rows, including those behind
            // a crop.
            let rows = matrix.count_rest((!has_another).then_some(&mut lines), options, &header)?;
            let stated = matrix.stated_values(rows, &header);
            (matrix.finish(rows, &header, options)?, MapFormat::Matrix, stated)
        }
        Some(Data::Xyz(points)) => {
            let stated = StatedValues { pixel_m: [None; 2], height_unit: header.value(), lateral_unit: header.lateral };
            let part = window_of(points.finish(&header, options)?, options.crop, options.decimation)?;
            (part, MapFormat::Xyz, stated)
        }
    };
    // If a matrix has axes, the unit of x and y is that of their steps.
    let given = if axes.is_some() { ReadOptions { lateral_unit: None, ..*options } } else { *options };
    notes.splice(..0, stated.notes(&given, format));
    Ok(ReadMap { map, whole, format, comments: header.comments, notes })
}

/// Format of a text, from its header and its first line of data.
fn detect(header: &Header, text: &str) -> MapFormat {
    if header.titled || !header.is_sized() && !header.keyence && is_point(text) {
        MapFormat::Xyz
    } else {
        MapFormat::Matrix
    }
}

#[cfg(test)]
mod tests {
    use super::super::GIVEN;
    use crate::topography::{Crop, Decimation, DecimationMethod, MapFormat, ReadError, ReadOptions, read_map};

    /// The map as text, in which NaN equals NaN.
    fn read(text: &str, options: &ReadOptions) -> Result<String, ReadError> {
        read_map(text.as_bytes(), options).map(|read| format!("{:?} {}", read.map, read.whole))
    }

    /// The rows of a map of five columns with missing points at its sides, written as `NaN`.
    const HOLED: [&str; 6] = [
        "NaN\t2\tNaN\t4\t5",
        "NaN\tNaN\tNaN\tNaN\tNaN",
        "1\t2\t3\t4\tNaN",
        "5\tNaN\tNaN\tNaN\tNaN",
        "NaN\t6\t7\t8\t9",
        "1\t2\t3\t4\t5",
    ];

    #[test]
    fn empty_fields_between_tabs_are_missing_points_wherever_they_stand() {
        let crop = Crop { first_row: 1, first_col: 0, rows: 3, cols: 4 };
        let blocks = Decimation { factor: 2, method: DecimationMethod::Pick };
        let all = [
            GIVEN,
            ReadOptions { crop: Some(crop), ..GIVEN },
            ReadOptions { crop: Some(Crop { first_col: 1, cols: 2, ..crop }), ..GIVEN },
            ReadOptions { decimation: Some(blocks), ..GIVEN },
        ];
        // Each row in turn is the first and the last.
        for first in 0..HOLED.len() {
            let rows: Vec<&str> = HOLED.iter().cycle().skip(first).take(HOLED.len()).copied().collect();
            for options in &all {
                let expected = read(&(rows.join("\n") + "\n"), options).unwrap();
                let empty = rows.join("\n").replace("NaN", "") + "\n";
                let closed = empty.replace('\n', "\t\n");
                for (text, ending) in [(&empty, "\n"), (&closed, "\n"), (&empty, "\r\n")] {
                    let text = text.replace('\n', ending);
                    assert_eq!(read(&text, options).unwrap(), expected, "{text:?} {options:?}");
                    // Also below a header whose lines are marked.
                    assert_eq!(read(&format!("# a map{ending}{ending}{text}"), options).unwrap(), expected, "{text:?}");
                }
            }
        }
    }

    #[test]
    fn tabs_before_all_rows_indent_them_and_lines_of_other_tabs_are_blank() {
        let plain = "1\t2\t3\t4\n5\t\t7\t8\n1\t1\t1\t1\n";
        let crop = Some(Crop { first_row: 0, first_col: 1, rows: 2, cols: 3 });
        for options in [GIVEN, ReadOptions { crop, ..GIVEN }] {
            let expected = read(plain, &options).unwrap();
            for indent in ["\t", "\t\t", "  \t"] {
                let indented: String = plain.lines().map(|row| format!("{indent}{row}\n")).collect();
                assert_eq!(read(&indented, &options).unwrap(), expected, "{indented:?}");
                let closed = indented.replace('\n', "\t\n");
                assert_eq!(read(&closed, &options).unwrap(), expected, "{closed:?}");
            }
            for blank in ["\t\n", "\t\t\n", "\t\t\t\t\t\n", " \t \n"] {
                for text in [
                    format!("{blank}{plain}"),
                    format!("{plain}{blank}"),
                    plain.replacen('\n', &format!("\n{blank}"), 1),
                ] {
                    assert_eq!(read(&text, &options).unwrap(), expected, "{text:?}");
                }
            }
            // Programs that write tables separate the lines above the data by lines of as many tabs.
            let table = format!("Operator: Anna\t\t\t\n\t\t\t\n{plain}");
            assert_eq!(read(&table, &options).unwrap(), expected);
        }
        // A column skipped by an indentation does not exist and cannot be cropped.
        let crop = Some(Crop { first_row: 0, first_col: 0, rows: 2, cols: 3 });
        let cropped = |text: &str| read(text, &ReadOptions { crop, ..GIVEN });
        assert!(cropped("\t2\t3\n\t5\t6\n").unwrap_err().to_string().contains("the crop takes"));
        assert!(cropped("\t2\t3\n4\t5\t6\n").is_ok());
        // A column count in the header decides.
        let told = |count: usize| format!("# File Format = ASCII\n# x-pixels = {count}\n\t2\t3\n\t5\t6\n");
        let missing = [2, 3].map(|count| read_map(told(count).as_bytes(), &GIVEN).unwrap().map.missing());
        assert_eq!(missing, [0, 2]);
        // A short row stays short.
        for (text, said) in
            [("1\t2\t3\n1\t2\n", "line 2: 2 values: expected 3"), ("\t2\t3\n4\t5\n", "line 2: 2 values")]
        {
            assert!(read(text, &GIVEN).unwrap_err().to_string().contains(said), "{text:?}");
        }
    }

    #[test]
    fn points_may_be_indented_and_parted_by_blank_lines() {
        let points = "\t0\t0\t1\n\t0\t1\t2\n\t\t\n\t1\t0\t3\n\t1\t1\t\n";
        let found = read_map(points.as_bytes(), &GIVEN).unwrap();
        assert_eq!((found.format, found.map.rows(), found.map.missing()), (MapFormat::Xyz, 2, 1));
        let rows = "\t\t5\t6\t7\t\t\n1\t2\t3\t4\t5\t6\t7\n";
        assert_eq!(read_map(rows.as_bytes(), &GIVEN).unwrap().format, MapFormat::Matrix);
    }
}
