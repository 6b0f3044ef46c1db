//! Colour of a rod's side: stripes and grain in the rod's own coordinates, prefiltered so that one sample a pixel does not alias.

use core::f64::consts::TAU;

use rodsight_geometry::Vec3;
use rodsight_optics::Bands;
use rodsight_scene::{Grain, Rod, Stripes};

use super::arc::Arc;
use super::solid::Ray;
use crate::lattice::pcg;

/// A place on a rod's side, and how large a sample is there.
pub(crate) struct Place {
    pub(crate) along_m: f64,
    /// Right-handed about the axis.
    pub(crate) angle_rad: f64,
    pub(crate) axis: Vec3,
    pub(crate) around: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) eye: Vec3,
    /// Across the ray, m.
    pub(crate) footprint_m: f64,
}

impl Place {
    /// Where a ray of this direction meets the side; `footprint_m` is the distance of samples across it.
    pub(crate) fn new(
        arc: &Arc,
        point_m: &Vec3,
        normal: &Vec3,
        direction: &Vec3,
        footprint_m: f64,
    ) -> Self {
        let along_m = arc.parameter_of(point_m);
        let axis = arc.at(along_m);
        let [e1, e2] = arc.across(along_m);
        let out = point_m - axis.point_m;
        Self {
            along_m,
            angle_rad: libm::atan2(out.dot(&e2), out.dot(&e1)),
            axis: axis.direction,
            around: axis.direction.cross(normal),
            normal: *normal,
            eye: *direction,
            footprint_m,
        }
    }

    /// How much a quantity of this gradient (per metre along the surface) changes within a sample at most: a step of the ray
    /// sideways moves its foot along the surface, the farther the flatter the surface is seen.
    pub(crate) fn change(&self, gradient: &Vec3) -> f64 {
        let facing = self.normal.dot(&self.eye);
        let facing = facing.abs().max(1e-3).copysign(facing);
        let seen = gradient - self.normal * (gradient.dot(&self.eye) / facing);
        seen.norm() * self.footprint_m
    }
}

/// Albedo of a rod where a ray meets its side; `footprint_m` is the distance of samples across the ray.
pub(crate) fn albedo(
    (rod, arc): (&Rod, &Arc),
    base: &Bands,
    seed_word: u32,
    (ray, t_m, normal): (&Ray, f64, &Vec3),
    footprint_m: f64,
) -> Bands {
    let finish = &rod.finish;
    if finish.stripes.is_none() && finish.grain.is_none() {
        return *base;
    }
    let place = Place::new(arc, &ray.at(t_m), normal, &ray.direction, footprint_m);
    let mut colour = *base;
    if let Some(stripes) = &finish.stripes {
        let share = covered(stripes, &place, rod.radius_m);
        colour = core::array::from_fn(|k| base[k] + share * (stripes.albedo[k] - base[k]));
    }
    if let Some(grain) = &finish.grain {
        let factor = 1.0 + grain.contrast * relief(grain, &place, rod.radius_m, seed_word);
        colour = colour.map(|c| c * factor);
    }
    colour
}

/// The share of a sample that stripes cover: the mean of the square wave over the sample's width.
pub(crate) fn covered(stripes: &Stripes, place: &Place, radius_m: f64) -> f64 {
    let starts = f64::from(stripes.starts);
    let phase = place.along_m / stripes.period_m - starts * place.angle_rad / TAU;
    let gradient = place.axis / stripes.period_m - place.around * (starts / (TAU * radius_m));
    let half = 0.5 * place.change(&gradient).max(1e-9);
    let sum = up_to(stripes.share, phase + half) - up_to(stripes.share, phase - half);
    (sum / (2.0 * half)).clamp(0.0, 1.0)
}

/// The integral up to x of a square wave of period 1 that begins each period high.
pub(crate) fn up_to(share: f64, x: f64) -> f64 {
    let whole = libm::floor(x);
    whole * share + (x - whole).min(share)
}

/// Octaves of value noise in [−1, 1]; those finer than two samples are left out.
pub(crate) fn relief(grain: &Grain, place: &Place, radius_m: f64, seed_word: u32) -> f64 {
    // Amplitudes 0.4 · 0.6^k: all of them together stay within 1.
    let (mut wavelength_m, mut amplitude, mut relief) = (grain.scale_m, 0.4, 0.0);
    let sample_m = place.change(&place.axis).max(place.change(&place.around));
    for octave in 0..8 {
        let fade = (wavelength_m / (2.0 * sample_m) - 1.0).clamp(0.0, 1.0);
        if fade == 0.0 {
            break;
        }
        // A whole number of cells around, or the seam would show.
        let cells = libm::round(TAU * radius_m / wavelength_m).max(3.0);
        let around = (place.angle_rad / TAU + 0.5) * cells;
        let along = place.along_m / wavelength_m;
        relief += fade * amplitude * value_noise(seed_word, octave, along, around, cells as u32);
        wavelength_m *= 0.5;
        amplitude *= 0.6;
    }
    relief
}

/// Smooth noise in [−1, 1] with a node at every integer, of period `cells` in y.
pub(crate) fn value_noise(seed_word: u32, octave: u32, x: f64, y: f64, cells: u32) -> f64 {
    let (x0, y0) = (libm::floor(x), libm::floor(y));
    let smooth = |s: f64| s * s * s * (s * (6.0 * s - 15.0) + 10.0);
    let (sx, sy) = (smooth(x - x0), smooth(y - y0));
    let node = |i: f64, j: u32| {
        let row = (y0 as u32 + j) % cells;
        let column =
            pcg(((x0 + i) as i64 as u32).wrapping_add(pcg(octave.wrapping_add(seed_word))));
        f64::from(pcg(row.wrapping_add(column)) >> 8) / f64::from(1 << 23) - 1.0
    };
    let row = |j: u32| node(0.0, j) * (1.0 - sx) + node(1.0, j) * sx;
    row(0) * (1.0 - sy) + row(1) * sy
}

/// All of a scene's seed, and which rod, in 32 bits.
pub(crate) fn seed_word(seed: u64, rod: usize) -> u32 {
    pcg((seed >> 32) as u32 ^ pcg((seed as u32) ^ pcg(rod as u32 + 1)))
}

#[cfg(test)]
mod tests {
    use rodsight_scene::{Finish, Material};

    use super::*;

    fn rod(finish: Finish) -> Rod {
        Rod {
            id: "r".to_owned(),
            centre_m: Vec3::new(2.0, 0.0, 0.0),
            direction: Vec3::z(),
            length_m: 4.0,
            radius_m: 0.05,
            bend: None,
            material: Material::Lambert([0.5; 3]),
            finish,
            fouling: None,
        }
    }

    /// Mean and extremes over the side of a rod, seen from right outside every point.
    fn survey(rod: &Rod, footprint_m: f64) -> (f64, f64, f64) {
        let arc = Arc::of(rod);
        let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, 0.0_f64);
        let (rows, columns) = (2000, 64);
        for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            let z = (f64::from(i) / f64::from(rows) - 0.5) * rod.length_m;
            let (sin, cos) = libm::sincos(TAU * (f64::from(j) + 0.3) / f64::from(columns));
            let normal = Vec3::new(cos, sin, 0.0);
            let ray = Ray {
                origin_m: Vec3::new(2.0, 0.0, z) + normal * 1.05,
                direction: -normal,
            };
            let found = albedo((rod, &arc), &[0.5; 3], 7, (&ray, 1.0, &normal), footprint_m)[0];
            (sum, least, most) = (sum + found, least.min(found), most.max(found));
        }
        (sum / f64::from(rows * columns), least, most)
    }

    #[test]
    fn grain_has_the_mean_asked_for_and_fades_with_the_footprint() {
        let grained = rod(Finish {
            grain: Some(Grain {
                contrast: 0.8,
                scale_m: 0.02,
            }),
            ..Finish::default()
        });
        let (mean, least, most) = survey(&grained, 1e-4);
        // 2000 × 16 nodes of the coarsest octave over which the mean is taken: well within 1 %.
        assert!((mean / 0.5 - 1.0).abs() < 0.01, "{mean}");
        assert!(
            least > 0.1 && least < 0.4 && most > 0.6 && most < 0.9,
            "{least} to {most}"
        );
        let (blurred, low, high) = survey(&grained, 0.02);
        assert!(
            blurred == 0.5 && low == 0.5 && high == 0.5,
            "finer than two samples: gone"
        );
    }

    #[test]
    fn stripes_cover_their_share_near_and_far() {
        for starts in [0, 1, 3] {
            let striped = rod(Finish {
                stripes: Some(Stripes {
                    period_m: 0.1,
                    albedo: [0.9; 3],
                    share: 0.25,
                    starts,
                }),
                ..Finish::default()
            });
            let (mean, least, most) = survey(&striped, 1e-6);
            assert!((mean - 0.6).abs() < 0.002, "{starts}: {mean}");
            assert!(
                least == 0.5 && (most - 0.9).abs() < 1e-12,
                "{least} to {most}"
            );
            // A sample of two periods and a half sees little of them, one of a thousand nothing.
            let (far, low, high) = survey(&striped, 100.0);
            assert!(
                (far - 0.6).abs() < 1e-3 && high - low < 1e-3,
                "{far} {low} {high}"
            );
        }
    }

    /// A right-handed helix goes forward along the axis as it turns right-handedly about it; the seam of the angle does not show.
    #[test]
    fn helices_are_right_handed_and_closed() {
        let striped = rod(Finish {
            stripes: Some(Stripes {
                period_m: 0.1,
                albedo: [1.0; 3],
                share: 0.5,
                starts: 1,
            }),
            ..Finish::default()
        });
        let arc = Arc::of(&striped);
        let at = |angle: f64, z: f64| {
            let (sin, cos) = libm::sincos(angle);
            let normal = Vec3::new(cos, sin, 0.0);
            let ray = Ray {
                origin_m: Vec3::new(2.0, 0.0, z) + normal * 1.05,
                direction: -normal,
            };
            albedo((&striped, &arc), &[0.0; 3], 7, (&ray, 1.0, &normal), 1e-7)[0]
        };
        for step in 0..200 {
            let (angle, z) = (f64::from(step) * 0.37, f64::from(step) * 0.013 - 1.3);
            // A hundredth of a turn with a hundredth of the pitch: the same place of the band, but where its edge lies just here.
            let turned = at(angle + TAU / 100.0, z + 0.001);
            assert!((at(angle, z) - turned).abs() < 1e-3, "step {step}");
            assert!((at(angle, z) - at(angle + TAU, z)).abs() < 1e-3);
        }
    }
}
