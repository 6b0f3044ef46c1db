//! The statistical limit: how accurate any unbiased method can be on a pair (Cramér 1946, Rao 1945).

use core::f64::consts::PI;

use nalgebra::{Matrix5, SMatrix, Vector2, Vector5};
use rodsight_geometry::{
    Cylinder, Eye, ImageLine, Line3, MountedCamera, Pixel, Rig, RigError, Side, Vec3,
};
use rodsight_render::{EyeTruth, Truth};
use serde::Serialize;

use crate::pair::{line, rig_of, seen_by};

/// Standard deviations that no unbiased method can beat when all it uses are the four limbs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Root mean square distance of the axis from the true grasp point, m.
    pub axis_offset_m: f64,
    /// Root mean square angle of the axis, rad.
    pub axis_angle_rad: f64,
    /// Standard deviation of the radius, m.
    pub radius_m: f64,
}

/// A stretch of a limb as one eye sees it: a straight edge of constant contrast. Stretches add up: many short ones describe a limb
/// that is hidden here and there, or whose contrast changes along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbStretch {
    /// Who sees it.
    pub eye: Eye,
    /// Which of the two limbs.
    pub side: Side,
    /// From where to where it is seen, m along the axis from its reference point.
    pub span_m: [f64; 2],
    /// Contrast over noise A/σ of the stored image, `√(Σ_bands (Δ/σ)²)`, dimensionless.
    pub contrast_to_noise: f64,
    /// `σ_t`: the spread of the edge, px ([`edge_sigma_px`]).
    pub edge_sigma_px: f64,
}

/// `σ_t`, px: the spread of an edge by the pixel's aperture, a box of one pixel of the variance 1/12, and by a lens of Gaussian blur:
/// `σ_t² = 1/12 + blur²`.
pub fn edge_sigma_px(blur_px: f64) -> f64 {
    (1.0 / 12.0 + blur_px * blur_px).sqrt()
}

/// How well a limb's profile across its edge tells its place, as the contrast-to-noise of the ideal step that tells as much.
///
/// A profile I(x), in units of the noise, tells a shift with the information ∫ (dI/dx)² dx per px of length, summed over bands; of a
/// step A/σ spread by `σ_t` that is (A/σ)²/(2√π `σ_t`). Stored images are not linear in light, and light may rise softly inside a limb:
/// both change the profile.
///
/// * `profiles`: per band, values one `step_px` apart across the edge, in units of the noise's standard deviation.
pub fn step_contrast_to_noise(profiles: &[Vec<f64>], step_px: f64, edge_sigma_px: f64) -> f64 {
    let squares: f64 = profiles
        .iter()
        .flat_map(|profile| profile.windows(2))
        .map(|pair| (pair[1] - pair[0]) * (pair[1] - pair[0]))
        .sum();
    (squares / step_px * 2.0 * PI.sqrt() * edge_sigma_px).sqrt()
}

/// The limit of a rendered pair, by [`limit_of`] with the pixel's aperture as the only blur; `None` for a bent rod, a lens with
/// distortion, without noise, or where a limb is not seen.
///
/// # Errors
/// A truth record whose rig is none.
pub fn limit(truth: &Truth) -> Result<Option<Limit>, RigError> {
    let rig = rig_of(truth)?;
    let rod = truth.target();
    let (axis, grasp) = (line(&truth.grasp.axis), Vec3::from(truth.grasp.point_m));
    let cylinder = Cylinder {
        axis: Line3 {
            point_m: grasp,
            ..axis
        },
        radius_m: rod.radius_m,
    };
    let middle_along_m = axis.direction.dot(&(Vec3::from(rod.axis.point_m) - grasp));
    let stretches: Option<Vec<LimbStretch>> = [
        (Eye::Left, &rod.left, Side::Plus),
        (Eye::Left, &rod.left, Side::Minus),
        (Eye::Right, &rod.right, Side::Plus),
        (Eye::Right, &rod.right, Side::Minus),
    ]
    .into_iter()
    .map(|(eye, seen, side)| stretch(middle_along_m, eye, seen, side))
    .collect();
    Ok(stretches.and_then(|stretches| limit_of(&rig, &cylinder, &stretches)))
}

fn stretch(middle_along_m: f64, eye: Eye, seen: &EyeTruth, side: Side) -> Option<LimbStretch> {
    seen.lines.as_ref()?;
    Some(LimbStretch {
        eye,
        side,
        span_m: seen_by(seen)?.map(|s_m| middle_along_m + s_m),
        contrast_to_noise: seen.contrast_to_noise[usize::from(side == Side::Minus)]?,
        edge_sigma_px: edge_sigma_px(0.0),
    })
}

/// The limit of a straight rod seen by two cameras without distortion, its offset counted at the axis' reference point; `None` where
/// the stretches do not tell where the rod is.
///
/// A straight edge of contrast-to-noise A/σ, spread `σ_t` and length L fixes its position at the centroid and its angle to
///
///   var ρ = σ₁²/L,  var θ = 12 σ₁²/L³,  σ₁² = 2√π `σ_t` (σ/A)²
///
/// and the five parameters of the cylinder follow from all of them: Σ = (Jᵀ W J)⁻¹. Nothing else is unknown: neither the lens, the
/// light, nor the calibration.
pub fn limit_of(rig: &Rig, cylinder: &Cylinder, stretches: &[LimbStretch]) -> Option<Limit> {
    let limbs: Option<Vec<Limb<'_>>> = stretches
        .iter()
        .map(|stretch| Limb::new(rig, cylinder, stretch))
        .collect();
    propagate(cylinder, &limbs?)
}

/// One stretch as a measurement.
struct Limb<'a> {
    mounted: &'a MountedCamera,
    side: Side,
    centre_px: Pixel,
    length_px: f64,
    /// σ₁², px² per px of length.
    sigma1_squared: f64,
}

impl<'a> Limb<'a> {
    fn new(rig: &'a Rig, cylinder: &Cylinder, stretch: &LimbStretch) -> Option<Self> {
        let LimbStretch {
            eye,
            side,
            span_m: [from_m, to_m],
            contrast_to_noise,
            edge_sigma_px,
        } = *stretch;
        let mounted = rig.eye(eye);
        let limb_m = mounted.limb_point_m(cylinder, side)?;
        let at = |s_m: f64| mounted.project(&(limb_m + cylinder.axis.direction * s_m));
        let (from, to) = (at(from_m)?, at(to_m)?);
        Some(Self {
            mounted,
            side,
            centre_px: (from + to) / 2.0,
            length_px: (to - from).norm(),
            sigma1_squared: 2.0 * PI.sqrt() * edge_sigma_px
                / (contrast_to_noise * contrast_to_noise),
        })
    }

    /// The limb of a cylinder as an image line.
    fn line(&self, cylinder: &Cylinder) -> Option<ImageLine> {
        let [plus, minus, _] =
            cylinder.image_lines(&self.mounted.camera, &self.mounted.rig_from_camera)?;
        Some(match self.side {
            Side::Plus => plus,
            Side::Minus => minus,
        })
    }

    /// Distance of the limb of a cylinder to this limb's centroid (px) and its angle (rad), relative to a line's normal.
    fn observe(&self, cylinder: &Cylinder, normal: &Pixel) -> Option<Vector2<f64>> {
        let line = self.line(cylinder)?;
        let n = if line.normal().dot(normal) < 0.0 {
            -line.normal()
        } else {
            line.normal()
        };
        let sign = n.dot(&line.normal()).signum();
        Some(Vector2::new(
            -line.distance_px(&self.centre_px) * sign,
            normal.perp(&n),
        ))
    }

    /// 1/variance of position (px⁻²) and angle (rad⁻²).
    fn information(&self) -> Vector2<f64> {
        let length = self.length_px;
        Vector2::new(length, length * length * length / 12.0) / self.sigma1_squared
    }
}

/// An eigenvalue of the correlation matrix below this is what rounding leaves of none.
const UNKNOWN: f64 = 1e-12;

fn propagate(cylinder: &Cylinder, limbs: &[Limb<'_>]) -> Option<Limit> {
    let d = cylinder.axis.direction;
    let e1 = d
        .cross(&if d.x.abs() < 0.7 {
            Vec3::x()
        } else {
            Vec3::y()
        })
        .normalize();
    let e2 = d.cross(&e1);
    let moved = |x: &Vector5<f64>| Cylinder {
        axis: Line3::new(
            cylinder.axis.point_m + e1 * x[0] + e2 * x[1],
            &(d + e1 * x[2] + e2 * x[3]),
        ),
        radius_m: cylinder.radius_m + x[4],
    };
    let mut information = Matrix5::zeros();
    for limb in limbs {
        let normal = limb.line(cylinder)?.normal();
        let mut jacobian = SMatrix::<f64, 2, 5>::zeros();
        for k in 0..5 {
            let mut step = Vector5::zeros();
            step[k] = 1e-6;
            let slope =
                limb.observe(&moved(&step), &normal)? - limb.observe(&moved(&-step), &normal)?;
            jacobian.set_column(k, &(slope / 2e-6));
        }
        information +=
            jacobian.transpose() * nalgebra::Matrix2::from_diagonal(&limb.information()) * jacobian;
    }
    // Scaled to correlations first: metres and radians differ by orders of magnitude.
    let scale = information.diagonal().map(|v| 1.0 / v.sqrt());
    let scaled = Matrix5::from_fn(|i, j| information[(i, j)] * scale[i] * scale[j]);
    let eigenvalues = scaled.symmetric_eigenvalues();
    // `!(…)` refuses NaN too: a parameter that no stretch knows.
    if !(eigenvalues.min() > UNKNOWN) {
        return None;
    }
    let covariance = scaled.try_inverse()?;
    let variance = |k: usize| covariance[(k, k)] * scale[k] * scale[k];
    Some(Limit {
        axis_offset_m: (variance(0) + variance(1)).sqrt(),
        axis_angle_rad: (variance(2) + variance(3)).sqrt(),
        radius_m: variance(4).sqrt(),
    })
}
