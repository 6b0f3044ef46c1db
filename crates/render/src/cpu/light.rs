//! Light: lamps, their cones and shadows, surfaces, and the light scattered back by the water.

use rodsight_geometry::Vec3;
use rodsight_optics::{Airlight, Bands, Cosines, Daylight, transmittance};
use rodsight_scene::{Lamp, Material, Mode};

use super::shadow::{MIN_STRETCH_M, Shadows};
use super::solid::{Capped, Ray};
use super::world::{Hit, Thing, World};
use crate::lattice::pcg;

/// Lengths of shadow rays end this much short of their surface, relative and absolute.
const SHADOW_GAP: f64 = 1e-6;

/// Fraction of the axial intensity that a lamp sends in a unit direction: 1 in the inner cone, 0 outside the outer one, smooth
/// (cubic in the cosine) between.
pub(crate) fn cone(lamp: &LampLight, direction: &Vec3) -> f64 {
    // Rounding must not put a direction just behind a lamp that shines everywhere out of its cone.
    let cos = lamp.lamp.direction.dot(direction).max(-1.0);
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
pub(crate) struct LampLight {
    pub(crate) lamp: Lamp,
    pub(crate) cos_inner: f64,
    pub(crate) cos_outer: f64,
    pub(crate) shadows: Shadows,
}

impl LampLight {
    pub(crate) fn new(lamp: &Lamp, pieces: impl Iterator<Item = (usize, Capped)>) -> Self {
        Self {
            lamp: *lamp,
            cos_inner: libm::cos(lamp.inner_half_angle_rad),
            cos_outer: libm::cos(lamp.outer_half_angle_rad),
            shadows: Shadows::new(lamp.position_m, pieces),
        }
    }
}

/// Light that leaves a surface towards the camera, and which lamps reach it, as a sum of hashes.
pub(super) struct Surface {
    /// In the water.
    pub(super) wet: Bands,
    /// Without any water.
    pub(super) dry: Bands,
    pub(super) lit_by: u32,
}

/// The cosines of a coat's reflection; `light` and the ray look at the surface.
fn cosines(normal: &Vec3, light: &Vec3, ray: &Ray) -> Cosines {
    let half = -(light + ray.direction).normalize();
    Cosines {
        light: -normal.dot(light),
        eye: (-normal.dot(&ray.direction)).max(1e-4),
        half: normal.dot(&half).clamp(0.0, 1.0),
        ray_half: (-half.dot(&ray.direction)).clamp(0.0, 1.0),
    }
}

impl World<'_> {
    /// Lambert, coated or not: L = Σ ρ/π · I cos θ / r² · e^(−K r) + ρ `L_ambient` (K is c but in mode `full`); a flat surface sends its
    /// own radiance.
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let look = self.look(ray, hit);
        let albedo = match look.material {
            Material::Flat(radiance) => {
                return Surface {
                    wet: radiance,
                    dry: radiance,
                    lit_by: 0,
                };
            }
            Material::Lambert(albedo) => albedo,
        };
        let point = ray.at(hit.t_m);
        let [wet, dry] = self.ambient_on(&point, -hit.normal.z);
        let mut surface = Surface {
            wet: core::array::from_fn(|k| albedo[k] * wet[k]),
            dry: core::array::from_fn(|k| albedo[k] * dry[k]),
            lit_by: 0,
        };
        if self.scene.mode == Mode::Koschmieder {
            return surface;
        }
        for (index, light) in self.lamps.iter().enumerate() {
            let to_point = point - light.lamp.position_m;
            let r = to_point.norm();
            let direction = to_point / r;
            let cos = -hit.normal.dot(&direction);
            let beam = cone(light, &direction);
            let lit = cos > 0.0 && hit.face_normal.dot(&direction) < 0.0;
            if !lit || beam == 0.0 {
                continue;
            }
            let own = match hit.thing {
                Thing::Rod(rod) => Some(rod),
                _ => None,
            };
            let Some((is_sharp, arriving)) = self.arriving(light, &point, own) else {
                continue;
            };
            surface.lit_by ^= u32::from(is_sharp) * pcg(index as u32);
            let reflection = match &look.coat {
                Some(coat) => coat.reflection(&albedo, &cosines(&hit.normal, &direction, ray)),
                None => albedo,
            };
            for k in 0..3 {
                let dry = reflection[k] * light.lamp.radiant_intensity_w_per_sr[k] * beam * cos
                    / (core::f64::consts::PI * r * r);
                surface.dry[k] += if is_sharp { dry } else { 0.0 };
                surface.wet[k] += dry * arriving[k];
            }
        }
        surface
    }

    /// Whether a lamp shines on a place straight, and the share of its light that arrives there: e^(−K r) without rods. In mode `full`
    /// a rod's shadow is sharp in e^(−c r) and soft in the rest: V e^(−c r) + V soft (e^(−K r) − e^(−c r)). Other bodies' shadows are sharp
    /// in all of it: then nothing arrives.
    fn arriving(
        &self,
        light: &LampLight,
        point_m: &Vec3,
        own: Option<usize>,
    ) -> Option<(bool, Bands)> {
        let lamp_m = light.lamp.position_m;
        let to_point = point_m - lamp_m;
        let r = to_point.norm();
        let ray = Ray {
            origin_m: lamp_m,
            direction: to_point / r,
        };
        let reach = r * (1.0 - SHADOW_GAP) - SHADOW_GAP;
        let is_sharp = !self.rods.block(&ray, reach);
        if (!is_sharp && self.soft_lobes.is_empty()) || self.bodies.block(&ray, reach) {
            return None;
        }
        let all = transmittance(&self.lamp_attenuation_per_m, r);
        if self.soft_lobes.is_empty() {
            return Some((true, all));
        }
        let soft = light.shadows.soft_share(point_m, &self.soft_lobes, own);
        if is_sharp && soft == 1.0 {
            return Some((true, all));
        }
        let sharp = transmittance(&self.attenuation_per_m, r);
        let straight = f64::from(u8::from(is_sharp));
        // Where more is scattered back than on, K is the larger: nothing is soft then.
        let sum = |k: usize| straight * sharp[k].min(all[k]) + soft * (all[k] - sharp[k]).max(0.0);
        Some((is_sharp, core::array::from_fn(sum)))
    }

    /// The radiance of a white matt surface in ambient light and daylight, by the upward part of its normal: in the water, and without
    /// any as bright as at the rig. Nothing throws a shadow in either.
    pub(super) fn ambient_on(&self, point_m: &Vec3, normal_up: f64) -> [Bands; 2] {
        let ambient = self.scene.ambient_radiance;
        let Some(daylight) = &self.scene.daylight else {
            return [ambient; 2];
        };
        let share = Daylight::face_share(normal_up) / core::f64::consts::PI;
        let dry = core::array::from_fn(|k| ambient[k] + share * daylight.irradiance_w_per_m2[k]);
        if self.scene.mode == Mode::Air {
            return [dry; 2];
        }
        let there = daylight.downwelling(point_m.z);
        [core::array::from_fn(|k| ambient[k] + share * there[k]), dry]
    }

    pub(super) fn is_blocked(&self, lamp_m: &Vec3, direction: &Vec3, distance_m: f64) -> bool {
        let ray = Ray {
            origin_m: *lamp_m,
            direction: *direction,
        };
        let reach = distance_m * (1.0 - SHADOW_GAP) - SHADOW_GAP;
        self.blocks(&ray, reach)
    }

    /// Whether lamps light the water.
    pub(super) fn has_airlight(&self) -> bool {
        !matches!(self.scene.mode, Mode::Air | Mode::Koschmieder)
            && !self.scene.medium.is_vacuum()
            && !self.lamps.is_empty()
    }

    /// Light the water scatters into a ray of the given length (infinite where there is no surface): single scattering of every
    /// lamp, shadowed by the rods, and the veil of the ambient light. `unshadowed` is what the lamps' would be without rods.
    pub(super) fn backscatter(&self, ray: &Ray, distance_m: f64, unshadowed: &Bands) -> Bands {
        let mut light = self.veil(ray, distance_m);
        if !self.has_airlight() {
            return light;
        }
        let mut lamps = *unshadowed;
        let distance_m = distance_m.min(self.horizon_m);
        for lamp in &self.lamps {
            let mut lit_from_m = 0.0_f64;
            for (from_m, to_m) in lamp.shadows.dark_stretches(ray, distance_m) {
                let from_m = from_m.max(lit_from_m);
                if to_m - from_m > MIN_STRETCH_M {
                    let points = self.points_on(lamp, ray, from_m, to_m);
                    let missing = self.scattered(lamp, ray, from_m, to_m, points);
                    lamps = core::array::from_fn(|k| lamps[k] - missing[k]);
                }
                lit_from_m = lit_from_m.max(to_m);
            }
        }
        // Where all of it is in the dark, the two sums differ by their quadratures.
        for k in 0..3 {
            light[k] += lamps[k].max(0.0);
        }
        light
    }

    /// The veil of the ambient light, B∞ (1 − e^(−c z)) with B∞ = b L / c, and of daylight. In mode `full` K and b(1 − ⟨cos θ⟩) stand for
    /// c and b: light scattered forwards stays what it was.
    pub(super) fn veil(&self, ray: &Ray, distance_m: f64) -> Bands {
        let (c, b) = (&self.lamp_attenuation_per_m, &self.scattering_per_m);
        let ambient = &self.scene.ambient_radiance;
        let sky = self.scene.daylight.as_ref();
        if self.scene.mode == Mode::Air || (*ambient == [0.0; 3] && sky.is_none()) {
            return [0.0; 3];
        }
        let sky = sky.map_or([0.0; 3], |sky| {
            sky.veil([c, b], ray.origin_m.z, ray.direction.z, distance_m)
        });
        core::array::from_fn(|k| {
            let veil = if distance_m.is_finite() {
                -libm::expm1(-c[k] * distance_m)
            } else {
                1.0
            };
            if c[k] > 0.0 {
                b[k] / c[k] * ambient[k] * veil + sky[k]
            } else {
                0.0
            }
        })
    }

    /// What all lamps' light would add to a stretch of a ray if nothing stood in it.
    pub(super) fn unshadowed(&self, ray: &Ray, from_m: f64, to_m: f64, points: u32) -> Bands {
        self.lamps.iter().fold([0.0; 3], |sum: Bands, lamp| {
            let light = self.scattered(lamp, ray, from_m, to_m.min(self.horizon_m), points);
            core::array::from_fn(|k| sum[k] + light[k])
        })
    }

    /// The same per metre, at a distance.
    pub(super) fn unshadowed_per_m(&self, ray: &Ray, distance_m: f64) -> Bands {
        let airlight = self.airlight(1);
        self.lamps.iter().fold([0.0; 3], |sum: Bands, light| {
            let lamp = &light.lamp;
            let gain = airlight.lamp_per_m(
                &(lamp.position_m - ray.origin_m),
                &ray.direction,
                distance_m,
                |direction, _| cone(light, direction),
            );
            core::array::from_fn(|k| sum[k] + lamp.radiant_intensity_w_per_sr[k] * gain[k])
        })
    }

    /// What one lamp's light adds to a stretch of a ray; nothing if it ends before it begins.
    fn scattered(
        &self,
        light: &LampLight,
        ray: &Ray,
        from_m: f64,
        to_m: f64,
        points: u32,
    ) -> Bands {
        let lamp = &light.lamp;
        let scattered = self.airlight(points).lamp(
            &(lamp.position_m - ray.at(from_m)),
            &ray.direction,
            to_m - from_m,
            |direction, _| cone(light, direction),
        );
        let before = transmittance(&self.lamp_attenuation_per_m, from_m);
        core::array::from_fn(|k| lamp.radiant_intensity_w_per_sr[k] * scattered[k] * before[k])
    }

    /// Midpoints of a stretch: as dense in the angle about the lamp as the scene's are on half a turn, and four at least.
    fn points_on(&self, light: &LampLight, ray: &Ray, from_m: f64, to_m: f64) -> u32 {
        let points = self.scene.sampling.airlight_points;
        let from = ray.at(from_m) - light.lamp.position_m;
        let to = ray.at(to_m) - light.lamp.position_m;
        let angle_rad = libm::atan2(from.cross(&to).norm(), from.dot(&to));
        let dense = libm::ceil(f64::from(points) * angle_rad / core::f64::consts::PI) as u32;
        dense.clamp(points.min(4), points)
    }

    fn airlight(&self, points: u32) -> Airlight<'_> {
        Airlight {
            medium: &self.scene.medium,
            attenuation_per_m: self.lamp_attenuation_per_m,
            points,
        }
    }
}
