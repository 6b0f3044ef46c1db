//! What is asked of the methods, what they answer and what draws scenes by seed: shared by pairs that are painted and pairs that are
//! rendered.
#![allow(dead_code, reason = "each program uses a part")]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the programs`"
)]

pub(crate) mod answer;
pub(crate) mod dice;

use std::error::Error;

use rodsight_geometry::{Camera, Pixel, StereoPair};
use rodsight_solver::{CalibrationSigma, Pick, RadiusPrior, Request, Roi};

/// What a thread may hand on.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// A region that the founding paper's chain is used with, px.
pub(crate) const REGION_PX: [u32; 2] = [640, 700];

/// What is asked, but for the images.
pub(crate) struct Asked {
    pub(crate) regions: [Option<Roi>; 2],
    pub(crate) pick: Option<Pick>,
    pub(crate) radius: Option<RadiusPrior>,
    pub(crate) calibration: Option<CalibrationSigma>,
}

impl Asked {
    pub(crate) fn of<'a>(&self, pair: &'a StereoPair) -> Request<'a> {
        Request {
            roi_left: self.regions[0],
            roi_right: self.regions[1],
            pick: self.pick,
            radius: self.radius,
            calibration: self.calibration,
            ..Request::new(pair)
        }
    }
}

/// A region of a size around a pixel, moved into the image where it would reach beyond.
pub(crate) fn region(camera: &Camera, at: &Pixel, [width_px, height_px]: [u32; 2]) -> Roi {
    let i = camera.intrinsics();
    let first = |at: f64, length: u32, all: u32| {
        (at - 0.5 * f64::from(length)).clamp(0.0, f64::from(all - length)) as u32
    };
    Roi {
        x_px: first(at.x, width_px, i.width_px),
        y_px: first(at.y, height_px, i.height_px),
        width_px,
        height_px,
    }
}
