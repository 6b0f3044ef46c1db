//! Where an eye sees the particles.

use rayon::prelude::*;
use rodsight_geometry::{MountedCamera, Pixel, Vec3};
use rodsight_scene::{Mode, Scene, Snow};

use super::strew::{self, Particle};

/// A particle where an eye sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Its centre in the image.
    pub(crate) at_px: [f64; 2],
    /// From steps of a column and of a row to units of its disc's radius.
    pub(crate) disc_per_px: [[f64; 2]; 2],
    /// How far the disc reaches in columns and rows.
    pub(crate) half_px: [f64; 2],
    /// Of the disc: 1, or less where blur has widened it.
    pub(crate) opacity: f64,
    pub(crate) range_m: f64,
    pub(crate) centre_m: Vec3,
    /// Where the line of sight begins.
    pub(crate) from_m: Vec3,
    pub(crate) to_eye: Vec3,
    /// The axes of the disc, across the view.
    pub(crate) axes: [Vec3; 2],
    /// Radiance at the lens over that in the water.
    pub(crate) gain: f64,
}

/// The snow of a scene that shows it.
pub(crate) fn of_scene(scene: &Scene) -> Option<Snow> {
    scene.snow.filter(|_| scene.mode != Mode::Air)
}

/// The particles that an eye sees if no surface hides them, nearest first.
pub(crate) fn places(scene: &Scene, mounted: &MountedCamera) -> Vec<Place> {
    let Some(snow) = of_scene(scene) else {
        return Vec::new();
    };
    let mut places = strew::in_view(&snow, scene, mounted, |particle| {
        Place::new(scene, mounted, &particle)
    });
    // Stable: equal ranges stay in the order of their cells.
    places.par_sort_by(|a, b| a.range_m.total_cmp(&b.range_m));
    places
}

impl Place {
    fn new(scene: &Scene, mounted: &MountedCamera, particle: &Particle) -> Option<Self> {
        let centre_m = particle.centre_m;
        let sight = mounted.sight(&centre_m)?;
        let to_eye = sight.from_m - centre_m;
        let range_m = to_eye.norm();
        let to_eye = to_eye / range_m;
        let i = mounted.camera.intrinsics();
        let size_px = [f64::from(i.width_px), f64::from(i.height_px)];
        let at_px: [f64; 2] = sight.pixel.into();
        // No disc is larger than the image, and rays far outside may not be there.
        if (0..2).any(|axis| !(at_px[axis].abs() < 2.0 * size_px[axis])) {
            return None;
        }
        // How the place at its range moves with the pixel, m/px, in two axes across the view.
        let aside = to_eye.cross(&least_axis(&to_eye)).normalize();
        let axes = [aside, to_eye.cross(&aside)];
        let step = |along: Pixel| {
            let [a, b] = [-0.5, 0.5].map(|half| mounted.ray(&(sight.pixel + along * half)));
            let [(from_a, along_a), (from_b, along_b)] = [a?, b?];
            let step_m = from_b - from_a + (along_b - along_a) * range_m;
            Some(axes.map(|axis| axis.dot(&step_m)))
        };
        let [right, down] = [step(Pixel::x())?, step(Pixel::y())?];
        let area_m2 = (right[0] * down[1] - down[0] * right[1]).abs();
        let radius_m = particle.radius_m / (1.0 - (particle.radius_m / range_m).powi(2)).sqrt();
        let blur_m = scene.lens.aperture.map_or(0.0, |aperture| {
            let depth_m = mounted.rig_from_camera.inverse().point(&centre_m).z;
            0.5 * aperture.blur_px(mounted, depth_m) * area_m2.sqrt()
        });
        // Of uniform discs: their variances add.
        let disc_m = (radius_m * radius_m + blur_m * blur_m).sqrt();
        let disc_per_px = [0, 1].map(|axis| [right[axis] / disc_m, down[axis] / disc_m]);
        let half_px = half_extent(&disc_per_px)?;
        let outside = |axis: usize| {
            at_px[axis] + half_px[axis] <= 0.0 || at_px[axis] - half_px[axis] >= size_px[axis]
        };
        if outside(0) || outside(1) {
            return None;
        }
        let inside = Pixel::new(
            at_px[0].clamp(0.0, size_px[0]),
            at_px[1].clamp(0.0, size_px[1]),
        );
        Some(Self {
            at_px,
            disc_per_px,
            half_px,
            opacity: (radius_m / disc_m) * (radius_m / disc_m),
            range_m,
            centre_m,
            from_m: sight.from_m,
            to_eye,
            axes,
            gain: mounted.water_ray(&inside)?.gain,
        })
    }

    /// The rows or columns it touches, of so many.
    pub(crate) fn span(&self, axis: usize, size: usize) -> core::ops::Range<usize> {
        let [from, to] = [-1.0, 1.0].map(|side| self.at_px[axis] + side * self.half_px[axis]);
        let last = libm::ceil(to).clamp(0.0, size as f64) as usize;
        (from.max(0.0) as usize).min(last)..last
    }

    /// Smaller than a pixel, so that one ray tells whether it is hidden.
    pub(crate) fn is_small(&self) -> bool {
        self.half_px[0].max(self.half_px[1]) < 1.0
    }

    /// Large and sharp enough to be seen to be round.
    pub(crate) fn is_round(&self) -> bool {
        self.half_px[0].min(self.half_px[1]) > super::ROUND_PX && self.opacity > 0.5
    }
}

/// The axis along which a vector is shortest.
fn least_axis(vector: &Vec3) -> Vec3 {
    let mut axis = Vec3::zeros();
    axis[vector.iamin()] = 1.0;
    axis
}

/// How far the ellipse |M x| = 1 reaches in columns and rows: the roots of the diagonal of (MᵀM)⁻¹.
fn half_extent([[a, b], [c, d]]: &[[f64; 2]; 2]) -> Option<[f64; 2]> {
    let area = (a * d - b * c).abs();
    (area > 0.0 && area.is_finite())
        .then(|| [(b * b + d * d).sqrt() / area, (a * a + c * c).sqrt() / area])
}
