//! A renderer of its own, so that the solver is not tested against the code it will be used with: the projection of a long
//! cylinder is the wedge between its two tangent planes, painted by supersampling.
#![allow(
    dead_code,
    unused_imports,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each test file uses a part"
)]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the files`"
)]

mod image;
mod lens;
mod random;
mod rays;
mod scene;

pub use random::Random;
pub use scene::{Ball, Disc, Scene, Texture};

use rodsight_geometry::{
    Camera, CameraFrame, Cylinder, Distortion, Eye, Intrinsics, Line3, Mat3, MountedCamera, Pose,
    Rig, RigFrame, Vec3,
};
use rodsight_solver::{Estimate, Method, PaperParams, Request, Status, solve};

/// Colours in 0…1.
pub const ORANGE: [f64; 3] = [0.85, 0.42, 0.08];
pub const WATER: [f64; 3] = [0.10, 0.32, 0.45];

/// The paper's rig: 1920×1080, 63° across, 1 m baseline, parallel axes.
pub fn rig() -> Rig {
    rig_of(1920, 1080, 1566.5776, Distortion::None)
}

/// The same field of view with fewer pixels.
pub fn small_rig() -> Rig {
    rig_of(640, 360, 1566.5776 / 3.0, Distortion::None)
}

pub fn rig_of(width_px: u32, height_px: u32, focal_px: f64, distortion: Distortion) -> Rig {
    let intrinsics = Intrinsics {
        width_px,
        height_px,
        fx_px: focal_px,
        fy_px: focal_px,
        cx_px: 0.5 * f64::from(width_px),
        cy_px: 0.5 * f64::from(height_px),
    };
    let camera = Camera::new(intrinsics, distortion).expect("a camera");
    let mounted = |y_m: f64| {
        let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let pose = Pose::<RigFrame, CameraFrame>::new(axes, Vec3::new(0.0, y_m, -1.0));
        MountedCamera::new(camera, pose)
    };
    Rig {
        left: mounted(-0.5),
        right: mounted(0.5),
    }
}

/// A rod through a point of the rig frame, given relative to the midpoint of the cameras (forward, starboard, down).
pub fn rod(at: [f64; 3], direction: [f64; 3], radius_m: f64) -> Cylinder {
    Cylinder {
        axis: Line3::new(
            Vec3::from(at) + Vec3::new(0.0, 0.0, -1.0),
            &Vec3::from(direction),
        ),
        radius_m,
    }
}

/// A pick at the image of a point on the axis.
pub fn pick_at(rig: &Rig, eye: Eye, point_m: &Vec3) -> rodsight_solver::Pick {
    rodsight_solver::Pick {
        pixel: rig
            .eye(eye)
            .project(point_m)
            .expect("in front of the camera"),
        eye,
    }
}

/// The rod of the small scene.
pub fn truth() -> Cylinder {
    rod([1.5, 0.05, 0.0], [0.3, 0.3, 1.0], 0.05)
}

/// One rod before the small rig.
pub fn scene() -> Scene {
    Scene::new(&small_rig(), vec![truth()])
}

pub fn bisector(request: &Request<'_>) -> Estimate {
    solve(request, Method::PaperBisector, &PaperParams::default()).unwrap()
}

/// Distance of the estimated axis to the true reference point, m.
pub fn offset_m(estimate: &Estimate, truth: &Cylinder) -> f64 {
    let axis = estimate.axis.unwrap();
    Line3::new(
        axis.point_m.unwrap().into(),
        &axis.direction.unwrap().into(),
    )
    .distance_m(&truth.axis.point_m)
}

pub fn refused(estimate: &Estimate, code: &str) {
    assert_eq!(estimate.status, Status::Refused, "{estimate:?}");
    assert_eq!(
        estimate.observability.refusal.as_deref(),
        Some(code),
        "{:?}",
        estimate.reason
    );
    assert!(estimate.axis.is_none_or(|a| a.point_m.is_none()) || code == "pick_off_rod");
    assert!(estimate.grasp.is_none());
}
