//! What is known of the radius beforehand: used where it agrees, told where it does not, the depth where nothing else gives it.

mod common;

use common::{Scene, bisector, offset_m, pick_at, refused, rig, rod, scene, small_rig, truth};
use rodsight_geometry::Eye;
use rodsight_solver::{RadiusPrior, Request, Status};

/// A given radius that the limbs contradict is not used, and both are named.
#[test]
fn a_radius_that_contradicts_is_not_used() {
    let pair = scene().pair();
    for (radius_m, sigma_m) in [(0.065, None), (0.07, Some(0.001))] {
        let mut request = Request::new(&pair);
        request.radius = Some(RadiusPrior { radius_m, sigma_m });
        let estimate = bisector(&request);
        assert_eq!(estimate.status, Status::Degraded, "{estimate:?}");
        let reason = estimate.reason.unwrap();
        assert!(reason.contains(&format!("{radius_m:.4} m")), "{reason}");
        let (found, sigma) = (estimate.radius_m.unwrap(), estimate.radius_sigma_m.unwrap());
        assert!((found - 0.05).abs() < 0.003, "{found}");
        assert!(sigma > 0.9 * (radius_m - found).abs(), "{sigma}");
    }
    let mut request = Request::new(&pair);
    request.radius = Some(RadiusPrior {
        radius_m: 0.2,
        sigma_m: Some(0.001),
    });
    refused(&bisector(&request), "radius_contradicted");
    request.radius = Some(RadiusPrior {
        radius_m: 0.05,
        sigma_m: Some(0.001),
    });
    assert_eq!(bisector(&request).status, Status::Ok);
}

/// A rod along the baseline has no depth by two eyes; a known radius gives it, with a standard deviation of D/r times its own.
#[test]
fn a_known_radius_gives_the_depth_of_a_rod_along_the_baseline() {
    let truth = rod([1.5, 0.0, 0.1], [0.0, 1.0, 0.0], 0.05);
    let pair = Scene::new(&rig(), vec![truth]).pair();
    let mut request = Request::new(&pair);
    let blind = bisector(&request);
    refused(&blind, "parallel_to_baseline");
    assert!(blind.reason.unwrap().contains("give the radius"));
    request.pick = Some(pick_at(&rig(), Eye::Left, &truth.axis.point_m));
    request.radius = Some(RadiusPrior {
        radius_m: 0.05,
        sigma_m: Some(0.001),
    });
    let estimate = bisector(&request);
    assert_eq!(estimate.status, Status::Degraded, "{estimate:?}");
    let sigma = estimate.observability.depth_sigma_m.unwrap();
    assert!((0.03..0.04).contains(&sigma), "{sigma}");
    assert!(offset_m(&estimate, &truth) < 3.0 * sigma);
    let grasp = estimate.grasp.unwrap().covariance_m2.unwrap();
    assert!(grasp[0][0].sqrt() > 0.9 * sigma, "{grasp:?}");
}

/// What is known of the radius only by its sigma is part of the grasp's.
#[test]
fn the_grasp_carries_the_sigma_of_the_radius() {
    let pair = scene().pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&small_rig(), Eye::Left, &truth().axis.point_m));
    let mut traces = Vec::new();
    for sigma_m in [None, Some(0.002)] {
        request.radius = Some(RadiusPrior {
            radius_m: 0.05,
            sigma_m,
        });
        let grasp = bisector(&request).grasp.unwrap().covariance_m2.unwrap();
        traces.push((0..3).map(|i| grasp[i][i]).sum::<f64>());
    }
    assert!(traces[1] > traces[0], "{traces:?}");
}
