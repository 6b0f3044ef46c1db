//! What surfaces give the halo, in the image and around it.

use rodsight_geometry::{MountedCamera, Pixel};
use rodsight_optics::Bands;

use super::Caster;
use super::halo::Scattered;
use super::solid::Ray;

impl Caster<'_> {
    /// The part of a surface's light that arrives scattered.
    pub(super) fn scattered(&self, wet: &Bands, range_m: f64) -> Scattered {
        match &self.halo {
            Some(halo) if range_m.is_finite() => {
                let total = halo.total(range_m);
                Scattered {
                    light: core::array::from_fn(|k| (wet[k] * total[k]) as f32),
                    range_m: range_m as f32,
                }
            }
            _ => Scattered::default(),
        }
    }

    /// The same for a place outside the image.
    pub(super) fn beyond(&self, place: &Pixel) -> Scattered {
        let Some((ray, gain)) = self.ray_beyond(place) else {
            return Scattered::default();
        };
        let sample = self.light_of(&ray, gain, self.world.hit(&ray).as_ref());
        self.scattered(&sample.wet, sample.range_m)
    }

    /// The ray of a place outside the image, with its gain. A lens with distortion or a port has none there that is sure: its rays turn
    /// on as they do at the border.
    fn ray_beyond(&self, place: &Pixel) -> Option<(Ray, f64)> {
        if self.mounted.is_pinhole() {
            return self.ray(place);
        }
        let i = self.mounted.camera.intrinsics();
        let border = Pixel::new(
            place.x.clamp(0.0, f64::from(i.width_px)),
            place.y.clamp(0.0, f64::from(i.height_px)),
        );
        let (ray, gain) = self.ray(&border)?;
        let mut direction = ray.direction;
        for (axis, out_px) in [
            (Pixel::x(), place.x - border.x),
            (Pixel::y(), place.y - border.y),
        ] {
            let (inside, _) = self.ray(&(border - axis * out_px.signum()))?;
            direction += (ray.direction - inside.direction) * out_px.abs();
        }
        let direction = direction.normalize();
        Some((Ray { direction, ..ray }, gain))
    }
}

/// Pixels per rad at the middle of the image, where the halo's widths are those of the water. Off its axis a pinhole's pixels are
/// narrower, by up to cos² of the angle, and the halo does not follow.
pub(crate) fn middle_px_per_rad(mounted: &MountedCamera) -> f64 {
    let i = mounted.camera.intrinsics();
    let middle = Pixel::new(0.5 * f64::from(i.width_px), 0.5 * f64::from(i.height_px));
    let angle_rad = |to: Pixel, focal_px: f64| {
        let rays = [middle - to * 0.5, middle + to * 0.5].map(|pixel| mounted.ray(&pixel));
        match rays {
            [Some((_, a)), Some((_, b))] => (a - b).norm(),
            _ => 1.0 / focal_px,
        }
    };
    1.0 / (angle_rad(Pixel::x(), i.fx_px) * angle_rad(Pixel::y(), i.fy_px)).sqrt()
}

/// Width around the image that is sampled finely: about a sixth of a rad.
pub(crate) fn overscan_px(mounted: &MountedCamera) -> usize {
    ((middle_px_per_rad(mounted) / 8.0) as usize)
        .next_power_of_two()
        .clamp(16, 1024)
}
