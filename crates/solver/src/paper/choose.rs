//! Which strip of the left eye and which of the right are the same rod, and how sure that is.

use rodsight_geometry::{Eye, MountedCamera, Pixel, Rig, Vec3};

use super::Centre;
use super::locate::{Setting, locate};
use super::pair::Strip;

/// One rod in both eyes.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    pub strips: [Strip; 2],
    /// Score of the best other rod over this one's.
    pub runner_up_ratio: f64,
}

/// Ratios of two widths or radii of one rod spread by about this much, as a natural logarithm: enough for the taper and for
/// pixel edges of a thin rod.
const LOG_RATIO_SPREAD: f64 = 0.3;

/// Nearer to the baseline than this a rod's depth is not looked at to tell rods apart: 3°.
const OFF_BASELINE_RAD: f64 = 0.05;

pub(crate) struct Chooser<'a> {
    pub rig: &'a Rig,
    pub centre: Centre,
    pub pick: Option<(Eye, (Vec3, Vec3))>,
    pub prior_radius_m: Option<f64>,
}

impl Chooser<'_> {
    pub(crate) fn choose(&self, left: &[Strip], right: &[Strip]) -> Option<Choice> {
        let mut pairs: Vec<(f64, &Strip, &Strip)> = Vec::new();
        for l in left {
            for r in right {
                pairs.push((l.score * r.score * self.consistency(l, r), l, r));
            }
        }
        // Stable: of equal scores the one with most points in the left eye.
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let &(best, l, r) = pairs.first()?;
        let other = pairs
            .iter()
            .find(|(_, l2, r2)| !(l.is_same_rod(l2) && r.is_same_rod(r2)));
        Some(Choice {
            strips: [l.clone(), r.clone()],
            runner_up_ratio: other.map_or(0.0, |(score, ..)| score / best.max(f64::MIN_POSITIVE)),
        })
    }

    /// Where the rod is looked at: the pick, else the middle of what the left eye sees.
    pub(crate) fn looked_at(&self, left: &Strip) -> Option<(Eye, (Vec3, Vec3))> {
        self.pick.or_else(|| {
            let ray = undistorted_ray(&self.rig.left, &left.middle_px)?;
            Some((Eye::Left, ray))
        })
    }

    /// How well two strips agree to be one rod, in [0, 1].
    fn consistency(&self, left: &Strip, right: &Strip) -> f64 {
        let Some((eye, middle)) = self.looked_at(left) else {
            return 0.0;
        };
        let setting = Setting {
            rig: self.rig,
            centre: self.centre,
            pick: None,
            middle,
            radius: None,
            by_radius: None,
        };
        let widths = agreement(left.width_px, right.width_px);
        let Some(location) = locate(&setting, &[left.lines(), right.lines()]) else {
            return 0.5 * widths;
        };
        // Depth and radius say nothing of a rod in one plane with the baseline; what is seen alike is alike.
        if location.off_baseline_rad < OFF_BASELINE_RAD {
            return 0.5 * widths;
        }
        let (other_eye, other) = match eye {
            Eye::Left => (Eye::Right, right),
            Eye::Right => (Eye::Left, left),
        };
        let mounted = self.rig.eye(other_eye);
        let camera = mounted.camera.without_distortion();
        let in_other = mounted.rig_from_camera.inverse().point(&location.seen_m);
        let Some(seen) = camera
            .project(&in_other)
            .filter(|_| location.seen_along_m > 0.0)
        else {
            return 1e-3;
        };
        let [l, r] = location.radii_m;
        let radii = agreement(l, r)
            * self
                .prior_radius_m
                .map_or(1.0, |prior| agreement(location.radius_m, prior));
        // Both eyes should see the stretch that was looked at; regions may cut it off.
        let reaches = other.distance_px(&seen) <= 20.0 + 0.2 * other.half_length_px;
        radii * if reaches { 1.0 } else { 0.3 }
    }
}

fn agreement(a: f64, b: f64) -> f64 {
    let log = libm::log(a / b) / LOG_RATIO_SPREAD;
    libm::exp(-0.5 * log * log).max(1e-6)
}

/// The ray, in the rig frame, of a point of the undistorted image.
fn undistorted_ray(mounted: &MountedCamera, pixel: &Pixel) -> Option<(Vec3, Vec3)> {
    let camera = mounted.camera.without_distortion();
    Some((
        mounted.rig_from_camera.origin_m(),
        mounted.rig_from_camera.direction(&camera.ray(pixel)?),
    ))
}
