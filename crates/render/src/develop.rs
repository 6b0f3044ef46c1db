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

/// What a random number is for; part of the counter, so that no two uses share one.
#[derive(Clone, Copy)]
enum Purpose {
    Plain,
    Photons,
    Read,
    ResponseFixed,
    DarkFixed,
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
            Samples::U16(digital(
                eye_frame,
                scene,
                eye,
                gain,
                &philox,
                65535.0,
                |v| v as u16,
            ))
        } else {
            Samples::U8(digital(eye_frame, scene, eye, gain, &philox, 255.0, |v| {
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

fn digital<T: Send>(
    frame: &EyeFrame,
    scene: &Scene,
    eye: Eye,
    gain: f64,
    philox: &Philox,
    full_scale: f64,
    quantise: impl Fn(f64) -> T + Sync,
) -> Vec<T> {
    let sample = |index: usize| {
        let (pixel, channel) = (index / 3, index % 3);
        let signal = gain * f64::from(frame.pixels[pixel].radiance[channel]);
        let balance = scene.white_balance[channel];
        let counter = |purpose: Purpose| {
            [
                pixel as u32,
                channel as u32,
                (eye as u32) << 8 | purpose as u32,
                0,
            ]
        };
        let encoded = match scene.sensor {
            Sensor::Plain { noise_sigma_dn } if noise_sigma_dn > 0.0 => {
                srgb_encode(balance * signal)
                    + noise_sigma_dn / 255.0 * philox.normals(counter(Purpose::Plain))[0]
            }
            Sensor::Plain { .. } => srgb_encode(balance * signal),
            Sensor::Emva(emva) => srgb_encode(balance * expose(&emva, signal, philox, counter)),
        };
        quantise(libm::round(encoded.clamp(0.0, 1.0) * full_scale))
    };
    (0..frame.pixels.len() * 3)
        .into_par_iter()
        .map(sample)
        .collect()
}

/// EMVA 1288, release 4.0, section 3: electrons of light and dark current (Poisson), clipped at the full well, read noise and
/// offset non-uniformity, then the converter. Returns the linear value, 1 = full well; the dark level is taken off.
fn expose(emva: &Emva, signal: f64, philox: &Philox, counter: impl Fn(Purpose) -> [u32; 4]) -> f64 {
    let normal = |purpose| philox.normals(counter(purpose))[0];
    let light_e =
        signal * emva.full_well_e * (1.0 + emva.prnu * normal(Purpose::ResponseFixed)).max(0.0);
    let collected_e = philox
        .poisson(light_e + emva.dark_e, counter(Purpose::Photons))
        .min(emva.full_well_e);
    let read_e = collected_e
        + emva.read_noise_e * normal(Purpose::Read)
        + emva.dsnu_e * normal(Purpose::DarkFixed);
    let steps = f64::from((1_u32 << emva.adc_bits) - 1);
    let converted = libm::round(read_e / emva.full_well_e * steps).clamp(0.0, steps) / steps;
    converted - emva.dark_e / emva.full_well_e
}

/// Standard deviation of the noise on an encoded sample, fraction of full scale, at a linear value before white balance.
pub(crate) fn noise_sigma(sensor: &Sensor, signal: f64, balance: f64) -> f64 {
    match sensor {
        Sensor::Plain { noise_sigma_dn } => noise_sigma_dn / 255.0,
        Sensor::Emva(emva) => {
            let light_e = signal.max(0.0) * emva.full_well_e;
            let variance_e2 = light_e
                + emva.dark_e
                + emva.read_noise_e * emva.read_noise_e
                + emva.dsnu_e * emva.dsnu_e
                + emva.prnu * light_e * (emva.prnu * light_e);
            srgb_slope((balance * signal).clamp(0.0, 1.0)) * balance * libm::sqrt(variance_e2) / emva.full_well_e
        }
    }
}
