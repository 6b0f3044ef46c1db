//! Balls and cubes under linear maps: stones, growth, occluders.

use rodsight_geometry::{Mat3, Vec3};

use super::solid::{Face, Ray, SolidHit};
use crate::bvh::Bounds;

/// The unit ball, or the cube from −1 to 1, under a linear map about a centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lump {
    pub(crate) centre_m: Vec3,
    /// Takes vectors from the centre to the unit ball's (or cube's) space.
    pub(crate) to_unit: Mat3,
    pub(crate) is_cube: bool,
    half_size_m: Vec3,
    /// The shortest half axis, m.
    pub(crate) shortest_m: f64,
}

impl Lump {
    /// `axes_m` holds the half axes as columns, perpendicular to each other.
    pub(crate) fn new(centre_m: Vec3, axes_m: &Mat3, is_cube: bool) -> Self {
        let length_m = Vec3::from_fn(|k, _| axes_m.column(k).norm());
        let to_unit = Mat3::from_fn(|i, j| axes_m[(j, i)] / (length_m[i] * length_m[i]));
        // A box reaches as far along an axis as its half edges together, an ellipsoid as their root sum of squares.
        let half_size_m = Vec3::from_fn(|k, _| {
            if is_cube {
                axes_m.row(k).abs().sum()
            } else {
                axes_m.row(k).norm()
            }
        });
        Self {
            centre_m,
            to_unit,
            is_cube,
            half_size_m,
            shortest_m: length_m.min(),
        }
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds {
            min_m: self.centre_m - self.half_size_m,
            max_m: self.centre_m + self.half_size_m,
        }
    }

    /// The first point of the surface on the ray; `None` also from inside.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<SolidHit> {
        let from = self.to_unit * (ray.origin_m - self.centre_m);
        let along = self.to_unit * ray.direction;
        let (t_m, unit_normal) = if self.is_cube {
            cube(&from, &along)?
        } else {
            ball(&from, &along)?
        };
        (t_m > 0.0).then(|| SolidHit {
            t_m,
            normal: self.to_unit.tr_mul(&unit_normal).normalize(),
            face: Face::Side,
        })
    }
}

/// Where a line first meets the unit ball, and the normal there. The nearest point of the line first: no cancellation from afar.
pub(crate) fn ball(from: &Vec3, along: &Vec3) -> Option<(f64, Vec3)> {
    let along2 = along.norm_squared();
    let middle = -from.dot(along) / along2;
    let nearest = from + along * middle;
    let chord2 = 1.0 - nearest.norm_squared();
    (chord2 > 0.0).then(|| {
        let t = middle - (chord2 / along2).sqrt();
        (t, from + along * t)
    })
}

/// Where a line first meets the cube, and the normal there.
pub(crate) fn cube(from: &Vec3, along: &Vec3) -> Option<(f64, Vec3)> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut normal = Vec3::zeros();
    for k in 0..3 {
        if along[k] == 0.0 {
            if from[k].abs() > 1.0 {
                return None;
            }
            continue;
        }
        let side = -along[k].signum();
        let (near, far) = ((side - from[k]) / along[k], (-side - from[k]) / along[k]);
        leave = leave.min(far);
        if near > enter {
            enter = near;
            normal = Vec3::zeros();
            normal[k] = side;
        }
    }
    (enter < leave).then_some((enter, normal))
}

#[cfg(test)]
mod tests {
    use rodsight_geometry::rotation_from_rpy;

    use super::*;

    fn ray(origin_m: Vec3, towards_m: Vec3) -> Ray {
        Ray {
            origin_m,
            direction: (towards_m - origin_m).normalize(),
        }
    }

    #[test]
    fn ball_is_a_sphere_to_the_last_digits_however_small_and_far() {
        let centre_m = Vec3::new(2.0, 0.3, -0.4);
        for radius_m in [1e-4, 0.01, 0.5] {
            let ball = Lump::new(centre_m, &(Mat3::identity() * radius_m), false);
            for off in [0.0, 0.5, 0.99] {
                let beside = centre_m + Vec3::new(0.0, off * radius_m, 0.0);
                let hit = ball.hit(&ray(beside - Vec3::x() * 2.0, beside)).unwrap();
                let expected = 2.0 - radius_m * (1.0 - off * off).sqrt();
                assert!(
                    (hit.t_m - expected).abs() < 1e-12,
                    "{radius_m} {off}: {}",
                    hit.t_m
                );
                assert!((hit.normal.y - off).abs() < 1e-9);
            }
            let beside = centre_m + Vec3::new(0.0, 1.01 * radius_m, 0.0);
            assert!(ball.hit(&ray(beside - Vec3::x(), beside)).is_none());
            assert!(
                ball.hit(&ray(centre_m, centre_m + Vec3::x())).is_none(),
                "from inside"
            );
            assert!(
                ball.hit(&ray(centre_m + Vec3::x(), centre_m + Vec3::x() * 2.0))
                    .is_none()
            );
        }
    }

    /// Every point of an ellipsoid's and of a box's surface is within the bounds, satisfies its equation and has its gradient.
    #[test]
    fn hits_lie_on_the_surface_and_in_the_bounds() {
        let turn = rotation_from_rpy(0.4, -0.9, 2.0);
        let axes_m = turn * Mat3::from_diagonal(&Vec3::new(0.3, 0.1, 0.2));
        for is_cube in [false, true] {
            let lump = Lump::new(Vec3::new(1.0, -0.5, 0.2), &axes_m, is_cube);
            let bounds = lump.bounds();
            let mut hits = 0;
            for i in 0..2000 {
                let angle = f64::from(i) * 2.4;
                let z = (f64::from(i) + 0.5) / 1000.0 - 1.0;
                let ring = (1.0 - z * z).sqrt();
                let out = Vec3::new(ring * libm::cos(angle), ring * libm::sin(angle), z);
                let aim = Vec3::new(z, libm::sin(3.0 * angle), libm::cos(5.0 * angle)) * 0.15;
                let ray = ray(lump.centre_m + out * 3.0, lump.centre_m + aim);
                let Some(hit) = lump.hit(&ray) else {
                    continue;
                };
                hits += 1;
                let point = ray.at(hit.t_m);
                let unit = turn.transpose() * (point - lump.centre_m);
                let unit = Vec3::new(unit.x / 0.3, unit.y / 0.1, unit.z / 0.2);
                let size = if is_cube { unit.amax() } else { unit.norm() };
                assert!((size - 1.0).abs() < 1e-12, "{size}");
                assert!((0..3).all(|k| {
                    point[k] >= bounds.min_m[k] - 1e-12 && point[k] <= bounds.max_m[k] + 1e-12
                }));
                assert!(hit.normal.dot(&ray.direction) < 0.0);
                assert!((hit.normal.norm() - 1.0).abs() < 1e-14);
            }
            assert!(hits > 500, "{hits}");
        }
    }

    #[test]
    fn bounds_are_tight() {
        let turn = rotation_from_rpy(0.4, -0.9, 2.0);
        let axes_m = turn * Mat3::from_diagonal(&Vec3::new(0.3, 0.1, 0.2));
        let ball = Lump::new(Vec3::zeros(), &axes_m, false);
        // A ray just within the box's face meets the ellipsoid somewhere on that face's level; just beyond, nowhere.
        let top = ball.bounds().max_m.z;
        // Where the gradient of the ellipsoid points along z.
        let highest = axes_m * (axes_m.transpose() * Vec3::z()).normalize();
        assert!((highest.z - top).abs() < 1e-14);
    }
}
