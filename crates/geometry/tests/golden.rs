//! The founding paper's tables, recomputed: `golden/paper.toml` holds the numbers and says where each comes from.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::path::Path;

use rodsight_geometry::{
    Camera, Cylinder, Distortion, ImageLine, Intrinsics, Line3, LineFit, MountedCamera, PaperGrasp,
    Pixel, Plane, Pose, Rig, Side, TangentPair, TangentPlane, Vec3, angle_between, degrees,
    radians, rotation_from_rpy,
};
use rodsight_testkit::Golden;

/// What the golden file was rounded to, and the task's tolerance.
const TOLERANCE: f64 = 1e-6;

fn golden() -> Golden {
    Golden::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/paper.toml"))
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "found {found}, expected {expected} ± {tolerance}"
    );
}

#[track_caller]
fn close3(found: &Vec3, expected: [f64; 3], tolerance: f64) {
    for k in 0..3 {
        assert!(
            (found[k] - expected[k]).abs() <= tolerance,
            "found {found:?}, expected {expected:?} ± {tolerance}"
        );
    }
}

/// Lines stand in the file as [ρ in px, θ in degrees].
fn line([rho_px, theta_deg]: [f64; 2]) -> ImageLine {
    ImageLine::new(rho_px, radians(theta_deg))
}

#[track_caller]
fn close_line(found: &ImageLine, [rho_px, theta_deg]: [f64; 2], tolerance: f64) {
    close(found.rho_px, rho_px, tolerance);
    close(degrees(found.theta_rad), theta_deg, tolerance);
}

/// Table 1 and section 4.1.
fn paper_rig(golden: &Golden) -> Rig {
    let (width, height) = (
        golden.f64("camera.width_px"),
        golden.f64("camera.height_px"),
    );
    let k_px = 0.5 * width / libm::tan(0.5 * radians(golden.f64("camera.hfov_deg")));
    let intrinsics = Intrinsics {
        width_px: width as u32,
        height_px: height as u32,
        fx_px: k_px,
        fy_px: k_px,
        cx_px: 0.5 * width,
        cy_px: 0.5 * height,
    };
    let mounted = |eye: &str| {
        let [roll, pitch, yaw] = golden.array(&format!("mount.{eye}_rpy_deg")).map(radians);
        let centre_m: [f64; 3] = golden.array(&format!("mount.{eye}_t_m"));
        MountedCamera {
            camera: Camera::new(intrinsics, Distortion::None).unwrap(),
            rig_from_camera: Pose::new(rotation_from_rpy(roll, pitch, yaw), centre_m.into()),
        }
    };
    Rig {
        left: mounted("left"),
        right: mounted("right"),
    }
}

/// (17) as it should be: (−`n_y`, `n_x`, 0) × (ρ̄ `n_x`, ρ̄ `n_y`, 1) = (`n_x`, `n_y`, −ρ̄), not a unit vector, with ρ̄ of (15).
fn paper_normal(camera: &Camera, line: &ImageLine) -> (f64, Vec3) {
    let (i, n) = (camera.intrinsics(), line.normal());
    let rho_bar = (line.rho_px - i.cx_px * n.x - i.cy_px * n.y) / i.fx_px;
    (rho_bar, Vec3::new(n.x, n.y, -rho_bar))
}

/// (17) with the 0 and the 1 exchanged, as it is printed.
fn misprinted_normal(camera: &Camera, line: &ImageLine) -> Vec3 {
    let (rho_bar, _) = paper_normal(camera, line);
    let n = line.normal();
    Vec3::new(-n.y, n.x, 1.0).cross(&Vec3::new(rho_bar * n.x, rho_bar * n.y, 0.0))
}

/// The 3D line of two image lines through unit normals: (18)–(25).
fn axis_of(rig: &Rig, left: &ImageLine, right: &ImageLine) -> Line3 {
    let plane = |mounted: &MountedCamera, line: &ImageLine| {
        Plane::through_camera(&mounted.rig_from_camera, &mounted.camera.plane_normal(line))
    };
    Line3::from_planes(
        &plane(&rig.left, left),
        &plane(&rig.right, right),
        &rig.left.rig_from_camera.origin_m(),
    )
    .unwrap()
}

fn table4(golden: &Golden) -> (ImageLine, ImageLine) {
    (
        line(golden.array("table4.left")),
        line(golden.array("table4.right")),
    )
}

fn recomputed(golden: &Golden) -> (Rig, Line3) {
    let rig = paper_rig(golden);
    let (left, right) = table4(golden);
    let axis = axis_of(&rig, &left, &right);
    (rig, axis)
}

/// The limbs of an eye: the two different lines among the last columns of its table.
fn limbs(golden: &Golden, table: &str) -> [ImageLine; 2] {
    let mut lines: Vec<[f64; 2]> = Vec::new();
    for row in 0..golden.len(table) {
        let found = golden.array(&format!("{table}.{row}.refined_twice"));
        if !lines.contains(&found) {
            lines.push(found);
        }
    }
    assert_eq!(lines.len(), 2, "{table} has two limbs");
    [line(lines[0]), line(lines[1])]
}

#[test]
fn camera_and_mounts_follow_from_the_printed_settings() {
    let golden = golden();
    let rig = paper_rig(&golden);
    let i = rig.left.camera.intrinsics();
    close(i.fx_px, golden.f64("camera.recomputed.k_px"), 1e-8);
    close(i.cx_px, golden.f64("camera.recomputed.u_c"), 0.0);
    close(i.cy_px, golden.f64("camera.recomputed.v_c"), 0.0);
    let vfov = 2.0 * libm::atan2(i.cy_px, i.fy_px);
    close(
        degrees(vfov),
        golden.f64("camera.recomputed.vfov_deg"),
        1e-8,
    );
    for eye in [&rig.left, &rig.right] {
        for (row, column) in (0..9).map(|k| (k / 3, k % 3)) {
            let expected = golden.f64(&format!("mount.recomputed.R_cam_to_rov.{row}.{column}"));
            close(
                eye.rig_from_camera.rotation()[(row, column)],
                expected,
                1e-15,
            );
        }
    }
    close3(
        &rig.baseline(),
        [0.0, golden.f64("mount.recomputed.baseline_m"), 0.0],
        0.0,
    );
}

#[test]
fn eq9_corrected_is_the_total_least_squares_line() {
    let golden = golden();
    let points: Vec<Pixel> = (0..golden.len("eq9.points"))
        .map(|k| golden.array::<2>(&format!("eq9.points.{k}")).into())
        .collect();
    let fit = LineFit::of(&points).unwrap();
    close(
        degrees(fit.line.theta_rad),
        golden.f64("eq9.theta_deg"),
        1e-12,
    );
    close(fit.line.rho_px, golden.f64("eq9.rho"), 1e-12);
    let across: f64 = points
        .iter()
        .map(|p| fit.line.distance_px(p))
        .map(|g| g * g)
        .sum();
    close(fit.scatter_across_px2, across, 1e-9);
}

#[test]
fn eq9_as_printed_gives_the_wrong_sign() {
    let golden = golden();
    let (s_uu, s_vv, s_uv) = (
        golden.f64("eq9.S_uu"),
        golden.f64("eq9.S_vv"),
        golden.f64("eq9.S_uv"),
    );
    // tan 2θ = 2 S_uv/(−S_uu + S_vv), as printed.
    let printed = 0.5 * libm::atan(2.0 * s_uv / (s_vv - s_uu));
    close(
        degrees(printed),
        golden.f64("eq9.theta_printed_formula_deg"),
        1e-12,
    );
    close(degrees(printed), -golden.f64("eq9.theta_deg"), 1e-12);
    // It is no line through the points at all: more than 8 px off, where the right one is within 1 px.
    let points: Vec<Pixel> = (0..golden.len("eq9.points"))
        .map(|k| golden.array::<2>(&format!("eq9.points.{k}")).into())
        .collect();
    let fit = LineFit::of(&points).unwrap();
    let worst = |line: &ImageLine| {
        points
            .iter()
            .map(|p| line.distance_px(p).abs())
            .fold(0.0, f64::max)
    };
    let normal = ImageLine::new(0.0, printed).normal();
    let printed_line = ImageLine::new(normal.dot(&fit.centroid_px), printed);
    assert!(worst(&fit.line) < 1.0, "{}", worst(&fit.line));
    assert!(worst(&printed_line) > 8.0, "{}", worst(&printed_line));
}

#[test]
fn table4_is_the_mean_of_the_refined_limbs_of_tables_2_and_3() {
    let golden = golden();
    for (table, eye) in [("table3", "left"), ("table2", "right")] {
        let [a, b] = limbs(&golden, table);
        let mean = [
            0.5 * (a.rho_px + b.rho_px),
            0.5 * (degrees(a.theta_rad) + degrees(b.theta_rad)),
        ];
        let recomputed = golden.array::<2>(&format!("table4.recomputed.{eye}_mean"));
        close(mean[0], recomputed[0], 1e-9);
        close(mean[1], recomputed[1], 1e-9);
        // Half a unit of the last printed digit.
        let printed = golden.array::<2>(&format!("table4.{eye}"));
        close(mean[0], printed[0], 0.500001e-4);
        close(mean[1], printed[1], 0.500001e-3);
        close(
            degrees(a.angle_to(&b)),
            golden.f64(&format!("table4.recomputed.limb_angle_{eye}_deg")),
            1e-9,
        );
    }
}

#[test]
fn tables_2_and_3_carry_half_a_bin_of_hough() {
    let golden = golden();
    let (step_px, step_deg) = (
        golden.f64("hough.d_rho_px"),
        golden.f64("hough.d_theta_deg"),
    );
    for table in ["table2", "table3"] {
        for row in 0..golden.len(table) {
            let [rho_px, theta_deg] = golden.array(&format!("{table}.{row}.hough"));
            assert_eq!(rho_px / step_px % 1.0, 0.5, "{table} line {row}");
            assert_eq!(theta_deg / step_deg % 1.0, 0.0, "{table} line {row}");
        }
    }
    close(golden.f64("hough.half_bin_bias_px"), 0.5 * step_px, 0.0);
}

#[test]
fn eqs_15_17_and_21_to_25_give_the_recomputed_line() {
    let golden = golden();
    let (rig, axis) = recomputed(&golden);
    let (left, right) = table4(&golden);
    let mut in_rig = Vec::new();
    for (eye, name, line) in [(&rig.left, "left", left), (&rig.right, "right", right)] {
        let (rho_bar, normal) = paper_normal(&eye.camera, &line);
        close(
            rho_bar,
            golden.f64(&format!("recomputed.rho_bar_{name}")),
            TOLERANCE,
        );
        close3(
            &normal,
            golden.array(&format!("recomputed.n_p_{name}_cam")),
            TOLERANCE,
        );
        close3(
            &eye.camera.plane_normal(&line),
            normal.normalize().into(),
            1e-15,
        );
        let turned = eye.rig_from_camera.direction(&normal);
        close3(
            &turned,
            golden.array(&format!("recomputed.n_p_{name}_rov")),
            TOLERANCE,
        );
        in_rig.push(turned);
    }
    let d = in_rig[0].cross(&in_rig[1]);
    close3(&d, golden.array("recomputed.d_c"), TOLERANCE);
    close(
        d.norm_squared(),
        golden.f64("recomputed.triple_product"),
        TOLERANCE,
    );
    // (23) in its simple form: λ = (t_R − t_L)·n_R/|d_c|², p_C = t_L + λ d_c × n_L.
    let lambda = rig.baseline().dot(&in_rig[1]) / d.norm_squared();
    close(lambda, golden.f64("recomputed.lambda"), 1e-5);
    let t_left = rig.left.rig_from_camera.origin_m();
    let p_c: [f64; 3] = golden.array("recomputed.p_C");
    close3(&(t_left + d.cross(&in_rig[0]) * lambda), p_c, TOLERANCE);
    // The crate's own way, with unit normals.
    close3(
        &axis.direction,
        golden.array("recomputed.d_c_unit"),
        TOLERANCE,
    );
    close3(&axis.point_m, p_c, TOLERANCE);
    let distance = golden.f64("recomputed.distance_left_to_line_m");
    close(axis.distance_m(&t_left), distance, TOLERANCE);
}

#[test]
fn exact_axis_is_the_bisector_of_the_tangent_planes() {
    let golden = golden();
    let rig = paper_rig(&golden);
    let mut axes = Vec::new();
    let mut sines = Vec::new();
    let mut planes = Vec::new();
    for (eye, name, table) in [
        (&rig.left, "left", "table3"),
        (&rig.right, "right", "table2"),
    ] {
        let [a, b] = limbs(&golden, table).map(|limb| eye.camera.plane_normal(&limb));
        let seen = eye.camera.ray(&between(&limbs(&golden, table))).unwrap();
        let view = TangentPair::one_view(&a, &b, &seen).unwrap();
        let axis = eye.camera.image_line(&view.axis_plane).unwrap();
        close_line(
            &axis,
            golden.array(&format!("table4.recomputed.{name}_axis_exact")),
            TOLERANCE,
        );
        let half_deg = degrees(libm::asin(view.sin_half_angle));
        close(
            half_deg,
            golden.f64(&format!("table4.recomputed.{name}_half_angle_deg")),
            TOLERANCE,
        );
        axes.push(axis);
        sines.push(view.sin_half_angle);
        let other = match view.first_side {
            Side::Plus => Side::Minus,
            Side::Minus => Side::Plus,
        };
        for (normal, side) in view.normals.into_iter().zip([view.first_side, other]) {
            planes.push(TangentPlane {
                normal: eye.rig_from_camera.direction(&normal),
                centre_m: eye.rig_from_camera.origin_m(),
                side,
            });
        }
    }
    let axis = axis_of(&rig, &axes[0], &axes[1]);
    close3(
        &axis.direction,
        golden.array("recomputed.exact_axis.d_c_unit"),
        TOLERANCE,
    );
    close3(
        &axis.point_m,
        golden.array("recomputed.exact_axis.p_C"),
        TOLERANCE,
    );
    let radius = |mounted: &MountedCamera, sin: f64| {
        axis.distance_m(&mounted.rig_from_camera.origin_m()) * sin
    };
    let (left, right) = (radius(&rig.left, sines[0]), radius(&rig.right, sines[1]));
    close(
        left,
        golden.f64("recomputed.exact_axis.radius_left_m"),
        TOLERANCE,
    );
    close(
        right,
        golden.f64("recomputed.exact_axis.radius_right_m"),
        TOLERANCE,
    );
    // The four planes are not of one rod, and the fit says so: it does not touch them.
    let fit = Cylinder::from_tangent_planes(&planes, None).unwrap();
    assert!(fit.residual_m > 1e-4, "{fit:?}");
}

/// A pixel between two limbs, at the middle row.
fn between(limbs: &[ImageLine; 2]) -> Pixel {
    let u = |line: &ImageLine| (line.rho_px - 540.0 * line.normal().y) / line.normal().x;
    Pixel::new(0.5 * (u(&limbs[0]) + u(&limbs[1])), 540.0)
}

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
