//! The paper's method on rendered pairs lands where theory says: averaging the limbs of each image puts the axis of an upright,
//! fronto-parallel rod r²/Z too near, Canny on a binary image is good to a fraction of a pixel, and the bisector of the tangent planes
//! removes the first part.
#![expect(clippy::unwrap_used, reason = "helpers of tests may")]

use rodsight_bench::{Errors, LimbStretch, Limit, edge_sigma_px, limit, limit_of, measure};
use rodsight_geometry::{Cylinder, Eye, Line3, Side, StereoPair, Vec3};
use rodsight_render::{CpuRenderer, Renderer, Truth, develop};
use rodsight_scene::Scene;
use rodsight_solver::{Method, PaperParams, Pick, Request, solve};

/// A noise-free flat orange rod before blue, upright but for a fraction of a degree so that its edges pass all phases of the pixel.
fn scene(radius_m: f64, noise_sigma_dn: f64) -> Scene {
    let text = format!(
        r#"
schema = 1
id = "theory"
mode = "air"
rig_file = "rigs/paper.toml"
background_radiance_w_per_m2_sr = [0.05, 0.10, 0.30]
[[rod]]
id = "rod"
centre_m = [2.3, 0.03, -1.02]
direction = [0.0, 0.02, 1.0]
length_m = 4.0
radius_m = {radius_m}
flat_radiance_w_per_m2_sr = [0.8, 0.3, 0.05]
[target]
rod = "rod"
along_m = 0.0
pick_eye = "left"
[exposure]
gain_m2_sr_per_w = 1.0
[sensor.plain]
noise_sigma_dn = {noise_sigma_dn:?}
"#
    );
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/theory.toml");
    Scene::from_toml(&text, beside.as_ref()).unwrap()
}

fn located(scene: &Scene, method: Method) -> (Truth, Errors) {
    let frame = CpuRenderer.render(scene, &|_| ()).unwrap();
    let developed = develop(&frame, scene).unwrap();
    let truth = Truth::of(scene, &frame, developed.gain).unwrap();
    let pair = StereoPair::new(scene.rig, developed.left, developed.right).unwrap();
    let pick = Pick {
        pixel: truth.grasp.pick_px.into(),
        eye: truth.grasp.pick_eye,
    };
    let request = Request {
        pick: Some(pick),
        ..Request::new(&pair)
    };
    let estimate = solve(&request, method, &PaperParams::default()).unwrap();
    let errors = measure(&truth, &estimate).unwrap();
    (
        truth,
        errors.unwrap_or_else(|| panic!("{method:?} refused: {:?}", estimate.reason)),
    )
}

/// Half a pixel of disparity at 2.3 m: Z² · 0.5 / (f b).
const HALF_PIXEL_OF_DEPTH_M: f64 = 2.3 * 2.3 * 0.5 / 1566.5776;

#[test]
fn averaging_is_biased_by_r_squared_over_z_and_the_bisector_is_not() {
    for radius_m in [0.01, 0.03, 0.05, 0.1, 0.2, 0.3] {
        let scene = scene(radius_m, 0.0);
        let (_, paper) = located(&scene, Method::Paper);
        let (_, bisector) = located(&scene, Method::PaperBisector);
        let bias_m = -radius_m * radius_m / 2.3;
        println!(
            "r {:3.0} mm: theory {:7.2}, paper {:7.2}, paper-bisector {:6.2} mm",
            radius_m * 1e3,
            bias_m * 1e3,
            paper.depth_m * 1e3,
            bisector.depth_m * 1e3
        );
        assert!(
            (paper.depth_m - bias_m).abs() < HALF_PIXEL_OF_DEPTH_M,
            "r {radius_m}: {} for {bias_m}",
            paper.depth_m
        );
        assert!(
            bisector.depth_m.abs() < HALF_PIXEL_OF_DEPTH_M,
            "r {radius_m}: {}",
            bisector.depth_m
        );
        // The two see the same edges: what differs is the bias alone.
        let removed_m = paper.depth_m - bisector.depth_m;
        assert!(
            (removed_m / bias_m - 1.0).abs() < 0.02 || (removed_m - bias_m).abs() < 2e-5,
            "r {radius_m}: {removed_m}"
        );
    }
}

/// The founding scene: shaded, in water, with noise. What the bisector removes is still the bias r²/D, D the distance to the axis;
/// what is left is Canny's fraction of a pixel.
#[test]
fn founding_scene_lands_where_theory_says() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/paper.toml");
    let scene = Scene::load(path.as_ref()).unwrap();
    let (_, paper) = located(&scene, Method::Paper);
    let (_, bisector) = located(&scene, Method::PaperBisector);
    let rod = &scene.rods[scene.target.rod];
    let distance_m = rod.centre_m.x;
    let bias_m = -rod.radius_m * rod.radius_m / distance_m;
    let removed_m = paper.depth_m - bisector.depth_m;
    assert!(
        (removed_m / bias_m - 1.0).abs() < 0.1,
        "{removed_m} for {bias_m}"
    );
    assert!(
        bisector.depth_m.abs() < HALF_PIXEL_OF_DEPTH_M,
        "{}",
        bisector.depth_m
    );
    assert!(
        bisector.axis_angle_rad < 2e-4 && paper.axis_angle_rad < 2e-4,
        "{bisector:?} {paper:?}"
    );
}

/// `σ_Z = Z² σ_ρ/(f b)`, `σ_ρ = σ₁/√L`: the closed form for an upright rod in the middle.
#[test]
fn limit_agrees_with_the_closed_form_of_an_upright_rod() {
    let scene = scene(0.05, 4.0);
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    let Limit {
        axis_offset_m,
        axis_angle_rad,
        ..
    } = limit(&truth)
        .unwrap()
        .expect("a straight rod with noise has a limit");
    let rod = truth.target();
    let contrast = rod.left.contrast_to_noise[0].unwrap();
    let sigma1 = (2.0 * core::f64::consts::PI.sqrt() * (1.0_f64 / 12.0).sqrt()).sqrt() / contrast;
    let (z_m, focal_px, baseline_m, length_px) = (2.3, 1566.5776, 1.0, 1080.0_f64);
    let sigma_px = sigma1 / length_px.sqrt();
    // Each view has two limbs, the disparity two views: the factors cancel. Across: half of that and no baseline.
    let depth_m = z_m * z_m / (focal_px * baseline_m) * sigma_px;
    let across_m = z_m / (2.0 * focal_px) * sigma_px;
    let expected = (depth_m * depth_m + across_m * across_m).sqrt();
    assert!(
        (axis_offset_m / expected - 1.0).abs() < 0.1,
        "{axis_offset_m} for {expected}"
    );
    let tilt = z_m / baseline_m * 12.0_f64.sqrt() * sigma1 / (length_px * length_px.sqrt());
    assert!(
        (axis_angle_rad / tilt - 1.0).abs() < 0.15,
        "{axis_angle_rad} for {tilt}"
    );
}

/// What the truth record says of the limbs, said directly: the same limit.
#[test]
fn limit_is_the_same_by_both_doors() {
    let scene = scene(0.05, 4.0);
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    let rod = truth.target();
    let grasp_m = Vec3::from(truth.grasp.point_m);
    let direction = Vec3::from(truth.grasp.axis.direction);
    let cylinder = Cylinder {
        axis: Line3::new(grasp_m, &direction),
        radius_m: rod.radius_m,
    };
    let to_middle_m = (Vec3::from(rod.axis.point_m) - grasp_m).dot(&direction);
    let stretches: Vec<LimbStretch> = [(Eye::Left, &rod.left), (Eye::Right, &rod.right)]
        .into_iter()
        .flat_map(|(eye, seen)| {
            let [from_m, to_m] = seen.visible_m[0];
            [(Side::Plus, 0), (Side::Minus, 1)].map(|(side, k)| LimbStretch {
                eye,
                side,
                span_m: [to_middle_m + from_m, to_middle_m + to_m],
                contrast_to_noise: seen.contrast_to_noise[k].unwrap(),
                edge_sigma_px: edge_sigma_px(0.0),
            })
        })
        .collect();
    let direct = limit_of(&scene.rig, &cylinder, &stretches).unwrap();
    let recorded = limit(&truth).unwrap().unwrap();
    for (a, b) in [
        (direct.axis_offset_m, recorded.axis_offset_m),
        (direct.axis_angle_rad, recorded.axis_angle_rad),
        (direct.radius_m, recorded.radius_m),
    ] {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} and {b}");
    }
}
