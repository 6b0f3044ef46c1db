//! Marine snow on the adapter. Places, their order and the pixels they touch come from the reference's own code; their light, what they
//! cover and what they hide is done here.

use std::sync::Arc;

use encase::ShaderSize;
use rodsight_geometry::{MountedCamera, Vec3};
use rodsight_shaders::{COMPOSE, FLAKES, Pass};
use wgpu::BufferUsages;

use super::device::Gpu;
use super::layout;
use super::passes::{PerVariant, Variant, module, pipeline};
use super::tile::{Tile, TileBuffers};
use super::timer::SNOW;
use super::upload::storage;
use crate::RenderError;
use crate::cpu::snow::place::{Place, places};
use crate::cpu::world::World;

const PASSES: [Pass; 2] = [FLAKES, COMPOSE];
/// Particles of a workgroup, and the edge of a square of pixels of one.
const GROUP: u32 = 64;
const SQUARE: u32 = 8;

/// The passes of the snow.
#[derive(Debug)]
pub(super) struct SnowPasses {
    modules: [wgpu::ShaderModule; 2],
    pipelines: PerVariant<[wgpu::ComputePipeline; 2]>,
}

impl SnowPasses {
    pub(super) fn new(device: &Gpu) -> Self {
        Self {
            modules: PASSES.map(|pass| module(&device.device, pass)),
            pipelines: PerVariant::default(),
        }
    }

    pub(super) fn of(
        &self,
        device: &Gpu,
        variant: Variant,
        groups: [&wgpu::BindGroupLayout; 2],
    ) -> Arc<[wgpu::ComputePipeline; 2]> {
        self.pipelines.get(variant, || {
            core::array::from_fn(|k| {
                let (pass, module) = (PASSES[k], &self.modules[k]);
                let groups = groups.map(Some);
                pipeline(&device.device, pass, module, &groups, &variant.constants())
            })
        })
    }
}

/// The particles that an eye may see, and which pixels they touch.
#[derive(Debug)]
pub(super) struct Snow {
    count: u32,
    pub(super) flakes: wgpu::Buffer,
    pub(super) first: wgpu::Buffer,
    pub(super) pairs: wgpu::Buffer,
}

impl Snow {
    /// `None` where there is none.
    ///
    /// # Errors
    /// More particles than the adapter's buffers hold.
    pub(super) fn new(
        device: &Gpu,
        world: &World<'_>,
        mounted: &MountedCamera,
    ) -> Result<Option<Self>, RenderError> {
        let i = mounted.camera.intrinsics();
        let size = [i.width_px as usize, i.height_px as usize];
        let places = places(world.scene, mounted);
        if places.is_empty() {
            return Ok(None);
        }
        let (first, pairs) = pixels_of(&places, size);
        let origin_m = mounted.rig_from_camera.origin_m();
        let flakes = places.iter().map(|place| flake(place, &origin_m)).collect();
        let buffer =
            |label, contents: Vec<u8>| device.filled(label, &contents, BufferUsages::STORAGE);
        let count = places.len() as u32;
        let groups = device.limits.max_compute_workgroups_per_dimension;
        device.check(
            "workgroups of snow",
            count.div_ceil(GROUP).into(),
            groups.into(),
        )?;
        Ok(Some(Self {
            count,
            flakes: buffer("particles of snow", storage::<layout::Flake>(flakes))?,
            first: buffer("pixels of snow", storage(first))?,
            pairs: buffer("pairs of particle and pixel", storage(pairs))?,
        }))
    }

    /// Puts the snow into a tile; before the first one it is lit.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &[wgpu::ComputePipeline; 2],
        scene: &wgpu::BindGroup,
        buffers: &TileBuffers,
        tile: &Tile,
    ) {
        let [light, compose] = pipelines;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("snow"),
            timestamp_writes: buffers.timer.as_ref().map(|timer| timer.of_stage(SNOW)),
        });
        pass.set_bind_group(0, scene, &[]);
        pass.set_bind_group(1, &buffers.group, &[]);
        if tile.kept.start == 0 {
            pass.set_pipeline(light);
            pass.dispatch_workgroups(self.count.div_ceil(GROUP), 1, 1);
        }
        pass.set_pipeline(compose);
        let rows = tile.kept.end - tile.kept.start;
        pass.dispatch_workgroups(tile.width.div_ceil(SQUARE), rows.div_ceil(SQUARE), 1);
    }
}

/// Every pixel's first pair, and the pairs: in each pixel in the order of the particles.
fn pixels_of(places: &[Place], [width, height]: [usize; 2]) -> (Vec<u32>, Vec<layout::SnowPair>) {
    let pixels = |place: &Place| {
        let (rows, columns) = (place.span(1, height), place.span(0, width));
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    };
    let mut first = vec![0_u32; width * height + 1];
    for pixel in places.iter().flat_map(pixels) {
        first[pixel + 1] += 1;
    }
    for pixel in 0..width * height {
        first[pixel + 1] += first[pixel];
    }
    let mut next = first.clone();
    let mut pairs = vec![layout::SnowPair::default(); first[width * height] as usize];
    for (index, place) in places.iter().enumerate() {
        for pixel in pixels(place) {
            pairs[next[pixel] as usize].flake = index as u32;
            next[pixel] += 1;
        }
    }
    (first, pairs)
}

fn flake(place: &Place, from_m: &Vec3) -> layout::Flake {
    let [[a, b], [c, d]] = place.disc_per_px;
    let pixel = place.at_px.map(libm::floor);
    layout::Flake {
        centre_m: (place.centre_m - from_m).into(),
        range_m: place.range_m as f32,
        from_m: (place.from_m - from_m).into(),
        opacity: place.opacity as f32,
        aside: place.axes[0].into(),
        gain: place.gain as f32,
        disc_per_px: [a, b, c, d].into(),
        pixel: pixel.map(|at| at as isize).into(),
        inside_px: [place.at_px[0] - pixel[0], place.at_px[1] - pixel[1]].into(),
        is_small: place.is_small().into(),
        is_round: place.is_round().into(),
        lit_from: Vec3::z().into(),
        ..layout::Flake::default()
    }
}

/// Bytes of snow's buffers where there is none.
pub(super) const NONE: [u64; 3] = [
    layout::Flake::SHADER_SIZE.get(),
    4,
    layout::SnowPair::SHADER_SIZE.get(),
];
