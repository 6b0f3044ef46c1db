//! One module a command.

pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod inspect;
pub(crate) mod render;
pub(crate) mod schema;
pub(crate) mod solve;

use std::io::Write;

use anyhow::Context as _;

use crate::failure::Failure;

/// Prints a value on standard output, the only thing there.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
    text.push('\n');
    print_text(&text)
}

/// Prints text on standard output.
fn print_text(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .context("standard output")
        .map_err(Failure::Failed)
}
