//! What a scene's seed strews: growth over rods, stones over the seabed. One list for every backend.

use core::f64::consts::TAU;

use rodsight_geometry::{Eye, Mat3, Vec3};
use rodsight_optics::Bands;
use rodsight_scene::{Rod, Scene};

use crate::cpu::arc::Arc;
use crate::noise::Philox;

/// An ellipsoid: the unit ball through `axes_m` (columns: half axes) about its centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lump {
    pub(crate) centre_m: Vec3,
    pub(crate) axes_m: Mat3,
    pub(crate) albedo: Bands,
}

/// Streams of random numbers, apart from those of the sensor.
const GROWTH: u64 = 0x6772_6f77_7468;
const STONES: u64 = 0x7374_6f6e_6573;

/// Lumps on the side of a rod: spheroids about points of its surface, up to the height asked for over it and one to two and a half
/// times as wide as high. As many as cover, by chance, the share asked for: 1 − e^(−n a/A) of a surface A under n discs of mean
/// area a (the Boolean model; Chiu et al., Stochastic Geometry and its Applications, 2013, §3.1).
pub(crate) fn growth(scene: &Scene, index: usize) -> Vec<Lump> {
    let rod = &scene.rods[index];
    let Some(fouling) = rod.fouling else {
        return Vec::new();
    };
    let arc = Arc::of(rod);
    let random = Philox::new(scene.seed ^ GROWTH);
    let count = libm::round(fouling.lumps(rod)) as u32;
    (0..count)
        .map(|k| {
            let [along, around, tall, wide] = random.uniforms([k, index as u32, 0, 0]);
            let [shade, ..] = random.uniforms([k, index as u32, 1, 0]);
            let s_m = rod.length_m * (along - 0.5);
            let axis = arc.at(s_m);
            let [e1, e2] = arc.across(s_m);
            let (sin, cos) = libm::sincos(TAU * around);
            let outwards = e1 * cos + e2 * sin;
            let height_m = fouling.height_m * (0.25 + 0.75 * tall);
            let width_m = height_m * (1.0 + 1.5 * wide);
            Lump {
                centre_m: axis.point_m + outwards * rod.radius_m,
                axes_m: Mat3::from_columns(&[
                    outwards * height_m,
                    axis.direction * width_m,
                    axis.direction.cross(&outwards) * width_m,
                ]),
                albedo: fouling.albedo.map(|a| a * (0.6 + 0.4 * shade)),
            }
        })
        .collect()
}

/// Stones on the seabed: flattened ellipsoids, up to two thirds of their height out of the sand, none that touches a rod or is where a
/// camera or a lamp is.
pub(crate) fn stones(scene: &Scene) -> Vec<Lump> {
    let Some((seabed, clutter)) = scene.seabed.and_then(|s| Some((s, s.clutter?))) else {
        return Vec::new();
    };
    let random = Philox::new(scene.seed ^ STONES);
    let area_m2 = core::f64::consts::PI * clutter.reach_m * clutter.reach_m;
    let count = libm::round(clutter.stones_per_m2 * area_m2) as u32;
    let [smallest, largest] = clutter.diameter_m;
    let strewn = (0..count).map(|k| {
        let [far, angle, size, turn] = random.uniforms([k, 0, 0, 0]);
        let [long, flat, sunk, shade] = random.uniforms([k, 1, 0, 0]);
        let (sin, cos) = libm::sincos(TAU * angle);
        let distance_m = clutter.reach_m * far.sqrt();
        let half_m = 0.5 * smallest * libm::pow(largest / smallest, size);
        let (s, c) = libm::sincos(TAU * turn);
        let up_m = half_m * (0.5 + 0.3 * flat);
        // Between a third and two thirds of it in the sand.
        let z_m = seabed.z_m + up_m * (2.0 * sunk - 1.0) / 3.0;
        Lump {
            centre_m: Vec3::new(distance_m * cos, distance_m * sin, z_m),
            axes_m: Mat3::from_columns(&[
                Vec3::new(c, s, 0.0) * half_m,
                Vec3::new(-s, c, 0.0) * (half_m * (0.65 + 0.35 * long)),
                Vec3::new(0.0, 0.0, up_m),
            ]),
            albedo: clutter.albedo.map(|a| a * (0.5 + shade)),
        }
    });
    strewn.filter(|stone| lies_free(scene, stone)).collect()
}

/// Whether a stone keeps off rods, cameras and lamps, by the ball around it.
fn lies_free(scene: &Scene, stone: &Lump) -> bool {
    let reach_m = stone.axes_m.column(0).norm();
    let centre_m = stone.centre_m;
    let off = |point_m: Vec3, margin_m: f64| (point_m - centre_m).norm() > reach_m + margin_m;
    let nearest_m = |rod: &Rod| {
        let half_m = 0.5 * rod.length_m;
        rod.axis_at(rod.nearest_along_m(&centre_m).clamp(-half_m, half_m))
            .0
    };
    scene
        .rods
        .iter()
        .all(|rod| off(nearest_m(rod), rod.radius_m))
        && Eye::BOTH
            .iter()
            .all(|&eye| off(scene.rig.eye(eye).rig_from_camera.origin_m(), 0.02))
        && scene.lamps.iter().all(|lamp| off(lamp.position_m, 0.02))
}
