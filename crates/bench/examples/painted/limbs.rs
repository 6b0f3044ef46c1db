//! The statistical limit of a painted pair, from the painter's light without noise.

use rodsight_bench::{LimbStretch, Limit, edge_sigma_px, limit_of, step_contrast_to_noise};
use rodsight_geometry::{Cylinder, Eye, Line3, Pixel, Side};

use super::painter::{Disc, Scene};

/// Length of the stretches over which a limb's contrast is taken for constant, px.
const STRETCH_PX: f64 = 4.0;
/// Fineness across an edge, in units of its spread: a Gaussian is integrated to a thousandth.
const STEP: f64 = 0.25;
/// How far across an edge its profile is followed, in units of its spread.
const REACH: f64 = 4.0;

/// The limbs of the first rod, as far as they are painted and nothing hides them.
pub(crate) struct Limbs {
    stretches: Vec<LimbStretch>,
}

impl Limbs {
    pub(crate) fn of(scene: &Scene) -> Self {
        let sides = [Side::Plus, Side::Minus];
        let stretches = scene.rods.first().map_or(Vec::new(), |rod| {
            Eye::BOTH
                .into_iter()
                .flat_map(|eye| {
                    let discs = scene.discs(eye);
                    sides
                        .map(|side| limb(scene, rod, eye, side, &discs))
                        .concat()
                })
                .collect()
        });
        Self { stretches }
    }

    /// The limit of a straight rod; `None` of a bent one, without one, and where too little of it is seen.
    pub(crate) fn limit(&self, scene: &Scene) -> Option<Limit> {
        if scene.curvature_per_m.norm() > 0.0 {
            return None;
        }
        limit_of(&scene.rig, scene.rods.first()?, &self.stretches)
    }

    /// The contrast over noise, root mean square over the length that is seen.
    pub(crate) fn contrast_to_noise(&self) -> Option<f64> {
        let contrasts = self.stretches.iter().map(|s| s.contrast_to_noise);
        let squares: f64 = contrasts.map(|contrast| contrast * contrast).sum();
        let count = self.stretches.len();
        (count > 0).then(|| libm::sqrt(squares / count as f64))
    }

    /// How much of them is seen, in pieces of a length.
    pub(crate) fn pieces(&self) -> usize {
        self.stretches.len()
    }
}

/// One limb, cut where the painted region's borders are and into pieces as long in the image.
fn limb(scene: &Scene, rod: &Cylinder, eye: Eye, side: Side, discs: &[Disc]) -> Vec<LimbStretch> {
    let mounted = scene.rig.eye(eye);
    let seen_at = |along_m: f64| {
        let at = Line3 {
            point_m: rod.axis.point_m + rod.axis.direction * along_m,
            ..rod.axis
        };
        let here = Cylinder { axis: at, ..*rod };
        Some((
            mounted.project(&mounted.limb_point_m(&here, side)?)?,
            mounted.project(&at.point_m)?,
        ))
    };
    let mut found = Vec::new();
    // From the middle to either end, until the region ends.
    for towards in [-1.0, 1.0] {
        let (mut from_m, mut is_near) = (0.0, false);
        for _ in 0..4000 {
            let Some((from, _)) = seen_at(from_m) else {
                break;
            };
            // Metres per pixel here, by a small step.
            let small_m = 1e-4 * towards;
            let Some((next, _)) = seen_at(from_m + small_m) else {
                break;
            };
            let speed_px_per_m = (next - from).norm() / small_m.abs();
            let to_m = from_m + towards * STRETCH_PX / speed_px_per_m.max(1.0);
            if to_m.abs() > scene.half_length_m {
                break;
            }
            let middle_m = f64::midpoint(from_m, to_m);
            let Some((at, axis)) = seen_at(middle_m) else {
                break;
            };
            let along = (next - from).normalize();
            let normal = Pixel::new(-along.y, along.x);
            let inwards = normal * (axis - at).dot(&normal).signum();
            if let Some(contrast_to_noise) = contrast(scene, eye, [&at, &inwards], discs) {
                is_near = true;
                found.push(LimbStretch {
                    eye,
                    side,
                    span_m: [from_m.min(to_m), from_m.max(to_m)],
                    contrast_to_noise,
                    edge_sigma_px: edge_sigma_px(scene.blur_px),
                });
            } else if is_near && !is_painted(scene, eye, &at) {
                break;
            }
            from_m = to_m;
        }
    }
    found
}

fn is_painted(scene: &Scene, eye: Eye, at: &Pixel) -> bool {
    scene.only[eye as usize].is_none_or(|roi| {
        let [x, y] = [at.x - f64::from(roi.x_px), at.y - f64::from(roi.y_px)];
        (0.0..f64::from(roi.width_px)).contains(&x) && (0.0..f64::from(roi.height_px)).contains(&y)
    })
}

/// What the stored profile across the limb is worth; `None` where the limb is hidden or at the region's border.
fn contrast(scene: &Scene, eye: Eye, [at, inwards]: [&Pixel; 2], discs: &[Disc]) -> Option<f64> {
    let spread_px = edge_sigma_px(scene.blur_px);
    let step_px = STEP * spread_px;
    let half = (REACH / STEP) as i32;
    let reach_px = 2.0 * REACH * spread_px;
    let near: Vec<&Disc> = discs
        .iter()
        .filter(|disc| (disc.centre_px - at).norm() < disc.radius_px + reach_px + 1.0)
        .collect();
    // As far again as the profile: the spread reaches beyond its ends.
    let light: Option<Vec<[f64; 3]>> = (-2 * half..=2 * half)
        .map(|k| {
            // Between the steps, so that the limb itself is at a border.
            let place = at + inwards * ((f64::from(k) + 0.5) * step_px);
            let (light, range_m) = scene.light(eye, place.x, place.y)?;
            let is_hidden = near.iter().any(|disc| {
                range_m > disc.range_m && (disc.centre_px - place).norm() < disc.radius_px + 0.5
            });
            (!is_hidden).then_some(light)
        })
        .collect();
    let light = light?;
    let weights: Vec<f64> = (-half..=half)
        .map(|k| libm::exp(-0.5 * (f64::from(k) * STEP) * (f64::from(k) * STEP)))
        .collect();
    let total: f64 = weights.iter().sum();
    let sigma = scene.stored_sigma();
    let spread = light.windows(weights.len()).map(|window| {
        let mut sum = [0.0; 3];
        for (weight, light) in weights.iter().zip(window) {
            for (sum, value) in sum.iter_mut().zip(light) {
                *sum += weight / total * value;
            }
        }
        scene.stored(sum)
    });
    let mut profiles = vec![Vec::new(); scene.channels as usize];
    for stored in spread {
        for (profile, value) in profiles.iter_mut().zip(stored) {
            profile.push(value / sigma);
        }
    }
    Some(step_contrast_to_noise(&profiles, step_px, spread_px))
}
