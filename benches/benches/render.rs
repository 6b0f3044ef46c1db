//! Speed of the renderer: pairs a second by mode, backend and size, and the cost of what a scene holds.
//!
//! "cpu" is the `f64` reference on all threads; "gpu" runs on the best adapter there is, whose name is printed: without a graphics card
//! that is a software driver on the same processor.

#![expect(
    clippy::print_stdout,
    reason = "says which adapter it measures, and what it leaves out"
)]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use rodsight_geometry::{Camera, Eye, Intrinsics, Mat3, Pose, Vec3};
use rodsight_render::{
    AdapterChoice, CpuRenderer, Developed, GpuRenderer, RenderError, Renderer, develop,
};
use rodsight_scene::{Mesh, MeshMaterial, MeshPart, Mode, Prop, Scene, Sensor, Snow};

const MODES: [(&str, Mode); 4] = [
    ("air", Mode::Air),
    ("koschmieder", Mode::Koschmieder),
    ("single", Mode::Single),
    ("full", Mode::Full),
];

fn founding_scene() -> Scene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    Scene::load(&scenes.join("paper.toml")).expect("a shipped scene loads")
}

/// The same view on fewer pixels.
fn resize(scene: &mut Scene, width_px: u32, height_px: u32) {
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let i = *mounted.camera.intrinsics();
        let (x, y) = (
            f64::from(width_px) / f64::from(i.width_px),
            f64::from(height_px) / f64::from(i.height_px),
        );
        let intrinsics = Intrinsics {
            width_px,
            height_px,
            fx_px: i.fx_px * x,
            fy_px: i.fy_px * x,
            cx_px: i.cx_px * x,
            cy_px: i.cy_px * y,
        };
        mounted.camera = Camera::new(intrinsics, *mounted.camera.distortion())
            .expect("a camera with fewer pixels is one");
    }
}

fn pixels(scene: &Scene) -> u64 {
    Eye::BOTH
        .map(|eye| scene.rig.eye(eye).camera.intrinsics())
        .iter()
        .map(|i| u64::from(i.width_px) * u64::from(i.height_px))
        .sum()
}

fn backends() -> Vec<Box<dyn Renderer>> {
    let mut all: Vec<Box<dyn Renderer>> = vec![Box::new(CpuRenderer)];
    match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(gpu) => all.push(Box::new(gpu)),
        Err(error) => println!("gpu left out: {error}"),
    }
    for backend in &all {
        println!("{}: {}", backend.backend(), backend.adapter());
    }
    all
}

fn slow<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    group
}

/// One line of a group: a renderer on a scene.
fn line(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: BenchmarkId,
    backend: &dyn Renderer,
    scene: &Scene,
) {
    let render = || backend.render(black_box(scene), &|_| ());
    group.bench_function(id, |b| b.iter(|| render().expect("the scene renders")));
}

fn modes(criterion: &mut Criterion) {
    let backends = backends();
    for (size, width_px, height_px) in [("1080p", 1920, 1080), ("640x512", 640, 512)] {
        let mut scene = founding_scene();
        resize(&mut scene, width_px, height_px);
        let mut group = slow(criterion, &format!("render pair {size}"));
        group.throughput(Throughput::Elements(pixels(&scene)));
        for (name, mode) in MODES {
            scene.mode = mode;
            for backend in &backends {
                let id = BenchmarkId::new(name, backend.backend());
                line(&mut group, id, backend.as_ref(), &scene);
            }
        }
        group.finish();
    }
}

/// Rods as a palisade behind the cable, the same area of it whatever their number.
fn with_rods(mut scene: Scene, count: usize) -> Scene {
    let like = scene.rods[0].clone();
    for i in 1..count {
        let place = i as f64 / count as f64 - 0.5;
        let mut rod = like.clone();
        rod.id = format!("rod_{i}");
        rod.centre_m = Vec3::new(3.5, 3.0 * place, -1.0);
        rod.direction = Vec3::z();
        rod.radius_m = 0.5 / count as f64;
        scene.rods.push(rod);
    }
    scene
}

fn with_lamps(mut scene: Scene, count: usize) -> Scene {
    let like = scene.lamps[0];
    scene.lamps = (0..count)
        .map(|i| {
            let mut lamp = like;
            lamp.position_m.y = 1.8 * (i as f64 + 0.5) / count as f64 - 0.9;
            lamp
        })
        .collect();
    scene
}

/// A wavy wall behind the cable, of about so many triangles.
fn with_triangles(mut scene: Scene, count: usize) -> Scene {
    let side = ((count / 2) as f64).sqrt().round() as u32;
    let vertex = |i: u32, j: u32| {
        let [y, z] = [i, j].map(|k| 4.0 * f64::from(k) / f64::from(side) - 2.0);
        let (slope_y, slope_z) = (0.6 * libm::cos(6.0 * y), 0.6 * libm::cos(6.0 * z));
        let x = 0.1 * (libm::sin(6.0 * y) + libm::sin(6.0 * z));
        let normal = Vec3::new(-1.0, slope_y, slope_z).normalize();
        [[x, y, z], [normal.x, normal.y, normal.z]].map(|v| v.map(|v| v as f32))
    };
    let vertices = (0..=side).flat_map(|j| (0..=side).map(move |i| vertex(i, j)));
    let (positions_m, normals) = vertices.map(|[at, normal]| (at, normal)).unzip();
    let row = side + 1;
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * row + i));
    let part = MeshPart {
        positions_m,
        normals,
        uvs: Vec::new(),
        triangles: cells
            .flat_map(|a| [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]])
            .collect(),
        material: 0,
    };
    let material = MeshMaterial {
        name: "wall".to_owned(),
        base: [0.4; 3],
        metallic: 0.0,
        roughness: 0.8,
        texture: None,
    };
    let mesh = Mesh {
        parts: vec![part],
        materials: vec![material],
        ..Mesh::default()
    };
    scene.props.push(Prop {
        id: "wall".to_owned(),
        mesh: Arc::new(mesh),
        rig_from_prop: Pose::new(Mat3::identity(), Vec3::new(3.5, 0.0, -1.0)),
        scale: 1.0,
    });
    scene
}

/// So many particles within 4 m of the cameras.
fn with_snow(mut scene: Scene, count: usize) -> Scene {
    scene.snow = Some(Snow {
        number_per_m3: count as f64 / (4.0 / 3.0 * core::f64::consts::PI * 64.0),
        diameter_m: [5e-4, 6e-3],
        exponent: 3.0,
        albedo: [0.15; 3],
        range_m: [0.15, 4.0],
        seed: None,
    });
    scene
}

fn contents(criterion: &mut Criterion) {
    let backends = backends();
    let mut scene = founding_scene();
    scene.mode = Mode::Single;
    resize(&mut scene, 640, 512);
    for (name, counts, with) in [
        (
            "rods",
            [1, 10, 50, 200],
            with_rods as fn(Scene, usize) -> Scene,
        ),
        ("lamps", [1, 2, 4, 8], with_lamps),
        (
            "triangles",
            [1000, 10_000, 100_000, 1_000_000],
            with_triangles,
        ),
        ("snow", [1000, 10_000, 100_000, 1_000_000], with_snow),
    ] {
        let mut group = slow(criterion, &format!("render pair 640x512 by {name}"));
        for count in counts {
            let scene = with(scene.clone(), count);
            for backend in &backends {
                let id = BenchmarkId::new(backend.backend(), count);
                line(&mut group, id, backend.as_ref(), &scene);
            }
        }
        group.finish();
    }
}

fn sensor(criterion: &mut Criterion) {
    let mut scene = founding_scene();
    scene.mode = Mode::Air;
    let frame = CpuRenderer
        .render(&scene, &|_| ())
        .expect("air is implemented");
    let mut group = slow(criterion, "develop pair 1080p");
    group.throughput(Throughput::Elements(3 * pixels(&scene)));
    let plain = Sensor::Plain {
        noise_sigma_dn: 2.0,
    };
    for (name, sensor) in [("emva", scene.sensor), ("plain", plain)] {
        scene.sensor = sensor;
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| develop(black_box(&frame), &scene));
        });
    }
    group.finish();
}

/// Images alone, by way of a frame and without: the same adapter, and what comes back from it.
fn images(criterion: &mut Criterion) {
    let gpu = match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(gpu) => gpu,
        Err(error) => return println!("images left out: {error}"),
    };
    println!("images: {}", gpu.adapter());
    let mut scene = founding_scene();
    let take = |scene: &Scene, by_frame| -> Result<Developed, RenderError> {
        if by_frame {
            return develop(&gpu.render(scene, &|_| ())?, scene);
        }
        gpu.shoot(scene, &|_| ())
    };
    let mut group = slow(criterion, "images of a pair 1080p");
    group.throughput(Throughput::Elements(pixels(&scene)));
    for (name, mode) in [("single", Mode::Single), ("full", Mode::Full)] {
        scene.mode = mode;
        for (way, by_frame) in [("by frame", true), ("shot", false)] {
            group.bench_function(BenchmarkId::new(name, way), |b| {
                let before = gpu.bytes_read();
                take(&scene, by_frame).expect("the scene renders");
                let bytes = gpu.bytes_read() - before;
                println!("{name}, {way}: {bytes} bytes come back");
                b.iter(|| take(black_box(&scene), by_frame));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, images, modes, contents, sensor);
criterion_main!(benches);
