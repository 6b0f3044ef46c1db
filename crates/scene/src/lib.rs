//! Scene files to validated scenes.
//!
//! A scene file is TOML; its format is [`SceneFile`], which is nothing but what was typed. [`SceneFile::to_scene`] checks
//! every number and gives a [`Scene`], the only thing a renderer takes. [`SceneFile::from_scene`] goes back, so that the
//! resolved scene can be written beside its images.
//!
//! ```no_run
//! use rodsight_scene::Scene;
//!
//! let scene = Scene::load("scenes/paper.toml".as_ref())?;
//! assert_eq!(scene.rods[scene.target.rod].id, "cable");
//! # Ok::<(), rodsight_scene::SceneError>(())
//! ```
//!
//! This crate draws nothing and knows no images.

mod camera;
mod check;
mod content;
mod daylight;
mod error;
mod file;
mod mesh;
mod model;
mod parts;
mod placement;
mod resolve;
mod rod;
mod snow;
mod write;

pub use camera::{
    Aperture, Bayer, BayerPattern, Demosaic, ImageFormat, Lens, Motion, MotionEntry, Output,
};
pub use daylight::DaylightEntry;
pub use error::SceneError;
pub use file::{AutoExposureEntry, FournierForandEntry, HenyeyGreensteinEntry, PlainSensorEntry};
pub use file::{
    BendEntry, EdgeEntry, EmvaEntry, ExposureEntry, LampEntry, LobeEntry, PhaseEntry, RodEntry,
    SamplingEntry, SceneFile, SeabedEntry, SensorEntry, TargetEntry, WaterEntry,
};
pub use file::{BlockEntry, CapsuleEntry, ClutterEntry, FoulingEntry, GlossEntry, GrainEntry};
pub use file::{OccluderEntry, PropEntry, RipplesEntry, SphereEntry, StripesEntry, SurfaceEntry};
pub use mesh::{Mesh, MeshMaterial, MeshPart, Texture, Wrap};
pub use model::{
    Bend, EdgeSampling, Emva, Exposure, Lamp, Material, Mode, Rod, Sampling, Scene, Seabed, Sensor,
    Target,
};
pub use model::{Clutter, Finish, Fouling, Gloss, Grain, Occluder, Prop, PropFrame, Ripples};
pub use model::{Shape, Stripes};

pub use snow::Snow;

/// The JSON Schema of scene files, for editors.
pub fn scene_json_schema() -> schemars::Schema {
    schemars::schema_for!(SceneFile)
}

/// The JSON Schema of rig files, for editors.
pub fn rig_json_schema() -> schemars::Schema {
    schemars::schema_for!(rodsight_geometry::RigFile)
}
