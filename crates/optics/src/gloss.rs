//! Glossy surfaces: a coat of microfacets over a matt body.

use crate::Bands;

/// A coat of mirror-like microfacets with the distribution of GGX (Walter et al. 2007, eq. 33), masked and shadowed after Smith
/// with correlated heights (Heitz 2014, eq. 99), reflecting after Schlick (1994).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Width of the distribution α, squared; in (0, 1].
    alpha2: f64,
    /// Reflectance at normal incidence, per band.
    reflectance: Bands,
}

/// Cosines at a surface, each in (0, 1]: to the light, to the eye, of the half vector to the normal and to either ray.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the type says it")]
pub struct Cosines {
    pub light: f64,
    pub eye: f64,
    pub half: f64,
    pub ray_half: f64,
}

impl Coat {
    /// From perceptual roughness in (0, 1], whose square is α, and reflectance in [0, 1]. `turn_rad` is how much the normal turns
    /// within one sample: so much wider is the lobe that one sample has to stand for (Tokuyoshi and Kaplanyan 2019, eq. 8 with
    /// σ² = ¼ and κ = 0.18).
    pub fn new(roughness: f64, reflectance: Bands, turn_rad: f64) -> Self {
        let alpha = roughness * roughness;
        let widened = alpha * alpha + (0.5 * turn_rad * turn_rad).min(0.18);
        Self {
            alpha2: widened.min(1.0),
            reflectance,
        }
    }

    /// π times the reflection function: what stands for the albedo in the formulas of a matt surface, per band.
    ///
    /// Matt light passes the coat twice, `(1 − F(cos θ_light)) (1 − F(cos θ_eye))`: reciprocal, and never more than arrives.
    pub fn reflection(&self, albedo: &Bands, at: &Cosines) -> Bands {
        let spread = 1.0 + at.half * at.half * (self.alpha2 - 1.0);
        let smith =
            |cos: f64, other: f64| other * (cos * cos * (1.0 - self.alpha2) + self.alpha2).sqrt();
        // π D G / (4 cos θ_light cos θ_eye)
        let lobe = self.alpha2 / (spread * spread) * 0.5
            / (smith(at.light, at.eye) + smith(at.eye, at.light));
        core::array::from_fn(|k| {
            let schlick = |cos: f64| {
                let rest = 1.0 - cos;
                let rest2 = rest * rest;
                self.reflectance[k] + (1.0 - self.reflectance[k]) * rest2 * rest2 * rest
            };
            let matt = albedo[k] * (1.0 - schlick(at.light)) * (1.0 - schlick(at.eye));
            matt + lobe * schlick(at.ray_half)
        })
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    /// The share of even light from everywhere that a surface sends into a direction of this cosine, by quadrature.
    fn furnace(coat: &Coat, albedo: f64, cos_eye: f64) -> f64 {
        const STEPS: u32 = 400;
        let eye = [(1.0 - cos_eye * cos_eye).max(0.0).sqrt(), 0.0, cos_eye];
        let mut sum = 0.0;
        for i in 0..STEPS {
            // Even steps of sin² θ: each of the same projected solid angle.
            let sin2 = (f64::from(i) + 0.5) / f64::from(STEPS);
            let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).sqrt());
            for j in 0..STEPS {
                let (s, c) = libm::sincos(PI * (f64::from(j) + 0.5) / f64::from(STEPS));
                let light = [sin * c, sin * s, cos];
                let half: [f64; 3] = core::array::from_fn(|k| light[k] + eye[k]);
                let norm = half.iter().map(|v| v * v).sum::<f64>().sqrt();
                let along = |v: &[f64; 3]| (0..3).map(|k| v[k] * half[k]).sum::<f64>() / norm;
                let at = Cosines {
                    light: cos,
                    eye: cos_eye,
                    half: half[2] / norm,
                    ray_half: along(&eye).min(1.0),
                };
                sum += coat.reflection(&[albedo; 3], &at)[0];
            }
        }
        sum / f64::from(STEPS * STEPS)
    }

    /// White furnace: a surface in even light sends back no more than arrives, whatever its roughness and reflectance.
    #[test]
    fn white_furnace_never_gains_light() {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for roughness in [0.15, 0.4, 0.7, 1.0] {
            for reflectance in [0.0, 0.04, 0.5, 1.0] {
                for cos in [0.05, 0.3, 0.7, 1.0] {
                    let coat = Coat::new(roughness, [reflectance; 3], 0.0);
                    let sent = furnace(&coat, 1.0, cos);
                    // The quadrature is good to 1e-3 for the narrowest lobe.
                    assert!(
                        sent <= 1.0 + 1e-3,
                        "{roughness} {reflectance} {cos}: {sent}"
                    );
                    least = least.min(sent);
                    most = most.max(sent);
                }
            }
        }
        // The bound is nearly reached, by mirrors. Light is lost in single bounces between rough facets, and most of all by a rough
        // coat seen at 3°, through which (1 − 0.05)⁵ of it does not come.
        assert!(most > 0.99 && least > 0.22, "{least} to {most}");
    }

    /// The narrow lobe of a perfect reflector sends back all light, and a coat that reflects nothing upright leaves the albedo.
    #[test]
    fn limits_are_a_mirror_and_a_matt_surface() {
        let mirror = furnace(&Coat::new(0.2, [1.0; 3], 0.0), 0.0, 0.8);
        assert!((mirror - 1.0).abs() < 5e-3, "{mirror}");
        let at = Cosines {
            light: 1.0,
            eye: 1.0,
            half: 1.0,
            ray_half: 1.0,
        };
        let matt = Coat::new(1.0, [0.0; 3], 0.0).reflection(&[0.3; 3], &at);
        assert!((matt[0] - 0.3).abs() < 1e-15, "{matt:?}");
    }

    /// D is normalised: ∫ D cos θ dω = 1, seen through the peak of the lobe, π D / 4 at normal incidence.
    #[test]
    fn peak_is_that_of_the_distribution() {
        let at = Cosines {
            light: 1.0,
            eye: 1.0,
            half: 1.0,
            ray_half: 1.0,
        };
        for roughness in [0.1, 0.5, 1.0] {
            let alpha2 = libm::pow(roughness, 4.0);
            let peak = Coat::new(roughness, [1.0; 3], 0.0).reflection(&[0.0; 3], &at)[0];
            assert!((peak * 4.0 * alpha2 - 1.0).abs() < 1e-12, "{peak}");
        }
    }

    /// Light goes the same way back.
    #[test]
    fn reflection_is_reciprocal() {
        let coat = Coat::new(0.3, [0.1, 0.2, 0.3], 0.05);
        let there = Cosines {
            light: 0.3,
            eye: 0.9,
            half: 0.8,
            ray_half: 0.7,
        };
        let back = Cosines {
            light: there.eye,
            eye: there.light,
            ..there
        };
        let (a, b) = (
            coat.reflection(&[0.5; 3], &there),
            coat.reflection(&[0.5; 3], &back),
        );
        assert!(
            (0..3).all(|k| (a[k] / b[k] - 1.0).abs() < 1e-14),
            "{a:?} {b:?}"
        );
    }
}
