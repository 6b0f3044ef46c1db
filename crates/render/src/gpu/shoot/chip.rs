//! Sensor and image of an eye.

use rodsight_geometry::{Eye, Image, Samples};
use rodsight_scene::{Scene, Sensor};
use wgpu::{BindGroup, Buffer, BufferUsages, SubmissionIndex};

use super::ShootPasses;
use super::film::{self, Film};
use crate::RenderError;
use crate::develop::bayer::{self, PARTS};
use crate::develop::emva::{self, Chip};
use crate::gpu::device::Gpu;
use crate::gpu::layout::{self, Vec4f};
use crate::gpu::tile::bind_group;
use crate::gpu::upload;
use crate::noise::Philox;
use crate::noise::quantile::CUBICS;

/// Invocations of a workgroup, and workgroups across; see `film.wgsl`.
const GROUP: u64 = 64;
const ACROSS: u64 = 32768;

/// An image on its way.
pub(super) struct Exposed {
    submission: SubmissionIndex,
    back: Buffer,
    size_px: [u32; 2],
    is_deep: bool,
    /// Of the raw image, if it is wanted: where it begins, and samples of a pixel.
    raw: Option<(u64, u8)>,
}

/// Takes the picture of an eye.
pub(super) fn expose(
    device: &Gpu,
    passes: &ShootPasses,
    (film, light): (&Film, &BindGroup),
    scene: &Scene,
    eye: Eye,
    gain: f64,
) -> Result<Exposed, RenderError> {
    let d = &device.device;
    let pixels = film.pixels() as u64;
    let samples = match &scene.sensor {
        Sensor::Plain { .. } => 0,
        Sensor::Emva(emva) if emva.bayer.is_some() => 1,
        Sensor::Emva(_) => 3,
    };
    // Invocations write whole words: codes of two pixels, samples of four.
    let (pairs, fours) = (pixels.div_ceil(2), pixels.div_ceil(4));
    let code_bytes = 4 * u64::from(samples) * pairs;
    let image_bytes = 12 * fours * u64::from(scene.bits / 8);
    let buffer = |label, size: u64, usage| {
        d.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.max(4),
            usage,
            mapped_at_creation: false,
        })
    };
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let codes = buffer("codes", code_bytes, usage);
    let packed = buffer("image", image_bytes, usage);
    let is_raw = scene.output.raw && samples > 0;
    let back_bytes = image_bytes + if is_raw { code_bytes } else { 0 };
    let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
    let back = buffer("image, back", back_bytes, usage);
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    bytes
        .write(&chip(scene, eye, gain))
        .expect("a vector grows");
    let chip = device.filled("chip", &bytes.into_inner(), BufferUsages::STORAGE)?;
    let cubics = CUBICS.iter().map(|&cubic| Vec4f::from(cubic)).collect();
    let cubics = upload::storage::<Vec4f>(cubics);
    let cubics = device.filled("quantile", &cubics, BufferUsages::STORAGE)?;
    let group = bind_group(d, "chip", &passes.chip, &[&chip, &cubics, &codes, &packed]);

    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_bind_group(0, light, &[]);
    pass.set_bind_group(1, &group, &[]);
    let mut run = |pipeline, invocations: u64| {
        let groups = invocations.div_ceil(GROUP);
        pass.set_pipeline(pipeline);
        pass.dispatch_workgroups(groups.min(ACROSS) as u32, groups.div_ceil(ACROSS) as u32, 1);
    };
    if samples > 0 {
        run(&passes.sense, pairs);
    }
    run(&passes.print, fours);
    drop(pass);
    encoder.copy_buffer_to_buffer(&packed, 0, &back, 0, image_bytes);
    if is_raw {
        encoder.copy_buffer_to_buffer(&codes, 0, &back, image_bytes, code_bytes);
    }
    Ok(Exposed {
        submission: device.queue.submit([encoder.finish()]),
        back,
        size_px: film::size_px(scene, eye),
        is_deep: scene.bits == 16,
        raw: is_raw.then_some((image_bytes, samples)),
    })
}

impl Exposed {
    /// Waits for the image, and the raw one.
    pub(super) fn read(self, device: &Gpu) -> Result<(Image, Option<Image>), RenderError> {
        let [width_px, height_px] = self.size_px;
        let pixels = width_px as usize * height_px as usize;
        let image = |channels: u8, samples| {
            let image = Image::new(width_px, height_px, channels, samples);
            image.expect("one or three samples a pixel")
        };
        let words = |bytes: &[u8], samples: u8| {
            let (words, _) = bytes.as_chunks::<2>();
            let words = words[..usize::from(samples) * pixels].iter();
            Samples::U16(words.map(|word| u16::from_le_bytes(*word)).collect())
        };
        device.wait(self.submission)?;
        device.mapped(&self.back, self.back.size(), |bytes| {
            let samples = if self.is_deep {
                words(bytes, 3)
            } else {
                Samples::U8(bytes[..3 * pixels].to_vec())
            };
            let raw = self
                .raw
                .map(|(start, samples)| image(samples, words(&bytes[start as usize..], samples)));
            (image(3, samples), raw)
        })
    }
}

/// All that the sensor and what follows it need to know.
fn chip(scene: &Scene, eye: Eye, gain: f64) -> layout::Chip {
    // No infinity, of which nothing times it makes no number.
    let finite = |gain: f64| gain.min(f32::MAX.into()) as f32;
    let [exposure_low, exposure_high] = Philox::new(scene.seed).key;
    let matrix = scene
        .colour_matrix
        .unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let every = layout::Chip {
        gain: finite(gain),
        exposure_low,
        exposure_high,
        stream: (eye as u32) << 8,
        balance: scene.white_balance.into(),
        matrix: matrix.map(|[r, g, b]| [r, g, b, 0.0].into()),
        full_scale: if scene.bits == 16 { 65535.0 } else { 255.0 },
        ..layout::Chip::default()
    };
    match &scene.sensor {
        Sensor::Plain { noise_sigma_dn } => layout::Chip {
            kind: 0,
            sigma: (noise_sigma_dn / 255.0) as f32,
            ..every
        },
        Sensor::Emva(emva) => {
            let [specimen_low, specimen_high] = Philox::new(emva.pattern_seed).key;
            let steps = f32::from(emva::steps(emva));
            let of_kind = match emva.bayer {
                None => layout::Chip {
                    kind: 1,
                    highest: steps,
                    ..every
                },
                Some(bayer) => {
                    let [red_column, red_row] = bayer.pattern.red().map(|at| at as u32);
                    let mut taps = every.taps;
                    for (taps, kernel) in taps.iter_mut().zip(bayer::kernels(bayer.demosaic)) {
                        for (tap, &(across, down, weight)) in taps.iter_mut().zip(kernel) {
                            *tap = [across as i32, down as i32, weight, 0].into();
                        }
                    }
                    layout::Chip {
                        kind: 2,
                        highest: f32::from(PARTS) * steps,
                        red_column,
                        red_row,
                        taps,
                        ..every
                    }
                }
            };
            layout::Chip {
                emva: layout::Emva {
                    full_well_e: emva.full_well_e as f32,
                    read_noise_e: emva.read_noise_e as f32,
                    dark_e: emva.dark_e as f32,
                    prnu: emva.prnu as f32,
                    dsnu_e: emva.dsnu_e as f32,
                    steps,
                },
                gain: finite(gain * emva.full_well_e),
                specimen_low,
                specimen_high,
                has_pattern: Chip::new(emva, scene.seed, eye).has_pattern().into(),
                dark: emva::dark_level(emva) as f32,
                ..of_kind
            }
        }
    }
}
