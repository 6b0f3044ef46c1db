//! Further pairs of one rod: what `solve --also` reads.

use std::path::{Path, PathBuf};

use rodsight_geometry::{ImageError, MountEntry, Pose, Rig, RigFrame, StereoPair, config, radians};
use rodsight_render::read_image;
use rodsight_solver::{MoveSigma, MovedPair, Roi};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::failure::Failure;

/// A further pair of the same rod, taken from where the rig went; `schema = 1`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AlsoFile {
    /// Version of this format: 1.
    schema: u32,
    /// Left image; a path that is not absolute begins at this file's folder.
    left: PathBuf,
    /// Right image.
    right: PathBuf,
    /// Where the rig is in the frame of the first pair's rig: x forward, y starboard, z down, where it was then.
    rig_from_moved: MountEntry,
    /// How well that is known; absent: exactly.
    #[serde(default)]
    sigma: Option<SigmaEntry>,
    /// Rig file, if it is not the first pair's.
    #[serde(default)]
    rig: Option<PathBuf>,
    /// Region of the left image.
    #[serde(default)]
    roi_left: Option<Roi>,
    /// Region of the right image.
    #[serde(default)]
    roi_right: Option<Roi>,
}

/// How well a move is known.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SigmaEntry {
    /// Standard deviation along each axis, m.
    translation_m: f64,
    /// Standard deviation about each axis, degrees.
    rotation_deg: f64,
}

const SCHEMA: u32 = 1;

/// Such a pair with its images.
#[derive(Debug)]
pub(crate) struct Also {
    pair: StereoPair,
    rig_from_moved: Pose<RigFrame, RigFrame>,
    sigma: Option<MoveSigma>,
    roi_left: Option<Roi>,
    roi_right: Option<Roi>,
}

impl Also {
    /// Reads the file and what it names; `rig` and its file are the first pair's.
    pub(crate) fn load(path: &Path, (rig, rig_path): (&Rig, &Path)) -> Result<Self, Failure> {
        let file: AlsoFile = config::read_text(path)
            .and_then(|text| config::parse_toml(&text, path))
            .map_err(Failure::input)?;
        let complain = |key: &str, expected: &str, found: &str| {
            let file = path.display();
            Failure::Input(anyhow::anyhow!(
                "{file}: {key}: expected {expected}, found {found}"
            ))
        };
        if file.schema != SCHEMA {
            return Err(complain("schema", "1", &file.schema.to_string()));
        }
        let rig_from_moved = file.rig_from_moved.to_pose();
        let rig_from_moved = rig_from_moved.map_err(|(key, expected, found)| {
            complain(&format!("rig_from_moved.{key}"), expected, &found)
        })?;
        let sigma = file.sigma.map(|sigma| {
            let values = [
                ("translation_m", sigma.translation_m),
                ("rotation_deg", sigma.rotation_deg),
            ];
            match values
                .into_iter()
                .find(|(_, v)| !(v.is_finite() && *v >= 0.0))
            {
                Some((key, found)) => Err(complain(
                    &format!("sigma.{key}"),
                    "a standard deviation, 0 or more",
                    &found.to_string(),
                )),
                None => Ok(MoveSigma {
                    translation_m: sigma.translation_m,
                    rotation_rad: radians(sigma.rotation_deg),
                }),
            }
        });
        let folder = path.parent().unwrap_or(Path::new(""));
        let (left, right) = (folder.join(&file.left), folder.join(&file.right));
        let own_rig = file.rig.map(|rig| folder.join(rig));
        let rig = match &own_rig {
            Some(path) => Rig::load(path).map_err(Failure::input)?,
            None => *rig,
        };
        Ok(Self {
            pair: stereo_pair(
                (&rig, own_rig.as_deref().unwrap_or(rig_path)),
                &left,
                &right,
            )
            .map_err(|failure| failure.of(path))?,
            rig_from_moved,
            sigma: sigma.transpose()?,
            roi_left: file.roi_left,
            roi_right: file.roi_right,
        })
    }

    pub(crate) fn moved(&self) -> MovedPair<'_> {
        MovedPair {
            sigma: self.sigma,
            roi_left: self.roi_left,
            roi_right: self.roi_right,
            ..MovedPair::new(&self.pair, self.rig_from_moved)
        }
    }
}

/// Reads two images of a rig.
pub(crate) fn stereo_pair(
    (rig, rig_path): (&Rig, &Path),
    left: &Path,
    right: &Path,
) -> Result<StereoPair, Failure> {
    StereoPair::new(*rig, read_image(left)?, read_image(right)?).map_err(|error| {
        let file = if matches!(error, ImageError::Size { eye: "right", .. }) {
            right
        } else {
            left
        };
        Failure::Input(anyhow::anyhow!(
            "{}: {error} ({})",
            file.display(),
            rig_path.display()
        ))
    })
}
