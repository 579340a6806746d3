//! Hybrid parameters of ISO 25178-2, clause 4.3: slopes and developed area, from neighbouring heights.

use slipgrid_base::monitor::{Cancelled, Monitor};

use crate::topography::HeightMap;

impl HeightMap {
    /// Sdr, the developed interfacial area ratio: the area of the surface relative to its projection, minus 1, over the
    /// cells between four points that are present. Zero if there is no such cell.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn sdr(&self, monitor: &dyn Monitor) -> Result<f64, Cancelled> {
        let (cols, dx, dy) = (self.cols(), self.dx_m(), self.dy_m());
        let (mut developed, mut cells) = (0.0, 0.0);
        for pair in self.heights_m().windows(2 * cols).step_by(cols) {
            monitor.heed()?;
            let (here, next) = pair.split_at(cols);
            for (a, b) in here.windows(2).zip(next.windows(2)) {
                // Corners: a[0] at (0, 0), a[1] at (0, dy), b[0] at (dx, 0), b[1] at (dx, dy). A triangle with slopes p
                // and q has the area sqrt(1 + p^2 + q^2) dx dy/2. The area of the cell is the mean over the two
                // diagonals that can divide it.
                let triangle =
                    |along_x: f64, along_y: f64| (1.0 + (along_x / dx).powi(2) + (along_y / dy).powi(2)).sqrt();
                let area = triangle(b[0] - a[0], a[1] - a[0])
                    + triangle(b[1] - a[1], b[1] - b[0])
                    + triangle(b[0] - a[0], b[1] - b[0])
                    + triangle(b[1] - a[1], a[1] - a[0]);
                if !area.is_nan() {
                    developed += area / 4.0 - 1.0;
                    cells += 1.0;
                }
            }
        }
        // Sdr = (sum of areas - projected area) / projected area
        Ok(if cells > 0.0 { developed / cells } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn a_plane_and_a_triangular_wave_are_exact() {
        let plane = |n: usize| 0.3 * (n / 7) as f64 * 1e-6 - 0.4 * (n % 7) as f64 * 2e-6;
        let plane = HeightMap::new(9, 7, 1e-6, 2e-6, (0..63).map(plane).collect()).unwrap();
        assert!((plane.rms_slope_finite_difference() - 0.5).abs() < 1e-12);
        assert!((plane.sdr(&Unwatched).unwrap() - (1.25_f64.sqrt() - 1.0)).abs() < 1e-12);
        let wave = |n: usize| 0.75e-6 * (((n / 7) % 8) as f64 - 4.0).abs();
        let wave = HeightMap::new(17, 7, 1e-6, 2e-6, (0..119).map(wave).collect()).unwrap();
        assert!(
            (wave.rms_slope_finite_difference() - 0.75).abs() < 1e-12
                && (wave.sdr(&Unwatched).unwrap() - 0.25).abs() < 1e-12
        );
    }

    #[test]
    fn the_developed_area_of_a_sinusoid_converges_with_the_square_of_the_pixel() {
        // For a small slope s = q a: Sdr = s^2/4 - 3 s^4/64 + 5 s^6/512 (series of the elliptic integral).
        let slope: f64 = 0.3;
        let exact = slope.powi(2) / 4.0 - 3.0 * slope.powi(4) / 64.0 + 5.0 * slope.powi(6) / 256.0;
        let error = |pixels: usize| {
            let q = std::f64::consts::TAU / pixels as f64;
            let height = |n: usize| slope / q * (q * (n / 2) as f64).cos() * 1e-6;
            let map = HeightMap::new(pixels + 1, 2, 1e-6, 1e-6, (0..2 * (pixels + 1)).map(height).collect()).unwrap();
            map.sdr(&Unwatched).unwrap() - exact
        };
        let (coarse, fine) = (error(32), error(64));
        assert!(fine.abs() < 1e-4 * exact * 10.0, "{fine}");
        let order = (coarse / fine).abs().log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}: {coarse} {fine}");
    }

    #[test]
    fn cells_with_a_missing_corner_are_left_out() {
        let mut heights: Vec<f64> = (0..63).map(|n| 0.75e-6 * (n / 7) as f64).collect();
        heights[10] = f64::NAN;
        let map = HeightMap::new(9, 7, 1e-6, 2e-6, heights).unwrap();
        assert!((map.sdr(&Unwatched).unwrap() - 0.25).abs() < 1e-12);
        let holes = HeightMap::new(2, 2, 1.0, 1.0, vec![f64::NAN, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(holes.sdr(&Unwatched).unwrap(), 0.0);
    }
}
