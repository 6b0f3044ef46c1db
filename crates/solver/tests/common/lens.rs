//! The blur of a lens around edges, where the pixels of an image are too coarse to blur it by.

use core::ops::Range;

use rodsight_geometry::Eye;

use super::Scene;

/// Softer lenses blur pixels as they blur light.
const SOFT_PX: f64 = 0.8;
/// Samples of a pixel per axis.
const PER_PIXEL: usize = 4;
const SAMPLES: usize = PER_PIXEL * PER_PIXEL;

/// The pixels of an image, row by row.
pub(super) struct Pixels<'a> {
    pub(super) width: usize,
    pub(super) columns: &'a Range<usize>,
    pub(super) rows: &'a Range<usize>,
    /// Of the light behind rods, without balls.
    pub(super) behind: &'a [[f64; 3]],
    /// Pixels within which light jumps.
    pub(super) is_edge: &'a [bool],
    /// Pixels with a ball before them.
    pub(super) is_ball: &'a [bool],
}

impl Pixels<'_> {
    /// Blurs the light that is really there, by a Gaussian and a pixel's square, where rods end.
    pub(super) fn blur_edges(&self, scene: &Scene, eye: Eye, light: &mut [[f64; 3]]) {
        let sigma_px = scene.blur_px;
        if !(sigma_px > 0.0 && sigma_px < SOFT_PX) {
            return;
        }
        let reach = (4.0 * sigma_px + 0.5).ceil() as usize;
        let near = self.around(self.is_edge, reach);
        let balls = self.around(self.is_ball, reach);
        let needed = self.around(&near, reach);
        let width = self.width;
        let mut samples: Vec<[[f64; 3]; SAMPLES]> = Vec::new();
        let mut places = vec![usize::MAX; needed.len()];
        for (place, index) in places
            .iter_mut()
            .enumerate()
            .filter(|(place, _)| needed[*place])
        {
            let (x, y) = ((place % width) as f64, (place / width) as f64);
            *index = samples.len();
            samples.push(core::array::from_fn(|k| {
                let [a, b] =
                    [k % PER_PIXEL, k / PER_PIXEL].map(|k| (k as f64 + 0.5) / PER_PIXEL as f64);
                let hit = scene.hit(eye, x + a, y + b);
                hit.map_or(self.behind[place], |hit| hit.colour)
            }));
        }
        let kernel = kernel(sigma_px, reach);
        let height = light.len() / width;
        for y in self.rows.clone() {
            for x in self.columns.clone() {
                let place = y * width + x;
                let is_inside = x >= reach && x + reach < width && y >= reach && y + reach < height;
                if !near[place] || balls[place] || !is_inside {
                    continue;
                }
                let mut sum = [0.0; 3];
                for (row, down) in kernel.chunks(PER_PIXEL).enumerate() {
                    for (column, across) in kernel.chunks(PER_PIXEL).enumerate() {
                        let there = (y + row - reach) * width + x + column - reach;
                        let colours = &samples[places[there]];
                        for (k, colour) in colours.iter().enumerate() {
                            let weight = down[k / PER_PIXEL] * across[k % PER_PIXEL];
                            for (sum, value) in sum.iter_mut().zip(colour) {
                                *sum += weight * value;
                            }
                        }
                    }
                }
                light[place] = sum;
            }
        }
    }

    /// Pixels that have a marked one within so many rows and columns.
    fn around(&self, marked: &[bool], reach: usize) -> Vec<bool> {
        let (width, height) = (self.width, marked.len() / self.width);
        let mut found = vec![false; marked.len()];
        for place in (0..marked.len()).filter(|place| marked[*place]) {
            let (x, y) = (place % width, place / width);
            let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
            for y in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                found[y * width + columns.start..y * width + columns.end].fill(true);
            }
        }
        found
    }
}

/// Weights of the samples from so many pixels before to as many after: of a Gaussian and a pixel.
fn kernel(sigma_px: f64, reach: usize) -> Vec<f64> {
    let below = |x: f64| libm::erf(x / (sigma_px * core::f64::consts::SQRT_2));
    let mut kernel: Vec<f64> = (0..PER_PIXEL * (2 * reach + 1))
        .map(|k| (k as f64 + 0.5) / PER_PIXEL as f64 - reach as f64 - 0.5)
        .map(|x| below(x + 0.5) - below(x - 0.5))
        .collect();
    let sum: f64 = kernel.iter().sum();
    for weight in &mut kernel {
        *weight /= sum;
    }
    kernel
}
