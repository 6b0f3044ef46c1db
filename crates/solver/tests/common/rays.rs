//! What light comes down a ray.

use rodsight_geometry::{Cylinder, Eye, Line3, Pixel, Vec3};
use rodsight_solver::Roi;

use super::{Random, Scene, Texture};

/// Where a ray meets a rod.
pub(super) struct Hit {
    pub(super) rod: usize,
    pub(super) range_m: f64,
    pub(super) colour: [f64; 3],
}

impl Scene {
    /// What a ray of an eye meets first; `None` where it meets no rod within its length.
    pub(super) fn hit(&self, eye: Eye, u: f64, v: f64) -> Option<Hit> {
        let mounted = self.rig.eye(eye);
        let (origin, direction) = mounted.ray(&Pixel::new(u, v))?;
        let met = self.rods.iter().enumerate().filter_map(|(k, rod)| {
            let (local, near, along_m) = self.met(k == 0, rod, &origin, &direction)?;
            let from_axis = origin + direction * near - local.axis.point_m;
            let along = from_axis.dot(&local.axis.direction);
            let normal = (from_axis - local.axis.direction * along) / local.radius_m;
            (near > 0.0 && along_m.abs() <= self.half_length_m)
                .then_some((near, k, normal, along_m))
        });
        let (range_m, rod, normal, along_m) = met.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let of = |lamp: &Vec3| normal.dot(lamp).max(0.0);
        let light = if self.is_lit() {
            self.ambient + self.lamps.iter().map(of).sum::<f64>()
        } else {
            1.0
        };
        let paint = self.paint(along_m, &normal);
        let left = libm::exp(-self.haze_per_m * range_m);
        let hazed = |k: usize| light * paint[k] * left + (1.0 - left) * self.background[k];
        let colour = [hazed(0), hazed(1), hazed(2)];
        Some(Hit {
            rod,
            range_m,
            colour,
        })
    }

    /// Light that comes down a ray of an eye, before balls, lens and noise, and from how far, m; `None` outside what is painted.
    pub fn light(&self, eye: Eye, u: f64, v: f64) -> Option<([f64; 3], f64)> {
        let i = *self.rig.eye(eye).camera.intrinsics();
        let painted = self.only[eye as usize].unwrap_or(Roi {
            x_px: 0,
            y_px: 0,
            width_px: i.width_px,
            height_px: i.height_px,
        });
        let within = |at: f64, from: u32, length: u32| {
            at >= f64::from(from) && at < f64::from(from) + f64::from(length)
        };
        if !(within(u, painted.x_px, painted.width_px)
            && within(v, painted.y_px, painted.height_px))
        {
            return None;
        }
        if let Some(hit) = self.hit(eye, u, v) {
            return Some((hit.colour, hit.range_m));
        }
        let x = (u - 0.5) / f64::from(i.width_px) - 0.5;
        let y = (v - 0.5) / f64::from(i.height_px) - 0.5;
        let [a, b] = self.background_slope;
        let slope = (1.0 + a * x + b * y).max(0.0);
        Some((self.background.map(|v| v * slope), f64::INFINITY))
    }

    /// The straight rod that a rod is where a ray meets it, the distance to it, and how far along the rod that is.
    fn met(
        &self,
        bends: bool,
        rod: &Cylinder,
        origin: &Vec3,
        direction: &Vec3,
    ) -> Option<(Cylinder, f64, f64)> {
        let (p, d) = (rod.axis.point_m, rod.axis.direction);
        let along = |near: f64| (origin + direction * near - p).dot(&d);
        let curvature = self.curvature_per_m - d * d.dot(&self.curvature_per_m);
        if !bends || curvature.norm() == 0.0 {
            let (near, _) = rod.intersect(origin, direction)?;
            return Some((*rod, near, along(near)));
        }
        // The tangent where the ray passes nearest, again and again; the arc's parabola.
        let mut s_m = {
            let w = p - origin;
            let cos = d.dot(direction);
            (w.dot(direction) * cos - w.dot(&d)) / (1.0 - cos * cos).max(1e-9)
        };
        let mut found = None;
        for _ in 0..6 {
            let tangent = d + curvature * s_m;
            let local = Cylinder {
                axis: Line3::new(p + d * s_m + curvature * (0.5 * s_m * s_m), &tangent),
                radius_m: rod.radius_m,
            };
            let Some((near, _)) = local.intersect(origin, direction) else {
                // Beside it: nearest to the ray.
                let w = local.axis.point_m - origin;
                let cos = local.axis.direction.dot(direction);
                let more = (w.dot(direction) * cos - w.dot(&local.axis.direction))
                    / (1.0 - cos * cos).max(1e-9);
                s_m += more;
                found = None;
                continue;
            };
            let at = origin + direction * near - local.axis.point_m;
            s_m += at.dot(&local.axis.direction);
            found = Some((local, near, s_m));
        }
        found
    }

    fn paint(&self, along_m: f64, normal: &Vec3) -> [f64; 3] {
        match self.texture {
            Texture::Plain => self.rod_colour,
            Texture::Bands { period_m, colour } => {
                let place = along_m / period_m;
                if place - place.floor() < 0.5 {
                    colour
                } else {
                    self.rod_colour
                }
            }
            Texture::Patches { size_m, share } => {
                // Values on a grid along the rod and around it, smoothly between them.
                let radius_m = self.rods[0].radius_m;
                let d = self.rods[0].axis.direction;
                let e1 = d.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize();
                let angle = libm::atan2(normal.dot(&d.cross(&e1)), normal.dot(&e1));
                let (x, y) = (along_m / size_m, angle * radius_m / size_m);
                let (i, j) = (x.floor(), y.floor());
                let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
                let (a, b) = (smooth(x - i), smooth(y - j));
                let value = |di: f64, dj: f64| {
                    let key = ((i + di) as i64 as u64).wrapping_mul(0x9E37_79B9)
                        ^ ((j + dj) as i64 as u64).wrapping_mul(0x85EB_CA6B);
                    Random::new(self.seed ^ key.wrapping_mul(0xC2B2_AE35)).uniform()
                };
                let low = (1.0 - a) * value(0.0, 0.0) + a * value(1.0, 0.0);
                let high = (1.0 - a) * value(0.0, 1.0) + a * value(1.0, 1.0);
                let left = 1.0 - share * ((1.0 - b) * low + b * high);
                self.rod_colour.map(|v| v * left)
            }
        }
    }
}
