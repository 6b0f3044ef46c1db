//! Circular arcs as curves: the axes of bent rods.

use rodsight_geometry::{Line3, Vec3};
use rodsight_scene::Rod;

/// A circular arc as a curve: the axis of a bent rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    centre_m: Vec3,
    direction: Vec3,
    towards: Vec3,
    /// 1/R; zero for a straight rod.
    pub(crate) curvature_per_m: f64,
}

impl Arc {
    pub(crate) fn of(rod: &Rod) -> Self {
        Self {
            centre_m: rod.centre_m,
            direction: rod.direction,
            towards: rod.bend.map_or(Vec3::zeros(), |bend| bend.towards),
            curvature_per_m: rod.bend_radius_m().map_or(0.0, |radius_m| 1.0 / radius_m),
        }
    }

    /// Point and unit tangent at arc length `s_m` from the middle.
    pub(crate) fn at(&self, s_m: f64) -> Line3 {
        if self.curvature_per_m == 0.0 {
            return Line3 {
                point_m: self.centre_m + self.direction * s_m,
                direction: self.direction,
            };
        }
        let (sin, cos) = libm::sincos(self.curvature_per_m * s_m);
        // 1 − cos by the half angle: a slight bend must not cancel.
        let half_sin = libm::sin(0.5 * self.curvature_per_m * s_m);
        let versine = 2.0 * half_sin * half_sin;
        Line3 {
            point_m: self.centre_m
                + (self.direction * sin + self.towards * versine) / self.curvature_per_m,
            direction: self.direction * cos + self.towards * sin,
        }
    }

    /// Unit vector to the arc's centre from where it has a tangent; zero for a straight rod.
    pub(crate) fn inward(&self, tangent: &Vec3) -> Vec3 {
        self.towards * tangent.dot(&self.direction) - self.direction * tangent.dot(&self.towards)
    }

    /// Two unit vectors across the tangent at arc length s, right-handed with it: to the arc's centre first, and for a straight rod
    /// as near to a fixed axis as may be.
    pub(crate) fn across(&self, s_m: f64) -> [Vec3; 2] {
        let tangent = self.at(s_m).direction;
        let side = if self.curvature_per_m == 0.0 {
            let mut flattest = Vec3::zeros();
            flattest[self.direction.iamin()] = 1.0;
            self.direction.cross(&flattest).normalize()
        } else {
            self.direction.cross(&self.towards)
        };
        [side.cross(&tangent), side]
    }

    /// Arc length of the point of the curve nearest to `point_m`.
    pub(crate) fn parameter_of(&self, point_m: &Vec3) -> f64 {
        let w = point_m - self.centre_m;
        let along = w.dot(&self.direction);
        if self.curvature_per_m == 0.0 {
            return along;
        }
        libm::atan2(along, 1.0 / self.curvature_per_m - w.dot(&self.towards)) / self.curvature_per_m
    }
}
