//! How accurate the methods are on rendered pairs, drawn by seed: a mix of everything, and sweeps of what only the renderer knows.
//!
//! `cargo run --release -p rodsight-bench --example rendered -- [-n COUNT] [-o DIR] [--redraw] [NAME…]`
//!
//! Of `core`, the mix, and each sweep, `NAME.csv` holds every outcome; tables go to the standard output, and of each sweep `NAME.svg` is
//! the picture; scenes that `joint` is wrong and sure about are written as `NAME-VALUE-SEED.toml`. `--redraw` reads the CSV instead of rendering again. The truth is the renderer's, by formula. What is rendered of the
//! founding paper's 1920×1080 images are the regions that the methods search, 640×700 px around the grasp.

#![expect(clippy::print_stdout, reason = "it is what it is for")]

#[path = "../asked/mod.rs"]
mod asked;
#[path = "../chart/mod.rs"]
mod chart;
mod list;
mod mix;
mod scenes;
mod solve;
#[path = "../swept/mod.rs"]
mod swept;

use std::error::Error;

use list::SWEEPS;
use swept::Orders;

fn main() -> Result<(), Box<dyn Error>> {
    let sweeps = SWEEPS.iter().map(|sweep| sweep.variable.name);
    let known: Vec<&str> = std::iter::once(mix::NAME).chain(sweeps).collect();
    let orders = Orders::read(20, &known)?;
    if orders.ask_for(mix::NAME) {
        let rows = orders.rows(mix::NAME, mix::solve_all)?;
        solve::keep_wrong(&orders.dir, mix::NAME, &rows, |_, seed| {
            mix::mixed(seed).draft
        })?;
        println!("{}", mix::table(&rows));
    }
    for sweep in SWEEPS {
        let variable = &sweep.variable;
        if orders.ask_for(variable.name) {
            let rows = orders.rows(variable.name, |count| solve::solve_all(sweep, count))?;
            solve::keep_wrong(&orders.dir, variable.name, &rows, |value, seed| {
                sweep.draft(value, seed)
            })?;
            println!("{}", orders.report(variable, &rows)?);
        }
    }
    Ok(())
}
