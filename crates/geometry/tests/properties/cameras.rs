//! Cameras, poses, image lines.

use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use rodsight_geometry::{
    Camera, CameraFrame, Distortion, ImageLine, Intrinsics, Line3, LineFit, Pixel, Plane, Pose,
    RigFrame, angle_between,
};

use crate::common::{config, rotation, unit};

fn intrinsics() -> impl Strategy<Value = Intrinsics> {
    (
        1000.0..2400.0_f64,
        0.99..1.01_f64,
        -30.0..30.0_f64,
        -30.0..30.0_f64,
    )
        .prop_map(|(f, aspect, dx, dy)| Intrinsics {
            width_px: 1280,
            height_px: 720,
            fx_px: f,
            fy_px: f * aspect,
            cx_px: 640.0 + dx,
            cy_px: 360.0 + dy,
        })
}

fn pixel() -> impl Strategy<Value = Pixel> {
    (0.0..1280.0_f64, 0.0..720.0_f64).prop_map(|(u, v)| Pixel::new(u, v))
}

/// What calibrations of real lenses look like: barrel or pincushion, k2 against k1, little tangential. None folds within 37°.
fn brown_conrady() -> impl Strategy<Value = Distortion> {
    (
        -0.38..0.3_f64,
        0.35..0.6_f64,
        -0.002..0.002_f64,
        -0.002..0.002_f64,
        -0.05..0.05_f64,
    )
        .prop_map(|(k1, ratio, p1, p2, k3)| {
            Distortion::BrownConrady([k1, -ratio * k1, p1, p2, k3 * k1.abs()])
        })
}

fn kannala_brandt() -> impl Strategy<Value = Distortion> {
    (
        -0.06..0.06_f64,
        -0.03..0.03_f64,
        -0.02..0.02_f64,
        -0.005..0.005_f64,
    )
        .prop_map(|(k1, k2, k3, k4)| Distortion::KannalaBrandt([k1, k2, k3, k4]))
}

#[track_caller]
fn round_trip(intrinsics: Intrinsics, distortion: Distortion, pixel: &Pixel, range_m: f64) {
    let camera = Camera::new(intrinsics, distortion).expect("a lens that does not fold");
    let ray = camera
        .ray(pixel)
        .expect("every pixel of the image has a ray");
    assert!((ray.norm() - 1.0).abs() < 1e-14, "{ray:?}");
    let back = camera.project(&(ray * range_m)).expect("in front");
    assert!(
        (back - pixel).norm() < 1e-9,
        "{pixel:?} came back as {back:?}"
    );
    let again = camera.ray(&back).expect("still in the image");
    assert!(
        angle_between(&ray, &again) < 1e-12,
        "{ray:?} came back as {again:?}"
    );
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn camera_pinhole_project_inverts_ray(i in intrinsics(), p in pixel(), z in 0.1..30.0_f64) {
        round_trip(i, Distortion::None, &p, z);
    }

    #[test]
    fn camera_brown_conrady_project_inverts_ray(
        i in intrinsics(), k in brown_conrady(), p in pixel(), z in 0.1..30.0_f64,
    ) {
        round_trip(i, k, &p, z);
    }

    #[test]
    fn camera_kannala_brandt_project_inverts_ray(
        i in intrinsics(), k in kannala_brandt(), p in pixel(), z in 0.1..30.0_f64,
        wide in 0.15..1.0_f64,
    ) {
        // Up to 85° off axis.
        let i = Intrinsics { fx_px: i.fx_px * wide, fy_px: i.fy_px * wide, ..i };
        prop_assume!(Camera::new(i, k).is_ok());
        round_trip(i, k, &p, z);
    }

    #[test]
    fn camera_undistorted_pixels_obey_the_pinhole(
        i in intrinsics(), k in brown_conrady(), p in pixel(),
    ) {
        let camera = Camera::new(i, k).unwrap();
        let ideal = camera.undistort(&p).unwrap();
        let angle = angle_between(
            &camera.without_distortion().ray(&ideal).unwrap(),
            &camera.ray(&p).unwrap(),
        );
        prop_assert!(angle < 1e-12);
        prop_assert!(camera.without_distortion().is_pinhole() && !camera.is_pinhole());
    }

    #[test]
    fn camera_plane_of_a_line_holds_its_rays(i in intrinsics(), a in pixel(), b in pixel()) {
        prop_assume!((a - b).norm() > 1.0);
        let camera = Camera::new(i, Distortion::None).unwrap();
        let normal = camera.plane_normal(&ImageLine::through(&a, &b));
        for p in [a, b, (a + b) * 0.5] {
            prop_assert!(normal.dot(&camera.ray(&p).unwrap()).abs() < 1e-12);
        }
    }

    #[test]
    fn camera_image_line_inverts_plane_normal(
        i in intrinsics(), rho in -2000.0..2000.0_f64, theta in -1.57..1.57_f64,
    ) {
        let camera = Camera::new(i, Distortion::None).unwrap();
        let line = ImageLine::new(rho, theta);
        for sign in [1.0, -1.0] {
            let back = camera.image_line(&(camera.plane_normal(&line) * sign)).unwrap();
            prop_assert!((back.rho_px - line.rho_px).abs() < 1e-9, "{line:?} {back:?}");
            prop_assert!((back.theta_rad - line.theta_rad).abs() < 1e-12, "{line:?} {back:?}");
        }
    }

    #[test]
    fn pose_inverse_undoes(r in rotation(), t in unit(), x in unit()) {
        let pose = Pose::<RigFrame, CameraFrame>::new(r, t * 3.0);
        prop_assert!((pose.inverse().point(&pose.point(&x)) - x).norm() < 1e-14);
        prop_assert!((pose.inverse().direction(&pose.direction(&x)) - x).norm() < 1e-14);
        let there_and_back: Pose<RigFrame, RigFrame> = pose * pose.inverse();
        prop_assert!((there_and_back.point(&x) - x).norm() < 1e-14);
    }

    #[test]
    fn image_line_is_canonical_and_the_same_line(rho in -3000.0..3000.0_f64, theta in -50.0..50.0_f64) {
        let line = ImageLine::new(rho, theta);
        let half_turn = core::f64::consts::FRAC_PI_2;
        prop_assert!(line.theta_rad > -half_turn && line.theta_rad <= half_turn);
        let (sin, cos) = libm::sincos(theta);
        for along in [-100.0, 0.0, 1000.0] {
            let p = Pixel::new(rho * cos - along * sin, rho * sin + along * cos);
            prop_assert!(line.distance_px(&p).abs() < 1e-9);
        }
        prop_assert_eq!(ImageLine::new(line.rho_px, line.theta_rad), line);
        let turned = ImageLine::from_normal(&-line.normal(), -line.rho_px);
        prop_assert!((turned.rho_px - line.rho_px).abs() < 1e-9 || line.theta_rad.abs() > 1.57);
        prop_assert!(turned.angle_to(&line) < 1e-12);
        prop_assert!(line.direction().dot(&line.normal()).abs() < 1e-15);
    }

    #[test]
    fn line_fit_is_the_smallest_eigenvector(
        points in prop::collection::vec((-500.0..2500.0_f64, -500.0..1500.0_f64), 3..40),
    ) {
        let points: Vec<Pixel> = points.into_iter().map(|(u, v)| Pixel::new(u, v)).collect();
        let mean = points.iter().sum::<Pixel>() / points.len() as f64;
        let scatter: Matrix2<f64> =
            points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
        let eigen = scatter.symmetric_eigen();
        let (low, high) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
        prop_assume!(high - low > 1e-3 * high);
        let fit = LineFit::of(&points).unwrap();
        let normal: Vector2<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        prop_assert!((fit.line.normal().dot(&normal).abs() - 1.0).abs() < 1e-9);
        prop_assert!(fit.line.distance_px(&mean).abs() < 1e-9);
        prop_assert!((fit.scatter_across_px2 - low).abs() < 1e-9 * high);
        prop_assert!((fit.scatter_along_px2 - high).abs() < 1e-9 * high);
        prop_assert_eq!(fit.count, points.len());
    }

    #[test]
    fn lines_from_planes_lie_in_both_and_start_at_the_foot(
        p in unit(), a in unit(), b in unit(), from in unit(),
    ) {
        prop_assume!(a.cross(&b).norm() > 1e-3);
        let planes = [Plane::through(&p, &a), Plane::through(&p, &b)];
        let line = Line3::from_planes(&planes[0], &planes[1], &from).unwrap();
        for plane in &planes {
            prop_assert!(plane.distance_m(&line.point_m).abs() < 1e-9);
            prop_assert!(plane.normal.dot(&line.direction).abs() < 1e-12);
        }
        prop_assert!((line.point_m - from).dot(&line.direction).abs() < 1e-9);
        prop_assert!(line.distance_m(&p) < 1e-9);
        let other = Line3::new(p, &a);
        prop_assert!(line.distance_to_line_m(&other) < 1e-9);
        let canonical = line.with_canonical_sign();
        prop_assert!(canonical.angle_to(&line) == 0.0 && canonical.direction.max() >= -canonical.direction.min());
    }
}
