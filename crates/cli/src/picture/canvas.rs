//! An RGB picture with anti-aliased lines on it.

use std::path::Path;

use base64::Engine;
use image::codecs::jpeg::JpegEncoder;
use rodsight_geometry::{Image, ImageLine, Pixel, Samples};
use rodsight_solver::Roi;
use tiny_skia::{Color, FilterQuality, Paint, PathBuilder, Pixmap, PixmapPaint, Stroke, Transform};

use crate::failure::Failure;

/// sRGB, 8 bits each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Colour(pub(crate) u8, pub(crate) u8, pub(crate) u8);

/// A picture whose coordinates are pixels of the image it shows, however much it is magnified.
#[derive(Clone)]
pub(crate) struct Canvas {
    pixmap: Pixmap,
    /// Image coordinates of the top-left corner.
    origin: Pixel,
    /// Picture pixels per image pixel.
    scale: f64,
}

impl Canvas {
    /// A part of an image, magnified by a whole number without smoothing; `colour` gives each pixel.
    pub(crate) fn of(window: Roi, magnify: u32, colour: impl Fn(u32, u32) -> Colour) -> Self {
        let (width, height) = (
            window.width_px.max(1) * magnify,
            window.height_px.max(1) * magnify,
        );
        let mut pixmap = Pixmap::new(width, height).expect("a picture has pixels");
        for (index, pixel) in pixmap.data_mut().chunks_exact_mut(4).enumerate() {
            let (x, y) = (index as u32 % width, index as u32 / width);
            let Colour(r, g, b) = colour(window.x_px + x / magnify, window.y_px + y / magnify);
            pixel.copy_from_slice(&[r, g, b, 255]);
        }
        Self {
            pixmap,
            origin: Pixel::new(f64::from(window.x_px), f64::from(window.y_px)),
            scale: f64::from(magnify),
        }
    }

    /// A part of a camera's image.
    pub(crate) fn of_image(image: &Image, window: Roi, magnify: u32) -> Self {
        Self::of(window, magnify, |x, y| image_colour(image, x, y))
    }

    /// A camera's image.
    pub(crate) fn of_whole_image(image: &Image) -> Self {
        Self::of_image(image, Roi::whole(image), 1)
    }

    /// A polyline, in image coordinates; `width_px` in pixels of the picture.
    pub(crate) fn polyline(&mut self, points: &[Pixel], colour: Colour, width_px: f64) {
        let mut path = PathBuilder::new();
        for (i, point) in points.iter().enumerate() {
            let at = (point - self.origin) * self.scale;
            if i == 0 {
                path.move_to(at.x as f32, at.y as f32);
            } else {
                path.line_to(at.x as f32, at.y as f32);
            }
        }
        let Some(path) = path.finish() else { return };
        let mut paint = Paint {
            anti_alias: true,
            ..Paint::default()
        };
        paint.set_color(Color::from_rgba8(colour.0, colour.1, colour.2, 255));
        let stroke = Stroke {
            width: width_px as f32,
            ..Stroke::default()
        };
        self.pixmap
            .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }

    /// A straight line across the whole picture.
    pub(crate) fn line(&mut self, line: &ImageLine, colour: Colour, width_px: f64) {
        let reach = f64::from(self.pixmap.width() + self.pixmap.height()) / self.scale;
        let middle = self.origin
            + Pixel::new(
                f64::from(self.pixmap.width()),
                f64::from(self.pixmap.height()),
            ) * (0.5 / self.scale);
        let foot = middle - line.normal() * line.distance_px(&middle);
        self.polyline(
            &[
                foot - line.direction() * reach,
                foot + line.direction() * reach,
            ],
            colour,
            width_px,
        );
    }

    /// A cross.
    pub(crate) fn cross(&mut self, at: &Pixel, size_px: f64, colour: Colour, width_px: f64) {
        let arm = size_px / self.scale;
        for along in [Pixel::new(arm, arm), Pixel::new(arm, -arm)] {
            self.polyline(&[at - along, at + along], colour, width_px);
        }
    }

    /// The picture made smaller, smoothly, to at most this width.
    pub(crate) fn shrunk(&self, width_px: u32) -> Self {
        if self.pixmap.width() <= width_px {
            return self.clone();
        }
        self.scaled(f64::from(width_px) / f64::from(self.pixmap.width()))
    }

    /// The picture at this height, smoothly.
    pub(crate) fn of_height(&self, height_px: u32) -> Self {
        self.scaled(f64::from(height_px) / f64::from(self.pixmap.height()))
    }

    fn scaled(&self, factor: f64) -> Self {
        let size = |pixels: u32| (f64::from(pixels) * factor).round().max(1.0) as u32;
        let (width_px, height_px) = (size(self.pixmap.width()), size(self.pixmap.height()));
        let source =
            image::RgbImage::from_raw(self.pixmap.width(), self.pixmap.height(), self.rgb())
                .expect("sizes agree");
        let small = image::imageops::thumbnail(&source, width_px, height_px);
        let window = Roi {
            x_px: 0,
            y_px: 0,
            width_px,
            height_px,
        };
        let mut canvas = Self::of(window, 1, |x, y| {
            let [r, g, b] = small.get_pixel(x, y).0;
            Colour(r, g, b)
        });
        canvas.scale = self.scale * factor;
        canvas.origin = self.origin;
        canvas
    }

    /// Pictures side by side in rows, with a gap.
    pub(crate) fn sheet(rows: &[Vec<Self>]) -> Self {
        const GAP: u32 = 12;
        let row_width =
            |row: &Vec<Self>| row.iter().map(|c| c.pixmap.width() + GAP).sum::<u32>() + GAP;
        let row_height =
            |row: &Vec<Self>| row.iter().map(|c| c.pixmap.height()).max().unwrap_or(0) + GAP;
        let window = Roi {
            x_px: 0,
            y_px: 0,
            width_px: rows.iter().map(row_width).max().unwrap_or(1),
            height_px: rows.iter().map(row_height).sum::<u32>() + GAP,
        };
        let mut sheet = Self::of(window, 1, |_, _| Colour(24, 28, 34));
        let mut y = GAP;
        for row in rows {
            let mut x = GAP;
            for picture in row {
                let paint = PixmapPaint {
                    quality: FilterQuality::Nearest,
                    ..PixmapPaint::default()
                };
                sheet.pixmap.draw_pixmap(
                    x.cast_signed(),
                    y.cast_signed(),
                    picture.pixmap.as_ref(),
                    &paint,
                    Transform::identity(),
                    None,
                );
                x += picture.pixmap.width() + GAP;
            }
            y += row_height(row);
        }
        sheet
    }

    fn rgb(&self) -> Vec<u8> {
        self.pixmap
            .data()
            .chunks_exact(4)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect()
    }

    /// As an image of ours.
    pub(crate) fn to_image(&self) -> Image {
        Image::new(
            self.pixmap.width(),
            self.pixmap.height(),
            3,
            Samples::U8(self.rgb()),
        )
        .expect("three samples a pixel")
    }

    /// Writes a PNG.
    pub(crate) fn write(&self, path: &Path) -> Result<(), Failure> {
        Ok(rodsight_render::write_image(path, &self.to_image())?)
    }

    /// A JPEG in a `data:` URL, for pages that carry their pictures.
    pub(crate) fn data_url(&self) -> Result<String, Failure> {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, 88)
            .encode(
                &self.rgb(),
                self.pixmap.width(),
                self.pixmap.height(),
                image::ExtendedColorType::Rgb8,
            )
            .map_err(Failure::failed)?;
        Ok(format!(
            "data:image/jpeg;base64,{}",
            base64::engine::general_purpose::STANDARD.encode(bytes)
        ))
    }
}

/// The colour of a camera image's pixel, 8 bits.
pub(crate) fn image_colour(image: &Image, x: u32, y: u32) -> Colour {
    let channels = usize::from(image.channels());
    let index = (y as usize * image.width_px() as usize + x as usize) * channels;
    let sample = |k: usize| match image.samples() {
        Samples::U8(values) => values[index + k],
        Samples::U16(values) => (values[index + k] >> 8) as u8,
    };
    if channels == 1 {
        Colour(sample(0), sample(0), sample(0))
    } else {
        Colour(sample(0), sample(1), sample(2))
    }
}
