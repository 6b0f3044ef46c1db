//! How long each pass took, by the adapter's own clock.

use wgpu::BufferUsages;

use super::device::Gpu;
use crate::RenderError;

/// What is timed: the passes of a tile, its snow, the weighing of mode `full`, and what it does when all tiles are there.
pub(super) const TIMED: [&str; 7] = [
    "centre",
    "backscatter",
    "mark",
    "refine",
    "snow",
    "weigh",
    "halo",
];
pub(super) const SNOW: usize = 4;
pub(super) const WEIGH: usize = 5;
pub(super) const HALO: usize = 6;
/// Of each, s.
pub(super) type Times = [f64; TIMED.len()];

/// The clock of some stages: a time before and one after each.
#[derive(Debug)]
pub(super) struct Timer {
    stages: Vec<usize>,
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    back: wgpu::Buffer,
}

impl Timer {
    /// `None` on an adapter that does not tell the time.
    pub(super) fn new(device: &Gpu, stages: Vec<usize>) -> Option<Self> {
        let d = &device.device;
        let stamps = 2 * stages.len() as u32;
        let buffer = |label, usage| {
            d.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 8 * u64::from(stamps),
                usage,
                mapped_at_creation: false,
            })
        };
        d.features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| Self {
                stages,
                queries: d.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stages"),
                    ty: wgpu::QueryType::Timestamp,
                    count: stamps,
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
        let place = self.stages.iter().position(|known| *known == stage);
        let first = 2 * place.expect("a stage of this clock") as u32;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// What a pass is begun with that is the first or the last of a stage of several.
    pub(super) fn of_part(
        &self,
        stage: usize,
        is_first: bool,
        is_last: bool,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let whole = self.of_stage(stage);
        (is_first || is_last).then(|| wgpu::ComputePassTimestampWrites {
            beginning_of_pass_write_index: whole.beginning_of_pass_write_index.filter(|_| is_first),
            end_of_pass_write_index: whole.end_of_pass_write_index.filter(|_| is_last),
            ..whole
        })
    }

    pub(super) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let stamps = 2 * self.stages.len() as u32;
        encoder.resolve_query_set(&self.queries, 0..stamps, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.back, 0, self.back.size());
    }

    /// Adds the stages of a finished submission, s.
    pub(super) fn add(&self, device: &Gpu, sums: &mut Times) -> Result<(), RenderError> {
        let ticks: Vec<u64> = device.mapped(&self.back, self.back.size(), |bytes| {
            let (words, _) = bytes.as_chunks::<8>();
            words.iter().map(|word| u64::from_le_bytes(*word)).collect()
        })?;
        let tick_s = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        for (stage, pair) in self.stages.iter().zip(ticks.chunks(2)) {
            sums[*stage] += pair[1].saturating_sub(pair[0]) as f64 * tick_s;
        }
        Ok(())
    }
}
