//! The light that lamps throw on a round rod, near a limb.
//!
//! A matt rod's light is the cosine of the angle around the axis from its lamp, or nothing beyond a right angle. That azimuth is the
//! same all along a straight rod, even for a lamp that is near, and one number for all limbs that the eyes see.

use rodsight_geometry::Vec3;

use super::bands::Ray;
use super::shade::shadowed;
use super::spread::{Shapes, Spread};
use super::state::State;

/// Light that ends so near to the limb, px, is light that does not end, but for how much of it there would be less than none.
const NEAR_PX: f64 = 1.0;
/// Nodes and weights of Gauss's quadrature with the density 3 − 3 √x on 0…1, which is that of less than none.
const LOBE: [(f64, f64); 3] = [
    (0.079_574_78, 0.444_320_24),
    (0.392_953_66, 0.435_736_71),
    (0.778_861_14, 0.119_943_05),
];

/// A lamp as a limb has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    /// From the direction to the camera, rad, growing towards the limb.
    pub(crate) psi_rad: f64,
    /// 1 where that grows with the lamp's azimuth, −1 where it falls.
    pub(crate) turn: f64,
}

impl Lamp {
    /// As the limb has them that a ray touches, of plus (sign 1) or minus (−1).
    pub(crate) fn of(state: &State, ray: &Ray, sign: f64) -> [Option<Self>; 2] {
        let d = state.cylinder.axis.direction;
        let [first, second] = state.across;
        // Out of the rod at the limb, and towards the camera.
        let out = ray.direction.cross(&d).normalize() * -sign;
        let back = back(&d, ray);
        state.lamps_rad.map(|lamp_rad| {
            let (sin, cos) = libm::sincos(lamp_rad?);
            let towards = first * cos + second * sin;
            Some(Self {
                psi_rad: libm::atan2(towards.dot(&out), towards.dot(&back)),
                turn: d.cross(&back).dot(&out).signum(),
            })
        })
    }

    /// The light at x px inside a limb whose shapes there are these, its first and second derivative by x and that by psi.
    pub(crate) fn at(
        &self,
        spread: &Spread,
        (x_px, shapes): (f64, &Shapes),
        (radius_px, rounded): (f64, f64),
    ) -> [f64; 4] {
        let (sin, cos) = libm::sincos(self.psi_rad);
        let end_px = radius_px * (1.0 - cos);
        if sin < 0.0 && end_px > NEAR_PX {
            let per_scale = 1.4 / radius_px.sqrt();
            let [value, by_x, by_blur, by_angle] = shadowed(spread, x_px, radius_px, -self.psi_rad);
            return [value, by_x, 2.0 * by_blur, -by_angle].map(|v| v * per_scale);
        }
        let per_radius = 1.0 / radius_px;
        let Shapes {
            step: [e, e1, e2],
            ramp: [ramp, ..],
            root: [root, root1, root2],
        } = shapes;
        let linear = [
            e - ramp * per_radius,
            e1 - e * per_radius,
            e2 - e1 * per_radius,
        ];
        let round = [root, root1, root2].map(|v| v * rounded);
        let [mut value, mut by_x, by_x2]: [f64; 3] =
            core::array::from_fn(|k| sin * linear[k] + cos * round[k]);
        let mut by_psi = cos * linear[0] - sin * round[0];
        if sin < 0.0 {
            // What would be less than none.
            let mass = -sin * end_px / 3.0;
            for (node, weight) in LOBE {
                let [_, line, slope] = spread.step(x_px - node * end_px);
                value += mass * weight * line;
                by_x += mass * weight * slope;
            }
            by_psi -= cos * (e - spread.step(x_px - end_px)[0]);
        }
        [value, by_x, by_x2, by_psi]
    }
}

/// Across a rod towards where a ray comes from.
pub(crate) fn back(d: &Vec3, ray: &Ray) -> Vec3 {
    let v = ray.direction;
    -(v - d * d.dot(&v)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_PX: f64 = 40.0;

    /// The light a distance inside the limb, unblurred.
    fn light(psi_rad: f64, x_px: f64) -> f64 {
        if x_px <= 0.0 {
            return 0.0;
        }
        let t = 1.0 - x_px / RADIUS_PX;
        let (sin, cos) = libm::sincos(psi_rad);
        (sin * t + cos * (1.0 - t * t).sqrt()).max(0.0)
    }

    /// By brute force: the mean over a pixel and a Gaussian.
    fn mean(psi_rad: f64, [across, along]: [f64; 2], sigma: f64, x_px: f64) -> f64 {
        const N: i32 = 80;
        let (mut sum, mut weights) = (0.0, 0.0);
        for g in -N..=N {
            let z = 5.0 * f64::from(g) / f64::from(N);
            let weight = libm::exp(-0.5 * z * z);
            for i in 0..N {
                for j in 0..N {
                    let [a, b] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(N) - 0.5);
                    let x_px = x_px + sigma * z + a * across + b * along;
                    sum += weight * light(psi_rad, x_px) / f64::from(N * N);
                }
            }
            weights += weight;
        }
        sum / weights
    }

    fn at(psi_rad: f64, spread: &Spread, x_px: f64) -> [f64; 4] {
        let lamp = Lamp { psi_rad, turn: 1.0 };
        let rounded = (2.0 * RADIUS_PX - x_px).sqrt() / RADIUS_PX;
        lamp.at(spread, (x_px, &spread.at(x_px)), (RADIUS_PX, rounded))
    }

    /// Lamps on the limb's side and on the other, whose light ends before the limb: just before it, and pixels away.
    #[test]
    fn light_is_that_of_a_blurred_round_rod() {
        let (normal, sigma) = ([0.8, 0.6], 0.45);
        let spread = Spread::new(normal, sigma * sigma);
        for psi_rad in [1.1, 0.3, 0.0, -0.12, -0.2, -0.4, -0.7] {
            for k in -3..12 {
                let x_px = 0.5 * f64::from(k) + 0.1;
                let found = at(psi_rad, &spread, x_px)[0];
                let wanted = mean(psi_rad, normal, sigma, x_px);
                assert!(
                    (found - wanted).abs() < 4e-3,
                    "{psi_rad} {x_px}: {found} {wanted}"
                );
            }
        }
    }

    #[test]
    fn slopes_are_slopes() {
        let spread = Spread::new([0.8, 0.6], 0.3);
        for psi_rad in [1.1, 0.3, -0.12, -0.4, -0.7] {
            for k in -3..12 {
                let x_px = 0.5 * f64::from(k) + 0.13;
                let h = 1e-4;
                let [_, by_x, _, by_psi] = at(psi_rad, &spread, x_px);
                let change = |a: [f64; 4], b: [f64; 4]| (a[0] - b[0]) / (2.0 * h);
                let slope = change(
                    at(psi_rad, &spread, x_px + h),
                    at(psi_rad, &spread, x_px - h),
                );
                assert!(
                    (by_x - slope).abs() < 2e-2,
                    "{psi_rad} {x_px}: {by_x} {slope}"
                );
                let slope = change(
                    at(psi_rad + h, &spread, x_px),
                    at(psi_rad - h, &spread, x_px),
                );
                assert!(
                    (by_psi - slope).abs() < 5e-2,
                    "{psi_rad} {x_px}: {by_psi} {slope}"
                );
            }
        }
    }
}
