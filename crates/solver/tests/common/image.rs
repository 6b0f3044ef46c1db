//! Light to images: anti-aliasing, balls, lens, noise, rounding.

use core::ops::Range;

use rodsight_geometry::{Eye, Image, Samples};

use super::lens::Pixels;
use super::{Random, Scene, Texture};

impl Scene {
    pub fn image(&self, eye: Eye) -> Image {
        let i = *self.rig.eye(eye).camera.intrinsics();
        let (width, height) = (i.width_px as usize, i.height_px as usize);
        let [columns, rows] = match self.only[eye as usize] {
            None => [0..width, 0..height],
            Some(roi) => [
                roi.x_px as usize..(roi.x_px + roi.width_px) as usize,
                roi.y_px as usize..(roi.y_px + roi.height_px) as usize,
            ],
        };
        let mut light = vec![self.background; width * height];
        if self.background_slope != [0.0; 2] {
            for (at, colour) in light.iter_mut().enumerate() {
                let x = (at % width) as f64 / width as f64 - 0.5;
                let y = (at / width) as f64 / height as f64 - 0.5;
                let [a, b] = self.background_slope;
                *colour = colour.map(|v| v * (1.0 + a * x + b * y).max(0.0));
            }
        }
        // The corners of all pixels first; only pixels whose corners differ are supersampled.
        let across = columns.len() + 1;
        let corners: Vec<Option<usize>> = (rows.start..=rows.end)
            .flat_map(|y| (columns.start..=columns.end).map(move |x| (x, y)))
            .map(|(x, y)| self.hit(eye, x as f64, y as f64).map(|hit| hit.rod))
            .collect();
        let behind = light.clone();
        let mut is_edge = vec![false; width * height];
        let mut range_m = vec![f64::INFINITY; width * height];
        for y in rows.clone() {
            for x in columns.clone() {
                let at = |dx: usize, dy: usize| {
                    corners[(y + dy - rows.start) * across + x + dx - columns.start]
                };
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                let place = y * width + x;
                let is_whole = four.iter().all(|c| *c == four[0]);
                // Bands end within a pixel.
                let is_plain = !matches!(self.texture, Texture::Bands { .. });
                if is_whole && (is_plain || four[0].is_none()) {
                    if let Some(hit) =
                        four[0].and_then(|_| self.hit(eye, x as f64 + 0.5, y as f64 + 0.5))
                    {
                        light[place] = hit.colour;
                        range_m[place] = hit.range_m;
                    }
                    continue;
                }
                is_edge[place] = !is_whole;
                let n = if is_whole { 3 } else { self.samples };
                let step = 1.0 / f64::from(n);
                let mut sum = [0.0; 3];
                for k in 0..n * n {
                    let (a, b) = (f64::from(k % n), f64::from(k / n));
                    let (u, v) = (x as f64 + (a + 0.5) * step, y as f64 + (b + 0.5) * step);
                    let colour = match self.hit(eye, u, v) {
                        Some(hit) => {
                            range_m[place] = range_m[place].min(hit.range_m);
                            hit.colour
                        }
                        None => behind[place],
                    };
                    for (sum, value) in sum.iter_mut().zip(colour) {
                        *sum += value * step * step;
                    }
                }
                light[place] = sum;
            }
        }
        let is_ball = self.add_balls(eye, &mut light, &range_m, width);
        if self.blur_px > 0.0 {
            blur(&mut light, width, [&columns, &rows], self.blur_px);
            let pixels = Pixels {
                width,
                columns: &columns,
                rows: &rows,
                behind: &behind,
                is_edge: &is_edge,
                is_ball: &is_ball,
            };
            pixels.blur_edges(self, eye, &mut light);
        }
        let mut random = Random::new(self.seed ^ if eye == Eye::Left { 0 } else { 0x5555_1234 });
        let most = if self.bits == 8 { 255.0 } else { 65535.0 };
        let mut values: Vec<u16> = Vec::with_capacity(light.len() * self.channels as usize);
        for (at, light) in light.into_iter().enumerate() {
            if !(columns.contains(&(at % width)) && rows.contains(&(at / width))) {
                values.extend(core::iter::repeat_n(0, self.channels.into()));
                continue;
            }
            for value in &self.stored(light)[..self.channels as usize] {
                let noise = if self.noise_sigma > 0.0 {
                    self.noise_sigma * random.normal()
                } else {
                    0.0
                };
                values.push(((value + noise).clamp(0.0, 1.0) * most + 0.5) as u16);
            }
        }
        let samples = if self.bits == 8 {
            Samples::U8(values.iter().map(|v| *v as u8).collect())
        } else {
            Samples::U16(values)
        };
        Image::new(i.width_px, i.height_px, self.channels, samples)
            .expect("as many samples as pixels")
    }

    /// Balls before what is farther, their borders a pixel wide; where they are.
    fn add_balls(
        &self,
        eye: Eye,
        light: &mut [[f64; 3]],
        range_m: &[f64],
        width: usize,
    ) -> Vec<bool> {
        let mut is_ball = vec![false; light.len()];
        let height = light.len() / width;
        for disc in self.discs(eye) {
            let at = disc.centre_px;
            let reach = disc.radius_px + 1.0;
            let clip = |v: f64, most: usize| v.clamp(0.0, most as f64) as usize;
            for y in clip((at.y - reach).floor(), height)..clip((at.y + reach).ceil(), height) {
                for x in clip((at.x - reach).floor(), width)..clip((at.x + reach).ceil(), width) {
                    let off = libm::hypot(x as f64 + 0.5 - at.x, y as f64 + 0.5 - at.y);
                    let share = (disc.radius_px - off + 0.5).clamp(0.0, 1.0);
                    let place = y * width + x;
                    if share > 0.0 && range_m[place] > disc.range_m {
                        is_ball[place] = true;
                        for (value, ball) in light[place].iter_mut().zip(disc.colour) {
                            *value += share * (ball - *value);
                        }
                    }
                }
            }
        }
        is_ball
    }
}

/// Blurs the pixels of some columns and rows by a Gaussian; what is beyond the image is as at its border.
fn blur(light: &mut [[f64; 3]], width: usize, only: [&Range<usize>; 2], sigma_px: f64) {
    let half = (4.0 * sigma_px).ceil() as usize;
    let mut kernel: Vec<f64> = (0..=2 * half)
        .map(|k| {
            let x = (k as f64 - half as f64) / sigma_px;
            libm::exp(-0.5 * x * x)
        })
        .collect();
    let sum: f64 = kernel.iter().sum();
    for weight in &mut kernel {
        *weight /= sum;
    }
    let height = light.len() / width;
    let [columns, rows] = only;
    // Across first, of all rows that blurring down will ask for.
    let reach = rows.start.saturating_sub(half)..(rows.end + half).min(height);
    let mut across = Vec::with_capacity(reach.len() * columns.len());
    for y in reach.clone() {
        let row = &light[y * width..(y + 1) * width];
        across.extend(
            columns
                .clone()
                .map(|x| weighed(&kernel, x, width, |x| row[x])),
        );
    }
    for y in rows.clone() {
        for (column, x) in columns.clone().enumerate() {
            light[y * width + x] = weighed(&kernel, y, height, |y| {
                across[(y - reach.start) * columns.len() + column]
            });
        }
    }
}

/// The mean of the values around a place, by the weights of a kernel.
fn weighed(
    kernel: &[f64],
    place: usize,
    along: usize,
    value: impl Fn(usize) -> [f64; 3],
) -> [f64; 3] {
    let half = kernel.len() / 2;
    let mut sum = [0.0; 3];
    for (k, weight) in kernel.iter().enumerate() {
        let there = (place + k).saturating_sub(half).min(along - 1);
        for (sum, value) in sum.iter_mut().zip(value(there)) {
            *sum += weight * value;
        }
    }
    sum
}
