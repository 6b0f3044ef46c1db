//! Which strip of the left eye and which of the right are one rod.

use nalgebra::Vector4;
use rodsight_geometry::{
    Cylinder, Eye, Line3, Mat3, MountedCamera, Pixel, Rig, Side, TangentPair, TangentPlane, Vec3,
};

use super::light::Light;
use super::shot::{Seen, Shot};
use super::strip::Strip;
use super::sums::Edge;
use crate::RadiusPrior;

/// Spread of the logarithm of the ratio of two radii of one rod, coarsely measured.
const LOG_RATIO_SPREAD: f64 = 0.4;

/// Nearer than this two planes through the eyes are one, rad.
const ONE_PLANE_RAD: f64 = 0.01;

/// A rod of both eyes, roughly.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) strips: [Strip; 2],
    /// Of the other pairs, where they are known.
    pub(crate) more: Vec<Option<[Strip; 2]>>,
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

/// The cylinder of strips in each eye of each pair, and how well their planes agree, px.
pub(crate) fn cylinder(
    shots: &[Shot<'_>],
    strips: &[Option<[Strip; 2]>],
    known_radius_m: Option<f64>,
) -> Option<(Cylinder, f64)> {
    let mut all = Vec::with_capacity(4 * shots.len());
    for (shot, strips) in shots.iter().zip(strips) {
        if let Some([left, right]) = strips {
            let lights = shot.lights();
            all.extend(planes(&shot.rig.left, lights[0], left)?);
            all.extend(planes(&shot.rig.right, lights[1], right)?);
        }
    }
    let (first, [strip, _]) = (shots.first()?, strips.first()?.as_ref()?);
    touching(&first.rig, first.lights()[0], strip, &all, known_radius_m)
}

/// The cylinder that touches planes; `strip` is of the first pair's left eye.
pub(crate) fn touching(
    rig: &Rig,
    light: &Light<'_>,
    strip: &Strip,
    all: &[TangentPlane],
    known_radius_m: Option<f64>,
) -> Option<(Cylinder, f64)> {
    let fit = Cylinder::from_tangent_planes(all, known_radius_m).ok()?;
    let mut cylinder = fit.cylinder;
    // The reference point where the left eye looks at the rod.
    let corner = Pixel::new(light.roi.x_px.into(), light.roi.y_px.into());
    let (from_m, along) = rig.left.ray(&(strip.middle_px + corner))?;
    cylinder.axis.point_m = nearest(&cylinder.axis, &from_m, &along)?;
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
fn nearest(axis: &Line3, from_m: &Vec3, along: &Vec3) -> Option<Vec3> {
    let (p, d) = (axis.point_m, axis.direction);
    let w = p - from_m;
    let (cos, sin2) = (d.dot(along), d.cross(along).norm_squared());
    (sin2 > 1e-9).then(|| p + d * ((cos * w.dot(along) - w.dot(&d)) / sin2))
}

/// A strip in space.
pub(crate) struct Sight<'a> {
    pub(crate) strip: &'a Strip,
    pub(crate) planes: [TangentPlane; 2],
    /// Unit normal of the plane through the eye and the axis.
    axis_plane: Vec3,
    /// Where the strip's middle is seen from, and in which direction.
    from_m: Vec3,
    along: Vec3,
}

/// The strips of both eyes that have tangent planes.
pub(crate) fn sights<'a>(shot: &'a Shot<'_>) -> [Vec<Sight<'a>>; 2] {
    [0, 1].map(|k| {
        let mounted = [&shot.rig.left, &shot.rig.right][k];
        let Seen { light, strips, .. } = &shot.seen[k];
        let corner = Pixel::new(light.roi.x_px.into(), light.roi.y_px.into());
        let sight = |strip: &'a Strip| {
            let planes = planes(mounted, light, strip)?;
            let [a, b] = planes.map(|plane| plane.normal);
            let (from_m, along) = mounted.ray(&(strip.middle_px + corner))?;
            Some(Sight {
                strip,
                planes,
                axis_plane: (a + b).normalize(),
                from_m,
                along,
            })
        };
        strips.iter().filter_map(sight).collect()
    })
}

/// Nearly what `touching` says of how well four planes agree, px, by normal equations, which is a fraction of the work but loses half
/// the digits. Infinite where the radius is not positive, `None` where it cannot be said so: near the baseline.
fn disagreement_px(rig: &Rig, left: &Sight<'_>, right: &Sight<'_>) -> Option<f64> {
    let cross = left.axis_plane.cross(&right.axis_plane);
    if !(cross.norm() > 2.0 * ONE_PLANE_RAD) {
        return None;
    }
    let all = [left.planes, right.planes];
    let all = all.as_flattened();
    let origin = 0.5 * (left.from_m + right.from_m);
    // The direction that is most nearly in all planes, by inverse iteration.
    let normals: Mat3 = all.iter().map(|p| p.normal * p.normal.transpose()).sum();
    let inverse = (normals + Mat3::identity() * 1e-12).try_inverse()?;
    let mut direction = cross;
    for _ in 0..4 {
        direction = (inverse * direction).try_normalize(0.0)?;
    }
    let row = |p: &TangentPlane| p.normal.push(-p.side.sign());
    let across = direction.push(0.0);
    let mut matrix = across * across.transpose() * 4.0;
    let mut values = Vector4::zeros();
    for plane in all {
        let row = row(plane);
        matrix += row * row.transpose();
        values += row * plane.normal.dot(&(plane.centre_m - origin));
    }
    let solution = matrix.try_inverse()? * values;
    if !(solution.w > 0.0) {
        return Some(f64::INFINITY);
    }
    let point_m = origin + solution.xyz();
    let off_m =
        |p: &TangentPlane| p.normal.dot(&(point_m - p.centre_m)) - p.side.sign() * solution.w;
    let squares: f64 = all.iter().map(|p| off_m(p) * off_m(p)).sum();
    let seen_m = nearest(&Line3 { point_m, direction }, &left.from_m, &left.along)?;
    let depth_m = |m: &MountedCamera| m.rig_from_camera.inverse().point(&seen_m).z;
    let depth_m = depth_m(&rig.left).min(depth_m(&rig.right));
    if !(depth_m > 0.0) {
        return Some(f64::INFINITY);
    }
    let fx_px = rig.left.camera.intrinsics().fx_px;
    Some(0.5 * squares.sqrt() * fx_px / depth_m)
}

/// What is nearly how far planes are apart is at least this share of how far they are.
const NEARLY: f64 = 0.9;

/// A strip of the left eye and one of the right.
#[derive(Clone, Copy)]
pub(crate) struct Double<'a> {
    /// What it scores at most.
    pub(crate) most: f64,
    pub(crate) alike: f64,
    pub(crate) left: &'a Sight<'a>,
    pub(crate) right: &'a Sight<'a>,
}

impl Double<'_> {
    pub(crate) fn strips(&self) -> [Strip; 2] {
        [*self.left.strip, *self.right.strip]
    }

    pub(crate) fn planes(&self) -> [TangentPlane; 4] {
        let ([a, b], [c, d]) = (self.left.planes, self.right.planes);
        [a, b, c, d]
    }
}

/// How far apart planes of one rod may be, px.
pub(crate) fn slack_px(shot: &Shot<'_>) -> f64 {
    1.2 * shot.seen[0].factor.max(shot.seen[1].factor) as f64
}

/// By how far a radius is off from what is known of it, in [0, 1].
pub(crate) fn by_radius(prior: &RadiusPrior, radius_m: f64) -> f64 {
    let off = libm::log(radius_m / prior.radius_m) / LOG_RATIO_SPREAD;
    libm::exp(-0.5 * off * off)
}

/// All pairs of strips of both eyes, by what they score at most.
pub(crate) fn doubles<'a>(
    shot: &Shot<'_>,
    [lefts, rights]: &'a [Vec<Sight<'a>>; 2],
    is_radius_known: bool,
) -> Vec<Double<'a>> {
    let slack_px = slack_px(shot);
    let mut pairs = Vec::with_capacity(lefts.len() * rights.len());
    for left in lefts {
        for right in rights {
            let both = f64::from((left.strip.score * right.strip.score).sqrt());
            let alike = both * likeness(left.strip, right.strip);
            // A radius that is known may locate what the planes alone do not.
            let off = (!is_radius_known).then(|| disagreement_px(&shot.rig, left, right));
            let off = off.flatten().unwrap_or(0.0) * NEARLY / slack_px;
            pairs.push(Double {
                most: alike * libm::exp(-0.5 * off * off),
                alike,
                left,
                right,
            });
        }
    }
    pairs.sort_by(|a, b| b.most.total_cmp(&a.most));
    pairs
}

/// All pairs of strips that may be one rod and score at least this share of the likeliest, likeliest first.
pub(crate) fn candidates(
    shot: &Shot<'_>,
    prior: Option<RadiusPrior>,
    least_share: f64,
) -> Vec<Candidate> {
    let slack_px = slack_px(shot);
    let known = prior.map(|prior| prior.radius_m);
    let sights = sights(shot);
    let mut found = Vec::new();
    let mut best = 0.0_f64;
    // Most are left before their cylinder is asked for.
    for double in doubles(shot, &sights, known.is_some()) {
        let Double {
            most, alike, left, ..
        } = double;
        if most < least_share * best || most <= 0.0 {
            break;
        }
        let all = double.planes();
        let touching = |known| touching(&shot.rig, shot.lights()[0], left.strip, &all, known);
        let located = touching(None).or_else(|| known.and_then(|r| touching(Some(r))));
        let Some((cylinder, residual_px)) = located else {
            continue;
        };
        let off = residual_px / slack_px;
        let mut score = alike * libm::exp(-0.5 * off * off);
        if let Some(prior) = &prior {
            score *= by_radius(prior, cylinder.radius_m);
        }
        best = best.max(score);
        found.push(Candidate {
            strips: double.strips(),
            more: Vec::new(),
            score,
        });
    }
    found.retain(|candidate: &Candidate| candidate.score >= least_share * best);
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found
}

/// The score of the likeliest pair of strips that are seen in one plane with the baseline, alike and equally wide; 0 without any.
pub(crate) fn parallel(shot: &Shot<'_>) -> f64 {
    let [lefts, rights] = sights(shot);
    let mut best = 0.0_f64;
    for left in &lefts {
        for right in &rights {
            if left.axis_plane.cross(&right.axis_plane).norm() < ONE_PLANE_RAD {
                let (left, right) = (left.strip, right.strip);
                let off = libm::log(left.width_px / right.width_px) / LOG_RATIO_SPREAD;
                let score = f64::from((left.score * right.score).sqrt()) * likeness(left, right);
                best = best.max(score * libm::exp(-0.5 * off * off));
            }
        }
    }
    best
}

/// How alike the colours are that two strips stand out by, in [0, 1].
pub(crate) fn likeness(left: &Strip, right: &Strip) -> f64 {
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
