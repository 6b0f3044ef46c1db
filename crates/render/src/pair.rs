//! A whole pair on disk.

use std::io::Write;
use std::path::{Path, PathBuf};

use rodsight_geometry::RigFile;
use rodsight_scene::{ImageFormat, Scene, SceneFile};

use crate::RenderError;
use crate::develop::Developed;
use crate::exr_file::write_exr;
use crate::frame::Frame;
use crate::image_file::{write_image, write_jpeg};
use crate::truth::Truth;
use crate::whole_file::{io, write_whole};

/// Where the files of a pair lie.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub struct PairPaths {
    /// PNG or JPEG.
    pub left_image: PathBuf,
    pub right_image: PathBuf,
    pub left_raw: PathBuf,
    pub right_raw: PathBuf,
    pub left_exr: PathBuf,
    pub right_exr: PathBuf,
    pub truth_json: PathBuf,
    pub rig_toml: PathBuf,
    pub scene_toml: PathBuf,
}

impl PairPaths {
    /// The file names every pair of a format has, in a folder.
    pub fn in_folder(folder: &Path, format: ImageFormat) -> Self {
        let extension = match format {
            ImageFormat::Png => "png",
            ImageFormat::Jpeg => "jpg",
        };
        Self {
            left_image: folder.join(format!("left.{extension}")),
            right_image: folder.join(format!("right.{extension}")),
            left_raw: folder.join("left_raw.png"),
            right_raw: folder.join("right_raw.png"),
            left_exr: folder.join("left.exr"),
            right_exr: folder.join("right.exr"),
            truth_json: folder.join("truth.json"),
            rig_toml: folder.join("rig.toml"),
            scene_toml: folder.join("scene.toml"),
        }
    }

    /// The files of a pair that is there: those with JPEG images if there are such, of which a folder has one kind only.
    pub fn found_in(folder: &Path) -> Self {
        let jpeg = Self::in_folder(folder, ImageFormat::Jpeg);
        if jpeg.left_image.exists() {
            jpeg
        } else {
            Self::in_folder(folder, ImageFormat::Png)
        }
    }
}

/// Writes `left.png right.png rig.toml scene.toml truth.json` (or `left.jpg right.jpg`), a mesh in `props` for each prop, the raw images
/// if they were developed and, of the frame if one is given, `left.exr right.exr` into an existing folder. Each file appears whole or
/// not at all, and `truth.json` last: a folder with it is complete and of one piece.
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
    let paths = PairPaths::in_folder(folder, scene.output.format);
    remove_stale(folder, &paths, scene.output.format)?;
    match scene.output.format {
        ImageFormat::Png => {
            write_image(&paths.left_image, &developed.left)?;
            write_image(&paths.right_image, &developed.right)?;
        }
        ImageFormat::Jpeg => {
            let quality = scene.output.jpeg_quality;
            write_jpeg(&paths.left_image, &developed.left, quality)?;
            write_jpeg(&paths.right_image, &developed.right, quality)?;
        }
    }
    if let Some([left, right]) = &developed.raw {
        write_image(&paths.left_raw, left)?;
        write_image(&paths.right_raw, right)?;
    }
    if let Some(frame) = channels {
        write_exr(&paths.left_exr, &frame.left)?;
        write_exr(&paths.right_exr, &frame.right)?;
    }
    for prop in &scene.props {
        let path = folder.join(prop.written_file());
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|error| io(parent, error))?;
        write_whole(&path, |file| file.write_all(&prop.mesh.to_glb()))?;
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

/// What an earlier run left must not stand beside what comes now.
fn remove_stale(folder: &Path, paths: &PairPaths, format: ImageFormat) -> Result<(), RenderError> {
    let other = PairPaths::in_folder(
        folder,
        match format {
            ImageFormat::Png => ImageFormat::Jpeg,
            ImageFormat::Jpeg => ImageFormat::Png,
        },
    );
    for stale in [
        &paths.truth_json,
        &other.left_image,
        &other.right_image,
        &paths.left_raw,
        &paths.right_raw,
        &paths.left_exr,
        &paths.right_exr,
    ] {
        match std::fs::remove_file(stale) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(io(stale, error));
            }
            _ => {}
        }
    }
    Ok(())
}
