//! A scene and a request that can still be changed.

use rodsight_geometry::{Cylinder, Eye, Pixel, Rig, StereoPair};
use rodsight_solver::{CalibrationSigma, Method, Pick, RadiusPrior, SolveError};

use super::painter::Scene;
use crate::asked::answer::Answer;
use crate::asked::dice::Dice;
use crate::asked::{Asked, REGION_PX, region};

/// A scene and what is asked of it.
pub(crate) struct Trial {
    pub(crate) scene: Scene,
    pub(crate) request: Asked,
    /// The rig as the solver is told.
    pub(crate) believed: Rig,
    /// The rod, if there is one.
    pub(crate) target: Option<Cylinder>,
}

impl Trial {
    pub(crate) fn answer(
        &self,
        seed: u64,
        pair: &StereoPair,
        method: Method,
    ) -> Result<Answer, SolveError> {
        Answer::of(seed, &self.request, self.target.as_ref(), pair, method)
    }

    /// The images, with the rig as the solver is told.
    pub(crate) fn pair(&self) -> StereoPair {
        StereoPair {
            rig: self.believed,
            ..self.scene.pair()
        }
    }
}

/// A scene before regions and pick are put on its first rod.
pub(crate) struct Draft {
    pub(crate) scene: Scene,
    /// The rig as the solver is told.
    pub(crate) believed: Rig,
    pub(crate) radius: Option<RadiusPrior>,
    pub(crate) calibration: Option<CalibrationSigma>,
    /// Whether the rod is painted.
    pub(crate) is_there: bool,
    /// In which eye it is picked.
    pub(crate) pick: Option<Eye>,
    /// Size of the regions, px; none: whole images.
    pub(crate) region_px: Option<[u32; 2]>,
    /// How far the regions lie off the rod, px; none: drawn.
    pub(crate) region_off_px: [Option<Pixel>; 2],
    /// What draws on.
    pub(crate) dice: Dice,
}

impl Draft {
    pub(crate) fn new(scene: Scene, dice: Dice) -> Self {
        Self {
            believed: scene.rig,
            scene,
            radius: None,
            calibration: None,
            is_there: true,
            pick: Some(Eye::Left),
            region_px: Some(REGION_PX),
            region_off_px: [None; 2],
            dice,
        }
    }

    /// Where the rod's middle is seen, px; `None` where it is not in both images.
    pub(crate) fn seen_at(&self) -> Option<[Pixel; 2]> {
        let point_m = self.scene.rods.first()?.axis.point_m;
        let [left, right] = Eye::BOTH.map(|eye| {
            let mounted = self.scene.rig.eye(eye);
            let pixel = mounted.project(&point_m)?;
            mounted.camera.contains(&pixel).then_some(pixel)
        });
        Some([left?, right?])
    }

    /// The scene with regions and pick; `None` where the rod is not in both images.
    pub(crate) fn finish(mut self) -> Option<Trial> {
        let target = *self.scene.rods.first()?;
        let seen = self.seen_at()?;
        if !self.is_there {
            self.scene.rods.clear();
        }
        let mut regions = [None; 2];
        if let Some(size_px) = self.region_px {
            for eye in Eye::BOTH {
                let drawn =
                    Pixel::new(self.dice.within(-60.0, 60.0), self.dice.within(-60.0, 60.0));
                let at = seen[eye as usize] + self.region_off_px[eye as usize].unwrap_or(drawn);
                let camera = &self.scene.rig.eye(eye).camera;
                regions[eye as usize] = Some(region(camera, &at, size_px));
            }
        }
        self.scene.only = regions;
        Some(Trial {
            request: Asked {
                regions,
                pick: self.pick.map(|eye| Pick {
                    pixel: seen[eye as usize],
                    eye,
                }),
                radius: self.radius,
                calibration: self.calibration,
            },
            believed: self.believed,
            target: self.is_there.then_some(target),
            scene: self.scene,
        })
    }
}
