//! Surface parameters, most of them of ISO 25178-2. The form is not removed here; remove it first.

mod height;
mod hybrid;
mod material_ratio;
mod spatial;
mod spectrum;

pub use height::HeightParameters;
pub use material_ratio::{CoreParameters, MaterialRatioCurve};
pub use spatial::{CorrelationLengths, Sides};
pub use spectrum::{LIMITED_BY_PIXELS, ShortWaves, SpectrumBin};

use slipgrid_base::monitor::Monitor;

use crate::topography::fourier::Fourier;
use crate::topography::{HeightMap, MapError};

impl HeightMap {
    /// Sa, the arithmetical mean height: mean of |h - mean h| over the points present, in metres.
    pub fn sa_m(&self) -> f64 {
        self.mean_deviation(f64::abs)
    }

    /// Sq, the root mean square height: sqrt(mean of (h - mean h)^2) over the points present, in metres.
    pub fn sq_m(&self) -> f64 {
        self.mean_deviation(|deviation| deviation * deviation).sqrt()
    }

    /// Mean of `of`(h - mean h) over the points present.
    fn mean_deviation(&self, of: impl Fn(f64) -> f64) -> f64 {
        let mean_m = self.mean_m();
        let (mut sum, mut present) = (0.0, 0.0);
        for height in self.heights_m().iter().filter(|height| !height.is_nan()) {
            sum += of(height - mean_m);
            present += 1.0;
        }
        sum / present
    }

    /// Spectral rms slope of the map taken as one period: sqrt(sum over waves of |q|^2 |h_q|^2), with h_q the Fourier
    /// coefficients. This is h'rms of contact theories, and exact for a band-limited map.
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] unless the map is complete; [`MapError::Cancelled`] once `monitor` cancels.
    pub fn rms_slope_spectral(&self, monitor: &dyn Monitor) -> Result<f64, MapError> {
        self.require_complete()?;
        let mean_m = self.mean_m();
        monitor.heed()?;
        let deviation: Vec<f64> = self.heights_m().iter().map(|height| height - mean_m).collect();
        monitor.heed()?;
        let fourier = Fourier::new(self.rows(), self.cols());
        // h'rms^2 = mean of |grad h|^2 = sum |q|^2 |h_q|^2 (Parseval), h_q = (1/N) sum h exp(-i q x) over N points
        let (mut sum, points) = (0.0, self.rows() as f64 * self.cols() as f64);
        let add = |q: f64, twins: f64, square: f64| sum += twins * (q * q) * square;
        fourier.visit_waves(&deviation, [self.dx_m(), self.dy_m()], add, monitor)?;
        Ok((sum / (points * points)).sqrt())
    }

    /// Finite-difference rms slope, sqrt(mean (dh/dx)^2 + mean (dh/dy)^2), with forward differences between neighbours
    /// that are both present; the map is not continued past its sides. It is below the spectral slope if waves are only
    /// a few pixels long, and is not affected by the step between opposite sides of a measured map. An axis without
    /// pairs of neighbours contributes zero.
    pub fn rms_slope_finite_difference(&self) -> f64 {
        let (heights, cols) = (self.heights_m(), self.cols());
        let along_x = heights.iter().zip(&heights[cols..]).map(|(here, next)| next - here);
        let along_y = heights.chunks_exact(cols).flat_map(|row| row.windows(2)).map(|pair| pair[1] - pair[0]);
        (mean_square(along_x) / (self.dx_m() * self.dx_m()) + mean_square(along_y) / (self.dy_m() * self.dy_m())).sqrt()
    }

    /// [`Self::rms_slope_finite_difference`] with its relative standard error, from the scatter of the logarithms of
    /// the slopes of `side` x `side` windows; the error is `None` if fewer than two windows have a slope.
    pub fn windowed_slope(&self, side: usize) -> (f64, Option<f64>) {
        let slopes = self.in_windows(side).flatten().map(|window| window.rms_slope_finite_difference());
        let logs: Vec<f64> = slopes.filter(|slope| *slope > 0.0).map(libm::log).collect();
        let std = slipgrid_base::statistics::mean_and_std(logs.iter().copied()).and_then(|(_, std)| std);
        (self.rms_slope_finite_difference(), std.map(|std| std / (logs.len() as f64).sqrt()))
    }
}

/// Mean of the squares of the `steps` between points that are present; 0 without any.
fn mean_square(steps: impl Iterator<Item = f64>) -> f64 {
    let known = steps.filter(|step| !step.is_nan());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), step| (sum + step * step, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use slipgrid_base::monitor::Unwatched;

    /// amplitude cos(2 pi 3 x / Lx) on 64 x 40 pixels of 1 um x 2 um.
    fn wave(amplitude_m: f64) -> HeightMap {
        let height = |n: usize| amplitude_m * (TAU * 3.0 * (n / 40) as f64 / 64.0).cos();
        HeightMap::new(64, 40, 1e-6, 2e-6, (0..64 * 40).map(height).collect()).unwrap()
    }

    #[test]
    fn parameters_of_a_wave_are_the_textbook_ones() {
        let map = wave(1e-6);
        // Sa = 2 a / pi (in the limit of many points), Sq = a / sqrt 2, slope = q a / sqrt 2
        assert!((map.sa_m() - 2e-6 / PI).abs() < 2e-9);
        assert!((map.sq_m() - 1e-6 / 2f64.sqrt()).abs() < 1e-15);
        let slope = TAU * 3.0 / 64e-6 * 1e-6 / 2f64.sqrt();
        assert!((map.rms_slope_spectral(&Unwatched).unwrap() / slope - 1.0).abs() < 1e-12);
        // Forward differences replace q by (2/dx) sin(q dx/2), 0.36 % less here. The 63 steps inside the map are not a
        // whole number of periods, which changes the mean square by up to 1/63.
        let seen = (TAU * 1.5 / 64.0).sin() / (TAU * 1.5 / 64.0);
        assert!((map.rms_slope_finite_difference() / (slope * seen) - 1.0).abs() < 0.008);
    }

    #[test]
    fn a_flat_map_has_no_roughness_and_a_hole_no_spectrum() {
        let flat = HeightMap::new(4, 4, 1e-6, 1e-6, vec![5e-6; 16]).unwrap();
        assert_eq!((flat.sa_m(), flat.sq_m()), (0.0, 0.0));
        assert_eq!((flat.rms_slope_spectral(&Unwatched), flat.rms_slope_finite_difference()), (Ok(0.0), 0.0));
        let mut heights = vec![1e-6; 16];
        heights[3] = f64::NAN;
        let holed = HeightMap::new(4, 4, 1e-6, 1e-6, heights).unwrap();
        assert_eq!(holed.sq_m(), 0.0);
        assert!(matches!(
            holed.rms_slope_spectral(&Unwatched),
            Err(MapError::MissingPoints { missing: 1, points: 16 })
        ));
    }
}
