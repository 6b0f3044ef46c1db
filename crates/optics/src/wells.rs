//! Light scattered forwards on its way to the camera: Wells' small-angle modulation transfer function (1969, 1973).
//!
//!   MTF(ψ, z) = exp(−z [a + b − b Σ wᵢ h(2π θᵢ ψ)]),  h(u) = (1 − e^(−u))/u,  ψ in cycles per rad
//!
//! A ray bent by θ at the fraction s of its path seems to come from the angle θ s, and s is uniform in [0, 1]; a lobe of
//! Henyey and Greenstein is (θᵢ² + θ²)^(−3/2) at small angles, θᵢ = (1 − gᵢ)/√gᵢ, with the Hankel transform e^(−2π θᵢ ψ), whose
//! mean over s is h. MTF(0) = e^(−(a + b(1 − Σ wᵢ)) z) is all that arrives, MTF(∞) = e^(−c z) what was never scattered.

use core::f64::consts::PI;

use crate::nnls::nnls;
use crate::{Bands, Medium, Phase};

/// A forward lobe of a phase function at small angles, w θ₀/(2π (θ₀² + θ²)^(3/2)) in sr⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardLobe {
    /// Share w of all scattered light, in (0, 1].
    pub share: f64,
    /// Width θ₀, rad.
    pub width_rad: f64,
}

impl Phase {
    /// The lobes that point forwards. Light of the others, and isotropic light, counts as lost to the camera's ray.
    ///
    /// Fournier–Forand is fitted by lobes of fixed widths, within 7 % of it from 0.01° to 90°, which together hold all that is
    /// scattered by less than 90°. Ask once, not per ray.
    pub fn forward_lobes(&self) -> Vec<ForwardLobe> {
        match self {
            Self::Isotropic => Vec::new(),
            Self::HenyeyGreensteinSum(lobes) => lobes
                .iter()
                .filter(|lobe| lobe.g > 0.0)
                .map(|lobe| ForwardLobe {
                    share: lobe.weight,
                    width_rad: (1.0 - lobe.g) / lobe.g.sqrt(),
                })
                .collect(),
            Self::FournierForand { .. } => fitted_lobes(self),
        }
    }
}

/// Lobes a factor 2 apart, by relative least squares at angles a twentieth of a decade apart.
fn fitted_lobes(phase: &Phase) -> Vec<ForwardLobe> {
    let widths: Vec<f64> = (0..14).map(|k| libm::ldexp(1.0, k - 13)).collect();
    let medium = Medium::new([0.0; 3], [0.0; 3], phase.clone()).expect("a valid phase function");
    let forward = 1.0 - phase.backscatter_fraction();
    // In q = 2 sin(θ/2) a lobe keeps its form, and the solid angle is 2π q dq, up to 90°.
    let rows = (0..80).map(|k| {
        let q = core::f64::consts::SQRT_2 * libm::pow(10.0, -f64::from(k) / 20.0);
        let p = medium.phase_per_sr(1.0 - 0.5 * q * q);
        widths
            .iter()
            .map(|&width| {
                let x = width * width + q * q;
                width / (2.0 * PI * x * x.sqrt() * p)
            })
            .collect::<Vec<f64>>()
    });
    let mut fit = Fit::new(rows.map(|row| (row, 1.0)).collect());
    fit.hold_sum(1e4);
    let shares = fit.solve(|_| 1.0, forward);
    let total: f64 = shares.iter().sum();
    widths
        .into_iter()
        .zip(shares)
        .filter(|(_, share)| *share > 0.0)
        .map(|(width_rad, share)| ForwardLobe {
            share: share * forward / total,
            width_rad,
        })
        .collect()
}

/// A non-negative fit whose matrix stays while its right-hand side changes.
#[derive(Debug)]
struct Fit {
    rows: Vec<(Vec<f64>, f64)>,
    gram: Vec<Vec<f64>>,
    sum_weight: f64,
}

impl Fit {
    /// Rows with their weights.
    fn new(rows: Vec<(Vec<f64>, f64)>) -> Self {
        let n = rows[0].0.len();
        let gram = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| {
                        rows.iter()
                            .map(|(row, weight)| weight * row[i] * row[j])
                            .sum()
                    })
                    .collect()
            })
            .collect();
        Self {
            rows,
            gram,
            sum_weight: 0.0,
        }
    }

    /// Adds the equation "the unknowns sum to what is asked", of this weight.
    fn hold_sum(&mut self, weight: f64) {
        self.sum_weight = weight;
        for value in self.gram.iter_mut().flatten() {
            *value += weight;
        }
    }

    fn solve(&self, right: impl Fn(usize) -> f64, sum: f64) -> Vec<f64> {
        let mut target = vec![self.sum_weight * sum; self.gram.len()];
        for (k, (row, weight)) in self.rows.iter().enumerate() {
            let value = weight * right(k);
            for (target, row) in target.iter_mut().zip(row) {
                *target += value * row;
            }
        }
        nnls(&self.gram, &target)
    }
}

/// Wells' transfer function of one band.
#[derive(Clone, Debug, PartialEq)]
pub struct Wells {
    beam_attenuation_per_m: f64,
    scattering_per_m: f64,
    lobes: Vec<ForwardLobe>,
}

impl Wells {
    /// The transfer functions of a medium's bands.
    pub fn of(medium: &Medium) -> [Self; 3] {
        let (c, b) = (medium.beam_attenuation_per_m(), medium.scattering_per_m());
        let lobes = medium.phase().forward_lobes();
        core::array::from_fn(|k| Self {
            beam_attenuation_per_m: c[k],
            scattering_per_m: b[k],
            lobes: lobes.clone(),
        })
    }

    /// b Σ wᵢ h(2π θᵢ ψ): what small angles give back of the light scattered, m⁻¹.
    pub fn regained_per_m(&self, cycles_per_rad: f64) -> f64 {
        let share: f64 = self
            .lobes
            .iter()
            .map(|lobe| lobe.share * mean_decay(2.0 * PI * lobe.width_rad * cycles_per_rad))
            .sum();
        self.scattering_per_m * share
    }

    /// MTF(ψ, z), in [0, 1]: contrast of a sine of so many cycles per rad after z metres, for a source of unit radiance.
    pub fn mtf(&self, cycles_per_rad: f64, range_m: f64) -> f64 {
        libm::exp(-range_m * (self.beam_attenuation_per_m - self.regained_per_m(cycles_per_rad)))
    }

    /// (MTF(ψ, z) − e^(−c z)) / (MTF(0, z) − e^(−c z)): the transfer function of the halo alone, 1 at ψ = 0. As z → 0 that of light
    /// scattered once; 1 where nothing is scattered forwards.
    pub fn halo_mtf(&self, cycles_per_rad: f64, range_m: f64) -> f64 {
        let all = self.regained_per_m(0.0);
        if all == 0.0 {
            return 1.0;
        }
        let part = self.regained_per_m(cycles_per_rad);
        let depth = all * range_m;
        if depth < 1e-9 {
            part / all
        } else if depth > 30.0 {
            libm::exp((part - all) * range_m)
        } else {
            libm::expm1(part * range_m) / libm::expm1(depth)
        }
    }
}

/// h(u) = (1 − e^(−u))/u, 1 at u = 0.
fn mean_decay(u: f64) -> f64 {
    if u > 0.0 { -libm::expm1(-u) / u } else { 1.0 }
}

/// The halo of every range as a sum of Gaussians of fixed widths.
///
///   MTF(ψ, z) − e^(−c z) ≈ [MTF(0, z) − e^(−c z)] Σⱼ fⱼ(z) exp(−2π² sⱼ² ψ²),  fⱼ ≥ 0, Σⱼ fⱼ = 1
///
/// with s₀ = 0 (light that stays in its pixel) and sⱼ = 1, 2, 4 … px up to 1 rad and more. The shares fⱼ are fitted over the
/// logarithm of ψ at 64 ranges, within 1 % of MTF(0) − e^(−c z), and are linear between: their sum is 1 everywhere, so that no
/// light is lost or made.
#[derive(Clone, Debug, PartialEq)]
pub struct Halo {
    scattered_per_m: [(f64, f64); 3],
    levels: usize,
    longest_m: f64,
    shares: Vec<[[f32; Self::LEVELS]; 3]>,
}

impl Halo {
    /// Widths at most, with that of 0 px; the widest is 2¹⁴ px.
    pub const LEVELS: usize = 16;
    /// Ranges of the table of shares.
    pub const KNOTS: usize = 64;

    /// The halo of a medium for a camera of `px_per_rad` at the middle of its image.
    pub fn new(medium: &Medium, px_per_rad: f64) -> Self {
        let wells = Wells::of(medium);
        let widest = (1..Self::LEVELS).find(|&j| width_px(j) >= px_per_rad);
        let levels = widest.map_or(Self::LEVELS, |j| j + 1);
        let clearest = wells
            .iter()
            .map(|band| band.beam_attenuation_per_m)
            .fold(f64::INFINITY, f64::min);
        let longest_m = (16.0 / clearest).min(1e4);
        let frequencies_per_px: Vec<f64> = (0..128)
            .map(|k| 0.5 * libm::exp2(-(levels as f64 + 2.0) * f64::from(k) / 127.0))
            .collect();
        let rows = frequencies_per_px.iter().map(|psi| {
            let row = (0..levels).map(|j| {
                let phase = PI * width_px(j) * psi;
                libm::exp(-2.0 * phase * phase)
            });
            (row.collect(), 1.0)
        });
        let mut fit = Fit::new(rows.collect());
        fit.hold_sum(1e3);
        let shares_at = |knot: usize, band: &Wells| {
            let t = knot as f64 / (Self::KNOTS - 1) as f64;
            let range_m = longest_m * t * t;
            let found = fit.solve(
                |k| band.halo_mtf(px_per_rad * frequencies_per_px[k], range_m),
                1.0,
            );
            let total: f64 = found.iter().sum();
            let mut shares = [0.0; Self::LEVELS];
            for (share, found) in shares.iter_mut().zip(found) {
                *share = (found / total) as f32;
            }
            shares
        };
        Self {
            scattered_per_m: [0, 1, 2].map(|k| {
                let band = &wells[k];
                let c = band.beam_attenuation_per_m;
                (c - band.regained_per_m(0.0), c)
            }),
            levels,
            longest_m,
            shares: (0..Self::KNOTS)
                .map(|knot| [0, 1, 2].map(|k| shares_at(knot, &wells[k])))
                .collect(),
        }
    }

    /// Number of widths in use.
    pub fn levels(&self) -> usize {
        self.levels
    }

    /// The shares at the knots of ranges z = Z (k/(KNOTS − 1))², and Z, m; linear in √z between, constant beyond.
    pub fn knots(&self) -> (&[[[f32; Self::LEVELS]; 3]], f64) {
        (&self.shares, self.longest_m)
    }

    /// MTF(0, z) − e^(−c z): the part of a surface's light that arrives scattered, per band.
    #[inline]
    pub fn total(&self, range_m: f64) -> Bands {
        let [all, unscattered] = [
            self.scattered_per_m.map(|(all, _)| all),
            self.scattered_per_m.map(|(_, c)| c),
        ]
        .map(|attenuation| crate::transmittance(&attenuation, range_m));
        core::array::from_fn(|k| (all[k] - unscattered[k]).max(0.0))
    }

    /// The shares fⱼ of the widths in that part, per band; beyond [`levels`](Self::levels) zero.
    #[inline]
    pub fn shares(&self, range_m: f32) -> [[f32; Self::LEVELS]; 3] {
        let last = (Self::KNOTS - 1) as f32;
        let place = (range_m / self.longest_m as f32).sqrt().min(1.0) * last;
        let knot = (place as usize).min(Self::KNOTS - 2);
        let along = place - knot as f32;
        let mut shares = self.shares[knot];
        for (here, next) in shares.iter_mut().zip(&self.shares[knot + 1]) {
            for (here, next) in here.iter_mut().zip(next) {
                *here += along * (next - *here);
            }
        }
        shares
    }
}

/// Standard deviation of a width: 0, 1, 2, 4 … px.
pub fn width_px(level: usize) -> f64 {
    if level == 0 {
        0.0
    } else {
        libm::exp2(level as f64 - 1.0)
    }
}
