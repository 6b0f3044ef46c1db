//! Mode `full`: halo, transport attenuation. V9 to V12 of the validation plan, through the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Eye, Vec3};
use rodsight_optics::{Lobe, Medium, Phase, Wells, water};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, Renderer, Truth};
use rodsight_scene::{Material, Mode, Rod, Scene};

fn render(scene: &Scene) -> EyeFrame {
    CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
}

/// A lit rod over a floor in water of some type.
fn lit(name: &str, shrink: u32) -> Scene {
    let mut scene = common::wet(shrink);
    scene.mode = Mode::Full;
    scene.medium = water::by_name(name).unwrap().medium();
    let rod = common::orange_rod(Vec3::new(2.0, -0.3, -0.9), Vec3::new(0.1, 0.2, 1.0), 0.05);
    scene.rods.push(rod);
    scene
}

/// A card that fills the view of the left eye and reaches far beyond it: the side of a rod so thick that it is flat.
fn card(distance_m: f64, radiance: [f64; 3]) -> Rod {
    Rod {
        length_m: 2e4,
        material: Material::Flat(radiance),
        ..common::flat_rod(Vec3::new(1e4 + distance_m, 0.0, -1.0), Vec3::z(), 1e4)
    }
}

/// V9: of a card that fills the view, all light arrives that small angles leave: MTF(0, z), sharp and halo together. The halo's tails see
/// the card at other distances than that of a pixel, so that only the middle of the view is exact.
#[test]
fn endless_card_arrives_whole() {
    let mut scene = common::empty(16);
    scene.mode = Mode::Full;
    scene.medium = water::by_name("1C").unwrap().medium();
    scene.rods.push(card(2.0, [1.0, 2.0, 3.0]));
    let wells = Wells::of(&scene.medium);
    for (frame, k) in common::on_each(&scene)
        .iter()
        .flat_map(|f| (0..3).map(move |k| (f, k)))
    {
        let pixel = frame.left.at(60, 33);
        let c = scene.medium.beam_attenuation_per_m()[k];
        let sent = 1.0 + k as f64;
        let sharp = f64::from(pixel.direct[k]) / (sent * libm::exp(-2.0 * c));
        assert!((sharp - 1.0).abs() < 1e-3, "band {k}: {sharp}");
        let halo = wells[k].mtf(0.0, 2.0) - libm::exp(-2.0 * c);
        let found = f64::from(pixel.forward[k]) / (sent * halo);
        // Parts of the card off the axis are farther: more of their light is scattered, less of it arrives.
        assert!((found - 1.0).abs() < 0.08, "band {k}: {found}");
        let sum = pixel.direct[k] + pixel.forward[k] + pixel.backscatter[k];
        assert!((pixel.radiance[k] / sum - 1.0).abs() < 1e-6, "band {k}");
    }
}

/// A rod shines over the dark beside it: the halo falls with the distance, is of the rod's colour, and is not there in mode `single`.
#[test]
fn halo_surrounds_what_shines() {
    let mut scene = common::empty(4);
    scene.mode = Mode::Full;
    scene.medium = water::by_name("1C").unwrap().medium();
    scene.rods.push(common::flat_rod(
        Vec3::new(2.0, -0.5, -1.0),
        Vec3::z(),
        0.05,
    ));
    let frame = render(&scene);
    let along: Vec<[f32; 3]> = (265..470)
        .map(|column| frame.at(column, 135).forward)
        .collect();
    for pair in along.windows(2) {
        assert!(
            pair[1][1] <= pair[0][1] * (1.0 + 1e-4) && pair[1][1] > 0.0,
            "{pair:?}"
        );
    }
    assert!(
        along[0][1] > 10.0 * along[200][1],
        "{:?} {:?}",
        along[0],
        along[200]
    );
    assert!(along[5][0] > along[5][1] && along[5][1] > along[5][2]);
    scene.mode = Mode::Single;
    assert!(
        render(&scene)
            .pixels
            .iter()
            .all(|pixel| pixel.forward == [0.0; 3])
    );
}

/// V9: an image that shows all of a halo shows all of its light. The rod is far and short, the camera wide.
#[test]
fn frame_sum_is_preserved() {
    let mut scene = common::empty(16);
    scene.mode = Mode::Full;
    // One narrow lobe: 0.51° wide, a pixel and a half, so that 1 % lies beyond 150 px.
    let phase = Phase::henyey_greenstein(0.9911).unwrap();
    scene.medium = Medium::new([0.05; 3], [0.3; 3], phase).unwrap();
    scene.rods.push(Rod {
        length_m: 0.3,
        ..common::flat_rod(Vec3::new(4.0, -0.5, -1.0), Vec3::y(), 0.1)
    });
    for frame in common::on_each(&scene) {
        let sum = |channel: fn(&rodsight_render::PixelTruth) -> [f32; 3]| -> f64 {
            let pixels = frame.left.pixels.iter();
            pixels.map(|pixel| f64::from(channel(pixel)[1])).sum()
        };
        let ratio = sum(|p| p.forward) / sum(|p| p.direct);
        let expected = libm::exp(0.3 * 3.9) - 1.0;
        assert!(
            (ratio / expected - 1.0).abs() < 0.03,
            "{}: {ratio} for {expected}",
            frame.backend
        );
    }
}

/// V10: without scattering, `full` is `single`; what is scattered by hardly any angle is not scattered at all.
#[test]
fn full_tends_to_single_and_to_clear_water() {
    let mut scene = lit("1C", 8);
    let absorption = [0.23, 0.05, 0.11];
    scene.medium = Medium::new(absorption, [0.0; 3], Phase::petzold3()).unwrap();
    let full = render(&scene);
    scene.mode = Mode::Single;
    let single = render(&scene);
    assert!(full.pixels == single.pixels, "b = 0");

    // K = a and MTF = e^(−a z): no loss by scattering, and no halo wider than a pixel.
    let forward = Phase::henyey_greenstein(1.0 - 1e-7).unwrap();
    scene.mode = Mode::Full;
    scene.medium = Medium::new(absorption, [0.4; 3], forward).unwrap();
    for (a, b) in render(&scene).pixels.iter().zip(&single.pixels) {
        for k in 0..3 {
            let error = (a.radiance[k] - b.radiance[k]).abs();
            assert!(
                error <= 2e-3 * b.radiance[k] + 1e-6,
                "{:?} {:?}",
                a.radiance,
                b.radiance
            );
        }
    }

    // Isotropic scattering has no forward lobe: K = c, and nothing to blur.
    scene.medium = Medium::new(absorption, [0.4; 3], Phase::Isotropic).unwrap();
    let full = render(&scene);
    scene.mode = Mode::Single;
    for (a, b) in full.pixels.iter().zip(&render(&scene).pixels) {
        assert_eq!(
            (a.direct, a.backscatter, a.forward),
            (b.direct, b.backscatter, [0.0; 3])
        );
    }
}

/// V11: the halo too is linear in the lamps.
#[test]
fn full_is_linear_in_the_lamps() {
    let scene = lit("1C", 16);
    let mut doubled = scene.clone();
    for lamp in &mut doubled.lamps {
        lamp.radiant_intensity_w_per_sr = lamp.radiant_intensity_w_per_sr.map(|i| 2.0 * i);
    }
    let only = |index: usize| {
        let mut one = scene.clone();
        one.lamps = vec![scene.lamps[index]];
        render(&one)
    };
    let (whole, doubled, first, second) = (render(&scene), render(&doubled), only(0), only(1));
    let mut off = 0;
    for (i, pixel) in whole.pixels.iter().enumerate() {
        for k in 0..3 {
            assert_eq!(
                doubled.pixels[i].radiance[k],
                2.0 * pixel.radiance[k],
                "{i} {k}"
            );
            let parts = first.pixels[i].forward[k] + second.pixels[i].forward[k];
            off += usize::from((parts / pixel.forward[k] - 1.0).abs() > 1e-3);
        }
    }
    // Edges of shadows are sampled more finely where either lamp has one.
    assert!(off < whole.pixels.len() * 3 / 100, "{off} samples differ");
}

/// V12: a scene that is its own mirror image gives mirrored halos; 0.5 % is for cells that the right border cuts and the left does not.
#[test]
fn mirrored_scene_gives_mirrored_halos() {
    let mut scene = common::wet(8);
    scene.mode = Mode::Full;
    scene.seabed = None;
    let rod = common::orange_rod(Vec3::new(2.0, 0.0, -0.9), Vec3::new(0.2, 0.0, 1.0), 0.08);
    scene.rods.push(rod);
    for Frame {
        left,
        right,
        backend,
        ..
    } in common::on_each(&scene)
    {
        let all = left.pixels.iter().map(|pixel| pixel.forward[0]);
        let brightest = all.fold(0.0, f32::max);
        for (column, row) in places(&left) {
            let a = left.at(column, row).forward[0];
            let b = right.at(left.width_px - 1 - column, row).forward[0];
            assert!(
                (a - b).abs() < 5e-3 * brightest,
                "{backend} ({column}, {row}): {a} {b}"
            );
        }
    }
}

fn places(frame: &EyeFrame) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (frame.width_px, frame.height_px);
    (0..height).flat_map(move |row| (0..width).map(move |column| (column, row)))
}

/// What lies outside the image gives it light: the halo is that of the same pixels in a wider image.
#[test]
fn halo_does_not_know_where_the_image_ends() {
    let scene = lit("1C", 16);
    let mut part = scene.clone();
    let mut i = *scene.rig.left.camera.intrinsics();
    (i.width_px, i.height_px) = (48, 40);
    (i.cx_px, i.cy_px) = (i.cx_px - 40.0, i.cy_px - 16.0);
    part.rig.left.camera =
        rodsight_geometry::Camera::new(i, rodsight_geometry::Distortion::None).unwrap();
    for (whole, part) in common::on_each(&scene).iter().zip(common::on_each(&part)) {
        let all = whole.left.pixels.iter().map(|pixel| pixel.forward[1]);
        let brightest = all.fold(0.0, f32::max);
        let off = places(&part.left).map(|(column, row)| {
            let [a, b] = [
                part.left.at(column, row),
                whole.left.at(column + 40, row + 16),
            ];
            (a.forward[1] - b.forward[1]).abs() / brightest
        });
        let worst = off.fold(0.0, f32::max);
        // One ray outside for 4×4 px.
        assert!(worst < 0.02, "{}: {worst}", part.backend);
    }
}

/// In 1C, c = 0.664 m⁻¹ at 600 nm: what lies farther than 2.5 / 0.664 m is flagged, water without a surface is not.
#[test]
fn what_is_beyond_the_model_is_flagged_in_mode_full_only() {
    let mut scene = lit("1C", 16);
    let limit_m = 2.5 / (0.248 + 0.416);
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let mut seen = [0; 3];
    for pixel in frame.left.pixels.iter().chain(&frame.right.pixels) {
        let range_m = f64::from(pixel.range_m);
        let far = range_m.is_finite() && range_m > limit_m;
        assert_eq!(pixel.beyond_model, far, "{range_m} m");
        seen[usize::from(far) + usize::from(range_m.is_infinite()) * 2] += 1;
    }
    assert!(seen.iter().all(|&count| count > 500), "{seen:?}");
    let truth = Truth::of(&scene, &frame, 1.0).unwrap();
    let shares = truth.beyond_model.unwrap();
    let whole = (shares.left_share + shares.right_share) * frame.left.pixels.len() as f64;
    assert!((whole - f64::from(seen[1])).abs() < 1e-6, "{whole}");

    scene.mode = Mode::Single;
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    assert!(frame.left.pixels.iter().all(|pixel| !pixel.beyond_model));
    assert!(
        Truth::of(&scene, &frame, 1.0)
            .unwrap()
            .beyond_model
            .is_none()
    );
}

/// Where more is scattered back than on, K is larger than c: what reaches a shadow is nothing, not less.
#[test]
fn shadows_in_water_that_scatters_back_are_not_darker_than_black() {
    let lobe = |weight, g| Lobe { weight, g };
    let phase = Phase::lobes(vec![lobe(0.3, 0.5), lobe(0.7, -0.6)]).unwrap();
    let mut scene = common::crossing(8);
    scene.mode = Mode::Full;
    scene.ambient_radiance = [0.0; 3];
    scene.medium = Medium::new([0.05; 3], [0.3; 3], phase).unwrap();
    let mut frames = vec![CpuRenderer.render(&scene, &|_| ()).unwrap()];
    frames.extend(common::gpu().map(|gpu| gpu.render(&scene, &|_| ()).unwrap()));
    for frame in frames {
        let pixels = || frame.left.pixels.iter().filter(|pixel| pixel.instance != 0);
        let darkest = pixels().fold(f32::INFINITY, |least, pixel| least.min(pixel.direct[1]));
        assert!(darkest == 0.0, "{}: {darkest}", frame.backend);
        assert!(
            pixels().any(|pixel| pixel.direct[1] > 0.0),
            "{}",
            frame.backend
        );
    }
}
