//! Ground-truth stereo pairs of rods under water.
//!
//! [`Renderer::render`] takes a validated [`Scene`] to a [`Frame`]: linear radiance with every truth channel, per eye.
//! [`expose`] does so as often as aperture and motion ask for, [`render_sequence`] for many scenes at a time. [`develop`] turns radiance
//! into the images a sensor would give; [`Renderer::shoot`] and [`shoot_sequence`] give images alone, sooner. [`Truth::of`] writes down what is to be found in them, and [`write_pair`] puts all of it on disk.
//!
//! Every sample is a camera ray; rods are analytic capped cylinders, never tessellated, so that a label and its image agree to
//! the last hundredth of a pixel. [`CpuRenderer`], `f64`, is the reference for [`GpuRenderer`].

mod bvh;
mod cpu;
mod develop;
mod exposure;
mod exr_file;
mod frame;
mod gpu;
mod image_file;
mod lattice;
mod lens;
mod noise;
mod pair;
mod sequence;
mod srgb;
mod strew;
mod truth;
mod whole_file;

pub use cpu::CpuRenderer;
pub use develop::{Developed, develop};
pub use exposure::expose;
pub use exr_file::read_exr;
pub use frame::{EyeFrame, Frame, PixelTruth};
pub use gpu::{AdapterChoice, GpuRenderer};
pub use image_file::{read_image, write_image, write_jpeg};
pub use lattice::edge_offsets;
pub use noise::Philox;
pub use pair::{PairPaths, write_pair};
pub use sequence::{render_sequence, shoot_sequence};
pub use srgb::{srgb_decode, srgb_encode};
pub use truth::{
    BeyondModelTruth, ConeTruth, EyeTruth, GraspTruth, LineTruth, RodTruth, Truth, WaterTruth,
};
pub use truth::{FoulingTruth, OccluderTruth, PropTruth, StonesTruth};
pub use whole_file::{discard_unfinished, write_whole};

use rodsight_scene::Scene;

/// A way to render scenes.
pub trait Renderer {
    /// Short name of the backend, as it stands in every record: "cpu", "gpu".
    fn backend(&self) -> &'static str;

    /// The machine part it runs on, as it stands in every record.
    fn adapter(&self) -> String;

    /// Renders both eyes. `progress` is told the fraction done, from any thread.
    ///
    /// # Errors
    /// What the scene asks for and this backend cannot do.
    fn render(&self, scene: &Scene, progress: &(dyn Fn(f64) + Sync)) -> Result<Frame, RenderError>;

    /// What [`expose`] and [`develop`] give, for whom images are enough. A backend may take a shorter way to them: see
    /// [`GpuRenderer`].
    ///
    /// # Errors
    /// As [`expose`] and [`develop`].
    fn shoot(
        &self,
        scene: &Scene,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Developed, RenderError> {
        develop(&expose(self, scene, progress)?, scene)
    }
}

/// Why a scene was not rendered or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum RenderError {
    #[error(
        "scene \"{scene}\": no light reaches the cameras, so no exposure can be found; set exposure.gain_m2_sr_per_w or add a lamp"
    )]
    Dark { scene: String },
    #[error(
        "scene \"{scene}\": {eye} camera: expected at most {} px to render, found {width_px}×{height_px}",
        Self::LARGEST_EYE_PX
    )]
    TooLarge {
        scene: String,
        eye: &'static str,
        width_px: u32,
        height_px: u32,
    },
    #[error(
        "no adapter: expected {wanted}, found none; install the card's driver or Mesa's software Vulkan (Debian and Ubuntu: apt install mesa-vulkan-drivers), or render with the cpu backend"
    )]
    NoAdapter { wanted: &'static str },
    #[error(
        "adapter {adapter}: {limit}: expected at least {wanted}, found {found}; render with the cpu backend"
    )]
    AdapterLimit {
        adapter: String,
        limit: String,
        wanted: u64,
        found: u64,
    },
    #[error(
        "adapter {adapter}: steps of loops: expected as many as the scene takes, found that the driver ended them before (Mesa's \
         software driver does after 65535 of an invocation); render with the cpu backend"
    )]
    LoopsCut { adapter: String },
    #[error("adapter {adapter}: {message}")]
    Device { adapter: String, message: String },
    #[error(
        "scene \"{scene}\": lens.aperture and motion: expected a blur that takes at most 2047 renders, found a motion of \
         {motion_px:.1} px and a circle of confusion of {blur_px:.1} px, which take {renders}"
    )]
    Blur {
        scene: String,
        motion_px: f64,
        blur_px: f64,
        renders: f64,
    },
    #[error(
        "scene \"{scene}\": lens.aperture: through a point of it the camera is none: {message}"
    )]
    Lens { scene: String, message: String },
    #[error("{}: {message}", path.display())]
    Io {
        path: std::path::PathBuf,
        message: String,
    },
}

impl RenderError {
    /// Every pixel with its truth takes a hundred bytes: these are seven gigabytes an eye.
    pub const LARGEST_EYE_PX: u64 = 1 << 26;

    fn refuse_too_large(scene: &Scene, eye: rodsight_geometry::Eye) -> Result<(), Self> {
        let i = scene.rig.eye(eye).camera.intrinsics();
        if u64::from(i.width_px) * u64::from(i.height_px) <= Self::LARGEST_EYE_PX {
            return Ok(());
        }
        Err(Self::TooLarge {
            scene: scene.id.clone(),
            eye: eye.name(),
            width_px: i.width_px,
            height_px: i.height_px,
        })
    }
}
