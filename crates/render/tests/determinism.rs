//! The same bytes whatever the number of threads, and what the seed may change.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Eye, Vec3};
use rodsight_render::{CpuRenderer, Developed, Frame, Renderer, develop};
use rodsight_scene::Scene;

fn scene(seed: u64) -> Scene {
    let mut scene = common::wet(8);
    scene.seed = seed;
    // Grains that this coarse image resolves.
    scene.seabed.as_mut().unwrap().texture_scale_m = 0.8;
    scene.rods.push(common::orange_rod(
        Vec3::new(2.2, -0.1, -0.9),
        Vec3::new(0.2, 0.3, 1.0),
        0.05,
    ));
    scene
}

fn with_threads(threads: usize, scene: &Scene) -> (Frame, Developed) {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let frame = CpuRenderer.render(scene, &|_| ()).unwrap();
        let developed = develop(&frame, scene).unwrap();
        (frame, developed)
    })
}

fn bits(frame: &Frame, eye: Eye) -> Vec<u32> {
    let pixels = frame.eye(eye).pixels.iter();
    pixels.flat_map(common::numbers).map(f32::to_bits).collect()
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads_or_the_run() {
    let scene = scene(1);
    let (first, first_images) = with_threads(1, &scene);
    for threads in [1, 2, 5] {
        let (frame, images) = with_threads(threads, &scene);
        for eye in Eye::BOTH {
            assert!(
                bits(&frame, eye) == bits(&first, eye),
                "{threads} threads, {} eye",
                eye.name()
            );
        }
        assert!(images == first_images, "{threads} threads");
    }
}

#[test]
fn another_seed_changes_noise_and_texture_only() {
    let (one, one_images) = with_threads(2, &scene(1));
    let (two, two_images) = with_threads(2, &scene(2));
    assert!(one_images.left != two_images.left && one_images.right != two_images.right);
    let (mut floor, mut changed) = (0, 0);
    for eye in Eye::BOTH {
        for (a, b) in one.eye(eye).pixels.iter().zip(&two.eye(eye).pixels) {
            let geometry = |p: &rodsight_render::PixelTruth| {
                let all = common::numbers(p);
                all[15..].iter().map(|v| v.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(geometry(a), geometry(b));
            assert_eq!(a.backscatter, b.backscatter);
            if a.instance == 1 && a.range_m < 5.0 {
                floor += 1;
                changed += u32::from(a.radiance != b.radiance);
            }
        }
    }
    assert!(
        floor > 500 && changed * 10 > floor * 9,
        "{changed} of {floor}"
    );
}
