//! Heights as a matrix, one row a line.

use std::io::BufRead;

use super::header::Header;
use super::lines::{Delimiter, Lines, excerpt, expected_height, height};
use super::window::Window;
use super::{MapFormat, ReadOptions};
use crate::{HeightMap, LengthUnit, MapOption, ReadError};

/// Rows read so far, in the text's unit, NaN where missing.
#[derive(Debug)]
pub(super) struct MatrixReader {
    delimiter: Delimiter,
    cols: usize,
    row: Vec<f64>,
    window: Window,
}

impl MatrixReader {
    /// A reader of rows like `first`, on line `line`.
    pub(super) fn new(first: &str, line: usize, header: &Header, options: &ReadOptions) -> Result<Self, ReadError> {
        let delimiter = Delimiter::of(first);
        let cols = delimiter.fields(first).count();
        if let Some(expected) = header.pixels[1].filter(|&expected| expected != cols as u64) {
            let expected = usize::try_from(expected).unwrap_or(usize::MAX);
            return Err(ReadError::RowLength { line, found: cols, expected });
        }
        let window = Window::new(None, cols as u64, options.crop, options.decimation)?;
        Ok(Self { delimiter, cols, row: Vec::new(), window })
    }

    pub(super) fn push(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        self.row.clear();
        for (n, field) in self.delimiter.fields(text).enumerate() {
            let value = height(field).ok_or_else(|| ReadError::NotANumber {
                line,
                column: n + 1,
                value: excerpt(field),
                expected: expected_height(field),
            })?;
            self.row.push(value.unwrap_or(f64::NAN));
        }
        if self.row.len() != self.cols {
            return Err(ReadError::RowLength { line, found: self.row.len(), expected: self.cols });
        }
        self.window.push(&self.row)
    }

    /// Whether all rows asked for have been read.
    pub(super) fn is_full(&self) -> bool {
        self.window.is_full()
    }

    /// Whether all values read are in the map.
    pub(super) fn is_whole(&self) -> bool {
        self.window.is_whole()
    }

    /// Rows of the whole text: those read and, if the header's sides must be shared among all or their number is
    /// known, those to come.
    pub(super) fn count_rest(
        &self,
        lines: &mut Lines<impl BufRead>,
        options: &ReadOptions,
        header: &Header,
    ) -> Result<usize, ReadError> {
        let mut rows = self.window.rows_seen();
        if (options.pixel_m.is_none() && header.height_m.is_some()) || header.pixels[0].is_some() {
            while let Some(text) = lines.next()? {
                rows += usize::from(!text.is_empty() && !text.starts_with(['#', '%']));
            }
        }
        match header.pixels[0] {
            Some(expected) if expected != rows as u64 => {
                let format = MapFormat::Matrix.name();
                Err(ReadError::Ended { format, what: "rows", expected, found: rows as u64 })
            }
            _ => Ok(rows),
        }
    }

    /// The map, on pixels that share the header's sides among `rows` rows.
    pub(super) fn finish(self, rows: usize, header: &Header, options: &ReadOptions) -> Result<HeightMap, ReadError> {
        let (unit, factor) = match (options.height_unit.or(header.value_unit), header.value_nm) {
            (Some(unit), _) => (unit, 1.0),
            (None, Some(value_nm)) => (LengthUnit::Nanometre, value_nm),
            (None, None) => {
                return Err(ReadError::NotGiven {
                    what: "unit of the heights",
                    expected: HOW_TO_GIVE_HEIGHT_UNIT,
                    option: MapOption::HeightUnit,
                });
            }
        };
        let pixel_m = match (options.pixel_m, header.height_m, header.width_m) {
            (Some(pixel_m), _, _) => pixel_m,
            (None, Some(height_m), Some(width_m)) => [height_m / rows as f64, width_m / self.cols as f64],
            (None, _, _) => {
                return Err(ReadError::NotGiven {
                    what: "pixel size",
                    expected: HOW_TO_GIVE_PIXEL,
                    option: MapOption::Pixel,
                });
            }
        };
        self.window.finish(pixel_m, |value| unit.to_metres(factor * value))
    }
}

/// How a text without a unit of its heights can be read.
pub(super) const HOW_TO_GIVE_HEIGHT_UNIT: &str =
    "a header line such as \"# Value units: um\", or a unit by option: m, cm, mm, um, nm, pm";
/// How a text without a pixel size can be read.
pub(super) const HOW_TO_GIVE_PIXEL: &str =
    "header lines such as \"# Width: 1 mm\" and \"# Height: 1 mm\", or a pixel size by option";
