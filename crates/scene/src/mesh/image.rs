//! Images of base colour.

use std::path::Path;

use gltf::Document;
use gltf::texture::{Info, WrappingMode};
use image::{ImageReader, Limits};

use super::buffers::{Buffers, resolve};
use super::{Texture, Wrap};
use crate::SceneError;
use crate::error::Complaints;

/// No side of an image is longer, px.
const LARGEST_PX: u32 = 16_384;

/// Bytes the decoder may take: the largest image in four channels of 16 bits, and what it needs besides.
const MOST_BYTES: u64 = 8 * (LARGEST_PX as u64).pow(2) + (64 << 20);

fn limits() -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(LARGEST_PX);
    limits.max_image_height = Some(LARGEST_PX);
    limits.max_alloc = Some(MOST_BYTES);
    limits
}

/// The image behind a texture.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers<'_>,
    info: &Info<'_>,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<Texture, SceneError> {
    let texture = info.texture();
    let index = texture.source().index();
    let key = format!("images[{index}]");
    let no = Complaints { path };
    let source = &document.as_json().images[index];
    let bytes = match (&source.buffer_view, &source.uri) {
        (Some(view), None) => {
            let view = document.views().nth(view.value());
            buffers.view(&view.expect("a validated index"))?.to_vec()
        }
        (None, Some(uri)) => {
            resolve(uri, path).map_err(|(expected, found)| no.value(&key, expected, found))?
        }
        _ => return Err(no.value(key, "either a bufferView or a uri", "not one of them")),
    };
    let mut reader = ImageReader::new(std::io::Cursor::new(bytes));
    reader.limits(limits());
    let decoded = reader
        .with_guessed_format()
        .map_err(image::ImageError::from)
        .and_then(ImageReader::decode)
        .map_err(|error| {
            let expected = format!("a PNG or JPEG of at most {LARGEST_PX} px a side");
            no.value(&key, expected, error)
        })?;
    if decoded.color().bytes_per_pixel() > decoded.color().channel_count() {
        notes.push(format!("{key}: 16 bits a channel, read as 8"));
    }
    if decoded.color().has_alpha() {
        notes.push(format!("{key}: its transparency is looked past"));
    }
    let decoded = decoded.into_rgb8();
    let sampler = texture.sampler();
    Ok(Texture {
        width_px: decoded.width(),
        height_px: decoded.height(),
        srgb: decoded.pixels().map(|pixel| pixel.0).collect(),
        wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
    })
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::ClampToEdge => Wrap::Clamp,
    }
}

#[cfg(test)]
mod tests {
    use image::ColorType;

    use super::*;

    #[test]
    fn largest_image_may_be_decoded_and_a_larger_one_not() {
        let holds = |mut limits: Limits, side: u32| {
            limits.check_dimensions(side, side).is_ok()
                && limits.reserve_buffer(side, side, ColorType::Rgba16).is_ok()
        };
        assert!(holds(limits(), LARGEST_PX));
        assert!(!holds(limits(), LARGEST_PX + 1));
        // The decoder's own limits end before.
        assert!(!holds(Limits::default(), LARGEST_PX));
    }
}
