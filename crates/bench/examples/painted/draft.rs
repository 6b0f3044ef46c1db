//! A scene and a request that can still be changed.

use rodsight_geometry::{Cylinder, Eye, Pixel, Pose, Rig, RigFrame, StereoPair, Vec3, radians};
use rodsight_solver::{CalibrationSigma, Pick, RadiusPrior, Request, Roi};

use super::painter::{Random, Scene};

/// A region that the founding paper's chain is used with, px.
const REGION_PX: [u32; 2] = [640, 700];

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
            *region = region.map(|roi| around(&scene.rig, eye, at, [roi.width_px, roi.height_px]));
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

/// The region of a size around a place, as far as the image has it.
fn around(rig: &Rig, eye: Eye, at: Pixel, [width_px, height_px]: [u32; 2]) -> Roi {
    let i = *rig.eye(eye).camera.intrinsics();
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
                let region = around(&self.scene.rig, eye, at, size_px);
                regions[eye as usize] = Some(region);
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

/// What draws by seed.
pub(crate) struct Dice(pub(crate) Random);

impl Dice {
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Small values as often as large ones.
    pub(crate) fn log_within(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.0.uniform())
    }

    pub(crate) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[((self.0.uniform() * all.len() as f64) as usize).min(all.len() - 1)]
    }

    pub(crate) fn colour(&mut self) -> [f64; 3] {
        self.one_of(&[
            [0.6, 0.3, 0.06],
            [0.5, 0.5, 0.45],
            [0.15, 0.15, 0.15],
            [0.7, 0.6, 0.05],
            [0.4, 0.05, 0.03],
            [0.05, 0.3, 0.1],
        ])
    }

    /// A lamp at so many degrees from the view's axis, aside in a direction.
    pub(crate) fn lamp(&mut self, from_deg: f64, to_deg: f64, side_rad: f64) -> Vec3 {
        let off = radians(self.within(from_deg, to_deg));
        let aside = libm::sin(off);
        Vec3::new(
            -libm::cos(off),
            aside * libm::cos(side_rad),
            aside * libm::sin(side_rad),
        ) * self.within(0.5, 1.0)
    }
}
