//! The program as its users meet it: arguments and files in; files, standard output and an exit code out.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod also;
mod bad_files;
mod bad_requests;
mod bad_scenes;
mod demo;
mod foreign;
mod fuzz;
mod harness;
mod help;
mod inspect;
mod output;
mod render;
mod schema;
mod solve;
