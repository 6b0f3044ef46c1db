//! The rig's own TOML file: read, written, and refused with file, key, expected and found.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::path::Path;

use rodsight_geometry::{Eye, Pixel, Pose, Rig, RigFile, Vec3, rotation_from_rpy};

const RIG: &str = r#"schema = 1
[left]
width_px = 1920
height_px = 1080
fx_px = 1566.5776
fy_px = 1566.5776
cx_px = 960.0
cy_px = 540.0
[left.rig_from_camera]
rotation = [[0,0,1],[1,0,0],[0,1,0]]
translation_m = [0.0, -0.5, -1.0]
[right]
width_px = 1920
height_px = 1080
fx_px = 1566.5776
fy_px = 1566.5776
cx_px = 960.0
cy_px = 540.0
distortion = { model = "brown_conrady", coefficients = [-0.1, 0.02, 0.001, -0.001, 0.0] }
[right.rig_from_camera]
rpy_deg = [90.0, 0.0, 90.0]
translation_m = [0.0, 0.5, -1.0]
"#;

fn rig(text: &str) -> Rig {
    Rig::from_toml(text, Path::new("rig.toml")).unwrap()
}

/// The message with which the rig is refused after a change.
#[track_caller]
fn refused(from: &str, to: &str, parts: &[&str]) {
    assert!(RIG.contains(from), "no `{from}`");
    let message = Rig::from_toml(&RIG.replacen(from, to, 1), Path::new("rig.toml"))
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("rig.toml"), "no file in: {message}");
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

#[test]
fn rig_file_is_read_and_written_back() {
    let read = rig(RIG);
    assert_eq!(read.baseline(), Vec3::new(0.0, 1.0, 0.0));
    let written = RigFile::from_rig(&read).to_toml();
    assert_eq!(rig(&written), read, "{written}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, written).unwrap();
    assert_eq!(Rig::load(&path), Ok(read));
}

#[test]
fn rig_file_rotations_of_all_kinds_agree() {
    let matrix = rig(RIG).left;
    for same in [
        "rpy_deg = [90, 0, 90]",
        "quaternion_wxyz = [0.5, 0.5, 0.5, 0.5]",
    ] {
        let other = rig(&RIG.replace("rotation = [[0,0,1],[1,0,0],[0,1,0]]", same)).left;
        let difference = matrix.rig_from_camera.rotation() - other.rig_from_camera.rotation();
        assert!(difference.norm() < 1e-15, "{same}: {difference}");
    }
    // Rounded to six or four digits they are made orthonormal: a ray goes there and back.
    for rounded in [
        "rotation = [[0,0,1],[0.866025,-0.5,0],[0.5,0.866025,0]]",
        "rotation = [[0.0871,0.0552,0.9947],[0.9956,0.0302,-0.0889],[-0.0349,0.9980,-0.0523]]",
    ] {
        let tilted = rig(&RIG.replace("rotation = [[0,0,1],[1,0,0],[0,1,0]]", rounded)).left;
        let pixel = Pixel::new(300.0, 800.0);
        let (origin, ray) = tilted.ray(&pixel).unwrap();
        assert!((tilted.project(&(origin + ray * 2.0)).unwrap() - pixel).norm() < 1e-9);
    }
}

#[test]
fn rig_file_of_centre_origin_is_shifted_by_half_a_pixel_once() {
    let centred = rig(&RIG.replace("schema = 1", "schema = 1\npixel_origin = \"center\""));
    assert_eq!(centred.left.camera.intrinsics().cx_px, 960.5);
    assert_eq!(centred.right.camera.intrinsics().cy_px, 540.5);
    assert_eq!(rig(&RigFile::from_rig(&centred).to_toml()), centred);
}

#[test]
fn rig_file_keys_that_are_wrong_are_named() {
    refused(
        "fx_px",
        "fz_px",
        &[
            "rig.toml:5",
            "unknown field `fz_px`",
            "did you mean `fx_px`?",
        ],
    );
    refused(
        "schema = 1",
        "schema = 1\npixel_orgin = \"center\"",
        &[
            "rig.toml:2",
            "unknown field `pixel_orgin`",
            "did you mean `pixel_origin`?",
        ],
    );
    refused("cx_px = 960.0\n", "", &["missing field `cx_px`"]);
    refused("schema = 1\n", "", &["missing field `schema`"]);
    refused(
        "fx_px = 1566.5776",
        "fx_px = \"wide\"",
        &[
            "rig.toml:5",
            "invalid type: string \"wide\", expected f64",
            "in `fx_px = \"wide\"`",
        ],
    );
    refused(
        "width_px = 1920",
        "width_px = -1",
        &["rig.toml:3", "-1", "width_px"],
    );
    refused(
        "schema = 1",
        "schema = 1\npixel_origin = \"middle\"",
        &["unknown variant `middle`", "`corner`", "`center`"],
    );
    refused(
        "brown_conrady",
        "brown_conradi",
        &[
            "unknown variant `brown_conradi`",
            "did you mean `brown_conrady`?",
        ],
    );
    refused("-0.001, 0.0]", "-0.001]", &["invalid length 4", "5"]);
    refused("[left]", "[left", &["rig.toml:2"]);
}

#[test]
fn rig_file_of_another_schema_is_told_before_its_keys() {
    refused(
        "schema = 1",
        "schema = 2\ncameras = 3",
        &["schema: expected 1, found 2"],
    );
}

#[test]
fn rig_file_rotations_that_are_none_are_refused() {
    let rotation = "rotation = [[0,0,1],[1,0,0],[0,1,0]]";
    refused(
        rotation,
        &format!("{rotation}\nrpy_deg = [90.0, 0.0, 90.0]"),
        &[
            "left.rig_from_camera.rotation: expected exactly one of rotation, rpy_deg, quaternion_wxyz, found 2",
        ],
    );
    refused(
        rotation,
        "",
        &[
            "left.rig_from_camera.rotation: expected exactly one of",
            "found 0",
        ],
    );
    refused(
        rotation,
        "rotation = [[0,0,1],[1,0.1,0],[0,1,0]]",
        &[
            "left.rig_from_camera.rotation: expected an orthonormal right-handed matrix",
            "|R Rᵀ − 1|",
        ],
    );
    refused(
        rotation,
        "rotation = [[0,0,1],[-1,0,0],[0,1,0]]",
        &[
            "left.rig_from_camera.rotation",
            "right-handed",
            "determinant -1.0",
        ],
    );
    refused(
        rotation,
        "rotation = [[0,0,nan],[1,0,0],[0,1,0]]",
        &["left.rig_from_camera.rotation", "NaN"],
    );
    refused(
        rotation,
        "rpy_deg = [90, nan, 0]",
        &["left.rig_from_camera.rpy_deg: expected finite numbers, found NaN"],
    );
    refused(
        rotation,
        "quaternion_wxyz = [1, 1, 0, 0]",
        &[
            "left.rig_from_camera.quaternion_wxyz: expected a unit quaternion",
            "norm 1.41",
        ],
    );
    refused(
        "[0.0, -0.5, -1.0]",
        "[0.0, inf, -1.0]",
        &["left.rig_from_camera.translation_m: expected finite numbers, found inf"],
    );
}

#[test]
fn rig_file_cameras_that_cannot_be_are_refused() {
    refused(
        "fx_px = 1566.5776",
        "fx_px = -1566.5776",
        &["left.fx_px: expected a positive number, found -1566.5776"],
    );
    refused(
        "fy_px = 1566.5776",
        "fy_px = nan",
        &["left.fy_px: expected a positive number, found NaN"],
    );
    refused(
        "cx_px = 960.0",
        "cx_px = inf",
        &["left.cx_px: expected a finite number, found inf"],
    );
    refused(
        "width_px = 1920",
        "width_px = 0",
        &["left.width_px: expected a positive number, found 0"],
    );
    refused(
        "[-0.1, 0.02,",
        "[-1.5, 0.02,",
        &[
            "right.distortion: the pixel (0, 0) of the image has no ray",
            "fold",
        ],
    );
    refused(
        "[-0.1, 0.02,",
        "[nan, 0.02,",
        &["right.distortion: expected a finite number, found NaN"],
    );
}

#[test]
fn rig_file_eyes_that_cannot_be_a_pair_are_refused() {
    refused(
        "[0.0, -0.5, -1.0]",
        "[0.0, 1.5, -1.0]",
        &[
            "right.rig_from_camera: expected the right camera on the right-hand (+x) side of the left one; are left and right exchanged?",
            "x = -1.0000 m",
        ],
    );
    refused(
        "[0.0, -0.5, -1.0]",
        "[0.0, 0.5, -1.0]",
        &["expected two cameras at different places"],
    );
    refused(
        "[0.0, -0.5, -1.0]",
        "[0.0, -500.0, -1.0]",
        &[
            "expected a baseline of at most 20 m",
            "millimetres",
            "found a baseline of 500.5 m",
        ],
    );
    refused(
        "rpy_deg = [90.0, 0.0, 90.0]",
        "rpy_deg = [90.0, 0.0, -90.0]",
        &[
            "expected two cameras that look roughly the same way",
            "180.0°",
        ],
    );
}

/// What a rig sees after a move is what it saw of the same things moved the other way.
#[test]
fn moved_rigs_see_from_where_they_went() {
    let rig = rig(RIG);
    let rig_from_moved = Pose::new(
        rotation_from_rpy(0.1, -0.2, 0.15),
        Vec3::new(0.3, -0.1, -0.4),
    );
    let moved = rig.moved(&rig_from_moved);
    let point_m = Vec3::new(2.5, 0.2, -0.7);
    let from_moved_m = rig_from_moved.inverse().point(&point_m);
    for eye in Eye::BOTH {
        let (there, here) = (moved.eye(eye), rig.eye(eye));
        let pixel = there.project(&point_m).unwrap();
        assert!((pixel - here.project(&from_moved_m).unwrap()).norm() < 1e-9);
        assert!((pixel - here.project(&point_m).unwrap()).norm() > 50.0);
    }
    assert!((moved.baseline().norm() - rig.baseline().norm()).abs() < 1e-15);
}
