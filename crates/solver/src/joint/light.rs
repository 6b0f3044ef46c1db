//! Linear light of a region, and how noisy it is.

use std::sync::OnceLock;

use rodsight_geometry::{Image, Samples};

use crate::Roi;

/// Linear light of a region, a plane a channel.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    pub(crate) roi: Roi,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Shape `[channels][height, width]`, 0 to 1.
    pub(crate) planes: Vec<Vec<f32>>,
}

/// The transfer function of sRGB, inverted (IEC 61966-2-1).
fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

fn table(steps: usize) -> Vec<f32> {
    let last = (steps - 1) as f64;
    (0..steps)
        .map(|code| decode(code as f64 / last) as f32)
        .collect()
}

impl Light {
    pub(crate) fn of(image: &Image, roi: Roi) -> Self {
        static OF_8: OnceLock<Vec<f32>> = OnceLock::new();
        static OF_16: OnceLock<Vec<f32>> = OnceLock::new();
        match image.samples() {
            Samples::U8(samples) => {
                let table = OF_8.get_or_init(|| table(1 << 8));
                Self::decoded(image, roi, samples, |code| table[usize::from(code)])
            }
            Samples::U16(samples) => {
                let table = OF_16.get_or_init(|| table(1 << 16));
                Self::decoded(image, roi, samples, |code| table[usize::from(code)])
            }
        }
    }

    fn decoded<T: Copy>(image: &Image, roi: Roi, samples: &[T], light: impl Fn(T) -> f32) -> Self {
        let channels = usize::from(image.channels());
        let (width, height) = (roi.width_px as usize, roi.height_px as usize);
        let stride = channels * image.width_px() as usize;
        let mut planes = vec![Vec::with_capacity(width * height); channels];
        for row in 0..height {
            let first = (roi.y_px as usize + row) * stride + channels * roi.x_px as usize;
            let row = &samples[first..first + channels * width];
            for (channel, plane) in planes.iter_mut().enumerate() {
                plane.extend(
                    row.iter()
                        .skip(channel)
                        .step_by(channels)
                        .map(|s| light(*s)),
                );
            }
        }
        Self {
            roi,
            width,
            height,
            planes,
        }
    }

    /// Means of squares of pixels; what does not fill one at the right and lower border is left out.
    pub(crate) fn binned(&self, factor: usize) -> Binned {
        let (width, height) = (self.width / factor, self.height / factor);
        let share = 1.0 / (factor * factor) as f32;
        let planes = self.planes.iter().map(|plane| {
            let mut binned = vec![0.0_f32; width * height];
            for row in 0..height * factor {
                let from = &plane[row * self.width..][..width * factor];
                let into = &mut binned[(row / factor) * width..][..width];
                for (sum, part) in into.iter_mut().zip(from.chunks_exact(factor)) {
                    *sum += share * part.iter().sum::<f32>();
                }
            }
            binned
        });
        Binned {
            factor,
            width,
            height,
            planes: planes.collect(),
        }
    }

    /// The light of a pixel of the image along an axis of colours.
    pub(crate) fn along(&self, axis: &[f64], column: usize, row: usize) -> f64 {
        let at = row * self.width + column;
        self.planes
            .iter()
            .zip(axis)
            .map(|(plane, weight)| weight * f64::from(plane[at]))
            .sum()
    }
}

/// A region at a coarser resolution.
#[derive(Clone, Debug)]
pub(crate) struct Binned {
    pub(crate) factor: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) planes: Vec<Vec<f32>>,
}
