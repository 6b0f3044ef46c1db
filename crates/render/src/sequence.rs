//! Many pairs, several at a time: while one is rendered, the one before is copied back and the one before that encoded and written.

use core::num::NonZeroUsize;
use core::ops::Range;
use std::sync::mpsc::{Receiver, sync_channel};

use rodsight_scene::Scene;

use crate::{Developed, Frame, RenderError, Renderer, expose};

/// Renders the scenes of a range of numbers, up to `in_flight` of them at a time, and hands each over in the order of the numbers to
/// `take`, which runs on the calling thread while others are rendered.
///
/// A pair depends on its scene alone: neither `in_flight` nor where the range begins changes a byte, so that a run that was
/// interrupted may go on anywhere. Memory holds `in_flight` pairs besides the one handed over, however long the range.
///
/// # Errors
/// The first, by number, that making a scene, rendering or `take` gives; those before it have been handed over.
pub fn render_sequence<E: From<RenderError> + Send>(
    renderer: &(dyn Renderer + Sync),
    numbers: Range<u64>,
    in_flight: NonZeroUsize,
    scene: impl Fn(u64) -> Result<Scene, E> + Sync,
    take: impl FnMut(u64, Scene, Frame) -> Result<(), E>,
) -> Result<(), E> {
    let expose = |scene: &Scene| expose(renderer, scene, &|_| ());
    in_order(numbers, in_flight, scene, expose, take)
}

/// [`render_sequence`] where images are enough: [`Renderer::shoot`] for each scene.
///
/// # Errors
/// As [`render_sequence`].
pub fn shoot_sequence<E: From<RenderError> + Send>(
    renderer: &(dyn Renderer + Sync),
    numbers: Range<u64>,
    in_flight: NonZeroUsize,
    scene: impl Fn(u64) -> Result<Scene, E> + Sync,
    take: impl FnMut(u64, Scene, Developed) -> Result<(), E>,
) -> Result<(), E> {
    let shoot = |scene: &Scene| renderer.shoot(scene, &|_| ());
    in_order(numbers, in_flight, scene, shoot, take)
}

fn in_order<T: Send, E: From<RenderError> + Send>(
    numbers: Range<u64>,
    in_flight: NonZeroUsize,
    scene: impl Fn(u64) -> Result<Scene, E> + Sync,
    render: impl Fn(&Scene) -> Result<T, RenderError> + Sync,
    mut take: impl FnMut(u64, Scene, T) -> Result<(), E>,
) -> Result<(), E> {
    let pair = |number| {
        let scene = scene(number)?;
        let rendered = render(&scene)?;
        Ok((scene, rendered))
    };
    let pair = &pair;
    std::thread::scope(|scope| {
        // Each worker renders every n-th pair and waits until it is taken; when this ends early, it sends to nobody and ends too.
        let workers: Vec<Receiver<Result<(Scene, T), E>>> = (0..in_flight.get())
            .map(|worker| {
                let (hand_over, handed_over) = sync_channel(0);
                let own = numbers.clone().skip(worker).step_by(in_flight.get());
                scope.spawn(move || {
                    for number in own {
                        if hand_over.send(pair(number)).is_err() {
                            break;
                        }
                    }
                });
                handed_over
            })
            .collect();
        for (number, worker) in numbers.zip(workers.iter().cycle()) {
            // A worker that is gone has panicked, and the scope will say so.
            let Ok(pair) = worker.recv() else { break };
            let (scene, rendered) = pair?;
            take(number, scene, rendered)?;
        }
        Ok(())
    })
}
