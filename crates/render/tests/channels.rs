//! The truth channels against geometry worked out apart from the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use common::{BROWN, KANNALA, crossing, distorted};
use rodsight_geometry::{Eye, Pixel, Vec3};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, Renderer, Truth};
use rodsight_scene::Scene;

fn render(scene: &Scene) -> Frame {
    CpuRenderer.render(scene, &|_| ()).unwrap()
}

#[test]
fn depth_range_and_normal_are_those_of_the_cylinder() {
    for scene in [
        crossing(8),
        distorted(BROWN, crossing(8)),
        distorted(KANNALA, crossing(8)),
    ] {
        let frame = render(&scene);
        let mut compared = 0;
        for eye in Eye::BOTH {
            let (mounted, frame) = (scene.rig.eye(eye), frame.eye(eye));
            for (index, pixel) in frame.pixels.iter().enumerate() {
                let Some(rod) = pixel.instance.checked_sub(2) else {
                    continue;
                };
                let rod = &scene.rods[usize::from(rod)];
                let centre = Pixel::new(
                    f64::from(index as u32 % frame.width_px) + 0.5,
                    f64::from(index as u32 / frame.width_px) + 0.5,
                );
                let (origin, ray) = mounted.ray(&centre).unwrap();
                // |(o + t v − p) × d|² = r², written out.
                let d = rod.direction;
                let (a, b) = (ray.cross(&d), (origin - rod.centre_m).cross(&d));
                let half = a.dot(&b) / a.norm_squared();
                let rest = (b.norm_squared() - rod.radius_m * rod.radius_m) / a.norm_squared();
                let t = -half - (half * half - rest).sqrt();
                let point = origin + ray * t;
                let along = (point - rod.centre_m).dot(&d);
                if along.abs() > rod.length_m / 2.0 {
                    continue; // a cap
                }
                let camera_from_rig = mounted.rig_from_camera.inverse();
                let normal =
                    camera_from_rig.direction(&((point - rod.centre_m - d * along) / rod.radius_m));
                let z = camera_from_rig.point(&point).z;
                assert!((f64::from(pixel.range_m) / t - 1.0).abs() < 1e-6);
                assert!((f64::from(pixel.depth_m) / z - 1.0).abs() < 1e-6);
                for k in 0..3 {
                    // Beside the limb the normal turns fast with t.
                    assert!((f64::from(pixel.normal[k]) - normal[k]).abs() < 1e-5);
                }
                compared += 1;
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}

/// A visible point of the left image is found in the right one where its disparity says; a hidden one is not.
#[test]
fn disparity_leads_to_the_same_surface_unless_it_is_occluded() {
    let scene = crossing(4);
    let frame = render(&scene);
    let (mut visible, mut hidden, mut agree, mut hidden_agree) = (0, 0, 0, 0);
    for row in 0..frame.left.height_px {
        for column in 0..frame.left.width_px {
            let pixel = frame.left.at(column, row);
            if pixel.instance < 2 {
                continue;
            }
            let u = f64::from(column) + 0.5 - f64::from(pixel.disparity_px);
            if !(0.0..f64::from(frame.right.width_px)).contains(&u) {
                assert!(pixel.occluded);
                continue;
            }
            let there = frame.right.at(u as u32, row);
            // A pixel of the right image is not just where the point is: half a pixel of slope is allowed.
            let same = there.instance == pixel.instance
                && (there.depth_m / pixel.depth_m - 1.0).abs() < 0.01;
            if pixel.occluded {
                hidden += 1;
                hidden_agree += u32::from(same);
            } else {
                visible += 1;
                agree += u32::from(same);
            }
        }
    }
    assert!(visible > 5000 && hidden > 200, "{visible}, {hidden}");
    assert!(
        f64::from(agree) > 0.97 * f64::from(visible),
        "{agree} of {visible}"
    );
    assert!(
        f64::from(hidden_agree) < 0.35 * f64::from(hidden),
        "{hidden_agree} of {hidden}"
    );
}

fn assert_conventions(name: &str, frame: &EyeFrame) {
    for (index, pixel) in frame.pixels.iter().enumerate() {
        for (k, value) in common::numbers(pixel).into_iter().enumerate() {
            let may_be_infinite = (24..27).contains(&k);
            assert!(
                value.is_finite() || (may_be_infinite && value == f32::INFINITY),
                "{name}: number {k} of pixel {index} is {value}"
            );
        }
        if pixel.instance == 0 {
            assert_eq!(pixel.depth_m, f32::INFINITY, "{name}");
            assert_eq!(pixel.range_m, f32::INFINITY, "{name}");
            assert_eq!(pixel.disparity_px, f32::INFINITY, "{name}");
            assert_eq!((pixel.normal, pixel.material), ([0.0; 3], 0), "{name}");
            assert!(!pixel.occluded, "{name}");
        } else {
            assert!(pixel.range_m.is_finite() && pixel.range_m > 0.0, "{name}");
            let norm = pixel.normal.iter().map(|v| v * v).sum::<f32>();
            assert!((norm - 1.0).abs() < 1e-5, "{name}: |n|² {norm}");
        }
    }
}

#[test]
fn every_value_is_finite_or_stands_for_nothing() {
    let along_the_view = || {
        let mut scene = common::wet(16);
        let eye = scene.rig.left.rig_from_camera.origin_m();
        scene
            .rods
            .push(common::orange_rod(eye + Vec3::x() * 3.0, Vec3::x(), 0.05));
        scene
    };
    let lamp_in_the_camera = || {
        let mut scene = crossing(16);
        scene.lamps[0].position_m = scene.rig.left.rig_from_camera.origin_m();
        scene
    };
    let through_the_border = || {
        let mut scene = crossing(16);
        scene.rods[0].centre_m = Vec3::new(0.8, -0.9, -1.2);
        scene.rods[1].direction = Vec3::x();
        scene
    };
    let lamp_before_an_end = || {
        let mut scene = crossing(16);
        let rod = &scene.rods[0];
        scene.lamps[0].position_m = rod.centre_m - rod.direction * 2.0;
        scene
    };
    let many_lamps = || {
        let mut scene = crossing(32);
        scene.lamps = (0..40).map(|_| scene.lamps[0]).collect();
        scene
    };
    let no_floor = || {
        let mut scene = distorted(KANNALA, crossing(16));
        scene.seabed = None;
        scene
    };
    for (name, scene) in [
        ("rod along the view", along_the_view()),
        ("lamp in the camera", lamp_in_the_camera()),
        ("rod through the border", through_the_border()),
        ("lamp before an end of the rod", lamp_before_an_end()),
        ("forty lamps", many_lamps()),
        ("Brown–Conrady", distorted(BROWN, crossing(16))),
        ("Kannala–Brandt before nothing", no_floor()),
    ] {
        let frame = render(&scene);
        for eye in Eye::BOTH {
            assert_conventions(name, frame.eye(eye));
        }
        let truth = Truth::of(&scene, &frame, 1.0).unwrap();
        let json = serde_json::to_string(&truth).unwrap();
        let back: Truth = serde_json::from_str(&json).unwrap();
        assert_eq!(
            back, truth,
            "{name}: null stands where a number was not finite"
        );
    }
}
