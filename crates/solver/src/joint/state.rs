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

/// The softest lens, px².
const MOST_BLUR_PX2: f64 = 25.0;
/// More than all of the rise is not one lamp's.
const MOST_AMOUNT: f64 = 1.5;

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

    /// Which unknowns are at the end of what they may be and would go on.
    pub(crate) fn held(&self, score: &SVector<f64, UNKNOWNS>) -> SVector<bool, UNKNOWNS> {
        let mut held = SVector::repeat(false);
        // A lens cannot be sharper than sharp.
        for (k, blur_px2) in self.blur_px2.iter().enumerate() {
            held[ROD + k] = *blur_px2 <= 1.001 * LEAST_BLUR_PX2 && score[ROD + k] < 0.0;
        }
        for (eye, limbs) in self.shadows.iter().enumerate() {
            for (side, limb) in limbs.iter().enumerate() {
                let k = of_shadow(eye, side);
                if let Some(Shadow {
                    amount,
                    angle_rad,
                    within_rad: [low, high],
                }) = limb
                {
                    let is_held = |value: f64, low: f64, high: f64, score: f64| {
                        (value <= low + 1e-9 && score < 0.0)
                            || (value >= high - 1e-9 && score > 0.0)
                    };
                    held[k] = is_held(*amount, 0.0, MOST_AMOUNT, score[k]);
                    held[k + 1] = is_held(*angle_rad, *low, *high, score[k + 1]);
                }
            }
        }
        held
    }

    /// What may be taken of a step.
    pub(crate) fn taken(&self, step: &SVector<f64, UNKNOWNS>) -> SVector<f64, UNKNOWNS> {
        let mut taken = *step;
        if self.bend_per_m.is_none() {
            taken.fixed_rows_mut::<2>(BEND).fill(0.0);
        }
        for k in ROD..ROD + 2 {
            let most = libm::log(MOST_BLUR_PX2 / self.blur_px2[k - ROD]);
            let least = libm::log(LEAST_BLUR_PX2 / self.blur_px2[k - ROD]);
            taken[k] = step[k].clamp(least.max(-2.0), most.min(2.0));
        }
        for (eye, limbs) in self.shadows.iter().enumerate() {
            for (side, limb) in limbs.iter().enumerate() {
                let k = of_shadow(eye, side);
                let Some(shadow) = limb else {
                    (taken[k], taken[k + 1]) = (0.0, 0.0);
                    continue;
                };
                taken[k] = step[k].clamp(-shadow.amount, MOST_AMOUNT - shadow.amount);
                let [low, high] = shadow.within_rad.map(|end| end - shadow.angle_rad);
                let most = 0.3 * shadow.angle_rad;
                taken[k + 1] = step[k + 1].clamp(low.max(-most), high.min(most));
            }
        }
        taken
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
        }
    }
}
