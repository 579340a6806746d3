use std::fmt;

use crate::topography::MapError;

/// Largest number of points of a map: 16384 x 16384, for which the contact solver takes 10.2 GB at one pressure, and 7.8
/// GB more for each further pressure solved in parallel.
pub const MAX_POINTS: usize = 1 << 28;
/// Range of pixel sides, in metres: wide enough for any surface, narrow enough that squares of slopes stay finite.
const PIXEL_RANGE_M: std::ops::RangeInclusive<f64> = 1e-13..=1e3;
/// Largest magnitude of a height, in metres.
pub(crate) const MAX_HEIGHT_M: f64 = 1e3;
/// Name of a height in errors.
pub(crate) const HEIGHT: &str = "height";

/// Heights on a regular grid: `rows` along x, `cols` along y, row by row, NaN where missing.
///
/// In files that hold lines of heights, such as matrix text, x runs along a line from point to point and y from line to
/// line, as in instrument software; readers and writers transpose such grids. In lists of points x is the file's x.
///
/// `height_m[i * cols + j]` is the height at x = i dx, y = j dy. A pixel is dx by dy; the map's sides are rows dx and
/// cols dy, so that a periodic map repeats after exactly its sides.
#[derive(Clone, PartialEq)]
pub struct HeightMap {
    rows: usize,
    cols: usize,
    dx_m: f64,
    dy_m: f64,
    height_m: Vec<f64>,
}

/// Writes heights as the hexadecimal digits of their bits: the keys of cached results are computed from this text, and
/// decimal digits take twenty times as long.
impl fmt::Debug for HeightMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows, cols, dx_m, dy_m, height_m } = self;
        write!(f, "HeightMap {{ rows: {rows}, cols: {cols}, dx_m: {dx_m:?}, dy_m: {dy_m:?}, height_m:")?;
        height_m.iter().try_for_each(|height| write!(f, " {:016x}", height.to_bits()))?;
        f.write_str(" }")
    }
}

/// Checks that a map may have `rows` x `cols` points.
pub(crate) fn check_grid(rows: usize, cols: usize) -> Result<(), MapError> {
    if rows < 2 || cols < 2 {
        return Err(MapError::TooFewPoints { rows, cols });
    }
    let points = rows as f64 * cols as f64;
    if points > MAX_POINTS as f64 {
        return Err(MapError::TooManyPoints { points, most: MAX_POINTS });
    }
    Ok(())
}

/// Checks that `value`, a side of a pixel in metres, lies in the accepted range.
pub(crate) fn check_pixel(quantity: &'static str, value: f64) -> Result<(), MapError> {
    check_range(quantity, value, PIXEL_RANGE_M, "a length from 1e-13 to 1e3 m")
}

/// Refuses a `value` outside `range`; `expected` describes the range.
pub(crate) fn check_range(
    quantity: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), MapError> {
    if range.contains(&value) { Ok(()) } else { Err(MapError::OutOfRange { quantity, value, expected }) }
}

impl HeightMap {
    /// A map of `rows` x `cols` heights in metres, row by row, NaN where missing. `dx_m` is the distance between rows,
    /// `dy_m` that between columns.
    ///
    /// # Errors
    /// [`MapError`] unless there are at least 2 rows and columns and at most [`MAX_POINTS`] points, as many heights as
    /// the grid has points, at least one height is present, heights lie within 1 km, and pixel sides are between 1e-13
    /// and 1e3 m.
    pub fn new(rows: usize, cols: usize, dx_m: f64, dy_m: f64, height_m: Vec<f64>) -> Result<Self, MapError> {
        check_grid(rows, cols)?;
        check_pixel("pixel size along x", dx_m)?;
        check_pixel("pixel size along y", dy_m)?;
        if height_m.len() != rows * cols {
            return Err(MapError::WrongLength { rows, cols, found: height_m.len() });
        }
        if let Some(&value) = height_m.iter().find(|height| height.abs() > MAX_HEIGHT_M) {
            return Err(MapError::OutOfRange { quantity: HEIGHT, value, expected: "a height within 1e3 m, or NaN" });
        }
        if height_m.iter().all(|height| height.is_nan()) {
            return Err(MapError::NoHeights { points: height_m.len() });
        }
        Ok(Self { rows, cols, dx_m, dy_m, height_m })
    }

    /// Divides the map into `side` x `side` windows of equal size, in row order; a window without heights or with a
    /// single row or column is an error. Rows and columns that do not fill a window are dropped.
    pub(crate) fn in_windows(&self, side: usize) -> impl Iterator<Item = Result<Self, MapError>> + '_ {
        let (rows, cols) = (self.rows / side, self.cols / side);
        (0..side * side).map(move |window| {
            let (first_row, first_col) = (window / side * rows, window % side * cols);
            let lines = self.height_m.chunks_exact(self.cols).skip(first_row).take(rows);
            let heights = lines.flat_map(|line| &line[first_col..first_col + cols]).copied().collect();
            Self::new(rows, cols, self.dx_m, self.dy_m, heights)
        })
    }

    /// Number of points along x.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Number of points along y.
    pub const fn cols(&self) -> usize {
        self.cols
    }

    /// Distance between rows, the pixel's side along x, in metres.
    pub const fn dx_m(&self) -> f64 {
        self.dx_m
    }

    /// Distance between columns, the pixel's side along y, in metres.
    pub const fn dy_m(&self) -> f64 {
        self.dy_m
    }

    /// Heights in metres, row by row, NaN where missing.
    pub fn heights_m(&self) -> &[f64] {
        &self.height_m
    }

    /// Number of missing points.
    pub fn missing(&self) -> usize {
        self.height_m.iter().filter(|height| height.is_nan()).count()
    }

    /// Refuses a map with missing points.
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] with the number of missing points.
    pub fn require_complete(&self) -> Result<(), MapError> {
        match self.missing() {
            0 => Ok(()),
            missing => Err(MapError::MissingPoints { missing, points: self.height_m.len() }),
        }
    }

    /// The same surface with every height multiplied by `factor`.
    ///
    /// # Errors
    /// [`MapError::OutOfRange`] if a height leaves the range of [`HeightMap::new`] or `factor` is not finite.
    pub fn scaled(&self, factor: f64) -> Result<Self, MapError> {
        if !factor.is_finite() {
            return Err(MapError::OutOfRange { quantity: "height factor", value: factor, expected: "a finite number" });
        }
        let height_m = self.height_m.iter().map(|height| height * factor).collect();
        Self::new(self.rows, self.cols, self.dx_m, self.dy_m, height_m)
    }

    /// The same heights with rows and columns exchanged.
    pub(crate) fn transposed(&self) -> Self {
        /// Side of the squares transposed one at a time: both the source and the destination square stay in cache.
        const SQUARE: usize = 32;
        let (rows, cols) = (self.rows, self.cols);
        let mut height_m = vec![0.0; self.height_m.len()];
        for (from, to) in (0..rows).step_by(SQUARE).flat_map(|i| (0..cols).step_by(SQUARE).map(move |j| (i, j))) {
            for i in from..(from + SQUARE).min(rows) {
                for j in to..(to + SQUARE).min(cols) {
                    height_m[j * rows + i] = self.height_m[i * cols + j];
                }
            }
        }
        Self { rows: cols, cols: rows, dx_m: self.dy_m, dy_m: self.dx_m, height_m }
    }

    /// Heights in metres, for operations of this module that keep the map valid.
    pub(crate) fn heights_mut(&mut self) -> &mut [f64] {
        &mut self.height_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl HeightMap {
        /// The map with other heights, in metres, computed from those at each index.
        pub(crate) fn changed(&self, change: impl Fn(usize, f64) -> f64) -> Self {
            let heights = self.height_m.iter().enumerate().map(|(n, &height)| change(n, height)).collect();
            Self::new(self.rows, self.cols, self.dx_m, self.dy_m, heights).unwrap()
        }
    }

    #[test]
    fn maps_that_mean_nothing_are_refused() {
        let flat = |rows, cols, dx, len| HeightMap::new(rows, cols, dx, 1e-6, vec![0.0; len]);
        assert!(matches!(flat(1, 4, 1e-6, 4), Err(MapError::TooFewPoints { rows: 1, cols: 4 })));
        assert!(matches!(flat(2, 2, 1e-6, 5), Err(MapError::WrongLength { found: 5, .. })));
        assert!(matches!(flat(usize::MAX, 2, 1e-6, 4), Err(MapError::TooManyPoints { .. })));
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            assert!(flat(2, 2, bad, 4).unwrap_err().to_string().contains("pixel size along x"));
        }
        let heights = |h: f64| HeightMap::new(2, 2, 1e-6, 1e-6, vec![0.0, h, 0.0, 0.0]);
        assert!(heights(f64::INFINITY).unwrap_err().to_string().contains("height is inf"));
        assert_eq!(heights(f64::NAN).unwrap().missing(), 1);
        assert!(heights(f64::NAN).unwrap().require_complete().unwrap_err().to_string().contains("1 of 4"));
        let nothing = HeightMap::new(2, 2, 1e-6, 1e-6, vec![f64::NAN; 4]);
        assert!(matches!(nothing, Err(MapError::NoHeights { points: 4 })));
    }

    #[test]
    fn a_map_turned_twice_is_the_map() {
        let map = HeightMap::new(37, 70, 1e-6, 2e-6, (0..37 * 70).map(|n| f64::from(n) * 1e-9).collect()).unwrap();
        let turned = map.transposed();
        assert_eq!((turned.rows(), turned.cols(), turned.dx_m(), turned.dy_m()), (70, 37, 2e-6, 1e-6));
        assert!((0..37).all(|i| (0..70).all(|j| turned.heights_m()[j * 37 + i] == map.heights_m()[i * 70 + j])));
        assert_eq!(turned.transposed(), map);
    }

    #[test]
    fn scaling_scales_and_refuses_what_is_no_number() {
        let map = HeightMap::new(2, 2, 1e-6, 1e-6, vec![1e-6, -1e-6, 0.0, f64::NAN]).unwrap();
        let doubled = map.scaled(2.0).unwrap();
        assert_eq!(doubled.heights_m()[..3], [2e-6, -2e-6, 0.0]);
        assert_eq!(doubled.missing(), 1);
        assert!(map.scaled(f64::NAN).is_err() && map.scaled(1e300).is_err());
    }
}
