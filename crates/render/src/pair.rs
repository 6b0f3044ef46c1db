//! A whole pair on disk.

use std::io::Write;
use std::path::{Path, PathBuf};

use rodsight_geometry::RigFile;
use rodsight_scene::{Scene, SceneFile};

use crate::RenderError;
use crate::develop::Developed;
use crate::exr_file::write_exr;
use crate::frame::Frame;
use crate::image_file::write_image;
use crate::truth::Truth;
use crate::whole_file::{io, write_whole};

/// Where the files of a pair lie.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub struct PairPaths {
    pub left_png: PathBuf,
    pub right_png: PathBuf,
    pub left_exr: PathBuf,
    pub right_exr: PathBuf,
    pub truth_json: PathBuf,
    pub rig_toml: PathBuf,
    pub scene_toml: PathBuf,
}

impl PairPaths {
    /// The file names every pair has, in a folder.
    pub fn in_folder(folder: &Path) -> Self {
        Self {
            left_png: folder.join("left.png"),
            right_png: folder.join("right.png"),
            left_exr: folder.join("left.exr"),
            right_exr: folder.join("right.exr"),
            truth_json: folder.join("truth.json"),
            rig_toml: folder.join("rig.toml"),
            scene_toml: folder.join("scene.toml"),
        }
    }
}

/// Writes `left.png right.png rig.toml scene.toml truth.json` and, of the frame if one is given, `left.exr right.exr` into an
/// existing folder. Each file appears whole or not at all, and `truth.json` last: a folder with it is complete and of one piece.
///
/// # Errors
/// The file that cannot be written and why.
pub fn write_pair(
    folder: &Path,
    scene: &Scene,
    channels: Option<&Frame>,
    developed: &Developed,
    truth: &Truth,
) -> Result<PairPaths, RenderError> {
    let paths = PairPaths::in_folder(folder);
    // What an earlier run left must not stand beside what comes now.
    for stale in [&paths.truth_json, &paths.left_exr, &paths.right_exr] {
        match std::fs::remove_file(stale) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(io(stale, error));
            }
            _ => {}
        }
    }
    write_image(&paths.left_png, &developed.left)?;
    write_image(&paths.right_png, &developed.right)?;
    if let Some(frame) = channels {
        write_exr(&paths.left_exr, &frame.left)?;
        write_exr(&paths.right_exr, &frame.right)?;
    }
    write_whole(&paths.rig_toml, |file| {
        file.write_all(RigFile::from_rig(&scene.rig).to_toml().as_bytes())
    })?;
    write_whole(&paths.scene_toml, |file| {
        file.write_all(SceneFile::from_scene(scene).to_toml().as_bytes())
    })?;
    write_whole(&paths.truth_json, |file| {
        serde_json::to_writer_pretty(&mut *file, truth)?;
        file.write_all(b"\n")
    })?;
    Ok(paths)
}
