//! What goes wrong on a device is an error, never a black image.

use rodsight_geometry::{Camera, Distortion, Intrinsics, Mat3, Pose, Vec3};
use rodsight_scene::{Mesh, MeshMaterial, MeshPart, Prop};

use super::*;

/// The founding scene on few pixels.
fn scene() -> Scene {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/paper.toml");
    let mut scene = Scene::load(&path).unwrap();
    let intrinsics = Intrinsics {
        width_px: 64,
        height_px: 40,
        fx_px: 50.0,
        fy_px: 50.0,
        cx_px: 32.0,
        cy_px: 20.0,
    };
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        mounted.camera = Camera::new(intrinsics, Distortion::None).unwrap();
    }
    scene
}

/// A renderer, or none where there is no adapter and none is demanded.
fn renderer() -> Option<GpuRenderer> {
    match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(renderer) => Some(renderer),
        Err(error @ RenderError::NoAdapter { .. })
            if std::env::var("RODSIGHT_REQUIRE_GPU").as_deref() != Ok("1") =>
        {
            println!("SKIPPED: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// That the device is lost, as a message that names it.
fn is_lost<T>(result: Result<T, RenderError>, adapter: &str) {
    let Err(error) = result else {
        panic!("an image from a lost device");
    };
    assert!(matches!(error, RenderError::Device { .. }), "{error}");
    let message = error.to_string();
    assert!(
        message.contains("the device is lost") && message.contains(adapter),
        "{message}"
    );
}

#[test]
fn lost_device_is_an_error_each_time() {
    let Some(renderer) = renderer() else { return };
    let scene = scene();
    assert!(renderer.render(&scene, &|_| ()).is_ok());
    renderer.device.device.destroy();
    for _ in 0..2 {
        is_lost(renderer.render(&scene, &|_| ()), &renderer.adapter());
        is_lost(renderer.shoot(&scene, &|_| ()), &renderer.adapter());
    }
}

/// In every mode, after the first tile or later.
#[test]
fn device_lost_at_work_is_an_error() {
    for (mode, after) in [
        (Mode::Single, 0.0),
        (Mode::Single, 0.5),
        (Mode::Full, 0.0),
        (Mode::Full, 0.9),
    ] {
        let mut scene = scene();
        scene.mode = mode;
        for is_shot in [false, true] {
            let Some(renderer) = renderer() else { return };
            let renderer = renderer.with_tile_pixels(400);
            let lose = |done: f64| {
                if done >= after {
                    renderer.device.device.destroy();
                }
            };
            let adapter = renderer.adapter();
            if is_shot {
                is_lost(renderer.shoot(&scene, &lose), &adapter);
            } else {
                is_lost(renderer.render(&scene, &lose), &adapter);
            }
        }
    }
}

/// A mesh that the adapter cannot hold: the message names the limit and what is too large for it.
#[test]
fn mesh_beyond_a_limit_is_refused_by_the_limit() {
    let Some(mut renderer) = renderer() else {
        return;
    };
    let mut scene = scene();
    let strip = |i: u32| {
        let y = i as f32 * 1e-4;
        [[1.0, y, 0.0], [1.0, y, 0.1]]
    };
    let mesh = Mesh {
        parts: vec![MeshPart {
            positions_m: (0..4000).flat_map(strip).collect(),
            normals: vec![[-1.0, 0.0, 0.0]; 8000],
            triangles: (0..7998).map(|i| [i, i + 1, i + 2]).collect(),
            ..MeshPart::default()
        }],
        materials: vec![MeshMaterial {
            name: "grey".to_owned(),
            base: [0.5; 3],
            metallic: 0.0,
            roughness: 1.0,
            texture: None,
        }],
        ..Mesh::default()
    };
    scene.props.push(Prop {
        id: "strip".to_owned(),
        mesh: Arc::new(mesh),
        rig_from_prop: Pose::new(Mat3::identity(), Vec3::new(2.0, 0.0, 0.0)),
        scale: 1.0,
    });
    assert!(renderer.render(&scene, &|_| ()).is_ok());
    // 8000 vertices of 32 bytes each.
    renderer.device.limits.max_storage_buffer_binding_size = 255_999;
    let Err(error) = renderer.render(&scene, &|_| ()) else {
        panic!("more than the limit");
    };
    let RenderError::AdapterLimit {
        limit,
        wanted,
        found,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!((*found, *wanted), (255_999, 256_000), "{limit}");
    assert!(
        limit.contains("max_storage_buffer_binding_size") && limit.contains("vertices"),
        "{limit}"
    );
}

/// A ray through the hard-edged beams of 16 lamps, which no table holds, takes 65 536 points, more than Mesa's software driver
/// walks through.
#[test]
fn loops_that_a_driver_cuts_are_an_error() {
    let Some(renderer) = renderer() else { return };
    let mut scene = scene();
    for lamp in &mut scene.lamps {
        lamp.inner_half_angle_rad = 0.02;
        lamp.outer_half_angle_rad = 0.02;
    }
    scene.lamps = scene.lamps.iter().cycle().take(16).copied().collect();
    let mut cut = |points| {
        scene.sampling.airlight_points = points;
        let frame = renderer.render(&scene, &|_| ()).map(|_| ());
        let image = renderer.shoot(&scene, &|_| ()).map(|_| ());
        let is_cut = |result| match result {
            Ok(()) => false,
            Err(RenderError::LoopsCut { .. }) => true,
            Err(error) => panic!("{error}"),
        };
        (is_cut(frame), is_cut(image))
    };
    assert_eq!(cut(256), (false, false));
    if renderer.adapter().contains("llvmpipe") {
        assert_eq!(cut(4096), (true, true));
    }
}
