//! What `rodsight solve --json` prints, of a pair that was solved before in the same process:
//! `cargo run --release -p rodsight-benches --example solve_warm -- PAIR METHOD U,V [X,Y,W,H X,Y,W,H]`, the regions left and right.
//!
//! The command solves once, and pays for memory that is touched for the first time and code that no branch predictor knows yet. A vehicle's
//! next frame does not, nor do others' times that are taken in a loop: `peers/locate.py` compares this one with them.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use rodsight_geometry::{Eye, Pixel, Rig, StereoPair};
use rodsight_render::read_image;
use rodsight_solver::{PaperParams, Pick, Request, Roi, Status, solve};

/// Solved so many times before the one that counts.
const WARM_UP: usize = 3;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match &arguments[..] {
        [pair, method, pick] => run(pair, method, pick, None),
        [pair, method, pick, left, right] => run(pair, method, pick, Some([left, right])),
        _ => {
            eprintln!("expected PAIR METHOD U,V [X,Y,W,H X,Y,W,H]");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(
    folder: &str,
    method: &str,
    pick: &str,
    regions: Option<[&str; 2]>,
) -> Result<(), Box<dyn Error>> {
    let folder = Path::new(folder);
    let pair = StereoPair::new(
        Rig::load(&folder.join("rig.toml"))?,
        read_image(&folder.join("left.png"))?,
        read_image(&folder.join("right.png"))?,
    )?;
    let mut request = Request::new(&pair);
    let [u_px, v_px] = numbers(pick)?;
    request.pick = Some(Pick {
        pixel: Pixel::new(u_px, v_px),
        eye: Eye::Left,
    });
    if let Some([left, right]) = regions {
        request.roi_left = Some(region(left)?);
        request.roi_right = Some(region(right)?);
    }
    let (method, params) = (method.parse()?, PaperParams::default());
    for _ in 0..WARM_UP {
        solve(&request, method, &params)?;
    }
    let estimate = solve(&request, method, &params)?;
    if estimate.status == Status::Refused {
        return Err(estimate.reason.unwrap_or_default().into());
    }
    println!("{}", serde_json::to_string(&estimate)?);
    Ok(())
}

fn region(text: &str) -> Result<Roi, Box<dyn Error>> {
    let [x_px, y_px, width_px, height_px] = numbers(text)?;
    Ok(Roi {
        x_px,
        y_px,
        width_px,
        height_px,
    })
}

fn numbers<T: core::str::FromStr, const N: usize>(text: &str) -> Result<[T; N], Box<dyn Error>> {
    let numbers: Option<Vec<T>> = text.split(',').map(|part| part.parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers, found `{text}`").into())
}
