//! Typed rigid transforms.

use core::marker::PhantomData;
use core::ops::Mul;

use crate::{Mat3, Vec3};

/// Marker: the rig (vehicle) frame, x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RigFrame;
/// Marker: a camera's frame, x right, y down, z forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraFrame;

/// A rigid transform that takes coordinates in `From` to coordinates in `To`: `x_to = R x_from + t`.
///
/// Composition exists only where the inner frames agree:
///
/// ```compile_fail
/// use rodsight_geometry::{CameraFrame, Pose, RigFrame};
/// let rig_from_camera = Pose::<RigFrame, CameraFrame>::identity();
/// let _ = rig_from_camera * rig_from_camera;
/// ```
pub struct Pose<To, From> {
    rotation: Mat3,
    translation_m: Vec3,
    frames: PhantomData<fn(From) -> To>,
}

impl<To, From> Pose<To, From> {
    /// A pose from an orthonormal, right-handed rotation and the origin of `From` in `To`.
    pub fn new(rotation: Mat3, translation_m: Vec3) -> Self {
        Self {
            rotation,
            translation_m,
            frames: PhantomData,
        }
    }

    /// Both frames coincide.
    pub fn identity() -> Self {
        Self::new(Mat3::identity(), Vec3::zeros())
    }

    /// The rotation matrix R.
    pub fn rotation(&self) -> &Mat3 {
        &self.rotation
    }

    /// The origin of `From` seen in `To`, m.
    pub fn origin_m(&self) -> Vec3 {
        self.translation_m
    }

    /// A point of `From` in `To`, m.
    pub fn point(&self, point_in_from_m: &Vec3) -> Vec3 {
        self.rotation * point_in_from_m + self.translation_m
    }

    /// A direction of `From` in `To`.
    pub fn direction(&self, direction_in_from: &Vec3) -> Vec3 {
        self.rotation * direction_in_from
    }

    /// The transform back.
    pub fn inverse(&self) -> Pose<From, To> {
        let back = self.rotation.transpose();
        Pose::new(back, -(back * self.translation_m))
    }
}

impl<A, B, C> Mul<Pose<B, C>> for Pose<A, B> {
    type Output = Pose<A, C>;

    fn mul(self, rhs: Pose<B, C>) -> Pose<A, C> {
        Pose::new(self.rotation * rhs.rotation, self.point(&rhs.translation_m))
    }
}

// Derives would ask `To` and `From` to be Clone and so on; markers carry no data.
impl<To, From> Clone for Pose<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Pose<To, From> {}
impl<To, From> core::fmt::Debug for Pose<To, From> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Pose")
            .field("rotation", &self.rotation)
            .field("translation_m", &self.translation_m)
            .finish_non_exhaustive()
    }
}
impl<To, From> PartialEq for Pose<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation == other.rotation && self.translation_m == other.translation_m
    }
}

/// R = Rz(yaw) Ry(pitch) Rx(roll), angles in rad: the convention of the paper's Table 1.
pub fn rotation_from_rpy(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Mat3 {
    let (sr, cr) = libm::sincos(roll_rad);
    let (sp, cp) = libm::sincos(pitch_rad);
    let (sy, cy) = libm::sincos(yaw_rad);
    Mat3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_inverse_undoes_and_composition_chains() {
        let a = Pose::<RigFrame, CameraFrame>::new(
            rotation_from_rpy(0.3, -0.2, 1.1),
            Vec3::new(1.0, -2.0, 0.5),
        );
        let p = Vec3::new(0.2, 0.7, -1.3);
        assert!((a.inverse().point(&a.point(&p)) - p).norm() < 1e-14);
        let both: Pose<CameraFrame, CameraFrame> = a.inverse() * a;
        assert!((both.rotation() - Mat3::identity()).norm() < 1e-15);
        assert!(both.origin_m().norm() < 1e-15);
    }
}
