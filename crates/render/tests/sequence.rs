//! Many pairs at a time: the same bytes, in order, wherever it begins.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "helpers of tests may panic"
)]

mod common;

use core::num::NonZeroUsize;
use core::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rodsight_geometry::{Eye, Vec3};
use rodsight_render::{
    CpuRenderer, Developed, Frame, RenderError, Renderer, render_sequence, shoot_sequence,
};
use rodsight_scene::Scene;

/// A rod that moves with the number.
fn scene(number: u64) -> Scene {
    let mut scene = common::wet(16);
    scene.seed = number;
    let y_m = 0.1 * number as f64 - 0.4;
    let direction = Vec3::new(0.2, 0.3, 1.0);
    scene.rods.push(common::orange_rod(
        Vec3::new(2.2, y_m, -0.9),
        direction,
        0.05,
    ));
    scene
}

fn bits(frame: &Frame) -> Vec<u32> {
    let eyes = Eye::BOTH.into_iter();
    let pixels = eyes.flat_map(|eye| &frame.eye(eye).pixels);
    pixels.flat_map(common::numbers).map(f32::to_bits).collect()
}

fn run(renderer: &(dyn Renderer + Sync), numbers: Range<u64>, in_flight: usize) -> Vec<Vec<u32>> {
    let (mut next, mut frames) = (numbers.start, Vec::new());
    let in_flight = NonZeroUsize::new(in_flight).unwrap();
    let given = |number| Ok::<_, RenderError>(scene(number));
    render_sequence(
        renderer,
        numbers,
        in_flight,
        given,
        |number, scene, frame| {
            assert_eq!((number, scene.seed), (next, next));
            next += 1;
            frames.push(bits(&frame));
            Ok(())
        },
    )
    .unwrap();
    frames
}

fn check(renderer: &(dyn Renderer + Sync)) {
    let one_by_one: Vec<Vec<u32>> = (0..7)
        .map(|number| bits(&renderer.render(&scene(number), &|_| ()).unwrap()))
        .collect();
    assert!(one_by_one[0] != one_by_one[1], "the rod moves");
    for in_flight in [1, 2, 3, 9] {
        assert!(
            run(renderer, 0..7, in_flight) == one_by_one,
            "{in_flight} in flight"
        );
    }
    // Taken up again at the fifth.
    assert!(run(renderer, 4..7, 2) == one_by_one[4..]);
    assert!(run(renderer, 3..3, 2).is_empty());
    let mut images: Vec<Developed> = Vec::new();
    let given = |number| Ok::<_, RenderError>(scene(number));
    let in_flight = NonZeroUsize::new(3).unwrap();
    shoot_sequence(renderer, 2..7, in_flight, given, |number, _, pair| {
        assert_eq!(number, 2 + images.len() as u64);
        images.push(pair);
        Ok(())
    })
    .unwrap();
    let one_by_one = (2..7).map(|number| renderer.shoot(&scene(number), &|_| ()).unwrap());
    assert!(images == one_by_one.collect::<Vec<_>>(), "images");
}

#[test]
fn pairs_in_flight_change_no_byte_on_the_cpu() {
    check(&CpuRenderer);
}

#[test]
fn pairs_in_flight_change_no_byte_on_the_gpu() {
    if let Some(gpu) = common::gpu() {
        check(&gpu);
    }
}

/// The number of an error, wherever it came from.
#[derive(Debug, PartialEq)]
struct Failed(u64);

impl From<RenderError> for Failed {
    fn from(_: RenderError) -> Self {
        Self(99)
    }
}

#[test]
fn the_first_error_ends_it_after_all_before_it() {
    let in_flight = NonZeroUsize::new(3).unwrap();
    let taken = AtomicU64::new(0);
    let take = |number, _: Scene, _: Frame| {
        taken.fetch_add(1, Ordering::Relaxed);
        if number == 5 {
            Err(Failed(number))
        } else {
            Ok(())
        }
    };
    let given = |number| {
        if number >= 3 {
            Err(Failed(number))
        } else {
            Ok(scene(number))
        }
    };
    let result = render_sequence(&CpuRenderer, 0..1000, in_flight, given, take);
    assert_eq!(
        (result, taken.swap(0, Ordering::Relaxed)),
        (Err(Failed(3)), 3)
    );
    let given = |number| Ok(scene(number));
    let result = render_sequence(&CpuRenderer, 0..1000, in_flight, given, take);
    assert_eq!(
        (result, taken.swap(0, Ordering::Relaxed)),
        (Err(Failed(5)), 6)
    );
    // A scene that cannot be rendered.
    let huge = |number| {
        let mut scene = scene(number);
        let i = *scene.rig.left.camera.intrinsics();
        let wide = rodsight_geometry::Intrinsics {
            width_px: 1 << 14,
            height_px: 1 << 14,
            ..i
        };
        scene.rig.left.camera =
            rodsight_geometry::Camera::new(wide, rodsight_geometry::Distortion::None).unwrap();
        Ok(scene)
    };
    let result = render_sequence(&CpuRenderer, 0..9, in_flight, huge, take);
    assert_eq!((result, taken.into_inner()), (Err(Failed(99)), 0));
}
