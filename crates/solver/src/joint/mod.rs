//! The best we can do: limbs found without a threshold in all colours, then one fit of the rod to the pixels of both images.
//!
//! `sums` finds edges in all colours at once (`radon` adds along lines, `whitening` knows the noise), `strip` pairs them, `pair`
//! matches strips of both eyes; `trace` and `contrast` look closer; `bands`, `spread` and `fit` are the likelihood of a rod, `climb`
//! its maximum, `judge` its covariance and redundancies. Each limb has its own axis of colours and its own light inside: lamps beside
//! the cameras end in shadows that no one profile across the rod holds.
//!
//! Not in it yet: bent, striped and overgrown rods; rods whose limb lies in its own lamp's shadow (the limb is taken to be where the
//! light begins, and the covariance does not know it); more than two views; speed.

mod answer;
mod bands;
mod climb;
mod contrast;
mod fit;
mod judge;
mod light;
mod pair;
mod radon;
mod refusal;
mod spread;
mod strip;
mod sums;
mod trace;
mod whitening;

use std::time::Instant;

use rodsight_geometry::{Eye, Pixel};

use crate::{Estimate, Request, SolveError};
use answer::give;
use climb::{Fit, Prior};
use fit::State;
use judge::Judgement;
use light::Light;
use pair::Candidate;
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
const TRIED: usize = 6;
const LEAST_SHARE: f64 = 0.2;
/// Another rod that is as likely as this is a warning.
const RUNNER_UP: f64 = 0.8;

/// What was seen in one image.
struct Seen<'a> {
    light: Light<'a>,
    strips: Vec<Strip>,
    factor: usize,
}

/// A rod that was fitted.
struct Located {
    fit: Fit,
    judgement: Judgement,
    prior: Option<Prior>,
}

/// Locates the rod.
///
/// # Errors
/// A malformed request. A rod that cannot be located is a refused [`Estimate`].
pub fn solve(request: &Request<'_>) -> Result<Estimate, SolveError> {
    request.validate()?;
    let start = Instant::now();
    let mut estimate = Estimate::refused("joint", String::new());
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
    let mut located: Option<(&Candidate, Located)> = None;
    for candidate in candidates.iter().take(TRIED) {
        let Some(found) = fitted(request, lights, candidate) else {
            continue;
        };
        // Edges within a rod are likely too; pixels are as a rod has them only where one is.
        let worth = |candidate: &Candidate, found: &Located| {
            let sums = &found.fit.sums;
            let misfit = (sums.chi2 / sums.pixels).max(1.0);
            (found.fit.converged, candidate.score / misfit)
        };
        let is_better = |(other, before): &(&Candidate, Located)| {
            worth(candidate, &found) > worth(other, before)
        };
        if located.as_ref().is_none_or(is_better) {
            located = Some((candidate, found));
        }
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
    estimate.timing_ms.locate = start.elapsed().as_secs_f64() * 1e3;
    give(request, estimate, &found)
}

/// Whether the one is seen where the other is, in both images.
fn is_same(a: &Candidate, b: &Candidate) -> bool {
    let mut pairs = a.strips.iter().zip(&b.strips);
    pairs.all(|(a, b)| a.holds(&b.middle_px) || b.holds(&a.middle_px))
}

/// Follows the limbs of a candidate and climbs to the likeliest rod.
fn fitted(
    request: &Request<'_>,
    lights: [&Light<'_>; 2],
    candidate: &Candidate,
) -> Option<Located> {
    let rig = &request.pair.rig;
    let mut strips = candidate.strips;
    for (k, strip) in strips.iter_mut().enumerate() {
        let axis = strip.edges[0].axis;
        let towards = strip.edges[0].normal.dot(&strip.edges[1].normal).signum();
        for (side, edge) in strip.edges.iter_mut().enumerate() {
            let polarity = if side == 0 { 1.0 } else { -towards };
            let traced = trace::trace(lights[k], edge, &axis, polarity, 14)
                .and_then(|t| trace::trace(lights[k], &t, &axis, polarity, 8));
            if let Some(traced) = traced {
                *edge = traced;
            }
        }
    }
    let known = request.radius.map(|prior| prior.radius_m);
    let (cylinder, _) = pair::cylinder(rig, lights, [&strips[0], &strips[1]], None)
        .or_else(|| pair::cylinder(rig, lights, [&strips[0], &strips[1]], known))?;
    let prior = request.radius.map(|prior| Prior {
        radius_m: prior.radius_m,
        sigma_m: prior.sigma_m.unwrap_or(1e-6).max(1e-6),
    });
    let mut state = State::new(cylinder, 0.1);
    let mut fit = None;
    let views = [
        contrast::view(0, &rig.left, lights[0], &cylinder)?,
        contrast::view(1, &rig.right, lights[1], &cylinder)?,
    ];
    // Again where the limbs turned out to be.
    for _ in 0..2 {
        let mut blocks = Vec::new();
        for (k, (view, light)) in views.iter().zip(lights).enumerate() {
            let (mounted, axes) = (&view.mounted, &view.axes);
            let inside_px = bands::INSIDE_PX;
            blocks.extend(bands::blocks(
                k,
                mounted,
                light,
                axes,
                &state.cylinder,
                inside_px,
            )?);
        }
        if blocks.len() < 4 {
            return None;
        }
        let floor = 1.0 / 255.0 / 12.0_f64.sqrt() * 0.3;
        let noise = [0, 1].map(|k| climb::noise_of(&blocks, k, floor));
        let found = climb::climb(state, &mut blocks, &noise, prior)?;
        state = found.state;
        fit = Some(found);
    }
    let fit = fit?;
    let judgement = judge::judge(&fit, prior)?;
    Some(Located {
        fit,
        judgement,
        prior,
    })
}
