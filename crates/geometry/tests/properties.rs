//! What must hold for every camera, line and rod: properties, on random cases with a fixed seed.

mod common;

use common::{config, rig, rod, rotation, unit};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use rodsight_geometry::{
    Camera, CameraFrame, Cylinder, CylinderError, Distortion, ImageLine, Intrinsics, Line3,
    LineFit, PaperGrasp, Pixel, Plane, Pose, RigFrame, Side, TangentPair, TangentPlane, Vec3,
    angle_between, surface_foot,
};

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
    fn cylinder_tangent_planes_touch(rod in rod(), centre in unit()) {
        let planes = rod.tangent_planes(&centre).unwrap();
        for (n, side) in [(planes.plus, Side::Plus), (planes.minus, Side::Minus)] {
            prop_assert!((n.norm() - 1.0).abs() < 1e-14);
            prop_assert!(n.dot(&rod.axis.direction).abs() < 1e-14);
            let distance_m = n.dot(&(rod.axis.point_m - centre));
            prop_assert!((distance_m - side.sign() * rod.radius_m).abs() < 1e-12);
        }
        let towards_axis = planes.axis_plane.dot(&(rod.axis.point_m - centre));
        prop_assert!(towards_axis.abs() < 1e-12);
        let [a, b] = [planes.plus, planes.minus].map(|n| angle_between(&n, &planes.axis_plane));
        prop_assert!((a - b).abs() < 1e-12, "the axis plane is the bisector");
    }

    #[test]
    fn cylinder_one_view_inverts_tangent_planes(
        rod in rod(), centre in unit(), flip_a in any::<bool>(), flip_b in any::<bool>(),
        exchanged in any::<bool>(), along in -0.5..0.5_f64,
    ) {
        let planes = rod.tangent_planes(&centre).unwrap();
        let signed = |n: Vec3, flip| if flip { -n } else { n };
        let (a, b) = (signed(planes.plus, flip_a), signed(planes.minus, flip_b));
        let (a, b) = if exchanged { (b, a) } else { (a, b) };
        let seen = rod.axis.point_m + rod.axis.direction * along - centre;
        let view = TangentPair::one_view(&a, &b, &seen).unwrap();
        let q = rod.axis.foot(&centre) - centre;
        prop_assert!((view.sin_half_angle - rod.radius_m / q.norm()).abs() < 1e-12);
        prop_assert!((view.towards - q.normalize()).norm() < 1e-9);
        let unsigned = |a: &Vec3, b: &Vec3| (a - b).norm().min((a + b).norm());
        prop_assert!(unsigned(&view.direction, &rod.axis.direction) < 1e-9);
        prop_assert!(unsigned(&view.axis_plane, &planes.axis_plane) < 1e-12);
        prop_assert!((view.direction.dot(&view.towards)).abs() < 1e-9);
        // The sides are right for the normals as they come back.
        let other = if view.first_side == Side::Plus { Side::Minus } else { Side::Plus };
        for (n, side) in view.normals.iter().zip([view.first_side, other]) {
            let distance_m = n.dot(&(rod.axis.point_m - centre));
            prop_assert!((distance_m - side.sign() * rod.radius_m).abs() < 1e-12);
        }
    }

    #[test]
    fn cylinder_follows_from_four_or_three_tangent_planes(rod in rod(), rig in rig()) {
        let all = tangents(&rod, &rig.map(|c| c.origin_m()));
        prop_assume!(observable(&rod, &rig.map(|c| c.origin_m())));
        let mut sets = vec![all.clone()];
        for left_out in 0..4 {
            let mut three = all.clone();
            three.remove(left_out);
            sets.push(three);
        }
        for planes in sets {
            for known in [None, Some(rod.radius_m)] {
                let fit = Cylinder::from_tangent_planes(&planes, known).unwrap();
                let axis = &fit.cylinder.axis;
                prop_assert!(axis.angle_to(&rod.axis) < 1e-8, "{fit:?}");
                prop_assert!(axis.distance_m(&rod.axis.point_m) < 1e-8, "{fit:?}");
                prop_assert!((fit.cylinder.radius_m - rod.radius_m).abs() < 1e-8, "{fit:?}");
                prop_assert!(fit.residual_m < 1e-10, "{fit:?}");
            }
        }
        // The sides of a normal and of its opposite are opposite: the signs do not matter.
        let turned: Vec<_> = all.iter().map(|p| TangentPlane {
            normal: -p.normal,
            side: if p.side == Side::Plus { Side::Minus } else { Side::Plus },
            ..*p
        }).collect();
        let fit = Cylinder::from_tangent_planes(&turned, None).unwrap();
        prop_assert!(fit.cylinder.axis.distance_m(&rod.axis.point_m) < 1e-8);
        // Every plane twice changes nothing, the conditioning included.
        let once = Cylinder::from_tangent_planes(&all, None).unwrap();
        let twice = Cylinder::from_tangent_planes(&[all.clone(), all].concat(), None).unwrap();
        prop_assert!((once.conditioning - twice.conditioning).abs() < 1e-9);
    }

    #[test]
    fn cylinder_parallel_to_the_baseline_needs_its_radius(rod in rod(), baseline_m in 0.1..1.5_f64, centre in unit()) {
        let centres = [centre, centre + rod.axis.direction * baseline_m];
        let planes = tangents(&rod, &centres);
        let fit = Cylinder::from_tangent_planes(&planes, Some(rod.radius_m)).unwrap();
        prop_assert!(fit.cylinder.axis.angle_to(&rod.axis) < 1e-8, "{fit:?}");
        prop_assert!(fit.cylinder.axis.distance_m(&rod.axis.point_m) < 1e-8, "{fit:?}");
        let refused = Cylinder::from_tangent_planes(&planes, None);
        prop_assert!(matches!(refused, Err(CylinderError::Degenerate { .. })), "{refused:?}");
    }

    #[test]
    fn cylinder_with_exchanged_sides_is_refused(rod in rod(), rig in rig()) {
        let centres = rig.map(|c| c.origin_m());
        prop_assume!(observable(&rod, &centres));
        let mut planes = tangents(&rod, &centres);
        for plane in &mut planes {
            plane.side = if plane.side == Side::Plus { Side::Minus } else { Side::Plus };
        }
        let refused = Cylinder::from_tangent_planes(&planes, None);
        prop_assert!(matches!(refused, Err(CylinderError::NegativeRadius { .. })), "{refused:?}");
    }

    #[test]
    fn everything_moves_with_the_frame(rod in rod(), rig in rig(), r in rotation(), t in unit()) {
        let motion = Pose::<RigFrame, RigFrame>::new(r, t * 5.0);
        let moved_rod = Cylinder {
            axis: Line3::new(motion.point(&rod.axis.point_m), &motion.direction(&rod.axis.direction)),
            ..rod
        };
        let camera = Camera::new(
            Intrinsics { width_px: 1280, height_px: 720, fx_px: 1000.0, fy_px: 1005.0, cx_px: 640.0, cy_px: 360.0 },
            Distortion::None,
        ).unwrap();
        let mut planes = [Vec::new(), Vec::new()];
        for pose in rig {
            let moved = motion * pose;
            // The image does not change.
            let before = rod.image_lines(&camera, &pose).unwrap();
            let after = moved_rod.image_lines(&camera, &moved).unwrap();
            for (a, b) in before.iter().zip(&after) {
                prop_assert!(a.angle_to(b) < 1e-9, "{a:?} {b:?}");
                let near = Pixel::new(640.0, 360.0);
                prop_assert!((a.distance_px(&near).abs() - b.distance_px(&near).abs()).abs() < 1e-6);
            }
            planes[0].push(Plane::through_camera(&pose, &camera.plane_normal(&before[2])));
            planes[1].push(Plane::through_camera(&moved, &camera.plane_normal(&after[2])));
        }
        let centres = rig.map(|c| c.origin_m());
        prop_assume!(observable(&rod, &centres));
        // The plane intersection moves with it, and so does the pick.
        let axis = Line3::from_planes(&planes[0][0], &planes[0][1], &centres[0]).unwrap();
        let moved_axis =
            Line3::from_planes(&planes[1][0], &planes[1][1], &motion.point(&centres[0])).unwrap();
        prop_assert!((motion.point(&axis.point_m) - moved_axis.point_m).norm() < 1e-7);
        prop_assert!(axis.angle_to(&rod.axis) < 1e-8);
        prop_assert!(axis.distance_m(&rod.axis.point_m) < 1e-8);
        let ray = rod.axis.point_m + Vec3::new(0.01, -0.02, 0.005) - centres[0];
        let grasp = PaperGrasp::new(&rod.axis, &centres[0], &ray).unwrap();
        let moved_grasp =
            PaperGrasp::new(&moved_rod.axis, &motion.point(&centres[0]), &motion.direction(&ray)).unwrap();
        prop_assert!((motion.point(&grasp.point_m) - moved_grasp.point_m).norm() < 1e-9);
        prop_assert!((grasp.gap_m - moved_grasp.gap_m).abs() < 1e-12);
    }

    #[test]
    fn cylinder_rays_meet_it_between_its_tangents(rod in rod(), centre in unit(), turn in -3.0..3.0_f64, tilt in -1.0..1.0_f64) {
        // A ray of the plane at `turn` half-angles from the axis plane, tilted along the rod.
        let q = rod.axis.foot(&centre) - centre;
        let (towards, across) = (q.normalize(), q.normalize().cross(&rod.axis.direction));
        let half = libm::asin(rod.radius_m / q.norm());
        prop_assume!((turn.abs() - 1.0).abs() > 1e-6 && (turn * half).abs() < 1.5);
        let (sin, cos) = libm::sincos(turn * half);
        let ray = (towards * cos + across * sin + rod.axis.direction * tilt).normalize();
        let [plus, minus] = [Side::Plus, Side::Minus]
            .map(|side| rod.tangency_residual_m(&centre, &ray, side).unwrap());
        prop_assert_eq!(rod.intersect(&centre, &ray).is_some(), plus < 0.0 && minus > 0.0);
        if let Some((near, far)) = rod.intersect(&centre, &ray) {
            prop_assert!(0.0 < near && near <= far);
            for along in [near, far] {
                let surface = rod.axis.distance_m(&(centre + ray * along));
                prop_assert!((surface - rod.radius_m).abs() < 1e-10);
            }
        }
        // And a ray in a tangent plane touches: the residual is zero.
        let planes = rod.tangent_planes(&centre).unwrap();
        for (n, side) in [(planes.plus, Side::Plus), (planes.minus, Side::Minus)] {
            let touching = (n.cross(&rod.axis.direction) * -1.0 + rod.axis.direction * tilt).normalize();
            prop_assert!(rod.tangency_residual_m(&centre, &touching, side).unwrap().abs() < 1e-12);
        }
    }

    #[test]
    fn grasp_points_differ_by_r_cot_psi(rod in rod(), centre in unit(), along in -1.0..1.0_f64, aside in -0.9..0.9_f64) {
        let target = rod.axis.point_m + rod.axis.direction * along;
        for gap_m in [0.0, aside * rod.radius_m] {
            let towards = (target - centre).normalize();
            let aside = towards.cross(&rod.axis.direction).normalize();
            let ray = (target + aside * gap_m - centre).normalize();
            let paper = PaperGrasp::new(&rod.axis, &centre, &ray).unwrap();
            let foot = surface_foot(&rod, &centre, &ray).unwrap();
            prop_assert!(rod.axis.distance_m(&foot) < 1e-12);
            prop_assert!(rod.axis.distance_m(&paper.point_m) < 1e-12);
            let cos = ray.dot(&rod.axis.direction);
            let cot = cos / (1.0 - cos * cos).sqrt();
            let chord = (rod.radius_m * rod.radius_m - paper.gap_m * paper.gap_m).sqrt();
            // The surface is met before the axis: the foot lies back along the ray.
            let step = (foot - paper.point_m).dot(&rod.axis.direction);
            prop_assert!((step + chord * cot).abs() < 1e-9, "{step} {}", chord * cot);
            if gap_m == 0.0 {
                prop_assert!(paper.gap_m < 1e-12);
                prop_assert!((step + rod.radius_m * cot).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn averaging_the_limbs_moves_a_frontal_rod_by_minus_r2_over_z(
        x in -0.6..0.6_f64, z in 1.0..4.0_f64, r in 0.01..0.3_f64, half_baseline in 0.1..0.6_f64,
    ) {
        // Upright, parallel to both images: the limbs are vertical lines u = ρ, and averaging ρ is unambiguous.
        let rod = Cylinder { axis: Line3::new(Vec3::new(x, 0.0, z), &Vec3::y()), radius_m: r };
        let camera = Camera::new(
            Intrinsics { width_px: 1920, height_px: 1080, fx_px: 1566.0, fy_px: 1566.0, cx_px: 960.0, cy_px: 540.0 },
            Distortion::None,
        ).unwrap();
        let planes = [-half_baseline, half_baseline].map(|at| {
            let pose = Pose::new(nalgebra::Matrix3::identity(), Vec3::new(at, 0.0, 0.0));
            let [plus, minus, _] = rod.image_lines(&camera, &pose).unwrap();
            let mean = ImageLine::new(0.5 * (plus.rho_px + minus.rho_px), 0.5 * (plus.theta_rad + minus.theta_rad));
            Plane::through_camera(&pose, &camera.plane_normal(&mean))
        });
        let axis = Line3::from_planes(&planes[0], &planes[1], &Vec3::zeros()).unwrap();
        let moved = axis.foot(&rod.axis.point_m) - rod.axis.point_m;
        prop_assert!((moved.z + r * r / z).abs() < 1e-10, "{} instead of {}", moved.z, -r * r / z);
        prop_assert!(axis.angle_to(&rod.axis) < 1e-12, "the direction stays");
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

/// Both tangent planes of both views.
fn tangents(rod: &Cylinder, centres: &[Vec3; 2]) -> Vec<TangentPlane> {
    centres
        .iter()
        .flat_map(|centre| {
            let planes = rod.tangent_planes(centre).expect("outside");
            [(planes.plus, Side::Plus), (planes.minus, Side::Minus)].map(|(normal, side)| {
                TangentPlane {
                    normal,
                    centre_m: *centre,
                    side,
                }
            })
        })
        .collect()
}

/// The planes of the axis meet at half a degree at least.
fn observable(rod: &Cylinder, centres: &[Vec3; 2]) -> bool {
    let [a, b] = centres.map(|c| rod.tangent_planes(&c).expect("outside").axis_plane);
    a.cross(&b).norm() > 0.01
}
