//! Sums of an image's gradient along all lines: where the edges of straight things are, without a threshold.
//!
//! Lines come in two families, steeper and flatter than 45°. Of a family's image the gradient across is summed along every digital
//! line (`radon`). What a line collects is in units of the noise: of the same sums all over the image, so that texture counts as
//! noise.

use nalgebra::{Matrix3, Vector3};
use rodsight_geometry::{ImageLine, Pixel};

use super::light::Binned;
use super::radon::{Grid, MARGIN};

/// Noise makes stronger edges than this, in its own standard deviations, hardly ever.
const LEAST_SCORE: f32 = 4.0;

/// Lines are looked at that have this share of the rows.
const LEAST_ROWS: f32 = 0.15;

/// The colours of an edge in units of noise: up to three, whitened.
pub(crate) type Colours = [f32; 3];

/// A straight edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// In the region, px of the image.
    pub(crate) line: ImageLine,
    /// The normal along which the step is counted: the one with a positive component across the family.
    pub(crate) normal: Pixel,
    /// The step along the normal, in units of noise.
    pub(crate) step: Colours,
    pub(crate) score: f32,
    /// The axis of colours, in linear light, along which the step stands out best from the noise; unit length.
    pub(crate) axis: [f64; 3],
    /// The colour of the step along the normal, in linear light; unit length.
    pub(crate) colour: [f64; 3],
}

/// The lines of one family.
struct Family<'a> {
    /// Rows of the family's image are columns of the image.
    is_flat: bool,
    grid: Grid,
    /// A plane a channel.
    sums: Vec<&'a [f32]>,
}

fn transposed(plane: &[f32], width: usize, height: usize) -> Vec<f32> {
    let mut out = vec![0.0; plane.len()];
    // Some columns at a time: what is read and what is written stays near.
    for (block, columns) in out.chunks_mut(BLOCK * height).enumerate() {
        for (row, from) in plane.chunks_exact(width).enumerate() {
            let columns = columns[row..].iter_mut().step_by(height);
            for (to, value) in columns.zip(&from[block * BLOCK..]) {
                *to = *value;
            }
        }
    }
    out
}

/// Columns that are turned at a time.
const BLOCK: usize = 8;

/// I(x + 1) − I(x − 1), nothing at the border and in the margins before and after each row.
fn across(plane: &[f32], width: usize) -> Vec<f32> {
    let wide = width + 2 * MARGIN;
    let mut out = vec![0.0; plane.len() / width * wide];
    for (out, row) in out.chunks_exact_mut(wide).zip(plane.chunks_exact(width)) {
        let pairs = row.iter().zip(&row[2..]);
        for (out, (before, after)) in out[MARGIN + 1..].iter_mut().zip(pairs) {
            *out = after - before;
        }
    }
    out
}

/// The grid of one family.
fn grid(binned: &Binned, is_flat: bool) -> Grid {
    let (width, height) = if is_flat {
        (binned.height, binned.width)
    } else {
        (binned.width, binned.height)
    };
    Grid::new(width, height, LEAST_ROWS * height as f32)
}

/// Appends the sums of one family, a plane a channel.
fn sum(binned: &Binned, is_flat: bool, sums: &mut Vec<f32>) {
    let grid = grid(binned, is_flat);
    for plane in &binned.planes {
        let gradient = if is_flat {
            across(&transposed(plane, binned.width, binned.height), grid.width)
        } else {
            across(plane, grid.width)
        };
        grid.sum(&gradient, sums);
    }
}

impl Family<'_> {
    /// Squares of lengths of colours in units of noise.
    fn scores(&self, whitening: &Whitening) -> Vec<f32> {
        let places = self.grid.places();
        let w = whitening.0.map(|v| v as f32);
        let mut scores = vec![0.0; self.grid.len()];
        for (slope, scores) in scores.chunks_exact_mut(places).enumerate() {
            let counts = self.grid.counts(slope);
            let share = |place| {
                let count: f32 = counts(place);
                if count > 0.0 { 1.0 / count } else { 0.0 }
            };
            let range = self.grid.range(slope);
            let here = slope * places + range.start..slope * places + range.end;
            let scores = range.clone().zip(&mut scores[range]);
            let mut sums = self.sums.iter().map(|sums| &sums[here.clone()]);
            match (sums.next(), sums.next(), sums.next()) {
                (Some(r), Some(g), Some(b)) => {
                    for ((((place, score), r), g), b) in scores.zip(r).zip(g).zip(b) {
                        let first = w.m11 * r;
                        let second = w.m21 * r + w.m22 * g;
                        let third = w.m31 * r + w.m32 * g + w.m33 * b;
                        *score = share(place) * (first * first + second * second + third * third);
                    }
                }
                (Some(grey), ..) => {
                    for ((place, score), grey) in scores.zip(grey) {
                        let colour = w.m11 * grey;
                        *score = share(place) * (colour * colour);
                    }
                }
                _ => {}
            }
        }
        scores
    }

    fn light(&self, line: usize) -> Vector3<f64> {
        let mut sums = Vector3::zeros();
        for (sum, plane) in sums.iter_mut().zip(&self.sums) {
            *sum = f64::from(plane[line]);
        }
        sums
    }

    /// A line's colours in units of noise, but for the root of its rows.
    fn colours(&self, line: usize, whitening: &Whitening) -> Colours {
        (whitening.0 * self.light(line)).map(|v| v as f32).into()
    }

    /// Whether none of its neighbours of the same polarity is larger.
    fn is_peak(&self, line: usize, scores: &[f32], whitening: &Whitening) -> bool {
        let places = self.grid.places().cast_signed();
        let here = scores[line];
        let mine = self.colours(line, whitening);
        NEIGHBOURS.iter().all(|(down, right)| {
            // Beyond the first and last slope there is none, and at the ends of each there are zeros.
            let other = line.wrapping_add_signed(down * places + right);
            let Some(there) = scores.get(other) else {
                return true;
            };
            let is_larger = *there > here || (*there == here && other < line);
            !(is_larger && dot(&mine, &self.colours(other, whitening)) > 0.0)
        })
    }

    /// How far the top is from a peak, in slopes and places: of the parabola through the sums there and beside it.
    fn top(&self, line: usize, whitening: &Whitening) -> [f64; 2] {
        let mine = self.colours(line, whitening);
        let here = f64::from(dot(&mine, &mine));
        [self.grid.places(), 1].map(|step| {
            let at = |other: usize| {
                let is_one = other < self.grid.len();
                is_one.then(|| f64::from(dot(&mine, &self.colours(other, whitening))))
            };
            let (Some(before), Some(after)) = (at(line.wrapping_sub(step)), at(line + step)) else {
                return 0.0;
            };
            let curvature = before - 2.0 * here + after;
            if curvature < 0.0 {
                (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
            } else {
                0.0
            }
        })
    }

    /// The line of a slope and a place between those of the grid, in px of the region.
    fn line(&self, slope: f64, place: f64, factor: usize) -> (ImageLine, Pixel) {
        let (slope, place_px) = (self.grid.slope(slope), self.grid.place_px(place));
        let factor = factor as f64;
        // x = x0 + slope (y − middle).
        let middle_px = 0.5 * self.grid.height as f64 * factor;
        let length = (1.0 + slope * slope).sqrt();
        let (across, along) = (1.0 / length, -slope / length);
        let rho_px = across * place_px * factor + along * middle_px;
        let normal = if self.is_flat {
            Pixel::new(along, across)
        } else {
            Pixel::new(across, along)
        };
        (ImageLine::from_normal(&normal, rho_px), normal)
    }
}

/// What a line is compared with, the nearest first: most lines have a larger one right beside them.
const NEIGHBOURS: [(isize, isize); 24] = [
    (0, -1),
    (0, 1),
    (-1, 0),
    (1, 0),
    (-1, -1),
    (-1, 1),
    (1, -1),
    (1, 1),
    (0, -2),
    (0, 2),
    (-2, 0),
    (2, 0),
    (-1, -2),
    (-1, 2),
    (1, -2),
    (1, 2),
    (-2, -1),
    (-2, 1),
    (2, -1),
    (2, 1),
    (-2, -2),
    (-2, 2),
    (2, -2),
    (2, 2),
];

/// Lines whose sums say how noisy the image is.
const SAMPLED: usize = 4096;

/// Turns sums of channels into independent ones of unit variance.
struct Whitening(Matrix3<f64>);

impl Whitening {
    /// From sums over √length of everything, largest values cut off: edges are few.
    fn of(families: &[Family<'_>; 2], channels: usize, floor: f64) -> Self {
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); channels];
        for family in families {
            let least = 2.0 * LEAST_ROWS * family.grid.height as f32;
            let (slopes, places) = (family.grid.slopes(), family.grid.places());
            let step = (2 * slopes * places / SAMPLED).max(1);
            // Every line of some slopes would be alike, and one place of all: both change.
            let mut place = 0;
            for slope in 0..slopes {
                let counts = family.grid.counts(slope);
                while place < places {
                    let count = counts(place);
                    if count >= least {
                        let at = slope * places + place;
                        for (sums, values) in family.sums.iter().zip(&mut values) {
                            values.push(f64::from(sums[at] / count.sqrt()));
                        }
                    }
                    place += step;
                }
                place -= places;
            }
        }
        let cuts: Vec<f64> = values
            .iter()
            .map(|values| {
                let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
                if sizes.is_empty() {
                    return floor;
                }
                let middle = sizes.len() / 2;
                let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
                (1.4826 * *median).max(floor)
            })
            .collect();
        let count = values[0].len().max(1) as f64;
        let covariance = Matrix3::from_fn(|i, j| {
            if i >= channels || j >= channels {
                return f64::from(u8::from(i == j));
            }
            let cut = |v: f64, cut: f64| v.clamp(-3.0 * cut, 3.0 * cut);
            let sum: f64 = (values[i].iter().zip(&values[j]))
                .map(|(a, b)| cut(*a, cuts[i]) * cut(*b, cuts[j]))
                .sum();
            let least = floor * floor + 1e-4 * cuts[i] * cuts[i];
            sum / count + if i == j { least } else { 0.0 }
        });
        // A covariance whose diagonal was added to has a factor, and the factor an inverse.
        let factor = covariance.cholesky().map(|factor| factor.l());
        let inverse = factor.and_then(Matrix3::try_inverse);
        Self(inverse.unwrap_or_else(|| {
            Matrix3::from_diagonal(&covariance.diagonal().map(|v| 1.0 / v.sqrt()))
        }))
    }

    /// Of a step its best axis: wᵀ I is what its whitened colours have in common with those of I (Fisher's discriminant).
    fn axis(&self, step: &Colours) -> [f64; 3] {
        let axis = self.0.tr_mul(&Vector3::from(step.map(f64::from)));
        axis.normalize().into()
    }
}

pub(crate) fn dot(a: &Colours, b: &Colours) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where a row of at least so large values has its maxima; of equal ones side by side all.
fn maxima(row: &[f32], least: f32, found: &mut Vec<usize>) {
    const TOGETHER: usize = 16;
    // Without a branch, unlike `f32::max`.
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let is_one = |before, here, after| here >= larger(larger(before, after), least);
    let mut first = 1;
    let (before, here, after) = (
        row.chunks(TOGETHER),
        row[1..].chunks(TOGETHER),
        row[2..].chunks(TOGETHER),
    );
    for ((before, here), after) in before.zip(here).zip(after) {
        // Most have none, which is found out at once for all of them.
        let triples = before.iter().zip(here).zip(after);
        let count = triples
            .clone()
            .map(|((a, b), c)| u32::from(is_one(*a, *b, *c)));
        if count.sum::<u32>() > 0 {
            for (k, ((before, here), after)) in triples.enumerate() {
                if is_one(*before, *here, *after) {
                    found.push(first + k);
                }
            }
        }
        first += TOGETHER;
    }
}

/// The strongest edges, at most so many, strongest first. `floor` is the noise of a pixel below which nothing is measured.
pub(crate) fn edges(binned: &Binned, most: usize, floor: f64) -> Vec<Edge> {
    if binned.width < 8 || binned.height < 8 {
        return Vec::new();
    }
    let channels = binned.planes.len();
    let grids = [false, true].map(|is_flat| grid(binned, is_flat));
    let lengths = grids.map(|grid| channels * grid.len());
    // In one piece: allocators hand small memory out again and again, and large memory from the system each time.
    let mut sums = Vec::with_capacity(lengths[0] + lengths[1]);
    sum(binned, false, &mut sums);
    sum(binned, true, &mut sums);
    let (steep, flat) = sums.split_at(lengths[0]);
    let families = [(false, grids[0], steep), (true, grids[1], flat)];
    let families = families.map(|(is_flat, grid, sums)| Family {
        is_flat,
        grid,
        sums: sums.chunks_exact(grid.len()).collect(),
    });
    let whitening = Whitening::of(&families, channels, floor);
    let mut found: Vec<Edge> = Vec::new();
    let mut peaks = Vec::new();
    for family in &families {
        let scores = family.scores(&whitening);
        let places = family.grid.places();
        for (slope, row) in scores.chunks_exact(places).enumerate() {
            peaks.clear();
            maxima(row, LEAST_SCORE * LEAST_SCORE, &mut peaks);
            for &place in &peaks {
                let at = slope * places + place;
                if !family.is_peak(at, &scores, &whitening) {
                    continue;
                }
                let root = family.grid.counts(slope)(place).sqrt();
                let step = family.colours(at, &whitening).map(|colour| colour / root);
                let [down, right] = family.top(at, &whitening);
                let (line, normal) =
                    family.line(slope as f64 + down, place as f64 + right, binned.factor);
                found.push(Edge {
                    line,
                    normal,
                    step,
                    score: scores[at].sqrt(),
                    axis: whitening.axis(&step),
                    colour: family.light(at).normalize().into(),
                });
            }
        }
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found.truncate(most);
    found
}
