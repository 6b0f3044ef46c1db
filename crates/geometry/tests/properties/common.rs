//! Random cases, the same on every run.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use rodsight_geometry::{
    CameraFrame, Cylinder, Line3, Mat3, Pose, RigFrame, Vec3, rotation_from_rpy,
};

/// A fixed seed and no file of failures: a failing case fails again by itself.
pub(crate) fn config() -> Config {
    Config {
        cases: 400,
        rng_seed: RngSeed::Fixed(0x0072_6f64),
        failure_persistence: None,
        ..Config::default()
    }
}

/// Any rotation.
pub(crate) fn rotation() -> impl Strategy<Value = Mat3> {
    (-3.1..3.1_f64, -1.5..1.5_f64, -3.1..3.1_f64).prop_map(|(r, p, y)| rotation_from_rpy(r, p, y))
}

/// Any unit vector.
pub(crate) fn unit() -> impl Strategy<Value = Vec3> {
    (-1.0..1.0_f64, -3.1..3.1_f64).prop_map(|(z, phi)| {
        let (sin, cos) = libm::sincos(phi);
        let across = (1.0 - z * z).sqrt();
        Vec3::new(across * cos, across * sin, z)
    })
}

/// A rod in front of the rig, at 2 to 5 m, so that every point within 1.1 m of the origin is outside it.
pub(crate) fn rod() -> impl Strategy<Value = Cylinder> {
    (unit(), 2.0..5.0_f64, unit(), 0.005..0.4_f64).prop_filter_map(
        "seen from the side",
        |(towards, distance_m, direction, radius_m)| {
            let axis = Line3::new(towards * distance_m, &direction);
            let foot_m = axis.distance_m(&Vec3::zeros());
            (foot_m > 1.7).then_some(Cylinder { axis, radius_m })
        },
    )
}

/// The poses of two cameras, within 1 m of the origin.
pub(crate) fn rig() -> impl Strategy<Value = [Pose<RigFrame, CameraFrame>; 2]> {
    (unit(), unit(), rotation(), rotation()).prop_filter_map("apart", |(a, b, r, s)| {
        ((a - b).norm() > 0.2).then(|| [Pose::new(r, a), Pose::new(s, b)])
    })
}
