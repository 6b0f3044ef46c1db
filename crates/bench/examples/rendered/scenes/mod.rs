//! Scenes of rods drawn by seed, as scene files: what the renderer is given and what is asked of the methods.

pub(crate) mod draft;
pub(crate) mod looks;
pub(crate) mod shot;
