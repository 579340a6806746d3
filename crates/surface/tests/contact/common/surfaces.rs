//! Surfaces of any size, made from a seed.

use slipgrid_base::statistics::splitmix64;
use slipgrid_surface::topography::HeightMap;
use slipgrid_surface::topography::fourier::Fourier;

/// A surface of `rows` x `cols` points with pixels of 1 x `aspect` µm.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// One of [`KINDS`].
    pub kind: &'a str,
    pub rows: usize,
    pub cols: usize,
    pub aspect: f64,
    pub seed: u64,
}

/// All kinds of surfaces.
pub const KINDS: [&str; 4] = ["self_affine", "white", "pits", "plateau"];

/// Side of a pixel along x, in metres.
const PIXEL_M: f64 = 1e-6;
/// Rms height of self-affine and white surfaces, in metres.
const RMS_HEIGHT_M: f64 = 2e-7;
/// Hurst exponent of self-affine surfaces.
const HURST: f64 = 0.8;
/// Number of waves along the longer side above which the spectrum of self-affine surfaces falls.
const ROLL_OFF_WAVES: f64 = 4.0;
/// Pitted surfaces have one pit of [`PIT_DEPTH_M`] per this many points, in noise of [`PITTED_RMS_HEIGHT_M`].
const POINTS_PER_PIT: u64 = 500;
const PIT_DEPTH_M: f64 = 9e-7;
const PITTED_RMS_HEIGHT_M: f64 = 4e-9;
/// Cut-off height of plateau surfaces in units of the rms height, and the rms height of the noise on plateaus.
const PLATEAU: f64 = -0.3;
const PLATEAU_NOISE_M: f64 = 2e-9;

/// Number `n` of the SplitMix64 generator for `seed`, identical on every machine.
pub fn random(seed: u64, n: u64) -> u64 {
    splitmix64((seed << 40).wrapping_add(n).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

impl Surface<'_> {
    pub fn map(&self) -> HeightMap {
        let points = (self.rows * self.cols) as u64;
        // Uniform distribution with mean 0 and rms 1.
        let noise = |seed| move |n| (random(seed, n) as f64 / 2f64.powi(64) - 0.5) * 12f64.sqrt();
        let white: Vec<f64> = (0..points).map(noise(self.seed)).collect();
        let heights = match self.kind {
            "self_affine" => self.roughen(&white).iter().map(|h| h * RMS_HEIGHT_M).collect(),
            "plateau" => {
                // Every second plateau is exactly flat.
                let rms_m = if self.seed.is_multiple_of(2) { PLATEAU_NOISE_M } else { 0.0 };
                let cut = self.roughen(&white).into_iter().map(|h| h.min(PLATEAU) * RMS_HEIGHT_M);
                cut.zip((0..points).map(noise(self.seed + 1))).map(|(h, noise)| h + noise * rms_m).collect()
            }
            "pits" => {
                let is_pit = |n: &u64| random(self.seed + 1, *n).is_multiple_of(POINTS_PER_PIT);
                let heights = (0..points).zip(&white);
                heights.map(|(n, h)| h * PITTED_RMS_HEIGHT_M - if is_pit(&n) { PIT_DEPTH_M } else { 0.0 }).collect()
            }
            _ => white.iter().map(|h| h * RMS_HEIGHT_M).collect(),
        };
        HeightMap::new(self.rows, self.cols, PIXEL_M, PIXEL_M * self.aspect, heights).unwrap()
    }

    /// Self-affine heights of rms 1.
    fn roughen(&self, white: &[f64]) -> Vec<f64> {
        let (dx_m, dy_m) = (PIXEL_M, PIXEL_M * self.aspect);
        let longest_m = (self.rows as f64 * dx_m).max(self.cols as f64 * dy_m);
        let roll_off = std::f64::consts::TAU * ROLL_OFF_WAVES / longest_m;
        let fourier = Fourier::new(self.rows, self.cols);
        let fall = fourier.multiplier(dx_m, dy_m, 0.0, |q| (q / roll_off).max(1.0).powf(-1.0 - HURST));
        let mut heights = vec![0.0; white.len()];
        fourier.filter(white, &fall, &mut heights, &mut fourier.work());
        let rms = (heights.iter().map(|h| h * h).sum::<f64>() / heights.len() as f64).sqrt();
        heights.iter_mut().for_each(|h| *h /= rms);
        heights
    }
}
