//! The truth of rods of which the image shows little: what it says is as close as the image asks for, not as the rod is long.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "helpers of tests may panic; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Camera, Distortion, Intrinsics, Pixel, Vec3};
use rodsight_render::{CpuRenderer, Renderer, Truth};
use rodsight_scene::{EdgeSampling, Rod, Scene};

fn truth(scene: &mut Scene) -> Truth {
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 2 };
    let frame = CpuRenderer.render(scene, &|_| ()).unwrap();
    Truth::of(scene, &frame, 1.0).unwrap()
}

fn pipe(centre_m: Vec3, direction: Vec3, length_m: f64) -> Rod {
    Rod {
        length_m,
        ..common::flat_rod(centre_m, direction, 0.05)
    }
}

#[test]
fn thin_hose_leaves_its_gap_in_a_long_pipe_wherever_it_hangs() {
    for y_m in [-0.63, -0.6, -0.57, -0.54, -0.51] {
        let mut scene = common::empty(8);
        scene
            .rods
            .push(pipe(Vec3::new(2.3, 0.3, -1.0), Vec3::y(), 20.0));
        // 20 mm wide, 2.4 px.
        let hose = common::flat_rod(Vec3::new(1.6, y_m, -1.0), Vec3::z(), 0.01);
        scene.rods.push(hose);
        let stretches = truth(&mut scene).rods[0].left.visible_m.clone();
        let [[from, end], [begin, to]] = stretches[..] else {
            panic!("{y_m}: {stretches:?}");
        };
        // The planes through the eye at (0, −0.5) that touch the hose.
        let (x, y) = (1.6, y_m + 0.5);
        let half_rad = libm::asin(0.01 / libm::hypot(x, y));
        for (found, side) in [(end, -1.0), (begin, 1.0)] {
            let expected = 2.3 * libm::tan(libm::atan2(y, x) + side * half_rad) - 0.8;
            assert!(
                (found - expected).abs() < 1e-6,
                "{y_m}: {found}, {expected}"
            );
        }
        assert!(from < end && begin < to, "{stretches:?}");
    }
}

#[test]
fn visible_stretch_of_a_pipeline_is_what_the_image_shows() {
    for centre_y_m in [-300.0, 1.9, 2.0, 101.9] {
        let mut scene = common::empty(8);
        let rod = pipe(Vec3::new(2.3, centre_y_m, -1.0), Vec3::y(), 1000.0);
        scene.rods.push(rod);
        scene.target.along_m = -0.5 - centre_y_m;
        let truth = truth(&mut scene);
        let stretches = &truth.rods[0].left.visible_m;
        let [ends] = stretches[..] else {
            panic!("{centre_y_m}: {stretches:?}");
        };
        for (s_m, border_px) in ends.into_iter().zip([0.0, 240.0]) {
            let point = Vec3::new(2.3, centre_y_m + s_m, -1.0);
            let pixel = scene.rig.left.project(&point).unwrap();
            assert!(
                (pixel.x - border_px).abs() < 1e-6,
                "{pixel:?}, {border_px} px"
            );
        }
    }
}

/// The fold of this lens is 0.06 px beyond a corner of the image.
fn folding() -> Camera {
    let i = Intrinsics {
        width_px: 240,
        height_px: 136,
        fx_px: 196.0,
        fy_px: 193.0,
        cx_px: 121.5,
        cy_px: 66.0,
    };
    Camera::new(i, Distortion::BrownConrady([-0.287, 0.0, 0.0, 0.0, 0.0])).unwrap()
}

#[test]
fn curves_reach_the_border_of_an_image_that_ends_at_the_fold() {
    let camera = folding();
    // Through the optical axis to that corner.
    let corner = Vec3::new(0.0, -121.5 / 196.0, 70.0 / 193.0);
    for length_m in [20.0, 27.0, 33.0, 71.0, 200.0, 2000.0] {
        let mut scene = common::empty(8);
        scene.rig.left.camera = camera;
        scene.rig.right.camera = camera;
        let rod = pipe(Vec3::new(2.3, -0.5, -1.0), corner, length_m);
        scene.rods.push(rod);
        let truth = truth(&mut scene);
        let curves = truth.rods[0].left.curves.as_ref().unwrap();
        for curve in [&curves.plus_limb, &curves.minus_limb, &curves.axis] {
            for end in [curve[0], curve[curve.len() - 1]] {
                assert!(!camera.contains(&Pixel::from(end)), "{length_m} m: {end:?}");
            }
        }
        // And it is the axis, to what its field promises.
        let distance = |p: Pixel| {
            let pieces = curves.axis.windows(2).map(|pair| {
                let [a, b] = [Pixel::from(pair[0]), Pixel::from(pair[1])];
                let chord = b - a;
                let t = (p - a).dot(&chord) / chord.norm_squared().max(1e-300);
                (a + chord * t.clamp(0.0, 1.0) - p).norm()
            });
            pieces.fold(f64::INFINITY, f64::min)
        };
        let rod = &scene.rods[0];
        for i in -1000..=1000 {
            let point = rod.centre_m + rod.direction * (f64::from(i) * 2.4e-3);
            let Some(pixel) = scene.rig.left.project(&point) else {
                continue;
            };
            if camera.contains(&pixel) {
                let off_px = distance(pixel);
                assert!(off_px < 1e-3, "{length_m} m: {off_px} px at {pixel:?}");
            }
        }
    }
}
