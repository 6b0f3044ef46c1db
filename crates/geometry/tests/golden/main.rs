//! The founding paper's tables, recomputed: `golden/paper.toml` holds the numbers and says where each comes from.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod published;
mod reconstruction;

use std::path::Path;

use rodsight_geometry::{
    Camera, Distortion, ImageLine, Intrinsics, Line3, MountedCamera, Plane, Pose, Rig, Vec3,
    degrees, radians, rotation_from_rpy,
};
use rodsight_testkit::Golden;

/// What the golden file was rounded to, and the task's tolerance.
pub(crate) const TOLERANCE: f64 = 1e-6;

pub(crate) fn golden() -> Golden {
    Golden::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/paper.toml"))
}

#[track_caller]
pub(crate) fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "found {found}, expected {expected} ± {tolerance}"
    );
}

#[track_caller]
pub(crate) fn close3(found: &Vec3, expected: [f64; 3], tolerance: f64) {
    for k in 0..3 {
        assert!(
            (found[k] - expected[k]).abs() <= tolerance,
            "found {found:?}, expected {expected:?} ± {tolerance}"
        );
    }
}

/// Lines stand in the file as [ρ in px, θ in degrees].
pub(crate) fn line([rho_px, theta_deg]: [f64; 2]) -> ImageLine {
    ImageLine::new(rho_px, radians(theta_deg))
}

#[track_caller]
pub(crate) fn close_line(found: &ImageLine, [rho_px, theta_deg]: [f64; 2], tolerance: f64) {
    close(found.rho_px, rho_px, tolerance);
    close(degrees(found.theta_rad), theta_deg, tolerance);
}

/// Table 1 and section 4.1.
pub(crate) fn paper_rig(golden: &Golden) -> Rig {
    let (width, height) = (
        golden.f64("camera.width_px"),
        golden.f64("camera.height_px"),
    );
    let k_px = 0.5 * width / libm::tan(0.5 * radians(golden.f64("camera.hfov_deg")));
    let intrinsics = Intrinsics {
        width_px: width as u32,
        height_px: height as u32,
        fx_px: k_px,
        fy_px: k_px,
        cx_px: 0.5 * width,
        cy_px: 0.5 * height,
    };
    let mounted = |eye: &str| {
        let [roll, pitch, yaw] = golden.array(&format!("mount.{eye}_rpy_deg")).map(radians);
        let centre_m: [f64; 3] = golden.array(&format!("mount.{eye}_t_m"));
        MountedCamera::new(
            Camera::new(intrinsics, Distortion::None).unwrap(),
            Pose::new(rotation_from_rpy(roll, pitch, yaw), centre_m.into()),
        )
    };
    Rig {
        left: mounted("left"),
        right: mounted("right"),
    }
}

/// (17) as it should be: (−`n_y`, `n_x`, 0) × (ρ̄ `n_x`, ρ̄ `n_y`, 1) = (`n_x`, `n_y`, −ρ̄), not a unit vector, with ρ̄ of (15).
pub(crate) fn paper_normal(camera: &Camera, line: &ImageLine) -> (f64, Vec3) {
    let (i, n) = (camera.intrinsics(), line.normal());
    let rho_bar = (line.rho_px - i.cx_px * n.x - i.cy_px * n.y) / i.fx_px;
    (rho_bar, Vec3::new(n.x, n.y, -rho_bar))
}

/// (17) with the 0 and the 1 exchanged, as it is printed.
pub(crate) fn misprinted_normal(camera: &Camera, line: &ImageLine) -> Vec3 {
    let (rho_bar, _) = paper_normal(camera, line);
    let n = line.normal();
    Vec3::new(-n.y, n.x, 1.0).cross(&Vec3::new(rho_bar * n.x, rho_bar * n.y, 0.0))
}

/// The 3D line of two image lines through unit normals: (18)–(25).
pub(crate) fn axis_of(rig: &Rig, left: &ImageLine, right: &ImageLine) -> Line3 {
    let plane = |mounted: &MountedCamera, line: &ImageLine| {
        Plane::through_camera(&mounted.rig_from_camera, &mounted.camera.plane_normal(line))
    };
    Line3::from_planes(
        &plane(&rig.left, left),
        &plane(&rig.right, right),
        &rig.left.rig_from_camera.origin_m(),
    )
    .unwrap()
}

pub(crate) fn table4(golden: &Golden) -> (ImageLine, ImageLine) {
    (
        line(golden.array("table4.left")),
        line(golden.array("table4.right")),
    )
}

pub(crate) fn recomputed(golden: &Golden) -> (Rig, Line3) {
    let rig = paper_rig(golden);
    let (left, right) = table4(golden);
    let axis = axis_of(&rig, &left, &right);
    (rig, axis)
}

/// The limbs of an eye: the two different lines among the last columns of its table.
pub(crate) fn limbs(golden: &Golden, table: &str) -> [ImageLine; 2] {
    let mut lines: Vec<[f64; 2]> = Vec::new();
    for row in 0..golden.len(table) {
        let found = golden.array(&format!("{table}.{row}.refined_twice"));
        if !lines.contains(&found) {
            lines.push(found);
        }
    }
    assert_eq!(lines.len(), 2, "{table} has two limbs");
    [line(lines[0]), line(lines[1])]
}
