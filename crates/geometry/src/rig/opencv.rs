//! `OpenCV`'s stereo calibration, as `cv::FileStorage` writes it: `M1 D1 M2 D2 R T` and the image size.
//!
//! `x_right = R x_left + T`; T in metres; pixels count from the first pixel's centre.

use super::yaml::File;
use super::{Rig, RigError};
use crate::{Camera, Distortion, Intrinsics, Pose};

/// The spellings the samples and tutorials use, the sample program's own first.
const MATRIX: [&[&str]; 2] = [
    &[
        "M1",
        "K1",
        "cameraMatrix1",
        "camera_matrix_1",
        "camera_matrix_left",
        "K_left",
        "M_left",
        "mtxL",
    ],
    &[
        "M2",
        "K2",
        "cameraMatrix2",
        "camera_matrix_2",
        "camera_matrix_right",
        "K_right",
        "M_right",
        "mtxR",
    ],
];
const DISTORTION: [&[&str]; 2] = [
    &[
        "D1",
        "distCoeffs1",
        "dist_coeffs_1",
        "distortion_coefficients_1",
        "dist_coeffs_left",
        "D_left",
        "distL",
    ],
    &[
        "D2",
        "distCoeffs2",
        "dist_coeffs_2",
        "distortion_coefficients_2",
        "dist_coeffs_right",
        "D_right",
        "distR",
    ],
];
const ROTATION: &[&str] = &["R", "rotation_matrix", "rotation"];
const TRANSLATION: &[&str] = &["T", "translation_vector", "translation"];
const WIDTH: &[&str] = &["image_width", "width", "imageWidth"];
const HEIGHT: &[&str] = &["image_height", "height", "imageHeight"];
const SIZE: &[&str] = &["image_size", "imageSize", "size", "img_size", "resolution"];

pub(super) fn recognises(file: &File) -> bool {
    [MATRIX[0], MATRIX[1], DISTORTION[0], DISTORTION[1]]
        .iter()
        .any(|keys| file.has(keys))
}

pub(super) fn to_rig(file: &File) -> Result<Rig, RigError> {
    let size = image_size(file)?;
    let fisheye = is_fisheye(file)?;
    let cameras = [
        camera(file, 0, size, fisheye)?,
        camera(file, 1, size, fisheye)?,
    ];
    let rows: [f64; 9] = file.array(ROTATION, "a 3×3 rotation matrix, x_right = R x_left + T")?;
    let rotation = file.rotation(ROTATION[0], &rows)?;
    let translation_m: [f64; 3] = file.array(
        TRANSLATION,
        "a translation of 3 numbers in metres, x_right = R x_left + T",
    )?;
    let right_from_left = Pose::new(rotation, translation_m.into());
    Rig::from_stereo(file.path(), TRANSLATION[0], cameras, right_from_left)
}

fn image_size(file: &File) -> Result<(u32, u32), RigError> {
    let expected = "image_width and image_height, or image_size: [width, height]";
    let [width, height] = if file.has(SIZE) {
        file.array(SIZE, expected)?
    } else {
        let [width] = file.array(WIDTH, expected)?;
        let [height] = file.array(HEIGHT, expected)?;
        [width, height]
    };
    Ok((
        file.pixels("image width", width)?,
        file.pixels("image height", height)?,
    ))
}

/// Only the file can say so: four coefficients are k1, k2, p1, p2 of the one model and k1…k4 of the other.
fn is_fisheye(file: &File) -> Result<bool, RigError> {
    if file.switch(&["fisheye"])? {
        return Ok(true);
    }
    let Some((key, model)) = file.word(&["distortion_model", "distortionModel", "camera_model"])?
    else {
        return Ok(false);
    };
    match model.as_str() {
        "fisheye" | "equidistant" | "kannala_brandt" => Ok(true),
        "plumb_bob" | "radtan" | "brown_conrady" | "pinhole" | "rational_polynomial" => Ok(false),
        _ => Err(file.complaint(
            &key,
            "plumb_bob, radtan, brown_conrady, rational_polynomial, fisheye or equidistant",
            format!("\"{model}\""),
        )),
    }
}

fn camera(
    file: &File,
    index: usize,
    (width_px, height_px): (u32, u32),
    fisheye: bool,
) -> Result<Camera, RigError> {
    let matrix_key = MATRIX[index][0];
    let expected = "a 3×3 camera matrix [fx 0 cx; 0 fy cy; 0 0 1]";
    let m: [f64; 9] = file.array(MATRIX[index], expected)?;
    if [m[1], m[3], m[6], m[7]].iter().any(|v| *v != 0.0) || m[8] != 1.0 {
        return Err(file.complaint(matrix_key, expected, format!("{m:?}")));
    }
    let [fx_px, _, cx, _, fy_px, cy, ..] = m;
    let (width, height) = (f64::from(width_px), f64::from(height_px));
    // From Python the size is easily written as (rows, columns): the principal point tells.
    let off_centre = |w: f64, h: f64| (cx - 0.5 * w).abs() + (cy - 0.5 * h).abs();
    let found = off_centre(width, height);
    if found > 0.1 * (width + height) && found > 4.0 * off_centre(height, width) {
        return Err(file.complaint(
            "image size",
            "width before height",
            format!("{width_px}×{height_px} px with the principal point ({cx}, {cy})"),
        ));
    }
    let intrinsics = Intrinsics {
        width_px,
        height_px,
        fx_px,
        fy_px,
        cx_px: cx + 0.5,
        cy_px: cy + 0.5,
    };
    let distortion = distortion(file, DISTORTION[index], fisheye)?;
    Camera::new(intrinsics, distortion).map_err(|source| RigError::Camera {
        path: file.path().display().to_string(),
        camera: format!("{matrix_key}, {}", DISTORTION[index][0]),
        source,
    })
}

fn distortion(file: &File, keys: &[&str], fisheye: bool) -> Result<Distortion, RigError> {
    if fisheye {
        let k = file.array(keys, "4 fisheye coefficients k1, k2, k3, k4")?;
        return Ok(Distortion::KannalaBrandt(k));
    }
    let expected = "distortion coefficients k1, k2, p1, p2 and perhaps k3";
    let (key, values) = file.numbers(keys, expected)?;
    let mut k = [0.0; 5];
    match values.len() {
        4 | 5 => k[..values.len()].copy_from_slice(&values),
        8 | 12 | 14 if values[5..].iter().all(|v| *v == 0.0) => k.copy_from_slice(&values[..5]),
        8 | 12 | 14 => {
            return Err(file.complaint(
                &key,
                "the coefficients after the fifth to be zero (calibrate without CALIB_RATIONAL_MODEL)",
                format!("{:?}", &values[5..]),
            ));
        }
        other => return Err(file.complaint(&key, expected, format!("{other} numbers"))),
    }
    Ok(if k == [0.0; 5] {
        Distortion::None
    } else {
        Distortion::BrownConrady(k)
    })
}
