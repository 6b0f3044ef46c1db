//! Memory over many pairs: `cargo run --release -p rodsight-benches --example memory -- [PAIRS]`.
//!
//! Renders the founding scene at 320 × 180 over and over on each backend, two pairs in flight, and prints what the process holds resident. It should not grow
//! once the first pairs have filled the caches. Reads `/proc`, so it runs on Linux only.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use core::num::NonZeroUsize;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use rodsight_geometry::{Camera, Intrinsics};
use rodsight_render::{AdapterChoice, CpuRenderer, GpuRenderer, Renderer, render_sequence};
use rodsight_scene::Scene;

const IN_FLIGHT: NonZeroUsize = NonZeroUsize::new(2).unwrap();
/// Growth over the second half of the pairs that is no leak: allocators keep what they like.
const FLAT_MIB: f64 = 4.0;

fn main() -> ExitCode {
    let frames = std::env::args().nth(1).map_or(Ok(200), |text| text.parse());
    let Ok(frames @ 4..) = frames else {
        eprintln!("expected a number of pairs, at least 4");
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
fn run(frames: u64) -> Result<bool, Box<dyn Error + Send + Sync>> {
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
    let mut backends: Vec<Box<dyn Renderer + Sync>> = vec![Box::new(CpuRenderer)];
    match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(gpu) => backends.push(Box::new(gpu)),
        Err(error) => println!("gpu left out: {error}"),
    }
    let mut is_flat = true;
    for backend in backends {
        println!("{}: {}", backend.backend(), backend.adapter());
        let mut half_way_mib = 0.0;
        let numbered = |number| {
            let mut scene = scene.clone();
            scene.seed = number;
            Ok::<_, Box<dyn Error + Send + Sync>>(scene)
        };
        render_sequence(
            backend.as_ref(),
            1..frames + 1,
            IN_FLIGHT,
            numbered,
            |number, _, _| {
                if number % (frames / 4) == 0 || number == 1 {
                    println!("  after {number:4} pairs: {:7.1} MiB", resident_mib()?);
                }
                if number == frames / 2 {
                    half_way_mib = resident_mib()?;
                }
                Ok(())
            },
        )?;
        let growth_mib = resident_mib()? - half_way_mib;
        println!("  second half: {growth_mib:+.1} MiB");
        is_flat &= growth_mib < FLAT_MIB;
    }
    Ok(is_flat)
}

fn resident_mib() -> Result<f64, Box<dyn Error + Send + Sync>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next());
    Ok(kib.ok_or("no VmRSS in /proc/self/status")?.parse::<f64>()? / 1024.0)
}
