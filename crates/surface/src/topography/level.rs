use slipgrid_base::monitor::Monitor;

use crate::topography::{HeightMap, MapError};

/// If det(A) divided by the product of A's diagonal is below this value, the points count as lying on one line.
const SMALLEST_DETERMINANT: f64 = 1e-12;

impl HeightMap {
    /// Subtracts the mean height of the points present and returns it, in metres.
    pub fn subtract_mean(&mut self) -> f64 {
        let mean_m = self.mean_m();
        for height in self.heights_mut() {
            *height -= mean_m;
        }
        mean_m
    }

    /// Mean height of the points present, in metres.
    pub fn mean_m(&self) -> f64 {
        let mut present = self.heights_m().iter().filter(|height| !height.is_nan());
        // Sums are relative to one of the heights, so that a constant map has exactly its height as mean.
        let Some(&origin) = present.next() else { return f64::NAN };
        let (mut sum, mut count) = (0.0, 1.0);
        for height in present {
            sum += height - origin;
            count += 1.0;
        }
        origin + sum / count
    }

    /// Subtracts the least-squares plane through the points present.
    ///
    /// # Errors
    /// [`MapError::PlaneUndetermined`] if the points present lie on one line; the map is then unchanged.
    /// [`MapError::Cancelled`] once `monitor` cancels.
    pub fn subtract_plane(&mut self, monitor: &dyn Monitor) -> Result<(), MapError> {
        let cols = self.cols();
        let mut count = 0.0;
        let mut sums = [0.0; 3];
        for (i, row) in self.heights_m().chunks_exact(cols).enumerate() {
            monitor.heed()?;
            for (j, &height) in row.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
                count += 1.0;
                for (sum, value) in sums.iter_mut().zip([i as f64, j as f64, height]) {
                    *sum += value;
                }
            }
        }
        let [i0, j0, mean_m] = sums.map(|sum| sum / count);

        // Normal equations about the centroid, in pixels: [ii ij; ij jj] [a; b] = [ih; jh]
        let (mut ii, mut ij, mut jj, mut ih, mut jh) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (i, row) in self.heights_m().chunks_exact(cols).enumerate() {
            monitor.heed()?;
            for (j, &height) in row.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
                let (i, j, h) = (i as f64 - i0, j as f64 - j0, height - mean_m);
                ii += i * i;
                ij += i * j;
                jj += j * j;
                ih += i * h;
                jh += j * h;
            }
        }
        let determinant = ii * jj - ij * ij;
        if determinant <= SMALLEST_DETERMINANT * ii * jj {
            return Err(MapError::PlaneUndetermined { points: count as usize });
        }
        let a = (ih * jj - jh * ij) / determinant;
        let b = (jh * ii - ih * ij) / determinant;
        monitor.heed()?;
        for (i, row) in self.heights_mut().chunks_exact_mut(cols).enumerate() {
            for (j, height) in row.iter_mut().enumerate() {
                *height -= mean_m + a * (i as f64 - i0) + b * (j as f64 - j0);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn points_on_one_line_have_no_plane() {
        let diagonal = |n: usize| if n / 4 == n % 4 { n as f64 * 1e-6 } else { f64::NAN };
        let mut map = HeightMap::new(4, 4, 1e-6, 1e-6, (0..16).map(diagonal).collect()).unwrap();
        assert_eq!(map.subtract_plane(&Unwatched), Err(MapError::PlaneUndetermined { points: 4 }));
        assert!((map.subtract_mean() - 7.5e-6).abs() < 1e-18);
        assert!(map.mean_m().abs() < 1e-18);
    }
}
