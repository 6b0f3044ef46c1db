//! `rodsight completions`.

use clap::CommandFactory;

use crate::args::{Args, CompletionsArgs};
use crate::commands::print_text;
use crate::failure::Failure;

pub(crate) fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    // Through memory: it panics where it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "rodsight", &mut script);
    print_text(&String::from_utf8_lossy(&script))
}
