//! The SplitMix64 generator (Steele, Lea and Flood, OOPSLA 2014): the same numbers on every machine.

/// Increment of the state: the odd number nearest to 2^64 over the golden ratio.
const INCREMENT: u64 = 0x9E37_79B9_7F4A_7C15;

/// Output of the generator whose state is `state`.
pub const fn splitmix64(state: u64) -> u64 {
    let mut z = state.wrapping_add(INCREMENT);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The generator, with its state; the initial state is the seed.
#[derive(Clone, Copy, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// Next 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        let bits = splitmix64(self.0);
        self.0 = self.0.wrapping_add(INCREMENT);
        bits
    }

    /// Next random number from 0 to below `limit`; 0 for a limit of 0. Its bias is below `limit` / 2^64.
    pub const fn below(&mut self, limit: usize) -> usize {
        // The remainder is below `limit`, a usize.
        (self.bits() % if limit == 0 { 1 } else { limit as u64 }) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        // First outputs for the state 1234567 (Vigna's reference implementation).
        let published = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        let mut generator = SplitMix64(1_234_567);
        assert_eq!([generator.bits(), generator.bits()], published);
        assert_eq!(splitmix64(1_234_567), published[0]);
    }
}
