//! `OpenCV` stereo calibrations.

use std::path::Path;

use rodsight_geometry::{Distortion, Pixel, Rig, Vec3};

use crate::{CV2, SAMPLES, axes, fixture, has, refused, text};

#[test]
fn opencv_rig_projects_as_opencv_does() {
    let rig = Rig::load(&fixture(CV2)).unwrap();
    // Points of the left camera's frame and where cv2 5.0.0 sees them, from the first pixel's centre.
    let seen = [
        (
            [0.1, -0.05, 1.2],
            [734.4828772310676, 321.47556342946416],
            [597.9702431340957, 307.7259935069243],
        ),
        (
            [-0.4, 0.2, 2.3],
            [425.2527724391821, 476.25495280651546],
            [347.71376674518154, 461.24206198108755],
        ),
        (
            [0.6, 0.3, 3.0],
            [872.4937583645872, 491.4416746960012],
            [809.840177067381, 479.2620377076384],
        ),
    ];
    for (in_left, left, right) in seen {
        let in_rig = axes() * Vec3::from(in_left);
        for (eye, expected) in [(&rig.left, left), (&rig.right, right)] {
            let pixel = eye.project(&in_rig).unwrap();
            // Half a pixel, once.
            let expected = Pixel::from(expected) + Pixel::new(0.5, 0.5);
            assert!(
                (pixel - expected).norm() < 1e-6,
                "{pixel:?} instead of {expected:?}"
            );
        }
    }
    assert_eq!(rig.left.rig_from_camera.origin_m(), Vec3::zeros());
    assert_eq!(*rig.left.rig_from_camera.rotation(), axes());
    let baseline = rig.baseline();
    assert!(
        (baseline - Vec3::new(0.0011, 0.12, -0.0006)).norm() < 1e-9,
        "{baseline:?}"
    );
    let i = rig.right.camera.intrinsics();
    assert_eq!((i.width_px, i.height_px), (1280, 720));
    assert_eq!((i.cx_px, i.cy_px), (641.80518, 366.94972));
}

#[test]
fn opencv_spellings_two_documents_four_and_eight_coefficients_are_read() {
    let rig = Rig::load(&fixture(SAMPLES)).unwrap();
    assert_eq!(
        *rig.left.camera.distortion(),
        Distortion::BrownConrady([-0.3127, 0.1302, 0.00041, -0.00027, 0.0])
    );
    assert_eq!(
        *rig.right.camera.distortion(),
        Distortion::BrownConrady([-0.3089, 0.1187, -0.00018, 0.00033, -0.0154])
    );
    assert_eq!(rig.baseline(), Vec3::new(0.0, 0.12, 0.0));
}

#[test]
fn opencv_spellings_of_size_and_matrices_are_one() {
    let original = Rig::from_yaml(&text(SAMPLES), Path::new("a.yml")).unwrap();
    for (from, to) in [
        ("image_size: [ 1280, 720 ]", "size: [ 1280, 720 ]"),
        ("image_size: [ 1280, 720 ]", "imageSize: [ 1280, 720 ]"),
        (
            "image_size: [ 1280, 720 ]",
            "image_width: 1280\nimage_height: 720",
        ),
        (
            "image_size: [ 1280, 720 ]",
            "image_size: !!opencv-matrix\n   rows: 2\n   cols: 1\n   dt: i\n   data: [ 1280, 720 ]",
        ),
        ("K1:", "cameraMatrix1:"),
        ("K2:", "M2:"),
        ("D1:", "distCoeffs1:"),
        (
            "   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]",
            "   data: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]",
        ),
        ("%YAML:1.0", "%YAML 1.2"),
        ("K1: !!opencv-matrix", "K1:"),
    ] {
        let changed = text(SAMPLES).replace(from, to);
        assert_eq!(
            Rig::from_yaml(&changed, Path::new("a.yml")),
            Ok(original),
            "{to}"
        );
    }
}

#[test]
fn opencv_is_fisheye_only_if_the_file_says_so() {
    let four = text(SAMPLES).replace("rows: 8\n", "rows: 4\n").replace(
        "-3.089e-01, 1.187e-01, -1.8e-04, 3.3e-04, -1.54e-02, 0., 0., 0.",
        "-1.32e-02, 2.11e-02, -1.57e-02, 4.2e-03",
    );
    let path = Path::new("a.yml");
    let plain = Rig::from_yaml(&four, path).unwrap();
    assert!(matches!(
        plain.left.camera.distortion(),
        Distortion::BrownConrady(_)
    ));
    let four = four.replace(
        "-3.127e-01, 1.302e-01, 4.1e-04, -2.7e-04",
        "-1.32e-02, 2.11e-02, -1.57e-02, 4.2e-03",
    );
    for says_so in [
        "fisheye: 1",
        "fisheye: true",
        "distortion_model: fisheye",
        "distortion_model: equidistant",
    ] {
        let said = four.replace("image_size:", &format!("{says_so}\nimage_size:"));
        let rig = Rig::from_yaml(&said, path).unwrap();
        assert_eq!(
            *rig.left.camera.distortion(),
            Distortion::KannalaBrandt([-0.0132, 0.0211, -0.0157, 0.0042])
        );
    }
}

#[test]
fn kannala_brandt_projects_as_opencv_fisheye_does() {
    let path = Path::new("a.yml");
    let file = text(CV2).replace("image_width:", "fisheye: 1\nimage_width:");
    let d1 = file.find("data: [ -0.31269").unwrap();
    let end = d1 + file[d1..].find(']').unwrap();
    let d2 = file.find("data: [ -0.30890").unwrap();
    let end2 = d2 + file[d2..].find(']').unwrap();
    let coefficients = "data: [ -0.0132, 0.0211, -0.0157, 0.0042 ";
    let file = [
        &file[..d1],
        coefficients,
        &file[end..d2],
        coefficients,
        &file[end2..],
    ]
    .concat();
    let file = file.replace("cols: 5", "cols: 4");
    let rig = Rig::from_yaml(&file, path).unwrap();
    for (in_left, expected) in [
        ([0.1, -0.05, 1.2], [734.4648230607905, 321.4817021330744]),
        ([-0.4, 0.2, 2.3], [425.54035183843496, 476.0983999798633]),
        ([0.6, 0.3, 3.0], [872.1640567318655, 491.24358431929863]),
    ] {
        let pixel = rig.left.project(&(axes() * Vec3::from(in_left))).unwrap();
        let expected = Pixel::from(expected) + Pixel::new(0.5, 0.5);
        assert!(
            (pixel - expected).norm() < 1e-6,
            "{pixel:?} instead of {expected:?}"
        );
    }
}

#[test]
fn opencv_mistakes_are_named() {
    has(
        &refused(CV2, "M2: !!opencv", "Mx: !!opencv"),
        &["M2: expected a 3×3 camera matrix", "found no such key"],
    );
    has(
        &refused(CV2, "D1: !!opencv", "Dx: !!opencv"),
        &["D1: expected distortion coefficients", "no such key"],
    );
    has(
        &refused(CV2, "\nT: !!", "\nTx: !!"),
        &[
            "T: expected a translation of 3 numbers in metres",
            "no such key",
        ],
    );
    has(
        &refused(CV2, "\nR: !!", "\nRx: !!"),
        &["R: expected a 3×3 rotation", "no such key"],
    );
    has(
        &refused(CV2, "image_height", "height_of_image"),
        &["image_width", "no such key"],
    );
    has(
        &refused(CV2, "1212.53827", ".Nan"),
        &["M1: expected", "found NaN"],
    );
    has(
        &refused(CV2, "1212.53827", ".Inf"),
        &["M1: expected", "found inf"],
    );
    has(
        &refused(CV2, "1212.53827", "-1212.5"),
        &["M1", "fx_px: expected a positive number, found -1212.5"],
    );
    has(
        &refused(CV2, "1212.53827, 0.,", "1212.53827, 0.3,"),
        &["M1: expected", "[fx 0 cx"],
    );
    has(
        &refused(CV2, "0.99980619421431072", "0.98"),
        &[
            "R: expected an orthonormal right-handed matrix",
            "|R Rᵀ − 1|",
        ],
    );
    has(
        &refused(CV2, "-0.11995830112249561", "0.11995830112249561"),
        &[
            "T: expected the right camera on the right-hand",
            "left and right exchanged?",
        ],
    );
    has(
        &refused(CV2, "-0.11995830112249561", "-119.95830112249561"),
        &[
            "T: expected a baseline of at most 20 m",
            "millimetres",
            "found a baseline of 119.95",
        ],
    );
    has(
        &refused(CV2, "image_width: 1280", "image_width: 1280.5"),
        &["image width: expected a whole, positive number", "1280.5"],
    );
    has(
        &refused(CV2, "-0.31269999999999998", "-3.1"),
        &["D1", "the coefficients fold the image over itself"],
    );
    has(
        &refused(
            CV2,
            "image_width",
            "distortion_model: thin_prism\nimage_width",
        ),
        &["distortion_model: expected plumb_bob", "\"thin_prism\""],
    );
    has(
        &refused(SAMPLES, "[ 1280, 720 ]", "[ 720, 1280 ]"),
        &[
            "image size: expected width before height, found 720×1280 px with the principal point (633.7",
        ],
    );
    has(
        &refused(SAMPLES, "0., 0., 0. ]\n...", "0.1, 0., 0. ]\n..."),
        &[
            "D2: expected the coefficients after the fifth to be zero",
            "[0.1, 0.0, 0.0]",
        ],
    );
    has(
        &refused(SAMPLES, "rows: 8", "rows: 7"),
        &["D2: expected rows × cols numbers", "7×1 with 8 numbers"],
    );
    has(
        &refused(SAMPLES, "-1.2e-01, 0., 0.", "0., 0., 0."),
        &["T: expected two cameras at different places"],
    );
    has(
        &refused(SAMPLES, "-1.2e-01, 0., 0.", "left, 0., 0."),
        &["T: expected a translation", "\"left\""],
    );
}
