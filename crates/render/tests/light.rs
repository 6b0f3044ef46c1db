//! Light against closed forms: V2, V3, V4, V10, V11 and V12 of the validation plan, through the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use core::f64::consts::PI;

use rodsight_geometry::{Eye, Pixel, Vec3};
use rodsight_optics::{Medium, Phase};
use rodsight_render::{CpuRenderer, EyeFrame};
use rodsight_scene::{Material, Mode, Rod, Scene, Seabed};

const LAMP_M: Vec3 = Vec3::new(0.1, 0.3, -1.2);
const INTENSITY: [f64; 3] = [2.0, 1.5, 1.0];

fn render(scene: &Scene) -> EyeFrame {
    CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
}

fn with_floor(z_m: f64) -> Scene {
    let mut scene = common::empty(16);
    scene.seabed = Some(Seabed {
        z_m,
        albedo: [0.5, 0.4, 0.3],
        texture_contrast: 0.0,
        texture_scale_m: 0.1,
        ripples: None,
        clutter: None,
    });
    scene.lamps.push(common::bare_lamp(LAMP_M, INTENSITY));
    scene
}

/// Lengths of the lamp's and the camera's leg, the cosine at the floor, for a pixel of the left eye.
fn legs(scene: &Scene, column: u32, row: u32) -> (f64, f64, f64) {
    let (origin, ray) = scene
        .rig
        .left
        .ray(&Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5))
        .unwrap();
    let z_m = scene.seabed.unwrap().z_m;
    let t = (z_m - origin.z) / ray.z;
    let r = (origin + ray * t - LAMP_M).norm();
    (r, t, (z_m - LAMP_M.z) / r)
}

fn water(absorption_per_m: [f64; 3], scattering_per_m: [f64; 3], phase: Phase) -> Medium {
    Medium::new(absorption_per_m, scattering_per_m, phase).unwrap()
}

/// V2: L = ρ I cos θ / (π r²), to the precision of the stored f32.
#[test]
fn vacuum_card_has_the_radiance_of_lambert_and_the_inverse_square() {
    let scene = with_floor(0.0);
    let frame = render(&scene);
    for (column, row) in [(10, 60), (60, 55), (110, 66)] {
        let (r, _, cos) = legs(&scene, column, row);
        for k in 0..3 {
            let expected = scene.seabed.unwrap().albedo[k] * INTENSITY[k] * cos / (PI * r * r);
            let found = f64::from(frame.at(column, row).radiance[k]);
            assert!(
                (found / expected - 1.0).abs() < 1e-5,
                "({column}, {row}) band {k}: {found} for {expected}"
            );
        }
    }
}

/// V3: in water that only absorbs, ln(L r²/cos) falls with the path at the rate a.
#[test]
fn absorbing_water_has_the_slope_of_beer_and_lambert() {
    let absorption = [0.23, 0.05, 0.11];
    let (column, row) = (60, 60);
    let mut samples = Vec::new();
    for step in 0..12 {
        let mut scene = with_floor(-0.9 + 0.25 * f64::from(step));
        scene.mode = Mode::Single;
        scene.medium = water(absorption, [0.0; 3], Phase::Isotropic);
        let (r, t, cos) = legs(&scene, column, row);
        samples.push((
            r + t,
            render(&scene)
                .at(column, row)
                .radiance
                .map(|l| libm::log(f64::from(l) * r * r / cos)),
        ));
    }
    assert!(
        samples.last().unwrap().0 - samples[0].0 > 6.0,
        "the paths must differ by metres"
    );
    for (k, a) in absorption.into_iter().enumerate() {
        let n = samples.len() as f64;
        let (mx, my) = (
            samples.iter().map(|s| s.0).sum::<f64>() / n,
            samples.iter().map(|s| s.1[k]).sum::<f64>() / n,
        );
        let slope = samples
            .iter()
            .map(|s| (s.0 - mx) * (s.1[k] - my))
            .sum::<f64>()
            / samples.iter().map(|s| (s.0 - mx) * (s.0 - mx)).sum::<f64>();
        assert!(
            (slope / -a - 1.0).abs() < 1e-4,
            "band {k}: slope {slope}, expected {}",
            -a
        );
    }
}

/// The airlight integral by brute force: uniform midpoints so many that 1/r² is resolved, and a shadow test at each.
fn airlight_by_brute_force(scene: &Scene, pixel: &Pixel, distance_m: f64) -> [f64; 3] {
    let (origin, ray) = scene.rig.left.ray(pixel).unwrap();
    let (c, b) = (
        scene.medium.beam_attenuation_per_m(),
        scene.medium.scattering_per_m(),
    );
    let n = 400_000;
    let mut sum = [0.0; 3];
    for i in 0..n {
        let t = distance_m * (f64::from(i) + 0.5) / f64::from(n);
        let to = origin + ray * t - LAMP_M;
        let r = to.norm();
        let shadowed = scene
            .rods
            .iter()
            .any(|rod| segment_meets_rod(rod, &LAMP_M, &(to / r), r));
        if shadowed {
            continue;
        }
        let phase = scene.medium.phase().value_per_sr(-to.dot(&ray) / r);
        for k in 0..3 {
            sum[k] +=
                b[k] * phase * INTENSITY[k] / (r * r) * libm::exp(-c[k] * (r + t)) * distance_m
                    / f64::from(n);
        }
    }
    sum
}

/// Whether a segment meets a rod's side: distances between two lines, written apart from the renderer's intersection.
fn segment_meets_rod(rod: &Rod, from: &Vec3, direction: &Vec3, length_m: f64) -> bool {
    let n = 2000;
    // Coarse march is enough: the rod is thick against the step.
    (0..n).any(|i| {
        let w = from + direction * (length_m * (f64::from(i) + 0.5) / f64::from(n)) - rod.centre_m;
        let s = w.dot(&rod.direction);
        s.abs() < rod.length_m / 2.0 && (w - rod.direction * s).norm() < rod.radius_m
    })
}

/// V4, through the renderer: isotropic phase, no surface and a surface, 0.5 % at 16 points.
#[test]
fn isotropic_airlight_matches_brute_force() {
    let mut scene = with_floor(0.2);
    scene.mode = Mode::Single;
    scene.medium = water([0.2, 0.1, 0.15], [0.4, 0.5, 0.6], Phase::Isotropic);
    let frame = render(&scene);
    for (column, row) in [(20, 10), (60, 50), (100, 65)] {
        let pixel = frame.at(column, row);
        let centre = Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let distance_m = f64::from(pixel.range_m).min(60.0);
        let expected = airlight_by_brute_force(&scene, &centre, distance_m);
        for k in 0..3 {
            let found = f64::from(pixel.backscatter[k]);
            assert!(
                (found / expected[k] - 1.0).abs() < 5e-3,
                "({column}, {row}) band {k}: {found} for {}",
                expected[k]
            );
        }
    }
}

/// The shadow that a rod casts into the water: rod between the lamp and some of the rays, and ending within the view.
#[test]
fn shadow_of_a_rod_in_the_water_matches_brute_force() {
    let mut scene = with_floor(0.2);
    scene.seabed = None;
    scene.mode = Mode::Single;
    scene.medium = water([0.05; 3], [0.5; 3], Phase::Isotropic);
    scene.rods.push(Rod {
        length_m: 0.5,
        material: Material::Lambert([0.0; 3]),
        ..common::flat_rod(Vec3::new(0.6, 0.15, -1.1), Vec3::new(0.1, 0.2, 1.0), 0.06)
    });
    let frame = render(&scene);
    let mut shadowed = 0;
    for (column, row) in [
        (55, 20),
        (60, 33),
        (65, 40),
        (70, 33),
        (80, 30),
        (90, 50),
        (100, 12),
    ] {
        let pixel = frame.at(column, row);
        let centre = Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let distance_m = f64::from(pixel.range_m).min(60.0);
        let expected = airlight_by_brute_force(&scene, &centre, distance_m)[0];
        let unshadowed = airlight_by_brute_force(
            &Scene {
                rods: Vec::new(),
                ..scene.clone()
            },
            &centre,
            distance_m,
        )[0];
        shadowed += u32::from(expected < 0.97 * unshadowed);
        let found = f64::from(pixel.backscatter[0]);
        assert!(
            (found / expected - 1.0).abs() < 1e-2,
            "({column}, {row}): {found} for {expected} ({unshadowed} without rod)"
        );
    }
    assert!(
        shadowed >= 3,
        "only {shadowed} of the rays pass through the shadow: the test would prove little"
    );
}

/// V10: without scattering the water only absorbs; without any, single is air; far water saturates.
#[test]
fn limits_of_the_water_are_air_and_saturation() {
    let mut air = with_floor(0.2);
    let dry = render(&air);
    air.mode = Mode::Single;
    assert_eq!(
        render(&air).pixels,
        dry.pixels,
        "vacuum in mode single is air"
    );

    let mut deep = with_floor(50.0);
    deep.mode = Mode::Single;
    deep.medium = water([0.3; 3], [0.3; 3], Phase::Isotropic);
    let far = render(&deep);
    deep.seabed = None;
    let endless = render(&deep);
    for (a, b) in far.pixels.iter().zip(&endless.pixels) {
        assert!(
            (a.radiance[0] / b.radiance[0] - 1.0).abs() < 1e-3,
            "{} and {}",
            a.radiance[0],
            b.radiance[0]
        );
    }
}

/// V11: light of two lamps is the sum of the light of each; twice the lamp is twice the light.
#[test]
fn light_is_linear_in_the_lamps() {
    let mut both = with_floor(0.2);
    both.mode = Mode::Single;
    both.medium = water([0.2, 0.1, 0.15], [0.4, 0.5, 0.6], Phase::Isotropic);
    both.rods.push(Rod {
        material: Material::Lambert([0.9, 0.5, 0.1]),
        ..common::flat_rod(Vec3::new(2.0, -0.3, -0.9), Vec3::new(0.1, 0.2, 1.0), 0.05)
    });
    both.lamps.push(common::bare_lamp(
        Vec3::new(0.2, -0.9, -1.5),
        [0.5, 1.0, 3.0],
    ));
    let only = |index: usize| {
        let mut scene = both.clone();
        scene.lamps = vec![both.lamps[index]];
        render(&scene)
    };
    let mut doubled = both.clone();
    for lamp in &mut doubled.lamps {
        lamp.radiant_intensity_w_per_sr = lamp.radiant_intensity_w_per_sr.map(|i| 2.0 * i);
    }
    let (sum, first, second, doubled) = (render(&both), only(0), only(1), render(&doubled));
    let mut compared = 0;
    for i in 0..sum.pixels.len() {
        for k in 0..3 {
            let whole = sum.pixels[i].radiance[k];
            let parts = first.pixels[i].radiance[k] + second.pixels[i].radiance[k];
            assert_eq!(
                doubled.pixels[i].radiance[k],
                2.0 * whole,
                "pixel {i} band {k}"
            );
            // Edges of shadows are sampled more finely where either lamp has one; elsewhere the sum is exact.
            if (parts / whole - 1.0).abs() < 1e-5 {
                compared += 1;
            } else {
                assert!(
                    (parts / whole - 1.0).abs() < 0.1,
                    "pixel {i} band {k}: {parts} for {whole}"
                );
            }
        }
    }
    assert!(
        compared > sum.pixels.len() * 3 * 97 / 100,
        "{compared} of {} agree",
        sum.pixels.len() * 3
    );
}

/// V12: a scene that is its own mirror image gives a mirrored pair.
#[test]
fn mirrored_scene_gives_a_mirrored_pair() {
    let mut scene = common::empty(8);
    scene.mode = Mode::Single;
    scene.medium = water([0.2, 0.1, 0.15], [0.4, 0.5, 0.6], Phase::petzold3());
    scene
        .lamps
        .push(common::bare_lamp(Vec3::new(0.1, 0.9, -1.3), INTENSITY));
    scene
        .lamps
        .push(common::bare_lamp(Vec3::new(0.1, -0.9, -1.3), INTENSITY));
    scene.rods.push(Rod {
        material: Material::Lambert([0.9, 0.5, 0.1]),
        ..common::flat_rod(Vec3::new(2.0, 0.0, -0.9), Vec3::new(0.2, 0.0, 1.0), 0.08)
    });
    let left = CpuRenderer.render_eye(&scene, Eye::Left, &|_| ()).unwrap();
    let right = CpuRenderer.render_eye(&scene, Eye::Right, &|_| ()).unwrap();
    let mut exact = 0;
    for row in 0..left.height_px {
        for column in 0..left.width_px {
            let (a, b) = (
                left.at(column, row),
                right.at(left.width_px - 1 - column, row),
            );
            let difference = (0..3)
                .map(|k| (a.radiance[k] / b.radiance[k] - 1.0).abs())
                .fold(0.0, f32::max);
            exact += usize::from(difference < 1e-5);
            // The lattice of an edge pixel is not its own mirror image: such pixels agree to a few of its 233 samples.
            assert!(
                difference < 0.05,
                "({column}, {row}): {:?} and {:?}",
                a.radiance,
                b.radiance
            );
        }
    }
    assert!(
        exact > left.pixels.len() * 95 / 100,
        "{exact} of {} pixels agree",
        left.pixels.len()
    );
}

#[test]
fn koschmieder_fades_the_surface_into_the_veil() {
    let mut scene = with_floor(0.0);
    scene.mode = Mode::Koschmieder;
    scene.ambient_radiance = [1.0, 2.0, 3.0];
    scene.medium = water([0.2, 0.1, 0.15], [0.4, 0.5, 0.6], Phase::Isotropic);
    let frame = render(&scene);
    let (_, t, _) = legs(&scene, 60, 60);
    for k in 0..3 {
        let (c, b) = (
            scene.medium.beam_attenuation_per_m()[k],
            scene.medium.scattering_per_m()[k],
        );
        let (surface, veil) = (
            scene.seabed.unwrap().albedo[k] * scene.ambient_radiance[k],
            b / c * scene.ambient_radiance[k],
        );
        let expected = surface * libm::exp(-c * t) + veil * (1.0 - libm::exp(-c * t));
        let found = f64::from(frame.at(60, 60).radiance[k]);
        assert!(
            (found / expected - 1.0).abs() < 1e-5,
            "band {k}: {found} for {expected}"
        );
    }
}

/// However many lamps there are, the edge of each one's shadow is an edge: their order changes nothing but rounding.
#[test]
fn shadows_of_the_33rd_lamp_have_edges_too() {
    let mut scene = common::crossing(8);
    let [near, far] = [scene.lamps[0], scene.lamps[1]];
    let with_far_at = |scene: &mut Scene, place: usize| {
        scene.lamps = vec![near; 33];
        scene.lamps[place] = far;
        CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
    };
    let (second, last) = (with_far_at(&mut scene, 1), with_far_at(&mut scene, 32));
    for (a, b) in second.pixels.iter().zip(&last.pixels) {
        for k in 0..3 {
            let off = (a.direct[k] - b.direct[k]).abs();
            assert!(
                off <= 1e-5 * b.direct[k].max(1e-6),
                "{} {}",
                a.direct[k],
                b.direct[k]
            );
        }
    }
}
