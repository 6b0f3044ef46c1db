//! Malformed requests, and regions that must not matter.

mod common;

use common::{Scene, bisector, offset_m, pick_at, rig, rod, scene, truth};
use proptest::prelude::*;
use rodsight_geometry::{Eye, Pixel, Vec3};
use rodsight_solver::{
    Estimate, Method, PaperParams, Pick, RadiusPrior, Request, Roi, SolveError, Status, solve,
};

#[test]
fn malformed_requests_are_errors_that_name_the_fault() {
    let pair = scene().pair();
    let message = |change: &dyn Fn(&mut Request<'_>, &mut PaperParams)| {
        let (mut request, mut params) = (Request::new(&pair), PaperParams::default());
        change(&mut request, &mut params);
        let error: SolveError = solve(&request, Method::Paper, &params).unwrap_err();
        error.to_string()
    };
    let roi = |x_px, y_px, width_px, height_px| {
        Some(Roi {
            x_px,
            y_px,
            width_px,
            height_px,
        })
    };
    assert_eq!(
        message(&|r, _| r.roi_right = roi(600, 0, 41, 10)),
        "right region: expected x,y,width,height inside the image of 640×360 px and not empty, found 600,0,41,10"
    );
    assert!(message(&|r, _| r.roi_left = roi(0, 0, 0, 10)).starts_with("left region"));
    assert!(message(&|r, _| r.roi_left = roi(u32::MAX, 0, 2, 10)).starts_with("left region"));
    let pick = |u, v| {
        Some(Pick {
            pixel: Pixel::new(u, v),
            eye: Eye::Right,
        })
    };
    assert_eq!(
        message(&|r, _| r.pick = pick(641.0, 3.0)),
        "pick: expected a pixel of the right image, 0,0 to 640,360, found 641,3"
    );
    assert!(message(&|r, _| r.pick = pick(f64::NAN, 3.0)).contains("NaN"));
    for radius_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let prior = RadiusPrior {
            radius_m,
            sigma_m: None,
        };
        assert!(message(&|r, _| r.radius = Some(prior)).starts_with("radius_m"));
    }
    assert_eq!(
        message(&|_, p| p.hough_theta_step_deg = 0.0),
        "parameter hough_theta_step_deg: expected 0.02 to 45, found 0"
    );
    assert!(message(&|_, p| p.refine_threshold_px = f64::NAN).contains("refine_threshold_px"));
}

#[test]
fn method_names_are_stable() {
    for method in Method::ALL {
        assert_eq!(method.name().parse::<Method>().unwrap(), method);
        assert_eq!(serde_json::to_value(method).unwrap(), method.name());
    }
    assert!(
        "papers"
            .parse::<Method>()
            .unwrap_err()
            .to_string()
            .contains("papers")
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// A region that holds the rod's stretch moves the answer by no more than its own uncertainty.
    #[test]
    fn regions_do_not_matter(left in 0_u32..60, top in 0_u32..60, right in 0_u32..60, bottom in 0_u32..60) {
        let scene = scene();
        let pair = scene.pair();
        let mut request = Request::new(&pair);
        request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m));
        let whole = bisector(&request);
        request.roi_left = Some(Roi { x_px: left, y_px: top, width_px: 640 - left - right, height_px: 360 - top - bottom });
        request.roi_right = Some(Roi { x_px: right, y_px: bottom, width_px: 640 - left - right, height_px: 360 - top - bottom });
        let part = bisector(&request);
        prop_assert_eq!(part.status, Status::Ok, "{:?}", part.reason);
        let grasp = |e: &Estimate| Vec3::from(e.grasp.unwrap().point_m.unwrap());
        prop_assert!((grasp(&whole) - grasp(&part)).norm() < 3e-3, "{} {}", grasp(&whole), grasp(&part));
    }
}

#[test]
fn regions_at_full_size() {
    let truth = rod([2.3, 0.1, 0.05], [0.4, 0.3, 1.0], 0.05);
    let scene = Scene::new(&rig(), vec![truth]);
    let pair = scene.pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth.axis.point_m));
    let around = |eye| {
        let p = scene.rig.eye(eye).project(&truth.axis.point_m).unwrap();
        Some(Roi {
            x_px: (p.x as u32).saturating_sub(320),
            y_px: 190,
            width_px: 640,
            height_px: 700,
        })
    };
    (request.roi_left, request.roi_right) = (around(Eye::Left), around(Eye::Right));
    let estimate = bisector(&request);
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    assert!(offset_m(&estimate, &truth) < 1.5e-3);
}
