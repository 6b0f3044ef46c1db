//! A scene and a request that can still be changed.

use rodsight_geometry::{Cylinder, Eye, Pixel, Pose, Rig, RigFrame, StereoPair};
use rodsight_solver::{CalibrationSigma, Method, MovedPair, Pick, RadiusPrior, SolveError};

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
        self.answer_all(seed, pair, &[], method)
    }

    pub(crate) fn answer_all(
        &self,
        seed: u64,
        pair: &StereoPair,
        more: &[MovedPair<'_>],
        method: Method,
    ) -> Result<Answer, SolveError> {
        let target = self.target.as_ref();
        Answer::of_all(seed, &self.request, target, (pair, more), method)
    }

    /// The images, with the rig as the solver is told.
    pub(crate) fn pair(&self) -> StereoPair {
        StereoPair {
            rig: self.believed,
            ..self.scene.pair()
        }
    }

    /// The images from where the rig went, with other noise, and regions as large around the rod; `None` where it is not in both.
    pub(crate) fn moved(&self, rig_from_moved: &Pose<RigFrame, RigFrame>) -> Option<Self> {
        let mut scene = self.scene.moved(rig_from_moved);
        scene.seed ^= 0x5DEE_CE66;
        let mut regions = self.request.regions;
        let target = self.target.map(|target| target.axis.point_m);
        for (eye, point_m) in Eye::BOTH.into_iter().zip([target; 2]) {
            // Where there is no rod, regions stay.
            let Some(point_m) = point_m else {
                continue;
            };
            let point_m = rig_from_moved.inverse().point(&point_m);
            let mounted = scene.rig.eye(eye);
            let at = mounted.project(&point_m)?;
            if !mounted.camera.contains(&at) {
                return None;
            }
            let region = &mut regions[eye as usize];
            let camera = &mounted.camera;
            *region = region.map(|roi| self::region(camera, &at, [roi.width_px, roi.height_px]));
        }
        scene.only = regions;
        Some(Self {
            request: Asked {
                regions,
                pick: None,
                ..self.request
            },
            scene,
            ..*self
        })
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
