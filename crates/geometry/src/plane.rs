//! Planes in space.

use crate::{CameraFrame, Pose, RigFrame, Vec3};

/// The plane `n · x = offset`, n a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Signed distance of the origin to the plane along the normal, m.
    pub offset_m: f64,
}

impl Plane {
    /// The plane through a point.
    pub fn through(point_m: &Vec3, normal: &Vec3) -> Self {
        let normal = normal.normalize();
        Self {
            normal,
            offset_m: normal.dot(point_m),
        }
    }

    /// In the rig frame, the plane through the camera's centre with this normal in the camera frame: eqs (18)–(20).
    pub fn through_camera(
        rig_from_camera: &Pose<RigFrame, CameraFrame>,
        normal_in_camera: &Vec3,
    ) -> Self {
        Self::through(
            &rig_from_camera.origin_m(),
            &rig_from_camera.direction(normal_in_camera),
        )
    }

    /// Signed distance of a point, m.
    pub fn distance_m(&self, point_m: &Vec3) -> f64 {
        self.normal.dot(point_m) - self.offset_m
    }
}
