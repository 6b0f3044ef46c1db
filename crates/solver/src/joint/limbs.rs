//! Which limbs are seen as limbs.

use super::block::Shades;
use super::climb::Fit;
use super::crossing::Middle;
use super::lamp::Lamp;
use super::pool::Block;

/// A limb that is not this much more likely than none is not seen.
const LEAST_EVIDENCE: f64 = 60.0;
/// Nor is one that is so much less plain than the plainest: models of light are not as good as that.
const LEAST_SHARE: f64 = 0.03;
/// So far inside a limb, px and in radii, light is looked at.
const INSIDE_PX: f64 = 4.0;
const INSIDE: f64 = 0.12;
/// Of light that rises ever faster inside a limb the step at it is at least this share.
const LEAST_STEP: f64 = 0.8;

/// Softer, a limb is not believed where no other would contradict it.
const MOST_SOFTNESS: f64 = 0.6;
/// Softer, it is little more than where light begins.
const FADED: f64 = 0.75;
/// On narrower rods no lamp before them ends far enough from a limb to be mistaken for it.
const FADED_RADIUS_PX: f64 = 8.0;

/// What a limb turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limb {
    Seen,
    /// Nothing steps there.
    Unseen,
    /// Light rises ever faster from there without a step: where a lamp's light ends on the rod, not where the rod ends.
    Soft,
}

/// A limb as it was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) limb: Limb,
    /// Share of the light inside it that rises only from there on: 0 of a plain step, 1 where nothing steps.
    pub(crate) softness: f64,
    /// Where it is; `None` where it is not looked at.
    pub(crate) middle: Option<Middle>,
}

impl Found {
    /// Whether it is seen, but as little more than where light begins.
    pub(crate) fn is_faded(&self) -> bool {
        let is_wide = self.middle.is_some_and(|m| m.radius_px > FADED_RADIUS_PX);
        self.limb == Limb::Seen && self.softness > FADED && is_wide && !self.is_explained()
    }

    /// Whether a lamp explains how light rises from it.
    pub(crate) fn is_explained(&self) -> bool {
        self.middle.is_some_and(|middle| middle.lamps[0].is_some())
    }

    /// What it is where no other limb would contradict it.
    pub(crate) fn alone(&self) -> Limb {
        if self.limb == Limb::Seen && self.softness > MOST_SOFTNESS && !self.is_explained() {
            Limb::Soft
        } else {
            self.limb
        }
    }
}

/// Of each eye its limbs plus and minus.
pub(crate) fn limbs(fit: &Fit, blocks: &[Block]) -> [[Found; 2]; 2] {
    let evidence = &fit.sums.evidence;
    let plainest = evidence.iter().flatten().copied().fold(0.0, f64::max);
    let least = LEAST_EVIDENCE.max(LEAST_SHARE * plainest);
    [0, 1].map(|eye| {
        [0, 1].map(|side| {
            let all = blocks.iter().zip(&fit.lit.shades);
            let mine = all.filter(|(block, _)| block.eye == eye && block.cuts[side].is_some());
            let shades: Vec<&Shades> = mine.map(|(_, shades)| shades).collect();
            let middle = Middle::of(&fit.state, blocks, eye, side);
            let radius_px = middle.map_or(1.0, |middle| middle.radius_px);
            let lamps = middle.map_or([None; 2], |middle| middle.lamps);
            let mut rise = Rise::of(&shades, side, radius_px, &lamps);
            if let Some(shadow) = fit.state.shadows[eye][side] {
                let mine = blocks.iter().filter(|block| block.eye == eye);
                let all: f64 = mine.map(|block| block.rise[side]).sum();
                rise.root += shadow.amount * all;
            }
            let limb = if shades.is_empty() || evidence[eye][side] < least {
                Limb::Unseen
            } else if rise.is_soft() && fit.state.lamps_rad[0].is_none() {
                Limb::Soft
            } else {
                Limb::Seen
            };
            Found {
                limb,
                softness: rise.softness(),
                middle,
            }
        })
    })
}

/// How light rises inside a limb.
struct Rise {
    step: f64,
    linear: f64,
    root: f64,
}

impl Rise {
    fn of(shades: &[&Shades], side: usize, radius_px: f64, lamps: &[Option<Lamp>; 2]) -> Self {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let inside = INSIDE.min(INSIDE_PX / radius_px);
        let mut all = Self {
            step: 0.0,
            linear: 0.0,
            root: 0.0,
        };
        for shades in shades {
            let [a0, a1, a2] = [0, 1, 2].map(|k| shades[3 * side + k]);
            all.step += a0 - shades[6 + 2 * side];
            if lamps[0].is_none() {
                all.step += sign * a1;
                all.linear -= sign * a1 * inside;
                all.root += a2 * (2.0 * inside).sqrt();
            }
            // A lamp's light steps at the limb if it is on that side.
            for (lamp, amount) in lamps.iter().flatten().zip([a2, a1]) {
                let (sin, cos) = libm::sincos(lamp.psi_rad);
                all.step += sin.max(0.0) * amount;
                all.root += cos.max(0.0) * amount * (2.0 * inside).sqrt();
            }
        }
        all
    }

    /// Lamps before a rod make light grow from its limbs with the root of the distance, or as the distance does; never the other way.
    fn is_soft(&self) -> bool {
        // Rods darker than what is behind them step the other way.
        let rise = self.root.abs() + self.linear.abs();
        self.root < 0.0 && self.step.abs() < LEAST_STEP * rise
    }

    fn softness(&self) -> f64 {
        let rise = (self.root + self.linear).abs();
        rise / (rise + self.step.abs()).max(f64::MIN_POSITIVE)
    }
}
