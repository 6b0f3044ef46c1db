//! From a first cylinder to the likeliest one.

use nalgebra::{DVector, SVector};

use super::block::{Alike, Lit};
use super::crossing::moved_px;
use super::drift::Drift;
use super::fit::{Sums, sums};
use super::pool::{Block, trust, usual};
use super::state::{BEND, RADIUS, ROD, State, UNKNOWNS, of_shadow};
use super::step::{Layout, Normal, Score, Slopes};

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

/// The likeliest state of a pair.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) state: State,
    pub(crate) lit: Lit,
    pub(crate) sums: Sums,
    /// How far off the pair is, where that is not known.
    pub(crate) drift: Option<Drift>,
}

/// The likeliest rod of all pairs.
#[derive(Clone, Debug)]
pub(crate) struct Fits {
    /// The first is there.
    pub(crate) pairs: Vec<Fit>,
    pub(crate) converged: bool,
    /// How many samples were fitted.
    pub(crate) samples: usize,
    /// Share of the rows that look as the model says.
    pub(crate) rows_kept: f64,
}

impl Fits {
    /// In the first pair's frame.
    pub(crate) fn state(&self) -> &State {
        &self.pairs[0].state
    }

    /// By how much the pixels would be likelier were the rod free to bend.
    pub(crate) fn bend_gain(&self) -> f64 {
        let slopes = |fit: &Fit| (fit.sums.normal, fit.sums.score);
        let slopes: Vec<_> = self.pairs.iter().map(slopes).collect();
        let layout = layout(&self.pairs);
        let mut freed = layout.gathered(&slopes);
        layout.add_drifts(&mut freed, drifts(&self.pairs));
        for pair in 0..self.pairs.len() {
            for k in ROD + 2..UNKNOWNS {
                freed.hold(Layout::place(pair, k));
            }
        }
        let mut straight = freed.clone();
        for k in BEND..BEND + 2 {
            straight.hold(k);
        }
        let gain = |slopes: &Slopes| {
            slopes
                .best()
                .map_or(0.0, |step| 0.5 * step.dot(&slopes.score))
        };
        gain(&freed) - gain(&straight)
    }

    /// Χ² of a pixel.
    pub(crate) fn misfit(&self) -> f64 {
        let sum =
            |of: fn(&Sums) -> f64| -> f64 { self.pairs.iter().map(|fit| of(&fit.sums)).sum() };
        sum(|sums| sums.chi2) / sum(|sums| sums.pixels)
    }
}

fn drifts(pairs: &[Fit]) -> impl Iterator<Item = Option<&Drift>> {
    pairs.iter().map(|fit| fit.drift.as_ref())
}

fn layout(pairs: &[Fit]) -> Layout {
    Layout::new(pairs.iter().map(|fit| (&fit.state, fit.drift.as_ref())))
}

/// Where the climb of a pair begins, and what is known before it.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) state: State,
    /// The light, if it is known.
    pub(crate) lit: Option<Lit>,
    pub(crate) alike: Alike,
    pub(crate) drift: Option<Drift>,
}

impl Start {
    /// Begins where a climb ended.
    pub(crate) fn take(&mut self, fit: &Fit) {
        (self.state, self.drift) = (fit.state, fit.drift);
    }

    fn fit(&self, blocks: &[Block]) -> Fit {
        let Self {
            state,
            lit,
            alike,
            drift,
        } = self.clone();
        let lit = lit.unwrap_or_else(|| {
            // Shading first: with none all derivatives are zero.
            let dark = Lit::dark(blocks.len());
            sums(&state, blocks, &dark, &alike).lit(&dark, &SVector::zeros())
        });
        Fit {
            sums: sums(&state, blocks, &lit, &alike),
            state,
            lit,
            drift,
        }
    }
}

/// Climbs by Gauss and Newton with Levenberg's and Marquardt's damping until what is to be gained is less than `enough`; `starts` and
/// `blocks` are of each pair.
pub(crate) fn climb(
    starts: &[Start],
    prior: Option<Prior>,
    blocks: &mut [Vec<Block>],
    enough: f64,
) -> Option<Fits> {
    let pairs = starts.iter().zip(&*blocks);
    let mut here: Vec<Fit> = pairs.map(|(start, blocks)| start.fit(blocks)).collect();
    let (mut damping, mut harder) = (1e-3, 2.0);
    let mut taken = 0;
    let mut converged = false;
    let mut costs = Vec::with_capacity(STEPS);
    while taken < STEPS {
        taken += 1;
        costs.push(likelihood(&here));
        let layout = layout(&here);
        let undamped = slopes(&here, &layout, prior);
        let bounds = layout.bounds(here.iter().map(|fit| &fit.state));
        // By how much a step without damping would be likelier, as far as slopes tell.
        let free = undamped.bounded(&bounds)?;
        if taken > 2 && undamped.gain(&free) < enough {
            converged = true;
            break;
        }
        let step = undamped.damped(damping).bounded(&bounds)?;
        let there = stepped(&here, starts, blocks, &layout, &step);
        // Weights change with the state: the likelihood is no sharper than that.
        let better = cost(&there, prior) <= cost(&here, prior) + GAIN;
        let squares = here.iter().enumerate().map(|(pair, fit)| {
            let step = layout.of_pair(&step, pair);
            (step.transpose() * fit.sums.normal * step)[(0, 0)]
        });
        let size2: f64 = squares.sum();
        if better {
            let gained = cost(&here, prior) - cost(&there, prior);
            let is_still = size2 < ENOUGH * ENOUGH || farthest_px(blocks, &here, &there) < STILL_PX;
            here = there;
            // By how well the step's gain was foreseen (Nielsen 1999).
            let foreseen = undamped.gain(&step).max(f64::MIN_POSITIVE);
            let off = 2.0 * gained / foreseen - 1.0;
            damping = (damping * (1.0 - off * off * off).clamp(0.1, 1.0)).max(1e-9);
            harder = 2.0;
            let is_free = damping < MOST_DAMPING;
            if taken > 2 && is_free && (is_still || gained.abs() < enough) {
                converged = true;
                break;
            }
            if taken == 2 {
                for ((fit, blocks), start) in here.iter_mut().zip(blocks.iter_mut()).zip(starts) {
                    weigh_cuts(blocks, &fit.sums);
                    fit.sums = sums(&fit.state, blocks, &fit.lit, &start.alike);
                }
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
    let crept = CREPT.max(CREPT_SHARE * likelihood(&here));
    converged |= taken == STEPS && costs[STEPS - CREEPS] - likelihood(&here) < crept;
    let cuts = || {
        blocks
            .iter()
            .flatten()
            .flat_map(|block| block.cuts.iter().flatten())
    };
    let kept = cuts().filter(|cut| cut.weight > 0.5);
    let kept: usize = kept.map(|cut| cut.rows_kept).sum();
    let rows: usize = cuts().map(|cut| cut.rows).sum();
    let rows_kept = kept as f64 / rows.max(1) as f64;
    Some(Fits {
        samples: cuts().map(|cut| cut.samples.len()).sum(),
        rows_kept,
        pairs: here,
        converged,
    })
}

/// How likelihood changes, with what is known.
fn slopes(here: &[Fit], layout: &Layout, prior: Option<Prior>) -> Slopes {
    let known = here.iter().enumerate().map(|(pair, fit)| {
        let (mut normal, mut score) = (fit.sums.normal, fit.sums.score);
        add_prior(
            &mut normal,
            &mut score,
            &fit.state,
            prior.filter(|_| pair == 0),
        );
        add_known(&mut normal, &mut score, &fit.state);
        (normal, score)
    });
    let mut all = layout.gathered(&known.collect::<Vec<_>>());
    layout.add_drifts(&mut all, drifts(here));
    all
}

/// All pairs after a step.
fn stepped(
    here: &[Fit],
    starts: &[Start],
    blocks: &[Vec<Block>],
    layout: &Layout,
    step: &DVector<f64>,
) -> Vec<Fit> {
    let mut there: Vec<Fit> = Vec::with_capacity(here.len());
    for (pair, ((fit, start), blocks)) in here.iter().zip(starts).zip(blocks).enumerate() {
        let own = layout.of_pair(step, pair);
        let mut state = fit.state.moved(&own);
        let drift = fit
            .drift
            .map(|drift| drift.moved(&layout.of_drift(step, pair)));
        // Turns do not add up as steps do: the rod is where the first pair has it.
        if let (Some(drift), Some(first)) = (&drift, there.first()) {
            state = drift.seen(&first.state, &state);
        }
        let lit = fit.sums.lit(&fit.lit, &own);
        there.push(Fit {
            sums: sums(&state, blocks, &lit, &start.alike),
            state,
            lit,
            drift,
        });
    }
    there
}

/// Of the pixels alone.
fn likelihood(pairs: &[Fit]) -> f64 {
    pairs.iter().map(|fit| fit.sums.cost).sum()
}

fn cost(pairs: &[Fit], prior: Option<Prior>) -> f64 {
    let known = pairs.iter().enumerate().map(|(pair, fit)| {
        let prior = prior.filter(|_| pair == 0);
        let drift = fit.drift.map_or(0.0, |drift| drift.cost());
        fit.sums.cost + prior_cost(&fit.state, prior) + known_cost(&fit.state) + drift
    });
    known.sum()
}

/// By how many pixels limbs differ at most.
pub(crate) fn farthest_px(blocks: &[Vec<Block>], from: &[Fit], to: &[Fit]) -> f64 {
    let pairs = blocks.iter().zip(from.iter().zip(to));
    let moved = pairs.map(|(blocks, (from, to))| moved_px(blocks, &from.state, &to.state));
    moved.fold(0.0, f64::max)
}

fn prior_cost(state: &State, prior: Option<Prior>) -> f64 {
    prior.map_or(0.0, |prior| {
        let off = (state.cylinder.radius_m - prior.radius_m) / prior.sigma_m;
        0.5 * off * off
    })
}

/// What is known of the radius, as one measurement more.
fn add_prior(normal: &mut Normal, score: &mut Score, state: &State, prior: Option<Prior>) {
    if let Some(prior) = prior {
        let weight = 1.0 / (prior.sigma_m * prior.sigma_m);
        normal[(RADIUS, RADIUS)] += weight;
        score[RADIUS] += weight * (prior.radius_m - state.cylinder.radius_m);
    }
}

/// What is known of blurs and shadows: how sharp lenses are, that shadows' light is a share of what there is, and that their angle is
/// not to run away.
pub(crate) fn add_known(normal: &mut Normal, score: &mut Score, state: &State) {
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
