//! Both backends on what stands in the water besides plain rods.
//!
//! Without an adapter these tests say that they were skipped, and pass; with `RODSIGHT_REQUIRE_GPU=1` they fail.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    clippy::print_stdout,
    reason = "helpers of tests may panic, and say how well it went"
)]

mod common;

use std::sync::Arc;

use common::compare::{SAMPLES, SAMPLING, compare};
use rodsight_geometry::{Pose, Vec3, rotation_from_rpy};
use rodsight_render::{CpuRenderer, Renderer};
use rodsight_scene::{
    Bend, Clutter, Finish, Fouling, Gloss, Grain, Mesh, MeshMaterial, MeshPart, Occluder, Prop,
    Ripples, Scene, Shape, Stripes, Texture, Wrap,
};

/// Two rods over sand, one of them bent.
fn plain() -> Scene {
    let mut scene = common::crossing(4);
    scene.rods[1].bend = Some(Bend {
        sagitta_m: 0.1,
        towards: scene.rods[1].direction.cross(&Vec3::x()).normalize(),
    });
    scene.ambient_radiance = [0.02, 0.03, 0.04];
    scene.sampling.edge = SAMPLING;
    scene
}

/// The scene looks the same on both backends, and what was added to the plain one shows.
fn check(name: &str, add: impl FnOnce(&mut Scene)) {
    let Some(gpu) = common::gpu() else { return };
    let mut scene = plain();
    add(&mut scene);
    let actual = gpu.render(&scene, &|_| ()).unwrap();
    let reference = CpuRenderer.render(&scene, &|_| ()).unwrap();
    match compare(&actual, &reference, SAMPLES) {
        Ok(report) => println!("{name} on {}:\n  {report}", gpu.adapter()),
        Err(message) => panic!("{name} on {}: {message}", gpu.adapter()),
    }
    let without = gpu.render(&plain(), &|_| ()).unwrap();
    compare(&without, &reference, SAMPLES).expect_err(name);
}

fn finished(name: &str, finish: Finish) {
    check(name, |scene| {
        for rod in &mut scene.rods {
            rod.finish = finish;
        }
    });
}

#[test]
fn striped_grained_and_glossy_rods_look_the_same() {
    let stripes = |starts| {
        Some(Stripes {
            period_m: 0.12,
            albedo: [0.9, 0.8, 0.1],
            share: 0.3,
            starts,
        })
    };
    let grain = Some(Grain {
        contrast: 0.7,
        scale_m: 0.06,
    });
    let gloss = |roughness| {
        Some(Gloss {
            roughness,
            reflectance: [0.04, 0.05, 0.06],
        })
    };
    let finish = |stripes, grain, gloss| Finish {
        stripes,
        grain,
        gloss,
    };
    finished("rings", finish(stripes(0), None, None));
    finished("helices", finish(stripes(2), None, None));
    finished("grain", finish(None, grain, None));
    finished("narrow gloss", finish(None, None, gloss(0.05)));
    finished("all of it", finish(stripes(1), grain, gloss(0.4)));
}

#[test]
fn occluders_growth_and_stones_look_the_same() {
    let shapes = [
        Shape::Sphere {
            centre_m: Vec3::new(1.4, -0.5, -1.2),
            radius_m: 0.12,
        },
        Shape::Capsule {
            from_m: Vec3::new(1.8, 0.2, -1.3),
            to_m: Vec3::new(1.7, 0.6, -0.8),
            radius_m: 0.06,
        },
        Shape::Block {
            centre_m: Vec3::new(2.2, 0.4, -0.3),
            half_m: Vec3::new(0.2, 0.1, 0.15),
            rotation: rotation_from_rpy(0.3, -0.4, 0.5),
        },
    ];
    check("occluders", |scene| {
        let numbered = shapes.into_iter().enumerate();
        scene.occluders.extend(numbered.map(|(i, shape)| Occluder {
            id: format!("body{i}"),
            shape,
            albedo: [0.3, 0.4, 0.5],
        }));
    });
    check("growth", |scene| {
        scene.rods[0].fouling = Some(Fouling {
            cover: 0.3,
            height_m: 0.02,
            albedo: [0.2, 0.25, 0.1],
        });
    });
    check("stones", |scene| {
        scene.seabed.as_mut().unwrap().clutter = Some(Clutter {
            stones_per_m2: 20.0,
            diameter_m: [0.05, 0.2],
            albedo: [0.3; 3],
            reach_m: 6.0,
        });
    });
}

#[test]
fn ripples_look_the_same() {
    check("ripples", |scene| {
        scene.seabed.as_mut().unwrap().ripples = Some(Ripples {
            wavelength_m: 0.3,
            height_m: 0.03,
            heading_rad: 0.4,
        });
    });
}

/// A textured sheet over a bare metal and a matt body, with all ways of going on beyond the texture's edges.
fn sheet(wrap: Wrap) -> Mesh {
    let texture = Texture {
        width_px: 16,
        height_px: 8,
        srgb: (0..128_u32)
            .map(|i| {
                [
                    40 + 37 * (i % 6) as u8,
                    250 - i as u8,
                    90 * (i / 16 % 3) as u8,
                ]
            })
            .collect(),
        wrap: [wrap, Wrap::Repeat],
    };
    Mesh {
        parts: vec![MeshPart {
            positions_m: vec![
                [0.0, -0.5, -0.5],
                [0.0, 0.5, -0.5],
                [0.1, 0.5, 0.5],
                [0.1, -0.5, 0.5],
            ],
            normals: vec![[-1.0, 0.0, 0.1]; 4]
                .into_iter()
                .map(|n: [f32; 3]| n.map(|v| v / 1.01_f32.sqrt()))
                .collect(),
            uvs: vec![[-0.7, 0.0], [1.9, 0.0], [1.9, 1.5], [-0.7, 1.5]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: 0,
        }],
        materials: vec![MeshMaterial {
            name: "sheet".to_owned(),
            base: [0.9, 0.8, 0.7],
            metallic: 0.4,
            roughness: 0.5,
            texture: Some(0),
        }],
        textures: vec![texture],
        ..Mesh::default()
    }
}

fn prop(mesh: Mesh, at_m: Vec3, scale: f64) -> Prop {
    Prop {
        id: "prop".to_owned(),
        mesh: Arc::new(mesh),
        rig_from_prop: Pose::new(rotation_from_rpy(0.2, -0.3, 0.4), at_m),
        scale,
    }
}

#[test]
fn textured_sheets_look_the_same() {
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        check(&format!("{wrap:?}"), |scene| {
            let places = [Vec3::new(1.9, 0.5, -0.8), Vec3::new(2.6, -0.6, -1.0)];
            let props = places.map(|at_m| prop(sheet(wrap), at_m, 0.6));
            scene.props.extend(props);
        });
    }
}

#[test]
fn shipped_props_look_the_same() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/props");
    for (file, scale) in [("boulder.glb", 0.5), ("panel.glb", 0.5), ("frame.glb", 0.4)] {
        let mesh = Mesh::load(&folder.join(file)).unwrap();
        check(file, |scene| {
            scene
                .props
                .push(prop(mesh, Vec3::new(2.0, 0.3, -0.6), scale));
        });
    }
}

/// Mesa's software driver ends loops, without a word, after 65535 steps of an invocation in all of them together: so many of a
/// pixel's samples of a mesh must not be one invocation's.
#[test]
fn many_samples_of_a_mesh_look_the_same() {
    let Some(gpu) = common::gpu() else { return };
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/props");
    let mesh = Mesh::load(&folder.join("boulder.glb")).unwrap();
    let mut scene = common::shrunk(plain(), 4);
    scene.props.push(prop(mesh, Vec3::new(2.0, 0.3, -0.6), 0.5));
    scene.sampling.edge = rodsight_scene::EdgeSampling::Fibonacci { points: 987 };
    let actual = gpu.render(&scene, &|_| ()).unwrap();
    let reference = CpuRenderer.render(&scene, &|_| ()).unwrap();
    // A few of the many may fall on the other side.
    println!("{}", compare(&actual, &reference, SAMPLES).unwrap());
}
