//! Light: lamps, their cones and shadows, surfaces, and the light scattered back by the water.

use rodsight_geometry::{Plane, Vec3};
use rodsight_optics::{Airlight, Bands, transmittance};
use rodsight_scene::{Lamp, Material, Mode};

use super::solid::{Capped, Ray};
use super::world::{Hit, World};

/// Lengths of shadow rays end this much short of their surface, relative and absolute.
const SHADOW_GAP: f64 = 1e-6;

/// Fraction of the axial intensity that a lamp sends in a unit direction: 1 in the inner cone, 0 outside the outer one, smooth
/// (cubic in the cosine) between.
pub(super) fn cone(lamp: &LampLight, direction: &Vec3) -> f64 {
    let cos = lamp.lamp.direction.dot(direction);
    if cos >= lamp.cos_inner {
        1.0
    } else if cos <= lamp.cos_outer {
        0.0
    } else {
        let s = (cos - lamp.cos_outer) / (lamp.cos_inner - lamp.cos_outer);
        s * s * (3.0 - 2.0 * s)
    }
}

/// A lamp with what can be computed once.
#[derive(Clone, Debug)]
pub(super) struct LampLight {
    pub(super) lamp: Lamp,
    cos_inner: f64,
    cos_outer: f64,
    /// Per straight piece of every rod, the planes through the lamp that touch it: between them lies its shadow.
    shadow_planes: Vec<(Capped, [Plane; 2])>,
}

impl LampLight {
    pub(super) fn new(lamp: &Lamp, pieces: impl Iterator<Item = Capped>) -> Self {
        let shadow_planes = pieces
            .filter_map(|piece| {
                let planes = piece.cylinder.tangent_planes(&lamp.position_m)?;
                let through = |normal: &Vec3| Plane::through(&lamp.position_m, normal);
                Some((piece, [through(&planes.plus), through(&planes.minus)]))
            })
            .collect();
        Self {
            lamp: *lamp,
            cos_inner: libm::cos(lamp.inner_half_angle_rad),
            cos_outer: libm::cos(lamp.outer_half_angle_rad),
            shadow_planes,
        }
    }
}

/// Light that leaves a surface towards the camera, and which lamps reach it (a bit each).
pub(super) struct Surface {
    /// In the water.
    pub(super) wet: Bands,
    /// Without any water.
    pub(super) dry: Bands,
    pub(super) lit_by: u32,
}

impl World<'_> {
    /// Lambert: L = Σ ρ/π · I cos θ / r² · e^(−c r) + ρ `L_ambient`; a flat surface sends its own radiance.
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let albedo = match self.material(ray, hit) {
            Material::Flat(radiance) => {
                return Surface {
                    wet: radiance,
                    dry: radiance,
                    lit_by: 0,
                };
            }
            Material::Lambert(albedo) => albedo,
        };
        let ambient = core::array::from_fn(|k| albedo[k] * self.scene.ambient_radiance[k]);
        let mut surface = Surface {
            wet: ambient,
            dry: ambient,
            lit_by: 0,
        };
        if self.scene.mode == Mode::Koschmieder {
            return surface;
        }
        let point = ray.at(hit.t_m);
        for (index, light) in self.lamps.iter().enumerate() {
            let to_point = point - light.lamp.position_m;
            let r = to_point.norm();
            let direction = to_point / r;
            let cos = -hit.normal.dot(&direction);
            let beam = cone(light, &direction);
            if cos <= 0.0 || beam == 0.0 || self.is_blocked(&light.lamp.position_m, &direction, r) {
                continue;
            }
            surface.lit_by |= 1 << index;
            let falloff = transmittance(&self.attenuation_per_m, r);
            for k in 0..3 {
                let dry = albedo[k] * light.lamp.radiant_intensity_w_per_sr[k] * beam * cos
                    / (core::f64::consts::PI * r * r);
                surface.dry[k] += dry;
                surface.wet[k] += dry * falloff[k];
            }
        }
        surface
    }

    fn is_blocked(&self, lamp_m: &Vec3, direction: &Vec3, distance_m: f64) -> bool {
        let ray = Ray {
            origin_m: *lamp_m,
            direction: *direction,
        };
        let reach = distance_m * (1.0 - SHADOW_GAP) - SHADOW_GAP;
        self.rods
            .iter()
            .any(|rod| rod.hit(&ray).is_some_and(|hit| hit.t_m < reach))
    }

    /// Light the water scatters into a ray of the given length (infinite where there is no surface): single scattering of every
    /// lamp, shadowed by the rods, and the veil of the ambient light.
    pub(super) fn backscatter(&self, ray: &Ray, distance_m: f64) -> Bands {
        let medium = &self.scene.medium;
        if self.scene.mode == Mode::Air || medium.is_vacuum() {
            return [0.0; 3];
        }
        let (c, b) = (&self.attenuation_per_m, medium.scattering_per_m());
        let mut light: Bands = core::array::from_fn(|k| {
            // B∞ (1 − e^(−c z)) with B∞ = b L / c.
            let veil = if distance_m.is_finite() {
                -libm::expm1(-c[k] * distance_m)
            } else {
                1.0
            };
            if c[k] > 0.0 {
                b[k] / c[k] * self.scene.ambient_radiance[k] * veil
            } else {
                0.0
            }
        });
        if self.scene.mode == Mode::Koschmieder {
            return light;
        }
        let distance_m = distance_m.min(self.horizon_m);
        let airlight = Airlight {
            medium,
            attenuation_per_m: *c,
            points: self.scene.sampling.airlight_points,
        };
        for lamp in &self.lamps {
            for (from_m, to_m) in self.lit_stretches(lamp, ray, distance_m) {
                let origin_m = ray.at(from_m);
                let scattered = airlight.lamp(
                    &(lamp.lamp.position_m - origin_m),
                    &ray.direction,
                    to_m - from_m,
                    |direction, _| cone(lamp, direction),
                );
                let before = transmittance(c, from_m);
                for k in 0..3 {
                    light[k] += lamp.lamp.radiant_intensity_w_per_sr[k] * scattered[k] * before[k];
                }
            }
        }
        light
    }

    /// The parts of a ray that a lamp reaches. Along the ray a rod's shadow begins and ends where the ray crosses a plane through
    /// the lamp that touches the rod, or where the end of the rod lets light past (found by bisection).
    fn lit_stretches(&self, light: &LampLight, ray: &Ray, distance_m: f64) -> Vec<(f64, f64)> {
        let mut lit = vec![(0.0, distance_m)];
        for (piece, [plus, minus]) in &light.shadow_planes {
            let crossing = |plane: &Plane| {
                let t = -plane.distance_m(&ray.origin_m) / plane.normal.dot(&ray.direction);
                if t.is_finite() {
                    t.clamp(0.0, distance_m)
                } else {
                    0.0
                }
            };
            let (a, b) = (crossing(plus), crossing(minus));
            let dark = |t: f64| {
                let to_point = ray.at(t) - light.lamp.position_m;
                let r = to_point.norm();
                piece.blocks(
                    &Ray {
                        origin_m: light.lamp.position_m,
                        direction: to_point / r,
                    },
                    r * (1.0 - SHADOW_GAP),
                )
            };
            for (from, to) in [
                (0.0, a.min(b)),
                (a.min(b), a.max(b)),
                (a.max(b), distance_m),
            ] {
                let middle = ray.at(0.5 * (from + to));
                // Only between the two planes, on the rod's side of the lamp, can there be shadow.
                if to - from > MIN_STRETCH_M
                    && plus.distance_m(&middle) > 0.0
                    && minus.distance_m(&middle) < 0.0
                {
                    remove_dark(&mut lit, from, to, dark);
                }
            }
        }
        lit
    }
}

/// Stretches shorter than this send no light worth a sum, m.
const MIN_STRETCH_M: f64 = 1e-9;

/// Takes away what is dark in (from, to), an interval in which darkness changes at most with the rod's two ends.
fn remove_dark(lit: &mut Vec<(f64, f64)>, from: f64, to: f64, dark: impl Fn(f64) -> bool) {
    const PROBES: u32 = 5;
    let probe = |i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(PROBES);
    let mut begin = dark(probe(0)).then_some(from);
    for i in 1..PROBES {
        let (mut a, mut b) = (probe(i - 1), probe(i));
        let was = begin.is_some();
        if dark(b) == was {
            continue;
        }
        for _ in 0..30 {
            let middle = 0.5 * (a + b);
            if dark(middle) == was {
                a = middle;
            } else {
                b = middle;
            }
        }
        match begin.take() {
            Some(start) => cut(lit, start, b),
            None => begin = Some(b),
        }
    }
    if let Some(start) = begin {
        cut(lit, start, to);
    }
}

fn cut(lit: &mut Vec<(f64, f64)>, from: f64, to: f64) {
    let halves = lit
        .iter()
        .flat_map(|&(a, b)| [(a, b.min(from)), (a.max(to), b)]);
    *lit = halves.filter(|(a, b)| b - a > MIN_STRETCH_M).collect();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cutting_keeps_what_lies_on_either_side() {
        let mut lit = vec![(0.0, 4.0)];
        cut(&mut lit, 1.0, 2.0);
        cut(&mut lit, 1.5, 3.0);
        assert_eq!(lit, [(0.0, 1.0), (3.0, 4.0)]);
        cut(&mut lit, 0.0, 4.0);
        assert!(lit.is_empty());
    }

    #[test]
    fn dark_interval_is_found_to_rounding() {
        let mut lit = vec![(0.0, 4.0)];
        remove_dark(&mut lit, 0.5, 3.0, |t| (1.1..2.2).contains(&t));
        assert_eq!(lit.len(), 2);
        assert!(
            (lit[0].1 - 1.1).abs() < 1e-8 && (lit[1].0 - 2.2).abs() < 1e-8,
            "{lit:?}"
        );
    }
}
