//! Renders scene files and locates the rod by every method: by a region around the grasp, by the pick alone, by nothing.
//!
//! `cargo run --release -p rodsight-bench --example methods -- scenes/paper.toml scenes/harbour.toml`

#![expect(clippy::print_stdout, reason = "it is what it is for")]

use std::error::Error;

use rodsight_bench::{limit, measure};
use rodsight_geometry::{Eye, StereoPair, Vec3, degrees};
use rodsight_render::{CpuRenderer, Renderer, Truth, develop};
use rodsight_scene::Scene;
use rodsight_solver::{Estimate, Method, PaperParams, Pick, Request, Roi, SolveError, solve};

/// A region in which the founding paper's chain works well, px.
const REGION_PX: [u32; 2] = [640, 700];

fn main() -> Result<(), Box<dyn Error>> {
    for path in std::env::args().skip(1) {
        let scene = Scene::load(path.as_ref())?;
        let frame = CpuRenderer.render(&scene, &|_| ())?;
        let developed = develop(&frame, &scene)?;
        let truth = Truth::of(&scene, &frame, developed.gain).ok_or("the scene has no target")?;
        let pair = StereoPair::new(scene.rig, developed.left, developed.right)?;
        println!("{path}");
        if let Some(limit) = limit(&truth)? {
            println!(
                "  {:<24} {:8.4} mm {:7.4}°",
                "limit",
                1e3 * limit.axis_offset_m,
                degrees(limit.axis_angle_rad)
            );
        }
        let pick = Request {
            pick: Some(Pick {
                pixel: truth.grasp.pick_px.into(),
                eye: truth.grasp.pick_eye,
            }),
            ..Request::new(&pair)
        };
        let grasp_m = Vec3::from(truth.grasp.point_m);
        let region = Request {
            roi_left: region(&scene, Eye::Left, &grasp_m),
            roi_right: region(&scene, Eye::Right, &grasp_m),
            ..pick
        };
        let params = PaperParams::default();
        for method in Method::ALL {
            for (given, request) in [
                ("region", &region),
                ("pick", &pick),
                ("nothing", &Request::new(&pair)),
            ] {
                // The paper's chain is made for regions.
                if given == "region" || method == Method::Joint {
                    show(
                        &truth,
                        method.name(),
                        given,
                        solve(request, method, &params),
                    )?;
                }
            }
        }
    }
    Ok(())
}

/// A region around a point of the rig frame, within the image.
fn region(scene: &Scene, eye: Eye, point_m: &Vec3) -> Option<Roi> {
    let mounted = scene.rig.eye(eye);
    let i = mounted.camera.intrinsics();
    let at = mounted.project(point_m)?;
    let [width_px, height_px] = [REGION_PX[0].min(i.width_px), REGION_PX[1].min(i.height_px)];
    let first = |at: f64, length: u32, all: u32| {
        (at - 0.5 * f64::from(length)).clamp(0.0, f64::from(all - length)) as u32
    };
    Some(Roi {
        x_px: first(at.x, width_px, i.width_px),
        y_px: first(at.y, height_px, i.height_px),
        width_px,
        height_px,
    })
}

fn show(
    truth: &Truth,
    method: &str,
    given: &str,
    outcome: Result<Estimate, SolveError>,
) -> Result<(), Box<dyn Error>> {
    let name = format!("{method}, {given}");
    let estimate = match outcome {
        Ok(estimate) => estimate,
        Err(error) => {
            println!("  {name:<24} {error}");
            return Ok(());
        }
    };
    let reason = estimate.reason.as_deref().unwrap_or_default();
    let total_ms = estimate.timing_ms.total;
    let Some(errors) = measure(truth, &estimate)? else {
        println!(
            "  {name:<24} {:?} {reason} {total_ms:.0} ms",
            estimate.status
        );
        return Ok(());
    };
    println!(
        "  {name:<24} {:8.4} mm {:7.4}° radius {:+8.4} mm, NEES {:8.2}, {:?} {reason} {total_ms:.0} ms",
        1e3 * errors.axis_offset_m,
        degrees(errors.axis_angle_rad),
        1e3 * errors.radius_m.unwrap_or(f64::NAN),
        errors.nees.map_or(f64::NAN, |nees| nees.value),
        estimate.status,
    );
    Ok(())
}
