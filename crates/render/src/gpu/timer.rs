//! How long each pass took, by the adapter's own clock.

use wgpu::BufferUsages;

use super::device::Gpu;
use super::passes::STAGES;
use crate::RenderError;

/// A time before and one after every stage.
const STAMPS: u32 = 2 * STAGES.len() as u32;
const SIZE: u64 = 8 * STAMPS as u64;

/// The clock of one tile.
#[derive(Debug)]
pub(super) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    back: wgpu::Buffer,
}

impl Timer {
    /// `None` on an adapter that does not tell the time.
    pub(super) fn new(device: &Gpu) -> Option<Self> {
        let d = &device.device;
        let buffer = |label, usage| {
            d.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: SIZE,
                usage,
                mapped_at_creation: false,
            })
        };
        d.features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| Self {
                queries: d.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stages"),
                    ty: wgpu::QueryType::Timestamp,
                    count: STAMPS,
                }),
                resolved: buffer(
                    "stages",
                    BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                ),
                back: buffer(
                    "stages, back",
                    BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                ),
            })
    }

    /// What a pass is begun with.
    pub(super) fn of_stage(&self, stage: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * stage as u32;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    pub(super) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..STAMPS, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.back, 0, SIZE);
    }

    /// Adds the stages of a finished submission, s.
    pub(super) fn add(
        &self,
        device: &Gpu,
        sums: &mut [f64; STAGES.len()],
    ) -> Result<(), RenderError> {
        let ticks: Vec<u64> = device.mapped(&self.back, SIZE, |bytes| {
            let (words, _) = bytes.as_chunks::<8>();
            words.iter().map(|word| u64::from_le_bytes(*word)).collect()
        })?;
        let tick_s = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        for (sum, pair) in sums.iter_mut().zip(ticks.chunks(2)) {
            *sum += pair[1].saturating_sub(pair[0]) as f64 * tick_s;
        }
        Ok(())
    }
}
