//! How accurate the methods are as one variable changes and everything else is drawn by seed as the kind `clean` of `trials` is: the
//! same seeds at each value, so that values are compared pair by pair.
//!
//! `cargo run --release -p rodsight-bench --example sweeps -- [-n COUNT] [-o DIR] [--redraw] [NAME…]`
//!
//! Of each sweep, `NAME.csv` holds every outcome and `NAME.svg` the picture; a table goes to the standard output. `--redraw` reads the
//! CSV instead of solving again.
//!
//! Cameras behind flat ports are left out: the painter knows none.

#![expect(clippy::print_stdout, reason = "it is what it is for")]

#[path = "../chart/mod.rs"]
mod chart;
mod list;
#[path = "../painted/mod.rs"]
mod painted;
mod picture;
mod rows;
mod scenes;
mod summary;
mod table;
mod targets;

use std::error::Error;
use std::path::PathBuf;

use list::SWEEPS;
use summary::Summary;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut count, mut dir, mut solves, mut names) = (30, PathBuf::from("."), true, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "-n" => count = words.next().ok_or("-n asks for a number")?.parse()?,
            "-o" => dir = words.next().ok_or("-o asks for a folder")?.into(),
            "--redraw" => solves = false,
            _ if SWEEPS.iter().any(|sweep| sweep.name == word) => names.push(word),
            _ => {
                let known: Vec<&str> = SWEEPS.iter().map(|sweep| sweep.name).collect();
                return Err(format!("expected one of {}, found `{word}`", known.join(", ")).into());
            }
        }
    }
    std::fs::create_dir_all(&dir)?;
    for sweep in SWEEPS {
        if !names.is_empty() && !names.iter().any(|name| name == sweep.name) {
            continue;
        }
        let file = dir.join(format!("{}.csv", sweep.name));
        if solves {
            rows::write(&file, &scenes::solve_all(sweep, count)?)?;
        }
        let summaries = Summary::of(sweep, &rows::read(&file)?);
        println!("{}", table::markdown(sweep, &summaries));
        picture::draw(&dir.join(format!("{}.svg", sweep.name)), sweep, &summaries)?;
    }
    Ok(())
}
