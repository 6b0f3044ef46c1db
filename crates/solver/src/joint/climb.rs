//! From a first cylinder to the likeliest one.

use nalgebra::{SMatrix, SVector};

use super::bands::Block;
use super::fit::{Noise, ROD, Shades, State, Sums, UNKNOWNS, sums};
use super::spread::LEAST_BLUR_PX2;

/// Steps at most.
const STEPS: usize = 40;
/// A step is done when it moves the limbs less than this, in standard deviations.
const ENOUGH: f64 = 0.02;
/// Nor is one worth taking that gains less likelihood.
const GAIN: f64 = 0.3;
/// Rows whose squares are this many times the usual ones weigh less.
const ROW_LIMIT: f64 = 2.0;

/// What is known of the radius, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prior {
    pub(crate) radius_m: f64,
    pub(crate) sigma_m: f64,
}

/// The likeliest state.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) state: State,
    pub(crate) sums: Sums,
    pub(crate) converged: bool,
    /// Share of the rows that look as the model says.
    pub(crate) rows_kept: f64,
}

/// Climbs by Gauss and Newton with Levenberg's and Marquardt's damping.
pub(crate) fn climb(
    start: State,
    blocks: &mut [Block],
    noise: &[Noise; 2],
    prior: Option<Prior>,
) -> Option<Fit> {
    let mut state = start;
    let mut shades = vec![Shades::zeros(); blocks.len()];
    // Shading first: with none all derivatives are zero.
    let first = sums(&state, blocks, &shades, noise);
    for (shades, (shift, _)) in shades.iter_mut().zip(&first.shading) {
        *shades += shift;
    }
    let mut damping = 1e-3;
    let mut here = sums(&state, blocks, &shades, noise);
    let mut taken = 0;
    let mut converged = false;
    while taken < STEPS {
        taken += 1;
        let (mut normal, mut score) = (here.normal, here.score);
        add_prior(&mut normal, &mut score, &state, prior);
        for k in 0..UNKNOWNS {
            normal[(k, k)] += damping * normal[(k, k)] + f64::MIN_POSITIVE;
        }
        // A lens cannot be sharper than sharp.
        for k in ROD..UNKNOWNS {
            let is_sharp = state.blur_px2[k - ROD] <= 1.001 * LEAST_BLUR_PX2;
            if is_sharp && score[k] < 0.0 {
                normal.row_mut(k).fill(0.0);
                normal.column_mut(k).fill(0.0);
                (normal[(k, k)], score[k]) = (1.0, 0.0);
            }
        }
        let step = solve(&normal, &score)?;
        let next = state.moved(&step);
        let mut next_shades = shades.clone();
        for (shades, (shift, by)) in next_shades.iter_mut().zip(&here.shading) {
            *shades += shift - by * step;
        }
        let there = sums(&next, blocks, &next_shades, noise);
        let cost = |sums: &Sums, state: &State| sums.cost + prior_cost(state, prior);
        // Weights change with the state: the likelihood is no sharper than that.
        let better = cost(&there, &next) <= cost(&here, &state) + GAIN;
        let size2 = (step.transpose() * here.normal * step)[(0, 0)];
        if better {
            let gained = cost(&here, &state) - cost(&there, &next);
            (state, shades, here) = (next, next_shades, there);
            damping = (0.2 * damping).max(1e-9);
            if taken > 2 && (size2 < ENOUGH * ENOUGH || gained.abs() < GAIN) {
                converged = true;
                break;
            }
            if taken == 2 {
                weigh_rows(blocks, &here);
                here = sums(&state, blocks, &shades, noise);
            }
        } else {
            if size2 < ENOUGH * ENOUGH {
                converged = true;
                break;
            }
            damping = (8.0 * damping).max(1e-6);
            if damping > 1e6 {
                break;
            }
        }
    }
    let rows = || blocks.iter().flat_map(|block| &block.rows);
    let kept = rows().filter(|row| row.weight > 0.5).count();
    let rows_kept = kept as f64 / rows().count().max(1) as f64;
    Some(Fit {
        rows_kept,
        state,
        sums: here,
        converged,
    })
}

fn prior_cost(state: &State, prior: Option<Prior>) -> f64 {
    prior.map_or(0.0, |prior| {
        let off = (state.cylinder.radius_m - prior.radius_m) / prior.sigma_m;
        0.5 * off * off
    })
}

/// What is known of the radius, as one measurement more.
fn add_prior(
    normal: &mut SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &mut SVector<f64, UNKNOWNS>,
    state: &State,
    prior: Option<Prior>,
) {
    if let Some(prior) = prior {
        let weight = 1.0 / (prior.sigma_m * prior.sigma_m);
        normal[(ROD - 1, ROD - 1)] += weight;
        score[ROD - 1] += weight * (prior.radius_m - state.cylinder.radius_m);
    }
}

/// Solves after scaling to a unit diagonal: metres and radians differ by orders of magnitude.
fn solve(
    normal: &SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &SVector<f64, UNKNOWNS>,
) -> Option<SVector<f64, UNKNOWNS>> {
    let scale = normal
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::from_fn(|i, j| {
        normal[(i, j)] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
    });
    let step = scaled.cholesky()?.solve(&score.component_mul(&scale));
    let step = step.component_mul(&scale);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

/// Rows that something hides say less.
fn weigh_rows(blocks: &mut [Block], here: &Sums) {
    let mut all: Vec<f64> = here.rows.iter().flatten().copied().collect();
    if all.is_empty() {
        return;
    }
    let middle = all.len() / 2;
    let usual = (*all.select_nth_unstable_by(middle, f64::total_cmp).1).max(1.0);
    for (block, rows) in blocks.iter_mut().zip(&here.rows) {
        for (row, squares) in block.rows.iter_mut().zip(rows) {
            let times = squares / usual;
            row.weight = if times > ROW_LIMIT {
                (ROW_LIMIT / times) * (ROW_LIMIT / times)
            } else {
                1.0
            };
        }
    }
}

/// The noise of the light in the blocks of an eye, by what its second differences cannot follow, inside and outside the limbs.
pub(crate) fn noise_of(blocks: &[Block], eye: usize, floor: f64) -> Noise {
    let mut samples: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let cuts = blocks
        .iter()
        .filter(|block| block.eye == eye)
        .flat_map(|block| &block.rows)
        .flat_map(|row| row.cuts.iter().flatten());
    for cut in cuts {
        for (k, window) in cut.values.windows(3).enumerate() {
            let inside_px = cut.inwards * (cut.first_px + k as f64 + 1.0);
            if inside_px.abs() >= 2.5 {
                let second = (window[0] - 2.0 * window[1] + window[2]).abs();
                samples[usize::from(inside_px < 0.0)].push(second);
            }
        }
    }
    let [inside, outside] = samples.map(|mut values| {
        if values.is_empty() {
            return floor * floor;
        }
        let middle = values.len() / 2;
        let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        // Of 1, −2, 1 the variance is six times a pixel's.
        let sigma = 1.4826 * *median / 6.0_f64.sqrt();
        sigma.max(floor) * sigma.max(floor)
    });
    Noise { inside, outside }
}
