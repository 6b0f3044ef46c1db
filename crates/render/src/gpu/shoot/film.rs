//! The light on an eye's sensor.

use rodsight_geometry::{Eye, Vec3};
use rodsight_scene::Scene;
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePipeline};

use super::ShootPasses;
use crate::RenderError;
use crate::gpu::device::Gpu;
use crate::gpu::layout;
use crate::gpu::tile::{Tile, bind_group};
use crate::gpu::upload;
use crate::lens::blur;

/// Edge of the square of pixels of a workgroup.
pub(super) const SQUARE: u32 = 8;
/// Bits of all bands.
pub(super) const ALL: u32 = 0b111;

pub(super) fn size_px(scene: &Scene, eye: Eye) -> [u32; 2] {
    let i = scene.rig.eye(eye).camera.intrinsics();
    [i.width_px, i.height_px]
}

/// The whole image of an eye.
#[derive(Debug)]
pub(super) struct Film {
    header: layout::Film,
    light: Buffer,
    weights: Buffer,
}

impl Film {
    pub(super) fn new(device: &Gpu, scene: &Scene, eye: Eye) -> Result<Self, RenderError> {
        let mounted = scene.rig.eye(eye);
        let [width, height] = size_px(scene, eye);
        // Without an aperture there is no diffraction: all bands are blurred alike.
        let weights = blur::kernel(scene.lens.psf_sigma_px);
        let header = layout::Film {
            camera: upload::camera(mounted, &Vec3::zeros()),
            lens: upload::lens(mounted),
            has_vignetting: scene.lens.vignetting.is_some().into(),
            vignetting: scene.lens.vignetting.unwrap_or_default().into(),
            width,
            height,
            balance: scene.white_balance.into(),
            reach: weights.len() as u32 - 1,
            ..layout::Film::default()
        };
        let weights = weights.into_iter().map(|w| w as f32).collect();
        let weights = upload::storage::<f32>(weights);
        Ok(Self {
            light: light(device, &header),
            weights: device.filled("blur", &weights, BufferUsages::STORAGE)?,
            header,
        })
    }

    pub(super) fn pixels(&self) -> usize {
        self.header.width as usize * self.header.height as usize
    }

    /// To write some bands of the light, with a halo or none.
    pub(super) fn group(
        &self,
        device: &Gpu,
        passes: &ShootPasses,
        bands: u32,
        halo: Option<&Buffer>,
    ) -> Result<BindGroup, RenderError> {
        let header = layout::Film {
            bands,
            has_halo: halo.is_some().into(),
            ..self.header
        };
        // Without a halo any buffer does.
        let source = halo.unwrap_or(&self.weights);
        self.bind(device, passes, &header, [&self.light, source])
    }

    fn bind(
        &self,
        device: &Gpu,
        passes: &ShootPasses,
        header: &layout::Film,
        [image, source]: [&Buffer; 2],
    ) -> Result<BindGroup, RenderError> {
        let mut bytes = encase::UniformBuffer::new(Vec::new());
        bytes.write(header).expect("a vector grows");
        let uniform = device.filled("film", &bytes.into_inner(), BufferUsages::UNIFORM)?;
        let buffers = [&uniform, image, source, &self.weights];
        Ok(bind_group(&device.device, "film", &passes.film, &buffers))
    }

    /// Blurs the light, and binds it to be read.
    pub(super) fn blurred(
        &self,
        device: &Gpu,
        passes: &ShootPasses,
    ) -> Result<BindGroup, RenderError> {
        if self.header.reach > 0 {
            let header = layout::Film {
                bands: ALL,
                ..self.header
            };
            let rows = light(device, &header);
            let mut encoder = device
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let ways = [[&rows, &self.light], [&self.light, &rows]];
            for (pipeline, buffers) in passes.smear.iter().zip(ways) {
                let group = self.bind(device, passes, &header, buffers)?;
                self.encode(&mut encoder, pipeline, &group);
            }
            device.queue.submit([encoder.finish()]);
        }
        self.group(device, passes, ALL, None)
    }

    /// A pass over all pixels.
    pub(super) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        pipeline: &ComputePipeline,
        group: &BindGroup,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        let [columns, rows] =
            [self.header.width, self.header.height].map(|size| size.div_ceil(SQUARE));
        pass.dispatch_workgroups(columns, rows, 1);
    }
}

fn light(device: &Gpu, header: &layout::Film) -> Buffer {
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("light of an image"),
        size: 12 * u64::from(header.width) * u64::from(header.height),
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}

/// Takes the light of a tile.
pub(super) fn encode_collect(
    encoder: &mut CommandEncoder,
    passes: &ShootPasses,
    film: &BindGroup,
    tiles: &BindGroup,
    tile: &Tile,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(&passes.collect);
    pass.set_bind_group(0, film, &[]);
    pass.set_bind_group(1, tiles, &[]);
    let rows = tile.kept.end - tile.kept.start;
    pass.dispatch_workgroups(tile.width.div_ceil(SQUARE), rows.div_ceil(SQUARE), 1);
}
