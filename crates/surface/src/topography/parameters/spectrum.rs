//! The power spectrum of a map, averaged over directions.
//!
//! ```text
//! C(q) = |h~(q)|^2 / A,   h~(q) = dx dy sum over points of h exp(-i q x),   A the map's area,
//! Sq^2 = integral of C d^2q / (2 pi)^2
//! ```
//!
//! C has the unit m^4, q is in rad/m (Jacobs, Junge and Pastewka, Surf. Topogr. Metrol. Prop. 5, 013001).

use std::f64::consts::{PI, TAU};

use slipgrid_base::monitor::{Cancelled, Monitor};

use crate::topography::fourier::Fourier;
use crate::topography::{HeightMap, MapError, Sides};

/// Spectrum in a ring of wave vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumBin {
    /// Mean of |q| over the waves in the ring, in rad/m.
    pub q_per_m: f64,
    /// Mean of C over the waves in the ring, in m^4.
    pub psd_m4: f64,
    /// Number of waves in the ring, counting a wave and its mirror image as two.
    pub waves: f64,
}

/// A wave is short if its wavelength is below this number of the longer sides of pixels: twice the shortest wave that
/// both axes resolve.
const SHORT_WAVE_PIXELS: f64 = 4.0;
/// If short waves hold at least this fraction of the squared slope, the pixel size limits the slope.
pub const LIMITED_BY_PIXELS: f64 = 0.4;

/// Contribution of the shortest waves of a map to its slope. If it is large, finer pixels would give a larger slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortWaves {
    /// Upper limit of the wavelengths counted, in metres: four pixels of the longer side.
    pub below_m: f64,
    /// Fraction of the squared rms slope contributed by waves shorter than `below_m`.
    pub slope_share: f64,
}

/// Number of rings of wave vectors per decade of |q|, spaced evenly in log |q|.
const BINS_PER_DECADE: f64 = 10.0;

impl HeightMap {
    /// Spectrum in ten rings per decade, from the longest wave of the map to the shortest that both axes resolve; rings
    /// without waves are omitted. With open `sides` heights at the distance r from the middle are multiplied by (1 +
    /// cos(pi r/R))/2 within the largest circle in the map, of radius R, scaled to mean square 1 (Hann's window).
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] unless the map is complete; [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn radial_spectrum(&self, sides: Sides, monitor: &dyn Monitor) -> Result<Vec<SpectrumBin>, MapError> {
        let longest = TAU / (self.rows() as f64 * self.dx_m()).max(self.cols() as f64 * self.dy_m());
        let shortest = PI / self.dx_m().max(self.dy_m());
        // The longest wave lies in the middle of the first ring, the shortest in the last ring.
        let first = longest.log10() - 0.5 / BINS_PER_DECADE;
        let count = ((shortest.log10() - first) * BINS_PER_DECADE).max(0.0).ceil();
        let edges: Vec<f64> = (0..=count as usize).map(|n| 10_f64.powf(first + n as f64 / BINS_PER_DECADE)).collect();
        self.radial_spectrum_between(&edges, sides, monitor)
    }

    /// Fraction of the squared rms slope s^2 in waves that are short relative to the map's pixels, with the whole
    /// spectrum h(q) of the map taken as one period:
    ///
    /// ```text
    /// s^2 = sum of q^2 |h(q)|^2
    /// ```
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] unless the map is complete; [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn short_waves(&self, monitor: &dyn Monitor) -> Result<ShortWaves, MapError> {
        self.require_complete()?;
        let below_m = SHORT_WAVE_PIXELS * self.dx_m().max(self.dy_m());
        let (mut short, mut all) = (0.0, 0.0);
        let fourier = Fourier::new(self.rows(), self.cols());
        let add = |q: f64, twins: f64, square: f64| {
            let squared_slope = twins * q * q * square;
            all += squared_slope;
            if q * below_m > TAU {
                short += squared_slope;
            }
        };
        fourier.visit_waves(self.heights_m(), [self.dx_m(), self.dy_m()], add, monitor)?;
        Ok(ShortWaves { below_m, slope_share: if all > 0.0 { short / all } else { 0.0 } })
    }

    /// Spectrum in rings with the given increasing `edges`, in rad/m.
    ///
    /// # Errors
    /// [`MapError::MissingPoints`] unless the map is complete; [`MapError::OutOfRange`] unless the edges increase;
    /// [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn radial_spectrum_between(
        &self,
        edges_per_m: &[f64],
        sides: Sides,
        monitor: &dyn Monitor,
    ) -> Result<Vec<SpectrumBin>, MapError> {
        self.require_complete()?;
        if let Some(pair) =
            edges_per_m.windows(2).find(|pair| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less))
        {
            return Err(MapError::OutOfRange {
                quantity: "edge of a ring",
                value: pair[1],
                expected: "increasing edges",
            });
        }
        let (rows, cols, dx_m, dy_m) = (self.rows(), self.cols(), self.dx_m(), self.dy_m());
        let mean_m = self.mean_m();
        monitor.heed()?;
        let mut height: Vec<f64> = self.heights_m().iter().map(|height| height - mean_m).collect();
        if sides == Sides::Open {
            fade(&mut height, [rows, cols], [dx_m, dy_m], monitor)?;
        }
        let mut bins: Vec<SpectrumBin> =
            edges_per_m.windows(2).map(|_| SpectrumBin { q_per_m: 0.0, psd_m4: 0.0, waves: 0.0 }).collect();
        // C = (dx dy)^2 |sum|^2 / A
        let scale = dx_m * dy_m / (rows as f64 * cols as f64);
        let add = |q: f64, twins: f64, square: f64| {
            let after = edges_per_m.partition_point(|&edge| edge <= q);
            if let Some(bin) = after.checked_sub(1).and_then(|bin| bins.get_mut(bin)) {
                bin.q_per_m += twins * q;
                bin.psd_m4 += twins * scale * square;
                bin.waves += twins;
            }
        };
        Fourier::new(rows, cols).visit_waves(&height, [dx_m, dy_m], add, monitor)?;
        bins.retain(|bin| bin.waves > 0.0);
        for bin in &mut bins {
            bin.q_per_m /= bin.waves;
            bin.psd_m4 /= bin.waves;
        }
        Ok(bins)
    }
}

/// Multiplies the heights by the Hann window about the middle of the map, scaled to mean square 1.
fn fade(
    height: &mut [f64],
    [rows, cols]: [usize; 2],
    [dx_m, dy_m]: [f64; 2],
    monitor: &dyn Monitor,
) -> Result<(), Cancelled> {
    let radius = 0.5 * (rows as f64 * dx_m).min(cols as f64 * dy_m);
    let factor = |i: usize, j: usize| {
        let x = (i as f64 - (rows / 2) as f64) * dx_m;
        let y = (j as f64 - (cols / 2) as f64) * dy_m;
        let r = x.hypot(y);
        if r < radius { 0.5 * (1.0 + (PI * r / radius).cos()) } else { 0.0 }
    };
    let mut square = 0.0;
    for i in 0..rows {
        monitor.heed()?;
        (0..cols).for_each(|j| square += factor(i, j).powi(2));
    }
    let norm = (square / height.len() as f64).sqrt().recip();
    for (i, row) in height.chunks_exact_mut(cols).enumerate() {
        monitor.heed()?;
        row.iter_mut().enumerate().for_each(|(j, height)| *height *= norm * factor(i, j));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::SelfAffine;
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn short_waves_are_all_those_shorter_than_four_of_the_longer_pixels() {
        // Waves of 16 rows and of 2 columns: one along the shorter pixels, beyond the waves that both axes resolve, and
        // in a corner of the spectrum.
        let (n, dx_m, dy_m) = (64, 2e-6, 1e-6);
        let height = |i: usize, j: usize| {
            let (x, y) = (TAU * i as f64 / 16.0, PI * j as f64);
            1e-6 * x.sin() + 1e-8 * y.cos() + 1e-8 * (PI * i as f64).cos() * y.cos()
        };
        let heights = (0..n * n).map(|at| height(at / n, at % n)).collect();
        let short = HeightMap::new(n, n, dx_m, dy_m, heights).unwrap().short_waves(&Unwatched).unwrap();
        let (long, row, column) = (TAU / 32e-6, PI / 2e-6, PI / 1e-6);
        let of_short = 1e-16 * (column * column + row * row + column * column);
        // The mean square of sin is 1/2, that of an alternating row is 1.
        let share = of_short / (of_short + 0.5e-12 * long * long);
        assert_eq!(short.below_m, 8e-6);
        assert!((short.slope_share / share - 1.0).abs() < 1e-9, "{short:?} {share}");
    }

    #[test]
    fn a_wave_puts_all_its_power_into_one_ring() {
        // a cos(q x) has the mean square a^2/2 = 2 waves times C/A.
        let height = |n: usize| 1e-6 * (TAU * 5.0 * (n / 48) as f64 / 64.0).cos();
        let map = HeightMap::new(64, 48, 1e-6, 2e-6, (0..64 * 48).map(height).collect()).unwrap();
        let q = TAU * 5.0 / 64e-6;
        let bins =
            map.radial_spectrum_between(&[0.5 * q, q - 1.0, q + 1.0, 2.0 * q], Sides::Periodic, &Unwatched).unwrap();
        let area = 64e-6 * 96e-6;
        let power: Vec<f64> = bins.iter().map(|bin| bin.psd_m4 * bin.waves / area).collect();
        assert!(power[0] < 1e-30 && power[2] < 1e-30, "{power:?}");
        assert!((power[1] / 0.5e-12 - 1.0).abs() < 1e-12, "{power:?}");
        assert!((bins[1].q_per_m / q - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_rings_of_all_waves_add_up_to_the_mean_square() {
        let map = SelfAffine { pixels: 128, max_wave: 20, ..SelfAffine::STAND_IN }.map().unwrap();
        let area = (128.0 * map.dx_m()).powi(2);
        let bins = map.radial_spectrum_between(&[1.0, 1e4, 1e5, 1e7], Sides::Periodic, &Unwatched).unwrap();
        let sum: f64 = bins.iter().map(|bin| bin.psd_m4 * bin.waves / area).sum();
        assert!((sum.sqrt() / map.sq_m() - 1.0).abs() < 1e-12);
        assert_eq!(bins.iter().map(|bin| bin.waves).sum::<f64>(), 128.0 * 128.0 - 1.0);
    }

    #[test]
    fn a_self_affine_map_shows_its_hurst_exponent() {
        // C ~ q^-2(1+H)
        let map = SelfAffine { hurst: 0.7, ..SelfAffine::STAND_IN }.map().unwrap();
        let bins = map.radial_spectrum(Sides::Periodic, &Unwatched).unwrap();
        let within: Vec<_> = bins.iter().filter(|bin| bin.q_per_m > TAU * 6.5e3 && bin.q_per_m < TAU * 56e3).collect();
        let (first, last) = (within[0], within[within.len() - 1]);
        let exponent = (last.psd_m4 / first.psd_m4).ln() / (last.q_per_m / first.q_per_m).ln();
        assert!(within.len() >= 8 && (exponent + 3.4).abs() < 0.03, "{exponent}");
    }

    #[test]
    fn edges_must_increase() {
        let map = HeightMap::new(2, 2, 1.0, 1.0, vec![0.0, 1.0, 0.0, 0.0]).unwrap();
        assert!(map.radial_spectrum_between(&[1.0, 1.0], Sides::Periodic, &Unwatched).is_err());
        assert!(!map.radial_spectrum(Sides::Open, &Unwatched).unwrap().is_empty());
    }
}
