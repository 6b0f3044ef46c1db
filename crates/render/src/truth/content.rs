//! Truth of what stands in the water besides plain rods.

use core::f64::consts::TAU;

use rodsight_scene::Scene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cpu::arc::Arc;
use crate::cpu::solid::Ray;
use crate::cpu::world::{Thing, World};

/// Marine growth on a rod. Axis, radius, limbs and grasp are those of the rod beneath; its image is wider by what grows on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FoulingTruth {
    /// Its number in the instance channel.
    pub instance: u16,
    /// Lumps that it consists of.
    pub lumps: u64,
    /// Share of the rod's side under it.
    pub cover: f64,
    /// Height over the rod's surface, mean over all of the side, m.
    pub mean_height_m: f64,
    /// Greatest height, m.
    pub max_height_m: f64,
}

/// A simple body that stands in the way.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct OccluderTruth {
    /// Its name.
    pub id: String,
    /// Its number in the instance channel.
    pub instance: u16,
}

/// A mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PropTruth {
    /// Its name.
    pub id: String,
    /// Its number in the instance channel.
    pub instance: u16,
    /// Number of triangles.
    pub triangles: u64,
    /// What its file asks for and was looked past.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// Stones on the seabed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StonesTruth {
    /// Their number in the instance channel.
    pub instance: u16,
    /// How many there are.
    pub count: u64,
}

pub(super) fn occluders(scene: &Scene) -> Vec<OccluderTruth> {
    let numbered = scene.occluders.iter().enumerate();
    let truth = numbered.map(|(index, occluder)| OccluderTruth {
        id: occluder.id.clone(),
        instance: scene.occluder_instance(index),
    });
    truth.collect()
}

pub(super) fn props(scene: &Scene) -> Vec<PropTruth> {
    let numbered = scene.props.iter().enumerate();
    let truth = numbered.map(|(index, prop)| PropTruth {
        id: prop.id.clone(),
        instance: scene.prop_instance(index),
        triangles: prop.mesh.triangle_count() as u64,
        notes: prop.mesh.notes.clone(),
    });
    truth.collect()
}

pub(super) fn stones(world: &World<'_>) -> Option<StonesTruth> {
    let is_there = world.scene.seabed.is_some_and(|s| s.clutter.is_some());
    is_there.then(|| StonesTruth {
        instance: world.scene.stones_instance(),
        count: count(world, Thing::Stones),
    })
}

fn count(world: &World<'_>, thing: Thing) -> u64 {
    let solids = world.bodies.solids.iter();
    solids.filter(|body| body.thing == thing).count() as u64
}

/// Measured by rays from all around straight down on the rod's surface.
pub(super) fn fouling(world: &World<'_>, index: usize) -> Option<FoulingTruth> {
    const RAYS: u32 = 20_000;
    let rod = &world.scene.rods[index];
    let fouling = rod.fouling?;
    let arc = Arc::of(rod);
    // From beyond any lump.
    let above_m = 1.01 * fouling.height_m;
    let (mut covered, mut height_m) = (0_u32, 0.0);
    for i in 0..RAYS {
        let s_m = rod.length_m * ((f64::from(i) + 0.5) / f64::from(RAYS) - 0.5);
        let [e1, e2] = arc.across(s_m);
        // Turns by the golden ratio fill the side evenly.
        let (sin, cos) = libm::sincos(TAU * 0.618_033_988_749_895 * f64::from(i));
        let outwards = e1 * cos + e2 * sin;
        let ray = Ray {
            origin_m: arc.at(s_m).point_m + outwards * (rod.radius_m + above_m),
            direction: -outwards,
        };
        if let Some(t_m) = world.bodies.growth(&ray, index)
            && t_m < above_m
        {
            covered += 1;
            height_m += above_m - t_m;
        }
    }
    Some(FoulingTruth {
        instance: world.scene.growth_instance(index),
        lumps: count(world, Thing::Growth(index)),
        cover: f64::from(covered) / f64::from(RAYS),
        mean_height_m: height_m / f64::from(RAYS),
        max_height_m: world.bodies.tallest_m(index),
    })
}
