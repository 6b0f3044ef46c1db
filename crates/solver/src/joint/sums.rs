//! Sums of an image's gradient along all lines: where the edges of straight things are, without a threshold.
//!
//! Lines come in two families, steeper and flatter than 45°. Of a family's image the gradient across is summed along every digital
//! line by adding whole rows, each moved by what the slope asks (a discrete Radon transform). What a line collects
//! is in units of the noise: of the same sums all over the image, so that texture counts as noise.

use nalgebra::{Matrix3, Vector3};
use rodsight_geometry::{ImageLine, Pixel};

use super::light::Binned;

/// Noise makes stronger edges than this, in its own standard deviations, hardly ever.
const LEAST_SCORE: f32 = 4.0;

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
}

/// Of one family: `sums[slope][place]`, a plane a channel.
struct Family {
    /// Rows of the family's image are columns of the image.
    is_flat: bool,
    /// The family's image.
    width: usize,
    height: usize,
    slopes: usize,
    /// Columns of `sums`: places before the first column come first.
    places: usize,
    before: usize,
    sums: Vec<Vec<f32>>,
    /// Pixels of each line in the image.
    counts: Vec<f32>,
}

fn transposed(plane: &[f32], width: usize, height: usize) -> Vec<f32> {
    let mut out = Vec::with_capacity(plane.len());
    for column in 0..width {
        out.extend((0..height).map(|row| plane[row * width + column]));
    }
    out
}

/// I(x + 1) − I(x − 1), nothing at the border.
fn across(plane: &[f32], width: usize) -> Vec<f32> {
    let mut out = vec![0.0; plane.len()];
    for (out, row) in out.chunks_exact_mut(width).zip(plane.chunks_exact(width)) {
        for x in 1..width - 1 {
            out[x] = row[x + 1] - row[x - 1];
        }
    }
    out
}

impl Family {
    fn new(binned: &Binned, is_flat: bool) -> Self {
        let (width, height) = if is_flat {
            (binned.height, binned.width)
        } else {
            (binned.width, binned.height)
        };
        // From −45° to 45°, a pixel apart at the ends.
        let slopes = height | 1;
        let before = height / 2 + 1;
        let places = width + 2 * before;
        let mut family = Self {
            is_flat,
            width,
            height,
            slopes,
            places,
            before,
            sums: Vec::new(),
            counts: Vec::new(),
        };
        for plane in &binned.planes {
            let gradient = if is_flat {
                across(&transposed(plane, binned.width, binned.height), width)
            } else {
                across(plane, width)
            };
            family.sums.push(family.summed(&gradient));
        }
        let mut inside = vec![1.0_f32; width * height];
        for row in inside.chunks_exact_mut(width) {
            (row[0], row[width - 1]) = (0.0, 0.0);
        }
        family.counts = family.summed(&inside);
        family
    }

    fn slope(&self, index: usize) -> f64 {
        let half = (self.slopes / 2) as f64;
        (index as f64 - half) / half.max(1.0)
    }

    fn summed(&self, image: &[f32]) -> Vec<f32> {
        let mut sums = vec![0.0_f32; self.slopes * self.places];
        let middle = 0.5 * (self.height as f64 - 1.0);
        for (index, sums) in sums.chunks_exact_mut(self.places).enumerate() {
            let slope = self.slope(index);
            for (y, row) in image.chunks_exact(self.width).enumerate() {
                // What lies at x in this row is on the line that passes the middle row at x − slope (y − middle).
                let moved = libm::round(slope * (y as f64 - middle)) as isize;
                let first = (self.before.cast_signed() - moved) as usize;
                for (sum, value) in sums[first..first + self.width].iter_mut().zip(row) {
                    *sum += value;
                }
            }
        }
        sums
    }

    /// The line, in px of the region.
    fn line(&self, index: usize, place: f64, factor: usize) -> (ImageLine, Pixel) {
        let slope = self.slope(index);
        let factor = factor as f64;
        // x = x0 + slope (y − middle), pixel centres at halves.
        let middle_px = 0.5 * self.height as f64 * factor;
        let x0_px = (place - self.before as f64 + 0.5) * factor;
        let length = (1.0 + slope * slope).sqrt();
        let (across, along) = (1.0 / length, -slope / length);
        let rho_px = across * x0_px + along * middle_px;
        let normal = if self.is_flat {
            Pixel::new(along, across)
        } else {
            Pixel::new(across, along)
        };
        (ImageLine::from_normal(&normal, rho_px), normal)
    }
}

/// Turns sums of channels into independent ones of unit variance.
struct Whitening(Matrix3<f64>);

impl Whitening {
    /// From sums over √length of everything, largest values cut off: edges are few.
    fn of(families: &[Family; 2], channels: usize, floor: f64) -> Self {
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); channels];
        for family in families {
            let least = 0.3 * family.height as f32;
            for at in (0..family.counts.len()).step_by(7) {
                let count = family.counts[at];
                if count >= least {
                    for (channel, values) in values.iter_mut().enumerate() {
                        values.push(f64::from(family.sums[channel][at] / count.sqrt()));
                    }
                }
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

    fn of_sum(&self, sums: [f32; 3], count: f32) -> Colours {
        let whitened = self.0 * Vector3::from(sums.map(f64::from)) / f64::from(count.sqrt());
        whitened.map(|v| v as f32).into()
    }
}

pub(crate) fn dot(a: &Colours, b: &Colours) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The strongest edges, at most so many, strongest first. `floor` is the noise of a pixel below which nothing is measured.
pub(crate) fn edges(binned: &Binned, most: usize, floor: f64) -> Vec<Edge> {
    if binned.width < 8 || binned.height < 8 {
        return Vec::new();
    }
    let channels = binned.planes.len();
    let families = [Family::new(binned, false), Family::new(binned, true)];
    let whitening = Whitening::of(&families, channels, floor);
    let mut found: Vec<Edge> = Vec::new();
    for family in &families {
        let least = 0.15 * family.height as f32;
        let colours: Vec<Colours> = (0..family.counts.len())
            .map(|at| {
                if family.counts[at] < least {
                    return [0.0; 3];
                }
                let mut sums = [0.0; 3];
                for (sum, plane) in sums.iter_mut().zip(&family.sums) {
                    *sum = plane[at];
                }
                whitening.of_sum(sums, family.counts[at])
            })
            .collect();
        let score = |slope: usize, place: usize| {
            let c = &colours[slope * family.places + place];
            dot(c, c)
        };
        for slope in 0..family.slopes {
            for place in 1..family.places - 1 {
                let here = score(slope, place);
                if here < LEAST_SCORE * LEAST_SCORE {
                    continue;
                }
                // The larger of its neighbours, of those of the same polarity.
                let mine = &colours[slope * family.places + place];
                let mut is_peak = true;
                for other in slope.saturating_sub(2)..=(slope + 2).min(family.slopes - 1) {
                    for there in place.saturating_sub(2)..=(place + 2).min(family.places - 1) {
                        let theirs = &colours[other * family.places + there];
                        let earlier = (other, there) < (slope, place);
                        let size = dot(theirs, theirs);
                        if (other, there) != (slope, place)
                            && dot(mine, theirs) > 0.0
                            && (size > here || (size == here && earlier))
                        {
                            is_peak = false;
                        }
                    }
                }
                if is_peak {
                    let (line, normal) = family.line(slope, place as f64, binned.factor);
                    found.push(Edge {
                        line,
                        normal,
                        step: *mine,
                        score: here.sqrt(),
                        axis: whitening.axis(mine),
                    });
                }
            }
        }
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found.truncate(most);
    found
}
