//! Steps, roots and their integrals, blurred by a Gaussian.

use core::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::OnceLock;

/// Beyond so many standard deviations only the Gaussian's moments are felt.
const REACH: f64 = 8.0;
const PER_SIGMA: usize = 16;
const NODES: usize = 16 * PER_SIGMA + 1;
/// Parts of an integral, even.
const PARTS: usize = 256;

/// By a Gaussian of unit variance: the bell, `x₊ⁿ/n!` for n from 0 to 3; and half of 1/√x₊, √x₊ and its integrals, twice. Each is the
/// slope of the next.
#[derive(Clone, Copy, Debug)]
struct Node {
    steps: [f64; 5],
    roots: [f64; 4],
}

/// What a place is blurred to: `x₊ⁿ/n!` for n from 0 to 3, and √x₊ and its first two integrals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub(crate) steps: [f64; 4],
    pub(crate) roots: [f64; 3],
}

/// At a place by a Gaussian of a standard deviation.
pub(crate) fn moments(x: f64, sigma: f64) -> Moments {
    let Moments {
        mut steps,
        mut roots,
    } = unit(x / sigma);
    let mut scale = 1.0;
    for step in &mut steps {
        *step *= scale;
        scale *= sigma;
    }
    scale = sigma.sqrt();
    for root in &mut roots {
        *root *= scale;
        scale *= sigma;
    }
    Moments { steps, roots }
}

fn unit(z: f64) -> Moments {
    static TABLE: OnceLock<Vec<Node>> = OnceLock::new();
    if z <= -REACH {
        return Moments {
            steps: [0.0; 4],
            roots: [0.0; 3],
        };
    }
    if z >= REACH {
        let z2 = z * z;
        let root = z.sqrt();
        let [a, b, c] = [1.0 / z2, 1.0 / (z2 * z2), 1.0 / (z2 * z2 * z2)];
        return Moments {
            steps: [1.0, z, 0.5 * (z2 + 1.0), z * (z2 + 3.0) / 6.0],
            roots: [
                root * (1.0 - a / 8.0 - b * 15.0 / 128.0 - c * 315.0 / 1024.0),
                root * z * (2.0 / 3.0 + a / 4.0 + b * 3.0 / 64.0 + c * 35.0 / 512.0),
                root * z2 * (4.0 / 15.0 + a / 2.0 - b / 32.0 - c * 5.0 / 256.0),
            ],
        };
    }
    let table = TABLE.get_or_init(|| (0..NODES).map(|k| node(at(k))).collect());
    let place = (z + REACH) * PER_SIGMA as f64;
    let k = (place as usize).min(NODES - 2);
    let s = place - k as f64;
    let (a, b) = (&table[k], &table[k + 1]);
    let between = |a: &[f64], b: &[f64], n: usize| {
        hermite(
            [a[n + 1], b[n + 1]],
            [a[n], b[n]].map(|slope| slope / PER_SIGMA as f64),
            s,
        )
    };
    Moments {
        steps: core::array::from_fn(|n| between(&a.steps, &b.steps, n)),
        roots: core::array::from_fn(|n| between(&a.roots, &b.roots, n)),
    }
}

fn at(node: usize) -> f64 {
    node as f64 / PER_SIGMA as f64 - REACH
}

/// Between two values with their slopes.
fn hermite([a, b]: [f64; 2], [a1, b1]: [f64; 2], s: f64) -> f64 {
    let c = 3.0 * (b - a) - 2.0 * a1 - b1;
    let d = 2.0 * (a - b) + a1 + b1;
    a + s * (a1 + s * (c + s * d))
}

fn bell(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt()
}

fn node(z: f64) -> Node {
    let (bell_here, whole) = (bell(z), 0.5 * libm::erfc(-z * FRAC_1_SQRT_2));
    let ramp = z * whole + bell_here;
    let square = 0.5 * (z * ramp + whole);
    // x = q²: the integrands are smooth then. Simpson's rule.
    let (from, to) = ((z - REACH).max(0.0).sqrt(), (z + REACH).max(0.0).sqrt());
    let width = (to - from) / PARTS as f64;
    let mut sums = [0.0; 4];
    for part in 0..=PARTS {
        let q = from + part as f64 * width;
        let share = match part {
            0 | PARTS => 1.0,
            odd if odd % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let q2 = q * q;
        let mut term = share * width / 3.0 * bell(q2 - z);
        for (sum, by) in sums
            .iter_mut()
            .zip([2.0 * q2, 2.0 / 3.0 * q2, 0.4 * q2, 0.0])
        {
            *sum += term;
            term *= by;
        }
    }
    Node {
        steps: [bell_here, whole, ramp, square, (z * square + ramp) / 3.0],
        roots: sums,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables and series against their definitions.
    #[test]
    fn moments_are_means_over_the_gaussian() {
        const PARTS: i32 = 200_000;
        for z in [-7.9, -3.03, -0.51, 0.0, 0.27, 1.9, 4.44, 7.99, 8.01, 11.3] {
            let Moments { steps, roots } = unit(z);
            let mut sums = [0.0; 5];
            for part in 0..PARTS {
                // By the root again: near zero it is steep.
                let (most, parts) = (30.0_f64.sqrt(), f64::from(PARTS));
                let q = (f64::from(part) + 0.5) / parts * most;
                let (x, measure) = (q * q, 2.0 * q * most / parts);
                let mass = bell(x - z) * measure;
                let values = [x, x * x / 2.0, q, q * x / 1.5, q * x * x / 3.75];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += mass * value;
                }
            }
            let found = [steps[1], steps[2], roots[0], roots[1], roots[2]];
            for (found, wanted) in found.into_iter().zip(sums) {
                assert!(
                    (found - wanted).abs() < 2e-7 * (1.0 + wanted),
                    "{z}: {found} {wanted}"
                );
            }
        }
    }
}
