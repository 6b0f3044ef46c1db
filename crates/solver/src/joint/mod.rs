//! The best we can do: limbs found without a threshold in all colours, then one fit of the rod to the pixels of both images.
//!
//! From coarse to fine: `light` bins, `radon` and `sums` find edges in all colours at once, `strip` pairs them (`shot` holds what a pair
//! of images shows), `pair` matches strips of both eyes, `elsewhere` those of several pairs; `refine` takes one match to the likeliest rod
//! there. In it `trace` and `contrast` look closer. Then the likelihood: `bands` are the pixels around the limbs, `noise` what they weigh,
//! and `pool` what neighbouring rows say together; `state` is what is unknown, `moments`, `spread` and `shade` the light of a pixel,
//! `crossing` where it is, `block` and `fit` the sums over all, `climb` their maximum by `step`s of all pairs, `drift` what is not known of a
//! move; `alike` learns how shading changes along the limbs; `shadow` and `limbs` look at what the light inside a limb says of lamps, and
//! whether it is a limb at all; where it is soft, `by_lamps` looks for the lamps whose light (`lamp`) ties all limbs. Last `judge` with
//! `covariance`: how sure it is and the redundancies, `astray`: whether pairs contradict each other, and `answer`.
//!
//! But for lamps, each limb has its own axis of colours and its own light inside, block by block: what is shadow on one side and gloss on
//! the other no one profile across the rod holds.
//!
//! Pairs from elsewhere are in the first one's frame from the start: their cameras are where the rig went. A rod is the same in all of
//! them; blurs, shadows and shading are each pair's own.
//!
//! Not in it: striped and overgrown rods whose limbs cancel, single images from elsewhere, fits of many rods at once.

mod alike;
mod answer;
mod astray;
mod bands;
mod block;
mod by_lamps;
mod climb;
mod contrast;
mod covariance;
mod crossing;
mod drift;
mod elsewhere;
mod fit;
mod judge;
mod lamp;
mod light;
mod limbs;
mod moments;
mod noise;
mod pair;
mod pool;
mod radon;
mod refine;
mod refusal;
mod shade;
mod shadow;
mod shot;
mod spread;
mod state;
mod step;
mod strip;
mod sums;
mod trace;
mod whitening;

use std::time::Instant;

use crate::{Estimate, Method, Request, SolveError};
use answer::give;
use pair::Candidate;
use refine::Located;
use refusal::Refusal;
use shot::Shot;

/// Rods that are fitted in turn until one fits, and what is likely enough of the likeliest to be tried.
const TRIED: usize = 8;
const LEAST_SHARE: f64 = 0.2;
/// What is likely enough of the likeliest to be taken for it as its fit comes to rest.
const REST_SHARE: f64 = 0.4;
/// What is likely enough of the likeliest to be looked at where a pick may mean what is in front.
const NEARER_SHARE: f64 = 0.25;
/// Strips that are turned by less are one.
const SAME_RAD: f64 = 0.15;
/// Where other pairs may show what is parallel to the baseline, all of them together are to be so much less likely than it.
const PARALLEL_SHARE: f64 = 0.5;
/// Another rod that is as likely as this is a warning.
const RUNNER_UP: f64 = 0.8;

/// Locates the rod.
///
/// # Errors
/// A malformed request. A rod that cannot be located is a refused [`Estimate`].
pub(crate) fn solve(request: &Request<'_>) -> Result<Estimate, SolveError> {
    request.validate()?;
    let start = Instant::now();
    let mut estimate = Estimate::refused(Method::Joint.name(), String::new());
    let outcome = locate(request, &mut estimate);
    estimate.conclude(outcome.map_err(|refusal| (refusal.to_string(), refusal.code())));
    estimate.timing_ms.total = start.elapsed().as_secs_f64() * 1e3;
    Ok(estimate)
}

fn locate(request: &Request<'_>, estimate: &mut Estimate) -> Result<(), Refusal> {
    let start = Instant::now();
    let mut shots = vec![Shot::first(request)?];
    shots.extend(request.more.iter().map(Shot::moved));
    let rig = &request.pair.rig;
    let (candidates, parallel_share) = match &shots[..] {
        [first] => (pair::candidates(first, request.radius, LEAST_SHARE), 1.0),
        all => (
            elsewhere::candidates(all, request.radius, LEAST_SHARE),
            PARALLEL_SHARE,
        ),
    };
    estimate.timing_ms.pair = start.elapsed().as_secs_f64() * 1e3;
    let start = Instant::now();
    let parallel = parallel_share * pair::parallel(&shots[0]);
    if request.radius.is_none() && parallel > candidates.first().map_or(0.0, |best| best.score) {
        return Err(Refusal::ParallelToBaseline);
    }
    let best = candidates.first().ok_or(Refusal::NoRod)?;
    let ray = request
        .pick
        .and_then(|pick| rig.eye(pick.eye).ray(&pick.pixel));
    let mut located: Option<(&Candidate, Located)> = None;
    let mut others: Vec<Located> = Vec::new();
    for candidate in candidates.iter().take(TRIED) {
        if let Some((other, before)) = &located {
            let is_done = before.fit.converged
                && ray.is_none_or(|ray| before.is_met(&ray))
                && worth(other, before) >= candidate.score;
            // What crosses behind what was pointed at is as good a rod.
            let may_be_nearer = ray.is_some()
                && candidate.score > NEARER_SHARE * best.score
                && !is_same(other, candidate);
            if is_done && !may_be_nearer {
                continue;
            }
        }
        let Some(found) = refine::refine(request, &shots, candidate) else {
            continue;
        };
        let is_better = match &located {
            None => true,
            Some((other, before)) => {
                let rank = |candidate, located: &Located| {
                    let is_met = ray.is_none_or(|ray| located.is_met(&ray));
                    let worth = worth(candidate, located);
                    // What is much less likely is not the better for coming to rest.
                    let is_at_rest = located.fit.converged && worth > REST_SHARE * best.score;
                    (is_met, is_at_rest, worth)
                };
                let nearer = ray.filter(|_| found.is_sure() && before.is_sure());
                let nearer = nearer.and_then(|ray| found.is_nearer(before, &ray));
                let by_rank = || rank(candidate, &found) > rank(other, before);
                nearer.unwrap_or_else(by_rank)
            }
        };
        let worse = if is_better {
            located
                .replace((candidate, found))
                .map(|(_, before)| before)
        } else {
            Some(found)
        };
        others.extend(worse);
    }
    let (chosen, found) = located.ok_or(Refusal::Lost)?;
    if let Some(astray) = astray::astray(request, &shots, chosen, &found) {
        astray.told(&mut estimate.observability.warnings)?;
    }
    let other = candidates.iter().find(|other| !is_same(other, chosen));
    let o = &mut estimate.observability;
    o.runner_up_ratio = other.map(|other| other.score / best.score.max(f64::MIN_POSITIVE));
    if let Some(ratio) = o.runner_up_ratio.filter(|ratio| *ratio > RUNNER_UP) {
        o.warnings.push(format!(
            "another rod is nearly as likely ({ratio:.2}): point at the one that is meant, or give regions"
        ));
    }
    let is_before = |other: &Located| {
        let is_nearer = ray.and_then(|ray| other.is_nearer(&found, &ray));
        is_nearer == Some(true) && other.is_seen_by_both()
    };
    if others.iter().any(is_before) {
        o.warnings
            .push("another rod may be in front of it where the pick is".to_owned());
    }
    estimate.timing_ms.locate = start.elapsed().as_secs_f64() * 1e3;
    give(request, estimate, &found)
}

/// How likely a candidate is, now that its pixels are known: edges within a rod are likely too, but pixels are as a rod has them only
/// where one is. Never more than its score.
fn worth(candidate: &Candidate, located: &Located) -> f64 {
    candidate.score / located.fit.misfit().max(1.0)
}

/// Whether the one is seen where the other is, in both images.
fn is_same(a: &Candidate, b: &Candidate) -> bool {
    let mut pairs = a.strips.iter().zip(&b.strips);
    pairs.all(|(a, b)| {
        let is_there = a.holds(&b.middle_px) || b.holds(&a.middle_px);
        let turned = a.edges[0].line.angle_to(&b.edges[0].line);
        is_there && turned < SAME_RAD
    })
}
