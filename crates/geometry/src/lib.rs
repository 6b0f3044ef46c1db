//! Frames, cameras, lines, planes, cylinders and stereo rigs: the vocabulary every other crate speaks.
//!
//! Everything is `f64`, SI and radians. Frames are in the types of [`Pose`] and in the names of vectors:
//! `rig_from_left` takes a point of the left camera's frame to the rig's.
//!
//! * rig (vehicle): x forward, y starboard, z down;
//! * camera: x right, y down, z forward (the optical axis);
//! * pixels: continuous, (0, 0) is the top-left *corner*, the first pixel's centre is (0.5, 0.5);
//! * image lines: `u cos θ + v sin θ = ρ`, θ in (−π/2, π/2], ρ signed.
//!
//! Equation numbers in plain brackets, as (17), are those of the founding paper (Wang, Wang, Leng 2022,
//! Mobile Information Systems, 2884611), mended where its print is wrong; see `ARCHITECTURE.md`.
//!
//! This crate neither renders nor estimates: it only says what the words mean.

mod camera;
pub mod config;
mod cylinder;
mod frame;
mod grasp;
mod image;
mod image_line;
mod line;
mod plane;
pub mod port;
mod rig;

pub use camera::{Camera, CameraError, Distortion, Intrinsics};
pub use cylinder::{
    Cylinder, CylinderError, CylinderFit, OneView, Side, TangentPair, TangentPlane,
};
pub use frame::{CameraFrame, Pose, RigFrame, rotation_from_rpy};
pub use grasp::{GraspError, PaperGrasp, surface_foot};
pub use image::{Image, ImageError, Samples, StereoPair};
pub use image_line::{ImageLine, LineFit};
pub use line::{Line3, PlanesNearlyParallel};
pub use plane::Plane;
pub use port::Band;
pub use rig::{
    CameraEntry, DistortionEntry, DomePortEntry, Eye, FlatPortEntry, MountEntry, MountedCamera,
    PixelOrigin, PortEntry, Rig, RigError, RigFile, Sight,
};

/// A vector or point of three metres (or a unit direction); the name of the variable says which frame.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A point in the image, px, from the top-left corner.
pub type Pixel = nalgebra::Vector2<f64>;
/// A 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Radians from degrees.
pub const fn radians(angle_deg: f64) -> f64 {
    angle_deg * (core::f64::consts::PI / 180.0)
}

/// Degrees from radians.
pub const fn degrees(angle_rad: f64) -> f64 {
    angle_rad * (180.0 / core::f64::consts::PI)
}

/// The angle between two directions of any length, rad, in [0, π]; exact near 0 and π, unlike `acos` of the dot product.
pub fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}
