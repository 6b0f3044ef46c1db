//! Pictures: canvases, lines drawn on them, and the panels people look at.

mod canvas;
mod scene;
mod trace;

pub(crate) use canvas::{Canvas, Colour};
pub(crate) use scene::{Annotation, annotated, channel_panels, close_up};
pub(crate) use trace::{figure6, write_trace};

pub(crate) const GREEN: Colour = Colour(46, 204, 113);
pub(crate) const YELLOW: Colour = Colour(255, 214, 10);
pub(crate) const WHITE: Colour = Colour(255, 255, 255);
pub(crate) const MAGENTA: Colour = Colour(255, 45, 150);
pub(crate) const CYAN: Colour = Colour(0, 200, 255);
