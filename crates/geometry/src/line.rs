//! Straight lines in space.

use crate::{Plane, Vec3, angle_between};

/// The line `p + μ d`, d a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line3 {
    /// A point of the line, m.
    pub point_m: Vec3,
    /// Unit direction; its sign carries no meaning.
    pub direction: Vec3,
}

/// Two planes that hardly intersect: a rod (nearly) parallel to the baseline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the two planes are {angle_rad:.3e} rad apart: their intersection is not defined")]
pub struct PlanesNearlyParallel {
    /// Angle between the planes, rad.
    pub angle_rad: f64,
}

impl Line3 {
    /// A line through a point; the direction need not be a unit vector but must not be zero.
    pub fn new(point_m: Vec3, direction: &Vec3) -> Self {
        Self {
            point_m,
            direction: direction.normalize(),
        }
    }

    /// Where two planes meet, and the point of it nearest to `from_m`: eqs (21)–(25) with unit normals, so that every
    /// quantity is in metres. With `from_m` in the first plane it is the paper's `p_C`.
    ///
    /// # Errors
    /// The planes are parallel to rounding. Whether a larger angle is still too small is for the caller's covariance to say.
    pub fn from_planes(
        first: &Plane,
        second: &Plane,
        from_m: &Vec3,
    ) -> Result<Self, PlanesNearlyParallel> {
        let cross = first.normal.cross(&second.normal);
        let sin = cross.norm();
        if sin < 1e-12 {
            return Err(PlanesNearlyParallel { angle_rad: sin });
        }
        let direction = cross / sin;
        let (a, b) = (first.distance_m(from_m), second.distance_m(from_m));
        // The foot is from − a n1* − b n2*, with the reciprocal basis of the two normals.
        let cos = first.normal.dot(&second.normal);
        let step = (first.normal * (a - b * cos) + second.normal * (b - a * cos)) / (sin * sin);
        Ok(Self {
            point_m: from_m - step,
            direction,
        })
    }

    /// The foot of the perpendicular from a point, m.
    pub fn foot(&self, point_m: &Vec3) -> Vec3 {
        self.point_m + self.direction * self.direction.dot(&(point_m - self.point_m))
    }

    /// Distance of a point to the line, m.
    pub fn distance_m(&self, point_m: &Vec3) -> f64 {
        (point_m - self.foot(point_m)).norm()
    }

    /// Shortest distance between two lines, m.
    pub fn distance_to_line_m(&self, other: &Self) -> f64 {
        let cross = self.direction.cross(&other.direction);
        let sin = cross.norm();
        if sin < 1e-12 {
            self.distance_m(&other.point_m)
        } else {
            (cross.dot(&(other.point_m - self.point_m)) / sin).abs()
        }
    }

    /// Angle between two lines, rad, in [0, π/2].
    pub fn angle_to(&self, other: &Self) -> f64 {
        let angle = angle_between(&self.direction, &other.direction);
        angle.min(core::f64::consts::PI - angle)
    }

    /// The same line with a fixed rule for its free sign: the component of largest modulus is positive.
    #[must_use]
    pub fn with_canonical_sign(&self) -> Self {
        let largest = self.direction[self.direction.iamax()];
        Self {
            direction: if largest < 0.0 {
                -self.direction
            } else {
                self.direction
            },
            ..*self
        }
    }
}
