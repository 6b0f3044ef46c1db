//! Pipelines, their bindings, and the passes of one tile.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rodsight_shaders::{BACKSCATTER, CENTRE, MARK, Pass, REFINE};

use super::SceneBuffers;
use super::device::Gpu;
use super::halo::HaloPasses;
use super::shoot::ShootPasses;
use super::snow::SnowPasses;
use super::tile::{Tile, TileBuffers};
use crate::RenderError;

/// The passes of a tile, in their order.
pub(super) const STAGES: [Pass; 4] = [CENTRE, BACKSCATTER, MARK, REFINE];

/// Edge of the square of pixels of a workgroup.
const GROUP: u32 = 8;
/// Storage buffers of the scene's group, after its uniform.
const SCENE_BUFFERS: u32 = 13;
/// Storage buffers of the tile's group, after its uniform.
const TILE_BUFFERS: u32 = 9;

/// What is compiled into the passes of an eye; see `scene.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "a scene has any of them or not"
)]
pub(super) struct Variant {
    pub(super) mode: u32,
    pub(super) eye_lens: u32,
    pub(super) other_lens: u32,
    pub(super) eye_port: u32,
    pub(super) other_port: u32,
    pub(super) has_seabed: bool,
    pub(super) has_phase_table: bool,
    pub(super) has_airlight_table: bool,
    pub(super) has_finish: bool,
    pub(super) has_bodies: bool,
    pub(super) has_mesh: bool,
    pub(super) has_ripples: bool,
}

impl Variant {
    pub(super) fn constants(self) -> [(&'static str, f64); 12] {
        [
            ("MODE", self.mode),
            ("EYE_LENS", self.eye_lens),
            ("OTHER_LENS", self.other_lens),
            ("EYE_PORT", self.eye_port),
            ("OTHER_PORT", self.other_port),
            ("HAS_SEABED", self.has_seabed.into()),
            ("PHASE_TABLE", self.has_phase_table.into()),
            ("AIRLIGHT_TABLE", self.has_airlight_table.into()),
            ("HAS_FINISH", self.has_finish.into()),
            ("HAS_BODIES", self.has_bodies.into()),
            ("HAS_MESH", self.has_mesh.into()),
            ("HAS_RIPPLES", self.has_ripples.into()),
        ]
        .map(|(name, value)| (name, f64::from(value)))
    }
}

/// The pipelines of a variant, in the order of [`STAGES`].
pub(super) type Pipelines = Arc<[wgpu::ComputePipeline; STAGES.len()]>;

/// What was compiled so far, by variant.
#[derive(Debug)]
pub(super) struct PerVariant<T>(Mutex<Vec<(Variant, Arc<T>)>>);

impl<T> Default for PerVariant<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> PerVariant<T> {
    /// What belongs to a variant, compiled when it is first asked for.
    pub(super) fn get(&self, variant: Variant, compile: impl FnOnce() -> T) -> Arc<T> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, compiled)) = all.iter().find(|(known, _)| *known == variant) {
            return Arc::clone(compiled);
        }
        let compiled = Arc::new(compile());
        all.push((variant, Arc::clone(&compiled)));
        compiled
    }
}

/// The passes, and the pipelines that were asked for so far.
#[derive(Debug)]
pub(super) struct Passes {
    pub(super) scene: wgpu::BindGroupLayout,
    pub(super) tile: wgpu::BindGroupLayout,
    /// The count of edges, written by `mark` and read by `refine`.
    pub(super) written: wgpu::BindGroupLayout,
    pub(super) read: wgpu::BindGroupLayout,
    modules: [wgpu::ShaderModule; STAGES.len()],
    pipelines: PerVariant<[wgpu::ComputePipeline; STAGES.len()]>,
    halo: OnceLock<HaloPasses>,
    snow: OnceLock<SnowPasses>,
    shoot: OnceLock<ShootPasses>,
}

impl Passes {
    pub(super) fn new(device: &Gpu) -> Result<Self, RenderError> {
        device.watched(|| {
            let d = &device.device;
            Ok(Self {
                scene: group(d, "scene", &uniform_and(SCENE_BUFFERS, true)),
                tile: group(d, "tile", &uniform_and(TILE_BUFFERS, false)),
                written: group(d, "edge count, written", &[storage(0, false)]),
                read: group(d, "edge count, read", &[storage(0, true)]),
                modules: STAGES.map(|pass| module(d, pass)),
                pipelines: PerVariant::default(),
                halo: OnceLock::new(),
                snow: OnceLock::new(),
                shoot: OnceLock::new(),
            })
        })
    }

    /// The passes of the halo, compiled when they are first asked for.
    pub(super) fn halo(&self, device: &Gpu) -> &HaloPasses {
        self.halo
            .get_or_init(|| HaloPasses::new(device, &self.scene, &self.tile))
    }

    /// The passes of the snow, for a variant.
    pub(super) fn snow(&self, device: &Gpu, variant: Variant) -> Arc<[wgpu::ComputePipeline; 2]> {
        let passes = self.snow.get_or_init(|| SnowPasses::new(device));
        passes.of(device, variant, [&self.scene, &self.tile])
    }

    /// The passes from light to images, compiled when they are first asked for.
    pub(super) fn shoot(&self, device: &Gpu) -> &ShootPasses {
        self.shoot
            .get_or_init(|| ShootPasses::new(&device.device, &self.tile))
    }

    /// The pipelines of a variant.
    pub(super) fn of(&self, device: &Gpu, variant: Variant) -> Pipelines {
        self.pipelines.get(variant, || {
            core::array::from_fn(|stage| {
                let pass = STAGES[stage];
                let third = match pass {
                    MARK => Some(&self.written),
                    REFINE => Some(&self.read),
                    _ => None,
                };
                let constants = variant.constants();
                // `mark` casts no rays.
                let constants: &[_] = if pass == MARK { &[] } else { &constants };
                let layouts = [Some(&self.scene), Some(&self.tile), third];
                pipeline(
                    &device.device,
                    pass,
                    &self.modules[stage],
                    &layouts,
                    constants,
                )
            })
        })
    }
}

pub(super) fn module(device: &wgpu::Device, pass: Pass) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(pass.name),
        source: wgpu::ShaderSource::Wgsl(pass.source().into()),
    })
}

pub(super) fn pipeline(
    device: &wgpu::Device,
    pass: Pass,
    module: &wgpu::ShaderModule,
    groups: &[Option<&wgpu::BindGroupLayout>],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(pass.name),
        bind_group_layouts: groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(pass.name),
        layout: Some(&layout),
        module,
        entry_point: Some(pass.name),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    })
}

/// All passes of a tile.
pub(super) fn encode(
    encoder: &mut wgpu::CommandEncoder,
    scene: &SceneBuffers,
    buffers: &TileBuffers,
    tile: &Tile,
) {
    for (stage, pipeline) in scene.pipelines.iter().enumerate() {
        let third = match STAGES[stage] {
            MARK => Some(&buffers.written),
            REFINE => Some(&buffers.read),
            _ => None,
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(STAGES[stage].name),
            timestamp_writes: buffers.timer.as_ref().map(|timer| timer.of_stage(stage)),
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &scene.group, &[]);
        pass.set_bind_group(1, &buffers.group, &[]);
        if let Some(third) = third {
            pass.set_bind_group(2, third, &[]);
        }
        if STAGES[stage] == REFINE {
            pass.dispatch_workgroups_indirect(&buffers.indirect, 0);
        } else {
            let groups = |pixels: u32| pixels.div_ceil(GROUP);
            pass.dispatch_workgroups(groups(tile.width), groups(tile.rows()), 1);
        }
    }
}

pub(super) fn storage(binding: u32, read_only: bool) -> wgpu::BindGroupLayoutEntry {
    entry(binding, wgpu::BufferBindingType::Storage { read_only })
}

pub(super) fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
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

pub(super) fn group(
    device: &wgpu::Device,
    label: &str,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries,
    })
}
