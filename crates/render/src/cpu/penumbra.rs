//! Soft shadows: what rods take of a lamp's light that the water has scattered forwards.
//!
//! Light that a lobe of width θ deflects at a fraction s of its way comes from s times the angle beside the lamp, s even in [0, 1] as in
//! Wells' transfer function; with the mean, ½, it is seen about the lamp as a bivariate Cauchy density of width θ/2, in tangents of angles.
//! A rod takes what lies behind it: a rectangle between its limbs and its ends, of which that density holds a closed form.

use core::f64::consts::PI;

use rodsight_geometry::Vec3;
use rodsight_optics::{ForwardLobe, Medium};

use super::shadow::Shadows;
use super::solid::Capped;

/// Stands for a right angle: its tangent.
const BEYOND: f64 = 1e4;
/// Nearer parts of a rod stand beside the point, not before the lamp, m.
const NEAR_M: f64 = 1e-4;

/// Tangents of the angles, from the lamp's direction, across the axis of a piece and along it; from, to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    pub(crate) across: [f64; 2],
    pub(crate) along: [f64; 2],
}

impl Rectangle {
    /// A piece before a lamp as a point sees it. `None` where no part of it is between.
    pub(crate) fn of(piece: &Capped, point_m: &Vec3, lamp_m: &Vec3) -> Option<Self> {
        let to_lamp = lamp_m - point_m;
        let r = to_lamp.norm();
        let to_lamp = to_lamp / r;
        let (d, radius) = (piece.cylinder.axis.direction, piece.cylinder.radius_m);
        let centre = piece.cylinder.axis.point_m - point_m;
        let (ahead, tilt) = (centre.dot(&to_lamp), d.dot(&to_lamp));
        // The axis from the point to the lamp.
        let [mut from, mut to] = [-piece.half_length_m, piece.half_length_m];
        if tilt.abs() > 1e-9 {
            let [a, b] = [NEAR_M, r].map(|limit| (limit - ahead) / tilt);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        } else if !(NEAR_M..=r).contains(&ahead) {
            return None;
        }
        if from >= to {
            return None;
        }
        let ends = [from, to].map(|t| (centre + d * t, ahead + tilt * t));
        let normal = centre.cross(&d);
        let distance = normal.norm();
        if distance <= radius {
            return Some(Self::end_on(radius, &to_lamp, ends));
        }
        let normal = normal / distance;
        // In the cross-section the lamp is at (front, aside); the limbs are an angle of sine radius/distance to either side of the axis.
        let aside = normal.dot(&to_lamp);
        let front = d.cross(&normal).dot(&to_lamp);
        let sin = radius / distance;
        let cos = (1.0 - sin * sin).sqrt();
        let limb = |side: f64| {
            let tangent = aside * cos + side * front * sin;
            if front * cos - side * aside * sin > 0.0 {
                (tangent / (1.0 - tangent * tangent).max(1e-12).sqrt()).clamp(-BEYOND, BEYOND)
            } else {
                BEYOND.copysign(aside)
            }
        };
        let up = normal.cross(&to_lamp).normalize();
        let thick = radius * (1.0 - d.dot(&up).powi(2)).max(0.0).sqrt();
        let seen = ends.map(|(end, depth)| (end.dot(&up) / depth, thick / depth));
        let rectangle = Self {
            across: [limb(-1.0), limb(1.0)],
            along: [
                seen.iter().map(|(at, rim)| at - rim).fold(BEYOND, f64::min),
                seen.iter()
                    .map(|(at, rim)| at + rim)
                    .fold(-BEYOND, f64::max),
            ],
        };
        (rectangle.across[0] < rectangle.across[1]).then_some(rectangle)
    }

    /// From within the cylinder made longer: the nearer cap, as a square of its area.
    pub(crate) fn end_on(radius: f64, to_lamp: &Vec3, ends: [(Vec3, f64); 2]) -> Self {
        let (cap, depth) = if ends[0].1 < ends[1].1 {
            ends[0]
        } else {
            ends[1]
        };
        let mut least = Vec3::zeros();
        least[to_lamp.iamin()] = 1.0;
        let aside = to_lamp.cross(&least).normalize();
        let half = 0.5 * PI.sqrt() * radius / depth;
        let span = |axis: Vec3| {
            let at = cap.dot(&axis) / depth;
            [at - half, at + half].map(|v| v.clamp(-BEYOND, BEYOND))
        };
        Self {
            across: span(aside),
            along: span(to_lamp.cross(&aside)),
        }
    }

    /// Share of a lobe's light from within: ∬ w/(2π (w² + x² + y²)^(3/2)) = Σ ± atan(x y/(w √(w² + x² + y²)))/2π over the corners. The sum
    /// of angles is taken as the angle of a product.
    pub(crate) fn share(&self, width: f64) -> f64 {
        let corner = |x: f64, y: f64| [width * (width * width + x * x + y * y).sqrt(), x * y];
        let ([x0, x1], [y0, y1]) = (self.across, self.along);
        let turned = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c + b * d, b * c - a * d];
        let high = turned(corner(x1, y1), corner(x0, y1));
        let low = turned(corner(x1, y0), corner(x0, y0));
        let [cos, sin] = turned(high, low);
        let angle = angle_rad(cos, sin);
        // More than half of the light only where the lamp itself is hidden.
        let hides_the_lamp = x0 < 0.0 && x1 > 0.0 && y0 < 0.0 && y1 > 0.0;
        let angle = if hides_the_lamp && angle < 0.0 {
            angle + 2.0 * PI
        } else {
            angle
        };
        (angle / (2.0 * PI)).clamp(0.0, 1.0)
    }
}

/// atan2(y, x) within 2e-8 rad, without a branch: Hastings' polynomial (Abramowitz and Stegun, 4.4.49).
pub(crate) fn angle_rad(x: f64, y: f64) -> f64 {
    let (along, aside) = (x.abs(), y.abs());
    let z = along.min(aside) / along.max(aside).max(f64::MIN_POSITIVE);
    let z2 = z * z;
    let odd = [
        -0.333_331_452_8,
        0.199_935_508_5,
        -0.142_088_994_4,
        0.106_562_639_3,
        -0.075_289_640_0,
        0.042_909_613_8,
        -0.016_165_736_7,
        0.002_866_225_7,
    ];
    let sum = odd.iter().rev().fold(0.0, |sum, c| (sum + c) * z2);
    let angle = z + z * sum;
    let angle = if aside > along {
        0.5 * PI - angle
    } else {
        angle
    };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

/// The forward lobes of a medium: shares that sum to 1, and half their widths.
pub(crate) fn soft_lobes(medium: &Medium) -> Vec<ForwardLobe> {
    let lobes = medium.phase().forward_lobes();
    let total: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    let halved = lobes.iter().map(|lobe| ForwardLobe {
        share: lobe.share / total,
        width_rad: 0.5 * lobe.width_rad,
    });
    halved.collect()
}

impl Shadows {
    /// Share of the lamp's scattered light that reaches a place; a rod stops none of its own.
    pub(crate) fn soft_share(
        &self,
        point_m: &Vec3,
        lobes: &[ForwardLobe],
        own: Option<usize>,
    ) -> f64 {
        let rods = self.casters.chunk_by(|a, b| a.rod == b.rod);
        let others = rods.filter(|pieces| Some(pieces[0].rod) != own);
        others.fold(1.0, |passed, pieces| {
            let rectangles = pieces
                .iter()
                .filter_map(|caster| Rectangle::of(&caster.piece, point_m, &self.lamp_m));
            let stopped: f64 = rectangles
                .map(|rectangle| {
                    let of_lobe = |lobe: &ForwardLobe| lobe.share * rectangle.share(lobe.width_rad);
                    lobes.iter().map(of_lobe).sum::<f64>()
                })
                .sum();
            passed * (1.0 - stopped).max(0.0)
        })
    }
}

#[cfg(test)]
mod tests;
