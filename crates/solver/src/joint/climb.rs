//! From a first cylinder to the likeliest one.

use nalgebra::{SMatrix, SVector};

use super::bands::Block;
use super::fit::{Shades, Sums, sums};
use super::state::{BEND, RADIUS, ROD, State, UNKNOWNS, of_shadow};

/// Steps at most.
const STEPS: usize = 40;
/// A step is done when it moves the limbs less than this, in standard deviations.
const ENOUGH: f64 = 0.05;
/// Nor is one worth taking that gains less likelihood.
const GAIN: f64 = 0.1;
/// Who gains less than this by the last so many steps is there.
const CREEPS: usize = 12;
const CREPT: f64 = 4.0;
/// Damped more, a step says nothing about how far it is.
const MOST_DAMPING: f64 = 0.1;
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
    pub(crate) shades: Vec<Shades>,
    pub(crate) sums: Sums,
    pub(crate) converged: bool,
    /// Share of the rows that look as the model says.
    pub(crate) rows_kept: f64,
}

impl Fit {
    /// By how much the pixels would be likelier were the rod free to bend.
    pub(crate) fn bend_gain(&self) -> f64 {
        let normal = &self.sums.normal;
        let mut freed = *normal;
        for k in ROD + 2..UNKNOWNS {
            freed.row_mut(k).fill(0.0);
            freed.column_mut(k).fill(0.0);
            freed[(k, k)] = 1.0;
        }
        let mut score = self.sums.score;
        score.rows_mut(ROD + 2, UNKNOWNS - ROD - 2).fill(0.0);
        let mut straight = freed;
        let mut of_straight = score;
        for k in BEND..BEND + 2 {
            straight.row_mut(k).fill(0.0);
            straight.column_mut(k).fill(0.0);
            (straight[(k, k)], of_straight[k]) = (1.0, 0.0);
        }
        let gain = |normal, score: &SVector<f64, UNKNOWNS>| {
            solve(normal, score).map_or(0.0, |step| 0.5 * step.dot(score))
        };
        gain(&freed, &score) - gain(&straight, &of_straight)
    }
}

/// Climbs by Gauss and Newton with Levenberg's and Marquardt's damping.
pub(crate) fn climb(start: &State, blocks: &mut [Block], prior: Option<Prior>) -> Option<Fit> {
    let mut state = *start;
    let mut shades = vec![Shades::zeros(); blocks.len()];
    // Shading first: with none all derivatives are zero.
    let first = sums(&state, blocks, &shades);
    for (shades, (shift, _)) in shades.iter_mut().zip(&first.shading) {
        *shades += shift;
    }
    let mut damping = 1e-3;
    let mut here = sums(&state, blocks, &shades);
    let mut taken = 0;
    let mut converged = false;
    let mut costs = Vec::with_capacity(STEPS);
    while taken < STEPS {
        taken += 1;
        costs.push(here.cost);
        let (mut normal, mut score) = (here.normal, here.score);
        add_prior(&mut normal, &mut score, &state, prior);
        add_shadows(&mut normal, &mut score, &state);
        for k in 0..UNKNOWNS {
            normal[(k, k)] += damping * normal[(k, k)] + f64::MIN_POSITIVE;
        }
        for (k, _) in state
            .held(&score)
            .iter()
            .enumerate()
            .filter(|(_, held)| **held)
        {
            normal.row_mut(k).fill(0.0);
            normal.column_mut(k).fill(0.0);
            (normal[(k, k)], score[k]) = (1.0, 0.0);
        }
        let step = state.taken(&solve(&normal, &score)?);
        let next = state.moved(&step);
        let mut next_shades = shades.clone();
        for (shades, (shift, by)) in next_shades.iter_mut().zip(&here.shading) {
            *shades += shift - by * step;
        }
        let there = sums(&next, blocks, &next_shades);
        let cost =
            |sums: &Sums, state: &State| sums.cost + prior_cost(state, prior) + shadow_cost(state);
        // Weights change with the state: the likelihood is no sharper than that.
        let better = cost(&there, &next) <= cost(&here, &state) + GAIN;
        let size2 = (step.transpose() * here.normal * step)[(0, 0)];
        if better {
            let gained = cost(&here, &state) - cost(&there, &next);
            (state, shades, here) = (next, next_shades, there);
            damping = (0.2 * damping).max(1e-9);
            let is_free = damping < MOST_DAMPING;
            if taken > 2 && is_free && (size2 < ENOUGH * ENOUGH || gained.abs() < GAIN) {
                converged = true;
                break;
            }
            if taken == 2 {
                weigh_rows(blocks, &here);
                here = sums(&state, blocks, &shades);
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
    // What creeps is as good as there.
    converged |= taken == STEPS && costs[STEPS - CREEPS] - here.cost < CREPT;
    let rows = || blocks.iter().flat_map(|block| &block.rows);
    let kept = rows().filter(|row| row.weight > 0.5).count();
    let rows_kept = kept as f64 / rows().count().max(1) as f64;
    Some(Fit {
        rows_kept,
        state,
        shades,
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
        normal[(RADIUS, RADIUS)] += weight;
        score[RADIUS] += weight * (prior.radius_m - state.cylinder.radius_m);
    }
}

/// What is known of shadows: their light is a share of what there is, and their angle is not to run away.
pub(crate) fn add_shadows(
    normal: &mut SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &mut SVector<f64, UNKNOWNS>,
    state: &State,
) {
    for (eye, limbs) in state.shadows.iter().enumerate() {
        for (side, limb) in limbs.iter().enumerate() {
            let k = of_shadow(eye, side);
            if let Some(shadow) = limb {
                normal[(k, k)] += 1.0;
                score[k] -= shadow.amount;
                normal[(k + 1, k + 1)] += 4.0 / (shadow.angle_rad * shadow.angle_rad);
            }
        }
    }
}

fn shadow_cost(state: &State) -> f64 {
    let limbs = state.shadows.iter().flatten().flatten();
    limbs
        .map(|shadow| 0.5 * shadow.amount * shadow.amount)
        .sum()
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
