//! Daylight in the water: even from all of the hemisphere above, weaker with depth.

use core::f64::consts::PI;

use crate::{Bands, Medium, transmittance};

/// Downwelling irradiance and how fast depth takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    /// `E_d` on a plane that faces up at depth 0, W m⁻².
    pub irradiance_w_per_m2: Bands,
    /// `K_d`, m⁻¹.
    pub diffuse_attenuation_per_m: Bands,
}

impl Daylight {
    /// `K_d` = √(a² + 0.256 a b), for the sun overhead (Kirk 1981, Aust. J. Mar. Freshwater Res. 32, 517), m⁻¹.
    pub fn kirk_attenuation_per_m(medium: &Medium) -> Bands {
        let (a, b) = (medium.absorption_per_m(), medium.scattering_per_m());
        core::array::from_fn(|k| (a[k] * a[k] + 0.256 * a[k] * b[k]).sqrt())
    }

    /// `E_d` at a depth, W m⁻².
    #[inline]
    pub fn downwelling(&self, depth_m: f64) -> Bands {
        let kept = transmittance(&self.diffuse_attenuation_per_m, depth_m);
        core::array::from_fn(|k| self.irradiance_w_per_m2[k] * kept[k])
    }

    /// What of `E_d` falls on a plane, by the upward part of its normal: ½ (1 + n·up).
    #[inline]
    pub fn face_share(normal_up: f64) -> f64 {
        0.5 * (1.0 + normal_up)
    }

    /// The light that water of attenuation K and scattering b puts before what lies along a ray (which may be endless), W m⁻² sr⁻¹:
    /// B∞ (1 − e^(−`K_h` t)), B∞ = b ½ `E_d`/π / `K_h`, `K_h` = K + `K_d` times the downward part of the ray's direction. Half of the
    /// sky's light is what any even phase function, and any at all along the level, sends into the ray. Upwards, where `K_d` may
    /// exceed K, `K_h` is not let fall below K/4: the light above is no brighter than a multiple of that here.
    pub fn veil(
        &self,
        [attenuation_per_m, scattering_per_m]: [&Bands; 2],
        depth_m: f64,
        down: f64,
        distance_m: f64,
    ) -> Bands {
        let here = self.downwelling(depth_m);
        core::array::from_fn(|k| {
            let along = attenuation_per_m[k] + down * self.diffuse_attenuation_per_m[k];
            let along = along.max(0.25 * attenuation_per_m[k]);
            let source = scattering_per_m[k] * 0.5 * here[k] / PI;
            if source == 0.0 {
                0.0
            } else if distance_m.is_finite() {
                -source * libm::expm1(-along * distance_m) / along
            } else {
                source / along
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::water;

    /// Jerlov measured `K_d`, Williamson and Hollins a and b of waters of the same names: two independent sets that agree to 25 %.
    #[test]
    fn kirk_agrees_with_jerlov() {
        for name in ["IB", "II", "III", "1C", "3C", "5C"] {
            let water = water::by_name(name).expect("a row");
            let measured = water.diffuse_attenuation_per_m.expect("Jerlov's");
            let found = Daylight::kirk_attenuation_per_m(&water.medium());
            let ratio = found[1] / measured[1];
            assert!((0.8..1.25).contains(&ratio), "{name}: {ratio}");
        }
        // Without scattering it is absorption.
        let clear = Medium::new([0.1, 0.2, 0.3], [0.0; 3], crate::Phase::Isotropic);
        let found = Daylight::kirk_attenuation_per_m(&clear.expect("water"));
        assert_eq!(found, [0.1, 0.2, 0.3]);
    }

    /// The veil is ∫ b ½ `E_d`(depth)/π e^(−K s) ds; it grows with the distance and saturates, and shrinks downwards.
    #[test]
    fn veil_is_the_integral_along_the_ray() {
        let daylight = Daylight {
            irradiance_w_per_m2: [2.0, 3.0, 1.0],
            diffuse_attenuation_per_m: [0.3, 0.1, 0.12],
        };
        let (k, b) = ([0.5, 0.2, 0.25], [0.2, 0.3, 0.3]);
        for down in [-0.6, 0.0, 0.8] {
            let veil = |distance_m| daylight.veil([&k, &b], 1.5, down, distance_m);
            for band in 0..3 {
                let step = 2e-4;
                let sum: f64 = (0..15_000)
                    .map(|i| (f64::from(i) + 0.5) * step)
                    .map(|s| {
                        let there = daylight.downwelling(1.5 + down * s)[band];
                        b[band] * 0.5 * there / PI * libm::exp(-k[band] * s) * step
                    })
                    .sum();
                let found = veil(3.0)[band];
                assert!((found / sum - 1.0).abs() < 1e-6, "{found} {sum}");
                let rising = [0.0, 0.1, 1.0, 10.0, f64::INFINITY].map(|t| veil(t)[band]);
                assert!(rising.is_sorted() && rising[0] == 0.0, "{rising:?}");
                assert!((veil(400.0)[band] / rising[4] - 1.0).abs() < 1e-6);
            }
        }
        let endless = |down| daylight.veil([&k, &b], 0.0, down, f64::INFINITY)[0];
        assert!(endless(-1.0) > endless(0.0) && endless(0.0) > endless(1.0));
    }
}
