//! The rig's own TOML file.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::port_entry::PortComplaint;
use super::{MountedCamera, PortEntry, Rig, RigError, checked_rotation};
use crate::{
    Camera, Distortion, Intrinsics, Mat3, Pose, RigFrame, config, radians, rotation_from_rpy,
};

/// What the first pixel's centre is called in a file: (0.5, 0.5) or (0, 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PixelOrigin {
    /// (0, 0) is the top-left corner of the image: COLMAP, WebGPU, and this project.
    #[default]
    Corner,
    /// (0, 0) is the centre of the first pixel: `OpenCV`, Kalibr, ROS.
    Center,
}

/// The rig file, `schema = 1`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigFile {
    /// Version of this format: 1.
    pub schema: u32,
    /// Where the principal points below have their origin.
    #[serde(default)]
    pub pixel_origin: PixelOrigin,
    /// The left camera.
    pub left: CameraEntry,
    /// The right camera.
    pub right: CameraEntry,
}

/// A camera in a rig file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraEntry {
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Focal length along u, px.
    pub fx_px: f64,
    /// Focal length along v, px.
    pub fy_px: f64,
    /// Principal point, px from the file's `pixel_origin`.
    pub cx_px: f64,
    /// Principal point, px from the file's `pixel_origin`.
    pub cy_px: f64,
    /// Lens distortion; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distortion: Option<DistortionEntry>,
    /// The glass between the camera in its housing and the water; without it the camera is an ideal one in the water.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<PortEntry>,
    /// Pose of the camera on the rig.
    pub rig_from_camera: MountEntry,
}

/// Lens distortion in a rig file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "model", rename_all = "snake_case", deny_unknown_fields)]
pub enum DistortionEntry {
    /// `OpenCV`'s default model ("plumb bob", Kalibr's "radtan").
    BrownConrady {
        /// k1, k2, p1, p2, k3.
        coefficients: [f64; 5],
    },
    /// `OpenCV`'s fisheye model (Kalibr's "equidistant").
    KannalaBrandt {
        /// k1, k2, k3, k4.
        coefficients: [f64; 4],
    },
}

/// A camera's pose on the rig: exactly one kind of rotation, and a translation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MountEntry {
    /// Rotation matrix, rows; takes camera coordinates to rig coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Roll, pitch, yaw in degrees: R = Rz(yaw) Ry(pitch) Rx(roll).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpy_deg: Option<[f64; 3]>,
    /// Unit quaternion, scalar first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// The camera's centre in the rig frame, m.
    pub translation_m: [f64; 3],
}

/// The key that says which keys to expect, read before any other.
#[derive(Deserialize)]
struct SchemaOnly {
    #[serde(default)]
    schema: Option<u32>,
}

impl RigFile {
    /// The version this code reads and writes.
    pub const SCHEMA: u32 = 1;

    /// Parses the text of a rig file; `path` is only named in messages. The values are not checked yet:
    /// [`to_rig`](Self::to_rig) does.
    ///
    /// # Errors
    /// Another schema, broken TOML, a missing or unknown key, a wrong type.
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        // A file of another version has other keys: naming the first of them would mislead.
        match config::parse_toml::<SchemaOnly>(text, path)?.schema {
            Some(schema) if schema != Self::SCHEMA => Err(RigError::value(
                path,
                "schema",
                &Self::SCHEMA.to_string(),
                schema.to_string(),
            )),
            _ => Ok(config::parse_toml(text, path)?),
        }
    }

    /// The file that describes a rig: corner origin, rotation matrices.
    pub fn from_rig(rig: &Rig) -> Self {
        let entry = |mounted: &MountedCamera| {
            let i = mounted.camera.intrinsics();
            let r = mounted.rig_from_camera.rotation();
            let row = |k: usize| [r[(k, 0)], r[(k, 1)], r[(k, 2)]];
            CameraEntry {
                width_px: i.width_px,
                height_px: i.height_px,
                fx_px: i.fx_px,
                fy_px: i.fy_px,
                cx_px: i.cx_px,
                cy_px: i.cy_px,
                distortion: match *mounted.camera.distortion() {
                    Distortion::None => None,
                    Distortion::BrownConrady(coefficients) => {
                        Some(DistortionEntry::BrownConrady { coefficients })
                    }
                    Distortion::KannalaBrandt(coefficients) => {
                        Some(DistortionEntry::KannalaBrandt { coefficients })
                    }
                },
                port: mounted.port.as_ref().map(PortEntry::from_port),
                rig_from_camera: MountEntry {
                    rotation: Some([row(0), row(1), row(2)]),
                    rpy_deg: None,
                    quaternion_wxyz: None,
                    translation_m: mounted.rig_from_camera.origin_m().into(),
                },
            }
        };
        Self {
            schema: Self::SCHEMA,
            pixel_origin: PixelOrigin::Corner,
            left: entry(&rig.left),
            right: entry(&rig.right),
        }
    }

    /// The rig this file describes, validated; `path` is only named in messages.
    ///
    /// # Errors
    /// Another schema, numbers out of range or not finite, a rotation that is none, coinciding or exchanged cameras.
    pub fn to_rig(&self, path: &Path) -> Result<Rig, RigError> {
        let value =
            |key: &str, expected: &str, found: String| RigError::value(path, key, expected, found);
        if self.schema != Self::SCHEMA {
            return Err(value(
                "schema",
                &Self::SCHEMA.to_string(),
                self.schema.to_string(),
            ));
        }
        let shift = match self.pixel_origin {
            PixelOrigin::Corner => 0.0,
            PixelOrigin::Center => 0.5,
        };
        let mounted = |name: &'static str,
                       entry: &CameraEntry|
         -> Result<MountedCamera, RigError> {
            let intrinsics = Intrinsics {
                width_px: entry.width_px,
                height_px: entry.height_px,
                fx_px: entry.fx_px,
                fy_px: entry.fy_px,
                cx_px: entry.cx_px + shift,
                cy_px: entry.cy_px + shift,
            };
            let distortion = match entry.distortion {
                None => Distortion::None,
                Some(DistortionEntry::BrownConrady { coefficients }) => {
                    Distortion::BrownConrady(coefficients)
                }
                Some(DistortionEntry::KannalaBrandt { coefficients }) => {
                    Distortion::KannalaBrandt(coefficients)
                }
            };
            let bad_camera = |source| RigError::Camera {
                path: path.display().to_string(),
                camera: name.to_owned(),
                source,
            };
            let camera = Camera::new(intrinsics, distortion).map_err(bad_camera)?;
            let port =
                entry.port.map(PortEntry::to_port).transpose().map_err(
                    |complaint| match complaint {
                        PortComplaint::Text(key, expected, found) => {
                            value(&format!("{name}.{key}"), &expected, found)
                        }
                        PortComplaint::Number(source) => bad_camera(source),
                    },
                )?;
            if let Some(port) = &port {
                port.refuse_blind(&camera).map_err(bad_camera)?;
            }
            let mount_key = format!("{name}.rig_from_camera");
            let rig_from_camera =
                entry
                    .rig_from_camera
                    .to_pose()
                    .map_err(|(key, expected, found)| {
                        value(&format!("{mount_key}.{key}"), expected, found)
                    })?;
            Ok(MountedCamera {
                camera,
                rig_from_camera,
                port,
            })
        };
        let rig = Rig {
            left: mounted("left", &self.left)?,
            right: mounted("right", &self.right)?,
        };
        rig.validate(path, "right.rig_from_camera")?;
        Ok(rig)
    }

    /// The text of the file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain numbers and strings always serialise")
    }
}

type Complaint = (&'static str, &'static str, String);

impl MountEntry {
    const ROTATION: &'static str = "an orthonormal right-handed matrix";

    /// The pose, of a camera or of anything else that is placed like one.
    ///
    /// # Errors
    /// The key, what was expected there and what was found.
    pub fn to_pose<From>(
        &self,
    ) -> Result<Pose<RigFrame, From>, (&'static str, &'static str, String)> {
        if let Some(bad) = self.translation_m.iter().find(|v| !v.is_finite()) {
            return Err(("translation_m", "finite numbers", bad.to_string()));
        }
        let rotation = match (self.rotation, self.rpy_deg, self.quaternion_wxyz) {
            (Some(rows), None, None) => checked_rotation(&Mat3::from_fn(|i, j| rows[i][j]))
                .map_err(|found| ("rotation", Self::ROTATION, found))?,
            (None, Some(rpy), None) => {
                if let Some(bad) = rpy.iter().find(|v| !v.is_finite()) {
                    return Err(("rpy_deg", "finite numbers", bad.to_string()));
                }
                rotation_from_rpy(radians(rpy[0]), radians(rpy[1]), radians(rpy[2]))
            }
            (None, None, Some(q)) => rotation_from_quaternion(q)?,
            _ => {
                let given = [
                    self.rotation.is_some(),
                    self.rpy_deg.is_some(),
                    self.quaternion_wxyz.is_some(),
                ];
                return Err((
                    "rotation",
                    "exactly one of rotation, rpy_deg, quaternion_wxyz",
                    given.iter().filter(|g| **g).count().to_string(),
                ));
            }
        };
        Ok(Pose::new(rotation, self.translation_m.into()))
    }
}

fn rotation_from_quaternion([w, x, y, z]: [f64; 4]) -> Result<Mat3, Complaint> {
    let norm2 = w * w + x * x + y * y + z * z;
    if !((norm2 - 1.0).abs() <= 1e-6) {
        return Err((
            "quaternion_wxyz",
            "a unit quaternion",
            format!("norm {}", libm::sqrt(norm2)),
        ));
    }
    let s = 2.0 / norm2;
    Ok(Mat3::new(
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    ))
}
