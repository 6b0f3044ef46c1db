//! Whether the driver walked through all loops: see `loops.wgsl`.

use encase::ShaderSize;
use wgpu::BufferUsages;

use super::device::Gpu;
use super::layout;
use crate::RenderError;

/// What the passes of a pair say of their loops.
#[derive(Debug)]
pub(super) struct Loops {
    pub(super) buffer: wgpu::Buffer,
    back: wgpu::Buffer,
}

impl Loops {
    const BYTES: u64 = layout::Loops::SHADER_SIZE.get();

    pub(super) fn new(device: &Gpu) -> Result<Self, RenderError> {
        let start = layout::Loops {
            steps: 2,
            are_cut: 0,
        };
        let mut bytes = encase::StorageBuffer::new(Vec::new());
        bytes.write(&start).expect("a vector grows");
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self {
            buffer: device.filled("loops", &bytes.into_inner(), usage)?,
            back: device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("loops, back"),
                size: Self::BYTES,
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        })
    }

    /// Waits for all that was submitted.
    ///
    /// # Errors
    /// The driver ended loops before their time.
    pub(super) fn check(&self, device: &Gpu) -> Result<(), RenderError> {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = device.device.create_command_encoder(&descriptor);
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &self.back, 0, Self::BYTES);
        device.wait(device.queue.submit([encoder.finish()]))?;
        let are_cut = device.mapped(&self.back, Self::BYTES, |bytes| bytes[4..] != [0; 4])?;
        if are_cut {
            return Err(RenderError::LoopsCut {
                adapter: device.adapter.clone(),
            });
        }
        Ok(())
    }
}
