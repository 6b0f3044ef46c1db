//! The stereo rig and its TOML file.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::{self, ConfigError};
use crate::{
    Camera, CameraError, CameraFrame, Distortion, Intrinsics, Mat3, Pixel, Pose, RigFrame, Vec3,
    radians, rotation_from_rpy,
};

/// Left or right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Eye {
    Left,
    Right,
}

impl Eye {
    /// Both, left first.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// "left" or "right".
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// A camera and where it sits on the rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountedCamera {
    /// The camera.
    pub camera: Camera,
    /// Its pose: `x_rig = R x_camera + t`.
    pub rig_from_camera: Pose<RigFrame, CameraFrame>,
}

impl MountedCamera {
    /// Origin (m) and unit direction, in the rig frame, of the ray seen at a pixel.
    pub fn ray(&self, pixel: &Pixel) -> Option<(Vec3, Vec3)> {
        Some((
            self.rig_from_camera.origin_m(),
            self.rig_from_camera.direction(&self.camera.ray(pixel)?),
        ))
    }

    /// The pixel at which a point of the rig frame is seen.
    pub fn project(&self, point_in_rig_m: &Vec3) -> Option<Pixel> {
        self.camera
            .project(&self.rig_from_camera.inverse().point(point_in_rig_m))
    }
}

/// Two cameras on one rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// The left camera.
    pub left: MountedCamera,
    /// The right camera.
    pub right: MountedCamera,
}

impl Rig {
    /// The camera of an eye.
    pub fn eye(&self, eye: Eye) -> &MountedCamera {
        match eye {
            Eye::Left => &self.left,
            Eye::Right => &self.right,
        }
    }

    /// From the left camera's centre to the right one's, in the rig frame, m.
    pub fn baseline(&self) -> Vec3 {
        self.right.rig_from_camera.origin_m() - self.left.rig_from_camera.origin_m()
    }

    /// Reads a rig file.
    ///
    /// # Errors
    /// A file that cannot be read or is no rig; the message names file, key, what was expected and what was found.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        Self::from_toml(&config::read_text(path)?, path)
    }

    /// Parses the text of a rig file; `path` is only named in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, RigError> {
        config::parse_toml::<RigFile>(text, path)?.to_rig(path)
    }
}

/// Why a rig file is no rig.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum RigError {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("{path}: {camera}: {source}")]
    Camera {
        path: String,
        camera: &'static str,
        source: CameraError,
    },
    #[error("{path}: {key}: expected {expected}, found {found}")]
    Value {
        path: String,
        key: String,
        expected: String,
        found: String,
    },
}

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

impl RigFile {
    /// The version this code reads and writes.
    pub const SCHEMA: u32 = 1;

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
        let value = |key: &str, expected: &str, found: String| RigError::Value {
            path: path.display().to_string(),
            key: key.to_owned(),
            expected: expected.to_owned(),
            found,
        };
        if self.schema != Self::SCHEMA {
            return Err(value("schema", "1", self.schema.to_string()));
        }
        let shift = match self.pixel_origin {
            PixelOrigin::Corner => 0.0,
            PixelOrigin::Center => 0.5,
        };
        let mounted = |name: &'static str, entry: &CameraEntry| -> Result<MountedCamera, RigError> {
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
            let camera =
                Camera::new(intrinsics, distortion).map_err(|source| RigError::Camera {
                    path: path.display().to_string(),
                    camera: name,
                    source,
                })?;
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
            })
        };
        let rig = Rig {
            left: mounted("left", &self.left)?,
            right: mounted("right", &self.right)?,
        };
        rig.validate().map_err(|(expected, found)| {
            value("right.rig_from_camera.translation_m", expected, found)
        })?;
        Ok(rig)
    }

    /// The text of the file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain numbers and strings always serialise")
    }
}

type Complaint = (&'static str, &'static str, String);

impl MountEntry {
    fn to_pose(&self) -> Result<Pose<RigFrame, CameraFrame>, Complaint> {
        if let Some(bad) = self.translation_m.iter().find(|v| !v.is_finite()) {
            return Err(("translation_m", "finite numbers", bad.to_string()));
        }
        let rotation = match (self.rotation, self.rpy_deg, self.quaternion_wxyz) {
            (Some(rows), None, None) => {
                let r = Mat3::from_fn(|i, j| rows[i][j]);
                let off = (r * r.transpose() - Mat3::identity()).norm();
                // NaN compares false: `!(… <= …)` refuses it.
                if !(off <= 1e-6) || r.determinant() < 0.0 {
                    return Err((
                        "rotation",
                        "an orthonormal right-handed matrix",
                        format!("|R Rᵀ − 1| = {off:.3e}, determinant {:.6}", r.determinant()),
                    ));
                }
                r
            }
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

impl Rig {
    /// The right camera must lie at +x of the left one and look roughly the same way, or the eyes are exchanged.
    fn validate(&self) -> Result<(), (&'static str, String)> {
        let baseline_m = self.baseline();
        if baseline_m.norm() < 1e-6 {
            return Err((
                "two cameras at different places",
                "both at the same place".to_owned(),
            ));
        }
        let in_left = self.left.rig_from_camera.inverse().direction(&baseline_m);
        if in_left.x <= 0.0 {
            return Err((
                "the right camera on the right-hand (+x) side of the left one; are left and right exchanged?",
                format!("x = {:.4} m in the left camera's frame", in_left.x),
            ));
        }
        Ok(())
    }
}
