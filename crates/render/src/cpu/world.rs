//! A scene prepared for ray-casting.

use rodsight_geometry::{Eye, MountedCamera, Pixel, Vec3};
use rodsight_optics::Bands;
use rodsight_scene::{Material, Mode, Scene};

use super::light::LampLight;
use super::rod::Rods;
use super::seabed;
use super::solid::{Face, Ray};

/// A scene with what can be computed once.
#[derive(Debug)]
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) rods: Rods,
    pub(crate) lamps: Vec<LampLight>,
    /// Attenuation of a surface's light on its way to the camera: c, or nothing in mode `air`.
    pub(crate) attenuation_per_m: Bands,
    /// Attenuation of a lamp's light, and of what the water scatters back: K in mode `full`, else the same.
    pub(crate) lamp_attenuation_per_m: Bands,
    /// Scattering that counts as such there: b, or b(1 − ⟨cos θ⟩) in mode `full`.
    pub(crate) scattering_per_m: Bands,
    /// Beyond this the water sends no more light, m.
    pub(crate) horizon_m: f64,
    /// Angle between the rays of neighbouring pixels of the coarser eye, rad: one for both, so that textures agree.
    pub(crate) footprint_rad: f64,
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
        let rods = Rods::new(&scene.rods);
        let pieces = || {
            let silhouettes = rods.solids.iter().map(|rod| rod.silhouette.iter());
            silhouettes.flatten().copied()
        };
        let lamps = scene
            .lamps
            .iter()
            .map(|lamp| LampLight::new(lamp, pieces()))
            .collect();
        let medium = &scene.medium;
        let attenuation_per_m = match scene.mode {
            Mode::Air => [0.0; 3],
            _ => medium.beam_attenuation_per_m(),
        };
        let lamp_attenuation_per_m = match scene.mode {
            Mode::Full => medium.transport_attenuation_per_m(),
            _ => attenuation_per_m,
        };
        let absorption = medium.absorption_per_m();
        let scattering_per_m = match scene.mode {
            Mode::Full => core::array::from_fn(|k| lamp_attenuation_per_m[k] - absorption[k]),
            _ => medium.scattering_per_m(),
        };
        // e^(−12) of the light comes from farther away.
        let clearest = lamp_attenuation_per_m
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        Self {
            scene,
            rods,
            lamps,
            attenuation_per_m,
            lamp_attenuation_per_m,
            scattering_per_m,
            horizon_m: (12.0 / clearest).min(1e4),
            footprint_rad: Eye::BOTH
                .map(|eye| pixel_angle_rad(scene.rig.eye(eye)))
                .into_iter()
                .fold(0.0, f64::max),
        }
    }

    /// The first surface on a ray.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        let floor = self
            .scene
            .seabed
            .as_ref()
            .and_then(|seabed| seabed::hit(seabed, ray));
        let floor = floor.map(|t_m| Hit {
            t_m,
            normal: Vec3::new(0.0, 0.0, -ray.direction.z.signum()),
            thing: Thing::Seabed,
            face: Face::Side,
        });
        let rod = self.rods.hit(ray).map(|(index, hit)| Hit {
            t_m: hit.t_m,
            normal: hit.normal,
            thing: Thing::Rod(index),
            face: hit.face,
        });
        match (floor, rod) {
            (Some(floor), Some(rod)) => Some(if rod.t_m < floor.t_m { rod } else { floor }),
            (floor, rod) => floor.or(rod),
        }
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
        self.rods.graze(ray, footprint_rad)
    }

    pub(super) fn material(&self, ray: &Ray, hit: &Hit) -> Material {
        match hit.thing {
            Thing::Rod(index) => self.scene.rods[index].material,
            Thing::Seabed => {
                let seabed = self.scene.seabed.as_ref().expect("a ray hit the seabed");
                let along_floor = hit.t_m * self.footprint_rad / ray.direction.z.abs().max(1e-3);
                Material::Lambert(seabed::albedo(
                    seabed,
                    self.scene.seed,
                    &ray.at(hit.t_m),
                    along_floor,
                ))
            }
        }
    }
}

/// Rays nearer than this to a limb take all samples: half a diagonal of the pixel, and as much again, as shading is steepest beside
/// a limb. Of the lens in air: behind a port rays part more slowly, but not from one point.
pub(crate) fn graze_rad(mounted: &MountedCamera) -> f64 {
    1.5 * pixel_angle_rad(&MountedCamera {
        port: None,
        ..*mounted
    })
}

/// The largest angle between the rays of neighbouring pixels, rad. A pinhole has it at its principal point, 1/f; a distorted lens or
/// one behind a port is asked on a grid, as nothing changes fast in a lens.
pub(super) fn pixel_angle_rad(mounted: &MountedCamera) -> f64 {
    const STEPS: u32 = 16;
    let (camera, port) = (&mounted.camera, &mounted.port);
    let i = camera.intrinsics();
    let on_axis = 1.0 / i.fx_px.min(i.fy_px);
    if mounted.is_pinhole() {
        return on_axis;
    }
    let mut largest = if port.is_none() { on_axis } else { 0.0 };
    let ray = |pixel: &Pixel| {
        let in_air = camera.ray(pixel)?;
        match port {
            None => Some(in_air),
            Some(port) => Some(port.water_ray(&in_air)?.direction),
        }
    };
    let step =
        |cells: u32, size_px: u32| (f64::from(size_px) - 1.0) * f64::from(cells) / f64::from(STEPS);
    for (column, row) in (0..=STEPS).flat_map(|c| (0..=STEPS).map(move |r| (c, r))) {
        let corner = Pixel::new(step(column, i.width_px), step(row, i.height_px));
        let across = [Pixel::x(), Pixel::y()].map(|one| ray(&(corner + one)));
        if let (Some(here), [Some(right), Some(below)]) = (ray(&corner), across) {
            largest = largest
                .max((right - here).norm())
                .max((below - here).norm());
        }
    }
    largest
}
