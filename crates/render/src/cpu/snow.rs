//! Marine snow: matt spheres in the water, between the surfaces and the lens.
//!
//! Places and sizes hang on the seed and a cell of space alone: both eyes, every thread and every instant of an exposure see the same
//! particles, and none is kept that is not in view. A particle covers the share of each pixel that its disc covers, exactly, be it
//! smaller than a pixel or larger; what it covers, it hides. An open aperture widens the disc and thins it out.

pub(crate) mod disc;
pub(crate) mod place;
mod strew;

use rayon::prelude::*;
use rodsight_geometry::{Pixel, Vec3};
use rodsight_optics::{Bands, sphere_share, transmittance};
use rodsight_scene::Mode;

use super::Caster;
use super::halo::{Mixed, Scattered};
use super::light::cone;
use super::solid::Ray;
use crate::frame::PixelTruth;
use disc::area_in_disc;
use place::Place;

/// Rows of a piece of work.
const ROWS: usize = 16;
/// From this radius on a particle is seen to be round, px.
const ROUND_PX: f64 = 8.0;
/// Less of a pixel is rounding.
const LEAST_COVER: f64 = 1e-9;

/// A particle as an eye sees it: all that compositing needs.
#[derive(Clone, Copy, Debug)]
struct Flake {
    place: Place,
    /// Mean radiance of the disc at the lens that came unscattered, W m⁻² sr⁻¹.
    direct: Bands,
    /// And scattered forwards on the way.
    scattered: Scattered,
    /// Where its light comes from, in the disc's axes and towards the eye: a unit vector.
    lit_from: [f64; 3],
    /// How much of its light is shaded as a ball's; 0 if it is too small to tell.
    shading: f64,
}

impl Flake {
    /// Share of a pixel that it covers.
    fn cover(&self, column: usize, row: usize) -> f64 {
        let [[a, b], [c, d]] = self.place.disc_per_px;
        let corner = |right: f64, down: f64| {
            let x = column as f64 + right - self.place.at_px[0];
            let y = row as f64 + down - self.place.at_px[1];
            [a * x + b * y, c * x + d * y]
        };
        let corners = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ];
        self.place.opacity * (area_in_disc(&corners) / (a * d - b * c)).clamp(0.0, 1.0)
    }

    /// Its radiance in a pixel over its mean: a ball lit from one side, n·l over the mean of that.
    fn shade(&self, column: usize, row: usize) -> f64 {
        if self.shading == 0.0 {
            return 1.0;
        }
        let [[a, b], [c, d]] = self.place.disc_per_px;
        let (u, v) = (
            column as f64 + 0.5 - self.place.at_px[0],
            row as f64 + 0.5 - self.place.at_px[1],
        );
        let (x, y) = (a * u + b * v, c * u + d * v);
        // A pixel that the limb crosses may have its middle outside.
        let out = (x * x + y * y).sqrt().max(1.0);
        let (x, y) = (x / out, y / out);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let [lx, ly, lz] = self.lit_from;
        let lit = (x * lx + y * ly + z * lz).max(0.0) / sphere_share(lz).max(1e-3);
        1.0 + self.shading * (lit - 1.0)
    }
}

impl Caster<'_> {
    /// The particles that this eye sees, nearest first.
    fn flakes(&self) -> Vec<Flake> {
        let Some(snow) = place::of_scene(self.world.scene) else {
            return Vec::new();
        };
        let places = place::places(self.world.scene, &self.mounted).into_par_iter();
        places
            .filter_map(|place| self.flake(&snow.albedo, place))
            .collect()
    }

    fn flake(&self, albedo: &Bands, place: Place) -> Option<Flake> {
        if place.is_small() && self.world.is_hidden(&place.centre_m, &place.from_m) {
            return None;
        }
        let (gain, range_m) = (place.gain, place.range_m);
        let (lamps, from) = self.lamps_on(albedo, &place.centre_m, &place.to_eye);
        // The mean normal of a ball's disc is two thirds of the way to the eye.
        let [ambient, _] = (self.world).ambient_on(&place.centre_m, -2.0 / 3.0 * place.to_eye.z);
        let wet: Bands = core::array::from_fn(|k| gain * (lamps[k] + albedo[k] * ambient[k]));
        let attenuated = transmittance(&self.world.attenuation_per_m, range_m);
        let mut flake = Flake {
            direct: core::array::from_fn(|k| wet[k] * attenuated[k]),
            scattered: self.scattered(&wet, range_m),
            lit_from: [0.0, 0.0, 1.0],
            shading: 0.0,
            place,
        };
        let all: f64 = wet.iter().sum();
        if place.is_round() && all > 0.0 && from.norm() > 0.0 {
            let from = from.normalize();
            let [across, down] = place.axes;
            flake.lit_from = [from.dot(&across), from.dot(&down), from.dot(&place.to_eye)];
            flake.shading = gain * lamps.iter().sum::<f64>() / all;
        }
        Some(flake)
    }

    /// The mean radiance that the lamps give a particle towards the eye, and the direction most of it comes from.
    fn lamps_on(&self, albedo: &Bands, centre_m: &Vec3, to_eye: &Vec3) -> (Bands, Vec3) {
        let mut light = [0.0; 3];
        let mut from = Vec3::zeros();
        if self.world.scene.mode == Mode::Koschmieder {
            return (light, from);
        }
        for lamp in &self.world.lamps {
            let away = centre_m - lamp.lamp.position_m;
            let r = away.norm();
            let direction = away / r;
            let beam = cone(lamp, &direction);
            if beam == 0.0 || self.world.is_blocked(&lamp.lamp.position_m, &direction, r) {
                continue;
            }
            let share =
                beam * sphere_share(-direction.dot(to_eye)) / (core::f64::consts::PI * r * r);
            let falloff = transmittance(&self.world.lamp_attenuation_per_m, r);
            for k in 0..3 {
                let radiance = lamp.lamp.radiant_intensity_w_per_sr[k] * share * falloff[k];
                light[k] += albedo[k] * radiance;
                from -= direction * radiance;
            }
        }
        (light, from)
    }

    /// Puts the particles between the image's surfaces and the lens: their light, what they hide, and, in mode `full`, what of their
    /// light is to be spread. Before the halo.
    pub(super) fn compose_snow(&self, pixels: &mut [PixelTruth], mixed: &mut [Mixed]) {
        let flakes = self.flakes();
        if flakes.is_empty() {
            return;
        }
        let i = self.mounted.camera.intrinsics();
        let (width, height) = (i.width_px as usize, i.height_px as usize);
        let mut pieces: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(ROWS)];
        for (index, flake) in flakes.iter().enumerate() {
            let rows = flake.place.span(1, height);
            if !rows.is_empty() {
                let last = (rows.end - 1) / ROWS;
                for piece in &mut pieces[rows.start / ROWS..=last] {
                    piece.push(index as u32);
                }
            }
        }
        pixels
            .par_chunks_mut(width * ROWS)
            .zip(mixed.par_chunks_mut(ROWS))
            .zip(pieces)
            .enumerate()
            .for_each(|(piece, ((pixels, mixed), indices))| {
                let flakes = indices.iter().map(|&index| &flakes[index as usize]);
                self.compose_rows(piece * ROWS, width, pixels, mixed, flakes);
            });
    }

    fn compose_rows<'f>(
        &self,
        first_row: usize,
        width: usize,
        pixels: &mut [PixelTruth],
        mixed: &mut [Mixed],
        flakes: impl Iterator<Item = &'f Flake>,
    ) {
        let mut passed = vec![1.0_f64; pixels.len()];
        let mut before = vec![[0.0_f64; 3]; pixels.len()];
        let mut spread: Vec<Mixed> = vec![Vec::new(); mixed.len()];
        for flake in flakes {
            let rows = flake.place.span(1, first_row + mixed.len());
            for row in rows.start.max(first_row)..rows.end {
                for column in flake.place.span(0, width) {
                    let index = (row - first_row) * width + column;
                    let pixel = &mut pixels[index];
                    let cover = flake.cover(column, row);
                    let hidden = f64::from(pixel.range_m) < flake.place.range_m;
                    if cover < LEAST_COVER || (hidden && !flake.place.is_small()) {
                        continue;
                    }
                    let seen = passed[index] * cover;
                    let lit = seen * flake.shade(column, row);
                    let share = self.share_before(flake.place.range_m, pixel.range_m, column, row);
                    for k in 0..3 {
                        pixel.snow[k] += (lit * flake.direct[k]) as f32;
                        before[index][k] += seen * share[k] * f64::from(pixel.backscatter[k]);
                    }
                    if self.halo.is_some() {
                        let light = flake.scattered.light.map(|light| lit as f32 * light);
                        let scattered = Scattered {
                            light,
                            ..flake.scattered
                        };
                        spread[row - first_row].push((column as u32, scattered));
                    }
                    passed[index] *= 1.0 - cover;
                }
            }
        }
        for ((pixel, &passed), before) in pixels.iter_mut().zip(&passed).zip(&before) {
            if passed == 1.0 {
                continue;
            }
            pixel.snow_cover = (1.0 - passed) as f32;
            let rest = passed as f32;
            for (k, before) in before.iter().enumerate() {
                pixel.direct[k] *= rest;
                pixel.forward[k] *= rest;
                pixel.backscatter[k] = pixel.backscatter[k] * rest + *before as f32;
            }
            // In mode `full` once more, when the halo is known.
            pixel.sum_radiance();
        }
        for (row, (mixed, spread)) in mixed.iter_mut().zip(spread).enumerate() {
            for (column, scattered) in mixed.iter_mut() {
                let rest = passed[row * width + *column as usize] as f32;
                scattered.light = scattered.light.map(|light| rest * light);
            }
            mixed.extend(spread);
        }
    }

    /// How much of a pixel's backscatter comes from before a particle, as if no rod threw a shadow.
    fn share_before(&self, range_m: f64, surface_m: f32, column: usize, row: usize) -> Bands {
        let pixel = Pixel::new(column as f64 + 0.5, row as f64 + 0.5);
        let Some((ray, _)) = self.ray(&pixel) else {
            return [0.0; 3];
        };
        let [near, all] =
            [range_m, f64::from(surface_m)].map(|to_m| self.water_light(&ray, &pixel, to_m));
        core::array::from_fn(|k| {
            if near[k] < all[k] {
                near[k] / all[k]
            } else {
                1.0
            }
        })
    }

    fn water_light(&self, ray: &Ray, pixel: &Pixel, distance_m: f64) -> Bands {
        let veil = self.world.veil(ray, distance_m);
        if !self.world.has_airlight() {
            return veil;
        }
        let lamps = self.airlight.at(self.world, ray, pixel, distance_m);
        core::array::from_fn(|k| lamps[k] + veil[k])
    }
}

#[cfg(test)]
mod tests;
