//! How noisy the light is, by how bright it is.

use super::bands::{Block, Cut};
use super::fit::HUBER;

/// Less noise than this is not believed: about a third of the rounding of eight bits.
const FLOOR: f64 = 3e-4;
/// Levels of light whose noise is measured apart, and samples of each at least.
const LEVELS: usize = 8;
const LEAST_SAMPLES: usize = 100;
/// No lens spreads light just as a Gaussian: pixels of an edge are uncertain as if each lay off by so much, px.
const LENS_PX: f64 = 0.03;
/// Nearer to the limb than this, px, light changes by more than noise.
const EDGE_PX: f64 = 1.5;

/// Weighs the pixels of each limb of each eye by the noise of their light. What second differences cannot follow is noise, and how
/// bright a pixel is meant to be is the mean of its block: weights that follow single pixels, or the fit, would pull at it.
pub(crate) fn weigh(blocks: &mut [Block]) {
    for eye in 0..2 {
        for side in 0..2 {
            let cuts = || {
                let of_eye = blocks.iter().filter(|block| block.eye == eye);
                let rows = of_eye.flat_map(|block| &block.rows);
                rows.filter_map(|row| row.cuts[side].as_ref())
            };
            let curve = curve(cuts());
            for block in blocks.iter_mut().filter(|block| block.eye == eye) {
                let profile = Profile::of(block, side);
                let cuts = block.rows.iter_mut();
                for cut in cuts.filter_map(|row| row.cuts[side].as_mut()) {
                    let first_px = cut.first_px;
                    let places = (0..cut.values.len()).map(|k| first_px + k as f64);
                    let of_place = |place_px: f64| {
                        let unsharp = LENS_PX * profile.steepest(place_px);
                        1.0 / (variance(&curve, profile.at(place_px)) + unsharp * unsharp)
                    };
                    cut.weights = places.map(of_place).collect();
                    cut.without = cost_without(cut);
                }
            }
        }
    }
}

/// What a cut's pixels cost that lie on a line.
fn cost_without(cut: &Cut) -> f64 {
    let places = (0..cut.values.len()).map(|k| cut.first_px + k as f64);
    let pixels = || places.clone().zip(&cut.values).zip(&cut.weights);
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        pixels()
            .map(|((x, value), weight)| weight * of(x, *value))
            .sum()
    };
    let (w, wx, wxx) = (sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|x, _| x * x));
    let (wv, wxv) = (sum(&|_, v| v), sum(&|x, v| x * v));
    let slope = (w * wxv - wx * wv) / (w * wxx - wx * wx);
    let mean = (wv - slope * wx) / w;
    let costs = pixels().map(|((x, value), weight)| {
        let off = (value - mean - slope * x).abs() * weight.sqrt();
        if off <= HUBER {
            0.5 * off * off
        } else {
            HUBER * (off - 0.5 * HUBER)
        }
    });
    costs.sum()
}

/// Typical variance of the noise of cuts.
pub(crate) fn typical<'a>(cuts: impl Iterator<Item = &'a Cut>) -> f64 {
    let mut samples = samples(cuts);
    spread(&mut samples)
}

/// Level and second difference.
fn samples<'a>(cuts: impl Iterator<Item = &'a Cut>) -> Vec<(f64, f64)> {
    let mut found = Vec::new();
    for cut in cuts {
        for (k, window) in cut.values.windows(3).enumerate() {
            let from_px = cut.first_px + k as f64;
            if from_px > EDGE_PX || from_px + 2.0 < -EDGE_PX {
                let second = window[0] - 2.0 * window[1] + window[2];
                found.push((window.iter().sum::<f64>() / 3.0, second.abs()));
            }
        }
    }
    found
}

/// Of 1, −2, 1 the variance is six times a pixel's.
fn spread(samples: &mut [(f64, f64)]) -> f64 {
    if samples.is_empty() {
        return FLOOR * FLOOR;
    }
    let middle = samples.len() / 2;
    let (_, median, _) = samples.select_nth_unstable_by(middle, |a, b| a.1.total_cmp(&b.1));
    let sigma = (1.4826 * median.1 / 6.0_f64.sqrt()).max(FLOOR);
    sigma * sigma
}

/// Levels and their variances, by growing levels.
fn curve<'a>(cuts: impl Iterator<Item = &'a Cut>) -> Vec<(f64, f64)> {
    let mut samples = samples(cuts);
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let size = samples.len().div_ceil(LEVELS).max(LEAST_SAMPLES);
    let levels = samples.chunks_mut(size).map(|chunk| {
        let level = chunk.iter().map(|sample| sample.0).sum::<f64>() / chunk.len() as f64;
        (level, spread(chunk))
    });
    levels.collect()
}

fn variance(curve: &[(f64, f64)], level: f64) -> f64 {
    let next = curve.partition_point(|node| node.0 < level);
    match (
        next.checked_sub(1).and_then(|k| curve.get(k)),
        curve.get(next),
    ) {
        (Some(before), Some(after)) => {
            let share = (level - before.0) / (after.0 - before.0);
            before.1 + share * (after.1 - before.1)
        }
        (Some(only), None) | (None, Some(only)) => only.1,
        (None, None) => FLOOR * FLOOR,
    }
}

/// The mean light of a block by the distance to the cuts' middles.
struct Profile {
    first_px: i32,
    means: Vec<f64>,
}

impl Profile {
    fn of(block: &Block, side: usize) -> Self {
        let cuts = || block.rows.iter().filter_map(|row| row.cuts[side].as_ref());
        let first = cuts().map(|cut| cut.first_px).fold(f64::INFINITY, f64::min);
        let last = cuts()
            .map(|cut| cut.first_px + cut.values.len() as f64)
            .fold(f64::NEG_INFINITY, f64::max);
        if !(last > first) {
            return Self {
                first_px: 0,
                means: vec![0.0],
            };
        }
        let first_px = first.floor() as i32;
        let length = (last.ceil() as i32 - first_px).unsigned_abs() as usize + 1;
        let mut sums = vec![(0.0, 0.0); length];
        for cut in cuts() {
            for (k, value) in cut.values.iter().enumerate() {
                let place = cut.first_px + k as f64 - f64::from(first_px);
                let (node, share) = (place as usize, place.fract());
                for (at, weight) in [(node, 1.0 - share), (node + 1, share)] {
                    if let Some(sum) = sums.get_mut(at) {
                        sum.0 += weight * value;
                        sum.1 += weight;
                    }
                }
            }
        }
        let mut before = 0.0;
        let means = sums.into_iter().map(|(sum, weight)| {
            if weight > 0.0 {
                before = sum / weight;
            }
            before
        });
        Self {
            first_px,
            means: means.collect(),
        }
    }

    /// The steepest slope within a pixel and a half, 1/px.
    fn steepest(&self, place_px: f64) -> f64 {
        let slope = |off_px: f64| {
            let [before, after] = [-0.5, 0.5].map(|half| self.at(place_px + off_px + half));
            (after - before).abs()
        };
        [-1.0, -0.5, 0.0, 0.5, 1.0]
            .map(slope)
            .into_iter()
            .fold(0.0, f64::max)
    }

    fn at(&self, place_px: f64) -> f64 {
        let place = (place_px - f64::from(self.first_px)).max(0.0);
        let node = (place as usize).min(self.means.len() - 1);
        let next = (node + 1).min(self.means.len() - 1);
        let share = (place - node as f64).min(1.0);
        self.means[node] + share * (self.means[next] - self.means[node])
    }
}
