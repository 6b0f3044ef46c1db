//! From radiance to the images a camera would give: exposure, noise, mosaic, white balance, colour matrix, sRGB, quantisation.

pub(crate) mod bayer;
pub(crate) mod emva;
mod print;

use rayon::prelude::*;
use rodsight_geometry::{Eye, Image, Samples};
use rodsight_scene::{Emva, Exposure, Scene, Sensor};

use crate::RenderError;
use crate::frame::Frame;
use crate::lens;
use crate::noise::Philox;
use crate::srgb::srgb_slope;
use emva::Chip;
use print::Printer;

/// Both images, and the exposure they were taken with.
#[derive(Clone, Debug, PartialEq)]
pub struct Developed {
    /// The left image.
    pub left: Image,
    /// The right image.
    pub right: Image,
    /// The converter's codes as they are, left and right, where the scene asks for them.
    pub raw: Option<[Image; 2]>,
    /// Fraction of full scale per W m⁻² sr⁻¹, the same for both eyes.
    pub gain: f64,
}

impl Developed {
    /// The image of an eye.
    pub fn eye(&self, eye: Eye) -> &Image {
        match eye {
            Eye::Left => &self.left,
            Eye::Right => &self.right,
        }
    }
}

/// Exposes, adds the sensor's noise, takes a colour filter's mosaic apart where there is one, encodes as sRGB and quantises.
///
/// # Errors
/// Automatic exposure of a scene without any light.
pub fn develop(frame: &Frame, scene: &Scene) -> Result<Developed, RenderError> {
    let light = Eye::BOTH.map(|eye| lens::on_sensor(frame.eye(eye), scene, eye));
    let samples = light.iter().map(|light| 3 * light.len()).sum();
    let gain = exposure_gain(scene, samples, |index| Ok(of_rank(&light, scene, index)))?;
    let images = Eye::BOTH.map(|eye| {
        let shot = Shot {
            scene,
            eye,
            light: &light[eye as usize],
            size_px: [frame.eye(eye).width_px, frame.eye(eye).height_px],
            gain,
        };
        let (samples, codes) = if scene.bits == 16 {
            let (values, codes) = shot.digital(65535.0, |v| v as u16);
            (Samples::U16(values), codes)
        } else {
            let (values, codes) = shot.digital(255.0, |v| v as u8);
            (Samples::U8(values), codes)
        };
        let codes = codes.filter(|_| scene.output.raw);
        (
            shot.image(samples),
            codes.map(|codes| shot.image(Samples::U16(codes))),
        )
    });
    let [(left, left_raw), (right, right_raw)] = images;
    Ok(Developed {
        left,
        right,
        raw: left_raw.zip(right_raw).map(Into::into),
        gain,
    })
}

/// The exposure of so many samples, in both eyes together, of which `of_rank` knows the one of a rank after white balance.
pub(crate) fn exposure_gain(
    scene: &Scene,
    samples: usize,
    of_rank: impl FnOnce(usize) -> Result<f32, RenderError>,
) -> Result<f64, RenderError> {
    let (quantile, level) = match scene.exposure {
        Exposure::Fixed(gain) => return Ok(gain),
        Exposure::Auto { quantile, level } => (quantile, level),
    };
    let value = of_rank(((samples - 1) as f64 * quantile) as usize)?;
    if value > 0.0 {
        Ok(level / f64::from(value))
    } else {
        Err(RenderError::Dark {
            scene: scene.id.clone(),
        })
    }
}

fn of_rank(light: &[Vec<[f32; 3]>; 2], scene: &Scene, index: usize) -> f32 {
    let balance = scene.white_balance.map(|gain| gain as f32);
    let balanced = |light: &[f32; 3]| [0, 1, 2].map(|k| light[k] * balance[k]);
    let mut values: Vec<f32> = light.iter().flatten().flat_map(balanced).collect();
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}

/// One eye's picture on its way through the sensor.
struct Shot<'a> {
    scene: &'a Scene,
    eye: Eye,
    /// What falls on the sensor, W m⁻² sr⁻¹.
    light: &'a [[f32; 3]],
    size_px: [u32; 2],
    gain: f64,
}

impl Shot<'_> {
    fn image(&self, samples: Samples) -> Image {
        let [width_px, height_px] = self.size_px;
        let channels = (samples.len() / self.light.len()) as u8;
        Image::new(width_px, height_px, channels, samples).expect("one or three samples a pixel")
    }

    /// Three encoded samples a pixel, and the converter's codes, which the plain sensor has none of.
    fn digital<T: Copy + Send + Sync>(
        &self,
        full_scale: f64,
        quantise: impl Fn(f64) -> T + Sync,
    ) -> (Vec<T>, Option<Vec<u16>>) {
        let quantise = |encoded: f64| quantise(libm::round(encoded.clamp(0.0, 1.0) * full_scale));
        let printer = Printer::new(self.scene);
        let (pixels, codes) = match &self.scene.sensor {
            Sensor::Plain { noise_sigma_dn } => {
                (self.plain(noise_sigma_dn / 255.0, &printer, quantise), None)
            }
            Sensor::Emva(emva) => {
                let (pixels, codes) = self.emva(emva, printer, quantise);
                (pixels, Some(codes))
            }
        };
        (pixels.into_flattened(), codes)
    }

    fn plain<T: Send>(
        &self,
        sigma: f64,
        printer: &Printer,
        quantise: impl Fn(f64) -> T + Sync,
    ) -> Vec<[T; 3]> {
        let philox = Philox::new(self.scene.seed);
        let pixels = self.light.par_iter().enumerate().map(|(pixel, light)| {
            let noise = if sigma > 0.0 {
                philox.normals([pixel as u32, 0, (self.eye as u32) << 8, 0])
            } else {
                [0.0; 4]
            };
            let encoded = printer.encode(light.map(|v| self.gain * f64::from(v)));
            [0, 1, 2].map(|k| quantise(encoded[k] + sigma * noise[k]))
        });
        pixels.collect()
    }

    /// One code a pixel under colour filters, else three.
    fn emva<T: Copy + Send + Sync>(
        &self,
        emva: &Emva,
        printer: Printer,
        quantise: impl Fn(f64) -> T + Sync,
    ) -> (Vec<[T; 3]>, Vec<u16>) {
        let chip = Chip::new(emva, self.scene.seed, self.eye);
        let Some(bayer) = emva.bayer else {
            let codes = chip.three_chips(self.light, self.gain);
            let print = printer.of_codes(emva, 1, quantise);
            let pixels = codes.par_chunks_exact(3);
            let pixels = pixels.map(|p| print([p[0], p[1], p[2]].map(i32::from)));
            return (pixels.collect(), codes);
        };
        let width = self.size_px[0] as usize;
        let filter = |pixel| bayer::filter(bayer, pixel % width, pixel / width);
        let codes = chip.mosaic(self.light, self.gain, filter);
        let print = printer.of_codes(emva, bayer::PARTS, quantise);
        let pixels = bayer::demosaic(bayer, &codes, width).into_par_iter();
        (pixels.map(&print).collect(), codes)
    }
}

/// Standard deviation of the noise on an encoded sample, fraction of full scale, at a linear value before white balance; without
/// mosaic, colour matrix, the rounding to the image's bits and clipping.
pub(crate) fn noise_sigma(sensor: &Sensor, signal: f64, balance: f64) -> f64 {
    match sensor {
        Sensor::Plain { noise_sigma_dn } => noise_sigma_dn / 255.0,
        Sensor::Emva(emva) => {
            let light_e = signal.max(0.0) * emva.full_well_e;
            let step_e = emva.full_well_e / f64::from(emva::steps(emva));
            let variance_e2 = light_e
                + step_e * step_e / 12.0
                + emva.dark_e
                + emva.read_noise_e * emva.read_noise_e
                + emva.dsnu_e * emva.dsnu_e
                + emva.prnu * light_e * (emva.prnu * light_e);
            srgb_slope((balance * signal).clamp(0.0, 1.0)) * balance * libm::sqrt(variance_e2)
                / emva.full_well_e
        }
    }
}
