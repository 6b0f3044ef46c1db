//! The scene file's format, `schema = 1`: what was typed, unchecked. Angles are in degrees here and nowhere else.

mod content;
mod sensor;

use std::path::PathBuf;

use rodsight_geometry::{Eye, RigFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use content::{BlockEntry, CapsuleEntry, ClutterEntry, FoulingEntry, GlossEntry, GrainEntry};
pub use content::{
    OccluderEntry, PropEntry, RipplesEntry, SphereEntry, StripesEntry, SurfaceEntry,
};
pub use sensor::{EmvaEntry, PlainSensorEntry, SensorEntry};

use crate::{DaylightEntry, Lens, Mode, MotionEntry, Output, Snow};

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A scene file. Coordinates are those of the rig: x forward, y starboard, z down; metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of this format: 1.
    pub schema: u32,
    /// Short name, used in file names: letters, digits, `_` and `-`.
    pub id: String,
    /// Seed of everything random: texture, stones, growth, snow, sensor noise.
    #[serde(default)]
    pub seed: u64,
    /// What of the water is rendered.
    pub mode: Mode,
    /// Bits per sample of the images, 8 or 16.
    #[serde(default = "default_bits")]
    pub bits: u8,
    /// Isotropic ambient radiance at the rig per band (red, green, blue); zero in the deep.
    #[serde(default, skip_serializing_if = "is_default")]
    pub ambient_radiance_w_per_m2_sr: [f64; 3],
    /// Daylight from above; none in the deep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub daylight: Option<DaylightEntry>,
    /// What is seen where there is nothing, in mode `air`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub background_radiance_w_per_m2_sr: [f64; 3],
    /// A rig file, relative to this file. Either this or `rig`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rig_file: Option<PathBuf>,
    /// The cameras, as in a rig file. Either this or `rig_file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rig: Option<RigFile>,
    /// The water; may be left out in mode `air`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water: Option<WaterEntry>,
    /// The lamps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lamp: Vec<LampEntry>,
    /// The rods.
    pub rod: Vec<RodEntry>,
    /// Simple bodies that stand in the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub occluder: Vec<OccluderEntry>,
    /// Meshes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prop: Vec<PropEntry>,
    /// The sea floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seabed: Option<SeabedEntry>,
    /// Marine snow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snow: Option<Snow>,
    /// What is to be grasped.
    pub target: TargetEntry,
    /// Radiance to digital numbers.
    #[serde(default)]
    pub exposure: ExposureEntry,
    /// Gains of the bands (red, green, blue) after the sensor, between 1 and 16: what makes the lamps' light white.
    #[serde(
        default = "no_white_balance",
        skip_serializing_if = "is_no_white_balance"
    )]
    pub white_balance: [f64; 3],
    /// From balanced bands to the display's red, green and blue: three rows, each of which sums to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour_matrix: Option<[[f64; 3]; 3]>,
    /// The lens.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lens: Lens,
    /// How the rig moves during the exposure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionEntry>,
    /// Noise of the sensor.
    #[serde(default)]
    pub sensor: SensorEntry,
    /// The image files.
    #[serde(default, skip_serializing_if = "is_default")]
    pub output: Output,
    /// How finely rays are cast.
    #[serde(default)]
    pub sampling: SamplingEntry,
}

fn no_white_balance() -> [f64; 3] {
    [1.0; 3]
}

fn is_no_white_balance(gains: &[f64; 3]) -> bool {
    *gains == no_white_balance()
}

fn default_bits() -> u8 {
    8
}

/// The water: either a `name` of the table or both coefficients.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaterEntry {
    /// A row of the table of published waters: `pure_sea`, `IB`, `II`, `III`, `1C`, `3C`, `5C`, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Absorption a at 600, 525 and 475 nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorption_per_m: Option<[f64; 3]>,
    /// Scattering b at 600, 525 and 475 nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scattering_per_m: Option<[f64; 3]>,
    /// What to call water that is given by its coefficients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Where scattered light goes; that of the named water, or `petzold3`, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<PhaseEntry>,
}

/// A phase function: a name, or a table with one key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PhaseEntry {
    /// Three lobes fitted to Petzold's harbour mean beyond 1°; the usual choice.
    Petzold3,
    /// Four lobes fitted from 0.1°.
    Petzold4,
    /// The same in all directions.
    Isotropic,
    /// `{ henyey_greenstein = { g = 0.92 } }`.
    HenyeyGreenstein(HenyeyGreensteinEntry),
    /// `{ lobes = [{ weight = 0.98, g = 0.93 }, { weight = 0.02, g = -0.5 }] }`.
    Lobes(Vec<LobeEntry>),
    /// `{ fournier_forand = { refractive_index = 1.10, junge_slope = 3.5835 } }`.
    FournierForand(FournierForandEntry),
}

/// One Henyey–Greenstein lobe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HenyeyGreensteinEntry {
    /// Mean cosine, in (−1, 1).
    pub g: f64,
}

/// A lobe of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LobeEntry {
    /// Share of the scattered light; the weights sum to 1.
    pub weight: f64,
    /// Mean cosine, in (−1, 1).
    pub g: f64,
}

/// Fournier and Forand's phase function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FournierForandEntry {
    /// Of the particles relative to water, in (1, 1.4].
    pub refractive_index: f64,
    /// Of the size distribution, in (3, 5).
    pub junge_slope: f64,
}

/// A lamp: a point with a cone. Give either `direction` or `aim_at_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LampEntry {
    /// Where it is.
    pub position_m: [f64; 3],
    /// Direction of the beam, of any length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// A point on the beam's axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aim_at_m: Option<[f64; 3]>,
    /// Radiant intensity on the beam's axis per band (red, green, blue).
    pub radiant_intensity_w_per_sr: [f64; 3],
    /// Half angle of the cone of full intensity.
    pub inner_half_angle_deg: f64,
    /// Half angle beyond which there is no light.
    pub outer_half_angle_deg: f64,
}

/// A rod, given by `from_m` and `to_m`, or by `centre_m`, `direction` and `length_m`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RodEntry {
    /// Its name, unique.
    pub id: String,
    /// One end of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_m: Option<[f64; 3]>,
    /// The other end of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_m: Option<[f64; 3]>,
    /// Middle of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_m: Option<[f64; 3]>,
    /// Direction of the axis at the middle, of any length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Length along the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Radius.
    pub radius_m: f64,
    /// Bend, if it is not straight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bend: Option<BendEntry>,
    /// Lambertian surface: albedo per band (red, green, blue), in [0, 1]. Either this or the flat radiance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub albedo: Option<[f64; 3]>,
    /// A surface that sends this radiance whatever light falls on it: for tests of edges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flat_radiance_w_per_m2_sr: Option<[f64; 3]>,
    /// What makes the surface other than evenly matt and clean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceEntry>,
}

/// A circular arc instead of a straight axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BendEntry {
    /// Height of the arc over its chord.
    pub sagitta_m: f64,
    /// The side on which the centre of the arc lies; only the part perpendicular to the axis counts.
    pub towards: [f64; 3],
}

/// A horizontal floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeabedEntry {
    /// Its z (down).
    pub z_m: f64,
    /// Mean albedo per band (red, green, blue).
    pub albedo: [f64; 3],
    /// Relative amplitude of the texture, [0, 1).
    #[serde(default)]
    pub texture_contrast: f64,
    /// Size of the coarsest grains.
    #[serde(default = "default_texture_scale_m")]
    pub texture_scale_m: f64,
    /// Ripples of the sand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ripples: Option<RipplesEntry>,
    /// Stones on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clutter: Option<ClutterEntry>,
}

fn default_texture_scale_m() -> f64 {
    0.1
}

/// What the operator points at: a rod, and a place along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetEntry {
    /// `id` of the rod.
    pub rod: String,
    /// Place of the grasp along the axis, from the middle, towards `direction` (or `to_m`); 0 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along_m: Option<f64>,
    /// Instead of `along_m`: the grasp is the point of the axis nearest to this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near_m: Option<[f64; 3]>,
    /// The image in which the operator picks.
    #[serde(default = "default_eye")]
    pub pick_eye: Eye,
}

fn default_eye() -> Eye {
    Eye::Left
}

/// How radiance becomes digital numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ExposureEntry {
    /// Full-scale fraction per W m⁻² sr⁻¹: `{ gain_m2_sr_per_w = 2.0 }`.
    #[serde(rename = "gain_m2_sr_per_w")]
    Gain(f64),
    /// A quantile of all samples of both images comes to a level: `{ auto = { quantile = 0.99, level = 0.8 } }`.
    Auto(AutoExposureEntry),
}

impl Default for ExposureEntry {
    fn default() -> Self {
        Self::Auto(AutoExposureEntry::default())
    }
}

/// Automatic exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AutoExposureEntry {
    /// In (0, 1].
    pub quantile: f64,
    /// Fraction of full scale, linear, in (0, 1].
    pub level: f64,
}

impl Default for AutoExposureEntry {
    fn default() -> Self {
        Self {
            quantile: 0.99,
            level: 0.8,
        }
    }
}

/// How finely rays are cast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SamplingEntry {
    /// Samples in a pixel at an edge.
    pub edge: EdgeEntry,
    /// Midpoints of the scattering integral per lamp and shadowed stretch of a ray that the lamp sees under half a turn; shorter ones take
    /// fewer in proportion, four at least. 16 are good for 1 %, 32 for 0.3 %.
    pub airlight_points: u32,
}

impl Default for SamplingEntry {
    fn default() -> Self {
        Self {
            edge: EdgeEntry::Fibonacci(233),
            airlight_points: 16,
        }
    }
}

/// The pattern of samples in a pixel at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EdgeEntry {
    /// A lattice of so many points, a Fibonacci number; edges are right at every angle.
    Fibonacci(u32),
    /// A regular grid of so many points per side; wrong for upright edges, kept to show that.
    Grid(u32),
}
