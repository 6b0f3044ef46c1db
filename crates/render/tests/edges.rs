//! The label and the image must agree: limbs measured in noise-free images against the analytic limbs.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    clippy::print_stdout,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Cylinder, Eye, ImageLine, Line3, LineFit, Pixel, Vec3, degrees, radians};
use rodsight_render::{CpuRenderer, EyeFrame, Renderer};
use rodsight_scene::{EdgeSampling, Scene};

/// Limb angles in the image, degrees from upright.
const ANGLES_DEG: [f64; 5] = [0.0, 12.0, 45.0, 89.9, 90.0];
/// Sub-pixel shifts of the rod, m at 2.3 m: about a third of a pixel each.
const SHIFTS_M: [f64; 3] = [0.0, 0.00049, 0.00098];
const OFFSET_LIMIT_PX: f64 = 0.005;
const ANGLE_LIMIT_DEG: f64 = 0.0005;

fn scene(angle_deg: f64, shift_m: f64, edge: EdgeSampling) -> Scene {
    let mut scene = common::empty(1);
    let (sin, cos) = libm::sincos(radians(angle_deg));
    // Fronto-parallel at 2.3 m: image u is rig y, image v is rig z.
    let centre = Vec3::new(2.3, 0.07 + shift_m, -1.05 + shift_m);
    scene
        .rods
        .push(common::flat_rod(centre, Vec3::new(0.0, -sin, cos), 0.05));
    scene.sampling.edge = edge;
    scene
}

/// The limb on one side, measured: on each row (or column, for lying rods) the light between the axis and the background is the
/// distance to the edge, exactly, for a flat rod before black.
fn measured_limb(frame: &EyeFrame, axis: &ImageLine, limb: &ImageLine, flat: f64) -> ImageLine {
    let upright = axis.theta_rad.abs() < radians(45.1);
    let (along_px, across_px) = if upright {
        (frame.height_px, frame.width_px)
    } else {
        (frame.width_px, frame.height_px)
    };
    let value = |along: u32, across: u32| {
        let pixel = if upright {
            frame.at(across, along)
        } else {
            frame.at(along, across)
        };
        f64::from(pixel.radiance[0]) / flat
    };
    // Position across at which a line crosses the middle of a row.
    let crossing = |line: &ImageLine, along: f64| {
        let n = line.normal();
        if upright {
            (line.rho_px - along * n.y) / n.x
        } else {
            (line.rho_px - along * n.x) / n.y
        }
    };
    let mut points = Vec::new();
    for along in 0..along_px {
        let middle = f64::from(along) + 0.5;
        let (inside, edge) = (crossing(axis, middle).floor(), crossing(limb, middle));
        let outside = (edge + (edge - inside).signum() * 10.0).floor();
        if inside < 0.0 || outside < 0.0 || inside.max(outside) >= f64::from(across_px) {
            continue;
        }
        let (from, to) = (inside.min(outside) as u32, inside.max(outside) as u32);
        let light: f64 = (from..to).map(|across| value(along, across)).sum();
        let position = if outside > inside {
            f64::from(from) + light
        } else {
            f64::from(to) - light
        };
        points.push(if upright {
            Pixel::new(position, middle)
        } else {
            Pixel::new(middle, position)
        });
    }
    assert!(
        points.len() > 500,
        "the limb is seen on {} rows only",
        points.len()
    );
    LineFit::of(&points).unwrap().line
}

/// Worst offset (px, at the middle of the image) and angle (degrees) over eyes, limbs and shifts.
fn worst_error(renderer: &dyn Renderer, angle_deg: f64, edge: EdgeSampling) -> (f64, f64) {
    let (mut offset, mut angle) = (0.0_f64, 0.0_f64);
    for shift_m in SHIFTS_M {
        let scene = scene(angle_deg, shift_m, edge);
        let rod = &scene.rods[0];
        let cylinder = Cylinder {
            axis: Line3::new(rod.centre_m, &rod.direction),
            radius_m: rod.radius_m,
        };
        let pair = renderer.render(&scene, &|_| ()).unwrap();
        for eye in Eye::BOTH {
            let mounted = scene.rig.eye(eye);
            let [plus, minus, axis] = cylinder
                .image_lines(&mounted.camera, &mounted.rig_from_camera)
                .unwrap();
            let frame = pair.eye(eye);
            for limb in [plus, minus] {
                let measured = measured_limb(frame, &axis, &limb, f64::from(0.8_f32));
                // Where the limb passes the centre of the image.
                let centre = Pixel::new(960.0, 540.0);
                let near = centre - limb.normal() * limb.distance_px(&centre);
                offset = offset.max(measured.distance_px(&near).abs());
                angle = angle.max(degrees(measured.angle_to(&limb)));
            }
        }
    }
    (offset, angle)
}

fn edges_lie_on_the_limbs(renderer: &dyn Renderer) {
    for angle_deg in ANGLES_DEG {
        let edge = EdgeSampling::Fibonacci { points: 233 };
        let (offset, angle) = worst_error(renderer, angle_deg, edge);
        let said = format!(
            "{} {angle_deg}°: {offset:.5} px, {angle:.6}°",
            renderer.backend()
        );
        println!("{said}");
        assert!(
            offset < OFFSET_LIMIT_PX && angle < ANGLE_LIMIT_DEG,
            "{said}"
        );
    }
}

#[test]
fn edges_of_flat_rods_lie_on_the_analytic_limbs_at_every_angle() {
    edges_lie_on_the_limbs(&CpuRenderer);
}

#[test]
fn edges_of_flat_rods_lie_on_the_analytic_limbs_on_the_graphics_backend_too() {
    if let Some(gpu) = common::gpu() {
        edges_lie_on_the_limbs(&gpu);
    }
}

#[test]
fn edges_sampled_on_a_regular_grid_fail_the_same_test() {
    let failed = ANGLES_DEG.iter().any(|&angle_deg| {
        let (offset, angle) = worst_error(&CpuRenderer, angle_deg, EdgeSampling::Grid { side: 8 });
        println!("{angle_deg}°, 8×8 grid: {offset:.5} px, {angle:.6}°");
        offset >= OFFSET_LIMIT_PX || angle >= ANGLE_LIMIT_DEG
    });
    assert!(
        failed,
        "the edge test cannot tell a regular grid from a lattice"
    );
}

/// A rod of 0.4 px, far away: the light of every row is that of its width, although few rays through pixel centres meet it.
#[test]
fn thin_rod_has_its_light_in_every_row() {
    thin_rod(&CpuRenderer);
    if let Some(gpu) = common::gpu() {
        thin_rod(&gpu);
    }
}

fn thin_rod(renderer: &dyn Renderer) {
    const WIDTH_PX: f64 = 0.4;
    // A row's light is counted in samples, in up to three pixels: with 233 a pixel the rod is 93 of them.
    for (angle_deg, points, limit) in [
        (0.0, 233, 0.04),
        (7.0, 233, 0.04),
        (0.0, 610, 0.02),
        (7.0, 610, 0.02),
        (30.0, 610, 0.02),
    ] {
        let mut scene = scene(angle_deg, 0.0003, EdgeSampling::Fibonacci { points });
        let distance_m = 2.3;
        scene.rods[0].radius_m = 0.5 * WIDTH_PX * distance_m / 1566.5776;
        let frame = renderer.render(&scene, &|_| ()).unwrap().left;
        let rod = &scene.rods[0];
        let cylinder = Cylinder {
            axis: Line3::new(rod.centre_m, &rod.direction),
            radius_m: rod.radius_m,
        };
        let left = &scene.rig.left;
        let [plus, minus, _] = cylinder
            .image_lines(&left.camera, &left.rig_from_camera)
            .unwrap();
        let width_px = |row: u32| {
            let at = |line: &ImageLine| {
                let n = line.normal();
                (line.rho_px - (f64::from(row) + 0.5) * n.y) / n.x
            };
            (at(&plus) - at(&minus)).abs()
        };
        let (mut worst, mut sum, mut rows) = (0.0_f64, 0.0, 0.0);
        for row in 20..frame.height_px - 20 {
            let light: f64 = (0..frame.width_px)
                .map(|column| f64::from(frame.at(column, row).radiance[0]))
                .sum();
            let width = light / f64::from(0.8_f32);
            let error = width / width_px(row) - 1.0;
            worst = worst.max(error.abs());
            (sum, rows) = (sum + error, rows + 1.0);
        }
        let mean: f64 = sum / rows;
        println!("{angle_deg}°, {points} points: worst row {worst:.4}, mean {mean:.5}");
        assert!(
            worst < limit && mean.abs() < 1e-3,
            "{angle_deg}°, {points} points: {worst}, {mean}"
        );
    }
}
