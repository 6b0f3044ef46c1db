//! Scene files to validated scenes.

mod model;

pub use model::{
    Bend, EdgeSampling, Emva, Exposure, Lamp, Material, Mode, Rod, Sampling, Scene, Seabed, Sensor,
    Target,
};
