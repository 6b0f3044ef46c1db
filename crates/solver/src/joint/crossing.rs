//! Where rays pass a rod: the distance of pixels to its limbs, and how that changes with the rod.

use rodsight_geometry::Line3;

use super::bands::{REACH_PX, Ray};
use super::lamp::Lamp;
use super::pool::{Block, Cut};
use super::spread::Spread;
use super::state::State;

/// h of a ray and how it changes with the rod's two shifts, two turns and two bends.
pub(crate) fn distance(state: &State, ray: &Ray) -> (f64, [f64; 6]) {
    let mut axis = state.cylinder.axis;
    // Where along the axis it is nearest to the ray: a bent one is as straight there as its tangent.
    let mut along_m = nearest_m(&axis, ray);
    if state.bend_per_m.is_some() {
        for _ in 0..2 {
            axis = state.tangent(along_m).axis;
            along_m += nearest_m(&axis, ray);
        }
        axis = state.tangent(along_m).axis;
    } else {
        axis.point_m += axis.direction * along_m;
    }
    let (point_m, direction) = (axis.point_m, axis.direction);
    let m = ray.direction.cross(&direction);
    let norm = m.norm().max(1e-12);
    let unit = m / norm;
    let q = point_m - ray.origin_m;
    let h = q.dot(&unit);
    let turn = (q - unit * h).cross(&ray.direction) / norm;
    let mut slopes = [0.0; 6];
    for (k, across) in state.across.iter().enumerate() {
        let (shifted, turned) = (unit.dot(across), turn.dot(across));
        slopes[k] = shifted;
        slopes[2 + k] = turned + along_m * shifted;
        slopes[4 + k] = along_m * (turned + 0.5 * along_m * shifted);
    }
    (h, slopes)
}

/// How far along an axis from its point it is nearest to a ray.
fn nearest_m(axis: &Line3, ray: &Ray) -> f64 {
    let w = axis.point_m - ray.origin_m;
    let cos = axis.direction.dot(&ray.direction);
    let square = ray.direction.norm_squared();
    let sin2 = (square - cos * cos).max(1e-9 * square);
    (cos * w.dot(&ray.direction) - square * w.dot(&axis.direction)) / sin2
}

/// A cut as the present rod crosses it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// h = h0 + h1 δ + h2 δ² at δ px from the cut's middle.
    pub(crate) h: [f64; 3],
    /// Its derivatives at the middle.
    pub(crate) slopes: [f64; 6],
    /// |∇h|, m/px.
    pub(crate) per_px: f64,
    /// Unit normal of the limb in the image, as the image is scanned: across, along.
    pub(crate) normal: [f64; 2],
}

impl Crossing {
    pub(crate) fn new(state: &State, cut: &Cut) -> Self {
        let at = |k: usize| distance(state, &cut.rays[k]).0;
        let (h0, slopes) = distance(state, &cut.rays[1]);
        let (before, after) = (at(0), at(2));
        let h1 = (after - before) / (2.0 * REACH_PX);
        let h2 = (after - 2.0 * h0 + before) / (2.0 * REACH_PX * REACH_PX);
        let up = 0.5 * (at(4) - at(3));
        let per_px = libm::hypot(h1, up);
        Self {
            h: [h0, h1, h2],
            slopes,
            per_px,
            normal: [h1 / per_px, up / per_px],
        }
    }
}

/// By how many pixels limbs differ at most.
pub(crate) fn moved_px(blocks: &[Block], from: &State, to: &State) -> f64 {
    let thicker_m = (to.cylinder.radius_m - from.cylinder.radius_m).abs();
    let cuts = blocks.iter().flat_map(|block| block.cuts.iter().flatten());
    let moved = cuts.map(|cut| {
        let here = Crossing::new(from, cut);
        let there_m = distance(to, &cut.rays[1]).0;
        ((there_m - here.h[0]).abs() + thicker_m) / here.per_px
    });
    moved.fold(0.0, f64::max)
}

/// A limb at its middle block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Middle {
    /// The rod's radius, px.
    pub(crate) radius_px: f64,
    /// Unit vector inwards, across and along as the image is scanned.
    pub(crate) inwards: [f64; 2],
    /// From the principal point, across and along, px; and along from −1 to 1.
    pub(crate) from_centre_px: [f64; 2],
    pub(crate) by_columns: bool,
    pub(crate) along: f64,
    /// Half of the length from −1 to 1, px.
    pub(crate) half_px: f64,
    /// The lamps that the rod's light is taken for that of.
    pub(crate) lamps: [Option<Lamp>; 2],
}

impl Middle {
    pub(crate) fn of(state: &State, blocks: &[Block], eye: usize, side: usize) -> Option<Self> {
        let (block, cut) = middle_cut(blocks, eye, side)?;
        let crossing = Crossing::new(state, cut);
        let sign = if side == 0 { -1.0 } else { 1.0 };
        Some(Self {
            radius_px: state.cylinder.radius_m / crossing.per_px,
            inwards: crossing.normal.map(|v| sign * v),
            from_centre_px: cut.from_centre_px,
            by_columns: cut.by_columns,
            along: block.along,
            half_px: block.half_px,
            lamps: Lamp::of(state, &cut.rays[1], -sign),
        })
    }
}

fn middle_cut(blocks: &[Block], eye: usize, side: usize) -> Option<(&Block, &Cut)> {
    let mut cuts = blocks
        .iter()
        .filter(|block| block.eye == eye)
        .filter_map(|block| Some((block, block.cuts[side].as_ref()?)));
    let count = cuts.clone().count();
    cuts.nth(count / 2)
}

/// The shading and the present spreads of an eye's limbs.
pub(crate) fn spreads(state: &State, blocks: &[Block]) -> [[Option<Spread>; 2]; 2] {
    let normal = |eye: usize, side: usize| {
        Some(Crossing::new(state, middle_cut(blocks, eye, side)?.1).normal)
    };
    [0, 1].map(|eye| {
        [0, 1].map(|side| {
            normal(eye, side)
                .or_else(|| normal(eye, 1 - side))
                .map(|normal| Spread::new(normal, state.blur_px2[eye]))
        })
    })
}
