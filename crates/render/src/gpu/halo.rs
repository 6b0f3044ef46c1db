//! The halo of mode `full` on the adapter: what `cpu/halo.rs` does, in the same order.
//!
//! Every tile leaves its light by widths in buffers of the whole image. When all have, the light around the image is cast, summed over
//! cells, and blurred from the widest to the finest. A sum has one order, whatever the tiles.

mod shape;

use encase::ShaderSize;
use rodsight_geometry::MountedCamera;
use rodsight_optics::Halo;
use rodsight_shaders::{BLUR_COLUMNS, BLUR_ROWS, FAR, GATHER, OVERSCAN, Pass, WEIGH};
use wgpu::BufferUsages;

use super::Wanted;
use super::device::Gpu;
use super::layout::{self, Vec4f};
use super::loops::Loops;
use super::passes::{PerVariant, Variant, entry, group, module, pipeline, storage};
use super::tile::{Tile, TileBuffers, bind_group};
use super::timer::{HALO, Timer, Times, WEIGH as WEIGH_STAGE};
use super::upload::storage as packed;
use crate::RenderError;
use crate::cpu::halo::FINE;
use crate::cpu::overscan::overscan_px;
use crate::frame::EyeFrame;
use shape::{RUN_PX, Shape};

/// Edge of the square of pixels of a workgroup, and invocations of one along a row.
const SQUARE: u32 = 8;
const ROW: u32 = 64;
/// Cells of a workgroup that casts rays beyond the overscan.
const FAR_CELLS: u32 = 4;

/// The passes of the halo.
#[derive(Debug)]
pub(super) struct HaloPasses {
    levels: wgpu::BindGroupLayout,
    image: wgpu::BindGroupLayout,
    blur: wgpu::BindGroupLayout,
    weigh: wgpu::ComputePipeline,
    /// By an invocation each cell, and by a workgroup.
    gather: [wgpu::ComputePipeline; 2],
    rows: wgpu::ComputePipeline,
    columns: wgpu::ComputePipeline,
    modules: [wgpu::ShaderModule; 2],
    /// Those that cast rays: of the overscan, and beyond it.
    casts: PerVariant<[wgpu::ComputePipeline; 2]>,
}

/// The pipelines of [`CASTS`].
type Casts = std::sync::Arc<[wgpu::ComputePipeline; 2]>;

const CASTS: [Pass; 2] = [OVERSCAN, FAR];

impl HaloPasses {
    pub(super) fn new(
        device: &Gpu,
        scene: &wgpu::BindGroupLayout,
        tile: &wgpu::BindGroupLayout,
    ) -> Self {
        let d = &device.device;
        let uniform = |binding, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset,
                min_binding_size: None,
            },
            ..entry(binding, wgpu::BufferBindingType::Uniform)
        };
        let levels_group = group(d, "halo", &[uniform(0, false), uniform(1, true)]);
        let image: Vec<_> = (0..8)
            .map(|binding| storage(binding, binding == 0))
            .collect();
        let image_group = group(d, "halo of an image", &image);
        let blur = [storage(0, true), storage(1, true), storage(2, false)];
        let blur_group = group(d, "blur", &blur);
        let compiled = |pass: Pass, groups: [Option<&_>; 4], constants: &[_]| {
            pipeline(d, pass, &module(d, pass), &groups, constants)
        };
        let (levels, image) = (Some(&levels_group), Some(&image_group));
        let blur = Some(&blur_group);
        Self {
            weigh: compiled(WEIGH, [None, Some(tile), levels, image], &[]),
            gather: [1, ROW].map(|lanes| {
                let groups = [Some(scene), None, levels, image];
                compiled(GATHER, groups, &[("LANES", f64::from(lanes))])
            }),
            rows: compiled(BLUR_ROWS, [None, blur, levels, None], &[]),
            columns: compiled(BLUR_COLUMNS, [None, blur, levels, None], &[]),
            modules: CASTS.map(|pass| module(d, pass)),
            casts: PerVariant::default(),
            levels: levels_group,
            image: image_group,
            blur: blur_group,
        }
    }

    /// The pipelines of a variant that cast rays.
    pub(super) fn casts(
        &self,
        device: &Gpu,
        scene: &wgpu::BindGroupLayout,
        variant: Variant,
    ) -> Casts {
        let layouts = [Some(scene), None, Some(&self.levels), Some(&self.image)];
        self.casts.get(variant, || {
            core::array::from_fn(|k| {
                let (pass, module) = (CASTS[k], &self.modules[k]);
                pipeline(&device.device, pass, module, &layouts, &variant.constants())
            })
        })
    }
}

/// Buffers of the halo of an eye.
#[derive(Debug)]
pub(super) struct HaloEye {
    shape: Shape,
    level: u32,
    levels: wgpu::BindGroup,
    image: wgpu::BindGroup,
    casts: Casts,
    /// Along rows and along columns, by level from 1.
    blurs: Vec<[wgpu::BindGroup; 2]>,
    pub(super) unspread: wgpu::Buffer,
    /// Where the channels are wanted.
    back: Option<wgpu::Buffer>,
    timer: Option<Timer>,
}

impl HaloEye {
    /// # Errors
    /// An image too large for the adapter's buffers.
    pub(super) fn new(
        device: &Gpu,
        passes: &HaloPasses,
        casts: Casts,
        halo: &Halo,
        mounted: &MountedCamera,
        wanted: Wanted,
        loops: &Loops,
    ) -> Result<Self, RenderError> {
        let d = &device.device;
        let i = mounted.camera.intrinsics();
        let shape = Shape::new(
            [i.width_px, i.height_px],
            overscan_px(mounted),
            halo.levels(),
        );
        let limits = &device.limits;
        let binding = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let buffer = |label: &'static str, floats: u64, usage| {
            let size = 4 * floats.max(4);
            device.check(label, size, binding)?;
            Ok(d.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            }))
        };
        let plane = |label, floats| buffer(label, floats, BufferUsages::STORAGE);
        let (knots, longest_m) = halo.knots();
        let shares: Vec<Vec4f> = knots
            .iter()
            .flat_map(|[red, green, blue]| {
                (0..Halo::LEVELS).map(|j| [red[j], green[j], blue[j], 0.0].into())
            })
            .collect();
        let shares = device.filled("halo: shares", &packed(shares), BufferUsages::STORAGE)?;
        let outside = plane(
            "halo: bytes around the image",
            4 * u64::from(shape.patches()),
        )?;
        let unspread = buffer(
            "halo: bytes of the image",
            shape.image_floats(),
            BufferUsages::STORAGE | BufferUsages::COPY_SRC,
        )?;
        let fine = "halo: bytes of the image with a margin";
        let (one_px, two_px) = (
            plane(fine, shape.fine_floats())?,
            plane(fine, shape.fine_floats())?,
        );
        let runs = plane("halo: bytes of sums along rows", shape.run_floats())?;
        let cells = plane("halo: bytes of cells", shape.cell_floats())?;
        let rows = plane("halo: bytes of blurred rows", shape.row_floats())?;
        let sums = [
            plane("halo: bytes of blurred cells", shape.blurred_floats(FINE))?,
            plane(
                "halo: bytes of blurred cells",
                shape.blurred_floats(FINE + 1),
            )?,
        ];
        let is_read = wanted == Wanted::Channels;
        let back = is_read.then(|| {
            buffer(
                "halo: bytes of the image, back",
                shape.image_floats(),
                BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            )
        });

        let mut bytes = encase::UniformBuffer::new(Vec::new());
        let uniform = layout::Halo {
            longest_m: longest_m as f32,
            knots: knots.len() as u32,
            ..shape.uniform()
        };
        bytes.write(&uniform).expect("a vector grows");
        let uniform = device.filled("halo", &bytes.into_inner(), BufferUsages::UNIFORM)?;
        let level = limits.min_uniform_buffer_offset_alignment.max(16);
        let indices: Vec<u8> = (0..Halo::LEVELS as u32)
            .flat_map(|index| {
                let mut bytes = vec![0; level as usize];
                bytes[..4].copy_from_slice(&index.to_le_bytes());
                bytes
            })
            .collect();
        let indices = device.filled("halo: levels", &indices, BufferUsages::UNIFORM)?;
        let levels = d.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("halo"),
            layout: &passes.levels,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: uniform.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &indices,
                        offset: 0,
                        size: core::num::NonZero::new(u32::SHADER_SIZE.get()),
                    }),
                },
            ],
        });
        let blur = |buffers: [&wgpu::Buffer; 3]| bind_group(d, "blur", &passes.blur, &buffers);
        let blurs = (1..shape.levels())
            .map(|at| {
                let coarser = &sums[(at.max(FINE - 1) + 1 - FINE) % 2];
                let (source, sum) = match at {
                    1 => (&one_px, &unspread),
                    2 => (&two_px, &unspread),
                    _ => (&cells, &sums[(at - FINE) % 2]),
                };
                // Rows are not added to anything: any buffer does.
                [blur([source, source, &rows]), blur([&rows, coarser, sum])]
            })
            .collect();
        Ok(Self {
            level,
            levels,
            image: bind_group(
                d,
                "halo of an image",
                &passes.image,
                &[
                    &shares,
                    &outside,
                    &unspread,
                    &one_px,
                    &two_px,
                    &runs,
                    &cells,
                    &loops.buffer,
                ],
            ),
            casts,
            blurs,
            unspread,
            back: back.transpose()?,
            timer: is_read.then(|| Timer::new(device, vec![HALO])).flatten(),
            shape,
        })
    }

    /// Weighs the light of a tile.
    pub(super) fn encode_weigh(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &HaloPasses,
        buffers: &TileBuffers,
        tile: &Tile,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(WEIGH.name),
            timestamp_writes: buffers
                .timer
                .as_ref()
                .map(|timer| timer.of_stage(WEIGH_STAGE)),
        });
        pass.set_pipeline(&passes.weigh);
        pass.set_bind_group(1, &buffers.group, &[]);
        pass.set_bind_group(2, &self.levels, &[0]);
        pass.set_bind_group(3, &self.image, &[]);
        pass.dispatch_workgroups(
            tile.width.div_ceil(RUN_PX).div_ceil(SQUARE),
            (tile.kept.end - tile.kept.start).div_ceil(SQUARE),
            1,
        );
    }

    /// Spreads the light of all tiles, and copies it where it can be read if it is to be.
    pub(super) fn encode_spread(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &HaloPasses,
        scene: &wgpu::BindGroup,
    ) {
        // A pass each time other groups are bound: wgpu 30 does not bind those again that come after one that is left out.
        let begin = |encoder: &mut wgpu::CommandEncoder, is_first, is_last| {
            let timer = self.timer.as_ref();
            encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("halo"),
                    timestamp_writes: timer
                        .and_then(|timer| timer.of_part(HALO, is_first, is_last)),
                })
                .forget_lifetime()
        };
        let mut pass = begin(encoder, true, false);
        self.bind_image(&mut pass, scene, 0);
        pass.set_pipeline(&self.casts[0]);
        pass.dispatch_workgroups(self.shape.patches().div_ceil(ROW), 1, 1);
        for at in (1..self.shape.levels()).rev() {
            let level = self.shape.level(at);
            if at >= FINE {
                drop(pass);
                pass = begin(encoder, false, false);
                let [columns, rows] = level.cells();
                self.bind_image(&mut pass, scene, at);
                if self.shape.is_far(at) {
                    pass.set_pipeline(&self.casts[1]);
                    pass.dispatch_workgroups(columns, rows.div_ceil(FAR_CELLS), 1);
                }
                let across = if level.is_wide() {
                    columns
                } else {
                    columns.div_ceil(ROW)
                };
                pass.set_pipeline(&passes.gather[usize::from(level.is_wide())]);
                pass.dispatch_workgroups(across, rows, 1);
            }
            drop(pass);
            pass = begin(encoder, false, at == 1);
            let [[row_floats, all_rows], [_, rows]] = level.blurred();
            let [along_rows, along_columns] = &self.blurs[at - 1];
            pass.set_bind_group(2, &self.levels, &[self.level * at as u32]);
            pass.set_pipeline(&passes.rows);
            pass.set_bind_group(1, along_rows, &[]);
            pass.dispatch_workgroups(row_floats.div_ceil(ROW), all_rows, 1);
            pass.set_pipeline(&passes.columns);
            pass.set_bind_group(1, along_columns, &[]);
            pass.dispatch_workgroups(row_floats.div_ceil(ROW), rows, 1);
        }
        drop(pass);
        if let Some(back) = &self.back {
            let size = 4 * self.shape.image_floats();
            encoder.copy_buffer_to_buffer(&self.unspread, 0, back, 0, size);
        }
        if let Some(timer) = &self.timer {
            timer.encode(encoder);
        }
    }

    fn bind_image(&self, pass: &mut wgpu::ComputePass<'_>, scene: &wgpu::BindGroup, level: usize) {
        pass.set_bind_group(0, scene, &[]);
        pass.set_bind_group(2, &self.levels, &[self.level * level as u32]);
        pass.set_bind_group(3, &self.image, &[]);
    }

    /// Waits for the halo and adds it to its image. Adds the time it took, s.
    pub(super) fn read(
        &self,
        device: &Gpu,
        submission: wgpu::SubmissionIndex,
        frame: &mut EyeFrame,
        times: &mut Times,
    ) -> Result<(), RenderError> {
        use rayon::prelude::*;

        device.wait(submission)?;
        let back = self.back.as_ref();
        let back = back.expect("only where the channels are wanted");
        device.mapped(back, 4 * self.shape.image_floats(), |bytes| {
            let (words, _) = bytes.as_chunks::<4>();
            let pairs = frame.pixels.par_iter_mut().zip(words.par_chunks(3));
            pairs.for_each(|(pixel, forward)| {
                pixel.forward = core::array::from_fn(|k| f32::from_le_bytes(forward[k]));
                pixel.sum_radiance();
            });
        })?;
        self.timer
            .as_ref()
            .map_or(Ok(()), |timer| timer.add(device, times))
    }
}
