//! What stands in the water besides plain rods, against closed forms and against each other.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "helpers of tests may panic"
)]

mod common;

use core::f64::consts::PI;
use std::sync::Arc;

use rodsight_geometry::{Eye, Mat3, Pose, Vec3, rotation_from_rpy};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, Renderer, Truth, develop, write_pair};
use rodsight_scene::{
    Clutter, Finish, Fouling, Gloss, Material, Mesh, MeshMaterial, MeshPart, Mode, Occluder, Prop,
    Ripples, Scene, Seabed, Shape,
};

fn left(scene: &Scene) -> EyeFrame {
    CpuRenderer.render_eye(scene, Eye::Left, &|_| ()).unwrap()
}

fn both(scene: &Scene) -> Frame {
    CpuRenderer.render(scene, &|_| ()).unwrap()
}

/// In even light and no water a matt body is an even patch: its radiance summed over the image is its area.
fn in_even_light(shape: Shape) -> Scene {
    let mut scene = common::empty(8);
    scene.ambient_radiance = [1.0; 3];
    scene.occluders.push(Occluder {
        id: "body".to_owned(),
        shape,
        albedo: [0.5; 3],
    });
    scene
}

fn area_px2(scene: &Scene) -> f64 {
    let frame = left(scene);
    frame
        .pixels
        .iter()
        .map(|p| f64::from(p.clean[0]) / 0.5)
        .sum()
}

const AHEAD_M: Vec3 = Vec3::new(3.0, -0.5, -1.0);

#[test]
fn sphere_has_the_outline_of_its_cone() {
    let radius_m = 0.2;
    let sphere = Shape::Sphere {
        centre_m: AHEAD_M,
        radius_m,
    };
    let scene = in_even_light(sphere);
    let focal_px = scene.rig.left.camera.intrinsics().fx_px;
    let outline_px = focal_px * radius_m / (9.0 - radius_m * radius_m).sqrt();
    let expected = PI * outline_px * outline_px;
    let found = area_px2(&scene);
    assert!(
        (found / expected - 1.0).abs() < 1e-3,
        "{found} for {expected}"
    );
    // The comparison sees a hundredth of a pixel.
    let larger = PI * (outline_px + 0.02) * (outline_px + 0.02);
    assert!((found / larger - 1.0).abs() > 1e-3);
    let centre = left(&scene).at(120, 67).range_m;
    assert!((f64::from(centre) - 2.8).abs() < 1e-3, "{centre}");
}

#[test]
fn block_and_capsule_have_the_outlines_of_their_faces() {
    let block = Shape::Block {
        centre_m: AHEAD_M,
        half_m: Vec3::new(0.5, 0.2, 0.1),
        rotation: Mat3::identity(),
    };
    let scene = in_even_light(block);
    let focal_px = scene.rig.left.camera.intrinsics().fx_px;
    let expected = (focal_px / 2.5) * (focal_px / 2.5) * 0.4 * 0.2;
    let found = area_px2(&scene);
    assert!(
        (found / expected - 1.0).abs() < 1e-3,
        "{found} for {expected}"
    );

    // Seen along its axis a capsule is its nearer ball.
    let capsule = Shape::Capsule {
        from_m: AHEAD_M,
        to_m: AHEAD_M + Vec3::x(),
        radius_m: 0.2,
    };
    let sphere = Shape::Sphere {
        centre_m: AHEAD_M,
        radius_m: 0.2,
    };
    let (a, b) = (
        area_px2(&in_even_light(capsule)),
        area_px2(&in_even_light(sphere)),
    );
    assert!((a / b - 1.0).abs() < 1e-3, "{a} and {b}");
    // Seen from the side it is as long as its axis and two radii.
    let across = Shape::Capsule {
        from_m: AHEAD_M - Vec3::y() * 0.3,
        to_m: AHEAD_M + Vec3::y() * 0.3,
        radius_m: 0.1,
    };
    let frame = left(&in_even_light(across));
    let row: f64 = (0..240)
        .map(|u| f64::from(frame.at(u, 67).clean[0]) / 0.5)
        .sum();
    assert!((row - focal_px * 0.8 / 3.0).abs() < 0.2, "{row}");
}

/// A cube as a mesh, with its own flat normals.
fn cube(half_m: f32) -> Mesh {
    let mut part = MeshPart::default();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let mut normal = [0.0; 3];
            normal[axis] = side;
            let first = part.positions_m.len() as u32;
            for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = [0.0; 3];
                corner[axis] = side * half_m;
                corner[(axis + 1) % 3] = u * half_m;
                corner[(axis + 2) % 3] = v * half_m;
                part.positions_m.push(corner);
                part.normals.push(normal);
            }
            part.triangles.push([first, first + 1, first + 2]);
            part.triangles.push([first, first + 2, first + 3]);
        }
    }
    Mesh {
        parts: vec![part],
        materials: vec![MeshMaterial {
            name: "grey".to_owned(),
            base: [0.5, 0.25, 0.125],
            metallic: 0.0,
            roughness: 1.0,
            texture: None,
        }],
        ..Mesh::default()
    }
}

fn prop(mesh: Mesh, at_m: Vec3, rotation: Mat3, scale: f64) -> Prop {
    Prop {
        id: "box".to_owned(),
        mesh: Arc::new(mesh),
        rig_from_prop: Pose::new(rotation, at_m),
        scale,
    }
}

/// The same box as a mesh and as a block: same depths, same ids but for their numbers, same shadows.
#[test]
fn a_box_of_triangles_is_the_block_of_the_same_size() {
    let rotation = rotation_from_rpy(0.3, -0.4, 0.5);
    let at_m = Vec3::new(2.2, -0.2, -0.5);
    let mut as_block = common::wet(8);
    as_block.rods.push(common::orange_rod(
        Vec3::new(2.6, 0.0, -0.9),
        Vec3::new(0.1, 0.3, 1.0),
        0.05,
    ));
    let mut as_mesh = as_block.clone();
    as_block.occluders.push(Occluder {
        id: "box".to_owned(),
        shape: Shape::Block {
            centre_m: at_m,
            half_m: Vec3::repeat(0.25),
            rotation,
        },
        albedo: [0.5, 0.25, 0.125],
    });
    as_mesh.props.push(prop(cube(0.5), at_m, rotation, 0.5));
    let (a, b) = (left(&as_block), left(&as_mesh));
    let (mut seen, mut differ) = (0, 0);
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        assert_eq!(p.instance, q.instance);
        assert_eq!((p.depth_m, p.occluded), (q.depth_m, q.occluded));
        assert_eq!(p.material == 3, q.material == 4);
        seen += u32::from(p.material == 3);
        // The mesh has glTF's thin coat: F = 0.3 % upright, and more at a slant.
        if p.material != 3 {
            differ += u32::from((p.radiance[1] / q.radiance[1] - 1.0).abs() > 1e-3);
        } else if p.normal != q.normal {
            assert!((0..3).all(|k| (p.normal[k] - q.normal[k]).abs() < 1e-6));
        }
    }
    assert!(seen > 500, "{seen} pixels show it");
    // Along its outline pixels are shared with what is behind.
    assert!(differ < seen / 5, "{differ} of the others differ");
}

/// Rays at the edges and corners of a closed mesh of many slivers never slip through.
#[test]
fn closed_meshes_have_no_cracks() {
    let mut scene = common::empty(4);
    scene.background_radiance = [100.0; 3];
    let mut part = MeshPart::default();
    // A wall with its middle on an axis through pixel corners, in a fan of 2000 slivers.
    let n = 2000;
    part.positions_m.push([0.0; 3]);
    for i in 0..n {
        let (sin, cos) = libm::sincos(2.0 * PI * f64::from(i) / f64::from(n));
        part.positions_m
            .push([0.0, 10.0 * cos as f32, 10.0 * sin as f32]);
        part.triangles.push([0, 1 + i, 1 + (i + 1) % n]);
    }
    part.normals = vec![[-1.0, 0.0, 0.0]; part.positions_m.len()];
    let wall = Mesh {
        parts: vec![part],
        ..cube(1.0)
    };
    scene.props.push(prop(wall, AHEAD_M, Mat3::identity(), 1.0));
    let frame = left(&scene);
    assert!(
        frame
            .pixels
            .iter()
            .all(|p| p.instance == 2 && p.clean[0] < 1.0)
    );
    assert!(frame.pixels.iter().all(|p| (p.depth_m - 3.0).abs() < 1e-6));
}

/// At normal incidence the coated end of a rod sends ρ (1 − F)² + F / 4α² times what a matt white one would.
#[test]
fn gloss_has_the_peak_of_its_distribution() {
    let mut scene = common::empty(8);
    scene
        .lamps
        .push(common::bare_lamp(Vec3::new(0.0, -0.5, -1.0), [1.0; 3]));
    let mut rod = common::flat_rod(Vec3::new(6.0, -0.5, -1.0), Vec3::x(), 0.3);
    rod.material = Material::Lambert([0.4; 3]);
    scene.rods.push(rod);
    let matt = left(&scene).at(120, 67).clean[0];
    for (roughness, reflectance) in [(0.6, 0.05), (0.9, 0.5)] {
        scene.rods[0].finish.gloss = Some(Gloss {
            roughness,
            reflectance: [reflectance; 3],
        });
        let coated = left(&scene).at(120, 67).clean[0];
        let alpha2 = libm::pow(roughness, 4.0);
        let expected =
            (0.4 * (1.0 - reflectance) * (1.0 - reflectance) + reflectance / (4.0 * alpha2)) / 0.4;
        let found = f64::from(coated / matt);
        // Half a pixel off the axis the lobe has fallen by less than this.
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} for {expected}"
        );
    }
}

fn fouled() -> Scene {
    let mut scene = common::crossing(8);
    scene.rods[0].fouling = Some(Fouling {
        cover: 0.3,
        height_m: 0.012,
        albedo: [0.2, 0.25, 0.1],
    });
    scene
}

#[test]
fn growth_covers_its_share_and_leaves_the_truth_of_the_rod_alone() {
    let scene = fouled();
    let frame = both(&scene);
    let truth = Truth::of(&scene, &frame, 1.0).unwrap();
    let fouling = truth.rods[0].fouling.unwrap();
    assert!(truth.rods[1].fouling.is_none());
    assert!((fouling.cover / 0.3 - 1.0).abs() < 0.1, "{fouling:?}");
    assert!(
        fouling.max_height_m <= 0.012 && fouling.max_height_m > 0.0115,
        "{fouling:?}"
    );
    assert!(fouling.mean_height_m > 0.0 && fouling.mean_height_m < 0.3 * 0.012);
    let grown = frame
        .left
        .pixels
        .iter()
        .filter(|p| p.instance == fouling.instance);
    assert!(grown.clone().count() > 50, "{}", grown.count());
    assert!(grown.clone().all(|p| p.material == 5));

    let mut clean = scene.clone();
    clean.rods[0].fouling = None;
    let clean_frame = both(&clean);
    let clean_truth = Truth::of(&clean, &clean_frame, 1.0).unwrap();
    assert_eq!(truth.rods[0].left.lines, clean_truth.rods[0].left.lines);
    assert_eq!(truth.grasp, clean_truth.grasp);
    let length = |truth: &Truth| -> f64 {
        let stretches = &truth.rods[0].left.visible_m;
        stretches.iter().map(|[from, to]| to - from).sum()
    };
    assert!(
        (length(&truth) / length(&clean_truth) - 1.0).abs() < 0.02,
        "growth hides no axis"
    );
    // Another seed strews other lumps.
    let mut other = scene.clone();
    other.seed += 1;
    assert_ne!(left(&other).pixels, frame.left.pixels);
}

#[test]
fn stones_lie_as_densely_as_asked_and_off_the_rods() {
    let mut scene = common::wet(8);
    scene.rods.push(common::orange_rod(
        Vec3::new(2.5, 0.0, 0.05),
        Vec3::y(),
        0.1,
    ));
    scene.seabed.as_mut().unwrap().clutter = Some(Clutter {
        stones_per_m2: 20.0,
        diameter_m: [0.05, 0.2],
        albedo: [0.3; 3],
        reach_m: 6.0,
    });
    let frame = both(&scene);
    let truth = Truth::of(&scene, &frame, 1.0).unwrap();
    let stones = truth.stones.unwrap();
    let most = 20.0 * PI * 36.0;
    // Less those that would touch the rod: two diameters wide and three metres long.
    assert!(
        stones.count as f64 > 0.97 * most && (stones.count as f64) < most,
        "{stones:?} of {most}"
    );
    assert_eq!(stones.instance, scene.stones_instance());
    let seen = frame.left.pixels.iter().filter(|p| p.material == 6);
    assert!(seen.clone().count() > 500);
    assert!(seen.clone().all(|p| p.instance == stones.instance));
}

#[test]
fn ripples_turn_normals_and_not_the_floor() {
    let mut scene = common::empty(8);
    scene
        .lamps
        .push(common::bare_lamp(Vec3::new(0.0, 0.0, -1.5), [1.0; 3]));
    scene.seabed = Some(Seabed {
        z_m: 0.0,
        albedo: [0.4; 3],
        texture_contrast: 0.0,
        texture_scale_m: 0.1,
        ripples: None,
        clutter: None,
    });
    let flat = left(&scene);
    scene.seabed.as_mut().unwrap().ripples = Some(Ripples {
        wavelength_m: 0.3,
        height_m: 0.03,
        heading_rad: 0.4,
    });
    let rippled = left(&scene);
    let (mut changed, mut ratio) = (0_usize, 0.0);
    for (a, b) in flat
        .pixels
        .iter()
        .zip(&rippled.pixels)
        .filter(|(a, _)| a.depth_m < 3.0)
    {
        assert_eq!(a.depth_m, b.depth_m);
        let norm: f32 = b.normal.iter().map(|v| v * v).sum();
        assert!((norm - 1.0).abs() < 1e-5);
        // Slope at most π h / λ = 0.314, a little more where crests wander.
        let cos: f32 = (0..3).map(|k| a.normal[k] * b.normal[k]).sum();
        assert!(cos > 1.0 / (1.0_f32 + 0.33 * 0.33).sqrt(), "{cos}");
        changed += usize::from(cos < 0.999);
        ratio += f64::from(b.clean[0] / a.clean[0]);
    }
    let near = flat.pixels.iter().filter(|p| p.depth_m < 3.0).count();
    assert!(near > 300 && 2 * changed > near, "{changed} of {near}");
    // Slopes to and fro cancel in the mean.
    assert!(
        (ratio / near as f64 - 1.0).abs() < 0.05,
        "{}",
        ratio / near as f64
    );
}

/// A written pair with props, growth and stones: its scene renders to the same pixels.
#[test]
fn written_scene_with_props_renders_to_the_same_bytes() {
    let mut scene = fouled();
    scene.props.push(prop(
        cube(0.5),
        Vec3::new(2.8, 0.6, -0.6),
        rotation_from_rpy(0.1, 0.2, 0.3),
        0.3,
    ));
    scene.rods[1].finish = Finish {
        gloss: Some(Gloss {
            roughness: 0.3,
            reflectance: [0.04; 3],
        }),
        ..Finish::default()
    };
    scene.mode = Mode::Single;
    scene.rods[1].id = "other".to_owned();
    // All around is more than a file may say.
    for lamp in &mut scene.lamps {
        (lamp.inner_half_angle_rad, lamp.outer_half_angle_rad) = (3.0, 3.1);
    }
    let frame = both(&scene);
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    assert_eq!(truth.props[0].triangles, 12);
    let folder = tempfile::tempdir().unwrap();
    let paths = write_pair(folder.path(), &scene, None, &developed, &truth).unwrap();
    assert!(folder.path().join("props/box.glb").is_file());
    let again = Scene::load(&paths.scene_toml).unwrap();
    let frame_again = both(&again);
    assert_eq!(frame.left.pixels, frame_again.left.pixels);
    assert_eq!(frame.right.pixels, frame_again.right.pixels);
}
