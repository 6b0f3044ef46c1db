//! Rods, their limbs, and where to grasp them.

use proptest::prelude::*;
use rodsight_geometry::{
    Camera, Cylinder, CylinderError, Distortion, ImageLine, Intrinsics, Line3, PaperGrasp, Pixel,
    Plane, Pose, RigFrame, Side, TangentPair, TangentPlane, Vec3, angle_between, surface_foot,
};

use crate::common::{config, rig, rod, rotation, unit};

proptest! {
    #![proptest_config(config())]

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
