//! How long Canny and Hough of the `imageproc` crate take, on one thread, for `peers/locate.py`:
//! `cargo run --release -p rodsight-benches --example imageproc_chain -- LOW HIGH VOTES IMAGE…`.
//!
//! A row for each grey image: Canny's time and Hough's, ms, after a run that is not timed, and the lines that were found, each ρ,θ in px and degrees.
//! Its Canny blurs by itself (σ 1.4 px) and takes the Euclidean norm of gradients; its Hough counts in cells of 1 px by 1°.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use imageproc::edges::canny;
use imageproc::hough::{LineDetectionOptions, detect_lines};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [low, high, votes, images @ ..] = &arguments[..] else {
        eprintln!("expected LOW HIGH VOTES IMAGE…");
        return ExitCode::from(2);
    };
    match run([low, high], votes, images) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run([low, high]: [&str; 2], votes: &str, images: &[String]) -> Result<(), Box<dyn Error>> {
    let (low, high) = (low.parse()?, high.parse()?);
    let options = LineDetectionOptions {
        vote_threshold: votes.parse()?,
        suppression_radius: 1,
    };
    for path in images {
        let image = image::open(path)?.into_luma8();
        detect_lines(&canny(&image, low, high), options);
        let start = Instant::now();
        let edges = canny(&image, low, high);
        let canny_ms = start.elapsed().as_secs_f64() * 1e3;
        let start = Instant::now();
        let lines = detect_lines(&edges, options);
        let hough_ms = start.elapsed().as_secs_f64() * 1e3;
        print!("{canny_ms} {hough_ms}");
        for line in lines {
            print!(" {},{}", line.r, line.angle_in_degrees);
        }
        println!();
    }
    Ok(())
}
