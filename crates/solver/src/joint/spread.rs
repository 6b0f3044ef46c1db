//! How an edge looks to a pixel: steps, ramps and roots of the distance to an edge, blurred by the lens and summed by the pixel.
//!
//! Across a limb everything that the fit needs is a function of x, the distance inside it in px: the rod's share of a pixel, light
//! that grows with the distance, and light that grows with its root, as that of a round rod lit from the camera does.

use core::f64::consts::PI;

/// Sharper lenses are taken for this one, which no pixel tells from them.
pub(crate) const LEAST_BLUR_PX2: f64 = 0.01;
/// Nodes of a table to either side of the edge.
const HALF: usize = 64;
const NODES: usize = 2 * HALF + 1;

/// A function and its slope at the nodes, and between them by cubics.
#[derive(Clone, Debug)]
struct Table([[f64; 2]; NODES]);

impl Table {
    /// Value, first and second derivative; the caller knows that the place is within reach.
    fn at(&self, x_px: f64, reach_px: f64) -> [f64; 3] {
        let step = reach_px / HALF as f64;
        let place = (x_px + reach_px) / step;
        let node = (place as usize).min(NODES - 2);
        let s = place - node as f64;
        let ([a, a1], [b, b1]) = (self.0[node], self.0[node + 1]);
        let (a1, b1) = (a1 * step, b1 * step);
        // a + a1 s + c s² + d s³.
        let c = 3.0 * (b - a) - 2.0 * a1 - b1;
        let d = 2.0 * (a - b) + a1 + b1;
        [
            a + s * (a1 + s * (c + s * d)),
            (a1 + s * (2.0 * c + s * 3.0 * d)) / step,
            (2.0 * c + 6.0 * d * s) / (step * step),
        ]
    }
}

/// The spread of an edge of one direction by one blur.
#[derive(Clone, Debug)]
pub(crate) struct Spread {
    /// Beyond it a step is a step, px.
    reach_px: f64,
    step: Table,
    ramp: Table,
    root: Table,
    /// Second and fourth moments of the spread, px² and px⁴.
    moments: [f64; 2],
}

/// Value, slope, curvature.
pub(crate) type Shape = [f64; 3];

impl Spread {
    /// An edge with a unit normal, blurred by a Gaussian of so many px² and by the pixel's square.
    pub(crate) fn new(normal: [f64; 2], blur_px2: f64) -> Self {
        let [mut wide, mut narrow] = normal.map(f64::abs);
        if narrow > wide {
            core::mem::swap(&mut wide, &mut narrow);
        }
        let blur = Blur::new(wide, narrow, blur_px2);
        let reach_px = 0.5 * (wide + narrow) + 5.0 * blur.sigma + 0.3;
        let place = |node: usize| (node as f64 / HALF as f64 - 1.0) * reach_px;
        let step = Table(core::array::from_fn(|n| {
            [blur.step(place(n)), blur.line(place(n))]
        }));
        let ramp = Table(core::array::from_fn(|n| {
            [blur.ramp(place(n)), blur.step(place(n))]
        }));
        let root = Table(core::array::from_fn(|n| {
            blurred_root(&step, place(n), reach_px)
        }));
        let [a2, b2] = [wide * wide, narrow * narrow];
        let boxes = (a2 + b2) / 12.0;
        Self {
            reach_px,
            step,
            ramp,
            root,
            moments: [
                blur_px2 + boxes,
                3.0 * blur_px2 * blur_px2
                    + 6.0 * blur_px2 * boxes
                    + (a2 * a2 + b2 * b2) / 80.0
                    + a2 * b2 / 24.0,
            ],
        }
    }

    /// Beyond it a step is a step.
    pub(crate) fn reach_px(&self) -> f64 {
        self.reach_px
    }

    /// 1 inside, 0 outside.
    pub(crate) fn step(&self, x_px: f64) -> Shape {
        if x_px >= self.reach_px {
            [1.0, 0.0, 0.0]
        } else if x_px <= -self.reach_px {
            [0.0; 3]
        } else {
            self.step.at(x_px, self.reach_px)
        }
    }

    /// The distance inside, 0 outside.
    pub(crate) fn ramp(&self, x_px: f64) -> Shape {
        if x_px >= self.reach_px {
            [x_px, 1.0, 0.0]
        } else if x_px <= -self.reach_px {
            [0.0; 3]
        } else {
            self.ramp.at(x_px, self.reach_px)
        }
    }

    /// The root of the distance inside, 0 outside.
    pub(crate) fn root(&self, x_px: f64) -> Shape {
        if x_px >= self.reach_px {
            let root = x_px.sqrt();
            let per_px2 = 1.0 / (x_px * x_px);
            let [second, fourth] = self.moments.map(|m| m * per_px2);
            let (second, fourth) = (0.125 * second, 15.0 / 384.0 * fourth * per_px2);
            [
                root * (1.0 - second - fourth),
                0.5 / root * (1.0 + 3.0 * second + 7.0 * fourth),
                -0.25 / (root * x_px),
            ]
        } else if x_px <= -self.reach_px {
            [0.0; 3]
        } else {
            self.root.at(x_px, self.reach_px)
        }
    }
}

/// A Gaussian with one box or two.
struct Blur {
    sigma: f64,
    wide: f64,
    narrow: Option<f64>,
}

impl Blur {
    /// A box narrower than this is part of the Gaussian.
    const NARROW: f64 = 0.05;

    fn new(wide: f64, narrow: f64, blur_px2: f64) -> Self {
        let is_box = narrow >= Self::NARROW;
        let variance =
            blur_px2.max(LEAST_BLUR_PX2) + if is_box { 0.0 } else { narrow * narrow / 12.0 };
        Self {
            sigma: variance.sqrt(),
            wide,
            narrow: is_box.then_some(narrow),
        }
    }

    /// The difference, once for each box, of what a function's integral is at its borders.
    fn boxed(&self, once: impl Fn(f64) -> f64, twice: impl Fn(f64) -> f64, x: f64) -> f64 {
        let a = 0.5 * self.wide;
        match self.narrow {
            None => (once(x + a) - once(x - a)) / self.wide,
            Some(narrow) => {
                let b = 0.5 * narrow;
                let sum = twice(x + a + b) - twice(x + a - b) - twice(x - a + b) + twice(x - a - b);
                sum / (self.wide * narrow)
            }
        }
    }

    fn line(&self, x: f64) -> f64 {
        self.boxed(|x| self.power(0, x), |x| self.power(1, x), x)
    }

    fn step(&self, x: f64) -> f64 {
        self.boxed(|x| self.power(1, x), |x| self.power(2, x), x)
    }

    fn ramp(&self, x: f64) -> f64 {
        self.boxed(|x| self.power(2, x), |x| self.power(3, x), x)
    }

    /// `x₊ⁿ / n!`, blurred by the Gaussian.
    fn power(&self, n: u32, x: f64) -> f64 {
        let z = x / self.sigma;
        let whole = 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
        let bell = libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        let s = self.sigma;
        match n {
            0 => whole,
            1 => s * (z * whole + bell),
            2 => 0.5 * s * s * ((z * z + 1.0) * whole + z * bell),
            _ => s * s * s / 6.0 * ((z * z * z + 3.0 * z) * whole + (z * z + 2.0) * bell),
        }
    }
}

/// ∫ step(x − q²) dq from 0 on, which is the blurred root of x, and its slope.
fn blurred_root(step: &Table, x_px: f64, reach_px: f64) -> [f64; 2] {
    const PARTS: usize = 64;
    let last = (x_px + reach_px).max(0.0).sqrt();
    let width = last / PARTS as f64;
    let mut sums = [0.0; 2];
    // Simpson's rule.
    for part in 0..=PARTS {
        let weight = match part {
            0 | PARTS => 1.0,
            odd if odd % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let q = part as f64 * width;
        let [value, slope, _] = step.at((x_px - q * q).max(-reach_px), reach_px);
        sums[0] += weight * value;
        sums[1] += weight * slope;
    }
    sums.map(|sum| sum * width / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By brute force: the mean over a pixel, and over a Gaussian, of a function of the distance.
    fn mean(normal: [f64; 2], sigma: f64, x: f64, of: impl Fn(f64) -> f64) -> f64 {
        const N: i32 = 60;
        let (mut sum, mut weights) = (0.0, 0.0);
        for g in -N..=N {
            let z = 5.0 * f64::from(g) / f64::from(N);
            let weight = libm::exp(-0.5 * z * z);
            let mut inner = 0.0;
            for i in 0..N {
                for j in 0..N {
                    let [a, b] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(N) - 0.5);
                    inner += of(x + sigma * z + a * normal[0] + b * normal[1]);
                }
            }
            sum += weight * inner / f64::from(N * N);
            weights += weight;
        }
        sum / weights
    }

    #[test]
    fn shapes_are_means_over_blur_and_pixel() {
        for (normal, sigma) in [([1.0, 0.0], 0.4), ([0.8, -0.6], 0.3), ([0.3, 0.954], 1.1)] {
            let spread = Spread::new(normal, sigma * sigma);
            for i in -14..=14 {
                let x = 0.43 * f64::from(i) + 0.07;
                let step = mean(normal, sigma, x, |x| f64::from(u8::from(x > 0.0)));
                let ramp = mean(normal, sigma, x, |x| x.max(0.0));
                let root = mean(normal, sigma, x, |x| x.max(0.0).sqrt());
                // Sums over cells are least exact of what jumps.
                for (found, wanted, off) in [
                    (spread.step(x), step, 1e-2),
                    (spread.ramp(x), ramp, 3e-4),
                    (spread.root(x), root, 3e-4),
                ] {
                    assert!(
                        (found[0] - wanted).abs() < off,
                        "{normal:?} {x}: {} {wanted}",
                        found[0]
                    );
                }
            }
        }
    }

    #[test]
    fn slopes_are_slopes_and_tables_end_smoothly() {
        let spread = Spread::new([0.8, 0.6], 0.5);
        for shape in [Spread::step, Spread::ramp, Spread::root] {
            for i in -70..=70 {
                let x = 0.1 * f64::from(i) + 0.013;
                let h = 1e-5;
                let slope = (shape(&spread, x + h)[0] - shape(&spread, x - h)[0]) / (2.0 * h);
                assert!((shape(&spread, x)[1] - slope).abs() < 2e-3, "{x}: {slope}");
            }
        }
    }
}
