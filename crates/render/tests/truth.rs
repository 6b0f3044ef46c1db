//! The truth record against geometry worked out apart from the renderer.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use common::{BROWN, KANNALA, crossing, distorted};
use rodsight_geometry::{
    Camera, Cylinder, Distortion, Eye, Intrinsics, Line3, Pixel, Vec3, radians, rotation_from_rpy,
};
use rodsight_render::{CpuRenderer, Frame, Renderer, Truth, develop};
use rodsight_scene::{Bend, EdgeSampling, Material, Rod, Scene, Sensor};
use rodsight_testkit::Golden;

fn render(scene: &Scene) -> Frame {
    CpuRenderer.render(scene, &|_| ()).unwrap()
}

fn truth(scene: &Scene) -> Truth {
    Truth::of(scene, &render(scene), 1.0).unwrap()
}

/// The steep line of the golden table: printed grasp point, corrected direction.
#[test]
fn truth_of_the_steep_line_has_the_golden_numbers() {
    let golden = Golden::load(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../geometry/tests/golden/paper.toml"),
    );
    let number = |key: &str| golden.f64(&format!("synthetic.steep_line.{key}"));
    let array = |key: &str| golden.array::<2>(&format!("synthetic.steep_line.{key}"));
    let point = Vec3::from(golden.array::<3>("synthetic.steep_line.axis_point_m"));
    let direction = Vec3::from(golden.array::<3>("synthetic.steep_line.axis_dir"));
    let mut scene = common::empty(1);
    for eye in [&mut scene.rig.left, &mut scene.rig.right] {
        let i = Intrinsics {
            fx_px: golden.f64("camera.recomputed.k_px"),
            fy_px: golden.f64("camera.recomputed.k_px"),
            ..*eye.camera.intrinsics()
        };
        eye.camera = Camera::new(i, Distortion::None).unwrap();
    }
    scene
        .rods
        .push(common::flat_rod(point, direction, number("radius_m")));
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 2 };
    let truth = truth(&scene);
    let close = |found: [f64; 2], expected: [f64; 2], tolerance: f64| {
        assert!(
            (Pixel::from(found) - Pixel::from(expected)).norm() < tolerance,
            "{found:?} and {expected:?}"
        );
    };
    close(truth.grasp.pick_px, array("left_grasp_px"), 2e-6);
    assert!((Vec3::from(truth.grasp.paper_point_m) - point).norm() < 1e-9);
    for (name, eye, view) in [
        ("left", Eye::Left, &truth.rods[0].left),
        ("right", Eye::Right, &truth.rods[0].right),
    ] {
        let grasp = scene.rig.eye(eye).project(&point).unwrap();
        close(grasp.into(), array(&format!("{name}_grasp_px")), 2e-6);
        let lines = view.lines.unwrap();
        let polar = |line: rodsight_geometry::ImageLine| {
            [line.rho_px, rodsight_geometry::degrees(line.theta_rad)]
        };
        close(polar(lines.axis), array(&format!("{name}_axis")), 1e-7);
        close(
            polar(lines.plus_limb),
            array(&format!("{name}_limbs.0")),
            1e-7,
        );
        close(
            polar(lines.minus_limb),
            array(&format!("{name}_limbs.1")),
            1e-7,
        );
        assert!(view.curves.is_none() && view.visible_px > 50_000);
    }
    // The surface foot lies r cot ψ from the axis point on the pick ray.
    let (_, ray) = scene
        .rig
        .left
        .ray(&Pixel::from(truth.grasp.pick_px))
        .unwrap();
    let psi = rodsight_geometry::angle_between(&ray, &direction);
    let apart = (Vec3::from(truth.grasp.point_m) - point).norm();
    let expected = number("radius_m") / libm::tan(psi).abs();
    assert!((apart - expected).abs() < 1e-9, "{apart} and {expected}");
}

/// A pick near the end of a rod seen from beyond it meets the cap, whose foot is the end, not a point past it.
#[test]
fn grasp_at_an_end_stays_on_the_rod() {
    let mut scene = common::empty(16);
    scene.rods.push(Rod {
        length_m: 1.0,
        ..common::flat_rod(Vec3::new(2.5, -0.5, -1.0), Vec3::new(1.0, 0.0, 0.3), 0.05)
    });
    scene.target.along_m = -0.47;
    let truth = truth(&scene);
    let rod = &scene.rods[0];
    let along = (Vec3::from(truth.grasp.point_m) - rod.centre_m).dot(&rod.direction);
    assert!((along + 0.5).abs() < 1e-9, "{along}");
}

/// Seen across, an end is met or missed by the pick's ray as rounding will have it.
#[test]
fn grasp_at_the_very_ends_can_be_picked() {
    let mut scene = common::empty(64);
    scene
        .rods
        .push(common::flat_rod(Vec3::x(), Vec3::x(), 0.05));
    let frame = render(&scene);
    let eye_m = scene.rig.left.rig_from_camera.origin_m();
    for i in 0..200 {
        let turn = f64::from(i);
        let end_m = eye_m + Vec3::new(2.3, 0.3 * libm::sin(turn), 0.2 * libm::cos(turn));
        let slope = Vec3::new(0.0, libm::cos(2.0 * turn), libm::sin(2.0 * turn));
        let direction = (end_m - eye_m).cross(&slope).normalize();
        let length_m = 0.3 + 0.0037 * turn;
        for side in [-0.5, 0.5] {
            scene.target.along_m = side * length_m;
            scene.rods[0] = Rod {
                length_m,
                ..common::flat_rod(end_m - direction * scene.target.along_m, direction, 0.05)
            };
            let truth = Truth::of(&scene, &frame, 1.0);
            let grasp = truth.unwrap_or_else(|| panic!("rod {i}, {side}")).grasp;
            let off_m = (Vec3::from(grasp.axis.point_m) - end_m).norm();
            assert!(off_m < 1e-8, "rod {i}: {off_m} m from its end");
        }
    }
}

#[test]
fn visible_stretches_and_pixels_know_what_hides_the_rod() {
    let scene = crossing(8);
    let frame = render(&scene);
    let truth = Truth::of(&scene, &frame, 1.0).unwrap();
    let behind = &truth.rods[0];
    let origin = scene.rig.left.rig_from_camera.origin_m();
    let hiding = Cylinder {
        axis: Line3::new(scene.rods[1].centre_m, &scene.rods[1].direction),
        radius_m: scene.rods[1].radius_m,
    };
    assert_eq!(
        behind.left.visible_m.len(),
        2,
        "{:?}",
        behind.left.visible_m
    );
    let [[from, end], [begin, to]] = [behind.left.visible_m[0], behind.left.visible_m[1]];
    assert!(from < end && end < begin && begin < to);
    // Where the rod vanishes behind the other, rays to its axis touch that one.
    for s in [end, begin] {
        let point = scene.rods[0].centre_m + scene.rods[0].direction * s;
        let ray = (point - origin).normalize();
        let cross = ray.cross(&hiding.axis.direction);
        let gap = (hiding.axis.point_m - origin).dot(&cross).abs() / cross.norm();
        assert!((gap - hiding.radius_m).abs() < 1e-6, "{s}: {gap}");
    }
    for (eye, view) in [(Eye::Left, &behind.left), (Eye::Right, &behind.right)] {
        let seen = frame.eye(eye).pixels.iter();
        let seen = seen.filter(|pixel| pixel.instance == behind.instance);
        assert_eq!(view.visible_px, seen.count() as u64);
    }
}

/// Distance, over the rows of the image, between a limb's curve in the truth and the edge of the rendered silhouette: the light on
/// a row, from outside to well inside the rod, is the place of the edge.
fn curve_errors(scene: &Scene, eye: Eye) -> Vec<f64> {
    let frame = CpuRenderer.render_eye(scene, eye, &|_| ()).unwrap();
    let truth = truth(scene);
    let view = match eye {
        Eye::Left => &truth.rods[0].left,
        Eye::Right => &truth.rods[0].right,
    };
    let curves = view.curves.as_ref().expect("lines do not do here");
    let crossing = |curve: &[[f64; 2]], v: f64| {
        curve.windows(2).find_map(|pair| {
            let ([u0, v0], [u1, v1]) = (pair[0], pair[1]);
            let s = (v - v0) / (v1 - v0);
            (0.0..1.0).contains(&s).then_some(u0 + s * (u1 - u0))
        })
    };
    let mut errors = Vec::new();
    for row in 4..frame.height_px - 4 {
        // The light of a row is the mean over it: compare with the mean of the curve.
        let mean = |curve: &[[f64; 2]]| -> Option<f64> {
            let at = (0..8).map(|k| crossing(curve, f64::from(row) + (f64::from(k) + 0.5) / 8.0));
            at.sum::<Option<f64>>().map(|sum| sum / 8.0)
        };
        let (Some(axis), Some(plus), Some(minus)) = (
            mean(&curves.axis),
            mean(&curves.plus_limb),
            mean(&curves.minus_limb),
        ) else {
            continue;
        };
        for edge in [plus, minus] {
            let inside = axis.floor();
            let outside = (edge + (edge - inside).signum() * 4.0).floor();
            if inside.min(outside) < 0.0 || inside.max(outside) >= f64::from(frame.width_px) {
                continue;
            }
            let columns = inside.min(outside) as u32..inside.max(outside) as u32;
            let light: f64 = columns
                .map(|column| f64::from(frame.at(column, row).radiance[0]) / f64::from(0.8_f32))
                .sum();
            let found = if outside > inside {
                inside + light
            } else {
                inside - light
            };
            errors.push(found - edge);
        }
    }
    errors
}

#[test]
fn curves_lie_on_the_silhouette_of_bent_rods_and_of_distorted_lenses() {
    let straight = || {
        let mut scene = common::empty(8);
        scene.rods.push(common::flat_rod(
            Vec3::new(2.3, 0.1, -1.0),
            Vec3::new(0.1, 0.25, 1.0),
            0.12,
        ));
        scene.rods[0].length_m = 4.0;
        scene.sampling.edge = EdgeSampling::Fibonacci { points: 2584 };
        scene
    };
    let mut bent = straight();
    bent.rods[0].bend = Some(Bend {
        sagitta_m: 0.4,
        towards: bent.rods[0].direction.cross(&Vec3::x()).normalize(),
    });
    let mut both = distorted(BROWN, bent.clone());
    both.sampling.edge = EdgeSampling::Fibonacci { points: 2584 };
    for (name, scene) in [
        ("bent", bent),
        ("Brown–Conrady", distorted(BROWN, straight())),
        ("Kannala–Brandt", distorted(KANNALA, straight())),
        ("bent and distorted", both),
    ] {
        for eye in Eye::BOTH {
            let errors = curve_errors(&scene, eye);
            assert!(errors.len() > 100, "{name}: {} rows", errors.len());
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let worst = errors.iter().fold(0.0_f64, |w, e| w.max(e.abs()));
            println!(
                "{name} {}: mean {mean:.5} px, worst {worst:.5} px",
                eye.name()
            );
            assert!(
                mean.abs() < 0.002 && worst < 0.01,
                "{name}: {mean}, {worst}"
            );
        }
    }
}

/// Contrast over noise as the truth says it, and as thirty noisy images show it.
#[test]
fn contrast_to_noise_is_what_noisy_images_show() {
    for sensor in [
        Sensor::Plain {
            noise_sigma_dn: 6.0,
        },
        common::wet(8).sensor,
    ] {
        let mut scene = common::empty(8);
        scene.rods.push(Rod {
            material: Material::Flat([0.5, 0.3, 0.2]),
            ..common::flat_rod(Vec3::new(2.3, 0.0, -1.0), Vec3::z(), 0.15)
        });
        scene.background_radiance = [0.2, 0.25, 0.3];
        scene.white_balance = [1.1, 1.0, 1.5];
        scene.sensor = sensor;
        let frame = render(&scene);
        let expected = Truth::of(&scene, &frame, 1.0).unwrap().rods[0]
            .left
            .contrast_to_noise[0]
            .unwrap();
        // Two columns of the left image: one on the rod, one beside it.
        let on = (0..240)
            .filter(|&u| frame.left.at(u, 60).instance == 2)
            .collect::<Vec<_>>();
        let (on, off) = (on[on.len() / 2], on[0] - 10);
        let mut samples: [[Vec<f64>; 2]; 3] = Default::default();
        for seed in 0..30 {
            scene.seed = seed;
            let image = develop(&frame, &scene).unwrap().left;
            let rodsight_geometry::Samples::U16(values) = image.samples() else {
                panic!("asked for 16 bits");
            };
            for row in 10..120 {
                for (place, column) in [on, off].into_iter().enumerate() {
                    for (k, band) in samples.iter_mut().enumerate() {
                        band[place].push(f64::from(values[(row * 240 + column as usize) * 3 + k]));
                    }
                }
            }
        }
        let mut squares = 0.0;
        for band in &samples {
            let moments = band.each_ref().map(|values: &Vec<f64>| {
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
                (mean, variance / (values.len() - 1) as f64)
            });
            let noise2 = 0.5 * (moments[0].1 + moments[1].1);
            squares += (moments[0].0 - moments[1].0) * (moments[0].0 - moments[1].0) / noise2;
        }
        let found = squares.sqrt();
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{found} for {expected}"
        );
    }
}

/// A turned camera with another focal length than the left one: its own pixels decide what is an edge.
#[test]
fn right_camera_of_longer_pixels_is_smoothed_by_its_own() {
    let mut scene = common::empty(2);
    let coarse = Intrinsics {
        width_px: 60,
        height_px: 34,
        fx_px: 49.0,
        fy_px: 49.0,
        cx_px: 30.0,
        cy_px: 17.0,
    };
    scene.rig.right.camera = Camera::new(coarse, Distortion::None).unwrap();
    scene.rig.right.rig_from_camera = rodsight_geometry::Pose::new(
        rotation_from_rpy(radians(90.0), 0.0, radians(88.0)),
        Vec3::new(0.0, 0.5, -1.0),
    );
    // A third of a coarse pixel wide.
    scene.rods.push(common::flat_rod(
        Vec3::new(2.3, 0.3, -1.0),
        Vec3::new(0.0, 0.2, 1.0),
        0.008,
    ));
    let frame = CpuRenderer.render_eye(&scene, Eye::Right, &|_| ()).unwrap();
    for row in 2..frame.height_px - 2 {
        let light: f32 = (0..frame.width_px)
            .map(|u| frame.at(u, row).radiance[0])
            .sum();
        let width = f64::from(light) / f64::from(0.8_f32);
        let expected = 2.0 * 0.008 / 2.3 * 49.0;
        assert!(
            (width / expected - 1.0).abs() < 0.1,
            "row {row}: {width} for {expected}"
        );
    }
}
