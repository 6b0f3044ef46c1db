//! What stands in the water besides plain rods: finishes, growth, occluders, props, what lies on the seabed.

use std::sync::Arc;

use rodsight_geometry::{Mat3, Pose, RigFrame, Vec3};
use rodsight_optics::Bands;

use crate::{Mesh, Rod, Scene};

/// What makes a rod's surface other than evenly matt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finish {
    /// Bands of a second albedo.
    pub stripes: Option<Stripes>,
    /// Grain of the albedo.
    pub grain: Option<Grain>,
    /// A glossy coat.
    pub gloss: Option<Gloss>,
}

/// Bands of a second albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripes {
    /// From one band to the next along the rod, m.
    pub period_m: f64,
    /// Albedo of the bands.
    pub albedo: Bands,
    /// Share of the rod that they cover, in (0, 1).
    pub share: f64,
    /// 0: rings; n: n interleaved right-handed helices.
    pub starts: u32,
}

/// Band-limited grain of the albedo, fixed to the rod; its mean is the albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Greatest relative departure from the mean, (0, 1].
    pub contrast: f64,
    /// Size of the coarsest grains, m.
    pub scale_m: f64,
}

/// A glossy coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Perceptual roughness, [0.05, 1]; the GGX width is its square.
    pub roughness: f64,
    /// Reflectance at normal incidence.
    pub reflectance: Bands,
}

/// Marine growth on a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fouling {
    /// Expected share of the rod's side that lumps cover, (0, 0.95].
    pub cover: f64,
    /// Height of the highest over the surface, m.
    pub height_m: f64,
    /// Albedo of the lumps.
    pub albedo: Bands,
}

impl Fouling {
    /// How many lumps cover, by chance, the share asked for: n discs of mean area a on a surface A leave e^(−n a/A) of it bare.
    /// Heights are even in [¼, 1] of the highest, radii even in [1, 2½] of the height.
    pub fn lumps(&self, rod: &Rod) -> f64 {
        let height2_m2 = self.height_m * self.height_m * (1.0 + 0.25 + 0.0625) / 3.0;
        let radius2_m2 = height2_m2 * (1.0 + 2.5 + 6.25) / 3.0;
        // A/a, with π in both.
        -libm::log1p(-self.cover) * 2.0 * rod.radius_m * rod.length_m / radius2_m2
    }
}

/// A body that stands in the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Occluder {
    /// Its name.
    pub id: String,
    /// Its form and place.
    pub shape: Shape,
    /// Lambertian albedo.
    pub albedo: Bands,
}

/// A convex body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Shape {
    Sphere {
        centre_m: Vec3,
        radius_m: f64,
    },
    /// A cylinder with a half ball at each end.
    Capsule {
        from_m: Vec3,
        to_m: Vec3,
        radius_m: f64,
    },
    /// A box.
    Block {
        centre_m: Vec3,
        half_m: Vec3,
        /// Takes its own axes to those of the rig.
        rotation: Mat3,
    },
}

/// Marker: a prop's own frame, x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PropFrame;

/// A mesh in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Prop {
    /// Its name, which becomes a file name.
    pub id: String,
    /// What it looks like.
    pub mesh: Arc<Mesh>,
    /// Where it is: takes the scaled mesh to the rig.
    pub rig_from_prop: Pose<RigFrame, PropFrame>,
    /// Times the mesh's size.
    pub scale: f64,
}

/// Waves of the sand: they turn its normal; the floor stays a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripples {
    /// Crest to crest, m.
    pub wavelength_m: f64,
    /// Trough to crest, m.
    pub height_m: f64,
    /// Direction across the crests, from forward to starboard, rad.
    pub heading_rad: f64,
}

/// Stones strewn over the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// How many, on average, m⁻².
    pub stones_per_m2: f64,
    /// Smallest and largest diameter, m.
    pub diameter_m: [f64; 2],
    /// Mean albedo.
    pub albedo: Bands,
    /// They lie within this distance of the point below the rig's origin, m.
    pub reach_m: f64,
}

impl Shape {
    /// Whether a point lies inside.
    pub fn contains(&self, point_m: &Vec3) -> bool {
        match *self {
            Self::Sphere { centre_m, radius_m } => (point_m - centre_m).norm() < radius_m,
            Self::Capsule {
                from_m,
                to_m,
                radius_m,
            } => {
                let axis = to_m - from_m;
                let along = (point_m - from_m).dot(&axis) / axis.norm_squared();
                (from_m + axis * along.clamp(0.0, 1.0) - point_m).norm() < radius_m
            }
            Self::Block {
                centre_m,
                half_m,
                rotation,
            } => {
                let inside = rotation.transpose() * (point_m - centre_m);
                (0..3).all(|k| inside[k].abs() < half_m[k])
            }
        }
    }
}

/// Numbers in the instance channel: 0 nothing, 1 the seabed, then one for each rod, occluder, prop, each rod's growth, and one for
/// all stones.
impl Scene {
    /// Of a rod.
    pub fn rod_instance(&self, index: usize) -> u16 {
        2 + index as u16
    }

    /// Of an occluder.
    pub fn occluder_instance(&self, index: usize) -> u16 {
        self.rod_instance(self.rods.len()) + index as u16
    }

    /// Of a prop.
    pub fn prop_instance(&self, index: usize) -> u16 {
        self.occluder_instance(self.occluders.len()) + index as u16
    }

    /// Of what grows on a rod, whether anything does or not.
    pub fn growth_instance(&self, rod: usize) -> u16 {
        self.prop_instance(self.props.len()) + rod as u16
    }

    /// Of all stones.
    pub fn stones_instance(&self) -> u16 {
        self.growth_instance(self.rods.len())
    }
}
