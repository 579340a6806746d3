//! Seeded Gaussian noise for synthetic data: SplitMix64 and Box-Muller.

use super::SplitMix64;

/// A stream of random numbers.
#[derive(Clone, Copy, Debug)]
pub struct Noise(SplitMix64);

impl Noise {
    /// Starts the stream with `seed`.
    pub const fn new(seed: u64) -> Self {
        Self(SplitMix64(seed))
    }

    /// Uniform deviate in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        ((self.0.bits() >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    /// Standard normal deviate: sqrt(-2 ln u) cos(2 pi v).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_have_mean_zero_and_variance_one() {
        let mut noise = Noise::new(1);
        let values: Vec<f64> = (0..20_000).map(|_| noise.normal()).collect();
        let mean = values.iter().sum::<f64>() / 20_000.0;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
    }
}
