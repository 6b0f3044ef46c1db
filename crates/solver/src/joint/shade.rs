//! The light of a pixel near a limb, and how it changes with all that is unknown.

use super::bands::REACH_PX;
use super::block::Shades;
use super::lamp::Lamp;
use super::spread::{Shapes, Spread};
use super::state::Shadow;

/// What a pixel knows, in the order of its row's sums: the near limb's three shapes inside and two outside, the light's derivatives
/// by the distance to the near limb and by blur; where the limb has a shadow the light's derivatives by its amount and angle; and
/// where the rod is so narrow that the far limb matters, its two shapes outside and the derivative by its distance.
pub(crate) const KNOWN: usize = 12;
pub(crate) const BY_NEAR: usize = 5;
pub(crate) const BY_BLUR: usize = 6;
pub(crate) const OF_SHADOW: usize = 7;
pub(crate) const BY_ANGLE: usize = 8;
pub(crate) const OF_FAR: usize = 9;
pub(crate) const BY_FAR: usize = 11;

/// The shading of a limb in a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shading {
    inner: [f64; 3],
    outer: [f64; 2],
    /// Outside the far limb.
    beyond: [f64; 2],
    pub(crate) shadow: Option<Shadow>,
    rise: f64,
    /// The lamps whose light the third and the second of the inner shades are, instead of a root and a slope.
    pub(crate) lamps: [Option<Lamp>; 2],
}

impl Shading {
    pub(crate) fn new(
        shades: &Shades,
        side: usize,
        (shadow, rise): (Option<Shadow>, f64),
        lamps: [Option<Lamp>; 2],
    ) -> Self {
        let (within, here, there) = (3 * side, 6 + 2 * side, 6 + 2 * (1 - side));
        Self {
            inner: [shades[within], shades[within + 1], shades[within + 2]],
            outer: [shades[here], shades[here + 1]],
            beyond: [shades[there], shades[there + 1]],
            shadow,
            rise,
            lamps,
        }
    }
}

/// A limb of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelModel<'a> {
    pub(crate) near: &'a Spread,
    pub(crate) far: &'a Spread,
    /// 1 for limb plus.
    pub(crate) sign: f64,
    pub(crate) radius_px: f64,
    pub(crate) light: &'a Shading,
}

impl PixelModel<'_> {
    /// Of a pixel at x px inside the near limb and `far_x` px inside the far one: what it knows, and its light.
    pub(crate) fn at(&self, (x, far_x): (f64, f64)) -> ([f64; KNOWN], f64) {
        let Shading {
            inner,
            outer,
            beyond,
            shadow,
            rise,
            lamps,
        } = self.light;
        let sign = self.sign;
        let per_radius = 1.0 / self.radius_px;
        let near = self.near.at(x);
        let Shapes {
            step: [e, e1, e2],
            ramp: [ramp, ..],
            root: [root, root1, root2],
        } = near;
        let Shapes {
            step: [f, f1, f2],
            ramp: [far_ramp, ..],
            root: [far_root, far_root1, far_root2],
        } = self.far.at(far_x);
        let inside = e + f - 1.0;
        let far_off = far_x - far_ramp;
        let linear = sign * (e - ramp * per_radius - (far_off * per_radius - (1.0 - f)));
        let rounded = far_root * per_radius;
        let free = if lamps[0].is_some() { 0.0 } else { 1.0 };
        let [a0, a1, a2] = [inner[0], free * sign * inner[1], free * inner[2] * rounded];
        let (b0, b1) = (outer[0], outer[1] / REACH_PX);
        let (c0, c1) = (beyond[0], beyond[1] / REACH_PX);
        let by_near2 = a0 * e2 + a1 * (e2 - e1 * per_radius) + a2 * root2 - b0 * e2 - b1 * e1;
        let by_far2 = a0 * f2 - a1 * (f2 - f1 * per_radius)
            + free * inner[2] * root * far_root2 * per_radius
            - c0 * f2
            - c1 * f1;
        let mut known = [
            inside,
            free * linear,
            free * root * rounded,
            1.0 - e,
            (x - ramp) / REACH_PX,
            a0 * e1 + a1 * (e1 - e * per_radius) + a2 * root1 - b0 * e1 + b1 * (1.0 - e),
            0.5 * (by_near2 + by_far2),
            0.0,
            0.0,
            1.0 - f,
            far_off / REACH_PX,
            a0 * f1 - a1 * (f1 + (1.0 - f) * per_radius)
                + free * inner[2] * root * far_root1 * per_radius
                - c0 * f1
                + c1 * (1.0 - f),
        ];
        let mut light = inner[0] * known[0] + inner[1] * known[1] + inner[2] * known[2];
        light += outer[0] * known[3] + outer[1] * known[4];
        light += beyond[0] * known[OF_FAR] + beyond[1] * known[OF_FAR + 1];
        if let Some(shadow) = shadow {
            let [value, by_x, by_blur, by_angle] =
                shadowed(self.near, x, self.radius_px, shadow.angle_rad);
            let amount = rise * shadow.amount;
            known[OF_SHADOW] = rise * value;
            known[BY_ANGLE] = amount * by_angle;
            known[BY_NEAR] += amount * by_x;
            known[BY_BLUR] += amount * by_blur;
            light += amount * value;
        }
        for (k, lamp) in lamps.iter().flatten().enumerate() {
            let [value, by_x, by_x2, by_psi] =
                lamp.at(self.near, (x, &near), (self.radius_px, rounded));
            let shade = 2 - k;
            let amount = inner[shade];
            known[shade] = value;
            known[OF_SHADOW + k] = amount * by_psi * lamp.turn;
            known[BY_NEAR] += amount * by_x;
            known[BY_BLUR] += 0.5 * amount * by_x2;
            light += amount * value;
        }
        (known, light)
    }
}

/// The light of a far lamp that ends at an angle before the limb, about 1 at some px inside; its first and second derivative by x
/// and that by the angle.
///
/// With t the distance to the axis over the radius, and t' that of where the light ends, it is
/// (t' − t)(t' + t)/(t' √(1 − t²) + t √(1 − t'²)) where t < t': a ramp, which lens and pixel blur, times what changes slowly.
pub(crate) fn shadowed(spread: &Spread, x_px: f64, radius_px: f64, angle_rad: f64) -> [f64; 4] {
    let scale = radius_px.sqrt() / 1.4;
    let (end, aside) = (libm::cos(angle_rad), libm::sin(angle_rad));
    let end_px = radius_px * (1.0 - end);
    let [ramp, step, line] = spread.ramp(x_px - end_px);
    if ramp == 0.0 {
        return [0.0; 4];
    }
    let per_radius = 1.0 / radius_px;
    // Slowly varying, with its derivatives by x and by the angle.
    let (slow, by_x, by_angle) = if x_px <= end_px {
        let slow = per_radius / aside;
        (slow, 0.0, -slow * end / aside)
    } else {
        let t = (1.0 - x_px * per_radius).max(-0.99);
        let c = (1.0 - t * t).sqrt();
        let (over, under) = (end + t, end * c + aside * t);
        let by_t = (under - over * (aside - end * t / c)) / (under * under);
        let by_angle = (-aside * under - over * (end * t - aside * c)) / (under * under);
        (
            per_radius * over / under,
            -per_radius * per_radius * by_t,
            per_radius * by_angle,
        )
    };
    [
        scale * ramp * slow,
        scale * (step * slow + ramp * by_x),
        0.5 * scale * line * slow,
        scale * (ramp * by_angle - step * slow * radius_px * aside),
    ]
}
