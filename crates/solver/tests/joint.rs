//! The joint method on images of another renderer: matt rods between two far lamps.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "a test that cannot go on panics"
)]

mod common;

use common::{Scene, offset_m, pick_at, refused, rig_of, rod};
use rodsight_geometry::port::{FlatPort, Port, PortShape};
use rodsight_geometry::{
    Cylinder, Distortion, Eye, Image, Pose, Rig, Samples, StereoPair, Vec3, angle_between,
    rotation_from_rpy,
};
use rodsight_solver::{
    CalibrationSigma, Estimate, Method, PaperParams, RadiusPrior, Request, Roi, Status, solve,
};

/// A rod between two lamps, which light both of its limbs.
fn lit(truth: Cylinder) -> Scene {
    let mut scene = Scene::new(&rig(), vec![truth]);
    let lamp = |aside: f64| Vec3::new(-0.5, aside, -0.15).normalize();
    scene.lamps = vec![lamp(-0.9), lamp(0.9)];
    scene.rod_colour = [0.6, 0.3, 0.06];
    scene.background = [0.02, 0.05, 0.08];
    scene.samples = 16;
    scene
}

fn rig() -> Rig {
    rig_of(1280, 720, 1566.5776 / 1.5, Distortion::None)
}

fn joint(request: &Request<'_>) -> Estimate {
    solve(request, Method::Joint, &PaperParams::default()).unwrap()
}

fn solved(pair: &StereoPair, truth: Option<&Cylinder>) -> Estimate {
    let pick = truth.map(|truth| pick_at(&pair.rig, Eye::Left, &truth.axis.point_m));
    let request = Request {
        pick,
        ..Request::new(pair)
    };
    joint(&request)
}

/// Rods across the view, upright, oblique and thick.
fn rods() -> [Cylinder; 3] {
    [
        rod([1.5, 0.05, 0.0], [0.3, 0.3, 1.0], 0.05),
        rod([1.5, 0.05, 0.0], [0.0, 0.02, 1.0], 0.05),
        rod([2.0, -0.1, 0.05], [-0.8, 0.2, 1.0], 0.12),
    ]
}

#[test]
fn rods_are_located_to_a_tenth_of_a_pixel() {
    for truth in rods() {
        let pair = lit(truth).pair();
        for picked in [Some(&truth), None] {
            let estimate = solved(&pair, picked);
            // That the same edges pair up in another way may be a warning.
            assert_ne!(estimate.status, Status::Refused, "{:?}", estimate.reason);
            let direction = Vec3::from(estimate.axis.unwrap().direction.unwrap());
            let angle = angle_between(&direction, &truth.axis.direction);
            let angle_deg = angle.min(core::f64::consts::PI - angle).to_degrees();
            let offset_mm = 1e3 * offset_m(&estimate, &truth);
            let radius_mm = 1e3 * (estimate.radius_m.unwrap() - truth.radius_m);
            println!("{offset_mm:.3} mm, {angle_deg:.4}°, radius {radius_mm:+.3} mm");
            // A tenth of a pixel of disparity of this rig is 0.22 mm at 1.5 m.
            assert!(offset_mm < 0.2, "{offset_mm} mm: {truth:?}");
            assert!(angle_deg < 0.02, "{angle_deg}°: {truth:?}");
            assert!(radius_mm.abs() < 0.1, "{radius_mm} mm: {truth:?}");
        }
    }
}

/// Behind flat ports rods are seen bent, by pixels; rays know it.
#[test]
fn rods_behind_ports_are_located_as_well() {
    let truth = rods()[0];
    let mut scene = lit(truth);
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let plate = PortShape::Flat(FlatPort {
            normal: Vec3::z(),
            distance_m: 0.03,
            thickness_m: 0.01,
        });
        mounted.port = Some(Port::new(plate, Port::ACRYLIC, [1.34; 3]).unwrap());
    }
    let pair = scene.pair();
    let region = |eye| {
        let at = pair.rig.eye(eye).project(&truth.axis.point_m).unwrap();
        Some(Roi {
            x_px: (at.x - 200.0).clamp(0.0, 880.0) as u32,
            y_px: (at.y - 150.0).clamp(0.0, 420.0) as u32,
            width_px: 400,
            height_px: 300,
        })
    };
    let request = Request {
        roi_left: region(Eye::Left),
        roi_right: region(Eye::Right),
        ..Request::new(&pair)
    };
    let estimate = joint(&request);
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    let offset_mm = 1e3 * offset_m(&estimate, &truth);
    println!("{offset_mm:.3} mm");
    assert!(offset_mm < 0.2, "{offset_mm} mm");
    assert!(
        estimate
            .centerlines
            .is_none_or(|lines| lines.left.is_none())
    );
    // Who does not know of the glass is far off, or knows that something is wrong.
    let mut bare = pair.clone();
    (bare.rig.left.port, bare.rig.right.port) = (None, None);
    let wrong = joint(&Request {
        pair: &bare,
        ..request
    });
    let knows = wrong.status == Status::Refused;
    assert!(knows || offset_m(&wrong, &truth) > 0.1, "{wrong:?}");
}

/// What noise does is within what the covariance says, and no image is better than it says by far.
#[test]
fn covariances_hold_under_noise() {
    let truth = rods()[0];
    let mut squares = 0.0;
    let runs = 8;
    for seed in 0..runs {
        let mut scene = lit(truth);
        scene.noise_sigma = 0.02;
        scene.seed = 100 + seed;
        let estimate = solved(&scene.pair(), Some(&truth));
        let sigma_m = estimate.observability.depth_sigma_m.unwrap();
        let off = offset_m(&estimate, &truth) / sigma_m;
        println!("{off:.2} sigma of {:.3} mm", 1e3 * sigma_m);
        squares += off * off / runs as f64;
    }
    assert!(squares < 3.0, "{squares}");
}

/// A known radius that is right changes little, and its covariance shrinks.
#[test]
fn a_known_radius_is_used() {
    let truth = rods()[0];
    let pair = lit(truth).pair();
    let request = Request {
        radius: Some(RadiusPrior {
            radius_m: truth.radius_m,
            sigma_m: Some(1e-5),
        }),
        ..Request::new(&pair)
    };
    let estimate = joint(&request);
    assert!((estimate.radius_m.unwrap() - truth.radius_m).abs() < 3e-5);
    assert!(estimate.radius_sigma_m.unwrap() <= 1e-5);
    assert!(offset_m(&estimate, &truth) < 4e-4);
}

/// One that is wrong contradicts the limbs.
#[test]
fn a_wrong_radius_is_refused() {
    let truth = rods()[0];
    let pair = lit(truth).pair();
    for (times, sigma_m) in [(1.02, None), (0.98, Some(1e-4)), (1.15, None)] {
        let request = Request {
            radius: Some(RadiusPrior {
                radius_m: times * truth.radius_m,
                sigma_m,
            }),
            pick: Some(pick_at(&pair.rig, Eye::Left, &truth.axis.point_m)),
            ..Request::new(&pair)
        };
        refused(&joint(&request), "radius_contradicts");
    }
}

/// A rod that bends by 2 % of its length is located as well, and its direction is that of its tangent at the grasp.
#[test]
fn a_bent_rod_has_the_tangent_at_the_grasp() {
    let truth = rods()[0];
    let mut scene = lit(truth);
    scene.curvature_per_m = Vec3::new(0.05, 0.15, -0.1);
    let pair = scene.pair();
    let estimate = solved(&pair, Some(&truth));
    assert_ne!(estimate.status, Status::Refused, "{:?}", estimate.reason);
    let direction = Vec3::from(estimate.axis.unwrap().direction.unwrap());
    let angle = angle_between(&direction, &truth.axis.direction);
    let angle_deg = angle.min(core::f64::consts::PI - angle).to_degrees();
    let offset_mm = 1e3 * offset_m(&estimate, &truth);
    println!("{offset_mm:.3} mm, {angle_deg:.4}°");
    assert!(offset_mm < 0.2, "{offset_mm} mm");
    assert!(angle_deg < 0.05, "{angle_deg}°");
}

/// One lamp from ever farther aside: its light ends before a limb. The answer is right, or within what it is not sure of, or the
/// limb is said to be lost.
#[test]
fn light_that_ends_before_a_limb_is_no_limb() {
    let truth = rods()[0];
    let mut sure = 0;
    for aside_deg in [0.0_f64, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0] {
        let mut scene = lit(truth);
        let (sin, cos) = (
            libm::sin(aside_deg.to_radians()),
            libm::cos(aside_deg.to_radians()),
        );
        scene.lamps = vec![Vec3::new(-cos, sin, -0.1 * sin)];
        scene.ambient = 0.05;
        scene.noise_sigma = 0.004;
        let estimate = solved(&scene.pair(), Some(&truth));
        if estimate.status == Status::Refused {
            println!("{aside_deg}°: {:?}", estimate.reason);
            continue;
        }
        let offset_mm = 1e3 * offset_m(&estimate, &truth);
        let sigma_mm = 1e3 * estimate.observability.depth_sigma_m.unwrap();
        println!(
            "{aside_deg}°: {offset_mm:.3} mm of {sigma_mm:.3}, {:?}",
            estimate.reason
        );
        assert!(offset_mm < 1.0, "{aside_deg}°: {offset_mm} mm");
        if estimate.status == Status::Ok {
            assert!(
                offset_mm < 5.0 * sigma_mm,
                "{aside_deg}°: {offset_mm} mm of {sigma_mm}"
            );
            sure += 1;
        }
    }
    assert!(sure >= 2, "{sure}");
}

/// Cameras that are known less well make an answer less sure, by what geometry says: a pixel of disparity is 2.1 mm here.
#[test]
fn doubtful_cameras_make_doubtful_rods() {
    let truth = rods()[1];
    let pair = lit(truth).pair();
    let sigma_mm = |pixel_px: f64| {
        let request = Request {
            calibration: Some(CalibrationSigma {
                pixel_px,
                roll_rad: 0.0,
            }),
            ..Request::new(&pair)
        };
        1e3 * joint(&request).observability.depth_sigma_m.unwrap()
    };
    let (exact, doubtful) = (sigma_mm(0.0), sigma_mm(0.5));
    let focal_px = pair.rig.left.camera.intrinsics().fx_px;
    // Two eyes, each off by so much: Z² σ √2/(f B).
    let expected = 1e3 * 1.5 * 1.5 * 0.5 * core::f64::consts::SQRT_2 / focal_px;
    let added = (doubtful * doubtful - exact * exact).sqrt();
    assert!((added / expected - 1.0).abs() < 0.1, "{added} {expected}");
}

/// What a roll adds to the direction's covariance is by how much the direction turns when an eye is believed to be rolled.
#[test]
fn a_doubtful_roll_adds_what_a_roll_does() {
    let truth = rods()[0];
    let pair = lit(truth).pair();
    let roll_rad = 2e-3;
    let asked = |pair: &StereoPair, roll_rad| {
        let calibration = Some(CalibrationSigma {
            pixel_px: 0.0,
            roll_rad,
        });
        joint(&Request {
            calibration,
            ..Request::new(pair)
        })
    };
    let direction = |estimate: &Estimate| Vec3::from(estimate.axis.unwrap().direction.unwrap());
    let sigma = |estimate: &Estimate| estimate.observability.direction_sigma_rad.unwrap();
    let exact = asked(&pair, 0.0);
    let mut squares = 0.0;
    for eye in Eye::BOTH {
        let mut rolled = pair.clone();
        let mounted = match eye {
            Eye::Left => &mut rolled.rig.left,
            Eye::Right => &mut rolled.rig.right,
        };
        let pose = &mounted.rig_from_camera;
        let about_z = rotation_from_rpy(0.0, 0.0, roll_rad);
        mounted.rig_from_camera = Pose::new(pose.rotation() * about_z, pose.origin_m());
        squares += (direction(&asked(&rolled, 0.0)) - direction(&exact)).norm_squared();
    }
    let added = sigma(&asked(&pair, roll_rad)).powi(2) - sigma(&exact).powi(2);
    println!("{} {}", added.sqrt(), squares.sqrt());
    assert!((added / squares - 1.0).abs() < 0.2, "{added} {squares}");
}

#[test]
fn images_without_a_rod_are_refused() {
    let blank = || Image::new(1280, 720, 3, Samples::U8(vec![90; 1280 * 720 * 3])).unwrap();
    let pair = StereoPair::new(rig(), blank(), blank()).unwrap();
    refused(&solved(&pair, None), "no_pair");
    let mut random = common::Random::new(7);
    let mut noise = || {
        let values = (0..1280 * 720 * 3).map(|_| (128.0 + 20.0 * random.normal()) as u8);
        Image::new(1280, 720, 3, Samples::U8(values.collect())).unwrap()
    };
    let pair = StereoPair::new(rig(), noise(), noise()).unwrap();
    let estimate = solved(&pair, None);
    assert_eq!(estimate.status, Status::Refused, "{estimate:?}");
}

#[test]
fn a_rod_along_the_baseline_is_refused_as_such() {
    let truth = rod([1.5, 0.0, 0.1], [0.0, 1.0, 0.0], 0.05);
    let pair = lit(truth).pair();
    refused(&solved(&pair, Some(&truth)), "parallel_to_baseline");
}

/// Exchanged eyes see the rod behind the cameras or none at all.
#[test]
fn exchanged_images_are_refused() {
    let truth = rods()[0];
    let pair = lit(truth).pair();
    let exchanged = StereoPair::new(pair.rig, pair.right, pair.left).unwrap();
    let estimate = solved(&exchanged, None);
    assert_eq!(estimate.status, Status::Refused, "{estimate:?}");
}

/// Grey images, and regions of any size and place, on the rod and beside it: what is called sure is right.
#[test]
fn regions_and_grey_images_of_any_kind_are_answered_or_refused() {
    let truth = rods()[0];
    let mut scene = lit(truth);
    scene.channels = 1;
    let grey = scene.pair();
    let estimate = solved(&grey, Some(&truth));
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    assert!(offset_m(&estimate, &truth) < 2e-4);
    let mut random = common::Random::new(11);
    let (mut answered, mut wrong) = (0, 0);
    for _ in 0..40 {
        let mut below = |most: u32| (random.uniform() * f64::from(most)) as u32;
        let mut roi = || {
            let (width_px, height_px) = (1 + below(1280), 1 + below(720));
            Some(Roi {
                x_px: below(1281 - width_px),
                y_px: below(721 - height_px),
                width_px,
                height_px,
            })
        };
        let request = Request {
            roi_left: roi(),
            roi_right: roi(),
            ..Request::new(&grey)
        };
        let estimate = joint(&request);
        if estimate.status == Status::Ok {
            let off = offset_m(&estimate, &truth);
            let sigma_m = estimate.observability.depth_sigma_m.unwrap();
            println!("{:.3} mm of {:.3}", 1e3 * off, 1e3 * sigma_m);
            answered += 1;
            wrong += u32::from(off > 6.0 * sigma_m);
        }
    }
    assert!(answered >= 5 && wrong == 0, "{wrong} of {answered}");
}
