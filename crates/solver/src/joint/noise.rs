//! How noisy the light is, by how bright it is.

use super::bands::Rows;

/// Less noise than this is not believed: about a third of the rounding of eight bits.
const FLOOR: f64 = 3e-4;
/// Levels of light whose noise is measured apart, and samples of each at least.
const LEVELS: usize = 8;
const LEAST_SAMPLES: usize = 100;
/// So many samples are enough.
const MOST_SAMPLES: usize = 4000;
/// Nearer to the limb than this, px, light changes by more than noise.
const EDGE_PX: f64 = 1.5;

/// Variances of the noise, by growing levels of light. What second differences cannot follow is noise.
#[derive(Clone, Debug)]
pub(crate) struct Noise(Vec<(f64, f64)>);

impl Noise {
    pub(crate) fn of<'a>(rows: impl Iterator<Item = &'a Rows>) -> Self {
        let mut samples = samples(rows);
        samples.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let size = samples.len().div_ceil(LEVELS).max(LEAST_SAMPLES);
        let levels = samples.chunks_mut(size).map(|chunk| {
            let level = chunk.iter().map(|sample| sample.0).sum::<f64>() / chunk.len() as f64;
            (level, variance(chunk))
        });
        Self(levels.collect())
    }

    pub(crate) fn variance(&self, level: f64) -> f64 {
        let next = self.0.partition_point(|node| node.0 < level);
        let before = next.checked_sub(1).and_then(|k| self.0.get(k));
        match (before, self.0.get(next)) {
            (Some(before), Some(after)) => {
                let share = (level - before.0) / (after.0 - before.0);
                before.1 + share * (after.1 - before.1)
            }
            (Some(only), None) | (None, Some(only)) => only.1,
            (None, None) => FLOOR * FLOOR,
        }
    }
}

/// Typical variance of the noise of rows.
pub(crate) fn typical<'a>(rows: impl Iterator<Item = &'a Rows>) -> f64 {
    variance(&mut samples(rows))
}

/// Level and second difference.
fn samples<'a>(rows: impl Iterator<Item = &'a Rows>) -> Vec<(f64, f64)> {
    let all: Vec<(f64, &[f64])> = rows.flat_map(Rows::iter).collect();
    let pixels: usize = all.iter().map(|(_, values)| values.len()).sum();
    let stride = (pixels / MOST_SAMPLES).max(1);
    let mut found = Vec::with_capacity(pixels / stride);
    for (first_px, values) in all.into_iter().step_by(stride) {
        for (k, window) in values.windows(3).enumerate() {
            let from_px = first_px + k as f64;
            if from_px > EDGE_PX || from_px + 2.0 < -EDGE_PX {
                let second = window[0] - 2.0 * window[1] + window[2];
                found.push((window.iter().sum::<f64>() / 3.0, second.abs()));
            }
        }
    }
    found
}

/// Of 1, −2, 1 the variance is six times a pixel's.
fn variance(samples: &mut [(f64, f64)]) -> f64 {
    if samples.is_empty() {
        return FLOOR * FLOOR;
    }
    let middle = samples.len() / 2;
    let (_, median, _) = samples.select_nth_unstable_by(middle, |a, b| a.1.total_cmp(&b.1));
    let sigma = (1.4826 * median.1 / 6.0_f64.sqrt()).max(FLOOR);
    sigma * sigma
}
