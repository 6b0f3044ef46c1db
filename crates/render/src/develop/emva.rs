//! The sensor after EMVA 1288, release 4.0, section 3: from radiance to the converter's codes.

use rayon::prelude::*;
use rodsight_geometry::Eye;
use rodsight_scene::Emva;

use crate::noise::Philox;

/// What random numbers are for; part of the counter, so that no two uses share one.
#[derive(Clone, Copy)]
enum Purpose {
    /// Normals of photons and read-out.
    Electrons = 1,
    /// Normals of response and offset.
    Pattern,
    /// Uniforms for few photons.
    FewPhotons,
}

/// One eye's chip.
#[derive(Clone, Copy)]
pub(crate) struct Chip<'a> {
    pub(super) emva: &'a Emva,
    pub(super) eye: Eye,
    /// Keyed by the scene's seed.
    pub(super) exposure: Philox,
    /// Keyed by the specimen: response and offset of a pixel stay when the scene's seed changes.
    pub(super) specimen: Philox,
}

impl<'a> Chip<'a> {
    pub(crate) fn new(emva: &'a Emva, seed: u64, eye: Eye) -> Self {
        Self {
            emva,
            eye,
            exposure: Philox::new(seed),
            specimen: Philox::new(emva.pattern_seed),
        }
    }

    /// The codes of three samples in every pixel.
    pub(super) fn three_chips(&self, light: &[[f32; 3]], gain: f64) -> Vec<u16> {
        let pixels = light.par_iter().enumerate().map(|(pixel, light)| {
            let normals = |philox: Philox, purpose: Purpose| {
                let [a, b, c, d] = philox.normals(self.counter(pixel, 0, purpose));
                let [e, f, ..] = philox.normals(self.counter(pixel, 1, purpose));
                [[a, d], [b, e], [c, f]]
            };
            let noise = normals(self.exposure, Purpose::Electrons);
            let pattern = if self.has_pattern() {
                normals(self.specimen, Purpose::Pattern)
            } else {
                [[0.0; 2]; 3]
            };
            let code = |k: usize| {
                let few = self.counter(pixel, k, Purpose::FewPhotons);
                self.expose(gain * f64::from(light[k]), noise[k], pattern[k], few)
            };
            [code(0), code(1), code(2)]
        });
        pixels.collect::<Vec<_>>().into_flattened()
    }

    /// The code of the one sample in every pixel, of the band that `filter` says.
    pub(super) fn mosaic(
        &self,
        light: &[[f32; 3]],
        gain: f64,
        filter: impl Fn(usize) -> usize + Sync,
    ) -> Vec<u16> {
        let codes = light.par_iter().enumerate().map(|(pixel, light)| {
            let pair = |philox: Philox, purpose: Purpose| {
                let [a, b, ..] = philox.normals(self.counter(pixel, 0, purpose));
                [a, b]
            };
            let noise = pair(self.exposure, Purpose::Electrons);
            let pattern = if self.has_pattern() {
                pair(self.specimen, Purpose::Pattern)
            } else {
                [0.0; 2]
            };
            let few = self.counter(pixel, 0, Purpose::FewPhotons);
            self.expose(gain * f64::from(light[filter(pixel)]), noise, pattern, few)
        });
        codes.collect()
    }

    fn counter(&self, pixel: usize, part: usize, purpose: Purpose) -> [u32; 4] {
        let stream = (self.eye as u32) << 8 | purpose as u32;
        [pixel as u32, part as u32, stream, 0]
    }

    pub(crate) fn has_pattern(&self) -> bool {
        self.emva.prnu > 0.0 || self.emva.dsnu_e > 0.0
    }

    /// Electrons of light and dark current (Poisson), clipped at the full well, read noise and offset, then the converter.
    pub(crate) fn expose(
        &self,
        signal: f64,
        [photons, read]: [f64; 2],
        [response, offset]: [f64; 2],
        few_photons: [u32; 4],
    ) -> u16 {
        let emva = self.emva;
        let light_e = signal * emva.full_well_e * (1.0 + emva.prnu * response).max(0.0);
        let collected_e = self
            .exposure
            .poisson(light_e + emva.dark_e, photons, few_photons)
            .min(emva.full_well_e);
        let read_e = collected_e + emva.read_noise_e * read + emva.dsnu_e * offset;
        let steps = f64::from(steps(emva));
        libm::round(read_e / emva.full_well_e * steps).clamp(0.0, steps) as u16
    }
}

/// The converter's highest code, which stands for the full well.
pub(crate) fn steps(emva: &Emva) -> u16 {
    u16::MAX >> (16 - emva.adc_bits)
}

/// What darkness reads, fraction of the full well.
pub(crate) fn dark_level(emva: &Emva) -> f64 {
    emva.dark_e / emva.full_well_e
}
