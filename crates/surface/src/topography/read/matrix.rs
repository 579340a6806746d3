//! Heights as a matrix, one row per line.

use std::io::BufRead;

use super::comma::SplitNumbers;
use super::header::Header;
use super::lines::{Delimiter, Greatest, Lines, expected_height, height, not_a_number};
use super::overridden::StatedValues;
use super::scale::Scale;
use super::tables::CoordinateListCheck;
use super::window::Window;
use super::{MapFormat, ReadOptions};
use crate::topography::unit::unit_names;
use crate::topography::{HeightMap, MapOption, NotGiven, ReadError};

/// Allowed relative difference of a pixel's sides, in addition to the rounding of the header's sides, because some
/// programs count the distances between pixels instead of the pixels.
const SQUARE_TOLERANCE: f64 = 0.01;
/// Largest allowed relative difference of a pixel's sides, whatever the rounding.
const MAX_SQUARE_TOLERANCE: f64 = 0.06;

/// Interpretation of delimiters at the ends of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LastField {
    /// Lines do not end with a delimiter, or the delimiter closes the last field.
    Counted,
    /// All lines so far end with a delimiter, so the last column is either empty or does not exist.
    Open,
}

/// Rows read so far, in the file's unit, NaN where missing.
#[derive(Debug)]
pub(super) struct MatrixReader {
    delimiter: Delimiter,
    /// Indentation before the first field of a line.
    indent: String,
    /// Number of columns, including a last one that may not exist.
    cols: usize,
    last: LastField,
    row: Vec<f64>,
    greatest: Greatest,
    window: Window,
    /// Checks whether the table is a list of coordinates; `None` if the table cannot be a list.
    listed: Option<CoordinateListCheck>,
    /// Checks whether commas delimit numbers and are decimal, too; `None` if they cannot.
    split: Option<SplitNumbers>,
    /// While all rows begin with the same tabs: a reader that takes these tabs as delimiters of empty fields instead of
    /// indentation.
    unindented: Option<Box<MatrixReader>>,
    /// Tabs with which all rows so far begin, and the error to report if these tabs are an indentation.
    unless_indented: Option<(String, ReadError)>,
}

impl MatrixReader {
    /// A reader for rows like `first`, which is on line `line`.
    pub(super) fn new(first: &str, line: usize, header: &Header, options: &ReadOptions) -> Result<Self, ReadError> {
        let delimiter = Delimiter::of(first);
        let first = delimiter.row(first);
        let indent = &first[..first.len() - first.trim_start_matches('\t').len()];
        let indented = Self::of(delimiter, first, indent, line, header, options);
        if indent.is_empty() {
            return indented;
        }
        match (indented, Self::of(delimiter, first, "", line, header, options)) {
            // A column count in the header decides.
            (Ok(indented), _) if header.pixels[1].is_some() => Ok(indented),
            (Ok(indented), unindented) => Ok(Self { unindented: unindented.ok().map(Box::new), ..indented }),
            (Err(_), Ok(unindented)) if header.pixels[1].is_some() => Ok(unindented),
            (Err(refused), Ok(unindented)) => {
                Ok(Self { unless_indented: Some((indent.to_owned(), refused)), ..unindented })
            }
            (Err(refused), Err(_)) => Err(refused),
        }
    }

    /// Like [`Self::new`], for rows that all begin with `indent`.
    fn of(
        delimiter: Delimiter,
        first: &str,
        indent: &str,
        line: usize,
        header: &Header,
        options: &ReadOptions,
    ) -> Result<Self, ReadError> {
        let row = &first[indent.len()..];
        let (closed, all) = (delimiter.fields(row).count(), delimiter.all_fields(row).count());
        let (cols, last) = match header.pixels[1].map(|expected| usize::try_from(expected).unwrap_or(usize::MAX)) {
            Some(expected) if expected == closed || expected == all => (expected, LastField::Counted),
            Some(expected) => return Err(ReadError::RowLength { line, found: closed, expected }),
            None if all > closed => (all, LastField::Open),
            None => (closed, LastField::Counted),
        };
        let window = Window::new(None, cols as u64, options.crop, options.decimation)?;
        let (indent, row) = (indent.to_owned(), Vec::new());
        // A given format or number of columns decides.
        let is_open = options.format.is_none() && header.pixels[1].is_none();
        let listed = CoordinateListCheck::new(cols).filter(|_| is_open);
        let greatest = Greatest::default();
        let split = (delimiter == Delimiter::Comma && is_open).then(SplitNumbers::default);
        let (unindented, unless_indented) = (None, None);
        Ok(Self { delimiter, indent, cols, last, row, greatest, window, listed, split, unindented, unless_indented })
    }

    /// Whether `text`, which contains only tabs, is a row of missing points.
    pub(super) fn is_row_of_missing(&self, text: &str) -> bool {
        let Some(tabs) = text.len().checked_sub(self.indent.len()) else { return false };
        let is_closed = self.last == LastField::Counted && tabs == self.cols;
        self.delimiter == Delimiter::Tab && !text.is_empty() && (tabs + 1 == self.cols || is_closed)
    }

    /// Takes leading tabs as delimiters of empty fields, if the row `text` does not begin with the presumed
    /// indentation.
    fn compare_indent(&mut self, text: &str) {
        if self.unless_indented.as_ref().is_some_and(|(indent, _)| !text.starts_with(&indent[..])) {
            self.unless_indented = None;
        }
        if !text.starts_with(&self.indent[..])
            && let Some(unindented) = self.unindented.take()
        {
            *self = *unindented;
        }
    }

    /// Number of columns known to exist.
    fn known_cols(&self) -> usize {
        self.cols - usize::from(self.last == LastField::Open)
    }

    pub(super) fn push(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        let text = self.delimiter.row(text);
        self.compare_indent(text);
        self.row.clear();
        if self.unindented.as_mut().is_some_and(|unindented| unindented.push(text, line).is_err()) {
            self.unindented = None;
        }
        let text = text.strip_prefix(&self.indent[..]).unwrap_or(text);
        for (n, field) in self.delimiter.all_fields(text).enumerate() {
            let value = height(field).ok_or_else(|| not_a_number(line, n, field, expected_height(field)))?;
            let value = value.unwrap_or(f64::NAN);
            self.greatest.take(value, line, n, field);
            self.row.push(value);
        }
        let ends = self.delimiter.ends(text);
        if self.last == LastField::Counted && self.row.len() == self.cols + 1 && ends {
            self.row.pop();
        } else if self.last == LastField::Open && !ends {
            if self.row.len() == self.known_cols() {
                self.drop_last_col()?;
            } else if self.row.len() == self.cols {
                self.last = LastField::Counted;
            }
        }
        if self.row.len() != self.cols {
            // A delimiter at the end closes the last field.
            let found = self.row.len() - usize::from(ends);
            return Err(ReadError::RowLength { line, found, expected: self.known_cols() });
        }
        if let Some(listed) = &mut self.listed {
            listed.push(&self.row);
        }
        if self.split.as_mut().is_some_and(|split| !split.push(self.delimiter.fields(text))) {
            self.split = None;
        }
        self.window.push(&self.row)
    }

    /// Interprets the delimiter at the ends of lines as closing their last field.
    fn drop_last_col(&mut self) -> Result<(), ReadError> {
        self.cols -= 1;
        self.last = LastField::Counted;
        self.window.drop_last_col()
    }

    /// Whether all requested rows have been read.
    pub(super) fn is_full(&self) -> bool {
        self.window.is_full()
    }

    /// Number of rows of the whole text: those read and, if the header's sides must be divided among all rows or their
    /// number is known, those still to come. A last column without any height is removed.
    pub(super) fn count_rest(
        &mut self,
        mut lines: Option<&mut Lines<impl BufRead>>,
        options: &ReadOptions,
        header: &Header,
    ) -> Result<usize, ReadError> {
        self.listed.as_ref().map_or(Ok(()), CoordinateListCheck::check)?;
        self.split.as_ref().map_or(Ok(()), SplitNumbers::check)?;
        let mut rows = self.window.rows_seen();
        let shared = options.pixel_m.is_none() && header.shares_sides();
        let is_undecided = self.last == LastField::Open && self.window.takes_last_col();
        let may_be_indented = self.unindented.is_some() || self.unless_indented.is_some();
        if shared || header.pixels[0].is_some() || is_undecided || may_be_indented {
            while let Some(text) = lines.as_mut().map_or(Ok(None), |lines| lines.next_row())? {
                let is_blank = text.trim().is_empty() && !self.is_row_of_missing(text);
                if header.restates_side(text) {
                    break;
                }
                if is_blank || text.starts_with(['#', '%']) {
                    continue;
                }
                rows += 1;
                let text = self.delimiter.row(text);
                let ends = self.delimiter.ends(text);
                self.compare_indent(text);
                let unindented = self.unindented.as_mut().map(|reader| &mut reader.last);
                for last in [Some(&mut self.last), unindented].into_iter().flatten() {
                    if *last == LastField::Open && !ends {
                        *last = LastField::Counted;
                    }
                }
            }
        }
        if let Some((_, refused)) = self.unless_indented.take() {
            return Err(refused);
        }
        if self.last == LastField::Open {
            self.drop_last_col()?;
        }
        match header.pixels[0] {
            Some(expected) if expected != rows as u64 => {
                let format = MapFormat::Matrix.name();
                Err(ReadError::Ended { format, what: "rows", expected, found: rows as u64 })
            }
            _ => Ok(rows),
        }
    }

    /// Quantities given neither by the header nor by the caller; `grid_m` are the pixel sides that the text read so far
    /// gives.
    fn missing_quantities(grid_m: [Option<f64>; 2], header: &Header, options: &ReadOptions) -> Vec<NotGiven> {
        let unit = options.height_unit.is_none() && header.value().is_none();
        let pixel = options.pixel_m.is_none() && grid_m.contains(&None);
        let way = NotGiven { what: "pixel size", expected: HOW_TO_GIVE_PIXEL, option: MapOption::Pixel };
        unit.then_some(NO_HEIGHT_UNIT).into_iter().chain(pixel.then_some(way)).collect()
    }

    /// Quantities given neither by the header nor by the caller.
    pub(super) fn missing(header: &Header, options: &ReadOptions) -> Vec<NotGiven> {
        Self::missing_quantities(header.grid_m(1, 1), header, options)
    }

    /// Distances between lines and between the points of a line, in metres, for `rows` lines; refused if rows seem to
    /// be missing.
    fn grid_m(&self, rows: usize, header: &Header) -> Result<[Option<f64>; 2], ReadError> {
        let grid_m = header.grid_m(rows, self.cols);
        // Counts stated in the header were compared already.
        let is_stated = header.pixels[0].is_some() || header.pixel_m.iter().any(Option::is_some);
        let allowed = (SQUARE_TOLERANCE + header.rounding.iter().sum::<f64>()).min(MAX_SQUARE_TOLERANCE);
        match (header.sides_m, grid_m) {
            ([Some(width_m), Some(height_m)], [Some(along_y_m), Some(along_x_m)])
                if !is_stated && log_aspect_ratio([along_y_m, along_x_m]) > allowed =>
            {
                Err(ReadError::Oblong { sides_m: [height_m, width_m], rows, cols: self.cols })
            }
            _ => Ok(grid_m),
        }
    }

    /// Values that the header states, with its sides divided among `rows` rows.
    pub(super) fn stated_values(&self, rows: usize, header: &Header) -> StatedValues {
        // Rows behind a crop are not counted if the pixel size is given.
        let is_counted = self.window.is_whole() || header.pixels[0].is_some();
        let [along_y_m, along_x_m] = header.grid_m(rows, self.cols);
        let along_y_m = along_y_m.filter(|_| is_counted || header.pixel_m[1].is_some());
        StatedValues { pixel_m: [along_x_m, along_y_m], height_unit: header.value(), lateral_unit: None }
    }

    /// The map, with the header's sides divided among `rows` rows, and whether all values read are in it.
    pub(super) fn finish(
        self,
        rows: usize,
        header: &Header,
        options: &ReadOptions,
    ) -> Result<(HeightMap, bool), ReadError> {
        let scale = options.height_unit.map(Scale::from).or(header.value());
        let grid_m = match options.grid_m() {
            Some(grid_m) => grid_m.map(Some),
            None => self.grid_m(rows, header)?,
        };
        let (Some(scale), [Some(along_y_m), Some(along_x_m)]) = (scale, grid_m) else {
            return Err(ReadError::NotGiven { missing: Self::missing_quantities(grid_m, header, options) });
        };
        let finished = self.window.finish_lines([along_y_m, along_x_m], |value| scale.to_metres(value));
        finished.map_err(|error| self.greatest.named(error))
    }
}

/// Magnitude of the natural logarithm of the ratio of a pixel's sides.
fn log_aspect_ratio([dx_m, dy_m]: [f64; 2]) -> f64 {
    (dx_m / dy_m).ln().abs()
}

/// Whether pixels of `dx_m` x `dy_m` count as square for readers of a header that gives the sides of a whole map.
pub(crate) fn is_square(dx_m: f64, dy_m: f64) -> bool {
    log_aspect_ratio([dx_m, dy_m]) <= SQUARE_TOLERANCE
}

/// Error entry for a text without a unit of heights.
pub(super) const NO_HEIGHT_UNIT: NotGiven = NotGiven {
    what: "unit of the heights",
    expected: concat!("a header line such as \"# Value units: um\", or a unit by option: ", unit_names!()),
    option: MapOption::HeightUnit,
};
/// Ways to give the pixel size of a text.
const HOW_TO_GIVE_PIXEL: &str =
    "header lines such as \"# Width: 1 mm\" and \"# Height: 1 mm\", or a pixel size by option";

#[cfg(test)]
mod tests {
    use super::super::GIVEN;
    use crate::topography::{Crop, Decimation, DecimationMethod, ReadOptions, read_map};

    /// Rows of 64 heights below a header that gives the sides.
    fn text(width: &str, height: &str, rows: usize) -> String {
        let row = |i: usize| (0..64).map(|j| format!("{}\t", (i * j) % 7)).collect::<String>() + "\n";
        let rows: String = (0..rows).map(row).collect();
        format!("# Channel: Topography\n# Width: {width}\n# Height: {height}\n# Value units: um\n{rows}")
    }

    fn refused(text: &str, options: &ReadOptions) -> Option<String> {
        read_map(text.as_bytes(), options).err().map(|error| error.to_string())
    }

    #[test]
    fn a_map_that_was_cut_between_two_lines_is_refused_by_its_oblong_pixels() {
        let plain = ReadOptions::default();
        for rows in [3, 24, 60] {
            let said = refused(&text("128.0 um", "128.0 um", rows), &plain).unwrap();
            assert!(said.contains(&format!("{rows} rows and 64 columns")) && said.contains("cut short"), "{said}");
        }
        assert!(refused(&text("128.0 um", "128.0 um", 24), &plain).unwrap().contains("pixels of 2 x 5.33333 um"));
        let said = refused(&text("128.0 um", "64.0 um", 64), &plain).unwrap();
        assert!(
            said.contains("height of 64 um and width of 128 um make pixels of 2 x 1 um, as of lines that"),
            "{said}"
        );
        // A crop does not change this.
        let crop = Crop { first_row: 0, first_col: 0, rows: 8, cols: 8 };
        assert!(refused(&text("128.0 um", "128.0 um", 24), &ReadOptions { crop: Some(crop), ..plain }).is_some());
        // Complete files pass if the sides are rounded or counted from pixel to pixel, and so do sides given by the
        // caller.
        for (width, height) in
            [("128.0 um", "128.0 um"), ("0.128 mm", "1.28e-1 mm"), ("0.13 mm", "0.128 mm"), ("127 um", "128 um")]
        {
            assert_eq!(refused(&text(width, height, 64), &plain), None, "{width} {height}");
        }
        let given = ReadOptions { pixel_m: Some([2e-6, 5.3e-6]), ..plain };
        assert_eq!(refused(&text("128.0 um", "128.0 um", 24), &given), None);
        // For oblong pixels the header may state the number of rows.
        let told = text("128.0 um", "128.0 um", 24).replacen("# Width", "# Rows: 24\n# Width", 1);
        assert_eq!(refused(&told, &plain), None);
        let cut = told.rsplit_once("\n").unwrap().0.rsplit_once("\n").unwrap().0;
        assert_eq!(refused(cut, &plain).unwrap(), "matrix: the rows end after 23 of 24");
    }

    #[test]
    fn an_empty_last_field_is_a_missing_point_and_a_mark_that_ends_all_lines_is_none() {
        let given = ReadOptions { lateral_unit: None, ..GIVEN };
        let map = |text: &str, options| read_map(text.as_bytes(), &options);
        // Compared as text, in which NaN equals NaN.
        let read = |text: &str, options| map(text, options).map(|read| format!("{:?} {}", read.map, read.whole));
        let whole = "1,NaN,3,4,5\nNaN,6,7,8,NaN\n9,10,11,NaN,12\n";
        for mark in [";", "\t", ","] {
            let written = whole.replace(',', mark);
            assert_eq!(map(&written, given).unwrap().map.missing(), 4);
            let expected = read(&written, given);
            let empty = written.replace("NaN", "");
            // Missing at the left edge, in the middle, and at the right edge, also with a delimiter that closes every
            // line.
            let closed = empty.replace('\n', &format!("{mark}\n"));
            for text in [&empty, &closed] {
                assert_eq!(read(text, given), expected, "{text}");
            }
            // The first row may be the one with the missing point.
            let first_hole = format!("1{mark}2{mark}3{mark}4{mark}\n{empty}");
            let expected = map(&format!("1{mark}2{mark}3{mark}4{mark}NaN\n{written}"), given).unwrap().map;
            assert_eq!(read(&first_hole, given), Ok(format!("{expected:?} true")), "{first_hole}");
            // Also in blocks, and if a crop ends before the column is found not to exist.
            let pick = Decimation { factor: 2, method: DecimationMethod::Pick };
            let blocks = ReadOptions { decimation: Some(pick), ..given };
            let joined = expected.transposed().windowed(None, Some(pick)).unwrap().transposed();
            assert_eq!(read(&first_hole, blocks), Ok(format!("{joined:?} false")));
            let crop = ReadOptions { crop: Some(Crop { first_row: 0, first_col: 3, rows: 1, cols: 2 }), ..given };
            assert!(!map(&first_hole, crop).unwrap_err().to_string().contains("crop"), "{mark:?}");
        }
        // Four columns in blocks of four, closed on every line: the delimiter adds no block.
        let four = "1;2;3;4;\n".repeat(8);
        let of_four = |factor| Decimation { factor, method: DecimationMethod::Pick };
        for factor in [1, 2] {
            let options = ReadOptions { decimation: Some(of_four(factor)), ..given };
            let expected = read(&four.replace(";\n", "\n"), options).unwrap();
            assert_eq!(read(&four, options).unwrap(), expected);
        }
        // A short row stays short; a column count in the header decides.
        for (text, said) in [
            ("1;2;3;4\n1;2;3\n", "line 2: 3 values: expected 4"),
            ("1;2;3;4;\n1;2;\n", "expected 4"),
            ("1;2;3;4;\n1;2;3;4;5;\n", "line 2: 5 values: expected 4"),
            ("1;2;3;4;\n1;2;3;\n", "line 2: 3 values: expected 4"),
        ] {
            assert!(read(text, given).unwrap_err().to_string().contains(said), "{text}");
        }
        let told = |count: usize| format!("# File Format = ASCII\n# x-pixels = {count}\n1;2;3;\n4;5;6;\n");
        let missing = [3, 4].map(|count| map(&told(count), given).unwrap().map.missing());
        assert_eq!(missing, [0, 2]);
        // Tabs next to other delimiters are blanks, also at the ends of lines.
        assert_eq!(map("1;\t2;\t3;\t4;\t\n5;\t6;\t7;\t8;\t\n", given).unwrap().map.missing(), 0);
        // A crop of a column that does not exist is refused, not narrowed.
        let crop = |cols| Some(Crop { first_row: 0, first_col: 1, rows: 2, cols });
        let cropped = |cols| read("1;2;3;4;\n5;6;7;8;\n", ReadOptions { crop: crop(cols), ..given });
        assert!(cropped(3).is_ok() && cropped(4).unwrap_err().to_string().contains("the crop takes"));
    }

    #[test]
    fn all_that_is_missing_is_asked_for_at_once() {
        let said = refused("1 2 3 4\n5 6 7 8\n", &ReadOptions::default()).unwrap();
        assert!(
            said.starts_with("the unit of the heights and the pixel size are not known: expected a header"),
            "{said}"
        );
        let said = refused("1;1;1,500\n1;2;1,500\n", &ReadOptions::default()).unwrap();
        for part in [
            "line 1, column 3: \"1,500\"",
            "--decimal-comma",
            "the unit of the heights and the unit of x and y are not known",
        ] {
            assert!(said.contains(part), "{part}: {said}");
        }
        let said = refused("1,500\t1,250\t1\t2\n1,500\t1,250\t1\t2\n", &ReadOptions::default()).unwrap();
        assert!(said.contains("line 1, column 1: \"1,500\"") && said.contains("--decimal-comma"), "{said}");
        let given = ReadOptions { decimal_comma: true, ..ReadOptions::default() };
        assert!(refused("0,0;0,0;1,5\n", &given).unwrap().starts_with("the unit of the heights and the unit of x"));
    }
}
