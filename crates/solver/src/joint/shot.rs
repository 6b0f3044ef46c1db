//! A pair of images as they are looked at.

use rodsight_geometry::{Eye, Pixel, Rig};

use super::drift::Drift;
use super::light::Light;
use super::refusal::Refusal;
use super::strip::{self, Strip};
use super::sums;
use crate::{MovedPair, Request};

/// Edges of an image that are paired.
const EDGES: usize = 48;
/// Strips of an image that are paired with the other's.
const STRIPS: usize = 12;
/// How many pixels, and how many a side, a region has at most as it is searched. Where nothing was found it is searched again: coarser
/// for what is faint, finer for what texture hides.
const COARSE: [(usize, usize); 3] = [(1 << 15, 256), (1 << 13, 128), (1 << 17, 512)];

/// What was seen in one image.
pub(crate) struct Seen<'a> {
    pub(crate) light: Light<'a>,
    pub(crate) strips: Vec<Strip>,
    pub(crate) factor: usize,
}

/// A pair of images and what was seen in them.
pub(crate) struct Shot<'a> {
    /// Where the cameras were, in the first pair's frame.
    pub(crate) rig: Rig,
    /// By how much they may be elsewhere.
    pub(crate) drift: Option<Drift>,
    pub(crate) seen: [Seen<'a>; 2],
}

impl<'a> Shot<'a> {
    /// The pair that was asked about; it must show something.
    pub(crate) fn first(request: &Request<'a>) -> Result<Self, Refusal> {
        let see = |eye: Eye| {
            let seen = see(request, eye);
            if !seen.strips.is_empty() {
                Ok(seen)
            } else if request.pick.is_some_and(|pick| pick.eye == eye) {
                Err(Refusal::PickOffStrip { eye: eye.name() })
            } else {
                Err(Refusal::NoPair { eye: eye.name() })
            }
        };
        Ok(Self {
            rig: request.pair.rig,
            drift: None,
            seen: [see(Eye::Left)?, see(Eye::Right)?],
        })
    }

    /// One more.
    pub(crate) fn moved(moved: &MovedPair<'a>) -> Self {
        Self {
            rig: moved.pair.rig.moved(&moved.rig_from_moved),
            drift: moved
                .sigma
                .map(|sigma| Drift::new(&sigma, moved.rig_from_moved.origin_m())),
            seen: Eye::BOTH.map(|eye| see(&moved.alone(), eye)),
        }
    }

    pub(crate) fn lights(&self) -> [&Light<'a>; 2] {
        [&self.seen[0].light, &self.seen[1].light]
    }
}

fn see<'a>(request: &Request<'a>, eye: Eye) -> Seen<'a> {
    let roi = request.roi(eye);
    let light = Light::of(request.image(eye), roi);
    let pick = request
        .pick
        .filter(|pick| pick.eye == eye)
        .map(|pick| pick.pixel - Pixel::new(roi.x_px.into(), roi.y_px.into()));
    let factors = COARSE.map(|(pixels, side)| light.factor(pixels, side));
    let mut seen = Seen {
        light,
        strips: Vec::new(),
        factor: factors[0],
    };
    for (look, factor) in factors.into_iter().enumerate() {
        if factors[..look].contains(&factor) {
            continue;
        }
        let binned = seen.light.binned(factor);
        let floor = 2e-4 / factor as f64;
        let edges = sums::edges(&binned, EDGES, floor);
        seen.strips = strip::strips(&edges, &binned, pick.as_ref(), STRIPS);
        if !seen.strips.is_empty() {
            seen.factor = factor;
            break;
        }
    }
    seen
}
