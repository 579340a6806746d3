use std::f64::consts::TAU;

use slipgrid_base::monitor::Unwatched;
use slipgrid_base::statistics::splitmix64;
use slipgrid_base::units::tidy;

use crate::topography::map::{check_grid, check_pixel, check_range};
use crate::topography::{HeightMap, MapError};

/// A synthetic self-affine map: every wave in a band has a random phase and an amplitude given by a power law.
///
/// ```text
/// h(x, y) = S sum 2 sqrt(C(k)) cos(2 pi (kx i + ky j)/n + phi(kx, ky)),   C = k^-2(1+H)
/// ```
///
/// The sum is over the half-plane ky > 0, or ky = 0 and kx > 0, with `min_wave` <= k <= `max_wave`, k = |(kx, ky)| in
/// waves per side; i is the row, j the column, n the number of pixels per side. Phases follow from the seed by two
/// steps of splitmix64; S is chosen to give Sa. The map is periodic, and the same to the last bit on every platform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfAffine {
    /// Pixels per side, n.
    pub pixels: usize,
    /// Side of the square map, in metres.
    pub side_m: f64,
    /// Hurst exponent H, above 0 and at most 1.
    pub hurst: f64,
    /// Smallest number of waves per side (longest wave).
    pub min_wave: u32,
    /// Largest number of waves per side (shortest wave), less than half the pixels.
    pub max_wave: u32,
    /// Sa = mean of |h - mean h|, in metres.
    pub sa_m: f64,
    /// Seed of the phases.
    pub seed: u32,
}

/// Largest number of waves per side that fits in the key from which a phase is computed.
const MAX_WAVES: u32 = 32_767;

impl SelfAffine {
    /// The map used in place of an unpublished measurement: 1 mm square, 512 x 512 points, Hurst exponent 0.8 between 4
    /// and 64 waves per side, Sa 0.158 um as measured on the flat sample (Balestra et al., J. Tribol. 144, 031704).
    /// Only Sa was measured; the other values were chosen.
    pub const STAND_IN: Self =
        Self { pixels: 512, side_m: 1e-3, hurst: 0.8, min_wave: 4, max_wave: 64, sa_m: 0.158e-6, seed: 20_240_607 };

    /// Computes the map. The work is proportional to pixels^2 times `max_wave`.
    ///
    /// # Errors
    /// [`MapError`] if a field is outside its range; see the fields.
    pub fn map(&self) -> Result<HeightMap, MapError> {
        self.validate()?;
        let n = self.pixels;
        let table: Vec<(f64, f64)> = (0..n)
            .map(|m| {
                let angle = TAU * m as f64 / n as f64;
                (libm::cos(angle), libm::sin(angle))
            })
            .collect();
        let mut height = vec![0.0; n * n];
        let mut along_x = vec![(0.0, 0.0); n];
        let (mut cos_y, mut sin_y) = (vec![0.0; n], vec![0.0; n]);
        for ky in 0..=i64::from(self.max_wave) {
            // B(i) = sum over kx of 2 sqrt(C) exp(i (2 pi kx i/n + phi))
            along_x.fill((0.0, 0.0));
            let widest = i64::from(self.max_wave);
            for kx in (if ky == 0 { 1 } else { -widest })..=widest {
                let Some((re, im)) = self.coefficient(kx, ky) else { continue };
                let step = kx.rem_euclid(n as i64) as usize;
                let mut turn = 0;
                for (sum_re, sum_im) in &mut along_x {
                    let (cos, sin) = table[turn];
                    *sum_re += re * cos - im * sin;
                    *sum_im += re * sin + im * cos;
                    turn += step;
                    turn -= if turn >= n { n } else { 0 };
                }
            }
            // h(i, j) += Re[B(i) exp(2 pi i ky j/n)]
            for (j, (cos, sin)) in cos_y.iter_mut().zip(&mut sin_y).enumerate() {
                (*cos, *sin) = table[(ky as usize * j) % n];
            }
            for (row, &(re, im)) in height.chunks_exact_mut(n).zip(&along_x) {
                for ((h, &cos), &sin) in row.iter_mut().zip(&cos_y).zip(&sin_y) {
                    *h += re * cos - im * sin;
                }
            }
        }
        let pixel_m = self.side_m / n as f64;
        let shape = HeightMap::new(n, n, pixel_m, pixel_m, height)?;
        shape.scaled(self.sa_m / shape.sa_m())
    }

    /// The same map with Sa changed such that its spectral rms slope is `rms_slope`; heights and slopes are
    /// proportional.
    ///
    /// # Errors
    /// [`MapError`] if a field is outside its range, or the slope is not positive and finite.
    pub fn with_rms_slope(self, rms_slope: f64) -> Result<Self, MapError> {
        if !(rms_slope.is_finite() && rms_slope > 0.0) {
            let expected = "a number above 0";
            return Err(MapError::OutOfRange { quantity: "rms slope", value: rms_slope, expected });
        }
        let sa_m = self.sa_m * rms_slope / self.map()?.rms_slope_spectral(&Unwatched)?;
        Ok(Self { sa_m, ..self })
    }

    /// Description of the map for the header of a file or a report, one line per element.
    pub fn description(&self) -> [String; 3] {
        [
            "synthetic self-affine map, not a measurement".to_owned(),
            format!(
                "{} x {} pixels, side {} mm, Hurst exponent {}, waves per side {} to {}, Sa {} um, seed {}",
                self.pixels,
                self.pixels,
                tidy(self.side_m * 1e3),
                self.hurst,
                self.min_wave,
                self.max_wave,
                tidy(self.sa_m * 1e6),
                self.seed
            ),
            "one period: opposite sides continue each other".to_owned(),
        ]
    }

    fn validate(&self) -> Result<(), MapError> {
        check_grid(self.pixels, self.pixels)?;
        check_pixel("pixel size", self.side_m / self.pixels as f64)?;
        let refuse = |quantity, value, expected| Err(MapError::OutOfRange { quantity, value, expected });
        if !(self.hurst > 0.0 && self.hurst <= 1.0) {
            return refuse("Hurst exponent", self.hurst, "a number above 0 and at most 1");
        }
        if self.min_wave == 0 || self.min_wave > self.max_wave {
            return refuse("longest wave per side", f64::from(self.min_wave), "at least 1 and at most the shortest");
        }
        if self.max_wave > MAX_WAVES || 2 * self.max_wave as usize >= self.pixels {
            return refuse(
                "shortest wave per side",
                f64::from(self.max_wave),
                "less than half the pixels, at most 32767",
            );
        }
        // Below 1e-30 m the squares of heights would underflow.
        check_range("Sa", self.sa_m, 1e-30..=1.0, "a positive height of at most 1 m")
    }

    /// Real and imaginary part of the amplitude 2 sqrt(C) exp(i phi) of the wave (kx, ky); `None` outside the band.
    fn coefficient(&self, kx: i64, ky: i64) -> Option<(f64, f64)> {
        let square = kx * kx + ky * ky;
        let band = i64::from(self.min_wave).pow(2)..=i64::from(self.max_wave).pow(2);
        if !band.contains(&square) {
            return None;
        }
        // 2 sqrt(C) = 2 k^-(1+H)
        let amplitude = 2.0 * libm::pow((square as f64).sqrt(), -(1.0 + self.hurst));
        let phase = self.phase(kx, ky);
        Some((amplitude * libm::cos(phase), amplitude * libm::sin(phase)))
    }

    /// Phase of the wave (kx, ky): phi = 2 pi (z >> 11) 2^-53 with z = m(m(key)), m a step of splitmix64, and key =
    /// seed << 32 | (kx + 32768) << 16 | (ky + 32768).
    fn phase(&self, kx: i64, ky: i64) -> f64 {
        // |kx|, |ky| <= 32767, so that both sums lie in 1..=65535.
        let key = u64::from(self.seed) << 32 | ((kx + 32_768) as u64) << 16 | (ky + 32_768) as u64;
        TAU * (splitmix64(splitmix64(key)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A_256: SelfAffine = SelfAffine { pixels: 256, max_wave: 32, ..SelfAffine::STAND_IN };

    /// Reference values of both maps, computed by an independent program: Sq in um and spectral rms slope.
    #[test]
    fn validation_roughness_of_the_reference_maps() {
        for (parameters, sq_um, slope) in [(A_256, 0.19752, 0.011120), (SelfAffine::STAND_IN, 0.19763, 0.013728)] {
            let map = parameters.map().unwrap();
            assert!((map.sa_m() * 1e6 - 0.158).abs() < 1e-12);
            assert!((map.sq_m() * 1e6 - sq_um).abs() < 5e-6, "{}", map.sq_m());
            assert!((map.rms_slope_spectral(&Unwatched).unwrap() - slope).abs() < 5e-7);
            assert!(map.mean_m().abs() < 1e-20);
        }
    }

    #[test]
    fn a_slope_can_be_asked_for() {
        let map = A_256.with_rms_slope(0.02).unwrap().map().unwrap();
        assert!((map.rms_slope_spectral(&Unwatched).unwrap() / 0.02 - 1.0).abs() < 1e-12);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(A_256.with_rms_slope(bad).is_err());
        }
    }

    #[test]
    fn heights_agree_with_the_direct_sum() {
        let map = A_256.map().unwrap();
        let direct = |i: f64, j: f64| {
            let mut sum = 0.0;
            for ky in 0..=32_i64 {
                for kx in -32..=32_i64 {
                    let k = ((kx * kx + ky * ky) as f64).sqrt();
                    if (ky > 0 || kx > 0) && (4.0..=32.0).contains(&k) {
                        let phase = TAU * (kx as f64 * i + ky as f64 * j) / 256.0 + A_256.phase(kx, ky);
                        sum += 2.0 * k.powf(-3.6).sqrt() * phase.cos();
                    }
                }
            }
            sum
        };
        let at = |i: usize, j: usize| map.heights_m()[i * 256 + j];
        let scale = at(0, 0) / direct(0.0, 0.0);
        for (i, j) in [(0, 1), (1, 0), (17, 200), (255, 255), (128, 3)] {
            assert!((at(i, j) - scale * direct(i as f64, j as f64)).abs() < 1e-12 * 0.158e-6);
        }
    }

    #[test]
    fn parameters_that_make_no_map_are_refused() {
        let refused = |change: fn(&mut SelfAffine)| {
            let mut parameters = A_256;
            change(&mut parameters);
            parameters.map().unwrap_err().to_string()
        };
        assert!(refused(|p| p.pixels = 1 << 20).contains("expected at most"));
        assert!(refused(|p| p.pixels = 64).contains("shortest wave"));
        assert!(refused(|p| p.min_wave = 0).contains("longest wave"));
        assert!(refused(|p| p.min_wave = 33).contains("longest wave"));
        assert!(refused(|p| p.hurst = f64::NAN).contains("Hurst"));
        assert!(refused(|p| p.sa_m = 0.0).contains("Sa"));
        assert!(refused(|p| p.side_m = f64::NAN).contains("pixel size"));
    }
}
