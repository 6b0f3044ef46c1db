//! Phase functions: where light goes when it is scattered, p(θ) in sr⁻¹ with 2π ∫ p sin θ dθ = 1.

use core::f64::consts::PI;

/// How scattered light is spread over directions.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// The same in all directions, 1/4π.
    Isotropic,
    /// A weighted sum of Henyey–Greenstein lobes; see [`Phase::lobes`].
    HenyeyGreensteinSum(Vec<Lobe>),
    /// Fournier and Forand (1994), in the form of Fournier and Jonasz (1999).
    FournierForand {
        /// Real refractive index of the particles relative to water, in (1, 1.4].
        refractive_index: f64,
        /// Slope of the Junge size distribution, in (3, 5).
        junge_slope: f64,
    },
}

/// One Henyey–Greenstein lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Share of the scattered light, in (0, 1].
    pub weight: f64,
    /// Mean cosine of the lobe, in (−1, 1); positive is forward.
    pub g: f64,
}

/// Why numbers make no phase function.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum PhaseError {
    #[error("lobes: expected 1 to {}, found {found}", Phase::MOST_LOBES)]
    Lobes { found: usize },
    #[error("lobes[{index}].g: expected > -1 and < 1, found {found}")]
    Anisotropy { index: usize, found: f64 },
    #[error("lobes[{index}].weight: expected > 0 and at most 1, found {found}")]
    Weight { index: usize, found: f64 },
    #[error("lobes: expected weights that sum to 1 within 1e-6, found {found}")]
    WeightSum { found: f64 },
    #[error("refractive_index: expected > 1 and at most 1.4, found {found}")]
    RefractiveIndex { found: f64 },
    #[error("junge_slope: expected > 3 and < 5, found {found}")]
    JungeSlope { found: f64 },
}

impl Phase {
    /// Three lobes fitted to the mean of Petzold's (1972) harbour measurements beyond 1° (rms 7.5 %), mean cosine 0.9226.
    ///
    /// The right one for a scattering coefficient from an instrument that misses what is scattered by less than about 1°,
    /// as those behind the measured Jerlov table do.
    pub fn petzold3() -> Self {
        Self::normalised(&[(0.42567, 0.98842), (0.57153, 0.88076), (0.00280, -0.55225)])
    }

    /// Four lobes fitted to the same data from 0.1° to 180° (rms 5.3 %), mean cosine 0.9224: for a scattering coefficient
    /// that includes the near-forward peak.
    pub fn petzold4() -> Self {
        Self::normalised(&[
            (0.11987, 0.99722),
            (0.37109, 0.98068),
            (0.50642, 0.86966),
            (0.00263, -0.56343),
        ])
    }

    /// One Henyey–Greenstein lobe.
    ///
    /// # Errors
    /// `g` not in (−1, 1).
    pub fn henyey_greenstein(g: f64) -> Result<Self, PhaseError> {
        Self::lobes(vec![Lobe { weight: 1.0, g }])
    }

    /// Lobes of a sum: as many as a graphics card is sent.
    pub const MOST_LOBES: usize = 14;

    /// A sum of lobes.
    ///
    /// # Errors
    /// No lobe or too many, `g` not in (−1, 1), a weight not in (0, 1], weights that do not sum to 1.
    pub fn lobes(lobes: Vec<Lobe>) -> Result<Self, PhaseError> {
        let phase = Self::HenyeyGreensteinSum(lobes);
        phase.validate()?;
        Ok(phase)
    }

    /// The printed weights are rounded to five digits; light must not be lost to that.
    fn normalised(weights_and_g: &[(f64, f64)]) -> Self {
        let total: f64 = weights_and_g.iter().map(|(weight, _)| weight).sum();
        Self::HenyeyGreensteinSum(
            weights_and_g
                .iter()
                .map(|&(weight, g)| Lobe {
                    weight: weight / total,
                    g,
                })
                .collect(),
        )
    }

    /// Checks the numbers inside; the variants can be built by hand.
    ///
    /// # Errors
    /// The first number out of its range.
    pub fn validate(&self) -> Result<(), PhaseError> {
        match self {
            Self::HenyeyGreensteinSum(lobes) => {
                if !(1..=Self::MOST_LOBES).contains(&lobes.len()) {
                    return Err(PhaseError::Lobes { found: lobes.len() });
                }
                for (index, lobe) in lobes.iter().enumerate() {
                    if !(lobe.g.abs() < 1.0) {
                        let found = lobe.g;
                        return Err(PhaseError::Anisotropy { index, found });
                    }
                    if !(lobe.weight > 0.0 && lobe.weight <= 1.0) {
                        let found = lobe.weight;
                        return Err(PhaseError::Weight { index, found });
                    }
                }
                let found: f64 = lobes.iter().map(|lobe| lobe.weight).sum();
                if (found - 1.0).abs() > 1e-6 {
                    return Err(PhaseError::WeightSum { found });
                }
                Ok(())
            }
            &Self::FournierForand {
                refractive_index: found,
                ..
            } if !(found > 1.0 && found <= 1.4) => Err(PhaseError::RefractiveIndex { found }),
            &Self::FournierForand {
                junge_slope: found, ..
            } if !(found > 3.0 && found < 5.0) => Err(PhaseError::JungeSlope { found }),
            Self::Isotropic | Self::FournierForand { .. } => Ok(()),
        }
    }

    /// p(θ) in sr⁻¹; `cos_theta` in [−1, 1], forward = +1.
    pub fn value_per_sr(&self, cos_theta: f64) -> f64 {
        Evaluator::new(self).value_per_sr(cos_theta)
    }

    /// ⟨cos θ⟩, in (−1, 1). A quadrature for Fournier–Forand: ask once, not per ray.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Self::Isotropic => 0.0,
            Self::HenyeyGreensteinSum(lobes) => lobes.iter().map(|lobe| lobe.weight * lobe.g).sum(),
            &Self::FournierForand {
                refractive_index,
                junge_slope,
            } => FournierForand::new(refractive_index, junge_slope).mean_cosine(),
        }
    }

    /// The share of the light that is scattered by more than 90°, in [0, 1].
    pub fn backscatter_fraction(&self) -> f64 {
        match self {
            Self::Isotropic => 0.5,
            // B = (1−g)/(2g) ((1+g)/√(1+g²) − 1), rid of its 0/0 at g = 0.
            Self::HenyeyGreensteinSum(lobes) => lobes
                .iter()
                .map(|&Lobe { weight, g }| {
                    let root = (1.0 + g * g).sqrt();
                    weight * (1.0 - g) / (root * (1.0 + g + root))
                })
                .sum(),
            &Self::FournierForand {
                refractive_index,
                junge_slope,
            } => FournierForand::new(refractive_index, junge_slope).backscatter_fraction(),
        }
    }
}

/// A phase function with everything worked out that does not depend on the angle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Evaluator {
    Isotropic,
    Lobes(Box<[LobeConstants]>),
    FournierForand(FournierForand),
}

/// A lobe's constants.
///
///   p(θ) = Σ wᵢ (1 − gᵢ²) / (4π xᵢ √xᵢ),  xᵢ = (1 − gᵢ)² + 2gᵢ (1 − cos θ)
///
/// The printed 1 + g² − 2g cos θ cancels for g near 1, just where the lobe is highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LobeConstants {
    amplitude: f64,
    offset: f64,
    slope: f64,
}

impl LobeConstants {
    fn new(&Lobe { weight, g }: &Lobe) -> Self {
        Self {
            amplitude: weight * (1.0 - g * g) / (4.0 * PI),
            offset: (1.0 - g) * (1.0 - g),
            slope: 2.0 * g,
        }
    }
}

impl Evaluator {
    pub(crate) fn new(phase: &Phase) -> Self {
        match phase {
            Phase::Isotropic => Self::Isotropic,
            Phase::HenyeyGreensteinSum(lobes) => {
                Self::Lobes(lobes.iter().map(LobeConstants::new).collect())
            }
            &Phase::FournierForand {
                refractive_index,
                junge_slope,
            } => Self::FournierForand(FournierForand::new(refractive_index, junge_slope)),
        }
    }

    #[inline]
    pub(crate) fn value_per_sr(&self, cos_theta: f64) -> f64 {
        self.values_per_sr(&[cos_theta])[0]
    }

    /// Several angles side by side: the square roots and divisions, which are most of the cost, go through the machine
    /// together.
    #[inline]
    pub(crate) fn values_per_sr<const N: usize>(&self, cos_theta: &[f64; N]) -> [f64; N] {
        match self {
            Self::Isotropic => [0.25 / PI; N],
            Self::Lobes(lobes) => {
                let mut p = [0.0; N];
                for lobe in lobes {
                    let x = cos_theta.map(|cos| lobe.offset + lobe.slope * (1.0 - cos));
                    let term = x.map(|x| lobe.amplitude / (x * x.sqrt()));
                    p = core::array::from_fn(|k| p[k] + term[k]);
                }
                p
            }
            Self::FournierForand(p) => cos_theta.map(|cos| p.value_per_sr(cos)),
        }
    }
}

/// δ = 1 is removable, but what is left of (1−δ)² beside it is noise: it is crossed on a chord of this half width.
const GAP: f64 = 1e-3;

/// Constants of a Fournier–Forand function: δ = 4 sin²(θ/2) / (3(n − 1)²), ν = (3 − μ)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FournierForand {
    nu: f64,
    delta_180: f64,
    backward: f64,
}

impl FournierForand {
    fn new(refractive_index: f64, junge_slope: f64) -> Self {
        let n1 = refractive_index - 1.0;
        let nu = 0.5 * (3.0 - junge_slope);
        let delta_180 = 4.0 / (3.0 * n1 * n1);
        let power = libm::pow(delta_180, nu);
        Self {
            nu,
            delta_180,
            backward: (1.0 - power) / (16.0 * PI * (delta_180 - 1.0) * power),
        }
    }

    ///   p = {ν(1−δ) − (1−δ^ν) + [δ(1−δ^ν) − ν(1−δ)] / sin²(θ/2)} / (4π (1−δ)² δ^ν)
    ///     + (1−δ₁₈₀^ν) (3cos²θ − 1) / (16π (δ₁₈₀−1) δ₁₈₀^ν)
    fn value_per_sr(&self, cos_theta: f64) -> f64 {
        // The forward direction itself is an integrable singularity; 1e-12 is 8e-5°.
        let sin2_half = (0.5 * (1.0 - cos_theta)).max(1e-12);
        let delta = self.delta_180 * sin2_half;
        let forward = if (delta - 1.0).abs() < GAP {
            let share = (delta - (1.0 - GAP)) / (2.0 * GAP);
            (1.0 - share) * self.forward(1.0 - GAP) + share * self.forward(1.0 + GAP)
        } else {
            self.forward(delta)
        };
        forward + self.backward * (3.0 * cos_theta * cos_theta - 1.0)
    }

    fn forward(&self, delta: f64) -> f64 {
        let sin2_half = delta / self.delta_180;
        let nu = self.nu;
        let power = libm::pow(delta, nu);
        let rest = 1.0 - delta;
        (nu * rest - (1.0 - power) + (delta * (1.0 - power) - nu * rest) / sin2_half)
            / (4.0 * PI * rest * rest * power)
    }

    ///   B = 1 − [1 − δ₉₀^(ν+1) − ½(1 − δ₉₀^ν)] / [(1 − δ₉₀) δ₉₀^ν]
    fn backscatter_fraction(&self) -> f64 {
        let delta_90 = 0.5 * self.delta_180;
        let power = libm::pow(delta_90, self.nu);
        1.0 - (1.0 - power * delta_90 - 0.5 * (1.0 - power)) / ((1.0 - delta_90) * power)
    }

    /// 2π ∫ p cos θ d(cos θ) with 1 − cos θ = 2y⁸, which tames the singularity, by midpoints.
    fn mean_cosine(&self) -> f64 {
        let (mut moment, mut total) = (0.0, 0.0);
        let points = 20_000;
        for k in 0..points {
            let y = (f64::from(k) + 0.5) / f64::from(points);
            let y7 = y * y * y * y * y * y * y;
            let cos_theta = 1.0 - 2.0 * y7 * y;
            let weight = y7 * self.value_per_sr(cos_theta);
            moment += weight * cos_theta;
            total += weight;
        }
        moment / total
    }
}
