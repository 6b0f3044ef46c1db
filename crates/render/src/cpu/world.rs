//! A scene prepared for ray-casting.

use rodsight_geometry::{Eye, MountedCamera, Pixel, Vec3};
use rodsight_optics::{Bands, Coat, ForwardLobe};
use rodsight_scene::{Material, Mode, Scene};

use super::bodies::Bodies;
use super::finish;
use super::light::LampLight;
use super::penumbra::soft_lobes;
use super::rod::Rods;
use super::seabed;
use super::solid::{Face, Ray};
use super::triangles::TriangleHit;

/// A scene with what can be computed once.
#[derive(Debug)]
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) rods: Rods,
    pub(crate) bodies: Bodies,
    pub(crate) lamps: Vec<LampLight>,
    /// Attenuation of a surface's light on its way to the camera: c, or nothing in mode `air`.
    pub(crate) attenuation_per_m: Bands,
    /// Attenuation of a lamp's light, and of what the water scatters back: K in mode `full`, else the same.
    pub(crate) lamp_attenuation_per_m: Bands,
    /// How the light that the difference of both attenuations leaves is spread about the lamp, in mode `full`.
    pub(crate) soft_lobes: Vec<ForwardLobe>,
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
    /// As light sees it: ripples and rounded meshes turn it away from the surface's own.
    pub(crate) normal: Vec3,
    /// Of the surface itself.
    pub(crate) face_normal: Vec3,
    pub(crate) thing: Thing,
    pub(crate) face: Face,
    /// Different where two smooth surfaces of one thing meet in a crease.
    pub(crate) part: u32,
    detail: Detail,
}

/// Where on a thing of many pieces.
#[derive(Clone, Copy, Debug)]
enum Detail {
    None,
    Solid(usize),
    Triangle(TriangleHit),
}

/// Something with a number in the instance channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Seabed,
    Rod(usize),
    Occluder(usize),
    Prop(usize),
    /// What grows on a rod.
    Growth(usize),
    Stones,
}

impl Thing {
    pub(crate) fn material(self) -> u16 {
        match self {
            Self::Seabed => 1,
            Self::Rod(_) => 2,
            Self::Occluder(_) => 3,
            Self::Prop(_) => 4,
            Self::Growth(_) => 5,
            Self::Stones => 6,
        }
    }
}

/// What a surface does with light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) material: Material,
    /// Over the matt surface.
    pub(super) coat: Option<Coat>,
}

impl<'a> World<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let rods = Rods::new(&scene.rods);
        let pieces = || {
            let rods = rods.solids.iter().enumerate();
            rods.flat_map(|(rod, solid)| solid.silhouette.iter().map(move |piece| (rod, *piece)))
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
            bodies: Bodies::new(scene),
            lamps,
            attenuation_per_m,
            lamp_attenuation_per_m,
            soft_lobes: match scene.mode {
                Mode::Full => soft_lobes(medium),
                _ => Vec::new(),
            },
            scattering_per_m,
            horizon_m: (12.0 / clearest).min(1e4),
            footprint_rad: Eye::BOTH
                .map(|eye| pixel_angle_rad(scene.rig.eye(eye)))
                .into_iter()
                .fold(0.0, f64::max),
        }
    }

    /// The number of a thing in the instance channel.
    pub(crate) fn instance(&self, thing: Thing) -> u16 {
        match thing {
            Thing::Seabed => 1,
            Thing::Rod(index) => self.scene.rod_instance(index),
            Thing::Occluder(index) => self.scene.occluder_instance(index),
            Thing::Prop(index) => self.scene.prop_instance(index),
            Thing::Growth(rod) => self.scene.growth_instance(rod),
            Thing::Stones => self.scene.stones_instance(),
        }
    }

    /// The material of each instance.
    pub(crate) fn materials(&self) -> Vec<u16> {
        let scene = self.scene;
        let things = [
            (1, Thing::Seabed.material()),
            (scene.rods.len(), Thing::Rod(0).material()),
            (scene.occluders.len(), Thing::Occluder(0).material()),
            (scene.props.len(), Thing::Prop(0).material()),
            (scene.rods.len(), Thing::Growth(0).material()),
            (1, Thing::Stones.material()),
        ];
        let numbered = things
            .into_iter()
            .flat_map(|(count, material)| core::iter::repeat_n(material, count));
        core::iter::once(0).chain(numbered).collect()
    }

    /// The first surface on a ray.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        let candidates = [
            self.floor(ray),
            self.rods.hit(ray).map(|(index, hit)| Hit {
                t_m: hit.t_m,
                normal: hit.normal,
                face_normal: hit.normal,
                thing: Thing::Rod(index),
                face: hit.face,
                part: 0,
                detail: Detail::None,
            }),
            self.bodies.hit(ray).map(|(index, hit)| {
                let body = &self.bodies.solids[index];
                Hit {
                    t_m: hit.t_m,
                    normal: hit.normal,
                    face_normal: hit.normal,
                    thing: body.thing,
                    face: Face::Side,
                    part: body.part,
                    detail: Detail::Solid(index),
                }
            }),
            self.mesh(ray),
        ];
        let nearer = |a: Hit, b: Hit| if b.t_m < a.t_m { b } else { a };
        candidates.into_iter().flatten().reduce(nearer)
    }

    fn floor(&self, ray: &Ray) -> Option<Hit> {
        let seabed = self.scene.seabed.as_ref()?;
        let t_m = seabed::hit(seabed, ray)?;
        let face_normal = Vec3::new(0.0, 0.0, -ray.direction.z.signum());
        let normal = match &seabed.ripples {
            Some(ripples) if face_normal.z < 0.0 => {
                seabed::rippled_normal(ripples, ray, t_m, self.along_floor_m(ray, t_m))
            }
            _ => face_normal,
        };
        Some(Hit {
            t_m,
            normal,
            face_normal,
            thing: Thing::Seabed,
            face: Face::Side,
            part: 0,
            detail: Detail::None,
        })
    }

    fn mesh(&self, ray: &Ray) -> Option<Hit> {
        let triangles = &self.bodies.triangles;
        let hit = triangles.hit(ray)?;
        let (normal, face_normal) = triangles.normals_at(&hit, ray);
        Some(Hit {
            t_m: hit.t_m,
            normal,
            face_normal,
            thing: Thing::Prop(triangles.paint(&hit).prop),
            face: Face::Side,
            part: triangles.patches[hit.index],
            detail: Detail::Triangle(hit),
        })
    }

    /// Whether something stands within the first `length_m` of a ray. The seabed, a plane below all, hides nothing from a lamp.
    pub(super) fn blocks(&self, ray: &Ray, length_m: f64) -> bool {
        self.rods.block(ray, length_m) || self.bodies.block(ray, length_m)
    }

    /// Whether anything hides a point from another.
    pub(crate) fn is_hidden(&self, point_m: &Vec3, from_m: &Vec3) -> bool {
        let to_point = point_m - from_m;
        let distance = to_point.norm();
        let ray = Ray {
            origin_m: *from_m,
            direction: to_point / distance,
        };
        let reach_m = distance * (1.0 - 1e-6) - 1e-6;
        let floor_m = self.scene.seabed.as_ref();
        let floor_m = floor_m.and_then(|seabed| seabed::hit(seabed, &ray));
        floor_m.is_some_and(|t_m| t_m < reach_m) || self.blocks(&ray, reach_m)
    }

    /// Whether a limb of a rod passes so near the ray that a single sample cannot stand for the pixel.
    pub(super) fn grazes_a_limb(&self, ray: &Ray, footprint_rad: f64) -> bool {
        self.rods.graze(ray, footprint_rad)
    }

    /// Distance between samples on the floor, m.
    fn along_floor_m(&self, ray: &Ray, t_m: f64) -> f64 {
        t_m * self.footprint_rad / ray.direction.z.abs().max(1e-3)
    }

    /// What the surface at a hit does with light.
    pub(super) fn look(&self, ray: &Ray, hit: &Hit) -> Look {
        let matt = |albedo: Bands| Look {
            material: Material::Lambert(albedo),
            coat: None,
        };
        match (hit.thing, hit.detail) {
            (Thing::Rod(index), _) => self.rod_look(index, ray, hit),
            (_, Detail::Solid(index)) => matt(self.bodies.solids[index].albedo),
            (_, Detail::Triangle(triangle)) => self.mesh_look(&triangle, ray, hit),
            _ => {
                let seabed = self.scene.seabed.as_ref().expect("a ray hit the seabed");
                let along_floor_m = self.along_floor_m(ray, hit.t_m);
                let point_m = ray.at(hit.t_m);
                matt(seabed::albedo(
                    seabed,
                    self.scene.seed,
                    &point_m,
                    along_floor_m,
                ))
            }
        }
    }

    fn rod_look(&self, index: usize, ray: &Ray, hit: &Hit) -> Look {
        let rod = &self.scene.rods[index];
        let mut look = Look {
            material: rod.material,
            coat: None,
        };
        // Ends are plain.
        let Material::Lambert(base) = rod.material else {
            return look;
        };
        let footprint_m = hit.t_m * self.footprint_rad;
        if hit.face == Face::Side {
            let arc = &self.rods.solids[index].arc;
            let seed_word = finish::seed_word(self.scene.seed, index);
            let at = (ray, hit.t_m, &hit.normal);
            let albedo = finish::albedo((rod, arc), &base, seed_word, at, footprint_m);
            look.material = Material::Lambert(albedo);
        }
        look.coat = rod.finish.gloss.map(|gloss| {
            let curvature_per_m = if hit.face == Face::Side {
                1.0 / rod.radius_m
            } else {
                0.0
            };
            let turn_rad = curvature_per_m * footprint_m / grazing(ray, hit);
            Coat::new(gloss.roughness, gloss.reflectance, turn_rad)
        });
        look
    }

    fn mesh_look(&self, triangle: &TriangleHit, ray: &Ray, hit: &Hit) -> Look {
        let triangles = &self.bodies.triangles;
        let footprint_m = hit.t_m * self.footprint_rad / grazing(ray, hit);
        let paint = triangles.paint(triangle);
        let (albedo, reflectance) = paint.split(triangles.base(triangle, footprint_m));
        let turn_rad = triangles.curvature_per_m(triangle.index) * footprint_m;
        Look {
            material: Material::Lambert(albedo),
            coat: Some(Coat::new(paint.roughness.max(0.05), reflectance, turn_rad)),
        }
    }
}

/// Cosine between the surface and what looks at it, kept away from zero.
fn grazing(ray: &Ray, hit: &Hit) -> f64 {
    hit.face_normal.dot(&ray.direction).abs().max(1e-3)
}

/// Rays nearer than this to a limb take more samples than one: half a diagonal of the pixel, and as much again, as shading is steepest
/// beside a limb. Of the lens in air: behind a port rays part more slowly, but not from one point.
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
