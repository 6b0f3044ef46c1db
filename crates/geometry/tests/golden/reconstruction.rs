//! Directions, grasp points and rods, recomputed.

use rodsight_geometry::{
    Cylinder, ImageLine, Line3, MountedCamera, PaperGrasp, Pose, Rig, Vec3, angle_between, degrees,
};

use crate::{
    TOLERANCE, axis_of, close, close_line, close3, golden, misprinted_normal, paper_normal,
    paper_rig, recomputed, table4,
};

/// The printed direction and grasp point do NOT follow from the paper's own tables: no acceptance test can be made of them.
#[test]
fn printed_direction_and_grasp_point_do_not_follow_from_the_tables() {
    let golden = golden();
    let (rig, axis) = recomputed(&golden);
    let at = |key: &str| golden.f64(&format!("recomputed.consistency.{key}"));
    let printed_d = Vec3::from(golden.array("reported.d_c"));
    let printed_grasp = Vec3::from(golden.array("reported.grasp_m"));

    let printed_line = Line3::new(printed_grasp, &printed_d);
    let angle = degrees(axis.angle_to(&printed_line));
    close(angle, at("angle_reported_d_vs_recomputed_deg"), 1e-4);
    assert!(angle > 50.0);
    let distance = axis.distance_m(&printed_grasp);
    close(distance, at("distance_reported_grasp_to_line_m"), TOLERANCE);
    assert!(distance > 6.0);
    close3(
        &axis.foot(&printed_grasp),
        golden.array("recomputed.consistency.nearest_point_on_line_m"),
        TOLERANCE,
    );

    // In the images: the printed point is 250 px off both lines.
    let (left, right) = table4(&golden);
    for (eye, name, line) in [(&rig.left, "left", left), (&rig.right, "right", right)] {
        let pixel = eye.project(&printed_grasp).unwrap();
        let expected =
            golden.array::<2>(&format!("recomputed.consistency.reported_grasp_{name}_px"));
        close(pixel.x, expected[0], 1e-4);
        close(pixel.y, expected[1], 1e-4);
        close(
            line.distance_px(&pixel),
            at(&format!("{name}_line_miss_px")),
            1e-4,
        );
    }
    // And in depth: its row has a disparity four times too small.
    let k_px = rig.left.camera.intrinsics().fx_px;
    close(k_px / printed_grasp.x, at("required_disparity_px"), 1e-4);
    let row = rig.left.project(&printed_grasp).unwrap().y;
    let u = |line: &ImageLine| (line.rho_px - row * line.normal().y) / line.normal().x;
    let disparity = u(&left) - u(&right);
    close(disparity, at("table4_disparity_at_v637_px"), 1e-4);
    close(k_px / disparity, at("table4_depth_at_v637_m"), 1e-5);

    // What agrees: the point after the displacement.
    let [forward, to_left, up] = golden.array("reported.displacement_forward_left_up_m");
    close3(
        &(printed_grasp - Vec3::new(forward, -to_left, -up)),
        golden.array("reported.grasp_after_m"),
        1e-12,
    );
}

/// (17) as printed gives, up to its length, the direction the paper prints.
#[test]
fn eq17_as_printed_gives_the_printed_direction() {
    let golden = golden();
    let rig = paper_rig(&golden);
    let (left, right) = table4(&golden);
    let normal = |eye: &MountedCamera, line| {
        eye.rig_from_camera
            .direction(&misprinted_normal(&eye.camera, line))
    };
    let d = normal(&rig.left, &left).cross(&normal(&rig.right, &right));
    let of = |key: &str| golden.array::<3>(&format!("hypothesis.eq17_as_printed.{key}"));
    close3(&d, of("d_c"), 1e-8);
    let printed = Vec3::from(golden.array("reported.d_c"));
    let scaled = d * (printed.dot(&d) / d.norm_squared());
    close3(&scaled, of("d_c_scaled_to_reported"), 1e-4);
    for k in 0..3 {
        close(scaled[k], printed[k], 5e-3);
    }
    let angle = degrees(angle_between(&d, &printed));
    close(
        angle,
        golden.f64("hypothesis.eq17_as_printed.angle_to_reported_deg"),
        1e-4,
    );
}

/// (27)–(31): the grasp, and μ, ξ, η as the paper scales them: with its own `d_c`, and a pick ray of unit depth.
#[track_caller]
fn check_grasp(
    rig: &Rig,
    axis: &Line3,
    d_c: &Vec3,
    pixel: [f64; 2],
    grasp: [f64; 3],
    paper: [f64; 3],
) {
    let (origin, ray) = rig.left.ray(&pixel.into()).unwrap();
    let found = PaperGrasp::new(axis, &origin, &ray).unwrap();
    close3(&found.point_m, grasp, 2e-6);
    let depth_of_unit = 1.0 / rig.left.rig_from_camera.inverse().direction(&ray).z;
    let unit_depth_ray = ray * depth_of_unit;
    let [mu, xi, eta] = paper;
    let sign = d_c.dot(&axis.direction).signum();
    close(found.mu_m, sign * mu * d_c.norm(), 5e-6);
    close(found.xi_m, xi * unit_depth_ray.norm(), 5e-6);
    close(
        found.gap_m,
        eta.abs() * d_c.cross(&unit_depth_ray).norm(),
        5e-6,
    );
}

#[test]
fn eqs_27_to_31_give_the_recomputed_grasp_points() {
    let golden = golden();
    let (rig, axis) = recomputed(&golden);
    let d_c = Vec3::from(golden.array("recomputed.d_c"));
    let of = |key: &str| format!("recomputed.consistency.{key}");
    check_grasp(
        &rig,
        &axis,
        &d_c,
        golden.array(&of("reported_grasp_left_px")),
        golden.array(&of("grasp_from_that_pixel_m")),
        golden.array(&of("mu_xi_eta")),
    );
    let (origin, ray) = rig
        .left
        .ray(&golden.array::<2>(&of("reported_grasp_left_px")).into())
        .unwrap();
    let gap = axis.distance_to_line_m(&Line3::new(origin, &ray));
    close(gap, golden.f64(&of("ray_to_axis_distance_m")), TOLERANCE);
    // A pixel on the line itself: the ray meets the axis.
    check_grasp(
        &rig,
        &axis,
        &d_c,
        golden.array(&of("check_pixel_on_axis")),
        golden.array(&of("check_pixel_grasp_m")),
        golden.array(&of("check_pixel_mu_xi_eta")),
    );
}

#[test]
fn hypothesis_of_a_shorter_baseline_explains_the_printed_point_best() {
    let golden = golden();
    let mut rig = paper_rig(&golden);
    let half = 0.5 * golden.f64("hypothesis.baseline.baseline_m");
    for (eye, y) in [(&mut rig.left, -half), (&mut rig.right, half)] {
        let pose = eye.rig_from_camera;
        eye.rig_from_camera = Pose::new(*pose.rotation(), Vec3::new(0.0, y, pose.origin_m().z));
    }
    let (left, right) = table4(&golden);
    let axis = axis_of(&rig, &left, &right);
    let printed = Vec3::from(golden.array("reported.grasp_m"));
    close(
        axis.distance_m(&printed),
        golden.f64("hypothesis.baseline.residual_m"),
        1e-4,
    );
    close3(
        &axis.foot(&printed),
        golden.array("hypothesis.baseline.nearest_point_m"),
        1e-4,
    );
}

#[test]
fn synthetic_lines_are_seen_and_reconstructed() {
    let golden = golden();
    let rig = paper_rig(&golden);
    for case in ["reported_line", "steep_line"] {
        let of = |key: &str| format!("synthetic.{case}.{key}");
        let point_m = Vec3::from(golden.array(&of("axis_point_m")));
        let cylinder = Cylinder {
            axis: Line3::new(point_m, &golden.array(&of("axis_dir")).into()),
            radius_m: golden.f64(&of("radius_m")),
        };
        let (mut axes, mut averages, mut normals) = (Vec::new(), Vec::new(), Vec::new());
        for (eye, name) in [(&rig.left, "left"), (&rig.right, "right")] {
            let [plus, minus, axis] = cylinder
                .image_lines(&eye.camera, &eye.rig_from_camera)
                .unwrap();
            let expected: [[f64; 2]; 2] =
                [0, 1].map(|k| golden.array(&of(&format!("{name}_limbs.{k}"))));
            let plus_first =
                (plus.rho_px - expected[0][0]).abs() < (minus.rho_px - expected[0][0]).abs();
            let found = if plus_first {
                [plus, minus]
            } else {
                [minus, plus]
            };
            close_line(&found[0], expected[0], TOLERANCE);
            close_line(&found[1], expected[1], TOLERANCE);
            close_line(&axis, golden.array(&of(&format!("{name}_axis"))), TOLERANCE);
            let pixel = eye.project(&point_m).unwrap();
            let expected = golden.array::<2>(&of(&format!("{name}_grasp_px")));
            close(pixel.x, expected[0], TOLERANCE);
            close(pixel.y, expected[1], TOLERANCE);
            let (_, normal) = paper_normal(&eye.camera, &axis);
            normals.push(eye.rig_from_camera.direction(&normal));
            averages.push(ImageLine::new(
                0.5 * (plus.rho_px + minus.rho_px),
                0.5 * (plus.theta_rad + minus.theta_rad),
            ));
            axes.push(axis);
        }
        let axis = axis_of(&rig, &axes[0], &axes[1]);
        close3(&axis.direction, golden.array(&of("d_c_unit")), TOLERANCE);
        close3(&axis.point_m, golden.array(&of("p_C")), TOLERANCE);
        let d_c = normals[0].cross(&normals[1]);
        let lambda = rig.baseline().dot(&normals[1]) / d_c.norm_squared();
        close(lambda, golden.f64(&of("lambda")), TOLERANCE);
        check_grasp(
            &rig,
            &axis,
            &d_c,
            golden.array(&of("left_grasp_px")),
            golden.array(&of("grasp_m")),
            golden.array(&of("mu_xi_eta")),
        );
        // The paper averages the limbs' (ρ, θ) instead.
        let averaged = axis_of(&rig, &averages[0], &averages[1]);
        close(
            averaged.distance_m(&point_m),
            golden.f64(&of("averaging_bias_m")),
            1e-7,
        );
    }
}
