//! From a scene back to a file: what stands in the water besides plain rods.

use rodsight_geometry::{Mat3, Vec3};

use super::degrees_that_read_back;
use crate::file::{
    BlockEntry, CapsuleEntry, ClutterEntry, FoulingEntry, GlossEntry, GrainEntry, OccluderEntry,
    PropEntry, RipplesEntry, SphereEntry, StripesEntry, SurfaceEntry,
};
use crate::{Clutter, Occluder, Prop, Ripples, Rod, Shape};

impl Prop {
    /// Where a written scene expects the mesh, relative to itself; [`Mesh::to_glb`](crate::Mesh::to_glb) is to be put there.
    pub fn written_file(&self) -> String {
        format!("props/{}.glb", self.id)
    }
}

impl SurfaceEntry {
    /// `None` for what is evenly matt and clean.
    pub(super) fn from_rod(rod: &Rod) -> Option<Self> {
        let surface = Self {
            stripes: rod.finish.stripes.map(|stripes| StripesEntry {
                period_m: stripes.period_m,
                albedo: stripes.albedo,
                share: stripes.share,
                starts: stripes.starts,
            }),
            texture: rod.finish.grain.map(|grain| GrainEntry {
                contrast: grain.contrast,
                scale_m: grain.scale_m,
            }),
            gloss: rod.finish.gloss.map(|gloss| GlossEntry {
                roughness: gloss.roughness,
                reflectance: gloss.reflectance,
            }),
            fouling: rod.fouling.map(|fouling| FoulingEntry {
                cover: fouling.cover,
                height_m: fouling.height_m,
                albedo: fouling.albedo,
            }),
        };
        (surface != Self::default()).then_some(surface)
    }
}

impl OccluderEntry {
    pub(super) fn from_occluder(occluder: &Occluder) -> Self {
        let mut entry = Self {
            id: occluder.id.clone(),
            albedo: occluder.albedo,
            sphere: None,
            capsule: None,
            block: None,
        };
        match occluder.shape {
            Shape::Sphere { centre_m, radius_m } => {
                let centre_m = centre_m.into();
                entry.sphere = Some(SphereEntry { centre_m, radius_m });
            }
            Shape::Capsule {
                from_m,
                to_m,
                radius_m,
            } => {
                entry.capsule = Some(CapsuleEntry {
                    from_m: from_m.into(),
                    to_m: to_m.into(),
                    radius_m,
                });
            }
            Shape::Block {
                centre_m,
                half_m,
                rotation,
            } => {
                entry.block = Some(BlockEntry {
                    centre_m: centre_m.into(),
                    size_m: (half_m * 2.0).into(),
                    rpy_deg: None,
                    quaternion_wxyz: None,
                    rotation: Some(rows(&rotation)),
                });
            }
        }
        entry
    }
}

impl PropEntry {
    pub(super) fn from_prop(prop: &Prop) -> Self {
        let origin_m: Vec3 = prop.rig_from_prop.origin_m();
        Self {
            id: prop.id.clone(),
            file: prop.written_file().into(),
            position_m: origin_m.into(),
            rpy_deg: None,
            quaternion_wxyz: None,
            rotation: Some(rows(prop.rig_from_prop.rotation())),
            scale: prop.scale,
        }
    }
}

fn rows(m: &Mat3) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)]))
}

impl RipplesEntry {
    pub(super) fn from_ripples(ripples: Ripples) -> Self {
        Self {
            wavelength_m: ripples.wavelength_m,
            height_m: ripples.height_m,
            heading_deg: degrees_that_read_back(ripples.heading_rad),
        }
    }
}

impl ClutterEntry {
    pub(super) fn from_clutter(clutter: Clutter) -> Self {
        Self {
            stones_per_m2: clutter.stones_per_m2,
            diameter_m: clutter.diameter_m,
            albedo: clutter.albedo,
            reach_m: clutter.reach_m,
        }
    }
}
