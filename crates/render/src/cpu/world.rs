//! A scene prepared for ray-casting.

use rodsight_geometry::Vec3;
use rodsight_optics::Bands;
use rodsight_scene::{Material, Mode, Scene};

use super::light::LampLight;
use super::seabed;
use super::solid::{Face, Ray, RodSolid};

/// A scene with what can be computed once.
#[derive(Debug)]
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    pub(super) rods: Vec<RodSolid>,
    pub(super) lamps: Vec<LampLight>,
    /// Attenuation on every leg: c, or nothing in mode `air`.
    pub(super) attenuation_per_m: Bands,
    /// Beyond this the water sends no more light, m.
    pub(super) horizon_m: f64,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t_m: f64,
    pub(crate) normal: Vec3,
    pub(crate) thing: Thing,
    pub(crate) face: Face,
}

/// Seabed or a rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Seabed,
    Rod(usize),
}

impl Thing {
    pub(crate) fn instance(self) -> u16 {
        match self {
            Self::Seabed => 1,
            Self::Rod(index) => index as u16 + 2,
        }
    }

    pub(crate) fn material(self) -> u16 {
        match self {
            Self::Seabed => 1,
            Self::Rod(_) => 2,
        }
    }
}

impl<'a> World<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let rods: Vec<RodSolid> = scene.rods.iter().map(RodSolid::new).collect();
        let pieces = || rods.iter().flat_map(|rod| rod.silhouette.iter().copied());
        let lamps = scene
            .lamps
            .iter()
            .map(|lamp| LampLight::new(lamp, pieces()))
            .collect();
        let attenuation_per_m = if scene.mode == Mode::Air {
            [0.0; 3]
        } else {
            scene.medium.beam_attenuation_per_m()
        };
        // e^(−12) of the light comes from farther away.
        let clearest = attenuation_per_m
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        Self {
            scene,
            rods,
            lamps,
            attenuation_per_m,
            horizon_m: (12.0 / clearest).min(1e4),
        }
    }

    /// The first surface on a ray.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        let floor = self
            .scene
            .seabed
            .as_ref()
            .and_then(|seabed| seabed::hit(seabed, ray));
        let mut first = floor.map(|t_m| Hit {
            t_m,
            normal: Vec3::new(0.0, 0.0, -ray.direction.z.signum()),
            thing: Thing::Seabed,
            face: Face::Side,
        });
        for (index, rod) in self.rods.iter().enumerate() {
            if let Some(hit) = rod.hit(ray)
                && first.is_none_or(|f| hit.t_m < f.t_m)
            {
                first = Some(Hit {
                    t_m: hit.t_m,
                    normal: hit.normal,
                    thing: Thing::Rod(index),
                    face: hit.face,
                });
            }
        }
        first
    }

    /// Whether anything hides a point from another.
    pub(crate) fn is_hidden(&self, point_m: &Vec3, from_m: &Vec3) -> bool {
        let to_point = point_m - from_m;
        let distance = to_point.norm();
        let ray = Ray {
            origin_m: *from_m,
            direction: to_point / distance,
        };
        self.hit(&ray)
            .is_some_and(|hit| hit.t_m < distance * (1.0 - 1e-6) - 1e-6)
    }

    /// Whether a limb of a rod passes so near the ray that a single sample cannot stand for the pixel.
    pub(super) fn grazes_a_limb(&self, ray: &Ray, footprint_rad: f64) -> bool {
        self.rods.iter().any(|rod| rod.grazes(ray, footprint_rad))
    }

    pub(super) fn material(&self, ray: &Ray, hit: &Hit) -> Material {
        match hit.thing {
            Thing::Rod(index) => self.scene.rods[index].material,
            Thing::Seabed => {
                let seabed = self.scene.seabed.as_ref().expect("a ray hit the seabed");
                let along_floor = hit.t_m * self.footprint_rad() / ray.direction.z.abs().max(1e-3);
                Material::Lambert(seabed::albedo(
                    seabed,
                    self.scene.seed,
                    &ray.at(hit.t_m),
                    along_floor,
                ))
            }
        }
    }

    /// Angle between the rays of neighbouring pixels, rad; the same for both eyes so that textures agree.
    pub(super) fn footprint_rad(&self) -> f64 {
        1.0 / self.scene.rig.left.camera.intrinsics().fx_px
    }
}
