//! Random parameters in a reproducible sequence.

use slipgrid_base::statistics::SplitMix64;

/// Random number generator with a fixed seed.
pub struct Random(SplitMix64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64(seed))
    }

    pub fn next(&mut self) -> u64 {
        self.0.bits()
    }

    /// Random number from 0 up to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Random number between `low` and `high`, rounded to `step`.
    pub fn between(&mut self, low: f64, high: f64, step: f64) -> f64 {
        let number = low + (high - low) * self.unit();
        (number / step).round() * step
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    pub fn choose<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.0.below(choices.len())]
    }
}
