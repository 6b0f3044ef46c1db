//! Automatic exposure: one sample of all by its rank, exactly, though no radiance comes back.

use encase::ShaderSize;
use wgpu::{BindGroup, BufferUsages};

use super::ShootPasses;
use super::film::Film;
use crate::RenderError;
use crate::gpu::device::Gpu;
use crate::gpu::layout;
use crate::gpu::tile::bind_group;

/// See `meter.wgsl` and `tally.wgsl`.
const BINS: u64 = 2048;
const RUN_PX: usize = 4096;
/// Bits below those that a step counts: 10, 11 and 11 of them.
const SHIFTS: [u32; 3] = [22, 11, 0];

/// The sample of a rank among those of both eyes after white balance, in the order of `f32::total_cmp`.
pub(super) fn of_rank(
    device: &Gpu,
    passes: &ShootPasses,
    films: [(&Film, &BindGroup); 2],
    rank: usize,
) -> Result<f32, RenderError> {
    let d = &device.device;
    let buffer = |label, size, usage| {
        d.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let start = layout::Meter {
        found: 0,
        rank: rank as u32,
        shift: SHIFTS[0],
    };
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    bytes.write(&start).expect("a vector grows");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let meter = device.filled("meter", &bytes.into_inner(), usage)?;
    let bins = buffer("bins", 4 * BINS, BufferUsages::STORAGE);
    let size = layout::Meter::SHADER_SIZE.get();
    let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
    let back = buffer("meter, back", size, usage);
    let group = bind_group(d, "meter", &passes.meter, &[&meter, &bins]);

    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_bind_group(1, &group, &[]);
    for _ in SHIFTS {
        pass.set_pipeline(&passes.tally);
        for (film, light) in films {
            pass.set_bind_group(0, light, &[]);
            pass.dispatch_workgroups(film.pixels().div_ceil(RUN_PX) as u32, 1, 1);
        }
        pass.set_pipeline(&passes.rank);
        pass.dispatch_workgroups(1, 1, 1);
    }
    drop(pass);
    encoder.copy_buffer_to_buffer(&meter, 0, &back, 0, size);
    device.wait(device.queue.submit([encoder.finish()]))?;
    device.mapped(&back, size, |bytes| {
        let (words, _) = bytes.as_chunks::<4>();
        let key = u32::from_le_bytes(words[0]);
        // Back from the key, in whose order floats are sorted as they should.
        f32::from_bits(if key >> 31 == 1 { key ^ 1 << 31 } else { !key })
    })
}
