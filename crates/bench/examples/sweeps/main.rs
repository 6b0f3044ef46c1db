//! How accurate the methods are as one variable changes and everything else is drawn by seed as the kind `clean` of `trials` is: the
//! same seeds at each value, so that values are compared pair by pair.
//!
//! `cargo run --release -p rodsight-bench --example sweeps -- [-n COUNT] [-o DIR] [--redraw] [NAME…]`
//!
//! Of each sweep, `NAME.csv` holds every outcome and `NAME.svg` the picture; a table goes to the standard output. `--redraw` reads the
//! CSV instead of solving again.
//!
//! The pairs are painted; `rendered` sweeps what only the renderer knows: waters, ports, surfaces.

#![expect(clippy::print_stdout, reason = "it is what it is for")]

#[path = "../asked/mod.rs"]
mod asked;
#[path = "../chart/mod.rs"]
mod chart;
mod list;
#[path = "../painted/mod.rs"]
mod painted;
mod scenes;
#[path = "../swept/mod.rs"]
mod swept;
mod targets;

use std::error::Error;

use list::SWEEPS;
use swept::Orders;

fn main() -> Result<(), Box<dyn Error>> {
    let known: Vec<&str> = SWEEPS.iter().map(|sweep| sweep.variable.name).collect();
    let orders = Orders::read(30, &known)?;
    for sweep in SWEEPS {
        let variable = &sweep.variable;
        if orders.ask_for(variable.name) {
            let rows = orders.rows(variable.name, |count| scenes::solve_all(sweep, count))?;
            println!("{}", orders.report(variable, &rows)?);
        }
    }
    Ok(())
}
