//! Analytic capped cylinders.

use rodsight_geometry::{Cylinder, Line3, Vec3};

use crate::bvh::Bounds;

/// A ray with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin_m: Vec3,
    pub(crate) direction: Vec3,
}

impl Ray {
    pub(crate) fn at(&self, t_m: f64) -> Vec3 {
        self.origin_m + self.direction * t_m
    }
}

/// Which part of a rod was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Face {
    Side,
    Cap,
}

/// Where a ray meets a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidHit {
    pub(crate) t_m: f64,
    pub(crate) normal: Vec3,
    pub(crate) face: Face,
}

/// A shading normal as a ray can see it, of unit length: one that looks away, as beside the silhouette of a rounded mesh, is turned
/// until it is square to the ray, so that nothing jumps there.
pub(crate) fn facing(normal: &Vec3, direction: &Vec3, face_normal: &Vec3) -> Vec3 {
    let turned = normal - direction * normal.dot(direction).max(0.0);
    turned.try_normalize(1e-6).unwrap_or(*face_normal)
}

/// A finite capped cylinder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capped {
    pub(crate) cylinder: Cylinder,
    pub(crate) half_length_m: f64,
}

impl Capped {
    pub(crate) fn new(centre_m: Vec3, direction: Vec3, half_length_m: f64, radius_m: f64) -> Self {
        Self {
            cylinder: Cylinder {
                axis: Line3 {
                    point_m: centre_m,
                    direction,
                },
                radius_m,
            },
            half_length_m,
        }
    }

    /// The smallest box around it: a disc of unit normal d and radius r reaches r √(1 − d²) along an axis.
    pub(crate) fn bounds(&self) -> Bounds {
        let axis = &self.cylinder.axis;
        let reach_m = axis.direction.map(|d| {
            self.half_length_m * d.abs() + self.cylinder.radius_m * (1.0 - d * d).max(0.0).sqrt()
        });
        Bounds {
            min_m: axis.point_m - reach_m,
            max_m: axis.point_m + reach_m,
        }
    }

    /// The first point of the surface on the ray; `None` also from inside.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<SolidHit> {
        let axis = &self.cylinder.axis;
        let cross = ray.direction.cross(&axis.direction);
        let triple = cross.dot(&(axis.point_m - ray.origin_m));
        let reach2 = self.cylinder.radius_m * self.cylinder.radius_m * cross.norm_squared();
        // Most rays miss. The slack leaves every doubt, and rays along the axis, to the exact test.
        if triple * triple > reach2 * (1.0 + 1e-9) + 1e-24 {
            return None;
        }
        self.near_hit(ray)
    }

    fn near_hit(&self, ray: &Ray) -> Option<SolidHit> {
        let axis = &self.cylinder.axis;
        let d = axis.direction;
        let start = d.dot(&(ray.origin_m - axis.point_m));
        let rate = d.dot(&ray.direction);
        // Part of the ray between the two end planes.
        let (mut enter, mut leave, mut face) = (f64::NEG_INFINITY, f64::INFINITY, Face::Cap);
        if rate.abs() > 1e-15 {
            let (a, b) = (
                (-self.half_length_m - start) / rate,
                (self.half_length_m - start) / rate,
            );
            (enter, leave) = (a.min(b), a.max(b));
        } else if start.abs() > self.half_length_m {
            return None;
        }
        match self.cylinder.intersect(&ray.origin_m, &ray.direction) {
            Some((near, far)) => {
                if near > enter {
                    (enter, face) = (near, Face::Side);
                }
                leave = leave.min(far);
            }
            // A miss, or a ray along the axis: inside the infinite cylinder or not.
            None if axis.distance_m(&ray.origin_m) > self.cylinder.radius_m || rate.abs() < 0.5 => {
                return None;
            }
            None => {}
        }
        if enter >= leave || enter <= 0.0 {
            return None;
        }
        let normal = match face {
            Face::Side => {
                let point = ray.at(enter);
                (point - axis.foot(&point)) / self.cylinder.radius_m
            }
            Face::Cap => d * -rate.signum(),
        };
        Some(SolidHit {
            t_m: enter,
            normal,
            face,
        })
    }

    /// Whether the ray passes the cylinder's limb closer than `footprint` (rad) allows one sample to tell.
    pub(crate) fn grazes(&self, ray: &Ray, footprint_rad: f64) -> bool {
        let axis = &self.cylinder.axis;
        let cross = ray.direction.cross(&axis.direction);
        let sin2 = cross.norm_squared();
        let w = axis.point_m - ray.origin_m;
        if sin2 < 1e-12 {
            return true;
        }
        let cos = ray.direction.dot(&axis.direction);
        let t = (w.dot(&ray.direction) - cos * w.dot(&axis.direction)) / sin2;
        let s = (cos * w.dot(&ray.direction) - w.dot(&axis.direction)) / sin2;
        let (margin, radius, sin) = (t * footprint_rad, self.cylinder.radius_m, sin2.sqrt());
        // A ray through the rim of a cap comes nearest to the axis at most r |cos|/sin beyond the cap.
        t > 0.0
            && s.abs() <= self.half_length_m + (margin + radius * cos.abs()) / sin
            && (cross.dot(&w).abs() / sin - radius).abs() < margin
    }

    /// Whether the first `length_m` of the ray meet the cylinder.
    pub(super) fn blocks(&self, ray: &Ray, length_m: f64) -> bool {
        self.hit(ray).is_some_and(|hit| hit.t_m < length_m)
    }
}
