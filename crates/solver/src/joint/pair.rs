//! Which strip of the left eye and which of the right are one rod.

use rodsight_geometry::{
    Cylinder, Eye, MountedCamera, Pixel, Rig, Side, TangentPair, TangentPlane, Vec3,
};

use super::light::Light;
use super::strip::Strip;
use super::sums::Edge;
use crate::RadiusPrior;

/// Spread of the logarithm of the ratio of two radii of one rod, coarsely measured.
const LOG_RATIO_SPREAD: f64 = 0.4;

/// A rod of both eyes, roughly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) strips: [Strip; 2],
    pub(crate) score: f64,
}

/// The plane through a camera's centre in which a line of its region is seen, and the place where the rays come from; lines behind
/// lenses that bend them are taken by their ends.
fn plane(mounted: &MountedCamera, light: &Light<'_>, edge: &Edge) -> Option<(Vec3, Vec3)> {
    let size = [light.width as f64, light.height as f64];
    let [from, to] = super::strip::chord(edge, size)?;
    let corner = Pixel::new(light.roi.x_px.into(), light.roi.y_px.into());
    let (from_m, a) = mounted.ray(&(from + corner))?;
    let (to_m, b) = mounted.ray(&(to + corner))?;
    let normal = a.cross(&b);
    (normal.norm() > 1e-9).then(|| (normal.normalize(), 0.5 * (from_m + to_m)))
}

/// The tangent planes of a strip.
pub(crate) fn planes(
    mounted: &MountedCamera,
    light: &Light<'_>,
    strip: &Strip,
) -> Option<[TangentPlane; 2]> {
    let corner = Pixel::new(light.roi.x_px.into(), light.roi.y_px.into());
    let (_, seen) = mounted.ray(&(strip.middle_px + corner))?;
    let [(a, at_a), (b, at_b)] = [
        plane(mounted, light, &strip.edges[0])?,
        plane(mounted, light, &strip.edges[1])?,
    ];
    let view = TangentPair::one_view(&a, &b, &seen)?;
    let [normal_a, normal_b] = view.normals;
    let (side_a, side_b) = match view.first_side {
        Side::Plus => (Side::Plus, Side::Minus),
        Side::Minus => (Side::Minus, Side::Plus),
    };
    let plane = |normal, centre_m, side| TangentPlane {
        normal,
        centre_m,
        side,
    };
    Some([plane(normal_a, at_a, side_a), plane(normal_b, at_b, side_b)])
}

/// The cylinder of a strip in each eye, and how well four planes agree, px.
pub(crate) fn cylinder(
    rig: &Rig,
    lights: [&Light<'_>; 2],
    strips: [&Strip; 2],
    known_radius_m: Option<f64>,
) -> Option<(Cylinder, f64)> {
    let left = planes(&rig.left, lights[0], strips[0])?;
    let right = planes(&rig.right, lights[1], strips[1])?;
    let all = [left[0], left[1], right[0], right[1]];
    let fit = Cylinder::from_tangent_planes(&all, known_radius_m).ok()?;
    let mut cylinder = fit.cylinder;
    // The reference point where the left eye looks at the rod.
    let corner = Pixel::new(lights[0].roi.x_px.into(), lights[0].roi.y_px.into());
    let (from_m, along) = rig.left.ray(&(strips[0].middle_px + corner))?;
    cylinder.axis.point_m = nearest(&cylinder, &from_m, &along)?;
    let depth = |eye: Eye| {
        let pose = rig.eye(eye).rig_from_camera.inverse();
        pose.point(&cylinder.axis.point_m).z
    };
    let depth_m = depth(Eye::Left).min(depth(Eye::Right));
    if !(depth_m > 2.0 * cylinder.radius_m && depth_m < 100.0) {
        return None;
    }
    let fx_px = rig.left.camera.intrinsics().fx_px;
    Some((cylinder, fit.residual_m * fx_px / depth_m))
}

/// The point of an axis nearest to a ray.
fn nearest(cylinder: &Cylinder, from_m: &Vec3, along: &Vec3) -> Option<Vec3> {
    let (p, d) = (cylinder.axis.point_m, cylinder.axis.direction);
    let w = p - from_m;
    let (cos, sin2) = (d.dot(along), d.cross(along).norm_squared());
    (sin2 > 1e-9).then(|| p + d * ((cos * w.dot(along) - w.dot(&d)) / sin2))
}

/// All pairs of strips that may be one rod, likeliest first.
pub(crate) fn candidates(
    rig: &Rig,
    lights: [&Light<'_>; 2],
    strips: [&[Strip]; 2],
    prior: Option<RadiusPrior>,
    factors: [usize; 2],
) -> Vec<Candidate> {
    let slack_px = 1.2 * factors[0].max(factors[1]) as f64;
    let mut found = Vec::new();
    for left in strips[0] {
        for right in strips[1] {
            let known = prior.map(|prior| prior.radius_m);
            let located = cylinder(rig, lights, [left, right], None)
                .or_else(|| cylinder(rig, lights, [left, right], known));
            let Some((cylinder, residual_px)) = located else {
                continue;
            };
            let off = residual_px / slack_px;
            let mut score = f64::from((left.score * right.score).sqrt());
            score *= libm::exp(-0.5 * off * off);
            score *= likeness(left, right);
            if let Some(prior) = prior {
                let off = libm::log(cylinder.radius_m / prior.radius_m) / LOG_RATIO_SPREAD;
                score *= libm::exp(-0.5 * off * off);
            }
            found.push(Candidate {
                strips: [*left, *right],
                score,
            });
        }
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found
}

/// Nearer than this two planes through the eyes are one, rad.
const ONE_PLANE_RAD: f64 = 0.01;

/// The score of the likeliest pair of strips that are seen in one plane with the baseline, alike and equally wide; 0 without any.
pub(crate) fn parallel(rig: &Rig, lights: [&Light<'_>; 2], strips: [&[Strip]; 2]) -> f64 {
    let axis_plane = |mounted, light, strip| {
        let [a, b] = planes(mounted, light, strip)?;
        Some((a.normal + b.normal).normalize())
    };
    let mut best = 0.0_f64;
    for left in strips[0] {
        let Some(n_left) = axis_plane(&rig.left, lights[0], left) else {
            continue;
        };
        for right in strips[1] {
            let Some(n_right) = axis_plane(&rig.right, lights[1], right) else {
                continue;
            };
            if n_left.cross(&n_right).norm() < ONE_PLANE_RAD {
                let off = libm::log(left.width_px / right.width_px) / LOG_RATIO_SPREAD;
                let score = f64::from((left.score * right.score).sqrt()) * likeness(left, right);
                best = best.max(score * libm::exp(-0.5 * off * off));
            }
        }
    }
    best
}

/// How alike the colours are that two strips stand out by, in [0, 1].
fn likeness(left: &Strip, right: &Strip) -> f64 {
    // Inwards. What one eye sees on the left may be lower for the other.
    let inwards = |strip: &Strip| strip.edges.map(|edge| inwards(&edge, &strip.middle_px));
    let cos = |l: [f64; 3], r: [f64; 3]| -> f64 { l.iter().zip(&r).map(|(l, r)| l * r).sum() };
    let ([a, b], [c, d]) = (inwards(left), inwards(right));
    let both = (cos(a, c) + cos(b, d)).max(cos(a, d) + cos(b, c));
    (0.5 + 0.25 * both).max(0.0)
}

/// The colour of a step towards a place.
fn inwards(edge: &Edge, place: &Pixel) -> [f64; 3] {
    let towards = edge.line.normal() * (edge.line.normal().dot(place) - edge.line.rho_px);
    let sign = edge.normal.dot(&towards).signum();
    edge.colour.map(|v| v * sign)
}
