//! Memory over many frames: `cargo run --release -p rodsight-benches --example memory -- [FRAMES]`.
//!
//! Renders the founding scene at 320 × 180 over and over on each backend and prints what the process holds resident. It should not grow
//! once the first frames have filled the caches. Reads `/proc`, so it runs on Linux only.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use std::path::Path;
use std::process::ExitCode;

use rodsight_geometry::{Camera, Intrinsics};
use rodsight_render::{AdapterChoice, CpuRenderer, GpuRenderer, Renderer};
use rodsight_scene::Scene;

/// Growth over the second half of the frames that is no leak: allocators keep what they like.
const FLAT_MIB: f64 = 4.0;

fn main() -> ExitCode {
    let frames = std::env::args().nth(1).map_or(Ok(200), |text| text.parse());
    let Ok(frames @ 4..) = frames else {
        eprintln!("expected a number of frames, at least 4");
        return ExitCode::from(2);
    };
    match run(frames) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether memory stayed flat on every backend there is.
fn run(frames: u32) -> Result<bool, Box<dyn std::error::Error>> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut scene = Scene::load(&scenes.join("paper.toml"))?;
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let i = *mounted.camera.intrinsics();
        let small = Intrinsics {
            width_px: i.width_px / 6,
            height_px: i.height_px / 6,
            fx_px: i.fx_px / 6.0,
            fy_px: i.fy_px / 6.0,
            cx_px: i.cx_px / 6.0,
            cy_px: i.cy_px / 6.0,
        };
        mounted.camera = Camera::new(small, *mounted.camera.distortion())?;
    }
    let mut backends: Vec<Box<dyn Renderer>> = vec![Box::new(CpuRenderer)];
    match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(gpu) => backends.push(Box::new(gpu)),
        Err(error) => println!("gpu left out: {error}"),
    }
    let mut is_flat = true;
    for backend in backends {
        println!("{}: {}", backend.backend(), backend.adapter());
        let mut half_way_mib = 0.0;
        for frame in 1..=frames {
            scene.seed = u64::from(frame);
            backend.render(&scene, &|_| ())?;
            if frame % (frames / 4) == 0 || frame == 1 {
                println!("  after {frame:4} frames: {:7.1} MiB", resident_mib()?);
            }
            if frame == frames / 2 {
                half_way_mib = resident_mib()?;
            }
        }
        let growth_mib = resident_mib()? - half_way_mib;
        println!("  second half: {growth_mib:+.1} MiB");
        is_flat &= growth_mib < FLAT_MIB;
    }
    Ok(is_flat)
}

fn resident_mib() -> Result<f64, Box<dyn std::error::Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next());
    Ok(kib.ok_or("no VmRSS in /proc/self/status")?.parse::<f64>()? / 1024.0)
}
