//! Painted pairs drawn by seed, and what became of them: shared by `trials`, `sweeps` and a test.
//!
//! The painter is that of the solver's tests, not the renderer: other code, other shading, other anti-aliasing.
#![allow(dead_code, reason = "each program uses a part")]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the programs`"
)]

#[path = "../../../solver/tests/common/mod.rs"]
pub(crate) mod painter;

pub(crate) mod draft;
pub(crate) mod kinds;
pub(crate) mod limbs;
