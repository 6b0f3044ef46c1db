//! The rule applied to every pixel of a region.

use rodsight_geometry::{Image, Samples};

use super::hsv::hue_ray;
use super::{Rule, Sample};
use crate::Roi;
use crate::paper::HueWindow;

/// Pixels per inner loop: fits registers and first-level cache, and lets the compiler use vectors.
const CHUNK: usize = 64;

/// 255 where the rule says rod, else 0; shape `[roi.height, roi.width]`.
pub fn binarise(image: &Image, roi: &Roi, rule: &Rule) -> Vec<u8> {
    match image.samples() {
        Samples::U8(samples) => binarise_samples(image, samples, roi, rule),
        Samples::U16(samples) => binarise_samples(image, samples, roi, rule),
    }
}

fn binarise_samples<T: Sample>(image: &Image, samples: &[T], roi: &Roi, rule: &Rule) -> Vec<u8> {
    let mut mask = vec![0; roi.area_px()];
    let channels = image.channels() as usize;
    let (width, stride) = (roi.width_px as usize, image.width_px() as usize * channels);
    for (row, out) in mask.chunks_exact_mut(width).enumerate() {
        let start = (roi.y_px as usize + row) * stride + roi.x_px as usize * channels;
        let row = &samples[start..start + width * channels];
        match (rule, channels) {
            (Rule::Hue { window, .. }, 3) => hue_row(row, &HueTest::new::<T>(window), out),
            // A grey image has no hue: nothing is in the window.
            (Rule::Hue { .. }, _) => {}
            (
                Rule::Luminance {
                    threshold,
                    rod_is_bright,
                },
                _,
            ) => {
                let threshold = *threshold as f32 * T::FULL;
                for (out, pixel) in out.iter_mut().zip(row.chunks_exact(channels)) {
                    *out = if (luminance(pixel) > threshold) == *rod_is_bright {
                        255
                    } else {
                        0
                    };
                }
            }
        }
    }
    mask
}

/// Luma of one pixel, in sample units: (R + 2G + B)/4, near enough to any standard for a threshold.
pub(super) fn luminance<T: Sample>(pixel: &[T]) -> f32 {
    match *pixel {
        [r, g, b] => 0.25 * (r.into() + 2.0 * g.into() + b.into()),
        [grey, ..] => grey.into(),
        [] => 0.0,
    }
}

/// A hue window as two half-plane tests of (R − B, G − B): no division, no branch per pixel.
struct HueTest {
    from: [f32; 2],
    to: [f32; 2],
    /// Windows of 180° and more are the union of the two half planes, smaller ones their intersection.
    wide: bool,
    min_saturation: f32,
    min_value: f32,
}

impl HueTest {
    fn new<T: Sample>(window: &HueWindow) -> Self {
        Self {
            from: hue_ray(window.from_deg),
            to: hue_ray(window.to_deg),
            wide: (window.to_deg - window.from_deg).rem_euclid(360.0) >= 180.0,
            min_saturation: window.min_saturation as f32,
            min_value: window.min_value as f32 * T::FULL,
        }
    }
}

fn hue_row<T: Sample>(row: &[T], test: &HueTest, out: &mut [u8]) {
    let (mut r, mut g, mut b) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK], [T::ZERO; CHUNK]);
    for (pixels, out) in row.chunks(3 * CHUNK).zip(out.chunks_mut(CHUNK)) {
        for (((r, g), b), pixel) in r
            .iter_mut()
            .zip(&mut g)
            .zip(&mut b)
            .zip(pixels.chunks_exact(3))
        {
            (*r, *g, *b) = (pixel[0], pixel[1], pixel[2]);
        }
        let flags = if test.wide {
            hue_chunk(&r, &g, &b, test, |a, b| if a > b { a } else { b })
        } else {
            hue_chunk(&r, &g, &b, test, smaller)
        };
        out.copy_from_slice(&flags[..out.len()]);
    }
}

/// As `f32::min`, but without its care for NaN, which has no vector instruction.
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Every condition is a margin that must not be negative; the least of them decides.
#[inline]
fn hue_chunk<T: Sample>(
    r: &[T; CHUNK],
    g: &[T; CHUNK],
    b: &[T; CHUNK],
    test: &HueTest,
    join: impl Fn(f32, f32) -> f32,
) -> [u8; CHUNK] {
    let mut flags = [0; CHUNK];
    for i in 0..CHUNK {
        let (r, g, b): (f32, f32, f32) = (r[i].into(), g[i].into(), b[i].into());
        let (x, y) = (r - b, g - b);
        let hue = join(
            test.from[0] * y - test.from[1] * x,
            x * test.to[1] - y * test.to[0],
        );
        let larger = if r > g { r } else { g };
        let max = if larger > b { larger } else { b };
        let chroma = max - smaller(smaller(r, g), b);
        // Samples are whole numbers: half a step keeps greys, which have no hue, out of every window.
        let coloured = smaller(chroma - test.min_saturation * max, chroma - 0.5);
        let margin = smaller(smaller(hue, coloured), max - test.min_value);
        flags[i] = if margin >= 0.0 { 255 } else { 0 };
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::super::{Hsv, HueSource};
    use super::*;

    /// The division-free test against the definition, over a grid of colours and windows.
    #[test]
    fn binarise_agrees_with_hsv() {
        let mut colours = Vec::new();
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(15) {
                for b in (0..=255).step_by(15) {
                    colours.extend([r as u8, g as u8, b as u8]);
                }
            }
        }
        let count = colours.len() / 3;
        let image = Image::new(count as u32, 1, 3, Samples::U8(colours.clone())).unwrap();
        for (from_deg, to_deg) in [(10.3, 40.7), (330.1, 20.2), (100.4, 300.6), (350.5, 340.3)] {
            let window = HueWindow {
                from_deg,
                to_deg,
                min_saturation: 0.2003,
                min_value: 0.1,
            };
            let rule = Rule::Hue {
                window,
                source: HueSource::Given,
            };
            let mask = binarise(&image, &Roi::whole(&image), &rule);
            let mut inside = 0;
            for (pixel, found) in colours.chunks_exact(3).zip(&mask) {
                let hsv = Hsv::of([0, 1, 2].map(|c| f32::from(pixel[c]) / 255.0));
                let width = (to_deg - from_deg).rem_euclid(360.0);
                let expected = (f64::from(hsv.hue_deg) - from_deg).rem_euclid(360.0) <= width
                    && f64::from(hsv.saturation) >= window.min_saturation
                    && hsv.saturation > 0.0
                    && f64::from(hsv.value) >= window.min_value;
                assert_eq!(*found == 255, expected, "{pixel:?} {from_deg}");
                inside += usize::from(expected);
            }
            assert!(inside > 100 && inside < count - 100, "{inside} of {count}");
        }
    }
}
