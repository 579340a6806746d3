//! Spatial parameters of ISO 25178-2, clause 4.2: autocorrelation length Sal and texture aspect ratio Str.

use std::f64::consts::PI;

use slipgrid_base::monitor::Monitor;

use crate::topography::fourier::Fourier;
use crate::topography::{Decimation, DecimationMethod, HeightMap, MapError};

/// Number of directions, over half a turn, in which the decay of the autocorrelation is followed.
const DIRECTIONS: usize = 720;
/// Steps per pixel along a direction.
const STEPS_PER_PIXEL: f64 = 4.0;
/// Largest number of points whose autocorrelation is computed directly; larger maps are first averaged in blocks.
const MAX_CORRELATED: usize = 1 << 23;

/// Autocorrelation lengths of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrelationLengths {
    /// Sal, the smallest distance at which the autocorrelation falls to 0.2 of its value at zero distance, in metres;
    /// `None` if it does not fall so far within half the map in any direction.
    pub sal_m: Option<f64>,
    /// Str, 1 for an isotropic surface: Sal over the largest distance in any direction at which the autocorrelation
    /// first falls to 0.2 of its value at zero distance; `None` if it does not fall so far within half the map in some
    /// direction.
    pub str_ratio: Option<f64>,
    /// Side in pixels of the blocks that were averaged first; 1 for all but the largest maps.
    pub block: usize,
}

/// Fraction of the autocorrelation at zero distance at which Sal and Str are read, from ISO 25178-3.
const CORRELATION_THRESHOLD: f64 = 0.2;

/// Continuation of the map past its sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sides {
    /// Unknown, as for a measured map.
    #[default]
    Open,
    /// Periodic, as for a synthetic map.
    Periodic,
}

impl HeightMap {
    /// Sal and Str at 0.2 times the autocorrelation at zero distance. With open sides each product
    /// is averaged over the overlapping points (the unbiased estimate).
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] unless the map is complete; [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn correlation_lengths(&self, sides: Sides, monitor: &dyn Monitor) -> Result<CorrelationLengths, MapError> {
        self.require_complete()?;
        let block = (1..).find(|block| self.heights_m().len() / (block * block) <= MAX_CORRELATED).unwrap_or(1);
        if block == 1 {
            return lengths(self, sides, 1, monitor);
        }
        let decimation = Some(Decimation { factor: block, method: DecimationMethod::Mean });
        match self.windowed(None, decimation) {
            Ok(coarse) => lengths(&coarse, sides, block, monitor),
            // The map exceeds the limit but has only a few rows or columns.
            Err(_) => lengths(self, sides, 1, monitor),
        }
    }
}

fn lengths(map: &HeightMap, sides: Sides, block: usize, monitor: &dyn Monitor) -> Result<CorrelationLengths, MapError> {
    monitor.heed()?;
    let correlation = Correlation::new(map, sides, monitor)?;
    if correlation.value(0, 0) <= 0.0 {
        return Ok(CorrelationLengths { sal_m: None, str_ratio: None, block });
    }
    let level = CORRELATION_THRESHOLD * correlation.value(0, 0);
    let (mut least_m, mut most_m) = (None, Some(0.0_f64));
    for direction in 0..DIRECTIONS {
        monitor.heed()?;
        let decay_m = correlation.decay(PI * direction as f64 / DIRECTIONS as f64, level);
        least_m = least_m.into_iter().chain(decay_m).reduce(f64::min);
        most_m = most_m.zip(decay_m).map(|(a, b)| a.max(b));
    }
    // Str = r_min / r_max
    Ok(CorrelationLengths { sal_m: least_m, str_ratio: least_m.zip(most_m).map(|(least, most)| least / most), block })
}

/// Autocorrelation at displacements of up to half the map.
struct Correlation {
    /// Autocorrelation, row by row; displacements along x and y run from 0 upwards, with the negative ones at the end.
    value: Vec<f64>,
    /// Numbers of rows and columns of `value`.
    size: [usize; 2],
    /// Largest displacements along x and y, in pixels.
    most: [usize; 2],
    pixel_m: [f64; 2],
}

impl Correlation {
    fn new(map: &HeightMap, sides: Sides, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let (rows, cols) = (map.rows(), map.cols());
        let mean_m = map.mean_m();
        let scale = map.sq_m().max(f64::MIN_POSITIVE);
        let most = [rows / 2, cols / 2];
        // Zeros appended to the map keep displacements of up to half the map from reaching the next period.
        let size = match sides {
            Sides::Periodic => [rows, cols],
            Sides::Open => [smooth(rows + most[0] + 1), smooth(cols + most[1] + 1)],
        };
        let mut value = vec![0.0; size[0] * size[1]];
        for (source, target) in map.heights_m().chunks_exact(cols).zip(value.chunks_exact_mut(size[1])) {
            for (target, height) in target.iter_mut().zip(source) {
                *target = (height - mean_m) / scale;
            }
        }
        Fourier::new(size[0], size[1]).autocorrelate(&mut value, monitor)?;
        if sides == Sides::Open {
            // R(t) = (1/overlap) sum over x of h(x) h(x + t)
            let overlap =
                |place: usize, points: usize, size: usize| points.saturating_sub(place.min(size - place)).max(1);
            for (i, row) in value.chunks_exact_mut(size[1]).enumerate() {
                monitor.heed()?;
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum /= (overlap(i, rows, size[0]) * overlap(j, cols, size[1])) as f64;
                }
            }
        }
        Ok(Self { value, size, most, pixel_m: [map.dx_m(), map.dy_m()] })
    }

    fn value(&self, i: i64, j: i64) -> f64 {
        let place = |n: i64, size: usize| n.rem_euclid(size as i64) as usize;
        self.value[place(i, self.size[0]) * self.size[1] + place(j, self.size[1])]
    }

    /// Autocorrelation at a displacement of `x` and `y` pixels, by cubic convolution along both axes (Catmull-Rom).
    fn interpolate(&self, x: f64, y: f64) -> f64 {
        let weights = |t: f64| {
            [
                0.5 * t * (t * (2.0 - t) - 1.0),
                0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
                0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
                0.5 * t * t * (t - 1.0),
            ]
        };
        let (i, j) = (x.floor(), y.floor());
        let (along_x, along_y) = (weights(x - i), weights(y - j));
        let mut sum = 0.0;
        for (a, weight_x) in (-1..).zip(along_x) {
            for (b, weight_y) in (-1..).zip(along_y) {
                sum += weight_x * weight_y * self.value(i as i64 + a, j as i64 + b);
            }
        }
        sum
    }

    /// Distance at which the autocorrelation first falls to `level` in the direction `angle` (radians from x towards
    /// y), in metres; `None` if it does not fall so far within half the map.
    fn decay(&self, angle: f64, level: f64) -> Option<f64> {
        let step_m = self.pixel_m[0].min(self.pixel_m[1]) / STEPS_PER_PIXEL;
        let (step_x, step_y) = (angle.cos() * step_m / self.pixel_m[0], angle.sin() * step_m / self.pixel_m[1]);
        let mut before = self.value(0, 0);
        for step in 1_u32.. {
            let (x, y) = (f64::from(step) * step_x, f64::from(step) * step_y);
            if x.abs() >= self.most[0] as f64 || y.abs() >= self.most[1] as f64 {
                return None;
            }
            let value = self.interpolate(x, y);
            if value <= level {
                // Linear interpolation between two steps, which are a fraction of a pixel apart.
                return Some((f64::from(step) - (level - value) / (before - value)) * step_m);
            }
            before = value;
        }
        None
    }
}

/// Smallest number not below `least` without a prime factor above 5, which makes the transform fast.
fn smooth(least: usize) -> usize {
    let is_smooth = |number: usize| {
        let without = |mut rest: usize, factor: usize| {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
            rest
        };
        without(without(without(number, 2), 3), 5) == 1
    };
    (least.max(1)..).find(|&number| is_smooth(number)).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use slipgrid_base::monitor::Unwatched;

    /// h(x, y) on 240 x 180 pixels of 1 um x 2 um.
    fn map(height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let heights = (0..240 * 180).map(|n| 1e-6 * height((n / 180) as f64 * 1e-6, (n % 180) as f64 * 2e-6)).collect();
        HeightMap::new(240, 180, 1e-6, 2e-6, heights).unwrap()
    }

    #[test]
    fn a_wave_decays_as_its_cosine_and_never_along_its_crests() {
        let map = map(|x, _| (TAU * x / 40e-6).cos());
        let exact = 0.2_f64.acos() / TAU * 40e-6;
        let found = map.correlation_lengths(Sides::Periodic, &Unwatched).unwrap();
        assert!((found.sal_m.unwrap() / exact - 1.0).abs() < 1e-4, "{found:?}");
        assert_eq!(found.str_ratio, None);
        // Six periods on an open map; the overlap is not a whole number of periods.
        let open = map.correlation_lengths(Sides::Open, &Unwatched).unwrap();
        assert!((open.sal_m.unwrap() / exact - 1.0).abs() < 0.02, "{open:?}");
    }

    #[test]
    fn two_crossed_waves_have_the_ratio_of_their_lengths() {
        // R = [cos(q1 x) + cos(q2 y)]/2 falls to 0.2 along x where cos(q1 x) = -0.6, and likewise along y. At an angle
        // t from an axis the distance changes by (t^2/2)(a - (q'/q)^2 a^2/sin a)/q with a = acos(-0.6): the x axis is a
        // minimum, the y axis a maximum.
        let map = map(|x, y| (TAU * x / 30e-6).cos() + (TAU * y / 60e-6).cos());
        let found = map.correlation_lengths(Sides::Periodic, &Unwatched).unwrap();
        let least = (-0.6_f64).acos() / TAU * 30e-6;
        assert!((found.sal_m.unwrap() / least - 1.0).abs() < 1e-3, "{found:?} {least}");
        assert!((found.str_ratio.unwrap() - 0.5).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn lengths_scale_with_the_pixel_and_not_with_the_height() {
        let heights: Vec<f64> = map(|x, y| (TAU * x / 30e-6).cos() * (TAU * y / 40e-6).cos()).heights_m().to_vec();
        let lengths = |scale: f64, height: f64| {
            let heights = heights.iter().map(|h| h * height).collect();
            let map = HeightMap::new(240, 180, scale * 1e-6, scale * 2e-6, heights).unwrap();
            map.correlation_lengths(Sides::Open, &Unwatched).unwrap()
        };
        let (one, other) = (lengths(1.0, 1.0), lengths(3.0, 1e-3));
        assert!((other.sal_m.unwrap() / one.sal_m.unwrap() - 3.0).abs() < 1e-9);
        assert!((other.str_ratio.unwrap() - one.str_ratio.unwrap()).abs() < 1e-9);
    }

    #[test]
    fn flat_maps_have_no_length() {
        let flat = map(|_, _| 1.0);
        let found = flat.correlation_lengths(Sides::Open, &Unwatched).unwrap();
        assert_eq!((found.sal_m, found.str_ratio), (None, None));
    }

    #[test]
    fn smooth_sizes() {
        assert_eq!([1, 7, 11, 121, 769].map(smooth), [1, 8, 12, 125, 800]);
    }
}
