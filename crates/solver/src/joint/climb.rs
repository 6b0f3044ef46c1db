//! From a first cylinder to the likeliest one.

use nalgebra::{SMatrix, SVector};

use super::block::{Alike, Lit};
use super::crossing::moved_px;
use super::fit::{Sums, sums};
use super::pool::{Block, trust, usual};
use super::state::{BEND, RADIUS, ROD, State, UNKNOWNS, of_shadow};

/// Steps at most.
const STEPS: usize = 40;
/// A step is done when it moves the limbs less than this, in standard deviations.
const ENOUGH: f64 = 0.05;
/// Or less than this, px: no image is so sharp.
const STILL_PX: f64 = 0.001;
/// Nor is one worth taking that gains less likelihood.
pub(crate) const GAIN: f64 = 0.1;
/// Who gains less than this by the last so many steps is there.
const CREEPS: usize = 12;
const CREPT: f64 = 4.0;
/// Or less than this share: where the model fits badly, likelihoods say less.
const CREPT_SHARE: f64 = 0.002;
/// Damped more, a step says nothing about how far it is.
const MOST_DAMPING: f64 = 0.1;

/// Lenses blur by so much, px², within this, as a standard deviation of its logarithm.
const USUAL_BLUR_PX2: f64 = 0.2;
const BLUR_SPREAD: f64 = 1.2;
/// Both eyes' are as alike as this, as a standard deviation of their ratio's logarithm.
const UNLIKE_SPREAD: f64 = 0.4;

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
    pub(crate) lit: Lit,
    pub(crate) sums: Sums,
    pub(crate) converged: bool,
    /// How many samples were fitted.
    pub(crate) samples: usize,
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

/// Where a climb begins, and what is known before it.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) state: State,
    /// The light, if it is known.
    pub(crate) lit: Option<Lit>,
    pub(crate) alike: Alike,
    pub(crate) prior: Option<Prior>,
}

/// Climbs by Gauss and Newton with Levenberg's and Marquardt's damping until what is to be gained is less than `enough`.
pub(crate) fn climb(start: &Start, blocks: &mut [Block], enough: f64) -> Option<Fit> {
    let Start {
        mut state,
        lit,
        alike,
        prior,
    } = start.clone();
    let mut lit = lit.unwrap_or_else(|| {
        // Shading first: with none all derivatives are zero.
        let dark = Lit::dark(blocks.len());
        sums(&state, blocks, &dark, &alike).lit(&dark, &SVector::zeros())
    });
    let (mut damping, mut harder) = (1e-3, 2.0);
    let mut here = sums(&state, blocks, &lit, &alike);
    let mut taken = 0;
    let mut converged = false;
    let mut costs = Vec::with_capacity(STEPS);
    while taken < STEPS {
        taken += 1;
        costs.push(here.cost);
        let (mut normal, mut score) = (here.normal, here.score);
        add_prior(&mut normal, &mut score, &state, prior);
        add_known(&mut normal, &mut score, &state);
        let undamped = normal;
        // By how much a step without damping would be likelier, as far as slopes tell.
        let free = bounded(&state, &normal, &score)?;
        if taken > 2 && foreseen(&normal, &score, &free) < enough {
            converged = true;
            break;
        }
        for k in 0..UNKNOWNS {
            normal[(k, k)] += damping * normal[(k, k)] + f64::MIN_POSITIVE;
        }
        let step = bounded(&state, &normal, &score)?;
        let next = state.moved(&step);
        let next_lit = here.lit(&lit, &step);
        let there = sums(&next, blocks, &next_lit, &alike);
        let cost =
            |sums: &Sums, state: &State| sums.cost + prior_cost(state, prior) + known_cost(state);
        // Weights change with the state: the likelihood is no sharper than that.
        let better = cost(&there, &next) <= cost(&here, &state) + GAIN;
        let size2 = (step.transpose() * here.normal * step)[(0, 0)];
        if better {
            let gained = cost(&here, &state) - cost(&there, &next);
            let is_still = size2 < ENOUGH * ENOUGH || moved_px(blocks, &state, &next) < STILL_PX;
            (state, lit, here) = (next, next_lit, there);
            // By how well the step's gain was foreseen (Nielsen 1999).
            let foreseen = foreseen(&undamped, &score, &step).max(f64::MIN_POSITIVE);
            let off = 2.0 * gained / foreseen - 1.0;
            damping = (damping * (1.0 - off * off * off).clamp(0.1, 1.0)).max(1e-9);
            harder = 2.0;
            let is_free = damping < MOST_DAMPING;
            if taken > 2 && is_free && (is_still || gained.abs() < enough) {
                converged = true;
                break;
            }
            if taken == 2 {
                weigh_cuts(blocks, &here);
                here = sums(&state, blocks, &lit, &alike);
            }
        } else {
            if size2 < ENOUGH * ENOUGH {
                converged = true;
                break;
            }
            damping = (harder * damping).max(1e-6);
            harder *= 2.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    // What creeps is as good as there.
    let crept = CREPT.max(CREPT_SHARE * here.cost);
    converged |= taken == STEPS && costs[STEPS - CREEPS] - here.cost < crept;
    let cuts = || blocks.iter().flat_map(|block| block.cuts.iter().flatten());
    let kept = cuts().filter(|cut| cut.weight > 0.5);
    let kept: usize = kept.map(|cut| cut.rows_kept).sum();
    let rows: usize = cuts().map(|cut| cut.rows).sum();
    let rows_kept = kept as f64 / rows.max(1) as f64;
    Some(Fit {
        samples: cuts().map(|cut| cut.samples.len()).sum(),
        rows_kept,
        state,
        lit,
        sums: here,
        converged,
    })
}

/// The step to the best of what the state may be: what would go beyond ends there, and the others step as is best then.
fn bounded(
    state: &State,
    normal: &SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &SVector<f64, UNKNOWNS>,
) -> Option<SVector<f64, UNKNOWNS>> {
    let [least, most] = state.bounds();
    let mut held = [None; UNKNOWNS];
    loop {
        let (mut normal, mut right) = (*normal, *score);
        for (k, held) in held.iter().enumerate() {
            if let Some(by) = held {
                right -= normal.column(k) * *by;
            }
        }
        for (k, held) in held.iter().enumerate() {
            if let Some(by) = held {
                normal.row_mut(k).fill(0.0);
                normal.column_mut(k).fill(0.0);
                (normal[(k, k)], right[k]) = (1.0, *by);
            }
        }
        let step = solve(&normal, &right)?;
        let mut is_within = true;
        for (k, held) in held
            .iter_mut()
            .enumerate()
            .filter(|(_, held)| held.is_none())
        {
            let end = step[k].clamp(least[k], most[k]);
            if end != step[k] {
                *held = Some(end);
                is_within = false;
            }
        }
        if is_within {
            return Some(step);
        }
    }
}

/// By how much likelier a step is as far as slopes tell.
fn foreseen(
    normal: &SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &SVector<f64, UNKNOWNS>,
    step: &SVector<f64, UNKNOWNS>,
) -> f64 {
    step.dot(score) - 0.5 * step.dot(&(normal * step))
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

/// What is known of blurs and shadows: how sharp lenses are, that shadows' light is a share of what there is, and that their angle is
/// not to run away.
pub(crate) fn add_known(
    normal: &mut SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    score: &mut SVector<f64, UNKNOWNS>,
    state: &State,
) {
    for (k, blur_px2) in state.blur_px2.into_iter().enumerate() {
        let sharpness = 1.0 / (BLUR_SPREAD * BLUR_SPREAD);
        normal[(ROD + k, ROD + k)] += sharpness;
        score[ROD + k] -= sharpness * libm::log(blur_px2 / USUAL_BLUR_PX2);
    }
    let likeness = 1.0 / (UNLIKE_SPREAD * UNLIKE_SPREAD);
    let unlike = libm::log(state.blur_px2[0] / state.blur_px2[1]);
    for (k, sign) in [(ROD, 1.0), (ROD + 1, -1.0)] {
        normal[(k, k)] += likeness;
        score[k] -= sign * likeness * unlike;
    }
    normal[(ROD, ROD + 1)] -= likeness;
    normal[(ROD + 1, ROD)] -= likeness;
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

fn known_cost(state: &State) -> f64 {
    let limbs = state.shadows.iter().flatten().flatten();
    let amounts = limbs.map(|shadow| shadow.amount);
    let blurs = state.blur_px2.into_iter();
    let blurs = blurs.map(|blur_px2| libm::log(blur_px2 / USUAL_BLUR_PX2) / BLUR_SPREAD);
    let unlike = libm::log(state.blur_px2[0] / state.blur_px2[1]) / UNLIKE_SPREAD;
    amounts
        .chain(blurs)
        .chain([unlike])
        .map(|off| 0.5 * off * off)
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

/// Limbs of blocks that something hides say less.
fn weigh_cuts(blocks: &mut [Block], here: &Sums) {
    let mut all: Vec<f64> = here.squares.iter().flatten().flatten().copied().collect();
    let usual = usual(&mut all);
    for (block, squares) in blocks.iter_mut().zip(&here.squares) {
        for (cut, squares) in block
            .cuts
            .iter_mut()
            .flatten()
            .zip(squares.iter().flatten())
        {
            cut.weight = trust(squares / usual);
        }
    }
}
