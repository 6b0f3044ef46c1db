//! Marine snow, through the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use core::f64::consts::PI;

use rodsight_geometry::{Eye, Vec3};
use rodsight_optics::{Medium, Phase};
use rodsight_render::{CpuRenderer, EyeFrame, PixelTruth, Renderer, expose};
use rodsight_scene::{Aperture, Material, Mode, Rod, Scene, Snow};

fn render(scene: &Scene) -> EyeFrame {
    CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
}

/// Snow in evenly lit water.
fn ambient(number_per_m3: f64, diameter_m: [f64; 2]) -> Scene {
    let mut scene = common::empty(8);
    scene.mode = Mode::Koschmieder;
    scene.medium = Medium::new([0.5; 3], [0.3; 3], Phase::petzold3()).unwrap();
    scene.ambient_radiance = [1.0, 2.0, 3.0];
    scene.snow = Some(Snow {
        number_per_m3,
        diameter_m,
        exponent: 3.0,
        albedo: [0.3, 0.2, 0.1],
        range_m: [0.4, 5.0],
        seed: Some(3),
    });
    scene
}

fn mean(frame: &EyeFrame, of: impl Fn(&PixelTruth) -> f32) -> f64 {
    let sum: f64 = frame.pixels.iter().map(|pixel| f64::from(of(pixel))).sum();
    sum / frame.pixels.len() as f64
}

/// Fully lit spheres dim the view by n σ as they shine: L = ρ L₀ n σ/(c + n σ) [e^(−(c + n σ) near) − e^(−(c + n σ) far)], σ their mean
/// cross-section. The far end differs with the other eye's distance, but e^(−4) is left there.
#[test]
fn mean_light_is_the_integral_along_the_ray() {
    for diameter_m in [[1e-3, 1e-3], [5e-4, 4e-3]] {
        let scene = ambient(20_000.0, diameter_m);
        let [from, to] = diameter_m;
        // ∫ d² d⁻³ / ∫ d⁻³.
        let mean_square = if from == to {
            from * from
        } else {
            2.0 * libm::log(to / from) / (from.powi(-2) - to.powi(-2))
        };
        let stopped = 20_000.0 * PI / 4.0 * mean_square;
        let lost = 0.8 + stopped;
        let reach = libm::exp(-lost * 0.4) - libm::exp(-lost * 5.0);
        let frame = render(&scene);
        for k in 0..3 {
            let sent = [0.3, 0.2, 0.1][k] * (1.0 + k as f64);
            let expected = sent * stopped / lost * reach;
            let found = mean(&frame, |pixel| pixel.snow[k]);
            // 2e5 particles in view, of which the near and large ones tell most.
            assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
        }
        let cover = 1.0 - libm::exp(-stopped * 4.6);
        let found = mean(&frame, |pixel| pixel.snow_cover);
        assert!((found / cover - 1.0).abs() < 0.03, "{found} {cover}");
    }
}

/// Twice as much snow is twice as bright, but for what it hides of itself.
#[test]
fn light_is_proportional_to_the_density() {
    let of = |number| {
        mean(&render(&ambient(number, [1e-3, 1e-3])), |pixel| {
            pixel.snow[0]
        })
    };
    let [one, two, four] = [5e3, 1e4, 2e4].map(of);
    assert!(
        (two / one - 2.0).abs() < 0.06 && (four / one - 4.0).abs() < 0.12,
        "{one} {two} {four}"
    );
}

/// A card across the view at 1 m: nothing behind it is seen, and of its own light e^(−n σ (1 − 0.4)/cos) passes.
#[test]
fn surfaces_hide_snow_and_snow_hides_surfaces() {
    let mut scene = ambient(20_000.0, [1e-3, 1e-3]);
    scene.rods.push(Rod {
        length_m: 2e4,
        material: Material::Flat([1.0; 3]),
        ..common::flat_rod(Vec3::new(1e4 + 1.0, 0.0, -1.0), Vec3::z(), 1e4)
    });
    let frame = render(&scene);
    scene.snow = None;
    let bare = render(&scene);
    let stopped = 20_000.0 * PI / 4.0 * 1e-6;
    let mut expected = 0.0;
    for pixel in &bare.pixels {
        expected += libm::exp(-stopped * (f64::from(pixel.range_m) - 0.4));
    }
    expected /= bare.pixels.len() as f64;
    let kept = mean(&frame, |p| p.direct[1]) / mean(&bare, |p| p.direct[1]);
    assert!((kept - expected).abs() < 3e-4, "{kept} {expected}");
    for (with, without) in frame.pixels.iter().zip(&bare.pixels) {
        assert_eq!(
            (with.instance, with.range_m, with.normal, with.clean),
            (
                without.instance,
                without.range_m,
                without.normal,
                without.clean
            )
        );
        for k in 0..3 {
            let parts = with.direct[k] + with.forward[k] + with.backscatter[k] + with.snow[k];
            assert!((with.radiance[k] / parts - 1.0).abs() < 1e-6);
            assert!(with.backscatter[k] <= without.backscatter[k] * (1.0 + 1e-6));
        }
        if with.snow_cover == 0.0 {
            assert_eq!(common::numbers(with), common::numbers(without));
        }
    }
}

/// Lamps, rods, shadows, a floor and a halo.
fn storm() -> Scene {
    let mut scene = common::crossing(8);
    scene.mode = Mode::Full;
    scene.snow = ambient(5e3, [5e-4, 5e-3]).snow;
    scene
}

#[test]
fn snow_is_the_same_on_any_number_of_threads_and_gone_without() {
    let scene = storm();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| render(&scene))
    };
    let frame = on(1);
    assert!(frame.pixels == on(3).pixels);
    assert!(mean(&frame, |pixel| pixel.snow_cover) > 1e-3);
    for pixel in &frame.pixels {
        for k in 0..3 {
            let parts = pixel.direct[k] + pixel.forward[k] + pixel.backscatter[k] + pixel.snow[k];
            assert!((pixel.radiance[k] / parts - 1.0).abs() < 1e-6);
        }
    }
    let mut other = scene.clone();
    other.seed += 1;
    other.snow.as_mut().unwrap().seed = None;
    assert!(frame.pixels != render(&other).pixels, "another seed");
    let bare = |mut scene: Scene| {
        scene.snow = None;
        render(&scene)
    };
    let without = bare(scene.clone());
    assert!(
        without
            .pixels
            .iter()
            .all(|p| p.snow == [0.0; 3] && p.snow_cover == 0.0)
    );
    // In the air there is none.
    let mut dry = scene;
    dry.mode = Mode::Air;
    assert!(render(&dry).pixels == bare(dry).pixels);
}

/// An open aperture spreads what is near and keeps its light.
#[test]
fn defocus_spreads_near_snow() {
    let mut scene = ambient(400.0, [2e-3, 2e-3]);
    scene.rig = common::rig(4);
    scene.snow.as_mut().unwrap().range_m = [0.4, 0.6];
    let sharp = CpuRenderer.render(&scene, &|_| ()).unwrap().left;
    scene.lens.aperture = Some(Aperture {
        f_number: 1.4,
        focal_length_m: 0.016,
        focus_m: 2.0,
    });
    let blurred = expose(&CpuRenderer, &scene, &|_| ()).unwrap().left;
    let light = |frame: &EyeFrame| mean(frame, |pixel| pixel.snow[1]);
    let brightest = |frame: &EyeFrame| {
        let all = frame.pixels.iter().map(|pixel| pixel.snow[1]);
        all.fold(0.0, f32::max)
    };
    let kept = light(&blurred) / light(&sharp);
    // What crosses the border goes out and comes in by chance.
    assert!((kept - 1.0).abs() < 0.02, "{kept}");
    assert!(brightest(&blurred) < 0.6 * brightest(&sharp));
}
