//! The statistical limit: by its doors, of limbs in pieces, and of painted pairs.

#[path = "../examples/asked/mod.rs"]
mod asked;
#[path = "../examples/painted/mod.rs"]
mod painted;

use nalgebra::Matrix5;
use painted::limbs::Limbs;
use painted::painter::{Ball, ORANGE, Scene, WATER, rig, rod};
use rodsight_bench::{LimbStretch, Limit, edge_sigma_px, limit_of, step_contrast_to_noise};
use rodsight_geometry::{Cylinder, Eye, Image, Line3, Samples, Side, Vec3};
use rodsight_solver::Roi;

/// Upright but for a fraction, 2.3 m ahead.
fn upright() -> Cylinder {
    rod([2.3, 0.03, 0.0], [0.0, 0.02, 1.0], 0.05)
}

fn four(contrast_to_noise: f64, edge_sigma_px: f64) -> Vec<LimbStretch> {
    [Side::Plus, Side::Minus]
        .into_iter()
        .flat_map(|side| Eye::BOTH.map(|eye| (eye, side)))
        .map(|(eye, side)| LimbStretch {
            eye,
            side,
            span_m: [-0.7, 0.7],
            contrast_to_noise,
            edge_sigma_px,
        })
        .collect()
}

#[track_caller]
fn ratio(a: &Limit, b: &Limit, expected: f64, tolerance: f64) {
    for (a, b) in [
        (a.axis_offset_m, b.axis_offset_m),
        (a.axis_angle_rad, b.axis_angle_rad),
        (a.radius_m, b.radius_m),
    ] {
        assert!(
            (a / b / expected - 1.0).abs() < tolerance,
            "{} instead of {expected}",
            a / b
        );
    }
}

#[test]
fn variance_goes_with_noise_squared_and_blur() {
    let limit = |contrast, spread| limit_of(&rig(), &upright(), &four(contrast, spread)).unwrap();
    ratio(&limit(5.0, 0.3), &limit(10.0, 0.3), 2.0, 1e-9);
    ratio(&limit(5.0, 1.2), &limit(5.0, 0.3), 2.0, 1e-9);
    assert!((edge_sigma_px(0.0) - libm::sqrt(1.0 / 12.0)).abs() < 1e-15);
    assert!((edge_sigma_px(1.0) - libm::sqrt(13.0 / 12.0)).abs() < 1e-15);
}

#[test]
fn limbs_in_pieces_are_the_same_limbs() {
    const PIECES: usize = 50;
    let whole = four(7.0, 0.5);
    let pieces: Vec<LimbStretch> = whole
        .iter()
        .flat_map(|limb| {
            let [from, to] = limb.span_m;
            let at = move |k: usize| from + (to - from) * k as f64 / PIECES as f64;
            (0..PIECES).map(move |k| LimbStretch {
                span_m: [at(k), at(k + 1)],
                ..*limb
            })
        })
        .collect();
    let limit = |stretches: &[LimbStretch]| limit_of(&rig(), &upright(), stretches).unwrap();
    ratio(&limit(&pieces), &limit(&whole), 1.0, 1e-3);
    // Half of them gone, every second one: √2.
    let half: Vec<LimbStretch> = pieces.iter().step_by(2).copied().collect();
    ratio(
        &limit(&half),
        &limit(&whole),
        core::f64::consts::SQRT_2,
        0.05,
    );
}

#[test]
fn two_limbs_of_one_side_say_no_radius() {
    let all = four(7.0, 0.5);
    assert!(limit_of(&rig(), &upright(), &all[..3]).is_some());
    assert_eq!(limit_of(&rig(), &upright(), &all[..2]), None);
    assert_eq!(limit_of(&rig(), &upright(), &[]), None);
}

#[test]
fn contrast_of_a_blurred_step_is_the_step() {
    // Error function by its derivative's sum: a step of 3 and one of 4 noise units, spread by 0.8 px.
    let (step_px, spread_px) = (0.05, 0.8);
    let profile = |height: f64| {
        let mut sum = 0.0;
        (-100..=100)
            .map(|k| {
                let x = f64::from(k) * step_px / spread_px;
                sum += height * step_px / spread_px * libm::exp(-0.5 * x * x)
                    / libm::sqrt(2.0 * core::f64::consts::PI);
                sum
            })
            .collect()
    };
    let found = step_contrast_to_noise(&[profile(3.0), profile(4.0)], step_px, spread_px);
    assert!((found - 5.0).abs() < 0.01, "{found}");
}

/// A flat rod in flat water: contrast and length are known without looking.
#[test]
fn painted_limit_is_that_of_what_was_painted() {
    let region = |x_px| {
        Some(Roi {
            x_px,
            y_px: 190,
            width_px: 640,
            height_px: 700,
        })
    };
    let mut scene = Scene::new(&rig(), vec![upright()]);
    scene.only = [region(980), region(300)];
    scene.noise_sigma = 0.02;
    scene.blur_px = 0.5;
    let step: f64 = (0..3)
        .map(|k| (ORANGE[k] - WATER[k]) * (ORANGE[k] - WATER[k]))
        .sum();
    let expected = libm::sqrt(step) / scene.stored_sigma();
    let found = Limbs::of(&scene).contrast_to_noise().unwrap();
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    // 700 px at 2.3 m, less what the blur needs at both ends.
    let half_m = 0.5 * 700.0 * 2.3 / 1566.5776;
    let mut by_hand = four(expected, edge_sigma_px(0.5));
    for limb in &mut by_hand {
        limb.span_m = [-half_m, half_m];
    }
    let by_hand = limit_of(&rig(), &upright(), &by_hand).unwrap();
    let free = Limbs::of(&scene);
    ratio(&free.limit(&scene).unwrap(), &by_hand, 1.0, 0.04);
    // A ball before the middle hides its own length of both limbs in both eyes, and takes as much away.
    scene.balls.push(Ball {
        centre_m: upright().axis.point_m - Vec3::x() * 0.2,
        radius_m: 0.1,
        colour: WATER,
    });
    let limbs = Limbs::of(&scene);
    let seen = limbs.pieces() as f64 / free.pieces() as f64;
    assert!((0.7..0.95).contains(&seen), "{seen}");
    let limit = limbs.limit(&scene).unwrap();
    assert!(limit.axis_offset_m > by_hand.axis_offset_m);
    // Bent, it has no limit that is known.
    scene.curvature_per_m = Vec3::y() * 0.1;
    assert_eq!(limbs.limit(&scene), None);
}

/// Cramér and Rao without any theory of edges: images of the rod moved a little each way, pixel by pixel. In one flat light nothing
/// but the limbs tells where the rod is.
#[test]
fn limit_is_the_fisher_information_of_the_pixels() {
    let rod = rod([2.3, 0.1, 0.05], [0.2, 0.3, 1.0], 0.05);
    let region = |x_px| {
        Some(Roi {
            x_px,
            y_px: 400,
            width_px: 640,
            height_px: 300,
        })
    };
    let mut scene = Scene::new(&rig(), vec![rod]);
    scene.only = [region(1040), region(360)];
    scene.ambient = 0.5;
    scene.haze_per_m = 0.3;
    scene.background_slope = [0.3, -0.2];
    scene.blur_px = 0.6;
    scene.noise_sigma = 0.02;
    scene.bits = 16;
    scene.samples = 16;
    let sigma = scene.stored_sigma();
    let d = rod.axis.direction;
    let e1 = d.cross(&Vec3::x()).normalize();
    let e2 = d.cross(&e1);
    // Each moves a limb by a fraction of a pixel.
    let steps = [3e-4, 1e-3, 3e-3, 1e-2, 3e-4];
    let images = |k: usize, sign: f64| {
        let mut x = [0.0; 5];
        x[k] = sign * steps[k];
        let moved = Cylinder {
            axis: Line3::new(
                rod.axis.point_m + e1 * x[0] + e2 * x[1],
                &(d + e1 * x[2] + e2 * x[3]),
            ),
            radius_m: rod.radius_m + x[4],
        };
        let scene = Scene {
            rods: vec![moved],
            noise_sigma: 0.0,
            ..scene.clone()
        };
        Eye::BOTH.map(|eye| scene.image(eye))
    };
    let values = |image: &Image| match image.samples() {
        Samples::U16(values) => values.clone(),
        Samples::U8(_) => panic!("16 bits were painted"),
    };
    let slopes: Vec<Vec<f64>> = (0..5)
        .map(|k| {
            let [more, less] = [images(k, 1.0), images(k, -1.0)];
            let differences = more.iter().zip(&less).flat_map(|(more, less)| {
                let pairs = values(more).into_iter().zip(values(less));
                pairs.map(|(a, b)| (f64::from(a) - f64::from(b)) / 65535.0)
            });
            differences.map(|v| v / (2.0 * steps[k] * sigma)).collect()
        })
        .collect();
    let information = Matrix5::from_fn(|i, j| {
        let products = slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b);
        products.sum::<f64>()
    });
    let covariance = information.try_inverse().unwrap();
    let root =
        |from: usize, to: usize| libm::sqrt((from..to).map(|k| covariance[(k, k)]).sum::<f64>());
    let of_pixels = Limit {
        axis_offset_m: root(0, 2),
        axis_angle_rad: root(2, 4),
        radius_m: root(4, 5),
    };
    let of_limbs = Limbs::of(&scene).limit(&scene).unwrap();
    println!("{of_pixels:?}\n{of_limbs:?}");
    // Three in a hundred more: what the blur needs at the ends of the limbs is not counted.
    ratio(&of_limbs, &of_pixels, 1.0, 0.05);
}
