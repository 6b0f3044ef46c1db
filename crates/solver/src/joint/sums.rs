//! Sums of an image's gradient along all lines: where the edges of straight things are, without a threshold.
//!
//! Lines come in two families, steeper and flatter than 45°. Of a family's image the gradient across is summed along every digital
//! line (`radon`). What a line collects is in units of the noise: of the same sums all over the image, so that texture counts as
//! noise.

use nalgebra::Vector3;
use rodsight_geometry::{ImageLine, Pixel};

use super::light::Binned;
use super::radon::{Grid, MARGIN};
use super::whitening::Whitening;

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

    /// Appends to each channel's values some of its sums, over the roots of their rows.
    fn sample(&self, values: &mut [Vec<f64>]) {
        let (slopes, places) = (self.grid.slopes(), self.grid.places());
        let least = SAMPLED_ROWS * self.grid.height as f32;
        let step = (slopes * places / SAMPLED).max(1);
        // From slope to slope other places.
        let mut place = 0;
        for slope in 0..slopes {
            let counts = self.grid.counts(slope);
            while place < places {
                let count = counts(place);
                if count >= least {
                    for (sums, values) in self.sums.iter().zip(values.iter_mut()) {
                        values.push(f64::from(sums[slope * places + place] / count.sqrt()));
                    }
                }
                place += step;
            }
            place -= places;
        }
    }

    /// A line's sums, channel by channel.
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

    /// The edge of a peak.
    fn edge(&self, line: usize, whitening: &Whitening, factor: f64) -> Edge {
        let (slope, place) = (line / self.grid.places(), line % self.grid.places());
        let root = self.grid.counts(slope)(place).sqrt();
        let step = self.colours(line, whitening).map(|colour| colour / root);
        // x = x0 + slope (y − middle), where the pixels of the line are and, of its neighbours, the top.
        let (x0_px, turn) = self.grid.course(slope, place);
        let [down, right] = self.top(line, whitening);
        let slope = turn + self.grid.slope(down) - self.grid.slope(0.0);
        let length = (1.0 + slope * slope).sqrt();
        let (across, along) = (1.0 / length, -slope / length);
        let middle_px = 0.5 * self.grid.height as f64;
        let rho_px = factor * (across * (x0_px + right) + along * middle_px);
        let normal = if self.is_flat {
            Pixel::new(along, across)
        } else {
            Pixel::new(across, along)
        };
        Edge {
            line: ImageLine::from_normal(&normal, rho_px),
            normal,
            step,
            score: dot(&step, &step).sqrt(),
            axis: whitening.axis(&step),
            colour: self.light(line).normalize().into(),
        }
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

/// Lines of a family whose sums say how noisy the image is, and the share of the rows that they have at least.
const SAMPLED: usize = 2048;
const SAMPLED_ROWS: f32 = 0.3;

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
    let mut values = vec![Vec::with_capacity(2 * SAMPLED); channels];
    for family in &families {
        family.sample(&mut values);
    }
    let whitening = Whitening::of(&values, floor);
    // Scores, and which family's which line.
    let mut found: Vec<(f32, &Family<'_>, usize)> = Vec::new();
    let strongest = |found: &mut Vec<(f32, &Family<'_>, usize)>| {
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(most);
    };
    let mut least = LEAST_SCORE * LEAST_SCORE;
    let mut peaks = Vec::new();
    for family in &families {
        let scores = family.scores(&whitening);
        let places = family.grid.places();
        for (slope, row) in scores.chunks_exact(places).enumerate() {
            peaks.clear();
            maxima(row, least, &mut peaks);
            let lines = peaks.iter().map(|place| slope * places + place);
            let ours = lines.filter(|line| family.is_peak(*line, &scores, &whitening));
            found.extend(ours.map(|line| (scores[line], family, line)));
            // What is weaker than enough others need not be looked at.
            if found.len() > most.saturating_mul(2) {
                strongest(&mut found);
                least = found.last().map_or(least, |weakest| weakest.0);
            }
        }
    }
    strongest(&mut found);
    let edge = |(_, family, line): (f32, &Family<'_>, usize)| {
        family.edge(line, &whitening, binned.factor as f64)
    };
    found.into_iter().map(edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviates of unit variance, the same on every machine.
    struct Noise(u32);

    impl Noise {
        fn next(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(self.0 >> 8) / f64::from(1 << 24)
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        }
    }

    /// Noise on what `light` is at a place.
    fn painted(
        [width, height]: [usize; 2],
        channels: usize,
        noise: &mut Noise,
        light: impl Fn(&Pixel) -> f64,
    ) -> Binned {
        let mut plane = || {
            (0..width * height)
                .map(|at| Pixel::new((at % width) as f64 + 0.5, (at / width) as f64 + 0.5))
                .map(|place| (light(&place) + 0.02 * noise.next()) as f32)
                .collect()
        };
        Binned {
            factor: 1,
            width,
            height,
            planes: (0..channels).map(|_| plane()).collect(),
        }
    }

    /// Steps of 2.5 times the noise are the strongest edges, a pixel off at most at the ends, and their sign is right.
    #[test]
    fn steps_are_found_at_all_angles() {
        let size = [90, 70];
        let mut noise = Noise(1);
        for turn in 0..60 {
            let (sin, cos) = libm::sincos(core::f64::consts::TAU * f64::from(turn) / 60.0);
            let normal = Pixel::new(cos, sin);
            let through = Pixel::new(45.0 + 8.0 * noise.next(), 35.0 + 6.0 * noise.next());
            let ahead = |place: &Pixel| normal.dot(&(place - through));
            let light = |place: &Pixel| 0.3 + 0.05 * (ahead(place) + 0.5).clamp(0.0, 1.0);
            let binned = painted(size, if turn % 2 == 0 { 3 } else { 1 }, &mut noise, light);
            let found = edges(&binned, 4, 1e-4);
            let edge = found.first().expect("an edge");
            let [from, to] =
                super::super::strip::chord(edge, size.map(|v| v as f64)).expect("a chord");
            for end in [from, to] {
                assert!(ahead(&end).abs() < 1.0, "{turn}: {} px off", ahead(&end));
            }
            let sign = edge.normal.dot(&normal);
            assert!(
                edge.colour.iter().all(|c| c * sign >= 0.0),
                "{turn}: {edge:?}"
            );
            // A step of s over noise n is summed over L rows to s √L / √2 n, a colour; somewhat less for wobbling.
            let rows = (to - from).abs().max();
            let ideal = 2.5 * (rows * binned.planes.len() as f64 / 2.0).sqrt();
            let share = f64::from(edge.score) / ideal;
            assert!((0.5..1.2).contains(&share), "{turn}: {share}");
        }
    }

    /// Both sides of a bright line a pixel and a half wide are found, with opposite signs.
    #[test]
    fn thin_rods_have_two_sides() {
        let size = [80, 96];
        let mut noise = Noise(7);
        for turn in 0..20 {
            let (sin, cos) = libm::sincos(core::f64::consts::PI * f64::from(turn) / 20.0);
            let normal = Pixel::new(cos, sin);
            let off = |place: &Pixel| normal.dot(place) - normal.dot(&Pixel::new(41.0, 47.0));
            let light = |place: &Pixel| 0.2 + 0.06 * (1.25 - off(place).abs()).clamp(0.0, 1.0);
            let found = edges(&painted(size, 3, &mut noise, light), 2, 1e-4);
            let [a, b] = &found[..] else {
                panic!("{found:?}");
            };
            let along = if a.normal.dot(&b.normal) < 0.0 {
                -1.0
            } else {
                1.0
            };
            assert!(along * dot(&a.step, &b.step) < 0.0, "{turn}: {found:?}");
            let [from, to] = [a, b].map(|edge| edge.line.distance_px(&Pixel::new(41.0, 47.0)));
            assert!(from.abs() < 2.0 && to.abs() < 2.0, "{turn}: {from} {to}");
        }
    }

    /// Noise, also correlated noise, has few edges and none that are strong.
    #[test]
    fn noise_has_few_edges() {
        let mut noise = Noise(3);
        for blob in [1, 3] {
            let (mut all, mut strong) = (0, 0);
            for _ in 0..10 {
                let white = painted([120 + blob, 100 + blob], 3, &mut noise, |_| 0.3);
                let mut binned = white.clone();
                (binned.width, binned.height) = (120, 100);
                for (plane, white_plane) in binned.planes.iter_mut().zip(&white.planes) {
                    let at = |x, y| white_plane[y * white.width + x];
                    *plane = (0..120 * 100)
                        .map(|i| (i % 120, i / 120))
                        .map(|(x, y)| {
                            let block = (0..blob * blob).map(|k| at(x + k % blob, y + k / blob));
                            block.sum::<f32>() / blob as f32
                        })
                        .collect();
                }
                let found = edges(&binned, usize::MAX, 1e-4);
                all += found.len();
                strong += found.iter().filter(|edge| edge.score > 6.0).count();
            }
            assert!(
                all < 10 * 100 && strong <= 1,
                "{blob}: {all}, {strong} strong"
            );
        }
    }
}
