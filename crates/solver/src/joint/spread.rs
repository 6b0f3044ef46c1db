//! How an edge looks to a pixel: steps, ramps and roots of the distance to an edge, blurred by the lens and summed by the pixel.
//!
//! Across a limb everything that the fit needs is a function of x, the distance inside it in px: the rod's share of a pixel, light
//! that grows with the distance, and light that grows with its root, as that of a round rod lit from the camera does.

use super::moments::{Moments, moments};

/// Sharper lenses are taken for this one, which no pixel tells from them.
pub(crate) const LEAST_BLUR_PX2: f64 = 0.01;
/// Nodes of a table to either side of the edge.
const HALF: usize = 40;
const NODES: usize = 2 * HALF + 1;

/// The spread of an edge of one direction by one blur.
#[derive(Clone, Debug)]
pub(crate) struct Spread {
    /// Beyond it a step is a step, px.
    reach_px: f64,
    /// Of a step, a ramp and a root the value and the slope; between nodes they are cubics.
    nodes: [[[f64; 2]; 3]; NODES],
    /// Second and fourth moments of the spread, px² and px⁴.
    moments: [f64; 2],
}

/// Value, slope, curvature.
pub(crate) type Shape = [f64; 3];

const NONE: Shape = [0.0; 3];

/// How light is spread at a distance inside an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shapes {
    /// Of what is 1 inside, 0 outside.
    pub(crate) step: Shape,
    /// Of the distance inside, 0 outside.
    pub(crate) ramp: Shape,
    /// Of the root of the distance inside, 0 outside.
    pub(crate) root: Shape,
}

impl Spread {
    /// An edge with a unit normal, blurred by a Gaussian of so many px² and by the pixel's square.
    pub(crate) fn new(normal: [f64; 2], blur_px2: f64) -> Self {
        let [mut wide, mut narrow] = normal.map(f64::abs);
        if narrow > wide {
            core::mem::swap(&mut wide, &mut narrow);
        }
        let blur = Blur::new(wide, narrow, blur_px2);
        let reach_px = 0.5 * (wide + narrow) + 5.0 * blur.sigma + 0.3;
        let nodes = core::array::from_fn(|node| {
            let place = (node as f64 / HALF as f64 - 1.0) * reach_px;
            let [line, step, ramp, sloped, root] = blur.at(place);
            [[step, line], [ramp, step], [root, sloped]]
        });
        let [a2, b2] = [wide * wide, narrow * narrow];
        let boxes = (a2 + b2) / 12.0;
        Self {
            reach_px,
            nodes,
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

    /// At a distance inside.
    pub(crate) fn at(&self, x_px: f64) -> Shapes {
        if x_px >= self.reach_px {
            Shapes {
                step: [1.0, 0.0, 0.0],
                ramp: [x_px, 1.0, 0.0],
                root: self.deep_root(x_px),
            }
        } else if x_px <= -self.reach_px {
            Shapes {
                step: NONE,
                ramp: NONE,
                root: NONE,
            }
        } else {
            let [step, ramp, root] = self.between(x_px, [0, 1, 2]);
            Shapes { step, ramp, root }
        }
    }

    /// The step alone.
    pub(crate) fn step(&self, x_px: f64) -> Shape {
        if x_px >= self.reach_px {
            [1.0, 0.0, 0.0]
        } else if x_px <= -self.reach_px {
            NONE
        } else {
            let [step] = self.between(x_px, [0]);
            step
        }
    }

    /// The ramp alone.
    pub(crate) fn ramp(&self, x_px: f64) -> Shape {
        if x_px >= self.reach_px {
            [x_px, 1.0, 0.0]
        } else if x_px <= -self.reach_px {
            NONE
        } else {
            let [ramp] = self.between(x_px, [1]);
            ramp
        }
    }

    /// Where nothing but the moments of the spread is felt.
    fn deep_root(&self, x_px: f64) -> Shape {
        let root = x_px.sqrt();
        let per_px2 = 1.0 / (x_px * x_px);
        let [second, fourth] = self.moments.map(|m| m * per_px2);
        let (second, fourth) = (0.125 * second, 15.0 / 384.0 * fourth * per_px2);
        [
            root * (1.0 - second - fourth),
            0.5 / root * (1.0 + 3.0 * second + 7.0 * fourth),
            -0.25 / (root * x_px),
        ]
    }

    /// Some of a step, a ramp and a root within reach.
    fn between<const N: usize>(&self, x_px: f64, which: [usize; N]) -> [Shape; N] {
        let per_px = HALF as f64 / self.reach_px;
        let px = self.reach_px / HALF as f64;
        let place = (x_px + self.reach_px) * per_px;
        let node = (place as usize).min(NODES - 2);
        let s = place - node as f64;
        let (before, after) = (&self.nodes[node], &self.nodes[node + 1]);
        which.map(|k| {
            let ([a, a1], [b, b1]) = (before[k], after[k]);
            let (a1, b1) = (a1 * px, b1 * px);
            // a + a1 s + c s² + d s³.
            let c = 3.0 * (b - a) - 2.0 * a1 - b1;
            let d = 2.0 * (a - b) + a1 + b1;
            [
                a + s * (a1 + s * (c + s * d)),
                (a1 + s * (2.0 * c + s * 3.0 * d)) * per_px,
                (2.0 * c + 6.0 * d * s) * (per_px * per_px),
            ]
        })
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

    /// At a distance: 1/distance, 1, the distance, half of one over its root, and its root, blurred. Boxes blur by differences, once for
    /// each, of integrals at their borders.
    fn at(&self, x: f64) -> [f64; 5] {
        let a = 0.5 * self.wide;
        let parts = |x: f64, sign: f64, order: usize| {
            let Moments { steps, roots } = moments(x, self.sigma);
            let [line, step, ramp] = [order - 1, order, order + 1].map(|n| sign * steps[n]);
            let [sloped, root] = [order - 1, order].map(|n| sign * roots[n]);
            [line, step, ramp, sloped, root]
        };
        let add = |a: [f64; 5], b: [f64; 5]| core::array::from_fn(|k| a[k] + b[k]);
        match self.narrow {
            None => {
                let sum: [f64; 5] = add(parts(x + a, 1.0, 1), parts(x - a, -1.0, 1));
                sum.map(|v| v / self.wide)
            }
            Some(narrow) => {
                let b = 0.5 * narrow;
                let outer = add(parts(x + a + b, 1.0, 2), parts(x - a - b, 1.0, 2));
                let inner = add(parts(x + a - b, -1.0, 2), parts(x - a + b, -1.0, 2));
                let sum: [f64; 5] = add(outer, inner);
                sum.map(|v| v / (self.wide * narrow))
            }
        }
    }
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
                    (spread.at(x).step, step, 1e-2),
                    (spread.at(x).ramp, ramp, 3e-4),
                    (spread.at(x).root, root, 3e-4),
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
        let shapes: [fn(&Spread, f64) -> Shape; 4] = [
            |spread, x| spread.at(x).step,
            |spread, x| spread.at(x).ramp,
            |spread, x| spread.at(x).root,
            Spread::ramp,
        ];
        for shape in shapes {
            for i in -70..=70 {
                let x = 0.1 * f64::from(i) + 0.013;
                let h = 1e-5;
                let slope = (shape(&spread, x + h)[0] - shape(&spread, x - h)[0]) / (2.0 * h);
                assert!((shape(&spread, x)[1] - slope).abs() < 2e-3, "{x}: {slope}");
            }
        }
    }
}
