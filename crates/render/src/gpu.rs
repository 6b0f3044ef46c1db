//! The graphics backend: the same rays in `f32`, cast by compute shaders through `wgpu`, which no other module names.
//!
//! The scene is prepared by the reference backend's [`World`], in `f64`, and sent over relative to the centre of each eye. An image
//! is cut into tiles of rows that the adapter's buffers hold; tiles and the order of edges in a tile change no value.

mod content;
mod device;
mod halo;
mod layout;
mod loops;
mod passes;
#[cfg(test)]
mod shader_parity;
mod shoot;
mod snow;
mod tables;
#[cfg(test)]
mod tests;
mod tile;
mod timer;
mod upload;

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

use rodsight_geometry::{Band, Eye};
use rodsight_scene::{Mode, Scene};

pub use device::AdapterChoice;

use crate::cpu::world::World;
use crate::frame::{EyeFrame, Frame, PixelTruth};
use crate::{Developed, RenderError, Renderer, develop, expose};
use device::Gpu;
use halo::HaloEye;
use loops::Loops;
use passes::{Passes, Pipelines};
use snow::Snow;
use tables::TableCache;
use tile::{Tile, TileBuffers};
use timer::{TIMED, Times};
use upload::Upload;

/// Pixels of a tile, where the adapter allows it: enough to keep any card busy, and 60 MB of buffers.
const TILE_PIXELS: u64 = 1 << 19;

/// What of a pair is to come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Channels,
    Images,
}

/// The scene as one eye sees it, and the pipelines that take it.
#[derive(Debug)]
struct SceneBuffers {
    group: wgpu::BindGroup,
    pipelines: Pipelines,
    /// In mode `full`.
    halo: Option<HaloEye>,
    snow: Option<(Snow, Arc<[wgpu::ComputePipeline; 2]>)>,
}

/// A band of both eyes, ready to be cast.
struct Casting {
    tiles: Vec<(Eye, Tile)>,
    scenes: [SceneBuffers; 2],
    buffers: [TileBuffers; 2],
    loops: Loops,
}

/// The renderer on a graphics card, or on a software driver for one.
#[derive(Debug)]
pub struct GpuRenderer {
    device: Gpu,
    passes: Passes,
    tables: TableCache,
    tile_pixels: u64,
    /// Of the last pair, s.
    times: Mutex<Times>,
}

impl GpuRenderer {
    /// Opens the best adapter there is.
    ///
    /// # Errors
    /// No adapter, one whose limits are too small, or one that fails.
    pub fn new(choice: AdapterChoice) -> Result<Self, RenderError> {
        let device = Gpu::new(choice)?;
        Ok(Self {
            passes: Passes::new(&device)?,
            device,
            tables: TableCache::default(),
            tile_pixels: TILE_PIXELS,
            times: Mutex::default(),
        })
    }

    /// Renders at most so many pixels at a time (at least three rows of the image): less memory, the same bytes.
    #[must_use]
    pub fn with_tile_pixels(self, tile_pixels: u64) -> Self {
        Self {
            tile_pixels,
            ..self
        }
    }

    /// How many bytes were copied back from the adapter so far.
    pub fn bytes_read(&self) -> u64 {
        self.device.bytes_read.load(Ordering::Relaxed)
    }

    /// How long each pass of the last pair that was rendered with its channels took on the adapter, s, both eyes together; zeros where
    /// the adapter does not tell the time.
    pub fn stage_times_s(&self) -> [(&'static str, f64); 7] {
        let times = *self.times.lock().unwrap_or_else(PoisonError::into_inner);
        core::array::from_fn(|stage| (TIMED[stage], times[stage]))
    }

    /// The tiles of both eyes, left and right in turn.
    fn tiles(&self, scene: &Scene) -> Result<Vec<(Eye, Tile)>, RenderError> {
        let mut tiles = Vec::new();
        for eye in Eye::BOTH {
            let i = scene.rig.eye(eye).camera.intrinsics();
            let is_spread = scene.mode == Mode::Full;
            let size = [i.width_px, i.height_px];
            let cut = Tile::cut(&self.device, size, self.tile_pixels, is_spread)?;
            tiles.extend(cut.into_iter().enumerate().map(|(i, tile)| (i, eye, tile)));
        }
        // Stable: left before right.
        tiles.sort_by_key(|(i, ..)| *i);
        Ok(tiles
            .into_iter()
            .map(|(_, eye, tile)| (eye, tile))
            .collect())
    }

    /// The scene's buffers as one eye sees them in one band.
    fn bind(
        &self,
        world: &World<'_>,
        eye: Eye,
        band: Band,
        wanted: Wanted,
        loops: &Loops,
    ) -> Result<SceneBuffers, RenderError> {
        let mounted = world.scene.rig.eye(eye).in_band(band);
        let tables = self.tables.of(world, &mounted);
        let upload = Upload::new(world, eye, band, &tables.airlight);
        let device = &self.device;
        let mut buffers =
            vec![device.filled("frame", &upload.frame, wgpu::BufferUsages::UNIFORM)?];
        for (label, contents) in &upload.storage {
            buffers.push(device.filled(label, contents, wgpu::BufferUsages::STORAGE)?);
        }
        let buffers: Vec<&wgpu::Buffer> = buffers.iter().collect();
        let layout = &self.passes.scene;
        let snow = Snow::new(&self.device, world, &mounted)?
            .map(|snow| (snow, self.passes.snow(&self.device, upload.variant)));
        let halo = tables.halo.as_ref().map(|halo| {
            let passes = self.passes.halo(&self.device);
            let casts = passes.casts(device, layout, upload.variant);
            HaloEye::new(device, passes, casts, halo, &mounted, wanted, loops)
        });
        Ok(SceneBuffers {
            group: tile::bind_group(&self.device.device, "scene", layout, &buffers),
            pipelines: self.passes.of(&self.device, upload.variant),
            halo: halo.transpose()?,
            snow,
        })
    }

    fn submit(
        &self,
        scene: &SceneBuffers,
        buffers: &TileBuffers,
        tile: &Tile,
        end: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> wgpu::SubmissionIndex {
        let Gpu { device, queue, .. } = &self.device;
        buffers.prepare(&self.device, tile);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        passes::encode(&mut encoder, scene, buffers, tile);
        if let Some((snow, pipelines)) = &scene.snow {
            snow.encode(&mut encoder, pipelines, &scene.group, buffers, tile);
        }
        if let Some(halo) = &scene.halo {
            halo.encode_weigh(&mut encoder, self.passes.halo(&self.device), buffers, tile);
        }
        end(&mut encoder);
        queue.submit([encoder.finish()])
    }

    /// Adds the halo to images whose tiles are all weighed.
    fn spread(
        &self,
        scenes: &[SceneBuffers; 2],
        eyes: &mut [EyeFrame; 2],
        times: &mut Times,
    ) -> Result<(), RenderError> {
        let submissions = scenes.each_ref().map(|scene| {
            let halo = scene.halo.as_ref()?;
            let descriptor = wgpu::CommandEncoderDescriptor::default();
            let mut encoder = self.device.device.create_command_encoder(&descriptor);
            halo.encode_spread(&mut encoder, self.passes.halo(&self.device), &scene.group);
            Some((halo, self.device.queue.submit([encoder.finish()])))
        });
        for (submission, eye) in submissions.into_iter().zip(eyes) {
            if let Some((halo, submission)) = submission {
                halo.read(&self.device, submission, eye, times)?;
            }
        }
        Ok(())
    }

    /// Both eyes: behind ports that part the bands each band by itself, with the truth of green.
    fn render_pair(
        &self,
        scene: &Scene,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<[EyeFrame; 2], RenderError> {
        let world = World::new(scene);
        let mut times = Times::default();
        let parts = Eye::BOTH.iter().any(|&eye| scene.rig.eye(eye).disperses());
        let renders = if parts { 3.0 } else { 1.0 };
        let mut eyes = self.render_band(&world, Band::Green, &mut times, &|done| {
            progress(done / renders);
        })?;
        if parts {
            for (before, band) in [(1.0, Band::Red), (2.0, Band::Blue)] {
                let part = |done| progress((before + done) / renders);
                let others = self.render_band(&world, band, &mut times, &part)?;
                for (eye, other) in eyes.iter_mut().zip(&others) {
                    eye.take_light(other, band);
                }
            }
        }
        *self.times.lock().unwrap_or_else(PoisonError::into_inner) = times;
        Ok(eyes)
    }

    fn render_band(
        &self,
        world: &World<'_>,
        band: Band,
        times: &mut Times,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<[EyeFrame; 2], RenderError> {
        let scene = world.scene;
        let casting = self.casting(world, band, Wanted::Channels)?;
        let Casting {
            scenes, buffers, ..
        } = &casting;
        let mut eyes = Eye::BOTH.map(|eye| {
            let i = scene.rig.eye(eye).camera.intrinsics();
            EyeFrame {
                width_px: i.width_px,
                height_px: i.height_px,
                pixels: vec![PixelTruth::NOTHING; i.width_px as usize * i.height_px as usize],
            }
        });
        let materials = world.materials();
        self.cast(
            &casting,
            |encoder, eye, tile| buffers[eye as usize].encode_copy(encoder, tile),
            |eye, tile, submission| {
                let width = tile.width as usize;
                let rows = tile.kept.start as usize * width..tile.kept.end as usize * width;
                let pixels = &mut eyes[eye as usize].pixels[rows];
                buffers[eye as usize].read(&self.device, submission, tile, pixels, times)?;
                for pixel in pixels {
                    pixel.material = materials[pixel.instance as usize];
                }
                Ok(())
            },
            progress,
        )?;
        self.spread(scenes, &mut eyes, times)?;
        casting.loops.check(&self.device)?;
        progress(1.0);
        Ok(eyes)
    }

    fn casting(
        &self,
        world: &World<'_>,
        band: Band,
        wanted: Wanted,
    ) -> Result<Casting, RenderError> {
        let tiles = self.tiles(world.scene)?;
        let loops = Loops::new(&self.device)?;
        let scenes = [
            self.bind(world, Eye::Left, band, wanted, &loops)?,
            self.bind(world, Eye::Right, band, wanted, &loops)?,
        ];
        let is_spread = world.scene.mode == Mode::Full;
        let buffers = Eye::BOTH.map(|eye| {
            let of_eye = tiles.iter().filter(|(e, _)| *e == eye);
            let largest = of_eye.map(|(_, tile)| tile.pixels()).max().unwrap_or(0);
            let snow = scenes[eye as usize].snow.as_ref().map(|(snow, _)| snow);
            let device = &self.device;
            TileBuffers::new(
                device,
                &self.passes,
                largest,
                is_spread,
                snow,
                wanted,
                &loops,
            )
        });
        Ok(Casting {
            tiles,
            scenes,
            buffers,
            loops,
        })
    }

    /// Casts all tiles. `end` closes a tile's submission, `take` waits for it and takes what it left.
    fn cast(
        &self,
        casting: &Casting,
        end: impl Fn(&mut wgpu::CommandEncoder, Eye, &Tile),
        mut take: impl FnMut(Eye, &Tile, wgpu::SubmissionIndex) -> Result<(), RenderError>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<(), RenderError> {
        let tiles = &casting.tiles;
        // While one eye's tile is taken the other eye's is computed.
        let mut before: Option<(Eye, &Tile, wgpu::SubmissionIndex)> = None;
        for (done, (eye, tile)) in tiles.iter().enumerate() {
            if let Some((eye, tile, submission)) = before.take_if(|(there, ..)| there == eye) {
                take(eye, tile, submission)?;
            }
            let index = *eye as usize;
            let (scene, buffers) = (&casting.scenes[index], &casting.buffers[index]);
            let submission = self.submit(scene, buffers, tile, |encoder| end(encoder, *eye, tile));
            if let Some((eye, tile, submission)) = before.replace((*eye, tile, submission)) {
                take(eye, tile, submission)?;
            }
            progress(done as f64 / tiles.len() as f64);
        }
        before.map_or(Ok(()), |(eye, tile, submission)| {
            take(eye, tile, submission)
        })
    }
}

impl Renderer for GpuRenderer {
    fn backend(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> String {
        self.device.adapter.clone()
    }

    fn render(&self, scene: &Scene, progress: &(dyn Fn(f64) + Sync)) -> Result<Frame, RenderError> {
        for eye in Eye::BOTH {
            RenderError::refuse_too_large(scene, eye)?;
        }
        let [mut left, mut right] = self.device.watched(|| self.render_pair(scene, progress))?;
        left.mark_beyond_model(scene);
        right.mark_beyond_model(scene);
        Ok(Frame {
            left,
            right,
            backend: self.backend(),
            adapter: self.adapter(),
        })
    }

    /// On the adapter, of which nothing but images, raw codes and the exposure comes back. They differ from what [`develop`] makes of
    /// [`Self::render`]'s frame by rounding: by a digit, or a code of the sensor, in fewer than a thousandth of the pixels at 8 bits and a
    /// hundredth at 16.
    ///
    /// By way of a frame after all go scenes with motion or an aperture, which take a mean over many renders; images of more light
    /// than one of the adapter's buffers holds; and sensors whose full well is of more electrons than `f32` counts, 2^24.
    fn shoot(
        &self,
        scene: &Scene,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Developed, RenderError> {
        if !self.can_shoot(scene) {
            return develop(&expose(self, scene, progress)?, scene);
        }
        for eye in Eye::BOTH {
            RenderError::refuse_too_large(scene, eye)?;
        }
        self.device.watched(|| self.shoot_pair(scene, progress))
    }
}
