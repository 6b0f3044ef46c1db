//! How alike the blocks of a limb are in their shading.
//!
//! Paint, lamps and water change little along a rod, or in few ways. What they leave alone is learned from all blocks together, and
//! each block's own pixels need only say the rest: without that, noise that looks as shading hides where the limb is.

use nalgebra::{SMatrix, SVector};

use super::block::{Alike, Lit};
use super::climb::Fit;
use super::pool::Block;

/// Shading of a limb: three inside, two outside.
const OF_LIMB: usize = 5;
/// From fewer blocks nothing is learned.
const LEAST_BLOCKS: usize = 6;
/// Turns of expectation and maximisation (Dempster, Laird and Rubin 1977).
const TURNS: usize = 12;
/// Blocks are not taken for more alike than this share of what one of them can tell, as a variance.
const LEAST_SPREAD: f64 = 0.02;

type Matrix = SMatrix<f64, OF_LIMB, OF_LIMB>;
type Vector = SVector<f64, OF_LIMB>;

/// What a block says of a limb's shading.
struct Told {
    along: f64,
    weight: f64,
    information: Matrix,
    shades: Vector,
}

/// Learns from a fit that knows nothing of it; the light with the means that were found.
pub(crate) fn alike(fit: &Fit, blocks: &[Block]) -> (Alike, Lit) {
    let (mut alike, mut lit) = (Alike::default(), fit.lit.clone());
    for (eye, (alike, means)) in alike.blocks.iter_mut().zip(&mut lit.means).enumerate() {
        for side in 0..2 {
            let places: [usize; OF_LIMB] = [
                3 * side,
                3 * side + 1,
                3 * side + 2,
                6 + 2 * side,
                7 + 2 * side,
            ];
            let sums = fit.sums.blocks.iter().zip(&fit.lit.shades);
            let seen = blocks
                .iter()
                .zip(sums)
                .filter(|(block, _)| block.eye == eye);
            let told: Vec<Told> = seen
                .filter_map(|(block, (sums, shades))| {
                    Some(Told {
                        along: block.along,
                        weight: block.cuts[side].as_ref()?.weight,
                        information: Matrix::from_fn(|i, j| sums.shading[(places[i], places[j])]),
                        shades: Vector::from_fn(|i, _| shades[places[i]]),
                    })
                })
                .collect();
            let Some((precision, found)) = learned(told) else {
                continue;
            };
            for (i, a) in places.into_iter().enumerate() {
                for (mean, found) in means.iter_mut().zip(&found) {
                    mean[a] = found[i];
                }
                for (j, b) in places.into_iter().enumerate() {
                    alike[(a, b)] = precision[(i, j)];
                }
            }
        }
    }
    (alike, lit)
}

/// One over the covariance of shading between blocks; its mean in the middle, and what it gains to the end.
fn learned(mut told: Vec<Told>) -> Option<(Matrix, [Vector; 2])> {
    if told.len() < LEAST_BLOCKS {
        return None;
    }
    let count = told.len() as f64;
    // In units of what a block can tell.
    let mean: Matrix = told.iter().map(|told| told.information).sum::<Matrix>() / count;
    let ridge = Matrix::identity() * (1e-9 * mean.trace());
    let unit = (mean + ridge).cholesky()?.l();
    let inverse = unit.try_inverse()?;
    for told in &mut told {
        told.information = inverse * told.information * inverse.transpose();
        told.shades = unit.transpose() * told.shades;
    }
    let mut spread = Matrix::identity();
    let mut means = trend(told.iter().map(|told| (told, told.shades)))?;
    for turn in 0..TURNS {
        let precision = spread.try_inverse()?;
        let mut guesses = Vec::with_capacity(told.len());
        let mut covariances = Matrix::zeros();
        let mut weights = 0.0;
        for told in &told {
            let covariance = (told.information + precision).try_inverse()?;
            let expected = means[0] + means[1] * told.along;
            let pull = told.information * told.shades + precision * expected;
            // At first all that blocks differ by is theirs.
            let guess = if turn == 0 {
                told.shades
            } else {
                covariance * pull
            };
            guesses.push(guess);
            covariances += covariance * told.weight;
            weights += told.weight;
        }
        means = trend(told.iter().zip(guesses.iter().copied()))?;
        let mut squares = Matrix::zeros();
        for (told, guess) in told.iter().zip(&guesses) {
            let off = guess - means[0] - means[1] * told.along;
            squares += off * off.transpose() * told.weight;
        }
        let own = if turn == 0 {
            Matrix::zeros()
        } else {
            covariances
        };
        spread =
            (squares * (count / (count - 2.0)) + own) / weights + Matrix::identity() * LEAST_SPREAD;
    }
    let precision = unit * spread.try_inverse()? * unit.transpose();
    let back = inverse.transpose();
    Some((
        (precision + precision.transpose()) * 0.5,
        means.map(|mean| back * mean),
    ))
}

/// Least squares of a middle and a slope.
fn trend<'a>(points: impl Iterator<Item = (&'a Told, Vector)>) -> Option<[Vector; 2]> {
    let (mut w, mut wx, mut wxx) = (0.0, 0.0, 0.0);
    let (mut wy, mut wxy) = (Vector::zeros(), Vector::zeros());
    for (told, value) in points {
        let (x, weight) = (told.along, told.weight);
        w += weight;
        wx += weight * x;
        wxx += weight * x * x;
        wy += value * weight;
        wxy += value * (weight * x);
    }
    let det = w * wxx - wx * wx;
    (det > 1e-9 * w * w).then(|| [(wy * wxx - wxy * wx) / det, (wxy * w - wy * wx) / det])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nearly normal: the sum of twelve numbers of a congruential sequence.
    fn normal(state: &mut u64) -> f64 {
        let uniform = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(state)).sum::<f64>() - 6.0
    }

    /// Blocks that differ in one way, or in none but what noise makes of them: that is told from what is theirs, though not all of it.
    #[test]
    fn blocks_differ_by_what_they_differ() {
        const SIGMA: f64 = 0.1;
        let (middle, slope) = (
            Vector::new(1.0, -0.2, 0.5, 0.3, 0.0),
            Vector::new(0.4, 0.0, 0.2, 0.0, 0.1),
        );
        for own in [0.0, 3.0] {
            let mut state = 7;
            let told = (0..60).map(|k| {
                let along = f64::from(k) / 30.0 - 1.0;
                let mut shades = middle + slope * along;
                shades += Vector::from_fn(|_, _| SIGMA * normal(&mut state));
                shades[0] += own * SIGMA * normal(&mut state);
                Told {
                    along,
                    weight: 1.0,
                    information: Matrix::identity() / (SIGMA * SIGMA),
                    shades,
                }
            });
            let (precision, means) = learned(told.collect()).expect("enough blocks");
            let spread = precision.try_inverse().expect("a covariance") / (SIGMA * SIGMA);
            if own > 0.0 {
                assert!(
                    (0.6..1.6).contains(&(spread[(0, 0)] / (own * own))),
                    "{spread}"
                );
            } else {
                assert!(spread[(0, 0)] < 0.75, "{spread}");
            }
            assert!((1..OF_LIMB).all(|k| spread[(k, k)] < 0.75), "{spread}");
            let off = (means[0] - middle).norm().max((means[1] - slope).norm());
            assert!(off < 0.2 * (1.0 + own), "{off}");
        }
        assert!(learned(Vec::new()).is_none());
    }
}
