//! The best we can do: limbs found without a threshold in all colours, then one fit of the rod to the pixels of both images.
//!
//! From coarse to fine: `light` bins, `radon` and `sums` find edges in all colours at once, `strip` pairs them, `pair` matches strips of
//! both eyes; `refine` takes one match to the likeliest rod there. In it `trace` and `contrast` look closer. Then the likelihood: `bands`
//! are the pixels around the limbs, `noise` what they weigh, and `pool` what neighbouring rows say together; `state` is what is unknown,
//! `moments`, `spread` and `shade` the light of a pixel, `crossing` where it is, `block` and `fit` the sums over all, `climb` their maximum; `alike` learns how
//! shading changes along the limbs; `shadow` and `limbs` look at what the light inside a limb says of lamps, and whether it is a limb at
//! all. Last `judge`, the covariance and the redundancies, and `answer`.
//!
//! Each limb has its own axis of colours and its own light inside, block by block: lamps beside the cameras end in shadows that no one
//! profile across the rod holds.
//!
//! Not in it: striped and overgrown rods whose limbs cancel, more than two views, fits of many rods at once.

mod alike;
mod answer;
mod bands;
mod block;
mod climb;
mod contrast;
mod crossing;
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
mod spread;
mod state;
mod strip;
mod sums;
mod trace;
mod whitening;

use std::time::Instant;

use rodsight_geometry::{Eye, Pixel};

use crate::{Estimate, Method, Request, SolveError};
use answer::give;
use light::Light;
use pair::Candidate;
use refine::Located;
use refusal::Refusal;
use strip::Strip;

/// Edges of an image that are paired.
const EDGES: usize = 48;
/// Strips of an image that are paired with the other's.
const STRIPS: usize = 12;
/// How many pixels, and how many a side, a region has at most as it is searched. Where nothing was found it is searched again: coarser
/// for what is faint, finer for what texture hides.
const COARSE: [(usize, usize); 3] = [(1 << 15, 256), (1 << 13, 128), (1 << 17, 512)];
/// Rods that are fitted in turn until one fits, and what is likely enough of the likeliest to be tried.
const TRIED: usize = 8;
const LEAST_SHARE: f64 = 0.2;
/// What is likely enough of the likeliest to be taken for it as its fit comes to rest.
const REST_SHARE: f64 = 0.4;
/// What is likely enough of the likeliest to be looked at where a pick may mean what is in front.
const NEARER_SHARE: f64 = 0.25;
/// Strips that are turned by less are one.
const SAME_RAD: f64 = 0.15;
/// Another rod that is as likely as this is a warning.
const RUNNER_UP: f64 = 0.8;

/// What was seen in one image.
struct Seen<'a> {
    light: Light<'a>,
    strips: Vec<Strip>,
    factor: usize,
}

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

fn see<'a>(request: &Request<'a>, eye: Eye) -> Result<Seen<'a>, Refusal> {
    let roi = request.roi(eye);
    let light = Light::of(request.image(eye), roi);
    let pick = request
        .pick
        .filter(|pick| pick.eye == eye)
        .map(|pick| pick.pixel - Pixel::new(roi.x_px.into(), roi.y_px.into()));
    let factors = COARSE.map(|(pixels, side)| light.factor(pixels, side));
    for (look, factor) in factors.into_iter().enumerate() {
        if factors[..look].contains(&factor) {
            continue;
        }
        let binned = light.binned(factor);
        let floor = 2e-4 / factor as f64;
        let edges = sums::edges(&binned, EDGES, floor);
        let strips = strip::strips(&edges, &binned, pick.as_ref(), STRIPS);
        if !strips.is_empty() {
            return Ok(Seen {
                light,
                strips,
                factor,
            });
        }
    }
    Err(if pick.is_some() {
        Refusal::PickOffStrip { eye: eye.name() }
    } else {
        Refusal::NoPair { eye: eye.name() }
    })
}

fn locate(request: &Request<'_>, estimate: &mut Estimate) -> Result<(), Refusal> {
    let start = Instant::now();
    let seen = [see(request, Eye::Left)?, see(request, Eye::Right)?];
    let lights = [&seen[0].light, &seen[1].light];
    let rig = &request.pair.rig;
    let candidates = pair::candidates(
        rig,
        lights,
        [&seen[0].strips, &seen[1].strips],
        request.radius,
        [seen[0].factor, seen[1].factor],
        LEAST_SHARE,
    );
    estimate.timing_ms.pair = start.elapsed().as_secs_f64() * 1e3;
    let start = Instant::now();
    let parallel = pair::parallel(rig, lights, [&seen[0].strips, &seen[1].strips]);
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
        let Some(found) = refine::refine(request, lights, candidate) else {
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
    candidate.score / located.misfit().max(1.0)
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
