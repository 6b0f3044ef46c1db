//! Metrics against numbers computed by hand, and their invariances.

use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use rodsight_bench::{
    AxisCovariance, Errors, Located, SUCCESS_LEVELS, TruthAxis, depth_error_m, grasp_error,
    max_span_distance_m, nees, radius_error_m,
};
use rodsight_geometry::{Line3, Mat3, Pose, RigFrame, Vec3, radians, rotation_from_rpy};

/// A rod across the view, 2 m ahead.
fn truth() -> TruthAxis {
    TruthAxis {
        axis: Line3::new(Vec3::new(2.0, 0.0, 0.0), &Vec3::y()),
        radius_m: 0.05,
        grasp_m: Vec3::new(2.0, 0.3, 0.0),
        visible_span_m: [-0.4, 0.8],
        depth_direction: Vec3::x(),
    }
}

#[track_caller]
fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-12,
        "{found} instead of {expected}"
    );
}

#[test]
fn errors_of_a_shifted_axis() {
    // 3 mm nearer and 4 mm lower: 5 mm off, no angle.
    let estimate = Located {
        radius_m: Some(0.048),
        grasp_m: Some(Vec3::new(1.997, 0.312, 0.004)),
        ..Located::of_axis(Line3::new(Vec3::new(1.997, -7.0, 0.004), &-Vec3::y()))
    };
    let errors = Errors::of(&estimate, &truth());
    close(errors.axis_angle_rad, 0.0);
    close(errors.axis_offset_m, 0.005);
    close(errors.max_span_distance_m, 0.005);
    close(errors.depth_m, -0.003);
    close(errors.radius_m.unwrap(), -0.002);
    let grasp = errors.grasp.unwrap();
    close(grasp.across_m, 0.005);
    close(grasp.along_m, 0.012);
    close(grasp.total_m(), 0.013);
    assert_eq!(errors.nees, None);
}

#[test]
fn errors_of_a_turned_axis() {
    // Turned by atan(3/4) about the true axis' reference point, in the plane of depth and the rod.
    let estimate = Line3::new(Vec3::new(2.0, 0.0, 0.0), &Vec3::new(3.0, 4.0, 0.0));
    let errors = Errors::of(&Located::of_axis(estimate), &truth());
    close(errors.axis_angle_rad, libm::atan2(3.0, 4.0));
    // Distances are 3/5 of the distance along: 0.3 m at the grasp, 0.8 m at the far end of the span.
    close(errors.axis_offset_m, 0.18);
    close(errors.max_span_distance_m, 0.48);
    // The foot of the grasp lies 0.24 m along the estimate, 0.144 m deeper.
    close(errors.depth_m, 0.144);
}

#[test]
fn single_metrics_by_hand() {
    close(radius_error_m(0.03, 0.05), -0.02);
    close(
        depth_error_m(
            &Line3::new(Vec3::new(2.5, 0.0, 1.0), &Vec3::y()),
            &Vec3::new(2.0, 9.0, 0.0),
            &Vec3::x(),
        ),
        0.5,
    );
    let error = grasp_error(&Vec3::new(1.0, 2.0, 2.0), &Vec3::zeros(), &Vec3::x());
    close(error.along_m, 1.0);
    close(error.across_m, 8.0_f64.sqrt());
    close(error.total_m(), 3.0);
    // The span lies on one side: the far end counts, not the middle.
    let estimate = Line3::new(Vec3::zeros(), &Vec3::new(1.0, 1.0, 0.0));
    close(
        max_span_distance_m(
            &estimate,
            &Line3::new(Vec3::zeros(), &Vec3::x()),
            [1.0, 4.0],
        ),
        8.0_f64.sqrt(),
    );
}

#[test]
fn success_levels_need_both_offset_and_angle() {
    let level = |offset_m: f64, angle_deg: f64| {
        let direction = Vec3::new(
            libm::sin(radians(angle_deg)),
            libm::cos(radians(angle_deg)),
            0.0,
        );
        let point = truth().grasp_m + Vec3::new(0.0, 0.0, offset_m);
        let errors = Errors::of(&Located::of_axis(Line3::new(point, &direction)), &truth());
        SUCCESS_LEVELS.map(|l| errors.within(&l))
    };
    assert_eq!(level(0.0009, 0.09), [true, true, true]);
    assert_eq!(level(0.0011, 0.09), [false, true, true]);
    assert_eq!(level(0.0009, 0.11), [false, true, true]);
    assert_eq!(level(0.0060, 0.40), [false, false, true]);
    assert_eq!(level(0.0210, 0.0), [false, false, false]);
    assert_eq!(level(0.0, 2.1), [false, false, false]);
}

/// Independent errors: σ of the point across the axis (m) and of the direction (rad).
fn covariance(point_sigma_m: f64, direction_sigma: f64) -> AxisCovariance {
    let (p, d) = (point_sigma_m.powi(2), direction_sigma.powi(2));
    Matrix6::from_diagonal(&Vector6::new(p, 0.0, p, d, 0.0, d))
}

#[test]
fn nees_by_hand() {
    let truth = truth().axis;
    // 2σ in depth, 1σ in height, 3σ of the direction: 4 + 1 + 9.
    let estimate = Line3 {
        point_m: Vec3::new(2.002, 5.0, 0.001),
        direction: Vec3::y(),
    };
    let found = nees(&estimate, &covariance(0.001, 0.01), &truth);
    close(found.value, 5.0);
    assert_eq!(found.dof, 4);
    let tilt = 0.03;
    let turned = Line3::new(Vec3::new(2.0, 0.0, 0.0), &Vec3::new(tilt, 1.0, 0.0));
    let to_turned = rotation_from_rpy(0.0, 0.0, -libm::atan(tilt));
    let found = nees(
        &turned,
        &rotated(&covariance(0.001, 0.01), &to_turned),
        &truth,
    );
    assert!((found.value - 9.0).abs() < 1e-9, "{found:?}");
}

#[test]
fn nees_without_variance_is_infinite_only_where_there_is_an_error() {
    let truth = truth().axis;
    let estimate = Line3 {
        point_m: Vec3::new(2.002, 0.0, 0.0),
        direction: Vec3::y(),
    };
    // Direction claimed exact, and it is: two degrees of freedom.
    let found = nees(&estimate, &covariance(0.001, 0.0), &truth);
    close(found.value, 4.0);
    assert_eq!(found.dof, 2);
    // Position claimed exact, and it is not.
    let found = nees(&estimate, &covariance(0.0, 0.01), &truth);
    assert_eq!(found.value, f64::INFINITY);
    // Perfectly correlated errors: along the correlation finite, across it impossible.
    let mut correlated = covariance(0.001, 0.01);
    correlated[(0, 2)] = 1e-6;
    correlated[(2, 0)] = 1e-6;
    let at = |x: f64, z: f64| {
        let point_m = Vec3::new(2.0 + x, 0.0, z);
        nees(
            &Line3 {
                point_m,
                direction: Vec3::y(),
            },
            &correlated,
            &truth,
        )
    };
    assert!((at(0.002, 0.002).value - 4.0).abs() < 1e-9);
    assert_eq!(at(0.002, 0.002).dof, 3);
    assert_eq!(at(0.002, -0.002).value, f64::INFINITY);
    // Not a covariance at all.
    assert_eq!(
        nees(&estimate, &(covariance(0.001, 0.01) * f64::NAN), &truth).value,
        f64::INFINITY
    );
}

/// The covariance seen from a turned frame.
fn rotated(covariance: &AxisCovariance, rotation: &Mat3) -> AxisCovariance {
    let mut both = Matrix6::zeros();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(rotation);
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(rotation);
    both * covariance * both.transpose()
}

fn vector(scale: f64) -> impl Strategy<Value = Vec3> {
    (-scale..scale, -scale..scale, -scale..scale).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    #![proptest_config(Config {
        cases: 400,
        rng_seed: RngSeed::Fixed(0x6265_6e63),
        failure_persistence: None,
        ..Config::default()
    })]

    #[test]
    fn errors_do_not_depend_on_the_frame_or_on_signs(
        direction in vector(1.0), off in vector(0.05), tilt in vector(0.1), grasp in vector(0.05),
        (roll, pitch, yaw) in (-3.0..3.0_f64, -1.5..1.5_f64, -3.0..3.0_f64), shift in vector(5.0),
        factors in prop::array::uniform6(prop::array::uniform6(-1.0..1.0_f64)),
        flip_estimate in any::<bool>(), flip_truth in any::<bool>(),
    ) {
        prop_assume!(direction.norm() > 0.2);
        let truth = TruthAxis {
            axis: Line3::new(Vec3::new(2.0, -0.3, 0.4), &direction),
            grasp_m: Vec3::new(2.0, -0.3, 0.4) + direction.normalize() * 0.3,
            ..truth()
        };
        let square = Matrix6::from_fn(|i, j| 0.01 * factors[i][j]);
        let estimate = Located {
            axis: Line3::new(truth.axis.point_m + off, &(truth.axis.direction + tilt)),
            covariance: Some(square * square.transpose() + Matrix6::identity() * 1e-6),
            radius_m: Some(0.06),
            grasp_m: Some(truth.grasp_m + grasp),
        };
        let motion = Pose::<RigFrame, RigFrame>::new(rotation_from_rpy(roll, pitch, yaw), shift);
        let moved_line = |line: &Line3, flip: bool| {
            let d = motion.direction(&line.direction);
            Line3 { point_m: motion.point(&line.point_m), direction: if flip { -d } else { d } }
        };
        let moved_truth = TruthAxis {
            axis: moved_line(&truth.axis, flip_truth),
            grasp_m: motion.point(&truth.grasp_m),
            // The span is counted along the axis.
            visible_span_m: if flip_truth {
                truth.visible_span_m.map(|s| -s)
            } else {
                truth.visible_span_m
            },
            depth_direction: motion.direction(&truth.depth_direction),
            ..truth
        };
        // Turning the direction turns its covariance with the point.
        let mut covariance = rotated(&estimate.covariance.unwrap(), motion.rotation());
        if flip_estimate {
            for i in 0..3 {
                for j in 3..6 {
                    covariance[(i, j)] = -covariance[(i, j)];
                    covariance[(j, i)] = -covariance[(j, i)];
                }
            }
        }
        let moved = Located {
            axis: moved_line(&estimate.axis, flip_estimate),
            covariance: Some(covariance),
            grasp_m: Some(motion.point(&estimate.grasp_m.unwrap())),
            ..estimate
        };
        let (a, b) = (Errors::of(&estimate, &truth), Errors::of(&moved, &moved_truth));
        for (name, x, y) in [
            ("angle", a.axis_angle_rad, b.axis_angle_rad),
            ("offset", a.axis_offset_m, b.axis_offset_m),
            ("span", a.max_span_distance_m, b.max_span_distance_m),
            ("depth", a.depth_m, b.depth_m),
            ("across", a.grasp.unwrap().across_m, b.grasp.unwrap().across_m),
            ("along", a.grasp.unwrap().along_m, b.grasp.unwrap().along_m),
            ("radius", a.radius_m.unwrap(), b.radius_m.unwrap()),
        ] {
            prop_assert!((x - y).abs() < 1e-12, "{name}: {x} and {y}");
        }
        let (x, y) = (a.nees.unwrap(), b.nees.unwrap());
        prop_assert_eq!((x.dof, y.dof), (4, 4));
        prop_assert!((x.value - y.value).abs() < 1e-6 * x.value, "{x:?} {y:?}");
    }

    #[test]
    fn span_distance_is_the_largest_of_all_its_points(
        off in vector(0.1), tilt in vector(0.5), low in -1.0..0.0_f64, length in 0.0..2.0_f64,
    ) {
        let truth = truth().axis;
        let estimate = Line3::new(truth.point_m + off, &(truth.direction + tilt));
        let largest = max_span_distance_m(&estimate, &truth, [low, low + length]);
        for k in 0..=50 {
            let along = low + length * f64::from(k) / 50.0;
            let here = estimate.distance_m(&(truth.point_m + truth.direction * along));
            prop_assert!(here <= largest + 1e-12);
        }
    }
}
