//! A validated scene: what the renderer is given. Every number here has been checked.
//!
//! Scene coordinates are those of the rig (vehicle): x forward, y starboard, z down.

mod content;

use rodsight_geometry::{Eye, Rig, Vec3};
use rodsight_optics::{Bands, Daylight, Medium};

pub use content::{Clutter, Finish, Fouling, Gloss, Grain, Occluder, Prop, PropFrame, Ripples};
pub use content::{Shape, Stripes};

use crate::{Bayer, Lens, Motion, Output, Snow};

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Short name, used in file names and records.
    pub id: String,
    /// Seed of everything random: texture, stones, growth, snow, sensor noise.
    pub seed: u64,
    /// The cameras.
    pub rig: Rig,
    /// What of the water is rendered.
    pub mode: Mode,
    /// Name of the water, a label only.
    pub water_label: String,
    /// The water's optical properties.
    pub medium: Medium,
    /// Isotropic ambient radiance at the rig, W m⁻² sr⁻¹; zero in the deep.
    pub ambient_radiance: Bands,
    /// Daylight, its depth counted from the rig's origin; none in the deep.
    pub daylight: Option<Daylight>,
    /// What is seen where there is nothing, in mode `air`, W m⁻² sr⁻¹.
    pub background_radiance: Bands,
    /// The lamps.
    pub lamps: Vec<Lamp>,
    /// The rods.
    pub rods: Vec<Rod>,
    /// Simple bodies that stand in the way.
    pub occluders: Vec<Occluder>,
    /// Meshes.
    pub props: Vec<Prop>,
    /// The sea floor.
    pub seabed: Option<Seabed>,
    /// Marine snow.
    pub snow: Option<Snow>,
    /// Radiance to digital numbers.
    pub exposure: Exposure,
    /// Gains of the bands after the sensor, at least 1: what makes the lamps' light white.
    pub white_balance: Bands,
    /// From balanced bands to the display's primaries, rows that sum to 1; the bands themselves if absent.
    pub colour_matrix: Option<[[f64; 3]; 3]>,
    /// The lens, alike in both cameras.
    pub lens: Lens,
    /// How the rig moves during the exposure; it stands still if absent.
    pub motion: Option<Motion>,
    /// Noise of the sensor.
    pub sensor: Sensor,
    /// Bits per sample of the images, 8 or 16.
    pub bits: u8,
    /// The image files.
    pub output: Output,
    /// How finely rays are cast.
    pub sampling: Sampling,
    /// What is to be grasped.
    pub target: Target,
}

/// What of the water is rendered.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// No water at all.
    Air,
    /// Ambient light only: I = J e^(−cz) + B∞ (1 − e^(−cz)).
    Koschmieder,
    /// Single scattering with the beam attenuation c on every leg.
    Single,
    /// Transport attenuation K on the lamps' legs and in backscatter, and a halo of what is scattered forwards on the way to the camera.
    Full,
}

/// A point lamp with a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is, m.
    pub position_m: Vec3,
    /// Unit direction of the beam.
    pub direction: Vec3,
    /// Radiant intensity on the beam's axis, W/sr.
    pub radiant_intensity_w_per_sr: Bands,
    /// Half angle of the full-intensity cone, rad.
    pub inner_half_angle_rad: f64,
    /// Half angle beyond which there is no light, rad; smoothstep in the angle's cosine between.
    pub outer_half_angle_rad: f64,
}

/// A rod: a capped cylinder, or a circular arc of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// Its name.
    pub id: String,
    /// Middle of its axis, m.
    pub centre_m: Vec3,
    /// Unit direction of its axis at the middle.
    pub direction: Vec3,
    /// Length along the axis, m.
    pub length_m: f64,
    /// Radius, m.
    pub radius_m: f64,
    /// Bend, if it is not straight.
    pub bend: Option<Bend>,
    /// Surface.
    pub material: Material,
    /// What makes it other than evenly matt.
    pub finish: Finish,
    /// What grows on it.
    pub fouling: Option<Fouling>,
}

/// A circular arc: the ends lie `sagitta_m` from the tangent at the middle, towards `towards`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Height of the arc over its chord, m.
    pub sagitta_m: f64,
    /// Unit vector perpendicular to the rod's direction: the side on which the centre of the arc lies.
    pub towards: Vec3,
}

/// A surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// Lambertian, albedo per band in [0, 1].
    Lambert(Bands),
    /// Sends this radiance whatever light falls on it, W m⁻² sr⁻¹: for tests of edges.
    Flat(Bands),
}

/// A horizontal floor with a procedural albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seabed {
    /// z of the floor, m (z is down).
    pub z_m: f64,
    /// Mean albedo per band.
    pub albedo: Bands,
    /// Relative amplitude of the texture, [0, 1).
    pub texture_contrast: f64,
    /// Size of the coarsest grains, m.
    pub texture_scale_m: f64,
    /// Waves of the sand.
    pub ripples: Option<Ripples>,
    /// Stones on it.
    pub clutter: Option<Clutter>,
}

/// How radiance becomes digital numbers: 1 = full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Full-scale fraction per W m⁻² sr⁻¹.
    Fixed(f64),
    /// The given quantile of all samples of both images comes to the given fraction of full scale (linear).
    Auto {
        /// In (0, 1].
        quantile: f64,
        /// In (0, 1].
        level: f64,
    },
}

/// The sensor's noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// Gaussian noise on the encoded image, in 8-bit digital numbers (any `bits`); 0 is none.
    Plain {
        /// Standard deviation, DN of 255.
        noise_sigma_dn: f64,
    },
    /// EMVA 1288 linear model.
    Emva(Emva),
}

/// EMVA 1288 parameters; electrons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Emva {
    pub full_well_e: f64,
    pub read_noise_e: f64,
    pub dark_e: f64,
    /// Photo-response non-uniformity, relative.
    pub prnu: f64,
    pub dsnu_e: f64,
    /// Bits of the converter; full scale = full well.
    pub adc_bits: u8,
    /// Which specimen of the sensor: its fixed pattern, whatever the scene's seed.
    pub pattern_seed: u64,
    /// Colour filters; without, each pixel has all three bands.
    pub bayer: Option<Bayer>,
}

/// How finely rays are cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Samples in a pixel at an edge.
    pub edge: EdgeSampling,
    /// Midpoints of the scattering integral per lamp and half a turn of a shadowed stretch about it, four at least.
    pub airlight_points: u32,
}

/// The pattern of samples in a pixel at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeSampling {
    /// Fibonacci lattice: uniform projections on both axes.
    Fibonacci {
        /// Number of points, a Fibonacci number.
        points: u32,
    },
    /// A regular n × n grid; wrong for upright edges, kept as the negative control of the edge test.
    Grid {
        /// Points per side.
        side: u32,
    },
}

/// What the operator would point at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Index of the rod.
    pub rod: usize,
    /// Position of the grasp along its axis from the middle, m.
    pub along_m: f64,
    /// The image in which the operator picks.
    pub pick_eye: Eye,
}
