//! Which renderer renders, and why.

use rodsight_render::{
    AdapterChoice, CpuRenderer, Frame, GpuRenderer, RenderError, Renderer, expose,
};
use rodsight_scene::Scene;

use crate::args::Backend;
use crate::failure::Failure;

/// A renderer that was chosen.
pub(crate) struct Chosen {
    renderer: Box<dyn Renderer>,
    /// Why this one, as it stands behind its name.
    pub(crate) why: String,
    /// Whether another one may step in.
    is_forced: bool,
}

impl Chosen {
    /// `auto` is a graphics card if there is one; a software driver for one is slower to start than the reference and no better.
    pub(crate) fn new(backend: Backend) -> Result<Self, Failure> {
        match backend {
            Backend::Cpu => Ok(Self::cpu("asked for".to_owned(), true)),
            Backend::Gpu => Ok(Self {
                renderer: Box::new(GpuRenderer::new(AdapterChoice::HardwareOrSoftware)?),
                why: "asked for".to_owned(),
                is_forced: true,
            }),
            Backend::Auto => Ok(match GpuRenderer::new(AdapterChoice::Hardware) {
                Ok(renderer) => Self {
                    renderer: Box::new(renderer),
                    why: "the best graphics card".to_owned(),
                    is_forced: false,
                },
                Err(RenderError::NoAdapter { .. }) => {
                    Self::cpu("no graphics card found".to_owned(), false)
                }
                Err(error) => Self::cpu(error.to_string(), false),
            }),
        }
    }

    fn cpu(why: String, is_forced: bool) -> Self {
        Self {
            renderer: Box::new(CpuRenderer),
            why,
            is_forced,
        }
    }

    /// Renders; where the graphics card was our choice and the scene is too large for it, or it fails, the reference does.
    pub(crate) fn render(
        &mut self,
        scene: &Scene,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Frame, RenderError> {
        match expose(self.renderer.as_ref(), scene, progress) {
            Err(
                error @ (RenderError::AdapterLimit { .. }
                | RenderError::LoopsCut { .. }
                | RenderError::Device { .. }),
            ) if !self.is_forced => {
                *self = Self::cpu(error.to_string(), true);
                expose(self.renderer.as_ref(), scene, progress)
            }
            outcome => outcome,
        }
    }
}
