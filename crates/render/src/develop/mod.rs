//! From radiance to the images a camera would give: exposure, noise, sRGB, quantisation.

use rayon::prelude::*;
use rodsight_geometry::{Eye, Image, Samples};
use rodsight_scene::{Emva, Exposure, Scene, Sensor};

use crate::RenderError;
use crate::frame::{EyeFrame, Frame};
use crate::noise::Philox;
use crate::srgb::{srgb_encode, srgb_slope};

/// Both images, and the exposure they were taken with.
#[derive(Clone, Debug, PartialEq)]
pub struct Developed {
    /// The left image.
    pub left: Image,
    /// The right image.
    pub right: Image,
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

/// What random numbers are for; part of the counter, so that no two uses share one.
#[derive(Clone, Copy)]
enum Purpose {
    /// Normals for the three channels of a pixel.
    Plain,
    /// Normals for a sample: photons, read-out.
    Electrons,
    /// Normals for a sample: response, offset.
    Pattern,
    /// Uniforms for few photons.
    FewPhotons,
}

/// Exposes, adds the sensor's noise, encodes as sRGB and quantises.
///
/// # Errors
/// Automatic exposure of a scene without any light.
pub fn develop(frame: &Frame, scene: &Scene) -> Result<Developed, RenderError> {
    let gain = exposure_gain(frame, scene)?;
    let philox = Philox::new(scene.seed);
    let image = |eye: Eye| {
        let eye_frame = frame.eye(eye);
        let samples = if scene.bits == 16 {
            Samples::U16(digital(eye_frame, scene, eye, gain, philox, 65535.0, |v| {
                v as u16
            }))
        } else {
            Samples::U8(digital(eye_frame, scene, eye, gain, philox, 255.0, |v| {
                v as u8
            }))
        };
        Image::new(eye_frame.width_px, eye_frame.height_px, 3, samples)
            .expect("three samples a pixel")
    };
    Ok(Developed {
        left: image(Eye::Left),
        right: image(Eye::Right),
        gain,
    })
}

fn exposure_gain(frame: &Frame, scene: &Scene) -> Result<f64, RenderError> {
    let (quantile, level) = match scene.exposure {
        Exposure::Fixed(gain) => return Ok(gain),
        Exposure::Auto { quantile, level } => (quantile, level),
    };
    let pixels = frame.left.pixels.iter().chain(&frame.right.pixels);
    let balance = scene.white_balance.map(|gain| gain as f32);
    let balanced = |light: [f32; 3]| [0, 1, 2].map(|k| light[k] * balance[k]);
    let mut values: Vec<f32> = pixels.flat_map(|pixel| balanced(pixel.radiance)).collect();
    let index = ((values.len() - 1) as f64 * quantile) as usize;
    let (_, value, _) = values.select_nth_unstable_by(index, f32::total_cmp);
    if *value > 0.0 {
        Ok(level / f64::from(*value))
    } else {
        Err(RenderError::Dark {
            scene: scene.id.clone(),
        })
    }
}

fn digital<T: Copy + Send + Sync>(
    frame: &EyeFrame,
    scene: &Scene,
    eye: Eye,
    gain: f64,
    philox: Philox,
    full_scale: f64,
    quantise: impl Fn(f64) -> T + Sync,
) -> Vec<T> {
    let number = |encoded: f64| quantise(libm::round(encoded.clamp(0.0, 1.0) * full_scale));
    let counter = |pixel: usize, channel: usize, purpose: Purpose| {
        let stream = (eye as u32) << 8 | purpose as u32;
        [pixel as u32, channel as u32, stream, 0]
    };
    let signals = |pixel: usize| frame.pixels[pixel].radiance.map(|v| gain * f64::from(v));
    let pixels = (0..frame.pixels.len()).into_par_iter();
    let samples: Vec<[T; 3]> = match scene.sensor {
        Sensor::Plain { noise_sigma_dn } => pixels
            .map(|pixel| {
                let noise = if noise_sigma_dn > 0.0 {
                    philox.normals(counter(pixel, 0, Purpose::Plain))
                } else {
                    [0.0; 4]
                };
                let signal = signals(pixel);
                core::array::from_fn(|k| {
                    let encoded = srgb_encode(scene.white_balance[k] * signal[k]);
                    number(encoded + noise_sigma_dn / 255.0 * noise[k])
                })
            })
            .collect(),
        Sensor::Emva(emva) => {
            // A converter knows few values: each is balanced, encoded and quantised once.
            let encoded = scene.white_balance.map(|balance| {
                let linear = (0..=converter_steps(&emva)).map(|code| emva_linear(&emva, code));
                linear
                    .map(|value| number(srgb_encode(balance * value)))
                    .collect::<Vec<T>>()
            });
            let specimen = Philox::new(emva.pattern_seed);
            pixels
                .map(|pixel| {
                    let signal = signals(pixel);
                    core::array::from_fn(|k| {
                        let few = counter(pixel, k, Purpose::FewPhotons);
                        let [photons, read, ..] =
                            philox.normals(counter(pixel, k, Purpose::Electrons));
                        let [response, offset, ..] =
                            specimen.normals(counter(pixel, k, Purpose::Pattern));
                        let normals = [response, photons, read, offset];
                        encoded[k][expose(&emva, signal[k], philox, few, normals)]
                    })
                })
                .collect()
        }
    };
    samples.into_flattened()
}

/// EMVA 1288, release 4.0, section 3: electrons of light and dark current (Poisson), clipped at the full well, read noise and
/// offset non-uniformity, then the converter, whose code it returns. Response and offset of a pixel are those of the
/// specimen: they stay when the scene's seed changes.
fn expose(
    emva: &Emva,
    signal: f64,
    philox: Philox,
    few_photons: [u32; 4],
    [response, photons, read, offset]: [f64; 4],
) -> usize {
    let light_e = signal * emva.full_well_e * (1.0 + emva.prnu * response).max(0.0);
    let collected_e = philox
        .poisson(light_e + emva.dark_e, photons, few_photons)
        .min(emva.full_well_e);
    let read_e = collected_e + emva.read_noise_e * read + emva.dsnu_e * offset;
    let steps = converter_steps(emva) as f64;
    libm::round(read_e / emva.full_well_e * steps).clamp(0.0, steps) as usize
}

/// The converter's highest code, which stands for the full well.
fn converter_steps(emva: &Emva) -> usize {
    (1 << emva.adc_bits) - 1
}

/// Linear value of a code, 1 = full well, with the dark level taken off.
fn emva_linear(emva: &Emva, code: usize) -> f64 {
    code as f64 / converter_steps(emva) as f64 - emva.dark_e / emva.full_well_e
}

/// Standard deviation of the noise on an encoded sample, fraction of full scale, at a linear value before white balance; without
/// the rounding to the image's bits and without clipping.
pub(crate) fn noise_sigma(sensor: &Sensor, signal: f64, balance: f64) -> f64 {
    match sensor {
        Sensor::Plain { noise_sigma_dn } => noise_sigma_dn / 255.0,
        Sensor::Emva(emva) => {
            let light_e = signal.max(0.0) * emva.full_well_e;
            let step_e = emva.full_well_e / converter_steps(emva) as f64;
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
