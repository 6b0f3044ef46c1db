//! Linear light of a region: of single pixels, and of means of squares of them.

use core::ops::AddAssign;
use std::sync::OnceLock;

use rodsight_geometry::{Image, Samples};

use crate::Roi;

/// A region of an image, decoded where it is looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light<'a> {
    pub(crate) roi: Roi,
    pub(crate) width: usize,
    pub(crate) height: usize,
    channels: usize,
    /// Samples from row to row of the image.
    stride: usize,
    /// The region's first sample.
    first: usize,
    codes: Codes<'a>,
}

/// Encoded samples and the light, 0 to 1, of each code.
#[derive(Clone, Copy, Debug)]
enum Codes<'a> {
    U8(&'a [u8], &'static [f32; 1 << 8]),
    U16(&'a [u16], &'static [f32]),
}

/// The transfer function of sRGB, inverted (IEC 61966-2-1).
fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

fn decoded(index: usize, last: usize) -> f32 {
    decode(index as f64 / last as f64) as f32
}

impl<'a> Light<'a> {
    pub(crate) fn of(image: &'a Image, roi: Roi) -> Self {
        static OF_8: OnceLock<[f32; 1 << 8]> = OnceLock::new();
        static OF_16: OnceLock<Vec<f32>> = OnceLock::new();
        let codes = match image.samples() {
            Samples::U8(samples) => Codes::U8(
                samples,
                OF_8.get_or_init(|| core::array::from_fn(|code| decoded(code, u8::MAX.into()))),
            ),
            Samples::U16(samples) => {
                let all = 0..=usize::from(u16::MAX);
                let table = || all.map(|code| decoded(code, u16::MAX.into())).collect();
                Codes::U16(samples, OF_16.get_or_init(table))
            }
        };
        let channels = usize::from(image.channels());
        let stride = channels * image.width_px() as usize;
        Self {
            roi,
            width: roi.width_px as usize,
            height: roi.height_px as usize,
            channels,
            stride,
            first: roi.y_px as usize * stride + roi.x_px as usize * channels,
            codes,
        }
    }

    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// The light of a pixel of the region along an axis of colours.
    pub(crate) fn along(&self, axis: &[f64], column: usize, row: usize) -> f64 {
        let first = self.first + row * self.stride + column * self.channels;
        let pixel = first..first + self.channels;
        match self.codes {
            Codes::U8(samples, table) => dot(&samples[pixel], axis, |c| table[usize::from(c)]),
            Codes::U16(samples, table) => dot(&samples[pixel], axis, |c| table[usize::from(c)]),
        }
    }

    /// The side of the smallest squares of which there are so few, and so few a side.
    pub(crate) fn factor(&self, squares: usize, side: usize) -> usize {
        let mut factor = self.width.max(self.height).div_ceil(side).max(1);
        while (self.width / factor) * (self.height / factor) > squares {
            factor += 1;
        }
        factor
    }

    /// Means of squares of pixels; what does not fill one at the right and lower border is left out.
    ///
    /// Codes are added and their mean decoded, nearly: the same but where light is uneven within a square, and a fraction of the work.
    pub(crate) fn binned(&self, factor: usize) -> Binned {
        let (width, height) = (self.width / factor, self.height / factor);
        let mut binned = Binned {
            factor,
            width,
            height,
            planes: vec![vec![0.0; width * height]; self.channels],
        };
        // The narrowest sums that hold a square of the largest codes are the fastest.
        match self.codes {
            Codes::U8(codes, _) if factor <= 16 => self.bin::<u8, u16>(codes, &mut binned),
            Codes::U8(codes, _) if factor <= 4096 => self.bin::<u8, u32>(codes, &mut binned),
            Codes::U8(codes, _) => self.bin::<u8, u64>(codes, &mut binned),
            Codes::U16(codes, _) if factor <= 256 => self.bin::<u16, u32>(codes, &mut binned),
            Codes::U16(codes, _) => self.bin::<u16, u64>(codes, &mut binned),
        }
        binned
    }

    fn bin<T, S>(&self, codes: &[T], binned: &mut Binned)
    where
        T: Copy + Bounded,
        S: Copy + Default + From<T> + Into<u64> + AddAssign,
    {
        let (channels, factor) = (self.channels, binned.factor);
        let share = 1.0 / (T::LAST * (factor * factor) as f32);
        let mut columns = vec![S::default(); channels * binned.width * factor];
        let mut squares = columns.clone();
        for row in 0..binned.height {
            columns.fill(S::default());
            for row in row * factor..(row + 1) * factor {
                let first = self.first + row * self.stride;
                for (sum, code) in columns.iter_mut().zip(&codes[first..]) {
                    *sum += S::from(*code);
                }
            }
            // Squares from all columns on, though few are needed: neighbours in memory are added at once.
            squares.copy_from_slice(&columns);
            for ahead in 1..factor {
                for (sum, column) in squares.iter_mut().zip(&columns[ahead * channels..]) {
                    *sum += *column;
                }
            }
            for (channel, plane) in binned.planes.iter_mut().enumerate() {
                let ours = squares.iter().skip(channel).step_by(channels * factor);
                let plane = &mut plane[row * binned.width..][..binned.width];
                for (value, sum) in plane.iter_mut().zip(ours) {
                    let sum: u64 = (*sum).into();
                    *value = sum.cast_signed() as f32;
                }
                for value in plane {
                    *value = nearly_decoded(*value * share);
                }
            }
        }
    }
}

/// A sample's largest code.
trait Bounded {
    const LAST: f32;
}

impl Bounded for u8 {
    const LAST: f32 = 255.0;
}

impl Bounded for u16 {
    const LAST: f32 = 65535.0;
}

fn dot<T: Copy>(codes: &[T], axis: &[f64], light: impl Fn(T) -> f32) -> f64 {
    let pairs = codes.iter().zip(axis);
    pairs
        .map(|(code, weight)| weight * f64::from(light(*code)))
        .sum()
}

/// `decode` to one part in 1600, without a branch: with v the root, v⁴ times a polynomial of what v^0.8 is.
fn nearly_decoded(encoded: f32) -> f32 {
    let v = ((encoded + 0.055) * (1.0 / 1.055)).sqrt();
    let power = 0.055_876 + v * (1.175_578 + v * (0.092_136 * v - 0.323_479));
    let v2 = v * v;
    if encoded <= 0.040_45 {
        encoded * (1.0 / 12.92)
    } else {
        v2 * v2 * power
    }
}

/// A region at a coarser resolution.
#[derive(Clone, Debug)]
pub(crate) struct Binned {
    pub(crate) factor: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Shape `[channels][height, width]`, 0 to 1.
    pub(crate) planes: Vec<Vec<f32>>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_decoded_is_nearly_decoded() {
        for step in 0..=1000 {
            let encoded = f64::from(step) / 1000.0;
            let (nearly, light) = (f64::from(nearly_decoded(encoded as f32)), decode(encoded));
            assert!(
                (nearly - light).abs() <= light / 1600.0,
                "{encoded}: {nearly} {light}"
            );
        }
    }

    /// A square of one light is of that light; regions begin anywhere, and what fills no square is left out.
    #[test]
    fn squares_are_means_of_their_pixels() {
        let sample =
            |x: usize, y: usize, channel: usize| (40 * (x / 3) + 10 * (y / 3) + 3 * channel) as u16;
        let (width, height) = (11_u32, 8_u32);
        for channels in [1_u8, 3] {
            let samples: Vec<u16> = (0..height as usize)
                .flat_map(|y| (0..width as usize).map(move |x| (x, y)))
                .flat_map(|(x, y)| (0..usize::from(channels)).map(move |c| sample(x, y, c)))
                .collect();
            let narrow = samples.iter().map(|code| *code as u8).collect();
            let wide = samples.iter().map(|code| code * 257).collect();
            for samples in [Samples::U8(narrow), Samples::U16(wide)] {
                let image = Image::new(width, height, channels, samples).expect("an image");
                let roi = Roi {
                    x_px: 3,
                    y_px: 0,
                    width_px: 8,
                    height_px: 8,
                };
                let light = Light::of(&image, roi);
                let binned = light.binned(3);
                assert_eq!((binned.width, binned.height), (2, 2));
                for (channel, plane) in binned.planes.iter().enumerate() {
                    let mut axis = [0.0; 3];
                    axis[channel] = 1.0;
                    for (at, value) in plane.iter().enumerate() {
                        let (column, row) = (3 * (at % 2), 3 * (at / 2));
                        let pixel = light.along(&axis, column, row);
                        let expected = f64::from(nearly_decoded(
                            f32::from(sample(3 + column, row, channel)) / 255.0,
                        ));
                        assert!((f64::from(*value) - expected).abs() < 1e-6);
                        assert!((pixel - expected).abs() <= expected / 1600.0 + 1e-7);
                    }
                }
            }
        }
    }
}
