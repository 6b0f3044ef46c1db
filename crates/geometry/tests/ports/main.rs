//! Cameras behind glass: rays against projections, both against Fermat, the published quartic and the textbook's limits.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod aperture;
mod calibration;
mod files;
mod limits;
mod rays;

use rodsight_geometry::port::{DomePort, FlatPort, Port, PortShape, sea_water_index};
use rodsight_geometry::{
    Camera, Distortion, Intrinsics, MountedCamera, Pose, RigFrame, Vec3, radians, rotation_from_rpy,
};

/// The indices of optics textbooks for acrylic and, in all bands, water.
const GLASS: f64 = 1.49;
const WATER: f64 = 1.34;

/// Half of a horizontal field of view of 63° in the water.
const HALF_FIELD_DEG: f64 = 31.5;

/// A 1080p camera in air that sees 63° through a flat port in water.
fn camera() -> Camera {
    let sin = WATER * libm::sin(radians(HALF_FIELD_DEG));
    let focal_px = 960.0 / libm::tan(libm::asin(sin));
    Camera::new(
        Intrinsics {
            width_px: 1920,
            height_px: 1080,
            fx_px: focal_px,
            fy_px: focal_px,
            cx_px: 960.0,
            cy_px: 540.0,
        },
        Distortion::None,
    )
    .unwrap()
}

fn flat(distance_m: f64, thickness_m: f64, normal: Vec3) -> PortShape {
    PortShape::Flat(FlatPort {
        normal: normal.normalize(),
        distance_m,
        thickness_m,
    })
}

fn dome(centre_m: Vec3, inner_radius_m: f64, thickness_m: f64) -> PortShape {
    PortShape::Dome(DomePort {
        centre_m,
        inner_radius_m,
        thickness_m,
    })
}

/// Behind acrylic, in sea water that disperses.
fn behind(shape: PortShape) -> MountedCamera {
    with_indices(shape, GLASS, sea_water_index(35.0, 10.0))
}

fn with_indices(shape: PortShape, glass: f64, water: [f64; 3]) -> MountedCamera {
    let pose: Pose<RigFrame, _> = Pose::new(
        rotation_from_rpy(radians(90.0), 0.05, radians(80.0)),
        Vec3::new(0.1, -0.5, -1.0),
    );
    MountedCamera {
        port: Some(Port::new(shape, glass, water).unwrap()),
        ..MountedCamera::new(camera(), pose)
    }
}

/// Ports as they are built, and worse.
fn ports() -> Vec<PortShape> {
    vec![
        flat(0.02, 0.01, Vec3::z()),
        flat(0.1, 0.02, Vec3::z()),
        flat(0.02, 0.01, Vec3::new(0.1, -0.05, 1.0)),
        flat(0.05, 0.006, Vec3::new(-0.35, 0.2, 1.0)),
        flat(0.0, 0.0, Vec3::z()),
        flat(0.0, 0.01, Vec3::z()),
        dome(Vec3::zeros(), 0.06, 0.006),
        dome(Vec3::new(0.002, -0.001, 0.003), 0.06, 0.006),
        dome(Vec3::new(0.0, 0.0, -0.01), 0.05, 0.004),
        dome(Vec3::new(-0.02, 0.015, 0.03), 0.05, 0.01),
    ]
}
