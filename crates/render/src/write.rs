//! Images in and out, and a whole pair on disk.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat,
    ImageReader,
};
use rodsight_geometry::{Eye, Image, RigFile, Samples};
use rodsight_scene::{Scene, SceneFile};

use crate::RenderError;
use crate::develop::Developed;
use crate::exr_file::write_exr;
use crate::frame::Frame;
use crate::truth::Truth;

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

pub(crate) fn io(path: &Path, error: impl std::fmt::Display) -> RenderError {
    RenderError::Io {
        path: path.to_owned(),
        message: error.to_string(),
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

/// Temporary files that are being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Takes away what is half-written, for the end of an interrupted program: no file can be begun or finished any more.
pub fn discard_unfinished() {
    let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for part in unfinished.iter() {
        // Best effort: there is nobody left to tell.
        drop(std::fs::remove_file(part));
    }
    std::mem::forget(unfinished);
}

/// Writes a file through a temporary neighbour, so that a full disk or a kill leaves no half file under the final name.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), RenderError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let unfinished = || UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    // Under the lock, both: no file comes up between the last look at the list and the end of the program.
    let begin = || {
        let mut unfinished = unfinished();
        unfinished.push(part.clone());
        File::create(&part)
    };
    let end = |written: std::io::Result<()>| {
        let mut unfinished = unfinished();
        unfinished.retain(|other| *other != part);
        written.and_then(|()| std::fs::rename(&part, path))
    };
    let written = begin().and_then(|file| {
        let mut file = BufWriter::new(file);
        content(&mut file)?;
        file.flush()
    });
    end(written).map_err(|error| {
        // Best effort: the error to report is the first one.
        drop(std::fs::remove_file(&part));
        io(path, error)
    })
}

/// Writes a PNG of 8 or 16 bits, at the fast level (the default one is thirty times slower on noise for 2 % fewer bytes).
///
/// # Errors
/// The file cannot be written.
pub fn write_image(path: &Path, image: &Image) -> Result<(), RenderError> {
    let bytes: Vec<u8>;
    let (data, colour): (&[u8], _) = match (image.samples(), image.channels()) {
        (Samples::U8(values), 1) => (values, ExtendedColorType::L8),
        (Samples::U8(values), _) => (values, ExtendedColorType::Rgb8),
        (Samples::U16(values), channels) => {
            bytes = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
            (
                &bytes,
                if channels == 1 {
                    ExtendedColorType::L16
                } else {
                    ExtendedColorType::Rgb16
                },
            )
        }
    };
    write_whole(path, |file| {
        PngEncoder::new_with_quality(file, CompressionType::Fast, FilterType::Adaptive)
            .write_image(data, image.width_px(), image.height_px(), colour)
            .map_err(std::io::Error::other)
    })
}

/// The largest sensors have half of this.
const LARGEST_IMAGE_PX: u64 = 1 << 28;

/// Reads a PNG or JPEG, grey or RGB (transparency is dropped), 8 or 16 bits.
///
/// # Errors
/// No such file, not an image, or one that holds floating-point samples.
pub fn read_image(path: &Path) -> Result<Image, RenderError> {
    let file = File::open(path).map_err(|error| io(path, error))?;
    let reader = ImageReader::new(BufReader::new(file))
        .with_guessed_format()
        .map_err(|error| io(path, error))?;
    let expected = "expected a PNG or JPEG image, found";
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => {}
        Some(other) => return Err(io(path, format!("{expected} {other:?}"))),
        None => return Err(io(path, format!("{expected} something else"))),
    }
    let broken = |error| io(path, format!("{expected} a broken one: {error}"));
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    // Before anything is allocated: a file of a few bytes may promise any size.
    if u64::from(width) * u64::from(height) > LARGEST_IMAGE_PX {
        let message = format!("expected at most {LARGEST_IMAGE_PX} pixels, found {width}×{height}");
        return Err(io(path, message));
    }
    let grey = matches!(
        decoder.color_type(),
        ColorType::L8 | ColorType::La8 | ColorType::L16 | ColorType::La16
    );
    let wide = decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count() == 2;
    let decoded = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let (channels, samples) = match (grey, wide) {
        (true, false) => (1, Samples::U8(decoded.into_luma8().into_raw())),
        (true, true) => (1, Samples::U16(decoded.into_luma16().into_raw())),
        (false, false) => (3, Samples::U8(decoded.into_rgb8().into_raw())),
        (false, true) => (3, Samples::U16(decoded.into_rgb16().into_raw())),
    };
    Image::new(width, height, channels, samples).map_err(|error| io(path, error))
}

/// The images of a pair, by eye.
impl Developed {
    /// The image of an eye.
    pub fn eye(&self, eye: Eye) -> &Image {
        match eye {
            Eye::Left => &self.left,
            Eye::Right => &self.right,
        }
    }
}
