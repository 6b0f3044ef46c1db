//! Images in and out.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat,
    ImageReader,
};
use rodsight_geometry::{Image, Samples};

use crate::RenderError;
use crate::whole_file::{io, write_whole};

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

/// Writes a JPEG of the quality given, 1 to 100; colour is not subsampled.
///
/// # Errors
/// The file cannot be written, an image of 16 bits, or a side longer than 65 535 px, which the format cannot hold.
pub fn write_jpeg(path: &Path, image: &Image, quality: u8) -> Result<(), RenderError> {
    let Samples::U8(data) = image.samples() else {
        return Err(io(
            path,
            "expected an image of 8 bits for a JPEG, found one of 16",
        ));
    };
    let colour = match image.channels() {
        1 => ExtendedColorType::L8,
        _ => ExtendedColorType::Rgb8,
    };
    write_whole(path, |file| {
        JpegEncoder::new_with_quality(file, quality)
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
