//! The part of a file's grid that is kept: a rectangle, and in it every pixel or blocks of pixels.

use crate::topography::map::MAX_POINTS;
use crate::topography::{HeightMap, MapError, ReadError};

/// A rectangle of pixels of the file's grid; row and column indices start at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Crop {
    /// First row kept.
    pub first_row: usize,
    /// First column kept.
    pub first_col: usize,
    /// Number of rows kept.
    pub rows: usize,
    /// Number of columns kept.
    pub cols: usize,
}

impl Crop {
    /// The same rectangle in a file whose lines are the columns of this file.
    pub(super) const fn transposed(self) -> Self {
        Self { first_row: self.first_col, first_col: self.first_row, rows: self.cols, cols: self.rows }
    }
}

/// Reduction of a block of pixels to one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DecimationMethod {
    /// Mean of the heights present, missing if fewer than half are present: corresponds to a coarser instrument.
    #[default]
    Mean,
    /// First height of the block: keeps the distribution of heights, but aliases short waves to long ones.
    Pick,
}

slipgrid_base::names!(DecimationMethod { Mean = "mean", Pick = "pick" });

/// Reduces blocks of `factor` x `factor` pixels to one pixel. Rows and columns left over at the end are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Decimation {
    /// Pixels along each side of a block, at least 1.
    pub factor: usize,
    /// Reduction of a block to one height.
    pub method: DecimationMethod,
}

/// Receives the heights of a file row by row and keeps only the part requested.
#[derive(Debug)]
pub(crate) struct Window {
    /// Number of rows of the file, if known before reading.
    file_rows: Option<usize>,
    /// Number of columns of the file.
    file_cols: usize,
    /// Rows kept: first index, and one past the last.
    rows: [usize; 2],
    /// Columns kept: first index, and one past the last.
    cols: [usize; 2],
    decimation: Decimation,
    /// Row of the next height in the file.
    row: usize,
    /// Column of the next height in the file.
    col: usize,
    /// Sum and number of the heights of each decimation block in the current rows.
    block: Vec<(f64, u32)>,
    /// Number of rows added to the current blocks.
    block_rows: usize,
    height: Vec<f64>,
}

impl Window {
    /// A window on a grid with `file_cols` columns and, if known, `file_rows` rows.
    pub(crate) fn new(
        file_rows: Option<u64>,
        file_cols: u64,
        crop: Option<Crop>,
        decimation: Option<Decimation>,
    ) -> Result<Self, ReadError> {
        let decimation = decimation.unwrap_or(Decimation { factor: 1, method: DecimationMethod::Mean });
        if decimation.factor == 0 {
            let (quantity, expected) = ("decimation factor", "a whole number from 1 up");
            return Err(MapError::OutOfRange { quantity, value: 0.0, expected }.into());
        }
        if file_cols == 0 {
            return Err(MapError::TooFewPoints { rows: file_rows.map_or(0, |rows| rows as usize), cols: 0 }.into());
        }
        let crop_ends = |axis, first: usize, count: usize, available: Option<u64>| {
            let end = first.saturating_add(count);
            match available {
                Some(available) if end as u64 > available => Err(outside(axis, first, count, available)),
                _ => Ok([first, end]),
            }
        };
        let counted = |count: u64| usize::try_from(count).unwrap_or(usize::MAX);
        let (rows, cols) = match crop {
            Some(crop) => (
                crop_ends("rows", crop.first_row, crop.rows, file_rows)?,
                crop_ends("columns", crop.first_col, crop.cols, Some(file_cols))?,
            ),
            None => ([0, usize::MAX], [0, counted(file_cols)]),
        };
        let window = Self {
            file_rows: file_rows.map(counted),
            file_cols: counted(file_cols),
            rows,
            cols,
            decimation,
            row: 0,
            col: 0,
            block: Vec::new(),
            block_rows: 0,
            height: Vec::new(),
        };
        // A size above the limit is refused before the data are read.
        if let Some(file_rows) = window.file_rows {
            let kept = (rows[1].min(file_rows).saturating_sub(rows[0]) / decimation.factor) as f64;
            check_points(kept * window.kept_cols() as f64)?;
        }
        Ok(window)
    }

    /// Number of columns kept.
    fn kept_cols(&self) -> usize {
        (self.cols[1] - self.cols[0]) / self.decimation.factor
    }

    /// Whether all requested rows have been received.
    pub(crate) fn is_full(&self) -> bool {
        self.row >= self.rows[1]
    }

    /// Whether every pixel of the file is in the map. Reading with a crop ends before the number of rows is known,
    /// unless the file states it; the map then counts as a part.
    pub(crate) fn is_whole(&self) -> bool {
        let Decimation { factor, .. } = self.decimation;
        let rows = self.file_rows.unwrap_or(if self.rows[1] == usize::MAX { self.row } else { usize::MAX });
        let whole = |kept: [usize; 2], count: usize| kept[0] == 0 && kept[1] >= count && count.is_multiple_of(factor);
        whole(self.rows, rows) && whole(self.cols, self.file_cols)
    }

    /// Whether the last column of the file is kept.
    pub(crate) const fn takes_last_col(&self) -> bool {
        self.cols[1] == self.file_cols
    }

    /// Number of rows received so far.
    pub(crate) fn rows_seen(&self) -> usize {
        self.row
    }

    /// Removes the last column of the file, if it holds no height.
    pub(crate) fn drop_last_col(&mut self) -> Result<(), ReadError> {
        let kept = self.kept_cols();
        self.file_cols -= 1;
        let [first, end] = self.cols;
        if end <= self.file_cols {
            return Ok(());
        }
        // Only a crop limits the columns; without a crop the map has all columns of the file.
        if self.rows[1] != usize::MAX {
            return Err(outside("columns", first, end - first, self.file_cols as u64));
        }
        self.cols[1] = self.file_cols;
        let left = self.kept_cols();
        if left < kept {
            self.block.truncate(left);
            let mut place = 0;
            self.height.retain(|_| {
                place += 1;
                (place - 1) % kept < left
            });
        }
        Ok(())
    }

    /// Adds the next heights in the order of the file, any number of them, NaN where missing.
    pub(crate) fn push(&mut self, mut heights: &[f64]) -> Result<(), ReadError> {
        while !heights.is_empty() {
            let (part, rest) = heights.split_at(heights.len().min(self.file_cols - self.col));
            if (self.rows[0]..self.rows[1]).contains(&self.row) {
                let from = self.cols[0].clamp(self.col, self.col + part.len()) - self.col;
                let to = self.cols[1].clamp(self.col, self.col + part.len()) - self.col;
                if from < to {
                    self.take(self.col + from - self.cols[0], &part[from..to])?;
                }
            }
            self.col += part.len();
            heights = rest;
            if self.col == self.file_cols {
                self.end_row()?;
            }
        }
        Ok(())
    }

    /// Adds kept heights, the first of them in kept column `first`.
    fn take(&mut self, first: usize, heights: &[f64]) -> Result<(), ReadError> {
        let Decimation { factor, method } = self.decimation;
        if factor == 1 {
            check_points((self.height.len() + heights.len()) as f64)?;
            self.height.extend_from_slice(heights);
            return Ok(());
        }
        // Columns left over at the end do not form a block.
        let whole = self.kept_cols() * factor;
        for (col, &height) in (first..whole).zip(heights) {
            let block = col / factor;
            if block >= self.block.len() {
                check_points((self.height.len() + block + 1) as f64)?;
                self.block.resize(block + 1, (0.0, 0));
            }
            let counted = match method {
                DecimationMethod::Mean => !height.is_nan(),
                DecimationMethod::Pick => self.block_rows == 0 && col % factor == 0 && !height.is_nan(),
            };
            if counted {
                self.block[block].0 += height;
                self.block[block].1 += 1;
            }
        }
        Ok(())
    }

    fn end_row(&mut self) -> Result<(), ReadError> {
        let Decimation { factor, method } = self.decimation;
        if (self.rows[0]..self.rows[1]).contains(&self.row) && factor > 1 {
            self.block_rows += 1;
            if self.block_rows == factor {
                // If fewer than half of the heights of a block are present, its mean is not representative.
                let least = match method {
                    DecimationMethod::Mean => (factor * factor).div_ceil(2),
                    DecimationMethod::Pick => 1,
                };
                check_points((self.height.len() + self.block.len()) as f64)?;
                let of_block = |&(sum, count): &(f64, u32)| {
                    if (count as usize) < least { f64::NAN } else { sum / f64::from(count) }
                };
                self.height.extend(self.block.iter().map(of_block));
                self.block.fill((0.0, 0));
                self.block_rows = 0;
            }
        }
        self.row += 1;
        self.col = 0;
        Ok(())
    }

    /// The map of a file of lines of heights: points of a line follow each other along x, lines along y. Heights are
    /// converted by `to_metres`, which must be linear; `pixel_m` are the distances between lines and between the points
    /// of a line, before decimation. Also returns whether every pixel of the file is in the map.
    pub(crate) fn finish_lines(
        self,
        pixel_m: [f64; 2],
        to_metres: impl Fn(f64) -> f64,
    ) -> Result<(HeightMap, bool), ReadError> {
        let (map, whole) = self.finish(pixel_m, to_metres)?;
        Ok((map.transposed(), whole))
    }

    /// The map in the order received. Heights are converted by `to_metres`, which must be linear; `pixel_m` are the
    /// distances between rows and between columns, before decimation. Also returns whether every pixel of the file is
    /// in the map.
    pub(crate) fn finish(
        mut self,
        pixel_m: [f64; 2],
        to_metres: impl Fn(f64) -> f64,
    ) -> Result<(HeightMap, bool), ReadError> {
        if self.rows[1] != usize::MAX && self.row < self.rows[1] {
            return Err(outside("rows", self.rows[0], self.rows[1] - self.rows[0], self.row as u64));
        }
        for height in &mut self.height {
            *height = to_metres(*height);
        }
        let (cols, factor, whole) = (self.kept_cols(), self.decimation.factor as f64, self.is_whole());
        let rows = self.height.len().checked_div(cols).unwrap_or(0);
        Ok((HeightMap::new(rows, cols, pixel_m[0] * factor, pixel_m[1] * factor, self.height)?, whole))
    }
}

/// Error for a crop of `count` rows or columns from `first` on, which reaches beyond the `available` ones.
fn outside(axis: &str, first: usize, count: usize, available: u64) -> ReadError {
    let last = first.saturating_add(count.saturating_sub(1));
    ReadError::Refused(format!("the crop takes {axis} {first} to {last}: the file has {available} {axis}, from 0"))
}

fn check_points(points: f64) -> Result<(), MapError> {
    if points > MAX_POINTS as f64 {
        return Err(MapError::TooManyPoints { points, most: MAX_POINTS });
    }
    Ok(())
}

impl HeightMap {
    /// A part of the map, or a coarser map, as [`read_map`](crate::topography::read_map) would have kept it; the rows of the crop
    /// are those of the map.
    ///
    /// # Errors
    /// [`ReadError`] if the crop lies outside the map, or no point is left.
    pub fn windowed(&self, crop: Option<Crop>, decimation: Option<Decimation>) -> Result<Self, ReadError> {
        let window = self.window(crop, decimation)?;
        window.finish([self.dx_m(), self.dy_m()], |height| height).map(|(map, _)| map)
    }

    fn window(&self, crop: Option<Crop>, decimation: Option<Decimation>) -> Result<Window, ReadError> {
        let mut window = Window::new(Some(self.rows() as u64), self.cols() as u64, crop, decimation)?;
        window.push(self.heights_m())?;
        Ok(window)
    }
}

/// Crops and decimates a map in memory; also returns whether every pixel of the map is in the result.
pub(super) fn window_of(
    map: HeightMap,
    crop: Option<Crop>,
    decimation: Option<Decimation>,
) -> Result<(HeightMap, bool), ReadError> {
    if crop.is_none() && decimation.is_none_or(|decimation| decimation.factor == 1) {
        return Ok((map, true));
    }
    // Rows of a crop are lines, as in files of lines of heights.
    let lines = map.transposed();
    lines.window(crop, decimation)?.finish_lines([lines.dx_m(), lines.dy_m()], |height| height)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of 7 x 10 heights 10 i + j, pushed in pieces of `piece`.
    fn windowed(crop: Option<Crop>, decimation: Option<Decimation>, piece: usize) -> Result<HeightMap, ReadError> {
        let heights: Vec<f64> = (0..70).map(f64::from).collect();
        let mut window = Window::new(Some(7), 10, crop, decimation)?;
        for part in heights.chunks(piece) {
            window.push(part)?;
        }
        window.finish([1e-6, 2e-6], |height| height * 1e-9).map(|(map, _)| map)
    }

    #[test]
    fn a_part_is_not_the_whole() {
        let pushed = |known: Option<u64>, rows: usize, crop, factor| {
            let decimation = Some(Decimation { factor, method: DecimationMethod::Pick });
            let mut window = Window::new(known, 10, crop, decimation).unwrap();
            for _ in 0..rows {
                if !window.is_full() {
                    window.push(&[0.0; 10]).unwrap();
                }
            }
            window.is_whole()
        };
        let whole = |rows: usize, crop, factor| pushed(Some(rows as u64), rows, crop, factor);
        assert!(whole(6, None, 1) && whole(6, None, 2));
        assert!(!whole(7, None, 2) && !whole(6, None, 3));
        let crop = |first_row, cols| Some(Crop { first_row, first_col: 0, rows: 6 - first_row, cols });
        assert!(pushed(None, 6, None, 2) && !pushed(None, 7, None, 2) && !pushed(None, 9, crop(0, 10), 1));
        assert!(
            whole(6, crop(0, 10), 1)
                && !whole(9, crop(0, 10), 1)
                && !whole(6, crop(1, 10), 1)
                && !whole(6, crop(0, 9), 1)
        );
    }

    #[test]
    fn a_rectangle_is_kept_whatever_the_pieces() {
        let crop = Crop { first_row: 2, first_col: 3, rows: 4, cols: 5 };
        for piece in [1, 3, 10, 17, 70] {
            let map = windowed(Some(crop), None, piece).unwrap();
            assert_eq!((map.rows(), map.cols(), map.dx_m(), map.dy_m()), (4, 5, 1e-6, 2e-6));
            assert_eq!((map.heights_m()[0], map.heights_m()[19]), (23e-9, 57e-9));
        }
    }

    #[test]
    fn blocks_become_their_mean_or_their_first_height() {
        let by = |method| Some(Decimation { factor: 3, method });
        for piece in [1, 4, 70] {
            let mean = windowed(None, by(DecimationMethod::Mean), piece).unwrap();
            // Mean of rows 0..3 and columns 0..3: 10 + 1.
            assert_eq!((mean.rows(), mean.cols(), mean.dx_m()), (2, 3, 3e-6));
            assert!((mean.heights_m()[0] - 11e-9).abs() < 1e-21);
            let pick = windowed(None, by(DecimationMethod::Pick), piece).unwrap();
            assert!((pick.heights_m()[4] - 33e-9).abs() < 1e-21);
        }
    }

    #[test]
    fn a_block_needs_half_of_its_heights() {
        let nan = f64::NAN;
        let mut window =
            Window::new(Some(4), 4, None, Some(Decimation { factor: 2, method: DecimationMethod::Mean })).unwrap();
        window.push(&[1.0, nan, nan, nan, nan, 3.0, nan, 8.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0]).unwrap();
        let (map, _) = window.finish([1.0, 1.0], |height| height).unwrap();
        assert_eq!(map.heights_m()[0], 2.0);
        assert!(map.heights_m()[1].is_nan());
        assert_eq!(map.heights_m()[2..], [1.0, 2.0]);
    }

    #[test]
    fn what_lies_outside_or_is_too_much_is_refused_first() {
        let outside = Crop { first_row: 5, first_col: 0, rows: 3, cols: 10 };
        let message = windowed(Some(outside), None, 70).unwrap_err().to_string();
        assert!(message.contains("rows 5 to 7") && message.contains("7 rows"), "{message}");
        let endless = Crop { first_row: usize::MAX, first_col: 0, rows: usize::MAX, cols: 1 };
        assert!(windowed(Some(endless), None, 70).is_err());
        assert!(Window::new(Some(u64::MAX), u64::MAX, None, None).is_err());
        assert!(Window::new(None, 0, None, None).is_err());
        assert!(Window::new(Some(5), 5, None, Some(Decimation { factor: 0, method: DecimationMethod::Mean })).is_err());
    }
}
