//! Seeds and random numbers for tests: the same on every machine, in any order of the tests.

/// The seed of a test case: a hash (FNV-1a, then mixed) of the suite's seed, the case's name and an index. A case that is
/// added moves no other.
pub fn seed(suite: u64, case: &str, index: u64) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    // The length, so that no name runs into the index.
    let numbers = [suite, case.len() as u64, index];
    let bytes = numbers.iter().flat_map(|n| n.to_le_bytes());
    for byte in bytes.chain(case.bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    SplitMix64::new(hash).next_u64()
}

/// Steele, Lea, Flood 2014: `SplitMix64`.
#[derive(Clone, Debug)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// From a seed; every seed is good.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splitmix64_gives_the_published_sequence() {
        // Seed 1234567, as in the reference implementation's test vectors.
        let mut rng = SplitMix64::new(1_234_567);
        let found: Vec<u64> = (0..3).map(|_| rng.next_u64()).collect();
        assert_eq!(
            found,
            [
                6_457_827_717_110_365_317,
                3_203_168_211_198_807_973,
                9_817_491_932_198_370_423
            ]
        );
    }

    #[test]
    fn seed_depends_on_all_three_and_on_nothing_else() {
        let base = seed(1, "rod", 2);
        assert_eq!(base, seed(1, "rod", 2));
        for other in [seed(2, "rod", 2), seed(1, "rods", 2), seed(1, "rod", 3)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn unit_stays_in_its_interval_and_is_centred() {
        let mut rng = SplitMix64::new(seed(0, "unit", 0));
        let values: Vec<f64> = (0..10_000).map(|_| rng.unit()).collect();
        assert!(values.iter().all(|v| (0.0..1.0).contains(v)));
        let mean = values.iter().sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 0.01, "mean {mean}");
    }
}
