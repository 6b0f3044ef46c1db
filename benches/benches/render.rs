//! Speed of the renderer on the founding scene, one 1080p eye, all threads; "develop" is the pair.

use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rodsight_geometry::Eye;
use rodsight_render::{CpuRenderer, Frame, Renderer, develop};
use rodsight_scene::{Mode, Scene, Sensor};

fn founding_scene() -> Scene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    Scene::load(&scenes.join("paper.toml")).expect("a shipped scene loads")
}

fn render(criterion: &mut Criterion) {
    let mut scene = founding_scene();
    let i = *scene.rig.left.camera.intrinsics();
    let pixels = u64::from(i.width_px) * u64::from(i.height_px);
    let mut group = criterion.benchmark_group("render eye 1080p");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(10))
        .throughput(Throughput::Elements(pixels));
    for (name, mode) in [("air", Mode::Air), ("single", Mode::Single)] {
        scene.mode = mode;
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| CpuRenderer.render_eye(black_box(&scene), Eye::Left, &|_| ()));
        });
    }
    group.finish();
}

fn sensor(criterion: &mut Criterion) {
    let mut scene = founding_scene();
    scene.mode = Mode::Air;
    let left = CpuRenderer
        .render_eye(&scene, Eye::Left, &|_| ())
        .expect("air is implemented");
    let frame = Frame {
        right: left.clone(),
        left,
        backend: CpuRenderer.backend(),
        adapter: CpuRenderer.adapter(),
    };
    let samples = 2 * 3 * frame.left.pixels.len() as u64;
    let mut group = criterion.benchmark_group("develop pair 1080p");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(10))
        .throughput(Throughput::Elements(samples));
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

criterion_group!(benches, render, sensor);
criterion_main!(benches);
