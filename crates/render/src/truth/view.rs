//! What one eye sees of one rod.

use rodsight_geometry::{Cylinder, Line3, MountedCamera, Pixel, Side, Vec3};
use rodsight_scene::Rod;

use super::places::{Places, beside};
use super::{ConeTruth, EyeTruth};
use crate::cpu::arc::Arc;
use crate::cpu::solid::Ray;
use crate::cpu::world::{Thing, World};
use crate::develop::noise_sigma;
use crate::frame::EyeFrame;
use crate::srgb::srgb_encode;

/// One rod in one eye.
pub(super) struct EyeView<'a> {
    pub(super) world: &'a World<'a>,
    pub(super) rod: &'a Rod,
    pub(super) arc: Arc,
    pub(super) mounted: &'a MountedCamera,
    pub(super) frame: &'a EyeFrame,
    /// What falls on the sensor.
    pub(super) light: &'a [[f32; 3]],
}

/// Distance in the image of places at which a rod is looked for: what hides less of it may be missed, px.
const SIGHT_STEP_PX: f64 = 1.0;
/// Distance of the points of a curve before those that its bend asks for, px: few, but no bend goes unseen between them.
const CURVE_STEP_PX: f64 = 32.0;
/// Half of what a reader who joins the points by straight lines may be off, px.
const CURVE_ERROR_PX: f64 = 5e-4;
/// A piece of a curve becomes at most 2¹² pieces.
const MAX_HALVINGS: u32 = 12;
/// Halvings that leave of a piece of a rod less than shows.
const MAX_BISECTIONS: u32 = 40;
/// Pixels from the limb at which contrast is measured, on either side: outside any blur. Within a thin rod, no farther than its axis.
const CONTRAST_REACH_PX: f64 = 2.5;

impl EyeView<'_> {
    pub(super) fn truth(&self, index: usize, gain: f64) -> EyeTruth {
        let camera_from_rig = self.mounted.rig_from_camera.inverse();
        let axis = self.arc.at(0.0);
        let straight = self.rod.bend.is_none() && self.mounted.is_pinhole();
        let lines = straight
            .then(|| {
                let cylinder = Cylinder {
                    axis,
                    radius_m: self.rod.radius_m,
                };
                cylinder.image_lines(&self.mounted.camera, &self.mounted.rig_from_camera)
            })
            .flatten()
            .map(|[plus_limb, minus_limb, axis]| ConeTruth {
                plus_limb,
                minus_limb,
                axis,
            });
        let visible_m = self.visible_stretches(index);
        let instance = self.world.scene.rod_instance(index);
        EyeTruth {
            axis_in_camera: Line3 {
                point_m: camera_from_rig.point(&axis.point_m),
                direction: camera_from_rig.direction(&axis.direction),
            }
            .into(),
            curves: if lines.is_some() { None } else { self.curves() },
            lines,
            contrast_to_noise: [1.0, -1.0]
                .map(|side| self.contrast_to_noise(side, &visible_m, gain)),
            visible_m,
            visible_px: self
                .frame
                .pixels
                .iter()
                .filter(|pixel| pixel.instance == instance)
                .count() as u64,
        }
    }

    /// Point of a limb (side ±1) or of the axis (0) at arc length s: the surface point at which the ray touches.
    fn contour_point(&self, s_m: f64, side: f64) -> Option<Vec3> {
        let axis = self.arc.at(s_m);
        if side == 0.0 {
            return Some(axis.point_m);
        }
        let cylinder = Cylinder {
            axis,
            radius_m: self.rod.radius_m,
        };
        let side = if side > 0.0 { Side::Plus } else { Side::Minus };
        self.mounted.limb_point_m(&cylinder, side)
    }

    /// Arc lengths close enough together for a curve along the rod, with its pixels.
    fn places(
        &self,
        half_m: f64,
        step_px: f64,
        pixel_at: &dyn Fn(f64) -> Option<Pixel>,
    ) -> Vec<(f64, Option<Pixel>)> {
        let places = Places {
            mounted: self.mounted,
            axis_at: &|s_m| self.arc.at(s_m).point_m,
            pixel_at,
            step_px,
        };
        places.along(half_m)
    }

    fn curves(&self) -> Option<ConeTruth<Vec<[f64; 2]>>> {
        let curve = |side: f64| -> Option<Vec<[f64; 2]>> {
            let at = |s_m: f64| self.mounted.project(&self.contour_point(s_m, side)?);
            let places = self.places(self.rod.length_m / 2.0, CURVE_STEP_PX, &at);
            let mut points: Vec<Pixel> = Vec::new();
            points.extend(places[0].1);
            for pair in places.windows(2) {
                let [from, to] = [pair[0], pair[1]].map(|(s_m, pixel)| Some((s_m, pixel?)));
                let reached = match (from, to) {
                    (Some(from), Some(to)) => Some([from, to]),
                    (Some(from), None) => Some([from, self.last_seen(&at, from, pair[1].0)]),
                    (None, Some(to)) => Some([self.last_seen(&at, to, pair[0].0), to]),
                    (None, None) => None,
                };
                if let Some([begin, end]) = reached {
                    points.extend(from.is_none().then_some(begin.1));
                    self.between(&at, begin, end, MAX_HALVINGS, &mut points);
                    points.push(end.1);
                }
            }
            (points.len() > 1).then(|| points.into_iter().map(Into::into).collect())
        };
        Some(ConeTruth {
            plus_limb: curve(1.0)?,
            minus_limb: curve(-1.0)?,
            axis: curve(0.0)?,
        })
    }

    /// The last point of a curve that is seen on the way from a seen place to one that is not, or the first outside the image.
    fn last_seen(
        &self,
        at: &dyn Fn(f64) -> Option<Pixel>,
        mut seen: (f64, Pixel),
        mut unseen_m: f64,
    ) -> (f64, Pixel) {
        for _ in 0..MAX_BISECTIONS {
            if !self.mounted.camera.contains(&seen.1) {
                break;
            }
            let middle_m = 0.5 * (seen.0 + unseen_m);
            match at(middle_m) {
                Some(pixel) => seen = (middle_m, pixel),
                None => unseen_m = middle_m,
            }
        }
        seen
    }

    /// Points between two of a curve, so that in the image the curve is within `CURVE_ERROR_PX` of the straight pieces.
    fn between(
        &self,
        at: &dyn Fn(f64) -> Option<Pixel>,
        from: (f64, Pixel),
        to: (f64, Pixel),
        halvings: u32,
        points: &mut Vec<Pixel>,
    ) {
        if halvings == 0 || beside(self.mounted.camera.intrinsics(), &from.1, &to.1) {
            return;
        }
        let s_m = 0.5 * (from.0 + to.0);
        let Some(middle) = at(s_m) else { return };
        let chord = to.1 - from.1;
        let sag_px = chord.perp(&(middle - from.1)).abs() / chord.norm().max(1e-9);
        if sag_px > CURVE_ERROR_PX {
            self.between(at, from, (s_m, middle), halvings - 1, points);
            points.push(middle);
            self.between(at, (s_m, middle), to, halvings - 1, points);
        }
    }

    /// Whether the surface over the axis point at s is in the image and nothing hides it.
    fn is_visible(&self, s_m: f64, index: usize) -> bool {
        let axis = self.arc.at(s_m);
        let Some(sight) = self.mounted.sight(&axis.point_m) else {
            return false;
        };
        let (origin_m, inside) = (sight.from_m, self.mounted.camera.contains(&sight.pixel));
        let to_axis = axis.point_m - origin_m;
        let distance_m = to_axis.norm();
        let ray = Ray {
            origin_m,
            direction: to_axis / distance_m,
        };
        // The surface over this point, not another turn of a bent rod, nor a cap that hides all behind it.
        let depth_m = self.rod.radius_m / ray.direction.cross(&axis.direction).norm();
        let foot_m = axis.foot(&origin_m);
        let grown_m = self.rod.fouling.map_or(0.0, |fouling| fouling.height_m);
        inside
            && (foot_m - origin_m).norm() > self.rod.radius_m
            && self.world.hit(&ray).is_some_and(|hit| {
                // What grows on a rod does not hide it.
                let own = [Thing::Rod(index), Thing::Growth(index)].contains(&hit.thing);
                own && distance_m - hit.t_m <= depth_m * (1.0 + grown_m / self.rod.radius_m) * 1.01
            })
    }

    fn visible_stretches(&self, index: usize) -> Vec<[f64; 2]> {
        let half = self.rod.length_m / 2.0;
        // A hair inside the ends: a ray to the very end may slip past the cap.
        let pixel_at = |s_m: f64| self.mounted.project(&self.arc.at(s_m).point_m);
        let places = self.places(half * (1.0 - 1e-9), SIGHT_STEP_PX, &pixel_at);
        let mut stretches = Vec::new();
        let mut begin = self.is_visible(places[0].0, index).then_some(-half);
        for pair in places.windows(2) {
            let [mut a, mut b] = [pair[0].0, pair[1].0];
            let was = begin.is_some();
            if self.is_visible(b, index) == was {
                continue;
            }
            for _ in 0..MAX_BISECTIONS {
                let middle = 0.5 * (a + b);
                if self.is_visible(middle, index) == was {
                    a = middle;
                } else {
                    b = middle;
                }
            }
            match begin.take() {
                Some(start) => stretches.push([start, b]),
                None => begin = Some(b),
            }
        }
        stretches.extend(begin.map(|start| [start, half]));
        stretches
    }

    /// Mean over the visible limb of the noise-free encoded difference across it, over the noise there.
    fn contrast_to_noise(&self, side: f64, visible_m: &[[f64; 2]], gain: f64) -> Option<f64> {
        const STEPS: usize = 64;
        let scene = self.world.scene;
        let (mut squares, mut count) = (0.0, 0.0);
        for [from, to] in visible_m {
            for i in 0..STEPS {
                let s_m = from + (to - from) * (i as f64 + 0.5) / STEPS as f64;
                let Some([inside, outside]) = self.across_limb(s_m, side) else {
                    continue;
                };
                for k in 0..3 {
                    let [a, b] = [inside[k], outside[k]].map(|light| gain * f64::from(light));
                    let balance = scene.white_balance[k];
                    let difference = srgb_encode(balance * a) - srgb_encode(balance * b);
                    let [sigma_a, sigma_b] =
                        [a, b].map(|signal| noise_sigma(&scene.sensor, signal, balance));
                    let variance = f64::midpoint(sigma_a * sigma_a, sigma_b * sigma_b);
                    if variance == 0.0 {
                        return None;
                    }
                    squares += difference * difference / variance;
                }
                count += 1.0;
            }
        }
        // The mean of the squares: what counts for the limit is information, and it adds up whatever the sign of the contrast.
        (count > 0.0).then(|| (squares / count).sqrt())
    }

    /// Light just inside and just outside a limb at s.
    fn across_limb(&self, s_m: f64, side: f64) -> Option<[[f32; 3]; 2]> {
        let limb_at = |s_m: f64| self.mounted.project(&self.contour_point(s_m, side)?);
        let limb = limb_at(s_m)?;
        let step_m = 0.1 * self.rod.radius_m;
        let along = (limb_at(s_m + step_m)? - limb_at(s_m - step_m)?).try_normalize(1e-12)?;
        let across = Pixel::new(-along.y, along.x);
        let to_axis = (self.mounted.project(&self.arc.at(s_m).point_m)? - limb).dot(&across);
        let inwards = across * to_axis.signum();
        let radiance = |pixel: Pixel| {
            self.mounted.camera.contains(&pixel).then(|| {
                let column = (pixel.x as u32).min(self.frame.width_px - 1);
                let row = (pixel.y as u32).min(self.frame.height_px - 1);
                self.light[(row * self.frame.width_px + column) as usize]
            })
        };
        Some([
            radiance(limb + inwards * to_axis.abs().min(CONTRAST_REACH_PX))?,
            radiance(limb - inwards * CONTRAST_REACH_PX)?,
        ])
    }
}
