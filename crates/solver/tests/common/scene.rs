//! What to paint.

use rodsight_geometry::{Cylinder, Eye, Line3, Pixel, Pose, Rig, RigFrame, StereoPair, Vec3};
use rodsight_solver::Roi;

use super::{ORANGE, WATER};

/// What rods are painted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    Plain,
    /// Bands of another colour around the rod, half and half.
    Bands {
        period_m: f64,
        colour: [f64; 3],
    },
    /// Patches darker by up to this share.
    Patches {
        size_m: f64,
        share: f64,
    },
}

/// A ball of one colour: snow, weed, a fish.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub centre_m: Vec3,
    pub radius_m: f64,
    pub colour: [f64; 3],
}

/// A ball as an eye sees it.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub centre_px: Pixel,
    pub radius_px: f64,
    pub range_m: f64,
    pub colour: [f64; 3],
}

/// What to paint.
#[derive(Clone, Debug)]
pub struct Scene {
    pub rig: Rig,
    pub rods: Vec<Cylinder>,
    /// Half of the length that is painted, m; measured from the axis' reference point.
    pub half_length_m: f64,
    /// How the first rod bends, 1/m, towards where the vector points.
    pub curvature_per_m: Vec3,
    pub rod_colour: [f64; 3],
    pub texture: Texture,
    pub background: [f64; 3],
    /// By how much the background brightens across and down the image, as a share.
    pub background_slope: [f64; 2],
    pub balls: Vec<Ball>,
    pub noise_sigma: f64,
    pub seed: u64,
    pub channels: u8,
    pub bits: u8,
    /// Towards far lamps, as long as they are bright: matt rods in linear light, stored as sRGB. None: rods of one flat colour.
    pub lamps: Vec<Vec3>,
    /// Light from everywhere, beside lamps.
    pub ambient: f64,
    /// Light is lost on its way to the camera, and the background takes its place, 1/m.
    pub haze_per_m: f64,
    /// Of the lens, px.
    pub blur_px: f64,
    /// Samples per pixel and axis on the silhouettes.
    pub samples: u32,
    /// What is painted of the left and the right image; the rest is background.
    pub only: [Option<Roi>; 2],
}

impl Scene {
    pub fn new(rig: &Rig, rods: Vec<Cylinder>) -> Self {
        Self {
            rig: *rig,
            rods,
            half_length_m: 50.0,
            curvature_per_m: Vec3::zeros(),
            rod_colour: ORANGE,
            texture: Texture::Plain,
            background: WATER,
            background_slope: [0.0; 2],
            balls: Vec::new(),
            noise_sigma: 0.0,
            seed: 1,
            channels: 3,
            bits: 8,
            lamps: Vec::new(),
            ambient: 0.0,
            haze_per_m: 0.0,
            blur_px: 0.0,
            samples: 8,
            only: [None; 2],
        }
    }

    pub fn pair(&self) -> StereoPair {
        StereoPair::new(self.rig, self.image(Eye::Left), self.image(Eye::Right))
            .expect("images of the rig's size")
    }

    /// The same as the rig sees it that went there; lamps go with it.
    pub fn moved(&self, rig_from_moved: &Pose<RigFrame, RigFrame>) -> Self {
        let moved_from_rig = rig_from_moved.inverse();
        let rod = |rod: &Cylinder| Cylinder {
            axis: Line3 {
                point_m: moved_from_rig.point(&rod.axis.point_m),
                direction: moved_from_rig.direction(&rod.axis.direction),
            },
            ..*rod
        };
        let ball = |ball: &Ball| Ball {
            centre_m: moved_from_rig.point(&ball.centre_m),
            ..*ball
        };
        Self {
            rods: self.rods.iter().map(rod).collect(),
            balls: self.balls.iter().map(ball).collect(),
            curvature_per_m: moved_from_rig.direction(&self.curvature_per_m),
            ..self.clone()
        }
    }

    pub(super) fn is_lit(&self) -> bool {
        self.ambient > 0.0 || !self.lamps.is_empty()
    }

    /// The balls as an eye sees them.
    pub fn discs(&self, eye: Eye) -> Vec<Disc> {
        let mounted = self.rig.eye(eye);
        let to_camera = mounted.rig_from_camera.inverse();
        self.balls
            .iter()
            .filter_map(|ball| {
                let seen = to_camera.point(&ball.centre_m);
                let centre_px = mounted.project(&ball.centre_m).filter(|_| seen.z > 0.05)?;
                Some(Disc {
                    centre_px,
                    radius_px: mounted.camera.intrinsics().fx_px * ball.radius_m / seen.z,
                    range_m: seen.norm(),
                    colour: ball.colour,
                })
            })
            .collect()
    }

    /// What is stored of light before noise and rounding, 0…1; the first `channels` of them.
    pub fn stored(&self, light: [f64; 3]) -> [f64; 3] {
        let colour = if self.is_lit() {
            light.map(encode)
        } else {
            light
        };
        if self.channels == 3 {
            colour
        } else {
            [0.25 * (colour[0] + 2.0 * colour[1] + colour[2]); 3]
        }
    }

    /// Standard deviation of what noise and rounding add to a stored value.
    pub fn stored_sigma(&self) -> f64 {
        let step = if self.bits == 8 {
            1.0 / 255.0
        } else {
            1.0 / 65535.0
        };
        libm::sqrt(self.noise_sigma * self.noise_sigma + step * step / 12.0)
    }
}

/// Linear light to sRGB (IEC 61966-2-1).
fn encode(light: f64) -> f64 {
    if light <= 0.0031308 {
        12.92 * light
    } else {
        1.055 * libm::pow(light, 1.0 / 2.4) - 0.055
    }
}
