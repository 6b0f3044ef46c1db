//! From strips to the likeliest rod there.

use rodsight_geometry::{Side, Vec3};

use super::alike;
use super::bands::{INSIDE_PX, Window};
use super::block::Alike;
use super::climb::{self, Fit, Fits, Prior, Start};
use super::contrast::{self, View};
use super::crossing::moved_px;
use super::drift::Drift;
use super::judge::{self, Judgement};
use super::light::Light;
use super::limbs::{self, Found, Limb};
use super::pair::{self, Candidate};
use super::pool::{self, Block};
use super::shadow;
use super::shot::Shot;
use super::state::State;
use super::strip::Strip;
use super::{bands, by_lamps, trace};
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
/// Where limbs leave a rod unsure by more than this share of how far it is, they do not place it.
const MOST_UNPLACED: f64 = 0.1;
/// χ² of a pixel of what surely is a rod.
const SURE_MISFIT: f64 = 1.3;

/// A rod that was fitted.
pub(super) struct Located {
    pub(super) fit: Fits,
    pub(super) judgement: Judgement,
    pub(super) prior: Option<Prior>,
    /// Of each pair of each eye plus and minus.
    pub(super) limbs: Vec<[[Limb; 2]; 2]>,
    /// From how many of the limbs of each pair that are seen light rises softly.
    pub(super) faded: Vec<usize>,
    /// The pairs that show it at all.
    pub(super) shown: Vec<usize>,
}

impl Located {
    /// Whether a ray meets this rod before another; `None` where they are met together, or one is not.
    pub(super) fn is_nearer(&self, other: &Self, (from_m, along): &(Vec3, Vec3)) -> Option<bool> {
        let met_m = |located: &Self| {
            let tangent = located.fit.state().tangent_at(Some(&(*from_m, *along)));
            Some(tangent.cylinder.intersect(from_m, along)?.0)
        };
        let (mine_m, theirs_m) = (met_m(self)?, met_m(other)?);
        let radius_m = |located: &Self| located.fit.state().cylinder.radius_m;
        let apart_m = radius_m(self).min(radius_m(other));
        ((mine_m - theirs_m).abs() > apart_m).then_some(mine_m < theirs_m)
    }

    /// Whether each eye sees a limb of it.
    pub(super) fn is_seen_by_both(&self) -> bool {
        let mut eyes = self.limbs.iter().flatten();
        eyes.all(|eye| eye.contains(&Limb::Seen))
    }

    /// Whether it surely is a rod.
    pub(super) fn is_sure(&self) -> bool {
        let mut limbs = self.limbs.iter().flatten().flatten();
        let is_seen = limbs.all(|limb| *limb == Limb::Seen);
        self.fit.converged && is_seen && self.fit.misfit() < SURE_MISFIT
    }

    /// Whether all of it is as it should be.
    pub(super) fn is_fine(&self) -> bool {
        let mut limbs = self.limbs.iter().flatten().flatten();
        let is_seen = limbs.all(|limb| *limb == Limb::Seen);
        // What contradicts itself bends.
        let is_straight = self.fit.state().bend_per_m.is_none();
        let is_agreed = self.judgement.chi2 <= self.judgement.redundancies as f64;
        is_seen && is_straight && is_agreed && self.fit.converged
    }

    /// Whether a ray meets the rod, or passes it nearly.
    pub(super) fn is_met(&self, ray: &(Vec3, Vec3)) -> bool {
        let tangent = self.fit.state().tangent_at(Some(ray)).cylinder;
        let beyond_m = tangent.tangency_residual_m(&ray.0, &ray.1, Side::Plus);
        beyond_m.is_some_and(|beyond_m| {
            let gap_m = (beyond_m + tangent.radius_m).abs();
            gap_m < (1.0 + MOST_MISS_RADII) * tangent.radius_m
        })
    }
}

/// Follows the limbs of a candidate and climbs to the likeliest rod.
pub(super) fn refine(
    request: &Request<'_>,
    shots: &[Shot<'_>],
    candidate: &Candidate,
) -> Option<Located> {
    let strips = [Some(candidate.strips)]
        .into_iter()
        .chain(candidate.more.iter().copied());
    let pairs = shots.iter().zip(strips);
    let strips: Vec<_> = pairs
        .map(|(shot, strips)| Some(followed(shot.lights(), strips?)))
        .collect();
    let known = request.radius.map(|prior| prior.radius_m);
    let free = pair::cylinder(shots, &strips, None);
    let is_free = free.is_some();
    let (cylinder, _) = free.or_else(|| pair::cylinder(shots, &strips, known))?;
    let prior = request.radius.map(|prior| Prior {
        radius_m: prior.radius_m,
        sigma_m: prior.sigma_m.unwrap_or(1e-6).max(1e-6),
    });
    let state = State::new(cylinder, 0.1);
    let (mut shown, mut pixels, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
    for (pair, shot) in shots.iter().enumerate() {
        if let Some((of_pair, around)) = Pixels::of(shot, &state) {
            shown.push(pair);
            pixels.push(of_pair);
            blocks.push(around);
        }
    }
    // What another pair does not show, the first may.
    if shown.first() != Some(&0) {
        return None;
    }
    let look = |states: &[State]| -> Option<Vec<Vec<Block>>> {
        let all = pixels.iter().zip(states);
        all.map(|(pixels, state)| pixels.blocks(state)).collect()
    };
    let states = |fit: &Fits| -> Vec<State> { fit.pairs.iter().map(|fit| fit.state).collect() };
    let mut starts: Vec<Start> = pixels
        .iter()
        .map(|pixels| Start {
            state,
            lit: None,
            alike: Alike::default(),
            drift: pixels.drift,
        })
        .collect();
    let free_prior = prior.filter(|_| !is_free);
    let mut fit = climb::climb(&starts, free_prior, &mut blocks, ROUGH_GAIN)?;
    // What the limbs show without the radius that was given: it might be wrong, and pull the limbs to where none is.
    let seen_radius = prior.filter(|_| is_free).and_then(|_| {
        let found = found(&fit, &blocks);
        judge::judge(&fit, &found, None, request.calibration.as_ref())?.seen_radius
    });
    let far_px = blocks.iter().zip(&fit.pairs);
    let mut far_px = far_px.map(|(blocks, fit)| moved_px(blocks, &state, &fit.state));
    let is_far = far_px.any(|far_px| far_px > MOVED_PX);
    for ((start, fit), blocks) in starts.iter_mut().zip(&mut fit.pairs).zip(&blocks) {
        let (alike, lit) = alike::alike(fit, blocks);
        fit.state.shadows = shadow::shadows(fit, blocks);
        (start.alike, start.lit) = (alike, Some(lit));
    }
    let bend = (fit.bend_gain() > BEND_GAIN).then(Vec3::zeros);
    for (start, fit) in starts.iter_mut().zip(&mut fit.pairs) {
        fit.state.bend_per_m = bend;
        start.take(fit);
    }
    if is_far {
        blocks = look(&states(&fit))?;
        for start in &mut starts {
            start.lit = None;
        }
    }
    fit = climb::climb(&starts, prior, &mut blocks, climb::GAIN)?;
    if fit.state().bend_per_m.is_some() {
        // Its ends come into view once the bend is known.
        blocks = look(&states(&fit))?;
        for (start, fit) in starts.iter_mut().zip(&fit.pairs) {
            start.take(fit);
            start.lit = None;
        }
        fit = climb::climb(&starts, prior, &mut blocks, climb::GAIN)?;
    }
    let mut found = found(&fit, &blocks);
    let of_pairs = pixels.iter().zip(&fit.pairs).zip(&found);
    // Light is not to tell what limbs do not.
    let lit: Vec<_> = of_pairs
        .filter(|_| is_placed(&fit, &found, prior))
        .map(|((pixels, fit), limbs)| pixels.by_lamps((fit, limbs), free_prior))
        .collect();
    if let Some(rod) = lit.iter().flatten().next().map(|(start, _)| start.state) {
        for (pair, lit) in lit.into_iter().enumerate() {
            if let Some((start, around)) = lit {
                (starts[pair], blocks[pair]) = (start, around);
            } else {
                starts[pair].take(&fit.pairs[pair]);
                starts[pair].lit = Some(fit.pairs[pair].lit.clone());
            }
            starts[pair].state.take_rod(&rod);
        }
        fit = climb::climb(&starts, prior, &mut blocks, climb::GAIN)?;
        found = self::found(&fit, &blocks);
    }
    let limbs_of = |found: &[[[Found; 2]; 2]]| -> Vec<[[Limb; 2]; 2]> {
        let limbs = found.iter();
        limbs
            .map(|eyes| eyes.map(|eye| eye.map(|found| found.limb)))
            .collect()
    };
    let mut limbs = limbs_of(&found);
    let is_lost = limbs
        .iter()
        .flatten()
        .flatten()
        .any(|limb| *limb != Limb::Seen);
    if is_lost && is_enough(&limbs, prior.is_some()) {
        for (blocks, limbs) in blocks.iter_mut().zip(&limbs) {
            for block in blocks {
                for side in (0..2).filter(|side| limbs[block.eye][*side] != Limb::Seen) {
                    block.cuts[side] = None;
                }
            }
        }
        for (start, fit) in starts.iter_mut().zip(fit.pairs) {
            start.take(&fit);
            start.lit = Some(fit.lit);
        }
        fit = climb::climb(&starts, prior, &mut blocks, climb::GAIN)?;
        // Without the others nothing checks those that are left but how they look.
        found = self::found(&fit, &blocks);
        let limbs = limbs.iter_mut().flatten().flatten();
        for (limb, found) in limbs.zip(found.iter().flatten().flatten()) {
            if *limb == Limb::Seen {
                *limb = found.alone();
            }
        }
    }
    let mut judgement = judge::judge(&fit, &found, prior, request.calibration.as_ref())?;
    judgement.seen_radius = seen_radius.or(judgement.seen_radius);
    let faded = |eyes: &[[Found; 2]; 2]| {
        let limbs = eyes.iter().flatten();
        limbs.filter(|found| found.is_faded()).count()
    };
    let mut of_all = vec![[[Limb::Unseen; 2]; 2]; shots.len()];
    for (pair, limbs) in shown.iter().zip(limbs) {
        of_all[*pair] = limbs;
    }
    Some(Located {
        faded: found.iter().map(faded).collect(),
        shown,
        fit,
        judgement,
        prior,
        limbs: of_all,
    })
}

/// Whether limbs tell where a rod is, to some share of how far it is, and it is straight: around a bent one lamps turn.
fn is_placed(fit: &Fits, found: &[[[Found; 2]; 2]], prior: Option<Prior>) -> bool {
    let rod = fit.state();
    let far_m = rod.cylinder.axis.point_m.norm();
    rod.bend_per_m.is_none()
        && judge::judge(fit, found, prior, None).is_some_and(|judgement| {
            let shifts = judgement.covariance.fixed_view::<2, 2>(0, 0);
            shifts.trace() < (MOST_UNPLACED * far_m).powi(2)
        })
}

/// The limbs of each pair.
fn found(fit: &Fits, blocks: &[Vec<Block>]) -> Vec<[[Found; 2]; 2]> {
    let pairs = fit.pairs.iter().zip(blocks);
    pairs
        .map(|(fit, blocks)| limbs::limbs(fit, blocks))
        .collect()
}

/// Strips with their edges followed through the pixels.
fn followed(lights: [&Light<'_>; 2], mut strips: [Strip; 2]) -> [Strip; 2] {
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

/// How the images of a pair are looked at.
struct Pixels<'a> {
    lights: [&'a Light<'a>; 2],
    views: [View; 2],
    /// How far inside a limb.
    inside_px: f64,
    drift: Option<Drift>,
}

impl<'a> Pixels<'a> {
    /// Of images that show a rod, and the pixels around its limbs.
    fn of(shot: &'a Shot<'_>, rod: &State) -> Option<(Self, Vec<Block>)> {
        let lights = shot.lights();
        let pixels = Self {
            lights,
            views: [
                contrast::view(&shot.rig.left, lights[0], rod)?,
                contrast::view(&shot.rig.right, lights[1], rod)?,
            ],
            inside_px: INSIDE_PX,
            drift: shot.drift,
        };
        let blocks = pixels.blocks(rod)?;
        Some((pixels, blocks))
    }

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

    /// As if one lamp or two lit the rod, near a fit to light of any kind; `None` where that is not suspected or much less likely.
    fn by_lamps(
        &self,
        (free, found): (&Fit, &[[Found; 2]; 2]),
        prior: Option<Prior>,
    ) -> Option<(Start, Vec<Block>)> {
        if !by_lamps::are_suspected(found) {
            return None;
        }
        // Both limbs of an eye in the same colours: they have the same paint.
        let mut views = self.views;
        for (view, evidence) in views.iter_mut().zip(&free.sums.evidence) {
            let plainest = usize::from(evidence[1] > evidence[0]);
            view.axes = [view.axes[plainest]; 2];
        }
        let pixels = Pixels {
            views,
            inside_px: by_lamps::inside_px(found),
            ..*self
        };
        let known = (prior, pixels.inside_px);
        let mut start = Start {
            state: by_lamps::by_lamps(&free.state, known, |state, step, inside_px| {
                let pixels = Pixels {
                    inside_px,
                    ..pixels
                };
                pixels.some_blocks(state, step)
            })?,
            lit: None,
            alike: Alike::default(),
            drift: self.drift,
        };
        let mut blocks = [pixels.blocks(&start.state)?];
        let fit = climb::climb(&[start.clone()], prior, &mut blocks, ROUGH_GAIN)?;
        let fit = fit.pairs.first()?;
        start.take(fit);
        let (mut alike, lit) = alike::alike(fit, &blocks[0]);
        alike.means = by_lamps::of_means(&lit);
        (start.alike, start.lit) = (alike, Some(lit));
        let [blocks] = blocks;
        Some((start, blocks))
    }
}

/// Whether limbs place a rod: three of a pair, or one in each of its eyes and the radius. The first pair is to see it with both eyes:
/// what others see might be another one.
pub(super) fn is_enough(limbs: &[[[Limb; 2]; 2]], is_radius_known: bool) -> bool {
    let least = if is_radius_known { 2 } else { 3 };
    let seen = |eyes: &[[Limb; 2]; 2]| {
        eyes.map(|eye| eye.iter().filter(|limb| **limb == Limb::Seen).count())
    };
    let are_of_both = |eyes: &[[Limb; 2]; 2], least: usize| {
        let seen = seen(eyes);
        seen[0] > 0 && seen[1] > 0 && seen[0] + seen[1] >= least
    };
    let is_first = limbs.first().is_some_and(|eyes| are_of_both(eyes, 2));
    is_first && limbs.iter().any(|eyes| are_of_both(eyes, least))
}
