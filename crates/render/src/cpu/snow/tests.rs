use std::path::Path;

use rodsight_geometry::{Band, Eye};
use rodsight_scene::{Scene, Snow};

use super::super::world::World;
use super::*;

fn scene(number_per_m3: f64) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scene = Scene::load(&folder.join("paper.toml")).unwrap();
    scene.snow = Some(Snow {
        number_per_m3,
        diameter_m: [5e-4, 5e-3],
        exponent: 3.0,
        albedo: [0.3, 0.2, 0.1],
        range_m: [0.3, 5.0],
        seed: None,
    });
    scene
}

/// Density times the volume of a piece of the view: (4³ − 1³)/3 times its solid angle 4 asin(w h/√((w² + f²)(h² + f²))), by half sides.
#[test]
fn as_many_are_in_view_as_the_density_says() {
    let mut scene = scene(2000.0);
    scene.rods[0].centre_m.x = 50.0;
    scene.seabed = None;
    let world = World::new(&scene);
    let flakes = Caster::new(&world, Eye::Left, Band::Green).flakes();
    let (w, h, f) = (960.0_f64, 540.0_f64, 1566.5776_f64);
    let solid_angle_sr = 4.0 * libm::asin(w * h / ((w * w + f * f) * (h * h + f * f)).sqrt());
    let expected = 2000.0 * 21.0 * solid_angle_sr;
    let found = flakes.iter().filter(|flake| {
        let [u, v] = flake.place.at_px;
        (1.0..4.0).contains(&flake.place.range_m)
            && (0.0..1920.0).contains(&u)
            && (0.0..1080.0).contains(&v)
    });
    let found = found.count() as f64;
    // Poisson.
    assert!(
        (found - expected).abs() < 4.0 * expected.sqrt(),
        "{found}, {expected}"
    );
    assert!(flakes.is_sorted_by(|a, b| a.place.range_m <= b.place.range_m));
}

/// Both eyes see the same particles, each where the other's ray and range say.
#[test]
fn eyes_see_the_same_particles() {
    let scene = scene(300.0);
    let world = World::new(&scene);
    let [left, right] = Eye::BOTH.map(|eye| Caster::new(&world, eye, Band::Green).flakes());
    let (mut common, mut hidden) = (0, 0);
    for flake in &left {
        let (from_m, along) = scene.rig.left.ray(&flake.place.at_px.into()).unwrap();
        let point_m = from_m + along * flake.place.range_m;
        let there = scene.rig.right.sight(&point_m).unwrap();
        if !scene.rig.right.camera.contains(&there.pixel) {
            continue;
        }
        let twin = right
            .iter()
            .find(|other| (Pixel::from(other.place.at_px) - there.pixel).norm() < 1e-6);
        common += usize::from(twin.is_some());
        hidden += usize::from(twin.is_none());
        assert!(twin.is_some() || world.is_hidden(&point_m, &there.from_m));
    }
    assert!(common > 1000 && hidden > 20, "{common} {hidden}");
}

/// A disc's light and cover in the image are its area, wherever it lies in its pixels; a ball's are within half a percent.
#[test]
fn a_flake_sends_its_area_times_its_radiance() {
    for radius_px in [0.05, 0.6, 2.3, 8.1, 12.0, 30.0_f64] {
        for (x, y) in [(40.0, 40.0), (40.31, 40.77), (40.5, 40.01)] {
            for tilt in [0.0, 0.9, 1.4] {
                let (sin, cos) = libm::sincos(tilt);
                let place = Place {
                    at_px: [x, y],
                    // An ellipse, turned: as a wide view draws a sphere.
                    disc_per_px: [[0.9 / radius_px, 0.2 / radius_px], [0.0, 1.0 / radius_px]],
                    half_px: [1.2 * radius_px, radius_px],
                    opacity: 0.7,
                    range_m: 1.0,
                    centre_m: Vec3::z(),
                    from_m: Vec3::zeros(),
                    to_eye: -Vec3::z(),
                    axes: [Vec3::x(), Vec3::y()],
                    gain: 1.0,
                };
                let flake = Flake {
                    place,
                    direct: [1.0; 3],
                    scattered: Scattered::default(),
                    lit_from: [0.6 * sin, 0.8 * sin, cos],
                    shading: f64::from(u8::from(radius_px > ROUND_PX)),
                };
                let (mut cover, mut light) = (0.0, 0.0);
                for row in flake.place.span(1, 100) {
                    for column in flake.place.span(0, 100) {
                        let share = flake.cover(column, row);
                        cover += share;
                        light += share * flake.shade(column, row);
                    }
                }
                let area = 0.7 * core::f64::consts::PI * radius_px * radius_px / 0.9;
                assert!(
                    (cover / area - 1.0).abs() < 1e-9,
                    "{radius_px}: {}",
                    cover / area
                );
                let error = (light / area - 1.0).abs();
                assert!(error < 0.01, "{radius_px} px, {tilt} rad: {error}");
            }
        }
    }
}

/// A lone particle's light at the lens, by hand: ρ/π I/r² · ⅔ (sin α + (π − α) cos α)/π · e^(−c (r + t)), and its area in pixels,
/// π R²/t² f²/cos³ of the angle to the axis.
#[test]
fn a_flake_is_lit_and_dimmed_as_a_matt_sphere() {
    let mut scene = scene(300.0);
    let snow = scene.snow.as_mut().unwrap();
    snow.diameter_m = [1e-3; 2];
    scene.mode = Mode::Single;
    scene.seabed = None;
    scene.rods[0].centre_m.x = 50.0;
    scene.lamps.truncate(1);
    let lamp = &mut scene.lamps[0];
    lamp.inner_half_angle_rad = core::f64::consts::PI;
    lamp.outer_half_angle_rad = core::f64::consts::PI;
    let lamp = *lamp;
    let world = World::new(&scene);
    let flakes = Caster::new(&world, Eye::Left, Band::Green).flakes();
    for flake in &flakes {
        let (from_m, along) = scene.rig.left.ray(&flake.place.at_px.into()).unwrap();
        let to_lamp = lamp.position_m - (from_m + along * flake.place.range_m);
        let r = to_lamp.norm();
        let alpha = libm::acos(-to_lamp.dot(&along) / r);
        let (sin, cos) = libm::sincos(alpha);
        let pi = core::f64::consts::PI;
        let phase = 2.0 / 3.0 * (sin + (pi - alpha) * cos) / pi;
        for (k, albedo) in [0.3, 0.2, 0.1].into_iter().enumerate() {
            let c = scene.medium.beam_attenuation_per_m()[k];
            let expected = albedo / pi * lamp.radiant_intensity_w_per_sr[k] / (r * r)
                * phase
                * libm::exp(-c * (r + flake.place.range_m));
            assert!((flake.direct[k] / expected - 1.0).abs() < 1e-9);
        }
        let [[a, b], [c, d]] = flake.place.disc_per_px;
        let area_px = pi / (a * d - b * c).abs();
        let cos3 = along.x * along.x * along.x;
        let expected = pi * (5e-4 / flake.place.range_m * 1566.5776).powi(2) / cos3;
        assert!(
            (area_px / expected - 1.0).abs() < 1e-4,
            "{}",
            area_px / expected
        );
    }
    assert!(flakes.len() > 5000, "{}", flakes.len());
}
