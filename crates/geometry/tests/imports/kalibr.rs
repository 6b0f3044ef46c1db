//! Kalibr camchains, and files that are neither.

use std::path::Path;

use rodsight_geometry::{Distortion, Mat3, Rig, Vec3};

use crate::{KALIBR, fixture, has, message, refused};

#[test]
fn kalibr_camchain_is_read() {
    let rig = Rig::load(&fixture(KALIBR)).unwrap();
    let (left, right) = (rig.left.camera.intrinsics(), rig.right.camera.intrinsics());
    assert_eq!(
        (left.fx_px, left.fy_px, left.cx_px, left.cy_px),
        (458.654, 457.296, 367.715, 248.875)
    );
    assert_eq!((right.width_px, right.height_px), (752, 480));
    assert_eq!(
        *rig.left.camera.distortion(),
        Distortion::BrownConrady([-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0])
    );
    assert_eq!(
        *rig.right.camera.distortion(),
        Distortion::KannalaBrandt([-0.0132, 0.0211, -0.0157, 0.0042])
    );
    // x_cam1 = R x_cam0 + t, so the right camera's centre is −Rᵀt, here 11 cm to starboard.
    let t = Vec3::new(-0.110073808, 0.000399122, -0.000853703);
    let in_right = rig.right.rig_from_camera.inverse().point(&Vec3::zeros());
    assert!((in_right - t).norm() < 1e-12, "{in_right:?}");
    assert!((rig.baseline().y - 0.11007).abs() < 1e-4);
    // Nine digits are not orthonormal to the last bit; the pose is.
    let r = rig.right.rig_from_camera.rotation();
    assert!((r * r.transpose() - Mat3::identity()).norm() < 1e-15);
}

#[test]
fn kalibr_mistakes_are_named() {
    has(
        &refused(KALIBR, "cam1:", "cam2:"),
        &["cam1: expected a mapping", "no such key"],
    );
    has(
        &refused(KALIBR, "  T_cn_cnm1", "  T_cam_imu"),
        &["cam1.T_cn_cnm1: expected a 4×4", "no such key"],
    );
    has(
        &refused(KALIBR, "-0.110073808", "0.110073808"),
        &[
            "cam1.T_cn_cnm1: expected the right camera on the right-hand",
            "exchanged?",
        ],
    );
    has(
        &refused(KALIBR, "-0.110073808", "-110.073808"),
        &[
            "cam1.T_cn_cnm1: expected a baseline of at most 20 m",
            "millimetres",
        ],
    );
    has(
        &refused(KALIBR, "0.999997256", "0.9"),
        &["cam1.T_cn_cnm1: expected an orthonormal"],
    );
    has(
        &refused(KALIBR, "0.0, 0.0, 0.0, 1.0", "0.0, 0.0, 0.0, 2.0"),
        &["cam1.T_cn_cnm1: expected the last row 0, 0, 0, 1"],
    );
    has(
        &refused(KALIBR, "distortion_model: radtan", "distortion_model: fov"),
        &[
            "cam0.distortion_model: expected radtan, equidistant or none",
            "\"fov\"",
        ],
    );
    has(
        &refused(
            KALIBR,
            "camera_model: pinhole\n  distortion_coeffs: [-0.0132",
            "camera_model: omni\n  distortion_coeffs: [-0.0132",
        ),
        &["cam1.camera_model: expected pinhole", "\"omni\""],
    );
    has(
        &refused(KALIBR, "458.654", ".nan"),
        &["cam0.intrinsics: expected [fu, fv, pu, pv]", "NaN"],
    );
    has(
        &refused(KALIBR, "458.654", "-458.654"),
        &["cam0.fx_px: expected a positive number", "-458.654"],
    );
    has(
        &refused(KALIBR, "[752, 480]", "[752]"),
        &["cam0.resolution: expected [width, height]", "1 numbers"],
    );
}

#[test]
fn yaml_that_is_no_stereo_calibration_is_told_what_was_expected() {
    has(
        &message("camera_matrix: [1, 2]\nrms: 0.3\n"),
        &[
            "expected an OpenCV stereo calibration (M1, D1, M2, D2, R, T) or a Kalibr camchain (cam0, cam1)",
            "found the keys camera_matrix, rms",
        ],
    );
    has(&message(""), &["found no keys"]);
    has(&message("M1: [1, 2\nM2: 3\n"), &["calib.yaml:"]);
    has(&message("M1: 1\nM1: 2\n"), &["calib.yaml:2", "duplicate"]);
    has(&message("- 1\n- 2\n"), &["calib.yaml:1"]);
}

#[test]
fn files_of_other_kinds_are_told_what_was_expected() {
    for (name, found) in [("rig.xml", ".xml"), ("rig", "no extension")] {
        let message = Rig::load(Path::new(name)).unwrap_err().to_string();
        has(
            &message,
            &[
                name,
                "expected a rig file (.toml), or an OpenCV or Kalibr calibration",
                found,
            ],
        );
    }
    let message = Rig::load(Path::new("nowhere/rig.toml"))
        .unwrap_err()
        .to_string();
    has(&message, &["nowhere/rig.toml", "No such file"]);
}
