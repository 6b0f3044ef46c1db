//! From two strips to the likeliest rod there.

use rodsight_geometry::{Side, Vec3};

use super::alike;
use super::bands::{INSIDE_PX, Window};
use super::block::Alike;
use super::climb::{self, Fit, Prior, Start};
use super::contrast::{self, View};
use super::crossing::moved_px;
use super::judge::{self, Judgement};
use super::light::Light;
use super::limbs::{self, Found, Limb};
use super::pair::{self, Candidate};
use super::pool::{self, Block};
use super::shadow;
use super::state::State;
use super::strip::Strip;
use super::{bands, lamp, trace};
use crate::Request;

/// A rod is bent if that makes the pixels so much likelier.
const BEND_GAIN: f64 = 12.0;
/// To come near, a step that gains less likelihood is not worth taking.
const ROUGH_GAIN: f64 = 4.0;
/// Fewer blocks show no rod.
const LEAST_BLOCKS: usize = 4;
/// Limbs that moved farther than this, px, are looked at again where they turned out to be.
const MOVED_PX: f64 = 0.5;
/// A pick may miss the rod by so many radii.
pub(super) const MOST_MISS_RADII: f64 = 0.2;
/// χ² of a pixel of what surely is a rod.
const SURE_MISFIT: f64 = 1.3;

/// A rod that was fitted.
pub(super) struct Located {
    pub(super) fit: Fit,
    pub(super) judgement: Judgement,
    pub(super) prior: Option<Prior>,
    /// Of each eye plus and minus.
    pub(super) limbs: [[Limb; 2]; 2],
    /// From how many of the limbs that are seen light rises softly.
    pub(super) faded: usize,
}

impl Located {
    /// Whether a ray meets this rod before another; `None` where they are met together, or one is not.
    pub(super) fn is_nearer(&self, other: &Self, (from_m, along): &(Vec3, Vec3)) -> Option<bool> {
        let met_m = |located: &Self| {
            let tangent = located.fit.state.tangent_at(Some(&(*from_m, *along)));
            Some(tangent.cylinder.intersect(from_m, along)?.0)
        };
        let (mine_m, theirs_m) = (met_m(self)?, met_m(other)?);
        let radius_m = |located: &Self| located.fit.state.cylinder.radius_m;
        let apart_m = radius_m(self).min(radius_m(other));
        ((mine_m - theirs_m).abs() > apart_m).then_some(mine_m < theirs_m)
    }

    /// Whether each eye sees a limb of it.
    pub(super) fn is_seen_by_both(&self) -> bool {
        self.limbs.iter().all(|eye| eye.contains(&Limb::Seen))
    }

    /// Whether it surely is a rod.
    pub(super) fn is_sure(&self) -> bool {
        let limbs = self.limbs.iter().flatten();
        let seen = limbs.filter(|limb| **limb == Limb::Seen).count();
        self.fit.converged && seen == 4 && self.misfit() < SURE_MISFIT
    }

    /// Whether a ray meets the rod, or passes it nearly.
    pub(super) fn is_met(&self, ray: &(Vec3, Vec3)) -> bool {
        let tangent = self.fit.state.tangent_at(Some(ray)).cylinder;
        let beyond_m = tangent.tangency_residual_m(&ray.0, &ray.1, Side::Plus);
        beyond_m.is_some_and(|beyond_m| {
            let gap_m = (beyond_m + tangent.radius_m).abs();
            gap_m < (1.0 + MOST_MISS_RADII) * tangent.radius_m
        })
    }

    /// χ² of a pixel.
    pub(super) fn misfit(&self) -> f64 {
        self.fit.sums.chi2 / self.fit.sums.pixels
    }
}

/// Follows the limbs of a candidate and climbs to the likeliest rod.
pub(super) fn refine(
    request: &Request<'_>,
    lights: [&Light<'_>; 2],
    candidate: &Candidate,
) -> Option<Located> {
    let rig = &request.pair.rig;
    let strips = followed(lights, candidate);
    let known = request.radius.map(|prior| prior.radius_m);
    let free = pair::cylinder(rig, lights, [&strips[0], &strips[1]], None);
    let is_free = free.is_some();
    let (cylinder, _) =
        free.or_else(|| pair::cylinder(rig, lights, [&strips[0], &strips[1]], known))?;
    let prior = request.radius.map(|prior| Prior {
        radius_m: prior.radius_m,
        sigma_m: prior.sigma_m.unwrap_or(1e-6).max(1e-6),
    });
    let state = State::new(cylinder, 0.1);
    let views = [
        contrast::view(&rig.left, lights[0], &state)?,
        contrast::view(&rig.right, lights[1], &state)?,
    ];
    let pixels = Pixels {
        lights,
        views,
        inside_px: INSIDE_PX,
    };
    let mut blocks = pixels.blocks(&state)?;
    let mut start = Start {
        state,
        lit: None,
        alike: Alike::default(),
        prior: prior.filter(|_| !is_free),
    };
    let mut fit = climb::climb(&start, &mut blocks, ROUGH_GAIN)?;
    // What the limbs show without the radius that was given: it might be wrong, and pull the limbs to where none is.
    let seen_radius = prior.filter(|_| is_free).and_then(|_| {
        let found = limbs::limbs(&fit, &blocks);
        judge::judge(&fit, &found, None, request.calibration.as_ref())?.seen_radius
    });
    let is_far = moved_px(&blocks, &state, &fit.state) > MOVED_PX;
    let (alike, lit) = alike::alike(&fit, &blocks);
    (start.alike, start.prior) = (alike, prior);
    fit.state.shadows = shadow::shadows(&fit, &blocks);
    fit.state.bend_per_m = (fit.bend_gain() > BEND_GAIN).then(Vec3::zeros);
    (start.state, start.lit) = (fit.state, Some(lit));
    if is_far {
        (blocks, start.lit) = (pixels.blocks(&fit.state)?, None);
    }
    fit = climb::climb(&start, &mut blocks, climb::GAIN)?;
    if fit.state.bend_per_m.is_some() {
        // Its ends come into view once the bend is known.
        blocks = pixels.blocks(&fit.state)?;
        (start.state, start.lit) = (fit.state, None);
        fit = climb::climb(&start, &mut blocks, climb::GAIN)?;
    }
    let mut found = limbs::limbs(&fit, &blocks);
    if lamp::are_suspected(&fit, &found)
        && let Some(lit) = pixels.by_lamps((&fit, &found), [prior.filter(|_| !is_free), prior])
    {
        (start, fit, blocks) = lit;
        found = limbs::limbs(&fit, &blocks);
    }
    let mut limbs = found.map(|eye| eye.map(|found| found.limb));
    let is_lost = limbs.iter().flatten().any(|limb| *limb != Limb::Seen);
    if is_lost && is_enough(limbs, prior.is_some()) {
        for block in &mut blocks {
            for side in (0..2).filter(|side| limbs[block.eye][*side] != Limb::Seen) {
                block.cuts[side] = None;
            }
        }
        (start.state, start.lit) = (fit.state, Some(fit.lit));
        fit = climb::climb(&start, &mut blocks, climb::GAIN)?;
        // Without the others nothing checks those that are left but how they look.
        found = limbs::limbs(&fit, &blocks);
        for (limb, found) in limbs.iter_mut().flatten().zip(found.iter().flatten()) {
            if *limb == Limb::Seen {
                *limb = found.alone();
            }
        }
    }
    let mut judgement = judge::judge(&fit, &found, prior, request.calibration.as_ref())?;
    judgement.seen_radius = seen_radius.or(judgement.seen_radius);
    let faded = found.iter().flatten().filter(|found| found.is_faded());
    Some(Located {
        faded: faded.count(),
        fit,
        judgement,
        prior,
        limbs,
    })
}

/// The strips of a candidate, their edges followed through the pixels.
fn followed(lights: [&Light<'_>; 2], candidate: &Candidate) -> [Strip; 2] {
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
    strips
}

/// How both images are looked at.
struct Pixels<'a> {
    lights: [&'a Light<'a>; 2],
    views: [View; 2],
    /// How far inside a limb.
    inside_px: f64,
}

impl Pixels<'_> {
    /// The pixels around the limbs of a rod.
    fn blocks(&self, rod: &State) -> Option<Vec<Block>> {
        self.some_blocks(rod, 1)
    }

    /// Of every so many-th block.
    fn some_blocks(&self, rod: &State, block_step: usize) -> Option<Vec<Block>> {
        let mut blocks = Vec::new();
        for (eye, (view, light)) in self.views.iter().zip(self.lights).enumerate() {
            let (mounted, axes) = (&view.mounted, &view.axes);
            let window = Window {
                inside_px: self.inside_px,
                blur_px2: rod.blur_px2[eye],
                row_step: 1,
                block_step,
            };
            let stretches = bands::stretches(mounted, light, axes, rod, &window)?;
            blocks.extend(pool::blocks(eye, &stretches));
        }
        (blocks.len() >= LEAST_BLOCKS).then_some(blocks)
    }

    /// As if one lamp or two lit the rod, near a fit to light of any kind; `None` where that is much less likely. What is known of the radius
    /// is given as of coming near, and of the end.
    fn by_lamps(
        &self,
        (free, found): (&Fit, &[[Found; 2]; 2]),
        [rough, prior]: [Option<Prior>; 2],
    ) -> Option<(Start, Fit, Vec<Block>)> {
        // Both limbs of an eye in the same colours: they have the same paint.
        let mut views = self.views;
        for (view, evidence) in views.iter_mut().zip(&free.sums.evidence) {
            let plainest = usize::from(evidence[1] > evidence[0]);
            view.axes = [view.axes[plainest]; 2];
        }
        let pixels = Pixels {
            views,
            inside_px: lamp::inside_px(found),
            ..*self
        };
        let mut start = Start {
            state: lamp::by_lamps(free, rough, |state, step| pixels.some_blocks(state, step))?,
            lit: None,
            alike: Alike::default(),
            prior: rough,
        };
        let mut blocks = pixels.blocks(&start.state)?;
        let fit = climb::climb(&start, &mut blocks, ROUGH_GAIN)?;
        let (mut alike, lit) = alike::alike(&fit, &blocks);
        alike.means = lamp::of_means(&lit);
        start = Start {
            state: fit.state,
            lit: Some(lit),
            alike,
            prior,
        };
        let fit = climb::climb(&start, &mut blocks, climb::GAIN)?;
        Some((start, fit, blocks))
    }
}

/// Whether limbs place a rod: three of them, or one in each eye and its radius.
pub(super) fn is_enough(limbs: [[Limb; 2]; 2], is_radius_known: bool) -> bool {
    let seen = limbs.map(|eye| eye.iter().filter(|limb| **limb == Limb::Seen).count());
    let least = if is_radius_known { 2 } else { 3 };
    seen[0] > 0 && seen[1] > 0 && seen[0] + seen[1] >= least
}
