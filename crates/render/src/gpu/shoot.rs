//! The camera on the adapter: what `lens.rs` and `develop/` do, from the light of the tiles to images, the only thing that is read.

mod chip;
mod film;
mod meter;

use rodsight_geometry::{Band, Eye};
use rodsight_scene::{Scene, Sensor};
use rodsight_shaders::{COLLECT, PRINT, Pass, RANK, SENSE, SMEAR, TALLY, THROUGH_LENS};
use wgpu::BufferBindingType::Uniform;

use super::passes::{entry, group, module, pipeline, storage};
use super::{GpuRenderer, Wanted};
use crate::RenderError;
use crate::cpu::world::World;
use crate::develop::{Developed, exposure_gain};
use film::Film;

/// A full well of more electrons is not counted one by one in `f32`.
const MOST_ELECTRONS: f64 = 16_777_216.0;

/// The passes from light to images.
#[derive(Debug)]
pub(super) struct ShootPasses {
    film: wgpu::BindGroupLayout,
    meter: wgpu::BindGroupLayout,
    chip: wgpu::BindGroupLayout,
    collect: wgpu::ComputePipeline,
    lens: wgpu::ComputePipeline,
    /// Along rows, along columns.
    smear: [wgpu::ComputePipeline; 2],
    tally: wgpu::ComputePipeline,
    rank: wgpu::ComputePipeline,
    sense: wgpu::ComputePipeline,
    print: wgpu::ComputePipeline,
}

impl ShootPasses {
    pub(super) fn new(device: &wgpu::Device, tile: &wgpu::BindGroupLayout) -> Self {
        let film = [
            entry(0, Uniform),
            storage(1, false),
            storage(2, true),
            storage(3, true),
        ];
        let film = group(device, "film", &film);
        let meter = group(device, "meter", &[storage(0, false), storage(1, false)]);
        let chip = [
            storage(0, true),
            storage(1, true),
            storage(2, false),
            storage(3, false),
        ];
        let chip = group(device, "chip", &chip);
        let compiled = |pass: Pass, second: Option<&_>, constants: &[_]| {
            let groups = [Some(&film), second];
            pipeline(device, pass, &module(device, pass), &groups, constants)
        };
        Self {
            collect: compiled(COLLECT, Some(tile), &[]),
            lens: compiled(THROUGH_LENS, None, &[]),
            smear: [0.0, 1.0].map(|along| compiled(SMEAR, None, &[("ALONG_COLUMNS", along)])),
            tally: compiled(TALLY, Some(&meter), &[]),
            rank: compiled(RANK, Some(&meter), &[]),
            sense: compiled(SENSE, Some(&chip), &[]),
            print: compiled(PRINT, Some(&chip), &[]),
            film,
            meter,
            chip,
        }
    }
}

impl GpuRenderer {
    /// Whether the adapter does all that a scene asks of its cameras.
    pub(super) fn can_shoot(&self, scene: &Scene) -> bool {
        let limits = &self.device.limits;
        let binding = limits.max_storage_buffer_binding_size;
        let most_bytes = binding.min(limits.max_buffer_size);
        let fits = |eye| {
            let [width, height] = film::size_px(scene, eye);
            let light_bytes = 12 * u64::from(width) * u64::from(height);
            let groups = width.max(height).div_ceil(film::SQUARE);
            light_bytes <= most_bytes && groups <= limits.max_compute_workgroups_per_dimension
        };
        let counts = match &scene.sensor {
            Sensor::Plain { .. } => true,
            Sensor::Emva(emva) => emva.full_well_e <= MOST_ELECTRONS,
        };
        let is_one_render = scene.motion.is_none() && scene.lens.aperture.is_none();
        is_one_render && counts && Eye::BOTH.into_iter().all(fits)
    }

    pub(super) fn shoot_pair(
        &self,
        scene: &Scene,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Developed, RenderError> {
        let world = World::new(scene);
        let (device, passes) = (&self.device, self.passes.shoot(&self.device));
        let films = [
            Film::new(device, scene, Eye::Left)?,
            Film::new(device, scene, Eye::Right)?,
        ];
        // Where ports part the bands each is rendered by itself.
        let parts = Eye::BOTH.iter().any(|&eye| scene.rig.eye(eye).disperses());
        let renders: &[_] = if parts {
            &[
                (Band::Red, 0b001),
                (Band::Green, 0b010),
                (Band::Blue, 0b100),
            ]
        } else {
            &[(Band::Green, film::ALL)]
        };
        for (done, &(band, bits)) in renders.iter().enumerate() {
            let part = |share| progress((done as f64 + share) / renders.len() as f64);
            self.shoot_band(&world, band, bits, &films, &part)?;
        }
        let [left, right] = films.each_ref().map(|film| film.blurred(device, passes));
        let lights = [left?, right?];
        let samples = films.each_ref().map(|film| 3 * film.pixels());
        let gain = exposure_gain(scene, samples.iter().sum(), |rank| {
            meter::of_rank(
                device,
                passes,
                [(&films[0], &lights[0]), (&films[1], &lights[1])],
                rank,
            )
        })?;
        let [left, right] = Eye::BOTH.map(|eye| {
            let (film, light) = (&films[eye as usize], &lights[eye as usize]);
            chip::expose(device, passes, (film, light), scene, eye, gain)
        });
        let (left, right) = (left?, right?);
        let (left, left_raw) = left.read(device)?;
        let (right, right_raw) = right.read(device)?;
        progress(1.0);
        Ok(Developed {
            left,
            right,
            raw: left_raw.zip(right_raw).map(Into::into),
            gain,
        })
    }

    /// Puts the light of some bands on both films.
    fn shoot_band(
        &self,
        world: &World<'_>,
        band: Band,
        bits: u32,
        films: &[Film; 2],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<(), RenderError> {
        let (device, passes) = (&self.device, self.passes.shoot(&self.device));
        let casting = self.casting(world, band, Wanted::Images)?;
        let group = |eye: Eye| {
            let halo = casting.scenes[eye as usize].halo.as_ref();
            films[eye as usize].group(device, passes, bits, halo.map(|halo| &halo.unspread))
        };
        let groups = [group(Eye::Left)?, group(Eye::Right)?];
        self.cast(
            &casting,
            |encoder, eye, tile| {
                let tiles = &casting.buffers[eye as usize].group;
                film::encode_collect(encoder, passes, &groups[eye as usize], tiles, tile);
            },
            |_, _, submission| device.wait(submission),
            progress,
        )?;
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (index, scene) in casting.scenes.iter().enumerate() {
            if let Some(halo) = &scene.halo {
                halo.encode_spread(&mut encoder, self.passes.halo(device), &scene.group);
            }
            films[index].encode(&mut encoder, &passes.lens, &groups[index]);
        }
        device.queue.submit([encoder.finish()]);
        casting.loops.check(device)
    }
}
