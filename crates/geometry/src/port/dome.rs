//! A spherical shell of glass between the lens and the water.

use core::f64::consts::PI;

use super::snell::refract;
use super::{Indices, WaterRay};
use crate::Vec3;

/// A dome port: the glass between two concentric spheres. With its centre in the entrance pupil it refracts nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomePort {
    /// Centre of the spheres in the camera's frame, m: zero for a dome that is adjusted perfectly.
    pub centre_m: Vec3,
    /// Radius of the inner face, m.
    pub inner_radius_m: f64,
    /// Thickness of the glass, m.
    pub thickness_m: f64,
}

impl DomePort {
    fn outer_radius_m(&self) -> f64 {
        self.inner_radius_m + self.thickness_m
    }

    pub(super) fn water_ray(&self, air: &Vec3, n: &Indices) -> Option<WaterRay> {
        let inner_m = self.leave(&Vec3::zeros(), air, self.inner_radius_m)?;
        let outward = (inner_m - self.centre_m) / self.inner_radius_m;
        let glass = refract(air, &outward, 1.0, n.glass)?;
        let outer_m = self.leave(&inner_m, &glass.direction, self.outer_radius_m())?;
        let outward = (outer_m - self.centre_m) / self.outer_radius_m();
        let water = refract(&glass.direction, &outward, n.glass, n.water)?;
        Some(WaterRay {
            origin_m: outer_m,
            direction: water.direction,
            gain: n.gain([glass.transmittance, water.transmittance]),
        })
    }

    /// Where a ray from inside leaves a sphere about the dome's centre.
    fn leave(&self, from_m: &Vec3, direction: &Vec3, radius_m: f64) -> Option<Vec3> {
        let w = from_m - self.centre_m;
        let along = w.dot(direction);
        let inside2 = radius_m * radius_m - (w - direction * along).norm_squared();
        (inside2 > 0.0).then(|| from_m + direction * (inside2.sqrt() - along))
    }

    /// The unit direction in air in which a point in the water is seen. Everything happens in the plane of dome centre, pupil and
    /// point, where n·b, b the distance of the ray from the centre, stays the same from medium to medium (Bouguer). With α the
    /// angle at the pupil between the ray and the way out from the centre, b = e sin α, and the ray sweeps about the centre
    ///
    ///   `Φ(α) = α − asin(b/Rᵢ) + [asin(b/(n_g Rᵢ)) − asin(b/(n_g Rₒ))] + [asin(b/(n_w Rₒ)) − asin(b/(n_w ρ))]`
    ///
    /// on its way from the pupil, e from the centre, to the point, ρ from it. Φ grows from 0 to π with α.
    pub(super) fn air_direction(&self, point_m: &Vec3, n: &Indices) -> Option<Vec3> {
        let (inner_m, outer_m) = (self.inner_radius_m, self.outer_radius_m());
        let to_point = point_m - self.centre_m;
        let range_m = to_point.norm();
        // `!(…)` refuses NaN too.
        if !(range_m > outer_m) {
            return None;
        }
        let pupil_m = self.centre_m.norm();
        if pupil_m == 0.0 {
            return Some(point_m.normalize());
        }
        let out = -self.centre_m / pupil_m;
        let across = to_point - out * out.dot(&to_point);
        let wanted_rad = libm::atan2(across.norm(), out.dot(&to_point));
        let Some(across) = across.try_normalize(0.0) else {
            return Some(point_m.normalize());
        };
        let crossings = [
            (-1.0, inner_m),
            (1.0, n.glass * inner_m),
            (-1.0, n.glass * outer_m),
            (1.0, n.water * outer_m),
            (-1.0, n.water * range_m),
        ];
        let (mut low, mut high, mut alpha) = (0.0, PI, wanted_rad);
        for _ in 0..MAX_STEPS {
            let (sin, cos) = libm::sincos(alpha);
            let b = pupil_m * sin;
            let (mut swept_rad, mut slope) = (alpha, 1.0);
            for (sign, reach_m) in crossings {
                swept_rad += sign * libm::asin(b / reach_m);
                slope += sign * pupil_m * cos / (reach_m * reach_m - b * b).sqrt();
            }
            let error = swept_rad - wanted_rad;
            if error > 0.0 {
                high = alpha;
            } else {
                low = alpha;
            }
            let step = error / slope;
            if step.abs() <= 2e-16 * PI {
                break;
            }
            let newton = alpha - step;
            alpha = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        let (sin, cos) = libm::sincos(alpha);
        Some(out * cos + across * sin)
    }
}

/// Newton's method inside a bracket: a handful of steps, and bisection to the last bit at worst.
const MAX_STEPS: u32 = 100;
