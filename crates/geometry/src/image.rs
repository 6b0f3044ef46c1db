//! Images as they come from a camera, and the pair of them with the rig that took them.

use crate::{MountedCamera, Rig};

/// Interleaved samples, row-major, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Samples {
    /// 8 bits each.
    U8(Vec<u8>),
    /// 16 bits each.
    U16(Vec<u16>),
}

impl Samples {
    /// How many samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// An sRGB-encoded image of one (grey) or three (R, G, B) channels, shape `[height, width, channels]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width_px: u32,
    height_px: u32,
    channels: u8,
    samples: Samples,
}

/// Why samples are no image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum ImageError {
    #[error("expected 1 or 3 channels, found {found}")]
    Channels { found: u8 },
    #[error("expected an image, found {width_px}×{height_px} px")]
    Empty { width_px: u32, height_px: u32 },
    #[error("expected {width_px}×{height_px}×{channels} samples, found {found}")]
    Length {
        width_px: u32,
        height_px: u32,
        channels: u8,
        found: usize,
    },
    #[error(
        "{eye} image: expected {expected_width_px}×{expected_height_px} px as in the rig, found {width_px}×{height_px}"
    )]
    Size {
        eye: &'static str,
        expected_width_px: u32,
        expected_height_px: u32,
        width_px: u32,
        height_px: u32,
    },
}

impl Image {
    /// An image from its samples.
    ///
    /// # Errors
    /// A channel count other than 1 or 3, no pixels, or a wrong number of samples.
    pub fn new(
        width_px: u32,
        height_px: u32,
        channels: u8,
        samples: Samples,
    ) -> Result<Self, ImageError> {
        if !matches!(channels, 1 | 3) {
            return Err(ImageError::Channels { found: channels });
        }
        if width_px == 0 || height_px == 0 {
            return Err(ImageError::Empty {
                width_px,
                height_px,
            });
        }
        // In 128 bits: three channels of the largest sizes overflow 64.
        let expected = u128::from(width_px) * u128::from(height_px) * u128::from(channels);
        if samples.len() as u128 != expected {
            return Err(ImageError::Length {
                width_px,
                height_px,
                channels,
                found: samples.len(),
            });
        }
        Ok(Self {
            width_px,
            height_px,
            channels,
            samples,
        })
    }

    /// Width, px.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Height, px.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// 1 or 3.
    pub fn channels(&self) -> u8 {
        self.channels
    }

    /// The samples, shape `[height, width, channels]`.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }
}

/// All a solver is given: two images and the rig that took them.
#[derive(Clone, Debug)]
pub struct StereoPair {
    /// The rig.
    pub rig: Rig,
    /// The left camera's image.
    pub left: Image,
    /// The right camera's image.
    pub right: Image,
}

impl StereoPair {
    /// A pair whose images have the sizes the rig promises.
    ///
    /// # Errors
    /// An image of another size.
    pub fn new(rig: Rig, left: Image, right: Image) -> Result<Self, ImageError> {
        let check = |eye, image: &Image, mounted: &MountedCamera| {
            let i = mounted.camera.intrinsics();
            if (image.width_px, image.height_px) == (i.width_px, i.height_px) {
                return Ok(());
            }
            Err(ImageError::Size {
                eye,
                expected_width_px: i.width_px,
                expected_height_px: i.height_px,
                width_px: image.width_px,
                height_px: image.height_px,
            })
        };
        check("left", &left, &rig.left)?;
        check("right", &right, &rig.right)?;
        Ok(Self { rig, left, right })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_refuses_what_is_none() {
        let image = |w, h, c, n| Image::new(w, h, c, Samples::U8(vec![0; n])).map(|_| ());
        assert_eq!(image(2, 3, 3, 18), Ok(()));
        assert_eq!(image(2, 3, 4, 24), Err(ImageError::Channels { found: 4 }));
        assert!(matches!(
            image(2, 3, 1, 5),
            Err(ImageError::Length { found: 5, .. })
        ));
        assert!(matches!(image(0, 3, 1, 0), Err(ImageError::Empty { .. })));
        assert!(matches!(
            image(u32::MAX, u32::MAX, 3, 1),
            Err(ImageError::Length { .. })
        ));
    }
}
