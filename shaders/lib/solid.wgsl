// Analytic capped cylinders and the pieces of bent rods: see cpu/solid.rs and cpu/rod.rs.

/// Farther than anything: no hit.
const SOLID_NONE_M: f32 = 3e38;

/// A capped cylinder.
struct Solid {
    centre_m: vec3<f32>,
    half_length_m: f32,
    direction: vec3<f32>,
    radius_m: f32,
}

/// A piece of a rod.
struct Segment {
    solid: Solid,
    /// From the piece's centre to the arc of the rod's axis, where the tangent is the piece's direction.
    arc_m: vec3<f32>,
    /// 1/R of the arc; zero for a straight rod.
    curvature_per_m: f32,
    /// Unit vector from the arc to its centre; zero for a straight rod.
    inward: vec3<f32>,
    /// 2 + index of the rod.
    instance: u32,
    /// Which of the piece's caps are ends of the rod, not seams: 1 the one against its direction, 2 the one along it.
    ends: u32,
}

/// Where a ray meets a solid, and whether on a cap. `t_m` is `SOLID_NONE_M` if it does not, also from inside.
struct SolidHit {
    t_m: f32,
    cap: bool,
}

/// The first point of a solid on a ray of unit direction.
///
/// With c = v × d and w from the origin to the centre, the ray passes the axis at |c·w|/|c|, nearest to it at
/// t₀ = (w × d)·c / |c|². No square of a distance is subtracted from another one: what is left of thin far rods would be noise.
fn solid_hit(solid: Solid, origin_m: vec3<f32>, direction: vec3<f32>) -> SolidHit {
    let d = solid.direction;
    let w = solid.centre_m - origin_m;
    let c = cross(direction, d);
    let sin2 = dot(c, c);
    let triple = dot(c, w);
    let r = solid.radius_m;
    // Most rays miss.
    if triple * triple > r * r * sin2 * 1.000001 + 1e-20 {
        return SolidHit(SOLID_NONE_M, false);
    }
    let around = cross(w, d);
    var enter = -SOLID_NONE_M;
    var leave = SOLID_NONE_M;
    if sin2 > 1e-12 {
        let sin = sqrt(sin2);
        let gap = abs(triple) / sin;
        if gap > r {
            return SolidHit(SOLID_NONE_M, false);
        }
        let nearest = dot(around, c) / sin2;
        let half = sqrt((r - gap) * (r + gap)) / sin;
        enter = nearest - half;
        leave = nearest + half;
    } else if dot(around, around) > r * r {
        return SolidHit(SOLID_NONE_M, false);
    }
    // Along the axis from the centre: where the ray starts, and how fast it goes.
    let start = -dot(d, w);
    let rate = dot(d, direction);
    let at_enter = start + rate * max(enter, -1e6);
    var cap = false;
    if abs(at_enter) > solid.half_length_m {
        // Beyond an end: only a ray that comes back towards the middle meets a cap.
        if at_enter * rate >= 0.0 {
            return SolidHit(SOLID_NONE_M, false);
        }
        enter = (sign(at_enter) * solid.half_length_m - start) / rate;
        cap = true;
    }
    if enter >= leave || enter <= 0.0 {
        return SolidHit(SOLID_NONE_M, false);
    }
    return SolidHit(enter, cap);
}

/// Unit normal at a point of a piece. On the side it is that of the rod's arc, so that seams do not show.
fn solid_normal(segment: Segment, point_m: vec3<f32>) -> vec3<f32> {
    let d = segment.solid.direction;
    let from_arc = point_m - (segment.solid.centre_m + segment.arc_m);
    // Arc length s to the foot of the point, small: the arc is d s + inward κ s²/2 to a hundredth of a micrometre.
    let s = dot(from_arc, d) / (1.0 - segment.curvature_per_m * dot(from_arc, segment.inward));
    return normalize(from_arc - d * s - segment.inward * (0.5 * segment.curvature_per_m * s * s));
}

/// Whether the cap that a ray meets, which goes along the piece's direction at `rate`, is an end of the rod.
fn solid_is_end(segment: Segment, rate: f32) -> bool {
    return (segment.ends & select(2u, 1u, rate > 0.0)) != 0u;
}

/// Whether the ray passes the limb of a solid closer than `footprint_rad` allows one sample to tell.
fn solid_grazes(solid: Solid, origin_m: vec3<f32>, direction: vec3<f32>, footprint_rad: f32) -> bool {
    let d = solid.direction;
    let w = solid.centre_m - origin_m;
    let c = cross(direction, d);
    let sin2 = dot(c, c);
    if sin2 < 1e-12 {
        return true;
    }
    let t = dot(cross(w, d), c) / sin2;
    let cos = dot(d, direction);
    let s = cos * t - dot(d, w);
    let margin = t * footprint_rad;
    let sin = sqrt(sin2);
    // A ray through the rim of a cap comes nearest to the axis at most r |cos|/sin beyond the cap.
    return t > 0.0
        && abs(s) <= solid.half_length_m + (margin + solid.radius_m * abs(cos)) / sin
        && abs(abs(dot(c, w)) / sin - solid.radius_m) < margin;
}

/// A shading normal as a ray can see it, of unit length: one that looks away is turned until it is square to the ray.
fn solid_facing(normal: vec3<f32>, direction: vec3<f32>, face_normal: vec3<f32>) -> vec3<f32> {
    let turned = normal - direction * max(dot(normal, direction), 0.0);
    let size = length(turned);
    return select(face_normal, turned / size, size > 1e-6);
}
