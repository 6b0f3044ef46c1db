//! Random numbers keyed by what they are for, never by the order in which they are drawn: any thread count, any tile order and
//! any restart give the same image.

pub(crate) mod quantile;

/// Philox4x32-10 (Salmon et al., SC 2011): four random words from a 128-bit counter and a 64-bit key.
#[derive(Clone, Copy, Debug)]
pub struct Philox {
    pub(crate) key: [u32; 2],
}

impl Philox {
    /// The generator of a seed.
    pub fn new(seed: u64) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
        }
    }

    /// The four words of a counter.
    pub fn words(self, counter: [u32; 4]) -> [u32; 4] {
        let [mut c0, mut c1, mut c2, mut c3] = counter;
        let [mut k0, mut k1] = self.key;
        for round in 0..10 {
            if round > 0 {
                k0 = k0.wrapping_add(0x9E37_79B9);
                k1 = k1.wrapping_add(0xBB67_AE85);
            }
            let a = u64::from(c0) * 0xD251_1F53;
            let b = u64::from(c2) * 0xCD9E_8D57;
            (c0, c1, c2, c3) = (
                (b >> 32) as u32 ^ c1 ^ k0,
                b as u32,
                (a >> 32) as u32 ^ c3 ^ k1,
                a as u32,
            );
        }
        [c0, c1, c2, c3]
    }

    /// Four uniform numbers in (0, 1).
    pub(crate) fn uniforms(self, counter: [u32; 4]) -> [f64; 4] {
        self.words(counter)
            .map(|word| (f64::from(word) + 0.5) / 4294967296.0)
    }

    /// Four standard normal numbers.
    pub(crate) fn normals(self, counter: [u32; 4]) -> [f64; 4] {
        self.words(counter).map(quantile::normal)
    }

    /// A Poisson number of the given mean: from a standard normal number, rounded, at 30 and above, where that differs by less than
    /// the read noise of any sensor; exact (Knuth's product of uniforms) below. `counter[3]` must be 0: it counts the uniforms drawn.
    pub(crate) fn poisson(self, mean: f64, normal: f64, counter: [u32; 4]) -> f64 {
        if mean >= 30.0 {
            return libm::round(mean + mean.sqrt() * normal).max(0.0);
        }
        let limit = libm::exp(-mean);
        let mut product = 1.0;
        let mut count = 0_u32;
        let [c0, c1, c2, _] = counter;
        loop {
            let draws = self.uniforms([c0, c1, c2, count / 4]);
            product *= draws[count as usize % 4];
            if product <= limit {
                return f64::from(count);
            }
            count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers of Random123's `kat_vectors`, `philox4x32 10`.
    #[test]
    fn philox_matches_the_published_known_answers() {
        let words = |counter, key: [u32; 2]| Philox { key }.words(counter);
        assert_eq!(
            words([0; 4], [0; 2]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            words([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            words(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn poisson_has_its_mean_and_variance_on_both_branches() {
        let philox = Philox::new(7);
        for mean in [0.3, 5.0, 29.0, 31.0, 900.0] {
            let draws: Vec<f64> = (0..20_000)
                .map(|i| philox.poisson(mean, philox.normals([i, 0, 1, 0])[0], [i, 0, 0, 0]))
                .collect();
            let average = draws.iter().sum::<f64>() / 20_000.0;
            let variance = draws
                .iter()
                .map(|x| (x - average) * (x - average))
                .sum::<f64>()
                / 19_999.0;
            // Five standard errors of a mean and of a variance of 20 000 draws.
            assert!(
                (average - mean).abs() < 5.0 * libm::sqrt(mean / 20_000.0),
                "mean {average} of {mean}"
            );
            assert!(
                (variance / mean - 1.0).abs() < 5.0 * libm::sqrt((2.0 + 1.0 / mean) / 20_000.0),
                "variance {variance} of {mean}"
            );
        }
    }
}
