//! Whether the side of a rod is its limb or only where it fades into its own shadow.
//!
//! A rod lit from one side goes black on the other before its limb is reached; the mask is cut there as straight as at a limb.
//! What tells them apart is how the light rises from the edge inwards, `I ∝ x^p` in linear light: p ≈ 0 where the lamp is on
//! that side, ½ where it is behind the camera (the cosine of a cylinder), 1 at the shadow's edge.

use std::sync::LazyLock;

use rodsight_geometry::{Camera, Image, Pixel, Samples, radians};

use super::{RefinedLine, Strip};

/// The profile is taken up to so far inside the edge, px.
const REACH_PX: f64 = 10.0;
/// Nearer than this to the edge the blur of the lens and of the pixels makes the profile.
const BLUR_PX: f64 = 1.5;
/// Background is looked at so far outside the edge, px.
const OUTSIDE_PX: [f64; 2] = [3.0, 6.0];
/// Stretches into which a limb is cut; the median of their exponents counts.
const STRETCHES: usize = 7;
/// Positions along a stretch, at most.
const POSITIONS: usize = 24;

/// From this exponent on a side may be no limb.
const SOFT: f64 = 0.6;
/// From this exponent on it is said so.
const FADED: f64 = 0.75;

/// No matt rod has an exponent above 1; blur and noise leave some room.
const STRANGE: f64 = 1.5;

/// How the light lies on the two sides of a rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shading {
    /// Exponents; `None` where the rod is too thin or too faint to say.
    pub softness: [Option<f64>; 2],
    /// How much of the rod may lie unseen beyond each side, px; 0 for a limb.
    pub unseen_px: [f64; 2],
}

impl Shading {
    pub(crate) fn of(image: &Image, camera: &Camera, strip: &Strip) -> Self {
        let softness = softness(image, camera, strip);
        let unseen_px = [0, 1].map(|k| match softness[k] {
            Some(p) if p > SOFT => unseen_px(image, camera, strip, k),
            _ => 0.0,
        });
        Self {
            softness,
            unseen_px,
        }
    }

    /// Whether the light rises as it does on no rod: something else lies along that side.
    pub(crate) fn is_strange(&self) -> bool {
        self.softness.iter().flatten().any(|p| *p > STRANGE)
    }

    pub(crate) fn fades(&self) -> bool {
        self.softness.iter().flatten().any(|p| *p > FADED)
    }
}

/// What a matt cylinder lit from the angle φ beside the line of sight hides: its light falls as cos(α − φ) and ends
/// cos φ of a radius from the axis on the other side. φ is fitted, in whole degrees, to the light across the strip.
fn unseen_px(image: &Image, camera: &Camera, strip: &Strip, side: usize) -> f64 {
    const ACROSS: u32 = 24;
    let limb = &strip.limbs[side];
    let inward = limb.inward();
    let count = ((2.0 * strip.half_length_px) as usize).clamp(1, 64);
    let total = |x: f64| {
        let (mut sum, mut n) = (0.0, 0);
        for k in 0..count {
            let t = strip.half_length_px * (2.0 * (k as f64 + 0.5) / count as f64 - 1.0);
            let middle = strip.middle_px + strip.direction * t;
            let foot = middle - limb.line.normal() * limb.line.distance_px(&middle);
            if let Some(light) = light_at(image, camera, &(foot + inward * x)) {
                sum += light.iter().sum::<f64>();
                n += 1;
            }
        }
        (n > 0).then(|| sum / f64::from(n))
    };
    let outside = total(-OUTSIDE_PX[1]).unwrap_or(0.0);
    let width = strip.width_px;
    // Distances from the limb on the lamp's side, and the light there.
    let across: Vec<(f64, f64)> = (0..ACROSS)
        .map(|j| width * (f64::from(j) + 0.5) / f64::from(ACROSS))
        .filter(|x| x.min(width - x) > BLUR_PX)
        .filter_map(|x| Some((width - x, total(x)? - outside)))
        .collect();
    let misfit = |degrees: u32| {
        let angle = radians(f64::from(degrees));
        let radius = width / (1.0 + libm::cos(angle));
        let model = |x: f64| libm::cos(libm::asin((x / radius - 1.0).clamp(-1.0, 1.0)) + angle);
        let (mut mm, mut ml, mut ll) = (f64::MIN_POSITIVE, 0.0, 0.0);
        for (x, light) in &across {
            let m = model(*x).max(0.0);
            (mm, ml, ll) = (mm + m * m, ml + m * light, ll + light * light);
        }
        ll - ml * ml / mm
    };
    let best = (0..80).min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)));
    let cos = libm::cos(radians(f64::from(best.unwrap_or(0))));
    width * (1.0 - cos) / (1.0 + cos)
}

/// Exponents of the two sides of a strip.
fn softness(image: &Image, camera: &Camera, strip: &Strip) -> [Option<f64>; 2] {
    let [a, b] = &strip.limbs;
    [a, b].map(|limb| exponent(image, camera, strip, limb))
}

fn exponent(image: &Image, camera: &Camera, strip: &Strip, limb: &RefinedLine) -> Option<f64> {
    let reach = REACH_PX.min(0.4 * strip.width_px);
    let mut exponents: Vec<f64> = (0..STRETCHES)
        .filter_map(|k| {
            let length = 2.0 * strip.half_length_px / STRETCHES as f64;
            let from = -strip.half_length_px + length * k as f64;
            exponent_of_stretch(image, camera, strip, limb, [from, from + length], reach)
        })
        .collect();
    if 2 * exponents.len() < STRETCHES {
        return None;
    }
    exponents.sort_by(f64::total_cmp);
    Some(exponents[exponents.len() / 2])
}

fn exponent_of_stretch(
    image: &Image,
    camera: &Camera,
    strip: &Strip,
    limb: &RefinedLine,
    [from, to]: [f64; 2],
    reach_px: f64,
) -> Option<f64> {
    let inward = limb.inward();
    let count = ((to - from) as usize).clamp(1, POSITIONS);
    let mean = |x: f64| {
        let (mut sum, mut n) = ([0.0; 3], 0.0);
        for k in 0..count {
            let t = from + (to - from) * (k as f64 + 0.5) / count as f64;
            let middle = strip.middle_px + strip.direction * t;
            let foot = middle - limb.line.normal() * limb.line.distance_px(&middle);
            if let Some(light) = light_at(image, camera, &(foot + inward * x)) {
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += light;
                }
                n += 1.0;
            }
        }
        (2.0 * n >= count as f64).then(|| sum.map(|s| s / n))
    };
    let outside = {
        let [near, far] = OUTSIDE_PX.map(|x| mean(-x));
        let (near, far) = (near?, far?);
        [0, 1, 2].map(|c| 0.5 * (near[c] + far[c]))
    };
    let over = |light: [f64; 3]| [0, 1, 2].map(|c| light[c] - outside[c]);
    let axis = over(mean(reach_px)?);
    let mut logs = Vec::new();
    let mut x = BLUR_PX;
    while x <= reach_px {
        let light = over(mean(x)?);
        let along: f64 = light.iter().zip(&axis).map(|(a, b)| a * b).sum();
        if along > 0.0 {
            logs.push((libm::log(x), libm::log(along)));
        }
        x += 1.0;
    }
    (logs.len() >= 3).then(|| slope(&logs)).flatten()
}

fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xx, mut xy) = (0.0, 0.0);
    for (a, b) in points {
        xx += (a - x) * (a - x);
        xy += (a - x) * (b - y);
    }
    (xx > 0.0).then_some(xy / xx)
}

/// Linear light of the pixel at a point of the undistorted image, of three channels; a grey image has three alike.
fn light_at(image: &Image, camera: &Camera, point: &Pixel) -> Option<[f64; 3]> {
    let seen = if camera.is_pinhole() {
        *point
    } else {
        camera.project(&camera.without_distortion().ray(point)?)?
    };
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    // Between the centres of four pixels.
    let (u, v) = (seen.x - 0.5, seen.y - 0.5);
    let (x, y) = (libm::floor(u), libm::floor(v));
    if !(x >= 0.0 && y >= 0.0 && x + 1.0 < width as f64 && y + 1.0 < height as f64) {
        return None;
    }
    let (fx, fy) = (u - x, v - y);
    let channels = image.channels() as usize;
    let sample = |dx: usize, dy: usize, c: usize| {
        let at = ((y as usize + dy) * width + x as usize + dx) * channels + c.min(channels - 1);
        match image.samples() {
            Samples::U8(samples) => DECODED[usize::from(samples[at])],
            Samples::U16(samples) => decode(f64::from(samples[at]) / 65535.0),
        }
    };
    Some([0, 1, 2].map(|c| {
        (1.0 - fy) * ((1.0 - fx) * sample(0, 0, c) + fx * sample(1, 0, c))
            + fy * ((1.0 - fx) * sample(0, 1, c) + fx * sample(1, 1, c))
    }))
}

/// Linear light of every 8-bit value.
static DECODED: LazyLock<[f64; 256]> =
    LazyLock::new(|| core::array::from_fn(|value| decode(value as f64 / 255.0)));

/// sRGB to linear light (IEC 61966-2-1).
fn decode(value: f64) -> f64 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::pow((value + 0.055) / 1.055, 2.4)
    }
}
