//! The `rodsight` command: arguments in, files and numbers out; the crates below do the work.

mod also;
mod args;
mod backend;
mod commands;
mod failure;
mod page;
mod picture;
mod progress;
mod table;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};

fn main() -> ExitCode {
    // Usage errors leave with 2 by clap's own hand; asking for help is no error.
    let args = Args::parse();
    failure::on_interrupt();
    let outcome = match &args.command {
        Command::Demo(args) => commands::demo::run(args),
        Command::Render(args) => commands::render::run(args),
        Command::Solve(args) => commands::solve::run(args),
        Command::Inspect(args) => commands::inspect::run(args),
        Command::Schema(args) => commands::schema::run(args),
        Command::Completions(args) => commands::completions::run(args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
