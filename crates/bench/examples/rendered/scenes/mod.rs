//! Scenes of rods drawn by seed, as scene files: what the renderer is given and what is asked of the methods.
#![allow(dead_code, reason = "a test uses a part")]
#![allow(clippy::allow_attributes, reason = "`expect` cannot say `in the test`")]

pub(crate) mod draft;
pub(crate) mod looks;
pub(crate) mod ports;
pub(crate) mod shot;
