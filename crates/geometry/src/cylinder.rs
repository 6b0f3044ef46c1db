//! Circular cylinders: limbs, tangent planes, and the cylinder from its tangent planes.
//!
//! Derivations: tangent planes n± = cos α n₀ ± sin α p̂, sin α = r/D, with d the axis direction, p̂ the unit vector from the
//! camera centre perpendicular to the axis, n₀ = p̂ × d, D the distance of the centre to the axis.

use nalgebra::{SMatrix, SVector};

use crate::{Camera, CameraFrame, ImageLine, Line3, Pose, RigFrame, Vec3};

/// An infinite circular cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Centre line.
    pub axis: Line3,
    /// Radius, m.
    pub radius_m: f64,
}

/// On which side of the axis a limb lies: the axis is at distance `s r` along the tangent plane's normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// s = +1.
    Plus,
    /// s = −1.
    Minus,
}

impl Side {
    /// +1 or −1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Plus => 1.0,
            Self::Minus => -1.0,
        }
    }
}

/// The two planes through a camera centre that touch a cylinder, and the plane that holds its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPair {
    /// Unit normal n₊ with n₊ · (p − C) = +r.
    pub plus: Vec3,
    /// Unit normal n₋ with n₋ · (p − C) = −r.
    pub minus: Vec3,
    /// Unit normal n₀ of the plane through the centre and the axis: the bisector of the two.
    pub axis_plane: Vec3,
}

/// What one view tells of a cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneView {
    /// Unit normal of the plane through the camera centre and the axis.
    pub axis_plane: Vec3,
    /// Unit direction of the axis (from the convergence of the limbs: weak for thin rods).
    pub direction: Vec3,
    /// Unit vector from the camera centre, perpendicular to the axis, towards it.
    pub towards: Vec3,
    /// Radius over distance of the centre to the axis.
    pub sin_half_angle: f64,
    /// Which side the first given normal was, after turning both alike.
    pub first_side: Side,
    /// The two normals as given, turned so that `n_a · n_b > 0`.
    pub normals: [Vec3; 2],
}

/// A tangent plane of a cylinder, in any common frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPlane {
    /// Unit normal; all normals of one view turned alike.
    pub normal: Vec3,
    /// Camera centre it passes through, m.
    pub centre_m: Vec3,
    /// Which limb it is.
    pub side: Side,
}

/// A cylinder from tangent planes, and how well they agreed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderFit {
    /// The cylinder.
    pub cylinder: Cylinder,
    /// Root mean square of `n · (p − C) − s r`, m.
    pub residual_m: f64,
    /// Smallest over largest singular value of the linear system for (p, r): near zero, the position is not observable.
    pub conditioning: f64,
}

/// Why no cylinder follows from tangent planes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum CylinderError {
    #[error("expected at least {needed} tangent planes, found {found}")]
    TooFewPlanes { needed: usize, found: usize },
    #[error("tangent plane {index}: expected finite numbers")]
    NotFinite { index: usize },
    #[error(
        "the position of the axis is not observable (conditioning {conditioning:.1e}), as for a rod parallel to the baseline"
    )]
    Degenerate { conditioning: f64 },
    #[error(
        "the tangent planes give a radius of {radius_m} m: the limbs are exchanged, or are not of one rod"
    )]
    NegativeRadius { radius_m: f64 },
}

impl TangentPair {
    /// What these two tangent planes say of the cylinder. `seen` is any direction, in the same frame, in which the axis is
    /// seen: it tells which plane is which. The order and the signs of the two normals do not matter.
    ///
    ///   n₀ = (n₊ + n₋)/(2 cos α), p̂ = (n₊ − n₋)/(2 sin α), d = n₋ × n₊ / sin 2α
    ///
    /// `None` if the planes coincide. The rod must be seen under less than a right angle (D > √2 r): nearer, turning the
    /// normals alike is no longer unique.
    pub fn one_view(n_a: &Vec3, n_b: &Vec3, seen: &Vec3) -> Option<OneView> {
        let n_a = *n_a;
        let n_b = if n_a.dot(n_b) < 0.0 { -n_b } else { *n_b };
        let difference = n_a - n_b;
        let sin = 0.5 * difference.norm();
        // `!(…)` refuses NaN too.
        if !(sin >= 1e-12) {
            return None;
        }
        let a_is_plus = difference.dot(seen) > 0.0;
        let (plus, minus) = if a_is_plus { (n_a, n_b) } else { (n_b, n_a) };
        Some(OneView {
            axis_plane: (n_a + n_b).normalize(),
            direction: minus.cross(&plus).normalize(),
            towards: (plus - minus) / (2.0 * sin),
            sin_half_angle: sin,
            first_side: if a_is_plus { Side::Plus } else { Side::Minus },
            normals: [n_a, n_b],
        })
    }
}

impl Cylinder {
    /// The planes through `centre_m` that touch the cylinder; `None` from inside it.
    pub fn tangent_planes(&self, centre_m: &Vec3) -> Option<TangentPair> {
        let d = self.axis.direction;
        let q = self.axis.foot(centre_m) - centre_m;
        let distance = q.norm();
        // `!(…)` refuses NaN too.
        if !(distance > self.radius_m) {
            return None;
        }
        let towards = q / distance;
        let axis_plane = towards.cross(&d);
        let sin = self.radius_m / distance;
        let cos = libm::sqrt(1.0 - sin * sin);
        Some(TangentPair {
            plus: axis_plane * cos + towards * sin,
            minus: axis_plane * cos - towards * sin,
            axis_plane,
        })
    }

    /// The limbs (plus, minus) and the axis as lines of the undistorted image; `None` from inside the cylinder or when a
    /// plane is parallel to the image.
    pub fn image_lines(
        &self,
        camera: &Camera,
        rig_from_camera: &Pose<RigFrame, CameraFrame>,
    ) -> Option<[ImageLine; 3]> {
        let planes = self.tangent_planes(&rig_from_camera.origin_m())?;
        let camera_from_rig = rig_from_camera.inverse();
        let line = |normal: &Vec3| camera.image_line(&camera_from_rig.direction(normal));
        Some([
            line(&planes.plus)?,
            line(&planes.minus)?,
            line(&planes.axis_plane)?,
        ])
    }

    /// The cylinder that touches three or more planes, at least three of them in two or more views.
    ///
    /// The direction is the right singular vector of the normals; then `n·p − s r = n·C`, `d·p = 0` is linear in (p, r).
    /// With a known radius the system keeps full rank for a rod parallel to the baseline, and two views of one limb, or
    /// one view of both, suffice. The rows `d·p = 0` and `r = known` weigh as much as all planes together, so that
    /// giving every plane twice changes nothing.
    ///
    /// # Errors
    /// Too few planes, numbers that are not finite, a position that is not observable, or a radius that is not positive.
    pub fn from_tangent_planes(
        planes: &[TangentPlane],
        known_radius_m: Option<f64>,
    ) -> Result<CylinderFit, CylinderError> {
        let needed = if known_radius_m.is_some() { 2 } else { 3 };
        if planes.len() < needed {
            return Err(CylinderError::TooFewPlanes {
                needed,
                found: planes.len(),
            });
        }
        let finite = |p: &TangentPlane| {
            let sum = p.normal + p.centre_m;
            sum.iter().all(|v| v.is_finite())
        };
        // The iterations below would not end on NaN.
        if let Some(index) = planes.iter().position(|p| !finite(p)) {
            return Err(CylinderError::NotFinite { index });
        }
        if let Some(radius_m) = known_radius_m
            && !(radius_m > 0.0 && radius_m.is_finite())
        {
            return Err(CylinderError::NegativeRadius { radius_m });
        }
        let normals = triangular(planes.iter().map(|p| p.normal));
        let direction = least_right_vector(&normals);

        // Distances are taken from the mean centre, so that d·p = 0 does not put p far away.
        let origin = planes.iter().map(|p| p.centre_m).sum::<Vec3>() / planes.len() as f64;
        let all = (planes.len() as f64).sqrt();
        let mut rows: Vec<SVector<f64, 5>> = Vec::with_capacity(planes.len() + 2);
        for plane in planes {
            let (n, s) = (plane.normal, plane.side.sign());
            let c = n.dot(&(plane.centre_m - origin));
            rows.push(match known_radius_m {
                None => SVector::from([n.x, n.y, n.z, -s, c]),
                Some(radius_m) => SVector::from([n.x, n.y, n.z, 0.0, c + s * radius_m]),
            });
        }
        rows.push(SVector::from([direction.x, direction.y, direction.z, 0.0, 0.0]) * all);
        if let Some(radius_m) = known_radius_m {
            rows.push(SVector::from([0.0, 0.0, 0.0, 1.0, radius_m]) * all);
        }
        // Not the normal equations: they would square the conditioning.
        let system = triangular(rows.into_iter());
        let matrix = system.fixed_view::<4, 4>(0, 0).into_owned();
        let values = matrix.singular_values();
        let conditioning = values.min() / values.max();
        let solution = (conditioning >= 1e-7)
            .then(|| matrix.solve_upper_triangular(&system.fixed_view::<4, 1>(0, 4)))
            .flatten()
            .ok_or(CylinderError::Degenerate { conditioning })?;
        let radius_m = solution.w;
        if !(radius_m > 0.0) {
            return Err(CylinderError::NegativeRadius { radius_m });
        }
        let axis = Line3 {
            point_m: origin + solution.xyz(),
            direction,
        };
        let squares: f64 = planes
            .iter()
            .map(|p| p.normal.dot(&(axis.point_m - p.centre_m)) - p.side.sign() * radius_m)
            .map(|g| g * g)
            .sum();
        let residual_m = libm::sqrt(squares / planes.len() as f64);
        Ok(CylinderFit {
            cylinder: Self { axis, radius_m },
            residual_m,
            conditioning,
        })
    }

    /// Distances along a unit ray at which it enters and leaves the infinite cylinder; `None` if it misses.
    pub fn intersect(&self, origin_m: &Vec3, direction: &Vec3) -> Option<(f64, f64)> {
        let d = self.axis.direction;
        let w = origin_m - self.axis.point_m;
        let across_dir = direction - d * d.dot(direction);
        let across_w = w - d * d.dot(&w);
        let a = across_dir.norm_squared();
        if a < 1e-30 {
            return None;
        }
        // From the point nearest the axis: no cancellation for thin far rods.
        let nearest = -across_dir.dot(&across_w) / a;
        let gap2 = (across_w + across_dir * nearest).norm_squared();
        let inside2 = self.radius_m * self.radius_m - gap2;
        if inside2 < 0.0 {
            return None;
        }
        let half = libm::sqrt(inside2 / a);
        Some((nearest - half, nearest + half))
    }

    /// Signed distance between a ray and the surface, m, zero where the ray touches:
    /// `g = (p − o)·m̂ − s r`, m = v × d. Any camera, distorted or behind a port, has such rays.
    pub fn tangency_residual_m(
        &self,
        origin_m: &Vec3,
        direction: &Vec3,
        side: Side,
    ) -> Option<f64> {
        let m = direction.cross(&self.axis.direction);
        let norm = m.norm();
        (norm > 1e-12)
            .then(|| (self.axis.point_m - origin_m).dot(&m) / norm - side.sign() * self.radius_m)
    }
}

/// The upper triangle R of a QR decomposition, row by row with Givens rotations: `Rᵀ R = Σ row rowᵀ` without squaring.
fn triangular<const N: usize>(rows: impl Iterator<Item = SVector<f64, N>>) -> SMatrix<f64, N, N> {
    let mut r = SMatrix::<f64, N, N>::zeros();
    for mut row in rows {
        for k in 0..N {
            let length = libm::hypot(r[(k, k)], row[k]);
            if length == 0.0 {
                continue;
            }
            let (cos, sin) = (r[(k, k)] / length, row[k] / length);
            for column in k..N {
                let (a, b) = (r[(k, column)], row[column]);
                r[(k, column)] = cos * a + sin * b;
                row[column] = cos * b - sin * a;
            }
        }
    }
    r
}

/// The right singular vector of the smallest singular value of a triangle, by inverse iteration: nalgebra decomposes 3×3
/// matrices by way of `Rᵀ R`, which squares the conditioning.
fn least_right_vector(r: &crate::Mat3) -> Vec3 {
    let mut vector = r
        .svd(false, true)
        .v_t
        .expect("the right singular vectors were asked for")
        .row(2)
        .transpose();
    // A perturbation of rounding size makes exact data invertible.
    let floor = (1e-16 * r.norm()).max(f64::MIN_POSITIVE);
    let diagonal = r.diagonal();
    let mut invertible = *r;
    invertible.set_diagonal(&diagonal.map(|x| if x.abs() < floor { floor } else { x }));
    for _ in 0..3 {
        let back = invertible
            .tr_solve_upper_triangular(&vector)
            .and_then(|y| invertible.solve_upper_triangular(&y));
        match back {
            Some(next) if next.norm().is_finite() => vector = next.normalize(),
            _ => break,
        }
    }
    vector
}
