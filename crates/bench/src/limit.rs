//! The statistical limit: how accurate any unbiased method can be on a pair (Cramér 1946, Rao 1945).

use core::f64::consts::PI;

use nalgebra::{Matrix5, SMatrix, Vector2, Vector5};
use rodsight_geometry::{Cylinder, Line3, MountedCamera, Pixel, RigError, Vec3};
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

/// Blur of an edge by the pixel's aperture alone, px: a box of one pixel has the variance 1/12.
const APERTURE_SIGMA_PX: f64 = 0.288_675_134_594_812_9;

/// One limb as a measurement: where it is seen, over which length, with which contrast.
struct Limb<'a> {
    mounted: &'a MountedCamera,
    plus: bool,
    centre_px: Pixel,
    length_px: f64,
    contrast_to_noise: f64,
}

/// The limit of a pair with a straight rod seen by two cameras without distortion; `None` for others, without noise, or where
/// a limb is not seen.
///
/// A straight edge of contrast-to-noise A/σ, blur `σ_t` and length L fixes its position at the centroid and its angle to
///
///   var ρ = σ₁²/L,  var θ = 12 σ₁²/L³,  σ₁² = 2√π `σ_t` (σ/A)²
///
/// and the five parameters of the cylinder follow from the eight of four limbs: Σ = (Jᵀ W J)⁻¹.
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
    let middle = Vec3::from(rod.axis.point_m);
    let limbs = [
        (&rig.left, &rod.left, true),
        (&rig.left, &rod.left, false),
        (&rig.right, &rod.right, true),
        (&rig.right, &rod.right, false),
    ]
    .map(|(mounted, eye, plus)| limb(&cylinder, &middle, mounted, eye, plus));
    let [Some(a), Some(b), Some(c), Some(d)] = limbs else {
        return Ok(None);
    };
    Ok(propagate(&cylinder, &[a, b, c, d]))
}

fn limb<'a>(
    cylinder: &Cylinder,
    middle_m: &Vec3,
    mounted: &'a MountedCamera,
    eye: &EyeTruth,
    plus: bool,
) -> Option<Limb<'a>> {
    eye.lines.as_ref()?;
    let planes = cylinder.tangent_planes(&mounted.rig_from_camera.origin_m())?;
    let towards_limb = if plus { -planes.plus } else { planes.minus } * cylinder.radius_m;
    let end =
        |s_m: f64| mounted.project(&(middle_m + cylinder.axis.direction * s_m + towards_limb));
    let [from_m, to_m] = seen_by(eye)?;
    let (from, to) = (end(from_m)?, end(to_m)?);
    Some(Limb {
        mounted,
        plus,
        centre_px: (from + to) / 2.0,
        length_px: (to - from).norm(),
        contrast_to_noise: eye.contrast_to_noise[usize::from(!plus)]?,
    })
}

impl Limb<'_> {
    /// Distance of the limb of a cylinder to this limb's centroid (px) and its angle (rad), relative to a line's normal.
    fn observe(&self, cylinder: &Cylinder, normal: &Pixel) -> Option<Vector2<f64>> {
        let [plus, minus, _] =
            cylinder.image_lines(&self.mounted.camera, &self.mounted.rig_from_camera)?;
        let line = if self.plus { plus } else { minus };
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
        let ratio = 1.0 / self.contrast_to_noise;
        let sigma1_squared = 2.0 * PI.sqrt() * APERTURE_SIGMA_PX * ratio * ratio;
        let length = self.length_px;
        Vector2::new(length, length * length * length / 12.0) / sigma1_squared
    }
}

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
        let [plus, minus, _] =
            cylinder.image_lines(&limb.mounted.camera, &limb.mounted.rig_from_camera)?;
        let normal = if limb.plus {
            plus.normal()
        } else {
            minus.normal()
        };
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
    let covariance = scaled.try_inverse()?;
    let variance = |k: usize| covariance[(k, k)] * scale[k] * scale[k];
    Some(Limit {
        axis_offset_m: (variance(0) + variance(1)).sqrt(),
        axis_angle_rad: (variance(2) + variance(3)).sqrt(),
        radius_m: variance(4).sqrt(),
    })
}
