//! The unknowns: a rod, what blurs it, and where shadows begin on it.

use nalgebra::SVector;
use rodsight_geometry::{Cylinder, Line3, Vec3};

use super::spread::LEAST_BLUR_PX2;

/// Of the rod: two shifts across, two turns, the radius, two bends.
pub(crate) const ROD: usize = 7;
pub(crate) const RADIUS: usize = 4;
pub(crate) const BEND: usize = 5;
/// Then the blur of each eye, and of each limb of each eye the amount and the angle of its shadow.
pub(crate) const UNKNOWNS: usize = ROD + 2 + 8;

/// Where among the unknowns the shadow of a limb (plus, minus) of an eye begins: its amount, then its angle.
pub(crate) fn of_shadow(eye: usize, side: usize) -> usize {
    ROD + 2 + 4 * eye + 2 * side
}

/// Where the azimuths of two lamps begin among the unknowns: in the place of shadows, which they explain.
pub(crate) const LAMPS: usize = ROD + 2;

/// The softest lens, px².
const MOST_BLUR_PX2: f64 = 25.0;
/// A shadow's angle changes by no more than this share of it at a step.
const MOST_TURN: f64 = 0.3;
/// More than all of the rise is not one lamp's.
pub(crate) const MOST_AMOUNT: f64 = 1.5;

/// Light that a limb does not get: of a lamp so far to the other side that its light ends before the limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shadow {
    /// Share of the light's rise inside the limb that is this lamp's, or about so.
    pub(crate) amount: f64,
    /// From the limb to where the lamp's light ends, around the axis, rad.
    pub(crate) angle_rad: f64,
    /// The least and the largest angle that can be told.
    pub(crate) within_rad: [f64; 2],
}

/// A rod, what blurs it, and its shadows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) cylinder: Cylinder,
    /// Two unit vectors across the axis.
    pub(crate) across: [Vec3; 2],
    /// Curvature of the axis at its point, 1/m; none of a straight rod.
    pub(crate) bend_per_m: Option<Vec3>,
    /// Of each eye, px².
    pub(crate) blur_px2: [f64; 2],
    /// Of each eye's limbs plus and minus, where there is one.
    pub(crate) shadows: [[Option<Shadow>; 2]; 2],
    /// Where lamps are, around the axis from the first of `across` to the second, rad, if the rod's light is taken for theirs; shadows
    /// are theirs then.
    pub(crate) lamps_rad: [Option<f64>; 2],
}

impl State {
    pub(crate) fn new(cylinder: Cylinder, blur_px2: f64) -> Self {
        let d = cylinder.axis.direction;
        let mut least = Vec3::zeros();
        least[d.iamin()] = 1.0;
        let first = d.cross(&least).normalize();
        Self {
            cylinder,
            across: [first, d.cross(&first)],
            bend_per_m: None,
            blur_px2: [blur_px2; 2],
            shadows: [[None; 2]; 2],
            lamps_rad: [None; 2],
        }
    }

    /// The straight rod that this one is at a distance along its axis: an arc's parabola.
    pub(crate) fn tangent(&self, along_m: f64) -> Cylinder {
        let axis = &self.cylinder.axis;
        let bend = self.bend_per_m.unwrap_or_default();
        let off = (axis.direction + bend * (0.5 * along_m)) * along_m;
        Cylinder {
            axis: Line3::new(axis.point_m + off, &(axis.direction + bend * along_m)),
            ..self.cylinder
        }
    }

    /// The straight rod that this one is where a ray comes nearest to it, or at its point.
    pub(crate) fn tangent_at(&self, ray: Option<&(Vec3, Vec3)>) -> Self {
        let (Some((from_m, along)), Some(_)) = (ray, self.bend_per_m) else {
            return Self {
                bend_per_m: None,
                ..*self
            };
        };
        let mut along_m = 0.0;
        for _ in 0..4 {
            let axis = self.tangent(along_m).axis;
            let w = axis.point_m - from_m;
            let cos = axis.direction.dot(along);
            let sin2 = (along.norm_squared() - cos * cos).max(1e-9);
            along_m += (cos * w.dot(along) - along.norm_squared() * w.dot(&axis.direction)) / sin2;
        }
        Self {
            cylinder: self.tangent(along_m),
            bend_per_m: None,
            ..*self
        }
    }

    /// The least and the most that a step may be.
    pub(crate) fn bounds(&self) -> [SVector<f64, UNKNOWNS>; 2] {
        let mut least = SVector::repeat(f64::NEG_INFINITY);
        let mut most = SVector::repeat(f64::INFINITY);
        let mut bound = |k: usize, from: f64, to: f64| (least[k], most[k]) = (from, to);
        if self.bend_per_m.is_none() {
            bound(BEND, 0.0, 0.0);
            bound(BEND + 1, 0.0, 0.0);
        }
        for (k, blur_px2) in self.blur_px2.iter().enumerate() {
            let [from, to] = [LEAST_BLUR_PX2, MOST_BLUR_PX2].map(|end| libm::log(end / blur_px2));
            bound(ROD + k, from.clamp(-2.0, 0.0), to.clamp(0.0, 2.0));
        }
        for (eye, limbs) in self.shadows.iter().enumerate() {
            for (side, limb) in limbs.iter().enumerate() {
                let k = of_shadow(eye, side);
                let (mut amounts, mut angles) = ([0.0; 2], [0.0; 2]);
                if let Some(shadow) = limb {
                    amounts = [-shadow.amount, MOST_AMOUNT - shadow.amount];
                    let [low, high] = shadow.within_rad.map(|end| end - shadow.angle_rad);
                    let most = MOST_TURN * shadow.angle_rad;
                    angles = [low.clamp(-most, 0.0), high.clamp(0.0, most)];
                }
                bound(k, amounts[0], amounts[1]);
                bound(k + 1, angles[0], angles[1]);
            }
        }
        for k in (0..2).filter(|k| self.lamps_rad[*k].is_some()) {
            bound(LAMPS + k, -MOST_TURN, MOST_TURN);
        }
        [least, most]
    }

    /// As another has it, nearly where this one is.
    pub(crate) fn take_rod(&mut self, other: &Self) {
        self.cylinder = other.cylinder;
        self.across = other.across;
        self.bend_per_m = other.bend_per_m;
    }

    /// By a step that may be taken.
    pub(crate) fn moved(&self, by: &SVector<f64, UNKNOWNS>) -> Self {
        let [e1, e2] = self.across;
        let axis = &self.cylinder.axis;
        let d = (axis.direction + e1 * by[2] + e2 * by[3]).normalize();
        let first = (e1 - d * d.dot(&e1)).normalize();
        let mut shadows = self.shadows;
        for (eye, limbs) in shadows.iter_mut().enumerate() {
            for (side, limb) in limbs.iter_mut().enumerate() {
                if let Some(shadow) = limb {
                    let k = of_shadow(eye, side);
                    shadow.amount += by[k];
                    shadow.angle_rad += by[k + 1];
                }
            }
        }
        Self {
            cylinder: Cylinder {
                axis: Line3 {
                    point_m: axis.point_m + e1 * by[0] + e2 * by[1],
                    direction: d,
                },
                radius_m: (self.cylinder.radius_m + by[RADIUS]).max(0.2 * self.cylinder.radius_m),
            },
            across: [first, d.cross(&first)],
            bend_per_m: self.bend_per_m.map(|bend| {
                let bend = bend + e1 * by[BEND] + e2 * by[BEND + 1];
                bend - d * d.dot(&bend)
            }),
            blur_px2: [0, 1].map(|k| self.blur_px2[k] * libm::exp(by[ROD + k])),
            shadows,
            lamps_rad: [0, 1].map(|k| self.lamps_rad[k].map(|lamp_rad| lamp_rad + by[LAMPS + k])),
        }
    }
}
