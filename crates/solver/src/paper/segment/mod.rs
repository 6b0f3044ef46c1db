//! Binarisation: which pixels are rod.

mod binarise;
mod hsv;
mod learn;
mod majority;

use core::fmt;

use rodsight_geometry::{Image, Pixel};

use crate::Roi;
use crate::paper::{HueWindow, PaperParams, Refusal};

pub use binarise::binarise;
pub use hsv::Hsv;
pub(crate) use learn::for_other_eye;
pub use learn::learn;
pub use majority::majority;

/// How the rod is told from the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// By hue.
    Hue {
        /// The hues of the rod.
        window: HueWindow,
        /// Where the window comes from.
        source: HueSource,
    },
    /// By luminance.
    Luminance {
        /// Between rod and background, 0…1 of full scale (Otsu 1979).
        threshold: f64,
        /// Whether the rod is the brighter one.
        rod_is_bright: bool,
    },
}

/// Where a hue window comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HueSource {
    /// The parameters.
    Given,
    /// The disc around the pick, against the rim of the region.
    Pick,
    /// The most colourful hue that is not the rim's.
    Picture,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hue { window, source } => {
                let source = match source {
                    HueSource::Given => "given",
                    HueSource::Pick => "learned at the pick",
                    HueSource::Picture => "learned from the picture, no pick",
                };
                write!(
                    f,
                    "hue {:.0}° to {:.0}°, saturation from {:.2}, value from {:.2}, {source}",
                    window.from_deg, window.to_deg, window.min_saturation, window.min_value
                )
            }
            Self::Luminance {
                threshold,
                rod_is_bright,
            } => {
                let side = if *rod_is_bright { "above" } else { "below" };
                write!(f, "luminance (Otsu) {side} {threshold:.3}")
            }
        }
    }
}

/// Learns the rule in this image, applies it and takes speckle off: 0/255, shape `[roi.height, roi.width]`.
///
/// # Errors
/// Hue was demanded and does not tell rod from background.
pub fn segment(
    image: &Image,
    roi: &Roi,
    pick: Option<&Pixel>,
    params: &PaperParams,
) -> Result<(Vec<u8>, Rule), Refusal> {
    let rule = learn(image, roi, pick, params, "the")?;
    let mask = binarise(image, roi, &rule);
    Ok((majority(&mask, roi, params.mask_median_radius_px), rule))
}

/// One kind of sample, so that 8 and 16 bits share every loop.
pub(crate) trait Sample: Copy + Into<f32> + Sync {
    /// Nothing.
    const ZERO: Self;
    /// Largest value.
    const FULL: f32;
}

impl Sample for u8 {
    const ZERO: Self = 0;
    const FULL: f32 = 255.0;
}

impl Sample for u16 {
    const ZERO: Self = 0;
    const FULL: f32 = 65535.0;
}
