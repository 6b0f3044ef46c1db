//! A scene that can still be changed.

use std::path::Path;

use rodsight_geometry::{Eye, Pixel, Rig, RigFile, Vec3, radians};
use rodsight_scene::{EmvaEntry, Scene, SceneFile, SeabedEntry, SensorEntry};
use rodsight_solver::{Pick, Roi};

use super::looks;
use crate::asked::dice::{Dice, Random};
use crate::asked::{Asked, REGION_PX, region};

const BASE: &str = include_str!("base.toml");
const PAPER_RIG: &str = include_str!("../../../../../scenes/rigs/paper.toml");

/// Of the fields below, the ones that differ from scene to scene are drawn.
pub(crate) struct Draft {
    pub(crate) file: SceneFile,
    /// The rig as the solver is told; none: as it is.
    pub(crate) believed: Option<Rig>,
    /// How far the regions lie off the rod, px.
    region_off_px: [Pixel; 2],
}

/// A scene and what is asked of it.
pub(crate) struct Trial {
    /// With whole images.
    pub(crate) scene: Scene,
    pub(crate) asked: Asked,
    /// The rig as the solver is told.
    pub(crate) believed: Rig,
    /// What is rendered of both images, and what the methods search.
    pub(crate) regions: [Roi; 2],
}

pub(crate) fn parse_rig(text: &str, name: &str) -> RigFile {
    RigFile::parse(text, Path::new(name)).expect("a rig file that is shipped")
}

impl Draft {
    /// A plain rod before lamps outboard, in clear to middling water.
    pub(crate) fn new(seed: u64) -> Self {
        let mut dice = Dice(Random::new(seed.wrapping_mul(0xA24B_AED4) ^ 0x0DDB_1A5E));
        let mut file = SceneFile::from_toml(BASE, Path::new("base.toml")).expect("a scene file");
        file.seed = seed;
        file.rig = Some(parse_rig(PAPER_RIG, "rigs/paper.toml"));
        let at_m = [
            dice.within(1.5, 3.5),
            dice.within(-0.2, 0.2),
            dice.within(-1.2, -0.8),
        ];
        let rod = &mut file.rod[0];
        rod.centre_m = Some(at_m);
        let (roll_sin, roll_cos) = libm::sincos(radians(dice.within(-60.0, 60.0)));
        let (tilt_sin, tilt_cos) = libm::sincos(radians(dice.within(-35.0, 35.0)));
        rod.direction = Some([tilt_sin, tilt_cos * roll_sin, tilt_cos * roll_cos]);
        rod.radius_m = dice.log_within(0.02, 0.08);
        rod.length_m = Some(dice.within(1.5, 4.0));
        rod.albedo = Some(dice.colour());
        if dice.one_of(&[true, false]) {
            file.seabed = Some(SeabedEntry {
                z_m: dice.within(-0.3, 0.5),
                albedo: [0.42, 0.36, 0.26],
                texture_contrast: 0.25,
                texture_scale_m: 0.15,
                ripples: None,
                clutter: None,
            });
        }
        if dice.one_of(&[true, false]) {
            let dim = dice.log_within(1e-4, 1e-2);
            file.ambient_radiance_w_per_m2_sr = [0.3 * dim, dim, dim];
        }
        file.lens.psf_sigma_px = dice.within(0.3, 0.8);
        file.sensor = SensorEntry::Emva(EmvaEntry {
            full_well_e: dice.log_within(3000.0, 12_000.0),
            ..EmvaEntry::default()
        });
        let mut off = || Pixel::new(dice.within(-60.0, 60.0), dice.within(-60.0, 60.0));
        let region_off_px = [off(), off()];
        let mut draft = Self {
            file,
            believed: None,
            region_off_px,
        };
        looks::water(&mut draft, dice.one_of(&["IB", "II", "III"]));
        looks::lamps(&mut draft, "outboard");
        draft
    }

    /// Dice for one aspect: what is drawn for it does not depend on what else is changed.
    pub(crate) fn dice(&self, aspect: u64) -> Dice {
        Dice(Random::new(self.file.seed ^ (aspect << 32) ^ 0x7F4A_7C15))
    }

    /// The middle of the rod, which is to be grasped, m.
    pub(crate) fn grasp_m(&self) -> Vec3 {
        self.file.rod[0].centre_m.map_or(Vec3::zeros(), Vec3::from)
    }

    /// The scene with regions and pick; `None` where the rod is not in both images, or something is where it cannot be.
    pub(crate) fn finish(self) -> Option<Trial> {
        let scene = self.file.to_scene(Path::new("drawn")).ok()?;
        let seen = Eye::BOTH.map(|eye| {
            let mounted = scene.rig.eye(eye);
            let at = mounted.project(&self.grasp_m())?;
            mounted.camera.contains(&at).then_some(at)
        });
        let [left, right] = [seen[0]?, seen[1]?];
        let around = |eye: Eye, at: Pixel| {
            let off = self.region_off_px[eye as usize];
            region(&scene.rig.eye(eye).camera, &(at + off), REGION_PX)
        };
        let regions = [around(Eye::Left, left), around(Eye::Right, right)];
        Some(Trial {
            asked: Asked {
                regions: regions.map(Some),
                pick: Some(Pick {
                    pixel: left,
                    eye: Eye::Left,
                }),
                radius: None,
                calibration: None,
            },
            believed: self.believed.unwrap_or(scene.rig),
            regions,
            scene,
        })
    }
}
