//! Kalibr's camchain: `cam0` is the left camera, `cam1` the right one.
//!
//! `x_cam1 = T_cn_cnm1 x_cam0`, in metres; pixels count from the first pixel's centre.

use super::yaml::File;
use super::{Rig, RigError};
use crate::{Camera, Distortion, Intrinsics, Pose, Vec3};

pub(super) fn recognises(file: &File) -> bool {
    file.has(&["cam0"])
}

pub(super) fn to_rig(file: &File) -> Result<Rig, RigError> {
    let (left, right) = (file.section("cam0")?, file.section("cam1")?);
    let cameras = [camera(&left)?, camera(&right)?];
    let key = "T_cn_cnm1";
    let expected = "a 4×4 transform, x_cam1 = T x_cam0, metres";
    let t: [f64; 16] = right.array(&[key], expected)?;
    if t[12..] != [0.0, 0.0, 0.0, 1.0] {
        let found = format!("the last row {:?}", &t[12..]);
        return Err(right.complaint(key, "the last row 0, 0, 0, 1", found));
    }
    let rows = [t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10]];
    let right_from_left = Pose::new(right.rotation(key, &rows)?, Vec3::new(t[3], t[7], t[11]));
    Rig::from_stereo(file.path(), &right.key(key), cameras, right_from_left)
}

fn camera(section: &File) -> Result<Camera, RigError> {
    let (model, expected) = ("camera_model", "pinhole");
    match section.word(&[model])? {
        Some((_, found)) if found == expected => {}
        Some((_, found)) => {
            return Err(section.complaint(model, expected, format!("\"{found}\"")));
        }
        None => return Err(section.complaint(model, expected, "no such key")),
    }
    let [fx_px, fy_px, cx, cy] = section.array(&["intrinsics"], "[fu, fv, pu, pv]")?;
    let [width, height] = section.array(&["resolution"], "[width, height]")?;
    let intrinsics = Intrinsics {
        width_px: section.pixels("resolution", width)?,
        height_px: section.pixels("resolution", height)?,
        fx_px,
        fy_px,
        cx_px: cx + 0.5,
        cy_px: cy + 0.5,
    };
    Camera::new(intrinsics, distortion(section)?).map_err(|source| RigError::Camera {
        path: section.path().display().to_string(),
        camera: section.key("").trim_end_matches('.').to_owned(),
        source,
    })
}

fn distortion(section: &File) -> Result<Distortion, RigError> {
    let (key, coefficients) = ("distortion_model", &["distortion_coeffs"]);
    let expected = "radtan, equidistant or none";
    let Some((_, model)) = section.word(&[key])? else {
        return Err(section.complaint(key, expected, "no such key"));
    };
    match model.as_str() {
        "none" => Ok(Distortion::None),
        "radtan" => {
            let [k1, k2, p1, p2] = section.array(coefficients, "k1, k2, p1, p2")?;
            Ok(Distortion::BrownConrady([k1, k2, p1, p2, 0.0]))
        }
        "equidistant" => Ok(Distortion::KannalaBrandt(
            section.array(coefficients, "k1, k2, k3, k4")?,
        )),
        _ => Err(section.complaint(key, expected, format!("\"{model}\""))),
    }
}
