//! Depth of field and motion blur against their closed forms.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use core::f64::consts::PI;
use core::sync::atomic::{AtomicUsize, Ordering};

use rodsight_geometry::port::{FlatPort, Port, PortShape};
use rodsight_geometry::{Camera, Distortion, Eye, Vec3};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, RenderError, Renderer, expose};
use rodsight_scene::{Aperture, EdgeSampling, Lens, Material, Motion, Scene, Snow};

/// Focal length of the rig at an eighth of its resolution, px.
const FX_PX: f64 = 1566.5776 / 8.0;
const FOCUS_M: f64 = 2.0;

/// An upright rod that shines, `x_m` ahead of the cameras and half way between them.
fn rod(x_m: f64, radius_m: f64) -> Scene {
    let mut scene = common::empty(8);
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 55 };
    scene.rods.push(common::flat_rod(
        Vec3::new(x_m, 0.0, -1.0),
        Vec3::z(),
        radius_m,
    ));
    scene
}

fn with_aperture(mut scene: Scene) -> Scene {
    scene.lens = Lens {
        aperture: Some(Aperture {
            f_number: 1.0,
            focal_length_m: 0.06,
            focus_m: FOCUS_M,
        }),
        ..Lens::default()
    };
    scene
}

fn moving(mut scene: Scene, velocity_m_per_s: Vec3, turn_rad_per_s: Vec3) -> Scene {
    scene.motion = Some(Motion {
        exposure_s: 0.02,
        velocity_m_per_s,
        turn_rad_per_s,
    });
    scene
}

fn exposed(scene: &Scene) -> Frame {
    expose(&CpuRenderer, scene, &|_| ()).unwrap()
}

fn sharp(scene: &Scene) -> Frame {
    CpuRenderer.render(scene, &|_| ()).unwrap()
}

/// The mean of the middle rows' red light.
fn profile(eye: &EyeFrame) -> Vec<f64> {
    let rows = eye.height_px / 2 - 20..eye.height_px / 2 + 20;
    let mean = |column: u32| {
        let light = rows
            .clone()
            .map(|row| f64::from(eye.at(column, row).radiance[0]));
        light.sum::<f64>() / 40.0
    };
    (0..eye.width_px).map(mean).collect()
}

/// Sum, centre (px) and variance (px²) of a profile.
fn moments(profile: &[f64]) -> (f64, f64, f64) {
    let sum: f64 = profile.iter().sum();
    let mean = |f: &dyn Fn(f64) -> f64| {
        let terms = profile.iter().enumerate();
        terms.map(|(i, v)| v * f(i as f64 + 0.5)).sum::<f64>() / sum
    };
    let centre = mean(&|u| u);
    (sum, centre, mean(&|u| (u - centre) * (u - centre)))
}

/// Share of a disc of radius 1 left of x.
fn disc_left_of(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + libm::asin(x)) / PI
}

#[test]
fn a_still_scene_without_an_aperture_is_the_plain_render() {
    let scene = common::crossing(16);
    let (one, two) = (exposed(&scene), sharp(&scene));
    assert!(one.left == two.left && one.right == two.right);
}

/// The limb of a thick rod nearer than the focus: its profile is the edge spread of a disc of the circle of confusion, and it stays
/// where it is.
#[test]
fn a_limb_out_of_focus_is_the_edge_spread_of_a_disc_and_does_not_move() {
    let (x_m, radius_m) = (1.3, 0.3);
    let scene = rod(x_m, radius_m);
    // Half a metre to the side of either camera; the ray that grazes the rod touches it before its middle.
    let distance2 = x_m * x_m + 0.25;
    let touch_m = distance2.sqrt() * (1.0 - radius_m * radius_m / distance2);
    let angle = libm::atan2(0.5, x_m) + libm::asin(radius_m / distance2.sqrt());
    let reach_m = (distance2 - radius_m * radius_m).sqrt();
    let limb_px = FX_PX * libm::tan(angle);
    let depth_m = reach_m * libm::cos(angle);
    assert!(touch_m < distance2.sqrt());
    // A |1/z − 1/s|, times fx.
    let blur_px = 0.06 * (1.0 / depth_m - 1.0 / FOCUS_M) * FX_PX;
    assert!(blur_px > 3.0, "{blur_px}");
    for eye in Eye::BOTH {
        let (blurred, still) = (exposed(&with_aperture(scene.clone())), sharp(&scene));
        let [blurred, still] = [&blurred, &still].map(|frame| profile(frame.eye(eye)));
        let middle = 0.5 * f64::from(240_u32);
        let side = if eye == Eye::Left { 1.0 } else { -1.0 };
        let outside = |column: usize| side * (column as f64 + 0.5 - middle) - limb_px;
        for column in (0..240).filter(|c| outside(*c).abs() < 8.0) {
            let points = (0..32).map(|i| outside(column) + (f64::from(i) - 15.5) / 32.0);
            let dark = points.map(|x| disc_left_of(2.0 * x / blur_px)).sum::<f64>() / 32.0;
            let found = blurred[column] / f64::from(0.8_f32);
            assert!(
                (found - (1.0 - dark)).abs() < 0.03,
                "{} {column}: {found} for {}",
                eye.name(),
                1.0 - dark
            );
        }
        // Light on this side of the rod's middle: what is lost inside the limb is outside it.
        let half = |profile: &[f64]| -> f64 {
            let columns = (0..240).filter(|c| outside(*c).abs() < 10.0);
            columns.map(|c| profile[c] / f64::from(0.8_f32)).sum()
        };
        let shift_px = half(&blurred) - half(&still);
        assert!(shift_px.abs() < 0.01, "{}: {shift_px} px", eye.name());
    }
}

#[test]
fn what_is_in_focus_stays_sharp_and_light_is_kept() {
    // A short rod, wholly in both images.
    let mut scene = rod(FOCUS_M, 0.02);
    scene.rods[0].length_m = 0.3;
    let total = |frame: &Frame| -> f64 {
        let pixels = frame.left.pixels.iter();
        pixels.map(|p| f64::from(p.radiance[0])).sum()
    };
    let (in_focus, still) = (exposed(&with_aperture(scene.clone())), sharp(&scene));
    let worst = in_focus.left.pixels.iter().zip(&still.left.pixels);
    let worst = worst
        .map(|(a, b)| (a.radiance[0] - b.radiance[0]).abs())
        .fold(0.0, f32::max);
    assert!(worst < 0.05, "{worst} of 0.8");
    scene.rods[0].centre_m.x = 1.0;
    scene.rods[0].radius_m = 0.01;
    let (blurred, still) = (exposed(&with_aperture(scene.clone())), sharp(&scene));
    let ratio = total(&blurred) / total(&still);
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    let peak = |frame: &Frame| {
        frame
            .left
            .pixels
            .iter()
            .map(|p| p.radiance[0])
            .fold(0.0, f32::max)
    };
    assert!(peak(&blurred) < peak(&still), "it is blurred at all");
}

/// The largest change of a pixel of the left image by an aperture of f/1.5.
fn change(scene: &Scene, focus_m: f64) -> f32 {
    let mut open = with_aperture(scene.clone());
    let aperture = open.lens.aperture.as_mut().unwrap();
    (aperture.f_number, aperture.focus_m) = (1.5, focus_m);
    let (open, still) = (exposed(&open), sharp(scene));
    let pairs = open.left.pixels.iter().zip(&still.left.pixels);
    let changes = pairs.map(|(a, b)| (a.radiance[0] - b.radiance[0]).abs());
    changes.fold(0.0, f32::max)
}

/// Through a real lens, and through one behind a port, what is in focus is as sharp as through a pinhole. Focused on where the
/// port makes it seem to be, it is not.
#[test]
fn distortion_and_ports_leave_sharp_what_is_in_focus() {
    let mut scene = rod(FOCUS_M, 0.02);
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let lens = Distortion::BrownConrady([-0.2, 0.05, 0.001, -0.002, 0.0]);
        mounted.camera = Camera::new(*mounted.camera.intrinsics(), lens).unwrap();
    }
    let (in_focus, behind) = (change(&scene, FOCUS_M), change(&scene, 0.75 * FOCUS_M));
    assert!(in_focus < 0.02 && behind > 0.05, "{in_focus} {behind}");
    // On the axis of the left camera, its limbs at the borders of pixels.
    scene.rods[0].radius_m = 0.023;
    scene.rods[0].centre_m.y = scene.rig.left.rig_from_camera.origin_m().y;
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let plate = PortShape::Flat(FlatPort {
            normal: Vec3::z(),
            distance_m: 0.05,
            thickness_m: 0.01,
        });
        mounted.port = Some(Port::new(plate, Port::ACRYLIC, [1.34; 3]).unwrap());
    }
    let (in_focus, behind) = (change(&scene, FOCUS_M), change(&scene, FOCUS_M / 1.34));
    assert!(in_focus < 0.02 && behind > 0.05, "{in_focus} {behind}");
}

/// A rod in focus before a bright wall that is not: blur layer by layer would smear the wall over the limb.
#[test]
fn a_sharp_limb_before_a_blurred_background_stays_where_it_is() {
    let mut scene = rod(FOCUS_M, 0.05);
    let mut wall = common::flat_rod(Vec3::new(9.0, 0.0, -1.0), Vec3::z(), 4.0);
    wall.material = Material::Flat([0.3, 0.3, 0.3]);
    wall.length_m = 30.0;
    scene.rods.push(wall);
    let (blurred, still) = (exposed(&with_aperture(scene.clone())), sharp(&scene));
    for eye in Eye::BOTH {
        let width = |frame: &Frame| -> f64 {
            let above = profile(frame.eye(eye))
                .into_iter()
                .map(|v| v - f64::from(0.3_f32));
            above.sum::<f64>() / f64::from(0.8_f32 - 0.3)
        };
        let change_px = width(&blurred) - width(&still);
        assert!(change_px.abs() < 0.02, "{}: {change_px} px", eye.name());
    }
}

/// A box as long as the path convolves the rod: its variance adds to the rod's, its centre is that of mid-exposure.
#[test]
fn a_streak_has_the_length_of_the_path_and_the_middle_of_the_exposure() {
    let (x_m, speed) = (2.0, 3.0);
    let still = sharp(&rod(x_m, 0.03));
    let path_px = FX_PX * speed * 0.02 / x_m;
    // Off the axis a turn's path is longer by 1/cos²; by as much it is shorter for an eye beside the rig's origin, which goes to and
    // fro as the rig turns.
    let turned_px = FX_PX * 1.6 * 0.02;
    for (velocity, turn, path_px) in [
        (Vec3::new(0.0, speed, 0.0), Vec3::zeros(), path_px),
        (Vec3::zeros(), Vec3::new(0.0, 0.0, 1.6), turned_px),
    ] {
        let scene = moving(rod(x_m, 0.03), velocity, turn);
        let frame = exposed(&scene);
        for eye in Eye::BOTH {
            let (sum, centre, variance) = moments(&profile(frame.eye(eye)));
            let (still_sum, still_centre, _) = moments(&profile(still.eye(eye)));
            assert!((sum / still_sum - 1.0).abs() < 2e-3, "{sum} {still_sum}");
            // Variances add: a box of the rod's width, one of the path's length, one of the pixel's side.
            let width_px = sum / f64::from(0.8_f32);
            let streak_px = (12.0 * variance - 1.0 - width_px * width_px).sqrt();
            assert!(
                (streak_px / path_px - 1.0).abs() < 0.01,
                "{streak_px} for {path_px}"
            );
            assert!(
                (centre - still_centre).abs() < 0.01,
                "{centre} {still_centre}"
            );
        }
    }
    // Geometry is that of the middle of the exposure.
    let frame = exposed(&moving(
        rod(x_m, 0.03),
        Vec3::new(0.0, speed, 0.0),
        Vec3::zeros(),
    ));
    for (a, b) in frame.left.pixels.iter().zip(&still.left.pixels) {
        assert_eq!(
            (a.instance, a.depth_m.to_bits()),
            (b.instance, b.depth_m.to_bits())
        );
    }
}

/// Lamps are on the rig: a rod lit by a lamp that moves along is as bright as one that stands, and light fields stay one sum.
#[test]
fn lamps_move_with_the_rig() {
    let mut scene = common::crossing(16);
    let still = sharp(&scene);
    scene = moving(scene, Vec3::new(0.0, 0.0, 0.02), Vec3::zeros());
    let frame = exposed(&scene);
    let mean = |frame: &Frame| -> f64 {
        let pixels = frame.left.pixels.iter();
        pixels.map(|p| f64::from(p.radiance[1])).sum()
    };
    assert!((mean(&frame) / mean(&still) - 1.0).abs() < 1e-3);
    for pixel in &frame.left.pixels {
        for k in 0..3 {
            let sum = pixel.direct[k] + pixel.backscatter[k];
            assert!((pixel.radiance[k] - sum).abs() <= 2e-6 * pixel.radiance[k].max(1e-3));
        }
    }
}

#[test]
fn blur_beyond_all_measure_is_refused() {
    let scene = moving(
        rod(2.0, 0.03),
        Vec3::new(0.0, 90.0, 0.0),
        Vec3::new(0.0, 0.0, 60.0),
    );
    let scene = with_aperture(scene);
    let mut near = scene.clone();
    near.lens.aperture.as_mut().unwrap().focal_length_m = 0.9;
    let error = expose(&CpuRenderer, &near, &|_| ()).unwrap_err();
    assert!(matches!(error, RenderError::Blur { .. }), "{error}");
    assert!(
        error
            .to_string()
            .contains("lens.aperture and motion: expected"),
        "{error}"
    );
}

/// Half a turn and whole ones end where nothing is to be seen, or where they began.
#[test]
fn turns_out_of_sight_are_no_still_pictures() {
    for turn_rad in [PI, 2.0 * PI] {
        let turn = Vec3::new(0.0, 0.0, turn_rad / 0.02);
        let scene = moving(rod(2.0, 0.03), Vec3::zeros(), turn);
        match expose(&CpuRenderer, &scene, &|_| ()) {
            Err(RenderError::Blur { motion_px, .. }) => {
                // On the axis fx px a rad, elsewhere more.
                assert!(motion_px > 0.99 * FX_PX * turn_rad, "{motion_px}");
            }
            other => panic!("{turn_rad}: {:?}", other.map(|_| ())),
        }
    }
}

/// Counts the renders.
struct Counted(AtomicUsize);

impl Renderer for Counted {
    fn backend(&self) -> &'static str {
        CpuRenderer.backend()
    }

    fn adapter(&self) -> String {
        CpuRenderer.adapter()
    }

    fn render(&self, scene: &Scene, progress: &(dyn Fn(f64) + Sync)) -> Result<Frame, RenderError> {
        self.0.fetch_add(1, Ordering::Relaxed);
        CpuRenderer.render(scene, progress)
    }
}

/// Snow is nearer than any surface, and so are its streaks longer.
#[test]
fn streaks_of_snow_are_whole() {
    let renders = |snow: Option<Snow>| {
        let mut scene = moving(rod(2.0, 0.03), Vec3::new(0.0, 0.25, 0.0), Vec3::zeros());
        scene.snow = snow;
        let counted = Counted(AtomicUsize::new(0));
        expose(&counted, &scene, &|_| ()).unwrap();
        counted.0.into_inner()
    };
    let snow = Snow {
        number_per_m3: 10.0,
        diameter_m: [1e-3, 2e-3],
        exponent: 3.0,
        albedo: [0.2; 3],
        range_m: [0.25, 2.0],
        seed: None,
    };
    // 5 mm at a quarter of a metre, two renders a pixel.
    let wanted = 2.0 * FX_PX * 0.005 / 0.25;
    let (clear, snowy) = (renders(None), renders(Some(snow)));
    assert!(clear < 4 && snowy as f64 >= wanted, "{clear} {snowy}");
}
