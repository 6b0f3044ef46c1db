//! The reference backend: `f64`, all cores, the same bytes on every machine.
//!
//! A pixel away from edges takes one ray through its centre; a pixel near an edge of instance, face, shadow or depth takes all
//! samples of the edge pattern. Random numbers have no part in it.

pub(crate) mod airlight_grid;
pub(crate) mod arc;
pub(crate) mod bodies;
pub(crate) mod finish;
pub(crate) mod halo;
pub(crate) mod light;
pub(crate) mod lump;
pub(crate) mod overscan;
pub(crate) mod penumbra;
pub(crate) mod plane;
pub(crate) mod rod;
pub(crate) mod seabed;
pub(crate) mod shadow;
pub(crate) mod snow;
pub(crate) mod solid;
pub(crate) mod texture;
pub(crate) mod triangles;
pub(crate) mod world;

use core::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;
use rodsight_geometry::{Band, CameraFrame, Eye, MountedCamera, Pixel, Pose, RigFrame};
use rodsight_optics::{Bands, Halo, transmittance};
use rodsight_scene::{Mode, Scene};

use crate::frame::{EyeFrame, Frame, PixelTruth};
use crate::lattice::{edge_offsets, inner_offsets, pixel_shift};
use crate::{RenderError, Renderer};
use airlight_grid::AirlightGrid;
use halo::{Mixed, Scattered, Sources};
use overscan::{middle_px_per_rad, overscan_px};
use solid::{Face, Ray};
use world::{Hit, Thing, World, graze_rad};

/// The `f64` reference renderer.
#[derive(Clone, Copy, Debug, Default)]
pub struct CpuRenderer;

impl Renderer for CpuRenderer {
    fn backend(&self) -> &'static str {
        "cpu"
    }

    fn adapter(&self) -> String {
        // Not the number of threads: it changes nothing, and the same scene gives the same truth on any of them.
        std::env::consts::ARCH.to_owned()
    }

    fn render(&self, scene: &Scene, progress: &(dyn Fn(f64) + Sync)) -> Result<Frame, RenderError> {
        Ok(Frame {
            left: self.render_eye(scene, Eye::Left, &|done| progress(done / 2.0))?,
            right: self.render_eye(scene, Eye::Right, &|done| progress(0.5 + done / 2.0))?,
            backend: self.backend(),
            adapter: self.adapter(),
        })
    }
}

impl CpuRenderer {
    /// Renders one eye.
    ///
    /// # Errors
    /// An image too large to hold.
    pub fn render_eye(
        &self,
        scene: &Scene,
        eye: Eye,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<EyeFrame, RenderError> {
        RenderError::refuse_too_large(scene, eye)?;
        let world = World::new(scene);
        let cast = |band, from, share| {
            let part = move |done| progress(from + done * share);
            Caster::new(&world, eye, band).render(&part)
        };
        let mut frame = if scene.rig.eye(eye).disperses() {
            let third = 1.0 / 3.0;
            let mut frame = cast(Band::Green, 0.0, third);
            frame.take_light(&cast(Band::Red, third, third), Band::Red);
            frame.take_light(&cast(Band::Blue, 2.0 * third, third), Band::Blue);
            frame
        } else {
            cast(Band::Green, 0.0, 1.0)
        };
        frame.mark_beyond_model(scene);
        Ok(frame)
    }
}

/// Casts the rays of one eye, as one band of light goes through its port.
struct Caster<'a> {
    world: &'a World<'a>,
    mounted: MountedCamera,
    camera_from_rig: Pose<CameraFrame, RigFrame>,
    other: MountedCamera,
    eye: Eye,
    airlight: AirlightGrid,
    /// In mode `full`.
    halo: Option<Halo>,
    /// Rays nearer than this to a limb take more samples than one.
    graze_rad: f64,
}

/// What must be alike in neighbouring pixels for one sample to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct EdgeKey {
    instance: u16,
    part: u32,
    cap: bool,
    lit_by: u32,
}

/// What tells pixels at edges from others.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    key: EdgeKey,
    limb: Limb,
    range_m: f32,
}

/// Where the nearest limb of a rod passes, whether the pixel's centre tells or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Limb {
    #[default]
    Away,
    /// Shading is steepest there.
    Beside,
    /// Perhaps through the pixel.
    Within,
}

/// Neighbouring pixels of one rod whose depths differ by more than this fraction are an edge of it against itself.
const DEPTH_STEP: f64 = 0.02;

impl<'a> Caster<'a> {
    fn new(world: &'a World<'a>, eye: Eye, band: Band) -> Self {
        let rig = &world.scene.rig;
        let mounted = rig.eye(eye).in_band(band);
        let other = *rig.eye(eye.other());
        Self {
            world,
            mounted,
            camera_from_rig: mounted.rig_from_camera.inverse(),
            other,
            eye,
            airlight: AirlightGrid::new(world, &mounted),
            halo: (world.scene.mode == Mode::Full)
                .then(|| Halo::new(&world.scene.medium, middle_px_per_rad(&mounted))),
            graze_rad: graze_rad(&mounted),
        }
    }

    fn render(&self, progress: &(dyn Fn(f64) + Sync)) -> EyeFrame {
        let i = *self.mounted.camera.intrinsics();
        let (width, height) = (i.width_px as usize, i.height_px as usize);
        let rows_done = AtomicU32::new(0);
        let tick = || {
            let done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
            progress(f64::from(done) / (2.0 * f64::from(i.height_px)));
        };

        let (mut pixels, mut marks) = (Vec::new(), Vec::new());
        let centres = (0..width * height).into_par_iter().map(|index| {
            let (column, row) = (index % width, index / width);
            let seen = self.centre(&Pixel::new(column as f64 + 0.5, row as f64 + 0.5));
            if column + 1 == width {
                tick();
            }
            seen
        });
        centres.unzip_into_vecs(&mut pixels, &mut marks);

        let pattern = self.world.scene.sampling.edge;
        let (offsets, inner_offsets) = (edge_offsets(pattern), inner_offsets(pattern));
        let mut mixed: Vec<Mixed> = pixels
            .par_chunks_mut(width)
            .enumerate()
            .map(|(row, pixels)| {
                let mut mixed = Mixed::new();
                let rows = row.saturating_sub(1)..(row + 2).min(height);
                for (column, pixel) in pixels.iter_mut().enumerate() {
                    let columns = column.saturating_sub(1)..(column + 2).min(width);
                    let here = row * width + column;
                    let mut around = rows
                        .clone()
                        .flat_map(|r| columns.clone().map(move |c| r * width + c));
                    let limb = marks[here].limb;
                    let is_edge = limb != Limb::Away
                        || around.any(|there| is_edge(&marks[here], &marks[there]));
                    if !is_edge {
                        continue;
                    }
                    let shift = pixel_shift(pattern, column as u32, row as u32);
                    let corner = Pixel::new(column as f64, row as f64);
                    let mut seen = Gathered::default();
                    if limb != Limb::Within {
                        seen = self.gather(&corner, &inner_offsets, shift);
                    }
                    // An outline, if there is one, is worth all samples.
                    if seen.things.len() != 1 {
                        seen = self.gather(&corner, &offsets, shift);
                    }
                    let scattered = self.store_mean(pixel, &corner, seen);
                    mixed.extend(scattered.map(|light| (column as u32, light)));
                }
                tick();
                mixed
            })
            .collect();
        self.compose_snow(&mut pixels, &mut mixed);
        if let Some(halo) = &self.halo {
            let spread = Sources {
                width,
                pixels: &pixels,
                mixed: &mixed,
                beyond: |place: &Pixel| self.beyond(place),
                overscan: overscan_px(&self.mounted),
            }
            .spread(halo);
            let pairs = pixels.par_iter_mut().zip(spread.pixels());
            pairs.for_each(|(pixel, forward)| {
                pixel.forward = *forward;
                pixel.sum_radiance();
            });
        }
        EyeFrame {
            width_px: i.width_px,
            height_px: i.height_px,
            pixels,
        }
    }

    /// The ray in the water through a pixel, and the share of its radiance that arrives at the lens. Every pixel of the image has
    /// one: lenses and ports for which that is not so are refused.
    fn ray(&self, pixel: &Pixel) -> Option<(Ray, f64)> {
        let seen = self.mounted.water_ray(pixel)?;
        let ray = Ray {
            origin_m: seen.origin_m,
            direction: seen.direction,
        };
        Some((ray, seen.gain))
    }

    /// Everything about the ray through a pixel's centre.
    fn centre(&self, pixel: &Pixel) -> (PixelTruth, Mark) {
        let Some((ray, gain)) = self.ray(pixel) else {
            return (PixelTruth::NOTHING, Mark::default());
        };
        let hit = self.world.hit(&ray);
        let surface = self.light_of(&ray, gain, hit.as_ref());
        let backscatter = self.backscatter(&ray, gain, pixel, surface.range_m);
        let mut truth = PixelTruth::NOTHING;
        let mut key = EdgeKey {
            lit_by: surface.lit_by,
            ..EdgeKey::default()
        };
        if let Some(hit) = hit {
            let point = ray.at(hit.t_m);
            let in_camera = self.camera_from_rig.point(&point);
            let seen_by_other = self.other.sight(&point);
            truth.depth_m = in_camera.z as f32;
            truth.range_m = hit.t_m as f32;
            truth.normal = self
                .camera_from_rig
                .direction(&hit.normal)
                .map(|v| v as f32)
                .into();
            truth.instance = self.world.instance(hit.thing);
            truth.material = hit.thing.material();
            if let Some(there) = seen_by_other {
                truth.disparity_px = match self.eye {
                    Eye::Left => pixel.x - there.pixel.x,
                    Eye::Right => there.pixel.x - pixel.x,
                } as f32;
            }
            truth.occluded = !seen_by_other.is_some_and(|there| {
                self.other.camera.contains(&there.pixel)
                    && !self.world.is_hidden(&point, &there.from_m)
            });
            key.instance = self.world.instance(hit.thing);
            key.part = hit.part;
            key.cap = hit.face == Face::Cap;
        }
        store(&mut truth, &surface, &backscatter);
        // Until it is spread over its neighbours.
        truth.forward = self.scattered(&surface.wet, surface.range_m).light;
        let mark = Mark {
            key,
            limb: self.limb(&ray),
            range_m: truth.range_m,
        };
        (truth, mark)
    }

    /// Rays as near as half the grazing angle have the limb within half a diagonal of the pixel.
    fn limb(&self, ray: &Ray) -> Limb {
        if !self.world.grazes_a_limb(ray, self.graze_rad) {
            Limb::Away
        } else if self.world.grazes_a_limb(ray, 0.5 * self.graze_rad) {
            Limb::Within
        } else {
            Limb::Beside
        }
    }

    /// The light that the water scatters into a ray, at the lens.
    fn backscatter(&self, ray: &Ray, gain: f64, pixel: &Pixel, distance_m: f64) -> Bands {
        let unshadowed = self.airlight.at(self.world, ray, pixel, distance_m);
        self.world
            .backscatter(ray, distance_m, &unshadowed)
            .map(|light| gain * light)
    }

    /// The light that leaves what a ray hits, after its way to the lens.
    fn light_of(&self, ray: &Ray, gain: f64, hit: Option<&Hit>) -> Sample {
        let Some(hit) = hit else {
            let background = if self.world.scene.mode == Mode::Air {
                self.world
                    .scene
                    .background_radiance
                    .map(|light| gain * light)
            } else {
                [0.0; 3]
            };
            return Sample {
                direct: background,
                wet: [0.0; 3],
                clean: background,
                transmission: [0.0; 3],
                range_m: f64::INFINITY,
                lit_by: 0,
                thing: None,
            };
        };
        let surface = self.world.surface(ray, hit);
        let transmission = transmittance(&self.world.attenuation_per_m, hit.t_m);
        Sample {
            direct: core::array::from_fn(|k| gain * (surface.wet[k] * transmission[k])),
            wet: surface.wet.map(|light| gain * light),
            clean: surface.dry.map(|light| gain * light),
            transmission,
            range_m: hit.t_m,
            lit_by: surface.lit_by,
            thing: Some(hit.thing),
        }
    }

    /// The light of surfaces at every sample of a pixel.
    fn gather(&self, corner: &Pixel, offsets: &[[f64; 2]], shift: [f64; 2]) -> Gathered {
        let mut mean = Sample::default();
        let mut things: Vec<Seen> = Vec::with_capacity(4);
        let wrapped = |offset: f64| if offset < 1.0 { offset } else { offset - 1.0 };
        for &[du, dv] in offsets {
            let inside = Pixel::new(wrapped(du + shift[0]), wrapped(dv + shift[1]));
            let Some((ray, gain)) = self.ray(&(corner + inside)) else {
                continue;
            };
            let sample = self.light_of(&ray, gain, self.world.hit(&ray).as_ref());
            for k in 0..3 {
                mean.direct[k] += sample.direct[k];
                mean.clean[k] += sample.clean[k];
                mean.transmission[k] += sample.transmission[k];
            }
            let known = things.iter().position(|seen| seen.thing == sample.thing);
            let known = known.unwrap_or_else(|| {
                things.push(Seen {
                    thing: sample.thing,
                    ..Seen::default()
                });
                things.len() - 1
            });
            let seen = &mut things[known];
            seen.count += 1.0;
            seen.range_sum_m += sample.range_m;
            for k in 0..3 {
                seen.wet_sum[k] += sample.wet[k];
            }
        }
        let samples = offsets.len() as f64;
        Gathered {
            mean: Sample {
                direct: mean.direct.map(|sum| sum / samples),
                clean: mean.clean.map(|sum| sum / samples),
                transmission: mean.transmission.map(|sum| sum / samples),
                ..mean
            },
            things,
            samples,
        }
    }

    /// Replaces a pixel's light by the mean over its samples. Light from the water, smooth but for the length of the ray, is taken once
    /// for each thing seen in the pixel, at its mean distance. Returns what of each thing's light arrives scattered.
    fn store_mean(
        &self,
        truth: &mut PixelTruth,
        corner: &Pixel,
        gathered: Gathered,
    ) -> impl Iterator<Item = Scattered> {
        let Gathered {
            mean,
            things,
            samples,
        } = gathered;
        let share = 1.0 / samples;
        let mut backscatter = [0.0; 3];
        let centre = Pixel::new(corner.x + 0.5, corner.y + 0.5);
        if let Some((ray, gain)) = self.ray(&centre) {
            for seen in &things {
                let scattered = self.backscatter(&ray, gain, &centre, seen.range_m());
                for k in 0..3 {
                    backscatter[k] += scattered[k] * seen.count * share;
                }
            }
        }
        store(truth, &mean, &backscatter);
        truth.forward = [0.0; 3];
        things.into_iter().map(move |seen| {
            let wet = seen.wet_sum.map(|sum| sum * share);
            self.scattered(&wet, seen.range_m())
        })
    }
}

/// What the samples of a pixel bring.
#[derive(Debug, Default)]
struct Gathered {
    mean: Sample,
    things: Vec<Seen>,
    samples: f64,
}

/// What they bring of one thing, or of none.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    thing: Option<Thing>,
    count: f64,
    range_sum_m: f64,
    wet_sum: Bands,
}

impl Seen {
    fn range_m(&self) -> f64 {
        self.range_sum_m / self.count
    }
}

/// What one ray brings.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    direct: Bands,
    /// Where it leaves the surface.
    wet: Bands,
    clean: Bands,
    transmission: Bands,
    range_m: f64,
    lit_by: u32,
    thing: Option<Thing>,
}

fn store(truth: &mut PixelTruth, sample: &Sample, backscatter: &Bands) {
    let single = |bands: &Bands| bands.map(|v| v as f32);
    truth.radiance = core::array::from_fn(|k| (sample.direct[k] + backscatter[k]) as f32);
    truth.direct = single(&sample.direct);
    truth.backscatter = single(backscatter);
    truth.clean = single(&sample.clean);
    truth.transmission = single(&sample.transmission);
}

/// Whether one sample cannot stand for both of two neighbouring pixels.
fn is_edge(here: &Mark, there: &Mark) -> bool {
    let step = f64::from((here.range_m - there.range_m).abs());
    here.key != there.key || (here.key.instance >= 2 && step > DEPTH_STEP * f64::from(here.range_m))
}
