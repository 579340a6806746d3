//! Heights as a matrix, one row a line.

use crate::header::Header;
use crate::lines::{Delimiter, excerpt, height};
use crate::map::MOST_POINTS;
use crate::read::ReadOptions;
use crate::{HeightMap, MapError, ReadError};

/// Rows read so far, in the text's unit, NaN where missing.
#[derive(Debug, Default)]
pub(crate) struct MatrixReader {
    delimiter: Option<Delimiter>,
    rows: usize,
    cols: usize,
    height: Vec<f64>,
}

impl MatrixReader {
    pub(crate) fn push(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        let delimiter = *self.delimiter.get_or_insert_with(|| Delimiter::of(text));
        let before = self.height.len();
        for (n, field) in delimiter.fields(text).enumerate() {
            let value = height(field).ok_or_else(|| ReadError::NotANumber {
                line,
                column: n + 1,
                value: excerpt(field),
                expected: "a height with a decimal point, or NaN, BAD, --- where it is missing",
            })?;
            if self.height.len() == MOST_POINTS {
                let points = self.height.len() as f64 + 1.0;
                return Err(MapError::TooManyPoints { points, most: MOST_POINTS }.into());
            }
            self.height.push(value.unwrap_or(f64::NAN));
        }
        let found = self.height.len() - before;
        if self.rows == 0 {
            self.cols = found;
        } else if found != self.cols {
            return Err(ReadError::RowLength { line, found, expected: self.cols });
        }
        self.rows += 1;
        Ok(())
    }

    pub(crate) fn finish(self, header: &Header, options: &ReadOptions) -> Result<HeightMap, ReadError> {
        let unit = options
            .height_unit
            .or(header.value_unit)
            .ok_or(ReadError::NotGiven { what: "unit of the heights", expected: HOW_TO_GIVE_HEIGHT_UNIT })?;
        let pixel_m = match (options.pixel_m, header.height_m, header.width_m) {
            (Some(pixel_m), _, _) => pixel_m,
            (None, Some(height_m), Some(width_m)) => [height_m / self.rows as f64, width_m / self.cols as f64],
            (None, _, _) => {
                return Err(ReadError::NotGiven {
                    what: "pixel size",
                    expected: "header lines such as \"# Width: 1 mm\" and \"# Height: 1 mm\", or a pixel size by option",
                });
            }
        };
        let mut height_m = self.height;
        for value in &mut height_m {
            *value = unit.to_metres(*value);
        }
        Ok(HeightMap::new(self.rows, self.cols, pixel_m[0], pixel_m[1], height_m)?)
    }
}

/// How a text without a unit of its heights can be read.
pub(crate) const HOW_TO_GIVE_HEIGHT_UNIT: &str =
    "a header line such as \"# Value units: um\", or a unit by option: m, cm, mm, um, nm, pm";
