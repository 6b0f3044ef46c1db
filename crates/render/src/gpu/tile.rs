//! Tiles: as many rows of an image as the adapter's buffers take at a time, and the way back of their pixels.

use core::ops::Range;

use encase::ShaderSize;
use wgpu::BufferUsages;

use super::Wanted;
use super::device::Gpu;
use super::layout;
use super::loops::Loops;
use super::passes::{Passes, STAGES};
use super::snow::{self, Snow};
use super::timer::{SNOW, Timer, Times, WEIGH};
use crate::RenderError;
use crate::frame::PixelTruth;

/// Planes of the buffers, 4 bytes a pixel each; see `tile.wgsl`.
const KEY_PLANES: u64 = 4;
const LIGHT_PLANES: u64 = 9;
/// After them those of light that is to be spread, which is not read back, and those of snow.
const SOURCE_PLANES: u64 = 3;
const SNOW_PLANES: u64 = 4;
/// Things told apart in a pixel at an edge.
pub(super) const THINGS: u64 = 8;
/// Bytes of such a pixel's sources.
const SOURCE_BYTES: u64 = 16 * THINGS;
const SURFACE_PLANES: u64 = 10;

const TAG_INSTANCE: u32 = 0xffff;
const TAG_IN_VIEW: u32 = 0x1_0000;
const TAG_OCCLUDED: u32 = 0x2_0000;

/// Some rows of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) width: u32,
    /// Rows that are cast: those that are kept and, where there are any, their neighbours.
    pub(super) cast: Range<u32>,
    pub(super) kept: Range<u32>,
}

impl Tile {
    /// Cuts an image into tiles of at most so many pixels; those whose light is to be spread hold more of each.
    pub(super) fn cut(
        device: &Gpu,
        [width, height]: [u32; 2],
        most_pixels: u64,
        is_spread: bool,
    ) -> Result<Vec<Self>, RenderError> {
        let limits = &device.limits;
        let binding = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        // The copy back holds light and surface in one buffer.
        let bytes = if is_spread {
            SOURCE_BYTES
        } else {
            4 * SURFACE_PLANES
        };
        let pixels = (binding / bytes)
            .min(limits.max_buffer_size / (4 * (LIGHT_PLANES + SURFACE_PLANES + SNOW_PLANES)))
            .min(u64::from(limits.max_compute_workgroups_per_dimension) * 64);
        // One row with its neighbours must fit.
        device.check("pixels of a tile", 3 * u64::from(width), pixels)?;
        device.check(
            "workgroups per dimension",
            u64::from(width.div_ceil(8)),
            limits.max_compute_workgroups_per_dimension.into(),
        )?;
        let rows = (most_pixels.min(pixels) / u64::from(width))
            .saturating_sub(2)
            .max(1);
        let rows = u32::try_from(rows).unwrap_or(u32::MAX).min(height);
        Ok((0..height.div_ceil(rows))
            .map(|i| {
                let kept = i * rows..(i * rows).saturating_add(rows).min(height);
                Self {
                    width,
                    cast: kept.start.saturating_sub(1)..(kept.end + 1).min(height),
                    kept,
                }
            })
            .collect())
    }

    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.cast.end - self.cast.start)
    }

    pub(super) fn rows(&self) -> u32 {
        self.cast.end - self.cast.start
    }
}

/// The buffers of a tile, used again by the next one.
#[derive(Debug)]
pub(super) struct TileBuffers {
    uniform: wgpu::Buffer,
    light: wgpu::Buffer,
    surface: wgpu::Buffer,
    has_snow: bool,
    pub(super) indirect: wgpu::Buffer,
    /// Where the channels are wanted.
    back: Option<wgpu::Buffer>,
    pub(super) group: wgpu::BindGroup,
    pub(super) written: wgpu::BindGroup,
    pub(super) read: wgpu::BindGroup,
    pub(super) timer: Option<Timer>,
}

impl TileBuffers {
    /// Buffers for tiles up to a size, whose light is to be spread or not, behind some snow or none; to be read or not.
    pub(super) fn new(
        device: &Gpu,
        passes: &Passes,
        largest: u64,
        is_spread: bool,
        snow: Option<&Snow>,
        wanted: Wanted,
        loops: &Loops,
    ) -> Self {
        let d = &device.device;
        let buffer = |label, size, usage| {
            d.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let copied = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let uniform = buffer(
            "tile",
            layout::Tile::SHADER_SIZE.get(),
            BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        );
        let keys = buffer("keys", 4 * KEY_PLANES * largest, BufferUsages::STORAGE);
        let source_bytes = if is_spread {
            SOURCE_BYTES * largest
        } else {
            SOURCE_BYTES
        };
        let planes = LIGHT_PLANES + SOURCE_PLANES + if snow.is_some() { SNOW_PLANES } else { 0 };
        let mut stages: Vec<usize> = (0..STAGES.len()).collect();
        stages.extend(snow.map(|_| SNOW));
        stages.extend(is_spread.then_some(WEIGH));
        let light = buffer("light", 4 * planes * largest, copied);
        let sources = buffer("sources", source_bytes, BufferUsages::STORAGE);
        let surface = buffer("surface", 4 * SURFACE_PLANES * largest, copied);
        let edges = buffer("edges", 4 * largest, BufferUsages::STORAGE);
        let indirect = buffer(
            "edge count",
            layout::Indirect::SHADER_SIZE.get(),
            BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_DST,
        );
        let is_read = wanted == Wanted::Channels;
        let back = is_read.then(|| {
            buffer(
                "back",
                4 * (LIGHT_PLANES + SURFACE_PLANES + SNOW_PLANES) * largest,
                BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            )
        });
        let none = snow::NONE.map(|bytes| buffer("no snow", bytes, BufferUsages::STORAGE));
        let [flakes, first, pairs] = match snow {
            Some(snow) => [&snow.flakes, &snow.first, &snow.pairs],
            None => none.each_ref(),
        };
        let bind = |label, layout, buffers: &[&wgpu::Buffer]| bind_group(d, label, layout, buffers);
        Self {
            group: bind(
                "tile",
                &passes.tile,
                &[
                    &uniform,
                    &keys,
                    &light,
                    &surface,
                    &edges,
                    &sources,
                    flakes,
                    first,
                    pairs,
                    &loops.buffer,
                ],
            ),
            written: bind("edge count, written", &passes.written, &[&indirect]),
            read: bind("edge count, read", &passes.read, &[&indirect]),
            uniform,
            light,
            surface,
            indirect,
            back,
            timer: is_read.then(|| Timer::new(device, stages)).flatten(),
            has_snow: snow.is_some(),
        }
    }

    /// Makes the buffers ready for a tile.
    pub(super) fn prepare(&self, device: &Gpu, tile: &Tile) {
        let header = layout::Tile {
            width: tile.width,
            first_row: tile.cast.start,
            rows: tile.rows(),
            kept_from: tile.kept.start - tile.cast.start,
            kept_to: tile.kept.end - tile.cast.start,
            has_snow: self.has_snow.into(),
        };
        let mut bytes = encase::UniformBuffer::new(Vec::new());
        bytes.write(&header).expect("a vector grows");
        device
            .queue
            .write_buffer(&self.uniform, 0, &bytes.into_inner());
        let none = layout::Indirect {
            x: 0,
            y: 0,
            z: 1,
            count: 0,
        };
        let mut bytes = encase::StorageBuffer::new(Vec::new());
        bytes.write(&none).expect("a vector grows");
        device
            .queue
            .write_buffer(&self.indirect, 0, &bytes.into_inner());
    }

    fn back(&self) -> &wgpu::Buffer {
        let back = self.back.as_ref();
        back.expect("only where the channels are wanted")
    }

    /// Copies the planes, and the times of the passes, where they can be read.
    pub(super) fn encode_copy(&self, encoder: &mut wgpu::CommandEncoder, tile: &Tile) {
        let back = self.back();
        let (light, surface) = (
            4 * LIGHT_PLANES * tile.pixels(),
            4 * SURFACE_PLANES * tile.pixels(),
        );
        encoder.copy_buffer_to_buffer(&self.light, 0, back, 0, light);
        encoder.copy_buffer_to_buffer(&self.surface, 0, back, light, surface);
        if self.has_snow {
            let from = 4 * (LIGHT_PLANES + SOURCE_PLANES) * tile.pixels();
            let size = 4 * SNOW_PLANES * tile.pixels();
            encoder.copy_buffer_to_buffer(&self.light, from, back, light + surface, size);
        }
        if let Some(timer) = &self.timer {
            timer.encode(encoder);
        }
    }

    /// Waits for a tile and writes its pixels into the rows of its image that it keeps. Adds the times of its passes, s.
    pub(super) fn read(
        &self,
        device: &Gpu,
        submission: wgpu::SubmissionIndex,
        tile: &Tile,
        rows: &mut [PixelTruth],
        times: &mut Times,
    ) -> Result<(), RenderError> {
        device.wait(submission)?;
        let snow = if self.has_snow { SNOW_PLANES } else { 0 };
        let size = 4 * (LIGHT_PLANES + SURFACE_PLANES + snow) * tile.pixels();
        device.mapped(self.back(), size, |bytes| unpack(bytes, tile, rows))?;
        self.timer
            .as_ref()
            .map_or(Ok(()), |timer| timer.add(device, times))
    }
}

pub(super) fn bind_group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
        .iter()
        .enumerate()
        .map(|(i, buffer)| wgpu::BindGroupEntry {
            binding: i as u32,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// Planes to pixels.
fn unpack(bytes: &[u8], tile: &Tile, rows: &mut [PixelTruth]) {
    use rayon::prelude::*;

    let (words, _) = bytes.as_chunks::<4>();
    let (width, pixels) = (tile.width as usize, tile.pixels() as usize);
    let first = (tile.kept.start - tile.cast.start) as usize * width;
    rows.par_chunks_mut(width)
        .enumerate()
        .for_each(|(row, out)| {
            for (column, out) in out.iter_mut().enumerate() {
                let at = first + row * width + column;
                let value = |plane: usize| f32::from_le_bytes(words[plane * pixels + at]);
                let three = |plane: usize| [value(plane), value(plane + 1), value(plane + 2)];
                let (direct, backscatter) = (three(0), three(3));
                let surface = LIGHT_PLANES as usize;
                let tag = value(surface + 9).to_bits();
                let mut pixel = PixelTruth {
                    direct,
                    backscatter,
                    clean: three(6),
                    transmission: three(surface),
                    ..PixelTruth::NOTHING
                };
                let snow = surface + SURFACE_PLANES as usize;
                if words.len() > snow * pixels {
                    pixel.snow = three(snow);
                    pixel.snow_cover = value(snow + 3);
                }
                pixel.sum_radiance();
                let instance = tag & TAG_INSTANCE;
                if instance != 0 {
                    pixel.normal = three(surface + 3);
                    pixel.depth_m = value(surface + 6);
                    pixel.range_m = value(surface + 7);
                    pixel.instance = instance as u16;
                    pixel.occluded = tag & TAG_OCCLUDED != 0;
                    if tag & TAG_IN_VIEW != 0 {
                        pixel.disparity_px = value(surface + 8);
                    }
                }
                *out = pixel;
            }
        });
}
