//! The scene file's format, second part: surfaces of rods, occluders, props, what lies on the seabed.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[rod.surface]`: what makes a rod's surface other than evenly matt and clean. Every key may be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SurfaceEntry {
    /// Bands of a second colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stripes: Option<StripesEntry>,
    /// Grain of the albedo.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<GrainEntry>,
    /// Mirror-like share of the reflection of lamps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gloss: Option<GlossEntry>,
    /// Marine growth that stands out of the rod.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fouling: Option<FoulingEntry>,
}

/// Bands of a second albedo: rings, or helices.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StripesEntry {
    /// Distance along the rod from one band to the next; that of a helix with one start is its pitch.
    pub period_m: f64,
    /// Albedo of the bands (red, green, blue).
    pub albedo: [f64; 3],
    /// Share of the rod that they cover, in (0, 1).
    #[serde(default = "half")]
    pub share: f64,
    /// 0: rings; n: n interleaved right-handed helices, each of pitch n periods.
    #[serde(default)]
    pub starts: u32,
}

fn half() -> f64 {
    0.5
}

/// Grain of the albedo, fixed to the rod.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainEntry {
    /// Greatest relative departure from the mean albedo, in (0, 1].
    pub contrast: f64,
    /// Size of the coarsest grains.
    pub scale_m: f64,
}

/// A glossy coat: microfacets of GGX distribution over the matt surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GlossEntry {
    /// Perceptual roughness, between 0.05 and 1; the distribution's width is its square.
    pub roughness: f64,
    /// Reflectance at normal incidence, under water, per band (red, green, blue): paint 0.003, stainless steel 0.5.
    pub reflectance: [f64; 3],
}

/// Marine growth: lumps strewn over the rod by the scene's seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoulingEntry {
    /// Expected share of the rod's side that they cover, in (0, 0.95].
    pub cover: f64,
    /// Height of the highest over the rod's surface.
    pub height_m: f64,
    /// Their albedo (red, green, blue).
    pub albedo: [f64; 3],
}

/// A body that stands in the way: exactly one of `sphere`, `capsule`, `block`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OccluderEntry {
    /// Its name, unique.
    pub id: String,
    /// Lambertian albedo per band (red, green, blue).
    pub albedo: [f64; 3],
    /// A ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereEntry>,
    /// A cylinder with a half ball at each end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<CapsuleEntry>,
    /// A box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub block: Option<BlockEntry>,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "the names say it")]
pub struct SphereEntry {
    pub centre_m: [f64; 3],
    pub radius_m: f64,
}

/// A cylinder with a half ball at each end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CapsuleEntry {
    /// Centre of one half ball.
    pub from_m: [f64; 3],
    /// Centre of the other.
    pub to_m: [f64; 3],
    /// Radius.
    pub radius_m: f64,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockEntry {
    /// Its middle.
    pub centre_m: [f64; 3],
    /// Lengths of its edges along its own x, y, z.
    pub size_m: [f64; 3],
    /// Roll, pitch, yaw of its axes in the rig's frame; those of the rig if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpy_deg: Option<[f64; 3]>,
    /// The same as a unit quaternion, scalar first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// The same as a matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[[f64; 3]; 3]>,
}

/// A mesh from a glTF file. Its front looks along x, its top along −z of its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PropEntry {
    /// Its name, unique: letters, digits, `_` and `-`.
    pub id: String,
    /// A `.glb` or `.gltf` file, relative to this file.
    pub file: PathBuf,
    /// Where the mesh's origin is.
    pub position_m: [f64; 3],
    /// Roll, pitch, yaw of its axes in the rig's frame; those of the rig if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpy_deg: Option<[f64; 3]>,
    /// The same as a unit quaternion, scalar first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// The same as a matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Times its size.
    #[serde(default = "one")]
    pub scale: f64,
}

fn one() -> f64 {
    1.0
}

/// Waves of the sand: they turn its normal, the floor itself stays a plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RipplesEntry {
    /// Crest to crest.
    pub wavelength_m: f64,
    /// Trough to crest.
    pub height_m: f64,
    /// Direction across the crests, from forward to starboard.
    #[serde(default)]
    pub heading_deg: f64,
}

/// Stones strewn over the floor by the scene's seed; none where a rod, a camera or a lamp is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClutterEntry {
    /// How many, on average.
    pub stones_per_m2: f64,
    /// Diameters of the smallest and the largest; evenly spread in their logarithm.
    pub diameter_m: [f64; 2],
    /// Mean albedo (red, green, blue); each stone has its own, half to one and a half times that.
    pub albedo: [f64; 3],
    /// They lie within this distance of the point below the rig's origin.
    #[serde(default = "default_reach_m")]
    pub reach_m: f64,
}

fn default_reach_m() -> f64 {
    10.0
}
