//! Both backends on the same scenes: light, depth and ids, pixel by pixel.
//!
//! Without an adapter these tests say that they were skipped, and pass; with `RODSIGHT_REQUIRE_GPU=1` they fail.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    clippy::print_stdout,
    reason = "helpers of tests may panic, and say how well it went"
)]

mod common;

use common::compare::{SAMPLES, SAMPLING, Samples, at_edges, compare};
use rodsight_geometry::port::{DomePort, FlatPort, Port, PortShape, sea_water_index};
use rodsight_geometry::{Camera, Distortion, Eye, Intrinsics, Vec3};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, Renderer};
use rodsight_scene::{Mode, Scene, Snow};

fn check(name: &str, scene: &mut Scene) {
    let Some(gpu) = common::gpu() else { return };
    scene.sampling.edge = SAMPLING;
    let reference = CpuRenderer.render(scene, &|_| ()).unwrap();
    let actual = gpu.render(scene, &|_| ()).unwrap();
    match compare(&actual, &reference, SAMPLES) {
        Ok(report) => println!("{name} on {}:\n  {report}", gpu.adapter()),
        Err(message) => panic!("{name} on {}: {message}", gpu.adapter()),
    }
}

#[test]
fn shipped_scenes_look_the_same_on_both_backends() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes = 0;
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    files.sort();
    for file in files
        .iter()
        .filter(|f| f.extension().is_some_and(|e| e == "toml"))
    {
        let mut scene = common::shrunk(Scene::load(file).unwrap(), 4);
        check(&file.file_name().unwrap().to_string_lossy(), &mut scene);
        scenes += 1;
    }
    assert!(scenes >= 7, "{scenes} scenes");
}

#[test]
fn every_mode_and_lens_looks_the_same_on_both_backends() {
    for mode in [Mode::Air, Mode::Koschmieder, Mode::Single, Mode::Full] {
        for lens in [None, Some(common::BROWN), Some(common::KANNALA)] {
            let mut scene = common::crossing(8);
            scene.mode = mode;
            scene.ambient_radiance = [0.02, 0.03, 0.04];
            if let Some(lens) = lens {
                scene = common::distorted(lens, scene);
            }
            check(&format!("{mode:?} {lens:?}"), &mut scene);
        }
    }
}

/// Plates and domes, on one eye or on both, that part the bands or not.
#[test]
fn ports_look_the_same_on_both_backends() {
    let shapes = [
        PortShape::Flat(FlatPort {
            normal: Vec3::new(0.1, -0.05, 1.0).normalize(),
            distance_m: 0.05,
            thickness_m: 0.01,
        }),
        PortShape::Dome(DomePort {
            centre_m: Vec3::new(0.004, -0.006, 0.015),
            inner_radius_m: 0.06,
            thickness_m: 0.006,
        }),
    ];
    for (shape, mode) in shapes.into_iter().zip([Mode::Single, Mode::Full]) {
        for (index, both) in [([1.34; 3], false), (sea_water_index(35.0, 10.0), true)] {
            let mut scene = common::crossing(8);
            scene.mode = mode;
            scene.ambient_radiance = [0.02, 0.03, 0.04];
            let port = Some(Port::new(shape, 1.49, index).unwrap());
            scene.rig.left.port = port;
            scene.rig.right.port = port.filter(|_| both);
            check(&format!("{mode:?} {shape:?} {index:?}"), &mut scene);
        }
    }
}

const SNOW: Snow = Snow {
    number_per_m3: 2e3,
    diameter_m: [5e-4, 3e-2],
    exponent: 2.0,
    albedo: [0.3, 0.25, 0.2],
    range_m: [0.1, 5.0],
    seed: None,
};

/// Dust and crumbs before rods, a floor and open water, near ones large enough to be shaded.
#[test]
fn snow_looks_the_same_on_both_backends() {
    for mode in [Mode::Koschmieder, Mode::Single, Mode::Full] {
        let mut scene = common::crossing(8);
        scene.mode = mode;
        scene.ambient_radiance = [0.02, 0.03, 0.04];
        scene.snow = Some(SNOW);
        check(&format!("snow in {mode:?}"), &mut scene);
    }
}

/// Fewer pixels than a margin of the halo has, and odd ones.
#[test]
fn tiny_images_look_the_same_on_both_backends() {
    let mut scene = common::crossing(8);
    scene.mode = Mode::Full;
    scene.snow = Some(SNOW);
    let intrinsics = Intrinsics {
        width_px: 37,
        height_px: 23,
        fx_px: 20.0,
        fy_px: 20.0,
        cx_px: 18.5,
        cy_px: 11.5,
    };
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        mounted.camera = Camera::new(intrinsics, Distortion::None).unwrap();
    }
    check("37×23 px", &mut scene);
}

/// From above, on rods, sand, snow and open water; in the air too.
#[test]
fn daylight_looks_the_same_on_both_backends() {
    for mode in [Mode::Air, Mode::Koschmieder, Mode::Single, Mode::Full] {
        let mut scene = common::crossing(8);
        scene.mode = mode;
        scene.ambient_radiance = [0.02, 0.03, 0.04];
        scene.daylight = Some(rodsight_optics::Daylight {
            irradiance_w_per_m2: [0.3, 0.9, 0.8],
            diffuse_attenuation_per_m: [0.35, 0.08, 0.07],
        });
        scene.snow = Some(SNOW);
        check(&format!("daylight in {mode:?}"), &mut scene);
    }
}

/// A beam too sharp for a table: each ray is summed.
#[test]
fn airlight_without_a_table_looks_the_same_on_both_backends() {
    let mut scene = common::crossing(8);
    for lamp in &mut scene.lamps {
        (lamp.inner_half_angle_rad, lamp.outer_half_angle_rad) = (0.3, 0.302);
        lamp.direction = Vec3::new(1.0, 0.1, 0.2).normalize();
    }
    scene.sampling.airlight_points = 128;
    check("sharp beams", &mut scene);
    scene.medium = rodsight_optics::Medium::new(
        [0.23, 0.05, 0.04],
        [0.12, 0.125, 0.13],
        rodsight_optics::Phase::FournierForand {
            refractive_index: 1.1,
            junge_slope: 3.5835,
        },
    )
    .unwrap();
    check("sharp beams, Fournier-Forand", &mut scene);
}

#[test]
fn bytes_depend_on_neither_the_run_nor_the_tiles() {
    let Some(gpu) = common::gpu() else { return };
    let mut scene = common::crossing(8);
    scene.mode = Mode::Full;
    let first = gpu.render(&scene, &|_| ()).unwrap();
    let mut renderer = gpu;
    for tile_pixels in [1 << 19, 8000, 1] {
        renderer = renderer.with_tile_pixels(tile_pixels);
        let again = renderer.render(&scene, &|_| ()).unwrap();
        for eye in Eye::BOTH {
            let bits = |frame: &Frame| -> Vec<u32> {
                let pixels = frame.eye(eye).pixels.iter();
                pixels.flat_map(common::numbers).map(f32::to_bits).collect()
            };
            assert!(
                bits(&again) == bits(&first),
                "{tile_pixels} pixels a tile, {eye:?}"
            );
        }
    }
}

/// Everything the comparison is there to find, made by hand from the reference.
#[test]
fn comparison_finds_shifts_gains_swaps_nan_and_missing_references() {
    let scene = common::crossing(8);
    let reference = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let samples = Samples {
        outline: 21.0,
        inner: 5.0,
    };
    compare(&reference, &reference, samples).unwrap();
    let fails = |name: &str, change: &dyn Fn(&mut Frame), says: &str| {
        let mut wrong = reference.clone();
        change(&mut wrong);
        let message = compare(&wrong, &reference, samples).expect_err(name);
        assert!(message.contains(says), "{name}: {message}");
    };
    fails(
        "shift by 1 px",
        &|f| f.left.pixels.rotate_right(1),
        "differ",
    );
    let brighter = |f: &mut Frame| {
        for pixel in &mut f.right.pixels {
            pixel.radiance = pixel.radiance.map(|v| 1.01 * v);
        }
    };
    fails("gain of 1 %", &brighter, "right: light");
    fails(
        "swapped eyes",
        &|f| core::mem::swap(&mut f.left, &mut f.right),
        "differ",
    );
    fails(
        "NaN",
        &|f| f.left.pixels[77].direct[1] = f32::NAN,
        "not finite",
    );
    let at_edge = at_edges(&reference.left, 2)
        .iter()
        .position(|edge| *edge)
        .unwrap();
    fails(
        "NaN at an edge",
        &|f| f.left.pixels[at_edge].clean[2] = f32::NAN,
        "instead of",
    );
    fails(
        "depth off by 1e-4",
        &|f| f.left.pixels.iter_mut().for_each(|p| p.depth_m *= 1.0001),
        "depth",
    );
    let none = EyeFrame {
        width_px: 0,
        height_px: 0,
        pixels: Vec::new(),
    };
    let missing = Frame {
        left: none.clone(),
        right: none,
        ..reference.clone()
    };
    assert!(
        compare(&reference, &missing, samples)
            .unwrap_err()
            .contains("no reference")
    );
    assert!(compare(&missing, &reference, samples).is_err());
}
