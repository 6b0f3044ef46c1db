//! End to end against a renderer that shares no code path with the product's: what the paper's chain can and cannot do.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Scene, pick_at, rig, rig_of, rod};
use rodsight_geometry::{Cylinder, Distortion, Eye, Line3, Vec3, degrees};
use rodsight_solver::{Estimate, Method, PaperParams, RadiusPrior, Request, Status, solve};

fn axis(estimate: &Estimate) -> Line3 {
    let axis = estimate.axis.expect("an axis");
    Line3 {
        point_m: axis.point_m.unwrap().into(),
        direction: axis.direction.unwrap().into(),
    }
}

/// Error at the true axis' reference point: along the view (forward), across it, and the angle.
fn errors(estimate: &Estimate, truth: &Cylinder) -> (f64, f64, f64) {
    let line = axis(estimate);
    let off = line.foot(&truth.axis.point_m) - truth.axis.point_m;
    let across = (off - Vec3::x() * off.x).norm();
    (off.x, across, degrees(line.angle_to(&truth.axis)))
}

#[test]
fn accuracy_averaging_is_biased_by_r2_over_z_and_the_bisector_is_not() {
    // An upright rod in the plane x = 2.3 m: the bias is exactly −r²/Z there.
    for radius_m in [0.05, 0.1, 0.2, 0.3] {
        let truth = rod([2.3, 0.1, 0.0], [0.0, 0.25, 1.0], radius_m);
        let scene = Scene::new(&rig(), vec![truth]);
        let pair = scene.pair();
        let mut request = Request::new(&pair);
        request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth.axis.point_m));
        let bias = -radius_m * radius_m / 2.3;

        let paper = solve(&request, Method::Paper, &PaperParams::default()).unwrap();
        let (forward, across, angle) = errors(&paper, &truth);
        assert!(
            (forward - bias).abs() < 1.0e-3,
            "{radius_m}: {forward} for {bias}"
        );
        assert!(
            across < 0.8e-3 && angle < 0.01,
            "{radius_m}: {across} {angle}"
        );

        let bisector = solve(&request, Method::PaperBisector, &PaperParams::default()).unwrap();
        assert_eq!(bisector.status, Status::Ok, "{:?}", bisector.reason);
        let (forward, across, angle) = errors(&bisector, &truth);
        // Half a pixel of Canny's moves both images alike: 0.7 mm across, nothing in depth.
        assert!(forward.abs() < 0.7e-3, "{radius_m}: {forward}");
        assert!(
            across < 0.8e-3 && angle < 0.01,
            "{radius_m}: {across} {angle}"
        );
        assert!((bisector.radius_m.unwrap() - radius_m).abs() < 0.5e-3);
    }
}

#[test]
fn accuracy_over_poses_stays_within_its_own_covariance() {
    let directions = [
        [0.5, 0.3, 1.0],
        [1.0, 0.2, 0.6],
        [0.2, 1.0, 0.5],
        [-0.6, 0.7, 1.0],
        [0.0, 1.0, 1.0],
        [-0.3, -1.0, 0.4],
        [0.0, 0.0, 1.0],
    ];
    for (k, direction) in directions.into_iter().enumerate() {
        for (at, radius_m) in [
            ([2.3, 0.1, 0.05], 0.05),
            ([1.6, -0.2, 0.0], 0.02),
            ([3.5, 0.3, -0.2], 0.1),
        ] {
            let truth = rod(at, direction, radius_m);
            let mut scene = Scene::new(&rig(), vec![truth]);
            scene.noise_sigma = 0.008;
            scene.seed = k as u64;
            let pair = scene.pair();
            let mut request = Request::new(&pair);
            request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth.axis.point_m));
            for method in [Method::Paper, Method::PaperBisector] {
                let estimate = solve(&request, method, &PaperParams::default()).unwrap();
                let what = format!("{direction:?} {at:?} {method}: {:?}", estimate.reason);
                assert_ne!(estimate.status, Status::Refused, "{what}");
                let line = axis(&estimate);
                let middle = (pair.rig.left.rig_from_camera.origin_m()
                    + pair.rig.right.rig_from_camera.origin_m())
                    * 0.5;
                let point_off = line.point_m - truth.axis.foot(&middle);
                let covariance = estimate.axis.unwrap().covariance.unwrap();
                let sigma: f64 = (0..3).map(|i| covariance[i][i]).sum::<f64>().sqrt();
                assert!(
                    point_off.norm() < 3.0 * sigma,
                    "{what}: {point_off} {sigma}"
                );
                let direction_sigma: f64 = (3..6).map(|i| covariance[i][i]).sum::<f64>().sqrt();
                let angle = line.angle_to(&truth.axis);
                assert!(
                    angle < 3.0 * direction_sigma,
                    "{what}: {angle} {direction_sigma}"
                );
                if method == Method::PaperBisector {
                    let off = line.foot(&truth.axis.point_m) - truth.axis.point_m;
                    assert!(
                        off.norm() < 2.0e-3 * at[0] / 2.3 * at[0] / 2.3,
                        "{what}: {off}"
                    );
                    assert!(degrees(angle) < 0.1, "{what}: {angle}");
                }
            }
        }
    }
}

#[test]
fn accuracy_of_the_grasp_point_from_a_pick_on_the_surface() {
    // A thick oblique rod: the surface foot is r·cot ψ from the paper's point along the rod.
    let truth = rod([2.3, 0.1, 0.0], [1.0, 0.2, 1.0], 0.12);
    let scene = Scene::new(&rig(), vec![truth]);
    let pair = scene.pair();
    for eye in Eye::BOTH {
        let mounted = scene.rig.eye(eye);
        let pick = pick_at(
            &scene.rig,
            eye,
            &(truth.axis.point_m + Vec3::new(0.0, 0.03, 0.02)),
        );
        let (origin, ray) = mounted.ray(&pick.pixel).unwrap();
        let expected = rodsight_geometry::surface_foot(&truth, &origin, &ray).unwrap();
        let mut request = Request::new(&pair);
        request.pick = Some(pick);
        let mut radii = vec![None];
        radii.push(Some(RadiusPrior {
            radius_m: 0.12,
            sigma_m: None,
        }));
        radii.push(Some(RadiusPrior {
            radius_m: 0.12,
            sigma_m: Some(0.002),
        }));
        for radius in radii {
            request.radius = radius;
            let estimate = solve(&request, Method::PaperBisector, &PaperParams::default()).unwrap();
            let grasp = estimate.grasp.unwrap();
            let off = Vec3::from(grasp.point_m.unwrap()) - expected;
            assert!(off.norm() < 3e-3, "{eye:?} {off}");
            let paper = Vec3::from(grasp.paper_point_m.unwrap());
            assert!(
                (paper - expected).norm() > 0.05,
                "the two points differ by r cot ψ"
            );
            let covariance = grasp.covariance_m2.unwrap();
            let sigma = (0..3).map(|i| covariance[i][i]).sum::<f64>().sqrt();
            assert!(off.norm() < 3.0 * sigma && sigma < 0.02, "{off} {sigma}");
            if radius.is_some_and(|r| r.sigma_m.is_none()) {
                assert_eq!(estimate.radius_m, Some(0.12));
                assert_eq!(estimate.radius_sigma_m, Some(0.0));
            }
        }
    }
}

#[test]
fn accuracy_with_a_distorted_lens() {
    let distortion = Distortion::BrownConrady([-0.12, 0.03, 0.0005, -0.0003, 0.0]);
    let rig = rig_of(1920, 1080, 1566.5776, distortion);
    let truth = rod([2.3, 0.2, 0.0], [0.2, 0.3, 1.0], 0.06);
    let scene = Scene::new(&rig, vec![truth]);
    let pair = scene.pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&rig, Eye::Right, &truth.axis.point_m));
    let estimate = solve(&request, Method::PaperBisector, &PaperParams::default()).unwrap();
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    let (forward, across, angle) = errors(&estimate, &truth);
    assert!(
        forward.abs() < 1.5e-3 && across < 1e-3 && angle < 0.05,
        "{forward} {across} {angle}"
    );
}

#[test]
fn parallel_to_the_baseline_is_refused_and_its_direction_kept() {
    for radius_m in [0.02, 0.05, 0.15] {
        for slope in [0.0, 0.003, 0.01] {
            let truth = rod([2.3, 0.0, 0.2], [slope, 1.0, slope], radius_m);
            let scene = Scene::new(&rig(), vec![truth]);
            let pair = scene.pair();
            let mut request = Request::new(&pair);
            request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth.axis.point_m));
            for method in [Method::Paper, Method::PaperBisector] {
                let estimate = solve(&request, method, &PaperParams::default()).unwrap();
                assert_eq!(
                    estimate.status,
                    Status::Refused,
                    "{slope} {radius_m} {method}: {:?}",
                    estimate.observability
                );
                assert_eq!(
                    estimate.observability.refusal.as_deref(),
                    Some("parallel_to_baseline")
                );
                assert!(estimate.centerlines.unwrap().left.is_some());
                assert!(estimate.grasp.is_none() && estimate.radius_m.is_none());
                let direction = estimate.axis.and_then(|a| a.direction);
                if method == Method::Paper {
                    assert_eq!(direction, None);
                    continue;
                }
                let line = Line3::new(truth.axis.point_m, &direction.unwrap().into());
                let sigma = estimate.observability.direction_sigma_rad.unwrap();
                let angle = line.angle_to(&truth.axis);
                assert!(angle < 3.0 * sigma, "{slope} {radius_m}: {angle} {sigma}");
                assert!(estimate.axis.unwrap().point_m.is_none());
            }
        }
    }
}
