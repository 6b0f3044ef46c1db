//! What must hold for every camera, line and rod: properties, on random cases with a fixed seed.

mod cameras;
mod common;
mod rods;
