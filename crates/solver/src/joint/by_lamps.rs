//! The search for one lamp or two whose light on a rod makes all its limbs likely.

use nalgebra::{SMatrix, SVector};
use rodsight_geometry::Vec3;

use super::bands::INSIDE_PX;
use super::block::{Alike, Lit, Shading};
use super::climb::{self, Prior, Start};
use super::crossing::Crossing;
use super::lamp::{Lamp, back};
use super::limbs::{self, Found, Limb};
use super::pool::Block;
use super::state::{State, UNKNOWNS};

/// Where one lamp and two may be from the view, around the axis, as a climb begins, rad.
const ONE_RAD: [[Option<f64>; 2]; 6] = [
    [Some(-1.2), None],
    [Some(-0.6), None],
    [Some(-0.2), None],
    [Some(0.2), None],
    [Some(0.6), None],
    [Some(1.2), None],
];
const TWO_RAD: [[Option<f64>; 2]; 6] = [
    [Some(-1.0), Some(1.0)],
    [Some(-0.6), Some(0.6)],
    [Some(-0.3), Some(0.9)],
    [Some(-0.9), Some(0.3)],
    [Some(-1.2), Some(0.6)],
    [Some(-0.6), Some(1.2)],
];
/// Of the radius so much is looked at, and no more px.
const INSIDE: f64 = 0.5;
const MOST_INSIDE_PX: f64 = 25.0;
/// What is nearer to a limb, px, is reached from it.
const LEAST_FARTHER_PX: f64 = 2.0;
/// Of narrower rods one limb's light is the other's.
const LEAST_RADIUS_PX: f64 = 4.0;
/// Softer limbs are suspect.
const LEAST_SOFTNESS: f64 = 0.6;
/// A climb that gains less likelihood is done.
const ENOUGH: f64 = 0.5;
/// As climbs from several beginnings are compared.
const ROUGH: f64 = 10.0;
/// Lamps farther from the view are behind the rod.
const MOST_ASIDE_RAD: f64 = 1.9;
/// The search looks at every so many-th block.
const SOME: usize = 4;
/// Of a sample of a model that is right, about.
const USUAL_COST: f64 = 0.45;
/// A second lamp has one unknown more in each block, of 70 samples or so: it has to be the likelier for it (Akaike 1974).
const WORSE: f64 = 0.014;
/// Where neither one lamp nor two explain the pixels, two do by being more: they have to cost so many times as much as one, no more.
const USUAL_DEEP_COST: f64 = 0.6;
const TIMES_TWO: f64 = 0.75;
/// Free light has three or four more: lamps may cost so many times as much.
const MOST_TIMES: f64 = 1.07;
/// And free light does not explain limbs that it does not see.
const MOST_TIMES_SEEN: f64 = 1.35;
/// Deep inside no light is exact, but it ought to be if it is no better than free light nearer by.
const MOST_TIMES_DEEP: f64 = 1.9;
/// Two lamps that are nearer to each other are something else that is not understood.
const LEAST_APART_RAD: f64 = 0.45;
/// By so much of a lamp's light the limbs of an eye may differ in light from everywhere and in that of the lamp, as standard deviations.
const UNLIKE_AROUND: f64 = 0.03;
const UNLIKE_LAMP: f64 = 0.05;
/// A block by itself may differ by more.
const UNLIKE_EACH: f64 = 0.1;

/// Whether lamps may tell more than free light does: light rises softly from a limb, or a limb is not seen.
pub(crate) fn are_suspected(found: &[[Found; 2]; 2]) -> bool {
    let limbs = || found.iter().flatten();
    let radii_px = limbs().filter_map(|found| Some(found.middle?.radius_px));
    let narrowest_px = radii_px.fold(f64::INFINITY, f64::min);
    let is_odd = |found: &Found| found.limb != Limb::Seen || found.softness > LEAST_SOFTNESS;
    narrowest_px > LEAST_RADIUS_PX && limbs().any(is_odd)
}

/// How far inside limbs the light of lamps is looked at, px.
pub(crate) fn inside_px(found: &[[Found; 2]; 2]) -> f64 {
    let limbs = found.iter().flatten();
    let radii_px = limbs.filter_map(|found| Some(found.middle?.radius_px));
    let least_px = radii_px.fold(f64::INFINITY, f64::min);
    (INSIDE * least_px).clamp(INSIDE_PX, MOST_INSIDE_PX)
}

/// The likeliest rod in the light of one lamp or two, near one that was fitted to light of any kind; `None` where it is much less likely.
/// `gather` finds the pixels around a rod: of every so many-th block, so many px inside its limbs.
pub(crate) fn by_lamps(
    rod: &State,
    (prior, deep_px): (Option<Prior>, f64),
    gather: impl Fn(&State, usize, f64) -> Option<Vec<Block>>,
) -> Option<State> {
    let blocks = gather(rod, SOME, deep_px)?;
    let search = Search {
        each: [0, 1].map(|eye| of_both_limbs(brightness(&blocks, eye), [UNLIKE_EACH; 2])),
        rod,
        prior,
        deep_px,
        blocks,
        gather,
    };
    let (one, two) = (search.likeliest(&ONE_RAD), search.likeliest(&TWO_RAD));
    let deep = match (one, two) {
        (Some(one), Some(two)) => {
            let explains = two.cost < USUAL_DEEP_COST || two.cost < TIMES_TWO * one.cost;
            let is_two = explains && two.cost + WORSE < one.cost;
            if is_two { two } else { one }
        }
        (one, two) => one.or(two)?,
    };
    search.is_believed(&deep)?.then_some(deep.state)
}

/// A rod in some light, what a sample costs there, and how many limbs each eye sees.
#[derive(Clone, Copy)]
struct Tried {
    state: State,
    cost: f64,
    seen: [usize; 2],
}

/// A search near a rod.
struct Search<'a, G> {
    rod: &'a State,
    prior: Option<Prior>,
    /// How far inside limbs it looks.
    deep_px: f64,
    /// Around the rod.
    blocks: Vec<Block>,
    /// What is known of the shading of lamps.
    each: [Shading; 2],
    gather: G,
}

impl<G: Fn(&State, usize, f64) -> Option<Vec<Block>>> Search<'_, G> {
    /// The likeliest of several beginnings.
    fn likeliest(&self, beginnings_rad: &[[Option<f64>; 2]]) -> Option<Tried> {
        let axis = &self.rod.cylinder.axis;
        let cuts = self
            .blocks
            .iter()
            .flat_map(|block| block.cuts.iter().flatten());
        let view: Vec3 = cuts.map(|cut| back(&axis.direction, &cut.rays[1])).sum();
        let [first, second] = self.rod.across;
        let view_rad = libm::atan2(view.dot(&second), view.dot(&first));
        let rough = |off_rad: &[Option<f64>; 2]| {
            let state = State {
                shadows: [[None; 2]; 2],
                lamps_rad: off_rad.map(|off_rad| Some(view_rad + off_rad?)),
                ..*self.rod
            };
            let farther = off_rad[1]
                .is_none()
                .then(|| out_of_shadow(&state, &self.blocks))
                .flatten();
            let here = self.climbed(self.blocks.clone(), &state, ROUGH);
            let farther = farther.and_then(|state| self.tried(&state, SOME, self.deep_px, ROUGH));
            [here, farther].into_iter().flatten()
        };
        let best = beginnings_rad
            .iter()
            .flat_map(rough)
            .filter(|tried| self.is_before(&tried.state) && are_enough(&tried.seen))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        self.tried(&best.state, 1, self.deep_px, ENOUGH)
    }

    /// Whether lamps make the pixels about as likely as free light does, by the pixels that free light is looked at.
    fn is_believed(&self, deep: &Tried) -> Option<bool> {
        let free = self.tried(self.rod, 1, INSIDE_PX, ENOUGH)?;
        let near = self.tried(&deep.state, 1, INSIDE_PX, ENOUGH)?;
        let sees_more = near.seen.iter().sum::<usize>() > free.seen.iter().sum();
        let most = if sees_more {
            MOST_TIMES_SEEN
        } else {
            MOST_TIMES
        };
        let as_free = free.cost.max(USUAL_COST);
        let is_deep = deep.cost < MOST_TIMES_DEEP * as_free || near.cost < free.cost;
        // Beside a rod all fits as well: there is nothing to explain.
        let is_rod = are_enough(&near.seen) && self.is_before(&deep.state);
        Some(is_rod && is_deep && near.cost < most * as_free && are_apart(&deep.state.lamps_rad))
    }

    /// Climbs from a state, among the pixels around it.
    fn tried(&self, state: &State, step: usize, inside_px: f64, enough: f64) -> Option<Tried> {
        self.climbed((self.gather)(state, step, inside_px)?, state, enough)
    }

    fn climbed(&self, around: Vec<Block>, state: &State, enough: f64) -> Option<Tried> {
        let is_free = state.lamps_rad[0].is_none();
        let alike = Alike {
            each: if is_free {
                Default::default()
            } else {
                self.each
            },
            ..Alike::default()
        };
        let start = Start {
            state: *state,
            lit: None,
            alike,
            drift: None,
        };
        let mut blocks = [around];
        let fits = climb::climb(&[start], self.prior, &mut blocks, enough)?;
        let fit = fits.pairs.first()?;
        let seen = limbs::limbs(fit, &blocks[0]);
        Some(Tried {
            state: fit.state,
            cost: fit.sums.cost / fits.samples as f64,
            seen: seen.map(|eye| eye.iter().filter(|found| found.limb == Limb::Seen).count()),
        })
    }

    /// Whether no lamp is behind the rod.
    fn is_before(&self, state: &State) -> bool {
        let cuts = self
            .blocks
            .iter()
            .flat_map(|block| block.cuts.iter().flatten());
        let mut lamps = cuts.flat_map(|cut| Lamp::of(state, &cut.rays[1], 1.0));
        lamps.all(|lamp| lamp.is_none_or(|lamp| lamp.psi_rad.abs() < MOST_ASIDE_RAD))
    }
}

/// Whether limbs seen by each eye place a rod.
fn are_enough(seen: &[usize; 2]) -> bool {
    !seen.contains(&0) && seen.iter().sum::<usize>() >= 3
}

/// Whether two lamps are not one that is seen badly.
fn are_apart(lamps_rad: &[Option<f64>; 2]) -> bool {
    let [Some(first), Some(second)] = lamps_rad else {
        return true;
    };
    libm::cos(first - second) < libm::cos(LEAST_APART_RAD)
}

/// A rod whose limbs lie as much farther out as a lamp's light ends before them: what was taken for limbs may be where that is.
fn out_of_shadow(state: &State, blocks: &[Block]) -> Option<State> {
    let mut normal = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    let mut is_dark = false;
    for block in blocks {
        for (side, cut) in block.cuts.iter().enumerate() {
            let Some(cut) = cut else { continue };
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let crossing = Crossing::new(state, cut);
            let [s0, s1, s2, s3, ..] = crossing.slopes.map(|slope| -sign * slope / crossing.per_px);
            let by_rod = SVector::<f64, 5>::new(s0, s1, s2, s3, 1.0 / crossing.per_px);
            let psi_rad = Lamp::of(state, &cut.rays[1], sign)[0]?.psi_rad;
            let radius_px = state.cylinder.radius_m / crossing.per_px;
            let farther_px = if psi_rad < 0.0 {
                radius_px * (1.0 - libm::cos(psi_rad))
            } else {
                0.0
            };
            is_dark |= farther_px > LEAST_FARTHER_PX;
            normal += by_rod * by_rod.transpose();
            right += by_rod * farther_px;
        }
    }
    let scale = normal
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = normal.component_mul(&(scale * scale.transpose()));
    let step = scaled
        .cholesky()?
        .solve(&right.component_mul(&scale))
        .component_mul(&scale);
    let mut by = SVector::<f64, UNKNOWNS>::zeros();
    by.fixed_rows_mut::<5>(0).copy_from(&step);
    is_dark.then(|| state.moved(&by))
}

/// How much brighter, or darker, an eye's rod is than what is beside it.
fn brightness(blocks: &[Block], eye: usize) -> f64 {
    let cuts = blocks.iter().filter(|block| block.eye == eye);
    let steps: Vec<f64> = cuts
        .flat_map(|block| block.cuts.iter().flatten())
        .filter_map(|cut| Some((cut.samples.last()?.value - cut.samples.first()?.value).abs()))
        .collect();
    steps.iter().sum::<f64>() / steps.len().max(1) as f64
}

/// Of the mean shading of an eye in the light of lamps.
pub(crate) fn of_means(lit: &Lit) -> [Shading; 2] {
    lit.means.map(|[mean, _]| {
        let lamps = [1, 2, 4, 5].map(|k: usize| mean[k].abs());
        of_both_limbs(
            0.5 * lamps.iter().sum::<f64>(),
            [UNLIKE_AROUND, UNLIKE_LAMP],
        )
    })
}

/// One over the covariance of shading whose limbs have the same paint, light from everywhere and from lamps, or nearly so: off by shares
/// of a brightness.
fn of_both_limbs(brightness: f64, [around, lamp]: [f64; 2]) -> Shading {
    let mut known = Shading::zeros();
    for (plus, share) in [(0, around), (1, lamp), (2, lamp)] {
        let minus = 3 + plus;
        let weight = 1.0 / (share * brightness).powi(2).max(f64::MIN_POSITIVE);
        known[(plus, plus)] += weight;
        known[(minus, minus)] += weight;
        known[(plus, minus)] -= weight;
        known[(minus, plus)] -= weight;
    }
    known
}
