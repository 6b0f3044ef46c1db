//! Rows that share their shading, taken together: what all of them say at each distance from a limb.
//!
//! Within a block a pixel's light depends on nothing but its distance from the limb. Means of pixels that are equally far say all that
//! the pixels themselves do, ten times fewer of them; and a row that does not look as its neighbours do is seen before any model.

use super::bands::{INSIDE_PX, Ray, Rows, Stretch};
use super::noise::Noise;

/// Pixels of a block that are so far from each other across a limb are taken together, px.
const BIN_PX: f64 = 0.5;
/// Fewer places do not show a limb.
const LEAST_SAMPLES: usize = 4;
/// Residuals beyond so many standard deviations of a pixel weigh less.
const HUBER: f64 = 3.0;
/// Rows whose squares are this many times the usual ones weigh less.
const ROW_LIMIT: f64 = 2.0;
/// No lens spreads light just as a Gaussian: pixels of an edge are uncertain as if each lay off by so much, px.
const LENS_PX: f64 = 0.03;
/// Within so many bins light is as steep as the steepest of them.
const STEEP_BINS: usize = 2;

/// Pixels that are equally far from a limb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// From the limb, px.
    pub(crate) place_px: f64,
    pub(crate) value: f64,
    /// One over the variance of a pixel.
    pub(crate) weight: f64,
    /// How many there are.
    pub(crate) pixels: f64,
}

impl Sample {
    /// What a residual costs, its square, and its weight.
    pub(crate) fn cost(&self, residual: f64) -> (f64, f64, f64) {
        let weight = self.pixels * self.weight;
        let (cost, share) = robust(residual * residual * self.weight);
        (
            self.pixels * cost,
            residual * residual * weight,
            weight * share,
        )
    }
}

/// Huber's loss of a square, and the share of a residual's weight that is left of it.
fn robust(square: f64) -> (f64, f64) {
    if square <= HUBER * HUBER {
        (0.5 * square, 1.0)
    } else {
        let off = square.sqrt();
        (HUBER * (off - 0.5 * HUBER), HUBER / off)
    }
}

/// How much what is so many times as far off as usual still weighs.
pub(crate) fn trust(times: f64) -> f64 {
    let share = (ROW_LIMIT / times).min(1.0);
    share * share
}

/// What a block shows around one limb.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    pub(crate) samples: Vec<Sample>,
    pub(crate) pixels: f64,
    /// Of the pixels about their means: χ², and plain weighted squares.
    pub(crate) chi2: f64,
    pub(crate) squares: f64,
    /// What the samples cost as a slope of light without a limb.
    pub(crate) without: f64,
    pub(crate) weight: f64,
    /// How many rows look as their neighbours do, and how many there are.
    pub(crate) rows_kept: usize,
    pub(crate) rows: usize,
    /// See [`Rows`].
    pub(crate) from_centre_px: [f64; 2],
    pub(crate) by_columns: bool,
    pub(crate) rays: [Ray; 5],
}

/// What neighbouring rows of an eye show around both limbs.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) eye: usize,
    /// Place along the limbs, from −1 to 1.
    pub(crate) along: f64,
    /// Half of the length from −1 to 1 along the limbs, px.
    pub(crate) half_px: f64,
    /// Around the limbs plus and minus.
    pub(crate) cuts: [Option<Cut>; 2],
    /// By how much light rises inside the limbs plus and minus.
    pub(crate) rise: [f64; 2],
}

/// The blocks of an eye.
pub(crate) fn blocks(eye: usize, stretches: &[Stretch]) -> Vec<Block> {
    let mut found: Vec<Block> = stretches
        .iter()
        .map(|stretch| Block {
            eye,
            along: stretch.along,
            half_px: stretch.half_px,
            cuts: [None, None],
            rise: [0, 1].map(|side| stretch.limbs[side].as_ref().map_or(0.0, rise)),
        })
        .collect();
    // Noise is more of a nuisance than what smoothing hides.
    let rises: Vec<[f64; 2]> = found.iter().map(|block| block.rise).collect();
    for (k, block) in found.iter_mut().enumerate() {
        let near = &rises[k.saturating_sub(1)..(k + 2).min(rises.len())];
        block.rise =
            [0, 1].map(|side| near.iter().map(|rise| rise[side]).sum::<f64>() / near.len() as f64);
    }
    for side in 0..2 {
        let all = || {
            stretches
                .iter()
                .filter_map(|stretch| stretch.limbs[side].as_ref())
        };
        let noise = Noise::of(all());
        let drafts: Vec<Draft<'_>> = all().map(|rows| Draft::new(rows, &noise)).collect();
        let mut squares: Vec<f64> = drafts
            .iter()
            .flat_map(|draft| &draft.squares)
            .copied()
            .collect();
        let usual = usual(&mut squares);
        let with_limb = found
            .iter_mut()
            .zip(stretches)
            .filter(|(_, stretch)| stretch.limbs[side].is_some());
        for ((block, _), draft) in with_limb.zip(&drafts) {
            block.cuts[side] = draft.pooled(usual);
        }
    }
    found.retain(|block| block.cuts.iter().any(Option::is_some));
    found
}

/// Squares that are usual, where their mean should be one.
pub(crate) fn usual(squares: &mut [f64]) -> f64 {
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return 1.0;
    }
    squares
        .select_nth_unstable_by(middle, f64::total_cmp)
        .1
        .max(1.0)
}

fn rise(rows: &Rows) -> f64 {
    let rise = rows.mean(3.0, INSIDE_PX).zip(rows.mean(0.7, 1.7));
    rise.map_or(0.0, |(deep, shallow)| (deep - shallow).max(0.0))
}

/// Light at one distance.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    place_px: f64,
    median: f64,
    slope_per_px: f64,
    weight: f64,
}

impl Bin {
    /// How far off a pixel is.
    fn off(&self, place_px: f64, value: f64) -> f64 {
        value - self.median - self.slope_per_px * (place_px - self.place_px)
    }
}

/// Rows and what is usual among them.
struct Draft<'a> {
    rows: &'a Rows,
    first_px: f64,
    bins: Vec<Option<Bin>>,
    /// Mean of each row.
    squares: Vec<f64>,
}

impl<'a> Draft<'a> {
    fn new(rows: &'a Rows, noise: &Noise) -> Self {
        let first_px = rows.iter().map(|row| row.0).fold(f64::INFINITY, f64::min);
        let mut draft = Self {
            rows,
            first_px,
            bins: Vec::new(),
            squares: Vec::new(),
        };
        let mut sorted: Vec<(usize, f64, f64)> = rows
            .pixels()
            .map(|(place_px, value)| (draft.bin(place_px), place_px, value))
            .collect();
        sorted.sort_unstable_by(|a, b| (a.0.cmp(&b.0)).then(a.2.total_cmp(&b.2)));
        draft.bins = vec![None; sorted.last().map_or(0, |last| last.0 + 1)];
        for all in sorted.chunk_by(|a, b| a.0 == b.0) {
            let count = all.len();
            draft.bins[all[0].0] = Some(Bin {
                place_px: all.iter().map(|pixel| pixel.1).sum::<f64>() / count as f64,
                median: 0.5 * (all[(count - 1) / 2].2 + all[count / 2].2),
                ..Bin::default()
            });
        }
        draft.weigh(noise);
        draft.squares = rows.iter().map(|row| draft.mean_square(row)).collect();
        draft
    }

    fn bin(&self, place_px: f64) -> usize {
        ((place_px - self.first_px) / BIN_PX) as usize
    }

    /// Weighs pixels by how bright and how steep the light is there among all rows: weights that follow single pixels would pull.
    fn weigh(&mut self, noise: &Noise) {
        let mut seen: Vec<&mut Bin> = self.bins.iter_mut().flatten().collect();
        let nodes: Vec<(f64, f64)> = seen.iter().map(|bin| (bin.place_px, bin.median)).collect();
        let near = |k: usize, reach: usize| {
            &nodes[k.saturating_sub(reach)..(k + reach + 1).min(nodes.len())]
        };
        for (k, bin) in seen.iter_mut().enumerate() {
            if let [(before_px, before), .., (after_px, after)] = near(k, 1) {
                bin.slope_per_px = (after - before) / (after_px - before_px);
            }
        }
        let slopes: Vec<f64> = seen.iter().map(|bin| bin.slope_per_px.abs()).collect();
        for (k, bin) in seen.into_iter().enumerate() {
            let levels = near(k, 1);
            let level = levels.iter().map(|node| node.1).sum::<f64>() / levels.len() as f64;
            let steepest = slopes
                [k.saturating_sub(STEEP_BINS)..(k + STEEP_BINS + 1).min(slopes.len())]
                .iter()
                .fold(0.0, |a: f64, b| a.max(*b));
            let unsharp = LENS_PX * steepest;
            bin.weight = 1.0 / (noise.variance(level) + unsharp * unsharp);
        }
    }

    fn mean_square(&self, (first_px, values): (f64, &[f64])) -> f64 {
        let squares = values.iter().enumerate().filter_map(|(k, value)| {
            let place_px = first_px + k as f64;
            let bin = self.bins[self.bin(place_px)]?;
            let off = bin.off(place_px, *value);
            Some(off * off * bin.weight)
        });
        squares.sum::<f64>() / values.len() as f64
    }

    /// Means over the rows that look as usual.
    fn pooled(&self, usual: f64) -> Option<Cut> {
        #[derive(Clone, Copy, Default)]
        struct Means {
            pixels: f64,
            places: f64,
            values: f64,
        }
        let mut means = vec![Means::default(); self.bins.len()];
        let (mut chi2, mut squares, mut rows_kept) = (0.0, 0.0, 0);
        for ((first_px, values), square) in self.rows.iter().zip(&self.squares) {
            let trust = trust(square / usual);
            rows_kept += usize::from(trust > 0.5);
            for (k, value) in values.iter().enumerate() {
                let place_px = first_px + k as f64;
                let at = self.bin(place_px);
                let Some(bin) = self.bins[at] else {
                    continue;
                };
                let off = bin.off(place_px, *value);
                let square = off * off * bin.weight;
                let (_, share) = robust(square);
                let pixels = trust * share;
                chi2 += pixels * square;
                squares += trust * square;
                let mean = &mut means[at];
                mean.pixels += pixels;
                mean.places += pixels * place_px;
                mean.values += pixels * value;
            }
        }
        let samples: Vec<Sample> = means
            .iter()
            .zip(&self.bins)
            .filter_map(|(mean, bin)| {
                Some(Sample {
                    place_px: mean.places / mean.pixels,
                    value: mean.values / mean.pixels,
                    weight: bin.as_ref()?.weight,
                    pixels: mean.pixels,
                })
            })
            .collect();
        (samples.len() >= LEAST_SAMPLES).then(|| Cut {
            pixels: samples.iter().map(|sample| sample.pixels).sum(),
            chi2,
            squares,
            without: cost_without(&samples),
            samples,
            weight: 1.0,
            rows_kept,
            rows: self.squares.len(),
            from_centre_px: self.rows.from_centre_px,
            by_columns: self.rows.by_columns,
            rays: self.rows.rays,
        })
    }
}

/// What samples cost that lie on a line.
fn cost_without(samples: &[Sample]) -> f64 {
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        let terms = samples.iter();
        terms
            .map(|s| s.pixels * s.weight * of(s.place_px, s.value))
            .sum()
    };
    let (w, wx, wxx) = (sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|x, _| x * x));
    let (wv, wxv) = (sum(&|_, v| v), sum(&|x, v| x * v));
    let slope = (w * wxv - wx * wv) / (w * wxx - wx * wx);
    let mean = (wv - slope * wx) / w;
    let costs = samples
        .iter()
        .map(|s| s.cost(s.value - mean - slope * s.place_px).0);
    costs.sum()
}
