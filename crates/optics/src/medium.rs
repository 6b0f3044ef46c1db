//! What water does to light per metre.

use crate::phase::Evaluator;
use crate::{Bands, Phase, PhaseError, exponential};

/// Homogeneous water: absorption a and scattering b per band, and where the scattered light goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    absorption_per_m: Bands,
    scattering_per_m: Bands,
    phase: Phase,
    mean_cosine: f64,
    evaluator: Evaluator,
}

/// Why numbers make no medium.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum MediumError {
    #[error("{coefficient}[{band}]: expected >= 0 and finite, found {found}")]
    Coefficient {
        coefficient: &'static str,
        band: usize,
        found: f64,
    },
    #[error("phase: {0}")]
    Phase(#[from] PhaseError),
}

impl Medium {
    /// Optical depth c z up to which surfaces are within 10 % of Monte Carlo (`docs/physics.md`, V7); beyond, too bright.
    pub const OPTICAL_DEPTH_LIMIT: f64 = 2.5;

    /// A medium from its coefficients.
    ///
    /// # Errors
    /// A coefficient that is negative or not finite, or a phase function that is none.
    pub fn new(
        absorption_per_m: Bands,
        scattering_per_m: Bands,
        phase: Phase,
    ) -> Result<Self, MediumError> {
        for (coefficient, values) in [
            ("absorption_per_m", &absorption_per_m),
            ("scattering_per_m", &scattering_per_m),
        ] {
            for (band, &found) in values.iter().enumerate() {
                if !(found >= 0.0 && found.is_finite()) {
                    return Err(MediumError::Coefficient {
                        coefficient,
                        band,
                        found,
                    });
                }
            }
        }
        phase.validate()?;
        Ok(Self {
            absorption_per_m,
            scattering_per_m,
            mean_cosine: phase.mean_cosine(),
            evaluator: Evaluator::new(&phase),
            phase,
        })
    }

    /// No water.
    pub fn vacuum() -> Self {
        Self {
            absorption_per_m: [0.0; 3],
            scattering_per_m: [0.0; 3],
            phase: Phase::Isotropic,
            mean_cosine: 0.0,
            evaluator: Evaluator::Isotropic,
        }
    }

    /// Whether nothing is absorbed and nothing scattered.
    pub fn is_vacuum(&self) -> bool {
        self.absorption_per_m == [0.0; 3] && self.scattering_per_m == [0.0; 3]
    }

    /// a.
    pub fn absorption_per_m(&self) -> Bands {
        self.absorption_per_m
    }

    /// b.
    pub fn scattering_per_m(&self) -> Bands {
        self.scattering_per_m
    }

    /// The phase function.
    pub fn phase(&self) -> &Phase {
        &self.phase
    }

    /// The phase function's value in sr⁻¹, without the cost of working its constants out again.
    #[inline]
    pub fn phase_per_sr(&self, cos_theta: f64) -> f64 {
        self.evaluator.value_per_sr(cos_theta)
    }

    #[inline]
    pub(crate) fn phases_per_sr<const N: usize>(&self, cos_theta: &[f64; N]) -> [f64; N] {
        self.evaluator.values_per_sr(cos_theta)
    }

    /// c = a + b: the loss of an unscattered beam.
    pub fn beam_attenuation_per_m(&self) -> Bands {
        self.attenuation_per_m(1.0)
    }

    /// K = a + b(1 − ⟨cos θ⟩): the loss of a lamp's light when what is scattered forwards still arrives.
    pub fn transport_attenuation_per_m(&self) -> Bands {
        self.attenuation_per_m(1.0 - self.mean_cosine)
    }

    /// Whether so much water is more than mode `full` is good for: c z above [`OPTICAL_DEPTH_LIMIT`](Self::OPTICAL_DEPTH_LIMIT) in any
    /// band that scatters. Absorption alone has no limit.
    pub fn is_beyond_model(&self, range_m: f64) -> bool {
        let bands = self
            .scattering_per_m
            .iter()
            .zip(self.beam_attenuation_per_m());
        bands
            .into_iter()
            .any(|(&b, c)| b > 0.0 && c * range_m > Self::OPTICAL_DEPTH_LIMIT)
    }

    fn attenuation_per_m(&self, lost_share: f64) -> Bands {
        core::array::from_fn(|k| self.absorption_per_m[k] + lost_share * self.scattering_per_m[k])
    }
}

/// e^(−K s): what is left of a beam after a path of s metres.
#[inline]
pub fn transmittance(attenuation_per_m: &Bands, path_m: f64) -> Bands {
    let [r, g, b] = attenuation_per_m;
    exponential::exp(&[-r * path_m, -g * path_m, -b * path_m])
}
