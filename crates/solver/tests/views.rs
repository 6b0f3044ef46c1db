//! One rod in several pairs, each from where the rig went.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "a test that cannot go on panics"
)]

mod common;

use common::{Random, Scene, offset_m, pick_at, refused, rig_of, rod};
use nalgebra::{Matrix4, Matrix6, Vector4};
use rodsight_geometry::{
    Cylinder, Distortion, Eye, Line3, Mat3, Pose, RigFrame, StereoPair, Vec3, rotation_from_rpy,
};
use rodsight_solver::{
    CalibrationSigma, Estimate, Method, MoveSigma, MovedPair, PaperParams, RadiusPrior, Request,
    Roi, SolveError, Status, solve,
};

type Move = Pose<RigFrame, RigFrame>;

/// A rod between lamps above and below the vehicle and at its sides.
fn lit(truth: Cylinder, noise_sigma: f64) -> Scene {
    let mut rig = rig_of(960, 540, 1566.5776 / 2.0, Distortion::None);
    for mounted in [&mut rig.left, &mut rig.right] {
        // Limbs along rows of pixels would be painted by eighths of them.
        let pose = mounted.rig_from_camera;
        let rolled = pose.rotation() * rotation_from_rpy(0.0, 0.0, 0.15);
        mounted.rig_from_camera = Pose::new(rolled, pose.origin_m());
    }
    let mut scene = Scene::new(&rig, vec![truth]);
    let lamps = [(-0.9, -0.15), (0.9, -0.15), (0.0, -0.9), (0.0, 0.9)];
    let lamp = |(aside, down)| 0.5 * Vec3::new(-0.5, aside, down).normalize();
    scene.lamps = lamps.map(lamp).to_vec();
    scene.rod_colour = [0.6, 0.3, 0.06];
    scene.background = [0.02, 0.05, 0.08];
    scene.noise_sigma = noise_sigma;
    scene
}

/// What a vehicle sees that went there.
fn seen(scene: &Scene, rig_from_moved: &Move, seed: u64) -> StereoPair {
    let mut scene = scene.moved(rig_from_moved);
    scene.seed = seed;
    scene.pair()
}

fn still() -> Move {
    Move::identity()
}

fn heaved(up_m: f64) -> Move {
    Move::new(Mat3::identity(), Vec3::new(0.0, 0.0, -up_m))
}

/// Up, ahead, aside and turned.
fn flown() -> Move {
    Move::new(
        rotation_from_rpy(0.03, 0.06, -0.05),
        Vec3::new(0.2, 0.1, -0.15),
    )
}

fn joint(request: &Request<'_>) -> Estimate {
    solve(request, Method::Joint, &PaperParams::default()).unwrap()
}

fn fused(first: &StereoPair, more: &[MovedPair<'_>]) -> Estimate {
    joint(&Request {
        more,
        ..Request::new(first)
    })
}

fn along_the_baseline() -> Cylinder {
    rod([1.5, 0.0, 0.1], [0.0, 1.0, 0.0], 0.05)
}

fn oblique() -> Cylinder {
    rod([1.5, 0.05, 0.0], [0.3, 0.3, 1.0], 0.05)
}

fn depth_sigma_m(estimate: &Estimate) -> f64 {
    estimate.observability.depth_sigma_m.unwrap()
}

/// The squared error of the axis in units of its claimed covariance; of four degrees of freedom.
fn nees(estimate: &Estimate, truth: &Cylinder, scene: &Scene) -> f64 {
    let axis = estimate.axis.unwrap();
    let [left, right] = [&scene.rig.left, &scene.rig.right].map(|m| m.rig_from_camera.origin_m());
    let (direction, point_m): (Vec3, Vec3) =
        (axis.direction.unwrap().into(), axis.point_m.unwrap().into());
    let d = truth.axis.direction * truth.axis.direction.dot(&direction).signum();
    let first = d.cross(&Vec3::new(0.6, -0.5, 0.62)).normalize();
    let across = [first, d.cross(&first)];
    let off_m = point_m - truth.axis.foot(&(0.5 * (left + right)));
    let rows = core::array::from_fn::<_, 4, _>(|k| {
        let mut row = nalgebra::Vector6::<f64>::zeros();
        row.fixed_rows_mut::<3>(3 * (k / 2))
            .copy_from(&across[k % 2]);
        row
    });
    let covariance = axis.covariance.unwrap();
    let covariance = Matrix6::from_fn(|i, j| covariance[i][j]);
    let covariance = Matrix4::from_fn(|i, j| rows[i].dot(&(covariance * rows[j])));
    let off =
        Vector4::from_fn(|k, _| across[k % 2].dot(&if k < 2 { off_m } else { direction - d }));
    off.dot(&covariance.cholesky().unwrap().solve(&off))
}

/// What one pair cannot tell, two can, and they know how well.
#[test]
fn a_rod_along_the_baseline_is_located_from_two_heights() {
    let truth = along_the_baseline();
    let scene = lit(truth, 0.01);
    let first = seen(&scene, &still(), 1);
    refused(&fused(&first, &[]), "parallel_to_baseline");
    let second = seen(&scene, &heaved(0.3), 2);
    let pick = pick_at(&scene.rig, Eye::Left, &truth.axis.point_m);
    for pick in [None, Some(pick)] {
        let estimate = joint(&Request {
            pick,
            more: &[MovedPair::new(&second, heaved(0.3))],
            ..Request::new(&first)
        });
        assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
        let (off_m, sigma_m) = (offset_m(&estimate, &truth), depth_sigma_m(&estimate));
        println!("{:.3} mm of {:.3}", 1e3 * off_m, 1e3 * sigma_m);
        assert!(off_m < 4.0 * sigma_m && sigma_m < 2e-3, "{off_m} {sigma_m}");
        assert_eq!(estimate.grasp.is_some(), pick.is_some());
    }
    // From the same place, or from along the baseline, there is no more to be seen.
    let again = seen(&scene, &still(), 3);
    refused(
        &fused(&first, &[MovedPair::new(&again, still())]),
        "parallel_to_baseline",
    );
    let beside = Move::new(Mat3::identity(), Vec3::new(0.0, 0.2, 0.0));
    let third = seen(&scene, &beside, 4);
    refused(
        &fused(&first, &[MovedPair::new(&third, beside)]),
        "parallel_to_baseline",
    );
}

/// Two pairs from one place are two measurements.
#[test]
fn two_pairs_halve_the_variance() {
    let truth = oblique();
    let scene = lit(truth, 0.02);
    let runs = 10;
    let (mut of_one, mut of_two, mut errors) = (0.0, 0.0, [0.0; 2]);
    for seed in 0..runs {
        let [a, b] = [10 + seed, 50 + seed].map(|seed| seen(&scene, &still(), seed));
        let (one, two) = (fused(&a, &[]), fused(&a, &[MovedPair::new(&b, still())]));
        of_one += depth_sigma_m(&one).powi(2);
        of_two += depth_sigma_m(&two).powi(2);
        errors[0] += offset_m(&one, &truth).powi(2);
        errors[1] += offset_m(&two, &truth).powi(2);
    }
    let (claimed, found) = (of_two / of_one, errors[1] / errors[0]);
    println!("claimed {claimed:.2}, found {found:.2} of the variance");
    assert!((0.4..0.62).contains(&claimed), "{claimed}");
    // Of twenty errors each, their ratio is within this nine times of ten.
    assert!((0.2..1.1).contains(&found), "{found}");
}

/// It does not matter which pair comes first but for the frame.
#[test]
fn the_order_of_pairs_does_not_matter() {
    let truth = oblique();
    let scene = lit(truth, 0.01);
    let (here, there) = (seen(&scene, &still(), 1), seen(&scene, &flown(), 2));
    let forth = fused(&here, &[MovedPair::new(&there, flown())]);
    let back = fused(&there, &[MovedPair::new(&here, flown().inverse())]);
    let point_m = |e: &Estimate| Vec3::from(e.axis.unwrap().point_m.unwrap());
    let direction = |e: &Estimate| Vec3::from(e.axis.unwrap().direction.unwrap());
    let line = Line3 {
        point_m: flown().point(&point_m(&back)),
        direction: flown().direction(&direction(&back)),
    };
    let off_m = line.distance_m(&point_m(&forth));
    let turned = line.direction.cross(&direction(&forth)).norm();
    println!("{off_m:.2e} m, {turned:.2e} rad");
    // A tenth of what noise does.
    assert!(off_m < 0.2 * depth_sigma_m(&forth), "{off_m}");
    assert!(turned < 0.2 * forth.observability.direction_sigma_rad.unwrap());
    let radii = [&forth, &back].map(|e| e.radius_m.unwrap());
    assert!((radii[0] - radii[1]).abs() < 0.2 * forth.radius_sigma_m.unwrap());
    assert!(offset_m(&forth, &truth) < 4.0 * depth_sigma_m(&forth));
}

/// Where a move was not what it is said to have been, pairs contradict each other: that is said, and no compromise given as sure.
#[test]
fn wrong_moves_are_found_out() {
    let truth = oblique();
    let scene = lit(truth, 0.01);
    let first = seen(&scene, &still(), 1);
    let second = seen(&scene, &heaved(0.3), 2);
    let with = |off_m: Vec3| {
        let said = Move::new(Mat3::identity(), heaved(0.3).origin_m() + off_m);
        fused(&first, &[MovedPair::new(&second, said)])
    };
    assert_eq!(with(Vec3::zeros()).status, Status::Ok);
    for off_m in [0.002, 0.005, 0.05] {
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let estimate = with(axis * off_m);
            println!("{off_m} {:?}", estimate.reason);
            assert_ne!(estimate.status, Status::Ok, "{off_m} {axis}");
            // Who left the other pair out is right, and says so; or takes what does not fit for light, and is as unsure as that is off.
            if estimate.status == Status::Degraded {
                let unsure_m = 2.0 * depth_sigma_m(&estimate);
                let off_m = offset_m(&estimate, &truth);
                assert!(off_m < unsure_m.max(5e-4), "{off_m} {axis}");
            }
        }
    }
}

/// A move that is known roughly is found out by the way, and costs what it must.
#[test]
fn doubtful_moves_cost_what_they_are_in_doubt_by() {
    let sigma = MoveSigma {
        translation_m: 0.01,
        rotation_rad: 0.005,
    };
    // One that each pair places by itself.
    let truth = oblique();
    let scene = lit(truth, 0.01);
    let first = seen(&scene, &still(), 1);
    let second = seen(&scene, &heaved(0.3), 2);
    let off = Move::new(
        rotation_from_rpy(0.004, -0.003, 0.002),
        heaved(0.3).origin_m() + Vec3::new(0.01, -0.008, 0.006),
    );
    let exact = MovedPair::new(&second, off);
    let doubtful = MovedPair {
        sigma: Some(sigma),
        ..exact
    };
    assert_ne!(fused(&first, &[exact]).status, Status::Ok);
    let estimate = fused(&first, &[doubtful]);
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    let (one_m, two_m) = (depth_sigma_m(&fused(&first, &[])), depth_sigma_m(&estimate));
    let off_m = offset_m(&estimate, &truth);
    println!(
        "{:.3} mm of {:.3}, one pair {:.3}",
        1e3 * off_m,
        1e3 * two_m,
        1e3 * one_m
    );
    assert!(
        off_m < 4.0 * two_m && two_m < 1.02 * one_m,
        "{off_m} {two_m} {one_m}"
    );
    // One that hangs on the move: its depth scales with how far the rig went.
    let truth = along_the_baseline();
    let scene = lit(truth, 0.01);
    let first = seen(&scene, &still(), 1);
    let second = seen(&scene, &heaved(0.3), 2);
    let with = |translation_m: f64| {
        let sigma = Some(MoveSigma {
            translation_m,
            rotation_rad: 0.0,
        });
        let moved = MovedPair::new(&second, heaved(0.3));
        depth_sigma_m(&fused(&first, &[MovedPair { sigma, ..moved }]))
    };
    let (none, some) = (with(0.0), with(0.01));
    let added_m = (some * some - none * none).sqrt();
    println!("{:.2} mm added", 1e3 * added_m);
    // A hundredth of 0.3 m is a thirtieth of 1.5 m.
    assert!((0.7..1.3).contains(&(added_m / 0.05)), "{added_m}");
}

/// Errors are as large as they are said to be, wherever the rig went; moves are off by as much as they are said to be.
#[test]
fn fused_covariances_hold() {
    let mut random = Random::new(5);
    let mut total = 0.0;
    let runs = 30;
    for seed in 0..runs {
        let truth = if seed % 3 == 0 {
            along_the_baseline()
        } else {
            oblique()
        };
        let scene = lit(truth, 0.06);
        let mut drawn = || 2.0 * random.uniform() - 1.0;
        let t_m = Vec3::new(0.1 * drawn(), 0.1 * drawn(), -0.25 + 0.1 * drawn());
        let went = Move::new(
            rotation_from_rpy(0.05 * drawn(), 0.05 * drawn(), 0.05 * drawn()),
            t_m,
        );
        let sigma = MoveSigma {
            translation_m: 0.001,
            rotation_rad: 0.0005,
        };
        let is_doubtful = seed % 2 == 1;
        let mut error = |sigma: f64| {
            if is_doubtful {
                sigma * random.normal()
            } else {
                0.0
            }
        };
        let off_m = Vec3::from_fn(|_, _| error(sigma.translation_m));
        let [a, b, c] = [0; 3].map(|_| error(sigma.rotation_rad));
        let said = Move::new(
            rotation_from_rpy(a, b, c) * went.rotation(),
            went.origin_m() + off_m,
        );
        let first = seen(&scene, &still(), 100 + seed);
        let second = seen(&scene, &went, 200 + seed);
        let moved = MovedPair {
            sigma: is_doubtful.then_some(sigma),
            ..MovedPair::new(&second, said)
        };
        let estimate = fused(&first, &[moved]);
        assert_ne!(
            estimate.status,
            Status::Refused,
            "{seed} {:?}",
            estimate.reason
        );
        let nees = nees(&estimate, &truth, &scene);
        println!("{seed} {nees:.2}");
        total += nees / 4.0 / runs as f64;
    }
    println!("mean NEES of one: {total:.2}");
    // Cautious, as with one pair: of pairs from the first place alone it is 0.2.
    assert!((0.1..1.5).contains(&total), "{total}");
}

/// Bent rods, regions, three pairs, a radius and doubtful cameras go together with more pairs.
#[test]
fn whatever_else_is_asked_for_works_with_more_pairs() {
    let truth = oblique();
    let mut scene = lit(truth, 0.01);
    scene.curvature_per_m = Vec3::new(0.05, 0.15, -0.1);
    let first = seen(&scene, &still(), 1);
    let second = seen(&scene, &flown(), 2);
    let third = seen(&scene, &heaved(0.2), 3);
    let pick = Some(pick_at(&scene.rig, Eye::Left, &truth.axis.point_m));
    let region = Some(Roi {
        x_px: 0,
        y_px: 40,
        width_px: 960,
        height_px: 480,
    });
    let more = [
        MovedPair {
            roi_left: region,
            ..MovedPair::new(&second, flown())
        },
        MovedPair::new(&third, heaved(0.2)),
    ];
    let request = Request {
        pick,
        more: &more,
        ..Request::new(&first)
    };
    let estimate = joint(&request);
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    let (off_m, sigma_m) = (offset_m(&estimate, &truth), depth_sigma_m(&estimate));
    println!("{:.3} mm of {:.3}", 1e3 * off_m, 1e3 * sigma_m);
    assert!(off_m < 2e-4, "{off_m}");
    let one_m = depth_sigma_m(&joint(&Request {
        more: &[],
        ..request
    }));
    assert!(sigma_m < 0.8 * one_m, "{sigma_m} {one_m}");
    // Doubtful cameras are the same cameras in every pair: more pairs from the same place do not make them less so.
    let doubtful = |more: &[MovedPair<'_>]| {
        let calibration = Some(CalibrationSigma {
            pixel_px: 0.5,
            roll_rad: 0.0,
        });
        depth_sigma_m(&joint(&Request {
            calibration,
            more,
            ..request
        }))
    };
    let again = seen(&scene, &still(), 4);
    let (one_m, two_m) = (doubtful(&[]), doubtful(&[MovedPair::new(&again, still())]));
    assert!((two_m / one_m - 1.0).abs() < 0.02, "{one_m} {two_m}");
    // Of a straight one the radius that was given is checked.
    scene.curvature_per_m = Vec3::zeros();
    let (first, second) = (seen(&scene, &still(), 1), seen(&scene, &flown(), 2));
    let radius = |radius_m| {
        joint(&Request {
            radius: Some(RadiusPrior {
                radius_m,
                sigma_m: None,
            }),
            more: &[MovedPair::new(&second, flown())],
            ..Request::new(&first)
        })
    };
    let right = radius(truth.radius_m);
    assert!(offset_m(&right, &truth) < 2e-4 && right.radius_sigma_m == Some(0.0));
    refused(&radius(1.1 * truth.radius_m), "radius_contradicts");
}

/// A pair that does not show the rod is left out, and that is said.
#[test]
fn a_pair_without_the_rod_is_named() {
    let truth = oblique();
    let scene = lit(truth, 0.01);
    let first = seen(&scene, &still(), 1);
    let one = fused(&first, &[]);
    let empty = Scene {
        rods: Vec::new(),
        ..scene.clone()
    };
    let blank = empty.pair();
    let turned = Move::new(rotation_from_rpy(0.0, 0.0, 2.0), Vec3::zeros());
    for pose in [heaved(0.1), turned] {
        let estimate = fused(&first, &[MovedPair::new(&blank, pose)]);
        assert_eq!(estimate.status, Status::Degraded, "{:?}", estimate.reason);
        let reason = estimate.reason.clone().unwrap();
        assert!(reason.contains("pair 2 shows no limb"), "{reason}");
        assert!(offset_m(&estimate, &truth) < 2e-4);
        assert!((depth_sigma_m(&estimate) / depth_sigma_m(&one) - 1.0).abs() < 0.3);
    }
}

#[test]
fn moves_that_are_none_and_methods_that_know_none_are_errors() {
    let scene = lit(oblique(), 0.01);
    let first = scene.pair();
    let moved = MovedPair::new(&first, still());
    let error = |moved: MovedPair<'_>, method| -> SolveError {
        let request = Request {
            more: &[moved],
            ..Request::new(&first)
        };
        solve(&request, method, &PaperParams::default()).unwrap_err()
    };
    for method in [Method::Paper, Method::PaperBisector] {
        assert_eq!(error(moved, method), SolveError::More { more: 1 });
    }
    let says = |moved, text: &str| {
        let message = error(moved, Method::Joint).to_string();
        assert!(
            message.starts_with("pair 2: ") && message.contains(text),
            "{message}"
        );
    };
    let rig_from_moved = Move::new(Mat3::identity(), Vec3::new(f64::NAN, 0.0, 0.0));
    says(
        MovedPair {
            rig_from_moved,
            ..moved
        },
        "found NaN",
    );
    for rotation in [
        Mat3::identity() * 1.01,
        -Mat3::identity(),
        Mat3::repeat(f64::NAN),
    ] {
        let rig_from_moved = Move::new(rotation, Vec3::zeros());
        says(
            MovedPair {
                rig_from_moved,
                ..moved
            },
            "expected a rotation",
        );
    }
    let sigma = Some(MoveSigma {
        translation_m: -1.0,
        rotation_rad: 0.0,
    });
    says(MovedPair { sigma, ..moved }, "0 or more, found -1");
    let roi_left = Some(Roi {
        x_px: 0,
        y_px: 0,
        width_px: 961,
        height_px: 1,
    });
    says(MovedPair { roi_left, ..moved }, "left region");
}
