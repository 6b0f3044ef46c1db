//! The sea floor: a plane with a band-limited procedural albedo.

use core::f64::consts::TAU;

use rodsight_geometry::Vec3;
use rodsight_scene::{Ripples, Seabed};

use super::solid::{Ray, facing};
use crate::lattice::pcg;

/// Distance along a ray to the floor; `None` if it never gets there.
pub(super) fn hit(seabed: &Seabed, ray: &Ray) -> Option<f64> {
    let t = (seabed.z_m - ray.origin_m.z) / ray.direction.z;
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// The normal of rippled sand: crests wander by 0.8 rad of their phase over five wavelengths. Ripples finer than two samples are
/// left out.
pub(crate) fn rippled_normal(ripples: &Ripples, ray: &Ray, t_m: f64, footprint_m: f64) -> Vec3 {
    const WANDER_RAD: f64 = 0.8;
    let fade = (ripples.wavelength_m / (2.0 * footprint_m) - 1.0).clamp(0.0, 1.0);
    let point_m = ray.at(t_m);
    let (sin, cos) = libm::sincos(ripples.heading_rad);
    let wavenumber = TAU / ripples.wavelength_m;
    let (u, v) = (
        point_m.x * cos + point_m.y * sin,
        point_m.y * cos - point_m.x * sin,
    );
    // Height ½ h cos(k u + w sin(k v / 5)), upwards.
    let (bend_sin, bend_cos) = libm::sincos(0.2 * wavenumber * v);
    let steepness = -0.5
        * ripples.height_m
        * wavenumber
        * fade
        * libm::sin(wavenumber * u + WANDER_RAD * bend_sin);
    let (along_u, along_v) = (steepness, steepness * 0.2 * WANDER_RAD * bend_cos);
    let slope = [along_u * cos - along_v * sin, along_u * sin + along_v * cos];
    let normal = Vec3::new(-slope[0], -slope[1], -1.0);
    facing(&normal, &ray.direction, &-Vec3::z())
}

/// Albedo at a point of the floor, seen with samples `footprint_m` apart: octaves of value noise finer than two samples are left
/// out, so that one sample a pixel does not alias.
pub(crate) fn albedo(seabed: &Seabed, seed: u64, point_m: &Vec3, footprint_m: f64) -> [f64; 3] {
    let seed_word = seed_word(seed);
    let mut relief = 0.0;
    let (mut wavelength, mut amplitude) = (seabed.texture_scale_m, 0.5);
    for octave in 0..8 {
        let fade = (wavelength / (2.0 * footprint_m) - 1.0).clamp(0.0, 1.0);
        if fade == 0.0 {
            break;
        }
        relief += fade
            * amplitude
            * value_noise(
                seed_word,
                octave,
                point_m.x / wavelength,
                point_m.y / wavelength,
            );
        wavelength *= 0.5;
        amplitude *= 0.6;
    }
    let factor = (1.0 + seabed.texture_contrast * relief).max(0.0);
    seabed.albedo.map(|a| (a * factor).min(1.0))
}

/// Smooth noise in [−1, 1] with a node at every integer.
pub(crate) fn value_noise(seed_word: u32, octave: u32, x: f64, y: f64) -> f64 {
    let (x0, y0) = (libm::floor(x), libm::floor(y));
    let smooth = |s: f64| s * s * s * (s * (6.0 * s - 15.0) + 10.0);
    let (sx, sy) = (smooth(x - x0), smooth(y - y0));
    let node = |i: f64, j: f64| hash(seed_word, octave, (x0 + i) as i64, (y0 + j) as i64);
    let row = |j: f64| node(0.0, j) * (1.0 - sx) + node(1.0, j) * sx;
    row(0.0) * (1.0 - sy) + row(1.0) * sy
}

/// All of a scene's seed in 32 bits.
pub(crate) fn seed_word(seed: u64) -> u32 {
    pcg((seed >> 32) as u32 ^ pcg(seed as u32))
}

/// A number in [−1, 1) for a node: 24 bits, which `f32` holds too.
pub(crate) fn hash(seed_word: u32, octave: u32, i: i64, j: i64) -> f64 {
    let column = pcg((i as u32).wrapping_add(pcg(octave.wrapping_add(seed_word))));
    let word = pcg((j as u32).wrapping_add(column));
    f64::from(word >> 8) / f64::from(1 << 23) - 1.0
}
