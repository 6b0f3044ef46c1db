//! The stereo rig, and the calibration files it is read from.

mod file;
mod kalibr;
mod mounted;
mod opencv;
mod port_entry;
mod yaml;

pub use file::{CameraEntry, DistortionEntry, MountEntry, PixelOrigin, RigFile};
pub use mounted::{MountedCamera, Sight};
pub use port_entry::{DomePortEntry, FlatPortEntry, PortEntry};

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::{self, ConfigError};
use crate::{Camera, CameraError, CameraFrame, Mat3, Pose, RigFrame, Vec3};

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

    /// The one beside it.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// "left" or "right".
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
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

    /// The same cameras after the rig has moved, in the frame where it was: `rig_from_moved` is where it went.
    #[must_use]
    pub fn moved(&self, rig_from_moved: &Pose<RigFrame, RigFrame>) -> Self {
        let moved = |mounted: &MountedCamera| MountedCamera {
            rig_from_camera: *rig_from_moved * mounted.rig_from_camera,
            ..*mounted
        };
        Self {
            left: moved(&self.left),
            right: moved(&self.right),
        }
    }

    /// Reads a calibration: a rig file (`.toml`), or an `OpenCV` stereo calibration or a Kalibr camchain (`.yaml`, `.yml`).
    ///
    /// The last two say nothing of the vehicle: the rig frame is then at the left camera's centre, with the vehicle's axes
    /// (x forward along the optical axis, y starboard, z down), and pixels are moved by half a pixel, once, from their
    /// origin at the first pixel's centre to ours.
    ///
    /// # Errors
    /// A file that cannot be read or is no rig; the message names file, key, what was expected and what was found.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_lowercase())
            .unwrap_or_default();
        match extension.as_str() {
            "toml" => Self::from_toml(&config::read_text(path)?, path),
            "yaml" | "yml" => Self::from_yaml(&config::read_text(path)?, path),
            _ => Err(RigError::value(
                path,
                "file name",
                "a rig file (.toml), or an OpenCV or Kalibr calibration (.yaml, .yml)",
                if extension.is_empty() {
                    "no extension".to_owned()
                } else {
                    format!(".{extension}")
                },
            )),
        }
    }

    /// Parses the text of a rig file; `path` is only named in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, RigError> {
        RigFile::parse(text, path)?.to_rig(path)
    }

    /// Parses the text of an `OpenCV` stereo calibration or a Kalibr camchain, told apart by their keys; `path` is only
    /// named in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_yaml(text: &str, path: &Path) -> Result<Self, RigError> {
        let file = yaml::File::parse(text, path)?;
        if kalibr::recognises(&file) {
            kalibr::to_rig(&file)
        } else if opencv::recognises(&file) {
            opencv::to_rig(&file)
        } else {
            Err(RigError::value(
                path,
                "top level",
                "an OpenCV stereo calibration (M1, D1, M2, D2, R, T) or a Kalibr camchain (cam0, cam1)",
                file.keys(),
            ))
        }
    }

    /// A rig from what stereo calibration tools tell: `x_right = R x_left + T`. `key` is where the file says so.
    fn from_stereo(
        path: &Path,
        key: &str,
        [left, right]: [Camera; 2],
        right_from_left: Pose<CameraFrame, CameraFrame>,
    ) -> Result<Self, RigError> {
        // Columns: where the camera's right, down and forward point in the vehicle's axes.
        let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let rig_from_left = Pose::<RigFrame, CameraFrame>::new(axes, Vec3::zeros());
        let rig = Self {
            left: MountedCamera::new(left, rig_from_left),
            right: MountedCamera::new(right, rig_from_left * right_from_left.inverse()),
        };
        rig.validate(path, key)?;
        Ok(rig)
    }

    /// The right camera must lie at +x of the left one, not too far, and look roughly the same way.
    fn validate(&self, path: &Path, key: &str) -> Result<(), RigError> {
        let baseline_m = self.baseline();
        let length_m = baseline_m.norm();
        let complain = |expected, found| Err(RigError::value(path, key, expected, found));
        // `!(…)` refuses NaN too.
        if !(length_m >= 1e-6) {
            return complain(
                "two cameras at different places",
                "both at the same place".to_owned(),
            );
        }
        if length_m > MAX_BASELINE_M {
            return complain(
                "a baseline of at most 20 m; are the translations in millimetres? Metres are needed",
                format!("a baseline of {length_m} m"),
            );
        }
        let in_left = self.left.rig_from_camera.inverse().direction(&baseline_m);
        if in_left.x <= 0.0 {
            return complain(
                "the right camera on the right-hand (+x) side of the left one; are left and right exchanged?",
                format!("x = {:.4} m in the left camera's frame", in_left.x),
            );
        }
        let forward = |camera: &MountedCamera| camera.rig_from_camera.direction(&Vec3::z());
        let angle = crate::angle_between(&forward(&self.left), &forward(&self.right));
        if angle >= core::f64::consts::FRAC_PI_2 {
            return complain(
                "two cameras that look roughly the same way",
                format!("{:.1}° between their optical axes", crate::degrees(angle)),
            );
        }
        Ok(())
    }
}

/// A longer baseline is a mistake of units.
const MAX_BASELINE_M: f64 = 20.0;

/// How far R Rᵀ may be from 1: files write four digits and more, a slip of the pen is larger.
const ROUNDED_ROTATION: f64 = 1e-3;

/// The rotation nearest to a matrix that is one to the digits a file has, or what is wrong with it.
fn checked_rotation(r: &Mat3) -> Result<Mat3, String> {
    let off = (r * r.transpose() - Mat3::identity()).norm();
    // `!(…)` refuses NaN too.
    if !(off <= ROUNDED_ROTATION) || r.determinant() < 0.0 {
        return Err(format!(
            "|R Rᵀ − 1| = {off:.3e}, determinant {:.6}",
            r.determinant()
        ));
    }
    // Poses are inverted by transposing. Newton's iteration for the polar factor; matrices that are exact stay as they are.
    let mut nearest = *r;
    if off > 1e-14 {
        for _ in 0..4 {
            let inverse = nearest.try_inverse().ok_or("a singular matrix")?;
            nearest = (nearest + inverse.transpose()) * 0.5;
        }
    }
    Ok(nearest)
}

/// Why a rig file is no rig.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum RigError {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("{path}: {camera}.{source}")]
    Camera {
        path: String,
        camera: String,
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

impl RigError {
    fn value(path: &Path, key: &str, expected: &str, found: impl Into<String>) -> Self {
        Self::Value {
            path: path.display().to_string(),
            key: key.to_owned(),
            expected: expected.to_owned(),
            found: found.into(),
        }
    }
}
