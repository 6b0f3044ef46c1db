//! Daylight, through the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use core::f64::consts::PI;

use rodsight_geometry::{Eye, Pixel, Vec3};
use rodsight_optics::{Daylight, water};
use rodsight_render::{CpuRenderer, EyeFrame};
use rodsight_scene::{Material, Mode, Rod, Scene, Seabed};

const IRRADIANCE: [f64; 3] = [2.0, 9.0, 7.0];
const ALBEDO: [f64; 3] = [0.4, 0.3, 0.2];

fn render(scene: &Scene) -> EyeFrame {
    CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
}

/// No lamp, a plain floor.
fn sunlit(mode: Mode) -> Scene {
    let mut scene = common::empty(16);
    scene.mode = mode;
    scene.medium = water::by_name("1C").unwrap().medium();
    scene.daylight = Some(Daylight {
        irradiance_w_per_m2: IRRADIANCE,
        diffuse_attenuation_per_m: [0.3, 0.13, 0.17],
    });
    scene.seabed = Some(Seabed {
        z_m: 0.6,
        albedo: ALBEDO,
        texture_contrast: 0.0,
        texture_scale_m: 0.1,
        ripples: None,
        clutter: None,
    });
    scene
}

/// A floor takes all of `E_d` at its depth, an upright wall half of that: L = ρ/π E e^(−k z) [1 or ½] e^(−c t).
#[test]
fn floors_and_walls_are_lit_as_their_normals_say() {
    for mode in [Mode::Koschmieder, Mode::Single, Mode::Full] {
        let mut scene = sunlit(mode);
        scene.rods.push(Rod {
            length_m: 2e4,
            material: Material::Lambert(ALBEDO),
            ..common::flat_rod(Vec3::new(1e4 + 6.0, 0.0, 0.0), Vec3::z(), 1e4)
        });
        let frame = render(&scene);
        let (mut floors, mut walls) = (0, 0);
        for (index, pixel) in frame.pixels.iter().enumerate() {
            let (column, row) = (index as u32 % frame.width_px, index as u32 / frame.width_px);
            let beside = |rows: u32| frame.at(column, (row + rows).clamp(1, 66) - 1).instance;
            if beside(0) != beside(2) {
                continue; // an edge
            }
            let centre = Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let (from_m, along) = scene.rig.left.ray(&centre).unwrap();
            let depth_m = from_m.z + along.z * f64::from(pixel.range_m);
            let share = if pixel.instance == 1 { 1.0 } else { 0.5 };
            *(if pixel.instance == 1 {
                &mut floors
            } else {
                &mut walls
            }) += 1;
            for k in 0..3 {
                let kd = [0.3, 0.13, 0.17][k];
                let c = scene.medium.beam_attenuation_per_m()[k];
                let dry = ALBEDO[k] / PI * IRRADIANCE[k] * share;
                let wet = dry * libm::exp(-kd * depth_m - c * f64::from(pixel.range_m));
                let found = [pixel.direct[k], pixel.clean[k]].map(f64::from);
                // The wall is the side of a cylinder: a little off upright aside, where f32 tells.
                assert!(
                    (found[0] / wet - 1.0).abs() < 1e-5,
                    "{mode:?} {found:?} {wet}"
                );
                assert!(
                    (found[1] / dry - 1.0).abs() < 1e-5,
                    "{mode:?} {found:?} {dry}"
                );
            }
        }
        assert!(floors > 500 && walls > 500, "{floors} {walls}");
    }
}

/// Without end and along the level: b ½ E/π / K at the camera's depth, 1 m above the rig's origin; more above, less below.
#[test]
fn open_water_is_bright_by_what_it_scatters() {
    for mode in [Mode::Koschmieder, Mode::Single, Mode::Full] {
        let mut scene = sunlit(mode);
        scene.seabed = None;
        let frame = render(&scene);
        // The middle row of a 67-row image looks half a row below the level.
        let [above, middle, below] = [0, 33, 66].map(|row| frame.at(60, row).backscatter);
        for k in 0..3 {
            let (a, b) = (
                scene.medium.absorption_per_m()[k],
                scene.medium.scattering_per_m()[k],
            );
            let scattered = match mode {
                Mode::Full => b * (1.0 - scene.medium.phase().mean_cosine()),
                _ => b,
            };
            let kd: f64 = [0.3, 0.13, 0.17][k];
            let here = 0.5 * IRRADIANCE[k] / PI * libm::exp(kd);
            let expected = scattered * here / (a + scattered);
            let found = f64::from(middle[k]);
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{mode:?}: {found} {expected}"
            );
            assert!(above[k] > middle[k] && middle[k] > below[k], "{mode:?}");
        }
    }
}

/// Twice the daylight, twice the light; none, none.
#[test]
fn light_is_linear_in_daylight() {
    let mut scene = sunlit(Mode::Full);
    let once = render(&scene);
    scene.daylight.as_mut().unwrap().irradiance_w_per_m2 = IRRADIANCE.map(|e| 2.0 * e);
    let twice = render(&scene);
    for (one, two) in once.pixels.iter().zip(&twice.pixels) {
        for k in 0..3 {
            assert!((two.radiance[k] / one.radiance[k] - 2.0).abs() < 1e-5);
        }
    }
    scene.daylight.as_mut().unwrap().irradiance_w_per_m2 = [0.0; 3];
    assert!(render(&scene).pixels.iter().all(|p| p.radiance == [0.0; 3]));
}
