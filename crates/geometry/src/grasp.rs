//! Where to grasp: the paper's point and the surface-foot point.

use crate::{Cylinder, Line3, Vec3};

/// The axis point nearest to the pick ray, eqs (27)–(31), with unit directions: μ, ξ and the gap are in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperGrasp {
    /// The grasp point on the axis, m.
    pub point_m: Vec3,
    /// Position along the axis from its reference point, m.
    pub mu_m: f64,
    /// Distance along the pick ray, m; positive.
    pub xi_m: f64,
    /// Shortest distance between the ray and the axis, m.
    pub gap_m: f64,
}

/// Why a pick names no grasp point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum GraspError {
    #[error(
        "the pick ray is parallel to the rod ({angle_rad:.1e} rad): no point of the axis is nearest"
    )]
    Parallel { angle_rad: f64 },
    #[error(
        "the point of the axis nearest to the pick ray lies {distance_m:.3} m behind the camera"
    )]
    Behind { distance_m: f64 },
}

impl PaperGrasp {
    /// The closed form of (31): with unit d and D, w = `p_C` − t,
    /// μ = [(d·D)(w·D) − w·d] / (1 − (d·D)²).
    ///
    /// # Errors
    /// The ray is parallel to the axis, or the nearest point lies behind the camera (ξ ≤ 0).
    pub fn new(axis: &Line3, origin_m: &Vec3, direction: &Vec3) -> Result<Self, GraspError> {
        let (d, ray) = (axis.direction, direction.normalize());
        let sin = d.cross(&ray).norm();
        // `!(…)` refuses NaN too: a ray of no length.
        if !(sin >= 1e-9) {
            return Err(GraspError::Parallel { angle_rad: sin });
        }
        let w = axis.point_m - origin_m;
        let cos = d.dot(&ray);
        let mu_m = (cos * w.dot(&ray) - w.dot(&d)) / (sin * sin);
        let point_m = axis.point_m + d * mu_m;
        let xi_m = (point_m - origin_m).dot(&ray);
        if xi_m <= 0.0 {
            return Err(GraspError::Behind { distance_m: -xi_m });
        }
        Ok(Self {
            point_m,
            mu_m,
            xi_m,
            gap_m: (w + d * mu_m - ray * xi_m).norm(),
        })
    }
}

/// The foot, on the axis, of the first point where a ray from outside meets the surface: the primary grasp point. It differs from the
/// paper's by r cot ψ along the rod, ψ the angle between ray and axis, where the ray meets the axis (√(r² − gap²) cot ψ where
/// it passes it at a distance). `None` if the ray misses the cylinder or meets it
/// behind its origin.
pub fn surface_foot(cylinder: &Cylinder, origin_m: &Vec3, direction: &Vec3) -> Option<Vec3> {
    let ray = direction.normalize();
    let (near, _) = cylinder.intersect(origin_m, &ray)?;
    (near > 0.0).then(|| cylinder.axis.foot(&(origin_m + ray * near)))
}
