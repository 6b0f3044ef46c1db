//! The printed tables, the equations on them, and what of the print does not follow.

use rodsight_geometry::{
    Cylinder, ImageLine, LineFit, MountedCamera, Pixel, Side, TangentPair, TangentPlane, degrees,
};

use crate::{
    TOLERANCE, axis_of, close, close_line, close3, golden, limbs, paper_normal, paper_rig,
    recomputed, table4,
};

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
