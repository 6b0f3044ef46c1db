//! Pipelines, their bindings, and the passes of one tile.

use rodsight_shaders::{BACKSCATTER, CENTRE, MARK, Pass, REFINE};

use super::device::Gpu;
use super::tile::{Tile, TileBuffers};
use crate::RenderError;

/// Edge of the square of pixels of a workgroup.
const GROUP: u32 = 8;
/// Storage buffers of the scene's group, after its uniform.
const SCENE_BUFFERS: u32 = 8;
/// Storage buffers of the tile's group, after its uniform.
const TILE_BUFFERS: u32 = 4;

/// The compiled passes.
#[derive(Debug)]
pub(super) struct Passes {
    pub(super) scene: wgpu::BindGroupLayout,
    pub(super) tile: wgpu::BindGroupLayout,
    /// The count of edges, written by `mark` and read by `refine`.
    pub(super) written: wgpu::BindGroupLayout,
    pub(super) read: wgpu::BindGroupLayout,
    centre: wgpu::ComputePipeline,
    backscatter: wgpu::ComputePipeline,
    mark: wgpu::ComputePipeline,
    refine: wgpu::ComputePipeline,
}

impl Passes {
    pub(super) fn new(device: &Gpu) -> Result<Self, RenderError> {
        device.watched(|| {
            let d = &device.device;
            let scene = group(d, "scene", &uniform_and(SCENE_BUFFERS, true));
            let tile = group(d, "tile", &uniform_and(TILE_BUFFERS, false));
            let written = group(d, "edge count, written", &[storage(0, false)]);
            let read = group(d, "edge count, read", &[storage(0, true)]);
            let pipeline = |pass: &Pass, third: Option<&wgpu::BindGroupLayout>| {
                let layout = d.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(pass.name),
                    bind_group_layouts: &[Some(&scene), Some(&tile), third],
                    immediate_size: 0,
                });
                let module = d.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(pass.name),
                    source: wgpu::ShaderSource::Wgsl(pass.source().into()),
                });
                d.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(pass.name),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some(pass.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
            };
            Ok(Self {
                centre: pipeline(&CENTRE, None),
                backscatter: pipeline(&BACKSCATTER, None),
                mark: pipeline(&MARK, Some(&written)),
                refine: pipeline(&REFINE, Some(&read)),
                scene,
                tile,
                written,
                read,
            })
        })
    }

    /// All passes of a tile.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &wgpu::BindGroup,
        buffers: &TileBuffers,
        tile: &Tile,
    ) {
        let pass = |encoder: &mut wgpu::CommandEncoder,
                    pipeline: &wgpu::ComputePipeline,
                    label: &str,
                    third: Option<&wgpu::BindGroup>| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(label),
                timestamp_writes: None,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, scene, &[]);
            pass.set_bind_group(1, &buffers.group, &[]);
            if let Some(third) = third {
                pass.set_bind_group(2, third, &[]);
            }
            if label == REFINE.name {
                pass.dispatch_workgroups_indirect(&buffers.indirect, 0);
            } else {
                pass.dispatch_workgroups(
                    tile.width.div_ceil(GROUP),
                    tile.rows().div_ceil(GROUP),
                    1,
                );
            }
        };
        pass(encoder, &self.centre, CENTRE.name, None);
        pass(encoder, &self.backscatter, BACKSCATTER.name, None);
        pass(encoder, &self.mark, MARK.name, Some(&buffers.written));
        pass(encoder, &self.refine, REFINE.name, Some(&buffers.read));
    }
}

fn storage(binding: u32, read_only: bool) -> wgpu::BindGroupLayoutEntry {
    entry(binding, wgpu::BufferBindingType::Storage { read_only })
}

fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn uniform_and(buffers: u32, read_only: bool) -> Vec<wgpu::BindGroupLayoutEntry> {
    let uniform = entry(0, wgpu::BufferBindingType::Uniform);
    core::iter::once(uniform)
        .chain((1..=buffers).map(|binding| storage(binding, read_only)))
        .collect()
}

fn group(
    device: &wgpu::Device,
    label: &str,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries,
    })
}
