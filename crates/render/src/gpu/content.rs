//! What stands in the water as the shaders take it; see `content.wgsl`.

use rodsight_geometry::Vec3;
use rodsight_scene::{Material, Ripples, Rod, Scene, Wrap};

use super::layout::{self, Vec3f};
use super::layout::{Arc, Body, Finish, Lump, Paint, SeabedRipples, Triangle, Vertex};
use super::upload::solid;
use crate::cpu::bodies::{self, Solid};
use crate::cpu::finish;
use crate::cpu::texture::Pyramid;
use crate::cpu::triangles::Triangles;
use crate::cpu::world::World;

/// A rod's surface, plain or finished.
pub(super) fn rod(world: &World<'_>, index: usize, from_m: &Vec3) -> layout::Rod {
    let rod = &world.scene.rods[index];
    let (value, is_flat) = match rod.material {
        Material::Lambert(albedo) => (albedo, 0),
        Material::Flat(radiance) => (radiance, 1),
    };
    let gloss = rod.finish.gloss;
    layout::Rod {
        value: value.into(),
        is_flat,
        arc: arc(&world.rods.solids[index].arc, from_m),
        finish: finish(world.scene, rod, index),
        reflectance: gloss.map_or([0.0; 3], |gloss| gloss.reflectance).into(),
        roughness: gloss.map_or(0.0, |gloss| gloss.roughness as f32),
    }
}

fn arc(arc: &crate::cpu::arc::Arc, from_m: &Vec3) -> Arc {
    let middle = arc.at(0.0);
    let [_, side] = arc.across(0.0);
    Arc {
        centre_m: (middle.point_m - from_m).into(),
        curvature_per_m: arc.curvature_per_m as f32,
        direction: middle.direction.into(),
        towards: arc.inward(&middle.direction).into(),
        side: side.into(),
    }
}

fn finish(scene: &Scene, rod: &Rod, index: usize) -> Finish {
    let (stripes, grain) = (rod.finish.stripes, rod.finish.grain);
    Finish {
        stripe: stripes.map_or([0.0; 3], |s| s.albedo).into(),
        period_m: stripes.map_or(0.0, |s| s.period_m as f32),
        share: stripes.map_or(0.0, |s| s.share as f32),
        starts: stripes.map_or(0.0, |s| s.starts as f32),
        contrast: grain.map_or(0.0, |g| g.contrast as f32),
        scale_m: grain.map_or(0.0, |g| g.scale_m as f32),
        seed: finish::seed_word(scene.seed, index),
        radius_m: rod.radius_m as f32,
    }
}

pub(super) fn ripples(ripples: &Ripples) -> SeabedRipples {
    let (sin, cos) = libm::sincos(ripples.heading_rad);
    SeabedRipples {
        wavelength_m: ripples.wavelength_m as f32,
        height_m: ripples.height_m as f32,
        heading: [cos, sin].into(),
    }
}

/// All bodies in the order of their tree's leaves.
pub(super) fn bodies(world: &World<'_>, from_m: &Vec3) -> Vec<Body> {
    let all = &world.bodies;
    let in_order = all.tree.order.iter().map(|&i| &all.solids[i as usize]);
    in_order.map(|it| body(world, it, from_m)).collect()
}

fn body(world: &World<'_>, body: &bodies::Body, from_m: &Vec3) -> Body {
    let (lump, side) = match &body.solid {
        Solid::Lump(it) => (lump(it, from_m), None),
        Solid::Capped(piece) => (Lump::default(), Some(solid(piece, from_m))),
    };
    Body {
        lump,
        side: side.unwrap_or_default(),
        albedo: body.albedo.into(),
        instance: world.instance(body.thing).into(),
        part: body.part,
        is_side: side.is_some().into(),
    }
}

pub(super) fn lump(lump: &crate::cpu::lump::Lump, from_m: &Vec3) -> Lump {
    let row = |k: usize| -> Vec3f { Vec3::from(lump.to_unit.row(k).transpose()).into() };
    Lump {
        centre_m: (lump.centre_m - from_m).into(),
        is_cube: lump.is_cube.into(),
        to_unit_x: row(0),
        to_unit_y: row(1),
        to_unit_z: row(2),
    }
}

pub(super) fn vertices(all: &Triangles, from_m: &Vec3) -> Vec<Vertex> {
    let vertices = all.vertices_m.iter().zip(&all.normals).zip(&all.uvs);
    let vertices = vertices.map(|((position_m, normal), uv)| Vertex {
        position_m: (position_m - from_m).into(),
        u: uv[0] as f32,
        normal: (*normal).into(),
        v: uv[1] as f32,
    });
    vertices.collect()
}

/// All triangles in the order of their tree's leaves.
pub(super) fn triangles(all: &Triangles) -> Vec<Triangle> {
    let in_order = all.tree.order.iter().map(|&index| {
        let index = index as usize;
        let [a, b, c] = all.corners[index];
        Triangle {
            a,
            b,
            c,
            part: all.patches[index],
            paint: all.painted[index],
            curvature_per_m: all.curvature_per_m(index) as f32,
            texels_per_m: all.texels_per_m(index) as f32,
        }
    });
    in_order.collect()
}

/// What triangles are painted with, and the texels of all textures.
pub(super) fn paints(world: &World<'_>) -> (Vec<Paint>, Vec<f32>) {
    let all = &world.bodies.triangles;
    let mut texels = Vec::new();
    let mut placed = Vec::new();
    for pyramid in &all.textures {
        placed.push(texels.len() as u32 / 3);
        texels.extend(pyramid.texels.iter().flatten());
    }
    let paints = all.paints.iter().map(|paint| {
        let plain = Paint {
            base: paint.base.into(),
            metallic: paint.metallic as f32,
            roughness: paint.roughness as f32,
            instance: world.scene.prop_instance(paint.prop).into(),
            ..Paint::default()
        };
        paint.texture.map_or(plain, |index| {
            let pyramid = &all.textures[index as usize];
            textured(plain, pyramid, placed[index as usize])
        })
    });
    (paints.collect(), texels)
}

fn textured(paint: Paint, pyramid: &Pyramid, first: u32) -> Paint {
    let (width, height, _) = pyramid.levels[0];
    let [wrap_u, wrap_v] = pyramid.wrap.map(|wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    });
    Paint {
        first,
        levels: pyramid.levels.len() as u32,
        width,
        height,
        wrap_u,
        wrap_v,
        ..paint
    }
}
