//! Many pairs, several at a time: while one is rendered, the one before is copied back and the one before that encoded and written.

use core::num::NonZeroUsize;
use core::ops::Range;
use std::sync::mpsc::{Receiver, sync_channel};

use rodsight_scene::Scene;

use crate::{Frame, RenderError, Renderer, expose};

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
    mut take: impl FnMut(u64, Scene, Frame) -> Result<(), E>,
) -> Result<(), E> {
    let pair = |number| {
        let scene = scene(number)?;
        let frame = expose(renderer, &scene, &|_| ())?;
        Ok((scene, frame))
    };
    let pair = &pair;
    std::thread::scope(|scope| {
        // Each worker renders every n-th pair and waits until it is taken; when this ends early, it sends to nobody and ends too.
        let workers: Vec<Receiver<Result<(Scene, Frame), E>>> = (0..in_flight.get())
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
            let (scene, frame) = pair?;
            take(number, scene, frame)?;
        }
        Ok(())
    })
}
